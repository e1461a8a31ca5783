//! Lists of the torus, certified by the distance function.
//!
//! For each crossing, the torus function in double-double has different signs one ulp before it and one ulp after
//! it. To exclude other crossings, the line is marched from one crossing to the next in steps that cannot cross
//! the surface: the distance changes no faster than the point moves (Hart 1996, "Sphere tracing"), and its slope
//! no faster than its curvature allows. Where the march gets stuck near a tangent, exact arithmetic decides.

use shotline::crossing::{Crossing, is_alternating};
use shotline::math::{Dd, Vec3, two_prod};
use shotline::ray::Line;
use shotline::solid::{Solid, torus::Torus};
use shotline::testkit::random::Random;

use super::Tally;
use super::exact::Section;

/// Below this, in sizes of the torus, a distance in f64 is meaningless.
const BLUR: f64 = 1e-14;

/// Tests the given number of rays.
pub fn run(random: &mut Random, rays: u64, tally: &mut Tally) {
    let mut list = Vec::new();
    for _ in 0..rays {
        let (major, minor) = radii(random);
        let torus = Torus::new(major, minor).expect("good radii");
        let (o, d) = ray(random, major, minor);
        list.clear();
        torus.crossings(&Line::exact(o, d), &mut list);
        tally.rays += 1;
        tally.crossings += list.len() as u64;
        let case = Case { major, minor, o, d };
        match case.certify(&list) {
            Verdict::Right => {}
            Verdict::Unsure => {
                tally.exact += 1;
                if let Err(why) = case.compare(&list) {
                    tally.fail(format!("{case:?}: {why}: {list:?}"));
                }
            }
            Verdict::Wrong(why) => tally.fail(format!("{case:?}: {why}: {list:?}")),
        }
    }
}

/// A number whose logarithm is uniformly distributed.
fn scale(random: &mut Random, low: f64, high: f64) -> f64 {
    random.number(low.ln(), high.ln()).exp()
}

/// Thin, fat, horn and spindle tori of all sizes.
fn radii(random: &mut Random) -> (f64, f64) {
    let major = if random.below(2) == 0 { 1.0 } else { scale(random, 1e-3, 1e3) };
    let share = match random.below(6) {
        0 => 1.0,
        1 => scale(random, 1.0, 10.0),
        2 => scale(random, 1e-4, 1e-2),
        _ => scale(random, 1e-2, 1.0),
    };
    (major, major * share)
}

/// A ray near the torus: at a random point, at a point of the surface, nearly tangent, in a plane of symmetry or
/// parallel to the axis, from near and far.
fn ray(random: &mut Random, major: f64, minor: f64) -> (Vec3, Vec3) {
    let size = major + minor;
    let (ring, tube) = (random.number(0.0, 6.3), random.number(0.0, 6.3));
    let outward = Vec3::new(ring.cos() * tube.cos(), ring.sin() * tube.cos(), tube.sin());
    let surface = Vec3::new(ring.cos(), ring.sin(), 0.0) * major + outward * minor;
    let mut d = random.direction();
    let target = match random.below(6) {
        0 | 1 => random.point(-1.0, 1.0) * size,
        2 => surface,
        // Nearly tangent: parallel to the surface, slightly above or below it.
        3 => {
            d = (d - outward * d.dot(outward)).normalize();
            surface
                + outward
                    * (minor * scale(random, 1e-9, 1e-1) * if random.below(2) == 0 { 1.0 } else { -1.0 })
        }
        4 => {
            let axis = random.below(3);
            d[axis] = 0.0;
            let mut p = random.point(-1.0, 1.0) * size;
            p[axis] = 0.0;
            p
        }
        _ => {
            d = Vec3::new(0.0, 0.0, 1.0);
            surface
        }
    };
    let far = if random.below(3) == 0 { scale(random, 1.0, 1e6) } else { random.number(0.0, 4.0) };
    let length = if random.below(3) == 0 { scale(random, 1e-6, 1e6) } else { 1.0 };
    (target - d * (far * size), d * (length * size))
}

#[derive(Debug)]
struct Case {
    major: f64,
    minor: f64,
    o: Vec3,
    d: Vec3,
}

/// For a far origin, the gap beside the pinch of a horn torus may be narrower than an ulp of `t`.
#[test]
fn two_crossings_may_share_an_ulp() {
    let o = Vec3::new(285587.40977421636, 43495.19513243396, 39509.17313389525);
    let d = Vec3::new(-1.958963954695009, -0.29835180596451044, -0.2710100073491851);
    let mut list = Vec::new();
    Torus::new(1.0, 1.0).expect("good radii").crossings(&Line::exact(o, d), &mut list);
    let case = Case { major: 1.0, minor: 1.0, o, d };
    assert_eq!(list.len(), 4);
    assert!(matches!(case.certify(&list), Verdict::Unsure));
    case.compare(&list).expect("as exact arithmetic has it");
}

enum Verdict {
    Right,
    Unsure,
    Wrong(String),
}

/// The signed distance from the surface at a point of the line (negative inside), its slope, a bound on how fast
/// the slope changes, and the distance up to which that bound holds.
struct Distance {
    value: f64,
    slope: f64,
    bend: f64,
    around: f64,
}

