//! What scenes say against what their descriptions hold; expected values follow from pbrt's documentation.

mod film;
mod layered_material;
mod light;
mod material;
mod medium;
mod receiver;
mod shape;
mod space;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glanz_formats::{Loaded, Options, load_str};
use glanz_light::{SpectralDistribution, Wavelengths, named};
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::description::{
    AlphaDescription, CameraKind, EmissionPower, FilterKind, FisheyeProjection, FloatParameter, FractalKind,
    GeometryDescription, IrisDescription, LensInterfaceDescription, LightDescription, LightKind,
    MappingDescription, MaterialKind, SampleLimit, SensorDescription, SpectrumParameter, SphericalMapping,
    SpotFalloff, StopShape, SurfaceDetailDescription, TextureKind,
};

fn read(text: &str) -> Loaded {
    load_str("test.pbrt", text, &Options::default()).unwrap_or_else(|d| panic!("{d}"))
}

/// Reads what must not even cause a warning.
fn read_clean(text: &str) -> Loaded {
    let loaded = read(text);
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
    loaded
}

fn material(text: &str) -> MaterialKind {
    read(&format!("WorldBegin Material {text}")).description.materials[0].kind.clone()
}

fn value(input: &SpectrumParameter) -> [f32; 3] {
    match input {
        SpectrumParameter::Value(s) => rgb(s),
        SpectrumParameter::Texture(i) => panic!("texture {i}"),
    }
}

fn rgb(s: &SpectralDistribution) -> [f32; 3] {
    s.radiance(&Wavelengths::Rgb).to_rgb(&Wavelengths::Rgb)
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-6 * b.abs().max(1.0), "{a}, expected {b}");
}
