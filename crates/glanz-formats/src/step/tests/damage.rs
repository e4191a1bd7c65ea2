//! Damaged files.

use glanz_scene::Description;
use proptest::prelude::*;

use super::*;
use crate::cad::CadModel;

/// A file with all kinds of entities that refer to one another.
fn sample() -> String {
    text(&format!(
        "{MILLIMETRES}{ONE_FACE}#10=CYLINDRICAL_SURFACE('',#30,2.);#40=PRODUCT_DEFINITION('','',#41,$);
         #41=PRODUCT_DEFINITION_FORMATION('','',#42);#42=PRODUCT('id','name\\X2\\03A6\\X0\\','',());#43=PRODUCT_DEFINITION_SHAPE('','',#40);
         #44=SHAPE_DEFINITION_REPRESENTATION(#43,#4);#50=ADVANCED_FACE('',(#51),#10,.T.);#51=FACE_BOUND('',#52,.F.);
         #52=EDGE_LOOP('',(#53));#53=ORIENTED_EDGE('',*,*,#54,.T.);#54=EDGE_CURVE('',#55,#55,#56,.T.);#55=VERTEX_POINT('',#31);
         #56=SEAM_CURVE('',#57,(#58,#58),.PCURVE_S1.);#57=TRIMMED_CURVE('',#60,(#31),(PARAMETER_VALUE(1.)),.T.,.CARTESIAN.);
         #58=PCURVE('',#10,#59);#59=DEFINITIONAL_REPRESENTATION('',(#61),#910);#60=CIRCLE('',#30,2.);
         #61=B_SPLINE_CURVE_WITH_KNOTS('',1,(#62,#63,#63,#62),.U.,.F.,.F.,(2,2,2),(0.,1.,2.),.U.);#62=CARTESIAN_POINT('',(0.,1.));
         #63=CARTESIAN_POINT('',(6.,1.));#64=OPEN_SHELL('',(#1,#50,#80,#82));#65=STYLED_ITEM('',(#66),#64);
         #66=PRESENTATION_STYLE_ASSIGNMENT((#67));#67=SURFACE_STYLE_USAGE(.BOTH.,#68);#68=SURFACE_SIDE_STYLE('',(#69));
         #69=SURFACE_STYLE_RENDERING(.X.,#70);#70=COLOUR_RGB('',1.,0.,0.);#71=MAPPED_ITEM('',#72,#30);#72=REPRESENTATION_MAP(#30,#73);
         #73=SHAPE_REPRESENTATION('',(#64,#74),#910);#74=OFFSET_SURFACE('',#75,1.,.F.);
         #75=BEZIER_SURFACE('',1,1,((#31,#31),(#31,#31)),.U.,.F.,.F.,.F.);#76=SHAPE_REPRESENTATION_RELATIONSHIP('','',#4,#77);
         #77=SHAPE_REPRESENTATION('',(#71),#910);
         #80=ADVANCED_FACE('',(),#81,.T.);#81=SPHERICAL_SURFACE('',#30,2.);#82=ADVANCED_FACE('',(#84),#83,.T.);#83=PLANE('',#30);
         #84=FACE_BOUND('',#85,.T.);#85=EDGE_LOOP('',(#86));#86=ORIENTED_EDGE('',*,*,#87,.T.);#87=EDGE_CURVE('',#88,#88,#60,.T.);
         #88=VERTEX_POINT('',#89);#89=CARTESIAN_POINT('',(1.,4.,3.));"
    ))
}

#[test]
fn sample_is_read_without_damage() {
    let file = read(sample().as_bytes()).unwrap();
    assert_eq!((file.report.faces.total, file.report.faces.read), (4, 4));
    assert_eq!(file.model.parts.len(), 2);
    let model = CadModel::read(sample().as_bytes(), false).unwrap();
    // The sphere and the disc.
    assert_eq!(model.into_world(&mut Description::default()).shapes.len(), 2);
}

/// Bytes that mean something in a file.
const MEANINGFUL: &[u8] = b"#(),;='.$*/\\0123456789-EXTS\"!\n";

/// Number of damaged files; `GLANZ_FUZZ` multiplies it.
fn cases() -> u32 {
    2000 * std::env::var("GLANZ_FUZZ").ok().and_then(|v| v.parse().ok()).unwrap_or(1)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn any_change_of_a_file_gives_a_model_or_an_error(
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0_u8..4, any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut bytes = sample().into_bytes();
        for (at, kind, byte, any) in changes {
            let at = at.index(bytes.len());
            let meaningful = MEANINGFUL[byte.index(MEANINGFUL.len())];
            match kind {
                0 => bytes[at] = meaningful,
                1 => bytes[at] = any,
                2 => bytes.insert(at, meaningful),
                _ => drop(bytes.drain(at..(at + usize::from(any)).min(bytes.len() - 1).max(at))),
            }
        }
        // What a user runs: a scene.
        if let Ok(model) = CadModel::read(&bytes, true) {
            let mut description = Description::default();
            let report = model.into_world(&mut description);
            let groups: usize = description.groups.iter().map(|group| group.shapes.len()).sum();
            prop_assert_eq!(report.shapes.len(), groups + description.world.shapes.len());
        }
        if let Ok(file) = read(&bytes) {
            let faces = file.report.faces;
            prop_assert_eq!(faces.total, faces.read + faces.refused + faces.hidden + faces.unreachable);
            let model = &file.model;
            prop_assert!(model.faces.iter().all(|face| face.surface < model.surfaces.len()));
            for (i, part) in model.parts.iter().enumerate() {
                prop_assert!(part.occurrences.iter().all(|occurrence| occurrence.part < i));
            }
        }
    }
}
