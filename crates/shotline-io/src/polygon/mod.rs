//! Faces of a mesh file: checked against the number of vertices and cut into triangles.

mod blockers;
mod cut;
#[cfg(any(test, feature = "testkit"))]
pub(crate) mod hold;
mod plane;
#[cfg(test)]
mod tests;

use std::ops::Range;

use shotline::math::Vec3;
use shotline::solid::mesh::{MeshError, TriangleMesh};

pub(crate) use self::cut::{Cut, cut};
use crate::fault::{At, Fault};
use crate::format::MeshFile;
use crate::note::{Effect, Note, NoteKind, Notes, Spot};

/// A vertex number as read, from 0: it may be anything.
pub(crate) type Corner = i64;

const CUT: NoteKind = NoteKind {
    name: "polygons_cut",
    effect: Effect::Kept,
    one: "1 polygon was cut into triangles",
    many: "# polygons were cut into triangles",
};

const IMPROPER: NoteKind = NoteKind {
    name: "crossed_polygons",
    effect: Effect::Changed,
    one: "1 polygon that crosses itself, or is far from flat, was cut into triangles that overlap; its edges are kept",
    many: "# polygons that cross themselves, or are far from flat, were cut into triangles that overlap; their edges \
           are kept",
};

const SHORT: NoteKind = NoteKind {
    name: "short_faces",
    effect: Effect::Changed,
    one: "1 face of fewer than three corners was dropped",
    many: "# faces of fewer than three corners were dropped",
};

const NOT_FINITE: NoteKind = NoteKind {
    name: "vertices_not_finite",
    effect: Effect::Kept,
    one: "1 vertex that no face uses has a coordinate that is NaN or infinite",
    many: "# vertices that no face uses have coordinates that are NaN or infinite",
};

/// The unused vertices of a mesh.
fn unused(count: usize, first: usize) -> Note {
    let text = if count == 1 {
        "1 vertex is used by no face".into()
    } else {
        format!("{count} vertices are used by no face")
    };
    Note { first: Some(Spot::Vertex(first)), ..Note::new("unused_vertices", Effect::Kept, count, text) }
}

/// The vertices of a file, in its numbering.
#[derive(Debug, Default)]
pub(crate) struct Vertices {
    points: Vec<Vec3>,
    /// Those with a coordinate that is NaN or infinite, and where they stand.
    not_finite: Vec<(u32, At)>,
}

impl Vertices {
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// Adds one; any numbers are taken as long as no face uses it.
    pub(crate) fn push(&mut self, point: Vec3, at: impl FnOnce() -> At) {
        if !point.is_finite()
            && let Ok(number) = u32::try_from(self.points.len())
        {
            self.not_finite.push((number, at()));
        }
        self.points.push(point);
    }
}

/// A mesh of faces with any number of corners, which are cut into triangles as those of files are; with notes of what was
/// cut or dropped.
///
/// # Errors
/// [`MeshError`] for a face that names a vertex that does not exist or is not finite, and where there is no face of three
/// corners or more.
pub fn mesh_of_polygons<'a>(
    vertices: Vec<Vec3>,
    faces: impl IntoIterator<Item = &'a [u32]>,
) -> Result<(TriangleMesh, Vec<Note>), MeshError> {
    let count = vertices.len();
    let mut polygons = Polygons::new(count, Notes::default());
    for (face, corners) in faces.into_iter().enumerate() {
        for &vertex in corners {
            let position =
                *vertices.get(vertex as usize).ok_or(MeshError::VertexOutOfRange { face, vertex, count })?;
            if !position.is_finite() {
                return Err(MeshError::NotFinite { vertex: vertex as usize, face, position });
            }
        }
        let corners: Vec<Corner> = corners.iter().map(|corner| Corner::from(*corner)).collect();
        // All corners are known to exist.
        let _ = polygons.add(&corners, || At::File);
    }
    let mut points = Vertices::default();
    vertices.into_iter().for_each(|vertex| points.push(vertex, || At::File));
    let MeshFile { mesh, notes } = polygons.finish(points, 0, &[]).map_err(|_| MeshError::Empty)?;
    Ok((mesh, notes))
}

/// Faces being gathered.
pub(crate) struct Polygons {
    vertices: usize,
    triangles: Vec<[u32; 3]>,
    /// The face of each triangle.
    numbers: Vec<u32>,
    /// Faces of more than three corners. They are cut when all vertices are known.
    uncut: Vec<Uncut>,
    corners: Vec<u32>,
    faces: u32,
    notes: Notes,
}

struct Uncut {
    /// How many triangles stand before it.
    before: usize,
    number: u32,
    corners: Range<usize>,
    at: At,
}

impl Polygons {
    /// Faces between so many vertices, of a file of which something was noted already.
    pub(crate) fn new(vertices: usize, notes: Notes) -> Polygons {
        Polygons {
            vertices,
            triangles: Vec::new(),
            numbers: Vec::new(),
            uncut: Vec::new(),
            corners: Vec::new(),
            faces: 0,
            notes,
        }
    }

