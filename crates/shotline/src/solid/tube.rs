//! A sector of a circular tube around the z axis, between two radii, two heights and two angles.

use std::sync::Arc;

use super::cylinder;
use super::form::Form;
use super::interval::{Interval, Slab};
use super::sector;
use super::{Build, Kind, Moments, Param, ParamError, Params, Solid, Wanted, constructors};
use crate::aabb::Aabb;
use crate::contact::{Border, Contact, Sector, Sheet};
use crate::crossing::{Crossing, NO_PRIMITIVE};
use crate::math::{Affine, Vec3, sin_cos_degrees_wide, unit};
use crate::ray::{Line, Span};
use crate::scratch::Scratch;

pub(super) static KIND: Kind = Kind {
    name: "tube",
    summary: "the part of a tube around the z axis that lies between two angles about it",
    interior: "rmin^2 < x^2 + y^2 < rmax^2, z0 < z < z1, a sector of dphi degrees about z that begins at the angle phi0",
    params: &[
        Param::length("rmin", "the inner radius; 0 for a solid cylinder"),
        Param::length("rmax", "the outer radius, above rmin"),
        Param::length("z0", "the lower end"),
        Param::length("z1", "the upper end, above z0"),
        Param::angle("phi0", "where the part begins, in degrees from the x axis towards the y axis")
            .or(&[0.0]),
        Param::angle("dphi", "the angle that it takes, in degrees, above 0 and at most 360").or(&[360.0]),
    ],
    build: Build::Solid(|p| Ok(Arc::new(Tube::new(p)?))),
    examples: &[
        &[&[0.5], &[1.0], &[-1.0], &[1.0]],
        &[&[0.0], &[1.0], &[-0.5], &[1.5], &[20.0], &[75.0]],
        &[&[0.3], &[1.25], &[-1.0], &[0.25], &[-100.0], &[250.0]],
        &[&[0.75], &[1.0], &[0.0], &[2.0], &[90.0], &[180.0]],
        &[&[0.999], &[1.0], &[-3.0], &[3.0], &[45.0], &[0.5]],
    ],
};

constructors! {
    tube:
    /// The tube around the z axis between two radii, from z0 to z1; with an inner radius of 0 a cylinder.
    fn tube(rmin: number, rmax: number, z0: number, z1: number);
    /// The part of a tube between two angles: it begins at phi0, in degrees from the x axis towards the y axis, and takes
    /// the angle dphi, above 0 and at most 360.
    fn tube_sector(rmin: number, rmax: number, z0: number, z1: number, phi0: number, dphi: number);
}

/// The indices of the surfaces.
const OUTER: u32 = 0;
const INNER: u32 = 1;
const CAPS: u32 = 2;
const START: u32 = 4;
const END: u32 = 5;

/// Directions that differ by less than this angle, in radians, count as one.
const ONE_DIRECTION: f64 = 1e-9;

#[derive(Debug)]
struct Tube {
    outer: Form,
    inner: Option<Form>,
    caps: Slab,
    wedge: Option<Wedge>,
    bounds: Aabb,
    moments: Moments,
}

/// The intersection of the half-spaces behind two planes through the axis, or their union for more than half a
/// turn.
#[derive(Debug)]
struct Wedge {
    start: Form,
    end: Form,
    /// The directions of its two ends.
    ends: [Vec3; 2],
    is_reflex: bool,
}

impl Tube {
    fn new(p: &Params) -> Result<Tube, ParamError> {
        let rmin = p.not_negative("rmin")?;
        let (_, rmax) = p.ascending("rmin", "rmax")?;
        let (low, high) = p.ascending("z0", "z1")?;
        let wedge = sector::Sector::of(p)?.map(|sector| Wedge::new(&sector));
        let (phi0, dphi) = (p.number("phi0")? % 360.0, p.number("dphi")?);
        let mut tube = Tube {
            outer: cylinder::form(rmax),
            inner: (rmin > 0.0).then(|| cylinder::form(rmin)),
            caps: Slab { axis: 2, low, high, surface: CAPS },
            wedge,
            bounds: Aabb::new(Vec3::new(-rmax, -rmax, low), Vec3::new(rmax, rmax, high)),
            moments: moments([rmin, rmax], [low, high], phi0, dphi),
        };
        tube.cut_bounds([rmin, rmax]);
        Ok(tube)
    }

