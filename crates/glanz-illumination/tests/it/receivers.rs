//! Grids on surfaces: areas, places, sides.

use std::f64::consts::PI;

use crate::common::*;
use glanz_illumination::*;
use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{HitLocation, SceneBuilder};

/// A rational quadratic patch: a quarter of a cylinder of radius 1 about z and height 2, over u in [0, 1] and v in [0, 2].
fn quarter_cylinder() -> ShapeDescription {
    let half = 0.5_f64.sqrt();
    let mut points = Vec::new();
    for (x, y, w) in [(1.0, 0.0, 1.0), (half, half, half), (0.0, 1.0, 1.0)] {
        for z in [0.0, 2.0] {
            points.push([x, y, z * w, w]);
        }
    }
    let knots = |degree: usize, end: f64| [vec![0.0; degree + 1], vec![end; degree + 1]].concat();
    GeometryDescription::Nurbs(NurbsDescription {
        degree_u: 2,
        degree_v: 1,
        knots_u: knots(2, 1.0),
        knots_v: knots(1, 2.0),
        points,
        domain: None,
    })
    .into()
}

/// Shapes with their areas.
fn shapes() -> Vec<(ShapeDescription, f64)> {
    let ring = GeometryDescription::Disk { height: 0.2, radius: 2.0, inner_radius: 0.5, phi_max: 3.0 };
    let (o, x, y) = (DVec3::ZERO, DVec3::X, DVec3::Y);
    vec![
        (rectangle(3.0, 2.0), 6.0),
        (ShapeDescription::disk(1.5), PI * 2.25),
        (ring.into(), 1.5 * 3.75),
        (ShapeDescription::mesh(vec![o, 2.0 * x, 2.0 * x + y, y], vec![[0, 1, 2], [0, 2, 3]]), 2.0),
        (ShapeDescription::mesh(vec![o, 2.0 * x, y], vec![[0, 1, 2]]), 1.0),
        // Not in a plane: counts by triangles.
        (
            ShapeDescription::mesh(vec![o, x, x + y, y + DVec3::Z], vec![[0, 1, 2], [0, 2, 3]]),
            0.5 + 0.5 * 3.0_f64.sqrt(),
        ),
        (ShapeDescription::parallelogram(o, 3.0 * x, y), 3.0),
        (ShapeDescription::sphere(0.5), PI),
        (quarter_cylinder(), PI),
        (ShapeDescription::torus(2.0, 0.5), 4.0 * PI * PI),
    ]
}

fn receivers(
    shape: ShapeDescription,
    place: DMat4,
    cells: GridResolution,
) -> (glanz_scene::Scene, Receivers) {
    let scene = SceneBuilder::new().shape(shape.transformed(place), diffuse(0.5)).resolve().unwrap().0;
    let receivers = Receivers::try_new(&scene, &[request("r", 0, cells)]).unwrap();
    (scene, receivers)
}

#[test]
fn cells_share_the_area() {
    for place in [
        DMat4::IDENTITY,
        DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0))
            * DMat4::from_rotation_x(0.7)
            * DMat4::from_rotation_z(0.4),
    ] {
        for (number, (geometry, expected)) in shapes().into_iter().enumerate() {
            let (_, receivers) = receivers(geometry, place, GridResolution::Cells([7, 5]));
            let [receiver] = receivers.as_slice() else { panic!("{number}") };
            let area: f64 = receiver.areas().iter().sum();
            assert!((area / expected - 1.0).abs() < 1e-6, "{number}: {area}, not {expected}");
        }
    }
}

