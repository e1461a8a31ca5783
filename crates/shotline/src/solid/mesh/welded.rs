//! A mesh with its exactly coincident vertices welded.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::TriangleMesh;
use super::distribute::{CHUNK, Groups, divided};
use crate::math::Vec3;

/// Returns for each vertex the first vertex at exactly the same position.
pub(super) fn first_at(vertices: &[Vec3]) -> Vec<u32> {
    divided(vertices.len(), || find_first_at(vertices))
}

fn find_first_at(vertices: &[Vec3]) -> Vec<u32> {
    let bits = (vertices.len() / 2048).max(1).ilog2().min(12);
    let hashes = Groups::new(vertices.len(), 1 << bits, |v| {
        let hash = hash(position(&vertices[v]));
        // The low bits are mixed badly where the coordinates have few digits.
        [((hash >> 48) as usize >> (16 - bits), ((hash >> 24) as u32, v as u32))]
    });
    let first: Vec<AtomicU32> = (0..vertices.len() as u32).map(AtomicU32::new).collect();
    (0..hashes.count).into_par_iter().for_each(|group| {
        let slots = (2 * hashes.group(group).count()).next_power_of_two();
        let mut table: Vec<Option<(u32, u32)>> = vec![None; slots];
        // Vertices ascend, so the first one at a position enters the table.
        for &(hash, v) in hashes.group(group) {
            let is_same = |other: u32| position(&vertices[other as usize]) == position(&vertices[v as usize]);
            let mut slot = hash as usize & (slots - 1);
            while let Some((other_hash, other)) = table[slot] {
                if other_hash == hash && is_same(other) {
                    first[v as usize].store(other, Ordering::Relaxed);
                    break;
                }
                slot = (slot + 1) & (slots - 1);
            }
            table[slot].get_or_insert((hash, v));
        }
    });
    first.into_iter().map(AtomicU32::into_inner).collect()
}

/// The bits of a position, the same for -0.0 and 0.0.
fn position(v: &Vec3) -> [u64; 3] {
    // Adding zero turns -0.0 into 0.0.
    v.to_array().map(|x| (x + 0.0).to_bits())
}

/// A hash whose high bits are well mixed.
fn hash(position: [u64; 3]) -> u64 {
    position
        .iter()
        .fold(0, |hash: u64, x| {
            let mixed = (hash.rotate_left(23) ^ x).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            mixed ^ mixed >> 32
        })
        .wrapping_mul(0xd6e8_feb8_6659_fd93)
}

/// A face whose vertices are each the first at their position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub(super) number: u32,
    pub(super) corners: [u32; 3],
}

/// Returns the faces with corners at three different positions.
pub(super) fn welded(mesh: &TriangleMesh, first_at: &[u32]) -> Vec<Face> {
    let face = |(number, corners): (usize, &[u32; 3])| Face {
        number: number as u32,
        corners: corners.map(|v| first_at[v as usize]),
    };
    let mut faces: Vec<Face> = mesh.faces.par_iter().enumerate().with_min_len(CHUNK).map(face).collect();
    faces.retain(|face| has_three_corners(&face.corners));
    faces
}

/// Whether no two corners coincide.
pub(super) fn has_three_corners([a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}
