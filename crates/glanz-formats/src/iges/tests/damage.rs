//! Damaged files.

use glanz_scene::Description;
use proptest::prelude::*;

use super::*;
use crate::cad::CadModel;

/// A file with all kinds of entities that refer to one another.
fn sample() -> String {
    text(&[
        EntityText { color: 3, matrix: 31, ..entity(144, 0, "3,1,1,5,7,0,1,33") },
        entity(128, 0, BILINEAR),
        entity(142, 0, "1,3,9,9,3"),
        entity(142, 0, "1,3,11,11,3"),
        entity(102, 0, "4,13,15,17,19"),
        entity(100, 0, "0.,0.5,0.5,0.75,0.5,0.75,0.5"),
        entity(110, 0, "0.,0.,0.,1.,0.,0."),
        entity(110, 0, "1.,0.,0.,1.,1.,0."),
        entity(106, 11, "1,2,0.,1.,1.,0.,1."),
        entity(126, 0, "1,1,1,0,1,0,0.,0.,1.,1.,1.,1.,0.,1.,0.,0.,0.,0.,0.,1.,0.,0.,1."),
        entity(120, 0, "23,25,0.,2."),
        entity(110, 0, "0.,0.,0.,0.,0.,1."),
        entity(104, 1, "0.25,0.,1.,-1.5,0.,1.25,0.,5.,0.,3.,1."),
        entity(122, 0, "11,1.,2.,3."),
        entity(118, 1, "13,17,0,0"),
        entity(124, 0, "0.,-1.,0.,1.,1.,0.,0.,2.,0.,0.,1.,3."),
        entity(406, 15, "1,4Hname"),
        entity(308, 0, "0,3Hsub,1,37"),
        entity(196, 0, "39,2."),
        entity(116, 0, "1.,2.,3."),
        entity(408, 0, "35,1.,2.,3.,1."),
        entity(408, 0, "35,1.,2.,4.,1."),
        entity(186, 0, "47,1,0"),
        entity(514, 1, "1,49,1"),
        entity(510, 1, "3,1,1,51"),
        entity(508, 1, "4,0,53,1,1,1,0,13,0,53,2,1,0,0,53,3,1,0,0,53,4,1,0"),
        entity(504, 1, "4,13,55,1,55,2,15,55,2,55,3,17,55,3,55,4,19,55,4,55,1"),
        entity(502, 1, "4,0.,0.,0.,1.,0.,0.,1.,1.,0.,0.,1.,0."),
        entity(143, 0, "1,3,1,59"),
        entity(141, 0, "1,0,3,2,11,1,0,9,2,1,9"),
        entity(402, 7, "2,1,57"),
        entity(184, 1, "2,45,65,0,31"),
        entity(430, 1, "45"),
        entity(144, 0, "3,1,0,69"),
        entity(142, 0, "1,3,9,0,1"),
    ])
}

#[test]
fn sample_is_read_without_damage() {
    let file = read(sample().as_bytes()).unwrap();
    let faces = file.report.faces;
    assert_eq!((faces.total, faces.read), (8, 8), "{:?}", omissions(&file));
    let model = CadModel::read(sample().as_bytes(), true).unwrap();
    assert!(model.into_world(&mut Description::default()).shapes.len() >= 6);
}

/// Bytes that mean something in a file.
const MEANINGFUL: &[u8] = b",;.0123456789-+EDHPGST \n";

proptest! {
    #![proptest_config(testing::config(100))]

    #[test]
    fn any_change_of_a_file_gives_a_model_or_an_error(changes in testing::changes()) {
        let bytes = testing::damaged(sample().into_bytes(), changes, MEANINGFUL);
        testing::check(&bytes, read)?;
    }
}
