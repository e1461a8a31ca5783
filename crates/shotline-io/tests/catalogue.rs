//! The catalogue of bad input, for scenes, rays and memory: one test per row. Mesh files are tested in
//! `catalogue_meshes.rs`, the messages of the program in `crates/shotline-cli/tests/bad_input.rs`.

use shotline::compile::{Options, SceneError, World, compile};
use shotline::math::{Affine, Vec3};
use shotline::query::batch::{self, BatchError, Run};
use shotline::query::{Caster, Hit, Limits, QueryError};
use shotline::ray::{InvalidRay, Ray, Span};
use shotline::scene::{LocalTransform, Node, NodeId, Op, Scene};
use shotline_io::{Location, parse_scene, write_scene};

fn solid(scene: &mut Scene, kind: &str, values: &[&[f64]]) -> NodeId {
    scene.add_solid(kind, values).expect(kind)
}

/// A scene of one object.
fn scene_of(make: impl FnOnce(&mut Scene) -> NodeId) -> Scene {
    let mut scene = Scene::default();
    let node = make(&mut scene);
    scene.add_object("object", None, node);
    scene
}

fn world(scene: &Scene) -> World {
    compile(scene, Options::default()).unwrap_or_else(|e| panic!("{e:?}"))
}

fn errors(scene: &Scene) -> Vec<SceneError> {
    compile(scene, Options::default()).expect_err("something is wrong")
}

/// The message of the only error, with its hint.
#[track_caller]
fn only_error(scene: &Scene) -> String {
    let errors = errors(scene);
    assert_eq!(errors.len(), 1, "{errors:?}");
    format!("{} ({})", errors[0].message, errors[0].hint.as_deref().unwrap_or("no hint"))
}

fn crossings(world: &World, ray: &Ray) -> Vec<Hit> {
    let mut hits = Vec::new();
    Caster::new(world).crossings(ray, Span::FORWARD, &mut hits).expect("within limits");
    hits
}

const NOTHING: [f64; 0] = [];

fn ts(world: &World, o: Vec3, d: Vec3) -> Vec<f64> {
    crossings(world, &Ray::new(o, d).expect("a ray")).iter().map(|h| h.t).collect()
}

/// The error message for the text of a scene file, which must be refused.
#[track_caller]
fn refused(text: &str) -> String {
    parse_scene(text, None).expect_err(text).to_string()
}

fn file_of(objects: &str) -> String {
    format!("{{\"shotline\": 1, \"objects\": [{objects}]}}")
}

// Rays

#[test]
fn nan_or_infinite_rays() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..3 {
            let mut v = Vec3::ONE;
            v[axis] = bad;
            assert_eq!(Ray::new(v, Vec3::X), Err(InvalidRay::Origin));
            assert_eq!(Ray::new(Vec3::ZERO, v), Err(InvalidRay::Direction));
        }
    }
}

#[test]
fn zero_direction() {
    for zero in [Vec3::ZERO, -Vec3::ZERO] {
        let error = Ray::new(Vec3::ONE, zero).unwrap_err();
        assert_eq!(error.to_string(), "the direction is zero");
    }
}

/// Directions of any length: the list of crossings is correct, and contains no crossing whose `t` is not finite.
#[test]
fn denormal_and_huge_directions() {
    let ball = world(&scene_of(|scene| solid(scene, "sphere", &[&[1.0]])));
    for size in [1e-300, 1e-200, 1e-100, 1.0, 1e100, 1e200, 1e300, 1e308] {
        let found = ts(&ball, Vec3::new(-4.0, 0.0, 0.0), Vec3::X * size);
        let near = found.iter().zip([3.0 / size, 5.0 / size]).all(|(a, b)| (a / b - 1.0).abs() < 1e-15);
        assert!(found.len() == 2 && near, "{size}: {found:?}");
    }
    for size in [1e-310, f64::from_bits(1)] {
        assert_eq!(ts(&ball, Vec3::new(-4.0, 0.0, 0.0), Vec3::X * size), NOTHING);
        assert_eq!(ts(&ball, Vec3::ZERO, Vec3::X * size), [0.0, f64::INFINITY]);
    }
}

