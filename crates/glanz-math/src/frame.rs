//! Orthonormal frames.

use crate::DVec3;

/// A right-handed orthonormal frame; in shading, `z` is the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub x: DVec3,
    /// Second tangent.
    pub y: DVec3,
    /// Normal.
    pub z: DVec3,
}

impl Frame {
    /// A frame around the unit vector `z`; the tangents vary smoothly except at `z = (0, 0, -1)`.
    ///
    /// # Source
    /// @duff2017.
    #[inline]
    #[must_use]
    pub fn from_z(z: DVec3) -> Self {
        let sign = 1.0_f64.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Self {
            x: DVec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: DVec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// A frame around the unit vector `z` whose `x` follows `tangent`; falls back to [`Frame::from_z`] where
    /// `tangent` is parallel to `z`, zero or not finite.
    #[inline]
    #[must_use]
    pub fn from_z_and_tangent(z: DVec3, tangent: DVec3) -> Self {
        let x = tangent - z * z.dot(tangent);
        match x.try_normalize() {
            // Where the tangent is almost parallel to z, cancellation leaves only noise.
            Some(x) if x.dot(z).abs() < 1e-3 => Self { x, y: z.cross(x), z },
            _ => Self::from_z(z),
        }
    }

    /// Converts `v` from world coordinates to those of this frame.
    #[inline]
    #[must_use]
    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// Converts `v` from coordinates of this frame to those of the world.
    #[inline]
    #[must_use]
    pub fn to_world(&self, v: DVec3) -> DVec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for z in [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(0.3, -0.7, -0.2).normalize()] {
            for frame in [Frame::from_z(z), Frame::from_z_and_tangent(z, DVec3::new(0.1, 0.9, 0.4))] {
                assert!((frame.x.cross(frame.y) - frame.z).length() < 1e-15);
                assert!((frame.x.length() - 1.0).abs() < 1e-15);
                let v = DVec3::new(1.0, 2.0, 3.0);
                assert!((frame.to_world(frame.to_local(v)) - v).length() < 1e-14);
            }
        }
    }

    #[test]
    fn tangent_parallel_to_the_normal_still_gives_a_frame() {
        let frame = Frame::from_z_and_tangent(DVec3::Y, DVec3::Y * 3.0);
        assert!((frame.x.cross(frame.y) - frame.z).length() < 1e-15);
    }
}
