//! A shape that becomes a mesh.

use shotline::compile::World;
use shotline::math::Vec3;
use shotline::query::batch::{self, Run};
use shotline::scene::{Node, Scene};

use crate::graph::scene_of_shape;
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
}
