//! Mappings from points of surfaces to coordinates of textures.

use std::f64::consts::{PI, TAU};

use glanz_math::{DVec2, DVec3, Transform};

use super::{TextureFootprint, TexturePoint};

/// Coordinates in a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureCoordinates {
    /// The coordinates; the third is 0 for flat textures.
    pub position: DVec3,
    /// Whether the third coordinate counts.
    pub solid: bool,
}

/// Mapping of a texture to surfaces; `T`: representation of transformations.
///
/// # Source
/// pbrt, file format: parameter `mapping` of textures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TextureMapping<T = Transform> {
    /// `(scale.x u + offset.x, scale.y v + offset.y)`.
    Uv {
        /// Factors on (u, v).
        scale: DVec2,
        /// Added after the factors.
        offset: DVec2,
    },
    /// `(p . v1 + offset.x, p . v2 + offset.y)`, p in the texture's space.
    Planar {
        /// First axis.
        v1: DVec3,
        /// Second axis.
        v2: DVec3,
        /// Added to both.
        offset: DVec2,
        /// Transformation from the world to the texture's space.
        to_texture: T,
    },
    /// `(theta / pi, phi / 2 pi)`: angle from +z and azimuth in [0, 2 pi), p in the texture's space.
    Spherical {
        /// Transformation from the world to the texture's space.
        to_texture: T,
    },
    /// `((phi + pi) / 2 pi, z)` with the azimuth in [-pi, pi], p in the texture's space.
    Cylindrical {
        /// Transformation from the world to the texture's space.
        to_texture: T,
    },
    /// The point itself in the texture's space: solid textures. A flat texture takes x and y.
    Solid {
        /// Transformation from the world to the texture's space.
        to_texture: T,
    },
}

impl<T> TextureMapping<T> {
    /// The same mapping with other transformations.
    ///
    /// # Errors
    /// Those of `convert`.
    pub fn try_map<U, E>(&self, convert: impl FnOnce(&T) -> Result<U, E>) -> Result<TextureMapping<U>, E> {
        Ok(match self {
            &Self::Uv { scale, offset } => TextureMapping::Uv { scale, offset },
            &Self::Planar { v1, v2, offset, ref to_texture } => {
                TextureMapping::Planar { v1, v2, offset, to_texture: convert(to_texture)? }
            }
            Self::Spherical { to_texture } => TextureMapping::Spherical { to_texture: convert(to_texture)? },
            Self::Cylindrical { to_texture } => {
                TextureMapping::Cylindrical { to_texture: convert(to_texture)? }
            }
            Self::Solid { to_texture } => TextureMapping::Solid { to_texture: convert(to_texture)? },
        })
    }
}

impl Default for TextureMapping {
    fn default() -> Self {
        Self::Uv { scale: DVec2::ONE, offset: DVec2::ZERO }
    }
}

impl TextureMapping {
    /// Coordinates of a point.
    #[must_use]
    pub fn coordinates(&self, at: &TexturePoint) -> TextureCoordinates {
        let flat = |x: f64, y: f64| TextureCoordinates { position: DVec3::new(x, y, 0.0), solid: false };
        match self {
            Self::Uv { scale, offset } => {
                let st = *scale * at.uv + *offset;
                flat(st.x, st.y)
            }
            Self::Planar { v1, v2, offset, to_texture } => {
                let p = to_texture.point(at.position);
                flat(p.dot(*v1) + offset.x, p.dot(*v2) + offset.y)
            }
            Self::Spherical { to_texture } => {
                let p = to_texture.point(at.position);
                let around = p.x.hypot(p.y);
                let phi = p.y.atan2(p.x);
                let phi = if phi < 0.0 { phi + TAU } else { phi };
                flat(around.atan2(p.z) / PI, phi / TAU)
            }
            Self::Cylindrical { to_texture } => {
                let p = to_texture.point(at.position);
                flat((PI + p.y.atan2(p.x)) / TAU, p.z)
            }
            Self::Solid { to_texture } => {
                TextureCoordinates { position: to_texture.point(at.position), solid: true }
            }
        }
    }

