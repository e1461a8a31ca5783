//! Solids: each answers, in its own frame, where a line crosses its surface: once, completely.
//!
//! Adding a solid is one file and one line in the registry at the end of this one; that line also stamps the
//! conformance suite (`testkit`) onto it.

mod capped;
#[cfg(test)]
mod capped_tests;
mod clear;
mod cone;
mod constructors;
mod cuboid;
mod cylinder;
mod definite;
mod ellipsoid;
mod form;
mod halfspace;
mod hyperboloid;
mod hyperboloid2;
mod interval;
mod kind;
pub mod mesh;
mod moments;
mod paraboloid;
mod quadratic;
mod quadric;
mod quadric_line;
mod quadric_matrix;
mod sides;
mod sphere;
pub mod torus;
mod tube;

use std::fmt::Debug;

use crate::aabb::Aabb;
use crate::contact::Contact;
use crate::crossing::Crossing;
use crate::math::{Plane, Vec3};
use crate::ray::{Line, Span};
use crate::scratch::Scratch;

use constructors::constructors;
pub use kind::{InvalidSolid, Kind, Param, ParamError, Params, Quantity};
pub(crate) use mesh::tetrahedron;
pub use moments::Moments;
pub use quadric_matrix::QuadricMatrix;

/// How much of a list is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Everything.
    All,
    /// What decides the first boundary.
    First,
}

/// A set with an interior, in its own frame.
pub trait Solid: Send + Sync + Debug {
    /// A box that holds the solid; infinite where it has no end. Conservative under rounding.
    fn bounds(&self) -> Aabb;

    /// Appends every crossing of the whole line: ascending, alternating from an entry, an even number.
    /// Where the interior has no end the list begins at `-inf` or ends at `inf`. Touching leaves nothing,
    /// or an entry and an exit whose `t` agree within their bounds.
    fn crossings(&self, line: &Line, out: &mut Vec<Crossing>);

    /// The crossings that matter to a query over a span: folding them over the span gives the same
    /// boundaries as folding the whole list, or, where only the first is wanted, the same first boundary.
    /// They alternate from an entry and are even; an entry at `-inf` may stand for what lies before the span.
    /// Overridden where the whole list is dear (the mesh).
    fn crossings_within(
        &self,
        line: &Line,
        _span: Span,
        _wanted: Wanted,
        out: &mut Vec<Crossing>,
        _scratch: &mut Scratch,
    ) {
        self.crossings(line, out);
    }

    /// Appends the stretches of a line that lie in the surface of the solid, up to rounding: a line in a face, or
    /// along a generator. Combinations need them to see that two operands share a face in which the line lies. Asked
    /// right after [`Solid::crossings_within`] of the same line with the same scratch, where that answered nothing or
    /// left faces in [`Scratch::in_plane`]; contacts stand for the crossings, which do not count then.
    fn contacts(&self, _line: &Line, _out: &mut Vec<Contact>, _scratch: &mut Scratch) {}

    /// Whether a line is certainly in the interior from one `t` to another, and so far from the surface that no crossing
    /// is one event with anything from the first `t` to the second. `false` says nothing: worth an answer only where that
    /// is much cheaper than [`Solid::crossings`].
    fn is_clear(&self, _line: &Line, _from: f64, _to: f64) -> bool {
        false
    }

    /// The implicit function of one surface: negative on the side of the interior, zero on the surface,
    /// with [`Solid::normal`] as its gradient (up to a positive factor).
    fn implicit(&self, p: Vec3, surface: u32, primitive: u32) -> f64;

    /// The gradient at a point of a surface: pointing out of the solid, of any non-zero length. Worked out
    /// on demand only.
    fn normal(&self, p: Vec3, surface: u32, primitive: u32) -> Vec3;

    /// Whether a point lies in the interior. No promise within rounding of the surface.
    fn contains(&self, p: Vec3) -> bool;

    /// The names of the surfaces, in the order of [`Crossing::surface`].
    fn surfaces(&self) -> &'static [&'static str];

    /// Barycentric coordinates of a point of a triangle, weights of its second and third vertex; `None` for
    /// solids without triangles.
    fn barycentric(&self, _p: Vec3, _primitive: u32) -> Option<[f64; 2]> {
        None
    }

    /// The polygon that a triangle was cut from, counted from 0; `None` for solids without triangles.
    fn polygon(&self, _primitive: u32) -> Option<u32> {
        None
    }

    /// The surface as a quadric over homogeneous points, up to a positive factor; `None` where it is none.
    fn quadric_matrix(&self, _surface: u32) -> Option<QuadricMatrix> {
        None
    }

    /// The planes in front of none of which the solid is, if it is all that lies behind them: a half-space, a box.
    fn half_spaces(&self) -> Option<Vec<Plane>> {
        None
    }

    /// Volume and moments in closed form, exact but for rounding; `None` where there is none. A mesh takes as long
    /// as a thorough check.
    fn moments(&self) -> Option<Moments> {
        None
    }

    /// The solid as a mesh, if it is one: where it passes through itself it still tells most of its moments.
    fn as_mesh(&self) -> Option<&mesh::MeshSolid> {
        None
    }

    /// Bytes used beyond the solid itself.
    fn memory(&self) -> usize {
        0
    }
}

/// Declares the registry, gathers the typed constructors and stamps the conformance suite onto each entry.
macro_rules! registry {
    ($($module:ident),* $(,)?) => {
        /// Every kind of solid that is given by parameters.
        pub static KINDS: &[&Kind] = &[$(&$module::KIND),*];

        /// What the typed constructors expand to, by the name of the module: the kind, and the macro that holds them.
        pub(crate) mod declared {
            pub(crate) use super::constructors::{argument, numbers};
            $(
                pub(crate) use super::$module::$module;

                pub(crate) fn $module() -> &'static super::Kind {
                    &super::$module::KIND
                }
            )*
        }

        /// The typed constructors of every kind.
        macro_rules! every_constructor {
            () => {
                $($crate::solid::declared::$module! {})*
            };
        }
        pub(crate) use every_constructor;

        #[cfg(test)]
        mod conformance {
            $(
                #[test]
                fn $module() {
                    super::constructors::conformance(&super::$module::KIND, super::$module::ARGUMENTS);
                    crate::testkit::solid::conformance(&super::$module::KIND);
                }
            )*
        }
    };
}

registry!(
    halfspace,
    cuboid,
    sphere,
    ellipsoid,
    cylinder,
    cone,
    paraboloid,
    hyperboloid,
    hyperboloid2,
    quadric,
    torus,
    tube,
);

/// The kind of a name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|k| k.name == name).copied()
}
