//! The room of a design from above: outlines, surfaces, areas of measurement, luminaires.

use std::collections::BTreeMap;

use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::{Bounds3, DVec2, DVec3};
use glanz_scene::description::ZoneKind;
use glanz_scene::{Light, LightId, PlacedSurface, Scene};
use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::luminaire::PlacedLuminaire;
use super::luminaire_list::{LuminaireGroup, OtherLight};
use super::plan_outline::ShapeOutline;
use crate::Receivers;

/// Height of a wall, as a share of that of the room.
const WALL_HEIGHT: f64 = 0.9;

/// Least area of a part of the floor or the ceiling, as a share of its largest part; least length of a wall, as a share of that of the room.
const LEAST_PART: f64 = 0.1;

/// Distance within which heights are equal, as a share of the extent of the room.
const NEAR: f64 = 1e-4;

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
    /// Luminous reflectance at right angles, the mean over the area.
    pub reflectance: f64,
    /// Least and largest reflectance of its parts.
    pub reflectance_range: [f64; 2],
}

/// A receiver in the room.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceiverPlace {
    /// Its name, that of its map.
    pub name: String,
    /// The part of a planned room that it is, if it is declared.
    pub kind: Option<ZoneKind>,
    /// Whether it is flat, level and faces up.
    pub is_level: bool,
    /// Whether it is flat and upright.
    pub is_upright: bool,
    /// Its lower left corner from above, if it is level: its first direction is x and its second one y; metres.
    pub corner: DVec2,
    /// Height of its middle, metres.
    pub height: f64,
    /// Its outline from above, metres.
    pub outline: Vec<DVec2>,
}

/// A room from above.
///
/// z is up. Walls are upright flat shapes nearly as high as the room, floor and ceiling the level ones at its lowest and its highest point; all other shapes are furniture, which
/// is represented by convex outlines.
#[derive(Clone, Debug, PartialEq)]
pub struct RoomLayout {
    /// Lowest and highest corner of the box around it, metres.
    pub corners: [DVec3; 2],
    /// Outlines of floor and walls, metres; those of two points are lines.
    pub walls: Vec<Vec<DVec2>>,
    /// Outlines of furniture, metres.
    pub furniture: Vec<Vec<DVec2>>,
    /// Floor, walls, and ceiling, as far as there are any.
    pub surfaces: Vec<RoomSurface>,
    /// Receivers in the order of their maps.
    pub receivers: Vec<ReceiverPlace>,
    /// Luminaires of photometric files by kind.
    pub luminaires: Vec<LuminaireGroup>,
    /// All other lights.
    pub other_lights: Vec<OtherLight>,
}

/// A shape of the scene with its surface.
struct RoomShape<'a> {
    surface: &'a PlacedSurface<'a>,
    faces: Vec<u32>,
    outline: ShapeOutline,
}

impl RoomLayout {
    /// The layout of a scene; `None` if it has no finite shape.
    #[must_use]
    pub fn of(scene: &Scene, receivers: &Receivers, luminaires: &[PlacedLuminaire]) -> Option<Self> {
        let placed = scene.placed_surfaces();
        let shapes = shapes(&placed);
        let mut bounds = Bounds3::EMPTY;
        for RoomShape { outline, .. } in &shapes {
            let [low, high] = outline.height;
            for point in &outline.outline {
                bounds = bounds.including(point.extend(low)).including(point.extend(high));
            }
        }
        if bounds.is_empty() || !bounds.is_finite() {
            return None;
        }
        let mut layout = Self {
            corners: [bounds.min, bounds.max],
            walls: Vec::new(),
            furniture: Vec::new(),
            surfaces: Vec::new(),
            receivers: receiver_places(scene, receivers, &placed),
            luminaires: LuminaireGroup::of(luminaires),
            other_lights: other_lights(scene, &placed),
        };
        layout.sort_shapes(scene, &shapes);
        Some(layout)
    }

