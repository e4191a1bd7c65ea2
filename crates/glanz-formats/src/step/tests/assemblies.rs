//! Products, placements and mapped items.

use glanz_math::{DMat4, DVec4};

use super::*;

/// A product with the numbers from `n` on: definition n, property n + 1, representation n + 2 with these items in a context.
fn product(n: usize, name: &str, items: &str, context: usize) -> String {
    let [p, r, s, f, product] = [n + 1, n + 2, n + 3, n + 4, n + 5];
    format!(
        "#{n}=PRODUCT_DEFINITION('','',#{f},$);#{p}=PRODUCT_DEFINITION_SHAPE('','',#{n});#{r}=SHAPE_REPRESENTATION('',({items}),#{context});
         #{s}=SHAPE_DEFINITION_REPRESENTATION(#{p},#{r});#{f}=PRODUCT_DEFINITION_FORMATION('','',#{product});
         #{product}=PRODUCT('id{n}','{name}','',());"
    )
}

/// A usage `n` of the product `child` in `parent`, placed from the frame `from` to the frame `to`.
fn usage(n: usize, name: &str, [parent, child]: [usize; 2], [from, to]: [usize; 2]) -> String {
    let [d, r, t, p] = [n + 1, n + 2, n + 3, n + 4];
    format!(
        "#{n}=NEXT_ASSEMBLY_USAGE_OCCURRENCE('id','{name}','',#{parent},#{child},$);
         #{d}=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{r},#{p});#{p}=PRODUCT_DEFINITION_SHAPE('','',#{n});
         #{r}=(REPRESENTATION_RELATIONSHIP('','',#{},#{})REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{t})
         SHAPE_REPRESENTATION_RELATIONSHIP());#{t}=ITEM_DEFINED_TRANSFORMATION('','',#{from},#{to});",
        child + 2,
        parent + 2
    )
}

/// A body #3; placements #10 at the origin, #20 at (10, 0, 0) turned by a right angle about z; a context #920 in inches.
fn common() -> String {
    let inches = INCHES.replace("#9", "#89");
    format!(
        "{MILLIMETRES}{inches}#1=ADVANCED_FACE('f',(),#2,.T.);#2=SPHERICAL_SURFACE('',#10,1.);#3=MANIFOLD_SOLID_BREP('',#4);
         #4=CLOSED_SHELL('',(#1));#10=AXIS2_PLACEMENT_3D('',#11,$,$);#11=CARTESIAN_POINT('',(0.,0.,0.));
         #20=AXIS2_PLACEMENT_3D('',#21,$,#22);#21=CARTESIAN_POINT('',(10.,0.,0.));#22=DIRECTION('',(0.,1.,0.));"
    )
}

/// Turned by a right angle about z, then moved along x.
fn turned(x: f64) -> DMat4 {
    DMat4::from_cols(DVec4::Y, -DVec4::X, DVec4::Z, DVec4::new(x, 0.0, 0.0, 1.0))
}

fn assert_matrix(read: DMat4, expected: DMat4) {
    assert!(read.abs_diff_eq(expected, 1e-15), "{read} is not {expected}");
}

#[test]
fn assembly_of_two_levels_has_parts_before_their_occurrences() {
    let file = clean(&format!(
        "{}{}{}{}{}{}{}",
        common(),
        product(100, "whole", "#10", 910),
        product(200, "pair", "#10", 910),
        product(300, "", "#3,#10", 910),
        usage(400, "", [200, 300], [10, 20]),
        usage(500, "second", [200, 300], [20, 10]),
        usage(600, "pair here", [100, 200], [10, 10])
    ));
    let model = &file.model;
    let names: Vec<&str> = model.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["id300", "pair", "whole"]);
    assert_eq!(model.roots.iter().map(|root| root.part).collect::<Vec<_>>(), [2]);
    assert_eq!(model.parts[0].bodies.len(), 1);
    let [first, second] = model.parts[1].occurrences.as_slice() else { panic!() };
    assert_eq!((first.part, first.name.as_str(), second.name.as_str()), (0, "id", "second"));
    assert_matrix(first.to_parent, turned(0.01));
    assert_matrix(second.to_parent, turned(0.01).inverse());
    assert_eq!(model.parts[2].occurrences[0].to_parent, DMat4::IDENTITY);
}

