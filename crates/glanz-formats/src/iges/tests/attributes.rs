//! Transformations, subfigures, colours, names, groups and levels.

use glanz_math::DMat4;

use super::*;

#[test]
fn matrix_of_a_face_places_a_part() {
    // A quarter turn about z, then moved by (1, 2, 3).
    let entities = [
        entity(128, 0, BILINEAR),
        EntityText { matrix: 5, ..entity(144, 0, "1,0,0,0") },
        entity(124, 0, "0.,-1.,0.,1.,1.,0.,0.,2.,0.,0.,1.,3."),
    ];
    let file = file(&entities);
    let [occurrence] = file.model.parts.last().unwrap().occurrences.as_slice() else { panic!() };
    assert_near(occurrence.to_parent.transform_point3(DVec3::X), DVec3::new(1.0, 3.0, 3.0));
    assert_eq!(file.model.parts[occurrence.part].bodies[0].shells[0].faces.len(), 1);
    let skewed = EntityText { parameters: "2.,0.,0.,0.,0.,1.,0.,0.,0.,0.,1.,0.", ..entities[2] };
    let omissions = omissions(&super::file(&[entities[0], entities[1], skewed]));
    assert_eq!(omissions, ["#3: its transformation is neither a rotation nor a reflection"]);
}

#[test]
fn matrices_of_matrices_are_applied_after_them() {
    let entities = [
        EntityText { matrix: 3, ..entity(128, 0, BILINEAR) },
        EntityText { matrix: 5, ..entity(124, 0, "1.,0.,0.,1.,0.,1.,0.,0.,0.,0.,1.,0.") },
        entity(124, 0, "0.,-1.,0.,0.,1.,0.,0.,0.,0.,0.,1.,0."),
        entity(144, 0, "1,0,0,0"),
    ];
    let file = file(&entities);
    let trimmed = trimmed_faces(&file.model);
    // The square of the corners (1, 0) and (2, 1), turned to (-1, 1) and (0, 2): its third of position times normal is 0.
    assert_close(trimmed.faces[0].as_ref().unwrap().measure(1e-9).area, 1.0);
    let glanz_brep::model::FaceSurface::Spline(surface) = &file.model.surfaces[0].surface else { panic!() };
    assert_near(surface.point(0.0, 0.0), DVec3::Y);
    let cycle = [
        EntityText { matrix: 3, ..entity(128, 0, BILINEAR) },
        EntityText { matrix: 3, ..entity(124, 0, "1.,0.,0.,1.,0.,1.,0.,0.,0.,0.,1.,0.") },
    ];
    assert_eq!(omissions(&super::file(&cycle))[0], "#1: transformations refer to one another");
}

#[test]
fn subfigures_are_parts_with_instances() {
    let entities = [
        entity(308, 0, "0,5Hplate,1,3"),
        entity(144, 0, "5,0,0,0"),
        entity(128, 0, BILINEAR),
        entity(408, 0, "1,1.,2.,3.,2."),
        EntityText { label: "SECOND", ..entity(408, 0, "1,0.,0.,0.,1.") },
    ];
    let file = clean(&entities);
    let [plate, root] = file.model.parts.as_slice() else { panic!() };
    assert_eq!((plate.name.as_str(), plate.bodies.len(), root.bodies.len()), ("plate", 1, 0));
    let [first, second] = root.occurrences.as_slice() else { panic!() };
    let expected = DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0)) * DMat4::from_scale(DVec3::splat(2.0));
    assert_eq!((first.to_parent, first.part, second.name.as_str()), (expected, 0, "SECOND"));
    // Without an instance the faces are not shown.
    let unused = super::file(&entities[..3]);
    assert_eq!((unused.report.faces.unreachable, unused.model.parts.len()), (1, 0));
}

#[test]
fn subfigures_that_contain_themselves_are_refused() {
    let entities =
        [entity(308, 0, "0,1Ha,1,3"), entity(408, 0, "1,0.,0.,0.,1."), entity(408, 0, "1,0.,0.,0.,1.")];
    let file = file(&entities);
    assert_eq!(omissions(&file)[0], "#3: #1: the subfigure contains itself");
    assert!(file.model.roots.is_empty());
}

#[test]
fn faces_with_a_negative_number_of_a_matrix_stand_beside_others() {
    let file = clean(&[
        entity(128, 0, BILINEAR),
        EntityText { matrix: -9, ..entity(144, 0, "1,0,0,0") },
        EntityText { matrix: 9, ..entity(144, 0, "1,0,0,0") },
        entity(144, 0, "1,0,0,0"),
        entity(124, 0, "1.,0.,0.,1.,0.,1.,0.,0.,0.,0.,1.,0."),
    ]);
    let [moved, whole] = file.model.parts.as_slice() else { panic!("{:?}", file.model.parts) };
    assert_eq!((whole.bodies.len(), whole.occurrences.len(), whole.occurrences[0].part), (1, 1, 0));
    assert_eq!(moved.bodies[0].shells[0].faces.len(), 2);
}

