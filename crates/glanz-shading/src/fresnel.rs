//! Reflection and refraction at smooth boundaries.

use glanz_math::DVec3;

/// Reflected and transmitted fraction of light at a smooth boundary between dielectrics, or at a pane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DielectricSplit {
    /// Fraction of the flux that is reflected, [0, 1]; the rest is transmitted.
    pub reflectance: f64,
    /// Cosine of the refracted ray to the normal, >= 0; 0 under total reflection.
    pub cos_transmitted: f64,
    /// Whether there is total reflection.
    pub total: bool,
}

/// Fresnel's equations for unpolarised light between dielectrics.
///
/// `cos_incident`: cosine to the normal on the side the light comes from, clamped to [0, 1]. `eta`: refractive index on the
/// far side over that on the near side, > 0.
///
/// # Source
/// @born1999 section 1.5.2; the critical angle is document 000 section 1.7.4.
#[must_use]
pub fn dielectric(cos_incident: f64, eta: f64) -> DielectricSplit {
    unpolarised(cos_incident, eta, |r| r)
}

/// The same for a pane between two parallel boundaries, with the light that its faces reflect to each other, for unpolarised light.
///
/// `eta`: refractive index of the pane over that of the medium on both of its sides. The refracted ray is that inside.
///
/// Each face keeps the polarisations perpendicular and parallel to the plane of incidence, so that reflections are summed for each of them
/// and averaged then. With the mean reflectance of a face in their place, a pane of index 1.5 would transmit 4 % less at 80 degrees. Interference is
/// neglected: real panes are thicker than light is coherent.
///
/// # Source
/// @born1999 section 1.5.2 for each face.
#[must_use]
pub fn pane(cos_incident: f64, eta: f64) -> DielectricSplit {
    // r + t^2 r + t^2 r^3 + ... with t = 1 - r.
    unpolarised(cos_incident, eta, |r| 2.0 * r / (1.0 + r))
}

/// The mean over both polarisations of the fraction that `reflectance` makes of the reflectance of a boundary.
fn unpolarised(cos_incident: f64, eta: f64, reflectance: impl Fn(f64) -> f64) -> DielectricSplit {
    let cos_i = cos_incident.clamp(0.0, 1.0);
    if eta == 1.0 {
        return DielectricSplit { reflectance: 0.0, cos_transmitted: cos_i, total: false };
    }
    // cos^2 of the refracted ray times eta^2, free of cancellation near grazing incidence for eta = 1.
    let remainder = (eta - 1.0) * (eta + 1.0) + cos_i * cos_i;
    if remainder < 0.0 {
        return DielectricSplit { reflectance: 1.0, cos_transmitted: 0.0, total: true };
    }
    let scaled = remainder.sqrt();
    let cos_t = (scaled / eta).min(1.0);
    // r_s = (cos_i - eta cos_t) / (cos_i + eta cos_t), r_p = (eta cos_i - cos_t) / (eta cos_i + cos_t)
    let r_s = (cos_i - scaled) / (cos_i + scaled);
    let r_p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let mean = 0.5 * (reflectance(r_s * r_s) + reflectance(r_p * r_p));
    DielectricSplit { reflectance: mean.min(1.0), cos_transmitted: cos_t, total: false }
}

/// Reflectance of a smooth conductor for unpolarised light.
///
/// `cos_incident`: cosine to the normal, its sign does not matter. `eta` and `k`: real and imaginary part of the refractive index
/// relative to that of the surrounding medium, >= 0. With `k` = 0 this is [`dielectric`].
///
/// # Source
/// @born1999 section 14.2, in the real form of @lagarde2013.
#[must_use]
pub fn conductor(cos_incident: f64, eta: f64, k: f64) -> f64 {
    let cos = cos_incident.abs().min(1.0);
    let cos2 = cos * cos;
    let sin2 = 1.0 - cos2;
    // eta^2 - k^2 - sin^2, free of cancellation near grazing incidence for eta = 1, k = 0.
    let real = (eta - 1.0) * (eta + 1.0) - k * k + cos2;
    let a2_plus_b2 = real.hypot(2.0 * eta * k);
    let a = (0.5 * (a2_plus_b2 + real)).max(0.0).sqrt();
    let (sum, twist) = (a2_plus_b2 + cos2, 2.0 * cos * a);
    let s = ratio(sum - twist, sum + twist);
    let (sum, twist) = (cos2 * a2_plus_b2 + sin2 * sin2, twist * sin2);
    let p = s * ratio(sum - twist, sum + twist);
    (0.5 * (s + p)).clamp(0.0, 1.0)
}

/// `a / b`, 0 where both vanish: equal media at grazing incidence, which reflect nothing at any angle.
fn ratio(a: f64, b: f64) -> f64 {
    if b == 0.0 { 0.0 } else { a / b }
}

