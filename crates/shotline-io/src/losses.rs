//! What the formats of meshes cannot hold of a scene.

use shotline::scene::{Material, Node, Scene};

/// What a format keeps of the look of materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// The colour.
    Color,
    /// The colour and the highlight.
    Highlight,
}

/// The note of a format that keeps names and looks of materials, if they have more.
pub(crate) fn of_materials(scene: &Scene, look: Look) -> Option<String> {
    let has_more = |material: &Material| {
        let Material { mu, density, composition, color: _, specular, shininess, mirror } = material;
        let is_dull = look == Look::Highlight || specular.or(*shininess).is_none();
        [mu, density, mirror].iter().any(|x| x.is_some()) || !composition.is_empty() || !is_dull
    };
    let kept = match look {
        Look::Color => "names and colours",
        Look::Highlight => "names, colours and highlights",
    };
    let is_lost = scene.materials.iter().any(|(_, material)| has_more(material));
    is_lost.then(|| format!("of materials only {kept} are kept"))
}

/// The note of a format whose objects do not contain others.
pub(crate) fn of_nesting(scene: &Scene) -> Option<String> {
    let is_nested = |node: &Node| match node {
        Node::Object { priority, contents, clip, .. } => *priority != 0 || !contents.is_empty() || *clip,
        _ => false,
    };
    let is_lost = scene.nodes.iter().any(is_nested);
    is_lost.then(|| "which objects contain others, and their priorities, are lost".into())
}

/// The note of a format without cameras and lights.
pub(crate) fn of_view(scene: &Scene) -> Option<String> {
    let is_lost = scene.camera.is_some() || !scene.lights.is_empty();
    is_lost.then(|| "the camera and the lights are lost".into())
}
