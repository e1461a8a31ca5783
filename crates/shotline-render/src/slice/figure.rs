//! The frame of the picture of a slice: title, axes with ticks, and legend, as marks that are drawn as PNG and as SVG.

use shotline::compile::World;
use shotline::scene::Scene;

use super::coloring::{ColorBy, Region};
use super::owners::Slice;
use super::ticks::ticks;
use crate::text;

/// Where a text is in relation to its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// The fill of a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fill {
    Color([u8; 3]),
    /// That of overlaps.
    Hatch,
}

/// Something in a picture. Positions are in pixels from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// A rectangle with a thin outline.
    Swatch { left: f32, top: f32, width: f32, height: f32, fill: Fill },
    /// A thin line.
    Line { from: [f32; 2], to: [f32; 2] },
    /// A line of text. The whole text, if only a part of it is shown, is in `whole`.
    Text { at: [f32; 2], anchor: Anchor, text: String, whole: Option<String> },
}

/// The picture of a slice without the slice.
#[derive(Clone, Debug)]
pub struct Figure {
    pub width: u32,
    pub height: u32,
    /// The upper left corner of the slice.
    pub left: u32,
    pub top: u32,
    /// The size of letters.
    pub font: f32,
    pub marks: Vec<Mark>,
    /// The colour of each region by its number, ascending.
    pub colors: Vec<(i64, [u8; 3])>,
    /// Whether conflicts are marked.
    pub marks_conflicts: bool,
}

/// Whether overlaps and protrusions are marked in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Conflicts {
    /// Only what owns each pixel is shown.
    #[default]
    Hidden,
    /// They are hatched, and named in the legend.
    Marked,
}

/// The most letters of a name in the legend, and of a pair of names.
const MAX_NAME: usize = 34;
const MAX_PAIR: usize = 52;

/// The fewest lines for which a legend has room.
const MIN_LINES: usize = 8;

impl Figure {
    pub fn new(
        slice: &Slice,
        world: &World,
        scene: &Scene,
        (by, regions): (ColorBy, &[Region]),
        conflicts: Conflicts,
    ) -> Figure {
        let font = (slice.width.max(slice.height) as f32 / 56.0).clamp(12.0, 80.0).round();
        let units = scene.units.map_or_else(String::new, |units| format!(" {units}"));
        let mut colors: Vec<(i64, [u8; 3])> = regions.iter().map(|r| (r.number, r.color)).collect();
        colors.sort_unstable();
        let marks_conflicts = conflicts == Conflicts::Marked;
        let (width, height) = (0, 0);
        let mut figure =
            Figure { width, height, left: 0, top: 0, font, marks: Vec::new(), colors, marks_conflicts };
        figure.axes(slice, &units);
        let title = format!("{}{units}, by {}", slice.plane, by.name());
        let at = [figure.left as f32 + 0.5 * font, figure.top as f32 - 0.9 * font];
        figure.text(at, Anchor::Start, title, None);
        let pairs = if marks_conflicts { &slice.pairs[..] } else { &[] };
        let mut entries: Vec<(Fill, String)> =
            pairs.iter().map(|pair| (Fill::Hatch, pair.text(world))).collect();
        let most_pairs = figure.lines(slice.height) / 2;
        if entries.len() > most_pairs {
            let more = entries.len() + 1 - most_pairs;
            entries.truncate(most_pairs - 1);
            entries.push((Fill::Hatch, format!("{more} more pairs")));
        }
        entries.extend(regions.iter().map(|r| (Fill::Color(r.color), r.name.clone())));
        figure.legend(slice, entries);
        figure
    }

    /// The colour of a region.
    pub fn color(&self, number: i64) -> [u8; 3] {
        let place = self.colors.binary_search_by_key(&number, |(number, _)| *number);
        place.map_or([0; 3], |place| self.colors[place].1)
    }

    /// The distance of lines of text.
    fn line(&self) -> f32 {
        (1.5 * self.font).round()
    }

    /// The lines of the legend beside a slice of some height.
    fn lines(&self, height: u32) -> usize {
        ((height as f32 / self.line()) as usize).max(MIN_LINES)
    }

    fn text(&mut self, at: [f32; 2], anchor: Anchor, text: String, whole: Option<String>) {
        self.marks.push(Mark::Text { at, anchor, text, whole });
    }

