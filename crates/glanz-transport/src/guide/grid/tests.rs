//! Tests of densities fitted to known light, and of their files.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::Ray;
use glanz_sampling::hash::{combine, unit_f64};
use glanz_sampling::statistics::chi_square;
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;
use proptest::prelude::*;

use super::*;
use crate::codec::{CRC_LENGTH, Decoder, Encoder, PREFIX_LENGTH, resealed};
use crate::guide::{Guide, Training, decode_training, encode_training};

fn settings(text: &str) -> GridSettings {
    match text.parse() {
        Ok(GuideSettings::Grid(settings)) => settings,
        other => panic!("{text}: {other:?}"),
    }
}

/// A sphere of 1 m around the origin, a cylinder around x = 5 m, and a mesh of two triangles at x = 9 m, 2 m by 4 m.
fn scene() -> Scene {
    let wall = [[0.0, 0.0], [2.0, 0.0], [2.0, 4.0], [0.0, 4.0]].map(|[y, z]| DVec3::new(9.0, y, z));
    let shapes = [
        ShapeDescription::sphere(1.0),
        ShapeDescription::cylinder(1.0, [0.0, 2.0]).translated([5.0, 0.0, 0.0]),
        ShapeDescription::mesh(wall.to_vec(), vec![[0, 1, 2], [0, 2, 3]]),
    ];
    SceneBuilder::new().shapes(shapes, MaterialKind::diffuse(1.0)).resolve().unwrap().0
}

/// Guide data at the hit of a ray.
fn place(guide: &GridGuide, scene: &Scene, from: [f64; 3], to: [f64; 3]) -> GridVertex {
    let (from, to) = (DVec3::from(from), DVec3::from(to));
    let hit = scene.intersect(&Ray::new(from, (to - from).normalize()), f64::INFINITY).unwrap();
    guide.place(&hit, hit.point.shading_normal * hit.point.shading_normal.dot(hit.wo).signum()).unwrap()
}

fn xi(seed: u64, i: u64) -> DVec2 {
    DVec2::new(unit_f64(combine(seed, 2 * i)), unit_f64(combine(seed, 2 * i + 1)))
}

/// Trains with `count` directions of `guide` at `place` under incident light `light` of the local direction.
fn trained(
    guide: &GridGuide,
    sums: &GridSums,
    place: &GridVertex,
    count: u64,
    light: impl Fn(DVec3) -> f64,
) -> (GridGuide, GridSums) {
    for i in 0..count {
        let draw = guide.sample(place, xi(17, i));
        let local = place.frame.to_local(draw.direction);
        let record = GridRecord {
            cell: place.cell,
            function: draw.function,
            cosine: local.z,
            light: Spectrum::BLACK,
            beyond: Spectrum::ONE,
            is_dispersed: false,
            left_out: Some(Spectrum::BLACK),
        };
        sums.add(&record, Spectrum::splat(light(local) as f32), &Wavelengths::default(), 1.0);
    }
    guide.fitted(sums, 1.0)
}

#[test]
fn map_of_the_hemisphere_is_invertible() {
    for i in 0..1000 {
        let square = xi(3, i).to_array();
        let direction = to_hemisphere(square);
        assert!((direction.length() - 1.0).abs() < 1e-14);
        // The middle of the square's side x = 0 is the normal, where phi is undefined.
        let back = to_square(direction);
        assert!(
            (back[0] - square[0]).abs() < 1e-14 && (back[1] - square[1]).abs() * square[0].sqrt() < 1e-14
        );
    }
    assert_eq!(to_hemisphere([0.0, 0.3]), DVec3::Z);
    assert_eq!(to_square(DVec3::X), [1.0, 0.0]);
    // Just below the seam.
    assert!(to_square(DVec3::new(1.0, -1e-300, 0.0))[1] < 1.0);
}

