//! A mesh prepared for ray queries.

use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, OnceLock};

use super::corners::Corners;
use super::distribute::{CHUNK, divided};
use super::empty_cells::EmptyCells;
use super::face_sides::{FaceSides, is_clear};
use super::index::MeshIndex;
use super::kernel::{BlockQuery, KernelMemory, MeshFrame, RayBlock, WideIndex};
use super::mesh_line::{MeshLine, PowerOfTwoScale};
use super::tally::FaceContacts;
use super::triangles::Triangles;
use super::winding::{FirstEntry, first_entry, order, to_crossings, total};
use super::{Attribute, MeshError, Topology, TriangleMesh, plane};
use crate::aabb::Aabb;
use crate::accel::NAMES;
use crate::contact::Contact;
use crate::counters::Counters;
use crate::crossing::Crossing;
use crate::math::Vec3;
use crate::ray::{Line, Span};
use crate::scratch::Scratch;
use crate::simd::{Simd, Task, dispatch};
use crate::solid::{Moments, Solid, Wanted};
use crate::trace::Act;

/// A mesh prepared for ray queries. It is a valid [`Solid`] only if it is closed; its inside is where the winding
/// number is not zero. [`MeshSolid::hits`] and [`MeshSolid::nearest`] query the surface, closed or not. Lines whose origin
/// is more than 1e150 sizes of the mesh away hit nothing.
#[derive(Debug)]
pub struct MeshSolid {
    pub(super) mesh: Arc<TriangleMesh>,
    pub(super) topology: Topology,
    pub(super) bounds: Aabb,
    pub(super) size: PowerOfTwoScale,
    /// The scaled triangles; an accelerator's items are their numbers.
    pub(super) triangles: Triangles,
    pub(super) scaled_bounds: Aabb,
    /// The name of the accelerator.
    accel: &'static str,
    pub(super) index: MeshIndex,
    /// Made for the first point whose nearest point is asked for, if the accelerator is another.
    pub(super) closest_index: OnceLock<WideIndex>,
    pub(super) face_contacts: OnceLock<FaceContacts>,
    /// Made for the first rays of blocks that need it; `None` if it cannot be made.
    face_sides: OnceLock<Option<FaceSides>>,
    /// Made when enough points have been tested; `None` if it cannot be made.
    pub(super) empty_cells: OnceLock<Option<EmptyCells>>,
    /// The number of points that were tested.
    pub(super) points: AtomicUsize,
}

impl MeshSolid {
    /// Checks a mesh and builds an accelerator over it, by name (see [`NAMES`]).
    ///
    /// # Errors
    /// [`MeshError`] if the input is not a mesh. An open mesh is not an error: see [`Topology`].
    pub fn new(mesh: Arc<TriangleMesh>, accel: &str) -> Result<MeshSolid, MeshError> {
        MeshSolid::with_index(mesh, accel, |_, _| None)
    }

    /// Returns the vertices and triangles.
    pub fn triangle_mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The solid of the same faces with moved vertices, which keep their numbers. It has the same bits as one made by
    /// [`MeshSolid::new`]. The accelerator is refitted, which is faster than to build it, unless it would become too slow
    /// or other faces than before have no area: then it is built. Attributes are kept, `normal` too, which may not fit the
    /// moved vertices.
    ///
    /// # Errors
    /// As [`MeshSolid::new`].
    pub fn with_vertices(&self, vertices: Vec<Vec3>) -> Result<MeshSolid, MeshError> {
        let TriangleMesh { faces, polygons, attributes, .. } = &*self.mesh;
        let mesh = TriangleMesh {
            vertices,
            faces: faces.clone(),
            polygons: polygons.clone(),
            attributes: attributes.clone(),
        };
        MeshSolid::with_index(Arc::new(mesh), self.accel, |triangles, bounds| {
            let is_same = triangles.has_faces_of(&self.triangles);
            if is_same { self.index.refitted(triangles, bounds) } else { None }
        })
    }

