//! Faces, shells and bodies.

use glanz_brep::model::{BoundaryLoop, FaceSurface, OrientedEdge};
use glanz_scene::Description;

use super::*;
use crate::cad::{CadFaceOutcome, CadModel};

/// Points of a tetrahedron with their vertices #51 to #54, straight edges #61 to #66, a plane #10, and a triangle of them as the loop #70.
const TETRAHEDRON: &str = "#41=CARTESIAN_POINT('',(0.,0.,0.));#42=CARTESIAN_POINT('',(1000.,0.,0.));
    #43=CARTESIAN_POINT('',(0.,1000.,0.));#44=CARTESIAN_POINT('',(0.,0.,1000.));
    #51=VERTEX_POINT('',#41);#52=VERTEX_POINT('',#42);#53=VERTEX_POINT('',#43);#54=VERTEX_POINT('',#44);
    #61=EDGE_CURVE('',#51,#52,#67,.T.);#62=EDGE_CURVE('',#52,#53,#67,.F.);#63=EDGE('',#53,#51);
    #67=POLYLINE('',(#41,#42));#10=PLANE('',#11);#11=AXIS2_PLACEMENT_3D('',#41,$,$);
    #70=EDGE_LOOP('',(#71,#72,#73));#71=ORIENTED_EDGE('',*,*,#61,.T.);#72=ORIENTED_EDGE('',*,*,#62,.F.);
    #73=ORIENTED_EDGE('',*,*,#63,.T.);#74=ORIENTED_EDGE('',*,*,#73,.F.);#80=POLY_LOOP('',(#41,#42,#43));";

fn shown(items: &str, data: &str) -> BrepFile {
    file(&format!("{MILLIMETRES}{TETRAHEDRON}#1=SHAPE_REPRESENTATION('r',({items}),#910);{data}"))
}

fn edge(edge: usize, forward: bool) -> OrientedEdge {
    OrientedEdge { edge, forward }
}

#[test]
fn orientation_of_a_bound_is_applied_to_its_loop() {
    let loop_of = |orientation: &str| {
        let data = format!("#2=FACE_SURFACE('',(#3),#10,.F.);#3=FACE_OUTER_BOUND('',#70,.{orientation}.);");
        let file = shown("#2", &data);
        let face = &file.model.faces[0];
        assert!(face.bounds[0].outer && !face.same_sense);
        let BoundaryLoop::Edges(edges) = face.bounds[0].boundary.clone() else { panic!() };
        let senses: Vec<bool> = file.model.edges.iter().map(|edge| edge.same_sense).collect();
        assert_eq!(senses, [true, false, true]);
        assert_eq!(file.model.edges[2].curve, None);
        edges
    };
    assert_eq!(loop_of("T"), [edge(0, true), edge(1, false), edge(2, true)]);
    assert_eq!(loop_of("F"), [edge(2, false), edge(1, true), edge(0, false)]);
}

#[test]
fn oriented_edge_of_an_oriented_edge_is_turned_twice() {
    let data = "#2=ADVANCED_FACE('',(#3),#10,.T.);#3=FACE_BOUND('',#4,.T.);#4=EDGE_LOOP('',(#74));";
    let file = shown("#2", data);
    assert!(
        matches!(&file.model.faces[0].bounds[0].boundary, BoundaryLoop::Edges(e) if *e == [edge(0, false)])
    );
}

#[test]
fn polygons_and_single_vertices_are_loops() {
    let data = "#2=ADVANCED_FACE('',(#3,#4),#10,.T.);#3=FACE_BOUND('',#80,.F.);#4=FACE_BOUND('',#5,.T.);#5=VERTEX_LOOP('',#54);";
    let file = shown("#2", data);
    let [polygon, vertex] = file.model.faces[0].bounds.as_slice() else { panic!() };
    let expected = [DVec3::ZERO, DVec3::Y, DVec3::X];
    assert_eq!(file.model.polygon(&polygon.boundary).unwrap(), expected);
    assert!(matches!(vertex.boundary, BoundaryLoop::Vertex(i) if file.model.vertices[i] == DVec3::Z));
}