#[test]
fn cells_end_at_seams_and_sides() {
    let (scene, n) = (scene(), 8);
    let guide = GridGuide::new(&scene, &settings("grid=8,scale=0")).unwrap();
    assert_eq!(guide.size().cells, (2 + 2 + 6) * 64);
    let cell = |from, to| place(&guide, &scene, from, to).cell;
    // The parameters of the sphere start at +x and increase towards +y; the column is u, the row v.
    let sphere = |y: f64, z: f64| cell([3.0, y, z], [0.0, y, z]);
    assert_eq!(sphere(-0.01, 0.01) - sphere(0.01, 0.01), (n - 1) * n);
    assert_eq!(sphere(0.01, -0.01).abs_diff(sphere(0.01, 0.01)), 1);
    assert_eq!(cell([0.1, 0.01, 0.01], [3.0, 0.01, 0.01]), sphere(0.01, 0.01) + n * n);
    // The cylinder has the next numbers; v is the height, 2 m.
    let cylinder = |y: f64, z: f64| cell([9.0, y, z], [5.0, y, z]) - 2 * n * n;
    assert_eq!(cylinder(-0.01, 0.01), (n - 1) * n);
    assert_eq!((cylinder(0.01, 0.01), cylinder(0.01, 1.99)), (0, n - 1));
    // Both triangles of the wall are seen from +x, the first sheet, whose cells are numbered by y and z.
    let wall = |y: f64, z: f64| cell([12.0, y, z], [9.0, y, z]) - 4 * n * n;
    assert_eq!([wall(0.01, 0.01), wall(1.99, 0.01), wall(0.01, 3.99)], [0, (n - 1) * n, n - 1]);
    assert_eq!(wall(1.0 - 1e-9, 2.0 + 1e-9), 3 * n + 4);
    // Points on the border belong inside.
    assert_eq!(cell_of(n, 0, DVec2::ONE), n * n - 1);
    assert_eq!(cell_of(n, 1, DVec2::ZERO), n * n);
}

#[test]
fn box_functions_are_fitted_to_the_means_of_light_times_cosine() {
    // Constant light: the cosine is 1 - x, with means 7/8, 5/8, 3/8 and 1/8 over four intervals, divided by the mean 1/2. The second
    // pass samples the density of the first and must give the same, because nothing is divided by the density.
    let scene = scene();
    let mut guide = GridGuide::new(&scene, &settings("grid=2,basis=haar,scale=2")).unwrap();
    let mut sums = guide.sums();
    let at = place(&guide, &scene, [3.0, 0.1, 0.1], [0.0, 0.1, 0.1]);
    for _ in 0..2 {
        (guide, sums) = trained(&guide, &sums, &at, 100_000, |_| 3.0);
        for (i, expected) in [1.75, 1.25, 0.75, 0.25].into_iter().enumerate() {
            let direction = at.frame.to_world(to_hemisphere([(i as f64 + 0.4) / 4.0, 0.3]));
            let found = TAU * guide.pdf(&at, direction);
            assert!((found - expected).abs() < 0.01, "{i}: {found}, not {expected}");
        }
    }
    assert_eq!((sums.records(), guide.size().active), (200_000, 1));
    // Other cells are untrained: constant.
    let other = place(&guide, &scene, [-3.0, -0.1, 0.1], [0.0, -0.1, 0.1]);
    let along = other.frame.to_world(to_hemisphere([0.7, 0.2]));
    assert!((TAU * guide.pdf(&other, along) - 1.0).abs() < 1e-12);
    assert_eq!(guide.pdf(&other, -other.frame.z), 0.0);
}

#[test]
fn hat_functions_are_fitted_to_a_line_and_raised_where_it_vanishes() {
    // 1 - x divided by its integral is 2 (1 - x): coefficients 2 and 0 along x. With the lower bound of 0.1 they are 2 and 0.1, with the integral 1.05.
    let scene = scene();
    let guide = GridGuide::new(&scene, &settings("grid=1,basis=spline1,scale=0")).unwrap();
    let at = place(&guide, &scene, [3.0, 0.1, 0.1], [0.0, 0.1, 0.1]);
    let (guide, sums) = trained(&guide, &guide.sums(), &at, 400_000, |_| 3.0);
    let (guide, _) = trained(&guide, &sums, &at, 400_000, |_| 3.0);
    for x in [0.01, 0.3, 0.6, 0.99] {
        let expected = (2.0 * (1.0 - x) + 0.1 * x) / 1.05;
        for y in [0.1, 0.5, 0.9] {
            let found = TAU * guide.pdf(&at, at.frame.to_world(to_hemisphere([x, y])));
            assert!((found - expected).abs() < 0.02, "{x} {y}: {found}, not {expected}");
        }
    }
}

