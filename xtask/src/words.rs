//! Names and phrases that readers of the field should not meet: one list, searched in sources and documents.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::workspace;

/// Names of types, and what to use instead.
const TYPES: &[(&str, &str)] = &[
    ("Against", "a noun for what is compared"),
    ("Along", "a noun"),
    ("Before", "a noun"),
    ("Clerk", "ThreadTally"),
    ("Directions", "DirectionSampler"),
    ("Draft", "LeafBuilder"),
    ("Dress", "SceneOverlay"),
    ("Every", "a noun"),
    ("Flight", "ParticlePath"),
    ("Found", "a noun for what is found, such as Root or IlluminateOutcome"),
    ("Gathered", "a noun for what is gathered"),
    ("Hands", "PointerControls"),
    ("Heard", "a noun for what is received, such as ServerMessage"),
    ("House", "AppState"),
    ("Keeper", "CheckpointWriter"),
    ("Kept", "a noun for what is kept, such as SampleStore"),
    ("Laid", "a noun for what is laid out"),
    ("Learner", "DensityFitter"),
    ("Learnt", "a noun for what is learnt, such as GuideUpdate"),
    ("Lessons", "TrainingSums"),
    ("Look", "LeafProjection"),
    ("Made", "a noun for what is made"),
    ("Met", "a noun for what is met"),
    ("Odds", "RouletteState"),
    ("Of", "a noun"),
    ("Posted", "PublishedModel"),
    ("Ran", "a noun for what ran"),
    ("Reported", "a noun"),
    ("Seat", "SessionSlot"),
    ("Seen", "a noun for what is seen"),
    ("Served", "a noun for what serves, such as ServerProcess"),
    ("Settled", "WeightedSums"),
    ("Shown", "a noun for what is shown"),
    ("Sight", "SurfaceFrame"),
    ("Solved", "Solution with its noun in front"),
    ("Surroundings", "StreamContext"),
    ("Talk", "Verbosity"),
    ("Taught", "a noun"),
    ("Teller", "ProgressSink"),
    ("Told", "a noun for what is told"),
    ("Truth", "RenderedImage"),
    ("Way", "PreviousVertex"),
    ("Whose", "a noun"),
];

/// Names of source files and folders, and what to use instead.
const MODULES: &[(&str, &str)] = &[
    ("against", "comparison"),
    ("aimed", "a noun"),
    ("along", "a noun"),
    ("chosen", "a noun"),
    ("dress", "overlay"),
    ("few", "a noun"),
    ("hands", "pointer_controls"),
    ("house", "app_state"),
    ("kept", "cache"),
    ("seen", "a noun for what is seen"),
    ("settled", "weighted_sums"),
    ("shown", "a noun for what is shown"),
    ("stage", "setup"),
    ("tell", "report"),
    ("things", "objects"),
    ("truth", "rendered_image"),
];

/// First words of a documentation comment, which should be a noun phrase or a verb in the third person.
const OPENINGS: &[&str] = &[
    "what became of",
    "what becomes of",
    "what came of",
    "whether somebody",
    "who ",
    "whom ",
    "whose ",
    "why not",
    "why there are",
    "why there is",
];

/// Phrases in comments and documents, and what to write instead.
const PHRASES: &[(&str, &str)] = &[
    ("became of", "the result"),
    ("becomes of", "the result"),
    ("goes on with", "continues"),
    ("looks on", "watches"),
    ("which is what", "two sentences"),
    ("who wants", "to"),
];

/// Names of types that may be defined in several modules: associated types, and words that every Rust library uses for its own.
const CONVENTIONAL: &[&str] = &["Err", "Error", "Item", "Node", "Output", "Scalar", "Settings", "Target"];

/// Lists of the words above are in these files.
const EXEMPT: &[&str] = &["xtask/src/words.rs"];

/// A place with what is wrong there.
type Fault = String;

/// Searches all sources and documents.
///
/// # Errors
/// One line per fault.
pub(crate) fn check() -> Result<String, String> {
    let (files, faults) = search()?;
    if faults.is_empty() {
        Ok(format!("{files} files, no banned name or phrase"))
    } else {
        Err(faults.join("\n"))
    }
}

/// Lists the faults without failing.
///
/// # Errors
/// A file cannot be read.
pub(crate) fn report() -> Result<String, String> {
    let (files, mut faults) = search()?;
    faults.push(format!("words: {files} files, {} faults", faults.len()));
    Ok(faults.join("\n"))
}

fn search() -> Result<(usize, Vec<Fault>), String> {
    let root = workspace::root();
    let mut files = Vec::new();
    for (folder, extensions) in [
        ("crates", &["rs", "js", "css", "html", "md"][..]),
        ("fuzz", &["rs", "md"]),
        ("xtask", &["rs"]),
        ("docs", &["md"]),
    ] {
        for extension in extensions {
            files.extend(workspace::files_below(&root.join(folder), extension));
        }
    }
    files.extend(["README.md", "CONTRIBUTING.md"].map(|name| root.join(name)));
    files.retain(|file| !file.components().any(|part| part.as_os_str() == "node_modules"));
    let mut faults = Vec::new();
    let mut definitions: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in &files {
        let text = fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
        let shown = file.strip_prefix(root).unwrap_or(file).display().to_string().replace('\\', "/");
        if EXEMPT.contains(&shown.as_str()) {
            continue;
        }
        faults.extend(module_faults(&shown));
        faults.extend(line_faults(&shown, &text));
        // Test code is small and private.
        if shown.ends_with(".rs")
            && !shown.split('/').any(|part| ["tests", "tests.rs", "benches", "examples"].contains(&part))
        {
            for (number, name) in definitions_in(product_code(&text)) {
                definitions.entry(name.to_owned()).or_default().push(format!("{shown}:{number}"));
            }
        }
    }
    for (name, places) in definitions {
        if places.len() > 1 && !CONVENTIONAL.contains(&name.as_str()) {
            faults.push(format!(
                "{}: the name {name} is defined in {} places: {}",
                places[0],
                places.len(),
                places.join(" ")
            ));
        }
    }
    Ok((files.len(), faults))
}

