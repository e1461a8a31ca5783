//! Pictures as arrays.

use std::io::Write;
use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray3, PyArrayMethods, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use shotline::counters::COUNTERS;
use shotline::scene::{Camera, HiddenObjects, Lens};
use shotline_io::atomic_write;
use shotline_render::{
    ClipPlane, Exposure, Image, InvalidOpacity, LOOKS, Lighting, Opacities, Sample, Settings, StandardView,
    Viewpoint, camera_of, encode_bytes, encode_jpeg_bytes, look, visible_subject,
};

use crate::cancellation::work;
use crate::scene::{Scene, write_error};

/// The `View` of the Python half, read by attribute.
#[derive(FromPyObject)]
pub struct View {
    eye: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    /// The vertical angle of view in degrees, for a perspective picture.
    fov: Option<f64>,
    /// The height in world units, for a parallel projection.
    height: Option<f64>,
}

/// Eye, target, up, angle of view and height.
type ViewFields = ([f64; 3], [f64; 3], [f64; 3], Option<f64>, Option<f64>);

impl View {
    fn camera(&self) -> PyResult<Camera> {
        let View { eye, target, up, fov, height } = *self;
        let lens = match (fov, height) {
            (Some(fov), None) => Lens::Pinhole { fov },
            (None, Some(height)) => Lens::Orthographic { height },
            _ => return Err(PyValueError::new_err("a camera takes either fov or height")),
        };
        Ok(Camera { eye: eye.into(), target: target.into(), up: up.into(), lens })
    }
}

/// The `PictureSettings` of the Python half, read by attribute.
#[derive(FromPyObject)]
pub struct PictureSettings {
    width: u32,
    height: u32,
    samples: u32,
    look: String,
    lighting: String,
    counter: String,
    background: Option<String>,
    edges: bool,
    clip: Vec<String>,
    hatch: bool,
    hide: Vec<String>,
    only: Vec<String>,
    opacity: Vec<(String, f64)>,
    view: Option<String>,
}

impl PictureSettings {
    fn standard_view(&self) -> PyResult<Option<StandardView>> {
        let parse = |name: &String| {
            name.parse().map_err(|error| PyValueError::new_err(format!("there is no view {name:?}: {error}")))
        };
        self.view.as_ref().map(parse).transpose()
    }

    fn resolve(&self, scene: &shotline::scene::Scene, camera: Option<View>) -> PyResult<Settings> {
        let PictureSettings {
            width, height, samples, look: look_name, lighting, counter, background, ..
        } = self;
        let plane = |text: &String| {
            text.parse::<ClipPlane>()
                .map_err(|e| PyValueError::new_err(format!("clip has the plane {text:?}: {e}")))
        };
        let unknown = |what: &str, name: &str, known: Vec<&str>| {
            PyValueError::new_err(format!("there is no {what} {name:?}; the names are {}", known.join(", ")))
        };
        let counters = || COUNTERS.iter().map(|c| c.name).collect();
        Ok(Settings {
            width: *width,
            height: *height,
            samples: *samples,
            camera: camera.as_ref().map(View::camera).transpose()?,
            look: look(look_name)
                .ok_or_else(|| unknown("look", look_name, LOOKS.iter().map(|l| l.name).collect()))?,
            lighting: match lighting.as_str() {
                "sharp" => Lighting::Sharp,
                "plain" => Lighting::Plain,
                "soft" => Lighting::Soft,
                _ => return Err(unknown("lighting", lighting, vec!["sharp", "plain", "soft"])),
            },
            counter: COUNTERS
                .iter()
                .find(|c| c.name == counter)
                .ok_or_else(|| unknown("counter", counter, counters()))?,
            background: match background {
                Some(name) => Some(
                    name.parse()
                        .map_err(|e| PyValueError::new_err(format!("background is {name:?}: {e}")))?,
                ),
                None => None,
            },
            edges: self.edges,
            hatch: self.hatch,
            clip: self.clip.iter().map(plane).collect::<PyResult<_>>()?,
            hidden: self.hidden(scene)?,
            opacities: self.opacities(scene)?,
            viewpoint: Viewpoint { view: self.standard_view()?, ..Viewpoint::default() },
            ..Settings::default()
        })
    }

    fn opacities(&self, scene: &shotline::scene::Scene) -> PyResult<Opacities> {
        Opacities::new(scene, &self.opacity).map_err(|error| match error {
            InvalidOpacity::Unknown(e) => {
                PyValueError::new_err(format!("opacity: {e}; scene.object_names lists the objects"))
            }
            error => PyValueError::new_err(error.to_string()),
        })
    }

    fn hidden(&self, scene: &shotline::scene::Scene) -> PyResult<HiddenObjects> {
        let hidden = match (&self.hide[..], &self.only[..]) {
            ([], []) => return Ok(scene.hiding_enclosures()),
            (hide, []) => scene.hiding(hide),
            ([], only) => scene.showing_only(only),
            _ => return Err(PyValueError::new_err("a picture takes either hide or only")),
        };
        hidden.map_err(|e| PyValueError::new_err(format!("{e}; scene.object_names lists the objects")))
    }
}

