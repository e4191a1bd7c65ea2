//! Glanz's side of the comparison of freeform surfaces; `compare.py` runs it and describes the comparison.
//!
//! Writes the tessellation of the surface and the rays into the given folder, prints a description as one line of JSON, then
//! answers each line `SET QUERY TIMES` with wall-clock nanoseconds, processor nanoseconds, number of rays, number of hits and
//! a sum: of the ray parameters (closest, all) or of the grey levels (picture). `SET compare 1` reads the ray parameters that
//! the other side has written.

#[path = "../../crates/glanz-geometry/benches/freeform/camera_rays.rs"]
mod camera_rays;
#[path = "../../crates/glanz-geometry/benches/freeform/models.rs"]
mod models;
#[path = "../../crates/glanz-geometry/benches/streams/processor_time.rs"]
mod processor_time;
#[path = "../../crates/glanz-geometry/benches/streams/ray_sets.rs"]
mod ray_sets;
mod tessellate;

use std::fmt::Write as _;
use std::fs::{File, read, read_to_string};
use std::hint::black_box;
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::time::Instant;

use camera_rays::{camera_rays, shuffled};
use glanz_geometry::freeform::SurfacePatch;
use glanz_geometry::{BoundedRay, RaySurface, Surface};
use glanz_math::Ray;
use models::{Failure, Model, NAMES, Source, holes};
use processor_time::processor_time;
use ray_sets::{random_lines, tiles};
use tessellate::{Cells, Deviation, Mesh, deviation, fewest_cells, tessellate};

/// Bounds on the tessellation: distance from the surface relative to the diagonal of its box, angle of the normal in degrees.
const CHORD: f64 = 1e-4;
const NORMAL: f64 = 0.1;

/// Default size of the picture, pixels.
const PICTURE: [u32; 2] = [1920, 1080];

/// Smallest total time of repeated short work: the kernel counts in ticks of some milliseconds.
const SHORTEST: u64 = 100_000_000;

