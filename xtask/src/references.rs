//! Whether every paper that the sources cite is in the list of references.

use std::collections::{BTreeMap, BTreeSet};

use crate::workspace;

/// Compares the `@key` citations of all sources with `docs/references.bib`.
///
/// # Errors
/// One line per key that is cited but not listed, with the first place that cites it.
pub(crate) fn check() -> Result<String, String> {
    let list = workspace::root().join("docs/references.bib");
    let listed = match std::fs::read_to_string(&list) {
        Ok(text) => entries(&text),
        Err(error) => return Err(format!("docs/references.bib: {error}")),
    };
    let mut cited = BTreeMap::new();
    for file in workspace::files_below(&workspace::root().join("crates"), "rs") {
        let text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        let shown = file.strip_prefix(workspace::root()).unwrap_or(&file);
        for (number, line) in text.lines().enumerate() {
            for key in citations(line) {
                cited.entry(key.to_owned()).or_insert_with(|| format!("{}:{}", shown.display(), number + 1));
            }
        }
    }
    let missing: Vec<String> = cited
        .iter()
        .filter(|(key, _)| !listed.contains(*key))
        .map(|(key, place)| format!("{place}: @{key} is not in docs/references.bib"))
        .collect();
    if missing.is_empty() {
        Ok(format!("{} of {} keys cited, every one listed", cited.len(), listed.len()))
    } else {
        Err(missing.join("\n"))
    }
}

/// The keys of a BibTeX file.
fn entries(text: &str) -> BTreeSet<String> {
    text.lines()
        .filter_map(|line| line.strip_prefix('@')?.split_once('{')?.1.strip_suffix(','))
        .map(str::to_owned)
        .collect()
}

/// The citations in the comment of a line: `@` after a blank or a bracket, then letters, digits, underscores and hyphens, a
/// letter first.
fn citations(line: &str) -> Vec<&str> {
    let Some((_, comment)) = line.split_once("//") else { return Vec::new() };
    comment
        .match_indices('@')
        .filter(|&(at, _)| comment[..at].ends_with([' ', '(', '[', '/', '!']))
        .map(|(at, _)| {
            let rest = &comment[at + 1..];
            &rest[..rest
                .find(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '-')
                .unwrap_or(rest.len())]
        })
        .filter(|key| key.starts_with(|c: char| c.is_ascii_lowercase()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn citations_are_told_from_other_signs() {
        assert_eq!(citations("/// @duff2017, and (@jakob2014b) section 3."), ["duff2017", "jakob2014b"]);
        assert_eq!(
            citations("    let a = b; // as @khr_lights and @iso10303-42 do"),
            ["khr_lights", "iso10303-42"]
        );
        assert_eq!(
            citations("    name @ Some(_) => 1, // someone@example.org, @2017, 3 @ 4"),
            Vec::<&str>::new()
        );
    }

    #[test]
    fn bibliography_keys_stand_after_the_brace() {
        let keys = entries("@article{duff2017,\n  title = {x},\n}\n@book{higham2002,\n}\n");
        assert_eq!(keys.into_iter().collect::<Vec<_>>(), ["duff2017", "higham2002"]);
    }
}
