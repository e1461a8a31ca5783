//! The section `solids`: each solid becomes a node, with the dimensions that Geant4 gives it.

use shotline::scene::{Node, NodeId};
use shotline::solid::{self, Params};

use super::attributes::{Found, Reported};
use super::{Element, Module, elements, tag};
use crate::suggest;

impl Module<'_> {
    /// Reads the solids; one that is wrong is reported, and the others are read.
    pub(super) fn solids(&mut self, section: Element) {
        for element in elements(section) {
            self.named_solid(element);
        }
    }

    fn named_solid(&mut self, element: Element) {
        match tag(element) {
            "define" => return self.define(element),
            // Surfaces of optics are no solids.
            "opticalsurface" => return,
            "loop" => {
                // What is wrong has been reported.
                let _ = self.repeat(element, &mut |module, child| module.named_solid(child));
                return;
            }
            _ => {}
        }
        let solid = self.solid(element).ok();
        if let Ok(name) = self.name(element) {
            // Of two with one name the first counts, as in Geant4.
            self.solids.entry(name).or_insert(solid);
        }
    }

    fn solid(&mut self, element: Element) -> Found<NodeId> {
        match tag(element) {
            "union" | "subtraction" | "intersection" => self.boolean(element),
            "multiUnion" => self.multi_union(element),
            "reflectedSolid" => self.reflected(element),
            "scaledSolid" => self.scaled(element),
            "tessellated" => self.tessellated(element),
            shape => self.shape(element, shape),
        }
    }

    /// A solid that is given by its dimensions; `shape` is the name of the solid, which the name of the element begins with.
    pub(super) fn shape(&mut self, element: Element, shape: &str) -> Found<NodeId> {
        match shape {
            "box" => self.cuboid(element),
            "tube" => self.tube(element),
            "cutTube" => self.cut_tube(element),
            "cone" => self.cone(element),
            "orb" => self.orb(element),
            "sphere" => self.sphere(element),
            "torus" => self.torus(element),
            "eltube" => self.elliptical_tube(element),
            "elcone" => self.elliptical_cone(element),
            "ellipsoid" => self.ellipsoid(element),
            "paraboloid" => self.paraboloid(element),
            "hype" => self.hyperboloid(element),
            "polycone" => self.polycone(element),
            "genericPolycone" => self.generic_polycone(element),
            "polyhedra" => self.polyhedra(element),
            "genericPolyhedra" => self.generic_polyhedra(element),
            "xtru" => self.extruded(element),
            "trd" => self.trd(element),
            "trap" => self.trap(element),
            "para" => self.para(element),
            "arb8" => self.arb8(element),
            "tet" => self.tetrahedron(element),
            "twistedtubs" => self.twisted_tube(element),
            "twistedbox" | "twistedtrd" | "twistedtrap" => self.twisted_trap(element),
            other => Err(self.unsupported(element, format!("<{other}>"))),
        }
    }

    /// A solid of a kind by its parameters.
    pub(super) fn of_kind(&mut self, element: Element, kind: &str, values: &[&[f64]]) -> Found<NodeId> {
        match solid::kind(kind) {
            Some(kind) => Ok(self.add(element, Node::Solid { kind, params: Params::of(kind, values) })),
            None => Err(self.unsupported(element, format!("<{}>", tag(element)))),
        }
    }

    /// The solid that an element refers to by an attribute.
    pub(super) fn solid_of(&mut self, element: Element, key: &str) -> Found<NodeId> {
        let name = self.reference(element, key)?;
        match self.solids.get(&name) {
            Some(Some(solid)) => Ok(*solid),
            // Why it has none has been reported.
            Some(None) => Err(Reported),
            None => {
                let help = suggest::hint(&name, &self.solids.keys().map(String::as_str).collect::<Vec<_>>());
                let message = format!("there is no solid '{name}' before this line");
                Err(self.report(element, Some(key), message, help))
            }
        }
    }
}
