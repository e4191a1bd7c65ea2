mod border;
mod revolution;

use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::sync::atomic::{AtomicUsize, Ordering};

use glanz_geometry::spline::NurbsSurface;
use glanz_math::glam::DVec4;
use glanz_math::{DMat4, DVec3};

use super::*;
use crate::model::{
    BoundaryLoop, BrepModel, Curve, Edge, EntityId, Face, FaceBound, FaceSurface, OrientedEdge, Placement,
    SurfaceEntry,
};

const WORLD: Placement = Placement { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };

fn at_height(z: f64) -> Placement {
    Placement { origin: DVec3::Z * z, ..WORLD }
}

/// A model under construction; entities are numbered by their kind and index.
#[derive(Default)]
struct ModelBuilder(BrepModel);

impl ModelBuilder {
    /// A full circle about the z axis as an edge.
    fn circle(&mut self, radius: f64, z: f64) -> usize {
        let vertex = self.0.vertices.len();
        self.0.vertices.push(DVec3::new(radius, 0.0, z));
        let curve = Curve::Ellipse { center: DVec3::Z * z, a: DVec3::X * radius, b: DVec3::Y * radius };
        self.edge([vertex, vertex], Some(curve))
    }

    fn edge(&mut self, [start, end]: [usize; 2], curve: Option<Curve<DVec3>>) -> usize {
        let number = self.0.edges.len();
        let entity = EntityId(1000 + number as u64);
        self.0.edges.push(Edge { start, end, curve, same_sense: true, parameter_curves: Vec::new(), entity });
        number
    }

    /// A face bounded by loops of single edges, forward or not.
    fn face(&mut self, surface: FaceSurface, same_sense: bool, loops: &[(usize, bool)]) {
        let bounds =
            loops.iter().map(|&(edge, forward)| BoundaryLoop::Edges(vec![OrientedEdge { edge, forward }]));
        self.bounded(surface, same_sense, bounds.collect());
    }

    /// A loop of straight edges, which it shares with those before it.
    fn polygon(&mut self, corners: &[DVec3]) -> BoundaryLoop {
        let numbers: Vec<usize> = corners
            .iter()
            .map(|&corner| {
                let known = self.0.vertices.iter().position(|&vertex| vertex == corner);
                known.unwrap_or_else(|| {
                    self.0.vertices.push(corner);
                    self.0.vertices.len() - 1
                })
            })
            .collect();
        let sides = (0..numbers.len()).map(|i| [numbers[i], numbers[(i + 1) % numbers.len()]]);
        let oriented = sides.map(|[start, end]| {
            let mut edges = self.0.edges.iter();
            let known = edges.position(|edge| [[start, end], [end, start]].contains(&[edge.start, edge.end]));
            let edge = known.unwrap_or_else(|| self.edge([start, end], None));
            OrientedEdge { edge, forward: self.0.edges[edge].start == start }
        });
        BoundaryLoop::Edges(oriented.collect())
    }

    fn bounded(&mut self, surface: FaceSurface, same_sense: bool, loops: Vec<BoundaryLoop>) {
        let (number, entity) = (self.0.surfaces.len(), EntityId(2000 + self.0.surfaces.len() as u64));
        self.0.surfaces.push(SurfaceEntry { surface, entity });
        let bound = |(i, boundary)| FaceBound { boundary, outer: i == 0, entity: EntityId(3000 + i as u64) };
        self.0.faces.push(Face {
            surface: number,
            same_sense,
            bounds: loops.into_iter().enumerate().map(bound).collect(),
            name: String::new(),
            style: None,
            layer: String::new(),
            entity: EntityId(4000 + number as u64),
        });
    }

    /// The faces, none of which is refused or repaired.
    fn faces(mut self) -> Vec<TrimmedFace> {
        self.0.uncertainty = 1e-7;
        let faces = trimmed_faces(&self.0).faces.into_iter().map(Result::unwrap).collect::<Vec<_>>();
        for face in &faces {
            assert_eq!(face.repairs, vec![]);
        }
        faces
    }
}

fn assert_close(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-8 * expected.abs(), "{value}, not {expected}");
}

/// Sum of areas, and volume.
fn assert_measures(faces: &[TrimmedFace], area: f64, volume: f64) {
    let sum = faces.iter().map(|face| face.measure(1e-9)).fold(FaceMeasure::default(), |a, b| a + b);
    assert_close(sum.area, area);
    assert_close(sum.volume, volume);
}

