//! The worked example of document 000 section 4.3, and its fan of 256 rays.

use std::f64::consts::{FRAC_PI_2, PI};

use glanz_geometry::{Hit, RaySurface, SurfaceError};
use glanz_math::{DVec2, DVec3, Ray};

use super::compare::{STEPS, STEPS_OF_000, Variant};
use super::iteration::{NewtonOutcome, StoppingCriteria};
use super::patches::{Shape, TRUE_POINTS, Target, faulty_points, reflector};
use crate::report::Report;
use glanz_report::number::{plural, significant};
use glanz_report::{Axis, Plot, Series, Table, TableCell};

/// Intersection of the infinite line of the example with the patch that document 000 computed with, extended beyond its domain:
/// 30 digits from the resultant of two plane cubics.
pub(super) const TAU: f64 = 46.012_263_655_548_77;

/// The only root of the fan: tau, (s, t) and the unit normal that faces the ray, to 30 digits by the same method.
const FAN_TAU: f64 = 43.341_790_020_607_25;
const FAN_AT: DVec2 = DVec2::new(0.354_776_787_529_589_9, 0.581_425_944_232_568_5);
const FAN_NORMAL: DVec3 =
    DVec3::new(-0.812_378_898_193_333_8, 0.425_688_116_503_215_64, 0.398_535_008_798_637_07);

/// Where document 000 starts: (s, t) = (beta, gamma) of the published barycentric coordinates, which its program assigns to the
/// wrong corners, and tau half-way between the hits with the hull; computed independently.
const START_OF_000: [f64; 3] = [0.244_662_274_047_676_35, 0.100_362_969_448_570_51, 43.684_761_608_745_16];

/// Residual in document 000.
const LIMIT: f64 = 1e-10;

/// The ray from the lamp at (0, 5, 5) with node (i, j) of a grid of n + 1 angles each; its direction has the length 0.1, as there.
pub(crate) fn fan_ray(n: i32, i: i32, j: i32) -> Ray {
    let theta = PI * f64::from(2 * i - n) / f64::from(n);
    let phi = FRAC_PI_2 * f64::from(2 * j - n) / f64::from(n);
    let v = 0.1 * DVec3::new(phi.cos() * theta.cos(), phi.cos() * theta.sin(), phi.sin());
    Ray::new(DVec3::new(0.0, 5.0, 5.0), v)
}

/// The ray of the example. Its printed direction belongs to the grid with k = 5, not to that with k = 4 of the text (@pumberger2010 section 4.3).
fn published_ray() -> Ray {
    fan_ray(31, 14, 13)
}

/// An iteration of the example.
pub(super) struct ExampleRun {
    patch: &'static str,
    start: &'static str,
    variant: Variant,
    outcome: NewtonOutcome<3>,
    inside: bool,
}

/// Results of the example.
pub(super) struct Example {
    pub(super) runs: Vec<ExampleRun>,
    /// Number of roots of the line with the true patch and with the faulty one, by the certified search.
    pub(super) hits: [usize; 2],
    pub(super) fan: Vec<(Hit, DVec2, DVec3)>,
    pub(super) fan_rays: u64,
    /// Iterations of the variants on the fan: converged ones, and of these the ones inside and ahead.
    pub(super) fan_newton: [(u64, u64); 3],
    /// Residuals by steps on the patch of document 000.
    convergence: Vec<Series>,
}

