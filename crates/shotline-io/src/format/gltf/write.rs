//! A scene to glTF: a root node that turns and scales it, below it a node for each object, and meshes that nodes share.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};
use shotline::math::{Affine, Vec3};
use shotline::scene::{Material, Scene, Units};
use shotline::solid::mesh::TriangleMesh;

use super::base64::encode;
use super::color::linear;
use super::container::glb;
use crate::error::WriteError;
use crate::format::WrittenScene;
use crate::format::instances::{Instance, instances, used_vertices};

/// Types of numbers, and what buffers are for, by the constants of OpenGL.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The accessors of a mesh: its positions and its indices.
type Accessors = [usize; 2];

/// The writer, with the lists of the file so far.
#[derive(Default)]
struct Writer<'s> {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
    material_numbers: HashMap<&'s str, usize>,
    /// The accessors of the meshes that are written.
    written: HashMap<*const TriangleMesh, Accessors>,
    /// The numbers of meshes in the file, by mesh and material.
    mesh_numbers: HashMap<(Accessors, Option<usize>), usize>,
    vertices: usize,
    /// How many vertices are rounded, and by how much at most.
    rounded: usize,
    largest: f64,
}

/// Writes a GLB, or a text if the file is called so.
pub(super) fn write(path: &Path, scene: &Scene) -> Result<WrittenScene, WriteError> {
    let (objects, mut notes) = instances(scene, "glTF")?;
    let mut writer = Writer::default();
    scene.materials.iter().for_each(|(name, material)| writer.add_material(name, material));
    writer.nodes.push(Value::Null);
    for object in &objects {
        writer.add(object)?;
    }
    let children: Vec<usize> = (1..writer.nodes.len()).collect();
    writer.nodes[0] = json!({ "matrix": y_up_metres(scene.units), "children": children });
    notes.push(frame_note(scene.units));
    if writer.rounded > 0 {
        let (rounded, all, largest) = (writer.rounded, writer.vertices, writer.largest);
        notes.push(format!("vertices rounded to float32: {rounded} of {all}, by at most {largest:.1e}"));
    }
    let is_text = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gltf"));
    Ok(WrittenScene { bytes: writer.file(is_text)?, notes })
}

/// Metres in a unit of length.
fn metres(units: Option<Units>) -> f64 {
    match units {
        None | Some(Units::Metres) => 1.0,
        Some(Units::Nanometres) => 1e-9,
        Some(Units::Micrometres) => 1e-6,
        Some(Units::Millimetres) => 1e-3,
        Some(Units::Centimetres) => 1e-2,
        Some(Units::Kilometres) => 1e3,
        Some(Units::Inches) => 0.0254,
        Some(Units::Feet) => 0.3048,
    }
}

/// The transform from a scene, in which z is up, to glTF: metres, in which y is up.
fn y_up_metres(units: Option<Units>) -> [f64; 16] {
    let s = metres(units);
    matrix(&Affine { rows: [[s, 0.0, 0.0, 0.0], [0.0, 0.0, s, 0.0], [0.0, -s, 0.0, 0.0]] })
}

fn frame_note(units: Option<Units>) -> String {
    let turned = "z is up in the scene, y in glTF: the root node turns it";
    match units {
        None => format!("{turned}; the scene has no units: its lengths are written as metres"),
        Some(Units::Metres) => turned.into(),
        Some(units) => format!("{turned}, and scales {units} to metres"),
    }
}

/// The 16 numbers of a matrix, column by column.
fn matrix(affine: &Affine) -> [f64; 16] {
    let [x, y, z] = affine.rows;
    std::array::from_fn(|i| [x, y, z, [0.0, 0.0, 0.0, 1.0]][i % 4][i / 4])
}

impl<'s> Writer<'s> {
    fn add_material(&mut self, name: &'s str, Material { color, .. }: &Material) {
        // Without these a viewer shows metal.
        let mut surface = json!({ "metallicFactor": 0.0, "roughnessFactor": 1.0 });
        if let Some(color) = color {
            let [red, green, blue] = color.map(linear);
            surface["baseColorFactor"] = json!([red, green, blue, 1.0]);
        }
        self.material_numbers.insert(name, self.materials.len());
        self.materials.push(json!({ "name": name, "pbrMetallicRoughness": surface }));
    }

