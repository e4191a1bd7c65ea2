//! A plain room with luminaires of one kind on a grid, as planners begin with it.

use std::sync::Arc;

use glanz_light::intensity::IntensityDistribution;
use glanz_math::{DMat3, DMat4, DVec2, DVec3};
use glanz_report::number::significant;
use glanz_report::{FactList, FactValue};
use glanz_scene::Description;
use glanz_scene::description::{
    LightDescription, LightKind, LuminaireDescription, MaterialKind, ReceiverDescription, ReceiverSide,
    ShapeDescription, ZoneKind,
};

use super::emergency::OPEN_AREA_BORDER;
use super::glare::GlareObserver;
use super::luminaire::PlacedLuminaire;
use super::request::{LitZone, PlanningRequest};
use super::requirement::grid_spacing;
use crate::room::walls;

/// Name of the receiver in the work plane.
const WORK_PLANE: &str = "work plane";

/// Least distance of a luminaire from the ceiling, metres: light that it sends upwards meets the ceiling.
const CLEARANCE: f64 = 1e-3;

/// Largest number of luminaires.
const LUMINAIRES_LIMIT: u32 = 10_000;

/// A kind of luminaire, from a photometric file.
#[derive(Clone, Debug)]
pub struct LuminaireKind {
    /// What the file states.
    pub description: Arc<LuminaireDescription>,
    /// Candela by direction in the luminaire's frame.
    pub distribution: Arc<IntensityDistribution>,
}

/// A box-shaped room from the origin to its size, with a work plane and a grid of luminaires.
#[derive(Clone, Debug)]
pub struct RoomPlan {
    /// Length along x, width along y, height, metres.
    pub size: DVec3,
    /// Reflectances of ceiling, walls and floor, each in [0, 1).
    pub reflectances: [f64; 3],
    /// The luminaires.
    pub luminaire: LuminaireKind,
    /// Numbers of luminaires along x and y, evenly spread: half a spacing from the walls.
    pub grid: [u32; 2],
    /// Height of the photometric centres above the floor, metres.
    pub height: f64,
    /// Turn of the luminaires about the vertical from x towards y, radians; at 0 their C0 points along x.
    pub turn: f64,
    /// Height of the work plane above the floor, metres; above 0.
    pub work_plane: f64,
    /// Height of eyes and of cylinders above the floor, metres: [`SEATED_EYE`](super::glare::SEATED_EYE) or
    /// [`STANDING_EYE`](super::glare::STANDING_EYE); below the luminaires.
    pub eye: f64,
    /// Distance of the work plane, and of the points of observers, from the walls, metres.
    pub margin: f64,
}

/// Errors of planning a room.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RoomPlanError {
    /// A length that is not above 0 and finite, or not below the largest allowed one.
    #[error("{what} is {value} m; it must be above {above} and at most {most} m")]
    Length {
        /// The length.
        what: &'static str,
        /// Its value, metres.
        value: f64,
        /// It must be larger.
        above: f64,
        /// It may not be larger.
        most: f64,
    },
    /// A reflectance that is not in [0, 1).
    #[error("the reflectance of the {surface} is {value}; it must be at least 0 and below 1")]
    Reflectance {
        /// The surface.
        surface: &'static str,
        /// Its reflectance.
        value: f64,
    },
    /// No luminaire or too many.
    #[error("a grid of {} x {} luminaires is not possible; there must be from 1 to {LUMINAIRES_LIMIT}", .0[0], .0[1])]
    Grid([u32; 2]),
    /// A distance from the walls that leaves no room.
    #[error("{margin} m along the walls leave nothing of a room of {} x {} m; choose a smaller margin", size.x, size.y)]
    Margin {
        /// The distance, metres.
        margin: f64,
        /// Of the room, metres.
        size: DVec2,
    },
    /// A room of this size, metres, that is too narrow for an open area.
    #[error(
        "a room of {} x {} m has no open area: EN 1838 leaves a border of {OPEN_AREA_BORDER} m out; rate emergency lighting of wider rooms only",
        .0.x, .0.y
    )]
    OpenArea(DVec2),
}

