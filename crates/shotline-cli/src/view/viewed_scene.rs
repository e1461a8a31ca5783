//! A scene, with the worlds that pages have asked for so far.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use shotline::aabb::Aabb;
use shotline::accel::DEFAULT;
use shotline::compile::{self, Options, World};
use shotline::scene::{HiddenObjects, Scene};
use shotline_io::Document;
use shotline_render::visible_subject;

use super::question::ShownOf;

/// The number of choices of objects whose worlds are kept.
const KEPT: usize = 4;

/// A scene that is viewed.
pub struct ViewedScene {
    /// What the page calls it.
    pub name: String,
    pub document: Document,
    /// The accelerator, where the page chooses none.
    pub default_accel: &'static str,
    /// Whole worlds by accelerator.
    worlds: Mutex<HashMap<&'static str, Arc<World>>>,
    /// The last choices of objects, the latest last.
    shown: Mutex<Vec<(ShownOf, &'static str, Arc<ShownScene>)>>,
}

/// The objects that a picture shows.
pub struct ShownScene {
    pub scene: Scene,
    pub world: Arc<World>,
    pub hidden: HiddenObjects,
    /// The box around them.
    pub subject: Option<Aabb>,
}

impl ViewedScene {
    /// Compiles a scene.
    ///
    /// # Errors
    /// All that is wrong with it, with the places in its file.
    pub fn new(name: String, document: Document) -> Result<ViewedScene, String> {
        let default_accel = document.scene.accel.unwrap_or(DEFAULT);
        let scene =
            ViewedScene { name, document, default_accel, worlds: Mutex::default(), shown: Mutex::default() };
        scene.world(None)?;
        Ok(scene)
    }

    /// The whole world under an accelerator.
    ///
    /// # Errors
    /// As [`ViewedScene::new`].
    pub fn world(&self, accel: Option<&'static str>) -> Result<Arc<World>, String> {
        let mut worlds = self.worlds.lock().unwrap_or_else(PoisonError::into_inner);
        let name = accel.unwrap_or("");
        if let Some(world) = worlds.get(name) {
            return Ok(Arc::clone(world));
        }
        let world = Arc::new(self.compile(&self.document.scene, accel)?);
        worlds.insert(name, Arc::clone(&world));
        Ok(world)
    }

    /// The chosen objects under an accelerator.
    ///
    /// # Errors
    /// If there is no object of a name, or the scene does not compile.
    pub fn shown(&self, chosen: &ShownOf, accel: Option<&'static str>) -> Result<Arc<ShownScene>, String> {
        let name = accel.unwrap_or("");
        let mut kept = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((.., shown)) = kept.iter().find(|(of, accel, _)| of == chosen && *accel == name) {
            return Ok(Arc::clone(shown));
        }
        let shown = Arc::new(self.show(chosen, accel)?);
        if kept.len() == KEPT {
            kept.remove(0);
        }
        kept.push((chosen.clone(), name, Arc::clone(&shown)));
        Ok(shown)
    }

    fn show(&self, chosen: &ShownOf, accel: Option<&'static str>) -> Result<ShownScene, String> {
        let scene = &self.document.scene;
        let hidden = if chosen.only.is_empty() {
            // Names that a scene had before it was read again are no mistakes.
            let known: Vec<&String> =
                chosen.hide.iter().filter(|name| scene.hiding(&[name]).is_ok()).collect();
            scene.hiding(&known)
        } else {
            scene.showing_only(&chosen.only)
        };
        let hidden = hidden.map_err(|error| error.to_string())?;
        if hidden.is_empty() || scene.has_owners() {
            // Hidden objects displace the objects around them.
            let world = self.world(accel)?;
            let subject = visible_subject(&world, scene, &hidden);
            return Ok(ShownScene { scene: scene.clone(), world, hidden, subject });
        }
        let scene = scene.without(&hidden);
        let world = Arc::new(self.compile(&scene, accel)?);
        let hidden = HiddenObjects::default();
        let subject = visible_subject(&world, &scene, &hidden);
        Ok(ShownScene { scene, world, hidden, subject })
    }

    fn compile(&self, scene: &Scene, accel: Option<&'static str>) -> Result<World, String> {
        compile::compile(scene, Options { accel })
            .map_err(|errors| self.document.diagnostics(&errors).to_string())
    }
}
