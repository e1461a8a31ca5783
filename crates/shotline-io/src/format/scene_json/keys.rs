//! The keys of a scene file with their documentation, declared once for the reader, the schema and the suggestions for
//! mistyped keys.

use self::Shape::{Boolean, Integer, Number, Numbers, Text};

/// The type of the value of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Number,
    Numbers(usize),
    Integer,
    Boolean,
    Text,
    /// A value with keys of its own, or of several types.
    Other,
}

/// A key.
pub(super) struct Key {
    pub(super) name: &'static str,
    pub(super) shape: Shape,
    pub(super) about: &'static str,
}

const fn key(name: &'static str, shape: Shape, about: &'static str) -> Key {
    Key { name, shape, about }
}

/// The whole file.
pub(super) const TOP: &[Key] = &[
    key("$schema", Text, "Where the schema lies, for editors; not read."),
    key("shotline", Integer, "The version of the format: 1."),
    key(
        "units",
        Text,
        "The unit of length, printed with lengths, which are never converted, and used for masses; none if absent.",
    ),
    key("defs", Shape::Other, "Parts by name; a node refers to one with {\"ref\": NAME}."),
    key("objects", Shape::Other, "The objects of the scene."),
    key("materials", Shape::Other, "Materials by name."),
    key("camera", Shape::Other, "Where the picture is taken from."),
    key("lights", Shape::Other, "What lights the picture."),
    key(
        "accel",
        Text,
        "The accelerator of what has none of its own: bvh if absent. No answer depends on it.",
    ),
    key("motions", Shape::Other, "How objects move in an animation (render --frames)."),
];

/// An object.
pub(super) const OBJECT: &[Key] = &[
    key("name", Text, "The object's name; object0, object1, ... if absent."),
    key("material", Text, "The name of its material."),
    key("priority", Integer, "Where objects overlap the higher owns the segment; 0 if absent."),
    key("node", Shape::Other, "Its shape."),
    key("contents", Shape::Other, "Objects, and groups of them, that are inside this one and displace it."),
    key("clip", Boolean, "Whether contents count only inside the shape; false if absent."),
];

/// The transform of a node.
pub(super) const PLACEMENT: &[Key] = &[
    key("transform", Numbers(12), "A 3x4 matrix row by row, parent from local; instead of the other three."),
    key("scale", Shape::Other, "One factor or three along the axes; applied first."),
    key("rotate", Shape::Other, "Degrees about x, then y, then z; or {\"axis\": [x, y, z], \"degrees\": a}."),
    key("translate", Numbers(3), "A shift; applied last."),
    key(
        "label",
        Text,
        "What it is called in the names of paths, where an empty label leaves it out; its own name and its index in the \
         group if absent.",
    ),
];

/// The accelerator of a mesh, a combination, or a group with several instances.
pub(super) const ACCEL: Key = key("accel", Text, "The accelerator of this part. No answer depends on it.");

/// A rotation about an axis.
pub(super) const ROTATION: &[Key] = &[
    key("axis", Numbers(3), "The axis, of any length."),
    key("degrees", Number, "The angle, counter-clockwise seen from the tip of the axis."),
];

/// A material.
pub(super) const MATERIAL: &[Key] = &[
    key("mu", Number, "Linear attenuation coefficient, per unit of length."),
    key(
        "density",
        Number,
        "Density in g/cm^3, whatever the units; in a scene without units, mass per cubed length.",
    ),
    key(
        "composition",
        Shape::Other,
        "The elements that it is made of, each with its share of the mass. No answer depends on them.",
    ),
    key("color", Numbers(3), "Colour as sRGB, each from 0 to 1."),
    key("specular", Number, "Strength of the highlight, from 0 to 1."),
    key("shininess", Number, "Exponent of the highlight."),
    key("mirror", Number, "Share of light that is mirrored, from 0 to 1."),
];

