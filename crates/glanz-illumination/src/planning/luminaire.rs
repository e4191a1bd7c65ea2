//! Luminaires at their places, as planners' figures need them: intensity and luminous area.

use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

use glanz_light::intensity::{IntensityDistribution, LuminousOpening, OpeningShape};
use glanz_math::{DMat3, DVec3, Transform};
use glanz_scene::Description;
use glanz_scene::description::{LightKind, LuminaireDescription};

/// A luminaire at its place.
#[derive(Clone, Debug)]
pub struct PlacedLuminaire {
    /// Its name in messages.
    pub name: String,
    /// What its file states, if it is known; the opening with sizes in the world, metres.
    pub description: Option<Arc<LuminaireDescription>>,
    /// Candela by direction in the luminaire's frame.
    pub distribution: Arc<IntensityDistribution>,
    /// Factor on the candela.
    pub factor: f64,
    /// The luminous opening, with sizes in the world, metres.
    pub opening: LuminousOpening,
    /// The photometric centre in the world, metres.
    pub position: DVec3,
    /// The axes of the luminaire in the world; orthonormal, perhaps mirrored.
    pub axes: DMat3,
}

impl PlacedLuminaire {
    /// The photometric lights of a scene, numbered from 1 in its order; those of ray files and of other kinds are none.
    ///
    /// A light that emits from a point has no opening, even if its file states one. Transformations that are no similarity, which the scene refuses,
    /// are left out.
    #[must_use]
    pub fn of_scene(description: &Description) -> Vec<Self> {
        let photometric = description.lights.iter().filter_map(|light| match &light.kind {
            LightKind::Photometric { distribution, opening, from } => {
                Some((light, distribution, opening, from))
            }
            _ => None,
        });
        let placed = (1..).zip(photometric).filter_map(|(number, (light, distribution, opening, from))| {
            let to_world = Transform::try_from_matrix(light.to_world).ok()?;
            let z = to_world.vector(DVec3::Z);
            // Rotations change lengths by rounding, which is not to make kinds of luminaires of their own.
            let scale = (z.length() * 1e12).round() / 1e12;
            let z = z.try_normalize()?;
            let x = to_world.vector(DVec3::X).reject_from_normalized(z).try_normalize()?;
            let y = z.cross(x) * light.to_world.determinant().signum();
            let opening = opening.unwrap_or(LuminousOpening::POINT);
            let scaled = |opening: LuminousOpening| LuminousOpening {
                size: opening.size.map(|length| length * scale),
                ..opening
            };
            // Those of one file are shared unless the scene scales them.
            let own = |stated: &Arc<LuminaireDescription>| {
                if scale == 1.0 {
                    return Arc::clone(stated);
                }
                let opening = scaled(stated.opening);
                Arc::new(LuminaireDescription { opening, ..LuminaireDescription::clone(stated) })
            };
            Some(Self {
                name: format!("luminaire {number}"),
                description: light.luminaire.as_ref().map(own),
                distribution: Arc::clone(distribution),
                factor: f64::from(light.scale),
                opening: scaled(opening),
                position: to_world.point(*from),
                axes: DMat3::from_cols(x, y, z),
            })
        });
        placed.collect()
    }

    /// Candela towards a point; 0 in the photometric centre.
    #[must_use]
    pub fn intensity_towards(&self, point: DVec3) -> f64 {
        self.factor * self.distribution.intensity(self.axes.transpose() * (point - self.position))
    }

    /// Area of the opening, m^2, as seen from a point far away; see [`projected_area`].
    #[must_use]
    pub fn area_towards(&self, point: DVec3) -> f64 {
        projected_area(&self.opening, self.axes.transpose() * (point - self.position))
    }

    /// The largest area of the opening as seen along its axes, m^2; 0 for points and lines.
    #[must_use]
    pub fn largest_area(&self) -> f64 {
        let along = [DVec3::X, DVec3::Y, DVec3::NEG_Z].map(|axis| projected_area(&self.opening, axis));
        along.into_iter().fold(0.0, f64::max)
    }

    /// Luminous flux, lm.
    #[must_use]
    pub fn flux(&self) -> f64 {
        self.factor * self.distribution.flux()
    }
}

