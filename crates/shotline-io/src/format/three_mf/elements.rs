//! Typed access to the elements of a model. Every error marks an attribute or a start tag.

use shotline::math::Affine;

use crate::diagnostic::RawDiagnostic;
use crate::xml::place_of;

/// An element of the tree.
pub(super) type Element<'a> = roxmltree::Node<'a, 'a>;

/// What a part of the reader returns.
pub(super) type Found<T> = Result<T, RawDiagnostic>;

/// The extension that lets a package have several models.
pub(super) const PRODUCTION: &str = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";

/// The elements directly below.
pub(super) fn elements<'a>(element: Element<'a>) -> impl Iterator<Item = Element<'a>> {
    element.children().filter(|child| child.is_element())
}

/// The name of an element.
pub(super) fn tag<'a>(element: Element<'a>) -> &'a str {
    element.tag_name().name()
}

/// The first element below with this name.
pub(super) fn child<'a>(element: Element<'a>, name: &str) -> Option<Element<'a>> {
    elements(element).find(|child| tag(*child) == name)
}

/// An error that marks an attribute of an element, or its start tag.
pub(super) fn error(element: Element, attribute: &str, message: impl Into<String>) -> RawDiagnostic {
    RawDiagnostic::text(place_of(element, attribute), message)
}

/// An attribute that must be there.
pub(super) fn required<'a>(element: Element<'a>, name: &str) -> Found<&'a str> {
    let message = || format!("<{}> has no attribute '{name}'", tag(element));
    element.attribute(name).ok_or_else(|| error(element, "", message()))
}

/// A whole number of at least 0; `None` if there is no such attribute.
pub(super) fn whole(element: Element, name: &str) -> Found<Option<u32>> {
    let Some(text) = element.attribute(name) else { return Ok(None) };
    let number = text.trim().parse::<u32>().map(Some);
    number.map_err(|_| error(element, name, format!("'{}' is not a whole number of at least 0", cut(text))))
}

/// A whole number that must be there.
pub(super) fn required_whole(element: Element, name: &str) -> Found<u32> {
    required(element, name)?;
    Ok(whole(element, name)?.unwrap_or(0))
}

/// A finite number that must be there.
pub(super) fn number(element: Element, name: &str) -> Found<f64> {
    let text = required(element, name)?;
    finite(text).map_err(|why| error(element, name, why))
}

fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("{} is not finite", cut(text))),
        Err(_) => Err(format!("'{}' is not a number", cut(text))),
    }
}

/// The transform of an element; `None` if it has none, or the identity. It is written for vectors that are rows: three
/// images of the axes, and a shift.
pub(super) fn transform(element: Element) -> Found<Option<Affine>> {
    const NAME: &str = "transform";
    let Some(text) = element.attribute(NAME) else { return Ok(None) };
    let mut m = [0.0; 12];
    let mut words = text.split_ascii_whitespace();
    for number in &mut m {
        let word = words.next().ok_or_else(|| wrong_count(element))?;
        *number = finite(word).map_err(|why| error(element, NAME, why))?;
    }
    if words.next().is_some() {
        return Err(wrong_count(element));
    }
    let row = |i: usize| [m[i], m[3 + i], m[6 + i], m[9 + i]];
    let affine = Affine { rows: [row(0), row(1), row(2)] };
    Ok((!affine.is_identity()).then_some(affine))
}

fn wrong_count(element: Element) -> RawDiagnostic {
    error(element, "transform", "a transform is 12 numbers").help("no transform is 1 0 0 0 1 0 0 0 1 0 0 0")
}

/// A colour `#RRGGBB` or `#RRGGBBAA` as four numbers from 0 to 1, which are sRGB.
pub(super) fn color(element: Element, name: &str) -> Found<[f64; 4]> {
    let text = required(element, name)?;
    let digits = text.trim().strip_prefix('#').unwrap_or("");
    let is_color = matches!(digits.len(), 6 | 8) && digits.bytes().all(|b| b.is_ascii_hexdigit());
    let Some(bits) = u32::from_str_radix(digits, 16).ok().filter(|_| is_color) else {
        let message = format!("'{}' is no colour", cut(text));
        return Err(error(element, name, message).help("colours are written as #RRGGBB or #RRGGBBAA"));
    };
    let bits = if digits.len() == 6 { bits << 8 | 0xFF } else { bits };
    Ok(bits.to_be_bytes().map(|byte| f64::from(byte) / 255.0))
}

/// A word for a message.
pub(super) fn cut(text: &str) -> String {
    text.chars().take(40).collect()
}
