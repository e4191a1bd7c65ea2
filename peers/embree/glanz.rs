//! Glanz's side of the comparison with Embree; `compare.py` runs it and describes the comparison.
//!
//! Writes the mesh and the rays into the given folder, then answers each line `SET QUERY THREADS` with wall-clock nanoseconds,
//! processor nanoseconds, number of rays, number of hits and sum of the ray parameters.

#[path = "../../crates/glanz-geometry/benches/mesh/landscape.rs"]
mod landscape;
#[path = "../../crates/glanz-geometry/benches/streams/processor_time.rs"]
mod processor_time;

use std::fs::{File, read_to_string};
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::time::Instant;

use glanz_geometry::RaySurface;
use glanz_geometry::mesh::Mesh;
use glanz_math::Ray;
use landscape::{Model, bounced_rays, camera_rays, displaced_sphere, random_rays, wavy_grid};
use processor_time::processor_time;

type Failure = Box<dyn std::error::Error>;

fn write_model(folder: &Path, model: &Model) -> Result<(), Failure> {
    let mut file = BufWriter::new(File::create(folder.join("mesh"))?);
    file.write_all(&(model.positions.len() as u32).to_le_bytes())?;
    file.write_all(&(model.indices.len() as u32).to_le_bytes())?;
    for x in model.positions.iter().flat_map(|p| p.to_array()) {
        file.write_all(&(x as f32).to_le_bytes())?;
    }
    for i in model.indices.iter().flatten() {
        file.write_all(&i.to_le_bytes())?;
    }
    Ok(file.flush()?)
}

fn write_rays(path: &Path, rays: &[Ray]) -> Result<(), Failure> {
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(&(rays.len() as u32).to_le_bytes())?;
    for x in rays.iter().flat_map(|r| [r.origin.to_array(), r.direction.to_array()]).flatten() {
        file.write_all(&(x as f32).to_le_bytes())?;
    }
    Ok(file.flush()?)
}

fn query(mesh: &Mesh, rays: &[Ray], any: bool) -> (u64, f64) {
    let (mut hits, mut sum) = (0, 0.0);
    for ray in rays {
        if any {
            hits += u64::from(mesh.occluded(ray, f64::INFINITY));
        } else if let Some(hit) = mesh.intersect(ray, f64::INFINITY) {
            hits += 1;
            sum += hit.t;
        }
    }
    (hits, sum)
}

fn measure(mesh: &Mesh, rays: &[Ray], any: bool, threads: usize) -> (u128, u64, u64, f64) {
    let start = Instant::now();
    let part = rays.len().div_ceil(threads);
    let work = |rays| {
        let before = processor_time();
        let (hits, sum) = query(mesh, rays, any);
        (processor_time() - before, hits, sum)
    };
    let (time, hits, sum) = std::thread::scope(|scope| {
        let workers: Vec<_> = rays.chunks(part).map(|rays| scope.spawn(move || work(rays))).collect();
        workers
            .into_iter()
            .filter_map(|worker| worker.join().ok())
            .fold((0, 0, 0.0), |(t, h, s), (time, hits, sum)| (t + time, h + hits, s + sum))
    });
    (start.elapsed().as_nanos(), time, hits, sum)
}

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let mut argument = || arguments.next().ok_or("usage: glanz FOLDER sphere|grid TRIANGLES");
    let (folder, shape, triangles) = (argument()?, argument()?, argument()?.parse::<f64>()?);
    let folder = Path::new(&folder);
    let mut out = std::io::stdout();
    let model = match shape.as_str() {
        "sphere" => displaced_sphere((triangles / 8.0).sqrt().round() as u32),
        "grid" => wavy_grid((triangles / 2.0).sqrt().round() as u32),
        _ => return Err("the shape is sphere or grid".into()),
    };
    write_model(folder, &model)?;
    let start = Instant::now();
    let mesh = Mesh::try_new(model.positions, model.indices, None, None)?;
    let built = start.elapsed();
    let camera = camera_rays(1024, 1024);
    let sets =
        [("bounced", bounced_rays(&mesh, &camera)), ("random", random_rays(1 << 20)), ("coherent", camera)];
    for (name, rays) in &sets {
        write_rays(&folder.join(name), rays)?;
    }
    let cpu = read_to_string("/proc/cpuinfo").unwrap_or_default();
    let cpu = cpu.lines().find(|line| line.starts_with("model name")).unwrap_or("processor unknown");
    writeln!(out, "{} s {} bytes {:?} {cpu}", built.as_secs_f64(), mesh.bytes(), mesh.statistics())?;
    for line in std::io::stdin().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let [set, query, threads] = words[..] else { return Err("expected SET QUERY THREADS".into()) };
        let (_, rays) = sets.iter().find(|(name, _)| *name == set).ok_or("no such set of rays")?;
        let (clock, processors, hits, sum) = measure(&mesh, rays, query == "any", threads.parse()?);
        writeln!(out, "{clock} {processors} {} {hits} {sum}", rays.len())?;
        out.flush()?;
    }
    Ok(())
}
