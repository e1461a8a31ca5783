//! Scenes written as GDML, and read again.

use std::path::{Path, PathBuf};

use shotline::compile::{World, compile};
use shotline::math::Vec3;
use shotline::query::{Caster, Overlaps};
use shotline::ray::{Ray, Span};
use shotline::scene::Scene;
use shotline::solid::KINDS;
use shotline::testkit::random::Random;
use shotline_io::{Document, load, parse_scene, save};

/// A scene of objects, as the text of a scene file.
fn scene(objects: &str) -> Scene {
    let text = format!("{{ \"shotline\": 1, \"units\": \"mm\", \"objects\": [{objects}] }}");
    parse_scene(text.clone(), None).unwrap_or_else(|error| panic!("{error}\n{text}")).scene
}

/// The text of a scene as GDML, the notes, and what is read from it.
fn written(scene: &Scene) -> Result<(String, Vec<String>, Document), String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("part.gdml");
    let notes = save(&path, scene).map_err(|error| error.to_string())?;
    let text = std::fs::read_to_string(&path).expect("a file");
    let document = load(&path).unwrap_or_else(|error| panic!("{error}\n{text}"));
    Ok((text, notes, document))
}

fn world_of(scene: &Scene) -> World {
    compile(scene, Default::default()).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// Where a ray is inside which object, or which path: name, begin and end. The box that was added around a scene is left out.
fn owners(world: &World, ray: &Ray, least: f64, by_path: bool) -> Vec<(String, f64, f64)> {
    let mut segments = Vec::new();
    Caster::new(world).segments(ray, Span::FORWARD, Overlaps::Priority, &mut segments).expect("solids");
    let mut found: Vec<(String, f64, f64)> = Vec::new();
    for segment in segments {
        let object = &world.object_names()[segment.object as usize];
        let name = if by_path { world.path_name(segment.path) } else { object.clone() };
        match found.last_mut() {
            _ if (object == "World" && !by_path) || segment.t_out - segment.t_in <= least => {}
            Some(last) if !by_path && last.0 == name && segment.t_in - last.2 <= least => {
                last.2 = segment.t_out
            }
            _ => found.push((name, segment.t_in, segment.t_out)),
        }
    }
    found
}

/// Compares the owners of rays through the bounds of two scenes, and returns how many segments were compared.
#[track_caller]
fn assert_same(what: &str, one: &Scene, other: &Scene, rays: usize, by_path: bool) -> usize {
    let worlds = [one, other].map(world_of);
    let bounds = worlds[0].finite_bounds();
    if bounds.is_empty() {
        return 0;
    }
    let size = (bounds.max - bounds.min).length();
    let mut random = Random::new(11);
    let mut inside = || {
        let u = random.point(0.0, 1.0);
        bounds.min + (bounds.max - bounds.min) * u
    };
    let mut met = 0;
    for _ in 0..rays {
        let (a, b) = (inside(), inside());
        let direction = (b - a).normalize();
        let ray = Ray::new(a - direction * size, direction).expect("a ray");
        let [expected, found] = worlds.each_ref().map(|world| owners(world, &ray, 1e-9 * size, by_path));
        met += expected.len();
        let is_near = |(a, b): (&(String, f64, f64), &(String, f64, f64))| {
            a.0 == b.0 && (a.1 - b.1).abs() < 2e-9 * size && (a.2 - b.2).abs() < 2e-9 * size
        };
        let same = expected.len() == found.len() && expected.iter().zip(&found).all(is_near);
        assert!(same, "{what}: {ray:?}\n{expected:?}\n{found:?}");
    }
    met
}

#[track_caller]
fn assert_round_trip(what: &str, scene: &Scene) -> (String, Vec<String>) {
    let (text, notes, document) = written(scene).unwrap_or_else(|error| panic!("{what}: {error}"));
    let met = assert_same(what, scene, &document.scene, 300, false);
    assert!(met > 0, "{what}: no ray meets anything");
    (text, notes)
}

/// Kinds and the numbers of their examples that GDML does not have.
const REFUSED: &[(&str, &[usize])] = &[
    ("halfspace", &[0, 1, 2, 3, 4, 5, 6, 7]),
    ("quadric", &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]),
    ("hyperboloid2", &[0, 1, 2]),
    ("torus", &[3, 4, 5]),
    ("twisted_tube", &[1]),
    ("twisted_trapezoid", &[2]),
];

