//! The entry of the kernel: casts a block of rays with the instructions that the CPU has.

use std::marker::PhantomData;
use std::ops::Range;

use super::block::{Block, Coordinate};
use super::context::Kernel;
use super::found::{All, Any, AnyOffEdges, Closest, Found, LaneHit, Mode};
use super::frame::MeshFrame;
use super::index::{Blocks, WideIndex};
use super::lines::{BlockQuery, RayBlock};
use super::prepare::Preparation;
use super::stream::{self, StreamMemory};
use super::wave::{self, Slots};
use crate::simd::{Simd, Task, dispatch};
use crate::solid::mesh::mesh_hit::MeshHit;

/// The memory of a thread, and the result of its last cast.
#[derive(Debug, Default)]
pub(crate) struct KernelMemory {
    slots: Slots,
    stream: StreamMemory,
    found: Found,
    hits: Vec<MeshHit>,
    hit_faces: Vec<(u32, u32)>,
}

impl KernelMemory {
    /// The hits, each with the row of its ray. For [`BlockQuery::Any`] there are none.
    pub fn hits(&self) -> &[MeshHit] {
        &self.hits
    }

    /// Exchanges the hits with other memory. Where all hits are asked for, they ascend by row.
    pub fn swap_hits(&mut self, other: &mut Vec<MeshHit>) {
        std::mem::swap(&mut self.hits, other);
    }

    /// For [`BlockQuery::Any`], the rows of the rays that hit something.
    pub fn rows_hit(&self) -> impl Iterator<Item = usize> {
        self.found.lane_hits.iter().map(|lane_hit| lane_hit.row as usize)
    }

    /// For [`BlockQuery::AnyOffEdges`], the rows of the rays that hit something, each with the face.
    pub fn hit_faces(&self) -> &[(u32, u32)] {
        &self.hit_faces
    }

    /// For [`BlockQuery::First`] and [`BlockQuery::AnyOffEdges`], the rows of the rays that may begin inside. Where the
    /// caller does not know whether they do, it has to cast them for [`BlockQuery::Within`].
    pub fn inside_rows(&self) -> &[u32] {
        &self.found.inside
    }

    /// Leaves all rays to the plain path.
    pub fn leave_all(&mut self, rows: usize) {
        self.clear();
        self.found.plain.extend(0..rows as u32);
    }

    fn clear(&mut self) {
        self.hits.clear();
        self.hit_faces.clear();
        self.found.plain.clear();
        self.found.lane_hits.clear();
        self.found.inside.clear();
    }

    /// The rows of the rays that the caller has to cast by the plain path. Their hits, if any, mean nothing.
    pub fn plain_rows(&self) -> &[u32] {
        &self.found.plain
    }
}

/// Rays whose way of traversal is chosen together.
const CHUNK: usize = 2048;

impl WideIndex {
    /// Casts a block of rays. The result has the bits of the plain path.
    pub fn cast(&self, frame: &MeshFrame, block: &RayBlock, query: BlockQuery, memory: &mut KernelMemory) {
        if self.has_duplicates && query == BlockQuery::Operand {
            // The plain path finds faces in whose planes a ray runs by the boxes of whole triangles.
            return memory.leave_all(block.lines.rows.len());
        }
        memory.clear();
        if self.tree.nodes.is_empty() {
            // No triangle is left after scaling.
            return;
        }
        match &self.blocks {
            Blocks::Single(blocks) => self.cast_at(blocks, frame, block, query, memory),
            Blocks::Double(blocks) => self.cast_at(blocks, frame, block, query, memory),
        }
    }

    fn cast_at<C: Coordinate>(
        &self,
        blocks: &[Block<C>],
        frame: &MeshFrame,
        block: &RayBlock,
        query: BlockQuery,
        memory: &mut KernelMemory,
    ) {
        let preparation = Preparation::of(frame, self.tree.frame, query);
        let has_duplicates = self.has_duplicates;
        let kernel = Kernel { frame, tree: &self.tree, blocks, has_duplicates, preparation, block };
        match query {
            BlockQuery::Nearest => kernel.cast::<Closest>(memory),
            BlockQuery::Any => kernel.cast::<Any>(memory),
            BlockQuery::All | BlockQuery::Within | BlockQuery::Operand => kernel.cast::<All>(memory),
            BlockQuery::AnyOffEdges => kernel.cast::<AnyOffEdges>(memory),
            BlockQuery::First => {
                kernel.cast::<Closest>(memory);
                kernel.keep_hits_within(memory);
            }
        }
    }
}

/// A cast.
struct Cast<'a, C, M> {
    kernel: &'a Kernel<'a, C>,
    memory: &'a mut KernelMemory,
    mode: PhantomData<M>,
}

impl<C: Coordinate, M: Mode> Task for Cast<'_, C, M> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        self.kernel.cast_by::<S, M>(self.memory);
    }
}

