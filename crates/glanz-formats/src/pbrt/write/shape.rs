//! Surfaces with their trimming.

use std::fmt::Write;

use glanz_geometry::curve::CurveShading;
use glanz_scene::description::{
    GeometryDescription, NurbsDescription, ShapeDescription, TrimCurveDescription, TrimDescription,
};

use super::parameters::ParameterWriter;

/// Writes the directive of a shape; `Err` states what the language cannot say.
pub(super) fn write(text: &mut String, shape: &ShapeDescription) -> Result<(), &'static str> {
    if shape.emission.is_some() {
        return Err("emission cannot be written yet");
    }
    if shape.receiver.is_some() {
        return Err("a receiver cannot be written yet");
    }
    if shape.alpha.is_some() {
        return Err("an opacity cannot be written yet");
    }
    // Writing to a text cannot fail.
    let _ = write!(text, "Shape \"{}\"", shape.geometry.name());
    let mut list = ParameterWriter::new(text);
    geometry(&mut list, &shape.geometry)?;
    if let Some(trim) = &shape.trim {
        write_trim(&mut list, trim)?;
    }
    if let Some(solid) = shape.solid {
        if i32::try_from(solid).is_err() {
            return Err("the number of its solid is too large");
        }
        list.integers("solid", [i64::from(solid)]);
    }
    list.finish()
}

