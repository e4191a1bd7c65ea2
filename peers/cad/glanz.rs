//! What Glanz makes of a STEP or IGES file: faces, solids, and all hits of given rays; `compare.py` has the format and makes the comparison.
//!
//!     cargo run --release -p glanz-formats --example peer_cad -- FILE.step REF.json > GLANZ.json

use std::collections::BTreeSet;
use std::io::Write as _;

use glanz_brep::face::{FaceMeasure, TrimmedFace, TrimmedFaces, trimmed_faces};
use glanz_brep::model::{Body, BrepModel, Occurrence};
use glanz_formats::cad::{CadFaceOutcome, CadReport};
use glanz_formats::{Options, load};
use glanz_geometry::trim::{RegionSettings, TrimCurve, TrimRegion};
use glanz_math::{Bounds3, DMat4, DVec2, DVec3, Ray};
use glanz_scene::{Description, Scene};
use serde_json::{Value, json};

type Failure = Box<dyn std::error::Error>;

/// Accuracy of areas and volumes, relative.
const ACCURACY: f64 = 1e-6;

/// Points per side of the lattice on a face from which its bounds are searched.
const LATTICE: u32 = 24;

/// Hits of a ray after which something is wrong.
const MAX_HITS: usize = 10_000;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let (Some(file), Some(reference)) = (arguments.next(), arguments.next()) else {
        return Err("usage: peer_cad FILE.step REF.json".into());
    };
    let reference: Value = serde_json::from_slice(&std::fs::read(reference)?)?;
    let bytes = std::fs::read(&file)?;
    let is_step = bytes.trim_ascii_start().starts_with(b"ISO-10303-21");
    let model = if is_step {
        glanz_formats::step::read(&bytes)?.model
    } else {
        glanz_formats::iges::read(&bytes)?.model
    };
    let trimmed = trimmed_faces(&model);
    let loaded = load(file.as_ref(), &Options::default()).map_err(|diagnostics| diagnostics.to_string())?;
    let report = loaded.cad.ok_or("the file is no CAD file")?;
    let output = json!({
        "faces": faces(&report, &trimmed),
        "solids": solids(&model, &trimmed),
        "rays": rays(&loaded.description, &report, &reference["rays"])?,
    });
    writeln!(std::io::stdout(), "{output}")?;
    Ok(())
}

fn faces(report: &CadReport, trimmed: &TrimmedFaces) -> Vec<Value> {
    let read = report.faces.iter().zip(&trimmed.faces).map(|(face, trimmed)| {
        let (status, reason) = match &face.outcome {
            CadFaceOutcome::Read => ("read", None),
            CadFaceOutcome::Repaired(repairs) => ("repaired", Some(repairs.join("; "))),
            CadFaceOutcome::Refused(reason) => ("refused", Some(reason.clone())),
        };
        let area = trimmed.as_ref().ok().map(|face| face.measure(ACCURACY).area);
        json!({ "entity": face.entity.0, "kind": face.kind, "area": area, "status": status, "reason": reason, "width": face.width })
    });
    let lost = report.reading.omissions.notes().iter().map(|note| {
        let entity = note.entity.map(|entity| entity.0);
        json!({ "entity": entity, "kind": null, "area": null, "status": "refused", "reason": note.reason, "width": null })
    });
    read.chain(lost).collect()
}

/// Every occurrence of a solid.
fn solids(model: &BrepModel, trimmed: &TrimmedFaces) -> Vec<Value> {
    let mut found = Vec::new();
    let mut open: Vec<(&Occurrence, DMat4)> = model.roots.iter().map(|root| (root, root.to_parent)).collect();
    while let Some((occurrence, to_world)) = open.pop() {
        let part = &model.parts[occurrence.part];
        open.extend(part.occurrences.iter().map(|inner| (inner, to_world * inner.to_parent)));
        found.extend(part.bodies.iter().filter(|body| body.solid).map(|body| solid(body, trimmed, to_world)));
    }
    found
}

fn solid(body: &Body, trimmed: &TrimmedFaces, to_world: DMat4) -> Value {
    let scale = to_world.determinant().abs().cbrt();
    let (mut sum, mut points) = (FaceMeasure::default(), Vec::new());
    for &(face, reversed) in body.shells.iter().flat_map(|shell| &shell.faces) {
        let Ok(face) = &trimmed.faces[face] else { continue };
        let mut part = face.measure(ACCURACY);
        if reversed {
            part.volume = -part.volume;
        }
        sum = sum + part;
        points.extend(extremes(face, to_world));
    }
    let Bounds3 { min, max } = Bounds3::from_points(points);
    json!({
        "entity": body.entity.0,
        "volume": sum.volume * scale.powi(3),
        "area": sum.area * scale.powi(2),
        "bounds": [min.to_array(), max.to_array()],
    })
}

