//! Which part of a ray a query looks at, and which kinds of crossings it looks for.

use crate::csg::HitKind;
use crate::ray::Span;

/// Which kinds of crossings a query looks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kinds {
    /// Every crossing: lists alternate and are even.
    #[default]
    All,
    /// Crossings with a surface. Those of kind [`HitKind::Start`] and [`HitKind::End`] are left out of lists and counts,
    /// and the first crossing is the first surface: a ray that begins inside may have an odd list, which begins with an
    /// exit.
    Surfaces,
}

impl Kinds {
    /// Whether a crossing of a kind is looked for.
    pub(super) fn hold(self, kind: HitKind) -> bool {
        self == Kinds::All || kind == HitKind::Surface
    }
}

/// What a query looks at. A [`Span`] by itself stands for every kind of crossing in it.
///
/// ```
/// # use shotline::{compile, math::Vec3, query::{Caster, Scope}, ray::{Ray, Span}, scene::Scene};
/// # let mut scene = Scene::default();
/// # let room = scene.add_solid("sphere", &[&[2.0]]).unwrap();
/// # scene.add_object("room", None, room);
/// # let world = compile::compile(&scene, compile::Options::default()).unwrap();
/// // From the middle of a ball of radius 2.
/// let (mut caster, ray) = (Caster::new(&world), Ray::new(Vec3::ZERO, Vec3::X).unwrap());
/// assert_eq!(caster.closest(&ray, Span::FORWARD).unwrap().unwrap().t, 0.0);
/// assert_eq!(caster.closest(&ray, Scope::surfaces(Span::FORWARD)).unwrap().unwrap().t, 2.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scope {
    /// The part of the ray.
    pub span: Span,
    /// The kinds of crossings.
    pub kinds: Kinds,
}

impl Scope {
    /// The surfaces in a span.
    pub fn surfaces(span: Span) -> Scope {
        Scope { span, kinds: Kinds::Surfaces }
    }
}

impl From<Span> for Scope {
    fn from(span: Span) -> Scope {
        Scope { span, kinds: Kinds::All }
    }
}
