//! Rays that are difficult: aimed at vertices and edges, along faces, from the surface, from far away, with extreme
//! directions.

use shotline::math::Vec3;
use shotline::ray::{Ray, Span};
use shotline::testkit::random::Random;

/// The triangles at which rays are aimed, in world coordinates.
pub struct Targets {
    pub triangles: Vec<[Vec3; 3]>,
    pub centre: Vec3,
    pub size: f64,
    low: Vec3,
    high: Vec3,
}

impl Targets {
    pub fn of(triangles: Vec<[Vec3; 3]>) -> Targets {
        let corners = || triangles.iter().flatten();
        let low = corners().fold(Vec3::INFINITY, |low, v| low.min(*v));
        let high = corners().fold(-Vec3::INFINITY, |high, v| high.max(*v));
        let size = (high - low).max_element().max(f64::MIN_POSITIVE);
        Targets { centre: low * 0.5 + high * 0.5, size, low, high, triangles }
    }

    fn triangle(&self, random: &mut Random) -> [Vec3; 3] {
        let [a, b, c] = self.triangles[random.below(self.triangles.len())];
        [[a, b, c], [b, c, a], [c, a, b]][random.below(3)]
    }

    /// A point of the surface: a vertex, the middle of an edge, a point of an edge or of a face.
    fn point(&self, random: &mut Random) -> Vec3 {
        let [a, b, c] = self.triangle(random);
        let (v, w) = (random.number(0.0, 0.5), random.number(0.0, 0.5));
        let p = match random.below(6) {
            0 => a,
            1 => a * 0.5 + b * 0.5,
            2 => a + (b - a) * v,
            3 => a * 0.5 + b * 0.25 + c * 0.25,
            _ => a + (b - a) * v + (c - a) * w,
        };
        if random.below(4) == 0 { nudged(p, random) } else { p }
    }

    fn origin(&self, random: &mut Random) -> Vec3 {
        let away = |by: f64, random: &mut Random| self.centre + random.direction() * (by * self.size);
        match random.below(16) {
            0 => self.point(random),
            1 => {
                self.point(random) + random.direction() * (self.size * 10f64.powf(random.number(-17.0, -1.0)))
            }
            2 => self.centre,
            3 => away(0.2, random),
            4 => away(1e3, random),
            5 => away(10f64.powf(random.number(1.0, 13.0)), random),
            6 => {
                let far = random.direction() * 1e200;
                if self.size > 1e100 { away(1e3, random) } else { far }
            }
            7 => Vec3::ZERO,
            8 => self.centre + Vec3::AXES[random.below(3)] * (2.0 * self.size),
            _ => away(random.number(0.5, 4.0), random),
        }
    }

    /// Any ray of the hard kinds.
    pub fn ray(&self, random: &mut Random) -> Ray {
        loop {
            let (o, d) = self.line(random);
            let d = with_small_components(d, random);
            if let Ok(ray) = Ray::new(o, d) {
                return ray;
            }
        }
    }

    fn line(&self, random: &mut Random) -> (Vec3, Vec3) {
        let o = self.origin(random);
        match random.below(12) {
            0 => {
                let (p, axis) = (self.point(random), Vec3::AXES[random.below(3)]);
                let sign = [1.0, -1.0][random.below(2)];
                (p - axis * (sign * self.size * [0.0, 1.0, 3.0, 1e3][random.below(4)]), axis * sign)
            }
            1 => {
                // In the plane of a face, up to rounding.
                let [a, b, c] = self.triangle(random);
                let d = (b - a) * random.number(-1.0, 1.0) + (c - a) * random.number(-1.0, 1.0);
                (a + (b - a) * random.number(-1.0, 2.0) - d * random.number(0.0, 3.0), d)
            }
            2 => {
                // Along an edge.
                let [a, b, _] = self.triangle(random);
                (a - (b - a) * [0.0, 0.5, 1.0, 2.0][random.below(4)], b - a)
            }
            3 => (o, random.direction() * self.size),
            4 | 5 => {
                let factor = 10f64.powf(random.number(-300.0, 300.0));
                let d = (self.point(random) - o) / self.size;
                (o, d * factor)
            }
            6 => (o, (self.point(random) - o) * random.number(-2.0, 2.0)),
            // Hits at t = 1, up to rounding.
            _ => (o, self.point(random) - o),
        }
    }