    /// Adds walls, furniture and surfaces.
    fn sort_shapes(&mut self, scene: &Scene, shapes: &[RoomShape<'_>]) {
        let [low, high] = self.corners;
        let (size, near) = (high - low, NEAR * (high - low).length());
        let parts = |height: f64| -> Vec<&RoomShape<'_>> {
            let is_part = |shape: &&RoomShape<'_>| {
                shape.outline.is_level() && (shape.outline.height[0] - height).abs() <= near
            };
            let all: Vec<&RoomShape<'_>> = shapes.iter().filter(is_part).collect();
            let largest = all.iter().map(|shape| shape.outline.area()).fold(0.0, f64::max);
            all.into_iter().filter(|shape| shape.outline.area() > LEAST_PART * largest).collect()
        };
        // A flat scene has neither walls nor a ceiling.
        let [floor, ceiling] =
            if size.z > near { [parts(low.z), parts(high.z)] } else { [parts(low.z), Vec::new()] };
        let is_wall = |shape: &&RoomShape<'_>| {
            let [from, to] = shape.outline.height;
            shape.outline.is_upright()
                && to - from >= WALL_HEIGHT * size.z
                && shape.outline.length() >= LEAST_PART * size.truncate().min_element()
        };
        let walls: Vec<&RoomShape<'_>> = shapes.iter().filter(is_wall).collect();
        let is_in = |list: &[&RoomShape<'_>], shape: &RoomShape<'_>| {
            list.iter().any(|other| std::ptr::eq(*other, shape))
        };
        let mut others: Vec<&RoomShape<'_>> = shapes
            .iter()
            .filter(|shape| ![&floor, &ceiling, &walls].into_iter().any(|list| is_in(list, shape)))
            .filter(|shape| shape.surface.light().is_none() && shape.outline.outline.len() > 1)
            .collect();
        others.sort_by(|a, b| b.outline.length().total_cmp(&a.outline.length()));
        others.truncate(MOST_FURNITURE);
        self.furniture = others.iter().map(|shape| shape.outline.outline.clone()).collect();
        self.walls = floor.iter().chain(&walls).map(|shape| shape.outline.outline.clone()).collect();
        let middle = 0.5 * (low + high);
        let kinds = [RoomSurfaceKind::Floor, RoomSurfaceKind::Walls, RoomSurfaceKind::Ceiling];
        let summed = kinds.into_iter().zip([&floor, &walls, &ceiling]);
        self.surfaces = summed.filter_map(|(kind, list)| room_surface(scene, kind, list, middle)).collect();
    }

    /// Size along x, y and z, metres.
    #[must_use]
    pub fn size(&self) -> DVec3 {
        self.corners[1] - self.corners[0]
    }

    /// Floor area, m^2; that of the box from above if there is no floor.
    #[must_use]
    pub fn floor_area(&self) -> f64 {
        let floor = self.surfaces.iter().find(|part| part.surface == RoomSurfaceKind::Floor);
        floor.map_or_else(|| self.size().truncate().element_product(), |floor| floor.area)
    }

    /// Electric power of all luminaires, watts; `None` if the power of one is unknown, or there is none.
    #[must_use]
    pub fn watts(&self) -> Option<f64> {
        let known = self.luminaires.iter().all(|group| group.description.watts > 0.0);
        let watts = self.luminaires.iter().map(|group| group.places.len() as f64 * group.description.watts);
        (known && !self.luminaires.is_empty()).then(|| watts.sum())
    }

    /// The place of the receiver with this name.
    #[must_use]
    pub fn receiver(&self, name: &str) -> Option<&ReceiverPlace> {
        self.receivers.iter().find(|place| place.name == name)
    }
}

