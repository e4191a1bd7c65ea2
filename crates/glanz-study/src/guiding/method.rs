//! What is compared: methods as data, and in which company they are shown.

use glanz_scene::description::{GridSettings, GuideBasis, GuideSettings, IntegratorDescription};

/// Samples per pixel of the pictures that tell how good a frozen guide is (document 003 section 3.5).
pub(super) const FROZEN_SAMPLES: u32 = 100;

/// Most samples that a guide learns from before it is frozen: document 003 finds that 500 suffice.
pub(super) const MOST_LEARNT: u32 = 512;

/// The bases of document 003, by degree.
pub(super) const BASES: [GuideBasis; 4] =
    [GuideBasis::Haar, GuideBasis::Spline(1), GuideBasis::Spline(2), GuideBasis::Spline(3)];

/// What people call a basis.
pub(super) fn basis_name(basis: GuideBasis) -> String {
    match basis {
        GuideBasis::Haar => "Haar".to_owned(),
        GuideBasis::Spline(1) => "linear".to_owned(),
        GuideBasis::Spline(2) => "quadratic".to_owned(),
        GuideBasis::Spline(3) => "cubic".to_owned(),
        GuideBasis::Spline(degree) => format!("splines of degree {degree}"),
    }
}

/// Subdivisions and scales that document 003 tries, and those that it finds good.
const ALL_CELLS: [u32; 4] = [2, 4, 8, 16];
const ALL_SCALES: [u32; 4] = [1, 2, 3, 4];
const CELLS: u32 = 8;
const SCALE: u32 = 3;

/// A way to render.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Method {
    /// Name in legends and tables.
    pub(super) name: String,
    /// Name in files.
    pub(super) key: String,
    /// Name in the table of integrators.
    integrator: &'static str,
    /// The plain method of document 003; without it a guide is a tree.
    pub(super) grid: Option<GridSettings>,
}

/// The plain method as document 003 uses it.
fn plain(basis: GuideBasis, cells: u32, scale: u32) -> GridSettings {
    GridSettings { cells, basis, scale, mixture: false, hierarchical: false }
}

impl Method {
    /// The path tracer that all others are measured by.
    pub(super) fn path() -> Self {
        Self { name: "path".into(), key: "path".into(), integrator: "path", grid: None }
    }

    /// Cells and directions that refine themselves.
    pub(super) fn tree() -> Self {
        Self { name: "guided, tree".into(), key: "tree".into(), integrator: "guided", grid: None }
    }

    /// The plain method.
    pub(super) fn of(grid: GridSettings) -> Self {
        let GridSettings { cells, basis, scale, mixture, hierarchical } = grid;
        let mut name = format!("{}, {cells} x {cells}, scale {scale}", basis_name(basis));
        let mut key = format!("{basis}-{cells}-{scale}");
        for (asked, word) in [(mixture, "mixed"), (hierarchical, "hierarchical")] {
            if asked {
                name = format!("{name}, {word}");
                key = format!("{key}-{word}");
            }
        }
        Self { name, key, integrator: "guided", grid: Some(grid) }
    }

    /// `scene`'s integrator changed to this one. `lights`: whether lights are sampled at every hit, which document 003 calls
    /// stratification.
    pub(super) fn described(&self, scene: &IntegratorDescription, lights: bool) -> IntegratorDescription {
        IntegratorDescription {
            name: self.integrator.to_owned(),
            light_sampling: lights,
            branching: None,
            guide: self.grid.map_or(GuideSettings::Tree, GuideSettings::Grid),
            ..scene.clone()
        }
    }
}

/// A method, and how closely it is looked at.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) method: Method,
    /// Samples per pixel at which its curve ends, a power of two.
    pub(super) samples: u32,
    /// Samples after which the guide is frozen and measured, ascending.
    pub(super) frozen: Vec<u32>,
}

/// Methods that are shown in one plot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Group {
    /// Name in files.
    pub(super) key: &'static str,
    pub(super) title: &'static str,
    /// Keys of the methods, that of `path` first.
    pub(super) methods: Vec<String>,
}

