//! Assemblies and instances of solids.

use glanz_math::DMat4;

use super::solids::{entities, tetrahedron};
use super::*;

/// The tetrahedron #1 with these entities behind it, from #57 on.
fn with_solid(others: &[(u32, &str)]) -> Vec<(u32, u32, String)> {
    let mut list = tetrahedron();
    assert_eq!(2 * list.len() + 1, 57);
    list.extend(others.iter().map(|(kind, parameters)| (*kind, 1, (*parameters).to_owned())));
    list
}

#[test]
fn items_of_an_assembly_are_occurrences_of_one_solid() {
    // A quarter turn about z, then moved by (1, 2, 3), within a move by (0, 0, 5).
    let list = with_solid(&[
        (184, "2,1,59,0,61"),
        (430, "1"),
        (124, "1.,0.,0.,0.,0.,1.,0.,0.,0.,0.,1.,5."),
        (124, "0.,-1.,0.,1.,1.,0.,0.,2.,0.,0.,1.,3."),
    ]);
    let mut entities = entities(&list);
    entities[28].label = "PAIR";
    entities[29] = EntityText { label: "SECOND", matrix: 63, color: 3, ..entities[29] };
    // Neither matrix has a form.
    entities[30].form = 0;
    entities[31].form = 0;
    let file = clean(&entities);
    let [solid, pair, root] = file.model.parts.as_slice() else { panic!("{:?}", file.model.parts) };
    assert_eq!((file.model.faces.len(), solid.bodies.len(), solid.bodies[0].solid), (4, 1, true));
    assert_eq!((pair.name.as_str(), pair.bodies.len(), root.occurrences.len()), ("PAIR", 0, 1));
    assert_eq!(root.occurrences[0].part, 1);
    let [first, second] = pair.occurrences.as_slice() else { panic!() };
    assert_eq!((first.part, first.to_parent, second.part), (0, DMat4::IDENTITY, 0));
    assert_eq!((second.name.as_str(), second.style.unwrap().rgb), ("SECOND", [0.0, 1.0, 0.0]));
    assert_near(second.to_parent.transform_point3(DVec3::X), DVec3::new(1.0, 3.0, 8.0));
}

#[test]
fn solid_of_an_instance_is_shown_by_it_only() {
    let file = clean(&entities(&with_solid(&[(430, "1"), (430, "1")])));
    let occurrences: Vec<usize> = file.model.parts[1].occurrences.iter().map(|inner| inner.part).collect();
    assert_eq!((file.model.parts.len(), occurrences), (2, vec![0, 0]));
}

#[test]
fn assemblies_inside_one_another_are_shown_up_to_the_cycle() {
    let file = file(&entities(&with_solid(&[(184, "2,1,59,0,0"), (184, "1,57,0")])));
    assert_eq!(
        omissions(&file),
        ["#59: #57: the assembly contains itself", "#57: #59: the assembly has no surface that can be read"]
    );
    assert_eq!((file.report.faces.read, file.model.roots.len()), (4, 1));
}

#[test]
fn deep_assemblies_are_refused() {
    // More than would fit on the stack.
    let deep: Vec<String> =
        (0..20_000).map(|i| format!("1,{},0", 59 + 2 * i)).chain(["1,1,0".to_owned()]).collect();
    let deep: Vec<(u32, &str)> = deep.iter().map(|parameters| (184, parameters.as_str())).collect();
    let file = file(&entities(&with_solid(&deep)));
    assert_eq!(omissions(&file)[0], "#87: #89: subfigures and assemblies are nested deeper than 16 levels");
    assert_eq!((file.report.faces.unreachable, file.model.roots.len()), (4, 0));
}

#[test]
fn other_items_of_an_assembly_are_refused_by_number() {
    let file = file(&entities(&with_solid(&[(184, "2,1,59,0,0"), (158, "1.,0.,0.,0.")])));
    assert_eq!(omissions(&file), ["#57: #59: type 158 (primitive solid), form 1, is not read as a solid"]);
    assert_eq!(file.report.faces.read, 4);
}

#[test]
fn solid_of_a_hidden_assembly_is_shown_where_an_instance_shows_it() {
    for (instance, faces) in [(430, (4, 0)), (116, (0, 4))] {
        let list = with_solid(&[(184, "1,1,0"), (instance, "1,0,0")]);
        let mut entities = entities(&list);
        entities[28].status = "01000000";
        let report = file(&entities).report;
        assert_eq!((report.faces.read, report.faces.hidden), faces);
        assert_eq!(report.omissions.notes()[0].to_string(), "#57: the file hides it");
    }
}
