//! Lines in lanes have the crossings of each line alone.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::*;
use crate::crossing::{Crossing, GROUPING};
use crate::math::{Affine, Vec3};
use crate::ray::Line;
use crate::scratch::Scratch;
use crate::simd::{Portable, Simd, Task, dispatch};
use crate::solid::ignored_axes_tests::QUADRICS;
use crate::solid::{KINDS, Params, Solid, kind};
use crate::testkit::random::Random;

/// The crossings of eight lines with a solid; `None` for those that are left open.
struct Cast<'a>(&'a dyn Solid, &'a [Line; 8], &'a Affine);

type Found = Vec<Option<Vec<Crossing>>>;

impl Task for Cast<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<S: Simd>(self) -> Found {
        let mut found = Vec::new();
        for first in (0..8).step_by(S::Wide::LANES) {
            let lines = LineLanes::<S::Wide>::from_fn(|lane| self.1[first + lane]);
            let inside = self.0.in_lanes().expect("lanes").inside(&lines.in_frame(self.2), S::Wide::ALL);
            found.extend((0..S::Wide::LANES).map(|lane| crossings(&inside, lane)));
        }
        found
    }
}

/// The crossings of eight lines, each with a solid of its own.
struct CastEach<'a>(&'a [&'a dyn Solid; 8], &'a [Line; 8]);

impl Task for CastEach<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<S: Simd>(self) -> Found {
        let mut found = Vec::new();
        for first in (0..8).step_by(S::Wide::LANES) {
            let lines = LineLanes::<S::Wide>::from_fn(|lane| self.1[first + lane]);
            let of_lane = |lane: usize| self.0[(first + lane) % 8].in_lanes().expect("lanes");
            let solids = [0, 1, 2, 3, 4, 5, 6, 7].map(of_lane);
            let inside = InLanes::inside_each(&solids, &lines, S::Wide::ALL);
            found.extend((0..S::Wide::LANES).map(|lane| crossings(&inside, lane)));
        }
        found
    }
}

fn crossings<F: Doubles>(inside: &InsideLanes<F>, lane: usize) -> Option<Vec<Crossing>> {
    let mut list = Vec::new();
    for interval in &inside.intervals {
        for (end, entering) in [(interval.enter, true), (interval.exit, false)] {
            if interval.lanes >> lane & 1 == 1 {
                let number = |of: F| of.store()[lane];
                let surface = number(end.surface) as u32;
                list.push(Crossing::new(number(end.t), number(end.t_err), entering, surface));
            }
        }
    }
    (inside.open >> lane & 1 == 0).then_some(list)
}

/// A number that solids share with lines, so that lines touch, run in faces and begin on surfaces.
fn coordinate(random: &mut Random, size: f64) -> f64 {
    match random.below(8) {
        0 => [0.0, -0.0, 1e-300, 1e-9, -1e9, 1.0][random.below(6)],
        1 => size * f64::from(random.below(5) as i32 - 2) * 0.5,
        _ => random.number(-2.0, 2.0) * size,
    }
}

fn line(random: &mut Random, size: f64) -> Line {
    let mut vector =
        |size: f64| Vec3::new(coordinate(random, size), coordinate(random, size), coordinate(random, size));
    let (o, mut d) = (vector(size), vector(1.0));
    let scale = [1.0, 1e-3, 1e150, 1e-150][random.below(4)];
    let away = [0.0, 0.0, 1e3, 1e9][random.below(4)];
    if d == Vec3::ZERO {
        d = Vec3::Z;
    }
    let mut line = Line::exact(o - d * (away * size), d * scale);
    if random.below(3) == 0 {
        let share = [1e-16, 1e-15, 1e-9][random.below(3)];
        (line.o_err, line.d_err) = (line.o.abs() * share, line.d.abs() * share);
    }
    line
}

fn frame(random: &mut Random, size: f64) -> Affine {
    match random.below(3) {
        0 => Affine::IDENTITY,
        1 => Affine::translation(random.point(-1.0, 1.0) * size),
        _ => Affine::rotation_xyz(random.point(-180.0, 180.0))
            .then_after(&Affine::scaling(random.point(0.1, 3.0))),
    }
}

fn bits(list: &[Crossing]) -> Vec<(u64, u64, bool, u32)> {
    // A zero may have any sign.
    let bits = |c: &Crossing| ((c.t + 0.0).to_bits(), c.t_err.to_bits(), c.entering, c.surface);
    list.iter().map(bits).collect()
}

fn owned(example: &[&[f64]]) -> Vec<Vec<f64>> {
    example.iter().map(|numbers| numbers.to_vec()).collect()
}

