//! The quick path has the same bits in lanes and alone, and what it calls certain is true.

use std::cmp::Ordering;
use std::f64::consts::TAU;

use num_rational::BigRational;

use super::{Torus, search};
use crate::crossing::{Crossing, are_coincident, is_alternating};
use crate::lanes::LineLanes;
use crate::math::{Real, Vec3};
use crate::ray::Line;
use crate::simd::{Doubles, Portable, Simd, Task, dispatch};
use crate::solid::Solid;
use crate::solid::ring::{self, Rings};
use crate::testkit::random::Random;

/// The crossings of eight lines; `None` for those that are left open.
struct Cast<'a>(&'a Torus, &'a [Line; 8]);

impl Task for Cast<'_> {
    type Output = Vec<Option<Vec<Crossing>>>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<Option<Vec<Crossing>>> {
        let mut found = Vec::new();
        for first in (0..8).step_by(S::Wide::LANES) {
            let lines = LineLanes::<S::Wide>::from_fn(|lane| self.1[first + lane]);
            let inside = ring::inside(&Rings::of(self.0.major, self.0.minor), &lines, S::Wide::ALL);
            found.extend((0..S::Wide::LANES).map(|lane| {
                let is_met = |lanes: u8| lanes >> lane & 1 == 1;
                let mut list = Vec::new();
                for interval in inside.intervals.iter().filter(|interval| is_met(interval.lanes)) {
                    for (end, entering) in [(&interval.enter, true), (&interval.exit, false)] {
                        list.push(Crossing::new(end.t.store()[lane], end.t_err.store()[lane], entering, 0));
                    }
                }
                (!is_met(inside.open)).then_some(list)
            }));
        }
        found
    }
}

fn bits(list: &[Crossing]) -> Vec<[u64; 2]> {
    list.iter().map(|c| [(c.t + 0.0).to_bits(), c.t_err.to_bits()]).collect()
}

/// A point of the surface, and the normal there.
fn surface_point(random: &mut Random, [major, minor]: [f64; 2]) -> (Vec3, Vec3) {
    let mut angle =
        || [random.number(0.0, TAU), 0.0, TAU / 4.0, TAU / 2.0][random.below(6).saturating_sub(2)];
    let (around, across) = (angle(), angle());
    let out = Vec3::new(around.cos(), around.sin(), 0.0);
    let normal = out * across.cos() + Vec3::Z * across.sin();
    (out * major + normal * minor, normal)
}

/// A line that may graze the torus, run along its axis or its symmetry planes, or pass through the hole.
fn hard_line(random: &mut Random, radii: [f64; 2]) -> Line {
    let [major, minor] = radii;
    let tiny = [0.0, 1e-15, -1e-15, 1e-9, 1e-4, -1e-4];
    let (mut p, mut d) = (random.point(-1.0, 1.0) * (major + minor), random.direction());
    match random.below(6) {
        0 => {
            let (point, normal) = surface_point(random, radii);
            p = point + normal * (minor * tiny[random.below(6)]);
            d = normal.cross(d);
        }
        1 => (p, d) = (p * tiny[random.below(6)], Vec3::Z + d * tiny[random.below(6)]),
        2 => {
            (p.z, d.z) = (minor * [0.0, 1.0, 0.5, 1.0 - 1e-15][random.below(4)], 0.0);
        }
        3 => p *= (1.0 - minor / major) * 0.7,
        _ => {}
    }
    if d.length() < 0.1 {
        d = Vec3::X;
    }
    let away = [0.0, 3.0, 3.0, 1e3, 1e6, 1e9, 1e12][random.below(7)] * major;
    let mut line = Line::exact(p - d * away, d * [1.0, 1e-3, 7.3, 1e150, 1e-150][random.below(5)]);
    if random.below(2) == 0 {
        let share = [1e-17, 1e-15, 1e-13, 1e-6][random.below(4)];
        (line.o_err, line.d_err) = (line.o.abs() * share, line.d.abs() * share);
    }
    line
}

#[test]
fn hard_lines_have_the_same_bits_in_lanes_and_alone_and_the_crossings_of_the_search() {
    let mut random = Random::new(77);
    let (mut certain, mut hits, mut all) = (0, 0, 0);
    for minor in [0.35, 1e-4, 2e-5, 0.01, 0.1, 0.9, 0.999, 1.0 - 1e-6] {
        for size in [1.0, 0.07, 3e5, 1e-80, 1e80] {
            let radii = [size, minor * size];
            let torus = Torus::new(radii[0], radii[1]).expect("a torus");
            assert!(torus.is_quick);
            for _ in 0..600 {
                let lines: [Line; 8] = [0; 8].map(|_| hard_line(&mut random, radii));
                let in_lanes = dispatch(Cast(&torus, &lines));
                let plain = Cast(&torus, &lines).run::<Portable>();
                for ((line, found), plain) in lines.iter().zip(in_lanes).zip(plain) {
                    let mut alone = Vec::new();
                    let is_certain = ring::crossings(radii[0], radii[1], line, &mut alone);
                    let alone = is_certain.then_some(alone);
                    assert_eq!(found.as_deref().map(bits), alone.as_deref().map(bits), "{torus:?} {line:?}");
                    assert_eq!(plain.as_deref().map(bits), alone.as_deref().map(bits), "{torus:?} {line:?}");
                    all += 1;
                    if let Some(found) = found {
                        certain += 1;
                        hits += usize::from(!found.is_empty());
                        agrees_with_the_search(&torus, line, &found);
                    }
                }
            }
        }
    }
    assert!(certain > all / 2 && hits > all / 5, "{certain} {hits} {all}");
}

