//! Animations: frames one after the other, each the same as if it were rendered alone.
//!
//! One world is kept, and the moving objects in it are moved from frame to frame ([`DynamicWorld`]). The first frame
//! records which pixels cannot change in any frame, because none of their rays meets a box in which something moves.
//! Only the other pixels are rendered again.

use shotline::compile::{DynamicWorld, Options, SceneError};
use shotline::query::batch::Run;
use shotline::scene::{LocalTransform, NodeId, Scene};

use crate::camera::orbited;
use crate::error::RenderError;
use crate::image::Image;
use crate::render::{Setup, render_frame};
use crate::settings::Settings;
use crate::temporal_cache::{SweptBounds, TemporalCache};

/// The maximum number of frames of an animation.
pub const MAX_FRAMES: u32 = 1 << 16;

/// What an animation shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Animation {
    /// The number of frames. The last is one step before the end of all motions, so that an animation of full turns can
    /// loop.
    pub frames: u32,
    /// Degrees by which the camera orbits its target.
    pub orbit: f64,
}

/// Why there is no animation.
#[derive(Debug, thiserror::Error)]
pub enum AnimationError<E> {
    /// The number of frames is out of range.
    #[error("{0} frames: it must be from 1 to {MAX_FRAMES}")]
    Frames(u32),
    /// The scene cannot be compiled, or the moving objects cannot be moved.
    #[error("the scene cannot be compiled")]
    Scene(Vec<SceneError>),
    /// A frame cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The caller rejected a frame.
    #[error("a frame was rejected")]
    Rejected(E),
}

/// Renders the frames of a scene and calls `take` with each. The scene's [motions](shotline::scene::Motion) say how
/// its objects move. A scene without a camera gets one that frames the first frame. The size of the first frame also
/// sets the scale of the look `xray`.
///
/// # Errors
/// [`AnimationError`].
pub fn animate<E>(
    mut scene: Scene,
    options: Options,
    settings: &Settings,
    animation: Animation,
    run: Run,
    mut take: impl FnMut(Image) -> Result<(), E>,
) -> Result<(), AnimationError<E>> {
    settings.check()?;
    let Animation { frames, orbit } = animation;
    if !(1..=MAX_FRAMES).contains(&frames) {
        return Err(AnimationError::Frames(frames));
    }
    let moving = MovingNodes { frames, nodes: scene.set_in_motion() };
    let mut live = DynamicWorld::new(scene, options).map_err(AnimationError::Scene)?;
    let mut cache = TemporalCache::default();
    if settings.coherence.frames && orbit == 0.0 && settings.look.is_local {
        cache.swept = Some(moving.swept(&mut live).map_err(|e| AnimationError::Scene(vec![e]))?);
    }
    moving.set(&mut live, 0).map_err(|e| AnimationError::Scene(vec![e]))?;
    let mut setup = Setup::new(live.world(), live.scene(), settings)?;
    let initial = setup.camera;
    for number in 0..frames {
        moving.set(&mut live, number).map_err(|e| AnimationError::Scene(vec![e]))?;
        setup.camera = orbited(&initial, orbit * moving.fraction(number));
        let image = render_frame(live.world(), live.scene(), &setup, settings, run, &mut cache)?;
        take(image).map_err(AnimationError::Rejected)?;
    }
    Ok(())
}

/// Transforms that move, each with the number of its motion.
struct MovingNodes {
    frames: u32,
    nodes: Vec<(NodeId, usize)>,
}

impl MovingNodes {
    /// The fraction of all motions that is done in a frame.
    fn fraction(&self, number: u32) -> f64 {
        f64::from(number) / f64::from(self.frames)
    }

    fn set(&self, live: &mut DynamicWorld, number: u32) -> Result<(), SceneError> {
        let at = |motion: usize| live.scene().motions[motion].at(self.fraction(number));
        let all: Vec<(NodeId, LocalTransform)> =
            self.nodes.iter().map(|&(id, motion)| (id, at(motion))).collect();
        live.set(&all)
    }

    /// The boxes of all moving nodes in all frames.
    fn swept(&self, live: &mut DynamicWorld) -> Result<SweptBounds, SceneError> {
        let mut boxes = Vec::new();
        for number in 0..self.frames {
            self.set(live, number)?;
            boxes.extend(self.nodes.iter().map(|&(id, _)| live.moved_bounds(id)));
        }
        Ok(SweptBounds::new(boxes))
    }
}
