//! The options that say from where a picture is seen.

use std::str::FromStr;

use clap::Args;
use shotline::math::Vec3;
use shotline_render::{StandardView, Viewpoint};

use crate::number::parse_vector;

/// From where the picture is seen.
#[derive(Args, Clone, Copy, Debug)]
pub struct ViewpointFlags {
    /// See everything from a standard direction, with z up, in parallel projection unless --fov is given: front (from -y),
    /// back, left (from -x), right, top, bottom or iso
    #[arg(long, value_name = "NAME", value_parser = StandardView::from_str, conflicts_with_all = ["eye", "target", "up"])]
    view: Option<StandardView>,
    /// Where the eye is; default: that of the scene's camera, or a point from which everything is seen
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vector, allow_hyphen_values = true)]
    eye: Option<Vec3>,
    /// What the eye looks at; default: that of the scene's camera, or the middle of everything
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vector, allow_hyphen_values = true)]
    target: Option<Vec3>,
    /// The direction that points up in the picture; default: that of the scene's camera, or z
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vector, allow_hyphen_values = true)]
    up: Option<Vec3>,
    /// The vertical angle of view in degrees
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    fov: Option<f64>,
    /// Magnify the picture about its middle by this factor
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    zoom: Option<f64>,
}

impl ViewpointFlags {
    /// The viewpoint that the options give.
    pub fn viewpoint(&self) -> Viewpoint {
        let &ViewpointFlags { view, eye, target, up, fov, zoom } = self;
        Viewpoint { view, eye, target, up, fov, zoom }
    }
}