#[test]
fn face_without_a_surface_has_the_plane_of_its_polygon() {
    let file = shown("#2", "#2=FACE('',(#3));#3=FACE_OUTER_BOUND('',#80,.F.);");
    let FaceSurface::Plane(placement) = &file.model.surfaces[0].surface else { panic!() };
    assert_near(placement.z, -DVec3::Z);
}

/// Faces #21 to #24 without bounds.
const FACES: &str =
    "#21=ADVANCED_FACE('a',(),#10,.T.);#22=ADVANCED_FACE('b',(),#10,.T.);#23=ADVANCED_FACE('c',(),#10,.T.);
    #24=ORIENTED_FACE('',*,#22,.F.);";

#[test]
fn solid_with_voids_has_its_outer_shell_first_and_turned_voids() {
    let file = shown(
        "#2",
        &format!(
            "{FACES}#2=BREP_WITH_VOIDS('body',#3,(#4));#3=CLOSED_SHELL('',(#21,#24));#4=ORIENTED_CLOSED_SHELL('',*,#5,.F.);
             #5=CLOSED_SHELL('',(#23,#24));"
        ),
    );
    assert_eq!(omissions(&file), [""; 0]);
    let body = &file.model.parts[0].bodies[0];
    assert_eq!((body.name.as_str(), body.solid, body.entity.0), ("body", true, 2));
    let [outer, void] = body.shells.as_slice() else { panic!() };
    assert_eq!((outer.faces.as_slice(), outer.closed), (&[(0, false), (1, true)][..], true));
    assert_eq!((void.faces.as_slice(), void.closed), (&[(2, true), (1, false)][..], true));
    assert_eq!((file.report.faces.total, file.report.faces.read), (3, 3));
}

#[test]
fn surface_models_of_all_kinds_are_bodies() {
    let data = format!(
        "{FACES}#2=SHELL_BASED_SURFACE_MODEL('',(#3,#4));#3=OPEN_SHELL('',(#21));#4=CLOSED_SHELL('',(#22));
         #5=FACE_BASED_SURFACE_MODEL('',(#6));#6=CONNECTED_FACE_SET('',(#23));#7=GEOMETRIC_SET('',(#8,#10));
         #8=SPHERICAL_SURFACE('',#11,1.);"
    );
    let file = shown("#2,#5,#3,#7,#11,#41", &data);
    let part = &file.model.parts[0];
    let shape: Vec<(bool, usize)> = part.bodies.iter().map(|body| (body.solid, body.shells.len())).collect();
    assert_eq!(shape, [(false, 2), (false, 1), (false, 1), (false, 1)]);
    assert_eq!(part.bodies[0].shells.iter().map(|s| s.closed).collect::<Vec<_>>(), [false, true]);
    assert_eq!(
        omissions(&file),
        [
            "#7: #10: the surface has no boundary",
            "#41: CARTESIAN_POINT is no solid, shell or surface; it is not shown"
        ]
    );
}

#[test]
fn faces_are_counted_by_their_outcome() {
    let data = format!(
        "{FACES}#2=MANIFOLD_SOLID_BREP('',#3);#3=CLOSED_SHELL('',(#21,#25,#25,#99,#26));#25=ADVANCED_FACE('',(),#98,.T.);
         #26=ADVANCED_FACE('',(),#10,.T.);#27=INVISIBILITY((#28));#28=STYLED_ITEM('',(),#26);"
    );
    let file = shown("#2", &data);
    let faces = file.report.faces;
    assert_eq!([faces.total, faces.read, faces.refused, faces.hidden, faces.unreachable], [5, 1, 1, 1, 2]);
    assert_eq!(
        omissions(&file),
        ["#25: #98 does not exist", "#3: #99 does not exist", "#26: the file hides it"]
    );
    assert!(!file.model.parts[0].bodies[0].shells[0].closed);
}