/// Solves the example.
///
/// # Errors
/// None in practice: the patches are valid.
pub(super) fn solve() -> Result<Example, SurfaceError> {
    let (truth, faulty) =
        (Target::try_new(reflector(TRUE_POINTS)?)?, Target::try_new(reflector(faulty_points())?)?);
    let ray = published_ray();
    let limits = StoppingCriteria { residual: LIMIT, iterations: STEPS };
    let mut runs = Vec::new();
    // For the true patch the coordinates are assigned to the right corners: t of P003 is alpha, s of P030 beta.
    let [beta, gamma, tau] = START_OF_000;
    let right = [beta, 1.0 - beta - gamma, tau];
    for (patch, start, from, shape) in [
        ("as computed in 000", "of 000", START_OF_000, &faulty.shape),
        ("as computed in 000", "at the right corners", right, &faulty.shape),
        ("true", "at the right corners", right, &truth.shape),
    ] {
        for variant in Variant::ALL {
            let outcome = variant.run(shape, &ray, from, limits);
            let [u, v, t] = outcome.iterate().x;
            let inside = shape.outside(u, v) == 0.0 && t > 0.0;
            runs.push(ExampleRun { patch, start, variant, outcome, inside });
        }
    }
    let count = |target: &Target| {
        let mut hits = Vec::new();
        target.search.all_hits(&ray, f64::INFINITY, &mut hits);
        hits.len()
    };
    let hits = [count(&truth), count(&faulty)];
    let convergence = Variant::ALL.map(|v| convergence(v, &faulty.shape, &ray)).to_vec();
    let mut example =
        Example { runs, hits, fan: Vec::new(), fan_rays: 0, fan_newton: [(0, 0); 3], convergence };
    example.shoot_fan(&truth);
    Ok(example)
}

/// Residuals of the iterates from the start of document 000.
fn convergence(variant: Variant, shape: &Shape, ray: &Ray) -> Series {
    let point = |n: u32| {
        // The n-th iterate is the end of a run of n steps without another limit.
        let outcome =
            variant.run(shape, ray, START_OF_000, StoppingCriteria { residual: 0.0, iterations: n });
        (outcome.iterate().iterations == n).then_some([f64::from(n), outcome.iterate().residual])
    };
    let points = (0..=20).map_while(point).filter(|p| p[1] < 1e6).collect();
    Series { name: variant.name().to_owned(), points }
}

