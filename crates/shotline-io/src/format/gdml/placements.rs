//! How volumes and the operands of combinations are placed.

use shotline::math::{Affine, Vec3};
use shotline::scene::{LocalTransform, Rotation};

use super::attributes::Found;
use super::definitions::Vector;
use super::{Element, Module, tag};

/// A position in millimetres, a rotation in degrees about x, then y, then z, and a scale.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    position: Vec3,
    rotation: Vec3,
    scale: Vec3,
}

impl Placement {
    pub(super) const NONE: Placement =
        Placement { position: Vec3::ZERO, rotation: Vec3::ZERO, scale: Vec3::ONE };

    pub(super) fn at(position: Vec3) -> Placement {
        Placement { position, ..Placement::NONE }
    }

    pub(super) fn turned(degrees_about_z: f64) -> Placement {
        Placement { rotation: Vec3::new(0.0, 0.0, degrees_about_z), ..Placement::NONE }
    }

    pub(super) fn is_none(&self) -> bool {
        self.position == Vec3::ZERO && self.rotation == Vec3::ZERO && self.scale == Vec3::ONE
    }

    /// The transform of an operand of a combination: the rotation turns the operand.
    pub(super) fn of_operand(&self) -> LocalTransform {
        self.transform(self.rotation)
    }

    /// The transform of a volume in its mother: the rotation turns the mother's frame, so the volume turns the other way. Its
    /// inverse is of the form of a rotation about x, y and z only where it turns about one axis.
    pub(super) fn of_volume(&self) -> LocalTransform {
        let axes = self.rotation.to_array().iter().filter(|x| **x != 0.0).count();
        if axes <= 1 {
            // Without the addition there would be negative zeros.
            return self.transform(Vec3::ZERO - self.rotation);
        }
        let turn = Affine::rotation_xyz(self.rotation);
        let mut matrix = Affine::translation(self.position);
        for (i, row) in matrix.rows.iter_mut().enumerate() {
            for (j, x) in row[..3].iter_mut().enumerate() {
                *x = turn.rows[j][i] * self.scale[j];
            }
        }
        LocalTransform::Matrix(matrix)
    }

    fn transform(&self, degrees: Vec3) -> LocalTransform {
        LocalTransform::Steps {
            scale: Some(self.scale).filter(|scale| *scale != Vec3::ONE),
            rotate: Some(Rotation::Xyz(degrees)).filter(|_| degrees != Vec3::ZERO),
            translate: Some(self.position).filter(|position| *position != Vec3::ZERO),
        }
    }
}

impl Module<'_> {
    /// Takes over a position, rotation or scale from an element, if it is one whose name begins with the prefix; tells whether
    /// it is.
    pub(super) fn place(&mut self, element: Element, prefix: &str, placement: &mut Placement) -> Found<bool> {
        let Some(name) = tag(element).strip_prefix(prefix) else { return Ok(false) };
        match name.strip_suffix("ref").unwrap_or(name) {
            "position" => placement.position = self.vector_of(element, Vector::Position)?,
            "rotation" => placement.rotation = self.vector_of(element, Vector::Rotation)?,
            "scale" => placement.scale = self.vector_of(element, Vector::Scale)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// A placement by the attributes of a reflected solid.
    pub(super) fn reflection(&mut self, element: Element) -> Found<Placement> {
        let mut placement = Placement::NONE;
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            placement.scale[i] = self.number_or(element, &format!("s{axis}"), 1.0)?;
            placement.rotation[i] = self.angle_or(element, &format!("r{axis}"), 0.0)?;
            placement.position[i] = self.length_or_zero(element, &format!("d{axis}"))?;
        }
        Ok(placement)
    }
}