/// Models of any size have the same list of crossings, with unit normals.
#[test]
fn denormal_and_huge_models() {
    let kinds: [(&str, &[&[f64]]); 5] = [
        ("sphere", &[&[1.0]]),
        ("box", &[&[-1.0; 3], &[1.0; 3]]),
        ("cylinder", &[&[1.0], &[-1.0], &[1.0]]),
        ("torus", &[&[2.0], &[0.5]]),
        ("quadric", &[&[1.0, 2.0, -1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]]),
    ];
    for (kind, values) in kinds {
        let list = |power: i32| {
            let factor = 2f64.powi(power);
            let world = world(&scene_of(|scene| {
                let node = solid(scene, kind, values);
                scene.add_transform(Affine::scaling(Vec3::splat(factor)), node)
            }));
            let (o, d) = (Vec3::new(-4.0, 0.2, 0.1), Vec3::new(1.0, 0.0, 0.0625));
            let hits = crossings(&world, &Ray::new(o * factor, d * factor).expect("a ray"));
            assert!(
                hits.iter().all(|h| (h.normal.length() - 1.0).abs() < 1e-14),
                "{kind} 2^{power}: {hits:?}"
            );
            hits.iter().map(|h| h.t).collect::<Vec<_>>()
        };
        let expected = list(1);
        assert!(expected.len() >= 2, "{kind}");
        for power in [-1000, -600, -300, 300, 600, 1000] {
            assert_eq!(list(power), expected, "{kind} 2^{power}");
        }
    }
}

#[test]
fn t_range_with_nan_or_reversed() {
    for (t_min, t_max) in [(f64::NAN, 1.0), (0.0, f64::NAN), (2.0, 1.0), (f64::NEG_INFINITY, 1.0)] {
        let error = Span::new(t_min, t_max).unwrap_err();
        assert!(error.to_string().contains("is not an interval"), "{error}");
    }
}

// Transforms and parameters

#[test]
fn singular_or_nan_transform() {
    let flat = Affine::scaling(Vec3::new(1.0, 1.0, 0.0));
    let mut rank_one = Affine::IDENTITY;
    rank_one.rows[2] = [2.0, 0.0, 0.0, 0.0];
    let mut with_nan = Affine::IDENTITY;
    with_nan.rows[1][3] = f64::NAN;
    let nearly = Affine::scaling(Vec3::new(1.0, 1.0, 1e-15));
    let cases = [
        (flat, ["singular", "inf"]),
        (rank_one, ["singular", "inf"]),
        (with_nan, ["the transform has a number", "not finite"]),
        (nearly, ["singular", "1.000e15"]),
    ];
    for (matrix, words) in cases {
        let scene = scene_of(|scene| {
            let ball = solid(scene, "sphere", &[&[1.0]]);
            scene.add_transform(matrix, ball)
        });
        let message = only_error(&scene);
        assert!(words.iter().all(|word| message.contains(word)) && !message.contains("no hint"), "{message}");
    }
}

#[test]
fn singular_only_together() {
    let scene = scene_of(|scene| {
        let ball = solid(scene, "sphere", &[&[1.0]]);
        (0..2).fold(ball, |node, _| scene.add_transform(Affine::scaling(Vec3::new(1.0, 1.0, 1e-10)), node))
    });
    let message = only_error(&scene);
    assert!(
        message.starts_with("all transforms above it together: the transform is singular or nearly so"),
        "{message}"
    );
}

