//! The tetrahedron with given corners.

use robust::{Coord3D, orient3d};

use super::faces::Faces;
use super::parts::Parts;
use super::{Build, Kind, Param, ParamError, Params, constructors};
use crate::math::Vec3;

pub(super) static KIND: Kind = Kind {
    name: "tetrahedron",
    summary: "the tetrahedron with four given corners",
    interior: "the convex hull of the four corners",
    params: &[Param::rows("corners", &["x", "y", "z"], 4, "four points, not in one plane, in any order")],
    build: Build::Parts(parts),
    examples: &[
        &[&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]],
        &[&[-2.0, 0.5, 0.25, 1.5, 2.0, -1.0, 1.0, -2.0, 0.75, 0.0, 0.25, 2.0]],
        &[&[2.0, 2.0, 2.0, -2.0, -2.0, 2.0, 2.0, -2.0, -2.0, -2.0, 1.5, -2.0]],
    ],
};

constructors! {
    tetrahedron:
    /// The tetrahedron with these four corners.
    fn tetrahedron(corners: rows3);
}

fn parts(p: &Params) -> Result<Parts, ParamError> {
    let rows = p.rows::<3>("corners")?;
    let error = |why: String| ParamError { param: rows.name, why };
    let [a, b, c, d] = rows.rows[..] else {
        return Err(error(format!("has {} rows, but takes four", rows.rows.len())));
    };
    let coord = |[x, y, z]: [f64; 3]| Coord3D { x, y, z };
    // Positive if a, b, c are counter-clockwise seen from the side opposite to d.
    let orientation = orient3d(coord(a), coord(b), coord(c), coord(d));
    if orientation == 0.0 {
        return Err(error("lie in one plane, but must enclose a volume".into()));
    }
    let corners = if orientation > 0.0 { [a, b, c, d] } else { [b, a, c, d] };
    let mut faces = Faces::default();
    let [a, b, c, d] = corners.map(|corner| faces.vertex(Vec3::from(corner)));
    [[a, b, c], [b, a, d], [c, b, d], [a, c, d]].iter().for_each(|face| faces.add(face));
    faces.finish("corners")
}
