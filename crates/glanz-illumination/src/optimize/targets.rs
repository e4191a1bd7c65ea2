//! The merits of the targets of a description.

use glanz_math::{DVec2, DVec3};
use glanz_scene::description::{ReceiverSide, TargetDescription, TargetKind};
use glanz_scene::{Description, PlacedSurface, Scene};

use super::error::OptimizeError;
use super::landing_grid::{LandingGrid, WantedLight};
use super::merit::{Merit, ReceiverFrame};
use super::ray_sources::first_of_world;
use crate::receiver::{GridResolution, Receiver, ReceiverRequest, Receivers};

/// Cells along the longer side of a target without cells of its own.
const CELLS: u32 = 16;
/// Most cells along a side of a target: there are 16 times as many with those around it, and sums of each for every chunk of rays.
const MAX_CELLS: u32 = 64;
/// Largest relative difference between the area of a receiver and that of its rectangle.
const FLATNESS: f64 = 1e-6;
/// Points along each side of a covered cell.
const POINTS: u32 = 16;

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
    let [across, up] = half_sides.map(DVec3::length);
    let placed = scene.placed_surfaces();
    let Some(surface) = placed.get(receiver.surface() as usize) else { return Ok(None) };
    let Some(middle) = receiver.place(surface, 0, DVec2::splat(0.5)) else { return Ok(None) };
    let normal = half_sides[0].cross(half_sides[1]).normalize_or_zero();
    // Parameters may turn either way about the normal.
    let normal = if normal.dot(middle.normal) < 0.0 { -normal } else { normal };
    let areas = receiver.areas().iter().zip(receiver.covered()).enumerate();
    let areas = areas.map(|(cell, (area, covered))| match 1.0 - covered {
        visible if visible > 0.0 => area / visible,
        _ => whole_area(receiver, surface, cell),
    });
    let area = 4.0 * across * up;
    let is_rectangle = (area - areas.sum::<f64>()).abs() <= FLATNESS * area
        && half_sides[0].dot(half_sides[1]).abs() <= FLATNESS * across * up;
    let is_flat = (d - b - half_sides[1]).length() <= FLATNESS * up;
    Ok((is_rectangle && is_flat).then_some(ReceiverFrame { center, half_sides, normal }))
}

/// The area of a cell that is covered, by a grid of points, m^2.
fn whole_area(receiver: &Receiver, surface: &PlacedSurface<'_>, cell: usize) -> f64 {
    let points = (0..POINTS * POINTS).map(|k| DVec2::new(f64::from(k % POINTS), f64::from(k / POINTS)) + 0.5);
    let areas = points.map(|at| receiver.place(surface, cell, at / f64::from(POINTS)));
    areas.flatten().map(|point| point.area_element).sum::<f64>() / f64::from(POINTS * POINTS)
}
