//! A polygon turned about the z axis, wholly or by an angle: cones and cylinders between planes.

use super::capped::Capped;
use super::form::Form;
use super::parts::Parts;
use super::sector::Sector;
use super::{Build, Kind, Param, ParamError, Params, cone, constructors, cylinder, profile};
use crate::math::{Dd, two_sum};
use crate::polygon::Ring;

pub(super) static KIND: Kind = Kind {
    name: "revolved",
    summary: "a polygon turned about the z axis, wholly or by an angle",
    interior: "(sqrt(x^2 + y^2), z) is inside the polygon, a sector of dphi degrees about z that begins at the angle phi0",
    params: &[
        Param::rows(
            "points",
            &["r", "z"],
            3,
            "the corners of the polygon, in either direction: the distance from the axis, and z",
        ),
        Param::angle("phi0", "where the part begins, in degrees from the x axis towards the y axis")
            .or(&[0.0]),
        Param::angle("dphi", "the angle that it takes, in degrees, above 0 and at most 360").or(&[360.0]),
    ],
    build: Build::Parts(|p| parts("points", &[profile::of_corners(&p.rows("points")?)?], p)),
    examples: &[
        // A ring of triangular section; an L on the axis; one that is concave towards all sides.
        &[&[1.0, -1.0, 2.0, 0.0, 1.5, 1.0]],
        &[&[0.0, 0.0, 2.0, 0.0, 2.0, 0.5, 0.5, 1.0, 0.0, 2.0], &[20.0], &[250.0]],
        &[&[0.5, -1.0, 2.0, -1.5, 1.5, 0.0, 2.0, 1.0, 1.0, 0.5, 0.25, 2.0, 0.75, 0.25], &[-30.0], &[130.0]],
        // A diamond that touches the axis in a corner, with a corner on a straight edge.
        &[&[0.0, 0.0, 0.5, -0.5, 1.0, -1.0, 2.0, 0.0, 1.0, 1.0]],
    ],
};

constructors! {
    revolved:
    /// The polygon with these corners turned about the z axis. Each corner is its distance from the axis, and its z.
    fn revolved(points: rows2);
    /// The polygon turned by an angle: it begins at phi0, in degrees from the x axis towards the y axis, and takes the angle dphi,
    /// above 0 and at most 360.
    fn revolved_section(points: rows2, phi0: number, dphi: number);
}

/// An edge of a profile that is not across the axis, as (r, z): its lower and its upper end.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    low: [f64; 2],
    high: [f64; 2],
}

/// What is between two edges, from one height to another.
#[derive(Clone, Copy, Debug)]
struct Piece {
    inner: Edge,
    outer: Edge,
    z: [f64; 2],
}

/// The polygons of a parameter turned about the z axis, within the sector of the others.
pub(super) fn parts(param: &'static str, rings: &[Ring], p: &Params) -> Result<Parts, ParamError> {
    let sector = Sector::of(p)?.map(|sector| sector.parts());
    let mut pieces: Vec<Piece> =
        rings.iter().flat_map(pieces).filter(|piece| piece.outer().is_some()).collect();
    pieces.sort_by(|a, b| a.z[0].total_cmp(&b.z[0]));
    let whole = match &pieces[..] {
        [] => return Err(ParamError { param, why: "enclose nothing, as their outline runs twice".into() }),
        // One difference has a sum, which a union of differences does not have.
        pieces if pieces.windows(2).all(|pair| pair[0].z[1] <= pair[1].z[0]) => {
            union(pieces.iter().filter_map(Piece::outer)).without(pieces.iter().filter_map(Piece::inner))
        }
        pieces => union(pieces.iter().filter_map(|piece| Some(piece.outer()?.without(piece.inner())))),
    };
    Ok(whole.within(sector))
}

fn union(parts: impl Iterator<Item = Parts>) -> Parts {
    let mut parts: Vec<Parts> = parts.collect();
    if parts.len() == 1 { parts.remove(0) } else { Parts::Union(parts) }
}

/// A polygon cut at the heights of its corners where its edges change. Between two heights the edges that pass
/// do not cross, and the interior is between the first and the second of them, the third and the fourth...
fn pieces(ring: &Ring) -> Vec<Piece> {
    let mut edges: Vec<Edge> = ring
        .edges()
        .filter(|[a, b]| a[1] != b[1])
        .map(|[a, b]| if a[1] < b[1] { Edge { low: a, high: b } } else { Edge { low: b, high: a } })
        .collect();
    edges.sort_by(|a, b| b.low[1].total_cmp(&a.low[1]));
    let mut heights: Vec<f64> = ring.corners.iter().map(|corner| corner[1]).collect();
    heights.sort_by(f64::total_cmp);
    heights.dedup();
    let (mut done, mut open, mut passing): (Vec<Piece>, Vec<Piece>, Vec<Edge>) = Default::default();
    for pair in heights.windows(2) {
        let z = [pair[0], pair[1]];
        passing.retain(|edge| edge.high[1] > z[0]);
        while let Some(edge) = edges.pop_if(|edge| edge.low[1] <= z[0]) {
            passing.push(edge);
        }
        let mut ordered: Vec<(Dd, Edge)> = passing.iter().map(|edge| (edge.radii(z), *edge)).collect();
        ordered.sort_by(|(a, _), (b, _)| a.hi.total_cmp(&b.hi).then(a.lo.total_cmp(&b.lo)));
        let between = ordered.chunks_exact(2).map(|pair| (pair[0].1, pair[1].1));
        let mut next = Vec::new();
        for (inner, outer) in between.filter(|(inner, outer)| inner != outer) {
            let continued = open.iter().position(|piece| piece.inner == inner && piece.outer == outer);
            let from = continued.map_or(z[0], |number| open.swap_remove(number).z[0]);
            next.push(Piece { inner, outer, z: [from, z[1]] });
        }
        done.append(&mut open);
        open = next;
    }
    done.append(&mut open);
    done
}

impl Edge {
    /// The sum of its radii at two heights, by which edges that do not cross between them are ordered.
    fn radii(&self, z: [f64; 2]) -> Dd {
        let ([r0, z0], [r1, z1]) = (self.low, self.high);
        let slope = two_sum(r1, -r0) * two_sum(z1, -z0).recip();
        let at = |z: f64| slope * two_sum(z, -z0) + Dd::from(r0);
        at(z[0]) + at(z[1])
    }

    /// The cone or the cylinder through all of it; `None` on the axis.
    fn form(&self) -> Option<Form> {
        match (self.low, self.high) {
            ([0.0, _], [0.0, _]) => None,
            ([r0, _], [r1, _]) if r0 == r1 => Some(cylinder::form(r0)),
            ([r0, z0], [r1, z1]) => Some(cone::form(r0, r1, z0, z1)),
        }
    }
}

impl Piece {
    /// The inside of the outer edge; `None` if that is on the axis.
    fn outer(&self) -> Option<Parts> {
        self.inside(&self.outer, &["outer", "bottom", "top"])
    }

    /// The inside of the inner edge.
    fn inner(&self) -> Option<Parts> {
        self.inside(&self.inner, &["inner", "bottom", "top"])
    }

    fn inside(&self, edge: &Edge, surfaces: &'static [&'static str]) -> Option<Parts> {
        let [z0, z1] = self.z;
        let solid = Capped::between(edge.form()?, z0, z1, edge.low[0].max(edge.high[0]));
        Some(Parts::named(solid, surfaces))
    }
}
