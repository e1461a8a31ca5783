//! The picture of one ray in its scene: seen from beside the ray, with objects that are seen through, the ray drawn over them,
//! its crossings as numbered dots, and a legend beside it.

mod beside;
mod paint;

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::query::Segment;
use shotline::query::batch::Run;
use shotline::ray::{Ray, Span};
use shotline::scene::Scene;

use self::beside::{camera_beside, span_in_picture};
use self::paint::grey;
use crate::background::Background;
use crate::camera::View;
use crate::error::RenderError;
use crate::framing;
use crate::image::Image;
use crate::opacity::Opacities;
use crate::render::render;
use crate::settings::Settings;
use crate::surface_material::surface_materials;
use crate::text;

/// How opaque all objects are.
const OPACITY: f64 = 0.3;
/// The size of letters, and the distance of lines of text.
const FONT: f32 = 13.0;
const LINE: f64 = 18.0;
/// Between the legend and the border, and around its text.
const MARGIN: f64 = 10.0;
/// The distance of numbers from the ray.
const BESIDE: f64 = 15.0;

/// A crossing of a ray, to be drawn as a numbered dot.
#[derive(Clone, Debug)]
pub struct RayMark {
    /// The ray parameter; what is infinite is in the legend only.
    pub t: f64,
    /// The text of its line in the legend.
    pub label: String,
}

/// A ray and what is drawn of it.
#[derive(Clone, Debug)]
pub struct RayDrawing<'a> {
    /// The ray.
    pub ray: Ray,
    /// The part of it that is drawn.
    pub span: Span,
    /// Its parts inside objects, ascending: they are thick, in the colours of the objects.
    pub segments: &'a [Segment],
    /// Its crossings, ascending; they are numbered from 1.
    pub marks: &'a [RayMark],
}

/// Makes the picture of a ray in its scene, with a legend to the right of it. The size without the legend, the samples and what is
/// hidden are those of the settings.
///
/// # Errors
/// [`RenderError`]; [`RenderError::NothingToFrame`] if neither the scene nor the ray has anything of finite size.
pub fn render_ray(
    world: &World,
    scene: &Scene,
    drawing: &RayDrawing,
    settings: &Settings,
    run: Run,
) -> Result<Image, RenderError> {
    let ratio = f64::from(settings.width) / f64::from(settings.height);
    let subject = framing::visible_subject(world, scene, &settings.hidden);
    let bounds = drawing.bounds(subject);
    let camera = camera_beside(&drawing.ray, &bounds, ratio).ok_or(RenderError::NothingToFrame)?;
    // The name `*` is that of all objects; a scene without any has none to see through.
    let opacities = Opacities::new(scene, &[("*", OPACITY)]).unwrap_or_default();
    let background = settings.background.or(Some(Background::WHITE));
    let settings = Settings { camera: Some(camera), opacities, edges: true, background, ..settings.clone() };
    let mut image = render(world, scene, &settings, run)?;
    let view = View::new(&camera, settings.width, settings.height)?;
    let shown = span_in_picture(&drawing.ray, drawing.span, &camera, ratio);
    drawing.draw_ray(&mut image, &view, shown, world, scene);
    let listed = drawing.listed(settings.height);
    drawing.draw_marks(&mut image, &view, listed);
    Ok(drawing.with_legend(image, listed))
}