#[test]
fn badly_conditioned_transform_is_accepted_and_reported() {
    let scene = scene_of(|scene| {
        let ball = solid(scene, "sphere", &[&[1.0]]);
        scene.add_transform(Affine::scaling(Vec3::new(1.0, 1.0, 1e-12)), ball)
    });
    let world = world(&scene);
    assert!((world.stats().condition / 1e12 - 1.0).abs() < 1e-3, "{:?}", world.stats());
    let found = ts(&world, Vec3::new(0.0, 0.0, -1.0), Vec3::Z);
    assert!(found.len() == 2 && found[1] - found[0] > 1.9e-12, "{found:?}");
}

#[test]
fn axis_of_any_length() {
    for size in [1e-300, 1e300] {
        let about = shotline::scene::Rotation::About { axis: Vec3::Z * size, degrees: 90.0 };
        let scene = scene_of(|scene| {
            let block = solid(scene, "box", &[&[0.0; 3], &[2.0, 1.0, 1.0]]);
            let transform = LocalTransform::Steps { scale: None, rotate: Some(about), translate: None };
            scene.add(Node::Transform { transform, child: block })
        });
        assert_eq!(ts(&world(&scene), Vec3::new(-0.5, -1.0, 0.5), Vec3::Y), [1.0, 3.0]);
    }
}

#[test]
fn parameters_out_of_range() {
    let cases: &[(&str, &[&[f64]], &str)] = &[
        ("sphere", &[&[0.0]], "sphere: radius is 0, but must be positive"),
        ("sphere", &[&[-2.5]], "radius is -2.5"),
        ("sphere", &[&[f64::NAN]], "radius is NaN"),
        ("sphere", &[&[f64::INFINITY]], "radius is inf"),
        ("box", &[&[0.0; 3], &[1.0, -1.0, 1.0]], "box: max"),
        ("cylinder", &[&[1.0], &[2.0], &[2.0]], "cylinder: z1 is 2, but must be greater than z0 = 2"),
        ("cylinder", &[&[1.0], &[2.0], &[1.0]], "z1 is 1"),
        ("cone", &[&[0.0], &[0.0], &[0.0], &[1.0]], "cone: r1 is 0 like r0, but one must be positive"),
        ("cone", &[&[-1.0], &[1.0], &[0.0], &[1.0]], "r0 is -1, but must not be negative"),
        ("torus", &[&[1.0], &[0.0]], "torus: r is 0"),
        ("torus", &[&[0.0], &[1.0]], "torus: R is 0"),
        ("ellipsoid", &[&[1.0, 0.0, 1.0]], "ellipsoid: semi_axes are"),
        ("halfspace", &[&[0.0; 3], &[1.0]], "halfspace: normal is zero"),
        ("hyperboloid2", &[&[1.0], &[2.0], &[-1.0], &[1.0]], "needed to reach a sheet"),
    ];
    for (kind, values, message) in cases {
        let scene = scene_of(|scene| solid(scene, kind, values));
        let error = &errors(&scene)[0];
        assert!(error.message.contains(message) && error.param.is_some(), "{message} is not in {error:?}");
    }
}

#[test]
fn horn_and_spindle_tori_are_legal() {
    for (major, minor) in [(1.0, 1.0), (1.0, 1.5), (1e-3, 1.0)] {
        let world = world(&scene_of(|scene| solid(scene, "torus", &[&[major], &[minor]])));
        let found = ts(&world, Vec3::new(-9.0, 0.01, 0.02), Vec3::X);
        assert!(found.len() >= 2 && found.len().is_multiple_of(2), "{major} {minor}: {found:?}");
    }
}

#[test]
fn quadric_without_coefficients_is_refused_and_an_empty_one_is_not() {
    let message = only_error(&scene_of(|scene| solid(scene, "quadric", &[&[0.0; 10]])));
    assert!(message.contains("coeffs are all zero, but one must not be"), "{message}");
    let empty = &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(
        ts(&world(&scene_of(|scene| solid(scene, "quadric", &[empty]))), Vec3::Z * 5.0, -Vec3::Z),
        NOTHING
    );
    let all = &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
    let everywhere = world(&scene_of(|scene| solid(scene, "quadric", &[all])));
    assert_eq!(ts(&everywhere, Vec3::Z * 5.0, -Vec3::Z), [0.0, f64::INFINITY]);
}

