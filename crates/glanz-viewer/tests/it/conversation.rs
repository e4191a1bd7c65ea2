//! Messages: what is asked, and what makes no sense.

use serde_json::{Value, json};
use tungstenite::Message;

use super::client::{BALL, ReceivedMessage, TestServer, view};

#[test]
fn pick_describes_the_surface_that_the_ray_hits() {
    let server = TestServer::open(BALL);
    let mut page = server.connect_page();
    let pick = |id: u32, hidden: &[u32], section: Value| json!({ "type": "pick", "id": id, "origin": [0, -4, 0], "direction": [0, 2, 0], "hidden": hidden, "section": section });
    page.send(pick(1, &[], Value::Null));
    let hit = page.receive_text("hit");
    // The ray along +y meets the unit ball at y = -1, 3 m from where it begins.
    assert_eq!(
        (&hit["id"], &hit["hit"]["leaf"], &hit["hit"]["kind"]),
        (&json!(1), &json!(0), &json!("sphere"))
    );
    assert!((hit["hit"]["distance"].as_f64().unwrap() - 3.0).abs() < 1e-9, "{hit}");
    // With y <= -2 alone nothing is left of it, and with the ball hidden there is nothing behind.
    page.send(pick(2, &[], json!([0, 1, 0, -2])));
    assert_eq!(page.receive_text("hit"), json!({ "type": "hit", "id": 2, "hit": null }));
    page.send(pick(3, &[0], Value::Null));
    assert_eq!(page.receive_text("hit"), json!({ "type": "hit", "id": 3, "hit": null }));
    page.send(json!({ "type": "pick", "id": 4, "origin": [0, 0, 0], "direction": [0, 0, 0] }));
    assert_eq!(page.receive_text("failed")["id"], 4);
}

#[test]
fn nothing_waits_for_the_pick_of_a_large_surface() {
    // Strips of a nearly flat surface whose area is integrated patch by patch.
    let patches: String = (0..20_000).map(|i| format!("{i} 0 0 {0} 0 0 {i} 1 .01 {0} 1 0 ", i + 1)).collect();
    let server = TestServer::open(&format!(
        "LookAt 0 0 9  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n\
         Shape \"bezierpatch\" \"integer udegree\" 1 \"integer vdegree\" 1 \"point3 P\" [ {patches} ]\n"
    ));
    let mut page = server.connect_page();
    let pick =
        |id: u32| json!({ "type": "pick", "id": id, "origin": [0.5, 0.5, 4], "direction": [0, 0, -1] });
    page.send(pick(1));
    page.send(json!({ "type": "stop", "id": 2 }));
    let ReceivedMessage::Text(first) = page.receive() else { panic!() };
    assert_eq!(first, json!({ "type": "stopped", "id": 2 }));
    let hit = page.receive_text("hit");
    assert_eq!(hit["id"], 1);
    assert!((hit["hit"]["area"].as_f64().unwrap() / 20_000.0 - 1.0).abs() < 1e-3, "{hit}");
    // Every one is answered, if only by the reason why it is not served.
    (0..300).for_each(|id| page.send(pick(id)));
    let mut answered: Vec<u64> = (0..300)
        .map(|_| match page.receive() {
            ReceivedMessage::Text(answer) if answer["type"] == "hit" || answer["type"] == "failed" => {
                answer["id"].as_u64().unwrap()
            }
            other => panic!("{other:?}"),
        })
        .collect();
    answered.sort_unstable();
    assert_eq!(answered, (0..300).collect::<Vec<u64>>());
}

#[test]
fn requests_that_cannot_be_served_are_answered() {
    let server = TestServer::open(BALL);
    let mut page = server.connect_page();
    page.send(json!({ "type": "save", "id": 1 }));
    assert_eq!(page.receive_text("failed")["id"], 1);
    page.send(json!({ "type": "stop", "id": 2 }));
    assert_eq!(page.receive_text("stopped")["id"], 2);
    for (id, size) in [(3, [0, 5]), (4, [5000, 5]), (5, [u32::MAX, u32::MAX])] {
        page.send(view(id, size, &[]));
        assert_eq!(page.receive_text("failed")["id"], id);
    }
    let mut odd = view(6, [8, 8], &[]);
    odd["camera"]["up"] = json!([1, 0, 0]);
    page.send(&odd);
    let failed = page.receive_text("failed");
    assert_eq!(failed["id"], 6);
    assert!(failed["message"].as_str().unwrap().contains("orthonormal"), "{failed}");
}

#[test]
fn malformed_messages_are_answered_and_too_many_end_the_conversation() {
    let server = TestServer::open(BALL);
    let (mut page, mut other) = (server.connect_page(), server.connect_page());
    let nonsense = ["", "{}", "[]", "\u{0}", "{\"type\":\"view\",\"id\":7}", "{\"type\":\"dance\",\"id\":8}"];
    for text in nonsense {
        page.send(text);
        assert_eq!(
            page.receive_text("failed")["id"],
            if text.ends_with("7}") {
                7
            } else if text.ends_with("8}") {
                8
            } else {
                0
            }
        );
    }
    page.socket.send(Message::binary(vec![0; 100])).unwrap();
    page.receive_text("failed");
    // 16 are borne.
    for _ in nonsense.len() + 1..16 {
        page.send("?");
        page.receive_text("failed");
    }
    page.send("?");
    assert!(matches!(page.receive(), ReceivedMessage::Closed(Some(1008))));
    other.send(json!({ "type": "stop", "id": 1 }));
    other.receive_text("stopped");
}

#[test]
fn messages_that_are_too_long_end_the_conversation() {
    let server = TestServer::open(BALL);
    let mut other = server.connect_page();
    for length in [(64 << 10) + 1, 10 << 20] {
        let mut page = server.connect_page();
        // The server need not take all of it.
        let _ = page.socket.send(Message::text("x".repeat(length)));
        let heard = page.receive();
        assert!(matches!(heard, ReceivedMessage::Closed(_)), "{heard:?}");
    }
    other.send(json!({ "type": "stop", "id": 1 }));
    other.receive_text("stopped");
}
