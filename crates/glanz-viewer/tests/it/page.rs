//! The files of the page and the model.

use std::fs;
use std::path::Path;

use super::client::{BALL, TestServer};

/// Paths of all files below `folder`, with `prefix` in front.
fn walk(folder: &Path, prefix: &str, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let path = format!("{prefix}{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            walk(&entry.path(), &format!("{path}/"), found);
        } else {
            found.push(path);
        }
    }
}

#[test]
fn every_file_of_the_page_is_served_with_its_type_and_a_tag() {
    let server = TestServer::open(BALL);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("web");
    let mut files = Vec::new();
    walk(&folder, "", &mut files);
    for file in &files {
        let answer = server.get(&format!("/{file}"));
        assert_eq!(answer.status, 200, "{file}");
        assert_eq!(answer.body, fs::read(folder.join(file)).unwrap(), "{file}");
        let kind = match file.rsplit_once('.').unwrap().1 {
            "js" => "text/javascript; charset=utf-8",
            "css" => "text/css; charset=utf-8",
            "html" => "text/html; charset=utf-8",
            "svg" => "image/svg+xml",
            other => panic!("{file}: {other}"),
        };
        assert_eq!(answer.header("content-type"), Some(kind), "{file}");
        let tag = answer.header("etag").unwrap();
        let again = server.request(&format!("GET /{file}"), &[&format!("If-None-Match: \"x\", {tag}")], &[]);
        assert_eq!((again.status, again.body.len()), (304, 0), "{file}");
        assert_eq!(answer.header("cache-control"), Some("no-cache"), "{file}");
    }
    assert_eq!(server.get("/").body, fs::read(folder.join("index.html")).unwrap());
    assert_eq!(server.get("/?x=y").status, 200);
    let head = server.request("HEAD /main.js", &[], &[]);
    assert_eq!((head.status, head.body.len()), (200, 0));
}

#[test]
fn paths_that_lead_elsewhere_lead_nowhere() {
    let server = TestServer::open(BALL);
    for path in [
        "/../Cargo.toml",
        "/gl/../../Cargo.toml",
        "/%2e%2e/Cargo.toml",
        "/..%2fCargo.toml",
        "//etc/passwd",
        "/etc/passwd",
        "/scene.pbrt",
        "/index.html%00.js",
        "/gl",
        "/gl/",
        "/INDEX.HTML",
        "/model/",
        "/model/../ws",
        "/model/%2e%2e%2f%2e%2e%2fetc%2fpasswd",
        "/model/00000000000000000000000000000000",
        "/open/x",
    ] {
        let answer = server.get(path);
        assert!(matches!(answer.status, 404), "{path}: {}", answer.status);
        assert!(answer.body.len() < 64, "{path}");
    }
    for line in ["GET ../Cargo.toml", "GET \\..\\Cargo.toml", "GET /\u{e4}\u{0}"] {
        assert!(matches!(server.request(line, &[], &[]).status, 400 | 404), "{line}");
    }
    assert_eq!(server.request("POST /", &[], &[]).status, 405);
    assert_eq!(server.request("DELETE /main.js", &[], &[]).status, 405);
    assert_eq!(server.request("GET /open", &[], &[]).status, 405);
    // Nothing of it hurt the server.
    assert_eq!(server.get("/").status, 200);
}

#[test]
fn every_response_has_security_headers() {
    let server = TestServer::open(BALL);
    let model = server.connect_page().scene["model"].as_str().unwrap().to_owned();
    let answers = [
        server.get("/"),
        server.get("/main.js"),
        server.get(&model),
        server.get("/nowhere"),
        server.get("/ws"),
        server.request("POST /", &[], &[]),
        server.request("POST /open", &[], b"x"),
        server.request_with("GET /", &["Host: evil.example"], &[]),
    ];
    for answer in answers {
        let policy = answer.header("content-security-policy").expect("a policy");
        assert!(policy.starts_with("default-src 'self';") && !policy.contains("unsafe"), "{policy}");
        for (name, value) in [
            ("x-content-type-options", "nosniff"),
            ("referrer-policy", "no-referrer"),
            ("cross-origin-opener-policy", "same-origin"),
            ("cross-origin-embedder-policy", "require-corp"),
            ("cross-origin-resource-policy", "same-origin"),
        ] {
            assert_eq!(answer.header(name), Some(value), "{}", answer.status);
        }
        assert!(answer.header("cache-control").is_some(), "{}", answer.status);
    }
}

#[test]
fn model_is_served_under_the_name_in_the_scene_message() {
    let server = TestServer::open(BALL);
    let page = server.connect_page();
    assert_eq!(page.scene["name"], "scene.pbrt");
    assert_eq!(page.scene["integrator"], "path");
    assert!(page.scene["error"].is_null());
    let answer = server.get(page.scene["model"].as_str().unwrap());
    assert_eq!(answer.status, 200);
    assert!(answer.body.starts_with(b"GLANZVW1"));
    assert_eq!(answer.header("content-type"), Some("application/octet-stream"));
    assert_eq!(answer.header("cache-control"), Some("no-store"));
}
