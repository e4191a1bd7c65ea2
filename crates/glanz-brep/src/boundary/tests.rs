use std::f64::consts::{PI, TAU};

use glanz_geometry::trim::{TrimCurve, TrimLoop, TrimRegion};
use glanz_math::{DVec2, DVec3};

use super::*;

const TOLERANCE: f64 = 1e-6;

fn line(from: [f64; 2], to: [f64; 2]) -> BoundaryCurve {
    BoundaryCurve::line(from.into(), to.into())
}

fn edge(number: usize, from: [f64; 2], to: [f64; 2]) -> BoundaryCurve {
    BoundaryCurve { edge: Some(number), ..line(from, to) }
}

fn polygon(corners: &[[f64; 2]]) -> Vec<BoundaryCurve> {
    corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| line(*a, *b)).collect()
}

fn flat(p: DVec2) -> DVec3 {
    p.extend(0.0)
}

fn on_cylinder(p: DVec2) -> DVec3 {
    DVec3::new(p.x.cos(), p.x.sin(), p.y)
}

fn on_sphere(p: DVec2) -> DVec3 {
    DVec3::new(p.y.cos() * p.x.cos(), p.y.cos() * p.x.sin(), p.y.sin())
}

fn on_torus(p: DVec2) -> DVec3 {
    let rho = 3.0 + p.y.cos();
    DVec3::new(rho * p.x.cos(), rho * p.x.sin(), p.y.sin())
}

const INFINITE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
const PLANE: ParameterSpace<'_> = ParameterSpace {
    domain: [INFINITE; 2],
    periods: [None; 2],
    movable: [false; 2],
    poles: [[false; 2]; 2],
    point: &flat,
};
const CYLINDER: ParameterSpace<'_> = ParameterSpace {
    domain: [[0.0, TAU], INFINITE],
    periods: [Some(TAU), None],
    movable: [true, false],
    point: &on_cylinder,
    ..PLANE
};
const SPHERE: ParameterSpace<'_> = ParameterSpace {
    domain: [[0.0, TAU], [-0.5 * PI, 0.5 * PI]],
    poles: [[false; 2], [true; 2]],
    point: &on_sphere,
    ..CYLINDER
};
const TORUS: ParameterSpace<'_> = ParameterSpace {
    domain: [[0.0, TAU], [0.0, TAU]],
    periods: [Some(TAU); 2],
    movable: [true, false],
    point: &on_torus,
    ..PLANE
};

fn boundary(
    loops: Vec<Vec<BoundaryCurve>>,
    space: &ParameterSpace<'_>,
) -> Result<ClosedBoundary, BoundaryError> {
    let chains: Result<Vec<_>, _> =
        loops.into_iter().map(|curves| chain(curves, space, TOLERANCE, 1e-2)).collect();
    close(chains?, space, 1e-9)
}

/// Part of the window that the face covers, by a lattice of n x n points.
fn covered(closed: &ClosedBoundary, n: u32) -> f64 {
    area(closed, n) / closed.window.iter().map(|[from, to]| to - from).product::<f64>()
}

fn area(closed: &ClosedBoundary, n: u32) -> f64 {
    let region = region(closed);
    let [low, size] = [
        DVec2::new(closed.window[0][0], closed.window[1][0]),
        DVec2::from_array(closed.window.map(|[from, to]| to - from)),
    ];
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
    let points = (0..n).flat_map(|i| (0..n).map(move |j| DVec2::new(at(i), at(j))));
    let inside = points.filter(|&p| region.contains(low + p * size)).count();
    inside as f64 / f64::from(n * n) * size.x * size.y
}

fn region(closed: &ClosedBoundary) -> TrimRegion {
    let [[x0, x1], [y0, y1]] = closed.window;
    let loops = closed.loops.iter().map(|curves| {
        let curves = curves.iter().map(|c| TrimCurve::try_nurbs(c.degree, &c.knots, &c.points).unwrap());
        TrimLoop::try_new(curves.collect(), 1e-9).unwrap()
    });
    TrimRegion::try_new(loops.collect(), [DVec2::new(x0, y0), DVec2::new(x1, y1)]).unwrap()
}

