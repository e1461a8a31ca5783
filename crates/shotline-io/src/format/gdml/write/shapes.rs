//! Shapes to solids: combinations, transforms of solids, and groups, whose members become a union.

use shotline::math::{Affine, ComposedTransform};
use shotline::scene::{LocalTransform, Node, NodeId, Op};

use super::Writer;
use super::names::as_xml_name;
use super::placements::{NOTABLE, Placement};
use super::report::Reported;
use super::traversal::parts_of_shape;
use super::xml::Xml;

/// A solid of the file, and where it is.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    /// Its name in the file.
    pub(super) solid: String,
    /// A rotation and a translation.
    pub(super) place: Affine,
}

impl Placed {
    pub(super) fn centred(solid: String) -> Placed {
        Placed { solid, place: Affine::IDENTITY }
    }
}

/// What a node becomes as a shape.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Solid(Placed),
    /// A group without solids.
    Nothing,
    /// One that has been reported.
    Refused,
}

impl Writer<'_> {
    /// The solid of an object's shape; `None` if it has none.
    pub(super) fn shape(&mut self, shape: NodeId) -> Result<Option<Placed>, Reported> {
        for part in parts_of_shape(self.scene, shape, |id| self.shapes.contains_key(&id)) {
            let made = match self.part(part) {
                Ok(Some(placed)) => Shape::Solid(placed),
                Ok(None) => Shape::Nothing,
                Err(_) => Shape::Refused,
            };
            self.shapes.insert(part, made);
        }
        self.known(shape)
    }

    /// A node whose children are known.
    fn known(&self, id: NodeId) -> Result<Option<Placed>, Reported> {
        match self.shapes.get(&id) {
            Some(Shape::Solid(placed)) => Ok(Some(placed.clone())),
            Some(Shape::Nothing) | None => Ok(None),
            Some(Shape::Refused) => Err(Reported),
        }
    }

    fn part(&mut self, id: NodeId) -> Result<Option<Placed>, Reported> {
        let scene = self.scene;
        match scene.node(id) {
            Node::Solid { kind, params } => self.kind(kind, params).map(Some),
            Node::Mesh { mesh, .. } => self.mesh(mesh).map(Some),
            Node::Transform { transform, child } => match self.known(*child)? {
                Some(placed) => self.transformed(placed, transform).map(Some),
                None => Ok(None),
            },
            Node::Group { members } => self.joined(members, Op::Union),
            Node::Csg { op, args } => {
                if self.structure.has_objects(id) {
                    return Err(self.refuse("a combination cannot hold objects"));
                }
                self.joined(args, *op)
            }
            // Lattices have been written out.
            Node::Object { .. } | Node::Lattice { .. } => Ok(None),
        }
    }

    /// Adds a solid under a free name, after its attributes and parts have been added.
    pub(super) fn solid(&mut self, tag: &'static str, fill: impl FnOnce(Xml) -> Xml) -> String {
        let name = self.free_name(tag);
        let element = fill(self.element(tag).named(&name));
        self.check(&element);
        element.write(&mut self.solids);
        name
    }

    /// Adds a solid that has no name yet, before its other attributes.
    pub(super) fn add_solid(&mut self, element: Xml) -> String {
        let name = self.free_name(element.tag());
        self.check(&element);
        element.named_first(&name).write(&mut self.solids);
        name
    }

    /// A free name for something of the object that is being written.
    pub(super) fn free_name(&mut self, what: &str) -> String {
        self.names.free(&format!("{}_{what}", as_xml_name(&self.object)))
    }

    /// Reports that the object that is being written cannot be.
    pub(super) fn refuse(&mut self, why: &str) -> Reported {
        let error = format!("object '{}': {why}", self.object);
        self.report.refuse(error)
    }

    fn transformed(&mut self, placed: Placed, transform: &LocalTransform) -> Result<Placed, Reported> {
        let matrix = self.rounded(&transform.inside(&ComposedTransform::IDENTITY))?;
        self.under(placed, &matrix)
    }

    /// A product of transforms as a matrix.
    pub(super) fn rounded(&mut self, transform: &ComposedTransform) -> Result<Affine, Reported> {
        match transform.placement() {
            Ok(pair) => Ok(pair.parent_from_local),
            Err(error) => Err(self.refuse(&error.to_string())),
        }
    }

    /// The parts of a transform; one that shears is refused.
    pub(super) fn placement(&mut self, matrix: &Affine) -> Result<Placement, Reported> {
        match Placement::of(matrix) {
            Some(placement) => {
                if placement.error > NOTABLE {
                    let what =
                        "transforms that were rotations and scales but for some digits were made so, in";
                    let object = self.object.clone();
                    self.report.lose(what, &object);
                }
                Ok(placement)
            }
            None => Err(self.refuse("a transform shears, for which GDML has no element")),
        }
    }

    /// A solid under a transform.
    pub(super) fn under(&mut self, placed: Placed, matrix: &Affine) -> Result<Placed, Reported> {
        let all = matrix.then_after(&placed.place);
        let (placed, all) = match Placement::of(&all) {
            Some(_) => (placed, all),
            // A scale of what is turned becomes one of a solid that is turned within.
            None => (self.fixed(placed), *matrix),
        };
        let placement = self.placement(&all)?;
        let mut solid = placed.solid;
        if placement.is_scaled() {
            solid = self
                .solid("scaledSolid", |element| element.reference("solidref", &solid).scale(placement.scale));
        }
        if placement.is_mirrored() {
            let [x, y, z] = placement.mirror.to_array();
            solid = self.solid("reflectedSolid", |element| {
                let element = element.text("solid", &solid);
                element.number("sx", x).number("sy", y).number("sz", z)
            });
        }
        Ok(Placed { solid, place: placement.rigid })
    }

    /// A solid that is where it is by itself: a union of one. Geant4 takes a `reflectedSolid` to the inverse of its transform, so
    /// that one serves for mirrors only.
    pub(super) fn fixed(&mut self, placed: Placed) -> Placed {
        if placed.place.is_identity() { placed } else { self.multi_union(&[placed]) }
    }

    /// The combination of some parts.
    fn joined(&mut self, parts: &[NodeId], op: Op) -> Result<Option<Placed>, Reported> {
        let known = parts.iter().map(|part| self.known(*part)).collect::<Result<Vec<_>, _>>()?;
        let first_is_empty = known.first().is_none_or(|first| first.is_none());
        let has_empty = known.iter().any(|part| part.is_none());
        if (op == Op::Intersection && has_empty) || (op == Op::Difference && first_is_empty) {
            return Ok(None);
        }
        let solids: Vec<Placed> = known.into_iter().flatten().collect();
        if op == Op::Union && solids.len() > 2 {
            return Ok(Some(self.multi_union(&solids)));
        }
        Ok(solids.into_iter().reduce(|first, second| self.pair(&first, &second, op)))
    }

    /// A union of any number of solids.
    fn multi_union(&mut self, solids: &[Placed]) -> Placed {
        let base = self.free_name("part");
        Placed::centred(self.solid("multiUnion", |mut element| {
            for (number, Placed { solid, place }) in solids.iter().enumerate() {
                let node = element.inner("multiUnionNode").named(&format!("{base}-{number}"));
                element.add(at(node.reference("solid", solid), place, ["position", "rotation"]));
            }
            element
        }))
    }

    fn pair(&mut self, first: &Placed, second: &Placed, op: Op) -> Placed {
        let tag = match op {
            Op::Union => "union",
            Op::Intersection => "intersection",
            Op::Difference => "subtraction",
        };
        Placed::centred(self.solid(tag, |element| {
            let element = element.reference("first", &first.solid);
            let element = element.reference("second", &second.solid);
            let element = at(element, &second.place, ["position", "rotation"]);
            at(element, &first.place, ["firstposition", "firstrotation"])
        }))
    }
}

/// An element with the position and the rotation of an operand.
fn at(element: Xml, place: &Affine, [position, rotation]: [&'static str; 2]) -> Xml {
    match Placement::of(place) {
        Some(placement) => element
            .position(position, placement.position())
            .rotation(rotation, placement.degrees_of_operand()),
        None => element,
    }
}