#[test]
fn a_cylinder_of_three_faces_has_its_area_and_volume() {
    let mut model = ModelBuilder::default();
    let (bottom, top) = (model.circle(2.0, 1.0), model.circle(2.0, 4.0));
    model.face(
        FaceSurface::Cylinder { placement: WORLD, radius: 2.0 },
        true,
        &[(bottom, true), (top, false)],
    );
    model.face(FaceSurface::Plane(at_height(4.0)), true, &[(top, true)]);
    model.face(FaceSurface::Plane(at_height(1.0)), false, &[(bottom, false)]);
    let faces = model.faces();
    assert_measures(&faces, 4.0 * PI * (3.0 + 2.0), 12.0 * PI);
    assert!(faces[2].reversed && !faces[1].reversed);
}

#[test]
fn cones_end_at_their_apex_or_before() {
    // Radius 1 at z = 0, 2 at z = 1; apex at z = -1.
    let cone = || FaceSurface::Cone { placement: WORLD, radius: 1.0, half_angle: FRAC_PI_4 };
    let mut frustum = ModelBuilder::default();
    let (bottom, top) = (frustum.circle(1.0, 0.0), frustum.circle(2.0, 1.0));
    frustum.face(cone(), true, &[(bottom, true), (top, false)]);
    frustum.face(FaceSurface::Plane(at_height(1.0)), true, &[(top, true)]);
    frustum.face(FaceSurface::Plane(WORLD), false, &[(bottom, false)]);
    assert_measures(&frustum.faces(), PI * (3.0 * 2f64.sqrt() + 4.0 + 1.0), PI / 3.0 * (1.0 + 2.0 + 4.0));
    let mut whole = ModelBuilder::default();
    let top = whole.circle(2.0, 1.0);
    let apex = whole.0.vertices.len();
    whole.0.vertices.push(DVec3::NEG_Z);
    let rim = BoundaryLoop::Edges(vec![OrientedEdge { edge: top, forward: false }]);
    whole.bounded(cone(), true, vec![rim, BoundaryLoop::Vertex(apex)]);
    whole.face(FaceSurface::Plane(at_height(1.0)), true, &[(top, true)]);
    assert_measures(&whole.faces(), PI * 2.0 * 8f64.sqrt() + 4.0 * PI, PI / 3.0 * 4.0 * 2.0);
}

#[test]
fn whole_spheres_and_tori_need_no_edges() {
    let mut sphere = ModelBuilder::default();
    sphere.0.vertices.push(DVec3::Z * 3.0);
    sphere.bounded(
        FaceSurface::Sphere { placement: WORLD, radius: 3.0 },
        true,
        vec![BoundaryLoop::Vertex(0)],
    );
    assert_measures(&sphere.faces(), 36.0 * PI, 36.0 * PI);
    let mut torus = ModelBuilder::default();
    let surface =
        FaceSurface::Torus { placement: WORLD, major_radius: 3.0, minor_radius: 1.0, select_outer: true };
    torus.bounded(surface, true, vec![]);
    assert_measures(&torus.faces(), TAU * TAU * 3.0, PI * TAU * 3.0);
}

#[test]
fn a_cap_of_a_sphere_and_a_disk_enclose_its_segment() {
    for z in [1.0, -1.5, 1.9, 1.99, -1.99] {
        let (r, h): (f64, f64) = (2.0, 2.0 - z);
        let mut model = ModelBuilder::default();
        let rim = model.circle((r * r - z * z).sqrt(), z);
        model.face(FaceSurface::Sphere { placement: WORLD, radius: r }, true, &[(rim, true)]);
        model.face(FaceSurface::Plane(at_height(z)), false, &[(rim, false)]);
        assert_measures(&model.faces(), TAU * r * h + PI * (r * r - z * z), PI * h * h * (3.0 * r - h) / 3.0);
    }
}

#[test]
fn half_a_torus_is_closed_by_two_disks() {
    let mut model = ModelBuilder::default();
    let circle = |model: &mut ModelBuilder, x: f64| {
        let vertex = model.0.vertices.len();
        model.0.vertices.push(DVec3::X * (4.0 * x));
        let curve = Curve::Ellipse { center: DVec3::X * (3.0 * x), a: DVec3::X * x, b: DVec3::Z };
        model.edge([vertex, vertex], Some(curve))
    };
    // At the azimuths 0 and pi, around the tube from outside upwards.
    let (start, end) = (circle(&mut model, 1.0), circle(&mut model, -1.0));
    let torus =
        FaceSurface::Torus { placement: WORLD, major_radius: 3.0, minor_radius: 1.0, select_outer: true };
    model.face(torus, true, &[(start, false), (end, true)]);
    let upright = Placement { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Z, z: DVec3::NEG_Y };
    model.face(FaceSurface::Plane(upright), true, &[(start, true)]);
    model.face(FaceSurface::Plane(upright), true, &[(end, false)]);
    assert_measures(&model.faces(), PI * TAU * 3.0 + TAU, PI * PI * 3.0);
}