/// A source text up to its module of tests, if that is not a file of its own.
fn product_code(text: &str) -> &str {
    let mut ends = text.match_indices("\n#[cfg(test)]\nmod ").map(|(start, _)| start);
    let is_inline = |start: &usize| text[start + 1..].lines().nth(1).is_some_and(|line| line.ends_with('{'));
    ends.find(is_inline).map_or(text, |end| &text[..end])
}

/// Banned names of folders and files in a path.
fn module_faults(shown: &str) -> Vec<Fault> {
    let path = Path::new(shown);
    let names = path
        .with_extension("")
        .components()
        .map(|part| part.as_os_str().to_string_lossy().into_owned())
        .collect::<Vec<_>>();
    let banned = MODULES.iter().filter(|(name, _)| names.iter().any(|n| n == name));
    banned
        .map(|(name, instead)| format!("{shown}:1: the file or folder \"{name}\"; use: {instead}"))
        .collect()
}

/// Banned definitions, openings and phrases.
fn line_faults(shown: &str, text: &str) -> Vec<Fault> {
    let mut faults = Vec::new();
    let is_code = !shown.ends_with(".md");
    for (number, name) in definitions_in(text) {
        if let Some((_, instead)) = TYPES.iter().find(|(banned, _)| *banned == name) {
            faults.push(format!("{shown}:{number}: the type {name}; use: {instead}"));
        }
    }
    let mut before = "";
    for (i, line) in text.lines().enumerate() {
        let line = line.trim_start();
        let prose = if is_code { comment(line) } else { Some(line) };
        if let Some(prose) = prose.map(str::to_lowercase) {
            let opening =
                documentation(line).filter(|_| documentation(before).is_none()).map(str::to_lowercase);
            if let Some(opening) = opening
                && let Some(banned) = OPENINGS.iter().find(|banned| opening.starts_with(**banned))
            {
                faults.push(format!(
                    "{shown}:{}: documentation opens with \"{}\"; use a noun phrase or a verb",
                    i + 1,
                    banned.trim_end()
                ));
            } else if let Some((banned, instead)) = PHRASES.iter().find(|(banned, _)| prose.contains(banned))
            {
                faults.push(format!("{shown}:{}: \"{banned}\"; use: {instead}", i + 1));
            }
        }
        before = line;
    }
    faults
}

/// The text of a comment on a line of code.
fn comment(line: &str) -> Option<&str> {
    let lines_of_blocks = line.strip_prefix("* ").or_else(|| line.strip_prefix("/** "));
    lines_of_blocks.or_else(|| line.split_once("//").map(|(_, comment)| comment))
}

/// The text of a documentation comment, if the line is one.
fn documentation(line: &str) -> Option<&str> {
    ["///", "//!", "/**"].iter().find_map(|mark| line.strip_prefix(mark)).map(str::trim_start)
}

/// Names of types that a text defines, with their lines. Associated types of implementations are none.
fn definitions_in(text: &str) -> Vec<(usize, &str)> {
    text.lines().enumerate().filter_map(|(i, line)| Some((i + 1, definition(line)?))).collect()
}

/// The name of the type that a line defines.
fn definition(line: &str) -> Option<&str> {
    let mut rest = line.trim_start();
    let is_nested = rest.len() < line.len();
    for word in ["export ", "default ", "pub ", "pub(crate) ", "pub(super) ", "unsafe "] {
        rest = rest.strip_prefix(word).unwrap_or(rest);
    }
    let (keyword, rest) = rest.split_once(' ')?;
    let defines = match keyword {
        "struct" | "enum" | "trait" | "union" => true,
        "type" | "class" => !is_nested,
        _ => false,
    };
    let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
    (defines && name.starts_with(|c: char| c.is_ascii_uppercase())).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definitions_are_told_from_uses() {
        let text = "pub(crate) struct House<'a> {\n    type Output = f64;\n    struct Inner;\ntype Pair = [f64; 2];\nlet trait_: House;\nexport class Truth {\n";
        assert_eq!(definitions_in(text), [(1, "House"), (3, "Inner"), (4, "Pair"), (6, "Truth")]);
    }

    #[test]
    fn product_code_ends_where_inline_tests_begin() {
        let code = "struct A;\n#[cfg(test)]\nmod tests;\nstruct B;\n";
        assert_eq!(product_code(code), code);
        assert_eq!(product_code("struct A;\n#[cfg(test)]\nmod tests {\n    struct B;\n}\n"), "struct A;");
    }

    #[test]
    fn banned_words_are_found_with_their_lines() {
        let text = "/// What becomes of a ray.\n/// Who wants it.\nstruct Whose;\n// It goes on with the next.\nlet s = \"goes on with\";\n";
        let faults = line_faults("crates/a/src/b.rs", text);
        let lines: Vec<&str> = faults.iter().filter_map(|fault| fault.split(':').nth(1)).collect();
        assert_eq!(lines, ["3", "1", "2", "4"]);
        assert_eq!(line_faults("docs/a.md", "He goes on with it.").len(), 1);
        assert_eq!(module_faults("crates/a/src/kept/of.rs").len(), 1);
        assert_eq!(module_faults("crates/a/src/keeping.rs"), [""; 0]);
    }
}
