//! Accessors: typed views of the buffers. Offsets, strides and counts are checked before anything is read, and what the
//! accessors of a file stand for is bounded by its size.

use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use super::buffers::Buffers;
use super::fields::{Field, List, Read};
use crate::diagnostic::RawDiagnostic;

/// Values of some numbers each.
#[derive(Debug)]
pub(super) struct Values {
    pub(super) width: usize,
    pub(super) numbers: Vec<f64>,
}

impl Values {
    /// How many values there are.
    pub(super) fn count(&self) -> usize {
        self.numbers.len() / self.width
    }
}

/// How many numbers a small file may stand for, and how many more for each of its bytes. A number takes at least a byte of
/// the buffers, unless accessors overlap or have no buffer.
const FREE: usize = 1 << 20;
const PER_BYTE: usize = 4;

/// The accessors of a file.
pub(super) struct Accessors<'j, 'b> {
    list: List<'j>,
    views: List<'j>,
    buffers: Buffers<'b>,
    known: HashMap<usize, Rc<Values>>,
    /// How many more numbers may be read.
    left: usize,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// An accessor whose values are of one type.
struct Layout<'j> {
    field: Field<'j>,
    count: usize,
    component: Component,
    normalized: bool,
    width: usize,
}

impl Component {
    fn of(field: Field) -> Read<Component> {
        let found = match field.whole("\"componentType\"")? {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            other => {
                let message = format!("there is no component type {other}");
                return Err(field.error(message).help("there are 5120, 5121, 5122, 5123, 5125 and 5126"));
            }
        };
        Ok(found)
    }

    fn bytes(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The number that so many bytes hold.
    fn number(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Component::I8, &[a, ..]) => f64::from(a as i8),
            (Component::U8, &[a, ..]) => f64::from(a),
            (Component::I16, &[a, b, ..]) => f64::from(i16::from_le_bytes([a, b])),
            (Component::U16, &[a, b, ..]) => f64::from(u16::from_le_bytes([a, b])),
            (Component::U32, &[a, b, c, d, ..]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            (Component::F32, &[a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => 0.0,
        }
    }

    /// What a number stands for that is normalised to 0 to 1, or -1 to 1.
    fn normalized(self, number: f64) -> f64 {
        match self {
            Component::I8 => (number / 127.0).max(-1.0),
            Component::U8 => number / 255.0,
            Component::I16 => (number / 32767.0).max(-1.0),
            Component::U16 => number / 65535.0,
            Component::U32 => number / f64::from(u32::MAX),
            Component::F32 => number,
        }
    }
}

impl Layout<'_> {
    fn element(&self) -> usize {
        self.component.bytes() * self.width
    }
}

/// Adds what an accessor is used for to the message of an error.
fn used_for(diagnostic: RawDiagnostic, index: usize, what: &str) -> RawDiagnostic {
    let message = format!("{what}: accessor {index}: {}", diagnostic.message);
    RawDiagnostic { message, ..diagnostic }
}

impl<'j, 'b> Accessors<'j, 'b> {
    pub(super) fn new(root: Field<'j>, buffers: Buffers<'b>, text_bytes: usize) -> Read<Accessors<'j, 'b>> {
        let left = FREE.saturating_add((buffers.total + text_bytes).saturating_mul(PER_BYTE));
        let (list, views) = (root.list("accessors")?, root.list("bufferViews")?);
        Ok(Accessors { list, views, buffers, known: HashMap::new(), left })
    }

    /// The number of the accessor that a field names.
    pub(super) fn index(&self, field: Field, what: &str) -> Read<usize> {
        let found = field.index("accessor", &self.list);
        found.map_err(|d| RawDiagnostic { message: format!("{what}: {}", d.message), ..d })
    }

    /// The values of an accessor, which have one of these widths; `what` is it for, for messages.
    pub(super) fn values(&mut self, index: usize, what: &str, widths: &[usize]) -> Read<Rc<Values>> {
        let values = match self.known.get(&index) {
            Some(known) => known.clone(),
            None => {
                let values = Rc::new(self.read(index).map_err(|error| used_for(error, index, what))?);
                self.known.insert(index, values.clone());
                values
            }
        };
        if widths.contains(&values.width) {
            return Ok(values);
        }
        let expected = widths.iter().map(usize::to_string).collect::<Vec<_>>().join(" or ");
        let message = format!("its values have {} numbers each, not {expected}", values.width);
        Err(used_for(self.error(index, message), index, what))
    }

