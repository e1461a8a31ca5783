//! Builds the nodes of a scene from the values of a scene file.
//!
//! Each entry of `defs` is one node, and every `{"ref"}` to it without a transform is the id of that node. So sharing,
//! forward references and cycles (which the compiler reports) need no further work. Tasks are kept in a list, so deep
//! nesting needs no deep stack.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use shotline::scene::{LocalTransform, Material, Node, NodeId, Op, Scene};
use shotline::solid::mesh::Weld;
use shotline::solid::{self, Layout, Param, Params};

use super::keys::{ACCEL, COPIES, Key, MESH, MESH_FILE, OBJECT, OPS, PLACEMENT, RING, WELD, names};
use super::lattices;
use super::mesh_files::Meshes;
use super::placement;
use super::values::{Values, layout_in_words};
use crate::json::{Content, Member, ValueId};
use crate::suggest;

/// A scene under construction.
pub(super) struct Graph<'r, 't> {
    pub(super) values: Values<'r, 't>,
    pub(super) scene: Scene,
    /// The bytes of each node in the text.
    pub(super) spans: Vec<Range<usize>>,
    pub(super) meshes: Meshes<'r>,
    defs: HashMap<&'r str, NodeId>,
    materials: HashSet<String>,
    unnamed: usize,
}

/// A node whose id is reserved and whose contents are still to be read.
struct Task {
    value: ValueId,
    id: NodeId,
    role: Role,
}

/// What a node may be.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    /// A shape.
    Shape,
    /// A shape or an object.
    Member,
    /// An object, at this index of the list of objects.
    Root(usize),
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Leaf,
    Combination,
    Ref,
    Object,
}

const FORMS: [(&str, Form); 4] =
    [("kind", Form::Leaf), ("op", Form::Combination), ("ref", Form::Ref), ("node", Form::Object)];

impl<'r, 't> Graph<'r, 't> {
    /// A graph that has only the materials so far.
    pub(super) fn new(
        values: Values<'r, 't>,
        meshes: Meshes<'r>,
        materials: Vec<(String, Material)>,
    ) -> Graph<'r, 't> {
        Graph {
            values,
            materials: materials.iter().map(|(name, _)| name.clone()).collect(),
            scene: Scene { materials, ..Scene::default() },
            spans: Vec::new(),
            meshes,
            defs: HashMap::new(),
            unnamed: 0,
        }
    }

    /// Reads the definitions and the objects.
    pub(super) fn read(&mut self, defs: Option<ValueId>, objects: Option<ValueId>) {
        let mut todo = Vec::new();
        if let Some(members) = defs.and_then(|at| self.values.object(at, "\"defs\"")) {
            self.define(members, &mut todo);
        }
        let roots = objects.and_then(|at| self.values.array(at, "\"objects\"")).unwrap_or(&[]);
        self.unnamed = roots.len();
        self.scene.objects =
            roots.iter().enumerate().map(|(i, v)| self.child(*v, Role::Root(i), &mut todo)).collect();
        todo.reverse();
        let mut below = Vec::new();
        while let Some(task) = todo.pop() {
            self.fill(task, &mut below);
            todo.extend(below.drain(..).rev());
        }
        for (id, value) in self.scene.objects.clone().into_iter().zip(roots) {
            if self.values.diagnostics.is_empty() && !self.is_object(id) {
                self.values.report_at_start(*value, "this is not an object", WRAP);
            }
        }
    }

    /// Whether a node is an object, which may be transformed. The nodes may have a cycle.
    fn is_object(&self, mut id: NodeId) -> bool {
        for _ in &self.scene.nodes {
            match self.scene.node(id) {
                Node::Object { .. } => return true,
                Node::Transform { child, .. } => id = *child,
                _ => return false,
            }
        }
        false
    }

