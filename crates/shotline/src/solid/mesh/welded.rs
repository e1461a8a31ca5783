//! A mesh with its exactly coincident vertices welded.

use std::hash::{BuildHasher, RandomState};
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
    let key = PositionKey::random();
    let hashes = Groups::new(vertices.len(), 1 << bits, |v| {
        let hash = key.hash(position(&vertices[v]));
        [((hash >> 48) as usize >> (16 - bits), (hash as u32, v as u32))]
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

/// A random key of a hash of positions. Without it, a file could be made whose vertices all have the same hash, so that
/// each would be compared with all others.
struct PositionKey([u64; 4]);

impl PositionKey {
    fn random() -> PositionKey {
        let random = RandomState::new();
        PositionKey(std::array::from_fn(|i| random.hash_one(i)))
    }

    /// A hash all of whose bits are well mixed.
    fn hash(&self, [x, y, z]: [u64; 3]) -> u64 {
        let [a, b, c, d] = self.0;
        // Folded once, coordinates of few digits leave out many values with some keys.
        folded_product(folded_product(x ^ a, y ^ b) ^ z ^ c, d)
    }
}

/// The upper and the lower half of a product, on each other: every bit depends on all bits of both factors.
fn folded_product(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    (product >> 64) as u64 ^ product as u64
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

#[cfg(test)]
mod tests {
    use std::collections::{HashMap, HashSet};

    use super::*;
    use crate::testkit::random::Random;

    /// Positions with the same value of a hash whose multiplier is known: any x and y, and the z that leads there.
    fn positions_for_a_known_hash(count: usize) -> Vec<Vec3> {
        let multiplied = |hash: u64, x: u64| {
            let mixed = (hash.rotate_left(23) ^ x).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            mixed ^ mixed >> 32
        };
        let position = |i: u32| {
            let [x, y] = [f64::from(i), 1.0];
            let hash = multiplied(multiplied(0, x.to_bits()), y.to_bits());
            Vec3::new(x, y, f64::from_bits(hash.rotate_left(23) ^ 0x1234_5678_9abc_def0))
        };
        (0..).map(position).filter(|v| v.is_finite()).take(count).collect()
    }

    #[test]
    fn no_file_gives_its_vertices_the_same_hash() {
        let few_digits = (0..20_000).map(|i| Vec3::new(f64::from(i % 50), f64::from(i / 50), 0.0)).collect();
        let (known, mut random) = (positions_for_a_known_hash(20_000), Random::new(5));
        for case in 0..20 {
            let vertices: &Vec<Vec3> = if case % 2 == 0 { &known } else { &few_digits };
            let key = PositionKey([0; 4].map(|_| random.bits()));
            let hashes: Vec<u64> = vertices.iter().map(|v| key.hash(position(v))).collect();
            // The bits that choose the group, and those that choose the slot.
            for bits in [|hash: u64| hash >> 52, |hash: u64| hash & 0xfff] {
                let different: HashSet<u64> = hashes.iter().map(|hash| bits(*hash)).collect();
                // Of 4096 values, 20,000 random ones leave out 31.
                assert!(different.len() > 4000, "{}", different.len());
            }
        }
    }

    #[test]
    fn the_first_vertex_at_each_position_is_found_with_any_key() {
        let mut random = Random::new(3);
        let mut vertices = positions_for_a_known_hash(9_000);
        vertices.extend((0..9_000).map(|_| random.point(-3.0, 3.0).round()));
        let mut known = HashMap::new();
        let expected: Vec<u32> =
            (0..).zip(&vertices).map(|(v, at)| *known.entry(position(at)).or_insert(v)).collect();
        for _ in 0..3 {
            assert_eq!(first_at(&vertices), expected);
        }
    }
}
