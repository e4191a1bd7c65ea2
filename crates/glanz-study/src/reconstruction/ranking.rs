//! Ranking of the interpolations, by the figures of document 003 and by new measurements.

use glanz_radiosity::reconstruct::{Border, Interpolation};

use super::measure::{DivisionResult, SceneResult};
use super::method::{FloorDivision, SCATTERED, methods, name};
use super::published::{self, NormErrors};
use glanz_report::number::significant;
use glanz_report::{Table, TableCell};

/// Names of the norms.
pub(super) const NORMS: [&str; 3] = ["L1", "L2", "Linf"];

/// Source of the figures of a ranking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FigureSource {
    Document,
    Measured,
}

const BOTH: [FigureSource; 2] = [FigureSource::Document, FigureSource::Measured];

/// Errors of the scattered methods on one division of one scene, in the order of [`SCATTERED`].
#[derive(Clone, Copy, Debug)]
struct MethodTriple([NormErrors; 3]);

impl MethodTriple {
    /// The errors on a division, with or without border samples; `None` if one is missing.
    fn of(scene: usize, of: &DivisionResult, border: Border, source: FigureSource) -> Option<Self> {
        let printed = published::errors(scene, of.division);
        let one = |interpolation: Interpolation| match source {
            FigureSource::Measured => of.of(interpolation, border).map(|made| made.errors),
            FigureSource::Document => {
                let is_it = |m: &super::method::InterpolationMethod| {
                    m.interpolation == interpolation && m.border == border
                };
                printed.get(methods(of.division).iter().position(is_it)?).copied()
            }
        };
        let [a, b, c] = SCATTERED.map(one);
        Some(Self([a?, b?, c?]))
    }

    /// Positions in [`SCATTERED`], the best first; in one norm.
    fn order(&self, norm: usize) -> [usize; 3] {
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| self.0[a][norm].total_cmp(&self.0[b][norm]));
        order
    }

    /// Error of the best method.
    fn least(&self, norm: usize) -> f64 {
        self.0.iter().map(|errors| errors[norm]).fold(f64::INFINITY, f64::min)
    }
}

/// Number of pairs of methods, of three, in the same order in both.
fn same_pairs(a: &MethodTriple, b: &MethodTriple, norm: usize) -> u64 {
    let pairs = [(0, 1), (0, 2), (1, 2)];
    let before = |three: &MethodTriple, (i, j): (usize, usize)| three.0[i][norm] < three.0[j][norm];
    pairs.iter().filter(|&&pair| before(a, pair) == before(b, pair)).count() as u64
}

/// Each scene and division, with the index of the scene.
fn all(outcomes: &[SceneResult]) -> impl Iterator<Item = (usize, &SceneResult, &DivisionResult)> {
    let scenes = outcomes.iter().enumerate();
    scenes.flat_map(|(i, outcome)| outcome.divisions.iter().map(move |of| (i, outcome, of)))
}

/// Table of the best method by both sources, for each scene, division and norm.
pub(super) fn summary(outcomes: &[SceneResult]) -> Table {
    let mut table = Table::new(
        "summary",
        "The best of Shepard's method, multiquadrics and natural neighbours, with border samples, by document 003's tables and \
         as measured; the last column counts pairs in the same order, over three norms.",
        &[
            ("scene", "scene"),
            ("division", "division"),
            ("elements", "elements"),
            ("published_elements", "elements, 003"),
            ("trials", "values computed"),
            ("published_l1", "best L1, 003"),
            ("l1", "best L1"),
            ("published_l2", "best L2, 003"),
            ("l2", "best L2"),
            ("published_linf", "best Linf, 003"),
            ("linf", "best Linf"),
            ("pairs_of_9", "pairs, of 9"),
        ],
    );
    for (i, outcome, of) in all(outcomes) {
        let [Some(theirs), Some(ours)] = BOTH.map(|source| MethodTriple::of(i, of, Border::Sampled, source))
        else {
            continue;
        };
        let mut row: Vec<TableCell> = vec![
            outcome.setup.number.into(),
            of.division.name().into(),
            (of.divided.cells.as_slice().len() as u64).into(),
            published::elements(i, of.division).into(),
            (of.divided.trials as u64).into(),
        ];
        for norm in 0..NORMS.len() {
            row.extend([&theirs, &ours].map(|three| TableCell::from(name(SCATTERED[three.order(norm)[0]]))));
        }
        row.push((0..NORMS.len()).map(|norm| same_pairs(&theirs, &ours, norm)).sum::<u64>().into());
        table.push(row);
    }
    table
}

