//! What is viewed now. A scene that was read from files is read again when they change.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use shotline_io::Document;

use super::viewed_scene::ViewedScene;
use crate::flags::Model;
use crate::{failure::Failure, input};

/// How often files are looked at.
const PAUSE: Duration = Duration::from_millis(300);

/// Where the scene comes from.
pub enum Source {
    /// From a file, which is watched.
    File(Box<Model>),
    /// From memory, with a name.
    Memory(String),
}

impl Source {
    /// The name that the page shows.
    fn name(&self) -> String {
        match self {
            Source::File(model) => {
                let path = &model.path;
                path.file_name().map_or_else(|| model.name(), |name| name.to_string_lossy().into_owned())
            }
            Source::Memory(name) => name.clone(),
        }
    }

    /// The files whose change changes the scene.
    fn files(&self, document: &Document) -> Vec<PathBuf> {
        match self {
            Source::File(model) => {
                let mut files = vec![model.path.clone()];
                files.extend(input::named_files(model, document));
                files.sort();
                files.dedup();
                files
            }
            Source::Memory(_) => Vec::new(),
        }
    }
}

/// What is viewed now.
pub struct Stage {
    source: Source,
    now: Mutex<Now>,
}

struct Now {
    scene: Arc<ViewedScene>,
    /// Why the files, as they are now, are not what is viewed.
    trouble: Option<String>,
    /// Changes with every reading.
    version: u64,
    files: Vec<(PathBuf, Option<SystemTime>)>,
    looked_at: Instant,
}

/// What is viewed, and how current it is.
#[derive(Clone)]
pub struct Current {
    pub scene: Arc<ViewedScene>,
    pub trouble: Option<String>,
    pub version: u64,
}

impl Stage {
    /// Puts a scene on the stage.
    ///
    /// # Errors
    /// If the scene does not compile.
    pub fn new(source: Source, document: Document) -> Result<Stage, Failure> {
        let files = with_times(source.files(&document));
        let scene = Arc::new(ViewedScene::new(source.name(), document).map_err(Failure::new)?);
        let now = Now { scene, trouble: None, version: 1, files, looked_at: Instant::now() };
        Ok(Stage { source, now: Mutex::new(now) })
    }

    /// What is viewed now, after a look at the files.
    pub fn current(&self) -> Current {
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        if let Source::File(model) = &self.source
            && now.looked_at.elapsed() >= PAUSE
        {
            now.looked_at = Instant::now();
            // What is no file now, such as a pipe, would not end.
            let is_file = model.path.metadata().is_ok_and(|data| data.is_file());
            if is_file && now.files.iter().any(|(path, time)| modified(path) != *time) {
                self.read_again(model, &mut now);
            }
        }
        Current { scene: Arc::clone(&now.scene), trouble: now.trouble.clone(), version: now.version }
    }

    /// Reads the files. If that fails, the scene before stays, with the reason.
    fn read_again(&self, model: &Model, now: &mut Now) {
        // The times are taken first: a file that changes while it is read is read once more.
        let times = with_times(now.files.iter().map(|(path, _)| path.clone()).collect());
        let read = input::load(model).map_err(|failure| failure.text()).and_then(|document| {
            let files = self.source.files(&document);
            Ok((files, ViewedScene::new(self.source.name(), document)?))
        });
        now.version += 1;
        now.files = times;
        match read {
            Ok((files, scene)) => {
                let new = files.into_iter().filter(|file| now.files.iter().all(|(known, _)| known != file));
                now.files.extend(with_times(new.collect()));
                (now.scene, now.trouble) = (Arc::new(scene), None);
            }
            Err(why) => now.trouble = Some(why),
        }
    }
}

fn modified(path: &Path) -> Option<SystemTime> {
    path.metadata().and_then(|data| data.modified()).ok()
}

fn with_times(files: Vec<PathBuf>) -> Vec<(PathBuf, Option<SystemTime>)> {
    let with_time = |path: PathBuf| {
        let time = modified(&path);
        (path, time)
    };
    files.into_iter().map(with_time).collect()
}
