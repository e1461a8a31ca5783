//! The picture of a slice as SVG: outlines of regions, and text that can be selected.

use std::collections::BTreeMap;
use std::fmt::{self, Write};

use shotline::compile::World;
use shotline::scene::Scene;

use super::coloring::{ColorBy, regions};
use super::figure::{Anchor, Conflicts, Figure, Fill, Mark};
use super::outline::outlines;
use super::owners::{Part, Slice};
use super::picture::HATCH;

/// The SVG of a slice: a path for each region, in the colours of [`slice_png`](super::slice_png), with axes and a legend. Along
/// the rows of pixels the boundaries are exact, to a hundred-thousandth of a pixel.
pub fn slice_svg(slice: &Slice, world: &World, scene: &Scene, by: ColorBy, conflicts: Conflicts) -> String {
    let regions = regions(slice, world, scene, by);
    let figure = Figure::new(slice, world, scene, (by, &regions), conflicts);
    let mut out = String::new();
    // A string takes everything.
    let _ = write_figure(&mut out, slice, &figure, |out| {
        for region in &regions {
            let rows = rows_of(slice, |part| by.number(part) == region.number);
            write!(
                out,
                "<path fill=\"{}\" stroke=\"{}\" d=\"",
                hex(region.color),
                hex(darker(region.color))
            )?;
            write_outlines(out, &rows)?;
            writeln!(out, "\"><title>{}</title></path>", Escaped(&region.name))?;
        }
        if figure.marks_conflicts { write_conflicts(out, slice, world) } else { Ok(()) }
    });
    out
}

fn write_figure(
    out: &mut String,
    slice: &Slice,
    figure: &Figure,
    paths: impl FnOnce(&mut String) -> fmt::Result,
) -> fmt::Result {
    let &Figure { width, height, left, top, font, .. } = figure;
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"DejaVu Sans, Verdana, sans-serif\" font-size=\"{font}\">"
    )?;
    let [a, b] = HATCH.map(hex);
    writeln!(
        out,
        "<defs><pattern id=\"conflict\" width=\"8\" height=\"8\" patternUnits=\"userSpaceOnUse\" patternTransform=\"rotate(45)\">\
         <rect width=\"8\" height=\"8\" fill=\"{b}\"/><rect width=\"5\" height=\"8\" fill=\"{a}\"/></pattern>\
         <clipPath id=\"area\"><rect width=\"{}\" height=\"{}\"/></clipPath></defs>",
        slice.width, slice.height
    )?;
    writeln!(out, "<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>")?;
    writeln!(
        out,
        "<g transform=\"translate({left} {top})\" clip-path=\"url(#area)\" stroke-width=\"0.6\" stroke-linejoin=\"round\">"
    )?;
    paths(out)?;
    writeln!(out, "</g>")?;
    for mark in &figure.marks {
        write_mark(out, mark)?;
    }
    writeln!(out, "</svg>")
}

/// The intervals of each row in which a condition holds; those that touch are joined.
fn rows_of(slice: &Slice, is_of: impl Fn(&Part) -> bool) -> Vec<Vec<[f64; 2]>> {
    let row = |parts: &Vec<Part>| joined(parts.iter().filter(|part| is_of(part)).map(|part| part.columns));
    slice.rows.iter().map(row).collect()
}

fn joined(intervals: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut out: Vec<[f64; 2]> = Vec::new();
    for [from, to] in intervals {
        match out.last_mut() {
            Some(last) if from <= last[1] => last[1] = last[1].max(to),
            _ => out.push([from, to]),
        }
    }
    out
}

/// Writes a hatched path for each pair of objects in conflict.
fn write_conflicts(out: &mut String, slice: &Slice, world: &World) -> fmt::Result {
    let mut by_pair: BTreeMap<u32, Vec<Vec<[f64; 2]>>> = BTreeMap::new();
    for (row, parts) in slice.conflicts.iter().enumerate() {
        for part in parts {
            let rows = by_pair.entry(part.pair).or_insert_with(|| vec![Vec::new(); slice.rows.len()]);
            rows[row].push(part.columns);
        }
    }
    for (pair, rows) in by_pair {
        let rows: Vec<_> = rows.into_iter().map(|row| joined(row.into_iter())).collect();
        let text = slice.pairs.get(pair as usize).map_or_else(String::new, |pair| pair.text(world));
        write!(out, "<path fill=\"url(#conflict)\" stroke=\"{}\" d=\"", hex(HATCH[0]))?;
        write_outlines(out, &rows)?;
        writeln!(out, "\"><title>{}</title></path>", Escaped(&text))?;
    }
    Ok(())
}

fn write_outlines(out: &mut String, rows: &[Vec<[f64; 2]>]) -> fmt::Result {
    for points in outlines(rows) {
        for (i, &[x, y]) in points.iter().enumerate() {
            write!(out, "{}{} {}", if i == 0 { 'M' } else { 'L' }, Short(x), Short(y))?;
        }
        out.push('Z');
    }
    Ok(())
}

fn write_mark(out: &mut String, mark: &Mark) -> fmt::Result {
    match mark {
        Mark::Swatch { left, top, width, height, fill } => {
            let fill = match fill {
                Fill::Color(color) => hex(*color),
                Fill::Hatch => "url(#conflict)".into(),
            };
            writeln!(
                out,
                "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"{fill}\" stroke=\"#404040\" stroke-width=\"0.7\"/>"
            )
        }
        Mark::Line { from, to } => writeln!(
            out,
            "<path stroke=\"#202020\" d=\"M{} {}L{} {}\"/>",
            from[0] + 0.5,
            from[1] + 0.5,
            to[0] + 0.5,
            to[1] + 0.5
        ),
        Mark::Text { at, anchor, text, whole } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            write!(out, "<text x=\"{}\" y=\"{}\" text-anchor=\"{anchor}\" fill=\"#202020\">", at[0], at[1])?;
            if let Some(whole) = whole {
                write!(out, "<title>{}</title>", Escaped(whole))?;
            }
            writeln!(out, "{}</text>", Escaped(text))
        }
    }
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn darker(color: [u8; 3]) -> [u8; 3] {
    color.map(|channel| (u32::from(channel) * 3 / 5) as u8)
}

/// A coordinate without needless digits.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}", (self.0 * 1e5).round() / 1e5 + 0.0)
    }
}

/// A text within XML. Characters that XML cannot hold are replaced.
struct Escaped<'a>(&'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for c in self.0.chars() {
            match c {
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '&' => f.write_str("&amp;")?,
                '"' => f.write_str("&quot;")?,
                c if c.is_control() || matches!(c, '\u{FFFE}' | '\u{FFFF}') => f.write_char('\u{FFFD}')?,
                c => f.write_char(c)?,
            }
        }
        Ok(())
    }
}