#[test]
fn solids_of_every_kind_are_the_same_again() {
    for kind in KINDS {
        for (number, example) in kind.examples.iter().enumerate() {
            let what = format!("{} {number}", kind.name);
            let mut scene = Scene::default();
            let solid = scene.add_solid(kind.name, example).expect("a kind");
            scene.add_object("part", None, solid);
            let is_refused =
                REFUSED.iter().any(|(name, numbers)| *name == kind.name && numbers.contains(&number));
            match written(&scene) {
                Err(error) => assert!(is_refused && error.contains("object 'part': its "), "{what}: {error}"),
                Ok((_, _, document)) => {
                    assert!(!is_refused, "{what}");
                    assert!(assert_same(&what, &scene, &document.scene, 300, false) > 0, "{what}");
                }
            }
        }
    }
}

const BALL: &str = r#"{ "kind": "sphere", "radius": 1.5 }"#;
const CORNER: &str = r#"{ "kind": "box", "min": [0, 0, 0], "max": [3, 1, 2] }"#;
const CONE: &str = r#"{ "kind": "cone", "r0": 0.25, "r1": 1, "z0": 0, "z1": 2 }"#;

fn object(name: &str, rest: &str) -> String {
    format!("{{ \"name\": \"{name}\", {rest} }}")
}

