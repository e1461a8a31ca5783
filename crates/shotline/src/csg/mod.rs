//! CSG.