fn agrees_with_the_search(torus: &Torus, line: &Line, found: &[Crossing]) {
    let mut searched = Vec::new();
    search::crossings(torus.major, torus.minor, line, &mut searched);
    let agrees = |(a, b): (&Crossing, &Crossing)| (a.t - b.t).abs() <= a.t_err + b.t_err;
    assert!(is_alternating(found) && found.windows(2).all(|w| !are_coincident(&w[0], &w[1])));
    assert!(
        found.len() == searched.len() && found.iter().zip(&searched).all(agrees),
        "{torus:?} {line:?} {found:?} {searched:?}"
    );
}

/// The sign of the quartic at `t`, in exact arithmetic.
fn exact_sign(torus: &Torus, line: &Line, t: f64) -> Ordering {
    // All numbers are multiples of 2^-200.
    let units = BigRational::from_float(2f64.powi(200)).expect("a number").to_integer();
    let fixed = |x: f64| {
        let ratio = BigRational::from_float(x).expect("a number");
        ratio.numer() * &units / ratio.denom()
    };
    let (one, t) = (fixed(1.0), fixed(t));
    let at = |axis: usize| fixed(line.o[axis]) * &one + &t * fixed(line.d[axis]);
    let (x, y, z) = (at(0), at(1), at(2));
    let (major, minor) = (fixed(torus.major) * &one, fixed(torus.minor) * &one);
    let (rho2, major2) = (&x * &x + &y * &y, &major * &major);
    let sum = &rho2 + &z * &z + &major2 - &minor * &minor;
    (&sum * &sum).cmp(&(major2 * rho2 * 4))
}

/// Each crossing is within its bound, and between and beside them the line is inside as the list says.
#[test]
fn certain_lists_are_true_in_exact_arithmetic() {
    let mut random = Random::new(5);
    let mut crossings = 0;
    for minor in [0.35, 1e-3, 0.05, 0.8, 0.98] {
        for case in 0..4_000 {
            let torus = Torus::new(1.0, minor).expect("a torus");
            let d = random.direction() * [1.0, 0.3][case % 2];
            let p = random.point(-1.0, 1.0) * (1.0 + minor);
            let line = Line::exact(p - d * [0.0, 3.0, 100.0, 1e5][case / 2 % 4], d);
            let mut list = Vec::new();
            if !ring::crossings(1.0, minor, &line, &mut list) {
                continue;
            }
            for c in &list {
                let (before, after) = (c.t - c.t_err, c.t + c.t_err);
                let (outside, inside) = if c.entering { (before, after) } else { (after, before) };
                let signs = [outside, inside].map(|t| exact_sign(&torus, &line, t));
                assert_eq!(signs, [Ordering::Greater, Ordering::Less], "{torus:?} {line:?} {c:?}");
                assert!(c.t_err <= 4.0 * (c.t.abs().next_up() - c.t.abs()) + 1e-17, "{line:?} {c:?}");
                crossings += 1;
            }
        }
    }
    assert!(crossings > 8_000, "{crossings}");
}

/// Nothing overflows in a torus that the quick path takes.
#[test]
fn tori_that_are_too_thin_too_fat_or_of_extreme_sizes_are_left_to_the_search() {
    for radii in [[1.0, 1.0], [1.0, 1.5], [1.0, 1e-6], [1e150, 1e149], [1e-150, 1e-151]] {
        let torus = Torus::new(radii[0], radii[1]).expect("a torus");
        assert!(torus.in_lanes().is_none(), "{torus:?}");
    }
}

struct Normals<'a>(&'a Torus, &'a [[f64; 8]; 3]);

impl Task for Normals<'_> {
    type Output = [[f64; 8]; 3];

    #[inline(always)]
    fn run<S: Simd>(self) -> [[f64; 8]; 3] {
        let mut out = [[0.0; 8]; 3];
        for first in (0..8).step_by(S::Wide::LANES) {
            let load = |axis: usize| S::Wide::load_some(&self.1[axis], first);
            let normals = ring::normals(<S::Wide as Real>::splat(self.0.major), [load(0), load(1), load(2)]);
            (0..3).for_each(|axis| normals[axis].store_some(&mut out[axis], first));
        }
        out
    }
}

#[test]
fn normals_in_lanes_have_the_bits_of_each_alone() {
    let mut random = Random::new(9);
    let torus = Torus::new(1.0, 0.4).expect("a torus");
    let numbers = [0.0, -0.0, 1e-200, 1e200, 1.0, -1.4];
    for _ in 0..2_000 {
        let mut number =
            |_| if random.below(3) == 0 { numbers[random.below(6)] } else { random.number(-1.5, 1.5) };
        let p: [[f64; 8]; 3] = [0; 3].map(|_| [0; 8].map(&mut number));
        let found = dispatch(Normals(&torus, &p));
        for lane in 0..8 {
            let normal = torus.normal(Vec3::new(p[0][lane], p[1][lane], p[2][lane]), 0, 0);
            let bits = [0, 1, 2].map(|axis: usize| found[axis][lane].to_bits());
            assert_eq!(bits, normal.to_array().map(f64::to_bits), "{p:?} {lane}");
        }
    }
}
