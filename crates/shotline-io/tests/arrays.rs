//! Writing columns to `.npz` and reading rays from `.npy`.

use std::io::Read;

use shotline_io::arrays::{Column, read_rays, write_npz};

/// The bytes of one array of an archive.
fn entry(path: &std::path::Path, name: &str) -> Vec<u8> {
    let mut archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn columns_are_written_as_numpy_reads_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.npz");
    let names = vec!["ball".to_string(), "größe😀".into(), String::new()];
    let columns = [
        ("t", Column::F64(&[1.5, f64::INFINITY])),
        ("normal", Column::Vec3(&[[0.0, 0.0, 1.0], [f64::NAN; 3]])),
        ("thickness", Column::Rows { width: 2, values: &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0] }),
        ("ray_splits", Column::I64(&[0, 2])),
        ("object", Column::I32(&[-1, 7])),
        ("kind", Column::I8(&[0, -2])),
        ("entering", Column::Bool(&[true, false])),
        ("object_names", Column::Text(&names)),
        ("empty", Column::F64(&[])),
        ("empty_names", Column::Text(&[])),
    ];
    write_npz(&path, &columns).unwrap();
    let expected = [
        ("t", "'<f8'", "(2,)", 16),
        ("normal", "'<f8'", "(2, 3,)", 48),
        ("thickness", "'<f8'", "(3, 2,)", 48),
        ("ray_splits", "'<i8'", "(2,)", 16),
        ("object", "'<i4'", "(2,)", 8),
        ("kind", "'|i1'", "(2,)", 2),
        ("entering", "'|b1'", "(2,)", 2),
        ("object_names", "'<U6'", "(3,)", 72),
        ("empty", "'<f8'", "(0,)", 0),
        ("empty_names", "'<U1'", "(0,)", 0),
    ];
    for (name, descr, shape, size) in expected {
        let bytes = entry(&path, name);
        let head = String::from_utf8_lossy(&bytes[10..bytes.len() - size]).into_owned();
        assert!(
            head.contains(&format!("'descr': {descr}, 'fortran_order': False, 'shape': {shape}")),
            "{head}"
        );
        assert!(head.ends_with('\n') && (bytes.len() - size).is_multiple_of(64));
    }
    assert_eq!(entry(&path, "object")[128..], [255, 255, 255, 255, 7, 0, 0, 0]);
    assert_eq!(entry(&path, "kind")[128..], [0, 254]);
    assert_eq!(entry(&path, "object_names")[128 + 24..128 + 28], u32::from('g').to_le_bytes());
}

#[test]
fn files_that_are_not_arrays_of_rays_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.npz");
    write_npz(&path, &[("t", Column::F64(&[1.0]))]).unwrap();
    let shown = read_rays(&path).unwrap_err().to_string();
    assert!(
        shown.contains("out.npz: byte 0: this is not a .npy file\nhelp: write the rays with numpy.save"),
        "{shown}"
    );
    assert!(read_rays(folder.path().join("none.npy")).unwrap_err().to_string().contains("cannot be read"));
}
