//! 3MF files that are read: objects, components, build items, materials and colours.

mod package;
mod reading;

use package::{RELS, TETRAHEDRON, model, package, tetrahedron, zip};
use reading::{ok, refused};
use shotline::compile::compile;
use shotline::math::Vec3;
use shotline::query::Caster;
use shotline::ray::{Ray, Span};
use shotline::scene::{Node, Scene, Units};
use shotline::solid::mesh::TriangleMesh;
use shotline_io::{Document, FORMATS};

fn objects(scene: &Scene) -> Vec<(&str, Option<&str>)> {
    let mut found = Vec::new();
    for node in &scene.nodes {
        if let Node::Object { name, material, .. } = node {
            found.push((name.as_str(), material.as_deref()));
        }
    }
    found
}

fn meshes(scene: &Scene) -> Vec<&TriangleMesh> {
    let mut found = Vec::new();
    for node in &scene.nodes {
        if let Node::Mesh { mesh, .. } = node {
            found.push(mesh.as_ref());
        }
    }
    found
}

fn kinds(document: &Document) -> Vec<(&'static str, usize)> {
    document.notes.iter().map(|note| (note.kind, note.count)).collect()
}

#[test]
fn items_place_shared_objects() {
    let text = model(
        &tetrahedron(7, "name=\"part\""),
        "<item objectid=\"7\"/><item objectid=\"7\" transform=\"0 2 0 -2 0 0 0 0 2 10 20 30\"/>",
    );
    let document = ok("part.3mf", package(&text));
    assert_eq!(objects(&document.scene), [("part", None)]);
    assert_eq!((meshes(&document.scene).len(), document.scene.objects.len()), (1, 2));
    assert_eq!((document.scene.units, document.notes.len()), (Some(Units::Millimetres), 0));
    let Node::Transform { transform, .. } = document.scene.node(document.scene.objects[1]) else {
        panic!("a transform")
    };
    // A row of the file is the image of an axis: x becomes 2 y.
    let placed = transform.inside(&shotline::math::ComposedTransform::IDENTITY).placement().unwrap();
    let image = placed.parent_from_local.point(Vec3::new(1.0, 0.0, 0.0));
    assert_eq!(image, Vec3::new(10.0, 22.0, 30.0));
    compile(&document.scene, Default::default()).unwrap();
}

#[test]
fn units_are_kept() {
    for (name, units) in [
        ("micron", Units::Micrometres),
        ("centimeter", Units::Centimetres),
        ("inch", Units::Inches),
        ("foot", Units::Feet),
        ("meter", Units::Metres),
    ] {
        let text = model(&tetrahedron(1, ""), "<item objectid=\"1\"/>").replace("millimeter", name);
        assert_eq!(ok("part.3mf", package(&text)).scene.units, Some(units));
    }
    let text = model(&tetrahedron(1, ""), "<item objectid=\"1\"/>").replace("unit=\"millimeter\"", "");
    assert_eq!(ok("part.3mf", package(&text)).scene.units, Some(Units::Millimetres));
}

#[test]
fn components_are_shared_objects_in_groups() {
    let resources = [
        tetrahedron(1, "name=\"tip\""),
        tetrahedron(2, ""),
        "<object id=\"3\" name=\"pair\"><components><component objectid=\"1\"/>\
         <component objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 5 0 0\"/></components></object>"
            .into(),
        "<object id=\"4\" name=\"pairs\"><components><component objectid=\"3\"/>\
         <component objectid=\"3\" transform=\"1 0 0 0 1 0 0 0 1 0 5 0\"/></components></object>"
            .into(),
        "<object id=\"5\" name=\"alone\"><components>\
         <component objectid=\"6\" transform=\"1 0 0 0 1 0 0 0 1 0 0 50\"/></components></object>"
            .into(),
        tetrahedron(6, ""),
    ]
    .join("\n");
    let text = model(
        &resources,
        "<item objectid=\"4\"/><item objectid=\"3\" transform=\"1 0 0 0 1 0 0 0 1 0 0 9\"/>\
        <item objectid=\"5\"/>",
    );
    let document = ok("part.3mf", package(&text));
    let names: Vec<&str> = objects(&document.scene).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["tip", "object2", "pairs", "pair", "alone"]);
    assert_eq!((meshes(&document.scene).len(), document.scene.objects.len()), (3, 3));
    let world = compile(&document.scene, Default::default()).unwrap();
    let mut caster = Caster::new(&world);
    let ray = Ray::new(Vec3::new(5.125, 5.125, -1.0), Vec3::Z).unwrap();
    let hit = caster.closest(&ray, Span::FORWARD).unwrap();
    assert_eq!(hit.unwrap().t, 1.0);
}

