//! Upload of files that are dropped on a page.

use std::time::Duration;

use glanz_viewer::server::Limits;
use serde_json::Value;

use super::client::{BALL, HttpResponse, TestPage, TestServer};

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// The body with these files, as pages send it.
fn body(files: &[(&str, &str)]) -> Vec<u8> {
    let list: Vec<(&str, usize)> = files.iter().map(|(name, text)| (*name, text.len())).collect();
    let texts: String = files.iter().map(|(_, text)| *text).collect();
    format!("{}\n{texts}", serde_json::to_string(&list).unwrap()).into_bytes()
}

pub(crate) fn send(server: &TestServer, session: &str, files: &[(&str, &str)]) -> HttpResponse {
    let line = format!("POST /open?session={session}");
    server.request(&line, &[], &body(files))
}

pub(crate) fn drop_on(server: &TestServer, page: &TestPage, files: &[(&str, &str)]) -> HttpResponse {
    send(server, page.session(), files)
}

#[test]
fn a_dropped_scene_is_shown_on_that_page_alone() {
    let server = TestServer::open(BALL);
    let (mut page, mut other) = (server.connect_page(), server.connect_page());
    let scene = "WorldBegin\nInclude \"parts/a.pbrt\"\n";
    let part = "Shape \"plymesh\" \"string filename\" \"mesh.ply\"\n";
    let files = [("parts/a.pbrt", part), ("own.pbrt", scene), ("mesh.ply", TRIANGLE)];
    let answer = drop_on(&server, &page, &files);
    assert_eq!(answer.status, 200, "{}", answer.text());
    let told: Value = serde_json::from_slice(&answer.body).unwrap();
    assert_eq!(told, page.receive_text("scene"));
    assert_eq!((&told["name"], &told["session"]), (&Value::from("own.pbrt"), &page.scene["session"]));
    assert_ne!(told["model"], page.scene["model"]);
    assert_eq!(server.get(told["model"].as_str().unwrap()).status, 200);
    // The pick hits the triangle now: it lies in the plane z = 0.
    let pick = r#"{"type":"pick","id":1,"origin":[0.2,0.2,9],"direction":[0,0,-1]}"#;
    page.send(pick);
    assert_eq!(page.receive_text("hit")["hit"]["distance"], 9.0);
    // The other page still shows the ball, of radius 1, and the one above it.
    other.send(pick);
    assert!(other.receive_text("hit")["hit"]["distance"].as_f64().is_some_and(|d| d < 6.0));
    assert_eq!(server.connect_page().scene["name"], "scene.pbrt");
    // Nobody needs the model when the page has gone.
    drop(page);
    let gone = told["model"].as_str().unwrap();
    while server.get(gone).status == 200 {
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_dropped_model_is_shown_in_a_studio() {
    let server = TestServer::open(BALL);
    let mut page = server.connect_page();
    let answer = drop_on(&server, &page, &[("a.ply", TRIANGLE)]);
    assert_eq!(answer.status, 200, "{}", answer.text());
    assert_eq!(page.receive_text("scene")["name"], "a.ply");
    // The triangle in the plane z = 0, and beside it the ground, since y is up.
    for (origin, distance) in [([0.2, 0.2, 9.0], Value::from(9.0)), ([2.0, 0.2, 9.0], Value::Null)] {
        let pick = serde_json::json!({ "type": "pick", "id": 1, "origin": origin, "direction": [0, 0, -1] });
        page.send(pick);
        assert_eq!(page.receive_text("hit")["hit"]["distance"], distance);
    }
    let down = r#"{"type":"pick","id":2,"origin":[2,1,9],"direction":[0,-1,0]}"#;
    page.send(down);
    assert!(page.receive_text("hit")["hit"]["distance"].as_f64().is_some_and(|d| (d - 1.0).abs() < 1e-3));
}

#[test]
fn errors_of_a_dropped_scene_are_reported() {
    let server = TestServer::open(BALL);
    let page = server.connect_page();
    for (files, said) in [
        (
            vec![("a.pbrt", "WorldBegin\nShape \"blob\"\nShape\n")],
            "error: a.pbrt:3:1: Shape needs a name in quotes",
        ),
        (
            vec![("a.pbrt", "WorldBegin\nInclude \"/etc/passwd\"\n")],
            "a.pbrt:2:9: Include: file \"/etc/passwd\" is outside",
        ),
        (
            vec![("a.pbrt", "WorldBegin\nInclude \"../../etc/passwd\"\n")],
            "is outside the folder of the scene",
        ),
        (vec![("a.pbrt", "WorldBegin\nInclude \"b.pbrt\"\n")], "file \"b.pbrt\" is not there"),
        (vec![("a.pbrt", "WorldBegin\nShape \"sphere\" \"float radius\" -1\n")], "a.pbrt:2:1: "),
        (vec![("a.pbrt", "\u{0}\u{1}")], "not in a known scene format"),
        (vec![("a.txt", TRIANGLE)], "none of the files is a scene"),
        (vec![("a.ply", TRIANGLE), ("b.ply", TRIANGLE)], "several files are models"),
        (vec![("a.ply", "ply\nformat odd 1.0\n")], "error: a.ply:2:"),
        (vec![("a.pbrt", BALL), ("b.pbrt", BALL)], "several files may be the scene (a.pbrt, b.pbrt)"),
        (vec![], "none of the files is a scene"),
    ] {
        let answer = drop_on(&server, &page, &files);
        assert_eq!(answer.status, 422, "{files:?} {}", answer.text());
        assert!(answer.text().contains(said), "{}", answer.text());
        // The temporary folder must not be revealed.
        assert!(!answer.text().contains("glanz-"), "{}", answer.text());
    }
}

#[test]
fn uploads_that_ask_for_too_much_are_refused() {
    let limits = Limits { upload_bytes: 10_000, upload_files: 3, ..Limits::default() };
    let server = TestServer::open_limited(BALL, limits);
    let page = server.connect_page();
    let long = "x".repeat(20_000);
    for (files, status) in [
        (vec![("a.pbrt", long.as_str())], 413),
        (vec![("1", ""), ("2", ""), ("3", ""), ("4", "")], 413),
        (vec![("../a.pbrt", BALL)], 400),
        (vec![("/a.pbrt", BALL)], 400),
        (vec![("a\\b.pbrt", BALL)], 400),
        (vec![("", BALL)], 400),
        (vec![("a.pbrt", BALL), ("a.pbrt", BALL)], 400),
        (vec![("a", BALL), ("a/b", BALL)], 500),
    ] {
        let answer = drop_on(&server, &page, &files);
        assert_eq!(answer.status, status, "{}", answer.text());
    }
    for session in ["", "x", "00000000000000000000000000000000"] {
        assert_eq!(send(&server, session, &[("a.pbrt", BALL)]).status, 400, "{session}");
    }
    let line = format!("POST /open?session={}", page.session());
    for (body, status) in [
        ("x", 400),
        ("x\n", 400),
        ("[[\"a.pbrt\",1]]", 400),
        ("[[\"a.pbrt\",-1]]\n", 400),
        ("[[\"a.pbrt\",2]]\nx", 400),
        ("[[\"a.pbrt\",99999999999999999]]\nx", 413),
        ("[[\"a.pbrt\",9999],[\"b.pbrt\",18446744073709551615]]\nx", 413),
        (&" ".repeat(9000), 413),
    ] {
        assert_eq!(server.request(&line, &[], body.as_bytes()).status, status, "{body:?}");
    }
    assert_eq!(drop_on(&server, &page, &[("a.pbrt", BALL)]).status, 200);
}

/// The connection of an upload of which the files do not come.
fn begun_upload(server: &TestServer, page: &TestPage) -> std::net::TcpStream {
    let head = format!(
        "POST /open?session={} HTTP/1.1\r\nHost: {}\r\nContent-Length: 1000\r\n\r\n\
         [[\"a.pbrt\",983]]\n",
        page.session(),
        server.host
    );
    let mut stream = server.connect();
    std::io::Write::write_all(&mut stream, head.as_bytes()).unwrap();
    stream
}

#[test]
fn an_upload_that_does_not_come_is_given_up() {
    let server = TestServer::open_limited(
        BALL,
        Limits { upload_time: Duration::from_millis(100), ..Limits::default() },
    );
    let page = server.connect_page();
    let mut stream = begun_upload(&server, &page);
    let mut first = [0; 12];
    std::io::Read::read_exact(&mut stream, &mut first).unwrap();
    assert_eq!(&first, b"HTTP/1.1 408");
    assert_eq!(drop_on(&server, &page, &[("a.pbrt", BALL)]).status, 200);
}

#[test]
fn an_upload_ends_when_its_page_leaves() {
    let limits = Limits { uploads: 1, upload_time: Duration::from_secs(600), ..Limits::default() };
    let server = TestServer::open_limited(BALL, limits);
    let (page, other) = (server.connect_page(), server.connect_page());
    let mut stream = begun_upload(&server, &page);
    // Time for it to take the only permit.
    std::thread::sleep(Duration::from_millis(300));
    drop(page);
    let mut first = [0; 12];
    std::io::Read::read_exact(&mut stream, &mut first).unwrap();
    assert_eq!(&first, b"HTTP/1.1 400");
    assert_eq!(drop_on(&server, &other, &[("a.pbrt", BALL)]).status, 200);
}