/// What is measured with curves of `samples` (a power of two) samples per pixel; `full`: all that document 003 measured.
pub(super) fn entries(samples: u32, full: bool) -> Vec<Entry> {
    let mut list: Vec<Entry> = Vec::new();
    let mut add = |method: Method, samples: u32, frozen: Vec<u32>| {
        if list.iter().all(|entry| entry.method != method) {
            list.push(Entry { method, samples, frozen });
        }
    };
    let learnt = samples.min(MOST_LEARNT);
    add(Method::path(), samples, Vec::new());
    add(Method::tree(), samples, steps(samples, if full { 2 } else { 4 }));
    for ((key, _), methods) in groups() {
        for method in methods {
            // Pictures by frozen guides take longer than all else: many of them only where much is to be seen.
            let frozen = match (full, key) {
                (true, _) => steps(samples, 2),
                (false, "bases") => steps(samples, 4),
                _ => vec![learnt],
            };
            add(method, samples, frozen);
        }
    }
    if full {
        // Figures E.25, E.26, E.42 and E.43: what each can reach, whatever its learning costs.
        for basis in BASES {
            for cells in ALL_CELLS {
                for scale in ALL_SCALES {
                    add(Method::of(plain(basis, cells, scale)), learnt, vec![learnt]);
                }
            }
        }
    }
    list
}

/// The groups of methods that are shown together, beside `path` and the tree.
fn groups() -> Vec<((&'static str, &'static str), Vec<Method>)> {
    let method = |basis, cells, scale| Method::of(plain(basis, cells, scale));
    let varied = |basis| {
        let grid = plain(basis, CELLS, SCALE);
        [grid, GridSettings { hierarchical: true, ..grid }, GridSettings { mixture: true, ..grid }]
            .map(Method::of)
    };
    let haar = GuideBasis::Haar;
    vec![
        (("bases", "bases"), BASES.iter().map(|&basis| method(basis, CELLS, SCALE)).collect()),
        (("cells", "subdivisions"), ALL_CELLS.iter().map(|&cells| method(haar, cells, SCALE)).collect()),
        (("scales", "scales"), ALL_SCALES.iter().map(|&scale| method(haar, CELLS, scale)).collect()),
        (("haar", "Haar, hierarchical or mixed with the BSDF"), varied(haar).into()),
        (("linear", "linear, hierarchical or mixed with the BSDF"), varied(GuideBasis::Spline(1)).into()),
    ]
}

/// The same by their keys, with `path` and the tree.
pub(super) fn shown_groups() -> Vec<Group> {
    let with_others = |((key, title), methods): ((&'static str, &'static str), Vec<Method>)| {
        let others = [Method::path(), Method::tree()];
        let methods = others.into_iter().chain(methods).map(|method| method.key).collect();
        Group { key, title, methods }
    };
    groups().into_iter().map(with_others).collect()
}

/// [`MOST_LEARNT`] or `samples`, and down to 4 divided by `factor`; ascending.
fn steps(samples: u32, factor: u32) -> Vec<u32> {
    let last = samples.min(MOST_LEARNT);
    let fewer = std::iter::successors(Some(last), |n| Some(n / factor));
    let mut list: Vec<u32> = fewer.take_while(|n| *n >= 4 || *n == last).take(10).collect();
    list.reverse();
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guides_are_frozen_where_curves_have_points() {
        assert_eq!(steps(64, 2), [4, 8, 16, 32, 64]);
        assert_eq!(steps(4096, 4), [8, 32, 128, 512]);
        assert_eq!((steps(4, 2), steps(1, 4)), (vec![4], vec![1]));
    }

    #[test]
    fn every_method_has_a_file_of_its_own() {
        for full in [false, true] {
            let all = entries(64, full);
            for (i, entry) in all.iter().enumerate() {
                assert!(all[..i].iter().all(|other| other.method.key != entry.method.key), "{entry:?}");
            }
            let known = |key: &String| all.iter().any(|entry| entry.method.key == *key);
            assert!(shown_groups().iter().all(|group| group.methods.iter().all(known)));
        }
        assert_eq!(
            entries(64, true).iter().filter(|e| e.method.grid.is_some_and(|g| !g.mixture)).count(),
            66
        );
    }
}