    /// Assigns a node to every definition; one that only refers to another gets the node of that.
    fn define(&mut self, members: &'r [Member<'t>], todo: &mut Vec<Task>) {
        let by_name: HashMap<&str, ValueId> = members.iter().map(|m| (m.key.as_ref(), m.value)).collect();
        for member in members {
            if !self.is_bare_ref(member.value) {
                let id = self.child(member.value, Role::Member, todo);
                self.defs.insert(member.key.as_ref(), id);
            }
        }
        for member in members {
            let name = member.key.as_ref();
            let id = match self.defs.get(name) {
                Some(id) => *id,
                None => self.follow(member.value, &by_name),
            };
            self.defs.insert(name, id);
            self.scene.defs.push((name.to_string(), id));
        }
    }

    /// Follows a chain of definitions that only refer to one another, and assigns the node at its end to all of them.
    fn follow(&mut self, first: ValueId, by_name: &HashMap<&str, ValueId>) -> NodeId {
        let (mut at, mut passed) = (first, Vec::new());
        let id = loop {
            let next = self.ref_name(at).and_then(|name| Some((name, *by_name.get(name)?)));
            let Some((name, next)) = next.filter(|(_, next)| self.is_bare_ref(*next)) else {
                break self.reference(at);
            };
            if let Some(id) = self.defs.get(name) {
                break *id;
            }
            if passed.len() == by_name.len() {
                let help = "give one of them a shape";
                self.values.report(first, "these parts only refer to one another", help);
                break self.reserve(first);
            }
            passed.push(name);
            at = next;
        };
        self.defs.extend(passed.into_iter().map(|name| (name, id)));
        id
    }

    fn reserve(&mut self, value: ValueId) -> NodeId {
        self.spans.push(self.values.tree.range(value));
        self.scene.add(Node::Group { members: Vec::new() })
    }

    /// The id of a child node.
    fn child(&mut self, value: ValueId, role: Role, todo: &mut Vec<Task>) -> NodeId {
        if self.is_bare_ref(value) {
            return self.reference(value);
        }
        let id = self.reserve(value);
        todo.push(Task { value, id, role });
        id
    }

    fn is_bare_ref(&self, value: ValueId) -> bool {
        let members = self.values.tree.members(value);
        let has = |key: &str| members.iter().any(|m| m.key == key);
        has("ref")
            && !FORMS.iter().any(|(key, form)| *form != Form::Ref && has(key))
            && !names(PLACEMENT).any(has)
    }

    fn ref_name(&self, value: ValueId) -> Option<&'r str> {
        match self.values.tree.content(self.values.tree.get(value, "ref")?) {
            Content::Text(name) if self.is_bare_ref(value) => Some(name),
            _ => None,
        }
    }

    /// The node that a `{"ref"}` names.
    fn reference(&mut self, value: ValueId) -> NodeId {
        let known: Vec<_> = ["ref"].into_iter().chain(names(PLACEMENT)).collect();
        self.values.only(value, "a reference", &known);
        let Some(at) = self.values.tree.get(value, "ref") else { return self.reserve(value) };
        let Some(name) = self.values.text(at, "\"ref\"") else { return self.reserve(value) };
        if let Some(id) = self.defs.get(name.as_ref()) {
            return *id;
        }
        let help = self.values.hint(name, self.defs.keys().copied());
        self.values.report(at, format!("there is no '{name}' in \"defs\""), help);
        self.reserve(value)
    }

    fn fill(&mut self, task: Task, todo: &mut Vec<Task>) {
        let Task { value, id, role } = task;
        let Some(form) = self.form(value, role) else { return };
        let label = self.values.tree.get(value, "label");
        if let Some(label) = label.and_then(|at| self.values.text(at, "\"label\"")) {
            self.scene.labels.insert(id, label.to_string());
        }
        let unmoved = LocalTransform::Steps { scale: None, rotate: None, translate: None };
        let id = match placement::read(&mut self.values, value).or(label.map(|_| unmoved)) {
            None => id,
            Some(transform) => {
                let child = if form == Form::Ref { self.reference(value) } else { self.reserve(value) };
                self.set(id, Node::Transform { transform, child });
                child
            }
        };
        if matches!(form, Form::Leaf | Form::Combination)
            && let Some(name) = self.values.accel(value)
        {
            self.scene.accels.insert(id, name);
        }
        let node = match form {
            Form::Leaf => self.leaf(value),
            Form::Combination => self.combination(value, todo),
            Form::Object => self.object(value, role, todo),
            Form::Ref => None,
        };
        if let Some(node) = node {
            self.set(id, node);
        }
    }

    fn set(&mut self, id: NodeId, node: Node) {
        self.scene.nodes[id.0 as usize] = node;
    }

    /// The form of a node. Reports a node of no form, of several forms, or of one that is not allowed here.
    fn form(&mut self, value: ValueId, role: Role) -> Option<Form> {
        let members = self.values.object(value, "a node")?;
        let present = |key: &str| members.iter().any(|m| m.key == key);
        let mut forms = FORMS.iter().filter(|(key, _)| present(key));
        let forms = [forms.next(), forms.next()];
        let root = matches!(role, Role::Root(_));
        let what = if root { "an object" } else { "a node" };
        match forms {
            [None, _] => {
                let (needs, help) = missing_form(members, role);
                self.values.report_at_start(value, format!("{what} needs {needs}"), help);
                None
            }
            [Some((_, form)), None] if root && !matches!(form, Form::Object | Form::Ref) => {
                self.values.report_at_start(value, "an object needs \"node\"", WRAP);
                None
            }
            [Some((_, Form::Object)), None] if role == Role::Shape => {
                let help = "objects stand in \"objects\", in \"contents\" and among the args of a group";
                self.values.report_at_start(value, "an object cannot stand here", help);
                None
            }
            [Some((_, form)), None] => Some(*form),
            [Some((a, _)), Some((b, _))] => {
                let help = "it is either a solid, an operation, a reference or an object";
                self.values.report_at_start(
                    value,
                    format!("a node cannot have both \"{a}\" and \"{b}\""),
                    help,
                );
                None
            }
        }
    }

    fn leaf(&mut self, value: ValueId) -> Option<Node> {
        let at = self.values.required(value, "a solid", "kind", "the name of a kind of solid")?;
        let name = self.values.text(at, "\"kind\"")?;
        if name == MESH {
            return self.mesh(value);
        }
        let Some(kind) = solid::kind(name) else {
            let help = self.values.hint(name, solid::KINDS.iter().map(|k| k.name).chain([MESH]));
            self.values.report(at, format!("there is no kind '{name}'"), help);
            return None;
        };
        let params = kind.params.iter().map(|p| p.name);
        let known: Vec<_> = ["kind"].into_iter().chain(params).chain(names(PLACEMENT)).collect();
        let meant = self.values.only(value, format_args!("a {name}"), &known);
        let mut entries = Some(Vec::with_capacity(kind.params.len()));
        for param in kind.params {
            let given = self.values.tree.get(value, param.name);
            if given.is_none() && meant.contains(&param.name) {
                entries = None;
                continue;
            }
            let read = match (given, param.default) {
                (Some(at), _) => self.param(at, param),
                (None, Some(default)) => Some(default.into()),
                (None, None) => {
                    let takes = format!("{}: {}", layout_in_words(param.layout), param.summary);
                    self.values.required(value, &format!("this {name}"), param.name, &takes);
                    None
                }
            };
            entries = entries.zip(read).map(|(mut all, numbers)| {
                all.push((param.name, numbers));
                all
            });
        }
        entries.map(|entries| Node::Solid { kind, params: Params { entries } })
    }

    fn param(&mut self, at: ValueId, param: &Param) -> Option<Arc<[f64]>> {
        match param.layout {
            Layout::Numbers(1) => self.values.number(at, param.name).map(|x| [x].into()),
            Layout::Numbers(count) => self.values.numbers(at, param.name, count).map(Arc::from),
            Layout::Rows { .. } => self.values.rows(at, param).map(Arc::from),
        }
    }

    fn mesh(&mut self, value: ValueId) -> Option<Node> {
        let known: Vec<_> =
            ["kind", MESH_FILE.name, WELD.name, ACCEL.name].into_iter().chain(names(PLACEMENT)).collect();
        self.values.only(value, "a mesh", &known);
        let at = self.values.required(value, "this mesh", MESH_FILE.name, "the name of a mesh file")?;
        let file = self.values.text(at, "\"file\"")?;
        let weld = match self.values.tree.get(value, WELD.name) {
            None => None,
            Some(at) => Some(self.weld(at)?),
        };
        match self.meshes.load(file, weld) {
            Ok(mesh) => Some(Node::Mesh { mesh, file: self.meshes.file(file, weld) }),
            Err(refusal) => {
                self.values.report(at, refusal.why, refusal.help);
                None
            }
        }
    }

    fn weld(&mut self, at: ValueId) -> Option<Weld> {
        let weld = match self.values.is_text(at) {
            true => self.values.text(at, "\"weld\"")?.parse(),
            false => Weld::within(self.values.number(at, "\"weld\"")?),
        };
        match weld {
            // `parse` accepts a distance in quotes, but the format does not.
            Ok(weld) if weld == Weld::Auto || !self.values.is_text(at) => Some(weld),
            Ok(_) => {
                self.values.report(
                    at,
                    "a distance is a number, without quotes",
                    "give a number, or \"auto\"",
                );
                None
            }
            Err(error) => {
                let message = format!("{} is not a distance to weld within", error.given);
                self.values.report(at, message, "give a number of at least 0, or \"auto\"");
                None
            }
        }
    }

    fn combination(&mut self, value: ValueId, todo: &mut Vec<Task>) -> Option<Node> {
        let of_copies = self.copies_keys(value);
        let known = ["op", "args", ACCEL.name].into_iter().chain(names(of_copies)).chain(names(PLACEMENT));
        self.values.only(value, "an operation", &known.collect::<Vec<_>>());
        let op_at = self.values.tree.get(value, "op").or_else(|| {
            let ops: Vec<_> = op_names().map(|op| format!("\"{op}\"")).collect();
            self.values.required(value, "this operation", "op", &format!("one of {}", ops.join(", ")))
        });
        let op = op_at.and_then(|at| Some((at, self.values.text(at, "\"op\"")?)));
        let args_at =
            self.values.required(value, "this operation", "args", "a list of nodes: [{...}, ...]")?;
        let args = self.values.array(args_at, "\"args\"")?;
        let (op_at, name) = op?;
        if args.is_empty() && op_names().any(|op| op == name) && name != "group" {
            self.values.report(args_at, format!("this {name} has no args"), "give it at least one");
        }
        if lattices::is_lattice(name) {
            let elements = args.iter().map(|v| self.child(*v, Role::Member, todo)).collect();
            let (lattice, table) = lattices::read(&mut self.values, value, name)?;
            return Some(Node::Lattice { lattice, elements, table });
        }
        if name == RING {
            let [arg] = args else {
                self.values.report(args_at, "a ring has one arg", "put several into a group");
                return None;
            };
            let child = self.child(*arg, Role::Member, todo);
            let turns = lattices::turns(&mut self.values, value)?;
            let members = turns.map(|transform| {
                let member = self.reserve(value);
                self.scene.nodes[member.0 as usize] = Node::Transform { transform, child };
                member
            });
            return Some(Node::Group { members: members.collect() });
        }
        let op = match name.as_ref() {
            "union" => Some(Op::Union),
            "intersection" => Some(Op::Intersection),
            "difference" => Some(Op::Difference),
            "group" => None,
            _ => {
                let help = self.values.hint(name, op_names());
                self.values.report(op_at, format!("there is no operation '{name}'"), help);
                // The args are still read, to report errors in them.
                Some(Op::Union)
            }
        };
        let role = if op.is_some() { Role::Shape } else { Role::Member };
        let args = args.iter().map(|v| self.child(*v, role, todo)).collect();
        Some(match op {
            Some(op) => Node::Csg { op, args },
            None => Node::Group { members: args },
        })
    }

    /// The keys of an operation that places copies, besides those of all operations; none for others.
    fn copies_keys(&self, value: ValueId) -> &'static [Key] {
        let op = self.values.tree.get(value, "op").map(|at| self.values.tree.content(at));
        let Some(Content::Text(op)) = op else { return &[] };
        COPIES.iter().find(|(name, ..)| *name == op.as_ref()).map_or(&[], |(_, _, keys, _)| keys)
    }

    fn object(&mut self, value: ValueId, role: Role, todo: &mut Vec<Task>) -> Option<Node> {
        let known: Vec<_> = names(OBJECT).chain(names(PLACEMENT)).collect();
        self.values.only(value, "an object", &known);
        let get = |key: &str| self.values.tree.get(value, key);
        let (name, material, priority) = (get("name"), get("material"), get("priority"));
        let name = match name {
            Some(at) => self.values.text(at, "\"name\"").map(ToString::to_string),
            None => Some(self.default_name(role)),
        };
        let material = material.and_then(|at| self.material(at));
        let priority = priority.and_then(|at| self.values.integer(at, "\"priority\"")).unwrap_or(0);
        let node = self.values.required(value, "an object", "node", "its shape: {...}")?;
        let node = self.child(node, Role::Shape, todo);
        let contents = get("contents").and_then(|at| self.values.array(at, "\"contents\"")).unwrap_or(&[]);
        let contents = contents.iter().map(|v| self.child(*v, Role::Member, todo)).collect();
        let clip = get("clip").and_then(|at| self.values.boolean(at, "\"clip\"")).unwrap_or(false);
        Some(Node::Object { name: name?, material, priority, node, contents, clip })
    }

    fn default_name(&mut self, role: Role) -> String {
        if let Role::Root(index) = role {
            return format!("object{index}");
        }
        self.unnamed += 1;
        format!("object{}", self.unnamed - 1)
    }

    fn material(&mut self, at: ValueId) -> Option<String> {
        let name = self.values.text(at, "\"material\"")?;
        if !self.materials.contains(name.as_ref()) {
            let help = self.values.hint(name, self.scene.materials.iter().map(|(name, _)| name.as_str()));
            self.values.report(at, format!("there is no '{name}' in \"materials\""), help);
        }
        Some(name.to_string())
    }
}

