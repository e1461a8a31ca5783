//! Profiles of solids of revolution: polygons of the half-plane of the distance from the z axis, and of z.

use std::f64::consts::PI;

use shotline::solid::Params;

/// The most steps of a circle.
const MOST_STEPS: f64 = 1_048_576.0;

/// The fewest steps of a circle: it looks round, and has 0.97 of the area.
const FEWEST_STEPS: f64 = 16.0;

/// A polygon (r, z), counter-clockwise, and its way around the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pub corners: Vec<[f64; 2]>,
    /// How far its sides are from the arcs that they stand for.
    pub deviation: f64,
    /// Where it begins, and the angle that it takes, in radians; `None` for the whole turn.
    pub sector: Option<[f64; 2]>,
}

/// How arcs become steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arcs {
    /// The greatest distance of a chord from its arc.
    pub tolerance: f64,
}

impl Arcs {
    /// The number of equal steps of an arc of an angle, and how far their chords are from it; `None` for too many.
    pub fn steps(&self, radius: f64, angle: f64) -> Option<(usize, f64)> {
        // Half of a step: its cosine is 1 - tolerance / radius.
        let half = 2.0 * (0.5 * self.tolerance / radius).min(1.0).sqrt().asin();
        let steps = (angle / (2.0 * half)).max(FEWEST_STEPS * angle / (2.0 * PI)).ceil();
        let sine = (0.25 * angle / steps).sin();
        (steps <= MOST_STEPS).then_some((steps as usize, 2.0 * radius * sine * sine))
    }
}

impl Profile {
    /// The profile of a solid; `None` if its kind has none, or it touches itself.
    pub fn of(kind: &str, params: &Params, arcs: Arcs) -> Option<Profile> {
        let number = |name: &'static str| params.number(name).ok();
        let ends = || Some([number("z0")?, number("z1")?]);
        let between = |inner: [f64; 2], outer: [f64; 2]| {
            let [z0, z1] = ends()?;
            Some(vec![[inner[0], z0], [outer[0], z0], [outer[1], z1], [inner[1], z1]])
        };
        let (corners, deviation) = match kind {
            "cylinder" => (between([0.0; 2], [number("radius")?; 2])?, 0.0),
            "cone" => (between([0.0; 2], [number("r0")?, number("r1")?])?, 0.0),
            "tube" => (between([number("rmin")?; 2], [number("rmax")?; 2])?, 0.0),
            "cone_section" => {
                let [inner, outer] = [["rmin0", "rmin1"], ["rmax0", "rmax1"]].map(|names| names.map(number));
                (between([inner[0]?, inner[1]?], [outer[0]?, outer[1]?])?, 0.0)
            }
            "polycone" => (of_planes(params.rows("planes").ok()?.rows)?, 0.0),
            "revolved" => (params.rows("points").ok()?.rows, 0.0),
            "sphere" => arc(0.0, number("radius")?, -0.5 * PI, PI, arcs)?,
            "torus" => {
                let (middle, radius) = (number("R")?, number("r")?);
                let (mut corners, deviation) = arc(middle, radius, -PI, 2.0 * PI, arcs)?;
                corners.pop();
                (Some(corners).filter(|_| radius < middle)?, deviation)
            }
            _ => return None,
        };
        let corners = counter_clockwise(corners)?;
        let sector = match (number("phi0"), number("dphi")) {
            (Some(from), Some(angle)) if angle < 360.0 => Some([from.to_radians(), angle.to_radians()]),
            _ => None,
        };
        Some(Profile { corners, deviation, sector })
    }
}

/// The points of an arc about (middle, 0), and how far its chords are from it. Where it begins and ends at the axis, it does so exactly.
fn arc(middle: f64, radius: f64, from: f64, angle: f64, arcs: Arcs) -> Option<(Vec<[f64; 2]>, f64)> {
    let (steps, deviation) = arcs.steps(radius, angle)?;
    let point = |step: usize| {
        let (sine, cosine) = (from + angle * step as f64 / steps as f64).sin_cos();
        let is_at_axis = middle == 0.0 && (step == 0 || step == steps);
        [if is_at_axis { 0.0 } else { middle + radius * cosine }, radius * sine]
    };
    Some(((0..=steps).map(point).collect(), deviation))
}

/// The outline of a wall between planes (z, rmin, rmax); `None` if it has no thickness somewhere.
fn of_planes(planes: Vec<[f64; 3]>) -> Option<Vec<[f64; 2]>> {
    let outer = planes.iter().map(|[z, _, rmax]| [*rmax, *z]);
    let inner = planes.iter().rev().map(|[z, rmin, _]| [*rmin, *z]);
    let is_wall = planes.iter().all(|[_, rmin, rmax]| rmin < rmax);
    // At a step the wall goes on only between the radii that both sides have.
    let goes_on = planes.windows(2).all(|pair| pair[0][1].max(pair[1][1]) < pair[0][2].min(pair[1][2]));
    (is_wall && goes_on).then(|| outer.chain(inner).collect())
}

/// A polygon without repeated corners, counter-clockwise; `None` if it has no area, or folds back on itself.
fn counter_clockwise(mut corners: Vec<[f64; 2]>) -> Option<Vec<[f64; 2]>> {
    corners.dedup();
    if corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    let next = corners.iter().cycle().skip(1);
    let area: f64 = corners.iter().zip(next).map(|([r, z], [next_r, next_z])| r * next_z - next_r * z).sum();
    if area < 0.0 {
        corners.reverse();
    }
    let has_area = corners.len() > 2 && area != 0.0 && area.is_finite();
    (has_area && !folds_back(&corners)).then_some(corners)
}

/// Whether an edge runs back along the one before it.
fn folds_back(corners: &[[f64; 2]]) -> bool {
    let count = corners.len();
    (0..count).any(|i| {
        let [a, b, c] = [i, i + 1, i + 2].map(|i| corners[i % count]);
        let ([r, z], [next_r, next_z]) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
        r * next_z == z * next_r && r * next_r + z * next_z < 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_are_counter_clockwise_and_have_no_spikes() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut clockwise = square.to_vec();
        clockwise.reverse();
        clockwise.insert(1, clockwise[0]);
        let mut found = counter_clockwise(clockwise).unwrap();
        found.rotate_left(1);
        assert_eq!(found.len(), 4);
        assert_eq!(counter_clockwise(square.to_vec()).unwrap(), square);
        let spike = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        assert_eq!(counter_clockwise(spike), None);
        assert_eq!(counter_clockwise(vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]), None);
    }

    #[test]
    fn steps_keep_the_tolerance() {
        for tolerance in [10.0, 0.1, 1e-3, 1e-9] {
            for angle in [0.01, 1.0, 2.0 * PI] {
                let (steps, deviation) = Arcs { tolerance }.steps(2.0, angle).unwrap();
                assert!(steps > 0 && deviation <= tolerance * (1.0 + 1e-9), "{steps} {deviation}");
                // One step fewer would not do, unless there are the fewest.
                let fewer = 2.0 * (1.0 - (0.5 * angle / (steps as f64 - 1.0)).cos());
                let are_fewest = steps as f64 - 1.0 < FEWEST_STEPS * angle / (2.0 * PI);
                assert!(are_fewest || fewer > tolerance * 0.999, "{tolerance} {angle} {steps}");
            }
        }
        assert_eq!(Arcs { tolerance: 1e-15 }.steps(1.0, PI), None);
    }
}