    /// Finds the place of the slice, and adds the axes.
    fn axes(&mut self, slice: &Slice, units: &str) {
        let font = self.font;
        let (width, height) = (slice.width as f32, slice.height as f32);
        let most = |length: f32, letter: f32| ((length / (letter * font)) as usize).clamp(2, 10);
        let ([u0, v0], [u1, v1]) = (slice.area.min, slice.area.max);
        let (across, along) = (ticks(u0, u1, most(width, 4.5)), ticks(v0, v1, most(height, 3.5)));
        let widest = along.iter().map(|tick| text::width(&tick.label, font)).fold(2.0 * font, f32::max);
        let tick = (0.4 * font).round();
        let [u_name, v_name] = slice.plane.axis_names();
        let unit = if units.is_empty() { String::new() } else { format!(" ({})", units.trim()) };
        let v_label = format!("{v_name}{unit}");
        let beside = (widest + tick + 0.3 * font).max(text::width(&v_label, font) + 0.5 * font);
        self.left = (beside + 0.8 * font).ceil() as u32;
        self.top = (2.4 * font).ceil() as u32;
        let (left, top) = (self.left as f32, self.top as f32);
        let (right, bottom) = (left + width, top + height);
        // A frame just outside of the slice.
        let frame = [[left - 1.0, top - 1.0], [left - 1.0, bottom], [right, bottom], [right, top - 1.0]];
        for (from, to) in frame.into_iter().zip(frame.into_iter().cycle().skip(1)) {
            self.marks.push(Mark::Line { from, to });
        }
        for tick_u in across {
            let x = left + ((tick_u.value - u0) / (u1 - u0)) as f32 * width;
            self.marks.push(Mark::Line { from: [x, bottom], to: [x, bottom + tick] });
            self.text([x, bottom + tick + 1.1 * font], Anchor::Middle, tick_u.label, None);
        }
        for tick_v in along {
            let y = top + ((v1 - tick_v.value) / (v1 - v0)) as f32 * height;
            self.marks.push(Mark::Line { from: [left - tick, y], to: [left, y] });
            self.text([left - tick - 0.3 * font, y + 0.36 * font], Anchor::End, tick_v.label, None);
        }
        let at = [left + width / 2.0, bottom + tick + 2.6 * font];
        self.text(at, Anchor::Middle, format!("{u_name}{unit}"), None);
        self.text([left - 0.5 * font, top - 0.9 * font], Anchor::End, v_label, None);
        self.width = (right + 1.5 * font).ceil() as u32;
        self.height = (bottom + tick + 3.4 * font).ceil() as u32;
    }

    /// Adds the legend, and the room for it.
    fn legend(&mut self, slice: &Slice, entries: Vec<(Fill, String)>) {
        let (font, line) = (self.font, self.line());
        let most = self.lines(slice.height);
        let left = (self.left + slice.width) as f32 + 1.5 * font;
        let (count, shown) = (entries.len(), if entries.len() > most { most - 1 } else { entries.len() });
        let mut widest = 0.0f32;
        for (place, (fill, name)) in (0u16..).zip(entries.into_iter().take(shown)) {
            let top = self.top as f32 + f32::from(place) * line;
            let side = font;
            self.marks.push(Mark::Swatch { left, top, width: 1.3 * side, height: side, fill });
            let short = shortened(&name, if fill == Fill::Hatch { MAX_PAIR } else { MAX_NAME });
            widest = widest.max(text::width(&short, font));
            let whole = (short != name).then_some(name);
            self.text([left + 1.9 * font, top + 0.87 * font], Anchor::Start, short, whole);
        }
        let mut lines = shown;
        if shown < count {
            let more = format!("and {} more", count - shown);
            widest = widest.max(text::width(&more, font));
            let top = self.top as f32 + shown as f32 * line;
            self.text([left + 1.9 * font, top + 0.87 * font], Anchor::Start, more, None);
            lines += 1;
        }
        if lines > 0 {
            self.width = (left + 1.9 * font + widest + font).ceil() as u32;
        }
        let title = self.title_end();
        self.width = self.width.max((title + font).ceil() as u32);
        self.height = self.height.max((self.top as f32 + lines as f32 * line + font).ceil() as u32);
    }

    /// The right end of the texts that begin at the left side of the slice.
    fn title_end(&self) -> f32 {
        let end = |mark: &Mark| match mark {
            Mark::Text { at, anchor: Anchor::Start, text, .. } => at[0] + text::width(text, self.font),
            _ => 0.0,
        };
        self.marks.iter().map(end).fold(0.0, f32::max)
    }
}

/// A text of at most so many letters; what is left out is in its middle, for names often differ at their ends. Control
/// characters are replaced.
fn shortened(text: &str, most: usize) -> String {
    let letters: Vec<char> = text.chars().map(|c| if c.is_control() { '\u{FFFD}' } else { c }).collect();
    if letters.len() <= most {
        return letters.into_iter().collect();
    }
    let (head, tail) = (most / 2, most - most / 2 - 1);
    let parts = [&letters[..head], &['…'], &letters[letters.len() - tail..]];
    parts.concat().into_iter().collect()
}
