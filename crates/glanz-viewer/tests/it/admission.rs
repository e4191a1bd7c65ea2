//! Tests of access control and time limits.

use std::io::{Read, Write};
use std::time::Duration;

use glanz_viewer::server::{Limits, ServerSettings};
use tungstenite::client::IntoClientRequest;

use super::client::{BALL, TestPage, TestServer};

#[test]
fn requests_under_another_name_or_from_another_page_are_refused() {
    let server = TestServer::open(BALL);
    let port = server.host.rsplit_once(':').unwrap().1.to_owned();
    for (header, status) in [
        ("Host: evil.example".to_owned(), 421),
        (format!("Host: evil.example:{port}"), 421),
        (format!("Host: localhost.evil.example:{port}"), 421),
        (format!("Host: localhost:{port}"), 200),
        ("Host: 127.0.0.1:1".to_owned(), 200),
    ] {
        assert_eq!(server.request_with("GET /", &[&header], &[]).status, status, "{header}");
    }
    assert_eq!(server.request_with("GET /", &[], &[]).status, 400);
    for origin in ["http://evil.example", "null", "http://127.0.0.1:1", "file://"] {
        let header = format!("Origin: {origin}");
        assert_eq!(server.request("GET /", &[&header], &[]).status, 403, "{origin}");
        assert_eq!(server.request("POST /open?session=x", &[&header], b"x").status, 403, "{origin}");
        let mut request = format!("ws://{}/ws", server.host).into_client_request().unwrap();
        request.headers_mut().insert("Origin", origin.parse().unwrap());
        assert!(tungstenite::client(request, server.connect()).is_err(), "{origin}");
    }
    let mut request = format!("ws://{}/ws", server.host).into_client_request().unwrap();
    request.headers_mut().insert("Origin", format!("http://{}", server.host).parse().unwrap());
    assert!(tungstenite::client(request, server.connect()).is_ok());
}

#[test]
fn server_for_other_machines_admits_holders_of_its_token() {
    let settings = ServerSettings { host: Some("127.0.0.1".to_owned()), ..ServerSettings::default() };
    let server = TestServer::open_with(BALL, settings);
    let (_, token) = server.address.split_once("/?token=").expect("an address with a token");
    assert_eq!(token.len(), 32);
    for path in [
        "/",
        "/main.js",
        "/model/x",
        "/ws",
        "/nowhere",
        "/?token=",
        "/?token=0123456789abcdef0123456789abcdef",
    ] {
        assert_eq!(server.get(path).status, 401, "{path}");
    }
    assert_eq!(server.request("POST /open?session=x", &[], b"x").status, 401);
    assert!(server.try_connect_page().is_none());
    let page = server.get(&format!("/?token={token}"));
    assert_eq!(page.status, 200);
    let cookie = page.header("set-cookie").unwrap();
    assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"), "{cookie}");
    let pair = cookie.split(';').next().unwrap();
    let header = format!("Cookie: other=1; {pair}");
    assert_eq!(server.request("GET /main.js", &[&header], &[]).status, 200);
    let mut request = format!("ws://{}/ws", server.host).into_client_request().unwrap();
    request.headers_mut().insert("Cookie", pair.parse().unwrap());
    assert!(tungstenite::client(request, server.connect()).is_ok());
    // Another server's token does not fit.
    let wrong = format!("Cookie: {}=0123456789abcdef0123456789abcdef", pair.split('=').next().unwrap());
    assert_eq!(server.request("GET /main.js", &[&wrong], &[]).status, 401);
}

/// Visits until there is room: the server learns that a page has gone a little later than the page.
fn visit_when_free(server: &TestServer) -> TestPage {
    loop {
        if let Some(page) = server.try_connect_page() {
            return page;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn number_of_pages_is_limited_and_closed_pages_make_room() {
    let server = TestServer::open_limited(BALL, Limits { sessions: 2, ..Limits::default() });
    let (first, _second) = (server.connect_page(), server.connect_page());
    let answer = server.request(
        "GET /ws",
        &["Upgrade: websocket", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg=="],
        &[],
    );
    // `Connection: close` makes it no upgrade; a page that asks properly is sent away because of the others.
    assert_eq!(answer.status, 400);
    assert!(server.try_connect_page().is_none());
    drop(first);
    visit_when_free(&server);
}

#[test]
fn a_page_that_does_not_answer_is_gone() {
    let limits = Limits {
        sessions: 1,
        ping_interval: Duration::from_millis(20),
        silence: Duration::from_millis(100),
        ..Limits::default()
    };
    let server = TestServer::open_limited(BALL, limits);
    // It reads nothing any more, so that it never answers a ping.
    let _silent = server.connect_page();
    visit_when_free(&server);
}

#[test]
fn a_request_that_never_ends_is_cut_off() {
    let server = TestServer::open_limited(
        BALL,
        Limits { header_time: Duration::from_millis(100), ..Limits::default() },
    );
    let mut slow = server.connect();
    slow.write_all(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-").unwrap();
    let mut rest = Vec::new();
    // Until the server closes the connection; it may say why.
    let _ = slow.read_to_end(&mut rest);
    assert!(rest.is_empty() || rest.starts_with(b"HTTP/1.1 408"), "{rest:?}");
    assert_eq!(server.get("/").status, 200);
}

#[test]
fn headers_without_end_are_refused() {
    let server = TestServer::open(BALL);
    let long = format!("X: {}", "y".repeat(200_000));
    assert!(matches!(server.request("GET /", &[&long], &[]).status, 400 | 431));
    assert_eq!(server.get("/").status, 200);
}
