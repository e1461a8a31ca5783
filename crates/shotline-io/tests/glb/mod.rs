//! Builds glTF files from accessors and JSON.
#![allow(dead_code)]

use serde_json::{Value, json};

/// A file while it is built: the bytes of its buffer, and the lists that describe them.
#[derive(Clone, Default)]
pub struct Glb {
    pub bin: Vec<u8>,
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
}

impl Glb {
    /// Adds bytes as a buffer view.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() }));
        self.bin.extend_from_slice(bytes);
        self.views.len() - 1
    }

    /// Adds an accessor of float32 values.
    pub fn floats(&mut self, kind: &str, width: usize, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(5126, kind, numbers.len() / width, &bytes)
    }

    /// Adds an accessor of uint16 indices.
    pub fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(5123, "SCALAR", indices.len(), &bytes)
    }

    /// Adds an accessor of these bytes.
    pub fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.accessors
            .push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    /// The JSON of the file, with these keys besides those of the buffer.
    pub fn json(&self, keys: Value) -> Value {
        let mut whole = json!({
            "asset": { "version": "2.0" },
            "buffers": [{ "byteLength": self.bin.len() }],
            "bufferViews": self.views,
            "accessors": self.accessors,
        });
        for (key, value) in keys.as_object().into_iter().flatten() {
            whole[key] = value.clone();
        }
        whole
    }

    /// The bytes of a GLB file.
    pub fn file(&self, keys: Value) -> Vec<u8> {
        pack(&self.json(keys).to_string(), &self.bin)
    }
}

/// A GLB file of two chunks.
pub fn pack(json: &str, bin: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], fill: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), fill);
        bytes
    };
    let (json, bin) = (padded(json.as_bytes(), b' '), padded(bin, 0));
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(((28 + json.len() + bin.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", bin)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

/// The sides of a cube from 0 to 1: the corners of each, counter-clockwise seen from outside, and its normal.
pub const SIDES: [([[f32; 3]; 4], [f32; 3]); 6] = [
    ([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]], [0.0, 0.0, -1.0]),
    ([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]], [0.0, 0.0, 1.0]),
    ([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]], [0.0, -1.0, 0.0]),
    ([[0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0]], [0.0, 1.0, 0.0]),
    ([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0]], [-1.0, 0.0, 0.0]),
    ([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]], [1.0, 0.0, 0.0]),
];

/// Adds a cube as exporters write it, with 24 vertices; returns its attributes and the accessor of its indices.
pub fn cube(glb: &mut Glb) -> (Value, usize) {
    let corners: Vec<f32> = SIDES.iter().flat_map(|(corners, _)| corners.concat()).collect();
    let normals: Vec<f32> = SIDES.iter().flat_map(|(_, normal)| normal.repeat(4)).collect();
    let uv = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0].repeat(6);
    let attributes = json!({
        "POSITION": glb.floats("VEC3", 3, &corners),
        "NORMAL": glb.floats("VEC3", 3, &normals),
        "TEXCOORD_0": glb.floats("VEC2", 2, &uv),
    });
    (attributes, glb.indices(&indices(6)))
}

/// The indices of so many sides of four corners.
pub fn indices(sides: u16) -> Vec<u16> {
    (0..sides).flat_map(|side| [0, 1, 2, 0, 2, 3].map(|corner| 4 * side + corner)).collect()
}

/// A file of one cube, with these keys besides.
pub fn cube_file(keys: Value) -> Vec<u8> {
    let mut glb = Glb::default();
    let (attributes, indices) = cube(&mut glb);
    let mut whole = json!({
        "meshes": [{ "name": "cube", "primitives": [{ "attributes": attributes, "indices": indices }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    });
    for (key, value) in keys.as_object().into_iter().flatten() {
        whole[key] = value.clone();
    }
    glb.file(whole)
}