#[test]
fn placements_are_in_the_units_of_their_representations() {
    // The parent is in inches: #20 is 10 inches from its origin, and the body keeps its millimetres.
    let file = clean(&format!(
        "{}{}{}{}",
        common(),
        product(100, "whole", "#10", 8910),
        product(300, "ball", "#3", 910),
        usage(400, "", [100, 300], [10, 20])
    ));
    assert_matrix(file.model.parts[1].occurrences[0].to_parent, turned(0.254));
    assert!((file.model.uncertainty - 0.0127).abs() < 1e-15);
    let both =
        clean(&format!("{}{}{}", common(), product(100, "a", "#3", 910), product(200, "b", "#3", 8910)));
    let radii: Vec<f64> = both.model.surfaces.iter().map(|s| sphere_radius(&s.surface)).collect();
    assert!((radii[0] - 0.001).abs() < 1e-15 && (radii[1] - 0.0254).abs() < 1e-15, "{radii:?}");
}

fn sphere_radius(surface: &glanz_brep::model::FaceSurface) -> f64 {
    match surface {
        glanz_brep::model::FaceSurface::Sphere { radius, .. } => *radius,
        other => panic!("{other:?}"),
    }
}

#[test]
fn exchanged_ends_of_a_relationship_are_recognised() {
    let wrong = usage(400, "", [100, 300], [20, 10]).replace("#302,#102", "#102,#302");
    let file =
        clean(&format!("{}{}{}{wrong}", common(), product(100, "", "#10", 910), product(300, "", "#3", 910)));
    assert_matrix(file.model.parts[1].occurrences[0].to_parent, turned(0.01));
}

#[test]
fn mapped_items_are_occurrences_and_their_usages_are_not_placed_again() {
    let file = clean(&format!(
        "{}{}{}#400=NEXT_ASSEMBLY_USAGE_OCCURRENCE('id','','',#100,#300,$);
         #30=MAPPED_ITEM('left',#31,#20);#31=REPRESENTATION_MAP(#10,#302);
         #32=MAPPED_ITEM('big',#31,#33);#33=CARTESIAN_TRANSFORMATION_OPERATOR_3D('',#22,$,#21,2.,$);",
        common(),
        product(100, "whole", "#30,#32", 910),
        product(300, "ball", "#3", 910)
    ));
    let [left, big] = file.model.parts[1].occurrences.as_slice() else { panic!("{:?}", file.model) };
    assert_eq!((left.name.as_str(), big.name.as_str(), left.part, big.part), ("left", "big", 0, 0));
    assert_matrix(left.to_parent, turned(0.01));
    assert_matrix(big.to_parent, turned(0.01) * DMat4::from_scale(DVec3::splat(2.0)));
}

#[test]
fn operator_with_a_left_handed_second_axis_is_a_reflection() {
    let file = clean(&format!(
        "{}#30=MAPPED_ITEM('',#31,#33);#31=REPRESENTATION_MAP(#10,#40);#40=SHAPE_REPRESENTATION('inner',(#3),#910);
         #41=SHAPE_REPRESENTATION('outer',(#30),#910);#34=DIRECTION('',(0.,-1.,0.));#35=DIRECTION('',(0.,0.,1.));#36=DIRECTION('',(1.,0.,0.));
         #33=CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,#36,#34,#11,$,#35);",
        common()
    ));
    assert_eq!(file.model.roots.len(), 1);
    assert_matrix(
        file.model.parts[1].occurrences[0].to_parent,
        DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0)),
    );
}

#[test]
fn linked_representations_belong_to_one_part() {
    let file = clean(&format!(
        "{}{}#40=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#3),#910);#41=SHAPE_REPRESENTATION_RELATIONSHIP('','',#102,#40);",
        common(),
        product(100, "ball", "#10", 910)
    ));
    assert_eq!((file.model.parts.len(), file.model.parts[0].bodies.len(), file.model.roots.len()), (1, 1, 1));
    assert_eq!(file.model.parts[0].name, "ball");
}