impl RoomPlan {
    /// Checks all lengths and numbers.
    ///
    /// # Errors
    /// [`RoomPlanError`] for the first that is out of range.
    pub fn check(&self) -> Result<(), RoomPlanError> {
        let DVec3 { x, y, z } = self.size;
        let length = |what, value: f64, above, most| {
            let is_valid = value > above && value <= most && value.is_finite();
            if is_valid { Ok(()) } else { Err(RoomPlanError::Length { what, value, above, most }) }
        };
        // Beyond, rooms are mistakes: a kilometre of luminaires.
        for (what, value) in [("the length of the room", x), ("its width", y), ("its height", z)] {
            length(what, value, 0.0, 1000.0)?;
        }
        length("the height of the luminaires", self.height, 0.0, z)?;
        length("the height of the work plane", self.work_plane, 0.0, self.height)?;
        length("the height of the eyes", self.eye, 0.0, self.height)?;
        for (surface, value) in ["ceiling", "walls", "floor"].into_iter().zip(self.reflectances) {
            // As the material has it.
            if !(0.0..1.0).contains(&(value as f32)) {
                return Err(RoomPlanError::Reflectance { surface, value });
            }
        }
        let [nx, ny] = self.grid;
        if nx == 0 || ny == 0 || u64::from(nx) * u64::from(ny) > u64::from(LUMINAIRES_LIMIT) {
            return Err(RoomPlanError::Grid(self.grid));
        }
        if !(self.margin >= 0.0 && 2.0 * self.margin < x.min(y)) {
            return Err(RoomPlanError::Margin { margin: self.margin, size: self.size.truncate() });
        }
        Ok(())
    }

    /// The luminaires, row by row.
    #[must_use]
    pub fn luminaires(&self) -> Vec<PlacedLuminaire> {
        let [nx, ny] = self.grid;
        let height = self.height.min(self.size.z - CLEARANCE.min(0.5 * self.size.z));
        let place =
            |number: u32, count: u32, length: f64| (f64::from(number) + 0.5) * length / f64::from(count);
        let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
        let placed = cells.map(|(i, j)| PlacedLuminaire {
            name: self.luminaire.description.label().to_owned(),
            description: Some(Arc::clone(&self.luminaire.description)),
            distribution: Arc::clone(&self.luminaire.distribution),
            factor: 1.0,
            opening: self.luminaire.description.opening,
            position: DVec3::new(place(i, nx, self.size.x), place(j, ny, self.size.y), height),
            axes: DMat3::from_rotation_z(self.turn),
        });
        placed.collect()
    }

    /// The room as a scene: walls, ceiling, floor and work plane are receivers with the points of EN 12464-1; the light of each luminaire leaves its centre.
    ///
    /// # Errors
    /// [`RoomPlanError`], as [`RoomPlan::check`].
    pub fn description(&self) -> Result<Description, RoomPlanError> {
        self.check()?;
        let mut description = Description::default();
        let [ceiling, wall, floor] = self.reflectances.map(|reflectance| {
            description.materials.push(MaterialKind::diffuse(reflectance as f32).into());
            description.materials.len() - 1
        });
        for (name, corner, u, v) in walls(self.size) {
            let material = match name.as_str() {
                "floor" => floor,
                "ceiling" => ceiling,
                _ => wall,
            };
            // The first direction of a receiver is level.
            let [level, other] = if v.z > 0.0 || u.x != 0.0 { [u, v] } else { [v, u] };
            let cells = points([level, other].map(|side| side.length()));
            let shape = ShapeDescription::parallelogram(corner, u, v);
            description.world.shapes.push(ShapeDescription { material, ..received(shape, name, cells) });
        }
        description.materials.push(MaterialKind::Interface.into());
        let material = description.materials.len() - 1;
        let inner = self.inner();
        let corner = DVec3::new(self.margin, self.margin, self.work_plane);
        let plane = ShapeDescription::parallelogram(corner, DVec3::X * inner.x, DVec3::Y * inner.y);
        let cells = points(inner.to_array());
        let plane = received(plane, WORK_PLANE.to_owned(), cells);
        description.world.shapes.push(ShapeDescription { material, ..plane });
        for luminaire in self.luminaires() {
            let kind = LightKind::Photometric {
                distribution: luminaire.distribution,
                opening: None,
                from: DVec3::ZERO,
            };
            let to_world = DMat4::from_translation(luminaire.position) * DMat4::from_mat3(luminaire.axes);
            let light = LightDescription::new(kind, 1.0);
            description.lights.push(LightDescription { to_world, luminaire: luminaire.description, ..light });
        }
        Ok(description)
    }

