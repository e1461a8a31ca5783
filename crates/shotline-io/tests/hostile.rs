//! Small valid files of every format with random damage: no reader panics or allocates much memory.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use peak_alloc::PeakAlloc;
use shotline::testkit::random::Random;
use shotline_io::{FORMATS, Format};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// More memory than any of these tests needs, and less than any of the false headers would take.
const MOST_MIB: f32 = 32.0;

const SCENE: &str = r#"{ "shotline": 1, "units": "mm", // a comment
  "defs": { "a": { "kind": "sphere", "radius": 1.5e0 }, "b": { "ref": "a" } },
  "objects": [ { "name": "\u00e9\ud83d\ude00", "material": "m", "priority": 2, "node":
    { "op": "difference", "args": [ { "ref": "b" }, { "ref": "a", "scale": 2, "rotate": [1, 2, 3] },
      { "kind": "sphere", "radius": 1, "transform": [1,0,0,0, 0,1,0,0, 0,0,1,0] } ] } } ],
  "materials": { "m": { "mu": 0.2, "color": [1, 0, 0.5] } },
  "camera": { "eye": [1, 2, 3], "target": [0, 0, 0], "fov": 40 },
  "lights": [ { "ambient": true }, { "point": [1, 1, 1], "intensity": 2 } ], }"#;

const PLY_TEXT: &str = "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty double y\n\
    property int z\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 1\n1 0 0 2\n0 1 0 3\n0 0 1 4\n3 0 1 2\n4 0 1 2 3\n";

const OBJ: &str = "# x\no a\nv 0 0 0\nv 1 0 0 1.0\nv 0 1 0\nvn 0 0 1\nf 1//1 2/1 -1\nf 1 \\\n2 3 1\n";

const STL_TEXT: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e-3 0\n\
    endloop\nendfacet\nendsolid a\n";

fn binary_ply(order: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 3\nproperty double x\nproperty float y\n\
         property short z\nelement face 1\nproperty list uint uint vertex_index\nproperty list char float q\n\
         end_header\n"
    )
    .into_bytes();
    let ordered = |mut raw: Vec<u8>| {
        if order == "big" {
            raw.reverse();
        }
        raw
    };
    for i in 0..3u8 {
        bytes.extend(ordered(f64::from(i).to_le_bytes().to_vec()));
        bytes.extend(ordered(f32::from(i * i).to_le_bytes().to_vec()));
        bytes.extend(ordered(i16::from(i).to_le_bytes().to_vec()));
    }
    for n in [3u32, 0, 1, 2] {
        bytes.extend(ordered(n.to_le_bytes().to_vec()));
    }
    bytes.push(0);
    bytes
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes[..5].copy_from_slice(b"solid");
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((0..100u8).map(|i| i % 7));
    bytes
}

fn npy() -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00\x46\x00".to_vec();
    bytes.extend(format!("{:<69}\n", "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 6), }").bytes());
    bytes.extend([7; 96]);
    bytes
}

fn format(extension: &str) -> &'static Format {
    FORMATS.iter().find(|f| f.extensions.contains(&extension)).unwrap()
}

/// The bytes with one to three changes: some removed, repeated or replaced, often by punctuation or large numbers.
fn broken(whole: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(bytes.len().max(1)).min(bytes.len());
        let end = (at + 1 + random.below(8)).min(bytes.len());
        match random.below(8) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..end)),
            2 => bytes.splice(at..at, whole[..random.below(whole.len())].iter().copied()).for_each(drop),
            3 => bytes.splice(at..end, b"4294967295".iter().copied()).for_each(drop),
            4 => bytes.splice(at..end, [0xFF; 8]).for_each(drop),
            5 => bytes
                .splice(at..end, b"\"[{}],:-/\\\n"[random.below(11)..].iter().take(1).copied())
                .for_each(drop),
            6 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            _ if at < bytes.len() => bytes[at] = random.bits() as u8,
            _ => {}
        }
    }
    bytes
}

#[test]
fn damaged_files_cause_no_panic_and_no_large_allocation() {
    let seeds: [(&str, Vec<u8>); 8] = [
        ("json", SCENE.into()),
        ("ply", PLY_TEXT.into()),
        ("ply", binary_ply("little")),
        ("ply", binary_ply("big")),
        ("obj", OBJ.into()),
        ("stl", STL_TEXT.into()),
        ("stl", binary_stl()),
        ("npy", npy()),
    ];
    let mut random = Random::new(7);
    for (extension, whole) in &seeds {
        let read = |bytes: &[u8]| match *extension {
            "npy" => shotline_io::arrays::parse_rays(bytes).err(),
            _ => format(extension).read(Path::new("folder/a"), bytes.to_vec()).err(),
        };
        assert_eq!(read(whole).map(|e| e.to_string()), None, "{extension}");
        for _ in 0..600 {
            let bytes = broken(whole, &mut random);
            let outcome = catch_unwind(AssertUnwindSafe(|| read(&bytes).map(|e| e.to_string())));
            let shown = String::from_utf8_lossy(&bytes).into_owned();
            assert!(!outcome.expect(&shown).is_some_and(|message| message.is_empty()), "{shown}");
            assert!(MEMORY.peak_usage_as_mb() < MOST_MIB, "{shown}");
        }
    }
}

#[test]
fn headers_that_announce_more_than_the_file_has_are_refused_without_allocating() {
    let file = |extension: &str, bytes: &[u8]| {
        format(extension).read(Path::new("a"), bytes.to_vec()).unwrap_err().to_string()
    };
    let ply = |encoding: &str, vertex: &str, face: &str, data: &[u8]| {
        let head =
            format!("ply\nformat {encoding} 1.0\nelement vertex {vertex}\nelement face {face}\nend_header\n");
        file("ply", &[head.as_bytes(), data].concat())
    };
    const XYZ: &str = "\nproperty float x\nproperty float y\nproperty float z";
    const CORNERS: &str = "\nproperty list uint int vertex_indices";
    for encoding in ["ascii", "binary_little_endian"] {
        let many = ply(encoding, &format!("2147483648{XYZ}"), &format!("1{CORNERS}"), b"0 0 0\n");
        assert!(many.contains("promises 2147483648 rows of 'vertex'"), "{many}");
        let many = ply(encoding, &format!("0{XYZ}"), &format!("18446744073709551615{CORNERS}"), b"0 0 0\n");
        assert!(many.contains("promises 18446744073709551615 rows of 'face'"), "{many}");
        assert!(ply(encoding, "4000000000", "4000000000", b"").contains("without"));
    }
    let long = ply("binary_little_endian", &format!("0{XYZ}"), &format!("1{CORNERS}"), &[0xFF; 20]);
    assert!(long.contains("byte 168: a list of 4294967295 is longer than the rest of the file"), "{long}");
    let mut stl = vec![0; 84];
    stl[80..].fill(0xFF);
    assert!(file("stl", &stl).contains("says 4294967295 triangles"));
    assert!(MEMORY.peak_usage_as_mb() < MOST_MIB);
}