/// All finite shapes that light does not pass, with the faces of each.
fn shapes<'a>(placed: &'a [PlacedSurface<'a>]) -> Vec<RoomShape<'a>> {
    let mut shapes = Vec::new();
    for surface in placed.iter().filter(|surface| !surface.is_passable()) {
        // Joined meshes are one surface, boxes one shape of several sides.
        let mut by_shape: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
        let is_box = surface.faces() > 1 && surface.faces() <= 64;
        for face in 0..surface.faces() {
            let side = if is_box { face } else { 0 };
            by_shape.entry((surface.shape(face), side)).or_default().push(face);
        }
        if by_shape.is_empty() {
            by_shape.insert((0, 0), Vec::new());
        }
        let outlined = by_shape.into_values().filter_map(|faces| {
            let outline = ShapeOutline::of(surface, &faces)?;
            Some(RoomShape { surface, faces, outline })
        });
        shapes.extend(outlined);
    }
    shapes
}

/// Area and reflectance of parts of a room; `None` without parts.
fn room_surface(
    scene: &Scene,
    surface: RoomSurfaceKind,
    parts: &[&RoomShape<'_>],
    middle: DVec3,
) -> Option<RoomSurface> {
    let (mut area, mut sum, mut range) = (0.0, 0.0, [f64::INFINITY, f64::NEG_INFINITY]);
    for part in parts {
        let Some(own) = reflectance(scene, part, middle) else { continue };
        let part_area: f64 = part.faces.iter().filter_map(|&face| part.surface.area(face..face + 1)).sum();
        (area, sum) = (area + part_area, sum + part_area * own);
        range = [range[0].min(own), range[1].max(own)];
    }
    let reflectance = sum / area;
    (area > 0.0).then_some(RoomSurface { surface, area, reflectance, reflectance_range: range })
}

/// Luminous reflectance of a shape at right angles, on the side that faces `middle`; `None` if the point in its middle is not on it.
fn reflectance(scene: &Scene, shape: &RoomShape<'_>, middle: DVec3) -> Option<f64> {
    let face = *shape.faces.first()?;
    let corners = shape.surface.face_domain(face).corners();
    let uv = corners.iter().sum::<DVec2>() / corners.len().max(1) as f64;
    let front = shape.surface.at(face, uv, false)?;
    let is_behind = front.at.wo.dot(middle - front.at.point.position) < 0.0;
    let at = if is_behind { shape.surface.at(face, uv, true)?.at } else { front.at };
    let wavelengths = Wavelengths::default();
    let bsdf = at.bsdf(scene, &wavelengths)?;
    let wo = at.frame_of(&bsdf, at.point.shading_normal).to_local(at.wo);
    Some(f64::from(bsdf.reflected(wo).luminance(&wavelengths)))
}

/// The receivers in the room.
fn receiver_places(scene: &Scene, receivers: &Receivers, placed: &[PlacedSurface<'_>]) -> Vec<ReceiverPlace> {
    let kind = |shape: u32| scene.receivers().iter().find(|declared| declared.shape() == shape)?.zone();
    let place = |receiver: &crate::Receiver| {
        let surface = placed.get(receiver.surface() as usize)?;
        let lit = receiver.areas().iter().position(|area| *area > 0.0)?;
        let normal = receiver.place(surface, lit, DVec2::splat(0.5)).map(|point| point.normal);
        let faces: Vec<u32> =
            (0..surface.faces()).filter(|face| surface.shape(*face) == receiver.shape()).collect();
        let outline = ShapeOutline::of(surface, &faces)?;
        let is_level = outline.is_level() && normal.is_some_and(|normal| normal.z > UPWARDS);
        let corner = outline.outline.iter().copied().reduce(DVec2::min)?;
        Some(ReceiverPlace {
            name: receiver.name().to_owned(),
            kind: kind(receiver.shape()),
            is_level,
            is_upright: outline.is_upright(),
            corner,
            height: outline.middle.z,
            outline: outline.outline,
        })
    };
    receivers.as_slice().iter().filter_map(place).collect()
}

/// All lights that are no luminaires of photometric files.
fn other_lights(scene: &Scene, placed: &[PlacedSurface<'_>]) -> Vec<OtherLight> {
    let wavelengths = Wavelengths::default();
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
            let surface = placed.iter().find(|surface| surface.light() == Some(LightId(number)))?;
            let outline = ShapeOutline::of(surface, &(0..surface.faces()).collect::<Vec<_>>())?;
            let flux = lumens(l.power());
            Some(OtherLight { outline: outline.outline, ..at("emitting surface", flux, outline.middle) })
        }
        Light::Distant(_) | Light::Sun(_) => {
            Some(OtherLight { kind: "sun", flux: None, position: None, outline: Vec::new() })
        }
        _ => Some(OtherLight { kind: "sky", flux: None, position: None, outline: Vec::new() }),
    };
    (0..).zip(scene.lights()).filter_map(light).collect()
}

/// In JSON: size and corner of the room, its floor area, its surfaces, outlines, and the level receivers. Luminaires and lights have entries of their own.
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
        let mut fields = serializer.serialize_struct("Room", 7)?;
        fields.serialize_field("size_m", &self.size().to_array())?;
        fields.serialize_field("corner_m", &self.corners[0].to_array())?;
        fields.serialize_field("floor_area_m2", &self.floor_area())?;
        fields.serialize_field("surfaces", &self.surfaces)?;
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

    fn lamp() -> SceneBuilder {
        SceneBuilder::new().light(LightDescription::point([1.0, 1.0, 2.0], 1.0))
    }

    #[test]
    fn rooms_have_walls_furniture_and_the_mean_reflectance_of_their_surfaces() {
        let grey = |reflectance: f32| MaterialKind::diffuse(reflectance);
        let quad = |corner: [f64; 3], u: [f64; 3], v: [f64; 3]| ShapeDescription::parallelogram(corner, u, v);
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
        assert!(room.walls.len() == 4 && (room.floor_area() - 12.0).abs() < 1e-9);
        let of = |kind| *room.surfaces.iter().find(|part| part.surface == kind).unwrap();
        // (8 * 0.4 + 4 * 0.1) / 12 = 0.3; (10 * 0.2 + 10 * 0.5) / 20 = 0.35.
        for (kind, area, mean, range) in [
            (RoomSurfaceKind::Floor, 12.0, 0.3, [0.1, 0.4]),
            (RoomSurfaceKind::Walls, 20.0, 0.35, [0.2, 0.5]),
            (RoomSurfaceKind::Ceiling, 12.0, 0.8, [0.8, 0.8]),
        ] {
            let found = of(kind);
            assert!((found.area - area).abs() < 1e-9 && (found.reflectance - mean).abs() < 1e-6, "{found:?}");
            assert!((found.reflectance_range[0] - range[0]).abs() < 1e-6, "{found:?}");
        }
        // The six sides of the table.
        assert_eq!(room.furniture.len(), 6);
        let desk = room.receiver("desk").unwrap();
        assert!(desk.is_level && desk.kind.is_none() && desk.corner.distance(DVec2::new(0.5, 0.5)) < 1e-12);
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
        assert_eq!((level, room.receivers.len(), room.walls.len()), (vec!["floor"], 6, 5));
        assert!(room.surfaces.iter().all(|part| part.reflectance == 0.0) && room.furniture.is_empty());
        let json = serde_json::to_value(&room).unwrap();
        assert_eq!(json["size_m"], serde_json::json!([5.0, 4.0, 3.0]));
        assert!((json["floor_area_m2"].as_f64().unwrap() - 20.0).abs() < 1e-9);
        assert_eq!(json["areas"][0]["receiver"], "floor");
    }

    #[test]
    fn a_scene_without_finite_shapes_is_no_room() {
        let plane = lamp().shape(ShapeDescription::plane(), MaterialKind::diffuse(0.5));
        assert_eq!(layout(plane, |_| ()), None);
    }
}