    /// The values of an accessor of whole numbers.
    pub(super) fn indices(&mut self, index: usize, what: &str) -> Read<Vec<u32>> {
        let read = |accessors: &mut Self| -> Read<Vec<u32>> {
            let layout = accessors.layout(index)?;
            let is_index = matches!(layout.component, Component::U8 | Component::U16 | Component::U32);
            if !is_index || layout.width != 1 {
                return Err(layout.field.error("its values are no indices: these are single whole numbers"));
            }
            let values = accessors.decode(&Layout { normalized: false, ..layout })?;
            Ok(values.iter().map(|x| *x as u32).collect())
        };
        read(self).map_err(|error| used_for(error, index, what))
    }

    /// Whether an accessor has bytes of its own.
    pub(super) fn has_bytes(&self, index: usize) -> bool {
        self.list.get(index).is_some_and(|field| field.get("bufferView").is_some())
    }

    /// An error about an accessor.
    pub(super) fn error(&self, index: usize, message: impl Into<String>) -> RawDiagnostic {
        let message = message.into();
        self.list.get(index).map_or_else(|| RawDiagnostic::file(&message), |field| field.error(&message))
    }

    /// Counts so many numbers that are made, and refuses more than the size of the file explains.
    pub(super) fn count(&mut self, numbers: usize) -> Result<(), String> {
        match self.left.checked_sub(numbers) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err("the file stands for many times more numbers than it has bytes".into()),
        }
    }

    fn read(&mut self, index: usize) -> Read<Values> {
        let layout = self.layout(index)?;
        Ok(Values { width: layout.width, numbers: self.decode(&layout)? })
    }

