//! Combinations of solids, and solids that are scaled or reflected.

use shotline::scene::{Node, NodeId, Op};

use super::attributes::Found;
use super::placements::Placement;
use super::{Element, Module, elements, tag};

impl Module<'_> {
    pub(super) fn boolean(&mut self, element: Element) -> Found<NodeId> {
        let op = match tag(element) {
            "union" => Op::Union,
            "subtraction" => Op::Difference,
            _ => Op::Intersection,
        };
        let [mut first, mut second] = [None; 2];
        let [mut of_first, mut of_second] = [Placement::NONE; 2];
        for child in elements(element) {
            match tag(child) {
                "first" => first = Some(self.solid_of(child, "ref")?),
                "second" => second = Some(self.solid_of(child, "ref")?),
                _ if self.place(child, "first", &mut of_first)?
                    || self.place(child, "", &mut of_second)? => {}
                other => {
                    let message = format!("<{other}> has no meaning in <{}>", tag(element));
                    return Err(self.report(child, None, message, "remove it"));
                }
            }
        }
        let (Some(first), Some(second)) = (first, second) else {
            let message = format!("<{}> lacks its first or second solid", tag(element));
            let help = "add <first ref=\"...\"/> and <second ref=\"...\"/>";
            return Err(self.report(element, None, message, help));
        };
        let args = vec![self.operand(element, first, of_first), self.operand(element, second, of_second)];
        Ok(self.add(element, Node::Csg { op, args }))
    }

    /// A solid under the transform that places it, if there is one.
    fn operand(&mut self, element: Element, solid: NodeId, placement: Placement) -> NodeId {
        if placement.is_none() {
            return solid;
        }
        self.add(element, Node::Transform { transform: placement.of_operand(), child: solid })
    }

    pub(super) fn multi_union(&mut self, element: Element) -> Found<NodeId> {
        let mut args = Vec::new();
        for node in elements(element) {
            if tag(node) != "multiUnionNode" {
                let message = format!("<{}> has no meaning in <multiUnion>", tag(node));
                return Err(self.report(node, None, message, "it has <multiUnionNode> elements"));
            }
            let (mut solid, mut placement) = (None, Placement::NONE);
            for child in elements(node) {
                if tag(child) == "solid" {
                    solid = Some(self.solid_of(child, "ref")?);
                } else if !self.place(child, "", &mut placement)? {
                    let message = format!("<{}> has no meaning in <multiUnionNode>", tag(child));
                    return Err(self.report(
                        child,
                        None,
                        message,
                        "it has a solid, a position and a rotation",
                    ));
                }
            }
            match solid {
                Some(solid) => args.push(self.operand(node, solid, placement)),
                None => {
                    return Err(self.report(node, None, "the node has no solid", "add <solid ref=\"...\"/>"));
                }
            }
        }
        if args.is_empty() {
            return Err(self.report(
                element,
                None,
                "the union has no solids",
                "add <multiUnionNode> elements",
            ));
        }
        Ok(self.add(element, Node::Csg { op: Op::Union, args }))
    }

    pub(super) fn reflected(&mut self, element: Element) -> Found<NodeId> {
        let solid = self.solid_of(element, "solid")?;
        let placement = self.reflection(element)?;
        Ok(self.operand(element, solid, placement))
    }

    pub(super) fn scaled(&mut self, element: Element) -> Found<NodeId> {
        let (mut solid, mut placement) = (None, Placement::NONE);
        for child in elements(element) {
            match tag(child) {
                "solidref" => solid = Some(self.solid_of(child, "ref")?),
                _ if self.place(child, "", &mut placement)? => {}
                other => {
                    let message = format!("<{other}> has no meaning in <scaledSolid>");
                    return Err(self.report(child, None, message, "it has a solidref and a scale"));
                }
            }
        }
        match solid {
            Some(solid) => Ok(self.operand(element, solid, placement)),
            None => Err(self.report(
                element,
                None,
                "the scaled solid lacks its solid",
                "add <solidref ref=\"...\"/>",
            )),
        }
    }
}