    /// What is to be rated: the work plane is the task area; walls and ceiling; observers who look along both axes from the points of a grid.
    #[must_use]
    pub fn request(&self) -> PlanningRequest {
        let zone = |name: String| {
            let kind = zone_kind(&name)?;
            Some(LitZone { receivers: vec![name.clone()], name, kind })
        };
        let names = walls(self.size).map(|(name, ..)| name);
        let zones = std::iter::once(WORK_PLANE.to_owned()).chain(names).filter_map(zone);
        let eyes = self.points_at(self.eye, self.margin);
        let views = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y];
        let observers =
            eyes.iter().flat_map(|&eye| views.iter().map(move |&view| GlareObserver::try_new(eye, view)));
        PlanningRequest {
            zones: zones.collect(),
            luminaires: self.luminaires(),
            observers: observers.filter_map(Result::ok).collect(),
            points: eyes,
            open_area: Vec::new(),
            watts: f64::from(self.grid[0]) * f64::from(self.grid[1]) * self.luminaire.description.watts,
            area: self.size.x * self.size.y,
            assumptions: self.assumptions(),
        }
    }

    /// The plan in words.
    fn assumptions(&self) -> FactList {
        let mut facts = FactList::default();
        let LuminaireDescription { maker, .. } = &*self.luminaire.description;
        let [nx, ny] = self.grid;
        facts.push("room", "room_m", FactValue::Lengths(self.size.to_array()));
        let [ceiling, walls, floor] = self.reflectances;
        let reflectances = format!("{ceiling} / {walls} / {floor}");
        facts.push("reflectances of ceiling / walls / floor", "reflectances", reflectances);
        facts.push("luminaire", "luminaire", self.luminaire.description.label());
        if !maker.is_empty() {
            facts.push("its maker", "maker", maker.clone());
        }
        facts.push("flux of one luminaire, lm", "luminaire_flux_lm", self.luminaire.distribution.flux());
        facts.push("grid along x and y", "grid", format!("{nx} x {ny}"));
        let [dx, dy] = [self.size.x / f64::from(nx), self.size.y / f64::from(ny)].map(significant);
        facts.push("spacing along x and y, m", "spacing_m", format!("{dx} x {dy}"));
        facts.push("height of the photometric centres, m", "mounting_height_m", self.height);
        facts.push("C0 of the luminaires from x towards y, degrees", "turn_degrees", self.turn.to_degrees());
        facts.push("height of the work plane, m", "work_plane_m", self.work_plane);
        facts.push("distance from the walls that does not count, m", "margin_m", self.margin);
        facts.push("height of eyes and of cylinders, m", "eye_m", self.eye);
        facts
    }

    /// Size of the room without its margins, metres.
    fn inner(&self) -> DVec2 {
        self.size.truncate() - 2.0 * self.margin
    }

    /// Points of the open area of emergency lighting, metres: on the floor, without the border that EN 1838 leaves out.
    ///
    /// # Errors
    /// [`RoomPlanError::OpenArea`] if the border is the whole room.
    pub fn open_area(&self) -> Result<Vec<DVec3>, RoomPlanError> {
        let size = self.size.truncate();
        if size.min_element() <= 2.0 * OPEN_AREA_BORDER {
            return Err(RoomPlanError::OpenArea(size));
        }
        Ok(self.points_at(0.0, OPEN_AREA_BORDER))
    }

    /// The points of a grid of EN 12464-1, middles of equal cells, at this height above the floor and without a margin along the walls, metres.
    fn points_at(&self, height: f64, margin: f64) -> Vec<DVec3> {
        let inner = self.size.truncate() - 2.0 * margin;
        let [nx, ny] = points(inner.to_array());
        let place =
            |number: u32, count: u32, side: f64| margin + (f64::from(number) + 0.5) * side / f64::from(count);
        let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
        cells.map(|(i, j)| DVec3::new(place(i, nx, inner.x), place(j, ny, inner.y), height)).collect()
    }
}

/// The zone that a receiver of the room is.
fn zone_kind(receiver: &str) -> Option<ZoneKind> {
    match receiver {
        WORK_PLANE => Some(ZoneKind::Task),
        "ceiling" => Some(ZoneKind::Ceiling),
        "floor" => None,
        _ => Some(ZoneKind::Wall),
    }
}

/// Numbers of points along both sides of an area, metres.
fn points(sides: [f64; 2]) -> [u32; 2] {
    let spacing = grid_spacing(sides);
    // A quotient that is whole but for rounding needs no further point.
    sides.map(|side| ((side / spacing - 1e-9).ceil() as u32).max(1))
}

