//! The outermost volume: the object that is the scene's only root, or a box around all roots.

use shotline::compile::{Options, compile};
use shotline::math::{Affine, Vec3};
use shotline::scene::Node;

use super::Writer;
use super::report::Reported;
use super::volumes::VolumeKey;

/// By how much the box of the world is larger than what it holds.
const MARGIN: f64 = 1.1;

impl Writer<'_> {
    /// Writes all volumes, and returns the name of the world.
    pub(super) fn world(&mut self) -> Result<String, Reported> {
        let scene = self.scene;
        if let [root] = scene.objects[..]
            && let Node::Object { .. } = scene.node(root)
        {
            let volume = self.volume(VolumeKey::of(root, Vec3::ONE), true)?;
            if !volume.is_assembly {
                return Ok(volume.name);
            }
        }
        self.box_around_all()
    }

    /// A box of vacuum around all roots, with its middle at the origin.
    fn box_around_all(&mut self) -> Result<String, Reported> {
        let name = self.names.free("World");
        self.volume_names.reserve(name.clone());
        self.object.clone_from(&name);
        let mut children = self.objects_among(self.scene.objects.clone(), Vec3::ONE);
        if self.structure.has_priorities {
            children.sort_by_key(|child| child.priority);
            self.check_priorities(&children);
        }
        for child in &children {
            // What cannot be written has been reported.
            let _ = self.volume(child.key, false);
        }
        if self.report.is_refused() {
            return Err(Reported);
        }
        self.object.clone_from(&name);
        let half = self.half_extent()?;
        let solid = self.solid("box", |element| {
            let side = |axis: usize| 2.0 * half[axis];
            let element = element.length("x", side(0)).length("y", side(1));
            element.length("z", side(2)).in_millimetres()
        });
        let material = self.vacuum();
        let element = self.element("volume").named(&name);
        let element = element.reference("materialref", &material).reference("solidref", &solid);
        let element = self.with_children(element, &Affine::IDENTITY, &children)?;
        self.check(&element);
        element.write(&mut self.volumes_text);
        let roots = self.scene.objects.len();
        self.report.note(format!(
            "the volume '{name}', a box of vacuum, was added around {roots} roots of the scene"
        ));
        Ok(name)
    }

    /// Half the sides of a box around everything, with few digits.
    fn half_extent(&mut self) -> Result<Vec3, Reported> {
        // Of the world only the bounds are needed, so no time is spent on an accelerator.
        let world = compile(self.scene, Options { accel: Some("brute") });
        let bounds = match world {
            Ok(world) => world.finite_bounds(),
            Err(errors) => {
                for error in errors {
                    self.report.refuse(error.to_string());
                }
                return Err(Reported);
            }
        };
        if bounds.is_empty() {
            return Err(self.report.refuse("the scene has no solids".into()));
        }
        let reach = bounds.min.abs().max(bounds.max.abs()) * MARGIN;
        Ok(Vec3::from(reach.to_array().map(rounded_up)))
    }
}

/// The next number of two digits that is not less.
fn rounded_up(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return x;
    }
    let unit = libm::pow(10.0, libm::floor(libm::log10(x)) - 1.0);
    (x / unit).ceil() * unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_have_few_digits() {
        assert_eq!([1.01, 99.9, 123.4, 50.0].map(rounded_up), [1.1, 100.0, 130.0, 50.0]);
    }
}