#[test]
fn samples_follow_the_density() {
    let scene = scene();
    for basis in ["haar", "spline0", "spline1", "spline2", "spline3"] {
        let guide = GridGuide::new(&scene, &settings(&format!("grid=3,basis={basis},scale=2"))).unwrap();
        let at = place(&guide, &scene, [9.0, 0.1, 0.6], [5.0, 0.1, 0.6]);
        // A bright spot in dim light.
        let light = |d: DVec3| if d.dot(DVec3::new(0.6, 0.5, 0.6)) > 0.85 { 9.0 } else { 0.5 };
        let (guide, _) = trained(&guide, &guide.sums(), &at, 50_000, light);
        assert_eq!(guide.size().active, 1);
        const SIDE: usize = 8;
        const COUNT: u64 = 200_000;
        let mut counts = vec![0_u64; SIDE * SIDE];
        for i in 0..COUNT {
            let draw = guide.sample(&at, xi(5, i));
            assert!((draw.pdf / guide.pdf(&at, draw.direction) - 1.0).abs() < 1e-9, "{basis}");
            let [x, y] = to_square(at.frame.to_local(draw.direction)).map(|x| (x * SIDE as f64) as usize);
            counts[x.min(SIDE - 1) * SIDE + y] += 1;
        }
        // The density is a polynomial of at most degree 3 per axis on a bin: 2 points of Gauss along each axis are exact.
        let nodes = [0.5 - 0.75_f64.sqrt() / 3.0, 0.5 + 0.75_f64.sqrt() / 3.0];
        let expected: Vec<f64> = (0..SIDE * SIDE)
            .map(|bin| {
                let corner = [bin / SIDE, bin % SIDE].map(|i| i as f64);
                let mut mass = 0.0;
                for x in nodes {
                    for y in nodes {
                        let square = [(corner[0] + x) / SIDE as f64, (corner[1] + y) / SIDE as f64];
                        mass += guide.pdf(&at, at.frame.to_world(to_hemisphere(square)));
                    }
                }
                COUNT as f64 * mass * TAU / 4.0 / (SIDE * SIDE) as f64
            })
            .collect();
        let total: f64 = expected.iter().sum();
        assert!((total / COUNT as f64 - 1.0).abs() < 1e-9, "{basis}: {total}");
        let p = chi_square(&counts, &expected).p_value;
        assert!(p > 1e-3, "{basis}: {p}");
    }
}