#[test]
fn files_without_products_show_their_representations_or_their_bodies() {
    let with = clean(&format!("{}#40=ADVANCED_BREP_SHAPE_REPRESENTATION('r',(#3,#10),#910);", common()));
    assert_eq!((with.model.parts[0].name.as_str(), with.model.roots.len()), ("r", 1));
    let without = file(&common());
    assert_eq!((without.model.parts[0].bodies.len(), without.report.faces.read), (1, 1));
    assert_eq!(
        without.report.repairs.notes()[0].to_string(),
        "#3: no representation has the shape; the units are those of #910"
    );
    let inches = file(&common().replace(MILLIMETRES, ""));
    assert!((sphere_radius(&inches.model.surfaces[0].surface) - 0.0254).abs() < 1e-15);
    let none = file(&common().replace(MILLIMETRES, "").replace("GLOBAL_UNIT_ASSIGNED", "OTHER"));
    assert!(none.report.repairs.notes()[0].reason.contains("millimetres"));
}

#[test]
fn what_no_product_shows_is_reported() {
    let file = file(&format!(
        "{}{}#40=ADVANCED_BREP_SHAPE_REPRESENTATION('r',(#43),#910);#43=MANIFOLD_SOLID_BREP('',#44);#44=CLOSED_SHELL('',(#45));
         #45=ADVANCED_FACE('',(),#2,.T.);",
        common(),
        product(100, "ball", "#3", 910)
    ));
    assert_eq!((file.report.faces.read, file.report.faces.unreachable), (1, 1));
    assert_eq!(omissions(&file), ["#40: the representation belongs to no product that is shown"]);
}

#[test]
fn products_inside_themselves_are_found() {
    let file = file(&format!(
        "{}{}{}{}{}{}",
        common(),
        product(100, "top", "#3", 910),
        product(200, "a", "#3", 910),
        product(300, "b", "#3", 910),
        usage(400, "", [100, 200], [10, 10]),
        usage(500, "", [200, 300], [10, 10]) + &usage(600, "", [300, 200], [10, 10])
    ));
    assert_eq!(omissions(&file), ["#600: #200: it contains itself"]);
    assert_eq!(file.model.parts.len(), 3);
}

#[test]
fn usage_without_a_placement_is_at_the_origin_and_reported() {
    let file = file(&format!(
        "{}{}{}#400=NEXT_ASSEMBLY_USAGE_OCCURRENCE('id','','',#100,#300,$);",
        common(),
        product(100, "", "#10", 910),
        product(300, "", "#3", 910)
    ));
    assert_eq!(file.model.parts[1].occurrences[0].to_parent, DMat4::IDENTITY);
    assert_eq!(file.report.repairs.notes()[0].to_string(), "#400: the usage has no placement; none is taken");
}

#[test]
fn long_name_that_many_share_is_shortened() {
    let name = "Ä".repeat(100_000);
    let body = common().replace("MANIFOLD_SOLID_BREP(''", &format!("MANIFOLD_SOLID_BREP('{name}'"));
    let data: String = (0..1000)
        .map(|i| format!("#{}=ADVANCED_BREP_SHAPE_REPRESENTATION('r',(#3),#910);", 1000 + i))
        .collect();
    let file = file(&(body + &data));
    let bodies = file.model.parts.iter().flat_map(|part| &part.bodies);
    let lengths: Vec<usize> = bodies.map(|body| body.name.chars().count()).collect();
    assert_eq!(lengths, vec![200; 1000]);
}

