//! Animations: frames one after the other, each the same as if it were rendered alone.
//!
//! What moves is placed anew in a world that is kept ([`DynamicWorld`]). While the first frame is made it is noted which
//! pixels nothing that moves can touch in any frame, because no ray of theirs comes through a box in which it is.
//! Only the others are rendered again.

use shotline::compile::{DynamicWorld, Options, SceneError};
use shotline::query::batch::Run;
use shotline::scene::{LocalTransform, NodeId, Scene};

use crate::camera::orbited;
use crate::error::RenderError;
use crate::image::Image;
use crate::render::{Settings, Setup, check, frame};
use crate::still::{Kept, Swept};

/// The most frames of an animation.
pub const MAX_FRAMES: u32 = 1 << 16;

/// What an animation shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Animation {
    /// How many frames. The last is one step before the end of all motions, so that full turns can be repeated.
    pub frames: u32,
    /// Degrees by which the camera goes round what it looks at.
    pub orbit: f64,
}

/// Why there is no animation.
#[derive(Debug, thiserror::Error)]
pub enum AnimationError<E> {
    /// The number of frames is zero or beyond reason.
    #[error("{0} frames: it must be from 1 to {MAX_FRAMES}")]
    Frames(u32),
    /// The scene cannot be compiled, or what moves cannot be placed.
    #[error("the scene cannot be compiled")]
    Scene(Vec<SceneError>),
    /// A frame cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Whoever was given a frame did not take it.
    #[error("a frame was not taken")]
    NotTaken(E),
}

/// Renders the frames of a scene and gives each to `take`. The scene's [motions](shotline::scene::Motion) say how
/// its objects move. A scene without a camera is framed as it is in the first
/// frame, and of that size the look `xray` takes its scale.
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
    check(settings)?;
    let Animation { frames, orbit } = animation;
    if !(1..=MAX_FRAMES).contains(&frames) {
        return Err(AnimationError::Frames(frames));
    }
    let moving = Moving { frames, nodes: scene.set_in_motion() };
    let mut live = DynamicWorld::new(scene, options).map_err(AnimationError::Scene)?;
    let mut kept = Kept::default();
    if settings.coherence.frames && orbit == 0.0 && settings.look.local {
        kept.swept = Some(moving.swept(&mut live).map_err(|e| AnimationError::Scene(vec![e]))?);
    }
    moving.set(&mut live, 0).map_err(|e| AnimationError::Scene(vec![e]))?;
    let mut setup = Setup::new(live.world(), live.scene(), settings)?;
    let rest = setup.camera;
    for number in 0..frames {
        moving.set(&mut live, number).map_err(|e| AnimationError::Scene(vec![e]))?;
        setup.camera = orbited(&rest, orbit * moving.share(number));
        let image = frame(live.world(), live.scene(), &setup, settings, run, &mut kept)?;
        take(image).map_err(AnimationError::NotTaken)?;
    }
    Ok(())
}

/// What moves: transforms, each with the number of its motion.
struct Moving {
    frames: u32,
    nodes: Vec<(NodeId, usize)>,
}

impl Moving {
    /// How much of all motions is done in a frame.
    fn share(&self, number: u32) -> f64 {
        f64::from(number) / f64::from(self.frames)
    }

    fn set(&self, live: &mut DynamicWorld, number: u32) -> Result<(), SceneError> {
        let at = |motion: usize| live.scene().motions[motion].at(self.share(number));
        let all: Vec<(NodeId, LocalTransform)> =
            self.nodes.iter().map(|&(id, motion)| (id, at(motion))).collect();
        live.set(&all)
    }

    /// Where all of it is, in all frames.
    fn swept(&self, live: &mut DynamicWorld) -> Result<Swept, SceneError> {
        let mut boxes = Vec::new();
        for number in 0..self.frames {
            self.set(live, number)?;
            boxes.extend(self.nodes.iter().map(|&(id, _)| live.moved_bounds(id)));
        }
        Ok(Swept::new(boxes))
    }
}