#[test]
fn combinations_are_the_same_again() {
    let turned = CONE.replace(" }", r#", "rotate": [30, 40, 50], "translate": [1, 0, 0.5] }"#);
    let scaled = CONE.replace(" }", r#", "scale": [2, 1, 0.5], "rotate": [0, 30, 0] }"#);
    let mirrored = CORNER.replace(" }", r#", "scale": [-1, 1, 1], "rotate": [0, 0, 20] }"#);
    let twice = format!(r#"{{ "op": "union", "args": [{scaled}], "scale": [1, 3, 1] }}"#);
    let all = [BALL, CORNER, &turned, &scaled, &mirrored, &twice];
    for op in ["union", "intersection", "difference"] {
        let mut met = 0;
        for first in 0..all.len() {
            for second in 0..all.len() {
                let args = format!("{}, {}", all[first], all[second]);
                let node = format!(r#""node": {{ "op": "{op}", "args": [{args}] }}"#);
                let scene = scene(&object("part", &node));
                // What has nothing in it has no bounds either.
                if let Ok((_, _, document)) = written(&scene) {
                    met +=
                        assert_same(&format!("{op} {first} {second}"), &scene, &document.scene, 300, false);
                }
            }
        }
        assert!(met > 1000, "{op}: {met}");
        let args = all.join(", ");
        let args = if op == "intersection" { format!("{BALL}, {CORNER}, {BALL}") } else { args };
        let (text, _) = assert_round_trip(
            op,
            &scene(&object("part", &format!(r#""node": {{ "op": "{op}", "args": [{args}] }}"#))),
        );
        assert!(op != "union" || text.contains("<multiUnion "));
    }
}

/// A tray that holds two parts, of which one holds a ball.
fn tray(clip: bool) -> String {
    let ball = object("ball", r#""node": { "kind": "sphere", "radius": 0.4 }"#);
    let ball = placed(&ball, r#""translate": [1.5, 0.5, 0.75], "rotate": [10, 0, 0]"#);
    object("cell", &format!(r#""node": {CORNER}, "clip": {clip}, "contents": [{ball}]"#))
}

fn placed(object: &str, placement: &str) -> String {
    object.replacen(r#""node""#, &format!("{placement}, \"node\""), 1)
}

#[test]
fn placements_are_the_same_again() {
    let placements = [
        r#""translate": [1, 2, 3]"#,
        r#""rotate": [10, 20, 30], "translate": [-4, 2, 3]"#,
        r#""rotate": [0, 90, 30], "translate": [-4, 2, 3]"#,
        r#""rotate": [0, 0, 35.5]"#,
        r#""scale": [1, -1, 1], "rotate": [10, 20, 30]"#,
        r#""scale": [-1, -1, -1], "rotate": [10, 20, 130]"#,
        r#""scale": 2, "rotate": [0, -90, 30]"#,
        r#""scale": [-2, 2, 2], "translate": [5, 5, 5]"#,
        r#""transform": [0, 0, 1, 4,  1, 0, 0, -2,  0, 1, 0, 1]"#,
        r#""rotate": { "axis": [1, 2, 3], "degrees": 100 }"#,
    ];
    for placement in placements {
        let scene = scene(&placed(&tray(true), placement));
        let (_, notes) = assert_round_trip(placement, &scene);
        assert!(notes.iter().any(|note| note.contains("the volume 'World'")), "{notes:?}");
        // Within a world, where no box is added.
        let hall = object(
            "hall",
            &format!(
                r#""node": {{ "kind": "cylinder", "radius": 20, "z0": -20, "z1": 20 }}, "clip": true, "contents": [{}]"#,
                placed(&tray(true), placement)
            ),
        );
        let (text, notes) = assert_round_trip(placement, &self::scene(&hall));
        assert!(!text.contains("World") && notes.iter().all(|note| !note.contains("World")), "{notes:?}");
    }
    // The scale along the axes of a part that holds nothing.
    let stretched = placed(
        &object("ball", &format!(r#""node": {BALL}"#)),
        r#""scale": [1, 2, 3], "rotate": [10, 20, 30]"#,
    );
    assert_round_trip("stretched", &scene(&stretched));
}

/// Files that would mean something else, or that cannot be read, are not written.
#[test]
fn what_would_be_wrong_is_refused() {
    let cube = |name: &str, priority: i32, size: f64, contents: &str| {
        let node =
            format!(r#""node": {{ "kind": "box", "min": [0, 0, 0], "max": [{size}, {size}, {size}] }}"#);
        object(name, &format!(r#""priority": {priority}, "clip": true, {node}, "contents": [{contents}]"#))
    };
    let refused = |objects: &str| written(&scene(objects)).expect_err("no file");
    let inner = cube("b", 5, 2.0, "");
    let roots = [cube("a", 0, 4.0, &inner), cube("c", 3, 3.0, "")].join(", ");
    let error = refused(&roots);
    assert!(error.contains("'c'") && error.contains("placed later wins"), "{error}");
    assert!(refused(&cube("hall", 0, 9.0, &roots)).contains("'c'"));
    // With nothing of a higher priority in it the order of placement says the same.
    assert!(
        written(&scene(&[cube("a", 0, 4.0, &cube("b", 2, 2.0, "")), cube("c", 3, 3.0, "")].join(", ")))
            .is_ok()
    );
    let long = r#""node": { "kind": "box", "min": [-1.5e308, 0, 0], "max": [1.5e308, 1, 1] }"#;
    assert!(refused(&object("long", long)).contains("'long': a length is no float64 in millimetres"));
}

#[test]
fn lattices_are_written_cell_by_cell() {
    let lattice = |op: &str| {
        let ball = object("ball", r#""node": { "kind": "sphere", "radius": 0.4 }"#);
        let node = r#"{ "kind": "box", "min": [-9, -9, -9], "max": [9, 9, 9] }"#;
        object(
            "hall",
            &format!(r#""node": {node}, "clip": true, "contents": [{{ {op}, "args": [{ball}] }}]"#),
        )
    };
    let rows = lattice(r#""op": "lattice", "counts": [3, 4, 2], "pitch": [1, 2, 1.5], "rotate": [0, 0, 20]"#);
    let (text, _) = assert_round_trip("a lattice", &scene(&rows));
    assert_eq!(text.matches("volumeref ref=\"ball\"").count(), 24);
    let many = lattice(r#""op": "lattice", "counts": [1000, 1000, 1000], "pitch": [0.01, 0.01, 0.01]"#);
    let error = written(&scene(&many)).expect_err("too many cells");
    assert!(error.contains("more than 1048576"), "{error}");
}

#[test]
fn shared_objects_are_written_once() {
    let text = format!(
        r#"{{ "shotline": 1, "units": "cm", "defs": {{
            "cell": {cell},
            "row": {{ "op": "group", "args": [ {{ "ref": "cell" }}, {{ "ref": "cell", "translate": [4, 0, 0], "label": "next[7]" }} ] }} }},
          "objects": [ {{ "name": "hall", "node": {{ "kind": "box", "min": [-20, -20, -20], "max": [20, 20, 25] }}, "clip": true,
            "contents": [ {{ "ref": "row", "label": "a" }}, {{ "ref": "row", "translate": [0, 5, 0], "label": "b[1]" }},
              {{ "ref": "row", "translate": [0, 10, 0], "scale": [1, 1, -1] }}, {{ "ref": "cell", "translate": [0, -5, 0], "scale": 0.5 }} ] }} ] }}"#,
        cell = tray(true)
    );
    let scene = parse_scene(text, None).expect("a scene").scene;
    let (text, notes, document) = written(&scene).expect("GDML");
    // The cell and its ball are there twice, because one is smaller; all else is shared.
    assert_eq!(text.matches("<volume ").count(), 5, "{text}");
    assert_eq!((text.matches("<assembly ").count(), text.matches("<physvol").count()), (1, 8), "{text}");
    assert!(notes.iter().any(|note| note.contains("lengths in cm are written in mm")), "{notes:?}");
    let world = world_of(&document.scene);
    let names: Vec<_> = (0..world.path_count()).map(|path| world.path_name(path)).collect();
    for name in ["hall/a/cell_PV/ball_PV", "hall/b[1]/next[7]", "hall/row_PV[2]/next[7]"] {
        assert!(names.iter().any(|known| known == name), "{name}: {names:?}");
    }
    let mut in_mm = scene.clone();
    in_mm.objects = scene
        .objects
        .iter()
        .map(|root| in_mm.add_transform(shotline::math::Affine::scaling(Vec3::splat(10.0)), *root))
        .collect();
    let rename = |scene: &Scene| {
        let mut scene = scene.clone();
        for node in &mut scene.nodes {
            if let shotline::scene::Node::Object { name, .. } = node {
                *name = name.trim_end_matches("0x2").to_owned();
            }
        }
        scene
    };
    assert!(assert_same("shared", &in_mm, &rename(&document.scene), 400, false) > 0);
}

#[test]
fn meshes_are_written_with_their_corners() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let obj = "v 0 0 0\nv 2 0 0\nv 0 3 0\nv 0.1 0.2 1.7\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    std::fs::write(path("good.obj"), obj).expect("a file");
    std::fs::write(
        path("inward.obj"),
        obj.replace("f 1 3 2", "f 1 2 3")
            .replace("f 1 2 4", "f 2 1 4")
            .replace("f 2 3 4", "f 3 2 4")
            .replace("f 3 1 4", "f 1 3 4"),
    )
    .expect("a file");
    std::fs::write(path("open.obj"), obj.replace("f 3 1 4\n", "")).expect("a file");
    for name in ["good.obj", "inward.obj"] {
        let scene = load(path(name)).expect("a mesh").scene;
        let (text, _) = assert_round_trip(name, &scene);
        assert_eq!(
            (text.matches("<position ").count(), text.matches("<triangular ").count()),
            (4, 4),
            "{text}"
        );
    }
    let error = written(&load(path("open.obj")).expect("a mesh").scene).expect_err("an open mesh");
    assert!(error.contains("a mesh is not closed, and GDML has solids only: 3 open edges"), "{error}");
    // A mesh in a scene is not written beside it.
    let scene = load(path("good.obj")).expect("a mesh").scene;
    save(path("out.gdml"), &scene).expect("a file");
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 4);
}

#[test]
fn materials_keep_densities_and_elements() {
    let text = r#"{ "shotline": 1, "units": "mm", "objects": [ { "name": "hall", "material": "air", "node": { "kind": "sphere", "radius": 9 }, "clip": true,
        "contents": [ { "name": "plate", "material": "Pb", "node": { "kind": "sphere", "radius": 1 } },
          { "name": "drop", "material": "my water!", "translate": [3, 0, 0], "node": { "kind": "sphere", "radius": 1 } },
          { "name": "gap", "translate": [-3, 0, 0], "node": { "kind": "sphere", "radius": 1 } } ] } ],
      "materials": { "air": { "density": 0.00129, "composition": { "N": 0.75, "Oxygen": 0.25 } }, "Pb": { "density": 11.35, "composition": { "Pb": 1 } },
        "my water!": { "density": 1, "composition": { "H": 0.112, "O": 0.888 }, "color": [0, 0, 1] }, "odd": { "composition": { "Unobtainium": 1 } } } }"#;
    let scene = parse_scene(text, None).unwrap_or_else(|error| panic!("{error}")).scene;
    let (text, notes, document) = written(&scene).expect("GDML");
    let known = |name: &str| &document.scene.materials.iter().find(|(known, _)| known == name).expect(name).1;
    for (name, again) in [("air", "air"), ("Pb", "Pb"), ("my water!", "my_water_")] {
        let (_, before) = scene.materials.iter().find(|(known, _)| known == name).expect(name);
        assert_eq!(
            (before.density, &before.composition),
            (known(again).density, &known(again).composition),
            "{text}"
        );
    }
    assert_eq!(known("Vacuum").density, Some(1e-25));
    let all = notes.join("\n");
    for part in ["'my water!'", "without a density", "'Unobtainium'", "colours", "written with vacuum: 'gap'"]
    {
        assert!(all.contains(part), "{part}: {all}");
    }
}

/// What GDML cannot hold is an error that names the object, and all of them are reported.
#[test]
fn what_gdml_lacks_is_refused() {
    let solids = [
        (
            r#"{ "kind": "halfspace", "normal": [0, 0, 1], "offset": 0 }"#,
            "its halfspace: GDML has no half-space",
        ),
        (
            r#"{ "kind": "quadric", "coeffs": [1, 2, 3, 0, 0, 0, 0, 0, 0, -1] }"#,
            "its quadric: GDML has no general quadric",
        ),
        (
            r#"{ "kind": "hyperboloid2", "a": 1, "c": 1, "z0": -3, "z1": 3 }"#,
            "its hyperboloid2: GDML has no hyperboloid of two sheets",
        ),
        (r#"{ "kind": "torus", "R": 1, "r": 1 }"#, "its torus: GDML has no torus without a hole"),
        (
            r#"{ "kind": "sphere", "radius": 1, "transform": [1, 0.5, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0] }"#,
            "a transform shears",
        ),
        (r#"{ "kind": "sphere", "radius": -1 }"#, "its sphere: radius is -1"),
    ];
    let objects: Vec<_> = (0..)
        .zip(solids)
        .map(|(i, (node, _))| object(&format!("part{i}"), &format!("\"node\": {node}")))
        .collect();
    let all = written(&scene(&objects.join(", "))).expect_err("nothing can be written");
    for (number, (_, why)) in (0..).zip(solids) {
        assert!(all.contains(&format!("object 'part{number}': {why}")), "{why}: {all}");
    }
    // Contents under a scale along axes that they are turned against.
    let turned = placed(&object("inner", &format!(r#""node": {BALL}"#)), r#""rotate": [10, 20, 30]"#);
    let outer = object("outer", &format!(r#""node": {BALL}, "clip": true, "contents": [{turned}]"#));
    let error = written(&scene(&placed(&outer, r#""scale": [1, 2, 3]"#))).expect_err("a shear");
    assert!(error.contains("object 'outer': a transform shears"), "{error}");
    let many: Vec<_> =
        (0..130).map(|i| object(&format!("o{i}"), &format!("\"node\": {}", solids[0].0))).collect();
    let error = written(&scene(&many.join(", "))).expect_err("half-spaces");
    assert!(error.contains("'o99'") && !error.contains("'o100'") && error.contains("and 30 more"), "{error}");
    let lower = object("inner", &format!(r#""priority": -1, "node": {BALL}"#));
    let error = written(&scene(&object("outer", &format!(r#""node": {CORNER}, "contents": [{lower}]"#))))
        .expect_err("a priority");
    assert!(error.contains("object 'outer': it contains an object of lower priority"), "{error}");
    assert!(written(&Scene::default()).expect_err("an empty scene").contains("the scene has no solids"));
}

#[test]
fn what_is_lost_is_noted() {
    let low = object("low", &format!(r#""node": {BALL}"#));
    let high = object("high", &format!(r#""priority": 2, "node": {CORNER}"#));
    let high_first = scene(&format!("{high}, {low}"));
    let (text, notes) = assert_round_trip("priorities", &high_first);
    assert!(text.find("ref=\"low\"") < text.find("ref=\"high\""), "{text}");
    assert!(
        notes.iter().any(|note| note.contains("GDML has no priorities") && note.contains("'high'")),
        "{notes:?}"
    );
    let (_, notes, _) = written(&scene(&tray(false))).expect("GDML");
    assert!(
        notes.iter().any(|note| note.contains("counts only inside them") && note.contains("'cell'")),
        "{notes:?}"
    );
    let group = object(
        "nuts",
        &format!(
            r#""node": {{ "op": "group", "args": [{BALL}, {}] }}"#,
            CORNER.replace(" }", r#", "translate": [9, 0, 0] }"#)
        ),
    );
    let (text, notes) = assert_round_trip("group", &scene(&group));
    assert!(text.contains("<union ") && notes.iter().any(|note| note.contains("became unions")), "{notes:?}");
    let names = format!(
        "{}, {}",
        object("a \\\"b\\\" <c>", &format!(r#""node": {BALL}"#)),
        object("twin", &format!(r#""node": {CORNER}, "translate": [5, 5, 5]"#))
    );
    let twins = scene(&format!(
        "{names}, {}",
        object("twin", &format!(r#""node": {BALL}, "translate": [-9, 5, 5]"#))
    ));
    let (text, notes, _) = written(&twins).expect("GDML");
    assert!(
        text.contains("<volume name=\"a__b___c_\">") && text.contains("<volume name=\"twin0x2\">"),
        "{text}"
    );
    assert!(
        notes.iter().any(|note| note.contains("'a \"b\" <c>'"))
            && notes.iter().any(|note| note.contains("'twin'")),
        "{notes:?}"
    );
}

/// The folder with the detectors that other tests of the project use, if it is there.
fn detectors() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/gdml");
    let is_there = folder.is_dir();
    if !is_there {
        eprintln!("{} is not there: no detectors are compared", folder.display());
    }
    is_there.then_some(folder)
}

#[test]
fn detectors_are_the_same_again() {
    for name in ["g4_solids", "celeritas_solids", "cmse", "lhcb_calos", "protodunehd_v8"] {
        let Some(folder) = detectors() else { return };
        let scene = load(folder.join(format!("{name}.gdml"))).unwrap_or_else(|error| panic!("{error}")).scene;
        let (_, notes, document) = written(&scene).unwrap_or_else(|error| panic!("{name}: {error}"));
        eprintln!("{name}: {notes:?}");
        let [one, other] = [&scene, &document.scene].map(world_of);
        assert_eq!(one.path_count(), other.path_count(), "{name}");
        let sorted = |world: &World| {
            let mut names = world.object_names().to_vec();
            names.sort();
            names
        };
        assert_eq!(sorted(&one), sorted(&other), "{name}");
        let step = one.path_count() / 1000 + 1;
        let mut paths = [&one, &other].map(|world| {
            let mut names: Vec<_> =
                (0..world.path_count()).step_by(step as usize).map(|path| world.path_name(path)).collect();
            names.sort();
            names
        });
        let [first, second] = &mut paths;
        assert_eq!(first, second, "{name}");
        assert!(assert_same(name, &scene, &document.scene, 200, true) > 0, "{name}");
    }
}
