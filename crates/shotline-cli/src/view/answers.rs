//! The answers to the questions of one page.

use std::sync::Arc;

use serde_json::{Value, json};
use shotline::accel;
use shotline::compile::World;
use shotline::counters::COUNTERS;
use shotline::math::{Vec3, unit};
use shotline::query::batch::Run;
use shotline::query::{Kinds, Scope};
use shotline::ray::{Ray, Span};
use shotline::scene::{Lens, Units};
use shotline_render::camera::View;
use shotline_render::slice::{
    Area, ColorBy, Conflicts, SlicePlane, SliceSettings, area_within_enclosures, slice, slice_png,
};
use shotline_render::{LOOKS, Settings, StandardView, Viewpoint, camera_of, visible_subject};

use super::answer::Answer;
use super::objects;
use super::outline_lines::lines;
use super::pane::Pane;
use super::question::{ColorByOf, PictureOf, Question, RayOf, accel_named};
use super::server::Server;
use super::stage::{Current, Stage};
use super::viewed_scene::ViewedScene;
use crate::number::{json as number, json_vector};
use crate::shoot_report::ShootReport;
use crate::trace_report::{TraceQuery, TraceReport};

/// The number of pictures that a page shows beside each other.
const PANES: usize = 2;
/// The steps of a trace that a page gets.
const MAX_STEPS: usize = 2000;
/// The pixels of a picture or of a slice for a page.
const MAX_PIXELS: u64 = 1 << 22;

/// Answers one page.
pub struct Answers<'s> {
    stage: &'s Stage,
    panes: [Option<Pane>; PANES],
    /// The version that the page knows.
    known: u64,
}

impl<'s> Answers<'s> {
    pub fn new(server: &'s Server) -> Answers<'s> {
        Answers { stage: &server.stage, panes: [None, None], known: 0 }
    }

    /// What the page should know without asking: that the scene has changed.
    pub fn news(&mut self) -> Option<Value> {
        let current = self.stage.current();
        let is_new = self.known != 0 && self.known != current.version;
        is_new.then(|| {
            self.known = current.version;
            json!({ "news": "changed" })
        })
    }

    /// Answers a question.
    pub fn answer(&mut self, id: u64, question: Question) -> Answer {
        let current = self.stage.current();
        let scene = Arc::clone(&current.scene);
        let answer = match question {
            Question::Scene => self.scene(&current),
            Question::Draw { pane, picture, coarse } => {
                return self
                    .draw(
                        &current,
                        pane,
                        picture,
                        coarse,
                        json!({ "id": id, "pane": pane, "version": current.version }),
                    )
                    .unwrap_or_else(|error| failed(id, &error));
            }
            Question::View { name, size } => viewed_from(&scene, name.as_deref(), size),
            Question::Slice { plane, size, area, by } => match sliced(&scene, plane, size, area, by) {
                Ok(bytes) => return Answer::Pixels { head: json!({ "id": id }), bytes },
                Err(error) => Err(error),
            },
            Question::Shoot { ray } => shoot(&scene, &ray),
            Question::Trace { ray, accel, query } => trace(&scene, &ray, accel.as_deref(), query),
            Question::Children { of, from } => objects::children(&scene.document.scene, of, from),
            Question::Find { text } => Ok(objects::find(&scene.document.scene, &text)),
        };
        match answer {
            Ok(answer) => Answer::Text(json!({ "id": id, "answer": answer })),
            Err(error) => failed(id, &error),
        }
    }

    fn scene(&mut self, current: &Current) -> Result<Value, String> {
        self.known = current.version;
        let viewed = &current.scene;
        let scene = &viewed.document.scene;
        let world = viewed.world(None)?;
        let enclosures: Vec<&str> = scene.enclosures();
        let hidden = scene.hiding_enclosures();
        let subject = visible_subject(&world, scene, &hidden);
        Ok(json!({
            "name": viewed.name,
            "trouble": current.trouble,
            "version": current.version,
            "units": scene.units.map(Units::name),
            "bounds": subject.map(|b| json!([json_vector(b.min), json_vector(b.max)])),
            "views": StandardView::NAMED.iter().map(|(name, _)| name).collect::<Vec<_>>(),
            "looks": LOOKS.iter().map(|look| json!({ "name": look.name, "summary": look.summary })).collect::<Vec<_>>(),
            "accels": accel::NAMES,
            "accel": viewed.default_accel,
            "counters": COUNTERS.iter().map(|counter| counter.name).collect::<Vec<_>>(),
            "enclosures": enclosures,
        }))
    }

    fn draw(
        &mut self,
        current: &Current,
        number: usize,
        picture: PictureOf,
        coarse: u32,
        head: Value,
    ) -> Result<Answer, String> {
        let pane = self.panes.get_mut(number).ok_or("there is no such pane")?;
        expect_size(picture.size)?;
        if !pane.as_ref().is_some_and(|pane| pane.is_of(&picture, current.version)) {
            *pane = None;
            let accel = accel_named(picture.accel.as_deref())?;
            let shown = current.scene.shown(&picture.shown, accel)?;
            *pane = Some(Pane::new(picture, current.version, shown, coarse)?);
        }
        match pane {
            Some(picture) => picture.advance(head),
            None => Err("there is no picture".into()),
        }
    }
}

fn failed(id: u64, error: &str) -> Answer {
    Answer::Text(json!({ "id": id, "error": error }))
}

fn expect_size([width, height]: [u32; 2]) -> Result<(), String> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 || pixels > MAX_PIXELS {
        return Err(format!(
            "a picture of {width}x{height} pixels cannot be shown: at most {MAX_PIXELS} pixels"
        ));
    }
    Ok(())
}

