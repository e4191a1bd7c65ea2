//! Scene files with the displacements of an inverse design.

use std::collections::BTreeMap;
use std::sync::Arc;

use glanz_scene::Location;
use glanz_scene::description::{FileId, VariableDescription, VariableQuantity};

use super::lexer::{LexError, Lexer};
use crate::source::{Sources, Span};

/// Error of writing displaced numbers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RewriteError {
    /// The scene was not read from a file, or that cannot be read any more.
    #[error("the scene file cannot be read again")]
    NoFile,
    /// A variable that does not stem from the file.
    #[error("a free number of the scene does not stand in its file")]
    NoNumber,
    /// A place of a variable that has no number.
    #[error("line {line} of the scene file has no free number: {message}")]
    NotANumber {
        /// Line, from 1.
        line: u32,
        /// What is there.
        message: String,
    },
}

/// The bytes of the scene file, as it was read, with its free numbers displaced, metres; all else stays as it is.
///
/// # Errors
/// [`RewriteError`] if the numbers are not in the file.
pub fn rewrite(
    sources: &Sources,
    variables: &[VariableDescription],
    displacements: &[f64],
) -> Result<Vec<u8>, RewriteError> {
    let bytes = sources.bytes(FileId(0)).ok_or(RewriteError::NoFile)?;
    let mut changes: BTreeMap<(u32, u32), (Location, BTreeMap<usize, f64>)> = BTreeMap::new();
    for (variable, &t) in variables.iter().zip(displacements) {
        let numbers = variable.numbers.as_ref().ok_or(RewriteError::NoNumber)?;
        let first = numbers.first;
        let (_, list) = changes.entry((first.line, first.column)).or_insert((first, BTreeMap::new()));
        for &(position, weight) in &numbers.positions {
            let change: &[f64] = match variable.quantity {
                VariableQuantity::Radius { .. } => &[t],
                _ => &(t * weight * variable.direction).to_array(),
            };
            for (number, change) in (position..).zip(change) {
                *list.entry(number).or_default() += change;
            }
        }
    }
    let mut rewritten = Vec::with_capacity(bytes.len());
    let mut copied = 0;
    for (first, list) in changes.into_values() {
        let offset = offset(&bytes, first).ok_or_else(|| RewriteError::NotANumber {
            line: first.line,
            message: "it is shorter".to_owned(),
        })?;
        let mut lexer = Lexer::resume(Arc::clone(&bytes), &Span { location: first, offset, length: 1 });
        let mut at = 0;
        // What does not change keeps its digits.
        for (number, change) in list.into_iter().filter(|(_, change)| *change != 0.0) {
            let span = lexer.word_after(number - at);
            at = number;
            let value = lexer.clone().float().map_err(|LexError { message, place, .. }| {
                RewriteError::NotANumber { line: place.location.line, message }
            })?;
            rewritten.extend_from_slice(bytes.get(copied..span.offset).unwrap_or_default());
            rewritten.extend_from_slice((value + change).to_string().as_bytes());
            copied = span.offset + span.length;
        }
    }
    rewritten.extend_from_slice(bytes.get(copied..).unwrap_or_default());
    Ok(rewritten)
}

/// Offset of a place in the bytes of its file.
fn offset(bytes: &[u8], place: Location) -> Option<usize> {
    let lines = bytes.split_inclusive(|&byte| byte == b'\n');
    let before: usize = lines.take(place.line.checked_sub(1)? as usize).map(<[u8]>::len).sum();
    let line = bytes.get(before..)?;
    // The column counts characters, of which each has one byte that does not continue it; a byte order mark does not count.
    let mark = if before == 0 && line.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 };
    let starts = line.iter().enumerate().skip(mark).filter(|(_, byte)| **byte & 0xC0 != 0x80);
    let mut starts = starts.skip(place.column.checked_sub(1)? as usize);
    Some(before + starts.next()?.0)
}

#[cfg(test)]
mod tests {
    use glanz_math::DVec3;
    use glanz_scene::description::{GeometryDescription, LightKind, TargetDescription, TargetKind};

    use super::*;
    use crate::registry::{Loaded, Options, load_str};

    const SCENE: &str = r#"# a bent mirror ä
WorldBegin
LightSource "point" "point3 from" [ 1 2 3 ] "string free" "from" "vector3 freedirection" [ 0 0 2  1 0 0 ]
AttributeBegin
Translate 0 0 4 Scale 2 2 2
Shape "sphere" "float radius" .5 "string free" "radius" "float freerange" [ -.1 .2 ]
Shape "disk" "vector3 offset" [ 0 0 1 ] "string free" "offset" "string receiver" "floor"
  "string target" "even" "float targetmargin" .1 "float targetweight" 3
AttributeEnd
Shape "bezierpatch" "integer udegree" 1 "integer vdegree" 2 "string free" "P" "integer freegroups" [ 0 -1 0 7 7 -1 ]
  "point3 P" [ 0 0 0   1 0 0.10   # the first row
               0 1 0   1 1 0   0 2 0   1 2 0 ]
  "string target" "collimation" "vector3 targetdirection" [ 0 0 3 ]
Shape "nurbs" "integer nu" 2 "integer uorder" 2 "integer nv" 2 "integer vorder" 2 "float uknots" [ 0 0 1 1 ] "float vknots" [ 0 0 1 1 ]
  "float Pw" [ 0 0 0 1  2 0 0 2  0 1 0 1  1 1 0 1 ] "string free" "Pw" "vector3 freedirection" [ 0 1 0 ]
"#;

