//! Mirrors of revolution about the z axis, exact as rational Bézier patches, and as triangles.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use glanz_math::DVec3;
use glanz_scene::description::{BezierPatchesDescription, GeometryDescription};

/// A quarter of the unit circle as a rational quadratic curve: (w x, w y, w).
const QUARTER: [[f64; 3]; 3] =
    [[1.0, 0.0, 1.0], [FRAC_1_SQRT_2, FRAC_1_SQRT_2, FRAC_1_SQRT_2], [0.0, 1.0, 1.0]];

/// A curve in the half-plane of distance from the axis and z, with increasing z: rational quadratic arcs of control points
/// (w distance, w z, w), metres.
pub(super) struct MirrorProfile(Vec<[DVec3; 3]>);

impl MirrorProfile {
    /// z = distance^2 / (4 focus) up to `radius`.
    pub(super) fn parabola(focus: f64, radius: f64) -> Self {
        let height = radius * radius / (4.0 * focus);
        Self(vec![[
            DVec3::new(0.0, 0.0, 1.0),
            DVec3::new(0.5 * radius, 0.0, 1.0),
            DVec3::new(radius, height, 1.0),
        ]])
    }

    /// Half of an ellipse about the origin from the lower pole to the upper, with half axes across and along z.
    pub(super) fn ellipse(across: f64, along: f64) -> Self {
        let w = FRAC_1_SQRT_2;
        let side = DVec3::new(across, 0.0, 1.0);
        Self(vec![
            [DVec3::new(0.0, -along, 1.0), DVec3::new(w * across, -w * along, w), side],
            [side, DVec3::new(w * across, w * along, w), DVec3::new(0.0, along, 1.0)],
        ])
    }

    /// The first arc of the profile.
    pub(super) fn first_arc(mut self) -> Self {
        self.0.truncate(1);
        self
    }

    /// The mirror, exactly: four patches for each arc.
    pub(super) fn patches(&self) -> GeometryDescription {
        let mut patches = Vec::new();
        for arc in &self.0 {
            for turns in 0..4 {
                let patch = QUARTER.iter().flat_map(|circle| {
                    let [x, y] = turned([circle[0], circle[1]], turns);
                    let w = circle[2];
                    arc.map(move |a| [x * a.x, y * a.x, w * a.y, w * a.z])
                });
                patches.push(patch.collect());
            }
        }
        GeometryDescription::BezierPatches(BezierPatchesDescription { degree_u: 2, degree_v: 2, patches })
    }

    /// Distance from the axis and z, and the unit normal that points to the axis, at a place in [0, arcs].
    fn at(&self, place: f64) -> ([f64; 2], [f64; 2]) {
        let number = (place as usize).min(self.0.len().saturating_sub(1));
        let Some(&[a, b, c]) = self.0.get(number) else { return ([0.0; 2], [0.0; 2]) };
        let t = place - number as f64;
        let (ab, bc) = (a.lerp(b, t), b.lerp(c, t));
        let (p, slope) = (ab.lerp(bc, t), bc - ab);
        // Along the curve, but for a positive factor.
        let [dx, dz] = [slope.x * p.z - p.x * slope.z, slope.y * p.z - p.y * slope.z];
        let length = dx.hypot(dz);
        ([p.x / p.z, p.y / p.z], [-dz / length, dx / length])
    }

    /// About `count` triangles with corners on the surface, at equal parameters: twice as many sectors as rings. `smooth`: with
    /// the surface's normals at the corners.
    pub(super) fn triangles(&self, count: u64, smooth: bool) -> GeometryDescription {
        let rings = ((0.5 * (count as f64).sqrt()).round() as u32).max(2);
        let sectors = 2 * rings;
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        for (i, j) in (0..=rings).flat_map(|i| (0..sectors).map(move |j| (i, j))) {
            let place = self.0.len() as f64 * f64::from(i) / f64::from(rings);
            let ([r, z], [nr, nz]) = self.at(place);
            let (sin, cos) = (TAU * f64::from(j) / f64::from(sectors)).sin_cos();
            positions.push(DVec3::new(r * cos, r * sin, z));
            normals.push(DVec3::new(nr * cos, nr * sin, nz));
        }
        let mut indices = Vec::new();
        for (i, j) in (0..rings).flat_map(|i| (0..sectors).map(move |j| (i, j))) {
            let [here, next] = [j, (j + 1) % sectors].map(|j| i * sectors + j);
            let [above, beyond] = [here + sectors, next + sectors];
            // At a pole one of the two has no area.
            let on_axis =
                |k: u32| positions.get(k as usize).is_none_or(|p: &DVec3| p.truncate().length() == 0.0);
            if !on_axis(above) {
                indices.push([here, above, beyond]);
            }
            if !on_axis(here) {
                indices.push([here, beyond, next]);
            }
        }
        GeometryDescription::Triangles { positions, indices, normals: smooth.then_some(normals), uvs: None }
    }
}

/// The vector turned by `turns` right angles.
fn turned([x, y]: [f64; 2], turns: u32) -> [f64; 2] {
    (0..turns).fold([x, y], |[x, y], _| [-y, x])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_lie_on_the_ellipsoid_and_normals_are_those_of_its_gradient() {
        let (across, along) = (0.8, 1.0);
        let GeometryDescription::Triangles { positions, indices, normals, .. } =
            MirrorProfile::ellipse(across, along).triangles(400, true)
        else {
            panic!("no triangles")
        };
        // 10 rings of 20 sectors: 2 triangles each, but 1 at the poles.
        assert_eq!(indices.len(), 2 * 20 * 10 - 2 * 20);
        let squares = DVec3::new(across, across, along).powf(2.0);
        for (p, n) in positions.iter().zip(normals.unwrap()) {
            assert!(((p * p / squares).element_sum() - 1.0).abs() < 1e-12, "{p}");
            let inwards = -(p / squares).normalize();
            assert!(n.distance(inwards) < 1e-12, "{p} {n}");
        }
        for t in &indices {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            // All turned alike: inwards.
            assert!((b - a).cross(c - a).dot(a + b + c) < 0.0);
        }
    }

    #[test]
    fn parabola_has_its_focus_where_it_is_said() {
        // At the distance 2 f the height is f and the slope 1.
        let profile = MirrorProfile::parabola(0.5, 1.0);
        let ([r, z], [nr, nz]) = profile.at(1.0);
        assert!((r - 1.0).abs() < 1e-15 && (z - 0.5).abs() < 1e-15);
        assert!((nr + FRAC_1_SQRT_2).abs() < 1e-15 && (nz - FRAC_1_SQRT_2).abs() < 1e-15);
    }
}
