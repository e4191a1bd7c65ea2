//! What a file hides.

use super::styles::{OCCURRENCE, SOLID, read_styles};
use super::*;

#[test]
fn hidden_bodies_are_left_out_and_reported() {
    for data in [
        "#30=STYLED_ITEM('',(#100),#24);#31=INVISIBILITY((#30));",
        "#30=PRESENTATION_LAYER_ASSIGNMENT('l','',(#24));#31=INVISIBILITY((#30));",
        "#30=STYLED_ITEM('',(#100),#24);#32=DRAUGHTING_MODEL('',(#30),#910);#31=INVISIBILITY((#32));",
    ] {
        let file = read_styles(data);
        assert_eq!((file.model.roots.len(), file.report.faces.hidden), (0, 2));
        assert_eq!(omissions(&file), ["#24: the file hides it"]);
    }
}

#[test]
fn hidden_things_of_all_kinds_are_left_out_counted_and_reported() {
    let mapped = "#31=MAPPED_ITEM('',#32,#11);#32=REPRESENTATION_MAP(#11,#25);#33=SHAPE_REPRESENTATION('',(#31),#910);";
    let product = "#300=PRODUCT_DEFINITION('','',$,$);#301=PRODUCT_DEFINITION_SHAPE('','',#300);
        #302=SHAPE_DEFINITION_REPRESENTATION(#301,#25);";
    for (context, hidden) in [
        ("", "#24"),
        ("", "#23"),
        ("", "#25"),
        (product, "#25"),
        (product, "#23"),
        (mapped, "#31"),
        (mapped, "#25"),
        (OCCURRENCE, "#400"),
        (OCCURRENCE, "#410"),
        (OCCURRENCE, "#25"),
    ] {
        let layer = format!("#90=PRESENTATION_LAYER_ASSIGNMENT('','',({hidden}));#91=INVISIBILITY((#90));");
        let styled = format!("#90=STYLED_ITEM('',(#100),{hidden});#91=INVISIBILITY((#90));");
        for data in [
            format!("{context}#91=INVISIBILITY(({hidden}));"),
            format!("{context}{layer}"),
            format!("{context}{styled}"),
        ] {
            let file = read_styles(&data);
            assert_eq!((file.model.roots.len(), file.report.faces.hidden), (0, 2), "{hidden}: {data}");
            let named = if hidden == "#410" { "#400" } else { hidden };
            assert_eq!(omissions(&file), [format!("{named}: the file hides it")], "{data}");
        }
    }
}

#[test]
fn what_is_placed_in_a_hidden_product_is_hidden_with_it() {
    // The shape #25 is not that of the product 300, but placed in it.
    let placed = OCCURRENCE.replace("(#301,#25)", "(#301,#26)")
        + "#26=SHAPE_REPRESENTATION('',(),#910);#27=(REPRESENTATION_RELATIONSHIP('','',#25,#26)
        REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#412)SHAPE_REPRESENTATION_RELATIONSHIP());";
    assert_eq!(read_styles(&placed).report.faces.read, 2);
    let file = read_styles(&(placed + "#90=INVISIBILITY((#400));"));
    assert_eq!((file.report.faces.hidden, file.report.faces.unreachable), (2, 0));
    assert_eq!(omissions(&file), ["#400: the file hides it"]);
}

#[test]
fn bodies_without_a_representation_are_hidden_too() {
    for hidden in ["#24", "#23"] {
        let data = format!("#30=INVISIBILITY(({hidden}));");
        let file =
            file(&format!("{MILLIMETRES}{}{data}", SOLID.replace("#25=SHAPE_REPRESENTATION", "#25=UNKNOWN")));
        assert_eq!((file.model.roots.len(), file.report.faces.hidden), (0, 2), "{hidden}");
    }
}
