//! The meshes that hits are on, and where on their triangles.

use std::collections::HashMap;

use super::{Body, World};
use crate::math::{Affine, Vec3};
use crate::solid::Solid;
use crate::solid::mesh::{Attribute, MeshSolid, TriangleMesh};

/// The meshes of a world by the surface and the path of a hit, also those in combinations. Each is looked up once.
#[derive(Debug)]
pub struct HitMeshes<'w> {
    world: &'w World,
    known: HashMap<(u32, u64), Option<HitMesh<'w>>>,
}

/// A mesh, and the frame in which it is.
#[derive(Clone, Copy, Debug)]
pub struct HitMesh<'w> {
    solid: &'w MeshSolid,
    mesh_from_world: Affine,
}

impl<'w> HitMeshes<'w> {
    /// Creates an empty table.
    pub fn new(world: &'w World) -> HitMeshes<'w> {
        HitMeshes { world, known: HashMap::new() }
    }

    /// Returns the mesh that has the surface of a hit, at the path of the hit; `None` if that is no mesh.
    pub fn get(&mut self, surface: u32, path: u64) -> Option<HitMesh<'w>> {
        let world = self.world;
        *self.known.entry((surface, path)).or_insert_with(|| {
            let (solid, mesh_from_body) = world.mesh_of_surface(surface)?;
            let mesh_from_world = world.frame_from_world(path, |_| mesh_from_body)?.placement().ok()?;
            Some(HitMesh { solid, mesh_from_world: mesh_from_world.parent_from_local })
        })
    }
}

impl<'w> HitMesh<'w> {
    /// The mesh.
    pub fn mesh(&self) -> &'w TriangleMesh {
        self.solid.triangle_mesh()
    }

    /// The weights of the corners of a triangle at a point of it, in world coordinates. Their sum is 1.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn barycentric(&self, primitive: u32, point: Vec3) -> [f64; 3] {
        let weights = self.solid.barycentric(self.mesh_from_world.point(point), primitive);
        let [second, third] = weights.unwrap_or([f64::NAN; 2]);
        [1.0 - second - third, second, third]
    }

    /// Writes the value of an attribute of the mesh at a point to `out`, as [`TriangleMesh::interpolate`] does.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn interpolate(&self, attribute: &Attribute, primitive: u32, point: Vec3, out: &mut [f64]) {
        self.mesh().interpolate(attribute, primitive, self.barycentric(primitive, point), out);
    }
}

impl World {
    /// Whether a mesh has an attribute with this name.
    pub fn has_attribute(&self, name: &str) -> bool {
        let has = |solid: &MeshSolid| solid.triangle_mesh().attribute(name).is_some();
        self.bodies.iter().any(|body| match &**body {
            Body::Surface(body) => has(&body.mesh),
            Body::Solid(body) => body.leaves.iter().filter_map(|leaf| leaf.solid.as_mesh()).any(has),
        })
    }

    /// The mesh that has a surface, and its frame in its body.
    fn mesh_of_surface(&self, surface: u32) -> Option<(&MeshSolid, &Affine)> {
        match self.body_of_surface(surface)? {
            Body::Surface(body) => Some((&body.mesh, &body.local_from_body)),
            Body::Solid(body) => {
                let leaf =
                    body.leaves.partition_point(|leaf| leaf.first_surface <= surface).checked_sub(1)?;
                let leaf = body.leaves.get(leaf)?;
                Some((leaf.solid.as_mesh()?, &leaf.local_from_body))
            }
        }
    }
}
