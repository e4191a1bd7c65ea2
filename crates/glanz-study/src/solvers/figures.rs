//! Plots of the study.

use super::descent::Descent;
use super::measure::{LEFT, RoomSolutions, SolverKind, SolverRun};
use crate::report::Figure;
use glanz_report::number::significant;
use glanz_report::{Axis, Plot, ReferenceLine, Series};

/// Exponent of the power law that fits the points, by least squares of logarithms; `None` for fewer than two points.
pub(super) fn exponent(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> =
        points.iter().filter(|p| p[0] > 0.0 && p[1] > 0.0).map(|p| p.map(f64::ln)).collect();
    let count = logs.len() as f64;
    let mean = |axis: usize| logs.iter().map(|p| p[axis]).sum::<f64>() / count;
    let [x, y] = [0, 1].map(mean);
    let (above, below) = logs
        .iter()
        .fold((0.0, 0.0), |(above, below), p| (above + (p[0] - x) * (p[1] - y), below + (p[0] - x).powi(2)));
    (logs.len() > 1 && below > 0.0).then(|| above / below)
}

/// Points of a quantity over the number of elements.
pub(super) fn over_elements(
    outcome: &RoomSolutions,
    solver: SolverKind,
    quantity: impl Fn(&SolverRun) -> Option<f64>,
) -> Vec<[f64; 2]> {
    outcome.of(solver).filter_map(|run| Some([run.elements as f64, quantity(run)?])).collect()
}

/// Processor time, s.
pub(super) fn time(run: &SolverRun) -> Option<f64> {
    Some(run.processors.as_secs_f64())
}

/// Stored form factors or links.
pub(super) fn stored(run: &SolverRun) -> Option<f64> {
    Some(run.stored? as f64)
}

/// Number of rays.
pub(super) fn rays(run: &SolverRun) -> Option<f64> {
    Some(run.rays as f64)
}

/// All plots of a room.
pub(super) fn figures(outcome: &RoomSolutions) -> Vec<Figure> {
    let RoomSolutions { name, .. } = outcome;
    let series = |solver: SolverKind, points: Vec<[f64; 2]>, fitted: bool| {
        let slope = exponent(&points).filter(|_| fitted);
        let slope = match slope {
            _ if points.is_empty() => ": none".to_owned(),
            Some(exponent) => format!(", exponent {exponent:.2}"),
            None => String::new(),
        };
        Series { name: format!("{}{slope}", solver.name()), points }
    };
    let over =
        |what: &'static str, title: &str, y: &str, quantity: &dyn Fn(&SolverRun) -> Option<f64>, fitted| {
            let all = SolverKind::ALL
                .map(|solver| series(solver, over_elements(outcome, solver, quantity), fitted));
            let plot = Plot {
                title: format!("{title}, room {name}"),
                x: Axis::logarithmic("elements"),
                y: Axis::logarithmic(y),
                // Series without points are included, so that each solver has the same colour in all plots.
                series: all.into(),
                reference_lines: Vec::new(),
            };
            (format!("{what}_{name}"), plot)
        };
    let figure =
        |(name, plot): (String, Plot), caption: &str| Figure { name, plot, caption: caption.to_owned() };
    let fitted =
        "exponents are slopes of straight lines through the points, fitted by least squares of logarithms";
    let by_time = SolverKind::ALL.map(|solver| {
        let points =
            outcome.of(solver).filter_map(|run| Some([run.processors.as_secs_f64(), run.errors[1]?]));
        series(solver, points.collect(), false)
    });
    let error_time = Plot {
        title: format!("Error against the finest links, room {name}"),
        x: Axis::logarithmic("processor time, s"),
        y: Axis::logarithmic("relative L2 error"),
        series: by_time.into(),
        reference_lines: Vec::new(),
    };
    vec![
        figure(
            over("time", "Time", "processor time, s", &time, true),
            &format!("Processor time of a solution over its number of elements; {fitted}."),
        ),
        figure(over("rays", "Rays", "rays", &rays, true), &format!("Visibility rays; {fitted}.")),
        figure(
            over("kept", "Memory", "stored form factors or links", &stored, true),
            &format!(
                "Form factors of all pairs that see each other, or links; progressive refinement stores none; {fitted}."
            ),
        ),
        figure(
            over("error", "Error against all pairs", "relative L2 error", &|run| run.errors[0], false),
            "Error against the finest solution by all pairs, over the number of elements; where it no longer falls, it is \
             the error of that solution itself.",
        ),
        figure(
            over(
                "error_links",
                "Error against the finest links",
                "relative L2 error",
                &|run| run.errors[1],
                false,
            ),
            "Error against the finest hierarchical solution.",
        ),
        figure((format!("error_time_{name}"), error_time), "The same error over processor time."),
        convergence(outcome),
    ]
}

fn convergence(outcome: &RoomSolutions) -> Figure {
    let Descent { elements, shooting, with_ambient, gathering, left } = &outcome.descent;
    let series =
        |name: &str, points: &Vec<[f64; 2]>| Series { name: name.to_owned(), points: points.clone() };
    let at = shooting.iter().zip(left).find(|(_, left)| **left <= LEFT).map(|(point, _)| point[0]);
    let rule = |at| ReferenceLine {
        name: format!("{} of the light unshot", significant(LEFT)),
        vertical: true,
        at,
        series: None,
    };
    Figure {
        name: format!("convergence_{}", outcome.name),
        plot: Plot {
            title: format!("Convergence, room {}, {elements} elements", outcome.name),
            x: Axis::logarithmic("steps: elements that have shot or gathered"),
            y: Axis::logarithmic("relative L2 error"),
            series: vec![
                series("shooting", shooting),
                series("shooting, with the ambient term", with_ambient),
                series("gathering, by whole sweeps", gathering),
            ],
            reference_lines: at.map(rule).into_iter().collect(),
        },
        caption: "Difference from the converged solution after each shooting element, without and with an estimate of the \
         unshot light, and after sweeps in which all elements gather (as compared by Cohen and others, 1988)."
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_of_powers_are_found() {
        let points: Vec<[f64; 2]> = [1.0, 2.0, 7.0, 30.0].map(|x: f64| [x, 3.0 * x.powf(1.7)]).into();
        assert!((exponent(&points).unwrap() - 1.7).abs() < 1e-12);
        assert_eq!(exponent(&[[2.0, 1.0], [2.0, 3.0]]), None);
        assert_eq!(exponent(&[[2.0, 1.0]]), None);
    }
}
