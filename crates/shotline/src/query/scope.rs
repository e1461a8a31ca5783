//! The scope of a query: a part of a ray, and the kinds of crossings to look for.

use crate::csg::HitKind;
use crate::ray::Span;

/// Which kinds of crossings a query looks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kinds {
    /// Every crossing: lists alternate and have an even length.
    #[default]
    All,
    /// Only crossings of a surface. Crossings of kind [`HitKind::Start`] and [`HitKind::End`] are left out of lists
    /// and counts, and the first crossing is the first surface. The list of a ray that begins inside may have an odd
    /// length and begin with an exit.
    Surfaces,
}

impl Kinds {
    /// Whether crossings of a kind are included.
    pub(super) fn hold(self, kind: HitKind) -> bool {
        self == Kinds::All || kind == HitKind::Surface
    }
}

/// What a query looks for. A [`Span`] alone stands for every kind of crossing in it.
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