/// Renders a range of rows, the end excluded, to linear colours, alpha and lines: (rows, width, 5).
#[pyfunction]
pub fn expose<'py>(
    py: Python<'py>,
    scene: PyRef<'py, Scene>,
    settings: PictureSettings,
    camera: Option<View>,
    rows: (u32, u32),
    threads: usize,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let settings = settings.resolve(&scene.scene, camera)?;
    let (world, described) = (&*scene.world, &*scene.scene);
    let exposed = work(py, usize::MAX, threads, None, |run| {
        shotline_render::expose(world, described, &settings, rows.0..rows.1, run)
    })?;
    let Exposure { width, height, samples } = exposed.map_err(|e| PyValueError::new_err(e.to_string()))?;
    let numbers: Vec<f64> =
        samples.iter().flat_map(|s| [s.color.x, s.color.y, s.color.z, s.alpha, s.ink]).collect();
    numbers.into_pyarray(py).reshape([height as usize, width as usize, 5])
}

/// The picture from what [`expose`] returns for all rows.
#[pyfunction]
pub fn develop<'py>(
    py: Python<'py>,
    scene: PyRef<'py, Scene>,
    settings: PictureSettings,
    camera: Option<View>,
    samples: PyReadonlyArray3<'py, f64>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let settings = settings.resolve(&scene.scene, camera)?;
    let (pixels, _) = samples.as_slice()?.as_chunks::<5>();
    let sample = |&[r, g, b, alpha, ink]: &[f64; 5]| Sample { color: [r, g, b].into(), alpha, ink };
    let samples = pixels.iter().map(sample).collect();
    let exposure = Exposure { width: settings.width, height: settings.height, samples };
    let image = shotline_render::develop(&scene.world, &scene.scene, &settings, exposure);
    array(py, &image.map_err(|e| PyValueError::new_err(e.to_string()))?)
}

fn array<'py>(py: Python<'py>, image: &Image) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let shape = [image.height() as usize, image.width() as usize, image.channels()];
    image.to_bytes().into_pyarray(py).reshape(shape)
}

/// Eight-bit sRGB of shape (height, width, 3), or 4 with alpha.
#[pyfunction]
pub fn render<'py>(
    py: Python<'py>,
    scene: PyRef<'py, Scene>,
    settings: PictureSettings,
    camera: Option<View>,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let settings = settings.resolve(&scene.scene, camera)?;
    let rays = settings.width as usize * settings.height as usize * settings.samples as usize;
    let (world, described) = (&*scene.world, &*scene.scene);
    let image = work(py, rays, threads, progress.as_ref(), |run| {
        shotline_render::render(world, described, &settings, run)
    })?;
    array(py, &image.map_err(|e| PyValueError::new_err(e.to_string()))?)
}

/// The camera of a picture, as the fields of `View`.
#[pyfunction]
pub fn picture_camera(
    scene: PyRef<Scene>,
    settings: PictureSettings,
    camera: Option<View>,
) -> PyResult<ViewFields> {
    let settings = settings.resolve(&scene.scene, camera)?;
    let subject = visible_subject(&scene.world, &scene.scene, &settings.hidden);
    let camera = camera_of(subject, &scene.scene, &settings);
    let Camera { eye, target, up, lens } = camera.map_err(|e| PyValueError::new_err(e.to_string()))?;
    let (fov, height) = match lens {
        Lens::Pinhole { fov } => (Some(fov), None),
        Lens::Orthographic { height } => (None, Some(height)),
    };
    Ok((eye.to_array(), target.to_array(), up.to_array(), fov, height))
}

/// The PNG of eight-bit sRGB of shape (height, width, 3 or 4).
#[pyfunction]
pub fn encode_png<'py>(py: Python<'py>, pixels: PyReadonlyArray3<'py, u8>) -> PyResult<Bound<'py, PyBytes>> {
    Ok(PyBytes::new(py, &png(&pixels)?))
}

/// Writes that PNG to a file, atomically.
#[pyfunction]
pub fn save_png(path: PathBuf, pixels: PyReadonlyArray3<u8>) -> PyResult<()> {
    let png = png(&pixels)?;
    atomic_write(&path, |out| out.write_all(&png)).map_err(write_error)
}

/// Writes the JPEG of eight-bit sRGB of shape (height, width, 3) to a file, atomically.
#[pyfunction]
pub fn save_jpeg(path: PathBuf, pixels: PyReadonlyArray3<u8>) -> PyResult<()> {
    let [width, height] = size(&pixels)?;
    let jpeg = encode_jpeg_bytes(width, height, pixels.as_slice()?)
        .map_err(|e| PyValueError::new_err(e.to_string()))?;
    atomic_write(&path, |out| out.write_all(&jpeg)).map_err(write_error)
}

fn png(pixels: &PyReadonlyArray3<u8>) -> PyResult<Vec<u8>> {
    let [width, height] = size(pixels)?;
    encode_bytes(width, height, pixels.as_slice()?.to_vec()).map_err(|e| PyValueError::new_err(e.to_string()))
}

/// The width and the height of pixels.
fn size(pixels: &PyReadonlyArray3<u8>) -> PyResult<[u32; 2]> {
    let [height, width, channels] = [0, 1, 2].map(|axis| pixels.shape()[axis]);
    let side = |n: usize| u32::try_from(n).map_err(|_| PyValueError::new_err("the picture is too large"));
    if !(3..=4).contains(&channels) {
        return Err(PyValueError::new_err(format!("a picture has 3 or 4 channels, not {channels}")));
    }
    Ok([side(width)?, side(height)?])
}
