//! The room of a design from above: outlines, surfaces, areas of measurement, luminaires.

use std::collections::{HashMap, HashSet};

use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::{Bounds3, DVec2, DVec3};
use glanz_scene::description::ZoneKind;
use glanz_scene::{Light, PlacedSurface, Scene};
use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::luminaire::PlacedLuminaire;
use super::luminaire_list::{LuminaireGroup, OtherLight, sky_kind};
use super::plan_outline::{NEAR, ShapeOutline};
use super::room_shapes::{RoomShape, joint_outlines, uncovered};
use super::room_walls::{WallEnds, inner_walls, tall_faces, walls};
use crate::{Receiver, Receivers};

/// Cosine from which on a receiver faces up.
const UPWARDS: f64 = 0.999;

/// Largest number of outlines of furniture; the smallest are left out.
const MOST_FURNITURE: usize = 400;

/// A part of the border of a room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RoomSurfaceKind {
    /// The floor.
    Floor,
    /// All walls.
    Walls,
    /// The ceiling.
    Ceiling,
}

impl RoomSurfaceKind {
    /// Name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Floor => "floor",
            Self::Walls => "walls",
            Self::Ceiling => "ceiling",
        }
    }
}

/// Floor, walls, or ceiling.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct RoomSurface {
    /// Which of them.
    pub surface: RoomSurfaceKind,
    /// Area, m^2.
    #[serde(rename = "area_m2")]
    pub area: f64,
    /// Luminous reflectance at right angles, the mean over the area of the parts where it is known; `None` if it is known of none.
    pub reflectance: Option<f64>,
    /// Least and largest reflectance of its parts.
    pub reflectance_range: Option<[f64; 2]>,
}

/// A receiver in the room.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceiverPlace {
    /// Its number, that of its map.
    pub number: usize,
    /// Its name, that of its map, which another may have, too.
    pub name: String,
    /// The part of a planned room that it is, if it is declared.
    pub kind: Option<ZoneKind>,
    /// Whether it is flat, level and faces up.
    pub is_level: bool,
    /// Whether its cells are rows and columns; those of a curved mesh are its triangles.
    pub is_grid: bool,
    /// The lower left corner of its grid, metres, and the unit directions of rows and of columns, if it is flat and not trimmed.
    pub frame: Option<[DVec3; 3]>,
    /// Height of its middle, metres.
    pub height: f64,
    /// Its outline from above, metres.
    pub outline: Vec<DVec2>,
}

/// A room from above.
///
/// z is up. Floor and ceiling are the level shapes at the lowest and the highest point, without what only lies on them and without tops and undersides of walls that are boxes or meshes (each face of a solid of a
/// STEP or IGES file is a shape of its own, so that those of its walls belong to floor, ceiling or furniture); walls are upright flat shapes nearly as high as the room at the border of floor, ceiling or the box around the room, of whose two faces up to 0.6 m apart only the one with floor in front of it counts if the other has none; all other
/// shapes are furniture, which is represented by convex outlines. Surfaces that emit light belong to none of these, unless there are no others. A scene without finite shapes has the box of its receivers, luminaires and lights.
#[derive(Clone, Debug, PartialEq)]
pub struct RoomLayout {
    /// Lowest and highest corner of the box around it, metres.
    pub corners: [DVec3; 2],
    /// Outlines of the whole floor, metres.
    pub floor: Vec<Vec<DVec2>>,
    /// Outlines of walls, metres; those of two points are lines.
    pub walls: Vec<Vec<DVec2>>,
    /// Outlines of furniture, metres.
    pub furniture: Vec<Vec<DVec2>>,
    /// Number of pieces of furniture without an outline, which are the smallest.
    pub furniture_left_out: usize,
    /// Floor, walls, and ceiling, as far as there are any.
    pub surfaces: Vec<RoomSurface>,
    /// Receivers in the order of their maps.
    pub receivers: Vec<ReceiverPlace>,
    /// Luminaires of photometric files by kind.
    pub luminaires: Vec<LuminaireGroup>,
    /// All other lights.
    pub other_lights: Vec<OtherLight>,
}

impl RoomLayout {
    /// The layout of a scene; `None` if it has neither finite shapes nor things with a place.
    #[must_use]
    pub fn of(scene: &Scene, receivers: &Receivers, luminaires: &[PlacedLuminaire]) -> Option<Self> {
        let placed = scene.placed_surfaces();
        let (emitting, passive): (Vec<_>, Vec<_>) =
            RoomShape::all(&placed).into_iter().partition(|shape| shape.surface.light().is_some());
        let shapes = if passive.is_empty() { emitting } else { passive };
        let mut bounds = Bounds3::EMPTY;
        for RoomShape { outline, .. } in &shapes {
            let [low, high] = outline.height;
            for point in &outline.outline {
                bounds = bounds.including(point.extend(low)).including(point.extend(high));
            }
        }
        let mut layout = Self {
            corners: [bounds.min, bounds.max],
            floor: Vec::new(),
            walls: Vec::new(),
            furniture: Vec::new(),
            furniture_left_out: 0,
            surfaces: Vec::new(),
            receivers: receiver_places(scene, receivers, &placed),
            luminaires: LuminaireGroup::of(luminaires),
            other_lights: other_lights(scene, &placed),
        };
        if bounds.is_empty() {
            bounds = layout.placed_points().fold(bounds, Bounds3::including);
        }
        if bounds.is_empty() || !bounds.is_finite() || (bounds.max - bounds.min).truncate() == DVec2::ZERO {
            return None;
        }
        layout.corners = [bounds.min, bounds.max];
        layout.sort_shapes(scene, &shapes);
        Some(layout)
    }

