//! How files are read.

use shotline::solid::mesh::Weld;

/// Which mesh files a scene may name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PathPolicy {
    /// Those below the folder of the scene, links resolved, so that an untrusted scene reads nothing else.
    #[default]
    SceneFolder,
    /// Any file.
    Anywhere,
}

/// How files are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// The mesh files that a scene may name.
    pub paths: PathPolicy,
    /// How to weld the vertices of meshes, except meshes of a scene whose nodes have a weld of their own. `None`
    /// welds nothing.
    pub weld: Option<Weld>,
    /// Whether a file is read without the parts of it that are not supported. They are notes then, and errors otherwise.
    pub partial: bool,
    /// Which setup of a GDML file is read, by its name. `None` reads the one named `Default`, or else the first.
    pub setup: Option<String>,
}

impl From<PathPolicy> for ReadOptions {
    fn from(paths: PathPolicy) -> ReadOptions {
        ReadOptions { paths, ..ReadOptions::default() }
    }
}
