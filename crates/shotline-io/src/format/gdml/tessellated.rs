//! Tessellated solids: closed meshes of triangles and quadrangles.

use std::collections::HashMap;
use std::sync::Arc;

use shotline::math::Vec3;
use shotline::scene::{Node, NodeId};

use super::attributes::Found;
use super::{Element, Module, elements, tag};
use crate::note::{Effect, Note};
use crate::polygon::mesh_of_polygons;

impl Module<'_> {
    /// Facets name their corners, which are positions; facets of the type RELATIVE give all but the first relative to it.
    pub(super) fn tessellated(&mut self, element: Element) -> Found<NodeId> {
        let mut vertices: Vec<Vec3> = Vec::new();
        let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
        let mut facets: Vec<Vec<u32>> = Vec::new();
        for facet in elements(element) {
            let keys = match tag(facet) {
                "triangular" => &["vertex1", "vertex2", "vertex3"][..],
                "quadrangular" => &["vertex1", "vertex2", "vertex3", "vertex4"][..],
                other => {
                    let message = format!("<{other}> has no meaning in <tessellated>");
                    let help = "it has <triangular> and <quadrangular> facets";
                    return Err(self.report(facet, None, message, help));
                }
            };
            let mut corners = self.corners(facet, keys)?;
            if facet.attribute("type") == Some("RELATIVE") {
                let first = corners[0];
                corners[1..].iter_mut().for_each(|corner| *corner += first);
            }
            let mut number = |corner: Vec3| {
                // The addition makes zeros equal.
                let bits = (corner + Vec3::ZERO).to_array().map(f64::to_bits);
                *numbers.entry(bits).or_insert_with(|| {
                    vertices.push(corner);
                    (vertices.len() - 1) as u32
                })
            };
            facets.push(corners.into_iter().map(&mut number).collect());
        }
        if has_open_edges(&facets) {
            merge_within(TOLERANCE, &vertices, &mut facets);
        }
        // It has no inside, so queries for segments would refuse the whole model.
        if self.reader.options.partial && has_open_edges(&facets) {
            return Err(self.unsupported(element, "tessellated solids that are not closed"));
        }
        let turned = orient(&vertices, &mut facets);
        let (mesh, notes) = match mesh_of_polygons(vertices, facets.iter().map(|facet| &facet[..])) {
            Ok(made) => made,
            Err(error) => {
                let help = "give it facets whose corners are defined positions";
                return Err(self.report(element, None, error.to_string(), help));
            }
        };
        let name = self.name(element)?;
        if turned > 0 {
            let text = format!("{turned} facets of '{name}' that faced inwards were turned over");
            self.reader.notes.push(Note::new("facets_turned", Effect::Changed, turned, text));
        }
        self.reader.notes.extend(notes.into_iter().filter(|note| note.effect == Effect::Changed));
        Ok(self.add(element, Node::Mesh { mesh: Arc::new(mesh), file: None }))
    }
}

/// Geant4 joins corners up to about this distance apart, in millimetres.
const TOLERANCE: f64 = 1e-8;

fn has_open_edges(facets: &[Vec<u32>]) -> bool {
    let mut counts: HashMap<[u32; 2], usize> = HashMap::new();
    for [a, b] in facets.iter().flat_map(|facet| sides(facet)) {
        *counts.entry([a.min(b), a.max(b)]).or_default() += 1;
    }
    counts.values().any(|count| count % 2 == 1)
}

/// Makes facets share the corners that are near each other, and drops those of which fewer than three corners are left.
fn merge_within(distance: f64, vertices: &[Vec3], facets: &mut Vec<Vec<u32>>) {
    let mut by_x: Vec<u32> = (0..vertices.len() as u32).collect();
    let at = |number: u32| vertices[number as usize];
    by_x.sort_by(|&a, &b| at(a).x.total_cmp(&at(b).x));
    let mut merged: Vec<u32> = (0..vertices.len() as u32).collect();
    let mut first = 0;
    for (place, &number) in by_x.iter().enumerate() {
        while at(number).x - at(by_x[first]).x > distance {
            first += 1;
        }
        let near = by_x[first..place]
            .iter()
            .find(|&&other| (at(other) - at(number)).abs().max_element() <= distance);
        if let Some(&near) = near {
            merged[number as usize] = merged[near as usize];
        }
    }
    for facet in facets.iter_mut() {
        facet.iter_mut().for_each(|corner| *corner = merged[*corner as usize]);
        facet.dedup();
        if facet.first() == facet.last() {
            facet.pop();
        }
    }
    facets.retain(|facet| facet.len() >= 3);
}