    /// Checks a mesh and takes the index that `reuse` returns, or builds one.
    fn with_index(
        mesh: Arc<TriangleMesh>,
        accel: &str,
        reuse: impl FnOnce(&Triangles, &Aabb) -> Option<MeshIndex> + Send,
    ) -> Result<MeshSolid, MeshError> {
        let unknown = || MeshError::UnknownAccelerator { name: accel.to_string() };
        let corners = Corners::of(&mesh)?;
        let size = PowerOfTwoScale::of(corners.largest());
        let name = NAMES.iter().copied().find(|name| *name == accel);
        let index = || {
            let triangles = Triangles::of(mesh.clone(), size, &corners);
            let [bounds, scaled_bounds] = triangles.bounds(&corners);
            let index = reuse(&triangles, &scaled_bounds)
                .or_else(|| MeshIndex::build(name?, &triangles, &scaled_bounds));
            (triangles, bounds, scaled_bounds, index)
        };
        let topology = || Topology::of_valid(&mesh);
        let both =
            || if mesh.faces.len() < CHUNK { (topology(), index()) } else { rayon::join(topology, index) };
        let (topology, (triangles, bounds, scaled_bounds, index)) = divided(mesh.elements(), both);
        let topology = topology?;
        let (accel, index) = name.zip(index).ok_or_else(unknown)?;
        Ok(MeshSolid {
            bounds,
            scaled_bounds,
            mesh,
            topology,
            size,
            triangles,
            accel,
            index,
            closest_index: OnceLock::new(),
            face_contacts: OnceLock::new(),
            face_sides: OnceLock::new(),
            empty_cells: OnceLock::new(),
            points: AtomicUsize::new(0),
        })
    }

    /// The report on the mesh's defects.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Whether the mesh is closed, and so a solid.
    pub fn is_closed(&self) -> bool {
        self.topology.is_closed()
    }

    /// Appends all hits of the surface in the span, sorted by `t` and then by triangle. A hit enters where the line
    /// sees the front. A ray through a shared edge or vertex hits one of the triangles there.
    pub fn hits(&self, line: &Line, span: Span, out: &mut Vec<Crossing>, scratch: &mut Scratch) {
        self.reserve_tags(scratch);
        if let Some(mesh_line) = self.mesh_line(line) {
            self.hits_between(&mesh_line, span.t_min(), span.t_max(), out, scratch);
        }
    }

    /// Returns the first of the [`MeshSolid::hits`].
    pub fn nearest(&self, line: &Line, span: Span, scratch: &mut Scratch) -> Option<Crossing> {
        self.reserve_tags(scratch);
        let mesh_line = self.mesh_line(line)?;
        let mut nearest: Option<Crossing> = None;
        self.traverse(&mesh_line, span.t_min(), span.t_max(), scratch, |hit| {
            if nearest.is_none_or(|best| order(&hit, &best).is_lt()) {
                nearest = Some(hit);
            }
            nearest.map_or(hit.t, |best| best.t)
        });
        nearest
    }

    /// Prepares a line for the triangles; `None` if it hits none.
    pub(super) fn mesh_line(&self, line: &Line) -> Option<MeshLine> {
        MeshLine::new(line, &self.size, &self.scaled_bounds)
    }

    /// Reserves tags for the triangles if the accelerator has duplicate references. This pays off only if `scratch` is
    /// reused.
    fn reserve_tags(&self, scratch: &mut Scratch) {
        if self.index.has_duplicate_refs() {
            scratch.tags.reserve(self.triangles.len());
        }
    }

    /// Visits hits between two `t` in the accelerator's order, roughly nearest first; a hit may be visited twice if no
    /// tags are reserved. `visit` returns the `t` behind which hits are no longer needed.
    fn traverse(
        &self,
        mesh_line: &MeshLine,
        from: f64,
        to: f64,
        scratch: &mut Scratch,
        mut visit: impl FnMut(Crossing) -> f64,
    ) {
        let mut limit = to;
        let Scratch { counters, tags, log, budget, in_plane, pending } = scratch;
        tags.begin();
        let mut before = *counters;
        let boxes = mesh_line.boxes(from, to);
        self.index.traverse(
            &self.triangles,
            &boxes,
            counters,
            (tags, pending),
            &mut |triangles, counters| {
                let mut hits = Vec::new();
                if !budget.step() {
                    return f64::NEG_INFINITY;
                }
                for triangle in triangles {
                    counters.primitive_tests += 1;
                    // Accelerators also report triangles whose own box the line misses. The result must not depend on them.
                    let run_in_plane = || {
                        if boxes.enter_exit(&triangle.bounds()).is_some() {
                            in_plane.push(triangle.face);
                        }
                    };
                    if let Some(hit) = mesh_line.hit(triangle, run_in_plane)
                        && from <= hit.t
                        && hit.t <= limit
                    {
                        // Hits are inserted in order, which is expensive if there are many.
                        if !budget.step() {
                            return f64::NEG_INFINITY;
                        }
                        limit = visit(hit);
                        if log.is_on() {
                            hits.push(hit);
                        }
                    }
                }
                if log.is_on() {
                    let met = |w: &Counters| w.boxes + w.cells + w.planes;
                    log.add(2, None, || Act::Run {
                        met: met(counters) - met(&before),
                        tested: counters.primitive_tests - before.primitive_tests,
                        saved: counters.tags_saved - before.tags_saved,
                        hits,
                        limit,
                    });
                    before = *counters;
                }
                mesh_line.latest_scaled(limit)
            },
        );
    }