/// Table of the errors over all scenes, relative to the best method.
pub(super) fn overall(outcomes: &[SceneResult]) -> Table {
    let mut table = Table::new(
        "overall",
        "Error relative to the best of the three: geometric mean over the six scenes, and in the worst scene; with border \
         samples.",
        &[
            ("division", "division"),
            ("norm", "norm"),
            ("whose", "figures of"),
            ("shepard", "Shepard"),
            ("multiquadrics", "multiquadrics"),
            ("natural", "natural neighbours"),
            ("shepard_worst", "Shepard, worst"),
            ("multiquadrics_worst", "multiquadrics, worst"),
            ("natural_worst", "natural neighbours, worst"),
        ],
    );
    for division in FloorDivision::ALL {
        for (norm, norm_name) in NORMS.iter().enumerate() {
            for source in BOTH {
                let [mean, worst] = ratios(outcomes, division, norm, source);
                let words = if source == FigureSource::Document { "document 003" } else { "this study" };
                let mut row: Vec<TableCell> = vec![division.name().into(), (*norm_name).into(), words.into()];
                row.extend(mean.into_iter().chain(worst).map(TableCell::from));
                table.push(row);
            }
        }
    }
    table
}

/// Geometric means and largest values of the errors relative to the best method.
fn ratios(
    outcomes: &[SceneResult],
    division: FloorDivision,
    norm: usize,
    source: FigureSource,
) -> [[f64; 3]; 2] {
    let (mut logarithms, mut worst, mut count) = ([0.0; 3], [0.0_f64; 3], 0.0);
    for (i, _, of) in all(outcomes).filter(|(.., of)| of.division == division) {
        let Some(three) = MethodTriple::of(i, of, Border::Sampled, source) else { continue };
        count += 1.0;
        for ((sum, worst), errors) in logarithms.iter_mut().zip(&mut worst).zip(&three.0) {
            let ratio = errors[norm] / three.least(norm);
            *sum += ratio.ln();
            *worst = worst.max(ratio);
        }
    }
    [logarithms.map(|sum: f64| (sum / count).exp()), worst]
}

/// Number of cases in which `method` (in [`SCATTERED`]) has the rank `place` (0: best), and number of all cases.
fn count_at(
    outcomes: &[SceneResult],
    chosen: &dyn Fn(&SceneResult, &DivisionResult) -> bool,
    norms: &[usize],
    method: usize,
    place: usize,
    source: FigureSource,
) -> [usize; 2] {
    let cases = all(outcomes).filter(|(_, outcome, of)| chosen(outcome, of));
    let threes = cases.filter_map(|(i, _, of)| MethodTriple::of(i, of, Border::Sampled, source));
    let places = threes.flat_map(|three| norms.iter().map(move |&norm| three.order(norm)[place] == method));
    places.fold([0, 0], |[hits, of], hit| [hits + usize::from(hit), of + 1])
}

/// Findings as sentences with their figures.
pub(super) fn findings(outcomes: &[SceneResult]) -> Vec<String> {
    let mut found = vec![agreement(outcomes)];
    found.push(soft(outcomes));
    for division in FloorDivision::ALL {
        found.push(hard(outcomes, division));
    }
    found.extend(all_kinds(outcomes));
    found.push(border_samples(outcomes));
    found.push(shepard(outcomes));
    found.push(overshoot(outcomes));
    found
}

fn agreement(outcomes: &[SceneResult]) -> String {
    let (mut same, mut pairs, mut best, mut cases) = (0, 0, 0, 0);
    for (i, _, of) in all(outcomes) {
        if let [Some(theirs), Some(ours)] =
            BOTH.map(|source| MethodTriple::of(i, of, Border::Sampled, source))
        {
            for norm in 0..2 {
                same += same_pairs(&theirs, &ours, norm);
                pairs += 3;
                best += usize::from(theirs.order(norm)[0] == ours.order(norm)[0]);
                cases += 1;
            }
        }
    }
    format!(
        "Of {pairs} pairs of the three methods (six scenes, two divisions, L1 and L2) {same} are in the order of document 003's \
         tables; the best is the same in {best} of {cases} cases."
    )
}

/// Finding on multiquadrics in soft shadows, with the exceptions.
fn soft(outcomes: &[SceneResult]) -> String {
    let (mut counts, mut cases, mut exceptions) = ([0, 0], 0, Vec::new());
    for (i, outcome, of) in all(outcomes).filter(|(_, outcome, _)| !outcome.setup.hard) {
        for (border, words) in [(Border::Sampled, "with"), (Border::Open, "without")] {
            for (norm, norm_name) in NORMS.iter().enumerate().take(2) {
                cases += 1;
                for (count, source) in counts.iter_mut().zip(BOTH) {
                    let Some(three) = MethodTriple::of(i, of, border, source) else { continue };
                    let best = three.order(norm)[0];
                    *count += usize::from(best == 1);
                    if best != 1 && source == FigureSource::Measured {
                        exceptions.push(format!(
                            "scene {}, {}, {words} border samples, {norm_name} ({} {}, multiquadrics {})",
                            outcome.setup.number,
                            of.division.name(),
                            name(SCATTERED[best]),
                            significant(three.0[best][norm]),
                            significant(three.0[1][norm])
                        ));
                    }
                }
            }
        }
    }
    let exceptions = if exceptions.is_empty() {
        String::new()
    } else {
        format!(" Exceptions here: {}.", exceptions.join("; "))
    };
    format!(
        "Soft shadows: \"multiquadrics have the least differences\" (section 4.7.3). By L1 and L2, with and without border samples, they \
         are the best of the three in {} of {cases} cases of scenes 1 and 2 in document 003's tables, and in {} of {cases} here: the finding is \
         {}confirmed.{exceptions}",
        counts[0],
        counts[1],
        if 2 * counts[1] > cases { "" } else { "not " }
    )
}