impl Case {
    fn certify(&self, list: &[Crossing]) -> Verdict {
        if !is_alternating(list) {
            return Verdict::Wrong("does not alternate".into());
        }
        for c in list {
            match (self.inside(c.t.next_down()), self.inside(c.t.next_up())) {
                (Some(before), Some(after)) if before != after && after == c.entering => {}
                // Also undecided if two crossings share an ulp.
                (None, _) | (_, None) => return Verdict::Unsure,
                (Some(before), Some(after)) if before == after => return Verdict::Unsure,
                _ => return Verdict::Wrong(format!("no crossing within an ulp of {}", c.t)),
            }
        }
        self.certify_nothing_else(list)
    }

    /// Whether a point is inside the torus. `None` if double-double arithmetic cannot decide.
    fn inside(&self, t: f64) -> Option<bool> {
        let [x, y, z] = std::array::from_fn(|i| two_prod(t, self.d[i]) + Dd::from(self.o[i]));
        let e = (x * x + y * y).sqrt() - Dd::from(self.major);
        let f = e * e + z * z - two_prod(self.minor, self.minor);
        let reach = self.o.abs().max_element() + (self.d * t).abs().max_element();
        let doubt = 1e-29 * reach * (e.hi.abs() + z.hi.abs() + self.minor + 1e-29 * reach);
        (f.hi.abs() > doubt).then_some(f.hi < 0.0)
    }

    fn certify_nothing_else(&self, list: &[Crossing]) -> Verdict {
        let size = self.major + self.minor;
        let middle = -self.o.dot(self.d) / self.d.length_squared();
        let p: [Dd; 3] = std::array::from_fn(|i| two_prod(middle, self.d[i]) + Dd::from(self.o[i]));
        let p = Vec3::new(p[0].hi, p[1].hi, p[2].hi);
        let speed = self.d.length();
        let off = p - self.d * (p.dot(self.d) / (speed * speed));
        let half = (1.01 * size * size - off.length_squared()).sqrt() / speed;
        if half.is_nan() {
            return if list.is_empty() {
                Verdict::Right
            } else {
                Verdict::Wrong("outside of the ball".into())
            };
        }
        let march = March { case: self, p, speed, blur: BLUR * size };
        let mut from = -half;
        for c in list {
            let tau = c.t - middle;
            // Around the crossing the slope keeps its sign, so there is no other crossing.
            let at = march.distance(tau);
            let way = (0.5 * at.slope.abs() / at.bend).min(at.around);
            let rounding = 4.0 * f64::EPSILON * (c.t.abs() + middle.abs());
            if rounding > 0.25 * way || !march.arrives(from, tau - way, !c.entering) {
                return Verdict::Unsure;
            }
            from = tau + way;
        }
        if march.arrives(from, half, false) { Verdict::Right } else { Verdict::Unsure }
    }

    /// Compares a list with exact arithmetic.
    fn compare(&self, list: &[Crossing]) -> Result<(), String> {
        let section = Section::new(self.major, self.minor, self.o, self.d);
        let middle = -self.o.dot(self.d) / self.d.length_squared();
        let half = 2.0 * (self.major + self.minor) / self.d.length();
        let changes = section.changes(middle - half, middle + half);
        if changes != list.len() {
            return Err(format!("{} crossings, exactly there are {changes}", list.len()));
        }
        for c in list {
            if section.changes(c.t.next_down(), c.t.next_up()) == 0 {
                return Err(format!("no crossing within an ulp of {}", c.t));
            }
        }
        Ok(())
    }
}

struct March<'a> {
    case: &'a Case,
    /// The point at `tau = 0`, near the closest approach.
    p: Vec3,
    speed: f64,
    blur: f64,
}

impl March<'_> {
    fn distance(&self, tau: f64) -> Distance {
        let (q, d) = (self.p + self.case.d * tau, self.case.d);
        let rho = (q.x * q.x + q.y * q.y).sqrt();
        let e = rho - self.case.major;
        let from_circle = (e * e + q.z * q.z).sqrt();
        let slope = (e * (q.x * d.x + q.y * d.y) / rho + q.z * d.z) / from_circle;
        // Up to half the distance to the circle and to the axis, the curvature at most doubles.
        let bend = self.speed * self.speed * 2.0 * (1.0 / from_circle + 1.0 / rho);
        let around = 0.5 * from_circle.min(rho) / self.speed;
        Distance { value: from_circle - self.case.minor, slope, bend, around }
    }

    /// Whether the line certainly stays on the given side of the surface between two `tau`.
    fn arrives(&self, from: f64, to: f64, inside: bool) -> bool {
        let mut tau = from;
        for _ in 0..400 {
            if tau >= to {
                return true;
            }
            let Distance { value, slope, bend, around } = self.distance(tau);
            let (value, slope) = if inside { (-value, -slope) } else { (value, slope) };
            let clear = value - self.blur;
            if clear.is_nan() || clear <= 0.0 {
                return false;
            }
            // At a further step h the distance is at least clear + slope h - bend h^2 / 2.
            let curved = (slope + (slope * slope + 2.0 * bend * clear).sqrt()) / bend;
            tau += (clear / self.speed).max(0.999 * curved.min(around));
        }
        false
    }
}