/// The camera of a view of everything but what encloses it.
fn viewed_from(viewed: &ViewedScene, name: Option<&str>, [width, height]: [u32; 2]) -> Result<Value, String> {
    expect_size([width, height])?;
    let scene = &viewed.document.scene;
    let view = name.map(str::parse).transpose()?;
    let viewpoint = Viewpoint { view, ..Viewpoint::default() };
    let settings = Settings { width, height, viewpoint, ..Settings::default() };
    let subject = visible_subject(&*viewed.world(None)?, scene, &scene.hiding_enclosures());
    camera_of(subject, scene, &settings).map(|camera| camera_json(&camera)).map_err(|error| error.to_string())
}

fn camera_json(camera: &shotline::scene::Camera) -> Value {
    let (fov, height) = match camera.lens {
        Lens::Pinhole { fov } => (Some(fov), None),
        Lens::Orthographic { height } => (None, Some(height)),
    };
    json!({
        "eye": json_vector(camera.eye),
        "target": json_vector(camera.target),
        "up": json_vector(camera.up),
        "fov": fov,
        "height": height,
    })
}

/// The ray that a page asks about, with a direction of length 1.
fn ray_of(ray: &RayOf) -> Result<Ray, String> {
    let (origin, direction) = match ray {
        RayOf::Given { origin, direction } => (Vec3::from(*origin), Vec3::from(*direction)),
        RayOf::Pixel { camera, size, at } => {
            expect_size(*size)?;
            let view = View::new(&camera.camera(), size[0], size[1]).map_err(|error| error.to_string())?;
            let ray = view.ray(at[0], at[1]).map_err(|error| error.to_string())?;
            (ray.origin(), ray.direction())
        }
    };
    if direction == Vec3::ZERO {
        return Err("the direction of a ray is not zero".into());
    }
    Ray::new(origin, unit(direction)).map_err(|error| error.to_string())
}

fn shoot(scene: &ViewedScene, ray: &RayOf) -> Result<Value, String> {
    let world = scene.world(None)?;
    let units = scene.document.scene.units;
    let report = ShootReport::new(&world, ray_of(ray)?, Span::FORWARD, Kinds::All, units);
    report.map(|report| report.to_json()).map_err(|error| error.to_string())
}

fn trace(scene: &ViewedScene, ray: &RayOf, accel: Option<&str>, query: TraceQuery) -> Result<Value, String> {
    let world = scene.world(accel_named(accel)?)?;
    let ray = ray_of(ray)?;
    let scope = Scope { span: Span::FORWARD, kinds: Kinds::All };
    let report =
        TraceReport::new(&world, &ray, scope, query, MAX_STEPS).map_err(|error| error.to_string())?;
    Ok(json!({
        "origin": json_vector(ray.origin()),
        "direction": json_vector(ray.direction()),
        "steps": steps(&report, &world),
        "left_out": report.trace().left_out,
    }))
}

/// Each step as a line of text, and the lines that show what it is about.
fn steps(report: &TraceReport, world: &World) -> Vec<Value> {
    let bounds = world.finite_bounds();
    let step = |step: &shotline::trace::Step| {
        let shape = step.outline.zip(step.frame);
        let lines = shape.map(|(outline, frame)| lines(&outline, &frame, &bounds)).unwrap_or_default();
        let lines: Vec<Vec<Value>> =
            lines.iter().map(|line| line.iter().map(|p| json_vector(*p)).collect()).collect();
        json!({
            "depth": step.depth,
            "t": step.t.map_or(Value::Null, number),
            "text": report.text_of(step),
            "lines": lines,
        })
    };
    report.trace().steps.iter().map(step).collect()
}

fn sliced(
    viewed: &ViewedScene,
    [x, y, z, height]: [f64; 4],
    size: [u32; 2],
    area: Option<[f64; 4]>,
    by: ColorByOf,
) -> Result<Vec<u8>, String> {
    expect_size(size)?;
    let plane = SlicePlane::new(Vec3::new(x, y, z), height).map_err(|error| error.to_string())?;
    let area = area.map(|[u0, v0, u1, v1]| Area::new([u0, v0], [u1, v1])).transpose();
    let (scene, size) = (&viewed.document.scene, Some((size[0], size[1])));
    let settings = SliceSettings {
        plane,
        area: area
            .map_err(|error| error.to_string())?
            .or_else(|| area_within_enclosures(scene, &plane, size)),
        size,
    };
    let world = viewed.world(None)?;
    let by = match by {
        ColorByOf::Object => ColorBy::Object,
        ColorByOf::Material => ColorBy::Material,
        ColorByOf::Instance => ColorBy::Instance,
    };
    let slice = slice(&world, &settings, Run::default()).map_err(|error| error.to_string())?;
    Ok(slice_png(&slice, &world, scene, by, Conflicts::Marked))
}