fn write_mesh(folder: &Path, mesh: &Mesh) -> Result<(), Failure> {
    let mut file = BufWriter::new(File::create(folder.join("mesh"))?);
    file.write_all(&(mesh.positions.len() as u32).to_le_bytes())?;
    file.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for x in mesh.positions.as_flattened() {
        file.write_all(&x.to_le_bytes())?;
    }
    for i in mesh.triangles.as_flattened() {
        file.write_all(&i.to_le_bytes())?;
    }
    file.flush()?;
    let mut file = BufWriter::new(File::create(folder.join("normals"))?);
    for x in mesh.normals.as_flattened() {
        file.write_all(&x.to_le_bytes())?;
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

/// Processor time of `work`, seconds: the median of three means.
fn seconds(mut work: impl FnMut()) -> f64 {
    let mut means = [0.0; 3];
    for mean in &mut means {
        let (start, mut times) = (processor_time(), 0);
        while processor_time() - start < SHORTEST {
            work();
            times += 1;
        }
        *mean = 1e-9 * (processor_time() - start) as f64 / f64::from(times);
    }
    means.sort_by(f64::total_cmp);
    means[1]
}

fn closest(surface: &impl RaySurface, rays: &[Ray]) -> (u64, f64) {
    let hits = rays.iter().filter_map(|ray| surface.intersect(ray, f64::INFINITY));
    hits.fold((0, 0.0), |(hits, sum), hit| (hits + 1, sum + hit.t))
}

fn any(surface: &impl RaySurface, rays: &[Ray]) -> (u64, f64) {
    (rays.iter().filter(|ray| surface.occluded(ray, f64::INFINITY)).count() as u64, 0.0)
}

/// Number of rays of a batch.
const BATCH: usize = 4096;

fn closest_in_batches(surface: &Surface, rays: &[BoundedRay]) -> (u64, f64) {
    let mut hits = Vec::new();
    rays.chunks(BATCH).fold((0, 0.0), |sums, batch| {
        surface.closest_batch(batch, &mut hits);
        hits.iter().flatten().fold(sums, |(count, sum), hit| (count + 1, sum + hit.t))
    })
}

fn any_in_batches(surface: &Surface, rays: &[BoundedRay]) -> (u64, f64) {
    let mut occluded = Vec::new();
    let count = rays.chunks(BATCH).map(|batch| {
        surface.occluded_batch(batch, &mut occluded);
        occluded.iter().filter(|&&hit| hit).count() as u64
    });
    (count.sum(), 0.0)
}

/// All hits of all rays, instead of the number of rays that hit.
fn all(surface: &Surface, rays: &[Ray]) -> (u64, f64) {
    let mut hits = Vec::new();
    rays.iter().fold((0, 0.0), |(count, sum), ray| {
        hits.clear();
        surface.all_hits(ray, f64::INFINITY, &mut hits);
        (count + hits.len() as u64, sum + hits.iter().map(|hit| hit.t).sum::<f64>())
    })
}

/// Grey levels under a light at the camera, pixel by pixel: the cosine of normal and ray. All data of a hit that a renderer uses
/// is computed.
fn picture(surface: &Surface, set: &RaySet, grey: &mut Vec<f32>) -> (u64, f64) {
    let (mut hits, mut points, mut sums) = (Vec::new(), Vec::new(), (0, 0.0));
    let (mut met, mut found, mut places) = (Vec::new(), Vec::new(), Vec::new());
    grey.clear();
    grey.resize(set.rays.len(), 0.0);
    for (batch, pixels) in set.bounded.chunks(BATCH).zip(set.pixels.chunks(BATCH)) {
        surface.closest_batch(batch, &mut hits);
        met.clear();
        found.clear();
        places.clear();
        for ((bounded, hit), &pixel) in batch.iter().zip(&hits).zip(pixels) {
            if let Some(hit) = hit {
                met.push(bounded.ray);
                found.push(*hit);
                places.push(pixel);
            }
        }
        surface.point_batch(&met, &found, &mut points);
        for ((ray, point), &pixel) in met.iter().zip(&points).zip(&places) {
            let level = point.normal.dot(ray.direction).abs() as f32;
            grey[pixel as usize] = level;
            sums = (sums.0 + 1, sums.1 + f64::from(level));
        }
    }
    sums
}

/// A set of rays, also as a batch takes them.
struct RaySet {
    name: &'static str,
    rays: Vec<Ray>,
    bounded: Vec<BoundedRay>,
    /// The pixels that the rays belong to.
    pixels: Vec<u32>,
}

fn answer(surface: &Surface, set: &RaySet, query: &str, grey: &mut Vec<f32>) -> Result<(u64, f64), Failure> {
    let RaySet { rays, bounded, .. } = set;
    // A scene also branches on the kind of its objects: one test per ray.
    Ok(match (query, surface) {
        ("closest", Surface::Freeform(freeform)) => closest(&**freeform, rays),
        ("any", Surface::Freeform(freeform)) => any(&**freeform, rays),
        ("closest", _) => closest(surface, rays),
        ("any", _) => any(surface, rays),
        ("closest_batch", _) => closest_in_batches(surface, bounded),
        ("any_batch", _) => any_in_batches(surface, bounded),
        ("all", _) => all(surface, rays),
        ("picture", _) => picture(surface, set, grey),
        _ => return Err("no such query".into()),
    })
}

/// Differences of the ray parameters of the other side from those of the surface, as JSON.
fn compare(surface: &Surface, rays: &[Ray], size: f64, dump: &Path) -> Result<String, Failure> {
    let bytes = read(dump)?;
    let theirs = bytes.chunks_exact(4).map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])));
    let (mut both, mut only_glanz, mut only_other, mut apart, mut most) = (0, 0, 0, 0, 0.0_f64);
    // At grazing angles a small distance from the surface is a large one along the ray.
    let mut most_facing = 0.0_f64;
    for (ray, t) in rays.iter().zip(theirs) {
        match (surface.intersect(ray, f64::INFINITY), t >= 0.0) {
            (Some(hit), true) => {
                both += 1;
                let difference = (hit.t - t).abs() / size;
                if difference > 0.01 {
                    apart += 1;
                } else {
                    most = most.max(difference);
                    if surface.point(ray, &hit).normal.dot(ray.direction).abs() > 0.2 {
                        most_facing = most_facing.max(difference);
                    }
                }
            }
            (Some(_), false) => only_glanz += 1,
            (None, true) => only_other += 1,
            (None, false) => {}
        }
    }
    Ok(format!(
        "{{\"both_hit\": {both}, \"only_glanz\": {only_glanz}, \"only_other\": {only_other}, \"other_sheet\": {apart}, \
         \"largest_difference_of_t\": {most:e}, \"where_seen_above_12_degrees\": {most_facing:e}}}"
    ))
}

