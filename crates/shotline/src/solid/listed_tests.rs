//! Kinds whose parameters are lists, and other recent ones, against their interiors as formulas that share nothing with them.

use super::{Kind, Params, kind};
use crate::math::Vec3;
use crate::testkit::random::Random;

/// The interior of a kind at a point.
type Interior = fn(&Params, Vec3) -> bool;

fn rows<const N: usize>(p: &Params, name: &'static str) -> Vec<[f64; N]> {
    p.rows::<N>(name).expect("rows").rows
}

fn number(p: &Params, name: &'static str) -> f64 {
    p.number(name).expect("a number")
}

/// The angle of a point from where the sector begins, in degrees.
fn turn(p: &Params, at: Vec3) -> f64 {
    (at.y.atan2(at.x).to_degrees() - number(p, "phi0")).rem_euclid(360.0)
}

fn sector(p: &Params, at: Vec3) -> bool {
    let dphi = number(p, "dphi");
    dphi == 360.0 || turn(p, at) < dphi
}

/// Whether a point is inside a polygon: a line from it to the right crosses the outline an odd number of times.
fn in_polygon(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    let crosses = |([ax, ay], [bx, by]): &(&[f64; 2], &[f64; 2])| {
        (*ay > y) != (*by > y) && x < ax + (bx - ax) * (y - ay) / (by - ay)
    };
    pairs.filter(crosses).count() % 2 == 1
}

/// Whether a radius is between those of the planes at a height.
fn in_planes(planes: &[[f64; 3]], radius: f64, z: f64) -> bool {
    planes.windows(2).any(|pair| {
        let ([z0, min0, max0], [z1, min1, max1]) = (pair[0], pair[1]);
        let s = (z - z0) / (z1 - z0);
        s > 0.0 && s < 1.0 && min0 + (min1 - min0) * s < radius && radius < max0 + (max1 - max0) * s
    })
}

/// The distance of a point from the axis along the middle of its flat side, and half the angle of a side in radians.
fn flat(p: &Params, at: Vec3) -> (f64, f64) {
    let side = number(p, "dphi") / number(p, "sides");
    let from_middle = (turn(p, at) / side).fract() * side - 0.5 * side;
    (at.x.hypot(at.y) * from_middle.to_radians().cos(), (0.5 * side).to_radians())
}

fn mixed([a, b]: [f64; 2], [c, d]: [f64; 2], s: f64) -> [f64; 2] {
    [a + (c - a) * s, b + (d - b) * s]
}

const INTERIORS: &[(&str, Interior)] = &[
    ("revolved", |p, at| in_polygon(&rows(p, "points"), [at.x.hypot(at.y), at.z]) && sector(p, at)),
    ("polycone", |p, at| in_planes(&rows(p, "planes"), at.x.hypot(at.y), at.z) && sector(p, at)),
    ("polyhedra", |p, at| in_planes(&rows(p, "planes"), flat(p, at).0, at.z) && sector(p, at)),
    ("generic_polyhedra", |p, at| {
        let (distance, half) = flat(p, at);
        in_polygon(&rows(p, "points"), [distance / half.cos(), at.z]) && sector(p, at)
    }),
    ("extruded", |p, at| {
        let polygon = rows(p, "polygon");
        rows::<4>(p, "sections").windows(2).any(|pair| {
            let ([z0, x0, y0, k0], [z1, x1, y1, k1]) = (pair[0], pair[1]);
            let s = (at.z - z0) / (z1 - z0);
            let ([x, y], k) = (mixed([x0, y0], [x1, y1], s), k0 + (k1 - k0) * s);
            s > 0.0 && s < 1.0 && in_polygon(&polygon, [(at.x - x) / k, (at.y - y) / k])
        })
    }),
    ("tetrahedron", |p, at| {
        let c: Vec<Vec3> = rows::<3>(p, "corners").into_iter().map(Vec3::from).collect();
        let volume = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| (b - a).cross(c - a).dot(d - a);
        let all = volume(c[0], c[1], c[2], c[3]);
        let parts = [
            volume(at, c[1], c[2], c[3]),
            volume(c[0], at, c[2], c[3]),
            volume(c[0], c[1], at, c[3]),
            volume(c[0], c[1], c[2], at),
        ];
        parts.iter().all(|part| part * all > 0.0)
    }),
    ("trapezoid", |p, at| {
        let z = number(p, "z");
        let pairs = rows(p, "lower").into_iter().zip(rows(p, "upper"));
        let section: Vec<_> = pairs.map(|(l, u)| mixed(l, u, (at.z + z) / (2.0 * z))).collect();
        at.z.abs() < z && in_polygon(&section, [at.x, at.y])
    }),
    ("twisted_trapezoid", |p, at| {
        let (z, shift) = (number(p, "z"), [number(p, "shift_x"), number(p, "shift_y")]);
        let s = at.z / (2.0 * z);
        let pairs = rows(p, "lower").into_iter().zip(rows(p, "upper"));
        let section: Vec<_> = pairs.map(|(l, u)| mixed(l, u, s + 0.5)).collect();
        let turned = (number(p, "twist") * s).to_radians();
        let (x, y) = (at.x - s * shift[0], at.y - s * shift[1]);
        let back = [x * turned.cos() + y * turned.sin(), y * turned.cos() - x * turned.sin()];
        at.z.abs() < z && in_polygon(&section, back)
    }),
    ("twisted_tube", |p, at| {
        let (z0, z1) = (number(p, "z0"), number(p, "z1"));
        let k = (0.5 * number(p, "twist")).to_radians().tan() / z0.abs().max(z1.abs());
        let straight = at.x.hypot(at.y) / 1f64.hypot(k * at.z);
        let turned = (k * at.z).atan();
        let back = Vec3::new(
            at.x * turned.cos() + at.y * turned.sin(),
            at.y * turned.cos() - at.x * turned.sin(),
            at.z,
        );
        let between = number(p, "rmin") < straight && straight < number(p, "rmax");
        between && z0 < at.z && at.z < z1 && sector(p, back)
    }),
];

