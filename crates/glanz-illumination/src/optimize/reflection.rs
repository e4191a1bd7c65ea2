//! A ray from a point of a light to a point of a mirror and on, with derivatives.

use glanz_math::DVec3;

use super::surface_basis::LocalFrame;

/// The emitting end of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmittingPoint {
    pub(super) position: DVec3,
    /// Unit normal; `None` for a point light.
    pub(super) normal: Option<DVec3>,
    /// Whether the back emits, too.
    pub(super) two_sided: bool,
}

/// A ray after its reflection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflection {
    /// From the light to the mirror, metres.
    incident: DVec3,
    /// Area vector of the mirror: the product of its tangents.
    area: DVec3,
    /// The point of the mirror.
    pub(super) origin: DVec3,
    /// Reflected direction, as long as the incident vector.
    pub(super) direction: DVec3,
    /// Flux per unit of the sample's weight.
    pub(super) flux: f64,
}

/// Derivatives of a number by the parts of a reflection.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ReflectionGradient {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    pub(super) flux: f64,
}

/// Derivatives of a number by what a ray starts from.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SourceGradient {
    pub(super) light: DVec3,
    pub(super) mirror: LocalFrame,
}

impl Reflection {
    /// The flux is that of the form factor, `cos cos / r^2` times the area elements; for a point light it is the solid angle.
    pub(super) fn new(from: &EmittingPoint, mirror: &LocalFrame) -> Self {
        let incident = mirror.position - from.position;
        let [du, dv] = mirror.tangents;
        let area = du.cross(dv);
        let along = area.dot(incident);
        let direction = incident - 2.0 * along / area.length_squared() * area;
        let r2 = incident.length_squared();
        let flux = match from.normal {
            Some(normal) => emission(normal.dot(incident), from.two_sided).0 * along.abs() / (r2 * r2),
            None => along.abs() / (r2 * r2.sqrt()),
        };
        Self { incident, area, origin: mirror.position, direction, flux }
    }

    /// The derivatives by light and mirror of a number with these derivatives by the reflection.
    pub(super) fn source_gradient(
        &self,
        from: &EmittingPoint,
        mirror: &LocalFrame,
        by: &ReflectionGradient,
    ) -> SourceGradient {
        let (d, n) = (self.incident, self.area);
        let (along, n2, r2) = (n.dot(d), n.length_squared(), d.length_squared());
        // direction = d - 2 a n with a = n.d / n.n
        let a = along / n2;
        let by_a = -2.0 * n.dot(by.direction);
        let mut by_d = by.direction + by_a / n2 * n;
        let mut by_n = -2.0 * a * by.direction + by_a / n2 * (d - 2.0 * a * n);
        // flux = f(normal.d) |n.d| / r^4, or |n.d| / r^3
        let (cosine, slope, power, normal) = match from.normal {
            Some(normal) => {
                let (value, slope) = emission(normal.dot(d), from.two_sided);
                (value / (r2 * r2), slope / (r2 * r2), 4.0, normal)
            }
            None => (1.0 / (r2 * r2.sqrt()), 0.0, 3.0, DVec3::ZERO),
        };
        by_d += by.flux
            * (slope * along.abs() * normal + cosine * along.signum() * n - power * self.flux / r2 * d);
        by_n += by.flux * cosine * along.signum() * d;
        let [du, dv] = mirror.tangents;
        SourceGradient {
            light: -by_d,
            mirror: LocalFrame { position: by.origin + by_d, tangents: [dv.cross(by_n), by_n.cross(du)] },
        }
    }
}

/// The emitting part of the cosine (here times the distance), and its derivative.
fn emission(cosine: f64, two_sided: bool) -> (f64, f64) {
    match (cosine > 0.0, two_sided) {
        (true, _) => (cosine, 1.0),
        (false, true) => (-cosine, -1.0),
        (false, false) => (0.0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mirror() -> LocalFrame {
        LocalFrame {
            position: DVec3::new(0.3, -0.2, 1.1),
            tangents: [DVec3::new(1.0, 0.2, 0.3), DVec3::new(-0.1, 0.8, 0.2)],
        }
    }

    #[test]
    fn mirrored_ray_obeys_the_law_of_reflection_and_flux_is_the_form_factor() {
        let from = EmittingPoint { position: DVec3::ZERO, normal: Some(DVec3::Z), two_sided: false };
        let tangents = [DVec3::X * 2.0, DVec3::Y * 3.0];
        // A horizontal mirror of 6 m2 per unit of parameters at a height of 2 m, seen at 45 degrees.
        let flat = LocalFrame { position: DVec3::new(2.0, 0.0, 2.0), tangents };
        let reflection = Reflection::new(&from, &flat);
        assert!(reflection.direction.distance(DVec3::new(2.0, 0.0, -2.0)) < 1e-15);
        assert!((reflection.flux - 0.5 * 6.0 / 8.0).abs() < 1e-15);
        let point = EmittingPoint { normal: None, ..from };
        assert!((Reflection::new(&point, &flat).flux - 0.5_f64.sqrt() * 6.0 / 8.0).abs() < 1e-15);
        let behind = EmittingPoint { normal: Some(DVec3::NEG_Z), ..from };
        assert_eq!(Reflection::new(&behind, &flat).flux, 0.0);
        let two_sided = EmittingPoint { two_sided: true, ..behind };
        assert!((Reflection::new(&two_sided, &flat).flux - 0.5 * 6.0 / 8.0).abs() < 1e-15);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let by = ReflectionGradient {
            origin: DVec3::new(0.3, 1.0, -2.0),
            direction: DVec3::new(1.5, -0.4, 0.7),
            flux: 2.5,
        };
        let number = |from: &EmittingPoint, mirror: &LocalFrame| {
            let r = Reflection::new(from, mirror);
            by.origin.dot(r.origin) + by.direction.dot(r.direction) + by.flux * r.flux
        };
        for normal in [None, Some(DVec3::new(0.0, 0.6, 0.8))] {
            let from = EmittingPoint { position: DVec3::new(0.1, 0.05, -0.3), normal, two_sided: false };
            let gradient = Reflection::new(&from, &mirror()).source_gradient(&from, &mirror(), &by);
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let step = 1e-5 * axis;
                let check = |derivative: DVec3, difference: [f64; 2]| {
                    let slope = (difference[1] - difference[0]) / 2e-5;
                    assert!((derivative.dot(axis) - slope).abs() < 1e-8, "{derivative} {slope}");
                };
                let moved = |sign: f64| EmittingPoint { position: from.position + sign * step, ..from };
                check(gradient.light, [-1.0, 1.0].map(|sign| number(&moved(sign), &mirror())));
                let moved = |sign: f64| LocalFrame { position: mirror().position + sign * step, ..mirror() };
                check(gradient.mirror.position, [-1.0, 1.0].map(|sign| number(&from, &moved(sign))));
                for k in 0..2 {
                    let moved = |sign: f64| {
                        let mut frame = mirror();
                        frame.tangents[k] += sign * step;
                        frame
                    };
                    check(gradient.mirror.tangents[k], [-1.0, 1.0].map(|sign| number(&from, &moved(sign))));
                }
            }
        }
    }
}
