//! Solids. Each one computes, in its own frame, all crossings of a line with its surface in one call.
//!
//! To add a solid, write one file and add one line to the registry at the end of this file. That line also runs
//! the conformance suite (`testkit`) on it.

mod capped;
#[cfg(test)]
mod capped_tests;
mod clear;
mod cone;
mod cone_section;
mod constructors;
mod cuboid;
mod cut_tube;
mod cylinder;
mod definite;
mod ellipsoid;
mod ellipsoid_section;
mod elliptical_cone;
mod elliptical_cylinder;
mod extruded;
mod faces;
mod form;
mod generic_polyhedra;
mod halfspace;
mod helicoid;
mod hyperboloid;
mod hyperboloid2;
mod hyperboloid_shell;
#[cfg(test)]
mod ignored_axes_tests;
mod interval;
mod kind;
pub(crate) mod lanes;
#[cfg(test)]
mod listed_tests;
pub mod mesh;
mod moments;
mod paraboloid;
mod paraboloid_section;
mod parts;
mod polycone;
mod polyhedra;
mod profile;
mod quadratic;
mod quadric;
mod quadric_line;
mod quadric_matrix;
mod revolved;
mod ring;
#[cfg(test)]
mod sections_tests;
mod sector;
mod sides;
mod sphere;
mod sphere_section;
mod tetrahedron;
pub mod torus;
mod torus_section;
mod trapezoid;
mod tube;
mod twisted_trapezoid;
mod twisted_tube;

use std::fmt::Debug;

use crate::aabb::Aabb;
use crate::contact::Contact;
use crate::crossing::Crossing;
use crate::math::{Plane, Vec3};
use crate::ray::{Line, Span};
use crate::scratch::Scratch;

use constructors::constructors;
pub use kind::{Build, InvalidSolid, Kind, Layout, Param, ParamError, Params, Quantity, Rows};
pub(crate) use mesh::tetrahedron;
pub use moments::Moments;
pub use parts::Parts;
pub use quadric_matrix::QuadricMatrix;

/// How many of the crossings a query needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// All crossings.
    All,
    /// Only those that decide the first boundary.
    First,
}

/// A set with an interior, in its own frame.
pub trait Solid: Send + Sync + Debug {
    /// Returns a box that contains the solid, infinite where the solid is unbounded. Conservative under rounding.
    fn bounds(&self) -> Aabb;

    /// Appends every crossing of the whole line. The list is ascending and even, and alternates beginning with an
    /// entry. Where the interior is unbounded, the list begins at `-inf` or ends at `inf`. A tangent point yields
    /// no crossing, or an entry and an exit whose `t` agree within their bounds.
    fn crossings(&self, line: &Line, out: &mut Vec<Crossing>);

    /// Appends the crossings that matter to a query over a span. Folding them over the span gives the same
    /// boundaries as folding the whole list, or the same first boundary if only that is wanted. The list is even
    /// and alternates beginning with an entry. An entry at `-inf` may stand for everything before the span.
    /// Overridden where the whole list is expensive (the mesh).
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

    /// Appends the intervals on which a line lies in the surface of the solid, up to rounding: in a face, or
    /// along a generator. Combinations need them to detect that two operands share a face in which the line lies.
    /// Called right after [`Solid::crossings_within`] for the same line and scratch, if that call appended
    /// nothing or left faces in [`Scratch::in_plane`]. Contacts then replace the crossings.
    fn contacts(&self, _line: &Line, _out: &mut Vec<Contact>, _scratch: &mut Scratch) {}

    /// Whether the line is certainly in the interior between two `t`, and so far from the surface there that no
    /// crossing is coincident with anything in that interval. `false` means unknown. Worth implementing only
    /// where it is much cheaper than [`Solid::crossings`].
    fn is_clear_of_surface(&self, _line: &Line, _from: f64, _to: f64) -> bool {
        false
    }

    /// The implicit function of one surface: negative on the interior side, zero on the surface.
    /// [`Solid::normal`] is its gradient, up to a positive factor.
    fn implicit(&self, p: Vec3, surface: u32, primitive: u32) -> f64;

    /// The gradient at a point of a surface. It points out of the solid and has any non-zero length. Computed on
    /// demand only.
    fn normal(&self, p: Vec3, surface: u32, primitive: u32) -> Vec3;

    /// Whether a point lies in the interior. The result is not reliable within rounding of the surface.
    fn contains(&self, p: Vec3) -> bool;

    /// The names of the surfaces, in the order of [`Crossing::surface`].
    fn surfaces(&self) -> &'static [&'static str];

    /// The barycentric coordinates of a point of a triangle: the weights of its second and third vertex. `None`
    /// for solids without triangles.
    fn barycentric(&self, _p: Vec3, _primitive: u32) -> Option<[f64; 2]> {
        None
    }

    /// The index, from 0, of the polygon that a triangle was cut from. `None` for solids without triangles.
    fn polygon(&self, _primitive: u32) -> Option<u32> {
        None
    }

    /// The surface as a quadric over homogeneous points, up to a positive factor. `None` if it is not a quadric.
    fn quadric_matrix(&self, _surface: u32) -> Option<QuadricMatrix> {
        None
    }

    /// The planes of a solid that is the intersection of the half-spaces behind them: a half-space or a box.
    /// `None` for other solids.
    fn half_spaces(&self) -> Option<Vec<Plane>> {
        None
    }

    /// Volume and moments in closed form, exact except for rounding. `None` if there is no closed form. For a
    /// mesh this takes as long as a thorough check.
    fn moments(&self) -> Option<Moments> {
        None
    }

    /// The solid as a mesh, if it is one. A mesh that intersects itself can still report most of its moments.
    fn as_mesh(&self) -> Option<&mesh::MeshSolid> {
        None
    }

    /// How several lines are intersected at once; `None` for one by one.
    #[doc(hidden)]
    fn in_lanes(&self) -> Option<lanes::InLanes<'_>> {
        None
    }

    /// Memory used beyond the solid's own struct, in bytes.
    fn memory(&self) -> usize {
        0
    }
}

/// Declares the registry, gathers the typed constructors and runs the conformance suite on each entry.
macro_rules! registry {
    ($($module:ident),* $(,)?) => {
        /// Every kind of solid that is defined by parameters.
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
                    crate::testkit::parts::conformance(&super::$module::KIND);
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
    cone_section,
    cut_tube,
    ellipsoid_section,
    elliptical_cone,
    elliptical_cylinder,
    hyperboloid_shell,
    paraboloid_section,
    sphere_section,
    torus_section,
    revolved,
    polycone,
    polyhedra,
    generic_polyhedra,
    extruded,
    tetrahedron,
    trapezoid,
    twisted_tube,
    twisted_trapezoid,
);

/// Returns the kind with a given name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|k| k.name == name).copied()
}