#[test]
fn lines_in_lanes_have_the_crossings_of_each_line_alone() {
    let mut random = Random::new(31);
    let (mut hits, mut open, mut all, mut scratch) = (0, 0, 0, Scratch::default());
    let quadric = kind("quadric").expect("a kind");
    let ignoring = QUADRICS.map(|numbers| vec![numbers.to_vec()]);
    let own = KINDS.iter().map(|kind| (*kind, kind.examples.iter().map(|e| owned(e)).collect::<Vec<_>>()));
    for (kind, examples) in own.chain([(quadric, ignoring.to_vec())]) {
        for example in &examples {
            let values: Vec<&[f64]> = example.iter().map(Vec::as_slice).collect();
            let parts = kind.build(&Params::of(kind, &values)).expect("an example");
            let Some(solid) = parts.single().filter(|solid| solid.in_lanes().is_some()) else { continue };
            let bounds = solid.bounds();
            let size = bounds.size().max_element();
            let (size, centre) = if size.is_finite() { (size, bounds.centre()) } else { (2.0, Vec3::ZERO) };
            for _ in 0..600 {
                let frame = frame(&mut random, size);
                let lines = [0; 8].map(|_| {
                    let line = line(&mut random, size);
                    Line { o: line.o + centre, ..line }
                });
                let found = dispatch(Cast(&**solid, &lines, &frame));
                assert_eq!(found, Cast(&**solid, &lines, &frame).run::<Portable>());
                for (line, found) in lines.iter().zip(&found) {
                    all += 1;
                    let Some(found) = found else {
                        open += 1;
                        continue;
                    };
                    let line = line.in_frame(&frame);
                    let (mut alone, mut contacts) = (Vec::new(), Vec::new());
                    solid.crossings(&line, &mut alone);
                    assert_eq!(bits(found), bits(&alone), "{} {example:?} {line:?}", kind.name);
                    assert!(alone.iter().all(|c| c.reach == GROUPING as f32), "{line:?}");
                    hits += alone.len();
                    if alone.is_empty() {
                        solid.contacts(&line, &mut contacts, &mut scratch);
                        assert_eq!(contacts.len(), 0, "{} {example:?} {line:?}", kind.name);
                    }
                }
            }
        }
    }
    assert!(hits > all / 4 && open < all / 3, "{hits} {open} {all}");
}

/// All solids that take several lines at once: the examples of all kinds, and quadrics that ignore axes; each also larger and
/// smaller.
fn solids() -> Vec<Arc<dyn Solid>> {
    let examples = KINDS.iter().flat_map(|kind| kind.examples.iter().map(|e| (*kind, owned(e))));
    let quadric = kind("quadric").expect("a kind");
    let all = examples.chain(QUADRICS.map(|numbers| (quadric, vec![numbers.to_vec()])));
    let sized = all.flat_map(|(kind, example)| [1.0, 0.75, 3.0].map(|by| (kind, example.clone(), by)));
    sized
        .filter_map(|(kind, mut example, by)| {
            example.iter_mut().flatten().for_each(|number| *number *= by);
            let values: Vec<&[f64]> = example.iter().map(Vec::as_slice).collect();
            kind.build(&Params::of(kind, &values))
                .ok()?
                .single()
                .filter(|solid| solid.in_lanes().is_some())
                .cloned()
        })
        .collect()
}

#[test]
fn lanes_may_have_solids_of_their_own() {
    let (mut random, mut hits) = (Random::new(37), 0);
    let solids = solids();
    let mut groups = BTreeMap::<u32, Vec<&dyn Solid>>::new();
    for solid in &solids {
        let group = solid.in_lanes().expect("lanes").group();
        assert!(group < GROUPS);
        groups.entry(group).or_default().push(&**solid);
    }
    assert!(groups.values().filter(|group| group.len() > 2).count() > 6);
    for group in groups.values() {
        for _ in 0..2000 {
            let some = [0; 8].map(|_| group[random.below(group.len())]);
            let lines = [0; 8].map(|_| line(&mut random, 2.0));
            let found = dispatch(CastEach(&some, &lines));
            assert_eq!(found, CastEach(&some, &lines).run::<Portable>());
            for lane in 0..8 {
                let expected = dispatch(Cast(some[lane], &[lines[lane]; 8], &Affine::IDENTITY));
                assert_eq!(found[lane], expected[lane], "{:?} {:?}", some[lane], lines[lane]);
                hits += found[lane].iter().flatten().count();
            }
        }
    }
    assert!(hits > 20_000, "{hits}");
}
