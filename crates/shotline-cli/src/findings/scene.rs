//! Findings in the scene as a whole.

use shotline::compile::{SceneError, World};
use shotline::query::ConflictKind;
use shotline::scene::Scene;
use shotline_io::Document;

use super::{Finding, Findings, Location, Severity};
use crate::empty_objects;
use crate::number::{counted, grouped, short, short_vector};
use crate::overlap::{Extent, ObjectPair, sample_world};

impl Findings {
    /// Adds the errors for which a scene cannot be compiled.
    pub fn add_errors(&mut self, document: &Document, errors: &[SceneError]) {
        let count = counted(errors.len() as u64, "error of the scene", "errors of the scene");
        let text = format!("{count}\n{}", document.diagnostics(errors));
        let (severity, subject, first) = (Severity::Fault, "scene".into(), Location::default());
        self.add(Finding { severity, subject, kind: "scene_errors", count: errors.len(), text, first });
    }

    /// Examines a world for overlaps of objects, coincident faces and empty objects.
    pub fn examine_world(&mut self, world: &World, scene: &Scene) {
        if world.object_names().is_empty() {
            let (severity, subject) = (Severity::Fault, "scene".into());
            let (text, first) = ("the scene has no objects".into(), Location::default());
            return self.add(Finding { severity, subject, kind: "no_objects", count: 1, text, first });
        }
        let sampling = sample_world(world);
        for object in empty_objects::by_construction(world, scene) {
            self.add_empty(world, object, "is empty: its parts have no point in common, or it has no parts");
        }
        for (object, rays) in empty_objects::unmet(world, &sampling.met) {
            let rays = grouped(rays as u64);
            let text =
                format!("seems to be empty: none of {rays} rays through the boxes of its parts meets it");
            self.add_empty(world, object, &text);
        }
        let (protrusions, overlaps): (Vec<_>, Vec<_>) =
            sampling.overlaps.into_iter().partition(|pair| pair.kind == ConflictKind::Protrusion);
        self.add_pairs(Severity::Fault, "overlap", overlaps, "objects of equal priority that overlap:");
        self.add_pairs(
            Severity::Fault,
            "protrusion",
            protrusions,
            "objects that stick out of what contains them and clips them:",
        );
        self.add_pairs(
            Severity::Remark,
            "coincidence",
            sampling.coincidences,
            "objects with coincident faces:",
        );
        if let Some(rays) = sampling.few_rays {
            self.line(format!("only {rays} rays were cast to find overlaps: each meets very many parts"));
        }
        for what in sampling.unexamined {
            self.unexamined(what);
        }
    }

    fn add_empty(&mut self, world: &World, object: u32, text: &str) {
        let name = &world.object_names()[object as usize];
        let first = Location { objects: vec![name.clone()], ..Location::default() };
        let (severity, subject, text) = (Severity::Remark, "scene".into(), format!("'{name}' {text}"));
        self.add(Finding { severity, subject, kind: "empty_object", count: 1, text, first });
    }

    fn add_pairs(&mut self, severity: Severity, kind: &'static str, pairs: Vec<ObjectPair>, title: &str) {
        if !pairs.is_empty() {
            self.line(title);
        }
        for ObjectPair { kind: of, first, second, point, rays, extent } in pairs {
            let (on, at) = (counted(rays as u64, "ray", "rays"), short_vector(point));
            let mut text = match of {
                _ if first == second => format!("two placements of '{first}', on {on}, as at {at}"),
                ConflictKind::Overlap => format!("'{first}' and '{second}', on {on}, as at {at}"),
                ConflictKind::Protrusion => format!("'{first}' out of '{second}', on {on}, as at {at}"),
            };
            if let Some(Extent { depth, volume }) = extent {
                text +=
                    &format!(": about {} deep there, with a volume of about {}", short(depth), short(volume));
            }
            let first = Location { objects: vec![first, second], point: Some(point), ..Location::default() };
            self.add(Finding { severity, subject: "scene".into(), kind, count: rays, text, first });
        }
    }
}
