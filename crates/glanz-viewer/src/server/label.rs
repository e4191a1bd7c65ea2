//! Labels that tell two designs apart.

use std::path::{Component, Path};

/// The labels of two designs: names of their scene files, with those of the folders of their maps if they are of one file.
pub(crate) fn design_labels(scenes: [&Path; 2], folders: [Option<&Path>; 2]) -> [String; 2] {
    let [first, second] = distinct_names(scenes);
    match folders {
        [Some(a), Some(b)] if first == second => {
            distinct_names([a, b]).map(|folder| format!("{first}, {folder}"))
        }
        _ => [first, second],
    }
}

/// Name of a file or folder; empty if its path has none.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// The names of two files or folders, after those of the folders that tell them apart: pages on other machines need not know where they are.
fn distinct_names(paths: [&Path; 2]) -> [String; 2] {
    let names = paths.map(file_name);
    let [first, second] = &names;
    let [a, b] = paths;
    if !first.is_empty() && !second.is_empty() && (first != second || a == b) {
        return names;
    }
    let whole = paths.map(|path| path.canonicalize().unwrap_or_else(|_| path.to_owned()));
    let [first, second] = whole.each_ref().map(|path| names_from_the_end(path));
    let equal = first.iter().zip(&second).take_while(|(a, b)| a == b).count();
    let count = if first == second { 1 } else { equal + 1 };
    [first, second].map(|names| {
        let mut names: Vec<String> = names.into_iter().take(count).collect();
        names.reverse();
        names.join("/")
    })
}

/// The names in a path, the last one first.
fn names_from_the_end(path: &Path) -> Vec<String> {
    let names = path.components().rev().filter(|part| matches!(part, Component::Normal(_)));
    names.map(|name| name.as_os_str().to_string_lossy().into_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_as_short_as_tells_designs_apart() {
        let labels = |scenes: [&str; 2], folders: [Option<&str>; 2]| {
            design_labels(scenes.map(Path::new), folders.map(|folder| folder.map(Path::new)))
        };
        // None of these exists.
        let lux = [Some("/none/lux"), Some("/none/after")];
        assert_eq!(labels(["/none/a.pbrt", "/none/b.pbrt"], lux), ["a.pbrt", "b.pbrt"]);
        assert_eq!(labels(["/none/old/a.pbrt", "/none/new/a.pbrt"], lux), ["old/a.pbrt", "new/a.pbrt"]);
        let same = ["/none/a.pbrt"; 2];
        assert_eq!(labels(same, lux), ["a.pbrt, lux", "a.pbrt, after"]);
        assert_eq!(
            labels(same, [Some("/none/x/1/lux"), Some("/none/y/1/lux")]),
            ["a.pbrt, x/1/lux", "a.pbrt, y/1/lux"]
        );
        assert_eq!(labels(same, [Some("/lux"), Some("/none/lux")]), ["a.pbrt, lux", "a.pbrt, none/lux"]);
        assert_eq!(labels(same, [Some("/none/lux"), None]), ["a.pbrt"; 2]);
    }

    #[test]
    fn folders_without_a_name_have_that_of_their_place() {
        let root = tempfile::TempDir::new().unwrap();
        let [first, second] = ["first", "second"].map(|name| root.path().join(name));
        for folder in [&first, &second] {
            std::fs::create_dir_all(folder.join("inner")).unwrap();
        }
        let up = second.join("inner/..");
        let scene = Path::new("/none/a.pbrt");
        let labels = design_labels([scene; 2], [Some(&first), Some(&up)]);
        assert_eq!(labels, ["a.pbrt, first", "a.pbrt, second"]);
    }
}
