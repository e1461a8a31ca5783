//! What a query does with the boundaries of the rays of a block, and the state of a ray while they are found.

use super::Kinds;
use super::fold_query::FoldControl;
use super::level_paths::LevelPaths;
use super::limit::limit_behind_row;
use super::traversal::{BodyEntry, PlacedBody};
use crate::csg::Boundary;
use crate::math::Vec3;

/// A ray in flight: its row in the block, and its number among the rays in flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InFlight {
    pub row: usize,
    pub slot: usize,
}

/// A boundary of a ray.
pub(super) struct Found<'f, 'w> {
    pub paths: &'f LevelPaths<'w>,
    pub placed: PlacedBody,
    pub boundary: Boundary,
    pub normal: Normal<'f>,
}

/// The normal of a boundary.
pub(super) enum Normal<'f> {
    /// In world coordinates, if normals are needed.
    Known(Vec3),
    /// Can be computed, given the ray in the body.
    Open(&'f BodyEntry),
}

/// What a query does with the boundaries of the rays of a block.
pub(super) trait BlockVisitor<'w> {
    /// Whether any boundary is enough, and nothing needs to be known of it.
    const IS_ANY: bool = false;

    /// Makes room for rays in flight with numbers below `in_flight`.
    fn make_room(&mut self, _in_flight: usize) {}

    /// Takes a boundary. Those of one ray and body come one after the other.
    fn boundary(&mut self, ray: InFlight, found: Found<'_, 'w>) -> FoldControl;

    /// Takes a ray that has a boundary, which ends it.
    fn any(&mut self, _ray: InFlight) {}

    /// Takes the end of a ray, after all its boundaries.
    fn end(&mut self, _ray: InFlight, _paths: &LevelPaths<'w>) {}

    /// Takes a ray that has to be cast by the plain path. What was passed of it means nothing.
    fn refuse(&mut self, ray: InFlight);
}

/// The state of a ray in flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slot {
    pub in_flight: InFlight,
    /// Its bundle, and its place there.
    pub bundle: usize,
    pub place: usize,
    /// How far it looks.
    pub limit: f64,
    /// Steps taken in bodies that were folded by the plain path.
    pub steps: u64,
    pub state: State,
}

/// The query for which boundaries are passed.
#[derive(Clone, Copy)]
pub(super) struct Passing<'b> {
    /// The rays of the block.
    pub rays: &'b [[f64; 6]],
    pub kinds: Kinds,
    /// Whether the query is for the closest crossing.
    pub is_closest: bool,
}

impl Slot {
    /// A ray that begins.
    pub fn new(in_flight: InFlight, (bundle, place): (usize, usize), limit: f64) -> Slot {
        Slot { in_flight, bundle, place, limit, steps: 0, state: State::Ready }
    }

    /// Passes a boundary of a body whose box the ray enters at `enter`, unless its kind is not asked for. Afterwards the ray
    /// may have ended.
    #[inline]
    pub fn pass<'w, V: BlockVisitor<'w>>(
        &mut self,
        mut found: Found<'_, 'w>,
        enter: f64,
        passing: Passing<'_>,
        visitor: &mut V,
    ) {
        if self.state == State::Ended || !passing.kinds.hold(found.boundary.kind) {
            return;
        }
        // Turns -0.0 into 0.0, as in the fold of a single ray.
        found.boundary.crossing.t += 0.0;
        if passing.is_closest && self.is_far_before_box(&found.boundary, enter, passing.rays) {
            return self.refuse(visitor);
        }
        let paths = found.paths;
        match visitor.boundary(self.in_flight, found) {
            FoldControl::Limit(t) => self.limit = self.limit.min(t),
            FoldControl::Stop => {
                self.state = State::Ended;
                visitor.end(self.in_flight, paths);
            }
        }
    }

    /// Whether a boundary lies so far before the box of its body that the search may end before the box. Whether a single ray
    /// finds it as its closest depends on the order in which it enters boxes, which is not that of a block: the ray takes the
    /// plain path. Otherwise the order does not matter: a search goes on up to `limit_behind` of the nearest crossing that it has
    /// found, and this box begins before that as long as nothing before this boundary has been found.
    #[inline]
    fn is_far_before_box(&self, boundary: &Boundary, enter: f64, rays: &[[f64; 6]]) -> bool {
        let t = boundary.crossing.t;
        t < enter && limit_behind_row(&rays[self.in_flight.row], t) < enter
    }

    /// Leaves the ray to the plain path.
    pub fn refuse<'w>(&mut self, visitor: &mut impl BlockVisitor<'w>) {
        self.state = State::Ended;
        visitor.refuse(self.in_flight);
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum State {
    /// The ray has ended.
    #[default]
    Ended,
    /// The ray goes on to its next body.
    Ready,
    /// The ray needs the meshes of a body.
    Waiting,
}
