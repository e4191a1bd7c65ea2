//! Colours, layers and what is hidden.

use glanz_brep::model::ColorStyle;

use super::*;

/// Two faces #21 and #22 in the shell #23 of the solid #24 of the representation #25.
const SOLID: &str =
    "#10=SPHERICAL_SURFACE('',#11,1.);#11=AXIS2_PLACEMENT_3D('',#12,$,$);#12=CARTESIAN_POINT('',(0.,0.,0.));
    #21=ADVANCED_FACE('',(),#10,.T.);#22=ADVANCED_FACE('',(),#10,.T.);#23=CLOSED_SHELL('',(#21,#22));
    #24=MANIFOLD_SOLID_BREP('',#23);#25=SHAPE_REPRESENTATION('',(#24),#910);";

/// A style `n` with the colour given as the entity `n + 5`.
fn style(n: usize, color: &str) -> String {
    let [usage, side, area, fill, last] = [n + 1, n + 2, n + 3, n + 4, n + 5];
    format!(
        "#{n}=PRESENTATION_STYLE_ASSIGNMENT((#{usage},NULL_STYLE(.NULL.)));#{usage}=SURFACE_STYLE_USAGE(.BOTH.,#{side});
         #{side}=SURFACE_SIDE_STYLE('',(#{area}));#{area}=SURFACE_STYLE_FILL_AREA(#{});#{}=FILL_AREA_STYLE('',(#{fill}));
         #{fill}=FILL_AREA_STYLE_COLOUR('',#{last});#{last}={color};",
        n + 6,
        n + 6
    )
}

fn read_styles(data: &str) -> StepFile {
    let styles =
        style(100, "COLOUR_RGB('',1.,0.5,0.)") + &style(200, "DRAUGHTING_PRE_DEFINED_COLOUR('blue')");
    file(&format!("{MILLIMETRES}{SOLID}{styles}{data}"))
}

fn rgb(style: Option<ColorStyle>) -> Option<[f64; 3]> {
    style.map(|style| style.rgb)
}

const ORANGE: Option<[f64; 3]> = Some([1.0, 0.5, 0.0]);
const BLUE: Option<[f64; 3]> = Some([0.0, 0.0, 1.0]);

/// Colours of the first face, the second face and the body.
fn colors(data: &str) -> [Option<[f64; 3]>; 3] {
    let file = read_styles(data);
    assert_eq!(file.report.repairs.notes(), []);
    let faces = &file.model.faces;
    [rgb(faces[0].style), rgb(faces[1].style), rgb(file.model.parts[0].bodies[0].style)]
}

#[test]
fn colours_are_where_the_file_puts_them() {
    assert_eq!(colors("#30=STYLED_ITEM('',(#100),#24);"), [None, None, ORANGE]);
    assert_eq!(
        colors("#30=STYLED_ITEM('',(#100),#24);#31=STYLED_ITEM('',(#200),#22);"),
        [None, BLUE, ORANGE]
    );
    assert_eq!(
        colors("#30=STYLED_ITEM('',(#100),#23);#31=STYLED_ITEM('',(#200),#22);"),
        [ORANGE, BLUE, None]
    );
    assert_eq!(colors("#30=STYLED_ITEM('',(#100),#25);"), [None, None, ORANGE]);
}

#[test]
fn overriding_style_counts_wherever_it_stands() {
    let plain = "#31=STYLED_ITEM('',(#100),#21);";
    let overriding = |n: usize| format!("#{n}=OVER_RIDING_STYLED_ITEM('',(#200),#21,#31);");
    assert_eq!(colors(&format!("{plain}{}", overriding(30))), [BLUE, None, None]);
    assert_eq!(colors(&format!("{plain}{}", overriding(32))), [BLUE, None, None]);
}

