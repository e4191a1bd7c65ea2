//! Valid and invalid lists of parameters.

use super::*;
use glanz_job::ResourceBudget;
use glanz_scene::description::FileId;
use std::sync::Arc;

fn list(text: &str) -> (ParameterList, Reporter) {
    let mut reporter = Reporter::default();
    let bytes: Arc<[u8]> = Arc::from(text.as_bytes());
    let file = reporter.sources.open("t.pbrt", None, &bytes);
    let mut lexer = Lexer::new(bytes, file, &ResourceBudget::default());
    let place = lexer.place(1);
    let list = ParameterList::parse(&mut lexer, "shape \"sphere\"".to_owned(), place).unwrap();
    (list, reporter)
}

fn error(text: &str) -> (String, u32) {
    let mut lexer = Lexer::new(Arc::from(text.as_bytes()), FileId(0), &ResourceBudget::default());
    let place = lexer.place(1);
    let error = ParameterList::parse(&mut lexer, String::new(), place).unwrap_err();
    (error.message, error.place.location.column)
}

#[test]
fn every_type_is_read_with_and_without_brackets() {
    let (mut l, mut r) = list(
        r#""integer i" 3 "float f" [0.5] "bool a" true "bool b" ["false"] "string s" "x"
        "point3 P" [1 2 3 4 5 6] "vector v" [1 0 0] "point2 uv" [0 1] "float st" [1 0 2 0]"#,
    );
    assert_eq!(l.integer("i", &mut r).unwrap(), Some(3));
    assert_eq!(l.float("f", &mut r).unwrap(), Some(0.5));
    assert_eq!(l.boolean("a", &mut r).unwrap(), Some(true));
    assert_eq!(l.boolean("b", &mut r).unwrap(), Some(false));
    assert_eq!(l.text("s", &mut r).unwrap().as_deref(), Some("x"));
    assert_eq!(l.vec3s("P", &mut r).unwrap().unwrap().1, [DVec3::new(1., 2., 3.), DVec3::new(4., 5., 6.)]);
    assert_eq!(l.vec3("v", &mut r).unwrap(), Some(DVec3::X));
    assert_eq!(l.vec2s("uv", &mut r).unwrap().unwrap().1, [DVec2::Y]);
    assert_eq!(l.vec2s("st", &mut r).unwrap().unwrap().1.len(), 2);
    l.finish(&mut r);
    assert!(r.diagnostics.is_empty());
}

#[test]
fn integers_and_whole_floats_are_interchangeable() {
    let (mut l, mut r) = list(r#""integer radius" 3 "float nsamples" 4"#);
    assert_eq!(l.float("radius", &mut r).unwrap(), Some(3.0));
    assert_eq!(l.integer("nsamples", &mut r).unwrap(), Some(4));
}

#[test]
fn errors_of_types_and_counts_name_the_expected_ones() {
    let (mut l, mut r) = list(r#""string radius" "3" "float zmin" [1 2] "point p1" [1 2]"#);
    assert!(l.float("radius", &mut r).is_err());
    assert!(l.float("zmin", &mut r).is_err());
    assert!(l.vec3("p1", &mut r).is_err());
    let found: Vec<_> = r.diagnostics.iter().map(ToString::to_string).collect();
    let line = r#"  1 | "string radius" "3" "float zmin" [1 2] "point p1" [1 2]"#;
    assert_eq!(
        found,
        [
            format!(
                "error: t.pbrt:1:1: shape \"sphere\": parameter \"radius\" is of type string\n{line}\n    | {}\n  help: write it as \"float radius\"\n",
                "^".repeat(15)
            ),
            format!(
                "error: t.pbrt:1:35: shape \"sphere\": parameter \"zmin\" has 2 values; 1 is needed\n{line}\n    | {}^^^\n",
                " ".repeat(34)
            ),
            format!(
                "error: t.pbrt:1:52: shape \"sphere\": parameter \"p1\" has 2 values; a multiple of 3 is needed\n{line}\n    | {}^^^\n",
                " ".repeat(51)
            ),
        ]
    );
}

#[test]
fn unused_parameters_cause_a_warning_with_the_nearest_name() {
    let (mut l, mut r) = list(r#""float raduis" 2 "float foo" 1"#);
    assert_eq!(l.float("radius", &mut r).unwrap(), None);
    l.finish(&mut r);
    let messages: Vec<_> = r.diagnostics.iter().map(|d| (d.message.as_str(), d.help.as_deref())).collect();
    assert_eq!(
        messages,
        [
            ("parameter \"raduis\" is not used by shape \"sphere\"", Some("did you mean \"radius\"?")),
            ("parameter \"foo\" is not used by shape \"sphere\"", None),
        ]
    );
}

#[test]
fn malformed_lists_are_reported_with_their_position() {
    for (text, message, column) in [
        (r#""radius" 1"#, "\"radius\" does not declare a parameter", 1),
        (r#""flaot radius" 1"#, "parameter \"radius\" has the unknown type \"flaot\"", 1),
        (r#""float radius" [1 2 x]"#, "\"x\" is not a number", 21),
        (r#""float radius" [1 nan]"#, "\"nan\" is not a number", 19),
        (r#""float radius" [1 2"#, "the file ends before a bracket is closed", 20),
        (r#""integer n" [1.5]"#, "\"1.5\" is not an integer", 14),
        (r#""bool b" maybe"#, "true or false is expected", 10),
        (r#""string s" 3"#, "a quoted text is expected", 12),
        (r#""float a" [[1]]"#, "a number is expected, not another bracket", 12),
    ] {
        assert_eq!(error(text), (message.to_owned(), column), "{text}");
    }
}