#[test]
fn placements_beyond_the_coordinates_of_a_scene_are_refused() {
    // Fifteen times 1e11 m, of which each alone is near enough.
    let mut entities = vec![entity(128, 0, BILINEAR), EntityText { matrix: 5, ..entity(144, 0, "1,0,0,0") }];
    for next in (7..35).step_by(2).chain([0]) {
        entities
            .push(EntityText { matrix: next, ..entity(124, 0, "1.,0.,0.,1.E11,0.,1.,0.,0.,0.,0.,1.,0.") });
    }
    let refused = omissions(&file(&entities));
    assert_eq!(refused, ["#3: the transformation has an entry of more than 1e12"]);
    // Two scales inside one another.
    for (scale, reason) in [("1.E7", "goes beyond the coordinates"), ("1.E-7", "shrinks lengths")] {
        let [inner, outer] = ["1", "7"].map(|definition| format!("{definition},0.,0.,0.,{scale}"));
        let entities = [
            entity(308, 0, "0,5Hinner,1,3"),
            entity(144, 0, "5,0,0,0"),
            entity(128, 0, BILINEAR),
            entity(308, 0, "0,5Houter,1,9"),
            entity(408, 0, &inner),
            entity(408, 0, &outer),
            entity(408, 0, &inner),
        ];
        let file = file(&entities);
        let refused = omissions(&file);
        assert_eq!(refused.len(), 1);
        assert!(
            refused[0].starts_with("#11: with those inside") && refused[0].contains(reason),
            "{refused:?}"
        );
        let [alone] = file.model.parts.last().unwrap().occurrences.as_slice() else { panic!() };
        assert_eq!(alone.entity, id(13));
    }
}

#[test]
fn colors_names_groups_and_levels_are_taken_over() {
    let entities = [
        EntityText { color: 4, level: 7, label: "LABEL", ..entity(128, 0, BILINEAR) },
        EntityText { color: -7, ..entity(144, 0, "5,0,0,0,0,1,9") },
        entity(128, 0, BILINEAR),
        entity(314, 0, "100.,50.,0.,6Horange"),
        entity(406, 15, "1,5Hcover"),
        entity(402, 7, "1,3,0,1,13"),
        entity(406, 15, "1,4Hlids"),
    ];
    let file = clean(&entities);
    let [body, lids] = file.model.parts[0].bodies.as_slice() else { panic!() };
    assert_eq!((lids.name.as_str(), lids.entity, body.name.as_str()), ("lids", id(11), ""));
    let faces = &file.model.faces;
    let cover = faces.iter().find(|face| face.name == "cover").unwrap();
    assert_eq!(cover.style.unwrap().rgb, [1.0, 0.5, 0.0]);
    let other = faces.iter().find(|face| face.name == "LABEL").unwrap();
    assert_eq!((other.style.unwrap().rgb, other.layer.as_str()), ([0.0, 0.0, 1.0], "7"));
}

#[test]
fn blanked_entities_are_hidden_and_counted() {
    let entities = [
        EntityText { status: "01000000", ..entity(144, 0, "3,0,0,0") },
        entity(128, 0, BILINEAR),
        EntityText { status: "01000000", ..entity(514, 1, "1,7,1") },
        entity(510, 1, "3,0,0"),
        EntityText { status: "00000600", ..entity(128, 0, BILINEAR) },
        entity(128, 0, BILINEAR),
    ];
    let file = file(&entities);
    let faces = file.report.faces;
    assert_eq!((faces.total, faces.read, faces.hidden), (3, 1, 2));
    assert!(omissions(&file).contains(&"#9: it is geometry for construction".to_owned()));
}

#[test]
fn what_is_not_read_is_reported_by_type_and_number() {
    let entities = [
        entity(128, 0, BILINEAR),
        entity(110, 0, "0.,0.,0.,1.,0.,0."),
        entity(212, 0, "0"),
        entity(110, 0, "0.,0.,0.,1.,0.,0."),
    ];
    assert_eq!(
        omissions(&file(&entities)),
        [
            "#3: 2 entities of type 110 (line) belong to no face; they are not shown",
            "#5: 1 entity of type 212 (annotation) belongs to no face; it is not shown",
        ]
    );
}

#[test]
fn whole_surface_has_the_name_of_its_property() {
    let spline = format!("{BILINEAR},0,1,3");
    let file = clean(&[entity(128, 0, &spline), entity(406, 15, "1,5Hcover")]);
    assert_eq!(file.model.faces[0].name, "cover");
    let file =
        clean(&[entity(196, 0, "3,2.,0,1,5"), entity(116, 0, "0.,0.,0."), entity(406, 15, "1,4Hball")]);
    assert_eq!(file.model.faces[0].name, "ball");
    // A note stands where form 1 has the axis.
    let noted = super::file(&[entity(196, 0, "3,2.,1,5,0"), entity(116, 0, "0.,0.,0."), entity(212, 0, "0")]);
    assert_eq!(noted.report.faces.read, 1);
}