#[test]
fn rays_meet_the_cells_that_places_lie_in() {
    for (number, (geometry, _)) in shapes().into_iter().enumerate() {
        let place = DMat4::from_translation(DVec3::new(1.0, -2.0, 0.5)) * DMat4::from_rotation_y(0.3);
        let (scene, receivers) = receivers(geometry, place, GridResolution::Cells([4, 3]));
        let receiver = &receivers.as_slice()[0];
        let placed = scene.placed_surfaces();
        let mut seen = 0;
        for cell in 0..receiver.len() {
            let mut area = 0.0;
            let n = 16;
            for k in 0..n * n {
                let share = (DVec2::new(f64::from(k % n), f64::from(k / n)) + 0.5) / f64::from(n);
                let Some(point) = receiver.place(&placed[0], cell, share) else { continue };
                area += point.area_element / f64::from(n * n);
                let ray = Ray::new(point.position + 0.01 * point.normal, -point.normal);
                let (hit, found) = scene.intersect_parametric(&ray, 0.02).unwrap();
                let met = receivers.met(&HitLocation::new(&hit, found)).unwrap();
                assert_eq!((met.cell, met.counts), (cell, true), "shape {number} at {share}");
                seen += 1;
            }
            // Midpoints of parts that a border may cut: about a row of 16 of 256.
            let off = (area - receiver.areas()[cell]).abs();
            assert!(
                off < 0.1 * receiver.areas().iter().fold(0.0, |a: f64, b| a.max(*b)),
                "{number}: {cell} {off}"
            );
        }
        assert!(seen > 1000 || number == 5, "shape {number}: {seen}");
    }
}

