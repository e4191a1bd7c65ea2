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

proptest! {
    #![proptest_config(testing::config(2000))]

    #[test]
    fn any_change_of_a_file_gives_a_model_or_an_error(changes in testing::changes()) {
        let bytes = testing::damaged(sample().into_bytes(), changes, MEANINGFUL);
        testing::check(&bytes, read)?;
    }
}