#[test]
fn transparency_and_colour_of_rendering_are_read() {
    let file = read_styles(
        "#30=STYLED_ITEM('',(#40),#24);#40=PRESENTATION_STYLE_ASSIGNMENT((#41));#41=SURFACE_STYLE_USAGE(.BOTH.,#42);
         #42=SURFACE_SIDE_STYLE('',(#43));#43=SURFACE_STYLE_RENDERING_WITH_PROPERTIES(.NORMAL_SHADING.,#44,(#45));
         #44=COLOUR_RGB('',0.25,0.5,2.);#45=SURFACE_STYLE_TRANSPARENT(0.75);",
    );
    let style = file.model.parts[0].bodies[0].style.unwrap();
    assert_eq!(style, ColorStyle { rgb: [0.25, 0.5, 1.0], transparency: 0.75 });
}

#[test]
fn mapped_items_have_the_colour_of_their_occurrence() {
    let data = "#30=STYLED_ITEM('',(#100),#31);#31=MAPPED_ITEM('',#32,#11);#32=REPRESENTATION_MAP(#11,#25);
        #33=SHAPE_REPRESENTATION('',(#31),#910);";
    let file = read_styles(data);
    assert_eq!(rgb(file.model.parts[1].occurrences[0].style), ORANGE);
}

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
fn layers_are_named_on_faces_and_bodies() {
    let file = read_styles("#30=PRESENTATION_LAYER_ASSIGNMENT('paint','',(#22,#24));");
    let layers: Vec<&str> = file.model.faces.iter().map(|face| face.layer.as_str()).collect();
    assert_eq!((layers, file.model.parts[0].bodies[0].layer.as_str()), (vec!["", "paint"], "paint"));
}

#[test]
fn style_that_cannot_be_read_is_reported() {
    let file = read_styles(
        &(style(300, "DRAUGHTING_PRE_DEFINED_COLOUR('mauve')") + "#30=STYLED_ITEM('',(#300),#24);"),
    );
    let note = file.report.repairs.notes()[0].to_string();
    assert_eq!(note, "#30: #305: the colour \"mauve\" is unknown; the style is left out");
}

/// The part 300 of the products 100 with an occurrence 400, and a representation 500 that stands for it.
const OCCURRENCE: &str = "#300=PRODUCT_DEFINITION('','',$,$);#301=PRODUCT_DEFINITION_SHAPE('','',#300);
    #302=SHAPE_DEFINITION_REPRESENTATION(#301,#25);#310=PRODUCT_DEFINITION('','',$,$);
    #400=NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#310,#300,$);#401=PRODUCT_DEFINITION_SHAPE('','',#400);
    #402=SHAPE_DEFINITION_REPRESENTATION(#401,#500);#500=SHAPE_REPRESENTATION('',(),#910);
    #410=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#411,#401);#411=(REPRESENTATION_RELATIONSHIP('','',#25,#25)
    REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#412)SHAPE_REPRESENTATION_RELATIONSHIP());
    #412=ITEM_DEFINED_TRANSFORMATION('','',#11,#11);#40=STYLED_ITEM('',(#100),#24);";

#[test]
fn style_in_the_context_of_an_occurrence_is_that_of_the_occurrence() {
    let by_context =
        "#41=OVER_RIDING_STYLED_ITEM('',(#42),#24,#40);#42=PRESENTATION_STYLE_BY_CONTEXT((#201),#500);";
    let item = "#41=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#200),#24,#40,(#410));";
    for data in [by_context, item] {
        let file = read_styles(&format!("{OCCURRENCE}{data}"));
        assert_eq!(file.report.repairs.notes(), []);
        assert_eq!(rgb(file.model.parts[0].bodies[0].style), ORANGE);
        assert_eq!(rgb(file.model.parts[1].occurrences[0].style), BLUE);
    }
    let face = by_context.replace("#24", "#21");
    let file = read_styles(&format!("{OCCURRENCE}{face}"));
    assert_eq!((file.report.repairs.count(), file.model.parts[1].occurrences[0].style), (1, None));
}