    /// Appends all hits between two `t`, in order, each once.
    pub(super) fn hits_between(
        &self,
        mesh_line: &MeshLine,
        from: f64,
        to: f64,
        out: &mut Vec<Crossing>,
        scratch: &mut Scratch,
    ) {
        let start = out.len();
        self.traverse(mesh_line, from, to, scratch, |hit| {
            insert(out, start, hit);
            to
        });
    }

    /// Appends the hits that decide the first boundary from `t_min` on: those up to the end of the first entry, or all
    /// if there is none. The line must be outside at `from`, the earliest `t` at which an event that reaches to `t_min`
    /// begins.
    fn hits_to_first_entry(
        &self,
        mesh_line: &MeshLine,
        t_min: f64,
        [mut from, to]: [f64; 2],
        out: &mut Vec<Crossing>,
        scratch: &mut Scratch,
    ) {
        let start = out.len();
        let end =
            |hits: &[Crossing]| first_entry(hits, t_min).map_or(to, |e| to.min(mesh_line.event_end(e.reach)));
        let mut wanted = to;
        loop {
            let mut lowest = wanted;
            self.traverse(mesh_line, from, wanted, scratch, |hit| {
                insert(out, start, hit);
                lowest = lowest.min(end(&out[start..]));
                lowest
            });
            // Hits are complete up to the lowest limit. That limit is too early if the hits that set it turned out to
            // be an event without effect (a flap): continue from there.
            wanted = end(&out[start..]);
            if wanted <= lowest {
                break;
            }
            from = lowest;
        }
        if let Some(FirstEntry { hits, .. }) = first_entry(&out[start..], t_min) {
            out.truncate(start + hits);
        }
    }

    /// Whether blocks of rays can be cast at the mesh. Their visits of nodes are not counted as steps.
    pub(crate) fn casts_blocks(&self) -> bool {
        self.index.as_wide().is_some()
    }

    /// Asks for the corners of triangles from which normals will be computed soon.
    pub(crate) fn prefetch(&self, triangles: impl Iterator<Item = u32>) {
        dispatch(Prefetch { mesh: &self.mesh, triangles });
    }

    /// Casts a block of rays. The result has the bits of the plain path.
    pub(crate) fn cast_block(&self, block: &RayBlock, query: BlockQuery, memory: &mut KernelMemory) {
        match self.index.as_wide() {
            Some(index) => index.cast(&self.frame(), block, query, memory),
            None => memory.leave_all(block.lines.rows.len()),
        }
    }

    /// What is known of the sides of the faces, if that is of use.
    pub(crate) fn face_sides(&self) -> Option<&FaceSides> {
        let sides = match self.face_sides.get() {
            Some(sides) => sides,
            None => {
                // Made before the cell is taken: while this thread waits for others, it may begin work that needs it.
                let faces = self.mesh.faces.len();
                let sides = divided(faces, || FaceSides::of(&self.triangles, faces));
                self.face_sides.get_or_init(|| sides)
            }
        };
        sides.as_ref().filter(|sides| sides.are_useful())
    }

    /// Takes the winding number on the front of a face where a ray of a block has hit it off the edges.
    pub(crate) fn learn_front(&self, face: u32, front: i32) {
        if let (Some(sides), Some(index)) = (self.face_sides(), self.index.as_wide()) {
            sides.learn(face, front, || is_clear(index, &self.triangles.of_face(face)));
        }
    }

    /// The winding number at a point: minus the sum of the hits on one side. `None` if lines from there hit nothing
    /// because the point is too far away.
    pub(super) fn winding_number(&self, p: Vec3) -> Option<i32> {
        let mesh_line = self.mesh_line(&Line::exact(p, Vec3::Z))?;
        let mut hits = Vec::new();
        self.hits_between(&mesh_line, 0.0, f64::INFINITY, &mut hits, &mut Scratch::default());
        Some(-total(&hits))
    }

    fn frame(&self) -> MeshFrame {
        MeshFrame {
            size: self.size,
            scaled_bounds: self.scaled_bounds,
            is_inward: self.topology.signed_volume.is_sign_negative(),
        }
    }

    /// The scaled corners of a triangle of the mesh.
    pub(super) fn corners(&self, primitive: u32) -> [Vec3; 3] {
        self.mesh.corners(primitive).map(|v| self.size.scale(v))
    }
}

struct Prefetch<'a, I> {
    mesh: &'a TriangleMesh,
    triangles: I,
}

impl<I: Iterator<Item = u32>> Task for Prefetch<'_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        for triangle in self.triangles {
            for &vertex in &self.mesh.faces[triangle as usize] {
                S::prefetch(&raw const self.mesh.vertices[vertex as usize]);
            }
        }
    }
}

