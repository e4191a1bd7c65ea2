//! Plots of the study.

use super::curve::{Clock, Norm, over_samples, over_time, value_at};
use super::method::{BASES, FROZEN_SAMPLES, MethodGroup, PassDistribution, basis_name, shown_groups};
use super::outcome::{MethodOutcome, RoomOutcome};
use crate::report::Figure;
use glanz_report::{Axis, Plot, ReferenceLine, Series};

/// Words for light sampling in file names and in sentences.
pub(super) fn light_words(lights: bool) -> (&'static str, &'static str) {
    if lights { ("lights", "with light sampling") } else { ("chance", "without light sampling") }
}

/// All plots of a room.
pub(super) fn figures(room: &RoomOutcome) -> Vec<Figure> {
    let mut all = Vec::new();
    for lights in [false, true] {
        for group in shown_groups() {
            let shown: Vec<&MethodOutcome> =
                group.methods.iter().filter_map(|key| room.outcome(key, lights)).collect();
            // Path and tree alone are plotted once.
            if shown.len() > 2 || group.key == "bases" {
                let view = GroupPlots { room, group: &group, shown, lights };
                all.extend(view.errors());
                all.extend(view.learning());
            }
        }
        all.extend(reachable(room, lights));
        all.extend(distributions(room, lights));
    }
    all
}

/// Plots of a group of methods in a room.
struct GroupPlots<'a> {
    room: &'a RoomOutcome,
    group: &'a MethodGroup,
    shown: Vec<&'a MethodOutcome>,
    lights: bool,
}

impl GroupPlots<'_> {
    fn figure(
        &self,
        what: &str,
        [x, y]: [&str; 2],
        line: &dyn Fn(&MethodOutcome) -> Vec<[f64; 2]>,
        caption: String,
    ) -> Figure {
        let (key, words) = light_words(self.lights);
        let series = |o: &&MethodOutcome| Series { name: o.method.name.clone(), points: line(o) };
        Figure {
            name: format!("{what}_{}_{}_{key}", self.group.key, self.room.name),
            plot: Plot {
                title: format!("{}, {words}: {}", self.room.name, self.group.title),
                x: Axis::logarithmic(x),
                y: Axis::logarithmic(y),
                series: self.shown.iter().map(series).filter(|s| !s.points.is_empty()).collect(),
                reference_lines: Vec::new(),
            },
            caption,
        }
    }

    /// Error over samples and over time in the norm of document 003, and over time in the plain one.
    fn errors(&self) -> [Figure; 3] {
        let (_, words) = light_words(self.lights);
        let room = &self.room.name;
        let time = |norm| move |o: &MethodOutcome| over_time(&o.curve, Clock::Wall, norm);
        [
            self.figure(
                "samples",
                ["samples per pixel", "modified L2 error"],
                &|o| over_samples(&o.curve, Norm::Shown),
                format!("Room {room}, {words}: error over samples (document 003, figures E.12 to E.46)."),
            ),
            self.figure(
                "time",
                ["time, s", "modified L2 error"],
                &time(Norm::Shown),
                format!("Room {room}, {words}: error over time (document 003, figures E.16 to E.53)."),
            ),
            self.figure(
                "l2",
                ["time, s", "L2 error"],
                &time(Norm::Plain),
                format!("Room {room}, {words}: error over time, including values too bright for a display."),
            ),
        ]
    }

    /// Error of pictures by frozen guides over the number of samples learnt from; `None` if only the tree has several such points.
    fn learning(&self) -> Option<Figure> {
        let (first, last) = (self.learnt().min()?, self.learnt().max()?);
        let caption = format!(
            "Room {}, {}: error of pictures of {FROZEN_SAMPLES} samples per pixel by guides that have learnt from the given \
             number (document 003, figures E.21 to E.24).",
            self.room.name,
            light_words(self.lights).1
        );
        let axes = ["samples per pixel learnt from", "modified L2 error"];
        let line = |o: &MethodOutcome| over_samples(&o.frozen, Norm::Shown);
        let mut figure = self.figure("frozen", axes, &line, caption);
        let several = figure.plot.series.iter().filter(|s| s.points.len() > 1).count();
        // The path tracer learns nothing and appears as a constant, in its usual colour.
        if let Some(rule) = path_rule(self.room, self.lights) {
            let points = [first, last].map(|samples| [f64::from(samples), rule.at]).into();
            figure.plot.series.insert(0, Series { name: rule.name, points });
        }
        (several > 1 || self.group.key == "bases").then_some(figure)
    }

    /// Numbers of samples that guides have learnt from.
    fn learnt(&self) -> impl Iterator<Item = u32> {
        self.shown.iter().flat_map(|o| o.frozen.iter().map(|p| p.samples))
    }
}

/// The error of the path tracer with as many samples as the pictures by frozen guides have.
fn path_rule(room: &RoomOutcome, lights: bool) -> Option<ReferenceLine> {
    let path = room.path(lights)?;
    let at = value_at(&over_samples(&path.curve, Norm::Shown), f64::from(FROZEN_SAMPLES))?;
    Some(ReferenceLine { name: format!("path, {FROZEN_SAMPLES} samples"), vertical: false, at, series: None })
}

