//! Pictures in the colours of vertices.

use shotline::prelude::*;
use shotline::query::batch::Run;
use shotline::scene::{Camera, Lens, Light, LightSource};
use shotline::solid::mesh::{Attribute, NO_ROW, TriangleMesh};
use shotline_render::{Settings, render};

/// The colours along the diagonal of a picture of a square, lit from everywhere, seen along z.
fn diagonal(attribute: Attribute, combined: bool) -> Vec<[f32; 4]> {
    let corner = |i: u32| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1));
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mut mesh = TriangleMesh::new((0..8).map(corner).collect(), faces);
    mesh.attributes.push(attribute);
    let cube = Shape::triangles(mesh.into()).unwrap();
    let far = Shape::sphere(0.1).unwrap().translate([0.0, 0.0, -9.0]);
    let shape = if combined { &cube | &far } else { cube };
    let mut scene = Scene::of([Object::new("cube", shape.scale(2.0))]);
    scene.lights = vec![Light { source: LightSource::Ambient, color: None, intensity: Some(1.0) }];
    let lens = Lens::Orthographic { height: 2.0 };
    let target = Vec3::new(1.0, 1.0, 0.0);
    scene.camera = Some(Camera { eye: target + Vec3::Z * 9.0, target, up: Vec3::Y, lens });
    let world = scene.compile().unwrap();
    let settings = Settings { width: 4, height: 4, samples: 1, ..Settings::default() };
    let image = render(&world, &scene, &settings, Run::default()).unwrap();
    (0..4).map(|i| image.pixel(i, i)).collect()
}

#[test]
fn a_mesh_has_the_colours_of_its_vertices() {
    // Red grows along x, green along y.
    let colors = (0..8).flat_map(|i| [f64::from(i & 1), f64::from(i >> 1 & 1), 0.0]).collect();
    let of_vertices = Attribute::of_vertices("color", 3, colors);
    let seen = diagonal(of_vertices.clone(), false);
    // Pixels hold linear light; a sample is not quite in the middle of its pixel.
    for (pixel, linear) in seen.iter().zip([0.0144, 0.1160, 0.3486, 0.7390_f32]) {
        assert!((pixel[0] - linear).abs() < 2e-3 && pixel[2] == 0.0, "{seen:?}");
    }
    let turned: Vec<f32> = seen.iter().rev().map(|pixel| pixel[1]).collect();
    assert!(seen.iter().zip(turned).all(|(pixel, green)| (pixel[0] - green).abs() < 2e-3), "{seen:?}");
    assert_eq!(diagonal(of_vertices.clone(), true), seen);
    // Without a colour a corner leaves the colour of the object.
    let none = Attribute { corners: Some(vec![[NO_ROW; 3]; 12]), ..of_vertices };
    let plain = diagonal(none, false);
    assert!(plain.iter().all(|pixel| *pixel == plain[0] && pixel[2] > pixel[0]), "{plain:?}");
}