impl Example {
    fn shoot_fan(&mut self, truth: &Target) {
        let n = 15;
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            let ray = fan_ray(n, i, j);
            self.fan_rays += 1;
            let mut hits = Vec::new();
            truth.search.all_hits(&ray, f64::INFINITY, &mut hits);
            self.fan.extend(hits.into_iter().map(|hit| {
                let point = truth.search.point(&ray, &hit);
                let facing = if point.normal.dot(ray.direction) > 0.0 { -point.normal } else { point.normal };
                (hit, point.uv, facing)
            }));
            let Some(start) = truth.start(&ray) else { continue };
            for (count, variant) in self.fan_newton.iter_mut().zip(Variant::ALL) {
                let limits = StoppingCriteria { residual: LIMIT, iterations: STEPS_OF_000 };
                if let Some(end) = variant.run(&truth.shape, &ray, start, limits).converged() {
                    count.0 += 1;
                    let [u, v, t] = end.x;
                    count.1 += u64::from(truth.shape.outside(u, v) == 0.0 && t > 0.0);
                }
            }
        }
    }

    /// The ray parameter at which the general method ends on the patch that document 000 computed with, from its start.
    pub(super) fn published(&self) -> Option<f64> {
        let run = self.runs.iter().find(|r| r.start == "of 000" && r.variant == Variant::General)?;
        run.outcome.converged().map(|end| end.x[2])
    }

    /// Adds the chapter to the report.
    pub(super) fn add_to(&self, report: &mut Report) {
        report.heading("The example of document 000, section 4.3");
        let [on_true, on_faulty] = self.hits;
        let verb = |n: usize| {
            if n == 0 {
                "misses".to_owned()
            } else {
                format!("meets (in {})", plural(n as u64, "root", "roots"))
            }
        };
        report.paragraph(format!(
            "According to the document, a line from (0, 5, 5) hits a cubic triangle at tau = 46.01226366. By the certified \
             search it {} the patch, and {} the patch that the program actually used (it omits the factors 3!/(i! j! k!)). \
             Extended beyond its domain, that patch has a root at tau = {TAU}.",
            verb(on_true),
            verb(on_faulty)
        ));
        report.paragraph(match self.published() {
            Some(tau) => format!(
                "General Newton's method from the published start ends at tau = {tau}, {} from that root.",
                significant((tau - TAU).abs())
            ),
            None => "General Newton's method from the published start does not converge.".to_owned(),
        });
        report.table(self.table());
        let plot = Plot {
            title: "Residual by steps, from the published start".to_owned(),
            x: Axis::linear("steps"),
            y: Axis::logarithmic("distance of patch and ray point, units of the scene"),
            series: self.convergence.clone(),
            reference_lines: Vec::new(),
        };
        report.plot(
            "convergence",
            plot,
            "Convergence of the variants to a root of the patch of document 000, extended beyond its domain.",
        );
        self.add_fan(report);
    }

    fn table(&self) -> Table {
        let columns = [
            ("patch", "patch"),
            ("start", "start"),
            ("method", "method"),
            ("end", "end"),
            ("steps", "steps"),
            ("tau", "tau"),
            ("r", "r"),
            ("s", "s"),
            ("t", "t"),
            ("residual", "residual"),
            ("inside", "in the triangle"),
        ];
        let caption = "The example: where the iterations end (at most 50 steps, residual 1e-10).";
        let mut table = Table::new("example", caption, &columns);
        for run in &self.runs {
            let end = run.outcome.iterate();
            let [s, t, tau] = end.x;
            let how = match run.outcome {
                NewtonOutcome::Converged(_) => "converged",
                NewtonOutcome::Singular(_) => "singular",
                NewtonOutcome::LeftDomain(_) => "left domain",
                NewtonOutcome::NotConverged(_) => "not converged",
            };
            let numbers =
                [TableCell::Precise(tau), (1.0 - s - t).into(), s.into(), t.into(), end.residual.into()];
            let words = [run.patch, run.start, run.variant.name(), how].map(TableCell::from);
            let steps = std::iter::once(TableCell::from(u64::from(end.iterations)));
            let inside = std::iter::once(TableCell::from(if run.inside { "yes" } else { "no" }));
            table.push(words.into_iter().chain(steps).chain(numbers).chain(inside));
        }
        table
    }

    fn add_fan(&self, report: &mut Report) {
        report.heading("The fan of 256 rays (k = 4)");
        let mut text = format!(
            "Of {} rays from the lamp, the certified search finds {}.",
            self.fan_rays,
            plural(self.fan.len() as u64, "root", "roots")
        );
        if let [(hit, at, normal)] = self.fan.as_slice() {
            text += &format!(
                " It lies at tau = {}, (s, t) = ({}, {}). From the root known to 30 digits it is {} away in tau, {} in \
                 (s, t); its normal deviates by {} rad.",
                hit.t,
                at.x,
                at.y,
                significant((hit.t - FAN_TAU).abs()),
                significant(at.distance(FAN_AT)),
                significant(normal.cross(FAN_NORMAL).length())
            );
        }
        report.paragraph(text);
        let columns =
            [("method", "method"), ("accepted", "accepted by residual"), ("inside", "of these hits")];
        let caption = "The fan: lines that each method accepts as hits within 10 steps, as in document 000, and how many of \
         these lie in the triangle and ahead of the lamp.";
        let mut table = Table::new("fan", caption, &columns);
        for (variant, (accepted, inside)) in Variant::ALL.into_iter().zip(self.fan_newton) {
            table.push([variant.name().into(), accepted.into(), inside.into()]);
        }
        let found = self.fan.len() as u64;
        table.push(["certified search".into(), found.into(), found.into()]);
        report.table(table);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_line_misses_the_true_patch_and_gives_the_published_root_on_the_other() {
        let example = solve().unwrap();
        assert_eq!(example.hits, [0, 0]);
        let tau = example.published().unwrap();
        assert!((tau - TAU).abs() < 1e-12, "{tau}");
        // Without clipping the true patch has roots too, outside of the triangle, computed like `TAU`.
        let known = [39.379_303_432_317_02, 65.892_297_052_705_1, 73.065_133_109_719_67];
        for run in example.runs.iter().filter(|r| r.patch == "true") {
            if let Some(end) = run.outcome.converged() {
                assert!(!run.inside && known.iter().any(|t| (t - end.x[2]).abs() < 1e-6), "{end:?}");
            }
        }
    }

    #[test]
    fn one_ray_of_the_fan_hits_where_the_reference_says() {
        let example = solve().unwrap();
        let [(hit, at, normal)] = example.fan[..] else { panic!("{} roots", example.fan.len()) };
        assert!((hit.t - FAN_TAU).abs() < 1e-11 && at.distance(FAN_AT) < 1e-12);
        assert!(normal.distance(FAN_NORMAL) < 1e-12);
        assert_eq!(example.fan_rays, 256);
    }
}
