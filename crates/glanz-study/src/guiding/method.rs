//! The compared methods, and the groups in which they are plotted.

use glanz_scene::description::{GridSettings, GuideBasis, GuideSettings, IntegratorDescription, PassLengths};

/// Samples per pixel of the pictures by which a frozen guide is assessed (document 003 section 3.5).
pub(super) const FROZEN_SAMPLES: u32 = 100;

/// Most samples that a guide learns from before it is frozen: document 003 finds that 500 suffice.
pub(super) const MOST_LEARNT: u32 = 512;

/// The bases of document 003, by degree.
pub(super) const BASES: [GuideBasis; 4] =
    [GuideBasis::Haar, GuideBasis::Spline(1), GuideBasis::Spline(2), GuideBasis::Spline(3)];

/// Name of a basis in reports.
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

/// A method of rendering.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RenderMethod {
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
    GridSettings { cells, basis, scale, ..GridSettings::default() }
}

impl RenderMethod {
    /// The path tracer, with which all others are compared.
    pub(super) fn path() -> Self {
        Self { name: "path".into(), key: "path".into(), integrator: "path", grid: None }
    }

    /// Glanz's guide: adaptively refined cells and directions.
    pub(super) fn tree() -> Self {
        Self { name: "guided, tree".into(), key: "tree".into(), integrator: "guided", grid: None }
    }

    /// The plain method.
    pub(super) fn of(grid: GridSettings) -> Self {
        let GridSettings { cells, basis, scale, mixture, hierarchical, passes } = grid;
        let mut name = format!("{}, {cells} x {cells}, scale {scale}", basis_name(basis));
        let mut key = format!("{basis}-{cells}-{scale}");
        for (asked, word) in [(mixture, "mixed"), (hierarchical, "hierarchical")] {
            if asked {
                name = format!("{name}, {word}");
                key = format!("{key}-{word}");
            }
        }
        if let Some(passes) = passes {
            name = format!("{name}, passes {passes}");
            key = format!("{key}-passes-{passes}");
        }
        Self { name, key, integrator: "guided", grid: Some(grid) }
    }

    /// The passes that learn, if they are listed.
    pub(super) fn passes(&self) -> Option<PassLengths> {
        self.grid.and_then(|grid| grid.passes)
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

/// A method with the points at which it is measured.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MethodEntry {
    pub(super) method: RenderMethod,
    /// Samples per pixel at which its curve ends: a power of two, or where the last of its passes does.
    pub(super) samples: u32,
    /// Samples after which the guide is frozen and measured, ascending.
    pub(super) frozen: Vec<u32>,
}

impl MethodEntry {
    /// Numbers of samples after which the picture is measured: the ends of the passes of guided integrators.
    pub(super) fn steps(&self) -> Vec<u32> {
        match self.method.passes() {
            Some(_) => vec![self.samples],
            None => (0..=self.samples.max(1).ilog2()).map(|power| 1 << power).collect(),
        }
    }
}

/// How samples are distributed over three passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PassDistribution {
    pub(super) basis: GuideBasis,
    pub(super) hierarchical: bool,
    /// Whether each pass takes twice as many as the one before.
    pub(super) doubled: bool,
}

impl PassDistribution {
    /// All distributions that document 003 compares.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let bases = [GuideBasis::Haar, GuideBasis::Spline(1)].into_iter();
        let kinds = [(false, false), (false, true), (true, false), (true, true)];
        bases
            .flat_map(move |basis| kinds.map(|(hierarchical, doubled)| Self { basis, hierarchical, doubled }))
    }

    /// Name in legends.
    pub(super) fn name(&self) -> String {
        let hierarchical = if self.hierarchical { ", hierarchical" } else { "" };
        let lengths = if self.doubled { "n-2n-4n" } else { "n-n-n" };
        format!("{lengths}{hierarchical}")
    }

    /// Whether the passes of a grid have this distribution.
    pub(super) fn has(&self, grid: &GridSettings) -> bool {
        let Some(lengths) = grid.passes.map(|passes| passes.iter().collect::<Vec<u32>>()) else {
            return false;
        };
        let doubled = lengths.is_sorted_by(|a, b| 2 * a == *b);
        (grid.basis, grid.hierarchical, doubled) == (self.basis, self.hierarchical, self.doubled)
    }

    /// Three passes, `n` samples per pixel in the first, after the first sample of the picture, which measures the brightness.
    fn entry(&self, n: u32) -> Option<MethodEntry> {
        let passes = PassLengths::new(&if self.doubled { [n, 2 * n, 4 * n] } else { [n; 3] })?;
        let samples = 1 + passes.iter().sum::<u32>();
        let grid = plain(self.basis, CELLS, SCALE);
        let grid = GridSettings { hierarchical: self.hierarchical, passes: Some(passes), ..grid };
        Some(MethodEntry { method: RenderMethod::of(grid), samples, frozen: vec![samples] })
    }
}

