//! Regions where the signed volume of a mesh may differ from the volume of its inside.
//!
//! The sum over the faces is the integral of the winding number `w`. Inside is where `w` is not 0, so the sum is wrong
//! where `w` is neither 0 nor the winding number of the inside, 1 or -1. Such a region is bounded by pieces of faces
//! that pass through others or have such a winding number on a side. A box around these faces is bisected repeatedly,
//! and cells that are proven sound are dropped. The remaining cells are sampled, and the correction is added to the sum
//! (a control variate). So the error is proportional to the uncertain volume, not to the mesh.

use std::collections::BinaryHeap;

use super::MeshSolid;
use super::intersections::common_segment;
use super::obb::{in_axes, principal_axes};
use super::patches::Patch;
use super::stop::{Cancelled, Stop};
use super::winding::step;
use crate::aabb::Aabb;
use crate::math::{Affine, Vec3};
use crate::ray::Line;
use crate::scratch::Scratch;
use crate::solid::Moments;

/// At most this many cells are left to be sampled.
const CELLS: usize = 512;

/// At most this many cells are bisected.
const CUTS: usize = 4096;

/// Faces nearer to each other than this, relative to the size of the uncertain region, count as touching.
const TOUCH: f64 = 1e-9;

/// Cells with more faces than this are bisected before any line is cast for them.
const FACES: usize = 32;

/// The integrals of the winding number, and the cells in which it may be wrong.
#[derive(Debug)]
pub struct Doubt<'a> {
    solid: &'a MeshSolid,
    frame: Frame,
    /// The certain integrals, in the frame: the signed sum, corrected in cells that lie in one region.
    certain: [f64; 10],
    /// Disjoint boxes in the frame, each with the total volume up to and including it.
    cells: Vec<(Aabb, f64)>,
}

/// Axes aligned with the uncertain region; lengths are those of the scaled mesh.
#[derive(Clone, Copy, Debug)]
struct Frame {
    origin: Vec3,
    axes: [Vec3; 3],
}

impl Frame {
    fn inward(&self, p: Vec3) -> Vec3 {
        in_axes(&self.axes, p - self.origin)
    }

    /// Converts moments in the scaled mesh to integrals in the frame.
    fn integrals(&self, moments: Moments) -> [f64; 10] {
        let rows = self.axes.map(|axis| [axis.x, axis.y, axis.z, 0.0]);
        let moved = Moments { centroid: moments.centroid - self.origin, ..moments };
        moved.placed(&Affine { rows }).integrals_from(Vec3::ZERO)
    }

    fn turned(&self, v: Vec3) -> Vec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }

    fn outward(&self, p: Vec3) -> Vec3 {
        self.origin + self.turned(p)
    }
}

