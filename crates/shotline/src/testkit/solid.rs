//! The conformance suite that every solid passes: the rules of the contract, each tested on the same lines.

use std::fmt::Display;
use std::sync::Arc;

use super::moments::closed_form_agrees_with_rays;
use super::random::Random;
use crate::aabb::Aabb;
use crate::crossing::{Crossing, is_alternating};
use crate::math::{Affine, HALF_ULP, TransformPair, Vec3, two_sum};
use crate::ray::Line;
use crate::solid::{Kind, Param, Params, Solid};

/// The number of lines per family and example.
const LINES: usize = 40;
/// Crossings are coincident if their `t` differ by at most this multiple of the sum of their bounds.
const EVENT: f64 = 8.0;

/// A solid, a line and the resulting list, to which the rules apply.
struct Case<'a> {
    kind: &'a Kind,
    params: &'a Params,
    solid: &'a dyn Solid,
    line: Line,
    list: Vec<Crossing>,
}

/// Runs the suite on all examples of a kind.
///
/// # Panics
/// If the solid breaks a rule. The message contains the kind, its parameters, the line and the rule.
pub fn conformance(kind: &'static Kind) {
    assert!(!kind.examples.is_empty(), "{} has no examples", kind.name);
    for example in kind.examples {
        let params = Params::of(kind, example);
        let parts = match kind.build(&params) {
            Ok(parts) => parts,
            Err(error) => panic!("{} refuses its own example {params:?}: {error}", kind.name),
        };
        let Some(solid) = parts.single() else { continue };
        closed_form_agrees_with_rays(kind, &params);
        for line in lines(&solid.bounds()) {
            let list = cast(&**solid, &line);
            let case = Case { kind, params: &params, solid: &**solid, line, list };
            for rule in RULES {
                rule(&case);
            }
        }
    }
}

/// The rules, one function each.
const RULES: &[fn(&Case)] = &[
    lists_alternate,
    points_lie_on_the_surface,
    points_lie_in_the_bounds,
    normals_are_gradients,
    entering_is_against_the_normal,
    parity_is_membership,
    the_far_end_sees_the_mirrored_list,
    sliding_the_origin_shifts_the_list,
    rigid_motions_change_nothing,
    directions_scale_exactly,
    extreme_directions_scale_exactly,
    sizes_scale_exactly,
];

fn lists_alternate(case: &Case) {
    let sound = |c: &Crossing| !c.t.is_nan() && c.t_err >= 0.0 && c.t_err.is_finite();
    case.require(is_alternating(&case.list) && case.list.iter().all(sound), "lists alternate", "");
}

fn points_lie_on_the_surface(case: &Case) {
    for c in case.finite() {
        let p = case.line.at(c.t);
        let value = case.solid.implicit(p, c.surface, c.primitive).abs();
        let slope = case.solid.normal(p, c.surface, c.primitive).length();
        let reach = 2.0 * c.t_err * case.line.d.length() + case.slack(c.t);
        case.require(
            value <= slope * reach,
            "points lie on the surface",
            format!("{c:?}: {value} over {slope}"),
        );
    }
}

fn points_lie_in_the_bounds(case: &Case) {
    let bounds = case.solid.bounds();
    for c in case.finite() {
        let p = case.line.at(c.t);
        let outside = (bounds.min - p).max(p - bounds.max).max_element();
        let reach = c.t_err * case.line.d.length() + case.slack(c.t);
        case.require(outside <= reach, "points lie in the bounds", format!("{c:?} at {p}"));
    }
}

fn normals_are_gradients(case: &Case) {
    let step = extent(&case.solid.bounds()).1 * 1e-6;
    for c in case.finite() {
        let p = case.line.at(c.t);
        let f = |p: Vec3| case.solid.implicit(p, c.surface, c.primitive);
        let slope = |i: usize| {
            let h = Vec3::AXES[i] * step[i];
            (f(p + h) - f(p - h)) / ((p + h)[i] - (p - h)[i])
        };
        // Compared in units of `step`, in which solids of all proportions are about as wide as long.
        let measured = (Vec3::new(slope(0), slope(1), slope(2)) * step).normalize_or_zero();
        let normal = (case.solid.normal(p, c.surface, c.primitive) * step).normalize_or_zero();
        let detail = format!("{c:?}: normal {normal}, measured {measured}");
        case.require((normal - measured).length() < 1e-3, "normals are gradients", detail);
    }
}