// Graphs

#[test]
fn cycles_are_reported_by_name() {
    let text = r#"{"shotline": 1,
      "defs": {"hen": {"op": "union", "args": [{"ref": "egg"}]}, "egg": {"op": "group", "args": [{"ref": "hen"}]},
               "self": {"op": "union", "args": [{"ref": "self", "scale": 2}]}},
      "objects": [{"node": {"ref": "hen"}}]}"#;
    let document = parse_scene(text, None).expect("a file may say so");
    let shown = document.diagnostics(&errors(&document.scene)).to_string();
    for fragment in
        ["2:23: a part contains itself: 'hen' -> 'egg' -> 'hen'", "'self' -> 'self'", "help: break the cycle"]
    {
        assert!(shown.contains(fragment), "{fragment} is not in\n{shown}");
    }
}

/// Reporting many long cycles takes little memory and time.
#[test]
fn cycles_by_the_thousand() {
    let mut scene = Scene::default();
    let count = 30_000;
    for i in 0..count {
        let next = NodeId((i + 1) % count);
        let node = scene.add_csg(Op::Union, vec![next, NodeId(0), NodeId(i / 2)]);
        scene.defs.push((format!("part{i}"), node));
    }
    scene.add_object("object", None, NodeId(0));
    let errors = errors(&scene);
    assert!(errors.iter().all(|e| e.message.len() < 400), "{}", errors[errors.len() - 1].message);
    let last = errors.iter().find(|e| e.message.contains("'part11' -> 29988 more -> 'part0'"));
    assert!(last.is_some(), "{}", errors[0].message);
}

/// A sphere below `depth` nested nodes: alternately a combination, a group and a transform.
fn deep(depth: usize) -> Scene {
    scene_of(|scene| {
        let ball = solid(scene, "sphere", &[&[1.0]]);
        (0..depth).fold(ball, |node, i| match i % 3 {
            0 => scene.add_csg(Op::Difference, vec![node]),
            1 => scene.add(Node::Group { members: vec![node] }),
            _ => scene.add_transform(Affine::IDENTITY, node),
        })
    })
}

/// A scene that is a million nodes deep can be built, compiled, queried and dropped. The writer splits a deep nest into
/// named definitions, so that the text can be read again.
#[test]
fn depth_bomb() {
    assert_eq!(ts(&world(&deep(1_000_000)), Vec3::new(-2.0, 0.0, 0.0), Vec3::X), [1.0, 3.0]);
    let text = write_scene(&deep(100_000)).expect("finite numbers");
    let again = parse_scene(text, None).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(ts(&world(&again.scene), Vec3::new(-2.0, 0.0, 0.0), Vec3::X), [1.0, 3.0]);
}

#[test]
fn depth_bomb_in_a_file() {
    for piece in [r#"{"op": "union", "args": ["#, "[", r#"{"a": "#] {
        let shown = refused(&file_of(&piece.repeat(1_000_000)));
        assert!(
            shown.contains("nested more than 20000 deep") && shown.contains("help: name the inner"),
            "{shown}"
        );
    }
}

fn doubled(scene: &mut Scene, times: usize, first: NodeId, double: impl Fn(Vec<NodeId>) -> Node) -> NodeId {
    (0..times).fold(first, |node, _| scene.add(double(vec![node, node])))
}

