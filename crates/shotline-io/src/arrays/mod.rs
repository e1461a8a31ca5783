//! Arrays on disk as NumPy keeps them: rays from `.npy`, results to `.npz`.
//!
//! The `.npy` header is a line of Python; reading the one and writing the other takes less than the libraries for it
//! (`npyz` brings a parser generator and big integers). The `.npz` container is left to `zip`.

mod npy;
mod npz;
mod rays;

pub use npz::{Column, fill_npz, write_npz};
pub use rays::{InvalidRow, parse_rays, rays_of, read_rays};