impl<'a> Doubt<'a> {
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn of(solid: &'a MeshSolid, patches: &[Patch], stop: Stop) -> Result<Doubt<'a>, Cancelled> {
        let suspects = suspects(solid, patches);
        let corners = || suspects.iter().flat_map(|s| solid.triangles.get(s.item).corners);
        let mut frame = Frame { origin: Vec3::ZERO, axes: principal_axes(corners()) };
        frame.origin = frame.outward(Aabb::around(corners().map(|p| frame.inward(p))).centre());
        let certain = frame.integrals(solid.scaled_moments(|_| f64::from(solid.inside())));
        let mut doubt = Doubt { solid, frame, certain, cells: Vec::new() };
        let root = Aabb::around(corners().map(|p| frame.inward(p)));
        let mut cover = Cover::new(&doubt, suspects, root, stop);
        let all = Cell {
            bounds: root,
            faces: (0..cover.faces.len() as u32).collect(),
            face_contacts: (0..cover.face_contacts.len() as u32).collect(),
        };
        let (cells, whole) = cover.cut(all);
        stop.check()?;
        for (bounds, winding) in whole {
            let mended = box_integrals(&bounds, doubt.correction(winding));
            doubt.certain = std::array::from_fn(|i| doubt.certain[i] + mended[i]);
        }
        let mut volume = 0.0;
        doubt.cells.extend(cells.into_iter().map(|bounds| {
            volume += bounds.size().element_product();
            (bounds, volume)
        }));
        Ok(doubt)
    }

    /// Returns the correction of a winding number, counted positive inside, that makes it 1 inside and 0 outside.
    fn correction(&self, winding: i32) -> f64 {
        f64::from(i32::from(winding != 0) - winding * self.solid.inside())
    }

    /// The volume of the cells to be sampled, in units of the original mesh.
    pub fn volume(&self) -> f64 {
        self.solid.size.volume(self.sampled_volume())
    }

    fn sampled_volume(&self) -> f64 {
        self.cells.last().map_or(0.0, |(_, volume)| *volume)
    }

    /// Returns the estimate of the total correction by one line, in the frame. The mean over lines that are evenly
    /// distributed over the unit square, along any of the three axes, is the total correction.
    pub fn sample(&self, axis: usize, place: [f64; 2], scratch: &mut Scratch) -> [f64; 10] {
        let all = self.sampled_volume();
        let wanted = place[0] * all;
        let n = self.cells.partition_point(|(_, volume)| *volume <= wanted).min(self.cells.len().max(1) - 1);
        let Some((bounds, end)) = self.cells.get(n) else { return [0.0; 10] };
        // The rest of the number selects the position in the cell.
        let size = bounds.size();
        let own = size.element_product();
        let part = ((wanted - (end - own)) / own).clamp(0.0, 1.0);
        let mut from = bounds.min;
        from[(axis + 1) % 3] += size[(axis + 1) % 3] * part;
        from[(axis + 2) % 3] += size[(axis + 2) % 3] * place[1];
        let mut sums = [0.0; 10];
        self.regions(from, axis, size[axis], scratch, |[t0, t1], winding| {
            let correction = self.correction(winding);
            if correction != 0.0 {
                let terms = line_integrals(from, axis, size[axis], [t0, t1]);
                sums = std::array::from_fn(|k| sums[k] + terms[k] * correction * all);
            }
        });
        sums
    }

    /// Visits the intervals between the faces, from 0 to 1, of a line of the frame, with their winding numbers.
    fn regions(
        &self,
        from: Vec3,
        axis: usize,
        length: f64,
        scratch: &mut Scratch,
        mut visit: impl FnMut([f64; 2], i32),
    ) {
        let size = &self.solid.size;
        let line =
            Line::exact(size.unscale(self.frame.outward(from)), size.unscale(self.frame.axes[axis] * length));
        let Some(mesh_line) = self.solid.mesh_line(&line) else { return };
        let mut hits = Vec::new();
        self.solid.hits_between(&mesh_line, f64::NEG_INFINITY, 1.0, &mut hits, scratch);
        let (mut winding, mut t) = (0, 0.0);
        for hit in hits {
            let next = hit.t.clamp(0.0, 1.0);
            if next > t {
                visit([t, next], winding);
            }
            (winding, t) = (winding + step(&hit), next);
        }
        if t < 1.0 {
            visit([t, 1.0], winding);
        }
    }

    /// The moments of the inside in the mesh's own frame, given the correction `added` that samples estimate.
    pub fn moments(&self, added: &[f64; 10]) -> Moments {
        let integrals = std::array::from_fn(|i| self.certain[i] + added[i]);
        let [a, b, c] = self.frame.axes;
        let o = self.frame.origin;
        let scale = self.solid.size.unscale(Vec3::ONE).x;
        let row = |i: usize| [a[i] * scale, b[i] * scale, c[i] * scale, o[i] * scale];
        Moments::from_integrals(integrals).placed(&Affine { rows: [row(0), row(1), row(2)] })
    }
}

/// A face that may bound an uncertain region.
struct Suspect {
    item: u32,
    /// Whether the winding number is known to be wrong on one whole side of it.
    is_wrong: bool,
}

fn suspects(solid: &MeshSolid, patches: &[Patch]) -> Vec<Suspect> {
    let marks = &solid.face_contacts().marks;
    let mut suspects = Vec::new();
    for patch in patches {
        let is_wrong = !patch.is_sound();
        let is_suspect = |item: &&u32| is_wrong || marks[**item as usize] != 0;
        suspects.extend(
            patch
                .items
                .iter()
                .filter(is_suspect)
                .map(|&item| Suspect { item, is_wrong: is_wrong && marks[item as usize] == 0 }),
        );
    }
    suspects.sort_by_key(|suspect| suspect.item);
    suspects
}

/// A box of the frame with its contents.
struct Cell {
    bounds: Aabb,
    /// Suspects, as indices into the list.
    faces: Vec<u32>,
    /// Contacts of faces, as indices into the list.
    face_contacts: Vec<u32>,
}

/// The result of examining a cell.
enum Finding {
    Sound,
    /// The cell lies in one region, of this winding number.
    Whole(i32),
    Open(Cell),
}

/// The search for cells that may be uncertain.
struct Cover<'a> {
    doubt: &'a Doubt<'a>,
    faces: Vec<Suspect>,
    /// The corners of these faces in the frame.
    corners: Vec<[Vec3; 3]>,
    /// Boxes around the contacts of faces.
    face_contacts: Vec<Aabb>,
    /// Whether the contacts are too many to be listed, so that faces may meet anywhere.
    anywhere: bool,
    stop: Stop<'a>,
}

