//! Colours and layers.

use glanz_brep::model::ColorStyle;
use glanz_light::rgb::srgb_decode;
use glanz_scene::Description;
use glanz_scene::description::MaterialDescription;
use glanz_scene::studio::cad_material;

use super::*;
use crate::cad::CadModel;

/// Two faces #21 and #22 in the shell #23 of the solid #24 of the representation #25.
pub(super) const SOLID: &str =
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

pub(super) fn read_styles(data: &str) -> BrepFile {
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
pub(super) const OCCURRENCE: &str =
    "#300=PRODUCT_DEFINITION('','',$,$);#301=PRODUCT_DEFINITION_SHAPE('','',#300);
    #302=SHAPE_DEFINITION_REPRESENTATION(#301,#25);#310=PRODUCT_DEFINITION('','',$,$);
    #400=NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#310,#300,$);#401=PRODUCT_DEFINITION_SHAPE('','',#400);
    #402=SHAPE_DEFINITION_REPRESENTATION(#401,#500);#500=SHAPE_REPRESENTATION('',(),#910);
    #410=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#411,#401);#411=(REPRESENTATION_RELATIONSHIP('','',#25,#25)
    REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#412)SHAPE_REPRESENTATION_RELATIONSHIP());
    #412=ITEM_DEFINED_TRANSFORMATION('','',#11,#11);#40=STYLED_ITEM('',(#100),#24);";

/// Colours of the shapes of a file in the scene: those of groups in their order, then those of the world.
fn scene_colors(data: &str) -> Vec<Option<[f64; 3]>> {
    let styles =
        style(100, "COLOUR_RGB('',1.,0.5,0.)") + &style(200, "DRAUGHTING_PRE_DEFINED_COLOUR('blue')");
    let model =
        CadModel::read(text(&format!("{MILLIMETRES}{SOLID}{styles}{data}")).as_bytes(), false).unwrap();
    let mut description = Description::default();
    let report = model.into_world(&mut description);
    assert_eq!(report.reading.repairs.notes(), []);
    let color = |rgb: [f64; 3]| {
        let material = MaterialDescription::from(cad_material(rgb.map(|c| srgb_decode(c as f32)), 0.0));
        format!("{material:?}")
    };
    let known: Vec<(String, Option<[f64; 3]>)> =
        [ORANGE, BLUE].into_iter().map(|rgb| (color(rgb.unwrap()), rgb)).collect();
    let groups = description.groups.iter().chain([&description.world]);
    let shapes = groups.flat_map(|group| &group.shapes);
    let find = |material: usize| {
        let material = format!("{:?}", description.materials[material]);
        known.iter().find(|(known, _)| *known == material).and_then(|(_, rgb)| *rgb)
    };
    shapes.map(|shape| find(shape.material)).collect()
}

#[test]
fn style_in_the_context_of_an_occurrence_overrides_those_of_its_body_and_faces() {
    let by_context =
        "#41=OVER_RIDING_STYLED_ITEM('',(#42),#24,#40);#42=PRESENTATION_STYLE_BY_CONTEXT((#201),#500);";
    let item = "#41=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#200),#24,#40,(#410));";
    let of_the_part = item.replace("#24,#40", "#25,#40");
    let face = "#43=STYLED_ITEM('',(#100),#21);";
    assert_eq!(scene_colors(OCCURRENCE), [ORANGE, ORANGE]);
    for data in [by_context, item, &of_the_part] {
        assert_eq!(scene_colors(&format!("{OCCURRENCE}{data}")), [BLUE, BLUE], "{data}");
    }
    // A body that is painted in an occurrence is so with its faces, whatever their colours.
    assert_eq!(scene_colors(&format!("{OCCURRENCE}{face}{item}")), [BLUE, BLUE]);
    let of_the_face = item.replace("#24", "#21");
    assert_eq!(scene_colors(&format!("{OCCURRENCE}{of_the_face}")), [BLUE, ORANGE]);
    let of_the_shell = item.replace("#24", "#23");
    assert_eq!(scene_colors(&format!("{OCCURRENCE}{of_the_shell}")), [BLUE, BLUE]);
}

#[test]
fn style_in_the_context_of_the_shape_of_a_product_holds_in_all_occurrences() {
    let data = "#41=STYLED_ITEM('',(#42),#21);#42=PRESENTATION_STYLE_BY_CONTEXT((#201),#25);";
    assert_eq!(scene_colors(&format!("{OCCURRENCE}{data}")), [BLUE, ORANGE]);
    let occurrence = "#43=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#100),#21,#40,(#410));";
    assert_eq!(scene_colors(&format!("{OCCURRENCE}{data}{occurrence}")), [ORANGE, ORANGE]);
    // A mapped item is an occurrence, too.
    let mapped =
        "#31=MAPPED_ITEM('',#32,#11);#32=REPRESENTATION_MAP(#11,#25);#33=SHAPE_REPRESENTATION('',(#31),#910);
        #300=PRODUCT_DEFINITION('','',$,$);#301=PRODUCT_DEFINITION_SHAPE('','',#300);
        #302=SHAPE_DEFINITION_REPRESENTATION(#301,#33);#40=STYLED_ITEM('',(#100),#24);
        #41=STYLED_ITEM('',(#42),#31);#42=PRESENTATION_STYLE_BY_CONTEXT((#201),#33);";
    assert_eq!(scene_colors(mapped), [BLUE, BLUE]);
}

#[test]
fn mapped_item_overrides_colours_inside_only_where_its_style_is_overriding() {
    let mapped =
        "#31=MAPPED_ITEM('',#32,#11);#32=REPRESENTATION_MAP(#11,#25);#33=SHAPE_REPRESENTATION('',(#31),#910);
        #40=STYLED_ITEM('',(#100),#24);";
    let plain = format!("{mapped}#41=STYLED_ITEM('',(#200),#31);");
    let overriding = format!("{mapped}#41=OVER_RIDING_STYLED_ITEM('',(#200),#31,#40);");
    assert_eq!(scene_colors(&plain), [ORANGE, ORANGE]);
    assert_eq!(scene_colors(&overriding), [BLUE, BLUE]);
}

/// Two occurrences 600 and 700 of the product 310 of [`OCCURRENCE`], which contains the occurrence 400, in a product 320.
const TWICE: &str = "#320=PRODUCT_DEFINITION('','',$,$);#321=PRODUCT_DEFINITION_SHAPE('','',#320);
    #322=SHAPE_DEFINITION_REPRESENTATION(#321,#323);#323=SHAPE_REPRESENTATION('',(),#910);#312=PRODUCT_DEFINITION_SHAPE('','',#310);
    #313=SHAPE_DEFINITION_REPRESENTATION(#312,#324);#324=SHAPE_REPRESENTATION('',(),#910);
    #600=NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#320,#310,$);#601=PRODUCT_DEFINITION_SHAPE('','',#600);
    #602=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#603,#601);#603=(REPRESENTATION_RELATIONSHIP('','',#324,#323)
    REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#412)SHAPE_REPRESENTATION_RELATIONSHIP());
    #700=NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#320,#310,$);#701=PRODUCT_DEFINITION_SHAPE('','',#700);
    #702=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#703,#701);#703=(REPRESENTATION_RELATIONSHIP('','',#324,#323)
    REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#412)SHAPE_REPRESENTATION_RELATIONSHIP());";

#[test]
fn style_on_a_path_of_occurrences_counts_there_only() {
    let higher = "#41=OVER_RIDING_STYLED_ITEM('',(#42),#24,#40);#42=PRESENTATION_STYLE_BY_CONTEXT((#201),#800);
        #800=SHAPE_REPRESENTATION('',(),#910);#801=SPECIFIED_HIGHER_USAGE_OCCURRENCE('','','',#320,#300,$,#600,#400);
        #802=PRODUCT_DEFINITION_SHAPE('','',#801);#803=SHAPE_DEFINITION_REPRESENTATION(#802,#800);";
    let list = |contexts: &str| {
        format!("#41=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#200),#24,#40,({contexts}));")
    };
    for data in [higher, &list("#602,#410"), &list("#410,#602")] {
        assert_eq!(
            scene_colors(&format!("{OCCURRENCE}{TWICE}{data}")),
            [BLUE, BLUE, ORANGE, ORANGE],
            "{data}"
        );
    }
    // Both occurrences of the assembly: its group is made once.
    assert_eq!(scene_colors(&format!("{OCCURRENCE}{TWICE}{}", list("#410"))), [BLUE, BLUE]);
    // The outer occurrence counts before the inner one.
    let outer = "#44=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#100),#310,#40,(#602));";
    let both = format!("{OCCURRENCE}{TWICE}{}{outer}", list("#410"));
    assert_eq!(scene_colors(&both), [ORANGE, ORANGE, BLUE, BLUE]);
}

#[test]
fn paths_of_many_occurrences_are_joined_whatever_usages_stand_for_them() {
    let mut whole = String::from(
        "#1000=PRODUCT_DEFINITION('','',$,$);#1001=PRODUCT_DEFINITION_SHAPE('','',#1000);
         #1002=SHAPE_DEFINITION_REPRESENTATION(#1001,#1003);#1003=SHAPE_REPRESENTATION('',(),#910);
         #801=SPECIFIED_HIGHER_USAGE_OCCURRENCE('','','',#320,#300,$,#600,#400);#802=PRODUCT_DEFINITION_SHAPE('','',#801);
         #803=SHAPE_DEFINITION_REPRESENTATION(#802,#800);#800=SHAPE_REPRESENTATION('',(),#910);
         #810=SPECIFIED_HIGHER_USAGE_OCCURRENCE('','','',#1000,#310,$,#1100,#600);
         #811=SPECIFIED_HIGHER_USAGE_OCCURRENCE('','','',#1000,#300,$,#810,#400);
         #812=SPECIFIED_HIGHER_USAGE_OCCURRENCE('','','',#1000,#300,$,#1100,#801);",
    );
    for usage in [1100, 1200] {
        let [property, placement, relationship] = [usage + 1, usage + 2, usage + 3];
        whole += &format!(
            "#{usage}=NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#1000,#320,$);#{property}=PRODUCT_DEFINITION_SHAPE('','',#{usage});
             #{placement}=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relationship},#{property});
             #{relationship}=(REPRESENTATION_RELATIONSHIP('','',#323,#1003)
             REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#412)SHAPE_REPRESENTATION_RELATIONSHIP());"
        );
    }
    for contexts in ["#1102,#602,#410", "#1102,#802", "#802,#1102", "#811", "#812"] {
        let data = format!("#41=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#200),#24,#40,({contexts}));");
        assert_eq!(
            scene_colors(&format!("{OCCURRENCE}{TWICE}{whole}{data}")),
            [BLUE, BLUE, ORANGE, ORANGE],
            "{contexts}"
        );
    }
}

#[test]
fn usages_that_contain_themselves_have_no_path() {
    for [upper, next] in [[801, 400], [600, 801], [801, 801]] {
        let file = read_styles(&format!(
            "{OCCURRENCE}{TWICE}#801=SPECIFIED_HIGHER_USAGE_OCCURRENCE('','','',#320,#300,$,#{upper},#{next});
             #41=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#200),#24,#40,(#801));"
        ));
        let notes: Vec<String> = file.report.repairs.notes().iter().map(ToString::to_string).collect();
        assert_eq!(notes, ["#41: #801: usages are nested deeper than 64 levels; the style is left out"]);
    }
}

#[test]
fn contexts_and_items_that_are_not_there_are_reported() {
    for (item, context, reason) in [
        ("#24", "#100", "#41: #100: the context of the style is no occurrence; the style is left out"),
        ("#24", "#999", "#41: #999: the context of the style is no occurrence; the style is left out"),
        ("#12", "#410", "#41: #12: the item is not shown; the style is left out"),
    ] {
        let file = read_styles(&format!(
            "{OCCURRENCE}#41=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#200),{item},#40,({context}));"
        ));
        let notes: Vec<String> = file.report.repairs.notes().iter().map(ToString::to_string).collect();
        // A reference to what does not exist is found earlier.
        let known = notes.len() == 1 && (notes[0] == reason || context == "#999");
        assert!(known && file.model.overrides.is_empty(), "{notes:?}");
    }
}

#[test]
fn styles_that_refer_to_one_another_often_are_read_once() {
    let often = |n: usize| vec![format!("#{n}"); 1000].join(",");
    // 1000^5 ways lead from the item to the colour.
    let data = format!(
        "#30=STYLED_ITEM('',({}),#24);#50=PRESENTATION_STYLE_ASSIGNMENT(({}));#51=SURFACE_STYLE_USAGE(.BOTH.,#52);
         #52=SURFACE_SIDE_STYLE('',({}));#53=SURFACE_STYLE_FILL_AREA(#54);#54=FILL_AREA_STYLE('',({}));
         #55=FILL_AREA_STYLE_COLOUR('',#56);#56=COLOUR_RGB('',0.,0.,1.);#57=STYLED_ITEM('',(#58),#21);
         #58=PRESENTATION_STYLE_ASSIGNMENT(({}));",
        often(50),
        often(51),
        often(53),
        often(55),
        often(58)
    );
    assert_eq!(colors(&data), [None, None, BLUE]);
}

#[test]
fn colours_of_many_paths_do_not_fill_the_memory() {
    // Each of 30 products contains the next one twice, in two colours of another face: 2^30 combinations.
    let mut data = String::new();
    let mut faces = String::new();
    for level in 0..30 {
        let [product, next, face] = [10_000 + 100 * level, 10_100 + 100 * level, 2000 + level];
        faces += &format!(",#{face}");
        let [a, b] = [product + 10, product + 20];
        data += &format!(
            "#{face}=ADVANCED_FACE('',(),#10,.T.);#{product}=PRODUCT_DEFINITION('','',$,$);
             #{a}=NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#{product},#{next},$);
             #{b}=NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#{product},#{next},$);
             #{}=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#100),#{face},#40,(#{a}));
             #{}=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#200),#{face},#40,(#{b}));",
            product + 30,
            product + 40
        );
    }
    data += "#13000=PRODUCT_DEFINITION('','',$,$);#13001=PRODUCT_DEFINITION_SHAPE('','',#13000);
        #13002=SHAPE_DEFINITION_REPRESENTATION(#13001,#25);";
    let styles =
        style(100, "COLOUR_RGB('',1.,0.5,0.)") + &style(200, "DRAUGHTING_PRE_DEFINED_COLOUR('blue')");
    let solid = SOLID.replace("(#21,#22)", &format!("(#21,#22{faces})"));
    let model =
        CadModel::read(text(&format!("{MILLIMETRES}{solid}{styles}{data}")).as_bytes(), false).unwrap();
    let mut description = Description::default();
    let report = model.into_world(&mut description);
    assert!(report.shapes.len() < 200_000, "{}", report.shapes.len());
    let last = report.reading.repairs.notes().last().unwrap();
    assert!(last.reason.contains("too many different colors"), "{last}");
}

#[test]
fn colours_are_not_handed_on_to_many_occurrences_for_ever() {
    // An occurrence colours 4000 faces, and contains 6000 occurrences of them.
    let (mut data, mut faces, mut maps) = (String::from(OCCURRENCE), String::new(), String::new());
    for face in 20_000..24_000 {
        let style = face + 10_000;
        faces += &format!(",#{face}");
        data += &format!(
            "#{face}=ADVANCED_FACE('',(),#10,.T.);
             #{style}=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#200),#{face},#40,(#410));"
        );
    }
    for item in 40_000..46_000 {
        maps += &format!(",#{item}");
        data += &format!("#{item}=MAPPED_ITEM('',#27,#11);");
    }
    data += "#26=SHAPE_REPRESENTATION('',(#24),#910);#27=REPRESENTATION_MAP(#11,#26);";
    let solid = SOLID
        .replace("(#21,#22)", &format!("(#21,#22{faces})"))
        .replace("('',(#24),#910)", &format!("('',(#11{maps}),#910)"));
    let styles =
        style(100, "COLOUR_RGB('',1.,0.5,0.)") + &style(200, "DRAUGHTING_PRE_DEFINED_COLOUR('blue')");
    let model =
        CadModel::read(text(&format!("{MILLIMETRES}{solid}{styles}{data}")).as_bytes(), false).unwrap();
    let report = model.into_world(&mut Description::default());
    let last = report.reading.repairs.notes().last().unwrap();
    assert!(last.reason.contains("too many different colors"), "{last}");
}
