//! What is found in a scene as a whole.

use shotline::compile::{SceneError, World};
use shotline_io::Document;

use super::{Finding, Findings, Place, Severity};
use crate::number::{counted, short_vector};
use crate::survey::{self, Pair};

impl Findings {
    /// Adds the errors for which a scene cannot be compiled.
    pub fn add_errors(&mut self, document: &Document, errors: &[SceneError]) {
        let count = counted(errors.len() as u64, "error of the scene", "errors of the scene");
        let text = format!("{count}\n{}", document.explain(errors));
        let (severity, subject, first) = (Severity::Fault, "scene".into(), Place::default());
        self.add(Finding { severity, subject, kind: "scene_errors", count: errors.len(), text, first });
    }

    /// Looks for objects that overlap and for faces that lie in each other.
    pub fn examine_world(&mut self, world: &World) {
        if world.object_names().is_empty() {
            self.scene_remark("no_objects", "the scene has no objects".into(), Place::default());
        }
        for (object, why) in survey::empty(world) {
            let text = format!("'{object}' {why}");
            self.scene_remark("empty_object", text, Place { objects: vec![object], ..Place::default() });
        }
        let survey = survey::survey(world);
        self.add_pairs(
            Severity::Fault,
            "overlap",
            survey.overlaps,
            "objects of equal priority that overlap:",
        );
        self.add_pairs(
            Severity::Remark,
            "coincidence",
            survey.coincidences,
            "objects with faces in one place:",
        );
        if let Some(rays) = survey.few_rays {
            self.line(format!("overlaps were looked for on {rays} rays only: each meets very many parts"));
        }
        for what in survey.unexamined.into_iter().chain(survey::out_of_range(world)) {
            self.unexamined(what);
        }
    }

    fn scene_remark(&mut self, kind: &'static str, text: String, first: Place) {
        let (severity, subject) = (Severity::Remark, "scene".into());
        self.add(Finding { severity, subject, kind, count: 1, text, first });
    }

    fn add_pairs(&mut self, severity: Severity, kind: &'static str, pairs: Vec<Pair>, title: &str) {
        if !pairs.is_empty() {
            self.line(title);
        }
        for Pair { first, second, point, rays } in pairs {
            let (on, at) = (counted(rays as u64, "ray", "rays"), short_vector(point));
            let text = format!("'{first}' and '{second}', on {on}, as at {at}");
            let place = Place { objects: vec![first, second], point: Some(point), ..Place::default() };
            self.add(Finding { severity, subject: "scene".into(), kind, count: rays, text, first: place });
        }
    }
}