    /// Shrinks the box to the sector: its corners, and the extreme points of the outer circle along x and y.
    fn cut_bounds(&mut self, radii: [f64; 2]) {
        let Some(wedge) = &self.wedge else { return };
        let corners = wedge.ends.into_iter().flat_map(|end| radii.map(|r| end * r));
        let farthest = [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y].map(|axis| axis * radii[1]);
        let points = corners.chain(farthest.into_iter().filter(|p| wedge.contains(*p)));
        let flat = Aabb::around(points).widened(8.0);
        for i in 0..2 {
            self.bounds.min[i] = flat.min[i].max(self.bounds.min[i]);
            self.bounds.max[i] = flat.max[i].min(self.bounds.max[i]);
        }
    }

    /// Returns the intervals of a line inside. For a surface that contains the line, `side` states on which side
    /// the line is taken to be: `Some(true)` the side of the interior, `Some(false)` the other. For other
    /// surfaces it returns `None`.
    fn intervals(&self, line: &Line, side: &dyn Fn(u32) -> Option<bool>) -> Vec<Interval> {
        let behind = |form: &Form, surface: u32| match side(surface) {
            Some(is_behind) => is_behind.then_some(Interval::ALL),
            None => form.inside(line)[0].map(|interval| interval.on(surface)),
        };
        let between = match (side(CAPS), side(CAPS + 1)) {
            (None, None) => self.caps.interval(line),
            (low, high) => (low != Some(false) && high != Some(false)).then_some(Interval::ALL),
        };
        let outer = behind(&self.outer, OUTER).zip(between).and_then(|(a, b)| a.clip(b));
        let mut intervals: Vec<Interval> = outer.into_iter().collect();
        if let Some(inner) = &self.inner {
            let hole = match side(INNER) {
                Some(is_outside) => (!is_outside).then_some(Interval::ALL),
                // A line in the wall of the hole is not in the interior either.
                None => match inner.inside(line)[0] {
                    None => inner.sheet_along(line).map(|_| Interval::ALL),
                    hole => hole.map(|interval| interval.on(INNER)),
                },
            };
            intervals = without(intervals, hole);
        }
        let Some(Wedge { start, end, is_reflex, .. }) = &self.wedge else { return intervals };
        let (start, end) = (behind(start, START), behind(end, END));
        if *is_reflex {
            let gap = in_front(start).zip(in_front(end)).and_then(|(a, b)| a.clip(b));
            without(intervals, gap)
        } else {
            let both = start.zip(end).and_then(|(a, b)| a.clip(b));
            both.map_or_else(Vec::new, |both| intervals.iter().filter_map(|s| s.clip(both)).collect())
        }
    }

    /// Returns the surfaces in which a line lies.
    fn surfaces_containing(&self, line: &Line) -> Vec<(u32, Sheet)> {
        let mut surfaces_containing = Vec::new();
        if let Some((_, Some(cap))) = self.caps.closed_interval(line) {
            surfaces_containing.push((CAPS + u32::from(cap.z > 0.0), Sheet::plane(cap)));
        }
        let mut add = |form: &Form, surface: u32| {
            surfaces_containing.extend(form.sheet_along(line).map(|sheet| (surface, sheet)));
        };
        add(&self.outer, OUTER);
        if let Some(wedge) = &self.wedge {
            add(&wedge.start, START);
            add(&wedge.end, END);
        }
        let hole = self.inner.as_ref().and_then(|inner| inner.sheet_along(line));
        surfaces_containing.extend(hole.map(|sheet| (INNER, sheet.turned_over())));
        surfaces_containing
    }

    /// Returns the form of a surface and a factor that makes it negative on the interior side. `None` for the
    /// caps.
    fn form(&self, surface: u32) -> Option<(&Form, f64)> {
        let wedge = self.wedge.as_ref();
        match surface {
            OUTER => Some((&self.outer, 1.0)),
            INNER => self.inner.as_ref().map(|form| (form, -1.0)),
            START => wedge.map(|w| (&w.start, 1.0)),
            END => wedge.map(|w| (&w.end, 1.0)),
            _ => None,
        }
    }
}