#[test]
fn a_square_with_a_hole_keeps_its_area_whatever_the_sense_of_its_loops() {
    let outer = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let hole = [[0.25, 0.25], [0.25, 0.5], [0.5, 0.5], [0.5, 0.25]];
    let turned = |corners: &[[f64; 2]]| corners.iter().rev().copied().collect::<Vec<_>>();
    for (loops, repairs) in [
        (vec![outer.to_vec(), hole.to_vec()], vec![]),
        (vec![hole.to_vec(), outer.to_vec()], vec![]),
        (vec![turned(&outer), turned(&hole)], vec![BoundaryRepair::ReversedBoundary]),
        (vec![turned(&outer), hole.to_vec()], vec![BoundaryRepair::ReversedLoop { number: 0 }]),
        (vec![outer.to_vec(), turned(&hole)], vec![BoundaryRepair::ReversedLoop { number: 1 }]),
    ] {
        let closed = boundary(loops.iter().map(|l| polygon(l)).collect(), &PLANE).unwrap();
        assert_eq!(closed.repairs, repairs);
        assert!((area(&closed, 330) - 0.9375).abs() < 0.01, "{}", area(&closed, 330));
    }
}

#[test]
fn gaps_are_bridged_and_counted_and_wide_ones_refused() {
    let corners = |x: f64| {
        vec![line([0.0, 0.0], [1.0, 0.0]), line([1.0 + x, 0.0], [1.0, 1.0]), line([1.0, 1.0], [0.0, 0.0])]
    };
    assert_eq!(boundary(vec![corners(1e-7)], &PLANE).unwrap().repairs, vec![]);
    let closed = boundary(vec![corners(0.0078125)], &PLANE).unwrap();
    assert_eq!(closed.repairs, vec![BoundaryRepair::BridgedGap { gap: 0.0078125 }]);
    assert_eq!(closed.loops[0][1].width, 0.0078125);
    assert_eq!(boundary(vec![corners(0.5)], &PLANE), Err(BoundaryError::OpenLoop { gap: 0.5, limit: 1e-2 }));
    assert_eq!(boundary(vec![vec![]], &PLANE), Err(BoundaryError::Empty));
    assert_eq!(boundary(vec![corners(f64::NAN)], &PLANE), Err(BoundaryError::NotFinite));
    assert_eq!(boundary(vec![], &PLANE), Err(BoundaryError::Unbounded));
}

#[test]
fn an_edge_that_runs_against_its_loop_is_turned() {
    for wrong in 0..3 {
        let mut curves = vec![
            edge(0, [0.0, 0.0], [1.0, 0.0]),
            edge(1, [1.0, 0.0], [1.0, 1.0]),
            edge(2, [1.0, 1.0], [0.0, 0.0]),
        ];
        curves[wrong] = curves[wrong].clone().reversed();
        let closed = boundary(vec![curves], &PLANE).unwrap();
        assert_eq!(closed.repairs, vec![BoundaryRepair::ReversedEdge { edge: wrong }]);
        assert!((area(&closed, 200) - 0.5).abs() < 0.02);
    }
}

#[test]
fn a_tube_between_two_circles_needs_no_seam() {
    // The wave rises and falls by a half; the mean height between the two borders is 2.
    let wave: Vec<BoundaryCurve> =
        vec![line([1.0, 0.0], [1.0 + PI, 0.5]), line([1.0 + PI, 0.5], [1.0 + TAU, 0.0])];
    let top = vec![line([TAU, 2.25], [0.0, 2.25])];
    let closed = boundary(vec![wave.clone(), top.clone()], &CYLINDER).unwrap();
    assert!((area(&closed, 500) - 2.0 * TAU).abs() < 0.03, "{}", area(&closed, 500));
    assert!(closed.window[0][1] - closed.window[0][0] <= TAU);
    // The same run the wrong way would be all but the tube.
    let turn = |curves: Vec<BoundaryCurve>| {
        curves.into_iter().rev().map(BoundaryCurve::reversed).collect::<Vec<_>>()
    };
    let closed = boundary(vec![turn(wave.clone()), turn(top)], &CYLINDER).unwrap();
    assert_eq!(closed.repairs, vec![BoundaryRepair::ReversedBoundary]);
    assert!((area(&closed, 500) - 2.0 * TAU).abs() < 0.03);
    // One circle alone bounds nothing.
    assert_eq!(boundary(vec![wave], &CYLINDER), Err(BoundaryError::Unbounded));
}

