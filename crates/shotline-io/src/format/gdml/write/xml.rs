//! Elements of XML as text.

use shotline::math::Vec3;

/// An element that is being written. What is inside it is text already, so that lists of any length take little memory.
#[derive(Debug)]
pub(super) struct Xml {
    tag: &'static str,
    depth: usize,
    /// Millimetres per unit of length of the scene.
    millimetres: f64,
    /// A name that nothing else has: the schema wants one for each position, rotation and scale in the element.
    name: String,
    attributes: String,
    inside: String,
    /// Whether a number in it is not finite, or a length that is not 0 became 0.
    is_broken: bool,
}

impl Xml {
    /// An element of a section.
    pub(super) fn new(tag: &'static str, millimetres: f64) -> Xml {
        let [name, attributes, inside] = [const { String::new() }; 3];
        Xml { tag, depth: 2, millimetres, name, attributes, inside, is_broken: false }
    }

    /// The same element with a name, which nothing else has.
    pub(super) fn named(self, name: &str) -> Xml {
        Xml { name: name.to_owned(), ..self.text("name", name) }
    }

    pub(super) fn tag(&self) -> &'static str {
        self.tag
    }

    /// The same element with a name before its other attributes.
    pub(super) fn named_first(mut self, name: &str) -> Xml {
        let others = std::mem::take(&mut self.attributes);
        self = self.named(name);
        self.attributes.push_str(&others);
        self
    }

    /// The same element, whose parts are called after this name.
    pub(super) fn with_parts_of(self, name: String) -> Xml {
        Xml { name, ..self }
    }

    /// A position, a rotation or a scale that will be added to this element.
    fn part(&self, tag: &'static str) -> Xml {
        self.inner(tag).text("name", &format!("{}_{tag}", self.name))
    }

    /// An element that will be added to this one.
    pub(super) fn inner(&self, tag: &'static str) -> Xml {
        Xml { depth: self.depth + 1, ..Xml::new(tag, self.millimetres) }
    }

    pub(super) fn text(mut self, key: &str, value: &str) -> Xml {
        self.attributes.push_str(&format!(" {key}=\"{}\"", escaped(value)));
        self
    }

    /// A number without a unit, or in the unit that another attribute names.
    pub(super) fn number(mut self, key: &str, x: f64) -> Xml {
        self.is_broken |= !x.is_finite();
        let digits = digits(x);
        self.text(key, &digits)
    }

    /// A length of the scene, in millimetres.
    pub(super) fn length(mut self, key: &str, x: f64) -> Xml {
        let written = x * self.millimetres;
        self.is_broken |= written == 0.0 && x != 0.0;
        self.number(key, written)
    }

    /// Whether it has a number that cannot be written.
    pub(super) fn is_broken(&self) -> bool {
        self.is_broken
    }

    /// The unit of the lengths of a solid.
    pub(super) fn in_millimetres(self) -> Xml {
        self.text("lunit", "mm")
    }

    /// The units of the lengths and the angles of a solid.
    pub(super) fn in_millimetres_and_degrees(self) -> Xml {
        self.in_millimetres().text("aunit", "deg")
    }

    /// A reference to something by its name.
    pub(super) fn reference(self, tag: &'static str, name: &str) -> Xml {
        let child = self.inner(tag).text("ref", name);
        self.with(child)
    }

    /// A position in millimetres, unless it is 0.
    pub(super) fn position(self, tag: &'static str, p: Vec3) -> Xml {
        if p == Vec3::ZERO {
            return self;
        }
        let child = self.part(tag).length("x", p.x).length("y", p.y).length("z", p.z).text("unit", "mm");
        self.with(child)
    }

    /// A rotation by degrees, unless they are 0.
    pub(super) fn rotation(self, tag: &'static str, degrees: Vec3) -> Xml {
        if degrees == Vec3::ZERO {
            return self;
        }
        let child = self.part(tag).vector(degrees).text("unit", "deg");
        self.with(child)
    }

    /// A scale.
    pub(super) fn scale(self, factors: Vec3) -> Xml {
        let child = self.part("scale").vector(factors);
        self.with(child)
    }

    /// Numbers for x, y and z.
    fn vector(self, v: Vec3) -> Xml {
        self.number("x", v.x).number("y", v.y).number("z", v.z)
    }

    /// Whether no element has been added.
    pub(super) fn is_empty(&self) -> bool {
        self.inside.is_empty()
    }

    /// Adds an element.
    pub(super) fn add(&mut self, child: Xml) {
        self.is_broken |= child.is_broken;
        child.write(&mut self.inside);
    }

    /// The same element with another one in it.
    pub(super) fn with(mut self, child: Xml) -> Xml {
        self.add(child);
        self
    }

    pub(super) fn write(self, out: &mut String) {
        let Xml { tag, depth, attributes, inside, .. } = self;
        let indent = "  ".repeat(depth);
        out.push_str(&format!("{indent}<{tag}{attributes}"));
        match inside.is_empty() {
            true => out.push_str("/>\n"),
            false => out.push_str(&format!(">\n{inside}{indent}</{tag}>\n")),
        }
    }
}

/// The shortest digits that read back as the same float64.
fn digits(x: f64) -> String {
    // Negative zeros mean nothing to any reader.
    let text = format!("{:?}", x + 0.0);
    match text.strip_suffix(".0") {
        Some(whole) => whole.to_owned(),
        None => text,
    }
}

/// A text as the value of an attribute.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_as_they_are() {
        for x in [0.1, 1e-25, 5e300, -3.0, 0.1 + 0.2, f64::MIN_POSITIVE] {
            assert_eq!(digits(x).parse::<f64>().map(f64::to_bits), Ok(x.to_bits()), "{x}");
        }
        assert_eq!((digits(-0.0), digits(100.0), digits(1e-25)), ("0".into(), "100".into(), "1e-25".into()));
    }

    #[test]
    fn elements_are_nested_and_escaped() {
        let outer = Xml::new("a", 10.0).named("x<\"&\">");
        let outer = outer.position("position", Vec3::X).rotation("rotation", Vec3::ZERO).reference("b", "c");
        let mut text = String::new();
        outer.write(&mut text);
        let expected = "    <a name=\"x&lt;&quot;&amp;&quot;>\">\n      <position name=\"x&lt;&quot;&amp;&quot;>_position\" x=\"10\" y=\"0\" z=\"0\" unit=\"mm\"/>\n      \
                        <b ref=\"c\"/>\n    </a>\n";
        assert_eq!(text, expected);
    }
}
