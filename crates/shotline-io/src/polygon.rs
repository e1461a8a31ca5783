//! The faces of a mesh file: checked against the number of vertices and triangulated.

use std::ops::Range;

use shotline::math::Vec3;
use shotline::polygon::{Triangulation, triangulate};
use shotline::solid::mesh::{Attribute, MeshError, TriangleMesh};

use crate::diagnostic::RawDiagnostic;
use crate::location::RawLocation;
use crate::mesh_file::MeshFile;
use crate::note::{Effect, Note, NoteKind, Notes, Spot};

/// A vertex number as read, counted from 0. It need not be valid.
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

/// The note of the vertices that no face uses.
fn unused_vertices(count: usize, first: usize) -> Note {
    let text = if count == 1 {
        "1 vertex is used by no face".into()
    } else {
        format!("{count} vertices are used by no face")
    };
    Note { first: Some(Spot::Vertex(first)), ..Note::new("unused_vertices", Effect::Kept, count, text) }
}

/// The vertices of a file, in its order.
#[derive(Debug, Default)]
pub(crate) struct Vertices {
    points: Vec<Vec3>,
    /// Those with a coordinate that is NaN or infinite, and their locations.
    not_finite: Vec<(u32, RawLocation)>,
}

impl Vertices {
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// Makes room for so many more vertices.
    pub(crate) fn reserve(&mut self, count: usize) {
        self.points.reserve(count);
    }

    /// Adds a vertex. Its coordinates need not be finite unless a face uses it.
    pub(crate) fn push(&mut self, point: Vec3, at: impl FnOnce() -> RawLocation) {
        if !point.is_finite()
            && let Ok(number) = u32::try_from(self.points.len())
        {
            self.not_finite.push((number, at()));
        }
        self.points.push(point);
    }
}

/// A mesh of faces with any number of corners, triangulated as the readers of files do; also returns notes of what was
/// triangulated or dropped.
///
/// # Errors
/// [`MeshError`] for a face that names a vertex that does not exist or is not finite, and if no face has three or more
/// corners.
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
        let _ = polygons.add(&corners, || RawLocation::File);
    }
    let mut points = Vertices::default();
    vertices.into_iter().for_each(|vertex| points.push(vertex, || RawLocation::File));
    let MeshFile { mesh, notes, .. } = polygons.finish(points, 0, &[]).map_err(|_| MeshError::Empty)?;
    Ok((mesh, notes))
}

/// The faces of a mesh while it is read.
pub(crate) struct Polygons {
    vertices: usize,
    triangles: Vec<[u32; 3]>,
    /// The number of the face of each triangle.
    numbers: Vec<u32>,
    /// Faces of more than three corners. They are triangulated when all vertices are known.
    pending: Vec<Pending>,
    corners: Vec<u32>,
    faces: u32,
    numbered: Option<NumberedCorners>,
    notes: Notes,
}

/// The numbers of corners: how many corners of faces were read before each. They tell the attributes of a corner.
#[derive(Default)]
struct NumberedCorners {
    read: u32,
    /// Of the corners of each triangle.
    triangles: Vec<[u32; 3]>,
    /// Of the corners of pending faces.
    pending: Vec<u32>,
}

/// A face of more than three corners.
struct Pending {
    /// The number of triangles before it.
    before: usize,
    number: u32,
    corners: Range<usize>,
    at: RawLocation,
}

impl Polygons {
    /// No faces yet, of a file with so many vertices and these notes.
    pub(crate) fn new(vertices: usize, notes: Notes) -> Polygons {
        Polygons {
            vertices,
            triangles: Vec::new(),
            numbers: Vec::new(),
            pending: Vec::new(),
            corners: Vec::new(),
            faces: 0,
            numbered: None,
            notes,
        }
    }

    /// Numbers the corners of the faces, none of which has been added yet, for [`Polygons::finish_with`].
    pub(crate) fn number_corners(&mut self) {
        self.numbered = Some(NumberedCorners::default());
    }

    /// Makes room for so many more triangles.
    pub(crate) fn reserve(&mut self, count: usize) {
        self.triangles.reserve(count);
        self.numbers.reserve(count);
    }

    /// Adds a face. Faces of fewer than three different corners are dropped and noted.
    ///
    /// # Errors
    /// The first corner that is not the number of a vertex.
    pub(crate) fn add(&mut self, corners: &[Corner], at: impl Fn() -> RawLocation) -> Result<(), Corner> {
        let number = self.faces;
        self.faces = self.faces.saturating_add(1);
        let first = self.corners.len();
        for corner in corners {
            let inside = usize::try_from(*corner).is_ok_and(|c| c < self.vertices);
            let vertex = u32::try_from(*corner).ok().filter(|_| inside).ok_or(*corner)?;
            // Equal corners in succession count as one, except in triangles, which are kept as they are.
            if corners.len() == 3 || self.corners[first..].last() != Some(&vertex) {
                self.corners.push(vertex);
                if let Some(numbered) = &mut self.numbered {
                    numbered.pending.push(numbered.read);
                }
            }
            if let Some(numbered) = &mut self.numbered {
                numbered.read = numbered.read.saturating_add(1);
            }
        }
        while corners.len() > 3
            && self.corners.len() > first + 1
            && self.corners.last() == self.corners.get(first)
        {
            self.corners.pop();
            self.numbered.iter_mut().for_each(|numbered| numbered.pending.truncate(self.corners.len()));
        }
        match self.corners[first..] {
            [] | [_] | [_, _] => self.notes.add(&SHORT, at()),
            [a, b, c] => {
                self.triangles.push([a, b, c]);
                self.numbers.push(number);
                if let Some(NumberedCorners { triangles, pending, .. }) = &mut self.numbered {
                    triangles.push([pending[first], pending[first + 1], pending[first + 2]]);
                }
            }
            _ => {
                let corners = first..self.corners.len();
                self.pending.push(Pending { before: self.triangles.len(), number, corners, at: at() });
                return Ok(());
            }
        }
        self.corners.truncate(first);
        if let Some(numbered) = &mut self.numbered {
            numbered.pending.truncate(first);
        }
        Ok(())
    }