impl RayDrawing<'_> {
    /// A box around everything of finite size and the crossings near to it: a ground that the ray meets far away must not make
    /// the rest small. Around all crossings if nothing has a finite size.
    fn bounds(&self, subject: Option<Aabb>) -> Aabb {
        let near = subject.map(|bounds| {
            let margin = bounds.size() / 2.0;
            Aabb::new(bounds.min - margin, bounds.max + margin)
        });
        let points = self.marks.iter().filter(|mark| mark.t.is_finite()).map(|mark| self.ray.at(mark.t));
        points
            .map(|point| Aabb::new(point, point))
            .filter(|point| near.is_none_or(|near| near.union(point) == near))
            .fold(subject.unwrap_or(Aabb::EMPTY), |bounds, point| bounds.union(&point))
    }

    /// Thin where it is outside of all objects, thick and in their colours inside.
    fn draw_ray(
        &self,
        image: &mut Image,
        view: &View,
        shown: Option<[f64; 2]>,
        world: &World,
        scene: &Scene,
    ) {
        let Some([from, to]) = shown else { return };
        let at = |t: f64| view.position(self.ray.at(t));
        image.line([at(from), at(to)], 1.6, grey(0.15));
        let materials = surface_materials(world, scene);
        let inside = self.segments.iter().map(|s| (s, [s.t_in.max(from), s.t_out.min(to)]));
        let inside: Vec<_> = inside.filter(|(_, [t_in, t_out])| t_in < t_out).collect();
        for (_, [t_in, t_out]) in &inside {
            image.line([at(*t_in), at(*t_out)], 7.0, grey(0.15));
        }
        for (segment, [t_in, t_out]) in inside {
            let color = materials.get(segment.object as usize).map_or(grey(0.5), |material| material.color);
            image.line([at(t_in), at(t_out)], 4.6, color);
        }
        if from == self.span.t_min() {
            // Where the ray begins, and an arrow where it goes on.
            image.disc(at(from), 3.0, grey(0.15));
        }
        self.draw_arrow(image, view, to);
    }

    /// An arrow at the end of the ray, or where it leaves the picture.
    fn draw_arrow(&self, image: &mut Image, view: &View, end: f64) {
        let [x, y] = view.position(self.ray.at(end));
        let [right, down] = self.on_picture(view);
        let (width, height) = (f64::from(image.width()), f64::from(image.height()));
        // Back from the end into the picture.
        let back = |x: f64, along: f64, side: f64| match along {
            a if a > 0.0 => (x - (side - MARGIN)) / a,
            a if a < 0.0 => (x - MARGIN) / a,
            _ => 0.0,
        };
        let back = back(x, right, width).max(back(y, down, height)).max(0.0);
        let tip = [x - back * right, y - back * down];
        for turn in [2.6f64, -2.6] {
            let (sin, cos) = turn.sin_cos();
            let barb = [right * cos - down * sin, right * sin + down * cos];
            image.line([tip, [tip[0] + 11.0 * barb[0], tip[1] + 11.0 * barb[1]]], 1.8, grey(0.15));
        }
    }

    /// The direction of the ray in the picture: to the right and down, of length 1.
    fn on_picture(&self, view: &View) -> [f64; 2] {
        let d = self.ray.direction();
        let (right, down) = (d.dot(view.right()), -d.dot(view.up()));
        let length = right.hypot(down);
        if length > 0.0 { [right / length, down / length] } else { [1.0, 0.0] }
    }

    /// How many crossings have a number and a line in the legend of a picture of a height.
    fn listed(&self, height: u32) -> usize {
        let lines = ((f64::from(height) - 4.0 * MARGIN) / LINE).max(1.0) as usize;
        if self.marks.len() > lines { lines - 1 } else { self.marks.len() }
    }

    /// Dots on the ray, with numbers beside it, in turn on both sides; further away where they would cover each other.
    fn draw_marks(&self, image: &mut Image, view: &View, listed: usize) {
        let [right, down] = self.on_picture(view);
        let mut ends = [[f64::NEG_INFINITY; 4]; 2];
        for (number, mark) in self.marks.iter().enumerate().filter(|(_, mark)| mark.t.is_finite()) {
            let dot = view.position(self.ray.at(mark.t));
            image.disc(dot, 4.2, grey(1.0));
            image.disc(dot, 3.2, grey(0.1));
            if number >= listed {
                continue;
            }
            let letters = (number + 1).to_string();
            let width = f64::from(text::width(&letters, FONT));
            let along = dot[0] * right + dot[1] * down;
            let side = number % 2;
            let free = ends[side].iter().position(|end| along - width / 2.0 > *end + 3.0).unwrap_or(3);
            ends[side][free] = along + width / 2.0;
            let distance = (BESIDE + LINE * free as f64) * if side == 0 { 1.0 } else { -1.0 };
            let middle = [dot[0] + down * distance, dot[1] - right * distance];
            if free > 0 {
                image.line([dot, middle], 0.8, grey(0.45));
            }
            image.disc(middle, 0.5 * width.max(8.0) + 3.0, grey(1.0));
            image.write([middle[0] - width / 2.0, middle[1] + 4.5], FONT, grey(0.1), &letters);
        }
    }

    /// The picture with the legend to the right of it, where it covers nothing.
    fn with_legend(&self, image: Image, listed: usize) -> Image {
        let mut lines: Vec<String> = (1..)
            .zip(&self.marks[..listed])
            .map(|(number, mark)| format!("{number}   {}", mark.label))
            .collect();
        match self.marks.len() - listed {
            0 if listed == 0 => lines.push("the ray crosses nothing".into()),
            0 => {}
            more => lines.push(format!("and {more} more")),
        }
        let widest = lines.iter().map(|line| text::width(line, FONT)).fold(0.0f32, f32::max);
        let left = f64::from(image.width()) + MARGIN;
        let mut image = image.widened((f64::from(widest) + 2.0 * MARGIN).ceil() as u32, grey(1.0));
        for (row, line) in lines.iter().enumerate() {
            let baseline = MARGIN + LINE * (row as f64 + 1.0);
            image.write([left, baseline], FONT, grey(0.1), line);
        }
        image
    }
}