/// Groups of shared nodes become instances and are never expanded, so 2^60 leaves are not a problem.
#[test]
fn reference_bomb_of_groups_is_legal() {
    let scene = scene_of(|scene| {
        let ball = solid(scene, "sphere", &[&[1.0]]);
        doubled(scene, 60, ball, |members| Node::Group { members })
    });
    let world = world(&scene);
    assert_eq!(world.stats().virtual_leaves, 1 << 60);
    assert!(world.stats().memory_bytes < 100_000);
    assert!(
        Caster::new(&world)
            .any(&Ray::new(Vec3::new(-2.0, 0.0, 0.0), Vec3::X).unwrap(), Span::FORWARD)
            .expect("within limits")
    );
    let too_many = scene_of(|scene| {
        let ball = solid(scene, "sphere", &[&[1.0]]);
        doubled(scene, 70, ball, |members| Node::Group { members })
    });
    assert!(only_error(&too_many).contains("more than 2^63 instances cannot be numbered"));
}

/// Combinations are expanded, so their size is counted first, also where they have no leaves.
#[test]
fn reference_bomb_of_combinations_is_counted() {
    let csg = |op| move |args| Node::Csg { op, args };
    for times in [24, 60, 100] {
        for op in [Op::Union, Op::Intersection, Op::Difference] {
            let scene = scene_of(|scene| {
                let ball = solid(scene, "sphere", &[&[1.0]]);
                doubled(scene, times, ball, csg(op))
            });
            let message = only_error(&scene);
            assert!(
                message.starts_with("a combination of 4194304 leaves; at most 4000000 are accepted"),
                "{message}"
            );
        }
    }
    let empty = scene_of(|scene| {
        let nothing = scene.add(Node::Group { members: Vec::new() });
        let groups = doubled(scene, 40, nothing, |members| Node::Group { members });
        scene.add_csg(Op::Union, vec![groups])
    });
    assert!(only_error(&empty).contains("nodes; at most"));
}

// Scene files

#[test]
fn huge_file() {
    assert_eq!(
        parse_scene(" ".repeat((256 << 20) + 1), None).unwrap_err().to_string(),
        "is larger than 256 MiB\nhelp: put triangles into mesh files and repeated parts into \"defs\""
    );
}