    /// Sets the number of the next face. Without it, faces are numbered in order.
    ///
    /// # Errors
    /// The least number that is valid here.
    pub(crate) fn number(&mut self, number: i64) -> Result<(), u32> {
        let least = self.faces.saturating_sub(1);
        self.faces = u32::try_from(number).ok().filter(|n| *n >= least).ok_or(least)?;
        Ok(())
    }

    /// Whether there is no face of three or more corners.
    pub(crate) fn is_empty(&self) -> bool {
        self.triangles.is_empty() && self.pending.is_empty()
    }

    /// The number of the next face.
    pub(crate) fn faces(&self) -> u32 {
        self.faces
    }

    /// How many corners of faces were read, if they are numbered.
    pub(crate) fn corners_read(&self) -> usize {
        self.numbered.as_ref().map_or(0, |numbered| numbered.read as usize)
    }

    /// The number of vertices.
    pub(crate) fn vertices(&self) -> usize {
        self.vertices
    }

    /// The notes so far.
    pub(crate) fn notes(&mut self) -> &mut Notes {
        &mut self.notes
    }

    /// The mesh. `first_number` is the number of the first vertex in the format; `bytes` are the file.
    ///
    /// # Errors
    /// If a face uses a vertex that is not finite, or there is no face.
    pub(crate) fn finish(
        self,
        vertices: Vertices,
        first_number: usize,
        bytes: &[u8],
    ) -> Result<MeshFile, RawDiagnostic> {
        self.finish_with(vertices, first_number, bytes, |_| Vec::new())
    }

    /// The mesh, as [`Polygons::finish`] returns it, with attributes, which are made from the numbers of the corners of each
    /// triangle.
    pub(crate) fn finish_with(
        mut self,
        vertices: Vertices,
        first_number: usize,
        bytes: &[u8],
        attributes: impl FnOnce(&[[u32; 3]]) -> Vec<Attribute>,
    ) -> Result<MeshFile, RawDiagnostic> {
        if self.is_empty() {
            return Err(
                RawDiagnostic::file("has no faces").help("a mesh needs faces of three corners or more")
            );
        }
        self.check_vertices(&vertices, first_number)?;
        self.triangulate(&vertices.points);
        let is_plain = (0..).zip(&self.numbers).all(|(i, number)| i == *number);
        let mesh = TriangleMesh {
            vertices: vertices.points,
            faces: self.triangles,
            polygons: if is_plain { Vec::new() } else { self.numbers },
            attributes: attributes(&self.numbered.unwrap_or_default().triangles),
        };
        Ok(MeshFile { mesh, notes: self.notes.finish(bytes), ..MeshFile::default() })
    }

    /// Notes the vertices that no face uses, and refuses vertices that are not finite and that faces use.
    fn check_vertices(&mut self, vertices: &Vertices, first_number: usize) -> Result<(), RawDiagnostic> {
        let mut is_used = vec![false; vertices.points.len()];
        for corner in self.triangles.iter().flatten().chain(&self.corners) {
            is_used[*corner as usize] = true;
        }
        for (number, at) in &vertices.not_finite {
            if is_used[*number as usize] {
                let message = "this vertex has a coordinate that is NaN or infinite, and faces use it";
                return Err(RawDiagnostic {
                    location: at.clone(),
                    message: message.into(),
                    help: None,
                    file: None,
                });
            }
            self.notes.add(&NOT_FINITE, at.clone());
        }
        if let Some(first) = is_used.iter().position(|used| !used) {
            let count = is_used.iter().filter(|used| !**used).count();
            self.notes.push(unused_vertices(count, first + first_number));
        }
        Ok(())
    }

    /// Triangulates the faces of more than three corners, and inserts their triangles in the order of the faces.
    fn triangulate(&mut self, vertices: &[Vec3]) {
        if self.pending.is_empty() {
            return;
        }
        let (mut triangles, mut numbers) = (Vec::new(), Vec::new());
        let mut numbered = NumberedCorners::default();
        let mut done = 0;
        for Pending { before, number, corners, at } in std::mem::take(&mut self.pending) {
            triangles.extend(&self.triangles[done..before]);
            numbers.extend(&self.numbers[done..before]);
            let of_corners = self
                .numbered
                .as_ref()
                .map(|numbered| (&numbered.triangles[done..before], &numbered.pending[corners.clone()]));
            done = before;
            let corners = &self.corners[corners];
            let points: Vec<Vec3> = corners.iter().map(|c| vertices[*c as usize]).collect();
            let Triangulation { triangles: cut, is_proper } = triangulate(&points);
            numbers.extend(std::iter::repeat_n(number, cut.len()));
            triangles.extend(cut.iter().map(|t| t.map(|i| corners[i as usize])));
            if let Some((whole, of_polygon)) = of_corners {
                numbered.triangles.extend(whole);
                numbered.triangles.extend(cut.iter().map(|t| t.map(|i| of_polygon[i as usize])));
            }
            if !is_proper {
                self.notes.add(&IMPROPER, at.clone());
            }
            self.notes.add(&CUT, at);
        }
        triangles.extend(&self.triangles[done..]);
        numbers.extend(&self.numbers[done..]);
        (self.triangles, self.numbers) = (triangles, numbers);
        if let Some(old) = &mut self.numbered {
            numbered.triangles.extend(&old.triangles[done..]);
            *old = numbered;
        }
    }
}
