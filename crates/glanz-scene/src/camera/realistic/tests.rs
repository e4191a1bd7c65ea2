use std::f64::consts::PI;

use glanz_math::DVec3;
use glanz_sampling::hash::{combine, unit_f64};

use super::interface::{interfaces, moved, trace};
use super::*;
use crate::description::{IrisDescription, LensInterfaceDescription, StopShape};

fn row(curvature_radius: f64, thickness: f64, eta: f64, diameter: f64) -> LensInterfaceDescription {
    LensInterfaceDescription { curvature_radius, thickness, eta, diameter }
}

fn lens(interfaces: Vec<LensInterfaceDescription>, focus_distance: f64) -> LensDescription {
    LensDescription {
        interfaces,
        aperture_diameter: 1.0,
        focus_distance,
        stop: StopShape::Iris(IrisDescription::default()),
        relative_weights: false,
    }
}

/// A lens convex to the scene and almost plane to the film: 50 mm radius, index 1.5, so that f = R / (n - 1) = 100 mm.
fn plano_convex(diameter: f64) -> Vec<LensInterfaceDescription> {
    vec![row(0.05, 0.004, 1.5, diameter), row(1e9, 0.1, 1.0, diameter)]
}

/// A double Gauss, as in the literature: @kolb1995 figure 1 in proportion, for film of 35 mm, f = 50 mm.
fn double_gauss() -> Vec<LensInterfaceDescription> {
    [
        [29.475, 3.76, 1.67, 25.2],
        [84.83, 0.12, 1.0, 25.2],
        [19.275, 4.025, 1.67, 23.0],
        [40.77, 3.275, 1.699, 23.0],
        [12.75, 5.705, 1.0, 18.0],
        [0.0, 4.5, 0.0, 17.1],
        [-14.495, 1.18, 1.603, 17.0],
        [40.77, 6.065, 1.658, 20.0],
        [-20.385, 0.19, 1.0, 20.0],
        [437.065, 3.22, 1.717, 20.0],
        [-39.73, 0.0, 1.0, 20.0],
    ]
    .map(|[r, t, n, d]| row(1e-3 * r, 1e-3 * t, n, 1e-3 * d))
    .to_vec()
}

fn xi(i: u64) -> DVec2 {
    DVec2::new(unit_f64(combine(31, i)), unit_f64(combine(32, i)))
}

#[test]
fn focal_length_is_that_of_the_lens_makers_equation() {
    // 1/f = (n - 1) (1/R1 - 1/R2 + (n - 1) t / (n R1 R2)) for thick lenses in air.
    for (r1, r2, n, t) in [(0.05, 1e9, 1.5, 0.004), (0.06, -0.09, 1.62, 0.02), (-0.2, -0.05, 1.5, 0.01)] {
        let described = lens(vec![row(r1, t, n, 0.01), row(r2, 0.0, 1.0, 0.01)], 1.0);
        let thick = ThickLens::try_new(&interfaces(&described).unwrap()).unwrap();
        let maker: f64 = (n - 1.0) * (1.0 / r1 - 1.0 / r2 + (n - 1.0) * t / (n * r1 * r2));
        assert!((thick.focal_length * maker - 1.0).abs() < 1e-12);
        // The principal plane of the film is f (n - 1) t / (n R1) before the last vertex.
        let plane = -(n - 1.0) * t / (n * r1 * maker);
        assert!((thick.rear_plane - plane).abs() < 1e-12, "{thick:?} {plane}");
    }
}

#[test]
fn rays_of_a_film_point_meet_at_the_distance_in_focus() {
    for (parts, focus) in [(plano_convex(0.002), 3.0), (double_gauss(), 1.5)] {
        let mut described = lens(parts, focus);
        // Rays near the axis, for which the paraxial focus holds up to the aberrations.
        described.aperture_diameter = 5e-4;
        described.interfaces.iter_mut().for_each(|row| row.diameter = row.diameter.max(0.004));
        let lens = RealisticLens::try_new(&described, 0.035).unwrap();
        let mut found = 0;
        for i in 0..4000 {
            let Some((ray, _)) = lens.ray(DVec2::ZERO, DVec2::ZERO, xi(i)) else { continue };
            let slope = ray.direction.truncate().length() / ray.direction.z;
            if slope < 1e-5 {
                continue;
            }
            let height = ray.origin.truncate().length();
            assert!(height < 0.0021);
            let distance = ray.origin.z
                - ray.origin.truncate().dot(ray.direction.truncate())
                    / (ray.direction.truncate().length_squared() / ray.direction.z);
            assert!((distance / focus - 1.0).abs() < 2e-2, "{distance} {focus} {height}");
            found += 1;
        }
        assert!(found > 100, "{found}");
    }
}