    /// The sides of the footprint of a point in the first two coordinates: differences between both ends of a side, which are bounded on the axes of
    /// spheres and cylinders, too.
    #[must_use]
    pub fn footprint(&self, at: &TexturePoint, footprint: &TextureFootprint) -> [DVec2; 2] {
        if let Self::Uv { scale, .. } = self {
            return footprint.uv.map(|side| *scale * side);
        }
        let here = self.coordinates(at).position.truncate();
        footprint.position.map(|side| {
            let end = TexturePoint { position: at.position + side, ..*at };
            let mut difference = self.coordinates(&end).position.truncate() - here;
            // The shorter way around.
            match self {
                Self::Spherical { .. } => difference.y -= difference.y.round(),
                Self::Cylindrical { .. } => difference.x -= difference.x.round(),
                Self::Uv { .. } | Self::Planar { .. } | Self::Solid { .. } => {}
            }
            difference
        })
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::DMat4;

    use super::*;

    fn at(x: f64, y: f64, z: f64) -> TexturePoint {
        TexturePoint::new(DVec2::new(0.25, 0.5), DVec3::new(x, y, z))
    }

    fn flat(mapping: &TextureMapping, point: &TexturePoint) -> DVec2 {
        mapping.coordinates(point).position.truncate()
    }

    #[test]
    fn uv_scales_and_shifts() {
        let mapping = TextureMapping::Uv { scale: DVec2::new(4.0, -2.0), offset: DVec2::new(0.5, 1.0) };
        let point = at(9.0, 9.0, 9.0);
        assert_eq!(flat(&mapping, &point), DVec2::new(1.5, 0.0));
        let uv = [DVec2::new(0.25, 0.5), DVec2::new(0.0, -1.0)];
        let footprint = TextureFootprint { uv, position: [DVec3::ZERO; 2] };
        assert_eq!(mapping.footprint(&point, &footprint), [DVec2::new(1.0, -1.0), DVec2::new(0.0, 2.0)]);
    }

    #[test]
    fn planar_projects_in_the_space_of_the_texture() {
        let mapping = TextureMapping::Planar {
            v1: DVec3::new(2.0, 0.0, 0.0),
            v2: DVec3::new(0.0, 0.0, 0.5),
            offset: DVec2::new(0.0, 1.0),
            to_texture: Transform::translate(DVec3::new(1.0, 0.0, 0.0)),
        };
        assert_eq!(flat(&mapping, &at(2.0, 7.0, 4.0)), DVec2::new(6.0, 3.0));
    }

    #[test]
    fn spherical_coordinates_of_the_axes() {
        let mapping = TextureMapping::Spherical { to_texture: Transform::IDENTITY };
        assert_eq!(flat(&mapping, &at(0.0, 0.0, 2.0)), DVec2::ZERO);
        assert_eq!(flat(&mapping, &at(2.0, 0.0, 0.0)), DVec2::new(0.5, 0.0));
        assert_eq!(flat(&mapping, &at(0.0, 2.0, 0.0)), DVec2::new(0.5, 0.25));
        assert_eq!(flat(&mapping, &at(0.0, -2.0, 0.0)), DVec2::new(0.5, 0.75));
        assert_eq!(flat(&mapping, &at(0.0, 0.0, -2.0)), DVec2::new(1.0, 0.0));
        assert!(flat(&mapping, &at(0.0, 0.0, 0.0)).is_finite());
    }

    #[test]
    fn cylindrical_coordinates_of_the_axes() {
        let mapping = TextureMapping::Cylindrical { to_texture: Transform::IDENTITY };
        assert_eq!(flat(&mapping, &at(2.0, 0.0, 3.0)), DVec2::new(0.5, 3.0));
        assert_eq!(flat(&mapping, &at(0.0, 2.0, -1.0)), DVec2::new(0.75, -1.0));
        assert_eq!(flat(&mapping, &at(-2.0, 0.0, 0.0)), DVec2::new(1.0, 0.0));
    }

    fn in_space(position: [DVec3; 2]) -> TextureFootprint {
        TextureFootprint { uv: [DVec2::ZERO; 2], position }
    }

    #[test]
    fn footprints_are_measured_in_the_space_of_the_texture() {
        let to_texture = Transform::try_from_matrix(DMat4::from_scale(DVec3::splat(3.0))).unwrap();
        let mapping = TextureMapping::Planar { v1: DVec3::Y, v2: DVec3::Z, offset: DVec2::ONE, to_texture };
        let axes = mapping.footprint(&at(1.0, 2.0, 3.0), &in_space([DVec3::X, DVec3::new(0.0, 0.5, -1.0)]));
        assert_eq!(axes, [DVec2::ZERO, DVec2::new(1.5, -3.0)]);
    }

    #[test]
    fn footprints_over_the_seam_of_a_mapping_are_as_small_as_elsewhere() {
        let (to_texture, across) = (Transform::IDENTITY, in_space([DVec3::new(0.0, 0.02, 0.0), DVec3::ZERO]));
        let turn = 2.0 * 0.01_f64.atan() / TAU;
        let spherical = TextureMapping::Spherical { to_texture };
        let axes = spherical.footprint(&at(1.0, -0.01, 0.0), &across);
        assert!((axes[0] - DVec2::new(0.0, turn)).length() < 1e-15, "{axes:?}");
        let cylindrical = TextureMapping::Cylindrical { to_texture };
        let axes = cylindrical.footprint(&at(-1.0, -0.01, 0.0), &across);
        assert!((axes[0] - DVec2::new(-turn, 0.0)).length() < 1e-15, "{axes:?}");
    }

    #[test]
    fn footprints_on_the_axis_of_a_mapping_stay_finite() {
        let to_texture = Transform::IDENTITY;
        for mapping in [TextureMapping::Spherical { to_texture }, TextureMapping::Cylindrical { to_texture }]
        {
            let axes = mapping.footprint(&at(0.0, 0.0, 0.0), &in_space([DVec3::splat(0.1), DVec3::X]));
            assert!(axes.iter().all(|axis| axis.abs().max_element() <= 1.0), "{axes:?}");
        }
    }
}