#[test]
fn hierarchical_densities_are_refined_by_pass_without_changing_the_function() {
    let scene = scene();
    let mut guide =
        GridGuide::new(&scene, &settings("grid=1,scale=2,hierarchical=on,basis=spline1")).unwrap();
    let mut sums = guide.sums();
    let at = place(&guide, &scene, [3.0, 0.1, 0.1], [0.0, 0.1, 0.1]);
    // (2^level + 1)^2 functions.
    for (pass, functions) in [4, 9, 25, 25].into_iter().enumerate() {
        assert_eq!(guide.basis().len(), functions, "pass {pass}");
        let coarse = guide.clone();
        (guide, sums) = trained(&guide, &sums, &at, 50_000, |_| 1.0);
        // On a new scale sums start anew; on the last one they continue.
        assert_eq!(sums.records(), if pass < 2 { 0 } else { 50_000 * (pass as u64 - 1) }, "pass {pass}");
        assert_ne!(coarse, guide);
    }
    // Without new light a finer scale does not change the function.
    let guide = GridGuide::new(&scene, &guide.settings()).unwrap();
    let (coarse, sums) = trained(&guide, &guide.sums(), &at, 50_000, |_| 1.0);
    let (fine, _) = coarse.fitted(&sums, 1.0);
    assert_eq!((coarse.basis().len(), fine.basis().len()), (9, 25));
    for i in 0..100 {
        let direction = at.frame.to_world(to_hemisphere(xi(8, i).to_array()));
        let (a, b) = (coarse.pdf(&at, direction), fine.pdf(&at, direction));
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn guides_that_may_need_too_much_memory_are_refused() {
    let scene = scene();
    let refused = GridGuide::new(&scene, &settings("grid=64,scale=6")).unwrap_err();
    let GridError::Memory { shapes: 3, bytes, .. } = refused else { panic!("{refused}") };
    // 10 sheets of 4096 cells with 4096 functions of 36 bytes.
    assert!((bytes as f64 / (10.0 * 4096.0 * 4096.0 * 36.0) - 1.0).abs() < 0.01, "{bytes}");
    assert!(refused.to_string().contains("5.6 GiB") && refused.to_string().contains("4 GiB"), "{refused}");
    assert!(GridGuide::new(&scene, &settings("grid=64,scale=5")).is_ok());
}

/// A guide in its third training pass.
fn example() -> Training {
    let scene = scene();
    let settings = settings("grid=2,basis=spline1,scale=1,hierarchical=on");
    let mut training = Training::new(Guide::new(&scene, &GuideSettings::Grid(settings)).unwrap());
    training.finish_pass(1.0);
    for brightness in [2.0, 1.5, 0.0] {
        if training.records() > 0 {
            training.finish_pass(brightness);
        }
        let Guide::Grid(grid) = training.guide().clone() else { panic!("it is a grid") };
        for (from, to) in [([3.0, 0.1, 0.1], [0.0, 0.1, 0.1]), ([12.0, 0.1, 0.1], [9.0, 0.1, 0.1])] {
            let at = place(&grid, &scene, from, to);
            let records: Vec<GridRecord> = (0..500)
                .map(|i| {
                    let draw = grid.sample(&at, xi(4, i));
                    GridRecord {
                        cell: at.cell,
                        function: draw.function,
                        cosine: at.cosine(draw.direction),
                        light: Spectrum::BLACK,
                        beyond: Spectrum::ONE,
                        is_dispersed: false,
                        left_out: Some(Spectrum::BLACK),
                    }
                })
                .collect();
            training.learn_on_grid(&records, Spectrum::splat(0.7), &Wavelengths::default());
        }
    }
    training
}

#[test]
fn written_guides_are_read_back() {
    let training = example();
    let guide = training.guide();
    assert_eq!((guide.size().active, training.records()), (2, 2000));
    assert_eq!(Guide::from_bytes(&guide.to_bytes()).as_ref(), Ok(guide));
    let mut e = Encoder::default();
    encode_training(&mut e, &training);
    assert_eq!(decode_training(&mut Decoder(&e.0)), Some(training));
    assert_eq!(decode_training(&mut Decoder(&e.0[..e.0.len() - 1])), None);
}

#[test]
fn sizes_beyond_the_file_are_refused_before_allocation() {
    let bytes = example().guide().to_bytes();
    let at = PREFIX_LENGTH + 1;
    let text = "grid=2,basis=spline1,scale=1,mixture=off,hierarchical=on";
    assert_eq!(&bytes[at + 1..at + 1 + text.len()], text.as_bytes());
    // 64 x 64 cells on each sheet, and shorter text elsewhere for the same length.
    let mut claims = bytes[..at].to_vec();
    let larger = text.replace("grid=2", "grid=64");
    claims.push(larger.len() as u8);
    claims.extend_from_slice(larger.as_bytes());
    claims.extend_from_slice(&bytes[at + 1 + text.len()..bytes.len() - CRC_LENGTH]);
    assert!(Guide::from_bytes(&resealed(claims)).is_err());
}

static EXAMPLE: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();

proptest! {
    #[test]
    fn arbitrary_bytes_neither_panic_nor_hang(
        changes in prop::collection::vec((PREFIX_LENGTH..300, any::<u8>()), 1..8), cut in 0_usize..100,
    ) {
        let mut bytes = EXAMPLE.get_or_init(|| example().guide().to_bytes()).clone();
        for (at, value) in changes {
            bytes[at] = value;
        }
        bytes.truncate(bytes.len() - CRC_LENGTH - cut);
        if let Ok(Guide::Grid(guide)) = Guide::from_bytes(&resealed(bytes)) {
            // Accepted guides can be used.
            let scene = scene();
            let ray = Ray::new(DVec3::new(12.0, 0.1, 0.1), -DVec3::X);
            let hit = scene.intersect(&ray, f64::INFINITY).unwrap();
            if let Some(place) = guide.place(&hit, DVec3::X) {
                let draw = guide.sample(&place, DVec2::new(0.2, 0.7));
                prop_assert!(guide.pdf(&place, draw.direction) >= 0.0);
            }
            let _ = guide.fitted(&guide.sums(), 1.0);
        }
    }
}