impl<'a> Cover<'a> {
    fn new(doubt: &'a Doubt<'a>, faces: Vec<Suspect>, root: Aabb, stop: Stop<'a>) -> Cover<'a> {
        let solid = doubt.solid;
        let triangle = |item: u32| solid.triangles.get(item).corners;
        let inward = |item: u32| triangle(item).map(|p| doubt.frame.inward(p));
        let padding = Vec3::splat(1e-12 * root.size().max_element());
        let padded = |b: Aabb| Aabb::new(b.min - padding, b.max + padding);
        let extent = |[i, j]: &[u32; 2]| match common_segment(triangle(*i), triangle(*j)) {
            Some(ends) => padded(Aabb::around(ends.map(|p| doubt.frame.inward(p)))),
            None => contact(inward(*i), inward(*j), TOUCH * root.size().max_element()),
        };
        let pairs = &solid.face_contacts().pairs;
        let folds = solid.folds();
        Cover {
            doubt,
            corners: faces.iter().map(|face| inward(face.item)).collect(),
            faces,
            face_contacts: pairs
                .iter()
                .flatten()
                .chain(&folds)
                .take_while(|_| !stop.is_set())
                .map(extent)
                .collect(),
            anywhere: pairs.is_none(),
            stop,
        }
    }

    /// Bisects the largest cell until there are enough cells. Returns the uncertain cells, and those that lie in one
    /// region that is not sound.
    fn cut(&mut self, root: Cell) -> (Vec<Aabb>, Vec<(Aabb, i32)>) {
        let (mut open, mut whole) = (BinaryHeap::new(), Vec::new());
        open.push(BySize(root));
        for _ in 0..CUTS {
            if open.len() >= CELLS || self.stop.is_set() {
                break;
            }
            let Some(BySize(cell)) = open.pop() else { break };
            for bounds in halves(&cell.bounds) {
                match self.examine(bounds, &cell) {
                    Finding::Sound => {}
                    Finding::Whole(winding) => whole.push((bounds, winding)),
                    Finding::Open(part) => open.push(BySize(part)),
                }
            }
        }
        let mut cells: Vec<Aabb> = open.into_iter().map(|cell| cell.0.bounds).collect();
        cells.retain(|b| b.size().element_product() > 0.0);
        cells.sort_by(|a, b| {
            let key = |b: &Aabb| b.min.to_array();
            key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal)
        });
        (cells, whole)
    }

    fn examine(&self, bounds: Aabb, parent: &Cell) -> Finding {
        let overlap = |m: &&u32| !self.face_contacts[**m as usize].intersection(&bounds).is_empty();
        let face_contacts: Vec<u32> = parent.face_contacts.iter().filter(overlap).copied().collect();
        let mut faces = Vec::new();
        let mut places = Vec::new();
        for &face in &parent.faces {
            if let Some(middle) = point_within(self.corners[face as usize], &bounds) {
                faces.push(face);
                places.push(middle);
            }
        }
        let solid = self.doubt.solid;
        let out = |p: Vec3| self.doubt.frame.outward(p);
        if faces.is_empty() {
            // The cell holds no suspect, and all other faces are sound. So no face in the cell bounds a region that is
            // not sound: such a region fills the cell, and its centre decides.
            let winding = solid.winding_at(solid.size.unscale(out(bounds.centre())), |_| true);
            let sound = winding == 0 || winding == solid.inside();
            return if sound { Finding::Sound } else { Finding::Whole(winding) };
        }
        let may_meet = !face_contacts.is_empty() || self.anywhere;
        if !may_meet && faces.len() <= FACES {
            let is_sound = |(face, middle): (&u32, &Vec3)| {
                let suspect = &self.faces[*face as usize];
                let sides = || solid.sides(&solid.triangles.get(suspect.item), out(*middle));
                let known = |w: &i32| *w == 0 || *w == solid.inside();
                !suspect.is_wrong && sides().is_some_and(|sides| sides.iter().all(known))
            };
            if faces.iter().zip(&places).all(is_sound) {
                return Finding::Sound;
            }
        }
        Finding::Open(Cell { bounds, faces, face_contacts })
    }
}

