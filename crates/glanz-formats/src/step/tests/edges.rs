//! Edges in descriptions.

use std::f64::consts::{FRAC_PI_2, TAU};

use glanz_brep::model::BoundaryLoop;
use glanz_scene::Description;
use glanz_scene::description::{EdgeDescription, EdgeKind, EdgeTransition};

use super::*;
use crate::cad::CadModel;

/// A cylinder of radius 2 and height 3, millimetres, of a side with a seam and two disks.
const CYLINDER: &str = "#1=MANIFOLD_SOLID_BREP('c',#2);#2=CLOSED_SHELL('',(#10,#20,#40));
    #4=ADVANCED_BREP_SHAPE_REPRESENTATION('r',(#1),#910);
    #10=ADVANCED_FACE('side',(#11),#12,.T.);#11=FACE_OUTER_BOUND('',#13,.T.);#12=CYLINDRICAL_SURFACE('',#50,2.);
    #13=EDGE_LOOP('',(#14,#15,#16,#17));#14=ORIENTED_EDGE('',*,*,#60,.T.);#15=ORIENTED_EDGE('',*,*,#62,.T.);
    #16=ORIENTED_EDGE('',*,*,#61,.F.);#17=ORIENTED_EDGE('',*,*,#62,.F.);
    #20=ADVANCED_FACE('top',(#21),#22,.T.);#21=FACE_OUTER_BOUND('',#23,.T.);#22=PLANE('',#51);#23=EDGE_LOOP('',(#24));
    #24=ORIENTED_EDGE('',*,*,#61,.T.);
    #40=ADVANCED_FACE('bottom',(#41),#42,.F.);#41=FACE_OUTER_BOUND('',#43,.T.);#42=PLANE('',#50);#43=EDGE_LOOP('',(#44));
    #44=ORIENTED_EDGE('',*,*,#60,.F.);
    #50=AXIS2_PLACEMENT_3D('',#52,#54,#55);#51=AXIS2_PLACEMENT_3D('',#53,#54,#55);
    #52=CARTESIAN_POINT('',(0.,0.,0.));#53=CARTESIAN_POINT('',(0.,0.,3.));#54=DIRECTION('',(0.,0.,1.));#55=DIRECTION('',(1.,0.,0.));
    #60=EDGE_CURVE('',#63,#63,#65,.T.);#61=EDGE_CURVE('',#64,#64,#66,.T.);#62=EDGE_CURVE('',#63,#64,#67,.T.);
    #63=VERTEX_POINT('',#68);#64=VERTEX_POINT('',#69);#65=CIRCLE('',#50,2.);#66=CIRCLE('',#51,2.);#67=LINE('',#68,#70);
    #68=CARTESIAN_POINT('',(2.,0.,0.));#69=CARTESIAN_POINT('',(2.,0.,3.));#70=VECTOR('',#54,1.);";

/// A cube of unit polygons, without its top.
const OPEN_BOX: &str =
    "#1=SHELL_BASED_SURFACE_MODEL('b',(#2));#2=OPEN_SHELL('',(#10,#11,#12,#13,#14));
    #4=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('r',(#1),#910);
    #10=FACE('',(#20));#11=FACE('',(#21));#12=FACE('',(#22));#13=FACE('',(#23));#14=FACE('',(#24));
    #20=FACE_OUTER_BOUND('',#30,.T.);#21=FACE_OUTER_BOUND('',#31,.T.);#22=FACE_OUTER_BOUND('',#32,.T.);
    #23=FACE_OUTER_BOUND('',#33,.T.);#24=FACE_OUTER_BOUND('',#34,.T.);
    #30=POLY_LOOP('',(#40,#42,#43,#41));#31=POLY_LOOP('',(#40,#41,#45,#44));#32=POLY_LOOP('',(#41,#43,#47,#45));
    #33=POLY_LOOP('',(#43,#42,#46,#47));#34=POLY_LOOP('',(#42,#40,#44,#46));
    #40=CARTESIAN_POINT('',(0.,0.,0.));#41=CARTESIAN_POINT('',(1.,0.,0.));#42=CARTESIAN_POINT('',(0.,1.,0.));
    #43=CARTESIAN_POINT('',(1.,1.,0.));#44=CARTESIAN_POINT('',(0.,0.,1.));#45=CARTESIAN_POINT('',(1.,0.,1.));
    #46=CARTESIAN_POINT('',(0.,1.,1.));#47=CARTESIAN_POINT('',(1.,1.,1.));";

fn edges(data: &str, wanted: bool) -> Vec<EdgeDescription> {
    let mut description = Description::default();
    CadModel::read(text(&format!("{MILLIMETRES}{data}")).as_bytes(), wanted)
        .unwrap()
        .into_world(&mut description);
    let groups = description.groups.into_iter().chain([description.world]);
    groups.flat_map(|group| group.edges).collect()
}

