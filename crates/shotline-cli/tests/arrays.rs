//! The output of `shotline cast`: the names, types, shapes and values of its arrays.

mod sandbox;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use sandbox::{DRILLED, Sandbox};

/// Rays through the walls of the hole, along the hole, not valid, past everything, from inside the ball.
const RAYS: &[[f64; 6]] = &[
    [-10.0, 0.0, 0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, -10.0, 0.0, 0.0, 3.0],
    [0.0; 6],
    [0.0, 0.0, 9.0, 0.0, 0.0, 1.0],
    [3.0, 0.0, 0.0, 0.5, 0.0, 0.0],
];

/// An array as it is in the file.
struct Array {
    descr: String,
    shape: String,
    data: Vec<u8>,
}

impl Array {
    fn f64s(&self) -> Vec<f64> {
        assert_eq!(self.descr, "<f8");
        self.data.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn i64s(&self) -> Vec<i64> {
        assert_eq!(self.descr, "<i8");
        self.data.chunks(8).map(|b| i64::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn i32s(&self) -> Vec<i32> {
        assert_eq!(self.descr, "<i4");
        self.data.chunks(4).map(|b| i32::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn texts(&self) -> Vec<String> {
        let width: usize = self.descr.strip_prefix("<U").unwrap().parse().unwrap();
        let character = |b: &[u8]| char::from_u32(u32::from_le_bytes(b.try_into().unwrap())).unwrap();
        let text = |row: &[u8]| row.chunks(4).map(character).collect::<String>();
        self.data.chunks(4 * width).map(|row| text(row).trim_end_matches('\0').to_string()).collect()
    }
}

fn load(path: &Path) -> BTreeMap<String, Array> {
    let mut zip = zip::ZipArchive::new(File::open(path).unwrap()).unwrap();
    let mut out = BTreeMap::new();
    for i in 0..zip.len() {
        let mut entry = zip.by_index(i).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let header = String::from_utf8(bytes[10..start].to_vec()).unwrap();
        let between = |from: &str, to: &str| {
            let rest = header.split_once(from).unwrap().1;
            rest.split_once(to).unwrap().0.to_string()
        };
        let array = Array {
            descr: between("'descr': '", "'"),
            shape: between("'shape': (", ")").trim_end_matches(',').to_string(),
            data: bytes[start..].to_vec(),
        };
        out.insert(entry.name().unwrap().strip_suffix(".npy").unwrap().to_string(), array);
    }
    out
}

fn cast(query: &str) -> BTreeMap<String, Array> {
    cast_with(query, &[])
}

fn cast_with(query: &str, rest: &[&str]) -> BTreeMap<String, Array> {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED).with_rays("rays.npy", RAYS);
    let fixed = ["cast", "drilled.json", "--rays", "rays.npy", "-o", "out.npz", "--on-invalid", "miss"];
    sandbox.run(&[&fixed[..], &["--query", query], rest].concat()).ok();
    load(&sandbox.path("out.npz"))
}

#[track_caller]
fn assert_close(found: &[f64], exact: &[f64]) {
    let same = |a: f64, b: f64| a == b || (a - b).abs() < 1e-12 || (a.is_nan() && b.is_nan());
    assert!(found.len() == exact.len() && found.iter().zip(exact).all(|(a, b)| same(*a, *b)), "{found:?}");
}

#[test]
fn closest() {
    let arrays = cast("closest");
    assert_close(&arrays["t"].f64s(), &[5.0, f64::INFINITY, f64::INFINITY, f64::INFINITY, 0.0]);
    assert_eq!(arrays["normal"].shape, "5, 3");
    assert_close(&arrays["normal"].f64s()[..6], &[-1.0, 0.0, 0.0, f64::NAN, f64::NAN, f64::NAN]);
    assert_eq!(arrays["object"].i32s(), [0, -1, -1, -1, 0]);
    assert_eq!(arrays["path"].i64s(), [0, -1, -1, -1, 0]);
    assert_eq!(arrays["primitive"].i32s(), [-1; 5]);
    assert_eq!(
        (arrays["entering"].descr.as_str(), &arrays["entering"].data[..]),
        ("|b1", &[1, 0, 0, 0, 1][..])
    );
    assert!(arrays.contains_key("surface") && arrays.contains_key("t_err"));
}

#[test]
fn only_the_fields_that_are_named() {
    let (all, some) = (cast("closest"), cast_with("closest", &["--fields", "normal,t_err"]));
    let names: Vec<&String> = some.keys().collect();
    assert_eq!(names, ["material_names", "normal", "object_names", "t", "t_err"]);
    assert!(some.iter().all(|(name, array)| array.data == all[name].data));
    let (all, some) = (cast("crossings"), cast_with("crossings", &["--fields", "path,ray_splits"]));
    let names: Vec<&String> = some.keys().collect();
    assert_eq!(names, ["material_names", "object_names", "path", "path_names", "ray_splits", "t"]);
    assert!(some.iter().all(|(name, array)| array.data == all[name].data));
    let sandbox = Sandbox::new().with("drilled.json", DRILLED).with_rays("rays.npy", RAYS);
    let fixed = ["cast", "drilled.json", "--rays", "rays.npy", "-o", "out.npz", "--on-invalid", "miss"];
    let refused = |rest: &[&str], why: &[&str]| {
        sandbox.run(&[&fixed[..], rest].concat()).fails_with(why);
    };
    refused(
        &["--query", "closest", "--fields", "t,kind"],
        &["no field 'kind'", "help: the fields are t, normal"],
    );
    refused(
        &["--query", "count", "--fields", "t"],
        &["--fields is for --query closest and crossings, not for count"],
    );
}

#[test]
fn any_and_count() {
    let any = &cast("any")["any"];
    assert_eq!((any.descr.as_str(), &any.data[..]), ("|b1", &[1, 0, 0, 0, 1][..]));
    assert_eq!(cast("count")["count"].i64s(), [6, 0, 0, 0, 4]);
}

#[test]
fn crossings() {
    let arrays = cast("crossings");
    assert_eq!(arrays["ray_splits"].i64s(), [0, 6, 6, 6, 6, 10]);
    assert_close(&arrays["t"].f64s(), &[5.0, 9.0, 11.0, 15.0, 16.0, 18.0, 0.0, 4.0, 6.0, 10.0]);
    assert_eq!(arrays["entering"].data, [1, 0, 1, 0, 1, 0, 1, 0, 1, 0]);
    assert_eq!(
        (arrays["kind"].descr.as_str(), &arrays["kind"].data[..7]),
        ("|i1", &[0, 0, 0, 0, 0, 0, 1][..])
    );
    assert_eq!(arrays["object"].i32s(), [0, 0, 0, 0, 1, 1, 0, 0, 1, 1]);
    assert_eq!(arrays["path"].i64s(), [0, 0, 0, 0, 1, 1, 0, 0, 1, 1]);
    assert_eq!(arrays["path_names"].texts(), ["ball", "slab"]);
    assert_eq!(arrays["object_names"].texts(), ["ball", "slab"]);
    assert_eq!(arrays["material_names"].texts(), ["air", "steel"]);
    assert_eq!(arrays["normal"].shape, "10, 3");
    assert!(arrays["t_err"].f64s().iter().all(|e| (0.0..1e-12).contains(e)));
}

#[test]
fn segments() {
    let arrays = cast("segments");
    assert_eq!(arrays["ray_splits"].i64s(), [0, 3, 3, 3, 3, 5]);
    assert_close(&arrays["t_in"].f64s(), &[5.0, 11.0, 16.0, 0.0, 6.0]);
    assert_close(&arrays["t_out"].f64s(), &[9.0, 15.0, 18.0, 4.0, 10.0]);
    assert_close(&arrays["length"].f64s(), &[4.0, 4.0, 2.0, 2.0, 2.0]);
    assert_eq!(arrays["material"].i32s(), [1, 1, 0, 1, 0]);
    assert_eq!(arrays["object"].i32s(), [0, 0, 1, 0, 1]);
    assert_eq!(arrays["path_names"].texts(), ["ball", "slab"]);
}

#[test]
fn only_paths_that_rays_meet_are_numbered() {
    // Eight pins in shared rows; the rays meet two of them.
    let scene = r#"{"shotline": 1,
      "defs": {
        "pin": {"kind": "sphere", "radius": 0.25},
        "ten": {"op": "group", "args": [{"ref": "pin"}, {"ref": "pin", "translate": [1, 0, 0]}]},
        "row": {"op": "group", "args": [{"ref": "ten"}, {"ref": "ten", "translate": [0, 5, 0]}]}},
      "objects": [{"name": "pins", "node": {"op": "group", "args": [
        {"ref": "row"}, {"ref": "row", "translate": [0, 50, 0]}]}}]}"#;
    let rays = [[0.0, 55.0, -1.0, 0.0, 0.0, 1.0], [1.0, 5.0, -1.0, 0.0, 0.0, 1.0]];
    let sandbox = Sandbox::new().with("pins.json", scene).with_rays("rays.npy", &rays);
    sandbox.run(&["cast", "pins.json", "--rays", "rays.npy", "-o", "out.npz", "--query", "crossings"]).ok();
    let arrays = load(&sandbox.path("out.npz"));
    assert_eq!(arrays["path"].i64s(), [1, 1, 0, 0]);
    let names = arrays["path_names"].texts();
    assert!(names.len() == 2 && names.iter().all(|n| n.starts_with("pins/")), "{names:?}");
}

#[test]
fn empty_arrays_keep_their_types() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED).with_rays("rays.npy", &[]);
    sandbox
        .run(&["cast", "drilled.json", "--rays", "rays.npy", "-o", "out.npz", "--query", "crossings"])
        .ok();
    let arrays = load(&sandbox.path("out.npz"));
    assert_eq!(arrays["ray_splits"].i64s(), [0]);
    assert_eq!((arrays["normal"].descr.as_str(), arrays["normal"].shape.as_str()), ("<f8", "0, 3"));
    assert_eq!(arrays["object_names"].texts(), ["ball", "slab"]);
}
