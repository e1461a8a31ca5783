//! A shape that becomes a mesh.

use std::collections::HashSet;

use shotline::compile::World;
use shotline::math::Vec3;
use shotline::query::batch::{self, Run};
use shotline::scene::{Node, Scene};
use shotline::solid::mesh::TriangleMesh;

use crate::direct::of_solid;
use crate::graph::{matrix, scene_of_shape, stretch};
use crate::plan::Piece;
use crate::refine::{RefineError, Refined, State, refine};
use crate::surface::Surface;
use crate::surface_points::first_points;
use crate::{MOST_SOLIDS, Progress, TessellateError};

/// A shape as a scene of its own.
pub struct Shape {
    scene: Scene,
    world: World,
    /// The name of its object.
    object: String,
    /// By how much it is enlarged where it is placed.
    stretch: f64,
}

impl Shape {
    /// The shape of a piece of a scene, if it can become a mesh.
    pub fn of(scene: &Scene, piece: &Piece, run: Run) -> Result<Shape, TessellateError> {
        let object = match scene.node(piece.object) {
            Node::Object { name, .. } => name.clone(),
            _ => String::new(),
        };
        let scene = scene_of_shape(scene, piece.node, &piece.placed, &object);
        let world = scene.compile()?;
        // Refuses surfaces without an inside, by object.
        batch::contains(&world, &[] as &[Vec3], run)?;
        let count = world.stats().virtual_leaves;
        if count > MOST_SOLIDS {
            return Err(TessellateError::TooManySolids { object, count });
        }
        let bounds = world.bounds();
        if !(bounds.is_finite() || bounds.is_empty()) {
            return Err(TessellateError::Unbounded { object });
        }
        Ok(Shape { scene, world, object, stretch: piece.stretch })
    }

    /// The mesh of a shape within a tolerance where it is placed, and how far it is from the surface there. It is empty if the shape is.
    pub fn mesh_within(
        &self,
        tolerance: f64,
        run: Run,
        report: &mut dyn FnMut(&Progress),
    ) -> Result<Refined, TessellateError> {
        let bounds = self.world.bounds();
        if bounds.is_empty() || bounds.size() == Vec3::ZERO {
            return Ok(Refined::default());
        }
        let local = tolerance / self.stretch;
        if let Some(found) = self.direct_mesh(local) {
            return Ok(Refined { deviation: found.deviation * self.stretch, ..found });
        }
        let surface = Surface { world: &self.world, object: 0, run };
        let points = first_points(&self.scene, self.scene.objects[0], &bounds, local, &surface)?;
        let mut of_object = |State { cells, triangles, deviation }: State| {
            report(&Progress { object: &self.object, cells, triangles, deviation: deviation * self.stretch });
        };
        let found =
            refine(&surface, &bounds, points, local, &mut of_object).map_err(|error| match error {
                RefineError::Batch(error) => error.into(),
                RefineError::TooFine(far) => {
                    let (object, distance) = (self.object.clone(), far.distance * self.stretch);
                    TessellateError::TooFine { object, tolerance, distance, place: far.place }
                }
            })?;
        Ok(Refined { deviation: found.deviation * self.stretch, ..found })
    }
    /// The mesh within a tolerance, if the shape is a solid that has one without a search, which may be transformed.
    fn direct_mesh(&self, tolerance: f64) -> Option<Refined> {
        let Node::Object { node, .. } = self.scene.node(self.scene.objects[0]) else { return None };
        let (mut id, mut transforms) = (*node, Vec::new());
        while let Node::Transform { transform, child } = self.scene.node(id) {
            transforms.push(transform);
            id = *child;
        }
        let Node::Solid { kind, params } = self.scene.node(id) else { return None };
        let placed = matrix(transforms);
        let stretch = stretch(&placed);
        let Refined { mut mesh, deviation } = of_solid(kind, params, tolerance / stretch)?;
        mesh.vertices.iter_mut().for_each(|vertex| *vertex = placed.point(*vertex));
        if placed.determinant() < 0.0 {
            mesh.faces.iter_mut().for_each(|face| face.swap(1, 2));
        }
        have_places_of_their_own(&mesh).then_some(Refined { mesh, deviation: deviation * stretch })
    }
}

/// Whether no two vertices are at one position, as after rounding far from the origin.
fn have_places_of_their_own(mesh: &TriangleMesh) -> bool {
    let mut places = HashSet::new();
    // Zeros have one sign.
    mesh.vertices.iter().all(|vertex| places.insert(vertex.to_array().map(|x| (x + 0.0).to_bits())))
}
