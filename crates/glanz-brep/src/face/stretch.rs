//! By how much distances on a surface grow in region coordinates.

use glanz_math::DVec2;

use crate::boundary::BoundaryCurve;
use crate::carrier::Carrier;

/// Largest ratio by which the width of a curve grows where parameters are dense, as near a pole.
const MAX_STRETCH: f64 = 1e3;

/// How much longer a small distance on the surface may be in region coordinates, at the points of a curve.
pub(super) fn stretch(carrier: &Carrier, metric: DVec2, curve: &BoundaryCurve) -> f64 {
    /// Between samples the ratio is taken to change by less than this.
    const SAFETY: f64 = 1.25;
    let mut least = f64::INFINITY;
    for at in curve.samples() {
        let [du, dv] = carrier.tangents(at / metric);
        let (du, dv) = (du / metric.x, dv / metric.y);
        // The smallest singular value of the two columns.
        let (e, f, g) = (du.length_squared(), du.dot(dv), dv.length_squared());
        let mean = 0.5 * (e + g);
        let square = mean - ((0.5 * (e - g)).powi(2) + f * f).sqrt();
        least = least.min(square.max(0.0).sqrt());
    }
    if least.is_finite() { (SAFETY / least).clamp(1.0, MAX_STRETCH) } else { 1.0 }
}