/// Sizes and build times of both sides, as JSON without its last brace.
fn about(model: &Model, surface: &Surface, mesh: &Mesh, cells: &[Cells]) -> Result<String, Failure> {
    let Surface::Freeform(freeform) = surface else { return Err("not a freeform surface".into()) };
    let pieces: Vec<_> = freeform.patches().collect();
    let deviations =
        pieces.iter().zip(cells).map(|(p, &cells)| deviation(p.patch(), cells, 5, usize::MAX, |_| false));
    let worst = deviations.fold(Deviation::default(), Deviation::max);
    let size = surface.bounds().diagonal().length();
    let extract = seconds(|| {
        let _ = black_box(model.source.pieces());
    });
    let build = seconds(|| {
        let _ = black_box(model.surface());
    });
    let stand_in = seconds(|| {
        black_box(tessellate(&pieces, cells, model.region.as_deref()));
    });
    let cpu = read_to_string("/proc/cpuinfo").unwrap_or_default();
    let cpu = cpu.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or(": unknown");
    let mut text = String::new();
    write!(text, "{{\"patches\": {}, \"leaves\": {}, ", pieces.len(), freeform.statistics().primitives)?;
    write!(
        text,
        "\"build_s\": {build}, \"of_which_patches_s\": {extract}, \"bytes\": {}, ",
        freeform.bytes()
    )?;
    write!(text, "\"triangles\": {}, \"vertices\": {}, ", mesh.triangles.len(), mesh.positions.len())?;
    write!(text, "\"tessellate_s\": {}, \"chord_of_size\": {:e}, ", extract + stand_in, worst.chord / size)?;
    write!(text, "\"normal_degrees\": {:.4}, \"facet_normal_degrees\": {:.4}, ", worst.normal, worst.facet)?;
    write!(text, "\"size\": {size}, \"processor\": \"{}\"", cpu.trim_start_matches(['\t', ' ', ':']))?;
    Ok(text)
}

fn cells_of(pieces: &[SurfacePatch], size: f64) -> Vec<Cells> {
    let bounds = Deviation { chord: CHORD * size, normal: NORMAL, facet: f64::INFINITY };
    pieces.iter().map(|piece| fewest_cells(piece.patch(), &bounds)).collect()
}

/// The control points of a spline surface and its holes as JSON, for other programs.
fn write_spline(path: &Path, model: &Model) -> Result<(), Failure> {
    let Source::Spline(spline) = &model.source else { return Ok(()) };
    let mut file = BufWriter::new(File::create(path)?);
    for (name, knots) in [("u", spline.knots_u()), ("v", spline.knots_v())] {
        let sign = if name == "u" { '{' } else { ',' };
        writeln!(
            file,
            "{sign} \"degree_{name}\": {}, \"knots_{name}\": {:?}",
            knots.degree(),
            knots.knots()
        )?;
    }
    let points: Vec<[f64; 4]> = spline.control_points().iter().map(|p| p.to_array()).collect();
    let holes = model.region.iter().flat_map(|_| holes());
    let holes: Vec<[f64; 3]> = holes.map(|(center, radius)| [center.x, center.y, radius]).collect();
    writeln!(file, ", \"points\": {points:?}, \"holes\": {holes:?}}}")?;
    Ok(file.flush()?)
}