#[test]
fn a_cylinder_has_two_circles_and_a_seam() {
    let edges = edges(CYLINDER, true);
    assert_eq!(edges.len(), 3);
    let (seams, circles): (Vec<_>, Vec<_>) = edges.iter().partition(|edge| edge.kind == EdgeKind::Line);
    for (edge, [z, other]) in circles.iter().zip([[0.0, 2.0], [3e-3, 1.0]]) {
        let EdgeKind::Circle { center, axis, radius } = edge.kind else { panic!("{:?}", edge.kind) };
        assert!((radius - 2e-3).abs() < 1e-15 && center.distance(DVec3::Z * z) < 1e-15);
        assert!(axis.cross(DVec3::Z).length() < 1e-12);
        assert!((edge.length - 2e-3 * TAU).abs() < 1e-12 && edge.is_closed());
        assert_eq!(
            (edge.transition, edge.shapes.as_slice()),
            (EdgeTransition::Sharp, &[0, other as usize][..])
        );
        assert!((edge.angle - FRAC_PI_2).abs() < 1e-7);
        let off = edge.points.windows(2).map(|side| {
            let middle = 0.5 * (side[0] + side[1]);
            2e-3 - (middle - center).length()
        });
        assert!(off.fold(0.0, f64::max) <= edge.deviation && edge.deviation < 1e-5);
    }
    assert_eq!((seams.len(), seams[0].transition), (1, EdgeTransition::Seam));
    assert_eq!(seams[0].shapes, [0, 0]);
    assert!((seams[0].length - 3e-3).abs() < 1e-15 && !seams[0].transition.is_feature());
}

#[test]
fn sides_of_polygons_are_edges() {
    let edges = edges(OPEN_BOX, true);
    let of = |transition| edges.iter().filter(|edge| edge.transition == transition).count();
    assert_eq!((of(EdgeTransition::Sharp), of(EdgeTransition::Border), edges.len()), (8, 4, 12));
    for edge in edges.iter().filter(|edge| edge.transition == EdgeTransition::Sharp) {
        assert!((edge.angle - FRAC_PI_2).abs() < 1e-12 && edge.length == 1e-3, "{edge:?}");
    }
}

#[test]
fn sign_of_a_zero_parts_no_sides() {
    // The first polygon has corners of its own at those that it shares.
    let negative = OPEN_BOX
        .replace("#30=POLY_LOOP('',(#40,#42,#43,#41));", "#30=POLY_LOOP('',(#60,#42,#43,#61));")
        + "#60=CARTESIAN_POINT('',(-0.,0.,-0.));#61=CARTESIAN_POINT('',(1.,-0.,0.));";
    assert_eq!(edges(&negative, true).len(), 12);
}

#[test]
fn faces_between_polygons_share_edges_and_vertices() {
    // The last polygon has points of its own, and its first corner twice.
    let own = OPEN_BOX
        .replace("#34=POLY_LOOP('',(#42,#40,#44,#46));", "#34=POLY_LOOP('',(#62,#60,#44,#46,#62));")
        + "#60=CARTESIAN_POINT('',(0.,0.,0.));#62=CARTESIAN_POINT('',(0.,1.,0.));";
    for data in [OPEN_BOX, &own] {
        let model = clean(&format!("{MILLIMETRES}{data}")).model;
        assert_eq!((model.vertices.len(), model.edges.len()), (8, 12));
        let uses = |edge: usize| {
            let bounds = model.faces.iter().flat_map(|face| &face.bounds);
            let edges = bounds.filter_map(|bound| match &bound.boundary {
                BoundaryLoop::Edges(edges) => Some(edges),
                _ => None,
            });
            edges
                .flatten()
                .filter(|oriented| oriented.edge == edge)
                .map(|oriented| oriented.forward)
                .collect()
        };
        let all: Vec<Vec<bool>> = (0..12).map(uses).collect();
        // Neighbours run through an edge in opposite directions.
        assert_eq!(all.iter().filter(|uses| matches!(uses[..], [a, b] if a != b)).count(), 8);
        assert_eq!(all.iter().filter(|uses| uses.len() == 1).count(), 4);
    }
    let point = OPEN_BOX.replace("(#42,#40,#44,#46)", "(#42,#42,#42)");
    let omissions = omissions(&file(&format!("{MILLIMETRES}{point}")));
    assert!(omissions.len() == 1 && omissions[0].contains("#34: the polygon is a point"), "{omissions:?}");
}

#[test]
fn polygons_of_other_bodies_have_edges_of_their_own() {
    let second = OPEN_BOX.replace('#', "#5").replace("#5910", "#910");
    let model = clean(&format!("{MILLIMETRES}{OPEN_BOX}{second}")).model;
    assert_eq!((model.vertices.len(), model.edges.len(), model.faces.len()), (16, 24, 10));
}

#[test]
fn edges_are_left_out_unless_they_are_wanted() {
    assert_eq!(edges(CYLINDER, false).len() + edges(OPEN_BOX, false).len(), 0);
}
