//! Plots of the integrands, their approximations and the densities.

use std::f64::consts::PI;

use glanz_sampling::density::Density;
use glanz_sampling::integrate::AdaptiveResult;

use crate::densities::measure::{plane, sine};
use glanz_report::{Axis, Plot, Series};

/// Steps of a curve, three in each of the finest segments.
const STEPS: u32 = 24;
/// Segments of the finest scale; functions may jump between them.
const SEGMENTS: u32 = 8;
/// Distance from a jump at which a curve is evaluated on both sides.
const BESIDE: f64 = 1e-9;

/// Points of a curve over [0, 1], where segments meet from both sides.
fn curve(name: impl Into<String>, f: impl Fn(f64) -> f64) -> Series {
    let points = (0..=STEPS).flat_map(|i| {
        let x = f64::from(i) / f64::from(STEPS);
        let before = (i > 0).then(|| [x, f(x - BESIDE)]);
        let after = (i < STEPS && (i == 0 || i % (STEPS / SEGMENTS) == 0)).then(|| [x, f(x + BESIDE)]);
        before.into_iter().chain(after)
    });
    Series { name: name.into(), points: points.collect() }
}

/// Figure 2.6: the sine and the approximation learnt in each pass.
pub(super) fn approximations(title: &str, result: &AdaptiveResult<1>) -> Plot {
    let mut series = vec![curve("sin(pi x / 2)", |x| sine(&[x]))];
    for (index, pass) in result.passes.iter().enumerate().take(3) {
        if let Some(c) = &pass.approximation {
            let basis = pass.density.basis();
            let name = format!("pass {}, scale {}", index + 1, pass.levels[0]);
            series.push(curve(name, |x| basis.evaluate(c, &[x]).unwrap_or(f64::NAN)));
        }
    }
    Plot {
        title: title.to_owned(),
        x: Axis::linear("x"),
        y: Axis::linear("integrand, approximation"),
        series,
        reference_lines: Vec::new(),
    }
}

/// The densities that passes 2 to 4 sample, and the best one.
pub(super) fn densities(title: &str, result: &AdaptiveResult<1>) -> Plot {
    let mut series = vec![curve("best density", |x| 0.5 * PI * sine(&[x]))];
    for (index, pass) in result.passes.iter().enumerate().skip(1) {
        series.push(curve(format!("pass {}", index + 1), |x| pass.density.pdf(&[x])));
    }
    Plot {
        title: title.to_owned(),
        x: Axis::linear("x"),
        y: Axis::linear("probability density"),
        series,
        reference_lines: Vec::new(),
    }
}

/// Figure 2.7: the integrand of two variables along lines of constant v.
pub(super) fn integrand() -> Plot {
    let series = [0.25, 0.5, 0.75, 1.0].map(|v| curve(format!("v = {v}"), move |u| plane(&[u, v])));
    Plot {
        title: "sin(pi (1 - u) / 2) sin(pi v / 2)".to_owned(),
        x: Axis::linear("u"),
        y: Axis::linear("integrand"),
        series: series.into(),
        reference_lines: Vec::new(),
    }
}

/// Figures 2.8 and 2.9: densities along the diagonal v = 1 - u, where the best one goes from its largest value to 0.
pub(super) fn along_diagonal(title: &str, densities: &[(String, Density<2>)]) -> Plot {
    let mut series = vec![curve("best density", |u| 0.25 * PI * PI * plane(&[u, 1.0 - u]))];
    for (name, density) in densities {
        series.push(curve(name.clone(), |u| density.pdf(&[u, 1.0 - u])));
    }
    Plot {
        title: title.to_owned(),
        x: Axis::linear("u, with v = 1 - u"),
        y: Axis::linear("probability density"),
        series,
        reference_lines: Vec::new(),
    }
}
