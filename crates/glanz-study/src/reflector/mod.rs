//! Light of a lamp after reflection in a freeform mirror (document 000 chapter 4).

mod comparison;
mod conics;
mod facets;
mod fan;
mod lux;
mod mesh;
mod particles;
mod report;
mod revolution;
mod room;
mod scene_plot;
mod speed;

use glanz_scene::description::ShapeDescription;

use self::conics::{Conic, MirrorModel};
use self::report::ConicRow;
use crate::clock;
use crate::report::Report;
use crate::study::{Settings, StudyError, StudyProgress};
use glanz_report::Series;
use glanz_report::number::grouped;

/// Default number of particles.
const PARTICLES: u64 = 10_000_000;

/// The extent of the measurements.
struct ReflectorPlan<'a> {
    /// Number of cells along a side of a wall.
    cells: u32,
    /// The same for the comparison with integration, and the largest number of points in a cell.
    comparison: (u32, usize),
    /// Numbers of triangles along an edge of the mirror.
    edges: &'a [u32],
    /// Number of rays at each mirror with a closed form.
    conic_rays: u32,
    /// Approximate numbers of triangles of these mirrors.
    triangles: &'a [u64],
    /// Numbers of parts of the mirrors' edges for the measurement of speed.
    parts: &'a [u32],
}

/// The whole study.
const WHOLE: ReflectorPlan<'static> = ReflectorPlan {
    cells: particles::CELLS,
    comparison: (comparison::CELLS, comparison::POINTS),
    edges: &facets::EDGES,
    conic_rays: 100_000,
    triangles: &[100, 1000, 10_000, 100_000, 1_000_000],
    parts: &speed::EDGES,
};

/// Number of triangles of the spherical mirrors whose aberration is plotted, few enough that facets are visible.
const DRAWN: u64 = 10_000;

/// Progress at the beginning of each part.
const LUX: f64 = 0.01;
const COMPARISON: f64 = 0.15;
const FACETS: f64 = 0.4;
const CONICS: f64 = 0.85;
const SPEED: f64 = 0.95;

/// Runs the study.
///
/// # Errors
/// [`StudyError::Interrupted`], or no particles.
pub(crate) fn run(settings: &Settings, progress: &mut StudyProgress<'_>) -> Result<Report, StudyError> {
    settings.cancel.check()?;
    run_plan(&WHOLE, settings, progress)
}

fn run_plan(
    plan: &ReflectorPlan<'_>,
    settings: &Settings,
    progress: &mut StudyProgress<'_>,
) -> Result<Report, StudyError> {
    let wanted = settings.rays.unwrap_or(PARTICLES);
    let bad = || StudyError::Setting {
        name: "rays",
        value: wanted.to_string(),
        needed: "a number from 1 to 1 000 000 000",
    };
    let particles = u32::try_from(wanted).ok().filter(|n| (1..=1_000_000_000).contains(n)).ok_or_else(bad)?;
    progress.report(0.0, "the fan of document 000");
    let mirror = room::alone(ShapeDescription::bezier_triangles(&[room::mirror()?]))?;
    let fan = fan::fan(&mirror, 4);
    let (scene, receivers) = lux::room(plan.cells)?;
    let mut on_progress = |done: f64| progress.report(LUX + (COMPARISON - LUX) * done, "lux on the walls");
    let lux = lux::measure(&scene, &receivers, u64::from(particles), settings, &mut on_progress)?;
    let mut on_progress = |done: f64| {
        progress.report(COMPARISON + (FACETS - COMPARISON) * done, "particles against integration")
    };
    let comparison = comparison::measure(plan.comparison, u64::from(particles), settings, &mut on_progress)?;
    let mut on_progress = |done: f64, what: String| progress.report(FACETS + (CONICS - FACETS) * done, &what);
    let facets = facets::measure(particles, plan.edges, settings, &mut on_progress)?;
    let rays = plan.conic_rays.min(particles);
    let mut on_progress = |done: f64, what: String| progress.report(CONICS + (SPEED - CONICS) * done, &what);
    let (rows, curves) = measure_conics(rays, plan.triangles, settings, &mut on_progress)?;
    progress.report(SPEED, "particles per second");
    let speeds = speed::measure(plan.parts, settings)?;

    let mut report =
        Report::new("Study reflector: light of a lamp after reflection in a freeform mirror", lux.table());
    report.heading("Question");
    report.paragraph(
        "Document 000 (chapter 4) puts a lamp and a mirror, a cubic triangular Bézier patch, into a closed room and computes \
         the distribution of its light. Its program has errors; this report contains the correct rays, the light on all six \
         walls, and the effect of replacing the mirror by triangles, as lighting programs usually do.",
    );
    let clock = if clock::counts_processor_time() { "processor times" } else { "wall times" };
    report.paragraph(format!(
        "Settings: {} particles, seed {}; times are {clock}.",
        grouped(u64::from(particles)),
        settings.seed
    ));
    fan::add_to(&fan, &mut report);
    report.drawing(
        "room",
        scene_plot::drawing(&fan, &fan::fan(&mirror, 7))?,
        "The room, seen from above the wall y = 0: lamp, mirror with the hull of its control points, rays, and their ends.",
    );
    lux.add_to(&mut report, &facets.exact)?;
    comparison.add_to(&mut report);
    report::add_facets(&facets, &mut report);
    report::add_conics(&rows, curves, &mut report);
    speed::add_to(&speeds, &mut report);
    progress.report(1.0, "done");
    Ok(report)
}

