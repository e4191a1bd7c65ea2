//! Mappings from points of surfaces to coordinates of textures.

use std::f64::consts::{PI, TAU};

use glanz_math::{DVec2, DVec3, Transform};

use super::TexturePoint;

/// Coordinates in a texture, and the extent to average over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureCoordinates {
    /// The coordinates; the third is 0 for flat textures.
    pub position: DVec3,
    /// Extent in the same units, one number for all directions; 0 without a footprint.
    pub width: f64,
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
        let flat = |x: f64, y: f64, width: f64| TextureCoordinates {
            position: DVec3::new(x, y, 0.0),
            width,
            solid: false,
        };
        match self {
            Self::Uv { scale, offset } => {
                let st = *scale * at.uv + *offset;
                flat(st.x, st.y, at.uv_width * scale.abs().max_element())
            }
            Self::Planar { v1, v2, offset, to_texture } => {
                let p = to_texture.point(at.position);
                let width = local_width(to_texture, at) * v1.length().max(v2.length());
                flat(p.dot(*v1) + offset.x, p.dot(*v2) + offset.y, width)
            }
            Self::Spherical { to_texture } => {
                let p = to_texture.point(at.position);
                let around = p.x.hypot(p.y);
                let phi = p.y.atan2(p.x);
                let phi = if phi < 0.0 { phi + TAU } else { phi };
                // The angle from the axis grows by 1 / |p| per metre.
                flat(
                    around.atan2(p.z) / PI,
                    phi / TAU,
                    finite(local_width(to_texture, at) / (PI * p.length())),
                )
            }
            Self::Cylindrical { to_texture } => {
                let p = to_texture.point(at.position);
                let width = local_width(to_texture, at);
                let turn = finite(width / (TAU * p.x.hypot(p.y)));
                flat((PI + p.y.atan2(p.x)) / TAU, p.z, width.max(turn))
            }
            Self::Solid { to_texture } => TextureCoordinates {
                position: to_texture.point(at.position),
                width: local_width(to_texture, at),
                solid: true,
            },
        }
    }
}

/// The extent of the footprint in the texture's space; the largest over the axes.
fn local_width(to_texture: &Transform, at: &TexturePoint) -> f64 {
    if at.position_width == 0.0 {
        return 0.0;
    }
    let m = to_texture.forward().matrix3;
    at.position_width * m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length())
}

/// On the axis of a mapping the extent has no bound: the whole turn is averaged.
fn finite(width: f64) -> f64 {
    if width.is_nan() { 0.0 } else { width.min(1.0) }
}

#[cfg(test)]
mod tests {
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
        let point = at(9.0, 9.0, 9.0).with_footprint(0.1, 0.0);
        assert_eq!(flat(&mapping, &point), DVec2::new(1.5, 0.0));
        assert!((mapping.coordinates(&point).width - 0.4).abs() < 1e-15);
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

    #[test]
    fn footprints_on_the_axis_of_a_mapping_stay_finite() {
        for mapping in [
            TextureMapping::Spherical { to_texture: Transform::IDENTITY },
            TextureMapping::Cylindrical { to_texture: Transform::IDENTITY },
        ] {
            let width = mapping.coordinates(&at(0.0, 0.0, 0.0).with_footprint(0.1, 0.1)).width;
            assert!((0.0..=1.0).contains(&width));
        }
    }
}
