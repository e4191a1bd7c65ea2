//! The spaces of eight rays at once: [`SurfaceFrame::ray_space`] lane by lane, with the same bits; and vectors in lanes.

use glanz_math::{DVec3, Ray};

use super::ray_space::{RaySpace, SurfaceFrame};
use crate::batch::BoundedRay;
use crate::bvh::simd::Simd;
use crate::bvh::simd::lanes::LANES;
use crate::bvh::simd::rows::columns;
use crate::ray_line::RayLine;

/// The z component of the cross product.
#[inline(always)]
pub(super) fn cross<S: Simd>(simd: S, a: [S::Wide; 2], b: [S::Wide; 2]) -> S::Wide {
    simd.sub8(simd.mul8(a[0], b[1]), simd.mul8(a[1], b[0]))
}

/// The scalar product of vectors of the plane.
#[inline(always)]
pub(super) fn dot2<S: Simd>(simd: S, a: [S::Wide; 2], b: [S::Wide; 2]) -> S::Wide {
    simd.add8(simd.mul8(a[0], b[0]), simd.mul8(a[1], b[1]))
}

/// The scalar product.
#[inline(always)]
pub(super) fn dot3<S: Simd>(simd: S, a: [S::Wide; 3], b: [S::Wide; 3]) -> S::Wide {
    simd.add8(simd.add8(simd.mul8(a[0], b[0]), simd.mul8(a[1], b[1])), simd.mul8(a[2], b[2]))
}

/// `-a`.
#[inline(always)]
pub(super) fn negated<S: Simd>(simd: S, a: S::Wide) -> S::Wide {
    simd.mul8(a, simd.splat8(-1.0))
}

/// The [`RayLine`] of a ray in memory, in one cache line; all else about the ray follows from it in a few operations.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct CompactLine {
    /// Origin, direction, shift and speed.
    numbers: [f64; LANES],
}

impl CompactLine {
    pub(super) const ZERO: Self = Self { numbers: [0.0; LANES] };

    /// The lines of eight rays.
    #[inline(always)]
    pub(super) fn eight<S: Simd>(
        simd: S,
        frame: &SurfaceFrame,
        rays: &[&BoundedRay; LANES],
    ) -> [Self; LANES] {
        let [ox, oy, oz, x, _, y, z, _] = columns(simd, *rays);
        let (center, origin) = (frame.center, frame.origin);
        let (ox, oy, oz) = (
            simd.sub8(ox, simd.splat8(origin.x)),
            simd.sub8(oy, simd.splat8(origin.y)),
            simd.sub8(oz, simd.splat8(origin.z)),
        );
        let from = [
            simd.sub8(ox, simd.splat8(center.x)),
            simd.sub8(oy, simd.splat8(center.y)),
            simd.sub8(oz, simd.splat8(center.z)),
        ];
        let far = simd.less8(simd.splat8(frame.far_squared()), dot3(simd, from, from));
        let speed = simd.sqrt8(dot3(simd, [x, y, z], [x, y, z]));
        let (x, y, z) = (simd.div8(x, speed), simd.div8(y, speed), simd.div8(z, speed));
        let mut lines = [Self::ZERO; LANES];
        let rows = simd.transpose8([ox, oy, oz, x, y, z, simd.splat8(0.0), speed]);
        for (k, (line, row)) in lines.iter_mut().zip(rows).enumerate() {
            line.numbers = simd.store8(row);
            if far >> k & 1 == 1 {
                *line = Self::new(frame, &rays[k].ray);
            }
        }
        lines
    }

    #[cold]
    fn new(frame: &SurfaceFrame, ray: &Ray) -> Self {
        let RayLine { origin: o, direction: d, shift, speed } = frame.line(ray);
        Self { numbers: [o.x, o.y, o.z, d.x, d.y, d.z, shift, speed] }
    }

    /// The space of the ray.
    pub(super) fn space(&self, frame: &SurfaceFrame) -> RaySpace {
        let [ox, oy, oz, dx, dy, dz, shift, speed] = self.numbers;
        let (origin, direction) = (DVec3::new(ox, oy, oz), DVec3::new(dx, dy, dz));
        frame.line_space(RayLine { origin, direction, shift, speed })
    }
}

/// The [`RaySpace`]s of eight rays.
#[derive(Clone, Copy)]
pub(super) struct RaySpaceLanes<S: Simd> {
    pub(super) origin: [S::Wide; 3],
    pub(super) direction: [S::Wide; 3],
    shift: S::Wide,
    speed: S::Wide,
    pub(super) axes: [[S::Wide; 3]; 2],
    pub(super) center: [S::Wide; 2],
    pub(super) noise: S::Wide,
}

