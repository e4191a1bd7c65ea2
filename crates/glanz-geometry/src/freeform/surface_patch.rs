//! A Bézier patch with its part of the parameter domain of a surface.

use glanz_math::DVec2;

use super::parameter_rect::ParameterRect;
use crate::bezier::TensorPatch;
use crate::error::{SurfaceError, finite};

/// A Bézier patch over a part of the parameters (u, v) of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfacePatch {
    pub(super) patch: TensorPatch,
    pub(super) placement: PatchPlacement,
}

/// Part of the parameter domain, diagonal of a box around the control points (metres) and degrees of a patch. The small fields share
/// eight bytes with the tag.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum PatchPlacement {
    Rectangle {
        rect: ParameterRect,
        extent: f32,
        degrees: [u8; 2],
    },
    /// Corners at (0, 0), (1, 0), (0, 1), (1, 1) of the patch. Boxed, since rectangles are many more.
    Quad {
        corners: Box<[DVec2; 4]>,
        extent: f32,
        degrees: [u8; 2],
    },
}

const _: () = assert!(size_of::<PatchPlacement>() == 40);

impl SurfacePatch {
    /// A patch over the rectangle `u` x `v`.
    ///
    /// # Errors
    /// [`SurfaceError::EmptyRange`] if an interval does not ascend, [`SurfaceError::NotFinite`].
    pub fn over_rectangle(patch: TensorPatch, u: [f64; 2], v: [f64; 2]) -> Result<Self, SurfaceError> {
        for (parameter, [min, max]) in [("u", u), ("v", v)] {
            finite(parameter, min)?;
            finite(parameter, max)?;
            if min >= max {
                return Err(SurfaceError::EmptyRange { parameter, min, max });
            }
        }
        let (extent, degrees) = extent_and_degrees(&patch);
        let rect = ParameterRect { u, v };
        Ok(Self { patch, placement: PatchPlacement::Rectangle { rect, extent, degrees } })
    }

    /// A patch over the convex quadrilateral with `corners` at (0, 0), (1, 0), (0, 1), (1, 1), bilinear between them.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::Degenerate`] if the corners are not those of a convex quadrilateral.
    pub fn over_quad(patch: TensorPatch, corners: [DVec2; 4]) -> Result<Self, SurfaceError> {
        for value in corners.iter().flat_map(|c| c.to_array()) {
            finite("corner", value)?;
        }
        let [a, b, c, d] = corners;
        let turns =
            [(b - a, c - a), (b - a, d - b), (d - c, c - a), (d - c, d - b)].map(|(x, y)| x.perp_dot(y));
        let least = turns.into_iter().fold(f64::INFINITY, f64::min);
        let most = turns.into_iter().fold(f64::NEG_INFINITY, f64::max);
        if least > 0.0 || most < 0.0 {
            let (extent, degrees) = extent_and_degrees(&patch);
            let corners = Box::new(corners);
            Ok(Self { patch, placement: PatchPlacement::Quad { corners, extent, degrees } })
        } else {
            Err(SurfaceError::Degenerate {
                reason: "the quadrilateral of parameters is not convex, turn",
                value: least,
            })
        }
    }

    /// The patch.
    #[must_use]
    pub fn patch(&self) -> &TensorPatch {
        &self.patch
    }

    /// Parameters (u, v) of the surface at (x, y) in the unit square of the patch.
    #[must_use]
    pub fn parameters(&self, x: f64, y: f64) -> DVec2 {
        self.placement.parameters(x, y)
    }
}

/// Diagonal of a box around the control points, metres, and degrees.
fn extent_and_degrees(patch: &TensorPatch) -> (f32, [u8; 2]) {
    let (p, q) = patch.degrees();
    // Finite, since an infinite one would make every normal count as collapsed.
    let extent = patch.bounds().diagonal().length().min(f32::MAX.into()) as f32;
    // Degrees of a `TensorPatch` are at most 128.
    (extent, [p as u8, q as u8])
}

