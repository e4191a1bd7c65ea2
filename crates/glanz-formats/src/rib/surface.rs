//! The requests `Patch`, `PatchMesh` and `NuPatch`.

use glanz_math::glam::DVec4;
use glanz_scene::description::{BezierPatchesDescription, NurbsDescription};

use super::lexer::{RibArgument, RibRequest, RibValue};
use super::state::PatchBasis;
use super::{RibError, RibErrorKind, RibReader};

/// The types of patches.
const TYPES: &str = "the type \"bicubic\" or \"bilinear\"";

/// Control points of a request: homogeneous, for meshes with u as the fastest index.
struct MeshPoints {
    /// Offset of their array.
    at: usize,
    /// Numbers per point in the file.
    size: usize,
    values: Vec<[f64; 4]>,
}

/// One direction of a mesh of patches.
struct MeshDirection {
    /// Points.
    count: usize,
    /// Patches.
    patches: usize,
    /// Basis of the points; `None`: corners of bilinear patches.
    basis: Option<PatchBasis>,
}

/// One direction of a `NuPatch`.
struct NurbsDirection {
    count: usize,
    degree: usize,
    knots: Vec<f64>,
    domain: [f64; 2],
    part: [f64; 2],
}

impl RibReader<'_> {
    /// A single patch.
    pub(super) fn patch(&mut self, request: &RibRequest<'_>) -> Result<(), RibError> {
        let bases = self.kind(request)?;
        let side =
            |basis: Option<PatchBasis>| MeshDirection { count: basis.map_or(2, |_| 4), patches: 1, basis };
        self.mesh(request, [side(bases[0]), side(bases[1])])
    }

    /// Patches with shared points: type, then number of points and wrap along u and v.
    pub(super) fn patch_mesh(&mut self, request: &RibRequest<'_>) -> Result<(), RibError> {
        let bases = self.kind(request)?;
        let u = self.side(request, 'u', 1, bases[0])?;
        let v = self.side(request, 'v', 3, bases[1])?;
        self.mesh(request, [u, v])
    }

    /// The bases of a bicubic type, none of a bilinear one.
    fn kind(&self, request: &RibRequest<'_>) -> Result<[Option<PatchBasis>; 2], RibError> {
        match request.arguments.first() {
            Some(RibArgument { value: RibValue::Text(b"bicubic"), .. }) => Ok(self.state.bases.map(Some)),
            Some(RibArgument { value: RibValue::Text(b"bilinear"), .. }) => Ok([None; 2]),
            other => Err(self.wrong(request, other.map_or(request.at, |a| a.at), TYPES)),
        }
    }

    fn side(
        &self,
        request: &RibRequest<'_>,
        axis: char,
        first: usize,
        basis: Option<PatchBasis>,
    ) -> Result<MeshDirection, RibError> {
        let count = self.count(request, first, "a number of points of at least 2")?;
        let periodic = match request.arguments.get(first + 1) {
            Some(RibArgument { value: RibValue::Text(b"periodic"), .. }) => true,
            Some(RibArgument { value: RibValue::Text(b"nonperiodic"), .. }) => false,
            other => {
                let at = other.map_or(request.at, |a| a.at);
                return Err(self.wrong(request, at, "the wrap \"periodic\" or \"nonperiodic\""));
            }
        };
        let (size, step) = basis.map_or((2, 1), |basis| (4, basis.step));
        let steps = if periodic { Some(count) } else { count.checked_sub(size) };
        match steps.filter(|n| n.is_multiple_of(step)) {
            Some(n) => Ok(MeshDirection { count, patches: n / step + usize::from(!periodic), basis }),
            None => {
                let at = request.arguments.get(first).map_or(request.at, |a| a.at);
                Err(self.places.error(at, RibErrorKind::MeshSize { axis, count, step }))
            }
        }
    }

    /// Divides a mesh into patches.
    fn mesh(&mut self, request: &RibRequest<'_>, [u, v]: [MeshDirection; 2]) -> Result<(), RibError> {
        let points = self.points(request, u.count.saturating_mul(v.count))?;
        let size = |side: &MeshDirection| side.basis.map_or((2, 1), |basis| (4, basis.step));
        let ((size_u, step_u), (size_v, step_v)) = (size(&u), size(&v));
        for (j, i) in (0..v.patches).flat_map(|j| (0..u.patches).map(move |i| (j, i))) {
            // Both indices are modulo the numbers of points, so that the point exists.
            let place =
                |k: usize, l: usize| (j * step_v + l) % v.count * u.count + (i * step_u + k) % u.count;
            let mut net = [[[0.0; 4]; 4]; 4];
            for (k, column) in net.iter_mut().enumerate().take(size_u) {
                for (l, point) in column.iter_mut().enumerate().take(size_v) {
                    *point = points.values[place(k, l)];
                }
            }
            if let (Some(basis_u), Some(basis_v)) = (u.basis, v.basis) {
                let rows: [_; 4] =
                    std::array::from_fn(|l| basis_u.to_bezier(std::array::from_fn(|k| net[k][l])));
                net = std::array::from_fn(|k| basis_v.to_bezier(std::array::from_fn(|l| rows[l][k])));
            }
            let mut patch = Vec::with_capacity(size_u * size_v);
            for (k, l) in (0..size_u).flat_map(|k| (0..size_v).map(move |l| (k, l))) {
                let index = place(k, l);
                patch.push(self.placed(&points, index, net[k][l])?);
            }
            if self.state.turns() {
                turn(&mut patch, size_v);
            }
            self.add([size_u - 1, size_v - 1], patch);
        }
        Ok(())
    }

    fn add(&mut self, [degree_u, degree_v]: [usize; 2], patch: Vec<[f64; 4]>) {
        let all = &mut self.file.patches;
        match all.iter_mut().find(|p| (p.degree_u, p.degree_v) == (degree_u, degree_v)) {
            Some(same) => same.patches.push(patch),
            None => all.push(BezierPatchesDescription { degree_u, degree_v, patches: vec![patch] }),
        }
    }

    /// A spline: number of points, order, knots and ends along u, the same along v.
    pub(super) fn nu_patch(&mut self, request: &RibRequest<'_>) -> Result<(), RibError> {
        let (mut u, v) = (self.axis(request, 0)?, self.axis(request, 5)?);
        let found = self.points(request, u.count.saturating_mul(v.count))?;
        let mut points = Vec::with_capacity(found.values.len());
        for i in 0..u.count {
            for index in (0..v.count).map(|j| j * u.count + i) {
                points.push(self.placed(&found, index, found.values[index])?);
            }
        }
        if self.state.turns() {
            turn(&mut points, v.count);
            let [low, high] = u.domain;
            let mirrored = |x: f64| low + (high - x);
            u.knots = u.knots.iter().rev().map(|&k| mirrored(k)).collect();
            u.part = [mirrored(u.part[1]), mirrored(u.part[0])];
        }
        let whole = u.part == u.domain && v.part == v.domain;
        self.file.splines.push(NurbsDescription {
            degree_u: u.degree,
            degree_v: v.degree,
            knots_u: u.knots,
            knots_v: v.knots,
            points,
            domain: (!whole).then_some([u.part, v.part]),
        });
        Ok(())
    }

    fn axis(&self, request: &RibRequest<'_>, first: usize) -> Result<NurbsDirection, RibError> {
        let count = self.count(request, first, "a number of points of at least 2")?;
        let order = self.count(request, first + 1, "an order of at least 2")?;
        if count < order {
            let (request_name, what) = (request.name.to_owned(), "points along an axis");
            let kind = RibErrorKind::Count { request: request_name, what, found: count, needed: order };
            return Err(self.places.error(request.at, kind));
        }
        let (at, knots) = match request.arguments.get(first + 2) {
            Some(RibArgument { at, value: RibValue::Numbers(knots) }) => (*at, knots.clone()),
            other => {
                return Err(self.wrong(request, other.map_or(request.at, |a| a.at), "an array of knots"));
            }
        };
        let needed = count.saturating_add(order);
        if knots.len() != needed {
            let found = knots.len();
            let kind = RibErrorKind::Count { request: request.name.to_owned(), what: "knots", found, needed };
            return Err(self.places.error(at, kind));
        }
        if let Some(i) = knots.windows(2).position(|pair| pair[0] > pair[1]) {
            let kind = RibErrorKind::KnotsDecrease { before: knots[i], after: knots[i + 1] };
            return Err(self.places.error(self.places.number_in_array(at, i + 1), kind));
        }
        let end = |i: usize| match request.arguments.get(i) {
            Some(RibArgument { at, value: RibValue::Number(x) }) => Ok((*at, *x)),
            other => Err(self.wrong(request, other.map_or(request.at, |a| a.at), "the ends of a range")),
        };
        let ((at_min, min), (_, max)) = (end(first + 3)?, end(first + 4)?);
        let [low, high] = [knots[order - 1], knots[count]];
        if !(low <= min && min < max && max <= high) {
            return Err(self.places.error(at_min, RibErrorKind::Range { min, max, low, high }));
        }
        Ok(NurbsDirection { count, degree: order - 1, knots, domain: [low, high], part: [min, max] })
    }

    /// A whole number of at least 2.
    fn count(&self, request: &RibRequest<'_>, index: usize, wanted: &'static str) -> Result<usize, RibError> {
        match request.arguments.get(index) {
            Some(RibArgument { value: RibValue::Number(x), .. })
                if (2.0..=f64::from(u32::MAX)).contains(x) && x.fract() == 0.0 =>
            {
                Ok(*x as usize)
            }
            other => Err(self.wrong(request, other.map_or(request.at, |a| a.at), wanted)),
        }
    }

    /// The array after `"P"` or `"Pw"`, whatever the declaration of the name.
    fn points(&self, request: &RibRequest<'_>, needed: usize) -> Result<MeshPoints, RibError> {
        let last_word = |text: &[u8]| text.rsplit(u8::is_ascii_whitespace).next() == Some(b"P");
        for pair in request.arguments.windows(2) {
            let [
                RibArgument { value: RibValue::Text(name), .. },
                RibArgument { at, value: RibValue::Numbers(numbers) },
            ] = pair
            else {
                continue;
            };
            let size = match name.strip_suffix(b"w") {
                _ if last_word(name) => 3,
                Some(name) if last_word(name) => 4,
                _ => continue,
            };
            if numbers.len() != needed.saturating_mul(size) {
                let (found, what) =
                    (numbers.len(), if size == 3 { "numbers in \"P\"" } else { "numbers in \"Pw\"" });
                let needed = needed.saturating_mul(size);
                let kind = RibErrorKind::Count { request: request.name.to_owned(), what, found, needed };
                return Err(self.places.error(*at, kind));
            }
            let point = |p: &[f64]| [p[0], p[1], p[2], p.get(3).copied().unwrap_or(1.0)];
            return Ok(MeshPoints { at: *at, size, values: numbers.chunks_exact(size).map(point).collect() });
        }
        Err(self.wrong(request, request.at, "control points \"P\" or \"Pw\""))
    }

    /// A Bézier or spline point in the frame of the file; `index`: index of the corresponding point of the file.
    fn placed(&self, points: &MeshPoints, index: usize, point: [f64; 4]) -> Result<[f64; 4], RibError> {
        let mut point = DVec4::from_array(point);
        if points.size == 3 {
            // Some bases contain differences of points, whose weights are not positive.
            point.w = 1.0;
        }
        let error = |number: usize, kind: RibErrorKind| {
            self.places.error(self.places.number_in_array(points.at, index * points.size + number), kind)
        };
        if point.w.is_nan() || point.w <= 0.0 {
            return Err(error(3, RibErrorKind::Weight(point.w)));
        }
        let placed = self.state.to_world * point;
        if placed.is_finite() && (placed / placed.w).is_finite() {
            return Ok(placed.to_array());
        }
        Err(error(0, RibErrorKind::OutOfRange))
    }

    fn wrong(&self, request: &RibRequest<'_>, at: usize, wanted: &'static str) -> RibError {
        self.places.error(at, RibErrorKind::RibArgument { request: request.name.to_owned(), wanted })
    }
}

/// Reverses the order along u; the `count_v` points of equal u are consecutive.
fn turn(points: &mut [[f64; 4]], count_v: usize) {
    points.reverse();
    points.chunks_mut(count_v.max(1)).for_each(<[_]>::reverse);
}
