//! Shells that are wound opposite to the rest.

use std::collections::BTreeMap;

use super::distribute::divided;
use super::shells::Shells;
use super::tetrahedra::signed_volume;
use super::welded::{Face, first_at, welded};
use super::winding::total;
use super::{MeshSolid, Tally};
use crate::crossing::Crossing;
use crate::math::Vec3;
use crate::ray::{Line, Span};
use crate::scratch::Scratch;

impl MeshSolid {
    /// Returns the shells of a closed mesh that lie outside all others and are wound opposite to the mesh as a whole,
    /// each by its first face. They are solid all the same, since their winding number is not zero. A shell wound the
    /// other way *inside* another is a cavity and not reported.
    pub fn inverted_shells(&self) -> Tally<u32> {
        if !self.is_closed() {
            return Tally::default();
        }
        divided(self.mesh.elements(), || self.find_inverted_shells())
    }

    fn find_inverted_shells(&self) -> Tally<u32> {
        let mesh = &self.mesh;
        let faces = welded(mesh, &first_at(&mesh.vertices));
        let roots = Shells::of(mesh.vertices.len(), &faces).into_roots();
        let mut shell_of_face = vec![u32::MAX; mesh.faces.len()];
        let mut faces_of_shell: BTreeMap<u32, Vec<Face>> = BTreeMap::new();
        for face in faces {
            let shell = roots[face.corners[0] as usize];
            shell_of_face[face.number as usize] = shell;
            faces_of_shell.entry(shell).or_default().push(face);
        }
        let inward = self.topology.signed_volume < 0.0;
        let mut inverted: Vec<u32> = (faces_of_shell.iter())
            .filter(|(_, faces)| self.is_inward(faces) == Some(!inward))
            .filter(|(shell, faces)| {
                let corner = mesh.vertices[faces[0].corners[0] as usize];
                self.winding_at(corner, |face| shell_of_face[face as usize] != **shell) == 0
            })
            .map(|(_, faces)| faces[0].number)
            .collect();
        inverted.sort_unstable();
        inverted.into_iter().collect()
    }

    /// Whether a closed shell is wound inward; `None` if rounding hides the sign of its volume.
    fn is_inward(&self, faces: &[Face]) -> Option<bool> {
        let at = |v: u32| self.size.scale(self.mesh.vertices[v as usize]);
        let volume = signed_volume(faces, |_| faces[0].corners[0], at);
        (volume != 0.0).then_some(volume < 0.0)
    }

    /// Returns the winding number at a point, by the faces that `counts` accepts.
    pub(super) fn winding_at(&self, p: Vec3, counts: impl Fn(u32) -> bool) -> i32 {
        let mut hits: Vec<Crossing> = Vec::new();
        self.hits(&Line::exact(p, Vec3::Z), Span::FORWARD, &mut hits, &mut Scratch::default());
        hits.retain(|hit| counts(hit.primitive));
        -total(&hits)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::Affine;
    use crate::solid::mesh::TriangleMesh;
    use crate::solid::mesh::shapes::{ball, ring, sheet};

    fn inverted(mesh: TriangleMesh) -> Tally<u32> {
        MeshSolid::new(Arc::new(mesh), "bvh").unwrap().inverted_shells()
    }

    fn small(x: f64) -> TriangleMesh {
        ball(1)
            .moved(&Affine::scaling(Vec3::splat(0.25)))
            .moved(&Affine::translation(Vec3::new(x, 0.1, 0.05)))
    }

    #[test]
    fn only_a_shell_outside_of_all_others_is_wound_the_wrong_way() {
        let count = ball(2).faces.len() as u32;
        // A cavity, a nested shell wound like a solid, and a shell in the hole of a ring.
        assert_eq!(inverted(ball(2).with(&small(0.2).inside_out())), Tally::default());
        assert_eq!(inverted(ball(2).with(&small(0.2))), Tally::default());
        assert_eq!(inverted(ring(9, 5).with(&small(0.0))), Tally::default());
        // Outside, both within the box of the rest and beyond it.
        for mesh in [ball(2), ball(2).with(&small(-3.0))] {
            let turned_last = inverted(mesh.clone().with(&small(3.0).inside_out()));
            assert_eq!(turned_last, Tally { count: 1, first: Some(mesh.faces.len() as u32) });
        }
        let in_the_hole = inverted(ring(9, 5).with(&small(0.0).inside_out()));
        assert_eq!(in_the_hole, Tally { count: 1, first: Some(90) });
        // Where nearly all is inward, the shell that is not is reported.
        assert_eq!(inverted(ball(2).inside_out().with(&small(3.0))), Tally { count: 1, first: Some(count) });
    }

    #[test]
    fn neither_flaps_nor_open_meshes_have_turned_shells() {
        assert_eq!(inverted(ball(2).with(&sheet(3)).with(&sheet(3).inside_out())), Tally::default());
        let mut open = ball(2).with(&small(3.0).inside_out());
        open.faces.pop();
        assert_eq!(inverted(open), Tally::default());
    }
}
