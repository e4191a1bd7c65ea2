//! The parts of curves that the camera sees.

use glanz_math::DVec2;
use glanz_scene::Scene;

use super::film_curve::FilmPoint;

/// Share of the width of a line by which surfaces may lie in front of it that are meant to bear it, as those of parts that touch: no
/// more than the eye can tell.
const LINE_SHARE: f64 = 1.0 / 16.0;

/// Multiple of the deviation of an edge by which the tangent plane of a curved face beside it may pass it: a line of sight that enters a
/// cylinder at the depth d below its silhouette is up to 4 d off the tangent plane where it leaves.
const TANGENT_PLANE: f64 = 4.0;

/// Halvings of a step in which a line ends: a sixteenth of a pixel.
const HALVINGS: u32 = 4;

/// The visible parts of a curve on the film, pixels. `deviation`: of the curve, metres; `width`: of the line, pixels.
pub(super) fn visible_parts(
    scene: &Scene,
    curve: &[FilmPoint],
    deviation: f64,
    width: f64,
) -> Vec<Vec<DVec2>> {
    let sees = |at: &FilmPoint| {
        scene.sees(at.eye, at.point, TANGENT_PLANE * deviation + LINE_SHARE * width * at.pixel)
    };
    let mut parts: Vec<Vec<DVec2>> = Vec::new();
    let mut before: Option<(FilmPoint, bool)> = None;
    for &at in curve {
        let visible = sees(&at);
        match before {
            Some((last, true)) if !visible => {
                let end = boundary(last, at, &sees);
                parts.last_mut().into_iter().for_each(|part| part.push(end));
            }
            Some((last, false)) if visible => parts.push(vec![boundary(at, last, &sees), at.film]),
            None if visible => parts.push(vec![at.film]),
            _ if visible => parts.last_mut().into_iter().for_each(|part| part.push(at.film)),
            _ => {}
        }
        before = Some((at, visible));
    }
    parts
}

/// Where the curve disappears between a visible point and a hidden one.
fn boundary(visible: FilmPoint, hidden: FilmPoint, sees: &impl Fn(&FilmPoint) -> bool) -> DVec2 {
    let (mut visible, mut hidden) = (visible, hidden);
    for _ in 0..HALVINGS {
        // Within a pixel, film and space are proportional.
        let middle = FilmPoint {
            film: 0.5 * (visible.film + hidden.film),
            point: 0.5 * (visible.point + hidden.point),
            eye: 0.5 * (visible.eye + hidden.eye),
            pixel: visible.pixel,
        };
        if sees(&middle) {
            visible = middle;
        } else {
            hidden = middle;
        }
    }
    0.5 * (visible.film + hidden.film)
}
