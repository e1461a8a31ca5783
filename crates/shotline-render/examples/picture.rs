//! Renders a scene file to a PNG, in soft light:
//! `cargo run --release -p shotline-render --example picture -- scenes/tori.json tori.png [LOOK] [SAMPLES]`

use std::error::Error;

use shotline::compile::{Options, compile};
use shotline::query::batch::Run;
use shotline_render::{Lighting, Settings, encode_png, look, render};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(scene), Some(picture)) = (arguments.next(), arguments.next()) else {
        return Err("usage: picture SCENE PICTURE [LOOK] [SAMPLES]".into());
    };
    let name = arguments.next().unwrap_or("lit".into());
    let look = look(&name).ok_or("there is no such look")?;
    let samples = arguments.next().map_or(Ok(64), |n| n.parse())?;

    let document = shotline_io::load(scene)?;
    let world = compile(&document.scene, Options::default()).map_err(|e| document.diagnostics(&e))?;
    let settings = Settings { samples, look, lighting: Lighting::Soft, ..Settings::default() };
    let image = render(&world, &document.scene, &settings, Run::default())?;
    Ok(std::fs::write(picture, encode_png(&image))?)
}
