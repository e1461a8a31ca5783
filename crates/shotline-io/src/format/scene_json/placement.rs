//! The transform of a node: a matrix, or readable steps.

use shotline::math::{Affine, Vec3};
use shotline::scene::{LocalTransform, Rotation};

use super::keys::{self, ROTATION};
use super::values::{Values, numbers_in_words};
use crate::json::{Content, ValueId};

/// The transform of a node, if it has one.
pub(super) fn read(values: &mut Values, node: ValueId) -> Option<LocalTransform> {
    let tree = values.tree;
    let [matrix, scale, rotate, translate] =
        ["transform", "scale", "rotate", "translate"].map(|key| tree.get(node, key));
    if let Some(at) = matrix {
        for other in [scale, rotate, translate].into_iter().flatten() {
            let help = "put everything into the matrix, or use \"scale\", \"rotate\" and \"translate\" only";
            values.report(other, "this node has a \"transform\" as well", help);
        }
        let numbers = values.numbers(at, "\"transform\"", 12)?;
        let rows = numbers.try_into().ok()?;
        return Some(LocalTransform::Matrix(Affine::from_row_major(rows)));
    }
    // Without any step there is no transform.
    scale.or(rotate).or(translate)?;
    Some(LocalTransform::Steps {
        scale: scale.and_then(|at| read_scale(values, at)),
        rotate: rotate.and_then(|at| read_rotation(values, at)),
        translate: translate.and_then(|at| values.vector(at, "\"translate\"")).map(Vec3::from),
    })
}

fn read_scale(values: &mut Values, at: ValueId) -> Option<Vec3> {
    match values.tree.content(at) {
        Content::Number(factor) => Some(Vec3::splat(*factor)),
        _ => values.vector(at, "\"scale\"").map(Vec3::from),
    }
}

/// A rotation: angles about x, y and z, or an axis and an angle.
pub(super) fn read_rotation(values: &mut Values, at: ValueId) -> Option<Rotation> {
    if !matches!(values.tree.content(at), Content::Object(_)) {
        return values.vector(at, "\"rotate\"").map(|v| Rotation::Xyz(Vec3::from(v)));
    }
    let known: Vec<_> = keys::names(ROTATION).collect();
    values.only(at, "a rotation", &known);
    let axis = values.required(at, "a rotation", "axis", &numbers_in_words(3));
    let axis = axis.and_then(|a| values.vector(a, "\"axis\""));
    let degrees = values.required(at, "a rotation", "degrees", &numbers_in_words(1));
    let degrees = degrees.and_then(|a| values.number(a, "\"degrees\""));
    let (axis, degrees) = (Vec3::from(axis?), degrees?);
    if axis == Vec3::ZERO {
        values.report(at, "the axis of this rotation is zero", "give it a direction");
    }
    Some(Rotation::About { axis, degrees })
}