    fn loaded(text: &str) -> Loaded {
        load_str("bent.pbrt", text, &Options::default()).unwrap()
    }

    #[test]
    fn design_of_a_scene_is_read() {
        let Loaded { description, diagnostics, .. } = loaded(SCENE);
        assert!(diagnostics.is_empty(), "{diagnostics}");
        let design = &description.design;
        let quantities: Vec<(&VariableQuantity, DVec3)> =
            design.variables.iter().map(|v| (&v.quantity, v.direction)).collect();
        let points = |points: &[usize]| VariableQuantity::ControlPoints { shape: 2, points: points.to_vec() };
        assert_eq!(quantities[0], (&VariableQuantity::LightPosition { light: 0 }, DVec3::Z));
        assert_eq!(quantities[1], (&VariableQuantity::LightPosition { light: 0 }, DVec3::X));
        assert_eq!(*quantities[2].0, VariableQuantity::Radius { shape: 0 });
        assert_eq!(design.variables[2].range, [-0.1, 0.2]);
        assert_eq!(quantities[3], (&VariableQuantity::ShapeOffset { shape: 1 }, DVec3::Z));
        // In files u runs fastest; in descriptions, v: points 0 and 2 of the file are at u = 0 with v = 0 and 1.
        assert_eq!(quantities[4], (&points(&[0, 1]), DVec3::Z));
        assert_eq!(quantities[5], (&points(&[4, 2]), DVec3::Z));
        assert_eq!(quantities.len(), 10);
        let kinds: Vec<(usize, f64, &TargetKind)> = design
            .targets
            .iter()
            .map(|TargetDescription { shape, weight, kind, .. }| (*shape, *weight, kind))
            .collect();
        assert_eq!(kinds[0], (1, 3.0, &TargetKind::Even { margin: 0.1 }));
        assert_eq!(kinds[1], (2, 1.0, &TargetKind::Collimation { direction: DVec3::Z }));
    }

    #[test]
    fn rewritten_scene_is_the_displaced_one_and_keeps_all_other_bytes() {
        let before = loaded(SCENE);
        let displacements = [0.5, -0.25, 0.125, 2.0, 0.0625, 0.0, 0.0, 0.5, 0.0, 0.0];
        let text = rewrite(&before.sources, &before.description.design.variables, &displacements).unwrap();
        let text = String::from_utf8(text).unwrap();
        let expected = SCENE
            .replace("\"point3 from\" [ 1 2 3 ]", "\"point3 from\" [ 0.75 2 3.5 ]")
            .replace("\"float radius\" .5", "\"float radius\" 0.625")
            .replace("[ 0 0 1 ] \"string free\" \"offset\"", "[ 0 0 3 ] \"string free\" \"offset\"")
            .replace("[ 0 0 0   1 0 0.10   #", "[ 0 0 0.0625   1 0 0.10   #")
            .replace("               0 1 0   1", "               0 1 0.0625   1")
            .replace("2 0 0 2  0 1 0 1", "2 1 0 2  0 1 0 1");
        assert_eq!(text, expected);
        let (moved, read) = (before.description.displaced(&displacements), loaded(&text).description);
        for (a, b) in moved.world.shapes.iter().zip(&read.world.shapes) {
            assert_eq!(a.to_parent, b.to_parent);
            assert_eq!(format!("{:?}", a.geometry), format!("{:?}", b.geometry));
        }
        let (LightKind::Point { from: a, .. }, LightKind::Point { from: b, .. }) =
            (&moved.lights[0].kind, &read.lights[0].kind)
        else {
            panic!()
        };
        assert_eq!(a, b);
        assert!(matches!(read.world.shapes[2].geometry, GeometryDescription::BezierPatches(_)));
    }

    #[test]
    fn points_that_patches_share_move_all_of_these() {
        // Two patches of 4 x 4 points side by side, among 7 x 4 points and one that no patch has.
        let points: String = (0..29).map(|n| format!("{} {} 0  ", n % 7, n / 7)).collect();
        let corners = [0, 3].map(|first| (0..16).map(move |n| first + n % 4 + 7 * (n / 4)));
        let corners: String = corners.into_iter().flatten().map(|n| format!("{n} ")).collect();
        // Point 10 is in both patches, 8 in the first, 28 in none.
        let groups: String = (0..29)
            .map(|n| match n {
                8 => "5 ",
                10 => "2 ",
                28 => "9 ",
                _ => "-1 ",
            })
            .collect();
        let text = format!(
            "WorldBegin\nShape \"patchmesh\" \"point3 P\" [{points}] \"integer indices\" [{corners}]\n\
             \"string free\" \"P\" \"integer freegroups\" [{groups}]\n"
        );
        let before = loaded(&text);
        assert!(before.diagnostics.is_empty(), "{}", before.diagnostics);
        let variables = &before.description.design.variables;
        // v runs fastest: number 4 i + j of a patch. Of point 10, i = 3 in the first and i = 0 in the second, j = 1.
        let moved: Vec<&VariableQuantity> = variables.iter().map(|variable| &variable.quantity).collect();
        let points = |points: &[usize]| VariableQuantity::ControlPoints { shape: 0, points: points.to_vec() };
        assert_eq!(moved, [&points(&[13, 17]), &points(&[5])]);
        let displacements = [0.5, 0.25];
        let again = rewrite(&before.sources, variables, &displacements).unwrap();
        let again = loaded(&String::from_utf8(again).unwrap()).description;
        let displaced = before.description.displaced(&displacements);
        let [before, displaced, again] =
            [&before.description, &displaced, &again].map(|d| format!("{:?}", d.world.shapes[0].geometry));
        assert_eq!(again, displaced);
        assert_ne!(again, before);
    }