impl Wedge {
    fn new(sector: &sector::Sector) -> Wedge {
        let [start, end] = sector.planes();
        Wedge { start, end, ends: sector.ends(), is_reflex: sector.is_reflex }
    }

    fn contains(&self, p: Vec3) -> bool {
        let (start, end) = (self.start.value(p) < 0.0, self.end.value(p) < 0.0);
        if self.is_reflex { start || end } else { start && end }
    }
}

/// Returns the interval of a line in front of a plane, given its interval behind the plane.
fn in_front(behind: Option<Interval>) -> Option<Interval> {
    let Some(Interval { enter, exit }) = behind else { return Some(Interval::ALL) };
    if exit.t < f64::INFINITY {
        Some(Interval::after(exit))
    } else {
        (enter.t > f64::NEG_INFINITY).then(|| Interval::before(enter))
    }
}

/// Removes an interval from a list of intervals.
fn without(intervals: Vec<Interval>, hole: Option<Interval>) -> Vec<Interval> {
    let Some(hole) = hole else { return intervals };
    let around = [Interval::before(hole.enter), Interval::after(hole.exit)];
    intervals.into_iter().flat_map(|s| around.map(|rest| s.clip(rest))).flatten().collect()
}

/// If the x axis bisects the sector, the coordinate axes are principal axes.
fn moments([rmin, rmax]: [f64; 2], [low, high]: [f64; 2], phi0: f64, dphi: f64) -> Moments {
    let (half, height) = ((0.5 * dphi).to_radians(), high - low);
    let (s, c) = sin_cos_degrees_wide(0.5 * dphi);
    let area = (rmax - rmin) * (rmax + rmin) * half;
    let middle = 2.0 / 3.0 * (rmax * rmax + rmax * rmin + rmin * rmin) / (rmax + rmin) * s.hi / half;
    let (mean, swing) = (0.25 * (rmax * rmax + rmin * rmin), s.hi * c.hi / half);
    let squares =
        Vec3::new(mean * (1.0 + swing) - middle * middle, mean * (1.0 - swing), height * height / 12.0);
    let centroid = Vec3::new(middle, 0.0, low.midpoint(high));
    Moments::along_axes(area * height, centroid, squares)
        .placed(&Affine::rotation_about(Vec3::Z, phi0 + 0.5 * dphi))
}

impl Solid for Tube {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn crossings(&self, line: &Line, out: &mut Vec<Crossing>) {
        self.intervals(line, &|_| None).into_iter().for_each(|interval| interval.push(out));
    }

    /// In the plane of one end of a sector of more than half a turn, a line may lie in the surface on one side of
    /// the axis and in the interior on the other.
    fn crossings_within(
        &self,
        line: &Line,
        _span: Span,
        _wanted: Wanted,
        out: &mut Vec<Crossing>,
        scratch: &mut Scratch,
    ) {
        let begin = out.len();
        self.crossings(line, out);
        let is_reflex = self.wedge.as_ref().is_some_and(|wedge| wedge.is_reflex);
        if is_reflex && out.len() > begin && !self.surfaces_containing(line).is_empty() {
            scratch.in_plane.push(NO_PRIMITIVE);
        }
    }

    fn contacts(&self, line: &Line, out: &mut Vec<Contact>, _scratch: &mut Scratch) {
        let surfaces_containing = self.surfaces_containing(line);
        let (x, y) = unit(line.d).any_orthonormal_pair();
        let angle = |v: Vec3| libm::atan2(v.dot(y), v.dot(x));
        let border = |(_, sheet): &(u32, Sheet), side: f64| {
            let direction = line.d.cross(sheet.normal) * side;
            (angle(unit(direction)), Border { sheet: *sheet, side })
        };
        let mut borders: Vec<(f64, Border)> =
            surfaces_containing.iter().flat_map(|sheet| [border(sheet, 1.0), border(sheet, -1.0)]).collect();
        borders.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (i, &(begin, from)) in borders.iter().enumerate() {
            let (end, to) = match borders.get(i + 1) {
                Some(next) => *next,
                None => (borders[0].0 + std::f64::consts::TAU, borders[0].1),
            };
            if end - begin < ONE_DIRECTION {
                continue;
            }
            let middle = 0.5 * (begin + end);
            let towards = x * libm::cos(middle) + y * libm::sin(middle);
            let side = |surface: u32| {
                let sheet = surfaces_containing.iter().find(|(other, _)| *other == surface);
                sheet.map(|(_, sheet)| sheet.normal.dot(towards) < 0.0)
            };
            let intervals = self.intervals(line, &side).into_iter();
            out.extend(intervals.map(|interval| interval.contact(Sector { from, to })));
        }
    }

