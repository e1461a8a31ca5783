//! Profiles: the polygons, in the half-plane of the distance from the z axis and of z, of solids around that axis.

use super::{ParamError, Rows};
use crate::polygon::{Ring, RingError};

/// The polygon whose corners are the rows of a parameter.
pub(super) fn ring(corners: &Rows<2>) -> Result<Ring, ParamError> {
    let error = |why: String| ParamError { param: corners.name, why };
    Ring::of(&corners.rows).map_err(|problem| match problem {
        RingError::Flat => error("lie on one line, but must be the corners of a polygon".into()),
        RingError::Crosses([[a, b], [c, d]]) => error(format!(
            "cross: the edge from row {} to row {} crosses that from row {} to row {}; \
             give the corners in their order around the outline",
            a + 1,
            b + 1,
            c + 1,
            d + 1
        )),
    })
}

/// The polygon whose corners are the rows (r, z) of a parameter.
pub(super) fn of_corners(points: &Rows<2>) -> Result<Ring, ParamError> {
    match points.rows.iter().position(|[r, _]| *r < 0.0) {
        Some(row) => Err(points.error(row, "but r, the distance from the axis, must not be negative")),
        None => ring(points),
    }
}

/// The polygons between two radii that are given, as rows (z, rmin, rmax), at planes across the axis, and linear between
/// them. Planes at equal z are a step. Where there is no wall, or only a point of it, one polygon ends and the next begins.
pub(super) fn of_planes(planes: &Rows<3>) -> Result<Vec<Ring>, ParamError> {
    check_planes(planes)?;
    let slabs = planes.rows.windows(2).filter(|pair| pair[0][0] != pair[1][0]);
    let (mut outlines, mut run): (Vec<Vec<[f64; 2]>>, Vec<[f64; 3]>) = (Vec::new(), Vec::new());
    for pair in slabs {
        let [from, to] = [pair[0], pair[1]];
        let goes_on =
            run.last().is_some_and(|[z, low, high]| *z == from[0] && low.max(from[1]) < high.min(from[2]));
        if !goes_on {
            outlines.extend(outline(std::mem::take(&mut run)));
        }
        if from[1] < from[2] || to[1] < to[2] {
            run.extend([from, to]);
        }
    }
    outlines.extend(outline(run));
    let rings: Vec<Ring> = outlines.iter().filter_map(|outline| Ring::of(outline).ok()).collect();
    if rings.is_empty() {
        let why = "enclose nothing, but rmax must be above rmin at one plane, and z must differ between two";
        return Err(ParamError { param: planes.name, why: why.into() });
    }
    Ok(rings)
}

fn check_planes(planes: &Rows<3>) -> Result<(), ParamError> {
    let mut direction = 0.0;
    for (row, [z, rmin, rmax]) in planes.rows.iter().enumerate() {
        if *rmin < 0.0 {
            return Err(planes.error(row, "but rmin must not be negative"));
        }
        if rmax < rmin {
            return Err(planes.error(row, "but rmax must be at least rmin"));
        }
        let before = if row > 0 { planes.rows[row - 1][0] } else { *z };
        if (z - before) * direction < 0.0 {
            let why = format!(
                "and z was {before} before it, but z must ascend or descend from the first row to the last"
            );
            return Err(planes.error(row, &why));
        }
        if *z != before {
            direction = (z - before).signum();
        }
    }
    Ok(())
}

/// The corners between two radii at successive planes: along the outer radii, and back along the inner ones.
fn outline(planes: Vec<[f64; 3]>) -> Option<Vec<[f64; 2]>> {
    let outer = planes.iter().map(|[z, _, rmax]| [*rmax, *z]);
    let inner = planes.iter().rev().map(|[z, rmin, _]| [*rmin, *z]);
    (!planes.is_empty()).then(|| outer.chain(inner).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rings(planes: &[[f64; 3]]) -> Vec<usize> {
        let rows = Rows { name: "planes", rows: planes.to_vec() };
        of_planes(&rows).unwrap().iter().map(|ring| ring.corners.len()).collect()
    }

    #[test]
    fn profiles_end_where_the_wall_does() {
        // A straight wall, though given in two pieces, has four corners.
        assert_eq!(rings(&[[0.0, 1.0, 2.0], [1.0, 1.0, 2.0], [3.0, 1.0, 2.0]]), [4]);
        // A step, and one of several planes.
        assert_eq!(rings(&[[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [1.0, 0.0, 1.0], [3.0, 0.0, 1.0]]), [6]);
        let several = [[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [1.0, 0.0, 9.0], [1.0, 0.0, 1.0], [3.0, 0.0, 1.0]];
        assert_eq!(rings(&several), [6]);
        // Two cones that share their apex; two tubes, one within the other, that share a plane; a wall of no thickness.
        assert_eq!(rings(&[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [2.0, 0.0, 1.0]]), [3, 3]);
        assert_eq!(rings(&[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 2.0, 3.0], [0.0, 2.0, 3.0]][..2]), [4]);
        assert_eq!(rings(&[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 2.0, 3.0], [2.0, 2.0, 3.0]]), [4, 4]);
        assert_eq!(rings(&[[0.0, 1.0, 2.0], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [1e3, 0.0, 2.0]]), [3, 3]);
    }
}
