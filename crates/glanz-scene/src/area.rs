//! Areas of objects.

use glanz_geometry::{FaceDomain, Surface};
use glanz_math::rounding::gamma;
use glanz_math::{DVec2, DVec3};
use glanz_sampling::basis::GaussLegendre;

use crate::object::SceneObject;

/// Relative error of an integrated area below which cells are no longer quartered.
const TOLERANCE: f64 = 1e-9;
/// Limit on the number of cells: where tangents vanish within a face, quartering would not end.
const MAX_CELLS: usize = 1 << 14;
/// Nodes along each side of a cell.
const NODES: usize = 4;
/// Angle, radians, by which normals of a flat surface may differ: coordinates printed with six digits pass.
const FLAT: f64 = 1e-5;

/// Area in the object's group, m^2, with a relative error of about 1e-6; closed forms are exact. `None` if it is infinite or cannot be sampled.
pub(crate) fn area(object: &SceneObject) -> Option<f64> {
    object.sample(DVec2::splat(0.5))?;
    let surface = object.surface();
    let scale = object.to_parent().map_or(Some(1.0), |map| map.uniform_scale(gamma(64)));
    let own = scale.and_then(|scale| Some(scale * scale * closed_form(surface)?));
    let area = own.unwrap_or_else(|| integrated(object));
    (area > 0.0 && area.is_finite()).then_some(area)
}

/// The largest area that a flat object or a whole sphere shows to a distant observer, m^2; `None` for others.
pub(crate) fn far_field_area(object: &SceneObject, is_sphere: bool) -> Option<f64> {
    let whole = area(object)?;
    if is_sphere { Some(0.25 * whole) } else { is_flat(object.surface()).then_some(whole) }
}

/// Area of a surface in its own frame, where it is known.
pub(crate) fn closed_form(surface: &Surface) -> Option<f64> {
    Some(match surface {
        Surface::Sphere(s) => s.area(),
        Surface::Cylinder(s) => s.area(),
        Surface::Cone(s) => s.area(),
        Surface::Paraboloid(s) => s.area(),
        Surface::Disk(s) => s.area(),
        Surface::Plane(s) => s.area(),
        Surface::Torus(s) => s.area(),
        Surface::Polyhedron(s) => s.area(),
        Surface::Cuboid(s) => s.area(),
        Surface::Triangle(s) => s.area(),
        Surface::Mesh(s) => s.area(),
        Surface::Freeform(s) => s.area(),
        _ => return None,
    })
}

fn is_flat(surface: &Surface) -> bool {
    let normal = |face: u32, uv: DVec2| surface.at(face, uv).map(|at| at.point.normal);
    let agree = |a: DVec3, b: DVec3| a.cross(b).length() <= FLAT && a.dot(b) > 0.0;
    match surface {
        Surface::Disk(_) | Surface::Plane(_) | Surface::Triangle(_) => true,
        // The normal is linear between the corners.
        Surface::Bilinear(_) => {
            let corners = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].map(|uv| normal(0, uv));
            corners.iter().all(|corner| corner.zip(corners[0]).is_some_and(|(a, b)| agree(a, b)))
        }
        Surface::Mesh(_) => {
            let middle = DVec2::splat(0.25);
            let first = normal(0, middle);
            (0..surface.faces()).all(|face| normal(face, middle).zip(first).is_some_and(|(a, b)| agree(a, b)))
        }
        _ => false,
    }
}

/// A square in the parameters of a face.
struct QuadratureCell {
    face: u32,
    low: DVec2,
    side: f64,
    integral: f64,
}

/// The integral of the area element over all faces, by Gauss's rule on squares that are quartered while that changes the result.
fn integrated(object: &SceneObject) -> f64 {
    let surface = object.surface();
    let area_element = |face: u32, uv: DVec2| {
        surface.at(face, uv).map_or(0.0, |at| {
            at.area_element * object.to_parent().map_or(1.0, |map| map.area_scale(at.point.normal))
        })
    };
    let rule = GaussLegendre::new(NODES);
    let cell = |face: u32, low: DVec2, side: f64| {
        let along = |v: f64| rule.integrate(low.x, low.x + side, |u| area_element(face, DVec2::new(u, v)));
        QuadratureCell { face, low, side, integral: rule.integrate(low.y, low.y + side, along) }
    };
    let (mut area, mut open) = (0.0, Vec::new());
    for face in 0..surface.faces() {
        match surface.face_domain(face) {
            // These are flat: the area element is the same everywhere.
            FaceDomain::Polygon(corners) => {
                let count = corners.len().max(1) as f64;
                area += polygon_area(&corners) * area_element(face, corners.iter().sum::<DVec2>() / count);
            }
            FaceDomain::Square => open.push(cell(face, DVec2::ZERO, 1.0)),
        }
    }
    let whole = area + open.iter().map(|cell| cell.integral).sum::<f64>();
    let each = TOLERANCE * whole / open.len().max(1) as f64;
    let mut left = open.len() + MAX_CELLS;
    while let Some(QuadratureCell { face, low, side, integral }) = open.pop() {
        let half = 0.5 * side;
        let quarters =
            [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].map(|corner| cell(face, low + half * corner, half));
        let refined: f64 = quarters.iter().map(|quarter| quarter.integral).sum();
        left = left.saturating_sub(1);
        if (refined - integral).abs() <= each * side * side || left == 0 {
            area += refined;
        } else {
            open.extend(quarters);
        }
    }
    area
}

/// Area of a polygon in the parameters.
pub(crate) fn polygon_area(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    0.5 * corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs()
}
