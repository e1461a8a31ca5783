//! The meshes that hits are on, alone, transformed, shared and in combinations.

use crate::compile::HitMeshes;
use crate::prelude::*;
use crate::solid::mesh::{Attribute, TriangleMesh};
use crate::testkit::random::Random;

/// A tetrahedron whose attribute is the position of its corners.
fn tetrahedron() -> Shape {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let values = corners.iter().flat_map(|corner| corner.to_array()).collect();
    let mut mesh = TriangleMesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    mesh.attributes.push(Attribute::of_vertices("place", 3, values));
    Shape::triangles(mesh.into()).unwrap()
}

fn ball(radius: f64) -> Shape {
    Shape::sphere(radius).unwrap()
}

#[test]
fn hits_find_their_mesh_and_their_place_on_it() {
    let part = tetrahedron();
    let turned = part.scale(3.0).rotate(Vec3::new(20.0, 30.0, 40.0)).translate(Vec3::new(2.0, 0.0, 1.0));
    let drilled = (part.translate(Vec3::X) - ball(0.2)) | part.translate(Vec3::new(0.3, 0.0, 4.0));
    let scene = Scene::of([
        Object::new("alone", &part),
        Object::new("turned", turned),
        Object::new("drilled", drilled.scale(2.0).translate(Vec3::new(0.0, 5.0, 0.0))),
        Object::new("ball", ball(0.5).translate(Vec3::new(-2.0, 0.0, 0.0))),
    ]);
    let world = scene.compile().unwrap();
    let (mut caster, mut random, mut meshes) = (Caster::new(&world), Random::new(5), HitMeshes::new(&world));
    let (mut met, mut hits) = ([0; 4], Vec::new());
    for _ in 0..4000 {
        let (from, to) = (random.direction() * 20.0, random.point(-2.0, 6.0));
        let Ok(ray) = Ray::new(from, to - from) else { continue };
        hits.clear();
        caster.crossings(&ray, Span::FORWARD, &mut hits).unwrap();
        for hit in &hits {
            met[hit.object as usize] += 1;
            let mesh = meshes.get(hit.surface.unwrap(), hit.path);
            let Some(primitive) = hit.primitive else {
                assert!(mesh.is_none());
                continue;
            };
            let mesh = mesh.unwrap();
            let point = ray.at(hit.t);
            let [a, b, c] = mesh.barycentric(primitive, point);
            let [second, third] = hit.barycentric.unwrap();
            assert!((a + b + c - 1.0).abs() < 1e-12 && (b - second).abs() + (c - third).abs() < 1e-9);
            let mut place = [0.0; 3];
            mesh.interpolate(mesh.mesh().attribute("place").unwrap(), primitive, point, &mut place);
            let corners = mesh.mesh().corners(primitive);
            let weighted = corners[0] * a + corners[1] * b + corners[2] * c;
            assert!((Vec3::from(place) - weighted).length() < 1e-12);
        }
    }
    assert!(met.iter().all(|count| *count > 40), "{met:?}");
    assert!(meshes.get(u32::MAX, 0).is_none() && meshes.get(0, u64::MAX).is_none());
    assert!(world.has_attribute("place") && !world.has_attribute("color"));
}