#[test]
fn picture_of_a_far_point_is_at_the_focal_length_times_its_angle() {
    // f tan(angle), upside down: what the screen shows above comes from above.
    let described = lens(plano_convex(0.002), 1e6);
    let lens = RealisticLens::try_new(&described, 0.035).unwrap();
    let screen = DVec2::new(0.002, -0.003);
    let (mut sum, mut count) = (DVec2::ZERO, 0);
    for i in 0..4000 {
        if let Some((ray, _)) = lens.ray(screen, screen, xi(i)) {
            sum += ray.direction.truncate() / ray.direction.z;
            count += 1;
        }
    }
    let slope = sum / f64::from(count);
    assert!((slope - screen / 0.1).length() < 1e-4, "{slope}");
}

#[test]
fn irradiance_through_a_small_stop_is_that_of_its_picture() {
    // A stop alone, of radius a at the distance d: E = pi L a^2 / (a^2 + d^2) on the axis; the weights are the estimate of E for L = 1.
    let (a, d) = (0.002_f64, 0.05_f64);
    let parts = vec![row(0.0, d, 0.0, 2.0 * a)];
    let described = lens(parts, 1.0);
    let stop = moved(interfaces(&described).unwrap(), d);
    let exact = PI * a * a / (a * a + d * d);
    for shape in [
        StopShape::Iris(IrisDescription::default()),
        StopShape::Iris(IrisDescription { blades: 6, rotation: 0.2 }),
        StopShape::Gaussian,
        StopShape::Square,
        StopShape::Pentagon,
        StopShape::Star,
    ] {
        let pupil = ExitPupil::new(&stop, 0.02);
        let lens = RealisticLens {
            interfaces: stop.clone().into(),
            stop: LensStop::new(shape),
            pupil,
            relative_weights: false,
        };
        for screen in [DVec2::ZERO, DVec2::new(0.006, 0.008)] {
            let n = 200_000;
            let weights = (0..n).map(|i| lens.ray(screen, screen, xi(i)).map_or(0.0, |(_, weight)| weight));
            let (sum, squares) = weights.fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
            let mean = sum / n as f64;
            let error = ((squares / n as f64 - mean * mean) / n as f64).sqrt();
            // Off the axis by the fourth power of the cosine; the stop is small: relative deviations of a^2 / d^2 = 0.16 % from both.
            let cos2 = d * d / (d * d + screen.length_squared());
            let exact = exact * cos2 * cos2;
            assert!((mean - exact).abs() < 4.0 * error + 2e-3 * exact, "{shape:?} {mean} {exact} {error}");
        }
    }
}

#[test]
fn sampling_the_exit_pupil_has_the_mean_of_sampling_the_last_lens() {
    let mut described = lens(double_gauss(), 2.0);
    described.aperture_diameter = 0.01;
    for stop in [StopShape::Iris(IrisDescription::default()), StopShape::Star] {
        described.stop = stop;
        let lens = RealisticLens::try_new(&described, 0.0433).unwrap();
        // Filters of pixels reach beyond the corners of the small film.
        let small = RealisticLens::try_new(&described, 0.01).unwrap();
        for (lens, x, y) in [
            (&lens, 0.0, 0.0),
            (&lens, 0.009, 0.0),
            (&lens, -0.008, 0.01),
            (&lens, 0.015, -0.0105),
            (&small, 0.008, -0.006),
        ] {
            let plane = lens.pupil.plane;
            let screen = DVec2::new(x, y);
            let n = 100_000;
            let estimate = |weight: &dyn Fn(DVec2) -> f64| {
                let (sum, squares) =
                    (0..n).map(|i| weight(xi(i))).fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
                let mean = sum / n as f64;
                (mean, (squares / n as f64 - mean * mean) / n as f64)
            };
            let (mean, variance) =
                estimate(&|xi| lens.ray(screen, screen, xi).map_or(0.0, |(_, weight)| weight));
            let reach = 2.0 * 0.01;
            let (all, all_variance) = estimate(&|xi| {
                let target = (reach * (2.0 * xi - 1.0)).extend(plane);
                let start = (-screen).extend(0.0);
                let ray = Ray::new(start, (target - start).normalize());
                let passed = trace(&lens.interfaces, &lens.stop, ray).map_or(0.0, |(_, t)| t);
                passed * ray.direction.z.powi(4) * 4.0 * reach * reach / (plane * plane)
            });
            assert!(mean > 0.0);
            let error = (variance + all_variance).sqrt();
            assert!((mean - all).abs() < 4.0 * error, "{screen} {mean} {all} {error}");
            assert!(variance < all_variance, "{screen}");
        }
    }
}