fn entering_is_against_the_normal(case: &Case) {
    for c in case.finite() {
        let along = |t: f64| case.solid.normal(case.line.at(t), c.surface, c.primitive).dot(case.line.d);
        let (before, after) = (along(c.t - 2.0 * c.t_err), along(c.t + 2.0 * c.t_err));
        // Near a tangent the normal may flip within the bound.
        if before * after > 0.0 {
            let detail = format!("{c:?}: n . d = {}", along(c.t));
            case.require((before < 0.0) == c.entering, "entering is against the normal", detail);
        }
    }
}

fn parity_is_membership(case: &Case) {
    let step = extent(&case.solid.bounds()).1.length() / case.line.d.length();
    let mut ends = vec![(f64::NEG_INFINITY, 0.0)];
    ends.extend(case.list.iter().map(|c| (c.t, c.t_err)));
    ends.push((f64::INFINITY, 0.0));
    for (i, pair) in ends.windows(2).enumerate() {
        let ((from, from_err), (to, to_err)) = (pair[0], pair[1]);
        let t = match (from.is_finite(), to.is_finite()) {
            (true, true) => 0.5 * from + 0.5 * to,
            (true, false) => from + step,
            (false, true) => to - step,
            (false, false) => 0.0,
        };
        // Two ends at the same infinity enclose nothing, and membership within coincident crossings is undefined.
        if from < to && to - from > EVENT * EVENT * (from_err + to_err) {
            let inside = case.solid.contains(case.line.at(t));
            case.require(inside == (i % 2 == 1), "parity is membership", format!("inside {inside} at {t}"));
        }
    }
}

fn the_far_end_sees_the_mirrored_list(case: &Case) {
    let far = case.finite().map(|c| c.t.abs()).fold(1.0, f64::max) * 2.0;
    let o_err = (case.line.o.abs() + 2.0 * case.line.d.abs() * far) * HALF_ULP;
    let back = Line { o: case.line.at(far), d: -case.line.d, o_err, d_err: Vec3::ZERO };
    let mirrored = cast(case.solid, &back).into_iter().rev().map(|c| Crossing {
        t: far - c.t,
        t_err: c.t_err + HALF_ULP * far,
        entering: !c.entering,
        ..c
    });
    case.agree(&mirrored.collect::<Vec<_>>(), "the far end sees the mirrored list");
}

/// For lines with few digits the origin moves without rounding. All differences come from the solid's own
/// arithmetic, which its bounds must cover.
fn sliding_the_origin_shifts_the_list(case: &Case) {
    let short = |v: Vec3| v.as_vec3().as_dvec3();
    let (o, d) = (short(case.line.o), short(case.line.d));
    let here = Case { line: Line::exact(o, d), list: cast(case.solid, &Line::exact(o, d)), ..*case };
    for steps in [-3.0, 0.5, 2.0, 64.0] {
        let exact = (0..3).all(|i| two_sum(o[i], d[i] * steps).lo == 0.0);
        if exact {
            let slid = cast(case.solid, &Line::exact(o + d * steps, d));
            let back = slid.into_iter().map(|c| {
                let t = c.t + steps;
                Crossing { t, t_err: c.t_err + HALF_ULP * t.abs(), ..c }
            });
            here.agree(&back.collect::<Vec<_>>(), "sliding the origin shifts the list");
        }
    }
}

