//! Freeform surfaces and trimming: what scenes say against what their descriptions hold, and what bad ones are told.

mod file;
mod surface;
mod trim;

use std::f64::consts::FRAC_1_SQRT_2;

use glanz_formats::{Options, load_str};
use glanz_scene::description::{
    BezierPatchesDescription, GeometryDescription, NurbsDescription, ShapeDescription, TrimCurveDescription,
    TrimDescription,
};

/// The only shape of a scene that must not even cause a warning.
fn shape(text: &str) -> ShapeDescription {
    let text = format!("WorldBegin Shape {text}");
    let loaded = load_str("test.pbrt", &text, &Options::default()).unwrap_or_else(|d| panic!("{d}"));
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
    loaded.description.world.shapes[0].clone()
}

/// The first error's `line:column: message`.
fn error(text: &str) -> String {
    let errors = load_str("bad.pbrt", text, &Options::default()).expect_err(text);
    let first = errors.iter().next().unwrap();
    let location = first.location.unwrap();
    format!("{}:{}: {}", location.line, location.column, first.message)
}

/// `text` with every `from` made `to`.
fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from:?} is not in {text:?}");
    text.replace(from, to)
}

/// Each text must be refused with its message first.
fn check_errors(cases: &[(String, &str)]) {
    for (text, message) in cases {
        assert_eq!(error(text), *message);
    }
}
