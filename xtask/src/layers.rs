//! Permitted dependencies between crates.

use crate::workspace;

/// A crate of the product with its layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct LayeredCrate {
    layer: u8,
    name: &'static str,
    /// As in the last column of the table in `docs/ARCHITECTURE.md`: `-`, short names, `LOW-HIGH` layers, or `all`.
    may_use: &'static str,
}

/// The layers. `docs/ARCHITECTURE.md` has the same table for readers; [`check`] compares the two.
const LAYERS: &[LayeredCrate] = &[
    LayeredCrate { layer: 0, name: "glanz-math", may_use: "-" },
    LayeredCrate { layer: 0, name: "glanz-job", may_use: "-" },
    LayeredCrate { layer: 1, name: "glanz-geometry", may_use: "math" },
    LayeredCrate { layer: 1, name: "glanz-denoise", may_use: "job" },
    LayeredCrate { layer: 1, name: "glanz-light", may_use: "math" },
    LayeredCrate { layer: 1, name: "glanz-sampling", may_use: "math" },
    LayeredCrate { layer: 2, name: "glanz-brep", may_use: "math, geometry" },
    LayeredCrate { layer: 2, name: "glanz-report", may_use: "job, light" },
    LayeredCrate { layer: 2, name: "glanz-shading", may_use: "math, job, light, sampling" },
    LayeredCrate { layer: 3, name: "glanz-scene", may_use: "0-2" },
    LayeredCrate { layer: 4, name: "glanz-formats", may_use: "0-3" },
    LayeredCrate { layer: 4, name: "glanz-transport", may_use: "0-3" },
    LayeredCrate { layer: 4, name: "glanz-radiosity", may_use: "0-3" },
    LayeredCrate { layer: 5, name: "glanz-illumination", may_use: "0-4" },
    LayeredCrate { layer: 5, name: "glanz-terminal", may_use: "report, job, scene" },
    LayeredCrate { layer: 6, name: "glanz-viewer", may_use: "0-5" },
    LayeredCrate { layer: 7, name: "glanz", may_use: "0-6" },
    LayeredCrate { layer: 8, name: "glanz-cli", may_use: "all" },
    LayeredCrate { layer: 8, name: "glanz-fuzz", may_use: "all" },
    LayeredCrate { layer: 8, name: "glanz-python", may_use: "all" },
    LayeredCrate { layer: 8, name: "glanz-study", may_use: "all" },
];

/// Members of the workspace that are not part of the product: they use none of its crates, and none uses them.
const OUTSIDE: &[&str] = &["xtask"];

impl LayeredCrate {
    fn named(name: &str) -> Option<&'static Self> {
        LAYERS.iter().find(|layered| layered.name == name)
    }

    fn may_use(&self, other: &Self) -> bool {
        let listed = match self.may_use {
            "-" => false,
            "all" => true,
            list => list.split(", ").any(|entry| match entry.split_once('-') {
                Some((low, high)) => match (low.parse::<u8>(), high.parse::<u8>()) {
                    (Ok(low), Ok(high)) => (low..=high).contains(&other.layer),
                    _ => false,
                },
                None => other.name.strip_prefix("glanz-") == Some(entry),
            }),
        };
        listed && other.layer < self.layer
    }
}

/// Compares the dependencies of all kinds with [`LAYERS`], and [`LAYERS`] with the table of `docs/ARCHITECTURE.md`.
///
/// # Errors
/// One line per breach.
pub(crate) fn check() -> Result<String, String> {
    let options = [
        "--depth=1",
        "--no-dedupe",
        "--prefix=depth",
        "--edges=normal,build,dev",
        "--target=all",
        "--all-features",
    ];
    let tree = workspace::cargo(["tree", "--workspace", "--format={p}"])
        .args(options)
        .output()
        .map_err(|error| format!("cargo tree: {error}"))?;
    if !tree.status.success() {
        return Err(format!("cargo tree: {}", String::from_utf8_lossy(&tree.stderr).trim_end()));
    }
    let edges = edges(&String::from_utf8_lossy(&tree.stdout));
    let mut breaches = breaches(&edges);
    let path = workspace::root().join("docs/ARCHITECTURE.md");
    match std::fs::read_to_string(&path) {
        Ok(text) => breaches.extend(table_differences(&text)),
        Err(error) => breaches.push(format!("docs/ARCHITECTURE.md: {error}")),
    }
    if breaches.is_empty() {
        let uses =
            edges.iter().flat_map(|(_, used)| used).filter(|u| LayeredCrate::named(u).is_some()).count();
        Ok(format!("{} crates, {uses} uses, every one of a lower layer", LAYERS.len()))
    } else {
        Err(breaches.join("\n"))
    }
}

/// The crates of a workspace with those they use, from lines `0glanz v0.1.0 (...)`, after each of which come those with a 1.
fn edges(tree: &str) -> Vec<(String, Vec<String>)> {
    let mut edges: Vec<(String, Vec<String>)> = Vec::new();
    let name = |line: &str| line.split(' ').next().unwrap_or_default().to_owned();
    for line in tree.lines() {
        if let Some(member) = line.strip_prefix('0') {
            edges.push((name(member), Vec::new()));
        } else if let Some(used) = line.strip_prefix('1')
            && let Some((_, uses)) = edges.last_mut()
        {
            uses.push(name(used));
        }
    }
    edges
}