    /// Points of receivers, luminaires and lights, metres.
    fn placed_points(&self) -> impl Iterator<Item = DVec3> {
        let receivers = self
            .receivers
            .iter()
            .flat_map(|place| place.outline.iter().map(|point| point.extend(place.height)));
        let luminaires = self.luminaires.iter().flat_map(|group| &group.places).flat_map(|place| {
            let opening = place.outline.iter().map(|point| point.extend(place.position.z));
            opening.chain([place.position])
        });
        let lights = self.other_lights.iter().filter_map(|light| Some((light, DVec3::from(light.position?))));
        let lights = lights.flat_map(|(light, middle)| {
            light.outline.iter().map(move |point| point.extend(middle.z)).chain([middle])
        });
        receivers.chain(luminaires).chain(lights)
    }

    /// Lower left and upper right corner of all that a plan shows, metres.
    #[must_use]
    pub fn plan_corners(&self) -> [DVec2; 2] {
        let [low, high] = self.corners.map(DVec3::truncate);
        let points = self.placed_points().map(DVec3::truncate);
        points.fold([low, high], |[low, high], p| [low.min(p), high.max(p)])
    }

    /// Adds walls, furniture and surfaces.
    fn sort_shapes(&mut self, scene: &Scene, shapes: &[RoomShape<'_>]) {
        let [low, high] = self.corners;
        let (size, near) = (high - low, NEAR * (high - low).length());
        let tall = tall_faces(shapes, size);
        let ends = WallEnds::of(&tall, [low, high]);
        let parts = |height: f64| -> Vec<&RoomShape<'_>> {
            let is_part = |shape: &&RoomShape<'_>| {
                shape.outline.is_level(near) && (shape.outline.height[0] - height).abs() <= near
            };
            let at_height = shapes.iter().filter(is_part);
            uncovered(at_height.filter(|shape| !ends.contains(shape)).collect())
        };
        // A flat scene has neither walls nor a ceiling.
        let [floor, ceiling] =
            if size.z > near { [parts(low.z), parts(high.z)] } else { [parts(low.z), Vec::new()] };
        let floor_outlines = joint_outlines(&floor);
        let mut border = [floor_outlines.clone(), joint_outlines(&ceiling)].concat();
        border.push(
            [[low.x, low.y], [high.x, low.y], [high.x, high.y], [low.x, high.y]].map(DVec2::from).into(),
        );
        let walls = walls(tall, &border, size);
        let ends = WallEnds::of(&walls, [low, high]);
        let is_end = |shape: &RoomShape<'_>| shape.outline.is_level(near) && ends.contains(shape);
        let of_room = [&floor, &ceiling, &walls].into_iter().flatten();
        let of_room: HashSet<*const RoomShape<'_>> =
            of_room.map(|shape| std::ptr::from_ref(*shape)).collect();
        let mut others: Vec<&RoomShape<'_>> = shapes
            .iter()
            .filter(|shape| !of_room.contains(&std::ptr::from_ref(*shape)) && !is_end(shape))
            .filter(|shape| shape.surface.light().is_none() && shape.outline.outline.len() > 1)
            .collect();
        others.sort_by(|a, b| b.outline.length().total_cmp(&a.outline.length()));
        self.furniture_left_out = others.len().saturating_sub(MOST_FURNITURE);
        others.truncate(MOST_FURNITURE);
        self.furniture = others.iter().map(|shape| shape.outline.outline.clone()).collect();
        self.floor = floor_outlines;
        self.walls = walls.iter().map(|shape| shape.outline.outline.clone()).collect();
        let middle = 0.5 * (low + high);
        let on_floor = floor.iter().flat_map(|part| part.polygons()).collect();
        let walls = inner_walls(walls, on_floor, middle.truncate(), size);
        let kinds = [RoomSurfaceKind::Floor, RoomSurfaceKind::Walls, RoomSurfaceKind::Ceiling];
        let summed = kinds.into_iter().zip([&floor, &walls, &ceiling]);
        self.surfaces = summed.filter_map(|(kind, list)| room_surface(scene, kind, list, middle)).collect();
    }

    /// Size along x, y and z, metres.
    #[must_use]
    pub fn size(&self) -> DVec3 {
        self.corners[1] - self.corners[0]
    }

    /// Floor area, m^2; that of the box from above if there is no floor, 0 if there are no finite shapes at all.
    #[must_use]
    pub fn floor_area(&self) -> f64 {
        let floor = self.surfaces.iter().find(|part| part.surface == RoomSurfaceKind::Floor);
        let outlines = [&self.floor, &self.walls, &self.furniture];
        if floor.is_none() && outlines.into_iter().all(Vec::is_empty) {
            return 0.0;
        }
        floor.map_or_else(|| self.size().truncate().element_product(), |floor| floor.area)
    }

    /// Electric power of all luminaires, watts; `None` if the power of one is unknown, there is none, or there are lights of other kinds, whose power is unknown.
    #[must_use]
    pub fn watts(&self) -> Option<f64> {
        let known = self.electric_lights().next().is_none()
            && self.luminaires.iter().all(|group| group.description.watts > 0.0);
        let watts = self.luminaires.iter().map(|group| group.places.len() as f64 * group.description.watts);
        (known && !self.luminaires.is_empty()).then(|| watts.sum())
    }

    /// Lights without a photometric file that draw power: not those of the sky.
    pub(crate) fn electric_lights(&self) -> impl Iterator<Item = &OtherLight> {
        self.other_lights.iter().filter(|light| light.is_electric())
    }

    /// The place of the receiver with this number.
    #[must_use]
    pub fn receiver(&self, number: usize) -> Option<&ReceiverPlace> {
        let place = self.receivers.binary_search_by_key(&number, |place| place.number).ok()?;
        self.receivers.get(place)
    }
}