#[test]
fn curve_used_by_many_edges_does_not_fill_the_memory() {
    let points = "#41,".repeat(3000);
    let edges: String =
        (0..3000).map(|i| format!("#{}=EDGE_CURVE('',#51,#51,#300,.T.);", 1000 + i)).collect();
    let oriented: String =
        (0..3000).map(|i| format!("#{}=ORIENTED_EDGE('',*,*,#{},.T.);", 5000 + i, 1000 + i)).collect();
    let faces: String = (0..3000)
        .map(|i| {
            let [face, bound, edge_loop] = [10_000 + i, 20_000 + i, 30_000 + i];
            format!(
                "#{face}=ADVANCED_FACE('',(#{bound}),#10,.T.);#{bound}=FACE_BOUND('',#{edge_loop},.T.);\
                 #{edge_loop}=EDGE_LOOP('',(#{}));",
                5000 + i
            )
        })
        .collect();
    let list: Vec<String> = (0..3000).map(|i| format!("#{}", 10_000 + i)).collect();
    let data = format!(
        "#300=POLYLINE('',({points}#42));{edges}{oriented}{faces}#2=OPEN_SHELL('',({}));",
        list.join(",")
    );
    let file = shown("#2", &data);
    let size = text(&data).len();
    assert!(file.report.faces.read > 10 && file.report.faces.refused > 1000);
    assert!(file.report.faces.read * 3000 < 3 * size);
    assert!(omissions(&file)[0].contains("repeats its geometry too often"));
}

#[test]
fn surface_bounded_by_curves_is_a_face_with_edges() {
    let data = "#2=GEOMETRIC_SET('',(#3));#3=CURVE_BOUNDED_SURFACE('cut',#10,(#4,#5),.F.);#4=OUTER_BOUNDARY_CURVE('',(#6,#7),.F.);
        #6=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#8);#7=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.F.,#9);#8=POLYLINE('',(#41,#42));
        #9=POLYLINE('',(#41,#43,#42));#5=BOUNDARY_CURVE('',(#20),.F.);#20=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#21);
        #21=SURFACE_CURVE('',#22,(),.CURVE_3D.);#22=CIRCLE('',#11,100.);";
    let file = shown("#2", data);
    assert_eq!(omissions(&file), [""; 0]);
    let face = &file.model.faces[0];
    assert_eq!((face.name.as_str(), face.bounds[0].outer, face.bounds[1].outer), ("cut", true, false));
    assert!(
        matches!(&face.bounds[0].boundary, BoundaryLoop::Edges(e) if *e == [edge(0, true), edge(1, false)])
    );
    let ends: Vec<[DVec3; 2]> =
        file.model.edges.iter().map(|edge| [edge.start, edge.end].map(|i| file.model.vertices[i])).collect();
    assert_eq!(ends[..2], [[DVec3::ZERO, DVec3::X], [DVec3::ZERO, DVec3::X]]);
    assert_eq!((ends[2][0], file.model.edges[2].start), (DVec3::X * 0.1, file.model.edges[2].end));
}

#[test]
fn boundary_without_ends_is_refused() {
    let data =
        "#2=GEOMETRIC_SET('',(#3));#3=CURVE_BOUNDED_SURFACE('',#10,(#4),.F.);#4=BOUNDARY_CURVE('',(#6),.F.);
        #6=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#8);#8=PARABOLA('',#11,1.);";
    assert_eq!(omissions(&shown("#2", data)), ["#2: #8: the segment of a boundary has no ends"]);
}

