use glanz_math::DVec3;
use glanz_scene::description::{ReceiverDescription, ReceiverSide, ZoneKind};

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

#[test]
fn receivers_are_zones_and_observers_are_placed() {
    let description = read_clean(
        r#"WorldBegin
        Shape "disk" "string receiver" "desk" "string zone" "task"
        Shape "disk" "string receiver" "floor"
        AttributeBegin
        Translate 1 0 0
        Rotate 90 0 0 1
        Observer "glare" "point3 P" [ 0 0 1.2  1 0 1.2 ] "vector3 view" [ 1 0 0  0 2 0 ]
        AttributeEnd
        Observer "cylinder" "point3 P" [ 2 3 1.6 ]"#,
    )
    .description;
    let zones: Vec<_> =
        description.world.shapes.iter().map(|shape| shape.receiver.as_ref().unwrap().zone).collect();
    assert_eq!(zones, [Some(ZoneKind::Task), None]);
    let found: Vec<(DVec3, Option<DVec3>)> =
        description.observers.iter().map(|observer| (observer.position, observer.view)).collect();
    let at = |y: f64| DVec3::new(1.0, y, 1.2);
    let expected = [
        (at(0.0), Some(DVec3::Y)),
        (at(0.0), Some(-2.0 * DVec3::X)),
        (at(1.0), Some(DVec3::Y)),
        (at(1.0), Some(-2.0 * DVec3::X)),
        (DVec3::new(2.0, 3.0, 1.6), None),
    ];
    assert_eq!(found.len(), 5);
    for ((position, view), (place, direction)) in found.into_iter().zip(expected) {
        assert!(position.distance(place) < 1e-12, "{position}");
        assert_eq!(view.is_some(), direction.is_some());
        assert!(view.unwrap_or_default().distance(direction.unwrap_or_default()) < 1e-12, "{view:?}");
    }
    assert_eq!(description.observers[0].location.unwrap().line, 7);
}