#[test]
fn a_box_of_polygons_has_its_volume_whatever_the_sense_of_its_planes() {
    let corner = |i: usize| DVec3::new((i & 1) as f64, 2.0 * (i >> 1 & 1) as f64, 3.0 * (i >> 2 & 1) as f64);
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for same_sense in [true, false] {
        let mut model = ModelBuilder::default();
        for side in sides {
            let [a, b, c, d] = side.map(corner);
            let outward = (b - a).cross(d - a).normalize();
            let z = if same_sense { outward } else { -outward };
            let x = (b - a).normalize();
            let plane = Placement { origin: a, x, y: z.cross(x), z };
            let polygon = model.polygon(&[a, b, c, d]);
            model.bounded(FaceSurface::Plane(plane), same_sense, vec![polygon]);
        }
        assert_measures(&model.faces(), 22.0, 6.0);
    }
}

/// A cylinder with a lid whose rim is off the cylinder by a distance: by how much the faces stray from the rim, and how far they extend beyond it.
fn rim_beside_cylinder(distance: f64, uncertainty: f64) -> (f64, [f64; 2]) {
    let mut model = ModelBuilder::default();
    let (bottom, top) = (model.circle(1.0, 0.0), model.circle(1.0, 1.0));
    let radius = 1.0 + distance;
    model.0.edges[top].curve =
        Some(Curve::Ellipse { center: DVec3::Z, a: DVec3::X * radius, b: DVec3::Y * radius });
    model.face(
        FaceSurface::Cylinder { placement: WORLD, radius: 1.0 },
        true,
        &[(bottom, true), (top, false)],
    );
    model.face(FaceSurface::Plane(at_height(1.0)), true, &[(top, true)]);
    model.0.uncertainty = uncertainty;
    let trimmed = trimmed_faces(&model.0);
    (trimmed.widths[top], [0, 1].map(|face| trimmed.faces[face].as_ref().unwrap().width))
}

#[test]
fn faces_beside_an_edge_extend_by_what_both_stray_from_it() {
    let (strayed, widths) = rim_beside_cylinder(1e-6, 1e-5);
    assert!((1e-6..2e-6).contains(&strayed), "{strayed}");
    assert!(widths.iter().all(|width| (8e-6..17e-6).contains(width)), "{widths:?}");
}

#[test]
fn faces_that_hardly_stray_extend_far_beyond_it_whatever_the_file_states() {
    // The rim is farther from the cylinder than the resolution that takes the place of the uncertainty.
    let (strayed, widths) = rim_beside_cylinder(5e-9, 1e-17);
    assert!((5e-9..6e-9).contains(&strayed), "{strayed}");
    assert!(widths.iter().all(|width| (1e-6..4e-6).contains(width)), "{widths:?}");
    // Farther away they never extend less.
    let mut before = [0.0; 2];
    for exponent in -12..=-3 {
        let (_, widths) = rim_beside_cylinder(10.0_f64.powi(exponent), 1e-6);
        assert!(widths.iter().zip(before).all(|(width, before)| *width >= before), "{exponent}: {widths:?}");
        before = widths;
    }
}

#[test]
fn a_face_whose_edges_are_elsewhere_is_refused() {
    let mut model = ModelBuilder::default();
    let rim = model.circle(1.0, 0.5);
    model.face(FaceSurface::Plane(WORLD), true, &[(rim, true)]);
    let refused = trimmed_faces(&model.0).faces.remove(0).unwrap_err();
    assert!(
        matches!(refused, FaceRefusal::StrayingEdge { edge: EntityId(1000), distance } if distance >= 0.5),
        "{refused}"
    );
}

#[test]
fn small_and_large_solids_are_measured_alike() {
    for scale in [1e-4, 1e4] {
        let mut model = ModelBuilder::default();
        let (bottom, top) = (model.circle(2.0 * scale, 0.0), model.circle(2.0 * scale, 3.0 * scale));
        let side = FaceSurface::Cylinder { placement: WORLD, radius: 2.0 * scale };
        model.face(side, true, &[(bottom, true), (top, false)]);
        model.face(FaceSurface::Plane(at_height(3.0 * scale)), true, &[(top, true)]);
        model.face(FaceSurface::Plane(WORLD), false, &[(bottom, false)]);
        assert_measures(&model.faces(), 20.0 * PI * scale * scale, 12.0 * PI * scale.powi(3));
    }
}

/// The angle between the normals of two faces along an edge of which each has one.
fn angle(faces: &[TrimmedFace], [a, b]: [usize; 2], edge: usize) -> f64 {
    let [a, b] = [a, b].map(|face| faces[face].edge_normals.iter().find(|n| n.edge == edge).unwrap());
    a.angle_to(b)
}

