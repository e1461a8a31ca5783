//! The option that makes objects seen through.

use clap::Args;
use shotline::scene::Scene;
use shotline_render::{InvalidOpacity, Opacities};

use crate::failure::Failure;

/// The objects that are seen through.
#[derive(Args, Debug)]
pub struct OpacityFlags {
    /// See through the objects of this name, in the looks lit and normal: 0 is invisible, 1 opaque. * stands for any letters.
    /// May be given several times; of several names that an object has, the last one counts. What is seen through has no shadow
    #[arg(long, value_name = "NAME=SHARE", value_parser = parse_opacity)]
    opacity: Vec<(String, f64)>,
}

impl OpacityFlags {
    /// The opacities of the objects of a scene.
    ///
    /// # Errors
    /// If no object has one of the names, or if a number is out of range.
    pub fn opacities(&self, scene: &Scene) -> Result<Opacities, Failure> {
        Opacities::new(scene, &self.opacity).map_err(|error| {
            let help = match error {
                InvalidOpacity::Unknown(_) => {
                    "\nhelp: `shotline info` lists the objects; * stands for any letters"
                }
                InvalidOpacity::Range { .. } => "",
            };
            Failure::new(format!("--opacity: {error}{help}"))
        })
    }
}

/// Parses a name and a number, as in wall=0.3. The name may have a = in it.
fn parse_opacity(text: &str) -> Result<(String, f64), String> {
    let parts = text.rsplit_once('=').and_then(|(name, share)| Some((name, share.trim().parse().ok()?)));
    match parts {
        Some((name, share)) if !name.is_empty() => Ok((name.to_string(), share)),
        _ => Err("expected the name of an object and a number from 0 to 1, as in wall=0.3".into()),
    }
}