/// Area and reflectance of parts of a room; `None` without parts.
fn room_surface(
    scene: &Scene,
    surface: RoomSurfaceKind,
    parts: &[&RoomShape<'_>],
    middle: DVec3,
) -> Option<RoomSurface> {
    let (mut area, mut known, mut sum) = (0.0, 0.0, 0.0);
    let mut range: Option<[f64; 2]> = None;
    for part in parts {
        let part_area = part.area();
        area += part_area;
        let Some(own) = part.reflectance(scene, middle) else { continue };
        (known, sum) = (known + part_area, sum + part_area * own);
        range = Some(range.map_or([own; 2], |[low, high]| [low.min(own), high.max(own)]));
    }
    let reflectance = (known > 0.0).then(|| sum / known);
    (area > 0.0).then_some(RoomSurface { surface, area, reflectance, reflectance_range: range })
}

/// The receivers in the room.
fn receiver_places(scene: &Scene, receivers: &Receivers, placed: &[PlacedSurface<'_>]) -> Vec<ReceiverPlace> {
    let kinds: HashMap<u32, Option<ZoneKind>> =
        scene.receivers().iter().rev().map(|declared| (declared.shape(), declared.zone())).collect();
    let place = |(number, receiver): (usize, &Receiver)| {
        let surface = placed.get(receiver.surface() as usize)?;
        let faces: Vec<u32> = match receiver.face() {
            Some(face) => vec![face],
            None => (0..surface.faces()).filter(|face| surface.shape(*face) == receiver.shape()).collect(),
        };
        let outline = ShapeOutline::of(surface, &faces)?;
        let frame = receiver.flat_frame();
        // Seen from the counted side, columns go up from rows that go to the right.
        let normal = frame.map(|[_, across, up]| across.cross(up)).or_else(|| {
            let middle = |cell| receiver.place(surface, cell, DVec2::splat(0.5));
            Some((0..receiver.len()).find_map(middle)?.normal)
        });
        Some(ReceiverPlace {
            number,
            name: receiver.name().to_owned(),
            kind: kinds.get(&receiver.shape()).copied().flatten(),
            is_level: outline.is_level(NEAR * outline.length())
                && normal.is_some_and(|normal| normal.z > UPWARDS),
            is_grid: receiver.is_grid(),
            frame,
            height: outline.middle.z,
            outline: outline.outline,
        })
    };
    receivers.as_slice().iter().enumerate().filter_map(place).collect()
}

/// All lights that are no luminaires of photometric files.
fn other_lights(scene: &Scene, placed: &[PlacedSurface<'_>]) -> Vec<OtherLight> {
    let wavelengths = Wavelengths::default();
    let emitting: HashMap<u32, &PlacedSurface<'_>> =
        placed.iter().rev().filter_map(|surface| Some((surface.light()?.0, surface))).collect();
    let lumens = |power| Some(photometric(power, &wavelengths)).filter(|flux| *flux > 0.0);
    let at = |kind, flux, position: DVec3| OtherLight {
        kind,
        flux,
        position: Some(position.to_array()),
        outline: Vec::new(),
    };
    let light = |(number, light): (u32, &Light)| match light {
        Light::Photometric(_) => None,
        Light::Point(l) => Some(at("point", lumens(l.power()), l.position())),
        Light::Spot(l) => Some(at("spot light", lumens(l.power()), l.position())),
        Light::Projection(l) => Some(at("projector", lumens(l.power()), l.position())),
        Light::Goniometric(l) => Some(at("point with a picture", lumens(l.power()), l.position())),
        Light::Rays(l) => Some(at("ray file", lumens(l.power()), l.position())),
        Light::Area(l) => {
            let (kind, flux) = ("emitting surface", lumens(l.power()));
            let outline = emitting
                .get(&number)
                .and_then(|surface| ShapeOutline::of(surface, &(0..surface.faces()).collect::<Vec<_>>()));
            Some(match outline {
                Some(outline) => OtherLight { outline: outline.outline, ..at(kind, flux, outline.middle) },
                None => OtherLight { kind, flux, position: None, outline: Vec::new() },
            })
        }
        _ => {
            let kind = sky_kind(light)?;
            Some(OtherLight { kind, flux: None, position: None, outline: Vec::new() })
        }
    };
    (0..).zip(scene.lights()).filter_map(light).collect()
}

/// In JSON: size and corner of the room, its floor area, its surfaces, outlines of floor, walls and furniture, and the level receivers. Luminaires and lights have entries of their own.
impl Serialize for RoomLayout {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(serde::Serialize)]
        struct AreaEntry<'a> {
            receiver: &'a str,
            zone: Option<&'static str>,
            height_m: f64,
            outline_m: Vec<[f64; 2]>,
        }
        let flat = |outline: &Vec<DVec2>| outline.iter().map(|point| point.to_array()).collect::<Vec<_>>();
        let areas = self.receivers.iter().filter(|place| place.is_level).map(|place| AreaEntry {
            receiver: &place.name,
            zone: place.kind.map(ZoneKind::name),
            height_m: place.height,
            outline_m: flat(&place.outline),
        });
        let mut fields = serializer.serialize_struct("Room", 8)?;
        fields.serialize_field("size_m", &self.size().to_array())?;
        fields.serialize_field("corner_m", &self.corners[0].to_array())?;
        fields.serialize_field("floor_area_m2", &self.floor_area())?;
        fields.serialize_field("surfaces", &self.surfaces)?;
        fields.serialize_field("floor_m", &self.floor.iter().map(flat).collect::<Vec<_>>())?;
        fields.serialize_field("walls_m", &self.walls.iter().map(flat).collect::<Vec<_>>())?;
        fields.serialize_field("furniture_m", &self.furniture.iter().map(flat).collect::<Vec<_>>())?;
        fields.serialize_field("areas", &areas.collect::<Vec<_>>())?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GridResolution, ReceiverRequest, add_walls};
    use glanz_scene::description::{LightDescription, MaterialKind, ShapeDescription};
    use glanz_scene::{Scene, SceneBuilder};

    fn layout(
        builder: SceneBuilder,
        change: impl FnOnce(&mut glanz_scene::Description),
    ) -> Option<RoomLayout> {
        let mut description = builder.describe().unwrap();
        change(&mut description);
        let luminaires = PlacedLuminaire::of_scene(&description);
        let (scene, _) = Scene::resolve(description).unwrap();
        let requests = ReceiverRequest::of_scene(&scene, GridResolution::Longer(4));
        let receivers = Receivers::try_new(&scene, &requests).unwrap();
        RoomLayout::of(&scene, &receivers, &luminaires)
    }

    fn named<'a>(room: &'a RoomLayout, name: &str) -> &'a ReceiverPlace {
        let place = room.receivers.iter().find(|place| place.name == name).unwrap();
        assert_eq!(room.receiver(place.number), Some(place));
        place
    }

    fn surface(room: &RoomLayout, kind: RoomSurfaceKind) -> RoomSurface {
        *room.surfaces.iter().find(|part| part.surface == kind).unwrap()
    }

    fn quad(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> ShapeDescription {
        ShapeDescription::parallelogram(corner, u, v)
    }

    fn lamp() -> SceneBuilder {
        SceneBuilder::new().light(LightDescription::point([1.0, 1.0, 2.0], 1.0))
    }

    #[test]
    fn rooms_have_walls_furniture_and_the_mean_reflectance_of_their_surfaces() {
        let grey = |reflectance: f32| MaterialKind::diffuse(reflectance);
        let builder = lamp()
            // 4 m x 3 m x 2.5 m; a third of the floor is darker, and one wall, whose normal points out.
            .shape(quad([0.0; 3], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]), grey(0.4))
            .shape(quad([0.0, 2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 1.0, 0.0]), grey(0.1))
            .shape(quad([0.0, 0.0, 2.5], [0.0, 3.0, 0.0], [4.0, 0.0, 0.0]), grey(0.8))
            .shape(quad([0.0; 3], [0.0, 0.0, 2.5], [4.0, 0.0, 0.0]), grey(0.2))
            .shape(quad([0.0, 3.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 2.5]), grey(0.5))
            .shape(ShapeDescription::cuboid([1.0, 1.0, 0.7], [2.0, 1.5, 0.75]), grey(0.3))
            .shape(
                quad([0.5, 0.5, 0.8], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0]).receiver("desk"),
                MaterialKind::Interface,
            );
        let room = layout(builder, |_| ()).unwrap();
        assert_eq!(room.size().to_array(), [4.0, 3.0, 2.5]);
        // The two parts of the floor are one; two walls.
        assert_eq!((room.floor.len(), room.walls.len()), (1, 2));
        assert!((room.floor_area() - 12.0).abs() < 1e-9);
        // (8 * 0.4 + 4 * 0.1) / 12 = 0.3; (10 * 0.2 + 10 * 0.5) / 20 = 0.35.
        for (kind, area, mean, range) in [
            (RoomSurfaceKind::Floor, 12.0, 0.3, [0.1, 0.4]),
            (RoomSurfaceKind::Walls, 20.0, 0.35, [0.2, 0.5]),
            (RoomSurfaceKind::Ceiling, 12.0, 0.8, [0.8, 0.8]),
        ] {
            let found = surface(&room, kind);
            assert!((found.area - area).abs() < 1e-9, "{found:?}");
            assert!((found.reflectance.unwrap() - mean).abs() < 1e-6, "{found:?}");
            let ends = found.reflectance_range.unwrap().into_iter().zip(range);
            assert!(ends.into_iter().all(|(end, expected)| (end - expected).abs() < 1e-6), "{found:?}");
        }
        // The six sides of the table.
        assert_eq!(room.furniture.len(), 6);
        let desk = named(&room, "desk");
        assert!(desk.is_level && desk.kind.is_none() && desk.is_grid);
        let [corner, across, up] = desk.frame.unwrap();
        assert!(corner.distance(DVec3::new(0.5, 0.5, 0.8)) < 1e-12);
        assert!(across.distance(DVec3::X) < 1e-12 && up.distance(DVec3::Y) < 1e-12);
        assert!((desk.height - 0.8).abs() < 1e-12);
        let [light] = room.other_lights.as_slice() else { panic!("one light") };
        // 4 pi sr of 683 lm/W.
        assert_eq!(light.position, Some([1.0, 1.0, 2.0]));
        assert!((light.flux.unwrap() / (683.0 * 4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-5);
        assert_eq!(room.watts(), None);
    }

    #[test]
    fn rooms_of_receivers_face_up_and_down() {
        let room = layout(lamp(), |description| add_walls(description, DVec3::new(5.0, 4.0, 3.0))).unwrap();
        let level: Vec<&str> =
            room.receivers.iter().filter(|place| place.is_level).map(|place| place.name.as_str()).collect();
        assert_eq!((level, room.receivers.len(), room.walls.len()), (vec!["floor"], 6, 4));
        assert!(room.surfaces.iter().all(|part| part.reflectance == Some(0.0)) && room.furniture.is_empty());
        let json = serde_json::to_value(&room).unwrap();
        assert_eq!(json["size_m"], serde_json::json!([5.0, 4.0, 3.0]));
        assert!((json["floor_area_m2"].as_f64().unwrap() - 20.0).abs() < 1e-9);
        assert_eq!(json["areas"][0]["receiver"], "floor");
    }

    #[test]
    fn a_scene_without_finite_shapes_has_the_box_of_its_things() {
        let plane = || lamp().shape(ShapeDescription::plane(), MaterialKind::diffuse(0.5));
        assert_eq!(layout(plane(), |_| ()), None);
        let field = ShapeDescription::parallelogram([-3.0, 0.0, 0.1], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        let field = layout(plane().shape(field.receiver("field"), MaterialKind::Interface), |_| ()).unwrap();
        assert_eq!(field.corners, [DVec3::new(-3.0, 0.0, 0.1), DVec3::new(1.0, 2.0, 2.0)]);
        // There is no floor to which a power could refer.
        assert!(field.floor.is_empty() && field.walls.is_empty() && field.floor_area() == 0.0);
    }

    #[test]
    fn plans_show_what_is_beyond_the_walls() {
        let lamp = SceneBuilder::new().light(LightDescription::point([9.0, -1.0, 2.0], 1.0));
        let room = layout(lamp, |description| add_walls(description, DVec3::new(5.0, 4.0, 3.0))).unwrap();
        assert_eq!(room.size(), DVec3::new(5.0, 4.0, 3.0));
        assert_eq!(room.plan_corners(), [DVec2::new(0.0, -1.0), DVec2::new(9.0, 4.0)]);
    }

    #[test]
    fn turned_receivers_and_facets_have_their_own_frames() {
        // A desk at 30 degrees; the six facets of a box.
        let (sin, cos) = 30.0_f64.to_radians().sin_cos();
        let desk = ShapeDescription::parallelogram(
            [1.0, 1.0, 0.7],
            [1.6 * cos, 1.6 * sin, 0.0],
            [-0.8 * sin, 0.8 * cos, 0.0],
        );
        let cuboid = ShapeDescription::cuboid([3.0, 3.0, 0.0], [4.0, 5.0, 1.0]);
        let builder = lamp()
            .shape(desk.receiver("desk"), MaterialKind::diffuse(0.5))
            .shape(cuboid.receiver("box"), MaterialKind::diffuse(0.5));
        let room = layout(builder, |_| ()).unwrap();
        let [corner, across, up] = named(&room, "desk").frame.unwrap();
        assert!(corner.distance(DVec3::new(1.0, 1.0, 0.7)) < 1e-12 && named(&room, "desk").is_level);
        assert!(across.distance(DVec3::new(cos, sin, 0.0)) < 1e-12, "{across}");
        assert!(up.distance(DVec3::new(-sin, cos, 0.0)) < 1e-12, "{up}");
        let facets = || room.receivers.iter().filter(|place| place.name.starts_with("box"));
        let upright = facets().filter(|place| place.outline.len() == 2).count();
        assert_eq!((facets().count(), upright, facets().filter(|place| place.is_level).count()), (6, 4, 1));
        assert_eq!(facets().find(|place| place.is_level).unwrap().height, 1.0);
    }

    #[test]
    fn floors_have_all_of_their_parts_and_nothing_that_lies_on_them() {
        let grey = || MaterialKind::diffuse(0.5);
        // 20 m2, and ten parts of 1.9 m2 beside them; a rug of 2 m x 1 m on them, and one across two parts.
        let floor = quad([0.0; 3], [5.0, 0.0, 0.0], [0.0, 4.0, 0.0]);
        let parts = (0..10).map(|i| quad([1.9 * f64::from(i), 4.0, 0.0], [1.9, 0.0, 0.0], [0.0, 1.0, 0.0]));
        let rugs = [
            ShapeDescription::cuboid([1.0, 1.0, 0.0], [3.0, 2.0, 0.01]),
            ShapeDescription::cuboid([1.5, 4.2, 0.0], [2.5, 4.6, 0.01]),
        ];
        let ceiling = quad([0.0, 0.0, 3.0], [0.0, 5.0, 0.0], [19.0, 0.0, 0.0]);
        let builder = [floor, ceiling]
            .into_iter()
            .chain(parts)
            .chain(rugs)
            .fold(lamp(), |builder, shape| builder.shape(shape, grey()));
        let room = layout(builder, |_| ()).unwrap();
        assert!((surface(&room, RoomSurfaceKind::Floor).area - 39.0).abs() < 1e-9, "{:?}", room.surfaces);
        assert_eq!(room.furniture.len(), 12);
    }

    #[test]
    fn thick_walls_count_by_their_inner_faces_also_where_coordinates_are_rounded() {
        // 5 m x 4 m x 3 m within, walls of 0.15 m, turned by 30 degrees and rounded to a millimetre.
        let (sin, cos) = 30.0_f64.to_radians().sin_cos();
        let turned = |x: f64, y: f64| {
            let round = |length: f64| (length * 1e3).round() / 1e3;
            [round(cos * x - sin * y), round(sin * x + cos * y)]
        };
        let upright = |[x0, y0]: [f64; 2], [x1, y1]: [f64; 2]| {
            quad([x0, y0, 0.0], [x1 - x0, y1 - y0, 0.0], [0.0, 0.0, 3.0])
        };
        let mut shapes = Vec::new();
        for off in [0.0, 0.15] {
            let corners = [[-off, -off], [5.0 + off, -off], [5.0 + off, 4.0 + off], [-off, 4.0 + off]];
            let corners = corners.map(|[x, y]| turned(x, y));
            shapes.extend((0..4).map(|i| upright(corners[i], corners[(i + 1) % 4])));
        }
        // Four triangles around a point of the floor, which is half a millimetre below the others.
        let level = |z: f64, middle: f64| {
            let corners = [[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [0.0, 4.0]].map(|[x, y]| turned(x, y));
            let mut points: Vec<DVec3> = corners.iter().map(|[x, y]| DVec3::new(*x, *y, z)).collect();
            let [x, y] = turned(2.5, 2.0);
            points.push(DVec3::new(x, y, middle));
            ShapeDescription::mesh(points, vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
        };
        shapes.extend([level(0.0, -0.0005), level(3.0, 3.0)]);
        let builder = shapes
            .into_iter()
            .fold(lamp(), |builder, shape| builder.shape(shape, MaterialKind::diffuse(0.5)));
        let room = layout(builder, |_| ()).unwrap();
        // 2 x (5 + 4) x 3 m2; both faces are drawn.
        let near = |kind, area: f64| (surface(&room, kind).area / area - 1.0).abs() < 1e-3;
        assert!(near(RoomSurfaceKind::Walls, 54.0) && room.walls.len() == 8, "{:?}", room.surfaces);
        assert!(near(RoomSurfaceKind::Floor, 20.0) && near(RoomSurfaceKind::Ceiling, 20.0), "{room:?}");
        assert!(room.furniture.is_empty() && room.furniture_left_out == 0);
    }

    /// Layout of a room whose shapes have a reflectance of 0.5.
    fn of_shapes(shapes: impl IntoIterator<Item = ShapeDescription>) -> RoomLayout {
        let add =
            |builder: SceneBuilder, shape: ShapeDescription| builder.shape(shape, MaterialKind::diffuse(0.5));
        layout(shapes.into_iter().fold(lamp(), add), |_| ()).unwrap()
    }

    /// A wall of 3 m height between two points.
    fn upright([x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> ShapeDescription {
        quad([x0, y0, 0.0], [x1 - x0, y1 - y0, 0.0], [0.0, 0.0, 3.0])
    }

    /// A rectangle of the floor, and the ceiling 3 m above it.
    fn floor_and_ceiling([x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> [ShapeDescription; 2] {
        let (x, y) = ([x1 - x0, 0.0, 0.0], [0.0, y1 - y0, 0.0]);
        [quad([x0, y0, 0.0], x, y), quad([x0, y0, 3.0], y, x)]
    }

    /// Walls of 3 m height along a closed outline.
    fn around<const N: usize>(corners: [[f64; 2]; N]) -> impl Iterator<Item = ShapeDescription> {
        (0..N).map(move |i| upright(corners[i], corners[(i + 1) % N]))
    }

    /// Rooms between these corners, each with single faces as walls.
    fn of_rooms(rooms: [[[f64; 2]; 2]; 2]) -> RoomLayout {
        of_shapes(rooms.into_iter().flat_map(|[[x0, y0], [x1, y1]]| {
            around([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]).chain(floor_and_ceiling([x0, y0], [x1, y1]))
        }))
    }

    fn assert_areas(room: &RoomLayout, floor: f64, walls: f64, ceiling: f64) {
        for (kind, area) in [
            (RoomSurfaceKind::Floor, floor),
            (RoomSurfaceKind::Walls, walls),
            (RoomSurfaceKind::Ceiling, ceiling),
        ] {
            assert!((surface(room, kind).area - area).abs() < 1e-9, "{area} m2: {:?}", room.surfaces);
        }
    }

    #[test]
    fn boxes_as_walls_count_by_their_inner_sides_alone() {
        // 5 m x 4 m x 3 m within; walls of 0.3 m, which is more than 5 % of the shorter side, without the corners of the house.
        let walls = [
            [[0.0, -0.3], [5.0, 0.0]],
            [[5.0, 0.0], [5.3, 4.0]],
            [[0.0, 4.0], [5.0, 4.3]],
            [[-0.3, 0.0], [0.0, 4.0]],
        ];
        let walls = walls.map(|[[x0, y0], [x1, y1]]| ShapeDescription::cuboid([x0, y0, 0.0], [x1, y1, 3.0]));
        let room = of_shapes(walls.into_iter().chain(floor_and_ceiling([0.0; 2], [5.0, 4.0])));
        assert_areas(&room, 20.0, 54.0, 20.0);
        let [floor] = room.floor.as_slice() else { panic!("one floor: {:?}", room.floor) };
        assert_eq!((floor.len(), room.walls.len()), (4, 8));
        // The narrow sides of the four boxes.
        assert_eq!(room.furniture.len(), 8);
        // A cube of 0.5 m, whose floor is no wider than a wall, is a room, too.
        assert_areas(&of_shapes([ShapeDescription::cuboid([0.0; 3], [0.5; 3])]), 0.25, 1.0, 0.25);
    }

    /// A rectangle in a mesh, at a height.
    fn level([x0, y0]: [f64; 2], [x1, y1]: [f64; 2], z: f64) -> [[f64; 3]; 4] {
        [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]]
    }

    /// A wall of 3 m height between two points, in a mesh.
    fn side([x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> [[f64; 3]; 4] {
        [[x0, y0, 0.0], [x1, y1, 0.0], [x1, y1, 3.0], [x0, y0, 3.0]]
    }

    /// A mesh of two triangles for each of some quadrilaterals.
    fn mesh_of(quads: &[[[f64; 3]; 4]]) -> ShapeDescription {
        let points = quads.iter().flatten().map(|point| DVec3::from(*point)).collect();
        let first = (0..quads.len() as u32).map(|number| 4 * number);
        let faces = first.flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 3]]).collect();
        ShapeDescription::mesh(points, faces)
    }

    #[test]
    fn walls_of_one_mesh_count_by_their_inner_sides_alone() {
        // 5 m x 4 m x 3 m within, walls of 0.3 m: their top and their underside are rings of 5.76 m2 about 0.3 m wide.
        let corners = |off: f64| [[-off, -off], [5.0 + off, -off], [5.0 + off, 4.0 + off], [-off, 4.0 + off]];
        let (inner, outer) = (corners(0.0), corners(0.3));
        let quads = (0..4).flat_map(|i| {
            let next = (i + 1) % 4;
            let ring = [outer[i], outer[next], inner[next], inner[i]];
            let top = ring.map(|[x, y]| [x, y, 3.0]);
            let [a, b, c, d] = ring.map(|[x, y]| [x, y, 0.0]);
            [side(outer[i], outer[next]), side(inner[next], inner[i]), top, [d, c, b, a]]
        });
        let mesh = mesh_of(&quads.collect::<Vec<_>>());
        let room = of_shapes([mesh].into_iter().chain(floor_and_ceiling([0.0; 2], [5.0, 4.0])));
        assert_areas(&room, 20.0, 54.0, 20.0);
        assert!(room.walls.len() == 8 && room.furniture.is_empty(), "{:?}", room.furniture);
    }

    #[test]
    fn desk_tops_in_the_mesh_of_a_room_are_furniture() {
        // Two of 1.6 m x 0.5 m in one plane, narrower than the thickest wall.
        let mut quads = vec![
            level([0.0; 2], [5.0, 4.0], 0.0),
            level([0.0; 2], [5.0, 4.0], 3.0),
            level([0.5, 0.5], [2.1, 1.0], 0.75),
            level([2.9, 0.5], [4.5, 1.0], 0.75),
        ];
        let corners = [[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [0.0, 4.0]];
        quads.extend((0..4).map(|i| side(corners[i], corners[(i + 1) % 4])));
        let room = of_shapes([mesh_of(&quads)]);
        assert_areas(&room, 20.0, 54.0, 20.0);
        assert_eq!((room.walls.len(), room.furniture.len()), (4, 1));
    }

    #[test]
    fn furniture_that_stands_a_little_in_a_wall_covers_no_floor() {
        // Its underside reaches 1 cm beyond the floor of 5 m x 4 m.
        let cabinet = ShapeDescription::cuboid([1.0, -0.01, 0.0], [3.0, 0.59, 0.9]);
        let walls = around([[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [0.0, 4.0]]);
        let room = of_shapes(walls.chain([cabinet]).chain(floor_and_ceiling([0.0; 2], [5.0, 4.0])));
        assert_areas(&room, 20.0, 54.0, 20.0);
        assert_eq!(room.furniture.len(), 6);
    }

    #[test]
    fn closets_keep_the_wall_behind_them() {
        // 4 m x 0.55 m, no deeper than the thickest wall, and a room of 4 m x 4 m, with 0.1 m between them.
        let room = of_rooms([[[0.0, 0.0], [4.0, 0.55]], [[0.0, 0.65], [4.0, 4.65]]]);
        // 2 x (4 + 0.55) x 3 m2 and 2 x (4 + 4) x 3 m2.
        assert_areas(&room, 18.2, 75.3, 18.2);
    }

    #[test]
    fn outer_faces_behind_the_end_of_a_partition_do_not_count() {
        // Two rooms of 4 m x 3 m with 0.1 m between them, and walls of 0.15 m along both.
        let floors = [[[0.0, 0.0], [4.0, 3.0]], [[4.1, 0.0], [8.1, 3.0]]];
        let floors = floors.into_iter().flat_map(|[from, to]| floor_and_ceiling(from, to));
        let walls = [
            [[0.0, 0.0], [8.1, 0.0]],
            [[0.0, 3.0], [8.1, 3.0]],
            [[0.0, -0.15], [8.1, -0.15]],
            [[0.0, 3.15], [8.1, 3.15]],
            [[0.0, 0.0], [0.0, 3.0]],
            [[4.0, 0.0], [4.0, 3.0]],
            [[4.1, 0.0], [4.1, 3.0]],
            [[8.1, 0.0], [8.1, 3.0]],
        ];
        let walls = walls.map(|[from, to]| upright(from, to));
        // 2 x 8.1 x 3 m2 and 4 x 3 x 3 m2.
        assert_areas(&of_shapes(floors.chain(walls)), 24.0, 84.6, 24.0);
    }

    #[test]
    fn pilasters_leave_the_wall_behind_them() {
        // 5 m x 4 m x 3 m, with a face of 1 m x 3 m at 0.1 m from the wall.
        let walls = around([[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [0.0, 4.0]]);
        let pilaster = upright([2.0, 0.1], [3.0, 0.1]);
        let room = of_shapes(walls.chain([pilaster]).chain(floor_and_ceiling([0.0; 2], [5.0, 4.0])));
        assert_areas(&room, 20.0, 57.0, 20.0);
    }

    #[test]
    fn walls_between_two_rooms_have_two_faces_that_count() {
        // Rooms of 4 m x 3 m and of 4 m x 2 m, with 0.12 m between them.
        let room = of_rooms([[[0.0, 0.0], [4.0, 3.0]], [[0.0, 3.12], [4.0, 5.12]]]);
        // 2 x (4 + 3) x 3 m2 and 2 x (4 + 2) x 3 m2.
        assert_areas(&room, 20.0, 78.0, 20.0);
    }

    #[test]
    fn thick_walls_of_a_room_like_an_l_count_by_their_inner_faces() {
        // 4 m x 4 m less 3 m x 3 m, so that the middle of the box is outside; outer faces at 0.15 m.
        let l = |off: f64| {
            let (low, side, arm) = (-off, 4.0 + off, 1.0 + off);
            around([[low, low], [side, low], [side, arm], [arm, arm], [arm, side], [low, side]])
        };
        let floor = [[[0.0, 0.0], [4.0, 1.0]], [[0.0, 1.0], [1.0, 4.0]]];
        let shapes = floor.into_iter().flat_map(|[from, to]| floor_and_ceiling(from, to));
        // 2 x (4 + 4) x 3 m2.
        assert_areas(&of_shapes(shapes.chain(l(0.15)).chain(l(0.0))), 7.0, 48.0, 7.0);
    }

    #[test]
    fn emitting_surfaces_are_no_part_of_the_room_unless_there_is_nothing_else() {
        let panel = || quad([1.0, 1.0, 2.5], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]).emitting(1.0);
        let room = |builder: SceneBuilder| builder.shape(panel(), MaterialKind::diffuse(0.9));
        let walls = |description: &mut _| add_walls(description, DVec3::new(5.0, 4.0, 2.5));
        let lit = layout(room(SceneBuilder::new()), walls).unwrap();
        let ceiling = surface(&lit, RoomSurfaceKind::Ceiling);
        assert!((ceiling.area - 20.0).abs() < 1e-9 && ceiling.reflectance == Some(0.0), "{ceiling:?}");
        let [light] = lit.other_lights.as_slice() else { panic!("one light") };
        assert!(light.is_electric() && light.position == Some([1.5, 1.5, 2.5]) && lit.furniture.is_empty());
        assert_eq!(layout(room(SceneBuilder::new()), |_| ()).unwrap().size(), DVec3::new(1.0, 1.0, 0.0));
    }

    #[test]
    fn high_cupboards_are_no_walls() {
        // 2.4 m of 2.5 m high, in the middle of 5 m x 4 m.
        let cupboard = ShapeDescription::cuboid([2.0, 1.5, 0.0], [3.0, 2.5, 2.4]);
        let builder = lamp().shape(cupboard, MaterialKind::diffuse(0.9));
        let room = layout(builder, |description| add_walls(description, DVec3::new(5.0, 4.0, 2.5))).unwrap();
        let walls = surface(&room, RoomSurfaceKind::Walls);
        // 2 x (5 + 4) x 2.5 m2, black.
        assert!((walls.area - 45.0).abs() < 1e-9 && walls.reflectance == Some(0.0), "{walls:?}");
    }
}