/// Turns facets over so that neighbours agree and the volume is positive. Returns how many were turned. Facets that do not meet
/// their neighbours in pairs are left as they are.
fn orient(vertices: &[Vec3], facets: &mut [Vec<u32>]) -> usize {
    let mut edges: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    for (number, facet) in facets.iter().enumerate() {
        for [a, b] in sides(facet) {
            edges.entry([a.min(b), a.max(b)]).or_default().push(number);
        }
    }
    let mut turned = vec![None; facets.len()];
    for first in 0..facets.len() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        let (mut part, mut next) = (vec![first], 0);
        while let Some(&facet) = part.get(next) {
            next += 1;
            for [a, b] in sides(&facets[facet]) {
                let [one, other] = edges[&[a.min(b), a.max(b)]][..] else { continue };
                let neighbour = if one == facet { other } else { one };
                if turned[neighbour].is_some() || neighbour == facet {
                    continue;
                }
                // Neighbours agree if they run along their common side in opposite directions.
                let disagree = sides(&facets[neighbour]).any(|side| side == [a, b]);
                turned[neighbour] = Some((turned[facet] == Some(true)) != disagree);
                part.push(neighbour);
            }
        }
        let volume: f64 = part.iter().map(|&facet| volume(vertices, &facets[facet], turned[facet])).sum();
        if volume < 0.0 {
            part.iter().for_each(|&facet| turned[facet] = turned[facet].map(|turned| !turned));
        }
    }
    for (facet, _) in facets.iter_mut().zip(&turned).filter(|(_, turned)| **turned == Some(true)) {
        facet.reverse();
    }
    turned.iter().filter(|turned| **turned == Some(true)).count()
}

/// The sides of a facet, in its order.
fn sides(facet: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0..facet.len()).map(|i| [facet[i], facet[(i + 1) % facet.len()]])
}

/// Six times the volume between a facet and the first vertex.
fn volume(vertices: &[Vec3], facet: &[u32], turned: Option<bool>) -> f64 {
    let corner = |i: usize| vertices[facet[i] as usize] - vertices[0];
    let sum: f64 = (1..facet.len() - 1).map(|i| corner(0).dot(corner(i).cross(corner(i + 1)))).sum();
    if turned == Some(true) { -sum } else { sum }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_that_differ_by_rounding_are_joined() {
        let vertices =
            [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::X * (1.0 + 1e-12), Vec3::Y + Vec3::splat(5e-9)];
        let mut facets = vec![vec![0, 2, 1], vec![0, 4, 3], vec![1, 5, 3], vec![2, 0, 3], vec![1, 4, 3]];
        assert!(has_open_edges(&facets));
        merge_within(TOLERANCE, &vertices, &mut facets);
        assert!(facets.len() == 4 && !has_open_edges(&facets), "{facets:?}");
    }

    #[test]
    fn facets_that_face_inwards_are_turned_over() {
        let vertices = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let good = [vec![0, 2, 1], vec![0, 1, 3], vec![1, 2, 3], vec![2, 0, 3]];
        for wrong in 0..16_usize {
            let mut facets = good.to_vec();
            let is_wrong = |i: usize| wrong >> i & 1 == 1;
            (0..4).filter(|i| is_wrong(*i)).for_each(|i| facets[i].reverse());
            assert_eq!(orient(&vertices, &mut facets), wrong.count_ones() as usize);
            // The same up to the corner with which it begins.
            for (facet, good) in facets.iter().zip(&good) {
                assert!((0..3).any(|shift| (0..3).all(|i| facet[(i + shift) % 3] == good[i])), "{wrong}");
            }
        }
    }
}