/// Area of a luminous opening projected on the plane across a `direction` of any length in the luminaire's frame, in the square of the unit of its sizes;
/// 0 for points and lines.
///
/// Flat openings count from both sides. Boxes and upright cylinders have no luminous top.
#[must_use]
pub fn projected_area(opening: &LuminousOpening, direction: DVec3) -> f64 {
    let [x, y, z] = opening.size;
    let DVec3 { x: dx, y: dy, z: dz } = direction.normalize_or_zero().abs();
    let downwards = if direction.z < 0.0 { dz } else { 0.0 };
    match opening.shape {
        OpeningShape::Point => 0.0,
        OpeningShape::Rectangle => x * y * dz,
        OpeningShape::Box => x * y * downwards + y * z * dx + x * z * dy,
        OpeningShape::Ellipse => FRAC_PI_4 * x * y * dz,
        OpeningShape::VerticalCylinder => FRAC_PI_4 * x * y * downwards + z * (x * dy).hypot(y * dx),
        OpeningShape::CylinderAlongX => FRAC_PI_4 * y * z * dx + x * (y * dz).hypot(z * dy),
        OpeningShape::CylinderAlongY => FRAC_PI_4 * x * z * dy + y * (x * dz).hypot(z * dx),
        OpeningShape::Ellipsoid => FRAC_PI_4 * DVec3::new(y * z * dx, x * z * dy, x * y * dz).length(),
        OpeningShape::EllipseFacingX => FRAC_PI_4 * y * z * dx,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::test_luminaires::uniform;
    use glanz_math::DMat4;
    use glanz_scene::SceneBuilder;
    use glanz_scene::description::LightDescription;
    use std::f64::consts::PI;

    /// The area that the shadow of a convex solid has, by Cauchy's formula: a quarter of its surface on average over all directions.
    fn mean_shadow(opening: &LuminousOpening) -> f64 {
        let n = 400;
        let mut sum = 0.0;
        for i in 0..n {
            let z = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(n);
            for j in 0..n {
                let (sin, cos) = (2.0 * PI * (f64::from(j) + 0.5) / f64::from(n)).sin_cos();
                let r = (1.0 - z * z).sqrt();
                sum += projected_area(opening, DVec3::new(r * cos, r * sin, z));
            }
        }
        sum / f64::from(n * n)
    }

    #[test]
    fn mean_shadows_of_solids_are_a_quarter_of_their_luminous_surfaces() {
        let (w, l, h) = (0.4, 0.7, 0.2);
        // Perimeter of the ellipse with half axes 0.2 and 0.1, by Ramanujan's second formula (error below 1e-9 of it).
        let ring = |a: f64, b: f64| {
            let h = ((a - b) / (a + b)).powi(2);
            PI * (a + b) * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()))
        };
        for (shape, surface) in [
            (OpeningShape::Rectangle, 2.0 * w * l),
            (OpeningShape::Ellipse, 0.5 * PI * w * l),
            (OpeningShape::EllipseFacingX, 0.5 * PI * l * h),
            // Without the top: a single-sided face counts half of a two-sided one.
            (OpeningShape::Box, w * l + 2.0 * h * (w + l)),
            (OpeningShape::VerticalCylinder, FRAC_PI_4 * w * l + h * ring(0.5 * w, 0.5 * l)),
            (OpeningShape::CylinderAlongX, 0.5 * PI * l * h + w * ring(0.5 * l, 0.5 * h)),
            (OpeningShape::CylinderAlongY, 0.5 * PI * w * h + l * ring(0.5 * w, 0.5 * h)),
        ] {
            let found = mean_shadow(&LuminousOpening { shape, size: [w, l, h] });
            assert!((found / (0.25 * surface) - 1.0).abs() < 1e-4, "{shape:?}: {found}, {}", 0.25 * surface);
        }
        let sphere = LuminousOpening { shape: OpeningShape::Ellipsoid, size: [w; 3] };
        assert!((mean_shadow(&sphere) / (FRAC_PI_4 * w * w) - 1.0).abs() < 1e-10);
        assert_eq!(mean_shadow(&LuminousOpening::POINT), 0.0);
    }

    #[test]
    fn luminaires_of_a_scene_are_placed_and_scaled() {
        let opening = LuminousOpening { shape: OpeningShape::Rectangle, size: [0.2, 0.1, 0.0] };
        let kind = LightKind::Photometric {
            distribution: uniform(10.0),
            opening: Some(opening),
            from: DVec3::new(0.0, 0.0, 1.0),
        };
        // x to y, y to -x, twice as large.
        let to_world = DMat4::from_translation(DVec3::X)
            * DMat4::from_rotation_z(0.5 * PI)
            * DMat4::from_scale(DVec3::splat(2.0));
        let stated = LuminaireDescription { opening, ..LuminaireDescription::default() };
        let light = LightDescription {
            scale: 3.0,
            to_world,
            luminaire: Some(Arc::new(stated)),
            ..LightDescription::new(kind, 1.0)
        };
        let builder = SceneBuilder::new().light(LightDescription::point(DVec3::ZERO, 1.0)).light(light);
        let description = builder.describe().unwrap();
        let [luminaire] = PlacedLuminaire::of_scene(&description).try_into().unwrap();
        assert_eq!((luminaire.name.as_str(), luminaire.opening.size), ("luminaire 1", [0.4, 0.2, 0.0]));
        assert_eq!(luminaire.description.as_ref().unwrap().opening.size, [0.4, 0.2, 0.0]);
        assert!((luminaire.position - DVec3::new(1.0, 0.0, 2.0)).length() < 1e-12);
        assert!((luminaire.axes * DVec3::X - DVec3::Y).length() < 1e-12);
        assert_eq!(luminaire.intensity_towards(DVec3::ZERO), 30.0);
        assert!((luminaire.area_towards(luminaire.position - DVec3::Z) - 0.08).abs() < 1e-12);
        assert!((luminaire.largest_area() - 0.08).abs() < 1e-12);
        assert!((luminaire.flux() - 30.0 * 4.0 * PI).abs() < 1e-9);
    }
}