/// A product with the occurrence "left", and another one "bad" of a scale.
fn one_scale(scale: &str) -> String {
    format!(
        "{}{}{}#400=NEXT_ASSEMBLY_USAGE_OCCURRENCE('id','','',#100,#300,$);
         #30=MAPPED_ITEM('left',#31,#20);#31=REPRESENTATION_MAP(#10,#302);
         #32=MAPPED_ITEM('bad',#31,#33);#33=CARTESIAN_TRANSFORMATION_OPERATOR_3D('',#22,$,#21,{scale},$);",
        common(),
        product(100, "whole", "#30,#32", 910),
        product(300, "ball", "#3", 910)
    )
}

#[test]
fn transformations_without_an_inverse_cost_their_occurrence_only() {
    for scale in ["1.E-120", "1.E120", "0.", "-1."] {
        let file = file(&one_scale(scale));
        let names: Vec<&str> = file.model.parts[1].occurrences.iter().map(|o| o.name.as_str()).collect();
        assert_eq!((names, file.report.omissions.count()), (vec!["left"], 1), "{scale}");
        assert!(omissions(&file)[0].starts_with("#32: #33: "), "{:?}", omissions(&file));
    }
}

/// The omissions of an assembly in which a transformation of a scale is inside another of the same scale, and the occurrences that are left.
fn nested_scales(scale: &str) -> (Vec<String>, Vec<String>) {
    let file = file(&format!(
        "{}{}{}{}#30=MAPPED_ITEM('inner',#31,#33);#31=REPRESENTATION_MAP(#10,#302);#32=MAPPED_ITEM('outer',#34,#33);
         #33=CARTESIAN_TRANSFORMATION_OPERATOR_3D('',#22,$,#11,{scale},$);#34=REPRESENTATION_MAP(#10,#202);#35=MAPPED_ITEM('alone',#31,#33);",
        common(),
        product(100, "whole", "#32,#35", 910),
        product(200, "middle", "#30", 910),
        product(300, "ball", "#3", 910)
    ));
    let whole = file.model.parts.iter().find(|part| part.name == "whole").unwrap();
    let names = whole.occurrences.iter().map(|occurrence| occurrence.name.clone()).collect();
    (omissions(&file), names)
}

#[test]
fn transformations_inside_one_another_are_refused_where_they_go_too_far_together() {
    // Each enlarges by 1e7, so that two make 1e14, or shrinks by as much.
    for (scale, reason) in
        [("1.E7", "beyond the coordinates"), ("1.E-7", "shrinks lengths to less than 1e-12")]
    {
        let (omissions, names) = nested_scales(scale);
        assert_eq!(names, ["alone"]);
        assert!(
            omissions[0].starts_with("#32: with those inside") && omissions[0].contains(reason),
            "{omissions:?}"
        );
    }
    // The determinant of one is 1e-300, that of two would be 0.
    let file = file(&one_scale("1.E-100"));
    assert_eq!(file.model.parts[1].occurrences.len(), 1);
    assert!(omissions(&file)[0].starts_with("#32: with those inside"), "{:?}", omissions(&file));
}

#[test]
fn parallel_links_are_taken_off_the_budget() {
    // Each of 100 placed representations is linked to all others, and two of them are linked 3000 times.
    let mut data =
        common() + "#40=ITEM_DEFINED_TRANSFORMATION('','',#10,#20);#50=SHAPE_REPRESENTATION('',(#10),#910);";
    for i in 0..100 {
        let [placed, link, placement] = [1000, 2000, 3000].map(|first| first + i);
        data += &format!(
            "#{placed}=SHAPE_REPRESENTATION('',(#3),#910);#{link}=SHAPE_REPRESENTATION_RELATIONSHIP('','',#1000,#{placed});
             #{placement}=(REPRESENTATION_RELATIONSHIP('','',#{placed},#50)REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#40)
             SHAPE_REPRESENTATION_RELATIONSHIP());"
        );
    }
    let parallel = |i: usize| format!("#{i}=SHAPE_REPRESENTATION_RELATIONSHIP('','',#1000,#1001);");
    let once = file(&data);
    assert_eq!(omissions(&once), [""; 0]);
    let often = file(&(data + &(10_000..13_000).map(parallel).collect::<String>()));
    assert!(omissions(&often)[0].contains("repeats its geometry too often"), "{:?}", omissions(&often));
}