/// Points of a face that are extreme along the axes.
fn extremes(face: &TrimmedFace, to_world: DMat4) -> Vec<DVec3> {
    let (region, border) = region(face);
    let [[u0, u1], [v0, v1]] = face.domain();
    // Loops that go around close outside of the domain.
    let domain = [DVec2::new(u0, v0), DVec2::new(u1, v1)];
    let kept = |uv: DVec2| {
        uv.cmpge(domain[0]).all()
            && uv.cmple(domain[1]).all()
            && region.as_ref().is_none_or(|region| region.contains(uv))
    };
    let size = DVec2::new(u1 - u0, v1 - v0);
    let point = |uv: DVec2| (to_world * face.to_part).transform_point3(face.geometry.point(uv));
    let lattice = (0..=LATTICE).flat_map(|i| {
        (0..=LATTICE).map(move |j| DVec2::new(f64::from(i), f64::from(j)) / f64::from(LATTICE))
    });
    let inside = lattice.map(|at| DVec2::new(u0, v0) + at * size).filter(|&uv| kept(uv));
    let starts: Vec<DVec2> = inside.chain(border.into_iter().filter(|&uv| kept(uv))).collect();
    let directions = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    directions
        .filter_map(|direction| {
            let height = |uv: &DVec2| point(*uv).dot(direction);
            let mut best = *starts.iter().max_by(|a, b| height(a).total_cmp(&height(b)))?;
            let mut step = size / f64::from(LATTICE);
            for _ in 0..40 {
                let around = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y, DVec2::ONE, DVec2::NEG_ONE];
                let next = around.map(|d| best + d * step).into_iter().filter(|&uv| kept(uv));
                match next.max_by(|a, b| height(a).total_cmp(&height(b))) {
                    Some(next) if height(&next) > height(&best) => best = next,
                    _ => step *= 0.5,
                }
            }
            Some(point(best))
        })
        .collect()
}

/// The part of the parameters within the edges of a face, and points of its border.
fn region(face: &TrimmedFace) -> (Option<TrimRegion>, Vec<DVec2>) {
    let Some(trim) = &face.trim else { return (None, Vec::new()) };
    let curves = trim
        .loops
        .iter()
        .map(|l| l.iter().filter_map(|c| TrimCurve::try_nurbs(c.degree, &c.knots, &c.points).ok()).collect());
    let [u, v] = trim.domain;
    let domain = Some([DVec2::new(u[0], v[0]), DVec2::new(u[1], v[1])]);
    let region =
        TrimRegion::try_with_settings(curves.collect(), RegionSettings { scale: trim.scale, domain }).ok();
    let border = trim.loops.iter().flatten().flat_map(|curve| curve.samples()).collect();
    (region, border)
}

/// Parameter and face of every hit of each ray, ascending.
///
/// Each solid is a scene of its own: where two of them touch, a ray that leaves one starts beyond the other.
fn rays(description: &Description, report: &CadReport, rays: &Value) -> Result<Vec<Vec<Value>>, Failure> {
    let rays: Vec<[f64; 7]> = serde_json::from_value(rays.clone())?;
    let groups = || description.groups.iter().chain([&description.world]);
    let solids: BTreeSet<Option<u32>> =
        groups().flat_map(|group| &group.shapes).map(|shape| shape.solid).collect();
    let mut hits: Vec<Vec<(f64, u64)>> = vec![Vec::new(); rays.len()];
    for solid in solids {
        let mut part = description.clone();
        part.groups
            .iter_mut()
            .chain([&mut part.world])
            .for_each(|group| group.shapes.retain(|shape| shape.solid == solid));
        let all = groups().flat_map(|group| &group.shapes).zip(&report.shapes);
        let faces: Vec<usize> =
            all.filter(|(shape, _)| shape.solid == solid).map(|(_, &face)| face).collect();
        let (scene, _) = Scene::resolve(part)?;
        for (ray, hits) in rays.iter().zip(&mut hits) {
            hits_of(&scene, ray, |t, shape| hits.push((t, report.faces[faces[shape]].entity.0)))?;
        }
        if scene.undecided() > 0 {
            return Err(format!("{} searches without a decision", scene.undecided()).into());
        }
    }
    Ok(hits
        .into_iter()
        .map(|mut hits| {
            hits.sort_by(|a, b| a.0.total_cmp(&b.0));
            hits.into_iter().map(|hit| json!(hit)).collect()
        })
        .collect())
}

/// Calls `visit` with the parameter and the shape of every hit of a ray, one after the other, as paths of light meet them.
fn hits_of(
    scene: &Scene,
    &[x, y, z, dx, dy, dz, length]: &[f64; 7],
    mut visit: impl FnMut(f64, usize),
) -> Result<(), Failure> {
    let (origin, direction) = (DVec3::new(x, y, z), DVec3::new(dx, dy, dz));
    let (mut ray, mut passed) = (Ray::new(origin, direction), 0.0);
    for _ in 0..MAX_HITS {
        let Some(hit) = scene.intersect(&ray, length - passed) else { return Ok(()) };
        visit(passed + hit.t, hit.id as usize);
        ray = hit.spawn(direction);
        passed = (ray.origin - origin).dot(direction);
    }
    Err("a ray has no end".into())
}
