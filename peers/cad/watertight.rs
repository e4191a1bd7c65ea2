//! Rays from inside the solids of STEP files: none may escape.
//!
//!     cargo run --release -p glanz-formats --example peer_watertight -- FILES [--rays 10000000] [--aimed 1000000]
//!
//! Each solid is a scene of its own. From points inside of it, rays go into random directions, and others towards points next to its edges
//! and vertices: within 1e-5 of its size. An escape is a ray without a hit, or one that first meets the outside of a face.

use std::collections::BTreeSet;
use std::io::Write as _;

use glanz_brep::EdgeCurve;
use glanz_brep::model::BrepModel;
use glanz_formats::{Options, load};
use glanz_geometry::BoundedRay;
use glanz_math::{DVec3, Ray};
use glanz_scene::{Description, Scene};

type Failure = Box<dyn std::error::Error>;

/// Points inside of a solid from which rays start.
const STARTS: usize = 1000;

/// Rays in a batch.
const BATCH: usize = 1 << 14;

/// Largest distance of a target from its edge or vertex, relative to the size of the solid.
const BESIDE: f64 = 1e-5;

/// Uniform numbers in [0, 1), the same in each run (@steele2014, SplitMix64).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> DVec3 {
        let z = 1.0 - 2.0 * self.next();
        let (sin, cos) = (std::f64::consts::TAU * self.next()).sin_cos();
        let rho = (1.0 - z * z).sqrt();
        DVec3::new(rho * cos, rho * sin, z)
    }
}

fn main() -> Result<(), Failure> {
    let (mut files, mut counts) = (Vec::new(), [10_000_000, 1_000_000]);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match ["--rays", "--aimed"].iter().position(|option| *option == argument) {
            Some(option) => counts[option] = arguments.next().ok_or("a number is missing")?.parse()?,
            None => files.push(argument),
        }
    }
    let mut escapes = 0;
    for file in files {
        escapes += check(&file, counts)?;
    }
    if escapes > 0 { Err(format!("{escapes} rays escaped").into()) } else { Ok(()) }
}

/// Number of rays that escape from the solids of a file.
fn check(file: &str, [random, aimed]: [usize; 2]) -> Result<usize, Failure> {
    let mut out = std::io::stdout();
    let model = glanz_formats::step::read(&std::fs::read(file)?)?.model;
    let loaded = load(file.as_ref(), &Options::default()).map_err(|diagnostics| diagnostics.to_string())?;
    let shapes =
        loaded.description.groups.iter().chain([&loaded.description.world]).flat_map(|group| &group.shapes);
    let solids: BTreeSet<u32> = shapes.filter_map(|shape| shape.solid).collect();
    let mut escapes = 0;
    for solid in solids {
        let scene = alone(&loaded.description, solid)?;
        let mut uniform = Uniform(u64::from(solid));
        let starts = inside(&scene, &mut uniform);
        if starts.is_empty() {
            writeln!(out, "{file}: solid {solid}: no point inside was found")?;
            continue;
        }
        let targets = targets(&model, &scene);
        let aimed = if targets.is_empty() { 0 } else { aimed };
        let start = |uniform: &mut Uniform| starts[(uniform.next() * starts.len() as f64) as usize];
        let lost = [count_escapes(&scene, random, || Ray::new(start(&mut uniform), uniform.direction())), {
            let beside = BESIDE * scene.bounds().diagonal().length();
            count_escapes(&scene, aimed, || {
                let target = targets[(uniform.next() * targets.len() as f64) as usize];
                let (from, to) =
                    (start(&mut uniform), target + uniform.direction() * (beside * uniform.next()));
                Ray::new(from, (to - from).normalize())
            })
        }];
        writeln!(
            out,
            "{file}: solid {solid}: {} of {random} random and {} of {aimed} aimed rays escape",
            lost[0], lost[1]
        )?;
        escapes += lost[0] + lost[1];
    }
    Ok(escapes)
}

/// The scene of one solid, in the frame of its part.
fn alone(description: &Description, solid: u32) -> Result<Scene, Failure> {
    let mut part = Description { materials: description.materials.clone(), ..Description::default() };
    let groups = description.groups.iter().chain([&description.world]);
    let shapes = groups.flat_map(|group| &group.shapes).filter(|shape| shape.solid == Some(solid));
    part.world.shapes.extend(shapes.cloned());
    Ok(Scene::resolve(part)?.0)
}

/// Points inside: in the middle between an entry and an exit of random lines.
fn inside(scene: &Scene, uniform: &mut Uniform) -> Vec<DVec3> {
    let bounds = scene.bounds();
    let size = bounds.diagonal().length();
    let mut found = Vec::new();
    for _ in 0..100 * STARTS {
        let at = bounds.min + DVec3::new(uniform.next(), uniform.next(), uniform.next()) * bounds.diagonal();
        let direction = uniform.direction();
        let Some(entry) = scene.intersect(&Ray::new(at - 2.0 * size * direction, direction), f64::INFINITY)
        else {
            continue;
        };
        let Some(exit) = scene.intersect(&entry.spawn(direction), f64::INFINITY) else { continue };
        let thickness = entry.point.position.distance(exit.point.position);
        if entry.point.normal.dot(direction) < 0.0
            && exit.point.normal.dot(direction) > 0.0
            && thickness > 1e-3 * size
        {
            found.push(0.5 * (entry.point.position + exit.point.position));
            if found.len() == STARTS {
                break;
            }
        }
    }
    found
}

/// Points of the edges and vertices within the bounds of a solid.
fn targets(model: &BrepModel, scene: &Scene) -> Vec<DVec3> {
    let curves = model
        .edges
        .iter()
        .filter_map(|edge| EdgeCurve::try_new(edge, &model.vertices, model.uncertainty).ok());
    let on_edges = curves.flat_map(|curve| (0..=64).map(move |i| curve.point(f64::from(i) / 64.0)));
    let bounds = scene.bounds();
    let mut all: Vec<DVec3> = on_edges.chain(model.vertices.iter().copied()).collect();
    all.retain(|p| p.cmpge(bounds.min).all() && p.cmple(bounds.max).all());
    all
}

fn count_escapes(scene: &Scene, count: usize, mut next: impl FnMut() -> Ray) -> usize {
    let (mut hits, mut escapes, mut done) = (Vec::new(), 0, 0);
    while done < count {
        let number = BATCH.min(count - done);
        let rays: Vec<BoundedRay> =
            (0..number).map(|_| BoundedRay { ray: next(), t_max: f64::INFINITY }).collect();
        scene.closest_batch(&rays, &mut hits);
        let escaped = |(ray, hit): &(&BoundedRay, &Option<_>)| {
            hit.as_ref()
                .is_none_or(|hit| scene.interaction(&ray.ray, hit).point.normal.dot(ray.ray.direction) < 0.0)
        };
        escapes += rays.iter().zip(&hits).filter(escaped).count();
        done += number;
    }
    escapes
}
