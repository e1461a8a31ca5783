//! Triangle meshes: closed ones are solids, others surfaces.

use crate::math::Vec3;

/// Vertices and triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// The vertices.
    pub vertices: Vec<Vec3>,
    /// Three vertex numbers a triangle.
    pub faces: Vec<[u32; 3]>,
}

// stub
use crate::aabb::Aabb;
use crate::accel::Work;
use crate::crossing::Crossing;
use crate::ray::{Line, Span};
/// stub
#[derive(Debug)]
pub struct MeshSolid {}
#[allow(missing_docs)]
impl MeshSolid {
    pub fn new(_m: std::sync::Arc<TriangleMesh>, _a: &str) -> Result<MeshSolid, String> {
        Ok(MeshSolid {})
    }
    pub fn is_closed(&self) -> bool {
        true
    }
    pub fn why_not_closed(&self) -> String {
        String::new()
    }
    pub fn hits(&self, _l: &Line, _s: Span, _wanted: super::Wanted, _out: &mut Vec<Crossing>, _w: &mut Work) {
    }
}
impl super::Solid for MeshSolid {
    fn bounds(&self) -> Aabb {
        Aabb::EMPTY
    }
    fn crossings(&self, _l: &Line, _o: &mut Vec<Crossing>) {}
    fn implicit(&self, _p: Vec3, _s: u32, _q: u32) -> f64 {
        0.0
    }
    fn normal(&self, p: Vec3, _s: u32, _q: u32) -> Vec3 {
        p
    }
    fn contains(&self, _p: Vec3) -> bool {
        false
    }
    fn surfaces(&self) -> &'static [&'static str] {
        &["mesh"]
    }
}