/// Inserts a hit into the sorted hits from `start` on, unless it is already there.
fn insert(out: &mut Vec<Crossing>, start: usize, hit: Crossing) {
    if let Err(place) = out[start..].binary_search_by(|other| order(other, &hit)) {
        out.insert(start + place, hit);
    }
}

impl Solid for MeshSolid {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn crossings(&self, line: &Line, out: &mut Vec<Crossing>) {
        let Some(mesh_line) = self.mesh_line(line) else { return };
        let start = out.len();
        self.hits_between(&mesh_line, f64::NEG_INFINITY, f64::INFINITY, out, &mut Scratch::default());
        to_crossings(out, start, 0);
    }

    fn crossings_within(
        &self,
        line: &Line,
        span: Span,
        wanted: Wanted,
        out: &mut Vec<Crossing>,
        scratch: &mut Scratch,
    ) {
        self.reserve_tags(scratch);
        let Some(mesh_line) = self.mesh_line(line) else { return };
        let start = out.len();
        // Hits just outside the span may belong to the same event as hits in it.
        let from = mesh_line.event_start(span.t_min());
        let to = mesh_line.event_end(span.t_max());
        let Some((enter, _)) = mesh_line.boxes(from, to).enter_exit(&self.scaled_bounds) else { return };
        if enter <= mesh_line.scaled(from) {
            // The line may be inside here. It is outside behind its last hit, so the sum of all hits ahead gives the
            // winding number.
            self.hits_between(&mesh_line, from, f64::INFINITY, out, scratch);
            let before = -total(&out[start..]);
            to_crossings(out, start, before);
        } else {
            match wanted {
                Wanted::All => self.hits_between(&mesh_line, from, to, out, scratch),
                Wanted::First => self.hits_to_first_entry(&mesh_line, span.t_min(), [from, to], out, scratch),
            }
            to_crossings(out, start, 0);
        }
    }

    fn contacts(&self, line: &Line, out: &mut Vec<Contact>, scratch: &mut Scratch) {
        let faces = std::mem::take(&mut scratch.in_plane);
        if let Some(mesh_line) = self.mesh_line(line).filter(|_| !faces.is_empty()) {
            self.contacts_with(&faces, line, &mesh_line, out, scratch);
        }
    }

    /// The height above the triangle's plane.
    fn implicit(&self, p: Vec3, surface: u32, primitive: u32) -> f64 {
        let [a, ..] = self.corners(primitive);
        self.normal(p, surface, primitive).dot(self.size.scale(p) - a)
    }

    /// The triangle's normal, negated if the mesh is wound inward.
    fn normal(&self, _p: Vec3, _surface: u32, primitive: u32) -> Vec3 {
        self.frame().oriented(plane::normal(self.corners(primitive)))
    }

    fn contains(&self, p: Vec3) -> bool {
        if !self.bounds.contains(p) {
            return false;
        }
        self.winding_number(p).is_some_and(|winding| winding != 0)
    }

    fn surfaces(&self) -> &'static [&'static str] {
        &["mesh"]
    }

    fn barycentric(&self, p: Vec3, primitive: u32) -> Option<[f64; 2]> {
        let [a, b, c] = self.corners(primitive);
        let (ab, ac, ap) = (b - a, c - a, self.size.scale(p) - a);
        // Project along the axis in which the normal is longest, so that the areas are largest.
        let normal = ab.cross(ac);
        let n = normal.abs();
        let k = if n.z >= n.x && n.z >= n.y { 2 } else { usize::from(n.y >= n.x) };
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let area = |u: Vec3, v: Vec3| (u[i] * v[j] - u[j] * v[i]) / normal[k];
        Some([area(ap, ac), area(ab, ap)])
    }

    fn polygon(&self, primitive: u32) -> Option<u32> {
        Some(self.mesh.polygon(primitive))
    }

    fn moments(&self) -> Option<Moments> {
        self.exact_moments()
    }

    fn as_mesh(&self) -> Option<&MeshSolid> {
        Some(self)
    }

    fn memory(&self) -> usize {
        size_of_val(self.mesh.vertices.as_slice())
            + size_of_val(self.mesh.faces.as_slice())
            + size_of_val(self.mesh.polygons.as_slice())
            + self.mesh.attributes.iter().map(Attribute::memory).sum::<usize>()
            + self.triangles.memory()
            + self.index.memory()
            + self.closest_index.get().map_or(0, WideIndex::memory)
            + self.face_sides.get().and_then(Option::as_ref).map_or(0, FaceSides::memory)
            + self.empty_cells.get().and_then(Option::as_ref).map_or(0, EmptyCells::memory)
            + self.face_contacts.get().map_or(0, FaceContacts::memory)
    }
}
