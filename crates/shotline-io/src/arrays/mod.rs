//! Arrays on disk as NumPy keeps them, rays from `.npy`, results to `.npz`; and both as `.csv`.
//!
//! The `.npy` header is a line of Python. Our code for it is smaller than the libraries (`npyz` depends on a parser
//! generator and big integers). The `.npz` container is written by `zip`.

mod csv;
mod npy;
mod npz;
mod rays;

pub use csv::fill_csv;
pub use npz::{Column, fill_npz, write_npz};
pub use rays::{InvalidRow, parse_rays, rays_of, read_rays};