#[test]
fn interiors_are_those_of_the_formulas() {
    let mut random = Random::new(302);
    for (name, interior) in INTERIORS {
        let kind = kind(name).expect("a kind");
        for example in kind.examples {
            let params = Params::of(kind, example);
            let (parts, mut inside) = (kind.build(&params).expect("an example"), 0);
            let bounds = parts.bounds();
            let (low, high) = (bounds.min - 0.1 * bounds.size(), bounds.max + 0.1 * bounds.size());
            for _ in 0..20_000 {
                let p = low + (high - low) * random.point(0.0, 1.0);
                let expected = interior(&params, p);
                inside += usize::from(expected);
                assert_eq!(parts.contains(p), expected, "{name} {example:?} at {p}");
                assert!(!expected || bounds.contains(p), "{name} {example:?}: {p} {bounds:?}");
            }
            assert!(inside > 200, "{name} {example:?}: {inside}");
        }
    }
}

fn error(kind: &Kind, values: &[&[f64]]) -> String {
    kind.build(&Params::of(kind, values)).expect_err("an error").to_string()
}

#[test]
fn wrong_rows_are_named() {
    let square = [-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0];
    let turned = [1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0];
    for (name, values, expected) in [
        ("revolved", &[&[0.0, 0.0, 1.0][..]][..], "points: has 3 numbers, but takes rows of 2 [r, z]"),
        ("revolved", &[&[0.0, 0.0, 1.0, 0.0]], "points: has 2 rows, but takes at least 3 rows [r, z]"),
        (
            "revolved",
            &[&[0.0, 0.0, 1.0, f64::NAN, 1.0, 1.0]],
            "points: row 2 of 3 is [1.0, NaN], but its numbers must be finite",
        ),
        ("revolved", &[&[0.0, 0.0, 1.0, 0.0, -1.0, 1.0]], "points: row 3 of 3 is [-1.0, 1.0], but r,"),
        (
            "revolved",
            &[&[0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0]],
            "points: cross: the edge from row 1 to row 2 crosses that from row 3 to row 4",
        ),
        ("revolved", &[&[0.0, 0.0, 1.0, 1.0, 2.0, 2.0]], "points: lie on one line"),
        (
            "polycone",
            &[&[0.0, 1.0, 2.0, 1.0, 3.0, 2.0]],
            "planes: row 2 of 2 is [1.0, 3.0, 2.0], but rmax must be at least rmin",
        ),
        (
            "polycone",
            &[&[0.0, 0.0, 2.0, 1.0, 0.0, 2.0, 0.5, 0.0, 1.0]],
            "planes: row 3 of 3 is [0.5, 0.0, 1.0], and z was 1 before it, but z must ascend or descend",
        ),
        ("polycone", &[&[0.0, 1.0, 1.0, 1.0, 2.0, 2.0]], "planes: enclose nothing"),
        ("polyhedra", &[&[0.0, 0.0, 1.0, 1.0, 0.0, 1.0], &[2.0]], "sides: is 2, but must be at least 3"),
        ("polyhedra", &[&[0.0, 0.0, 1.0, 1.0, 0.0, 1.0], &[2.5]], "sides: is 2.5, but must be a whole"),
        (
            "extruded",
            &[&square, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]],
            "sections: row 2 of 2 is [0.0, 0.0, 0.0, 1.0], but its z must be above",
        ),
        (
            "extruded",
            &[&square, &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0]],
            "sections: row 2 of 3 is [1.0, 0.0, 0.0, 0.0], but its scale must be positive",
        ),
        ("tetrahedron", &[&[0.0; 12]], "corners: lie in one plane"),
        ("tetrahedron", &[&[0.0; 15]], "corners: has 5 rows, but takes four"),
        (
            "trapezoid",
            &[&[1.0], &square, &[1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0]],
            "upper: runs round the other way",
        ),
        (
            "trapezoid",
            &[&[1.0], &square, &[-1.0, -1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0]],
            "upper: cross: give the corners in their order",
        ),
        ("trapezoid", &[&[1.0], &[1.0; 8], &[2.0; 8]], "upper: encloses nothing"),
        ("trapezoid", &[&[1.0], &[-1.0, -1.0, 1.0, -1.0, 0.0, -0.5, -1.0, 1.0], &turned], "upper: "),
        (
            "trapezoid",
            &[
                &[1.0],
                &[-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0],
                &[-1.0, -1.0, 1.0, -1.0, -0.5, -0.7, -1.0, 1.0],
            ],
            "upper: makes twisted sides together with lower, and then each cross-section must be convex",
        ),
        ("twisted_tube", &[&[0.0], &[1.0], &[0.0], &[1.0], &[180.0]], "twist: is 180, but must be between"),
        (
            "twisted_trapezoid",
            &[&[1.0], &square, &[-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 0.5], &[30.0]],
            "upper: has an edge that is not parallel to that of lower",
        ),
        ("twisted_trapezoid", &[&[1.0], &square, &square, &[361.0]], "twist: is 361, but must be from"),
    ] {
        let found = error(kind(name).expect("a kind"), values);
        assert!(found.starts_with(expected), "{name}: {found}");
    }
}