#[test]
fn materials_and_colours_are_kept() {
    let groups = "<basematerials id=\"10\"><base name=\"PLA\" displaycolor=\"#FF0000\"/>\
        <base name=\"PLA\" displaycolor=\"#00FF0080\"/></basematerials>\n\
        <m:colorgroup id=\"11\"><m:color color=\"#0000FF\"/><m:color color=\"#FFFFFF00\"/></m:colorgroup>\n\
        <m:texture2d id=\"13\" path=\"/a.png\" contenttype=\"image/png\"/>\n<m:texture2dgroup id=\"12\" texid=\"13\"/>";
    let painted = |of_first: &str| TETRAHEDRON.replacen("v3=\"1\"/>", &format!("v3=\"1\" {of_first}/>"), 1);
    let all = |of_each: &str| {
        TETRAHEDRON
            .replace("\"/><triangle", &format!("\" {of_each}/><triangle"))
            .replace("\"/></triangles>", &format!("\" {of_each}/></triangles>"))
    };
    let object =
        |id: u32, attributes: &str, mesh: &str| format!("<object id=\"{id}\" {attributes}>{mesh}</object>");
    let resources = [
        groups.to_owned(),
        object(1, "pid=\"10\" pindex=\"1\"", TETRAHEDRON),
        object(2, "pid=\"10\" pindex=\"0\"", &painted("pid=\"11\" p1=\"0\" p2=\"1\" p3=\"0\"")),
        object(3, "", &all("pid=\"11\" p1=\"1\"")),
        object(4, "", &painted("pid=\"12\" p1=\"7\"")),
        object(5, "pid=\"10\" pindex=\"1\"", TETRAHEDRON),
    ]
    .join("\n");
    let build: String = (1..=5).map(|id| format!("<item objectid=\"{id}\"/>")).collect();
    let document = ok("part.3mf", package(&model(&resources, &build)));
    let materials: Vec<Option<&str>> = objects(&document.scene).into_iter().map(|(_, m)| m).collect();
    assert_eq!(materials, [Some("PLA"), Some("PLA_2"), Some("#FFFFFF"), None, Some("PLA")]);
    let colors: Vec<_> =
        document.scene.materials.iter().map(|(_, material)| material.color.unwrap()).collect();
    assert_eq!(colors, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0; 3]]);
    let found = meshes(&document.scene);
    let color = found[1].attribute("color").unwrap();
    let value = |face, corner| found[1].corner_value(color, face, corner).unwrap().to_vec();
    assert_eq!(value(0, 0), [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(value(0, 1), [1.0, 1.0, 1.0, 0.0]);
    assert_eq!(value(3, 2), [1.0, 0.0, 0.0, 1.0]);
    assert!([0, 2, 3, 4].iter().all(|i| found[*i].attributes.is_empty()));
    assert_eq!(kinds(&document), [("resources_not_read", 2), ("properties_not_read", 1)]);
}

#[test]
fn supports_are_left_out_and_noted() {
    let resources = [
        tetrahedron(1, ""),
        tetrahedron(2, "type=\"support\""),
        tetrahedron(3, "type=\"other\""),
        tetrahedron(4, "type=\"surface\""),
    ]
    .join("\n");
    let build: String = (1..=4).map(|id| format!("<item objectid=\"{id}\"/>")).collect();
    let document = ok("part.3mf", package(&model(&resources, &build)));
    assert_eq!(objects(&document.scene).len(), 2);
    assert_eq!(kinds(&document), [("supports", 2)]);
    let shown = document.notes[0].to_string();
    assert!(shown.starts_with("part.3mf/3D/3dmodel.model: 2 objects that support"), "{shown}");
    assert!(shown.ends_with("the first on line 9"), "{shown}");
}

#[test]
fn objects_in_other_model_parts_are_read() {
    let main = model(
        "<object id=\"1\"><components><component objectid=\"1\" p:path=\"/3D/Objects/a.model\"/></components></object>",
        "<item objectid=\"1\"/><item objectid=\"2\" p:path=\"3D/Objects/a.model\"/>",
    )
    .replace("<model ", "<model requiredextensions=\"p m\" ");
    let other = model(&[tetrahedron(1, "name=\"far\""), tetrahedron(2, "")].join("\n"), "");
    let file = |other: &str| {
        zip(&[
            ("_rels/.rels", RELS.as_bytes()),
            ("3D/3dmodel.model", main.as_bytes()),
            ("3D/objects/A.model", other.as_bytes()),
        ])
    };
    let document = ok("part.3mf", file(&other));
    let names: Vec<&str> = objects(&document.scene).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["far", "object2"]);
    refused("part.3mf", file(&other.replace("v1=\"2\"", "v1=\"9\"")), "part.3mf/3D/Objects/a.model:4:");
    refused("part.3mf", file(&other.replace("id=\"2\"", "id=\"3\"")), "part.3mf/3D/3dmodel.model:6:");
}

#[test]
fn the_contents_tell_the_format() {
    let bytes = package(&model(&tetrahedron(1, ""), "<item objectid=\"1\"/>"));
    let found = FORMATS.iter().find(|format| (format.detect)(&bytes)).map(|format| format.name);
    assert_eq!(found, Some("3MF"));
    assert_eq!(objects(&ok("-", bytes).scene).len(), 1);
}

#[test]
fn a_bomb_is_refused() {
    // 40 MB of white space shrink to 40 kB.
    let text = model(&tetrahedron(1, ""), "<item objectid=\"1\"/>")
        .replace("<build>", &(" ".repeat(40 << 20) + "<build>"));
    refused("part.3mf", package(&text), "the parts that are needed unpack to more than");
}

#[test]
fn doubling_components_take_no_more_memory_than_the_file() {
    let mut resources = vec![tetrahedron(1, "")];
    for id in 2..60 {
        let part = format!("<component objectid=\"{}\"/>", id - 1);
        resources.push(format!("<object id=\"{id}\"><components>{part}{part}</components></object>"));
    }
    let document = ok("part.3mf", package(&model(&resources.join("\n"), "<item objectid=\"59\"/>")));
    assert!(document.scene.nodes.len() < 100);
}
