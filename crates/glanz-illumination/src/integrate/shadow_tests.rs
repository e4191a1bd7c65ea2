//! Means over cells at the edges of shadows, compared with closed forms.

use glanz_math::DVec2;

use super::tests::*;
use super::*;

/// A cell of the plane z = 0, from `x[0]` to `x[1]` and of 2 m about the x axis.
fn cell(x: [f64; 2]) -> impl Fn(DVec2) -> Option<(DVec3, DVec3, f64)> {
    let width = x[1] - x[0];
    move |uv| Some((DVec3::new(x[0] + width * uv.x, 2.0 * uv.y - 1.0, 0.0), DVec3::Z, 2.0 * width))
}

/// The half plane x < 0 at z = 1, or the other one.
fn curtain(is_left: bool) -> NamedShape {
    (
        rectangle(if is_left { [-9.0, 0.0] } else { [0.0, 9.0] }, [-9.0, 9.0]).translated([0.0, 0.0, 1.0]),
        BLACK,
    )
}

#[test]
fn cells_at_the_edge_of_a_hard_shadow_have_the_flux_of_their_lit_part() {
    // The light is above the edge of the curtain: its shadow ends at x = 0. On a rectangle from the foot to (a, b), I atan(a b / (h sqrt(h^2 + a^2 + b^2))).
    let scene = scene_with(vec![curtain(true)], vec![lit_by_point()]);
    let tolerance = Tolerance { relative: 1e-3, absolute: 0.0 };
    let reflections = Reflections::new(&scene).unwrap();
    for [low, high] in [[-1.0, 1.0], [-0.3, 2.0], [-2.0, 0.1]] {
        let mean = reflections.cell_mean(cell([low, high]), tolerance, 100);
        let solid_angle = 2.0 * (high / (2.0 * (5.0 + high * high).sqrt())).atan();
        let expected = LUMINANCE * 2.0 * solid_angle / (2.0 * (high - low));
        close(mean.mean, expected, 1e-3, &format!("{low} to {high}"));
        assert!((mean.mean - expected).abs() <= mean.error && mean.error <= 1e-3 * mean.mean, "{mean:?}");
    }
}

#[test]
fn shadows_on_cells_at_the_rim_of_a_surface_have_the_mean_over_its_part() {
    // As before, on the part of the cell left of x = 0.1, of which Gauss' points know the area badly.
    let scene = scene_with(vec![curtain(true)], vec![lit_by_point()]);
    let (whole, tolerance) = (cell([-1.0, 1.0]), Tolerance { relative: 1e-3, absolute: 0.0 });
    let patch = |uv| whole(uv).filter(|(point, ..)| point.x < 0.1);
    let mean = Reflections::new(&scene).unwrap().cell_mean(patch, tolerance, 100);
    let solid_angle = 2.0 * (0.1_f64 / (2.0 * (5.0_f64 + 0.01).sqrt())).atan();
    let expected = LUMINANCE * 2.0 * solid_angle / (2.0 * 1.1);
    assert!(
        (mean.mean - expected).abs() <= mean.error && mean.error <= 1e-3 * mean.mean,
        "{mean:?} {expected}"
    );
}

#[test]
fn half_shadows_of_both_halves_of_a_plane_add_up_to_the_whole_light() {
    let lamps = [
        emitter(turned(rectangle([-0.3, 0.2], [-0.4, 0.4]), [0.0, 0.0, 2.0])),
        emitter(turned(disk(0.3), [0.05, 0.0, 2.0])),
        emitter(sphere(0.3).translated([0.05, 0.0, 2.0])),
    ];
    let tolerance = Tolerance { relative: 2e-3, absolute: 0.0 };
    for lamp in lamps {
        let means = |curtains: &[NamedShape], tolerance| {
            let scene = scene(curtains.iter().cloned().chain([lamp.clone()]).collect());
            Reflections::new(&scene).unwrap().cell_mean(cell([-0.2, 0.5]), tolerance, 1000)
        };
        let whole = means(&[], Tolerance { relative: 1e-5, absolute: 0.0 });
        let [left, right] = [true, false].map(|is_left| means(&[curtain(is_left)], tolerance));
        let (sum, bound) = (left.mean + right.mean, left.error + right.error + whole.error);
        assert!((sum - whole.mean).abs() <= bound, "{left:?} {right:?} {whole:?}");
        assert!(left.error <= 2e-3 * left.mean && right.error <= 2e-3 * right.mean, "{left:?} {right:?}");
        assert!(left.mean > 0.05 * whole.mean && right.mean > 0.05 * whole.mean, "{left:?} {right:?}");
    }
}

#[test]
fn mean_over_a_half_shadow_is_that_of_a_fine_grid() {
    let lamp = emitter(turned(rectangle([-0.3, 0.2], [-0.4, 0.4]), [0.0, 0.0, 2.0]));
    let scene = scene(vec![lamp, curtain(true)]);
    let reflections = Reflections::new(&scene).unwrap();
    let mean = reflections.cell_mean(cell([-0.2, 0.4]), Tolerance { relative: 1e-3, absolute: 0.0 }, 1000);
    // The midpoint rule over pairs of points of the cell and the lamp, whose middle is right of the edge: h^2 / d^4 with h = 2.
    let grid = |low: f64, width: f64, steps: u32| {
        (0..steps).map(move |k| low + width * (f64::from(k) + 0.5) / f64::from(steps))
    };
    let along = grid(-0.2, 0.6, 121).flat_map(|x| grid(-0.3, 0.5, 119).map(move |lamp| (x, lamp)));
    let across: Vec<f64> =
        grid(-1.0, 2.0, 20).flat_map(|y| grid(-0.4, 0.8, 16).map(move |lamp| (y - lamp).powi(2))).collect();
    let open = along.filter(|(x, lamp)| x + lamp > 0.0);
    let kernel = |(x, lamp): (f64, f64)| {
        across.iter().map(|y2| 4.0 / (4.0 + (x - lamp).powi(2) + y2).powi(2)).sum::<f64>()
    };
    let pairs = 121.0 * 119.0 * across.len() as f64;
    let expected = LUMINANCE * 0.5 * 0.8 * open.map(kernel).sum::<f64>() / pairs;
    close(mean.mean, expected, 1e-3, "mean");
    assert!(mean.error <= 1e-3 * mean.mean, "{mean:?}");
}