fn write_picture(path: &Path, size: [u32; 2], grey: &[f32]) -> Result<(), Failure> {
    let bytes: Vec<u8> = grey.iter().map(|x| (255.0 * x).round() as u8).collect();
    let mut file = File::create(path)?;
    writeln!(file, "P5 {} {} 255", size[0], size[1])?;
    Ok(file.write_all(&bytes)?)
}

/// Runs everything on one thread, so that its time is the processor time.
fn main() -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| run().map_err(|error| error.to_string()))?;
    Ok(())
}

fn run() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let mut out = std::io::stdout();
    let (Some(folder), Some(name)) = (arguments.next(), arguments.next()) else {
        writeln!(out, "{}", NAMES.join("\n"))?;
        return Ok(());
    };
    let pixels = match (arguments.next(), arguments.next()) {
        (Some(width), Some(height)) => [width.parse()?, height.parse()?],
        _ => PICTURE,
    };
    let folder = Path::new(&folder);
    let model = Model::named(&name)?;
    let surface = model.surface()?;
    let size = surface.bounds().diagonal().length();
    let pieces = model.source.pieces()?;
    let cells = cells_of(&pieces, size);
    let mesh = tessellate(&pieces, &cells, model.region.as_deref());
    write_mesh(folder, &mesh)?;
    write_spline(&folder.join("spline.json"), &model)?;
    let coherent = camera_rays(&surface.bounds(), pixels[0], pixels[1]);
    let lines = random_lines(&surface.bounds(), coherent.len());
    let sets = [
        ("shuffled", shuffled(coherent.clone())),
        ("tiles", tiles(&coherent, pixels.map(|n| n as usize))),
        ("lines", lines),
        ("coherent", coherent),
    ];
    let in_lines: Vec<u32> = (0..pixels[0] * pixels[1]).collect();
    let with_ends = |(name, rays): (&'static str, Vec<Ray>)| {
        let bounded = rays.iter().map(|&ray| ray.into()).collect();
        let size = pixels.map(|n| n as usize);
        let pixels = match name {
            "tiles" => tiles(&in_lines, size),
            "shuffled" => shuffled(in_lines.clone()),
            _ => in_lines.clone(),
        };
        RaySet { name, rays, bounded, pixels }
    };
    let sets = sets.map(with_ends);
    for set in &sets {
        write_rays(&folder.join(set.name), &set.rays)?;
    }
    writeln!(out, "{}}}", about(&model, &surface, &mesh, &cells)?)?;
    let mut grey = Vec::new();
    for line in std::io::stdin().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let [set, query, times] = words[..] else { return Err("expected SET QUERY TIMES".into()) };
        let set = sets.iter().find(|known| known.name == set).ok_or("no such set of rays")?;
        let rays = &set.rays;
        if query == "compare" {
            let undecided = if let Surface::Freeform(freeform) = &surface { freeform.undecided() } else { 0 };
            let text = compare(&surface, rays, size, &folder.join("t"))?;
            writeln!(out, "{}, \"undecided\": {undecided}}}", text.trim_end_matches('}'))?;
        } else {
            let (clock, before) = (Instant::now(), processor_time());
            let times = times.parse::<usize>()?;
            let (mut hits, mut sum) = (0, 0.0);
            for _ in 0..times {
                (hits, sum) = answer(&surface, set, query, &mut grey)?;
            }
            let processor = processor_time() - before;
            writeln!(out, "{} {processor} {} {hits} {sum}", clock.elapsed().as_nanos(), times * rays.len())?;
            if query == "picture" {
                write_picture(&folder.join("glanz.pgm"), pixels, &grey)?;
            }
        }
        out.flush()?;
    }
    Ok(())
}
