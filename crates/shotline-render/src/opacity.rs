//! Objects that are seen through.

use shotline::scene::{Scene, UnknownObject};

/// Which objects of a scene are seen through, and by how much.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Opacities {
    /// By number of an object; objects beyond the end are opaque.
    of_objects: Vec<f64>,
}

/// The opacities are not those of a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidOpacity {
    /// The number is out of range.
    #[error(
        "the opacity of '{name}' is {opacity}, but must be from 0, which is seen through, to 1, which is opaque"
    )]
    Range {
        /// The name of the objects.
        name: String,
        /// Their opacity.
        opacity: f64,
    },
    /// No object has the name.
    #[error(transparent)]
    Unknown(#[from] UnknownObject),
}

impl Opacities {
    /// The opacities of objects, by name; in a name `*` stands for any letters. Of several names that an object has, the last
    /// one counts. The scene must be the one of which a picture is made.
    ///
    /// # Errors
    /// [`InvalidOpacity`].
    pub fn new(scene: &Scene, opacities: &[(impl AsRef<str>, f64)]) -> Result<Opacities, InvalidOpacity> {
        let mut of_objects = Vec::new();
        for (name, opacity) in opacities {
            let (name, opacity) = (name.as_ref(), *opacity);
            if !(0.0..=1.0).contains(&opacity) {
                return Err(InvalidOpacity::Range { name: name.into(), opacity });
            }
            let is_named = scene.hiding(&[name])?.by_number(scene);
            of_objects.resize(is_named.len(), 1.0);
            for (of_object, _) in of_objects.iter_mut().zip(is_named).filter(|(_, is_named)| *is_named) {
                *of_object = opacity;
            }
        }
        Ok(Opacities { of_objects })
    }

    /// Whether no object is seen through.
    pub fn is_opaque(&self) -> bool {
        self.of_objects.iter().all(|opacity| *opacity == 1.0)
    }

    /// The opacity of an object.
    pub(crate) fn of(&self, object: u32) -> f64 {
        self.of_objects.get(object as usize).copied().unwrap_or(1.0)
    }
}