    fn implicit(&self, p: Vec3, surface: u32, _primitive: u32) -> f64 {
        match self.form(surface) {
            Some((form, factor)) => factor * form.value(p),
            None if surface == CAPS => self.caps.low - p.z,
            None => p.z - self.caps.high,
        }
    }

    fn normal(&self, p: Vec3, surface: u32, _primitive: u32) -> Vec3 {
        match self.form(surface) {
            Some((form, factor)) => factor * form.gradient(p),
            None if surface == CAPS => Vec3::NEG_Z,
            None => Vec3::Z,
        }
    }

    fn contains(&self, p: Vec3) -> bool {
        self.caps.contains(p.z)
            && self.outer.value(p) < 0.0
            && self.inner.as_ref().is_none_or(|inner| inner.value(p) > 0.0)
            && self.wedge.as_ref().is_none_or(|wedge| wedge.contains(p))
    }

    fn surfaces(&self) -> &'static [&'static str] {
        &["outer", "inner", "bottom", "top", "start", "end"]
    }

    fn moments(&self) -> Option<Moments> {
        Some(self.moments)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::{Options, compile};
    use crate::query::Caster;
    use crate::ray::Ray;
    use crate::scene::{NodeId, Op, Scene};
    use crate::testkit::random::Random;

    type Numbers = [f64; 6];

    /// The same solid as a combination of cylinders and half-spaces.
    fn combination(scene: &mut Scene, [rmin, rmax, z0, z1, phi0, dphi]: Numbers) -> NodeId {
        let mut node = scene.add_solid("cylinder", &[&[rmax], &[z0], &[z1]]).unwrap();
        if rmin > 0.0 {
            let bore = scene.add_solid("cylinder", &[&[rmin], &[z0 - 1.0], &[z1 + 1.0]]).unwrap();
            node = scene.add_csg(Op::Difference, vec![node, bore]);
        }
        if dphi < 360.0 {
            let mut half = |phi: f64, side: f64| {
                let (s, c) = sin_cos_degrees_wide(phi);
                scene.add_solid("halfspace", &[&[side * s.hi, -side * c.hi, 0.0], &[0.0]]).unwrap()
            };
            let halves = vec![half(phi0, 1.0), half(phi0 + dphi, -1.0)];
            let wedge = scene.add_csg(if dphi > 180.0 { Op::Union } else { Op::Intersection }, halves);
            node = scene.add_csg(Op::Intersection, vec![node, wedge]);
        }
        node
    }

    fn tube(scene: &mut Scene, [rmin, rmax, z0, z1, phi0, dphi]: Numbers) -> NodeId {
        scene.add_solid("tube", &[&[rmin], &[rmax], &[z0], &[z1], &[phi0], &[dphi]]).unwrap()
    }

    /// Returns what a ray crosses of an object that also has a distant component, so that contacts count.
    fn list(make: impl FnOnce(&mut Scene) -> NodeId, ray: &Ray) -> Vec<(f64, f64)> {
        let mut scene = Scene::default();
        let far = scene.add_solid("box", &[&[90.0; 3], &[91.0; 3]]).unwrap();
        let node = make(&mut scene);
        let both = scene.add_csg(Op::Union, vec![node, far]);
        scene.add_object("it", None, both);
        let world = compile(&scene, Options::default()).unwrap();
        let mut hits = Vec::new();
        Caster::new(&world).crossings(ray, Span::FORWARD, &mut hits).unwrap();
        hits.iter().map(|hit| (hit.t, hit.t_err)).collect()
    }

    #[track_caller]
    fn assert_alike(a: &[(f64, f64)], b: &[(f64, f64)], what: &str) {
        let near = |(a, b): (&(f64, f64), &(f64, f64))| (a.0 - b.0).abs() <= 8.0 * (a.1 + b.1) + 1e-14 * a.0;
        assert!(a.len() == b.len() && a.iter().zip(b).all(near), "{what}: {a:?}, but {b:?}");
    }

    fn random_tube(random: &mut Random, step: f64) -> Numbers {
        let rmin = [0.0, 0.25, 0.5][random.below(3)];
        let angle = |random: &mut Random, n: usize| random.below(n) as f64 * step;
        let turns = (360.0 / step) as usize;
        let (phi0, dphi) = (angle(random, 2 * turns) - 360.0, step + angle(random, turns));
        [rmin, rmin + 0.5, -0.5, 1.0, phi0, dphi]
    }

    #[test]
    fn a_tube_is_a_combination_of_cylinders_and_half_spaces() {
        let mut random = Random::new(91);
        let mut crossed = 0;
        for _ in 0..3000 {
            let numbers = random_tube(&mut random, 7.5);
            let o = random.direction() * 3.0;
            let ray = Ray::new(o, random.point(-0.8, 0.8) - o).unwrap();
            let found = list(|scene| tube(scene, numbers), &ray);
            crossed += usize::from(found.len() > 2);
            assert_alike(&found, &list(|s| combination(s, numbers), &ray), &format!("{numbers:?} {ray:?}"));
        }
        assert!(crossed > 200, "{crossed}");
    }

    /// Rays along generators, in the planes of the ends, in caps and along the axis, of a tube alone and of one
    /// completed to a full ring.
    #[test]
    fn rays_in_the_surfaces_of_a_tube_see_what_is_around_them() {
        let mut random = Random::new(92);
        for _ in 0..1500 {
            let numbers = random_tube(&mut random, 90.0);
            let [rmin, rmax, z0, z1, phi0, dphi] = numbers;
            let at = |k: usize| [0.0, rmin, rmax, -rmin, -rmax, 0.1, -0.1][k];
            let mut o = Vec3::new(at(random.below(7)), at(random.below(7)), [z0, z1, 0.25][random.below(3)]);
            let axis = random.below(3);
            o[axis] = -2.0;
            let ray = Ray::new(o, Vec3::AXES[axis]).unwrap();
            let what = format!("{numbers:?} {ray:?}");
            let alone = list(|scene| tube(scene, numbers), &ray);
            assert_alike(&alone, &list(|s| combination(s, numbers), &ray), &what);
            if dphi < 360.0 {
                let rest = [rmin, rmax, z0, z1, phi0 + dphi, 360.0 - dphi];
                let filled = |scene: &mut Scene| {
                    let parts = vec![tube(scene, numbers), tube(scene, rest)];
                    scene.add_csg(Op::Union, parts)
                };
                let ring = [rmin, rmax, z0, z1, 0.0, 360.0];
                assert_alike(&list(filled, &ray), &list(|s| tube(s, ring), &ray), &what);
            }
        }
    }

    #[test]
    fn bounds_are_tight() {
        let bounds = |values: &[&[f64]]| KIND.build(&Params::of(&KIND, values)).unwrap().bounds();
        let quarter = bounds(&[&[0.5], &[1.0], &[0.0], &[1.0], &[0.0], &[90.0]]);
        assert!((quarter.min - Vec3::ZERO).abs().max_element() < 1e-14, "{quarter:?}");
        assert!((quarter.max - Vec3::ONE).abs().max_element() < 1e-14, "{quarter:?}");
        let most = bounds(&[&[0.5], &[1.0], &[0.0], &[1.0], &[45.0], &[270.0]]);
        assert!(most.min.x == -1.0 && (most.max.x - 0.5f64.sqrt()).abs() < 1e-14, "{most:?}");
        assert!(most.min.y == -1.0 && most.max.y == 1.0);
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        let error = |values: &[&[f64]]| KIND.build(&Params::of(&KIND, values)).unwrap_err().to_string();
        assert_eq!(error(&[&[-1.0], &[1.0], &[0.0], &[1.0]]), "rmin: is -1, but must not be negative");
        assert!(error(&[&[1.0], &[1.0], &[0.0], &[1.0]]).starts_with("rmax: is 1, but"));
        assert!(error(&[&[0.0], &[1.0], &[0.0], &[1.0], &[0.0], &[361.0]]).starts_with("dphi: is 361"));
    }
}
