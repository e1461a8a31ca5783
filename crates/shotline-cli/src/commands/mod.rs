//! One verb a file. Each declares its flags and answers the exit code.

pub mod bench;
pub mod cast;
pub mod check;
pub mod compare;
pub mod convert;
pub mod info;
pub mod measure;
pub mod render;
pub mod shoot;
