//! Shapes on which incident light is measured.

use glanz_scene::description::{MAX_RECEIVER_CELLS, ReceiverDescription, ReceiverSide, ZoneKind};

use super::Lowering;
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::ParseResult;

impl Lowering {
    /// `receiver`, `cells`, `receiverside` and `zone` of a shape; an empty name means no receiver.
    pub(super) fn receiver(&mut self, list: &mut ParameterList) -> ParseResult<Option<ReceiverDescription>> {
        let Some((p, name)) = list.text_parameter("receiver", &mut self.reporter)? else {
            return Ok(None);
        };
        let cells = self.cells(list)?;
        let side = self.side(list)?;
        let zone = self.zone(list)?;
        if name.is_empty() {
            return Ok(None);
        }
        if self.object.is_some() {
            let message = format!(
                "{}: receiver {:?} is in an object, every copy of which would be the same receiver",
                list.subject,
                shortened(&name)
            );
            let help = Some("put the shape into the world, outside ObjectBegin and ObjectEnd".to_owned());
            return Err(self.reporter.error_with_help(&p.value_place, "receiver-in-object", message, help));
        }
        Ok(Some(ReceiverDescription { name, cells, side, zone, location: Some(p.value_place.location) }))
    }

    fn cells(&mut self, list: &mut ParameterList) -> ParseResult<Option<[u32; 2]>> {
        let Some((p, [u, v])) = list.integer_array("cells", &mut self.reporter)? else { return Ok(None) };
        let count = |n: i32| u32::try_from(n).ok().filter(|n| (1..=MAX_RECEIVER_CELLS).contains(n));
        match (count(u), count(v)) {
            (Some(u), Some(v)) => Ok(Some([u, v])),
            _ => {
                let message = format!(
                    "{}: \"cells\" are {u} x {v}, each must be from 1 to {MAX_RECEIVER_CELLS}",
                    list.subject
                );
                Err(self.reporter.error(&p.value_place, "parameter-range", message))
            }
        }
    }

    fn zone(&mut self, list: &mut ParameterList) -> ParseResult<Option<ZoneKind>> {
        let Some((p, zone)) = list.text_parameter("zone", &mut self.reporter)? else { return Ok(None) };
        let found = ZoneKind::ALL.into_iter().find(|kind| kind.name() == zone);
        if found.is_none() {
            let message = format!("{}: zone {:?} is unknown", list.subject, shortened(&zone));
            let help = Some(format!("zones are {}", ZoneKind::ALL.map(ZoneKind::name).join(", ")));
            return Err(self.reporter.error_with_help(&p.value_place, "parameter-range", message, help));
        }
        Ok(found)
    }

    fn side(&mut self, list: &mut ParameterList) -> ParseResult<ReceiverSide> {
        let Some((p, side)) = list.text_parameter("receiverside", &mut self.reporter)? else {
            return Ok(ReceiverSide::default());
        };
        match side.as_str() {
            "front" => Ok(ReceiverSide::Front),
            "back" => Ok(ReceiverSide::Back),
            "both" => Ok(ReceiverSide::Both),
            other => {
                let message = format!("{}: receiverside {:?} is unknown", list.subject, shortened(other));
                let help = Some("sides are front, back and both".to_owned());
                Err(self.reporter.error_with_help(&p.value_place, "parameter-range", message, help))
            }
        }
    }
}