impl<C: Coordinate> Kernel<'_, C> {
    fn cast<M: Mode>(&self, memory: &mut KernelMemory) {
        dispatch(Cast { kernel: self, memory, mode: PhantomData::<M> });
    }

    #[inline(always)]
    fn cast_by<S: Simd, M: Mode>(&self, memory: &mut KernelMemory) {
        let KernelMemory { slots, stream, found, hits, hit_faces } = memory;
        let rows = self.lines().rows.len();
        for start in (0..rows).step_by(CHUNK) {
            let chunk = start..rows.min(start + CHUNK);
            if chunk.len() >= stream::SIZE && self.is_coherent::<S, M>(chunk.clone()) {
                for start in chunk.clone().step_by(stream::SIZE) {
                    stream::cast::<S, C, M>(self, start..chunk.end.min(start + stream::SIZE), stream, found);
                }
            } else {
                wave::cast::<S, C, M>(self, chunk.clone(), slots, found);
            }
            if M::OFF_EDGES {
                let face = |hit: &LaneHit| (hit.row, self.face(hit.leaf, hit.lane as usize));
                hit_faces.extend(found.lane_hits.drain(..).map(|hit| face(&hit)));
            }
            if M::ANY {
                continue;
            }
            if found.is_full() {
                found.plain.extend(chunk.map(|row| row as u32));
            } else {
                self.take_hits::<S, M>(found, chunk, hits);
            }
            found.lane_hits.clear();
        }
    }

    /// Appends the hits that have been found at the rays of a chunk, each once.
    #[inline(always)]
    fn take_hits<S: Simd, M: Mode>(&self, found: &mut Found, chunk: Range<usize>, hits: &mut Vec<MeshHit>) {
        if !M::CLOSEST {
            found.sort_by_row(chunk);
        }
        if self.has_duplicates {
            let key = |hit: &LaneHit| (hit.row, self.face(hit.leaf, hit.lane as usize));
            found.lane_hits.sort_unstable_by_key(|hit| (key(hit), hit.leaf));
            found.lane_hits.dedup_by_key(|hit| key(hit));
        }
        self.finish::<S>(&found.lane_hits, hits);
    }

    /// Keeps the first hits that are events within the span. Those near its ends are left to the plain path.
    fn keep_hits_within(&self, KernelMemory { hits, found, .. }: &mut KernelMemory) {
        let t_min = self.block.span.t_min();
        hits.retain(|hit| {
            let t_max = self.block.end(hit.row as usize);
            let is_within =
                hit.crossing.low() > t_min && (t_max == f64::INFINITY || hit.crossing.high() < t_max);
            if !is_within {
                found.plain.push(hit.row);
            }
            is_within
        });
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::{Affine, Vec3};
    use crate::ray::{Line, Ray, Span};
    use crate::simd::Portable;
    use crate::solid::mesh::MeshSolid;
    use crate::solid::mesh::kernel::Lines;
    use crate::testkit::meshes::{Thin, rays_at};
    use crate::testkit::random::Random;

    /// The ways to cast a chunk: as chosen, by the operations in plain Rust, as a wave, and as streams.
    #[derive(Clone, Copy, Debug)]
    enum Way {
        Chosen,
        Portable,
        Wave,
        Streams,
    }

    /// A hit, as bits.
    type Bits = (u32, u32, u64, u64, bool, [u64; 3], [bool; 2]);

    /// The hits of the rays that are not left to the plain path, the rows that hit something, and the rows that are
    /// left.
    type Outcome = (Vec<Bits>, Vec<usize>, Vec<u32>);

    fn outcome(memory: &KernelMemory) -> Outcome {
        let bits = |hit: &MeshHit| {
            let MeshHit { row, crossing, normal, is_against, is_off_edges } = *hit;
            let normal = normal.to_array().map(f64::to_bits);
            let t = (crossing.t.to_bits(), crossing.t_err.to_bits());
            (row, crossing.primitive, t.0, t.1, crossing.entering, normal, [is_against, is_off_edges])
        };
        let of_faces = memory.hit_faces().iter().map(|(row, _)| *row as usize);
        let rows_hit = memory.rows_hit().chain(of_faces).collect();
        (memory.hits().iter().map(bits).collect(), rows_hit, memory.plain_rows().to_vec())
    }

    impl<C: Coordinate> Kernel<'_, C> {
        fn cast_in<M: Mode>(&self, way: Way, memory: &mut KernelMemory) {
            let rows = 0..self.lines().rows.len();
            let KernelMemory { slots, stream, found, .. } = &mut *memory;
            match way {
                Way::Chosen => return self.cast::<M>(memory),
                Way::Portable => return self.cast_by::<Portable, M>(memory),
                Way::Wave => wave::cast::<Portable, C, M>(self, rows.clone(), slots, found),
                Way::Streams => rows.clone().step_by(stream::SIZE).for_each(|start| {
                    let some = start..rows.end.min(start + stream::SIZE);
                    stream::cast::<Portable, C, M>(self, some, stream, found);
                }),
            }
            if !M::ANY {
                self.take_hits::<Portable, M>(&mut memory.found, rows, &mut memory.hits);
                memory.found.lane_hits.clear();
            }
        }
    }

    fn cast_at<C: Coordinate>(
        index: &WideIndex,
        blocks: &[Block<C>],
        (frame, block): (&MeshFrame, &RayBlock),
        query: BlockQuery,
        way: Way,
    ) -> Outcome {
        let preparation = Preparation::of(frame, index.tree.frame, query);
        let has_duplicates = index.has_duplicates;
        let kernel = Kernel { frame, tree: &index.tree, blocks, has_duplicates, preparation, block };
        let mut memory = KernelMemory::default();
        match query {
            BlockQuery::Nearest | BlockQuery::First => kernel.cast_in::<Closest>(way, &mut memory),
            BlockQuery::Any => kernel.cast_in::<Any>(way, &mut memory),
            BlockQuery::All | BlockQuery::Within | BlockQuery::Operand => {
                kernel.cast_in::<All>(way, &mut memory)
            }
            BlockQuery::AnyOffEdges => kernel.cast_in::<AnyOffEdges>(way, &mut memory),
        }
        outcome(&memory)
    }

    /// The outcome in the order of rows and triangles, without rays that are left to the plain path in either way.
    fn comparable((mut hits, mut rows, _): Outcome, plain: &[u32]) -> (Vec<Bits>, Vec<usize>) {
        hits.retain(|hit| !plain.contains(&hit.0));
        rows.retain(|row| !plain.contains(&(*row as u32)));
        hits.sort_unstable();
        rows.sort_unstable();
        (hits, rows)
    }

    fn rows_of(lines: &[Line], half: impl Fn(&Line) -> (Vec3, Vec3)) -> Vec<[f64; 6]> {
        let row = |(a, b): (Vec3, Vec3)| [a.x, a.y, a.z, b.x, b.y, b.z];
        lines.iter().map(|line| row(half(line))).collect()
    }

    /// A mesh, rays at it, and how they are cast.
    fn compare_ways(random: &mut Random, rays: &[Ray], solid: &MeshSolid, query: BlockQuery) {
        let index = solid.index.as_wide().expect("a wide index");
        let frame = MeshFrame {
            size: solid.size,
            scaled_bounds: solid.scaled_bounds,
            is_inward: solid.topology.signed_volume.is_sign_negative(),
        };
        let turn = Affine::rotation_xyz(Vec3::new(10.0, 20.0, 30.0));
        let affine = if random.below(2) == 0 { Affine::IDENTITY } else { turn };
        let exact = rows_of(&rays.iter().map(Line::of).collect::<Vec<_>>(), |line| (line.o, line.d));
        let lines: Vec<Line> = rays.iter().map(|ray| Line::of(ray).in_frame(&affine)).collect();
        let rows = rows_of(&lines, |line| (line.o, line.d));
        let errors = rows_of(&lines, |line| (line.o_err, line.d_err));
        let span = [Span::FORWARD, Span::new(-1.0, 1.0).expect("a span")][random.below(2)];
        let block = RayBlock {
            rays: &exact,
            frames: [&affine, &Affine::IDENTITY],
            wants_normals: random.below(2) == 0,
            lines: Lines { rows: &rows, errors: (affine == turn).then_some(&errors) },
            span,
            ends: None,
            cancel: None,
        };
        let cast = |way: Way| match &index.blocks {
            Blocks::Single(blocks) => cast_at(index, blocks, (&frame, &block), query, way),
            Blocks::Double(blocks) => cast_at(index, blocks, (&frame, &block), query, way),
        };
        let chosen = cast(Way::Chosen);
        assert_eq!(chosen, cast(Way::Portable), "{query:?} {span:?}");
        for way in [Way::Wave, Way::Streams] {
            let other = cast(way);
            let plain = [&chosen.2[..], &other.2].concat();
            assert_eq!(
                comparable(other, &plain),
                comparable(chosen.clone(), &plain),
                "{way:?} {query:?} {span:?}"
            );
        }
    }

    /// The instructions change no bit and not even the order; waves and streams find the same hits. Rays that are left
    /// to the plain path because of another hit nearby may differ.
    #[test]
    fn all_ways_to_cast_find_the_same_hits() {
        let mut random = Random::new(7);
        for _ in 0..150 {
            let thin = if random.below(2) == 0 { Thin::any(&mut random) } else { Thin::near(&mut random) };
            let mut mesh = thin.mesh(&mut random);
            if random.below(2) == 0 {
                let single = |v: Vec3| Vec3::from(v.to_array().map(|x| f64::from(x as f32)));
                mesh.vertices.iter_mut().for_each(|v| *v = single(*v));
            }
            let rays = rays_at(&mut random, &mesh, &thin, 150);
            let accel = ["bvh", "bvh_best"][random.below(2)];
            let Ok(solid) = MeshSolid::new(Arc::new(mesh), accel) else { continue };
            for query in [
                BlockQuery::Nearest,
                BlockQuery::Any,
                BlockQuery::All,
                BlockQuery::AnyOffEdges,
                BlockQuery::First,
                BlockQuery::Within,
            ] {
                compare_ways(&mut random, &rays, &solid, query);
            }
        }
    }
}