#[test]
fn duplicate_and_unknown_keys() {
    let shown = refused(&file_of(r#"{"name": "a", "name": "b", "nod": {"kind": "sphere", "radius": 1}}"#));
    for fragment in
        ["1:43: the key 'name' stands here twice", "help: keep one of them", "an object needs \"node\""]
    {
        assert!(shown.contains(fragment), "{fragment} is not in\n{shown}");
    }
}

#[test]
fn invalid_numbers() {
    let cases = [
        ("1e400", "1e400 is too large for a float64"),
        ("-1e400", "-1e400 is too large"),
        ("NaN", "NaN is not a number"),
        ("-Infinity", "'-Infinity' is not a number: it must be finite"),
        ("01", "'01' is not a number: a leading 0 is not allowed"),
        ("0x10", "'0x10' is not a number: only decimal numbers are allowed"),
        (".5", "'.5' is not a number: a digit must come first"),
        ("\"1\"", "radius must be a number, not a string"),
        ("[1]", "radius must be a number, not an array"),
        ("null", "radius must be a number"),
    ];
    for (number, message) in cases {
        let shown = refused(&file_of(&format!(r#"{{"node": {{"kind": "sphere", "radius": {number}}}}}"#)));
        assert!(shown.contains(&format!("1:67: {message}")), "1:67: {message}\nis not in\n{shown}");
    }
    // A number that underflows is zero, which the sphere refuses.
    let tiny =
        parse_scene(file_of(r#"{"node": {"kind": "sphere", "radius": 1e-400}}"#), None).expect("a number");
    assert!(only_error(&tiny.scene).contains("radius is 0"));
}

#[test]
fn trailing_data() {
    let shown = refused("{\"shotline\": 1}\n{}");
    assert!(
        shown.contains("2:1: something follows the end of the scene") && shown.contains("help: "),
        "{shown}"
    );
}

#[test]
fn byte_order_mark() {
    assert!(parse_scene("\u{FEFF}{\"shotline\": 1}", None).is_ok());
    let shown = refused("{\"shotline\": 1, \u{FEFF}\"objects\": []}");
    assert!(shown.contains("1:17: a key in quotes is expected"), "{shown}");
}

#[test]
fn unknown_units() {
    for (units, hint) in
        [("parnsips", "nm, um, mm"), ("Mm", "did you mean 'mm'"), ("inch", "did you mean 'in'")]
    {
        let shown = refused(&format!("{{\"shotline\": 1, \"units\": \"{units}\"}}"));
        assert!(shown.contains("1:26: ") && shown.contains(units) && shown.contains(hint), "{shown}");
    }
    for units in ["nm", "um", "mm", "cm", "m", "km", "in", "ft", "none"] {
        let document = parse_scene(format!("{{\"shotline\": 1, \"units\": \"{units}\"}}"), None).unwrap();
        assert_eq!(document.scene.units.map_or("none", |units| units.name()), units);
    }
}

#[test]
fn lone_surrogates() {
    for text in [r"\ud800", r"\udc00", r"\ud800\ud800", r"\ud800x", r"\u12"] {
        let shown = refused(&format!("{{\"shotline\": 1, \"units\": \"{text}\"}}"));
        assert!(shown.contains("1:27: "), "{shown}");
    }
    let scene = shotline_io::FORMATS.iter().find(|format| format.name == "scene").unwrap();
    let error = scene.read("a.json".as_ref(), b"{\"shotline\": 1, \"units\": \"\xED\xA0\x80\"}".into());
    assert!(error.unwrap_err().to_string().contains("a.json:1:27: the text is not UTF-8 from here on"));
}

#[test]
fn truncated_file() {
    let whole = file_of(r#"{"node": {"kind": "sphere", "radius": 1.5}}"#);
    for end in 0..whole.len() {
        let error = parse_scene(&whole[..end], None).expect_err("cut off");
        assert!(error.diagnostics.iter().all(|p| matches!(p.location, Location::Text { .. })), "{error}");
    }
}

// Output

/// A ray along 10^12 balls has more crossings than its limit; many rays along 100 balls exceed the limit of rows.
#[test]
fn more_crossings_than_the_limit() {
    let row = |digits: i32| {
        world(&scene_of(|scene| {
            let mut node = solid(scene, "sphere", &[&[0.25]]);
            for level in 0..digits {
                let step = 10f64.powi(level);
                let transform = |i: i32| Affine::translation(Vec3::X * (step * f64::from(i)));
                let members = (0..10).map(|i| scene.add_transform(transform(i), node)).collect();
                node = scene.add(Node::Group { members });
            }
            node
        }))
    };
    let ray = Ray::new(Vec3::new(-1.0, 0.0, 0.0), Vec3::X).expect("a ray");
    let long = row(12);
    let mut hits = Vec::new();
    let mut caster = Caster::new(&long);
    caster.limit(Limits { crossings: 1000, ..Limits::default() });
    let refused = caster.crossings(&ray, Span::FORWARD, &mut hits);
    assert_eq!((refused, hits.len()), (Err(QueryError::TooMany { most: 1000 }), 0));
    let short = row(2);
    let rays = [ray; 50];
    for threads in [1, 2] {
        let run = |most_rows| Run { threads, most_rows, ..Run::default() };
        assert!(batch::crossings(&short, &rays, Span::FORWARD, run(10_000)).is_ok());
        let error = batch::crossings(&short, &rays, Span::FORWARD, run(9_999)).unwrap_err();
        assert_eq!(error, BatchError::TooMany { most: 9_999 });
        assert_eq!(error.to_string(), "the answer has more than 9999 rows");
        assert!(batch::count(&short, &rays, Span::FORWARD, run(0)).is_ok(), "a row a ray is no matter");
    }
}