/// The names of all operations.
fn op_names() -> impl Iterator<Item = &'static str> {
    OPS.iter().map(|(op, _)| *op).chain(COPIES.iter().map(|(op, ..)| *op))
}

const WRAP: &str =
    "an object is {\"name\": ..., \"material\": ..., \"node\": {...}} with its shape in \"node\"";

/// The message and the help for a node of no form.
fn missing_form(members: &[Member], role: Role) -> (&'static str, String) {
    if matches!(role, Role::Root(_)) {
        return ("\"node\"", WRAP.into());
    }
    for member in members {
        let key = member.key.as_ref();
        if key == "type" {
            return ("\"kind\"", "write \"kind\" instead of \"type\"".into());
        }
        if solid::kind(key).is_some() {
            return ("\"kind\"", format!("write {{\"kind\": \"{key}\", ...}} with the parameters beside it"));
        }
        if op_names().any(|op| op == key) {
            return ("\"op\"", format!("write {{\"op\": \"{key}\", \"args\": [...]}}"));
        }
        if let Some(meant) = suggest::nearest_name(key, FORMS.map(|(name, _)| name)) {
            return ("\"kind\", \"op\" or \"ref\"", format!("did you mean '{meant}' instead of '{key}'?"));
        }
    }
    let kinds: Vec<_> = solid::KINDS.iter().map(|k| k.name).chain([MESH]).collect();
    ("\"kind\", \"op\" or \"ref\"", format!("kinds are {}", kinds.join(", ")))
}