#[test]
fn relative_weights_are_those_of_the_square_around_the_exit_pupil() {
    // The pupil is a disk as seen from the middle of the film: pi / 4 of the square, whatever its size.
    for aperture_diameter in [0.001, 0.003, 0.006] {
        let described =
            LensDescription { aperture_diameter, relative_weights: true, ..lens(double_gauss(), 2.0) };
        let lens = RealisticLens::try_new(&described, 0.0433).unwrap();
        let n = 100_000;
        let weights =
            (0..n).map(|i| lens.ray(DVec2::ZERO, DVec2::ZERO, xi(i)).map_or(0.0, |(_, weight)| weight));
        let (sum, squares) = weights.fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
        let mean = sum / n as f64;
        let error = ((squares / n as f64 - mean * mean) / n as f64).sqrt();
        // The mean fourth power of the cosine within a cone of slope s is 1 / (1 + s^2), above 0.99 at f / 5.
        assert!((mean / (0.25 * PI) - 1.0).abs() < 4.0 * error + 0.02, "{aperture_diameter} {mean} {error}");
    }
}

#[test]
fn shapes_of_stops_have_the_light_of_a_disk() {
    let n = 1000;
    for shape in [
        StopShape::Iris(IrisDescription { blades: 3, rotation: 1.0 }),
        StopShape::Gaussian,
        StopShape::Square,
        StopShape::Pentagon,
        StopShape::Star,
    ] {
        let stop = LensStop::new(shape);
        let cell = 2.0 / f64::from(n);
        let place = |i: i32| (f64::from(i) + 0.5) * cell - 1.0;
        let sum: f64 =
            (0..n * n).map(|i| stop.transmittance(DVec2::new(place(i % n), place(i / n)))).sum::<f64>();
        assert!((sum * cell * cell / PI - 1.0).abs() < 2e-3, "{shape:?} {}", sum * cell * cell);
    }
    // The pentagon points down, the square has half the width of the disk.
    let is_open = |shape, x, y| LensStop::new(shape).transmittance(DVec2::new(x, y)) > 0.0;
    assert!(is_open(StopShape::Pentagon, 0.0, -0.79) && !is_open(StopShape::Pentagon, 0.0, 0.7));
    assert!(is_open(StopShape::Square, 0.49, -0.49) && !is_open(StopShape::Square, 0.51, 0.0));
    assert!(is_open(StopShape::Star, -0.95, 0.0) && !is_open(StopShape::Star, 0.5, 0.0));
}

#[test]
fn rays_are_refracted_by_the_law_of_snell_and_run_backwards() {
    let interfaces = interfaces(&lens(double_gauss(), 1.0)).unwrap();
    let interfaces = moved(interfaces, 0.03);
    let ray = Ray::new(DVec3::new(0.004, -0.002, 0.0), DVec3::new(-0.05, 0.03, 1.0).normalize());
    // Interface by interface: sines to the normal are in the ratio of the indices.
    for interface in interfaces.iter().filter(|interface| interface.curvature_radius.is_some()) {
        let (out, _) = trace(std::slice::from_ref(interface), &LensStop::DISK, ray).unwrap();
        let radius = interface.curvature_radius.unwrap();
        let normal = (out.origin - DVec3::new(0.0, 0.0, interface.z - radius)) / radius;
        assert!((normal.length() - 1.0).abs() < 1e-9);
        let sines = [ray.direction, out.direction].map(|d| d.cross(normal).length());
        assert!((sines[0] * interface.eta_film - sines[1] * interface.eta_scene).abs() < 1e-9);
    }
}

#[test]
fn lenses_that_cannot_be_focused_are_refused() {
    let error = |described: &LensDescription| RealisticLens::try_new(described, 0.035).unwrap_err().0;
    assert_eq!(error(&lens(Vec::new(), 1.0)), "focal length of the lens");
    let diverging = vec![row(-0.05, 0.004, 1.5, 0.01), row(1e9, 0.1, 1.0, 0.01)];
    assert_eq!(error(&lens(diverging, 1.0)), "focal length of the lens");
    // Nearer than 4 f = 400 mm.
    assert_eq!(error(&lens(plano_convex(0.01), 0.39)), "focus distance of the lens");
    assert_eq!(error(&lens(plano_convex(-0.01), 1.0)), "diameter of a lens or stop");
    assert_eq!(error(&lens(vec![row(0.0, 0.001, 1.0, 0.01); 257], 1.0)), "number of surfaces of a lens");
    let mut round = lens(plano_convex(0.01), 1.0);
    round.stop = StopShape::Iris(IrisDescription { blades: 1 << 30, rotation: 0.0 });
    assert_eq!(error(&round), "number of blades");
    round.stop = StopShape::Iris(IrisDescription { blades: 5, rotation: f64::NAN });
    assert_eq!(error(&round), "rotation of the blades");
    assert_eq!(error(&lens(vec![row(f64::NAN, 0.0, 1.0, 1.0)], 1.0)), "curvature radius of a lens");
}