/// The forbidden uses in a workspace of crates and the crates they use.
fn breaches(edges: &[(String, Vec<String>)]) -> Vec<String> {
    let mut found = Vec::new();
    for (name, used) in edges {
        let inside: Vec<&str> =
            used.iter().map(String::as_str).filter(|u| edges.iter().any(|(n, _)| n == u)).collect();
        let Some(layered) = LayeredCrate::named(name) else {
            if !OUTSIDE.contains(&name.as_str()) {
                found.push(format!("{name} has no layer; give it one in xtask/src/layers.rs"));
            }
            found.extend(inside.iter().map(|u| format!("{name} uses {u}, but is not part of the product")));
            continue;
        };
        for used in inside {
            match LayeredCrate::named(used) {
                Some(other) if layered.may_use(other) => {}
                Some(other) => found.push(format!(
                    "{name} (layer {}) uses {used} (layer {}), but may use: {}",
                    layered.layer, other.layer, layered.may_use
                )),
                None => found.push(format!("{name} uses {used}, which has no layer")),
            }
        }
    }
    let missing = LAYERS.iter().filter(|layered| !edges.iter().any(|(name, _)| name == layered.name));
    found.extend(
        missing
            .map(|layered| format!("{} is in the table of layers, but not in the workspace", layered.name)),
    );
    found
}

/// Differences of the table of layers in a text (rows of layer, crate, purpose, may use) from [`LAYERS`].
fn table_differences(text: &str) -> Vec<String> {
    let rows: Vec<(u8, String, String)> = text.lines().filter_map(table_row).collect();
    let mut found = Vec::new();
    for layered in LAYERS {
        match rows.iter().find(|(_, name, _)| name == layered.name) {
            None => found.push(format!("docs/ARCHITECTURE.md: the table of layers lacks {}", layered.name)),
            Some((layer, _, may_use)) if (*layer, may_use.as_str()) != (layered.layer, layered.may_use) => {
                found.push(format!(
                    "docs/ARCHITECTURE.md: {} on layer {layer} may use \"{may_use}\"; xtask/src/layers.rs says layer {} and \"{}\"",
                    layered.name, layered.layer, layered.may_use
                ));
            }
            Some(_) => {}
        }
    }
    let unknown = rows.iter().filter(|(_, name, _)| LayeredCrate::named(name).is_none());
    found.extend(unknown.map(|(_, name, _)| {
        format!("docs/ARCHITECTURE.md: {name} is in the table of layers, but not in xtask/src/layers.rs")
    }));
    found
}

/// A row ``| 1 | `glanz-light` | purpose | math |`` as layer, crate and the crates it may use.
fn table_row(line: &str) -> Option<(u8, String, String)> {
    let cells: Vec<&str> = line.trim().trim_matches('|').split('|').map(str::trim).collect();
    match *cells.as_slice() {
        [layer, name, _, may_use] => {
            let name = name.strip_prefix('`')?.strip_suffix('`')?;
            Some((layer.parse().ok()?, name.to_owned(), may_use.to_owned()))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All crates without any use, to which a test adds one.
    fn unused_crates() -> Vec<(String, Vec<String>)> {
        LAYERS.iter().map(|layered| (layered.name.to_owned(), Vec::new())).collect()
    }

    fn with_use(name: &str, used: &str) -> Vec<(String, Vec<String>)> {
        let mut crates = unused_crates();
        crates.retain(|(n, _)| n != name);
        crates.push((name.to_owned(), vec![used.to_owned()]));
        crates
    }

    #[test]
    fn uses_are_read_from_the_tree_that_cargo_prints() {
        let tree = "0glanz v0.2.0 (/a/glanz)\n1glam v0.34.0\n1glanz-math v0.2.0 (/a/math)\n\n0xtask v0.2.0 (/a/xtask)\n";
        let glanz = ("glanz".to_owned(), vec!["glam".to_owned(), "glanz-math".to_owned()]);
        assert_eq!(edges(tree), [glanz, ("xtask".to_owned(), Vec::new())]);
    }

    #[test]
    fn uses_of_lower_layers_pass() {
        assert_eq!(breaches(&unused_crates()), Vec::<String>::new());
        for (name, used) in [
            ("glanz-shading", "glanz-light"),
            ("glanz-scene", "glanz-geometry"),
            ("glanz", "glanz-formats"),
            ("glanz-math", "serde"),
        ] {
            assert_eq!(breaches(&with_use(name, used)), Vec::<String>::new(), "{name} uses {used}");
        }
    }

    #[test]
    fn uses_upward_sideways_and_of_unlisted_crates_are_breaches() {
        for (name, used) in [
            ("glanz-math", "glanz-light"),
            ("glanz-geometry", "glanz-light"),
            ("glanz-shading", "glanz-geometry"),
            ("glanz-formats", "glanz-transport"),
            ("glanz-scene", "glanz"),
            ("xtask", "glanz"),
        ] {
            assert_eq!(breaches(&with_use(name, used)).len(), 1, "{name} uses {used}");
        }
        assert_eq!(breaches(&with_use("glanz-new", "serde")).len(), 1);
    }

    #[test]
    fn different_rows_are_reported() {
        let row = |layered: &LayeredCrate| {
            format!("| {} | `{}` | purpose | {} |\n", layered.layer, layered.name, layered.may_use)
        };
        let table: String = LAYERS.iter().map(row).collect();
        assert_eq!(table_differences(&table), Vec::<String>::new());
        assert_eq!(table_differences(&table.replace("| 3 | `glanz-scene`", "| 2 | `glanz-scene`")).len(), 1);
        assert_eq!(table_differences(&table.replacen("| all |", "| 0-4 |", 1)).len(), 1);
        assert_eq!(table_differences(&(table + "| 4 | `glanz-unlisted` | purpose | 0-3 |")).len(), 1);
        assert_eq!(table_differences("").len(), LAYERS.len());
    }
}
