//! Observers of planned rooms: `Observer`, a directive in addition to those of pbrt.

use glanz_math::DVec3;
use glanz_scene::description::ObserverDescription;

use super::{EntityState, Lowering};
use crate::pbrt::parameters::ParameterList;
use crate::source::ParseResult;

/// Largest number of observers of a scene.
const MAX_OBSERVERS: usize = 100_000;

impl Lowering {
    /// `Observer "glare"`: every eye looks in every direction. `Observer "cylinder"`: points of cylindrical illuminance.
    pub(crate) fn observer(
        &mut self,
        kind: &str,
        mut list: ParameterList,
        context: &EntityState,
    ) -> ParseResult<()> {
        let place = list.place;
        let has_views = match kind {
            "glare" => true,
            "cylinder" => false,
            _ => {
                let message = format!("{} is unknown", list.subject);
                let help = Some("observers are \"glare\" and \"cylinder\"".to_owned());
                return Err(self.reporter.error_with_help(&place, "parameter-range", message, help));
            }
        };
        let points = list.vec3s("P", &mut self.reporter)?.map(|(_, points)| points).unwrap_or_default();
        if points.is_empty() {
            let message = format!("{} has no \"point3 P\"", list.subject);
            return Err(self.reporter.error(&place, "parameter-missing", message));
        }
        let mut views = vec![None];
        if has_views {
            let Some((p, directions)) = list.vec3s("view", &mut self.reporter)? else {
                let message = format!("{} has no \"vector3 view\"", list.subject);
                return Err(self.reporter.error(&place, "parameter-missing", message));
            };
            let directions: Vec<DVec3> =
                directions.into_iter().map(|view| context.ctm.transform_vector3(view)).collect();
            // The position index refers to the vertical plane of the line of sight.
            if let Some(view) = directions
                .iter()
                .find(|view| view.x.hypot(view.y) <= 1e-9 * view.z.abs() || !view.is_finite())
            {
                let message = format!("{}: view {view} in the world is vertical", list.subject);
                let help = Some("a line of sight needs a horizontal part".to_owned());
                return Err(self.reporter.error_with_help(&p.value_place, "parameter-range", message, help));
            }
            views = directions.into_iter().map(Some).collect();
        }
        list.finish(&mut self.reporter);
        let observers = &mut self.description.observers;
        if observers.len().saturating_add(points.len().saturating_mul(views.len())) > MAX_OBSERVERS {
            let message = format!("there are more than {MAX_OBSERVERS} observers");
            return Err(self.reporter.error(&place, "limit", message));
        }
        for position in points.into_iter().map(|point| context.ctm.transform_point3(point)) {
            let location = Some(place.location);
            observers.extend(views.iter().map(|&view| ObserverDescription { position, view, location }));
        }
        Ok(())
    }
}