/// Smallest error of densities over scale and subdivision: a plot for each basis.
fn reachable(room: &RoomOutcome, lights: bool) -> Vec<Figure> {
    let (key, words) = light_words(lights);
    let mut all = Vec::new();
    for basis in BASES {
        // Cells, scale and error of the plain grids of this basis.
        let mut found: Vec<[f64; 3]> = Vec::new();
        for outcome in room.outcomes.iter().filter(|o| o.lights == lights) {
            if let (Some(grid), Some(best)) = (outcome.method.grid, outcome.frozen.last())
                && (grid.basis, grid.mixture, grid.hierarchical, grid.passes) == (basis, false, false, None)
            {
                found.push([f64::from(grid.cells), f64::from(grid.scale), best.error.shown]);
            }
        }
        found.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let series: Vec<Series> = found
            .chunk_by(|a, b| a[0] == b[0])
            .filter(|points| points.len() > 1)
            .map(|points| Series {
                name: format!("{0} x {0} cells", points.first().map_or(0.0, |p| p[0])),
                points: points.iter().map(|p| [p[1], p[2]]).collect(),
            })
            .collect();
        if series.is_empty() {
            continue;
        }
        let name = basis_name(basis);
        all.push(Figure {
            name: format!("reachable_{basis}_{}_{key}", room.name),
            plot: Plot {
                title: format!("{}, {words}: {name}", room.name),
                x: Axis::linear("scale"),
                y: Axis::logarithmic("modified L2 error"),
                series,
                reference_lines: path_rule(room, lights).into_iter().collect(),
            },
            caption: format!(
                "Room {}, {words}, {name} basis: error of pictures of {FROZEN_SAMPLES} samples per pixel by guides after all \
                 learning passes (document 003, figures E.8, E.9, E.25, E.26, E.42 and E.43).",
                room.name
            ),
        });
    }
    all
}

/// Error after few learning samples over their time: a plot for each basis, a line for each distribution of samples over three passes.
fn distributions(room: &RoomOutcome, lights: bool) -> Vec<Figure> {
    let (key, words) = light_words(lights);
    let line = |distribution: &PassDistribution| {
        let those = room.outcomes.iter().filter(|o| o.lights == lights);
        let those = those.filter(|o| o.method.grid.is_some_and(|grid| distribution.has(&grid)));
        let point = |o: &MethodOutcome| Some([o.last()?.wall, o.frozen.last()?.error.shown]);
        Series { name: distribution.name(), points: those.filter_map(point).collect() }
    };
    let all: Vec<PassDistribution> = PassDistribution::all().collect();
    let each = all.chunk_by(|a, b| a.basis == b.basis).filter_map(|those| {
        let basis = those.first()?.basis;
        let series: Vec<Series> = those.iter().map(line).filter(|s| s.points.len() > 1).collect();
        let name = basis_name(basis);
        (!series.is_empty()).then(|| Figure {
            name: format!("distributions_{basis}_{}_{key}", room.name),
            plot: Plot {
                title: format!("{}, {words}: {name}, samples of three passes", room.name),
                x: Axis::logarithmic("time of three passes, s"),
                y: Axis::logarithmic("modified L2 error"),
                reference_lines: path_rule(room, lights).into_iter().collect(),
                series,
            },
            caption: format!(
                "Room {}, {words}, {name} basis: error of pictures of {FROZEN_SAMPLES} samples per pixel by guides that have \
                 learnt in three passes of equal or doubled length, over the learning time (document 003, figures \
                 E.37 and E.39).",
                room.name
            ),
        })
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guiding::method::entries;
    use crate::guiding::outcome::constructed;

    #[test]
    fn every_plot_has_a_name_of_its_own_and_lines() {
        let room = constructed(entries(128, true).into_iter().map(|entry| entry.method));
        let all = figures(&room);
        for (i, figure) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|other| other.name != figure.name), "{}", figure.name);
            assert!(figure.plot.series.iter().any(|s| s.points.len() > 1), "{}", figure.name);
            assert!(!figure.caption.contains("  ") && figure.plot.series.len() <= 6, "{}", figure.name);
        }
        // Three plots of errors, one of learning for each of five groups, one of scales for each basis, one of distributions
        // for two of them.
        assert_eq!(all.len(), 2 * (5 * 4 + 4 + 2));
        let reachable = all.iter().find(|figure| figure.name == "reachable_haar_hall_lights").unwrap();
        assert_eq!(reachable.plot.series.len(), 4);
        assert_eq!(reachable.plot.series[2].name, "8 x 8 cells");
        assert_eq!(
            reachable.plot.series[2].points.iter().map(|p| p[0]).collect::<Vec<_>>(),
            [1.0, 2.0, 3.0, 4.0]
        );
    }
}