fn hard(outcomes: &[SceneResult], division: FloorDivision) -> String {
    let hard = |o: &SceneResult, of: &DivisionResult| o.setup.hard && of.division == division;
    let [theirs, ours] = BOTH.map(|source| count_at(outcomes, &hard, &[0, 1], 2, 0, source));
    let away = |interpolation: Interpolation| {
        let of = |o: &SceneResult| {
            o.divisions.iter().find(|of| of.division == division)?.of(interpolation, Border::Sampled)?.away
        };
        let values: Vec<f64> = outcomes.iter().filter_map(of).collect();
        values.iter().sum::<f64>() / values.len().max(1) as f64
    };
    let [_, quadrics, natural] = SCATTERED.map(away);
    format!(
        "Hard shadows, {}: \"natural neighbours have the least deviations\". By L1 and L2 they are the best of the three in {} of {} cases \
         in document 003's tables, and in {} of {} here. The visible error is ringing beside the border: further than an \
         element of the grid from borders the mean root mean square error of multiquadrics is {}, that of natural neighbours \
         {}: {}.",
        division.name(),
        theirs[0],
        theirs[1],
        ours[0],
        ours[1],
        significant(quadrics),
        significant(natural),
        if natural < quadrics {
            "there natural neighbours are better"
        } else {
            "there multiquadrics are better"
        }
    )
}

/// Findings on natural neighbours over all kinds of shadow.
fn all_kinds(outcomes: &[SceneResult]) -> Vec<String> {
    FloorDivision::ALL
        .map(|division| {
            let of = |source| {
                let best = [0, 1].map(|norm| {
                    let [mean, _] = ratios(outcomes, division, norm, source);
                    let leading = (0..3).min_by(|&a, &b| mean[a].total_cmp(&mean[b])).unwrap_or(0);
                    format!(
                        "{} in {} (multiquadrics {}, natural neighbours {})",
                        name(SCATTERED[leading]),
                        NORMS[norm],
                        significant(mean[1]),
                        significant(mean[2])
                    )
                });
                best.join(" and ")
            };
            format!(
                "All kinds of shadow, {}: \"natural neighbours are the best method for all kinds of scenes\" (section 4.8). By \
                 the geometric mean of the errors relative to the best in each scene, the best by document 003's own tables \
                 are {}; here {}.",
                division.name(),
                of(FigureSource::Document),
                of(FigureSource::Measured)
            )
        })
        .into()
}

fn border_samples(outcomes: &[SceneResult]) -> String {
    let of = |source| {
        let ratio = |(i, _, of): (usize, &SceneResult, &DivisionResult)| {
            let [open, sampled] =
                [Border::Open, Border::Sampled].map(|border| MethodTriple::of(i, of, border, source));
            Some(sampled?.0[2][1] / open?.0[2][1])
        };
        let ratios: Vec<f64> = all(outcomes).filter_map(ratio).collect();
        [ratios.iter().copied().fold(f64::INFINITY, f64::min), ratios.iter().copied().fold(0.0, f64::max)]
    };
    let [theirs, ours] = BOTH.map(of);
    format!(
        "Border samples multiply the L2 error of natural neighbours by {} to {} in document 003's tables, and by {} to {} here. \
         Here Voronoi cells end at the sides of the floor, so that every value lies between those of elements; the \
         document's program fails beyond the hull of the middles of elements, which border samples correct.",
        significant(theirs[0]),
        significant(theirs[1]),
        significant(ours[0]),
        significant(ours[1])
    )
}

fn shepard(outcomes: &[SceneResult]) -> String {
    let [theirs, ours] = BOTH.map(|source| count_at(outcomes, &|_, _| true, &[1], 0, 2, source));
    format!(
        "\"Shepard's method has the largest L2 error in almost all scenes\" (section 4.7.4): it has the largest of the three in {} of {} cases \
         of document 003's tables, and in {} of {} here.",
        theirs[0], theirs[1], ours[0], ours[1]
    )
}

fn overshoot(outcomes: &[SceneResult]) -> String {
    let most = |interpolation: Interpolation| {
        let made = all(outcomes).flat_map(|(.., of)| &of.made);
        let of = made.filter(|made| made.method.interpolation == interpolation);
        of.flat_map(|made| made.overshoot).fold(0.0, f64::max)
    };
    format!(
        "Overshoot beyond the range of all elements, relative to the largest light: bicubic splines up to {}, multiquadrics \
         {}, natural neighbours {}, Shepard's method {}, bilinear interpolation {}.",
        significant(most(Interpolation::Spline)),
        significant(most(SCATTERED[1])),
        shown_zero(most(SCATTERED[2])),
        shown_zero(most(SCATTERED[0])),
        shown_zero(most(Interpolation::Bilinear))
    )
}

/// Rounding errors are no overshoot.
fn shown_zero(value: f64) -> String {
    if value < 1e-12 { "0".to_owned() } else { significant(value) }
}
