//! Bilinear patches, twisted, flat and collapsed.

use glanz_geometry::bilinear::BilinearPatch;
use glanz_math::{DMat3, DVec3};

use super::case::ContractCase;
use super::harness::check_kind;

/// The patch of the saddle z = x y over the unit square, mapped by `m` and moved by `offset`: every non-planar patch has
/// this form.
fn twisted(m: DMat3, offset: DVec3) -> ContractCase {
    let back = m.inverse();
    let at = move |x: f64, y: f64| offset + m * DVec3::new(x, y, x * y);
    let (p00, p10, p01, p11) = (at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0));
    let center = at(0.5, 0.5);
    // A step out of the domain is at most as long as the shortest axis of the map.
    let unit = m.x_axis.length().min(m.y_axis.length());
    ContractCase {
        kept: Box::new(move |p| {
            let q = back * (p - offset);
            q.x.min(1.0 - q.x).min(q.y).min(1.0 - q.y) * unit
        }),
        position: Some(Box::new(move |uv| at(uv.x, uv.y))),
        center,
        size: 1.1 * [p00, p10, p01, p11].iter().map(|p| p.distance(center)).fold(0.0, f64::max),
        targets: vec![[p00, p10], [p10, p11], [p11, p01], [p01, p00], [p00, p11]],
        // Rulings of both families, the tangent along which the saddle bends least, and off a ruling by little.
        directions: vec![
            p10 - p00,
            p11 - p10,
            at(0.3, 1.0) - at(0.3, 0.0),
            m.x_axis + m.y_axis,
            (p11 - p01) + m.z_axis * 1e-9,
        ],
        ..ContractCase::new(
            format!("bilinear patch {m:?}"),
            BilinearPatch::try_new(p00, p10, p01, p11).unwrap(),
            move |p| {
                let q = back * (p - offset);
                (q.z - q.x * q.y) * m.z_axis.length()
            },
        )
    }
}

#[test]
fn twisted_patches_keep_the_contract() {
    let m = |x: [f64; 3], y: [f64; 3], z: [f64; 3]| DMat3::from_cols(x.into(), y.into(), z.into());
    let cases = [
        twisted(DMat3::IDENTITY, DVec3::ZERO),
        twisted(m([1.0, 0.2, -0.3], [-0.4, 1.3, 0.1], [0.5, -0.2, 0.9]), DVec3::new(3.0, -5.0, 2.0)),
        // Almost flat, and strongly twisted.
        twisted(m([1.0, 0.0, 0.1], [0.2, 0.8, 0.0], [0.0, 0.0, 1e-4]), DVec3::new(0.0, 0.0, 1.0)),
        twisted(m([1.0, 0.0, 0.1], [0.2, 0.8, 0.0], [0.3, 0.1, 20.0]), DVec3::ZERO),
        twisted(m([1e3, 0.0, 0.0], [0.0, 1e3, 50.0], [100.0, 0.0, 700.0]), DVec3::ZERO),
        // Ten times as long as wide, in millimetres.
        twisted(m([0.0, 1e-2, 0.0], [1e-3, 0.0, 0.0], [1e-3, 0.0, 2e-3]), DVec3::ZERO),
    ];
    check_kind("twisted bilinear patch", 26, &cases);
}

/// A convex quadrilateral in a plane.
fn flat(name: &str, [p00, p10, p01, p11]: [DVec3; 4]) -> ContractCase {
    let n = ((p10 - p00).cross(p11 - p00) + (p11 - p00).cross(p01 - p00)).normalize();
    let edges = [[p00, p10], [p10, p11], [p11, p01], [p01, p00]];
    let center = 0.25 * (p00 + p10 + p01 + p11);
    let doubled = (p11 - p00).cross(p01 - p10).length();
    let at = move |u: f64, v: f64| p00.lerp(p10, u).lerp(p01.lerp(p11, u), v);
    ContractCase {
        kept: Box::new(move |x| {
            let to_edge = |[a, b]: [DVec3; 2]| {
                let along = b - a;
                if along == DVec3::ZERO { f64::INFINITY } else { n.cross(along.normalize()).dot(x - a) }
            };
            edges.map(to_edge).into_iter().fold(f64::INFINITY, f64::min)
        }),
        position: Some(Box::new(move |uv| at(uv.x, uv.y))),
        // Half the cross product of the diagonals.
        area: Some(0.5 * doubled),
        center,
        size: 1.1 * [p00, p10, p01, p11].iter().map(|p| p.distance(center)).fold(0.0, f64::max),
        convex: true,
        targets: edges.to_vec(),
        directions: vec![n, p10 - p01, p11 - p00, (p11 - p10) + n * 1e-9],
        ..ContractCase::new(name, BilinearPatch::try_new(p00, p10, p01, p11).unwrap(), move |x| {
            n.dot(x - center)
        })
    }
}

#[test]
fn flat_patches_keep_the_contract() {
    let v = DVec3::new;
    let mut collapsed =
        flat("collapsed", [v(0.0, 0.0, 0.0), v(0.0, 0.0, 0.0), v(1.0, 2.0, 0.5), v(2.0, -0.5, 1.5)]);
    collapsed.parameter_singular = vec![DVec3::ZERO];
    let cases = [
        flat("square", [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(1.0, 1.0, 0.0)]),
        flat("parallelogram", [v(1.0, 2.0, 3.0), v(2.0, 2.5, 3.25), v(1.5, 3.0, 2.0), v(2.5, 3.5, 2.25)]),
        flat("kite", [v(0.0, 0.0, 0.0), v(2.0, 0.5, 0.0), v(0.5, 2.0, 0.0), v(1.6, 1.6, 0.0)]),
        flat("trapezium", [v(0.0, 0.0, 1.0), v(4.0, 0.0, 1.0), v(1.0, 0.0, 3.0), v(2.0, 0.0, 3.0)]),
        collapsed,
    ];
    check_kind("flat bilinear patch", 27, &cases);
}