/// Also a million sizes away, where counts must still be right. The size is that of the thinnest side.
fn rigid_motions_change_nothing(case: &Case) {
    let turn = Affine::rotation_xyz(Vec3::new(20.0, -35.0, 130.0));
    let (_, size) = extent(&case.solid.bounds());
    for away in [size * 3.0, Vec3::splat(1e6 * size.min_element())] {
        let motion = Affine::translation(away).then_after(&turn);
        let Ok(TransformPair { parent_from_local, local_from_parent, .. }) = TransformPair::new(&motion)
        else {
            panic!("a rigid motion has an inverse");
        };
        let there_and_back = case.line.in_frame(&parent_from_local).in_frame(&local_from_parent);
        case.agree(&cast(case.solid, &there_and_back), "rigid motions change nothing");
    }
}

fn directions_scale_exactly(case: &Case) {
    for k in [-300, -41, 1, 100, 300] {
        case.require_scaled(&case.line, k);
    }
}

/// Directions with subnormal components, and directions whose squares overflow. They have few digits, so neither
/// scaling loses any.
fn extreme_directions_scale_exactly(case: &Case) {
    let short = |v: Vec3| v.as_vec3().as_dvec3();
    let line = Line::exact(case.line.o, short(case.line.d));
    let exactly = |k: i32| (0..3).all(|i| scaled(scaled(line.d[i], k), -k) == line.d[i]);
    for k in [-1015, 960] {
        if line.d != Vec3::ZERO && exactly(k) {
            case.require_scaled(&line, k);
        }
    }
}

/// The same solid and line, scaled by powers of two.
fn sizes_scale_exactly(case: &Case) {
    for k in [-300, -20, 7, 300] {
        let Some(solid) =
            case.kind.build(&grown(case.kind, case.params, k)).ok().and_then(|parts| parts.single().cloned())
        else {
            panic!("{} refuses its own example times 2^{k}", case.kind.name);
        };
        let list = cast(&*solid, &Line::exact(scaled_vector(case.line.o, k), scaled_vector(case.line.d, k)));
        let same = list.iter().map(|c| c.t).eq(case.list.iter().map(|c| c.t));
        case.require(same, "sizes scale exactly", format!("2^{k}: {list:?}"));
    }
}

/// The parameters of the same solid scaled by `2^k`.
fn grown(kind: &Kind, params: &Params, k: i32) -> Params {
    let grow = |(param, (name, numbers)): (&Param, &(&'static str, Arc<[f64]>))| {
        let power = |i: usize| k * param.power_of_length(i);
        (*name, numbers.iter().enumerate().map(|(i, x)| scaled(*x, power(i))).collect())
    };
    Params { entries: kind.params.iter().zip(&params.entries).map(grow).collect() }
}

fn scaled_vector(v: Vec3, k: i32) -> Vec3 {
    Vec3::from(v.to_array().map(|x| scaled(x, k)))
}

/// A number times `2^k`.
fn scaled(x: f64, k: i32) -> f64 {
    let half = k / 2;
    x * 2f64.powi(half) * 2f64.powi(k - half)
}

impl Case<'_> {
    /// Checks a rule.
    ///
    /// # Panics
    /// If the rule does not hold.
    fn require(&self, holds: bool, rule: &str, detail: impl Display) {
        assert!(
            holds,
            "{}: {rule}: {detail}\n  {:?}\n  {:?}\n  {:?}",
            self.kind.name, self.params, self.line, self.list
        );
    }

    /// Checks that a line's list scales exactly with the line's direction.
    ///
    /// # Panics
    /// If it does not.
    fn require_scaled(&self, line: &Line, k: i32) {
        let longer = Line::exact(line.o, scaled_vector(line.d, k));
        let (there, here) = (cast(self.solid, &longer), cast(self.solid, line));
        let same = |(a, b): (&Crossing, &Crossing)| {
            let (t, t_err) = (scaled(b.t, -k), scaled(b.t_err, -k));
            // The bounds include a margin for underflow.
            a.t == t
                && a.entering == b.entering
                && (a.t_err - t_err).abs() <= 1e-3 * t_err + 4.0 * f64::MIN_POSITIVE
        };
        let holds = there.len() == here.len() && there.iter().zip(&here).all(same);
        let overflows = here.iter().any(|c| scaled(c.t, -k).is_infinite());
        self.require(
            holds || overflows,
            "directions scale exactly",
            format!("2^{k}: {line:?} {there:?} for {here:?}"),
        );
    }

    /// The finite crossings, at which there is a surface.
    fn finite(&self) -> impl Iterator<Item = &Crossing> {
        self.list.iter().filter(|c| c.t.is_finite())
    }

    /// The length by which rounding may have moved the point at `t` or changed an implicit function there.
    fn slack(&self, t: f64) -> f64 {
        let bounds = self.solid.bounds();
        let (centre, size) = extent(&bounds);
        let reach = self.line.o.abs() + self.line.d.abs() * t.abs() + centre.abs() + size;
        32.0 * HALF_ULP * reach.length()
    }

    /// Checks that another list equals this one within the bounds of both, as they are or without coincident
    /// pairs. Crossings far away compared with the solid's size count as infinitely far, because rounding turns a
    /// line parallel to a plane into one that crosses it there.
    fn agree(&self, other: &[Crossing], rule: &str) {
        let (centre, size) = extent(&self.solid.bounds());
        let far = ((self.line.o - centre).length() + 1e3 * size.length()) / self.line.d.length();
        let clamp = |list: &[Crossing]| -> Vec<Crossing> {
            let near = |c: &Crossing| c.t.abs() < far;
            let limit = |c: &Crossing| Crossing { t: c.t.clamp(-far, far), t_err: 0.0, ..*c };
            list.iter().map(|c| if near(c) { *c } else { limit(c) }).collect()
        };
        let (ours, theirs) = (clamp(&self.list), clamp(other));
        let agree = same(&ours, &theirs) || same(&without_events(&ours), &without_events(&theirs));
        self.require(agree, rule, format!("{other:?}"));
    }
}