/// The direction of mirror reflection; `wo` and the result point away from the surface, `normal` has unit length.
///
/// # Source
/// Document 001 section 3.4: 2 (v . n) n - v.
#[must_use]
pub fn reflect(wo: DVec3, normal: DVec3) -> DVec3 {
    2.0 * wo.dot(normal) * normal - wo
}

/// The direction of refraction, away from the surface; `None` under total reflection.
///
/// `wo`: unit direction away from the surface. `normal`: unit normal of either side. `eta`: refractive index on the far
/// side of `wo` over that on its own side.
///
/// # Source
/// Document 000 eq. (1.7), with eta_12 = 1 / eta and v = -wo.
#[must_use]
pub fn refract(wo: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cos = wo.dot(normal);
    let split = dielectric(cos.abs(), eta);
    if split.total {
        return None;
    }
    let facing = if cos < 0.0 { -normal } else { normal };
    (facing * (cos.abs() / eta - split.cos_transmitted) - wo / eta).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_reflects_four_percent_at_normal_incidence_from_both_sides() {
        assert!((dielectric(1.0, 1.5).reflectance - 0.04).abs() < 1e-15);
        assert!((dielectric(1.0, 1.0 / 1.5).reflectance - 0.04).abs() < 1e-15);
    }

    #[test]
    fn at_brewster_angle_only_one_polarisation_is_reflected() {
        // tan(theta) = n; r_p = 0 and, since both rays are perpendicular, r_s = cos(2 theta) in size.
        let n: f64 = 1.5;
        let theta = n.atan();
        let expected = 0.5 * (2.0 * theta).cos().powi(2);
        assert!((dielectric(theta.cos(), n).reflectance - expected).abs() < 1e-15);
    }

    #[test]
    fn pane_reflects_what_bounces_between_its_faces_add_up_to() {
        for n in [1.33_f64, 1.5, 1.8, 2.4] {
            for degrees in [0.01, 30.0, 45.0, n.atan().to_degrees(), 60.0, 70.0, 80.0, 89.0] {
                let angle = f64::to_radians(degrees);
                let inner = (angle.sin() / n).asin();
                // Fresnel's equations by angles, perpendicular and parallel to the plane of incidence.
                let perpendicular = ((angle - inner).sin() / (angle + inner).sin()).powi(2);
                let parallel = ((angle - inner).tan() / (angle + inner).tan()).powi(2);
                // Light of each polarisation between the faces, followed until nothing is left of it.
                let [mut reflected, mut transmitted] = [0.0; 2];
                for r in [perpendicular, parallel] {
                    reflected += 0.5 * r;
                    let mut inside = 0.5 * (1.0 - r);
                    while inside > 1e-18 {
                        transmitted += inside * (1.0 - r);
                        reflected += inside * r * (1.0 - r);
                        inside *= r * r;
                    }
                }
                let found = pane(angle.cos(), n);
                let error =
                    (found.reflectance - reflected).abs().max((1.0 - found.reflectance - transmitted).abs());
                assert!(error < 1e-9, "{n} {degrees}: {found:?}, not {reflected} and {transmitted}");
                assert!((found.cos_transmitted - inner.cos()).abs() < 1e-12 && !found.total);
            }
        }
    }

    #[test]
    fn pane_at_brewster_angle_transmits_one_polarisation_wholly() {
        // The other is reflected by the fraction r = ((n^2 - 1) / (n^2 + 1))^2 at each face.
        for n in [1.33_f64, 1.5, 2.4] {
            let r = ((n * n - 1.0) / (n * n + 1.0)).powi(2);
            let expected = 0.5 * (2.0 * r / (1.0 + r));
            assert!((pane(n.atan().cos(), n).reflectance - expected).abs() < 1e-14, "{n}");
        }
    }

    #[test]
    fn pane_is_dark_along_its_surface_and_unseen_in_its_own_medium() {
        assert_eq!(pane(0.0, 1.5).reflectance, 1.0);
        assert_eq!(pane(0.3, 1.0).reflectance, 0.0);
        // A gap of air in glass beyond the critical angle.
        assert!(pane(0.6, 1.0 / 1.5).total && pane(0.6, 1.0 / 1.5).reflectance == 1.0);
        for n in [1.2, 1.5, 4.0_f64] {
            let r = ((n - 1.0) / (n + 1.0)).powi(2);
            assert!((pane(1.0, n).reflectance - 2.0 * r / (1.0 + r)).abs() < 1e-15, "{n}");
        }
    }

    #[test]
    fn total_reflection_begins_at_the_critical_angle() {
        // Document 000 section 1.7.4: glass to air at 41.8 degrees.
        let critical = (1.0_f64 / 1.5).asin();
        assert!((critical.to_degrees() - 41.8).abs() < 0.02);
        assert!(!dielectric((critical - 1e-9).cos(), 1.0 / 1.5).total);
        let beyond = dielectric((critical + 1e-9).cos(), 1.0 / 1.5);
        assert!(beyond.total);
        assert_eq!(beyond.reflectance, 1.0);
    }

    #[test]
    fn reflectance_is_the_same_along_a_ray_and_back() {
        for i in 0..90 {
            let cos = f64::from(i).to_radians().cos();
            let there = dielectric(cos, 1.33);
            let back = dielectric(there.cos_transmitted, 1.0 / 1.33);
            assert!((there.reflectance - back.reflectance).abs() < 1e-12);
            assert!((back.cos_transmitted - cos).abs() < 1e-14);
        }
    }

    #[test]
    fn grazing_light_is_reflected_unless_the_media_agree() {
        assert_eq!(dielectric(0.0, 1.5).reflectance, 1.0);
        for cos in [0.0, 1e-300, 1e-9, 0.5, 1.0] {
            assert_eq!(dielectric(cos, 1.0).reflectance, 0.0, "cos {cos}");
            assert!((conductor(cos, 1.0, 0.0)).abs() < 1e-12, "cos {cos}");
        }
    }

    #[test]
    fn conductor_at_normal_incidence_follows_the_closed_form() {
        // ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2); gold at 650 nm (@johnson1972: n = 0.166, k = 3.15): 0.942.
        let closed = |n: f64, k: f64| ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
        for (n, k) in [(0.166, 3.15), (1.5, 0.0), (0.0, 2.0), (3.0, 4.0)] {
            assert!((conductor(1.0, n, k) - closed(n, k)).abs() < 1e-14);
        }
        assert!((conductor(1.0, 0.166, 3.15) - 0.942).abs() < 1e-3);
        assert_eq!(conductor(0.0, 0.166, 3.15), 1.0);
    }

    #[test]
    fn conductor_agrees_with_complex_fresnel_coefficients() {
        // r_s = (cos - q) / (cos + q), r_p = (m^2 cos - q) / (m^2 cos + q), m = n + ik, q = sqrt(m^2 - sin^2).
        type Complex = (f64, f64);
        let norm = |a: Complex| a.0 * a.0 + a.1 * a.1;
        for (n, k) in [(0.166, 3.15), (2.5, 0.3), (1.5, 0.0)] {
            for i in 1..20 {
                let cos = f64::from(i) / 20.0;
                let m2: Complex = (n * n - k * k, 2.0 * n * k);
                let q2: Complex = (m2.0 - (1.0 - cos * cos), m2.1);
                let size = norm(q2).sqrt();
                let q: Complex = ((0.5 * (size + q2.0)).sqrt(), (0.5 * (size - q2.0)).max(0.0).sqrt());
                let r_s = norm((cos - q.0, -q.1)) / norm((cos + q.0, q.1));
                let r_p =
                    norm((m2.0 * cos - q.0, m2.1 * cos - q.1)) / norm((m2.0 * cos + q.0, m2.1 * cos + q.1));
                assert!((conductor(cos, n, k) - 0.5 * (r_s + r_p)).abs() < 1e-12, "{n} {k} {cos}");
            }
        }
    }

    #[test]
    fn conductor_without_absorption_is_a_dielectric() {
        for i in 0..=20 {
            let cos = f64::from(i) / 20.0;
            assert!((conductor(cos, 1.5, 0.0) - dielectric(cos, 1.5).reflectance).abs() < 1e-12);
        }
    }

    #[test]
    fn refraction_follows_snell_from_both_sides_of_any_normal() {
        let normal = DVec3::new(0.3, -0.5, 0.7).normalize();
        let wo = DVec3::new(-0.2, 0.4, 0.6).normalize();
        for (wo, eta) in [(wo, 1.5), (wo, 1.0), (-wo, 1.2), (wo, 0.99)] {
            let wi = refract(wo, normal, eta).unwrap();
            assert!((wi.length() - 1.0).abs() < 1e-15);
            let (sin_o, sin_i) = (wo.cross(normal), wi.cross(normal));
            assert!((sin_o + eta * sin_i).length() < 1e-14, "tangential parts oppose, scaled by eta");
            assert!(wi.dot(normal) * wo.dot(normal) < 0.0);
        }
        assert_eq!(refract(DVec3::new(0.8, 0.0, 0.6), DVec3::Z, 1.0 / 1.5), None);
        assert!((reflect(wo, normal).dot(normal) - wo.dot(normal)).abs() < 1e-15);
    }
}
