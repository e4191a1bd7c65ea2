//! Faces so narrow that chords of their borders cross, or lie on the wrong sides of each other.

use super::*;
use crate::description::NurbsDescription;

/// A curve of degree 2 in the unit square that is a whole edge.
fn arc(points: [[f64; 2]; 3], edge: u32, vertices: [u32; 2]) -> TrimCurveDescription {
    TrimCurveDescription {
        degree: 2,
        knots: [0, 0, 0, 1, 1, 1].map(f64::from).to_vec(),
        points: points.map(|[u, v]| [u, v, 1.0]).to_vec(),
        width: Some(1e-9),
        edge: Some(TrimEdgeDescription { edge, vertices, range: [0.0, 1.0] }),
    }
}

/// A wall of height 1 along an arc, with its four edges: below, at the end, above, at the start.
fn wall(arc: [[f64; 2]; 3], edges: [(u32, [u32; 2]); 4]) -> ShapeDescription {
    let points = arc.iter().flat_map(|&[x, y]| [[x, y, 0.0, 1.0], [x, y, 1.0, 1.0]]).collect();
    let nurbs = NurbsDescription {
        degree_u: 2,
        degree_v: 1,
        knots_u: [0, 0, 0, 1, 1, 1].map(f64::from).to_vec(),
        knots_v: [0, 0, 1, 1].map(f64::from).to_vec(),
        points,
        domain: None,
    };
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let ranges = [[0.0, 1.0], [0.0, 1.0], [1.0, 0.0], [1.0, 0.0]];
    let side = |i: usize| part(corners[i], corners[(i + 1) % 4], (edges[i].0, edges[i].1, ranges[i]));
    ShapeDescription::from(GeometryDescription::Nurbs(nurbs)).trimmed(trim(vec![(0..4).map(side).collect()]))
}

/// A crescent between two parabolas of these heights over a chord of length 1.6, extruded by 1; the inner one in two parts.
pub(super) fn crescent(outer: f64, inner: f64) -> Vec<ShapeDescription> {
    let over = [[0.8, 0.0], [0.0, 2.0 * outer], [-0.8, 0.0]];
    let first = [[-0.8, 0.0], [-0.4, inner], [0.0, inner]];
    let second = [[0.0, inner], [0.4, inner], [0.8, 0.0]];
    // Vertices: 0 and 1 at the start of the first part, 2 and 3 at the end of the second, 4 and 5 between; the even ones below.
    let cap = |level: u32| {
        let map = |points: [[f64; 2]; 3]| points.map(|[x, y]| [0.5 * (x + 1.0), 0.5 * (y + 1.0)]);
        trim(vec![vec![
            arc(map(over), level, [2 + level, level]),
            arc(map(first), 2 + level, [level, 4 + level]),
            arc(map(second), 4 + level, [4 + level, 2 + level]),
        ]])
    };
    let flat = || ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]);
    let (left, right, middle) = ((6, [0, 1]), (7, [2, 3]), (8, [4, 5]));
    vec![
        flat().trimmed(cap(1)).translated([0.0, 0.0, 1.0]),
        flat().trimmed(cap(0)).reversed(),
        wall(over, [(0, [2, 0]), left, (1, [3, 1]), right]),
        wall(first, [(2, [0, 4]), middle, (3, [1, 5]), left]),
        wall(second, [(4, [4, 2]), right, (5, [5, 3]), middle]),
    ]
}

#[test]
fn chords_on_the_wrong_side_of_each_other_are_divided() {
    // One chord of the outer parabola, two of the inner one: they do not cross, but the outer one is inside.
    let (outer, inner) = (0.1, 0.08);
    let volume = 2.0 / 3.0 * 1.6 * (outer - inner);
    for deviation in [0.15, 0.05, 1e-3] {
        let mesh = assert_closed(crescent(outer, inner), deviation, volume, 2.0 * volume + 3.27);
        let found = mesh.volume(0..5);
        assert!((0.7 * volume..1.1 * volume).contains(&found), "{found} {volume}");
    }
}

#[test]
fn chords_of_a_thin_ring_do_not_cross() {
    // Vertices of the inner circle are opposite to the middles of the outer one's chords, and beyond them.
    let (inner, turn) = (0.99, PI / 16.0);
    let ring = |wall: u32| {
        let [below, above] = [wall, wall + 1].map(|edge| (edge, [edge, edge]));
        let (forward, back, joint) = ([0.0, 1.0], [1.0, 0.0], (wall + 4, [wall, wall + 1]));
        trim(vec![vec![
            part([0.0, 0.0], [1.0, 0.0], (below.0, below.1, forward)),
            part([1.0, 0.0], [1.0, 1.0], (joint.0, joint.1, forward)),
            part([1.0, 1.0], [0.0, 1.0], (above.0, above.1, back)),
            part([0.0, 1.0], [0.0, 0.0], (joint.0, joint.1, back)),
        ]])
    };
    let cap = |level: u32| {
        let outer = numbered(circle([0.5; 2], [0.5; 2], true), level, true);
        let mut hole = numbered(circle([0.5; 2], [0.5 * inner; 2], false), 2 + level, false);
        for [u, v, w] in &mut hole.points {
            let [x, y] = [*u - 0.5 * *w, *v - 0.5 * *w];
            (*u, *v) =
                (0.5 * *w + x * turn.cos() - y * turn.sin(), 0.5 * *w + x * turn.sin() + y * turn.cos());
        }
        trim(vec![vec![outer], vec![hole]])
    };
    let flat = || ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]);
    let shapes = vec![
        flat().trimmed(cap(0)).reversed(),
        flat().trimmed(cap(1)).translated([0.0, 0.0, 3.0]),
        ShapeDescription::cylinder(1.0, [0.0, 3.0]).trimmed(ring(0)),
        ShapeDescription::cylinder(inner, [0.0, 3.0]).trimmed(ring(2)).rotated(DVec3::Z, turn).reversed(),
    ];
    let section = PI * (1.0 - inner * inner);
    let area = 2.0 * section + 3.0 * TAU * (1.0 + inner);
    for deviation in [0.2, 0.01] {
        let mesh = assert_closed(shapes.clone(), deviation, 3.0 * section, area);
        assert!(mesh.volume(0..4) > 2.0 * section, "{}", mesh.volume(0..4));
    }
}