#[test]
fn interpolation_between_middles_of_cells_is_exact_for_linear_values() {
    let mut seen = 0;
    for (number, (geometry, _)) in shapes().into_iter().enumerate() {
        let cells = [6, 5];
        let (scene, receivers) =
            receivers(geometry, DMat4::from_rotation_x(0.4), GridResolution::Cells(cells));
        let receiver = &receivers.as_slice()[0];
        let placed = scene.placed_surfaces();
        let places = [(8, [0.5, 0.5]), (8, [0.8, 0.3]), (15, [0.1, 0.9]), (0, [0.2, 0.1]), (29, [0.9, 0.8])];
        for (cell, share) in places {
            let share = DVec2::from(share);
            let Some(point) = receiver.place(&placed[0], cell, share) else { continue };
            let ray = Ray::new(point.position + 0.01 * point.normal, -point.normal);
            let (hit, found) = scene.intersect_parametric(&ray, 0.02).unwrap();
            let around = receiver.interpolation(&HitLocation::new(&hit, found)).unwrap();
            assert!((around.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
            // The column and the row themselves, as values of the cells.
            let mean = |value: fn(usize) -> f64| {
                around.iter().map(|&(cell, weight)| weight * value(cell)).sum::<f64>()
            };
            let at = DVec2::new(mean(|cell| (cell % 6) as f64), mean(|cell| (cell / 6) as f64));
            let own = DVec2::new((cell % 6) as f64, (cell / 6) as f64);
            // Constant in the outer half of cells at the border; cells that are triangles have their own value.
            let is_faces = receiver.cells() != cells;
            let within = (own + share - 0.5).clamp(DVec2::ZERO, DVec2::new(5.0, 4.0));
            let expected = if is_faces { own } else { within };
            assert!(at.distance(expected) < 1e-6, "shape {number}, cell {cell}: {at}, not {expected}");
            seen += 1;
        }
    }
    assert!(seen >= 20, "{seen}");
}

#[test]
fn walls_are_seen_upright_from_the_side_that_counts() {
    // A wall in the plane y = 0 that faces +y: someone in front, looking along -y, has +x to the left.
    let (o, x, z) = (DVec3::ZERO, DVec3::X, DVec3::Z);
    let wall =
        ShapeDescription::mesh(vec![o, 4.0 * x, 4.0 * x + 2.0 * z, 2.0 * z], vec![[0, 2, 1], [0, 3, 2]]);
    let scene = SceneBuilder::new().shape(wall, diffuse(0.5)).resolve().unwrap().0;
    let of = |side| {
        let asked = ReceiverRequest { side, ..request("wall", 0, GridResolution::Longer(4)) };
        Receivers::try_new(&scene, &[asked]).unwrap().as_slice()[0].clone()
    };
    let front = of(ReceiverSide::Front);
    assert_eq!((front.cells(), front.size()), ([4, 2], DVec2::new(4.0, 2.0)));
    assert_eq!(front.positions()[0], DVec3::new(3.5, 0.0, 0.5));
    assert_eq!(front.positions()[7], DVec3::new(0.5, 0.0, 1.5));
    let back = of(ReceiverSide::Back);
    assert_eq!(back.positions()[0], DVec3::new(0.5, 0.0, 0.5));
    // A floor has x to the right and y up, seen from above.
    let floor = SceneBuilder::new().shape(rectangle(2.0, 2.0), diffuse(0.5)).resolve().unwrap().0;
    let floor = Receivers::try_new(&floor, &[request("floor", 0, GridResolution::Texel(0.9))]).unwrap();
    assert_eq!(floor.as_slice()[0].cells(), [2, 2]);
    assert_eq!(floor.as_slice()[0].positions()[1], DVec3::new(0.5, -0.5, 0.0));
}

#[test]
fn boxes_count_by_facets_and_names_that_repeat_are_numbered() {
    let cuboid = ShapeDescription::cuboid([0.0; 3], [1.0, 2.0, 3.0]);
    let scene = SceneBuilder::new()
        .shape(cuboid, diffuse(0.5))
        .shape(ShapeDescription::disk(1.0).translated([5.0, 0.0, 0.0]), diffuse(0.5))
        .resolve()
        .unwrap()
        .0;
    let asked =
        [request("box", 0, GridResolution::Cells([2, 2])), request("box", 1, GridResolution::Cells([2, 2]))];
    let receivers = Receivers::try_new(&scene, &asked).unwrap();
    let names: Vec<&str> = receivers.as_slice().iter().map(Receiver::name).collect();
    assert_eq!(names[0], "box 1 facet 1");
    assert_eq!((names[5], names[6], names.len()), ("box 1 facet 6", "box 2", 7));
    let areas: f64 = receivers.as_slice()[..6].iter().flat_map(Receiver::areas).sum();
    assert!((areas - 22.0).abs() < 1e-12);
}

#[test]
fn sides_of_a_border_count_by_themselves_and_stop_nothing() {
    // A point above the middle of a border: what goes down passes it and comes to the floor behind.
    let receiver = ReceiverDescription {
        zone: None,
        name: "air".into(),
        cells: Some([1, 1]),
        side: ReceiverSide::Both,
        location: None,
    };
    let border = ShapeDescription { receiver: Some(receiver), ..rectangle(2.0, 2.0) };
    let scene = SceneBuilder::new()
        .shape(border, MaterialKind::Interface)
        .shape(rectangle(40.0, 40.0).translated([0.0, 0.0, -1.0]), diffuse(0.5))
        .light(point_light(DVec3::new(0.0, 0.0, 1.0), 100.0));
    let scene = resolved(scene);
    let asked = ReceiverRequest::of_scene(&scene, GridResolution::Longer(9));
    let (maps, balance) = maps(&scene, &asked, 1 << 17);
    let names: Vec<&str> = maps.iter().map(|map| map.name.as_str()).collect();
    assert_eq!(names, ["air front", "air back"]);
    // A face of the cube around the point, 4 pi / 6 sr.
    let front = 100.0 * 4.0 * PI / 6.0 / 4.0;
    assert!((maps[0].lux[0] - front).abs() < 4.0 * maps[0].errors[0], "{} {front}", maps[0].lux[0]);
    // The floor sends half of it back, about half of which meets the border from below.
    assert!(maps[1].lux[0] > 0.05 * front && maps[1].lux[0] < 0.5 * front);
    assert_eq!(balance.absorbed_by_receivers, 0.0);
    assert!(balance.closes_to() < 1e-6);
}

#[test]
fn shapes_without_end_or_parameters_are_refused() {
    let scene = resolved(SceneBuilder::new().shape(ShapeDescription::plane(), diffuse(0.5)));
    let refused =
        |shape| Receivers::try_new(&scene, &[request("sea", shape, GridResolution::Longer(4))]).unwrap_err();
    assert_eq!(refused(0), ReceiverError::NoParameters("sea".into()));
    assert_eq!(refused(1), ReceiverError::NoArea("sea".into()));
}

/// A floor of 4 m x 4 m in 8 x 8 cells under a thing of `material` from `low` to `high`.
fn floor_under(material: MaterialKind, low: [f64; 3], high: [f64; 3]) -> Vec<f64> {
    let scene = SceneBuilder::new()
        .shape(rectangle(4.0, 4.0), diffuse(0.0))
        .shape(ShapeDescription::cuboid(low, high), material)
        .resolve()
        .unwrap()
        .0;
    let receivers =
        Receivers::try_new(&scene, &[request("floor", 0, GridResolution::Cells([8, 8]))]).unwrap();
    let floor = &receivers.as_slice()[0];
    let left: f64 = floor.areas().iter().sum();
    let covered: f64 = floor.covered().iter().map(|share| 0.25 * share).sum();
    assert!((left + covered - 16.0).abs() < 1e-9);
    floor.covered().to_vec()
}

#[test]
fn things_that_stand_on_a_receiver_cover_its_cells() {
    let wood = || diffuse(0.5);
    // On the floor, through it, and less than a thousandth of a cell above: four cells.
    for bottom in [0.0, -0.1, 2e-4] {
        let shares = floor_under(wood(), [0.0, 0.0, bottom], [1.0, 1.0, 0.5]);
        assert_eq!(shares.iter().filter(|share| **share == 1.0).count(), 4);
        assert_eq!(shares.iter().sum::<f64>(), 4.0);
    }
    // Half a cell further: one cell, halves of four, quarters of four.
    let shares = floor_under(wood(), [0.25, 0.25, 0.0], [1.25, 1.25, 0.5]);
    let count = |wanted: f64| shares.iter().filter(|share| (**share - wanted).abs() < 0.01).count();
    assert_eq!([count(1.0), count(0.5), count(0.25), count(0.0)], [1, 4, 4, 55]);
}

#[test]
fn tables_glass_and_rooms_do_not_cover_a_receiver() {
    let open = [0.0; 64];
    // A table's top, glass on the floor, and a box that is the room.
    assert_eq!(floor_under(diffuse(0.5), [0.0, 0.0, 0.7], [1.0, 1.0, 0.75]), open);
    assert_eq!(floor_under(MaterialKind::dielectric(1.5, 1.0, 1.0), [0.0, 0.0, 0.0], [1.0, 1.0, 0.5]), open);
    assert_eq!(floor_under(diffuse(0.5), [-3.0, -3.0, -0.001], [3.0, 3.0, 3.0]), open);
}

#[test]
fn covered_cells_do_not_count_as_dark() {
    let scene = SceneBuilder::new()
        .shape(rectangle(4.0, 4.0), diffuse(0.0))
        .shape(ShapeDescription::cuboid([0.1, 0.1, 0.0], [0.9, 0.9, 0.01]), diffuse(0.0))
        .light(point_light(DVec3::Z * 3.0, 100.0))
        .resolve()
        .unwrap()
        .0;
    let (maps, _) = maps(&scene, &[request("floor", 0, GridResolution::Cells([8, 8]))], 1 << 19);
    // I h / d^3, smallest in the corners; the plate of 1 cm hides less than 1 % of any other cell.
    let lux = |p: DVec2| 300.0 / (9.0 + p.length_squared()).powf(1.5);
    let expected = cell_means(&maps[0], lux);
    let least = expected.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((maps[0].summary().minimum / least - 1.0).abs() < 0.03, "{} {least}", maps[0].summary().minimum);
    for (cell, expected) in expected.iter().enumerate().filter(|(cell, _)| maps[0].areas[*cell] > 0.0) {
        // The plate covers 64 % of each of four cells: the rest is known to 2 %.
        let (lux, error) = (maps[0].lux[cell], maps[0].errors[cell]);
        assert!((lux - expected).abs() < 4.0 * error + 0.03 * expected, "{cell}: {lux} {error} {expected}");
        assert!(error < 0.04 * expected);
    }
}
