//! The merits of the targets of a description.

use glanz_math::DVec3;
use glanz_scene::description::{ReceiverSide, TargetDescription, TargetKind};
use glanz_scene::{Description, Scene};

use super::error::OptimizeError;
use super::landing_grid::{LandingGrid, WantedLight};
use super::merit::{Merit, ReceiverFrame};
use super::ray_sources::first_of_world;
use crate::receiver::{GridResolution, ReceiverRequest, Receivers};

/// Cells along the longer side of a target without cells of its own.
const CELLS: u32 = 16;
/// Most cells along a side of a target: there are 16 times as many around it, and sums for every chunk of rays.
const MAX_CELLS: u32 = 128;
/// Largest relative difference between the area of a receiver and that of its rectangle.
const FLATNESS: f64 = 1e-6;

/// The merit of a target; `emitted`: flux of all lights, lm.
pub(super) fn merit(
    description: &Description,
    scene: &Scene,
    index: usize,
    target: &TargetDescription,
    emitted: f64,
) -> Result<Merit, OptimizeError> {
    if let TargetKind::Collimation { direction } = target.kind {
        return Ok(Merit::Collimation { mirror: target.shape, direction });
    }
    let shape = (first_of_world(description) + target.shape) as u32;
    let declared = description.world.shapes.get(target.shape).and_then(|shape| shape.receiver.as_ref());
    let side = declared.map_or(ReceiverSide::Front, |receiver| receiver.side);
    let receiver = frame(scene, shape, side)?.ok_or(OptimizeError::NoRectangle { index })?;
    let [across, up] = receiver.half_sides.map(DVec3::length);
    let longer = across.max(up);
    let usual = [across, up].map(|side| (f64::from(CELLS) * side / longer).round().max(1.0) as u32);
    let cells = declared.and_then(|receiver| receiver.cells).unwrap_or(usual).map(|n| n.min(MAX_CELLS));
    let grid =
        |wanted: &WantedLight<'_>| Merit::Distribution { receiver, grid: LandingGrid::new(cells, wanted) };
    Ok(match &target.kind {
        TargetKind::Even { margin } => grid(&WantedLight::Even { margin: *margin }),
        TargetKind::Values { cells, values } => grid(&WantedLight::Values { cells: *cells, values }),
        TargetKind::Peak => grid(&WantedLight::Peak),
        TargetKind::Flux | TargetKind::Collimation { .. } => Merit::Flux { receiver, emitted },
    })
}

/// The rectangle of a receiver by the middles of four cells of its lux map; `None` if it has another form.
fn frame(scene: &Scene, shape: u32, side: ReceiverSide) -> Result<Option<ReceiverFrame>, OptimizeError> {
    let side = if side == ReceiverSide::Back { side } else { ReceiverSide::Front };
    let request =
        ReceiverRequest { name: String::new(), shape, side, fineness: GridResolution::Cells([2, 2]) };
    let receivers = Receivers::try_new(scene, &[request])?;
    let [receiver] = receivers.as_slice() else { return Ok(None) };
    let &[a, b, c, d] = receiver.positions() else { return Ok(None) };
    let center = 0.25 * (a + b + c + d);
    let half_sides = [b - a, c - a];
    let normal = half_sides[0].cross(half_sides[1]).normalize_or_zero();
    let area = 4.0 * half_sides[0].cross(half_sides[1]).length();
    let covered = receiver.areas().iter().zip(receiver.covered());
    let known: f64 = covered.map(|(area, covered)| area / (1.0 - covered)).sum();
    let is_rectangle = (area - known).abs() <= FLATNESS * area || !known.is_finite();
    let is_flat = (d - b - half_sides[1]).length() <= FLATNESS * half_sides[1].length();
    Ok((is_rectangle && is_flat).then_some(ReceiverFrame { center, half_sides, normal }))
}