/// Methods of one plot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MethodGroup {
    /// Name in files.
    pub(super) key: &'static str,
    pub(super) title: &'static str,
    /// Keys of the methods, that of `path` first.
    pub(super) methods: Vec<String>,
}

/// The measured methods, with curves of `samples` (a power of two) per pixel; `full`: all methods that document 003 measures.
pub(super) fn entries(samples: u32, full: bool) -> Vec<MethodEntry> {
    let mut list: Vec<MethodEntry> = Vec::new();
    let mut add = |method: RenderMethod, samples: u32, frozen: Vec<u32>| {
        if list.iter().all(|entry| entry.method != method) {
            list.push(MethodEntry { method, samples, frozen });
        }
    };
    let learnt = samples.min(MOST_LEARNT);
    add(RenderMethod::path(), samples, Vec::new());
    add(RenderMethod::tree(), samples, steps(samples, if full { 2 } else { 4 }));
    for ((key, _), methods) in groups() {
        for method in methods {
            // Pictures by frozen guides dominate the time: many of them only for the bases.
            let frozen = match (full, key) {
                (true, _) => steps(samples, 2),
                (false, "bases") => steps(samples, 4),
                _ => vec![learnt],
            };
            add(method, samples, frozen);
        }
    }
    if full {
        // Figures E.25, E.26, E.42 and E.43: the smallest error of each, regardless of its learning time.
        for basis in BASES {
            for cells in ALL_CELLS {
                for scale in ALL_SCALES {
                    add(RenderMethod::of(plain(basis, cells, scale)), learnt, vec![learnt]);
                }
            }
        }
    }
    // Figures E.37 and E.39.
    for distribution in PassDistribution::all() {
        let firsts: &[u32] = if full { &[1, 2, 3, 4, 6, 8, 12, 16] } else { &[1, 4] };
        list.extend(firsts.iter().filter_map(|&n| distribution.entry(n)));
    }
    list
}

/// The groups of methods that are plotted together, without `path` and the tree.
fn groups() -> Vec<((&'static str, &'static str), Vec<RenderMethod>)> {
    let method = |basis, cells, scale| RenderMethod::of(plain(basis, cells, scale));
    let varied = |basis| {
        let grid = plain(basis, CELLS, SCALE);
        [grid, GridSettings { hierarchical: true, ..grid }, GridSettings { mixture: true, ..grid }]
            .map(RenderMethod::of)
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
pub(super) fn shown_groups() -> Vec<MethodGroup> {
    let with_others = |((key, title), methods): ((&'static str, &'static str), Vec<RenderMethod>)| {
        let others = [RenderMethod::path(), RenderMethod::tree()];
        let methods = others.into_iter().chain(methods).map(|method| method.key).collect();
        MethodGroup { key, title, methods }
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
    fn each_distribution_knows_its_own() {
        for full in [false, true] {
            let grids: Vec<GridSettings> = entries(64, full).iter().filter_map(|e| e.method.grid).collect();
            let listed = grids.iter().filter(|grid| grid.passes.is_some());
            assert_eq!(listed.clone().count(), 8 * if full { 8 } else { 2 });
            for grid in listed {
                assert_eq!(PassDistribution::all().filter(|d| d.has(grid)).count(), 1, "{grid}");
            }
        }
        let doubled = PassDistribution { basis: GuideBasis::Haar, hierarchical: true, doubled: true };
        let entry = doubled.entry(3).unwrap();
        assert_eq!(entry.method.key, "haar-8-3-hierarchical-passes-3-6-12");
        assert_eq!((entry.samples, entry.steps()), (22, vec![22]));
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
        let plain = |e: &&MethodEntry| e.method.grid.is_some_and(|g| !g.mixture && g.passes.is_none());
        assert_eq!(entries(64, true).iter().filter(plain).count(), 66);
    }
}
