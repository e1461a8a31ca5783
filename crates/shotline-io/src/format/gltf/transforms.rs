//! How nodes are placed: by a matrix, or by a translation, a rotation and a scale.

use shotline::math::{Affine, Vec3};
use shotline::scene::{LocalTransform, Rotation};

use super::fields::{Field, Read};

/// The transform of a node; `None` if it is the identity.
pub(super) fn of_node(node: Field, what: &str) -> Read<Option<LocalTransform>> {
    if let Some(matrix) = node.get("matrix") {
        let affine = affine(matrix, what)?;
        return Ok((!affine.is_identity()).then_some(LocalTransform::Matrix(affine)));
    }
    let vector = |key: &str| {
        let field = node.get(key);
        field.map(|field| field.numbers::<3>(&format!("\"{key}\"")).map(Vec3::from_array)).transpose()
    };
    let scale = vector("scale")?.filter(|scale| *scale != Vec3::ONE);
    let translate = vector("translation")?.filter(|shift| *shift != Vec3::ZERO);
    let rotate = node.get("rotation").map(|field| rotation(field, what)).transpose()?.flatten();
    let is_identity = scale.is_none() && translate.is_none() && rotate.is_none();
    Ok((!is_identity).then_some(LocalTransform::Steps { scale, rotate, translate }))
}

/// A matrix of 16 numbers, column by column.
fn affine(field: Field, what: &str) -> Read<Affine> {
    let m = field.numbers::<16>("\"matrix\"")?;
    if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
        let message = format!("the matrix of {what} is not affine: its last row is not 0, 0, 0, 1");
        return Err(field.error(message).help("the matrix is written column by column"));
    }
    let row = |i: usize| [m[i], m[4 + i], m[8 + i], m[12 + i]];
    Ok(Affine { rows: [row(0), row(1), row(2)] })
}

/// A unit quaternion x, y, z, w, which need not be of length 1 exactly, as an axis and an angle.
fn rotation(field: Field, what: &str) -> Read<Option<Rotation>> {
    let [x, y, z, w] = field.numbers::<4>("\"rotation\"")?;
    let sine = libm::hypot(libm::hypot(x, y), z);
    if !(1e-3..=1e3).contains(&libm::hypot(sine, w)) {
        let message = format!("the rotation of {what} is no quaternion of length 1");
        return Err(field.error(message).help("no rotation is [0, 0, 0, 1]"));
    }
    if sine == 0.0 {
        return Ok(None);
    }
    let axis = Vec3::new(x / sine, y / sine, z / sine);
    Ok(Some(Rotation::About { axis, degrees: (2.0 * libm::atan2(sine, w)).to_degrees() }))
}

/// Whether a transform maps everything into a plane, as the scale 0 does with which some programs hide parts.
pub(super) fn is_flat(transform: &LocalTransform) -> bool {
    match transform {
        LocalTransform::Matrix(matrix) => matrix.determinant() == 0.0,
        LocalTransform::Steps { scale, .. } => scale.is_some_and(|scale| scale.to_array().contains(&0.0)),
    }
}
