//! The surface at its points: position, derivatives and normal.

use glanz_math::{DVec2, DVec3};

use super::control_net::{PatchJet, SecondOrderJet, second_order_jet};
use super::{Freeform, SurfacePatch};
use crate::hit::SurfacePoint;

/// Length of the normal S_x x S_y, relative to the square of the size of the patch, below which half of its digits are lost.
pub(super) const COLLAPSED: f64 = 1e-8;

/// Largest distance of a hit from the surface, in units of the noise: up to eight times for the search, and as much for the
/// rounding of the leaves.
const ERROR: f64 = 16.0;

impl Freeform {
    pub(crate) fn point_at(&self, face: u32, x: f64, y: f64) -> SurfacePoint {
        // The hit of another surface may have any face; the first patch replaces a missing one.
        let Some(patch) = self.patches.get(face as usize).or(self.patches.first()) else { return nowhere() };
        let (points, degrees) = (patch.patch.control_points(), patch.patch.degrees());
        let here = PatchJet::new(self.bvh.isa(), points, degrees, x, y);
        let n = here.su.cross(here.sv);
        let (length, size) = (n.length(), patch.extent());
        let is_regular = length > COLLAPSED * size * size;
        let normal = if is_regular { n * (1.0 / length) } else { next_to(patch, x, y).1 };
        let [by_u, by_v] = patch.rates(x, y);
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
            uv: patch.parameters(x, y),
            dpdu: along(by_u),
            dpdv: along(by_v),
        }
    }

    /// Derivatives of the normal at a point of a patch.
    pub(crate) fn normal_derivatives_at(&self, face: u32, x: f64, y: f64, normal: DVec3) -> [DVec3; 2] {
        let Some(patch) = self.patches.get(face as usize).or(self.patches.first()) else {
            return [DVec3::ZERO; 2];
        };
        let (points, degrees) = (patch.patch.control_points(), patch.patch.degrees());
        let here = second_order_jet(points, degrees, x, y);
        let (length, size) = (here.su.cross(here.sv).length(), patch.extent());
        let (regular, length) = if length > COLLAPSED * size * size {
            (here, length)
        } else {
            let (beside, _, length) = next_to(patch, x, y);
            (beside, length)
        };
        let SecondOrderJet { su, sv, suu, suv, svv, .. } = regular;
        let [by_u, by_v] = patch.rates(x, y);
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
        ERROR * self.frame.noise_within()
    }
}

/// `p` in the box; of zeros with different signs that of the box, in lanes as well.
fn clamped(p: DVec3, min: DVec3, max: DVec3) -> DVec3 {
    let at_least = DVec3::select(p.cmpgt(min), p, min);
    DVec3::select(at_least.cmplt(max), at_least, max)
}

/// At a collapsed edge or corner: the jet of a close point with a normal, the unit normal at (x, y), and the length of
/// S_x x S_y at that point.
#[cold]
fn next_to(patch: &SurfacePatch, x: f64, y: f64) -> (SecondOrderJet, DVec3, f64) {
    let (points, degrees) = (patch.patch.control_points(), patch.patch.degrees());
    let size = patch.extent();
    // Where the normal vanishes, its derivative towards the centre of the patch has the direction of the normals nearby.
    let here = second_order_jet(points, degrees, x, y);
    let SecondOrderJet { su, sv, suu, suv, svv, .. } = here;
    let (by_x, by_y) = (suu.cross(sv) + su.cross(suv), suv.cross(sv) + su.cross(svv));
    let rise = by_x * (0.5 - x) + by_y * (0.5 - y);
    let mut at = here;
    for step in [1e-3, 1e-2, 0.1, 0.5] {
        at = second_order_jet(points, degrees, x + (0.5 - x) * step, y + (0.5 - y) * step);
        let n = at.su.cross(at.sv);
        if n.length() > COLLAPSED * size * size {
            let normal = if rise.length() > 1e-6 * size * size { rise } else { n };
            return (at, normal.normalize(), n.length());
        }
    }
    (at, su.cross(sv).try_normalize().unwrap_or(DVec3::Z), size * size)
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