    /// Adds a face. Those of fewer than three different corners are dropped and noted.
    ///
    /// # Errors
    /// The first corner that is the number of no vertex.
    pub(crate) fn add(&mut self, corners: &[Corner], at: impl Fn() -> At) -> Result<(), Corner> {
        let number = self.faces;
        self.faces = self.faces.saturating_add(1);
        let first = self.corners.len();
        for corner in corners {
            let inside = usize::try_from(*corner).is_ok_and(|c| c < self.vertices);
            let vertex = u32::try_from(*corner).ok().filter(|_| inside).ok_or(*corner)?;
            // A corner that is given twice in turn is one, but for triangles, which are kept as they are.
            if corners.len() == 3 || self.corners[first..].last() != Some(&vertex) {
                self.corners.push(vertex);
            }
        }
        while corners.len() > 3
            && self.corners.len() > first + 1
            && self.corners.last() == self.corners.get(first)
        {
            self.corners.pop();
        }
        match self.corners[first..] {
            [] | [_] | [_, _] => self.notes.add(&SHORT, at()),
            [a, b, c] => {
                self.triangles.push([a, b, c]);
                self.numbers.push(number);
            }
            _ => {
                let corners = first..self.corners.len();
                self.uncut.push(Uncut { before: self.triangles.len(), number, corners, at: at() });
                return Ok(());
            }
        }
        self.corners.truncate(first);
        Ok(())
    }

    /// Gives the next face a number; without, faces are numbered as they come.
    ///
    /// # Errors
    /// The least number that is possible here.
    pub(crate) fn number(&mut self, number: i64) -> Result<(), u32> {
        let least = self.faces.saturating_sub(1);
        self.faces = u32::try_from(number).ok().filter(|n| *n >= least).ok_or(least)?;
        Ok(())
    }

    /// Whether there is no face of three corners or more.
    pub(crate) fn is_empty(&self) -> bool {
        self.triangles.is_empty() && self.uncut.is_empty()
    }

    /// How many vertices there are.
    pub(crate) fn vertices(&self) -> usize {
        self.vertices
    }

    /// What was noted so far.
    pub(crate) fn notes(&mut self) -> &mut Notes {
        &mut self.notes
    }

    /// The mesh, of a file of these bytes that numbers its vertices from some number on.
    ///
    /// # Errors
    /// If a face uses a vertex that is not finite, or there is no face.
    pub(crate) fn finish(
        mut self,
        vertices: Vertices,
        first_number: usize,
        bytes: &[u8],
    ) -> Result<MeshFile, Fault> {
        if self.is_empty() {
            return Err(Fault::file("has no faces").help("a mesh needs faces of three corners or more"));
        }
        self.look_at(&vertices, first_number)?;
        self.cut(&vertices.points);
        let is_plain = (0..).zip(&self.numbers).all(|(i, number)| i == *number);
        let mesh = TriangleMesh {
            vertices: vertices.points,
            faces: self.triangles,
            polygons: if is_plain { Vec::new() } else { self.numbers },
        };
        Ok(MeshFile { mesh, notes: self.notes.finish(bytes) })
    }

    /// Notes which vertices no face uses, and refuses those that faces use and that are not finite.
    fn look_at(&mut self, vertices: &Vertices, first_number: usize) -> Result<(), Fault> {
        let mut is_used = vec![false; vertices.points.len()];
        for corner in self.triangles.iter().flatten().chain(&self.corners) {
            is_used[*corner as usize] = true;
        }
        for (number, at) in &vertices.not_finite {
            if is_used[*number as usize] {
                let message = "this vertex has a coordinate that is NaN or infinite, and faces use it";
                return Err(Fault { at: at.clone(), message: message.into(), help: None });
            }
            self.notes.add(&NOT_FINITE, at.clone());
        }
        if let Some(first) = is_used.iter().position(|used| !used) {
            let count = is_used.iter().filter(|used| !**used).count();
            self.notes.push(unused(count, first + first_number));
        }
        Ok(())
    }

    /// Cuts the faces of more than three corners and puts their triangles where they belong.
    fn cut(&mut self, vertices: &[Vec3]) {
        if self.uncut.is_empty() {
            return;
        }
        let (mut triangles, mut numbers) = (Vec::new(), Vec::new());
        let mut done = 0;
        for Uncut { before, number, corners, at } in std::mem::take(&mut self.uncut) {
            triangles.extend(&self.triangles[done..before]);
            numbers.extend(&self.numbers[done..before]);
            done = before;
            let corners = &self.corners[corners];
            let places: Vec<Vec3> = corners.iter().map(|c| vertices[*c as usize]).collect();
            let Cut { triangles: cut, is_proper } = cut(&places);
            numbers.extend(std::iter::repeat_n(number, cut.len()));
            triangles.extend(cut.iter().map(|t| t.map(|i| corners[i as usize])));
            if !is_proper {
                self.notes.add(&IMPROPER, at.clone());
            }
            self.notes.add(&CUT, at);
        }
        triangles.extend(&self.triangles[done..]);
        numbers.extend(&self.numbers[done..]);
        (self.triangles, self.numbers) = (triangles, numbers);
    }
}