/// Whether two lists are equal within the bounds of both.
fn same(ours: &[Crossing], theirs: &[Crossing]) -> bool {
    let near = |a: &Crossing, b: &Crossing| (a.t - b.t).abs() <= a.t_err + b.t_err;
    ours.len() == theirs.len() && ours.iter().zip(theirs).all(|(a, b)| near(a, b) && a.entering == b.entering)
}

fn cast(solid: &dyn Solid, line: &Line) -> Vec<Crossing> {
    let mut list = Vec::new();
    solid.crossings(line, &mut list);
    list
}

/// A list without coincident neighbours, as the sweep of a boolean expression sees it.
fn without_events(list: &[Crossing]) -> Vec<Crossing> {
    let mut kept: Vec<Crossing> = Vec::new();
    for c in list {
        match kept.last() {
            Some(last) if c.t - last.t <= EVENT * (c.t_err + last.t_err) => drop(kept.pop()),
            _ => kept.push(*c),
        }
    }
    kept
}

/// The centre and size of a box. If the box is unbounded, those of a box of size 2 around the origin.
fn extent(bounds: &Aabb) -> (Vec3, Vec3) {
    if bounds.is_finite() { (bounds.centre(), bounds.size()) } else { (Vec3::ZERO, Vec3::splat(2.0)) }
}

/// Lines at a solid: from near and far, from inside, and along the axes with zeros of either sign.
fn lines(bounds: &Aabb) -> Vec<Line> {
    let mut random = Random::new(1);
    let (centre, size) = extent(bounds);
    // The targets fill slightly more than the box, so that some lines miss.
    let (low, high) = (centre - size * 0.55, centre + size * 0.55);
    let mut lines = Vec::new();
    for _ in 0..LINES {
        for sizes in [0.0, 2.0, 1e3, 1e6] {
            let target = low + (high - low) * random.point(0.0, 1.0);
            let toward = random.direction();
            let o = target - toward * (sizes * size.length());
            let d = if sizes == 0.0 { toward } else { target - o };
            lines.push(Line::exact(o, d * random.number(0.1, 10.0)));
        }
        let mut d = Vec3::splat([0.0, -0.0][random.below(2)]);
        let axis = random.below(3);
        d[axis] = [1.0, -1.0][random.below(2)] * size[axis];
        lines.push(Line::exact(low + (high - low) * random.point(0.0, 1.0) - d * random.number(0.0, 5.0), d));
    }
    lines
}