/// The shape as a receiver with these cells.
fn received(shape: ShapeDescription, name: String, cells: [u32; 2]) -> ShapeDescription {
    let (side, zone) = (ReceiverSide::Front, zone_kind(&name));
    let receiver = ReceiverDescription { name, cells: Some(cells), side, zone, location: None };
    ShapeDescription { receiver: Some(receiver), ..shape }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::test_luminaires::uniform;
    use crate::{GridResolution, ReceiverRequest, Receivers};
    use glanz_light::intensity::{LuminousOpening, OpeningShape};
    use glanz_scene::Scene;

    pub(crate) fn plan() -> RoomPlan {
        RoomPlan {
            size: DVec3::new(6.0, 4.0, 3.0),
            reflectances: [0.7, 0.5, 0.2],
            luminaire: LuminaireKind {
                description: Arc::new(LuminaireDescription {
                    name: "panel".to_owned(),
                    opening: LuminousOpening { shape: OpeningShape::Rectangle, size: [0.6, 0.6, 0.0] },
                    watts: 30.0,
                    ..LuminaireDescription::default()
                }),
                distribution: uniform(100.0),
            },
            grid: [3, 2],
            height: 3.0,
            turn: 0.0,
            work_plane: 0.75,
            eye: 1.2,
            margin: 0.5,
        }
    }

    #[test]
    fn room_has_its_luminaires_and_receivers_with_the_points_of_the_standard() {
        let plan = plan();
        let positions: Vec<DVec3> = plan.luminaires().iter().map(|luminaire| luminaire.position).collect();
        let expected = [1.0, 3.0].into_iter().flat_map(|y| [1.0, 3.0, 5.0].map(|x| DVec3::new(x, y, 2.999)));
        assert_eq!(positions.len(), 6);
        for (position, expected) in positions.iter().zip(expected) {
            assert!(position.distance(expected) < 1e-12, "{position}");
        }
        let (scene, warnings) = Scene::resolve(plan.description().unwrap()).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        let requests = ReceiverRequest::of_scene(&scene, GridResolution::Longer(1));
        let receivers = Receivers::try_new(&scene, &requests).unwrap();
        let cells: Vec<(&str, [u32; 2])> =
            receivers.as_slice().iter().map(|receiver| (receiver.name(), receiver.cells())).collect();
        // p = 0.2 * 5^lg d: 0.700 m for 6 m, 0.527 m for 4 m, 0.616 m for 5 m; walls of 6 m x 3 m count by their height: 0.431 m.
        assert_eq!(
            cells,
            [
                ("floor", [9, 6]),
                ("ceiling", [9, 6]),
                ("wall x=0", [8, 6]),
                ("wall x=6", [8, 6]),
                ("wall y=0", [14, 7]),
                ("wall y=4", [14, 7]),
                ("work plane", [9, 5]),
            ]
        );
        // The cells are about square: the first direction of walls is level.
        for receiver in receivers.as_slice() {
            let [u, v] = [0, 1].map(|i| receiver.size()[i] / f64::from(receiver.cells()[i]));
            assert!((u / v).ln().abs() < 0.35, "{}: {u} {v}", receiver.name());
        }
        let request = plan.request();
        assert_eq!((request.points.len(), request.observers.len(), request.zones.len()), (45, 180, 6));
        assert_eq!((request.watts, request.area), (180.0, 24.0));
    }

    #[test]
    fn corridors_have_points_by_their_width_and_open_areas_a_fixed_border() {
        assert_eq!(points([19.0, 1.0]), [95, 5]);
        let mut plan = plan();
        plan.margin = 0.0;
        let points = plan.open_area().unwrap();
        // 5 m x 3 m at 0.616 m.
        assert_eq!(points.len(), 9 * 5);
        assert!((points[0] - DVec3::new(0.5 + 2.5 / 9.0, 0.8, 0.0)).length() < 1e-12, "{}", points[0]);
        plan.size.y = 1.0;
        let error = plan.open_area().unwrap_err().to_string();
        assert!(error.starts_with("a room of 6 x 1 m has no open area"), "{error}");
    }

    #[test]
    fn faults_of_a_plan_are_reported_with_their_values() {
        let text = |change: fn(&mut RoomPlan)| {
            let mut plan = plan();
            change(&mut plan);
            plan.description().unwrap_err().to_string()
        };
        for (fault, start) in [
            (text(|plan| plan.size.y = 0.0), "its width is 0 m"),
            (
                text(|plan| plan.height = 3.1),
                "the height of the luminaires is 3.1 m; it must be above 0 and at most 3 m",
            ),
            (text(|plan| plan.work_plane = 3.1), "the height of the work plane is 3.1 m"),
            (text(|plan| plan.eye = 0.0), "the height of the eyes is 0 m"),
            (text(|plan| plan.reflectances[1] = 1.0), "the reflectance of the walls is 1;"),
            (
                text(|plan| plan.reflectances[0] = 1.0 - 1e-9),
                "the reflectance of the ceiling is 0.999999999;",
            ),
            (text(|plan| plan.reflectances[2] = f64::NAN), "the reflectance of the floor is NaN;"),
            (text(|plan| plan.grid = [0, 2]), "a grid of 0 x 2 luminaires"),
            (text(|plan| plan.grid = [1 << 16, 1 << 16]), "a grid of 65536 x 65536 luminaires"),
            (text(|plan| plan.margin = 2.0), "2 m along the walls leave nothing of a room of 6 x 4 m"),
        ] {
            assert!(fault.starts_with(start), "{fault}");
        }
    }
}