#[test]
fn surface_that_ends_at_its_own_border_says_so() {
    let bounds = |implicit: &str| {
        let data = format!(
            "#2=GEOMETRIC_SET('',(#3));#3=CURVE_BOUNDED_SURFACE('',#4,(#5),{implicit});
             #4=RECTANGULAR_TRIMMED_SURFACE('',#10,-5.,5.,-5.,5.,.T.,.T.);#5=BOUNDARY_CURVE('',(#20),.F.);
             #20=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.F.,#22);#22=CIRCLE('',#11,1.);"
        );
        let mut description = Description::default();
        let model = CadModel::read(
            text(&format!("{MILLIMETRES}{TETRAHEDRON}#1=SHAPE_REPRESENTATION('r',(#2),#910);{data}"))
                .as_bytes(),
            false,
        )
        .unwrap();
        let report = model.into_world(&mut description);
        assert_eq!(report.reading.omissions.notes(), []);
        let loops = description.world.shapes.iter().filter_map(|shape| shape.trim.as_ref());
        loops.map(|trim| trim.loops.len()).collect::<Vec<_>>()
    };
    assert_eq!(bounds(".T."), [2]);
    assert_eq!(bounds(".F."), [1]);
    assert_eq!(bounds("$"), [1]);
}

#[test]
fn plane_of_a_face_between_polygons_is_that_of_the_largest() {
    // The hole, which runs the other way, is named first.
    let data = "#2=FACE('',(#3,#4));#3=FACE_BOUND('',#5,.T.);#4=FACE_BOUND('',#80,.T.);#5=POLY_LOOP('',(#91,#92,#93));
        #91=CARTESIAN_POINT('',(100.,100.,0.));#92=CARTESIAN_POINT('',(100.,200.,0.));#93=CARTESIAN_POINT('',(200.,100.,0.));";
    let file = shown("#2", data);
    let FaceSurface::Plane(plane) = file.model.surfaces[file.model.faces[0].surface].surface else {
        panic!()
    };
    assert_eq!(plane.z, DVec3::Z);
}

#[test]
fn one_face_that_no_scene_takes_leaves_the_others() {
    let data =
        "#2=GEOMETRIC_SET('',(#3,#4));#3=SPHERICAL_SURFACE('',#11,1.E30);#4=SPHERICAL_SURFACE('',#11,1.);";
    let bytes = text(&format!("{MILLIMETRES}{TETRAHEDRON}#1=SHAPE_REPRESENTATION('r',(#2),#910);{data}"));
    let mut description = Description::default();
    let report = CadModel::read(bytes.as_bytes(), false).unwrap().into_world(&mut description);
    assert_eq!(description.world.shapes.len(), 1);
    assert!(
        matches!(&report.faces[0].outcome, CadFaceOutcome::Refused(reason) if reason.contains("coordinate"))
    );
    assert_eq!(report.faces[0].entity.0, 3);
}

#[test]
fn searches_on_composite_curves_take_time_in_proportion_to_the_file() {
    let segments: String = (0..20_000)
        .map(|i| format!("#{}=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#67);", 1000 + i))
        .collect();
    let list: Vec<String> = (0..20_000).map(|i| format!("#{}", 1000 + i)).collect();
    // Many curves are cut out of a composite one, or out of a part of it.
    let cut: String = (0..50)
        .map(|i| {
            let [curve, part, edge] = [100_000 + i, 110_000 + i, 120_000 + i];
            format!(
                "#{curve}=TRIMMED_CURVE('',#900000,(#41),(#42),.T.,.CARTESIAN.);
                 #{part}=TRIMMED_CURVE('',#{curve},(#41),(#42),.T.,.CARTESIAN.);#{edge}=EDGE_CURVE('',#51,#52,#{part},.T.);"
            )
        })
        .collect();
    let edges: Vec<String> = (0..50).map(|i| format!("#{}", 120_000 + i)).collect();
    let data = format!(
        "{segments}#900000=COMPOSITE_CURVE('',({}),.F.);{cut}#2=ADVANCED_FACE('',(#3),#10,.T.);
         #3=FACE_BOUND('',#4,.T.);#4=EDGE_LOOP('',({}));",
        list.join(","),
        edges.join(",")
    );
    let file = shown("#2", &data);
    assert!(omissions(&file)[0].contains("repeats its geometry too often"), "{:?}", omissions(&file));
}
