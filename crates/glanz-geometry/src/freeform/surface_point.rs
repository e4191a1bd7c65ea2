//! The surface at its points: position, derivatives and normal.

use glanz_math::{DVec2, DVec3};

use super::Freeform;
use super::control_net::SecondOrderJet;
use crate::hit::SurfacePoint;

/// Length of the normal S_x x S_y, relative to the square of the size of the patch, below which half of its digits are lost.
pub(super) const COLLAPSED: f64 = 1e-8;

/// Largest distance of a hit from the surface, in units of the noise: up to eight times for the search, and as much for the
/// rounding of the leaves.
const ERROR: f64 = 16.0;

impl Freeform {
    pub(crate) fn point_at(&self, face: u32, x: f64, y: f64) -> SurfacePoint {
        let face = self.own_face(face);
        let (Some(placement), Some(here)) = (self.patches.placement(face), self.first_order(face, x, y))
        else {
            return nowhere();
        };
        let n = here.su.cross(here.sv);
        let (length, size) = (n.length(), placement.extent());
        let is_regular = length > COLLAPSED * size * size;
        let beside = if is_regular { None } else { self.next_to(face, x, y) };
        let normal = beside.map_or_else(|| n * (1.0 / length), |(_, normal, _)| normal);
        let [by_u, by_v] = placement.rates(x, y);
        // Along a collapsed edge the derivative is only rounding, without a direction.
        let steep = 1e2 * self.error();
        let [sx, sy] = [here.su, here.sv].map(|s| {
            if s.length_squared() > steep * steep { s - normal * normal.dot(s) } else { DVec3::ZERO }
        });
        let along = |rate: DVec2| sx * rate.x + sy * rate.y;
        let flip = if by_u.perp_dot(by_v) < 0.0 { -1.0 } else { 1.0 };
        let normal = normal * flip;
        let bounds = self.bvh.bounds();
        SurfacePoint {
            position: clamped(here.s, bounds.min, bounds.max),
            error: DVec3::splat(self.error()),
            normal,
            shading_normal: normal,
            uv: placement.parameters(x, y),
            dpdu: along(by_u),
            dpdv: along(by_v),
        }
    }

    /// Derivatives of the normal at a point of a patch.
    pub(crate) fn normal_derivatives_at(&self, face: u32, x: f64, y: f64, normal: DVec3) -> [DVec3; 2] {
        let face = self.own_face(face);
        let (Some(placement), Some(here)) = (self.patches.placement(face), self.second_order(face, x, y))
        else {
            return [DVec3::ZERO; 2];
        };
        let (length, size) = (here.su.cross(here.sv).length(), placement.extent());
        let beside = if length > COLLAPSED * size * size { None } else { self.next_to(face, x, y) };
        let (regular, length) = beside.map_or((here, length), |(beside, _, length)| (beside, length));
        let SecondOrderJet { su, sv, suu, suv, svv, .. } = regular;
        let [by_u, by_v] = placement.rates(x, y);
        let per = if by_u.perp_dot(by_v) < 0.0 { -1.0 } else { 1.0 } / length;
        // n = N / |N| with N = S_x x S_y; the component along n drops out.
        [by_u, by_v].map(|rate| {
            let turn = (suu.cross(sv) + su.cross(suv)) * rate.x + (suv.cross(sv) + su.cross(svv)) * rate.y;
            let turn = turn * per;
            turn - normal * normal.dot(turn)
        })
    }

    /// The absolute error per axis, metres.
    ///
    /// The origin of a ray that starts here is this point or close to it, so that its noise is that of an origin within the
    /// surface.
    pub(super) fn error(&self) -> f64 {
        (ERROR + self.patches.evaluation_rounding()) * self.frame.noise_within()
    }

    /// The face, or the first one instead of one that is not there: the hit of another surface may have any.
    fn own_face(&self, face: u32) -> u32 {
        if (face as usize) < self.patch_count() { face } else { 0 }
    }

    /// At a collapsed edge or corner: the jet of a close point with a normal, the unit normal at (x, y), and the length of
    /// S_x x S_y at that point.
    #[cold]
    fn next_to(&self, face: u32, x: f64, y: f64) -> Option<(SecondOrderJet, DVec3, f64)> {
        let size = self.patches.placement(face)?.extent();
        // Where the normal vanishes, its derivative towards the centre of the patch has the direction of the normals nearby.
        let here = self.second_order(face, x, y)?;
        let SecondOrderJet { su, sv, suu, suv, svv, .. } = here;
        let (by_x, by_y) = (suu.cross(sv) + su.cross(suv), suv.cross(sv) + su.cross(svv));
        let rise = by_x * (0.5 - x) + by_y * (0.5 - y);
        let mut at = here;
        for step in [1e-3, 1e-2, 0.1, 0.5] {
            at = self.second_order(face, x + (0.5 - x) * step, y + (0.5 - y) * step)?;
            let n = at.su.cross(at.sv);
            if n.length() > COLLAPSED * size * size {
                let normal = if rise.length() > 1e-6 * size * size { rise } else { n };
                return Some((at, normal.normalize(), n.length()));
            }
        }
        Some((at, su.cross(sv).try_normalize().unwrap_or(DVec3::Z), size * size))
    }
}

/// `p` in the box; of zeros with different signs that of the box, in lanes as well.
fn clamped(p: DVec3, min: DVec3, max: DVec3) -> DVec3 {
    let at_least = DVec3::select(p.cmpgt(min), p, min);
    DVec3::select(at_least.cmplt(max), at_least, max)
}

/// The point of a surface without patches, which cannot be built.
pub(super) fn nowhere() -> SurfacePoint {
    let zero = DVec3::ZERO;
    SurfacePoint {
        position: zero,
        error: zero,
        normal: DVec3::Z,
        shading_normal: DVec3::Z,
        uv: DVec2::ZERO,
        dpdu: zero,
        dpdv: zero,
    }
}
