//! Units of contexts in which not all can be read.

use glanz_brep::model::FaceSurface;

use super::*;

/// The radius in metres and the half angle in radians of a cone with 1 of each, the uncertainty in metres, and the repairs.
fn cone(context: &str) -> ([f64; 3], Vec<String>) {
    let file = file(&format!("{context}{ONE_FACE}#10=CONICAL_SURFACE('',#30,1.,1.);"));
    let FaceSurface::Cone { radius, half_angle, .. } = file.model.surfaces[0].surface else { panic!() };
    let repairs = file.report.repairs.notes().iter().map(ToString::to_string).collect();
    ([radius, half_angle, file.model.uncertainty], repairs)
}

/// A context with these units and measures; #900 is a metre, #901 a radian, and #902 an uncertainty of 0.5 metres.
fn context(units: &str, measures: &str, more: &str) -> String {
    format!(
        "#900=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.));#901=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
         #902=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.5),#900,'','');{more}
         #910=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({measures}))
         GLOBAL_UNIT_ASSIGNED_CONTEXT(({units}))REPRESENTATION_CONTEXT('',''));"
    )
}

#[test]
fn unreadable_unit_or_measure_costs_itself_only() {
    let bad = "#905=(NAMED_UNIT(*)LENGTH_UNIT()SI_UNIT(.HUGE.,.METRE.));#906=UNCERTAINTY_MEASURE_WITH_UNIT(.X.,#900,'','');";
    for (units, measures, repairs) in [
        ("#900,#901", "#902", 0),
        ("#905,#900,#901", "#902", 1),
        ("#900,#901,#905,#999,7", "#902", 3),
        ("#900,#901", "#906,#902", 1),
        ("#900,#901", "#999,#902,#906", 2),
    ] {
        let (values, notes) = cone(&context(units, measures, bad));
        assert_eq!((values, notes.len()), ([1.0, 1.0, 0.5], repairs), "{units} {measures}: {notes:?}");
    }
}

#[test]
fn prefix_matters_for_lengths_and_angles_only() {
    let (values, notes) =
        cone(&context("#900,#901,#905", "#902", "#905=(NAMED_UNIT(*)SI_UNIT(.HUGE.,.GRAM.)MASS_UNIT());"));
    assert_eq!((values, notes), ([1.0, 1.0, 0.5], vec![]));
}

#[test]
fn prefix_that_is_no_enumeration_is_refused() {
    let (values, notes) =
        cone(&context("#905,#901", "#902", "#905=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT('MILLI',.METRE.));"));
    assert_eq!((values[0], notes.len()), (1e-3, 2), "{notes:?}");
    assert!(notes[0].contains("prefix") && notes[1].contains("no unit of length"), "{notes:?}");
}

#[test]
fn missing_unit_of_angle_is_reported() {
    let (values, notes) = cone(&context("#900", "#902", ""));
    assert_eq!((values, notes.len()), ([1.0, 1.0, 0.5], 1), "{notes:?}");
    assert!(notes[0].contains("no unit of angle"), "{notes:?}");
}

#[test]
fn factors_whose_product_is_no_normal_number_are_refused() {
    for [first, second] in
        [["1.E-200", "1.E-200"], ["1.E200", "1.E200"], ["0.", "1."], ["1.E-160", "1.E-160"]]
    {
        let chain = format!(
            "#903=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({first}),#900);#904=(CONVERSION_BASED_UNIT('A',#903)LENGTH_UNIT()NAMED_UNIT(*));
             #905=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({second}),#904);#906=(CONVERSION_BASED_UNIT('B',#905)LENGTH_UNIT()NAMED_UNIT(*));"
        );
        let (values, notes) = cone(&context("#906,#901", "#902", &chain));
        assert_eq!((values[0], notes.len()), (1e-3, 2), "{first} {second}: {notes:?}");
    }
}