#[test]
fn normals_along_an_edge_tell_whether_faces_continue_each_other() {
    // A cylinder with a hemisphere on it, closed by a disk below: a cap of a ball of radius 1 about (0, 0, 2).
    let mut model = ModelBuilder::default();
    let (bottom, rim) = (model.circle(1.0, 0.0), model.circle(1.0, 2.0));
    model.face(
        FaceSurface::Cylinder { placement: WORLD, radius: 1.0 },
        true,
        &[(bottom, true), (rim, false)],
    );
    model.face(FaceSurface::Sphere { placement: at_height(2.0), radius: 1.0 }, true, &[(rim, true)]);
    model.face(FaceSurface::Plane(WORLD), false, &[(bottom, false)]);
    assert!(trimmed_faces(&model.0).edges.is_none());
    let trimmed = trimmed_faces_with_edges(&model.0);
    let faces: Vec<TrimmedFace> = trimmed.faces.into_iter().map(Result::unwrap).collect();
    assert!(angle(&faces, [0, 1], rim) < 1e-7);
    assert!((angle(&faces, [0, 2], bottom) - FRAC_PI_4 * 2.0).abs() < 1e-7);
    let edges = trimmed.edges.unwrap();
    let polyline = edges[rim].as_ref().unwrap();
    assert!((polyline.length - TAU).abs() < 1e-9 && polyline.points.len() > 49);
    assert!(polyline.points.iter().all(|p| (p.truncate().length() - 1.0).abs() < 1e-12 && p.z == 2.0));
}

#[test]
fn polylines_end_when_they_may_not_proceed() {
    let mut model = ModelBuilder::default();
    let (bottom, top) = (model.circle(1.0, 0.0), model.circle(1.0, 2.0));
    model.face(
        FaceSurface::Cylinder { placement: WORLD, radius: 1.0 },
        true,
        &[(bottom, true), (top, false)],
    );
    let within = |with_edges: bool, questions: usize| {
        let asked = AtomicUsize::new(0);
        let proceed = || asked.fetch_add(1, Ordering::Relaxed) < questions;
        trimmed_faces_while(&model.0, with_edges, &proceed).is_some()
    };
    // Two edges, one face twice, and two polylines.
    assert!(within(false, 4) && !within(false, 3));
    assert!(within(true, 6) && !within(true, 5) && !within(true, 4));
}

#[test]
fn face_beside_a_fold_lies_on_the_part_of_the_offset_before_it() {
    // The planes y = 0 and x = 1, and a rectangle 0.1 above the first.
    let points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)];
    let points = points.iter().flat_map(|&(x, y)| [0.0, 1.0].map(|z| DVec4::new(x, y, z, 1.0)));
    let knots = [vec![0.0, 0.0, 1.0, 2.0, 2.0], vec![0.0, 0.0, 1.0, 1.0]];
    let fold = NurbsSurface::try_new([1, 1], knots, points.collect()).unwrap();
    // In the second case up to the mitre, which is as far from the one plane as from the other.
    for end in [0.8, 0.9] {
        let mut model = ModelBuilder::default();
        let corners = [(0.2, 0.1), (0.2, 0.9), (end, 0.9), (end, 0.1)];
        // The normal of the first plane is against y.
        model.0.vertices.extend(corners.map(|(x, z)| DVec3::new(x, 0.1, z)));
        let edges: Vec<usize> = (0..4).map(|i| model.edge([i, (i + 1) % 4], None)).collect();
        let oriented = edges.into_iter().map(|edge| OrientedEdge { edge, forward: true }).collect();
        let basis = Box::new(FaceSurface::Spline(fold.clone()));
        let loops = vec![BoundaryLoop::Edges(oriented)];
        model.bounded(FaceSurface::Offset { basis, distance: -0.1 }, false, loops);
        let [face] = model.faces().try_into().unwrap();
        assert_close(face.measure(1e-9).area, (end - 0.2) * 0.8);
    }
}

#[test]
fn areas_hold_where_weights_make_parameters_uneven() {
    // The unit square, of which the first thousandth of u is most.
    let points = [(0.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 0.0, 1e3), (1.0, 1.0, 1e3)];
    let points = points.map(|(x, y, w)| DVec4::new(w * x, w * y, 0.0, w)).to_vec();
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    let surface = NurbsSurface::try_new([1, 1], [knots(), knots()], points).unwrap();
    let face = TrimmedFace {
        geometry: FaceGeometry::Spline(surface),
        to_part: DMat4::IDENTITY,
        reversed: false,
        trim: None,
        width: 0.0,
        repairs: Vec::new(),
        edge_normals: Vec::new(),
    };
    let area = face.measure(1e-9).area;
    assert!((area - 1.0).abs() < 1e-8, "{area}");
}