impl<S: Simd> RaySpaceLanes<S> {
    /// The spaces of eight rays by their lines.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        frame: &SurfaceFrame,
        [a, b, c, d, e, f, g, h]: [&CompactLine; LANES],
    ) -> Self {
        let rows =
            [&a.numbers, &b.numbers, &c.numbers, &d.numbers, &e.numbers, &f.numbers, &g.numbers, &h.numbers];
        let [ox, oy, oz, x, y, z, shift, speed] = simd.columns8(&rows);
        // As in `Frame::from_z`.
        let one = simd.splat8(1.0);
        let sign = simd.copysign8(one, z);
        let a = simd.div8(simd.splat8(-1.0), simd.add8(sign, z));
        let b = simd.mul8(simd.mul8(x, y), a);
        let signed = simd.mul8(sign, x);
        let first =
            [simd.add8(one, simd.mul8(simd.mul8(signed, x), a)), simd.mul8(sign, b), negated(simd, signed)];
        let second = [b, simd.add8(sign, simd.mul8(simd.mul8(y, y), a)), negated(simd, y)];
        let center = frame.center;
        let from = [
            simd.sub8(simd.splat8(center.x), ox),
            simd.sub8(simd.splat8(center.y), oy),
            simd.sub8(simd.splat8(center.z), oz),
        ];
        let largest = simd.max8(simd.abs8(ox), simd.max8(simd.abs8(oy), simd.abs8(oz)));
        let [relative, size] = frame.rounding();
        Self {
            origin: [ox, oy, oz],
            direction: [x, y, z],
            shift,
            speed,
            axes: [first, second],
            center: [dot3(simd, first, from), dot3(simd, second, from)],
            noise: simd.mul8(simd.splat8(relative), simd.add8(simd.splat8(size), largest)),
        }
    }

    /// Ray parameters at these arc lengths.
    #[inline(always)]
    pub(super) fn t(&self, simd: S, s: S::Wide) -> S::Wide {
        simd.add8(self.shift, simd.div8(s, self.speed))
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::{Bounds3, DVec2};

    use super::*;
    use crate::bvh::simd::{Isa, Task};

    struct Spaces<'a> {
        frame: &'a SurfaceFrame,
        rays: [Ray; LANES],
    }

    impl Task for Spaces<'_> {
        type Output = Vec<[f64; LANES]>;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Vec<[f64; LANES]> {
            let rays = self.rays.map(BoundedRay::from);
            let lines = CompactLine::eight(simd, self.frame, &std::array::from_fn(|k| &rays[k]));
            let lanes = RaySpaceLanes::new(simd, self.frame, std::array::from_fn(|k| &lines[k]));
            let mut all = lanes.axes.concat();
            all.extend(lanes.center);
            all.extend([lanes.noise, lanes.t(simd, simd.splat8(0.7))]);
            all.into_iter().map(|wide| simd.store8(wide)).collect()
        }
    }

    #[test]
    fn lanes_are_the_spaces_of_single_rays() {
        for offset in [DVec3::ZERO, DVec3::new(1e5, -3e5, 2e5)] {
            let (low, high) = (DVec3::new(-1.0, 2.0, 0.5) + offset, DVec3::new(3.0, 2.5, 4.0) + offset);
            let frame = SurfaceFrame::new(&Bounds3::new(low, high), high.abs().max_element(), (3, 3));
            assert_eq!(frame.is_moved(), offset != DVec3::ZERO);
            let rays = std::array::from_fn(|k| {
                let x = k as f64 - 3.3;
                // Far and near origins, directions of any length.
                let origin = DVec3::new(x, 0.3 * x * x, -x) * if k % 3 == 0 { 1e6 } else { 1.0 };
                Ray::new(offset + origin, DVec3::new(0.1 * x, 1.0 - x, x * x - 4.0) * 3.0)
            });
            for isa in Isa::all() {
                let lanes = isa.run(Spaces { frame: &frame, rays });
                for (k, ray) in rays.iter().enumerate() {
                    let RaySpace { line, axes: [a, b], center: DVec2 { x, y }, noise } = frame.ray_space(ray);
                    let expected = [a.x, a.y, a.z, b.x, b.y, b.z, x, y, noise, line.t(0.7)];
                    assert_eq!(lanes.iter().map(|lanes| lanes[k]).collect::<Vec<_>>(), expected);
                }
            }
        }
    }
}