impl PatchPlacement {
    /// Memory outside of this value, bytes.
    pub(super) fn boxed_bytes(&self) -> usize {
        match self {
            Self::Rectangle { .. } => 0,
            Self::Quad { corners, .. } => size_of_val(&**corners),
        }
    }

    /// Diagonal of a box around the control points, metres, rounded.
    pub(super) fn extent(&self) -> f64 {
        let (Self::Rectangle { extent, .. } | Self::Quad { extent, .. }) = self;
        (*extent).into()
    }

    pub(super) fn degrees(&self) -> (usize, usize) {
        let (Self::Rectangle { degrees: [p, q], .. } | Self::Quad { degrees: [p, q], .. }) = *self;
        (p.into(), q.into())
    }

    /// See [`SurfacePatch::parameters`].
    pub(super) fn parameters(&self, x: f64, y: f64) -> DVec2 {
        match self {
            Self::Rectangle { rect, .. } => rect.at(x, y).into(),
            Self::Quad { corners, .. } => {
                let [a, b, c, d] = **corners;
                a.lerp(b, x).lerp(c.lerp(d, x), y)
            }
        }
    }

    /// The rectangle of parameters, unless they are those of a quadrilateral.
    pub(super) fn rectangle(&self) -> Option<&ParameterRect> {
        match self {
            Self::Rectangle { rect, .. } => Some(rect),
            Self::Quad { .. } => None,
        }
    }

    /// Smallest and largest parameters (u, v) of the surface over a part of the patch.
    pub(super) fn range(&self, rect: &ParameterRect) -> [DVec2; 2] {
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| self.parameters(rect.u[i], rect.v[j]));
        let (low, high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        [corners.into_iter().fold(low, DVec2::min), corners.into_iter().fold(high, DVec2::max)]
    }

    /// Derivatives of the parameters (x, y) of the patch by u and by v.
    pub(super) fn rates(&self, x: f64, y: f64) -> [DVec2; 2] {
        match self {
            Self::Rectangle { rect: ParameterRect { u, v }, .. } => {
                [DVec2::new(1.0 / (u[1] - u[0]), 0.0), DVec2::new(0.0, 1.0 / (v[1] - v[0]))]
            }
            Self::Quad { corners, .. } => {
                let [a, b, c, d] = **corners;
                let (by_x, by_y) = ((b - a).lerp(d - c, y), (c - a).lerp(d - b, x));
                let per = 1.0 / by_x.perp_dot(by_y);
                [DVec2::new(by_y.y, -by_x.y) * per, DVec2::new(-by_y.x, by_x.x) * per]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_math::glam::DVec4;

    #[test]
    fn rates_are_the_inverse_of_the_parameters_derivatives() {
        let flat: Vec<DVec4> = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)]
            .map(|(x, y)| DVec4::new(x, y, 0.0, 1.0))
            .to_vec();
        let patch = TensorPatch::try_new(1, 1, flat).unwrap();
        let corners = [(0.0, 0.0), (0.5, 0.1), (-0.1, 0.5), (0.4, 0.6)].map(DVec2::from);
        let patches = [
            SurfacePatch::over_quad(patch.clone(), corners).unwrap(),
            SurfacePatch::over_rectangle(patch.clone(), [2.0, 5.0], [-1.0, 1.0]).unwrap(),
        ];
        for patch in patches {
            let h = 1e-6;
            let (x, y) = (0.3, 0.8);
            let by_x = (patch.parameters(x + h, y) - patch.parameters(x - h, y)) / (2.0 * h);
            let by_y = (patch.parameters(x, y + h) - patch.parameters(x, y - h)) / (2.0 * h);
            let [by_u, by_v] = patch.placement.rates(x, y);
            assert!((by_x * by_u.x + by_y * by_u.y - DVec2::X).length() < 1e-9);
            assert!((by_x * by_v.x + by_y * by_v.y - DVec2::Y).length() < 1e-9);
        }
        assert!(SurfacePatch::over_quad(patch.clone(), [DVec2::ZERO; 4]).is_err());
        assert!(SurfacePatch::over_rectangle(patch, [1.0, 1.0], [0.0, 1.0]).is_err());
    }
}
