//! Small files, with facts that follow from the standards.

mod assemblies;
mod curves;
mod edges;
mod faces;
mod hidden;
mod styles;
mod surfaces;
mod units;

use glanz_math::DVec3;

use super::read;
use crate::cad::BrepFile;
use crate::cad::testing::{self, assert_near, omissions};

/// A context with the number 910 in millimetres and radians.
const MILLIMETRES: &str = "#900=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
    #901=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
    #902=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.5),#900,'distance_accuracy_value','');
    #910=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#902))
    GLOBAL_UNIT_ASSIGNED_CONTEXT((#900,#901))REPRESENTATION_CONTEXT('',''));";

/// A context with the number 910 in inches and degrees.
const INCHES: &str = "#900=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.CENTI.,.METRE.));
    #901=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
    #903=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(2.54),#900);
    #904=(CONVERSION_BASED_UNIT('FURLONG',#903)LENGTH_UNIT()NAMED_UNIT(#906));
    #905=PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.017453292519943295),#901);
    #906=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);
    #907=(CONVERSION_BASED_UNIT('DEGREE',#905)NAMED_UNIT(#906)PLANE_ANGLE_UNIT());
    #902=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.5),#904,'distance_accuracy_value','');
    #910=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#902))
    GLOBAL_UNIT_ASSIGNED_CONTEXT((#904,#907))REPRESENTATION_CONTEXT('',''));";

/// One face without bounds on the surface #10, in a representation in the context #910, and a placement #30 at (1, 2, 3) whose axis is x and
/// whose reference direction is y.
const ONE_FACE: &str =
    "#1=ADVANCED_FACE('f',(),#10,.T.);#2=OPEN_SHELL('',(#1));#3=SHELL_BASED_SURFACE_MODEL('m',(#2));
    #4=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('r',(#3),#910);#30=AXIS2_PLACEMENT_3D('',#31,#32,#33);
    #31=CARTESIAN_POINT('',(1.,2.,3.));#32=DIRECTION('',(2.,0.,0.));#33=DIRECTION('',(5.,1.,0.));";

fn text(data: &str) -> String {
    format!(
        "ISO-10303-21;HEADER;FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;{data}ENDSEC;END-ISO-10303-21;"
    )
}

fn file(data: &str) -> BrepFile {
    read(text(data).as_bytes()).unwrap()
}

/// A file in which nothing is wrong.
fn clean(data: &str) -> BrepFile {
    testing::clean(file(data))
}