fn geometry(list: &mut ParameterWriter<'_>, geometry: &GeometryDescription) -> Result<(), &'static str> {
    match geometry {
        GeometryDescription::Sphere { radius, z, phi_max }
        | GeometryDescription::Cylinder { radius, z, phi_max }
        | GeometryDescription::Paraboloid { radius, z, phi_max } => {
            list.float("radius", *radius);
            heights(list, *z);
            list.azimuth(*phi_max);
        }
        GeometryDescription::Cone { radius, height, phi_max } => {
            list.float("radius", *radius);
            list.float("height", *height);
            list.azimuth(*phi_max);
        }
        GeometryDescription::Hyperboloid { p1, p2, phi_max } => {
            list.points("p1", [*p1]);
            list.points("p2", [*p2]);
            list.azimuth(*phi_max);
        }
        GeometryDescription::TwoSheetedHyperboloid { a, c, z, phi_max } => {
            list.float("a", *a);
            list.float("c", *c);
            heights(list, *z);
            list.azimuth(*phi_max);
        }
        GeometryDescription::Disk { height, radius, inner_radius, phi_max } => {
            list.float("height", *height);
            list.float("radius", *radius);
            list.float("innerradius", *inner_radius);
            list.azimuth(*phi_max);
        }
        GeometryDescription::Plane { x, y } => {
            for (name, range) in [("x", x), ("y", y)] {
                if *range != [f64::NEG_INFINITY, f64::INFINITY] {
                    list.floats(name, *range);
                }
            }
        }
        GeometryDescription::Algebraic { terms, clip } => {
            let exponents = terms.iter().flat_map(|(exponents, _)| exponents.map(i64::from));
            list.integers("exponents", exponents);
            list.floats("coefficients", terms.iter().map(|term| term.1));
            list.points("clip", *clip);
        }
        GeometryDescription::Torus { major_radius, minor_radius, phi_max } => {
            list.float("majorradius", *major_radius);
            list.float("minorradius", *minor_radius);
            list.azimuth(*phi_max);
        }
        GeometryDescription::Polyhedron { half_spaces } => {
            list.normals("N", half_spaces.iter().map(|half_space| half_space.0));
            list.floats("d", half_spaces.iter().map(|half_space| half_space.1));
        }
        GeometryDescription::Cuboid { min, max } => {
            list.points("min", [*min]);
            list.points("max", [*max]);
        }
        GeometryDescription::Triangles { positions, indices, normals, uvs } => {
            list.points("P", positions.iter().copied());
            list.integers("indices", indices.iter().flatten().map(|&i| i64::from(i)));
            if let Some(normals) = normals {
                list.normals("N", normals.iter().copied());
            }
            if let Some(uvs) = uvs {
                list.pairs("uv", uvs.iter().copied());
            }
        }
        GeometryDescription::Bilinear { positions, indices } => {
            list.points("P", positions.iter().copied());
            list.integers("indices", indices.iter().flatten().map(|&i| i64::from(i)));
        }
        GeometryDescription::Nurbs(nurbs) => write_nurbs(list, nurbs),
        GeometryDescription::BezierPatches(patches) => {
            let [u, v] = [patches.degree_u, patches.degree_v];
            list.integers("udegree", [u as i64]);
            list.integers("vdegree", [v as i64]);
            // In files, u runs fastest.
            let in_file = |patch: &Vec<[f64; 4]>| {
                let places = (0..=v).flat_map(|j| (0..=u).map(move |i| i * (v + 1) + j));
                places.filter_map(|place| patch.get(place).copied()).collect::<Vec<_>>()
            };
            weighted(list, patches.patches.iter().flat_map(in_file));
        }
        GeometryDescription::BezierTriangles(patches) => {
            list.integers("degree", [patches.degree as i64]);
            weighted(list, patches.patches.iter().flatten().copied());
        }
        GeometryDescription::Curve { points, widths, shading } => {
            list.points("P", points.iter().copied());
            list.float("width0", widths[0]);
            list.float("width1", widths[1]);
            let shading = match shading {
                CurveShading::Flat => "flat",
                CurveShading::Cylinder => "cylinder",
            };
            list.text("type", shading);
        }
    }
    Ok(())
}

fn heights(list: &mut ParameterWriter<'_>, [low, high]: [f64; 2]) {
    list.float("zmin", low);
    list.float("zmax", high);
}

/// Homogeneous points.
fn weighted(list: &mut ParameterWriter<'_>, points: impl Iterator<Item = [f64; 4]>) {
    list.floats("Pw", points.flatten());
}

fn write_nurbs(list: &mut ParameterWriter<'_>, nurbs: &NurbsDescription) {
    let NurbsDescription { degree_u, degree_v, knots_u, knots_v, points, domain } = nurbs;
    let count = |knots: &[f64], degree: usize| knots.len().saturating_sub(degree + 1);
    let (nu, nv) = (count(knots_u, *degree_u), count(knots_v, *degree_v));
    for (count_name, count, order_name, degree, knots_name, knots) in
        [("nu", nu, "uorder", degree_u, "uknots", knots_u), ("nv", nv, "vorder", degree_v, "vknots", knots_v)]
    {
        list.integers(count_name, [count as i64]);
        list.integers(order_name, [*degree as i64 + 1]);
        list.floats(knots_name, knots.iter().copied());
    }
    if let Some([u, v]) = domain {
        for (name, value) in [("u0", u[0]), ("u1", u[1]), ("v0", v[0]), ("v1", v[1])] {
            list.float(name, value);
        }
    }
    // In files, u runs fastest.
    let places = (0..nv).flat_map(|j| (0..nu).map(move |i| i * nv + j));
    weighted(list, places.filter_map(|place| points.get(place).copied()));
}

fn write_trim(list: &mut ParameterWriter<'_>, trim: &TrimDescription) -> Result<(), &'static str> {
    let curves: Vec<&TrimCurveDescription> = trim.loops.iter().flat_map(|l| &l.curves).collect();
    list.integers("trimloops", trim.loops.iter().map(|l| l.curves.len() as i64));
    list.integers("trimorders", curves.iter().map(|curve| curve.degree as i64 + 1));
    list.integers("trimcounts", curves.iter().map(|curve| curve.points.len() as i64));
    list.floats("trimknots", curves.iter().flat_map(|curve| curve.knots.iter().copied()));
    list.floats("trimpoints", curves.iter().flat_map(|curve| curve.points.iter().flatten().copied()));
    let widths: Vec<f64> = curves.iter().filter_map(|curve| curve.width).collect();
    if widths.len() == curves.len() {
        list.floats("trimwidths", widths);
    } else if !widths.is_empty() {
        return Err("some of its trimming curves have a width and others have none");
    }
    if curves.iter().any(|curve| curve.edge.is_some()) {
        let edges = curves.iter().flat_map(|curve| match curve.edge {
            Some(edge) => [edge.edge, edge.vertices[0], edge.vertices[1]].map(i64::from),
            None => [-1; 3],
        });
        let edges: Vec<i64> = edges.collect();
        if edges.iter().any(|&number| i32::try_from(number).is_err()) {
            return Err("the number of an edge is too large");
        }
        list.integers("trimedges", edges);
        let ranges = curves.iter().flat_map(|curve| curve.edge.map_or([0.0, 1.0], |edge| edge.range));
        list.floats("trimedgeranges", ranges);
    }
    list.floats("trimscale", trim.scale);
    if let Some([[u0, v0], [u1, v1]]) = trim.domain {
        list.floats("trimdomain", [u0, v0, u1, v1]);
    }
    Ok(())
}