/// Deviations of all mirrors with closed forms, and crossings of the axis of the spherical one.
fn measure_conics(
    rays: u32,
    triangles: &[u64],
    settings: &Settings,
    on_progress: &mut dyn FnMut(f64, String),
) -> Result<(Vec<ConicRow>, Vec<Series>), StudyError> {
    let models: Vec<MirrorModel> = [MirrorModel::Quadric, MirrorModel::Patches]
        .into_iter()
        .chain(triangles.iter().map(|&n| MirrorModel::Facets(n)))
        .chain(triangles.iter().map(|&n| MirrorModel::Smooth(n)))
        .collect();
    let parts = (Conic::ALL.len() * models.len()) as f64;
    let mut rows = Vec::new();
    let mut curves = vec![report::closed_form_curve()];
    for conic in Conic::ALL {
        for &model in &models {
            on_progress(rows.len() as f64 / parts, format!("{} mirror, {}", conic.name(), model.name()));
            let (scene, triangles) = conic.scene(model)?;
            let deviation = conic.deviations(&scene, rays, settings)?;
            if conic == Conic::Spherical
                && matches!(
                    model,
                    MirrorModel::Patches | MirrorModel::Facets(DRAWN) | MirrorModel::Smooth(DRAWN)
                )
            {
                let name = match triangles {
                    Some(n) => format!("{} {}", grouped(n), model.name()),
                    None => model.name().to_owned(),
                };
                curves.push(Series { name, points: conics::crossings(&scene, &report::heights(41)) });
            }
            rows.push(ConicRow { conic, model, triangles, deviation });
        }
    }
    Ok((rows, curves))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::StudyProgress;
    use glanz_job::Silent;

    #[test]
    fn report_has_a_row_for_every_wall_ray_and_mirror() {
        let settings = Settings { rays: Some(20_000), ..Settings::default() };
        let plan = ReflectorPlan {
            cells: 2,
            comparison: (1, 13),
            edges: &[4],
            conic_rays: 100,
            triangles: &[100],
            parts: &[],
        };
        let report = run_plan(&plan, &settings, &mut StudyProgress::new(&mut Silent)).unwrap();
        assert_eq!(report.summary().rows().len(), 6);
        let rows =
            |name: &str| report.tables().find(|table| table.name() == name).map(|table| table.rows().len());
        assert_eq!(rows("fan"), Some(256));
        // 112 rays away from the wall of the lamp, 32 along it.
        let walls = ["fan_floor", "fan_ceiling", "fan_x0", "fan_x10", "fan_y0", "fan_y10"];
        assert_eq!(walls.iter().map(|name| rows(name).unwrap()).sum::<usize>(), 144);
        assert_eq!(rows("lux"), Some(6 * 4));
        // Walls, all of them, and Student's distribution.
        assert_eq!(rows("against"), Some(6 + 2));
        // Exact, flat, smooth; quadric, patches, flat, smooth for each of three.
        assert_eq!((rows("facets"), rows("closed_forms"), rows("speed")), (Some(3), Some(12), Some(0)));
        let text = report.markdown();
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    }

    #[test]
    fn no_particles_are_refused() {
        for bad in [0, 1_000_000_001, u64::MAX] {
            let settings = Settings { rays: Some(bad), ..Settings::default() };
            let refused = run(&settings, &mut StudyProgress::new(&mut Silent));
            assert!(matches!(refused, Err(StudyError::Setting { name: "rays", .. })), "{bad}");
        }
    }
}
