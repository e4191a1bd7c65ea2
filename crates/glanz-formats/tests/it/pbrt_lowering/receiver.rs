use glanz_scene::description::{ReceiverDescription, ReceiverSide};

use super::*;

fn receivers(text: &str) -> Vec<Option<ReceiverDescription>> {
    read_clean(text).description.world.shapes.into_iter().map(|shape| shape.receiver).collect()
}

#[test]
fn shapes_are_receivers_by_name() {
    let found = receivers(
        r#"WorldBegin
        Shape "disk" "string receiver" "desk" "integer cells" [ 20 10 ] "string receiverside" "both"
        Shape "disk" "string receiver" "floor"
        Shape "disk" "string receiver" "" "integer cells" [ 4 4 ]
        Shape "disk""#,
    );
    let desk = found[0].as_ref().unwrap();
    assert_eq!((desk.name.as_str(), desk.cells, desk.side), ("desk", Some([20, 10]), ReceiverSide::Both));
    let location = desk.location.unwrap();
    assert_eq!((location.line, location.column), (2, 40));
    let floor = found[1].as_ref().unwrap();
    assert_eq!((floor.name.as_str(), floor.cells, floor.side), ("floor", None, ReceiverSide::Front));
    assert_eq!(found[2..], [None, None]);
}

#[test]
fn attributes_make_receivers_of_the_shapes_to_come() {
    let found = receivers(
        r#"Option "bool any" true WorldBegin
        AttributeBegin
        Attribute "shape" "string receiver" "walls" "integer cells" [ 6 6 ] "string receiverside" "back"
        Shape "disk"
        Shape "disk" "string receiver" "door"
        Shape "disk" "string receiver" ""
        AttributeEnd
        Shape "disk""#,
    );
    let names: Vec<_> = found.iter().map(|r| r.as_ref().map(|r| r.name.as_str())).collect();
    assert_eq!(names, [Some("walls"), Some("door"), None, None]);
    for receiver in found.iter().flatten() {
        assert_eq!((receiver.cells, receiver.side), (Some([6, 6]), ReceiverSide::Back));
    }
}
