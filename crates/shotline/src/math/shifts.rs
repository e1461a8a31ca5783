//! One chain of transforms under many shifts, as the cells of a lattice need it.

use super::affine::{Wide, dot, inverse_linear, plus, round, widen};
use super::{Affine, ComposedTransform, Dd, SingularTransform, TransformPair, Vec3};

/// A chain of transforms that is applied before a shift. Gives the same bits as [`ComposedTransform`] for the shift and
/// the chain, at a small part of the cost: shifts do not change the linear part.
#[derive(Clone, Debug)]
pub struct ShiftedTransform {
    /// The linear parts of the product and of its inverse.
    linear: [[Dd; 3]; 3],
    inverse: [[Dd; 3]; 3],
    /// What the chain adds to a shift, in the order of the product.
    terms: Vec<[Dd; 3]>,
    /// Whether the chain is empty.
    is_shift: bool,
}

impl ShiftedTransform {
    /// Prepares a chain, outermost first. Returns it with the condition number of the product.
    ///
    /// # Errors
    /// As [`ComposedTransform::placement`].
    pub fn new(chain: &[Affine]) -> Result<(ShiftedTransform, f64), SingularTransform> {
        let mut composed = ComposedTransform::IDENTITY;
        let mut terms = Vec::new();
        for matrix in chain.iter().filter(|matrix| !matrix.is_identity()) {
            let (outer, inner) = (&composed.0, widen(matrix));
            terms.push([0, 1, 2].map(|i| {
                dot([outer[i][0], outer[i][1], outer[i][2]], [inner[0][3], inner[1][3], inner[2][3]])
            }));
            composed = composed.then(matrix);
        }
        let TransformPair { condition, .. } = composed.placement()?;
        let linear = composed.0.map(|row| [row[0], row[1], row[2]]);
        let inverse = inverse_linear(&composed.0);
        Ok((ShiftedTransform { linear, inverse, is_shift: terms.is_empty(), terms }, condition))
    }

    /// The transforms under a shift.
    #[inline]
    pub fn at(&self, shift: Vec3) -> Affine {
        // The inverse of a shift by 0 or by -0 is one by -0.
        if self.is_shift {
            return Affine::translation(-(shift + Vec3::ZERO));
        }
        let column = self.column(shift);
        round(&[0, 1, 2].map(|i| {
            let row = self.inverse[i];
            [row[0], row[1], row[2], -dot(row, column)]
        }))
    }

    /// The inverse of [`ShiftedTransform::at`]: parent from local.
    pub fn parent_from_local(&self, shift: Vec3) -> Affine {
        let column = self.column(shift);
        let wide: Wide = [0, 1, 2].map(|i| {
            let row = self.linear[i];
            [row[0], row[1], row[2], column[i]]
        });
        round(&wide)
    }

    /// Bytes used.
    pub fn memory(&self) -> usize {
        size_of::<ShiftedTransform>() + size_of_val(self.terms.as_slice())
    }

    /// The shift of the product.
    fn column(&self, shift: Vec3) -> [Dd; 3] {
        let start = [shift.x, shift.y, shift.z].map(Dd::from);
        self.terms.iter().fold(start, |column, term| [0, 1, 2].map(|i| plus(term[i], column[i])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    /// The bits of a shift above a chain are those of the product of both.
    #[test]
    fn shifts_above_a_chain_are_its_products() {
        let bits = |m: &Affine| m.rows.map(|row| row.map(f64::to_bits));
        let mut random = Random::new(91);
        for case in 0..4000 {
            let mut step = || match random.below(4) {
                0 => Affine::translation(random.point(-3.0, 3.0)),
                1 => Affine::rotation_xyz(random.point(-180.0, 180.0)),
                2 => Affine::scaling(random.point(0.5, 3.0)),
                _ => Affine::IDENTITY,
            };
            let chain: Vec<Affine> = (0..case % 4).map(|_| step()).collect();
            let shift = match case % 5 {
                0 => Vec3::ZERO,
                1 => Vec3::new(-0.0, 0.0, random.number(-9.0, 9.0)),
                _ => random.point(-1e3, 1e3),
            };
            let start = ComposedTransform::IDENTITY.then(&Affine::translation(shift));
            let expected = chain.iter().fold(start, |all, m| all.then(m)).placement().unwrap();
            let (prepared, condition) = ShiftedTransform::new(&chain).unwrap();
            assert_eq!(bits(&prepared.at(shift)), bits(&expected.local_from_parent), "{chain:?} {shift}");
            assert_eq!(prepared.parent_from_local(shift), expected.parent_from_local);
            assert_eq!(condition, expected.condition);
        }
    }
}