    fn layout(&self, index: usize) -> Read<Layout<'j>> {
        let Some(field) = self.list.get(index) else {
            return Err(RawDiagnostic::file(format!("there is no accessor {index}")));
        };
        let kind = field.required("type", "it")?;
        let width = match kind.text("\"type\"")? {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            other => return Err(kind.error(format!("values of the type '{other}' have no use here"))),
        };
        Ok(Layout {
            field,
            count: field.required("count", "it")?.whole("\"count\"")?,
            component: Component::of(field.required("componentType", "it")?)?,
            normalized: field.flag("normalized"),
            width,
        })
    }

    /// The numbers of an accessor.
    fn decode(&mut self, layout: &Layout) -> Read<Vec<f64>> {
        let total = layout.count.saturating_mul(layout.width);
        let refuse = |message: String| {
            let field = layout.field.get("count").unwrap_or(layout.field);
            let message = format!("it promises {} values; {message}", layout.count);
            Err(field.error(message).help("the number may be damaged; export the scene again"))
        };
        // Before the budget: this error says more.
        if let Some(view) = layout.field.get("bufferView") {
            self.bytes_of(layout, view)?;
        }
        if let Err(message) = self.count(total) {
            return refuse(message);
        }
        let mut numbers = match layout.field.get("bufferView") {
            Some(view) => {
                let (stride, bytes) = self.bytes_of(layout, view)?;
                decoded(layout, stride, bytes)
            }
            None => vec![0.0; total],
        };
        if let Some(sparse) = layout.field.get("sparse") {
            self.replace(layout, sparse, &mut numbers)?;
        }
        Ok(numbers)
    }

    /// The stride and the bytes of an accessor's values.
    fn bytes_of(&self, layout: &Layout, view: Field) -> Read<(usize, &[u8])> {
        let offset = layout.field.whole_or_zero("byteOffset")?;
        let element = layout.element();
        let (stride, bytes) = self.view(view)?;
        let stride = stride.unwrap_or(element);
        if stride < element {
            let message = format!("its values of {element} bytes begin every {stride} bytes");
            return Err(layout.field.error(message).help("\"byteStride\" is at least the size of a value"));
        }
        let needed = span(layout.count, stride, element);
        match range_within(bytes.len(), offset, needed) {
            Some(range) => Ok((stride, &bytes[range])),
            None => {
                let message = format!(
                    "{} values from byte {offset} on end behind the {} bytes of the buffer view",
                    layout.count,
                    bytes.len()
                );
                let field = layout.field.get("count").unwrap_or(layout.field);
                Err(field.error(message))
            }
        }
    }

    /// The stride and the bytes of a buffer view.
    fn view(&self, number: Field) -> Read<(Option<usize>, &[u8])> {
        let index = number.index("buffer view", &self.views)?;
        let Some(view) = self.views.get(index) else { return Err(number.error("there is no such view")) };
        let buffer = view.required("buffer", &format!("buffer view {index}"))?.whole("\"buffer\"")?;
        let bytes = self.buffers.get(buffer);
        let length = view.required("byteLength", &format!("buffer view {index}"))?.whole("\"byteLength\"")?;
        let offset = view.whole_or_zero("byteOffset")?;
        let Some(range) = range_within(bytes.len(), offset, Some(length)) else {
            let message = format!(
                "buffer view {index} of {length} bytes from byte {offset} on ends behind the {} bytes of buffer {buffer}",
                bytes.len()
            );
            return Err(view.error(message));
        };
        let stride = view.get("byteStride").map(|stride| stride.whole("\"byteStride\"")).transpose()?;
        Ok((stride, &bytes[range]))
    }

    /// Replaces the values that a sparse accessor lists.
    fn replace(&mut self, layout: &Layout, sparse: Field, numbers: &mut [f64]) -> Read<()> {
        let count_field = sparse.required("count", "\"sparse\"")?;
        let count = count_field.whole("\"count\"")?;
        let (at, new) = (sparse.required("indices", "\"sparse\"")?, sparse.required("values", "\"sparse\"")?);
        let component = Component::of(at.required("componentType", "\"indices\"")?)?;
        let indices = Layout { field: at, count, component, normalized: false, width: 1 };
        let values = Layout { field: new, count, ..*layout };
        self.count(count.saturating_mul(1 + layout.width)).map_err(|message| count_field.error(message))?;
        let read = |layout: &Layout| -> Read<Vec<f64>> {
            let (stride, bytes) = self.bytes_of(layout, layout.field.required("bufferView", "it")?)?;
            Ok(decoded(layout, stride, bytes))
        };
        let (indices, values) = (read(&indices)?, read(&values)?);
        for (index, value) in indices.iter().zip(values.chunks_exact(layout.width)) {
            let first =
                if *index < 0.0 { usize::MAX } else { (*index as usize).saturating_mul(layout.width) };
            let Some(place) = first.checked_add(layout.width).and_then(|end| numbers.get_mut(first..end))
            else {
                let message = format!("it replaces value {index}, but has {} values", layout.count);
                return Err(count_field.error(message));
            };
            place.copy_from_slice(value);
        }
        Ok(())
    }
}

/// How many bytes so many values take; `None` if it is no number.
fn span(count: usize, stride: usize, element: usize) -> Option<usize> {
    match count.checked_sub(1) {
        None => Some(0),
        Some(before) => before.checked_mul(stride)?.checked_add(element),
    }
}

/// A range of so many bytes, if it lies within so many.
fn range_within(bytes: usize, offset: usize, needed: Option<usize>) -> Option<Range<usize>> {
    let end = offset.checked_add(needed?)?;
    (end <= bytes).then_some(offset..end)
}

/// The numbers of values that begin every `stride` bytes.
fn decoded(layout: &Layout, stride: usize, bytes: &[u8]) -> Vec<f64> {
    let (size, component) = (layout.component.bytes(), layout.component);
    let mut numbers = Vec::with_capacity(layout.count * layout.width);
    for first in (0..layout.count).map(|i| i * stride) {
        for number in bytes[first..first + layout.element()].chunks_exact(size) {
            let number = component.number(number);
            numbers.push(if layout.normalized { component.normalized(number) } else { number });
        }
    }
    numbers
}