#[test]
fn a_tube_with_a_seam_edge_is_the_same() {
    let seam = |u: f64| edge(1, [u, 0.0], [u, 2.0]);
    let curves = vec![
        edge(0, [0.0, 0.0], [TAU, 0.0]),
        seam(0.0),
        edge(2, [0.0, 2.0], [TAU, 2.0]).reversed(),
        seam(TAU).reversed(),
    ];
    let closed = boundary(vec![curves], &CYLINDER).unwrap();
    assert!((area(&closed, 300) - 2.0 * TAU).abs() < 0.02 * TAU);
}

#[test]
fn a_patch_over_the_seam_moves_the_window() {
    let corners = [[TAU - 0.5, 0.0], [TAU, 0.0], [TAU, 1.0], [TAU - 0.5, 1.0]];
    let mut curves = polygon(&corners);
    // The half beyond the seam has its parameters at the other end.
    curves.splice(
        1..2,
        [line([0.0, 0.0], [0.75, 0.0]), line([0.75, 0.0], [0.75, 1.0]), line([0.75, 1.0], [0.0, 1.0])],
    );
    let closed = boundary(vec![curves], &CYLINDER).unwrap();
    assert!((area(&closed, 300) - 1.25).abs() < 0.02);
    assert!(closed.window[0][1] - closed.window[0][0] < 1.4);
}

#[test]
fn caps_of_a_sphere_contain_their_pole() {
    let circle = |v: f64| line([0.0, v], [TAU, v]);
    // Above the latitude 1: the rest up to the north pole.
    let cap = boundary(vec![vec![circle(1.0)]], &SPHERE).unwrap();
    assert!((area(&cap, 300) - TAU * (0.5 * PI - 1.0)).abs() < 0.05);
    let below = boundary(vec![vec![circle(1.0).reversed()]], &SPHERE).unwrap();
    assert!((area(&below, 300) - TAU * (0.5 * PI + 1.0)).abs() < 0.1, "{}", area(&below, 300));
    let whole = boundary(vec![], &SPHERE).unwrap();
    assert_eq!(covered(&whole, 100), 1.0);
}

#[test]
fn an_octant_of_a_sphere_closes_at_the_pole() {
    let half = 0.5 * PI;
    for start in [0.0, 1.0, 5.5] {
        let curves = vec![
            line([start, 0.0], [start + half, 0.0]),
            line([start + half, 0.0], [start + half, half]),
            line([start, half], [start, 0.0]),
        ];
        let closed = boundary(vec![curves], &SPHERE).unwrap();
        assert!((area(&closed, 300) - half * half).abs() < 0.03, "{start}: {}", area(&closed, 300));
    }
    // The same octant from the other side is the rest of the sphere.
    let rest =
        vec![line([half, 0.0], [0.0, 0.0]), line([0.0, 0.0], [0.0, half]), line([half, half], [half, 0.0])];
    let closed = boundary(vec![rest], &SPHERE).unwrap();
    assert!((area(&closed, 300) - (TAU * PI - half * half)).abs() < 0.2, "{}", area(&closed, 300));
}

#[test]
fn a_sphere_cut_along_one_meridian_is_whole() {
    let up = edge(0, [2.0, -0.5 * PI], [2.0, 0.5 * PI]);
    let closed = boundary(vec![vec![up.clone(), up.reversed()]], &SPHERE).unwrap();
    assert!(covered(&closed, 200) > 0.98, "{}", covered(&closed, 200));
}