    /// A point in the box: anywhere, on a regular grid, or on or near the surface.
    fn point_within(&self, random: &mut Random) -> Vec3 {
        let near =
            |random: &mut Random| random.direction() * (self.size * 10f64.powf(random.number(-18.0, -1.0)));
        match random.below(8) {
            0..3 => {
                let share = [(); 3].map(|()| random.number(0.0, 1.0));
                self.low + (self.high - self.low) * Vec3::from(share)
            }
            3 => {
                let half_cells = [(); 3].map(|()| random.below(34) as f64);
                let p = (self.low + Vec3::from(half_cells) * (self.size / 32.0)).min(self.high);
                if random.below(2) == 0 { p } else { nudged(p, random) }
            }
            4 => self.point(random),
            _ => self.point(random) + near(random),
        }
    }

    /// Rays that begin in the box, some of them at the same point.
    pub fn rays_from_within(&self, random: &mut Random, n: usize) -> Vec<Ray> {
        let mut o = self.point_within(random);
        let mut ray = |_| loop {
            if random.below(3) > 0 {
                o = self.point_within(random);
            }
            let d = match random.below(8) {
                0 => Vec3::AXES[random.below(3)] * [self.size, -self.size][random.below(2)],
                1 => {
                    let [a, b, _] = self.triangle(random);
                    b - a
                }
                2..5 => self.point(random) - o,
                _ => random.direction() * self.size,
            };
            if let Ok(ray) = Ray::new(o, with_small_components(d, random)) {
                return ray;
            }
        };
        (0..n).map(&mut ray).collect()
    }

    /// Rays from one point over a window, or parallel ones, in scan order.
    pub fn coherent(&self, random: &mut Random, n: usize) -> Vec<Ray> {
        let away = random.direction();
        let eye = self.centre + away * (self.size * random.number(0.3, 5.0));
        let (u, v) = (away.cross(random.direction()), away.cross(Vec3::AXES[random.below(3)]));
        let (width, is_parallel) = ((n as f64).sqrt().ceil() as usize, random.below(2) == 0);
        let extent = self.size * [1.2, 0.5, 0.01][random.below(3)];
        let ray = |i: usize| {
            let place = |k: usize| k as f64 / width as f64 - 0.5;
            let across = (u * place(i % width) + v * place(i / width)) * extent;
            let (o, d) = if is_parallel { (eye + across, -away) } else { (eye, self.centre + across - eye) };
            Ray::new(o, d).unwrap_or_else(|_| Ray::new(o, Vec3::X).expect("a ray"))
        };
        (0..n).map(ray).collect()
    }

    pub fn rays(&self, random: &mut Random, n: usize) -> Vec<Ray> {
        (0..n).map(|_| self.ray(random)).collect()
    }
}

/// A point some ulps away along each axis.
fn nudged(p: Vec3, random: &mut Random) -> Vec3 {
    Vec3::from(p.to_array().map(|mut x| {
        for _ in 0..random.below(3) {
            x = if random.below(2) == 0 { x.next_up() } else { x.next_down() };
        }
        x
    }))
}

/// Sometimes replaces components of a direction by zeros, denormals and other small numbers.
fn with_small_components(d: Vec3, random: &mut Random) -> Vec3 {
    if random.below(5) > 0 {
        return d;
    }
    let longest = d.abs().max_element();
    let small = |x: f64, random: &mut Random| match random.below(9) {
        0 => 0.0,
        1 => -0.0,
        2 => f64::from_bits(1),
        3 => -1e-310,
        4 => longest * 1e-18,
        5 => longest * -10f64.powf(random.number(-120.0, -10.0)),
        _ => x,
    };
    Vec3::from(d.to_array().map(|x| small(x, random)))
}

pub fn shuffle<T>(items: &mut [T], random: &mut Random) {
    for i in (1..items.len()).rev() {
        items.swap(i, random.below(i + 1));
    }
}

/// A span for rays that have hits at some of the given `t`.
pub fn span(random: &mut Random, hits: &[f64]) -> Span {
    let at = |random: &mut Random| {
        let found = if hits.is_empty() { 1.0 } else { hits[random.below(hits.len())] };
        [1.0, found, found, found.next_up(), found.next_down()][random.below(5)]
    };
    let (a, b) = (at(random), at(random));
    let ends = match random.below(14) {
        0 => (0.0, 1.0),
        1 => (0.0, a),
        2 => (a, f64::INFINITY),
        3 => (a, a),
        4 => (a.min(b), a.max(b)),
        5 => (-a.abs(), a.abs()),
        6 => (-f64::MAX, f64::INFINITY),
        7 => (-f64::MAX, f64::MAX),
        8 => (-1e3 * a.abs(), 2.0 * a.abs()),
        9 => (0.5, 1e3),
        10 => (0.0, 0.0),
        _ => (0.0, f64::INFINITY),
    };
    Span::new(ends.0, ends.1).unwrap_or(Span::FORWARD)
}
