//! The cost of the hardest rays of sixty pathological surfaces, relative to the median of an ordinary bicubic patch and to that of chords of
//! the surface itself. The second median shows the usual cost for high degrees and many sheets.
//!
//! The number of cells is bounded by the test; times depend on what else the machine does, and are printed: `cargo xtask zoo` shows the
//! table. `GLANZ_ZOO_SHOW` prints undecided rays.

use std::time::Instant;

use glanz_geometry::RaySurface;
use glanz_math::Ray;
use glanz_math::glam::DVec4;

use super::number;
use super::pathologies;
use super::rays::{Random, RayFamily};
use super::test_surface::TestSurface;

/// Families of rays that are traced, besides asymptotic ones and those through singular points.
const FAMILIES: [RayFamily; 10] = [
    RayFamily::Chord,
    RayFamily::Tangent,
    RayFamily::Isoline,
    RayFamily::Corner,
    RayFamily::Border,
    RayFamily::BorderTangent,
    RayFamily::ControlPoints,
    RayFamily::AxisParallel,
    RayFamily::TwoPoints,
    RayFamily::FromSurface,
];

/// The costliest ray of a surface.
#[derive(Default)]
struct HardestRay {
    seconds: f64,
    most_cells: u64,
    undecided: u64,
    rays: u64,
    what: String,
}

/// Smallest of a few measurements of the time for all hits of a ray, seconds.
fn seconds(tested: &TestSurface, ray: &Ray, times: usize) -> f64 {
    let mut hits = Vec::new();
    let measure = |_| {
        hits.clear();
        let start = Instant::now();
        tested.surface.all_hits(ray, f64::INFINITY, &mut hits);
        start.elapsed().as_secs_f64()
    };
    (0..times).map(measure).fold(f64::INFINITY, f64::min)
}

fn ordinary() -> TestSurface {
    TestSurface::tensor("ordinary", (3, 3), |x, y| {
        DVec4::new(x, y, 0.4 * (4.0 * x + 1.0).sin() * (3.0 * y).cos(), 1.0)
    })
}

/// Median time of a chord of the surface, seconds.
fn median(tested: &TestSurface) -> f64 {
    let mut random = Random::new(1);
    let mut times: Vec<f64> =
        (0..501).map(|_| seconds(tested, &RayFamily::Chord.ray(tested, &mut random), 5)).collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// A ray along an asymptotic direction at a random point, or along the direction of least curvature if there is none.
fn asymptotic(tested: &TestSurface, random: &mut Random) -> Ray {
    let patch = &tested.patches[random.below(tested.patches.len())];
    // Also at points and along lines where patches are special.
    let at = |random: &mut Random| {
        [0.0, 0.25, 0.5, 1.0, 0.3, random.unit(), random.unit(), random.unit()][random.below(8)]
    };
    let (u, v) = (at(random), at(random));
    let [s, su, sv] = patch.tangent(u, v);
    let h = 1.0 / 1024.0;
    let (u0, u1) = ((u - h).max(0.0), (u + h).min(1.0));
    let (v0, v1) = ((v - h).max(0.0), (v + h).min(1.0));
    let n = su.cross(sv).normalize_or_zero();
    let by_u = (patch.tangent(u1, v)[1] - patch.tangent(u0, v)[1]) / (u1 - u0);
    let by_v = (patch.tangent(u, v1)[2] - patch.tangent(u, v0)[2]) / (v1 - v0);
    let mixed = (patch.tangent(u, v1)[1] - patch.tangent(u, v0)[1]) / (v1 - v0);
    let [l, m, k] = [by_u, mixed, by_v].map(|d| d.dot(n));
    // l a^2 + 2 m a b + k b^2 = 0.
    let root = (m * m - l * k).max(0.0).sqrt() * if random.unit() < 0.5 { 1.0 } else { -1.0 };
    let direction = if l.abs() > k.abs() { su * (-m + root) / l + sv } else { su + sv * (-m + root) / k };
    let direction = direction.try_normalize().unwrap_or_else(|| random.direction());
    Ray::new(s - direction * (tested.size * random.between(2.0, 4.0)), direction)
}

fn hardest(tested: &TestSurface, count: u64) -> HardestRay {
    let mut hardest = HardestRay::default();
    for index in 0..count {
        let mut random = Random::new(index + (1 << 41));
        let family = FAMILIES.get((index % 11) as usize);
        let ray = match family {
            Some(family) => family.ray(tested, &mut random),
            None => asymptotic(tested, &mut random),
        };
        let (cells, undecided) = (tested.surface.subdivision_cells(), tested.surface.undecided());
        let first = seconds(tested, &ray, 1);
        let cells = tested.surface.subdivision_cells() - cells;
        let was_undecided = tested.surface.undecided() > undecided;
        hardest.rays += 1;
        hardest.undecided += u64::from(was_undecided);
        hardest.most_cells = hardest.most_cells.max(cells);
        if was_undecided && std::env::var_os("GLANZ_ZOO_SHOW").is_some() {
            println!("    undecided: {index} {family:?} {ray:?}");
        }
        if first > hardest.seconds {
            let time = seconds(tested, &ray, 4).min(first);
            if time > hardest.seconds {
                hardest.seconds = time;
                hardest.what = format!(
                    "{index} {} {cells} cells",
                    family.map_or("Asymptotic".to_owned(), |f| format!("{f:?}"))
                );
            }
        }
    }
    hardest
}

#[test]
fn hardest_rays_have_a_bounded_cost() {
    let count = number("GLANZ_ZOO_HARD", 110);
    // The medians of surfaces are only for the table, and take longer than the hard rays.
    let shows_medians = std::env::var_os("GLANZ_ZOO_HARD").is_some();
    let mut surfaces = pathologies::all();
    assert_eq!(surfaces.len(), 60);
    if let Ok(only) = std::env::var("GLANZ_ZOO_ONLY") {
        surfaces.retain(|(_, tested)| tested.name.contains(&only));
    }
    let of_ordinary = median(&ordinary());
    println!("median of an ordinary patch: {:.2} us", 1e6 * of_ordinary);
    println!(
        "kind         surface                                 leaves  cells slowest/median /own median undecided of rays"
    );
    let (mut cells, mut slowest, mut undecided) = (0, 0.0_f64, 0);
    for (kind, tested) in &surfaces {
        let hard = hardest(tested, count);
        let ratio = hard.seconds / of_ordinary;
        let own = if shows_medians { hard.seconds / median(tested) } else { f64::NAN };
        let leaves = tested.surface.statistics().leaves;
        println!(
            "{:13}{:38}{leaves:8}{:7}{ratio:15.0}{own:12.0}{:10}{:8}  {}",
            format!("{kind:?}"),
            tested.name,
            hard.most_cells,
            hard.undecided,
            hard.rays,
            hard.what
        );
        cells = cells.max(hard.most_cells);
        slowest = slowest.max(ratio);
        undecided += hard.undecided;
    }
    println!("most cells {cells}, slowest {slowest:.0}, undecided {undecided}");
    assert_eq!(undecided, 0);
    assert!(cells <= MOST_CELLS, "{cells} cells");
}

/// Largest number of cells of a ray: twice that of the hardest of 330 rays.
const MOST_CELLS: u64 = 700;