#[test]
fn a_band_around_the_tube_of_a_torus_may_pass_its_seam() {
    let circle = |v: f64| line([0.0, v], [TAU, v]);
    for (from, to, height) in [(1.0, 2.0, 1.0), (5.0, 1.0, TAU - 4.0), (2.0, 1.0, TAU - 1.0)] {
        let closed = boundary(vec![vec![circle(from)], vec![circle(to).reversed()]], &TORUS).unwrap();
        assert!((area(&closed, 400) - TAU * height).abs() < 0.2, "{from} {to}: {}", area(&closed, 400));
    }
    // The same around the other way: from the angle 1 to the angle 2 of the axis the face is on the left of the first circle run down.
    let tube = |u: f64| line([u, 0.0], [u, TAU]);
    let closed = boundary(vec![vec![tube(2.0)], vec![tube(1.0).reversed()]], &TORUS).unwrap();
    assert!((area(&closed, 400) - TAU).abs() < 0.2, "{}", area(&closed, 400));
    assert_eq!(boundary(vec![vec![tube(2.0)]], &TORUS), Err(BoundaryError::Unpaired(1, 0)));
}

#[test]
fn a_torus_cut_along_both_circles_is_whole() {
    let (around, tube) = (edge(0, [0.0, 0.0], [TAU, 0.0]), edge(1, [0.0, 0.0], [0.0, TAU]));
    let curves = vec![around.clone(), tube.clone(), around.reversed(), tube.reversed()];
    let closed = boundary(vec![curves], &TORUS).unwrap();
    assert!(covered(&closed, 200) > 0.97, "{}", covered(&closed, 200));
}

#[test]
fn a_disk_on_a_torus_and_its_complement_add_up() {
    let disk = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let closed = boundary(vec![polygon(&disk)], &TORUS).unwrap();
    assert!((area(&closed, 400) - 1.0).abs() < 0.03, "{}", area(&closed, 400));
    let turned: Vec<_> = disk.iter().rev().copied().collect();
    let closed = boundary(vec![polygon(&turned)], &TORUS).unwrap();
    assert!((area(&closed, 400) - (TAU * TAU - 1.0)).abs() < 0.1, "{}", area(&closed, 400));
}

#[test]
fn an_oblique_cut_that_touches_a_circle_bounds_the_same_tube_in_any_order() {
    let circle = vec![line([0.0, 0.0], [TAU, 0.0])];
    let cut = vec![line([TAU, 0.0], [PI, 2.0]), line([PI, 2.0], [0.0, 0.0])];
    for loops in [vec![circle.clone(), cut.clone()], vec![cut, circle]] {
        let closed = boundary(loops, &CYLINDER).unwrap();
        assert!((area(&closed, 400) - TAU).abs() < 0.05, "{}", area(&closed, 400));
        assert_eq!(closed.repairs, vec![]);
    }
}

#[test]
fn a_hole_in_a_tube_is_a_hole_whatever_its_sense() {
    let hole = [[1.0, 0.5], [2.0, 0.5], [2.0, 1.5], [1.0, 1.5]];
    let (bottom, top) = (line([0.0, 0.0], [TAU, 0.0]), line([TAU, 2.0], [0.0, 2.0]));
    let closed = boundary(vec![vec![bottom], vec![top], polygon(&hole)], &CYLINDER).unwrap();
    assert_eq!(closed.repairs, vec![BoundaryRepair::ReversedLoop { number: 2 }]);
    assert!((area(&closed, 400) - (2.0 * TAU - 1.0)).abs() < 0.05, "{}", area(&closed, 400));
}

#[test]
fn curves_many_periods_away_come_home_and_endless_ones_are_refused() {
    let far = 1e9 * TAU;
    let tube = |x: f64| vec![vec![line([x, 0.0], [x + TAU, 0.0])], vec![line([TAU, 2.0], [0.0, 2.0])]];
    let closed = boundary(tube(far), &CYLINDER).unwrap();
    assert!((area(&closed, 300) - 2.0 * TAU).abs() < 0.02 * TAU);
    let endless = vec![vec![line([0.0, 0.0], [far, 0.0])]];
    assert_eq!(boundary(endless, &CYLINDER), Err(BoundaryError::TooLarge));
}