/// A camera.
pub(super) const CAMERA: &[Key] = &[
    key("eye", Numbers(3), "Where the eye is."),
    key("target", Numbers(3), "What it looks at."),
    key("up", Numbers(3), "Which direction is up in the picture; z if absent, y for a view along z."),
    key("fov", Number, "The vertical angle of view in degrees, for a perspective picture; 40 if absent."),
    key("height", Number, "The height of the picture in world units, for a parallel projection."),
];

/// A light.
pub(super) const LIGHT: &[Key] = &[
    key("point", Numbers(3), "A light at a point."),
    key("direction", Numbers(3), "A light from far away that travels in this direction."),
    key("ambient", Boolean, "true for a light from everywhere, without shadows."),
    key("color", Numbers(3), "Colour as sRGB, each from 0 to 1; white if absent."),
    key("intensity", Number, "Strength; 1 if absent."),
];

/// A motion.
pub(super) const MOTION: &[Key] = &[
    key("object", Text, "The name of what moves."),
    key("rotate", Shape::Other, "How far it has turned in the end, as in a node."),
    key("about", Numbers(3), "The point about which it turns; the origin if absent."),
    key("translate", Numbers(3), "How far it has gone in the end."),
];

/// The boolean operations and the group, as `op`.
pub(super) const OPS: &[(&str, &str)] = &[
    ("union", "In any of the args."),
    ("intersection", "In all of the args."),
    ("difference", "In the first of the args and in no other."),
    ("group", "A collection: each member is a body of its own."),
];

/// The operations that place copies of their args in cells.
pub(super) const LATTICE: &str = "lattice";
pub(super) const HEXAGONAL_LATTICE: &str = "hexagonal_lattice";
pub(super) const RING: &str = "ring";

/// The operations that place copies of their args, each with what it is, its keys, and how many of these are required: the
/// first ones.
pub(super) const COPIES: &[(&str, &str, &[Key], usize)] = &[
    (
        LATTICE,
        "Copies in rows, columns and layers: each is a body of its own. The first is where the arg is.",
        &[
            key("counts", Numbers(3), "The numbers of cells along x, y and z."),
            key("pitch", Numbers(3), "The distances between neighbours along x, y and z."),
            CELLS,
            key(
                "stagger",
                Boolean,
                "Whether every second row is shifted by half a pitch along x; false if absent.",
            ),
        ],
        2,
    ),
    (
        HEXAGONAL_LATTICE,
        "Copies in rings around the z axis, each as far from its six neighbours; the first ring is one cell.",
        &[
            key("rings", Integer, "The number of rings."),
            key("pitch", Number, "The distance between neighbours."),
            CELLS,
            key("layers", Integer, "The number of layers along z; 1 if absent."),
            key("height", Number, "The distance between layers; 0 if absent."),
        ],
        2,
    ),
    (
        RING,
        "Copies turned about the z axis: each is a body of its own. The first is where the arg is.",
        &[
            key("count", Integer, "The number of copies."),
            key(
                "step",
                Number,
                "The degrees from one to the next; those of a whole turn over the count if absent.",
            ),
        ],
        1,
    ),
];

/// What the cells of a lattice hold.
const CELLS: Key = key(
    "cells",
    Shape::Other,
    "For each cell the index of its arg, or null for an empty cell: x runs fastest, then y, then z. Every cell holds the \
     first arg if absent.",
);

/// The kind of a mesh, which is read from a file.
pub(super) const MESH: &str = "mesh";

/// The file of a mesh; the schema describes it with the names of the mesh formats.
pub(super) const MESH_FILE: Key = key("file", Text, "");

/// The welding of a mesh.
pub(super) const WELD: Key = key(
    "weld",
    Shape::Other,
    "Vertices to weld: those up to this distance apart, in the lengths of the file, or \"auto\": those within \
     rounding of each other and far from all others. What is merged is a note.",
);

/// The names of some keys.
pub(super) fn names(keys: &'static [Key]) -> impl Iterator<Item = &'static str> {
    keys.iter().map(|k| k.name)
}