/// Cells ordered by volume.
struct BySize(Cell);

impl BySize {
    fn volume(&self) -> f64 {
        self.0.bounds.size().element_product()
    }
}

impl PartialEq for BySize {
    fn eq(&self, other: &BySize) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for BySize {}

impl PartialOrd for BySize {
    fn partial_cmp(&self, other: &BySize) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for BySize {
    fn cmp(&self, other: &BySize) -> std::cmp::Ordering {
        self.volume().total_cmp(&other.volume())
    }
}

/// The two halves of a box, split across its longest edge.
fn halves(bounds: &Aabb) -> [Aabb; 2] {
    let size = bounds.size();
    let axis = (0..3).fold(0, |best, i| if size[i] > size[best] { i } else { best });
    let middle = bounds.min[axis].midpoint(bounds.max[axis]);
    let (mut low, mut high) = (*bounds, *bounds);
    (low.max[axis], high.min[axis]) = (middle, middle);
    [low, high]
}

/// A point of the piece of a triangle that lies in a box; `None` if no piece does.
fn point_within(corners: [Vec3; 3], bounds: &Aabb) -> Option<Vec3> {
    if Aabb::around(corners).intersection(bounds).is_empty() {
        return None;
    }
    let mut polygon = corners.to_vec();
    for axis in 0..3 {
        polygon = clipped(&polygon, |p| p[axis] - bounds.min[axis]);
        polygon = clipped(&polygon, |p| bounds.max[axis] - p[axis]);
    }
    (!polygon.is_empty()).then(|| polygon.iter().sum::<Vec3>() / polygon.len() as f64)
}

/// Clips a convex polygon to where the height is not negative (I. E. Sutherland and G. W. Hodgman 1974).
fn clipped(polygon: &[Vec3], height: impl Fn(Vec3) -> f64) -> Vec<Vec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (n, &p) in polygon.iter().enumerate() {
        let q = polygon[(n + 1) % polygon.len()];
        let (hp, hq) = (height(p), height(q));
        if hp >= 0.0 {
            kept.push(p);
        }
        if (hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0) {
            kept.push(p + (q - p) * (hp / (hp - hq)));
        }
    }
    kept
}

/// A box around the points where two triangles are at most a distance apart.
fn contact(a: [Vec3; 3], b: [Vec3; 3], distance: f64) -> Aabb {
    let padded = |b: Aabb| Aabb::new(b.min - Vec3::splat(distance), b.max + Vec3::splat(distance));
    let both = padded(Aabb::around(a)).intersection(&padded(Aabb::around(b)));
    let normal = (a[1] - a[0]).cross(a[2] - a[0]).normalize();
    if !normal.is_finite() {
        return both;
    }
    // The prism over the first triangle, and a slab around its plane.
    let mut polygon = clipped(&b, |p| normal.dot(p - a[0]) + distance);
    polygon = clipped(&polygon, |p| distance - normal.dot(p - a[0]));
    for k in 0..3 {
        let (from, to) = (a[k], a[(k + 1) % 3]);
        let inward = normal.cross(to - from).normalize();
        polygon = clipped(&polygon, |p| inward.dot(p - from) + distance);
    }
    if polygon.is_empty() { both } else { padded(Aabb::around(polygon)).intersection(&both) }
}

/// The integrals over a box, times a factor.
fn box_integrals(bounds: &Aabb, factor: f64) -> [f64; 10] {
    let (size, middle) = (bounds.size(), bounds.centre());
    let spread = size * size / 12.0;
    Moments::along_axes(size.element_product(), middle, spread).integrals_from(Vec3::ZERO).map(|x| x * factor)
}

/// The integrals of the terms over an interval of a line of the frame, divided by the length of the whole line.
fn line_integrals(from: Vec3, axis: usize, length: f64, [t0, t1]: [f64; 2]) -> [f64; 10] {
    let (a, b) = (from[axis] + t0 * length, from[axis] + t1 * length);
    let (mut mean, mut square) = (from, from * from);
    mean[axis] = a.midpoint(b);
    square[axis] = (a * a + a * b + b * b) / 3.0;
    let Vec3 { x, y, z } = mean;
    [1.0, x, y, z, square.x, square.y, square.z, y * z, x * z, x * y].map(|mean| mean * (t1 - t0))
}