    #[test]
    fn wrong_designs_are_refused_at_their_place() {
        let refused = |line: &str, words: &[&str]| {
            let text = format!("WorldBegin\n{line}\n");
            let message = load_str("a.pbrt", &text, &Options::default()).unwrap_err().to_string();
            assert!(message.contains("a.pbrt:2:"), "{message}");
            words.iter().for_each(|word| assert!(message.contains(word), "{word}: {message}"));
        };
        refused(r#"Shape "sphere" "string free" "radius""#, &["radius", "not given"]);
        refused(r#"Shape "sphere" "string free" "offset""#, &["[0 0 0]"]);
        refused(r#"Shape "sphere" "float zmin" -1 "string free" "zmin""#, &["zmin", "cannot be free"]);
        refused(
            r#"Shape "disk" "float radius" 1 "string free" "radius" "float freerange" [.1 .2]"#,
            &["freerange"],
        );
        refused(
            r#"Shape "disk" "float radius" 1 "string free" "radius" "integer freegroups" [1]"#,
            &["freegroups"],
        );
        let patch = r#"Shape "bezierpatch" "integer udegree" 1 "integer vdegree" 1 "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0]"#;
        refused(
            &format!(r#"{patch} "string free" "P" "integer freegroups" [1 2 3]"#),
            &["3 numbers", "4 points"],
        );
        refused(&format!(r#"{patch} "string free" "P" "vector3 freedirection" [0 0 0]"#), &["freedirection"]);
        refused(r#"Shape "disk" "string target" "evn""#, &["evn", "even, values"]);
        refused(r#"Shape "disk" "string target" "values""#, &["targetcells"]);
        refused(
            r#"Shape "disk" "string target" "values" "integer targetcells" [2 2] "float targetvalues" [1 2 3]"#,
            &["3 numbers", "2 times 2"],
        );
        refused(r#"Shape "disk" "string target" "even" "float targetmargin" -1"#, &["targetmargin"]);
        refused(
            &format!(r#"{patch} "string free" "P" "vector3 freedirection" [1 1 0  0 0 1  -3 -3 0]"#),
            &["freedirection", "twice"],
        );
        refused(
            &format!(r#"{patch} "string free" "P" "vector3 freedirection" [1 0 0 0 1 0 0 0 1 1 1 0]"#),
            &["freedirection", "4 vectors"],
        );
        // Numbers that the shape does not read.
        let unused = &["cannot be free", "does not use"];
        let weighted = r#""float Pw" [0 0 0 1 1 0 0 1 0 1 0 1 1 1 0 1]"#;
        refused(&format!(r#"{patch} {weighted} "string free" "P""#), unused);
        refused(&format!(r#"{patch} "float radius" 1 "string free" "radius""#), unused);
        refused(r#"Shape "sphere" "float radius" 1 "float radius" 2 "string free" "radius""#, unused);
        refused(
            r#"Shape "disk" "integer solid" 1 "string free" "solid""#,
            &["cannot be free", "free numbers are"],
        );
        // Numbers of another type, and numbers that other shapes have, too.
        refused(
            r#"Shape "sphere" "integer radius" 2 "string free" "radius""#,
            &["a.pbrt:2:16:", "\"float radius\""],
        );
        refused(
            r#"LightSource "point" "integer from" [1 2 3] "string free" "from""#,
            &["a.pbrt:2:21:", "integer", "\"point3 from\""],
        );
        let shared = &["a.pbrt:2:", "Attribute", "into the shape"];
        refused(r#"Attribute "shape" "float radius" 2 Shape "sphere" "string free" "radius""#, shared);
        refused(
            r#"Attribute "shape" "float radius" 2 "string free" "radius" Shape "sphere" Shape "disk""#,
            shared,
        );
        refused(
            r#"Attribute "light" "point3 from" [0 0 1] LightSource "point" "string free" "from""#,
            &["Attribute"],
        );
        refused(r#"LightSource "spot" "point3 from" [0 0 0] "string free" "from""#, &["point"]);
        refused(r#"ObjectBegin "a" Shape "disk" "string target" "even" ObjectEnd"#, &["world"]);
    }
}
