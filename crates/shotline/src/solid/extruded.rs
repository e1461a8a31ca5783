//! A polygon moved along z, and moved and scaled across it.

use super::faces::Faces;
use super::parts::Parts;
use super::{Build, Kind, Param, ParamError, Params, constructors, profile};
use crate::math::Vec3;
use crate::polygon::triangulate;

pub(super) static KIND: Kind = Kind {
    name: "extruded",
    summary: "a polygon moved along z: at each of several planes across z it is scaled, then moved by x and y, and linear between them",
    interior: "((x, y) - (x(z), y(z))) / scale(z) is inside the polygon, between the first and the last z",
    params: &[
        Param::rows("polygon", &["x", "y"], 3, "the corners of the polygon, in either direction"),
        Param::rows(
            "sections",
            &["z", "x", "y", "scale"],
            2,
            "planes of ascending z, where the origin of the polygon is there, and the factor, which may be 0 at an end",
        )
        .scaling(&[1, 1, 1, 0]),
    ],
    build: Build::Parts(parts),
    examples: &[
        &[&[-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0], &[-1.0, 0.0, 0.0, 1.0, 1.0, 0.5, 0.0, 0.5]],
        // A U with a straight corner, clockwise, in three sections that lean.
        &[
            &[-1.5, -1.0, -1.5, 1.0, -1.0, 1.0, -1.0, -0.5, 0.0, -0.5, 1.0, -0.5, 1.0, 1.25, 1.5, 1.0, 1.5, -1.0],
            &[-2.0, 0.5, 0.5, 1.0, 0.0, 0.0, 0.0, 0.75, 0.5, -0.5, 0.25, 1.5],
        ],
        // A pyramid with its apex above a corner.
        &[&[-1.0, -1.0, 2.0, -1.0, 0.0, 1.5], &[0.0, 0.0, 0.0, 1.0, 2.0, -1.0, -1.0, 0.0]],
    ],
};

constructors! {
    extruded:
    /// The polygon with these corners, moved along z. Each section is z, where the origin of the polygon is there, as x and y,
    /// and the factor by which the polygon is scaled.
    fn extruded(polygon: rows2, sections: rows4);
}

fn parts(p: &Params) -> Result<Parts, ParamError> {
    let ring = profile::ring(&p.rows("polygon")?)?;
    let sections = p.rows::<4>("sections")?;
    let count = sections.rows.len();
    for (row, [z, _, _, scale]) in sections.rows.iter().enumerate() {
        if row > 0 && *z <= sections.rows[row - 1][0] {
            return Err(sections.error(row, "but its z must be above that of the row before"));
        }
        let is_apex = *scale == 0.0 && (row == 0 || row == count - 1);
        if !(*scale > 0.0 || is_apex) {
            return Err(sections.error(row, "but its scale must be positive, or 0 at one of the ends"));
        }
    }
    if count == 2 && sections.rows.iter().all(|[.., scale]| *scale == 0.0) {
        return Err(sections.error(1, "but only one of the two scales may be 0"));
    }
    let mut faces = Faces::default();
    let mut at = |[z, x, y, scale]: &[f64; 4]| -> Vec<u32> {
        let corner = |[u, v]: &[f64; 2]| Vec3::new(x + scale * u, y + scale * v, *z);
        match scale {
            0.0 => vec![faces.vertex(Vec3::new(*x, *y, *z)); ring.corners.len()],
            _ => ring.corners.iter().map(|c| faces.vertex(corner(c))).collect(),
        }
    };
    let levels: Vec<Vec<u32>> = sections.rows.iter().map(&mut at).collect();
    for pair in levels.windows(2) {
        for i in 0..ring.corners.len() {
            let j = (i + 1) % ring.corners.len();
            faces.add(&[pair[0][i], pair[0][j], pair[1][j], pair[1][i]]);
        }
    }
    let flat: Vec<Vec3> = ring.corners.iter().map(|[x, y]| Vec3::new(*x, *y, 0.0)).collect();
    let cut = triangulate(&flat).triangles;
    for (level, is_top) in [(&levels[0], false), (&levels[count - 1], true)] {
        let turned = |[a, b, c]: &[u32; 3]| if is_top { [*a, *b, *c] } else { [*a, *c, *b] };
        let is_point = level[0] == level[1];
        let cut = if is_point { &[][..] } else { &cut[..] };
        faces.add_triangles(cut.iter().map(|face| turned(face).map(|i| level[i as usize])));
    }
    faces.finish("sections")
}