    fn add(&mut self, object: &Instance<'s>) -> Result<(), WriteError> {
        let material = object.material.map(|name| {
            if !self.material_numbers.contains_key(name) {
                self.add_material(name, &Material::default());
            }
            self.material_numbers[name]
        });
        let accessors = match self.written.get(&Arc::as_ptr(&object.mesh)) {
            Some(known) => *known,
            None => self.add_mesh(object)?,
        };
        let mesh = *self.mesh_numbers.entry((accessors, material)).or_insert_with(|| {
            let [positions, indices] = accessors;
            let mut primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
            if let Some(material) = material {
                primitive["material"] = json!(material);
            }
            self.meshes.push(json!({ "name": object.name, "primitives": [primitive] }));
            self.meshes.len() - 1
        });
        let mut node = json!({ "name": object.name, "mesh": mesh });
        if !object.world_from_local.is_identity() {
            node["matrix"] = json!(matrix(&object.world_from_local));
        }
        self.nodes.push(node);
        Ok(())
    }

    fn add_mesh(&mut self, object: &Instance) -> Result<Accessors, WriteError> {
        let (vertices, faces) = used_vertices(&object.mesh);
        let (mut least, mut most) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        let first = self.buffer.len();
        for vertex in &vertices {
            let rounded = vertex.to_array().map(|x| x as f32);
            if !rounded.iter().all(|x| x.is_finite()) {
                let name = object.name;
                let message =
                    format!("object '{name}' has a vertex beyond the largest float32, which glTF holds");
                return Err(WriteError::Unwritable(message));
            }
            for (i, x) in rounded.into_iter().enumerate() {
                (least[i], most[i]) = (least[i].min(x), most[i].max(x));
                self.buffer.extend(x.to_le_bytes());
            }
            let distance = (Vec3::from_array(rounded.map(f64::from)) - *vertex).length();
            self.rounded += usize::from(distance > 0.0);
            self.largest = self.largest.max(distance);
        }
        self.vertices += vertices.len();
        let view = self.view(first, VERTICES);
        let positions = self.accessors.len();
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": vertices.len(), "type": "VEC3",
            "min": least.map(f64::from), "max": most.map(f64::from),
        }));
        let first = self.buffer.len();
        self.buffer.extend(faces.iter().flatten().flat_map(|vertex| vertex.to_le_bytes()));
        let view = self.view(first, INDICES);
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": 3 * faces.len(), "type": "SCALAR",
        }));
        let accessors = [positions, positions + 1];
        self.written.insert(Arc::as_ptr(&object.mesh), accessors);
        Ok(accessors)
    }

    /// Adds a view of the buffer from a byte to its end.
    fn view(&mut self, first: usize, target: u32) -> usize {
        let length = self.buffer.len() - first;
        self.views.push(json!({ "buffer": 0, "byteOffset": first, "byteLength": length, "target": target }));
        self.views.len() - 1
    }

    /// The bytes of the file: a text, which holds the buffer, or a GLB.
    fn file(self, is_text: bool) -> Result<Vec<u8>, WriteError> {
        let mut buffer = json!({ "byteLength": self.buffer.len() });
        if is_text {
            buffer["uri"] = json!(format!("data:application/octet-stream;base64,{}", encode(&self.buffer)));
        }
        let mut root = json!({
            "asset": { "version": "2.0", "generator": "shotline" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [buffer],
        });
        // Lists must not be empty.
        if !self.materials.is_empty() {
            root["materials"] = Value::Array(self.materials);
        }
        let text = root.to_string();
        if is_text {
            return Ok(text.into_bytes());
        }
        let too_large = || WriteError::Unwritable("a GLB has at most 4294967295 bytes".into());
        glb(text.as_bytes(), &self.buffer).ok_or_else(too_large)
    }
}
