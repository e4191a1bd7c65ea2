//! The luminaires of a design by kind, and its other lights.

use std::f64::consts::TAU;
use std::sync::Arc;

use glanz_light::intensity::{AngularSystem, LuminousOpening, OpeningShape};
use glanz_math::{DVec2, DVec3};
use glanz_scene::Light;
use glanz_scene::description::LuminaireDescription;
use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::luminaire::PlacedLuminaire;
use super::plan_outline::convex_hull;
use crate::report::PolarPlot;

/// Points of the outline of a round opening.
const ROUND: u32 = 32;

/// Luminaires of one kind, that is, of the same file, flux and luminous opening.
#[derive(Clone, Debug, PartialEq)]
pub struct LuminaireGroup {
    /// What the file states.
    pub description: LuminaireDescription,
    /// Luminous flux of one as it was calculated, lm.
    pub flux: f64,
    /// Its intensity in the plane of the peak and across it.
    pub polar: PolarPlot,
    /// Its largest intensity, cd.
    pub peak: f64,
    /// Whether the light of one of them leaves its photometric centre, instead of its whole opening.
    pub is_point: bool,
    /// Where they are.
    pub places: Vec<LuminairePlace>,
}

/// The place of a luminaire.
#[derive(Clone, Debug, PartialEq)]
pub struct LuminairePlace {
    /// Its number, from 1.
    pub number: u32,
    /// Its photometric centre, metres.
    pub position: DVec3,
    /// Turn of its C0 about the vertical from x towards y, degrees in [0, 360).
    pub turn: f64,
    /// Angle between its axis and the vertical, degrees.
    pub tilt: f64,
    /// Its luminous opening from above, metres; none for a point.
    pub outline: Vec<DVec2>,
}

/// A light that is no luminaire of a photometric file.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct OtherLight {
    /// Its kind.
    pub kind: &'static str,
    /// Its flux, lm; `None` if it is unknown or infinite.
    #[serde(rename = "flux_lm")]
    pub flux: Option<f64>,
    /// Its middle, metres; `None` if it is infinitely far or large.
    #[serde(rename = "position_m")]
    pub position: Option<[f64; 3]>,
    /// Its outline from above, metres; none for points.
    #[serde(skip)]
    pub outline: Vec<DVec2>,
}

impl OtherLight {
    /// Kinds of the lights of the sky, which draw no power.
    pub(crate) const SUN: &str = "sun";
    pub(crate) const SKY: &str = "sky";

    /// Whether it draws power, as all lights but those of the sky do.
    #[must_use]
    pub fn is_electric(&self) -> bool {
        ![Self::SUN, Self::SKY].contains(&self.kind)
    }
}

impl LuminaireGroup {
    /// The luminaires by kind, numbered in their order.
    #[must_use]
    pub fn of(luminaires: &[PlacedLuminaire]) -> Vec<Self> {
        let mut groups: Vec<(&PlacedLuminaire, Vec<LuminairePlace>)> = Vec::new();
        for (number, luminaire) in (1..).zip(luminaires) {
            let place = LuminairePlace::of(luminaire, number);
            match groups.iter_mut().find(|(first, _)| are_alike(first, luminaire)) {
                Some((_, places)) => places.push(place),
                None => groups.push((luminaire, vec![place])),
            }
        }
        groups.into_iter().map(|(first, places)| Self::new(first, places)).collect()
    }

    fn new(luminaire: &PlacedLuminaire, places: Vec<LuminairePlace>) -> Self {
        let own = luminaire.description.as_deref().cloned();
        let description = own.unwrap_or_else(|| LuminaireDescription {
            name: luminaire.name.clone(),
            opening: luminaire.opening,
            flux: luminaire.distribution.flux(),
            ..LuminaireDescription::default()
        });
        let (distribution, factor) = (&luminaire.distribution, luminaire.factor);
        let peak = distribution.beam().map_or([0.0; 2], |beam| {
            let [azimuth, polar] = beam.peak_angles;
            AngularSystem::C.angles(distribution.direction(azimuth, polar))
        });
        // Straight down, and up, lies in every plane.
        let plane = if (0.5..=179.5).contains(&peak[1]) { peak[0].rem_euclid(180.0) } else { 0.0 };
        let candela =
            |c: f64, gamma: f64| factor * distribution.intensity(AngularSystem::C.direction(c, gamma));
        let gammas: Vec<f64> = distribution.polars().iter().copied().chain([peak[1]]).collect();
        let flux = luminaire.flux();
        let polar = PolarPlot::sample(description.label(), plane, &gammas, candela).with_flux(flux);
        let is_point = luminaire.opening.shape == OpeningShape::Point;
        let peak = factor * distribution.peak();
        Self { description, flux, polar, peak, is_point, places }
    }

    /// Luminous efficacy, lm/W; `None` if the power is unknown.
    #[must_use]
    pub fn efficacy(&self) -> Option<f64> {
        (self.description.watts > 0.0).then(|| self.flux / self.description.watts)
    }

    /// Heights of the photometric centres, lowest and highest, metres.
    #[must_use]
    pub fn heights(&self) -> [f64; 2] {
        let heights = || self.places.iter().map(|place| place.position.z);
        [heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Share of the flux of its file with which it was calculated; `None` if that is all of it, but for rounding.
    #[must_use]
    pub fn dimming(&self) -> Option<f64> {
        let share = self.flux / self.description.flux;
        (share.is_finite() && (share - 1.0).abs() > 1e-3).then_some(share)
    }
}

impl LuminairePlace {
    fn of(luminaire: &PlacedLuminaire, number: u32) -> Self {
        let axes = luminaire.axes;
        // The remainder of a tiny negative angle is rounded up to 360.
        let turn = Some(axes.x_axis.y.atan2(axes.x_axis.x).to_degrees().rem_euclid(360.0));
        let turn = turn.filter(|turn| *turn < 360.0).unwrap_or(0.0) + 0.0;
        let tilt = axes.z_axis.z.clamp(-1.0, 1.0).acos().to_degrees();
        let outline = outline(luminaire);
        Self { number, position: luminaire.position, turn, tilt, outline }
    }
}

/// Whether two luminaires are of one kind.
fn are_alike(a: &PlacedLuminaire, b: &PlacedLuminaire) -> bool {
    let same = |a: &Option<Arc<LuminaireDescription>>, b: &Option<Arc<LuminaireDescription>>| match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b) || a == b,
        (None, None) => true,
        _ => false,
    };
    let distributions = (&a.distribution, &b.distribution);
    a.factor == b.factor
        && a.opening == b.opening
        && same(&a.description, &b.description)
        && (Arc::ptr_eq(distributions.0, distributions.1) || distributions.0 == distributions.1)
}

/// The luminous opening from above, in the world; that of the file if the light leaves a point.
fn outline(luminaire: &PlacedLuminaire) -> Vec<DVec2> {
    let of_file = luminaire.description.as_ref().map(|description| description.opening);
    let opening = if luminaire.opening.shape == OpeningShape::Point {
        of_file.unwrap_or(luminaire.opening)
    } else {
        luminaire.opening
    };
    let points = corners(&opening).into_iter().map(|p| (luminaire.position + luminaire.axes * p).truncate());
    convex_hull(points.collect())
}

/// Points around an opening, in its frame, metres.
fn corners(opening: &LuminousOpening) -> Vec<DVec3> {
    let half = 0.5 * DVec3::from(opening.size);
    let signs = [-1.0, 1.0];
    match opening.shape {
        OpeningShape::Point => Vec::new(),
        OpeningShape::Rectangle | OpeningShape::Box => signs
            .into_iter()
            .flat_map(|x| signs.into_iter().flat_map(move |y| signs.map(|z| half * DVec3::new(x, y, z))))
            .collect(),
        // Bodies that lie or stand, and balls, are covered by circles across their axes.
        _ => (0..ROUND)
            .flat_map(|i| {
                let (sin, cos) = (TAU * f64::from(i) / f64::from(ROUND)).sin_cos();
                match opening.shape {
                    OpeningShape::CylinderAlongX => signs.map(|x| half * DVec3::new(x, cos, sin)).to_vec(),
                    OpeningShape::CylinderAlongY => signs.map(|y| half * DVec3::new(cos, y, sin)).to_vec(),
                    OpeningShape::EllipseFacingX => vec![half * DVec3::new(0.0, cos, sin)],
                    OpeningShape::Ellipsoid => {
                        vec![
                            half * DVec3::new(cos, sin, 0.0),
                            half * DVec3::new(cos, 0.0, sin),
                            half * DVec3::new(0.0, cos, sin),
                        ]
                    }
                    _ => signs.map(|z| half * DVec3::new(cos, sin, z)).to_vec(),
                }
            })
            .collect(),
    }
}

/// The kind of a light of the sky; `None` for electric ones.
pub(super) fn sky_kind(light: &Light) -> Option<&'static str> {
    match light {
        Light::Photometric(_)
        | Light::Point(_)
        | Light::Spot(_)
        | Light::Projection(_)
        | Light::Goniometric(_)
        | Light::Rays(_)
        | Light::Area(_) => None,
        Light::Distant(_) | Light::Sun(_) => Some(OtherLight::SUN),
        _ => Some(OtherLight::SKY),
    }
}

/// In JSON: what the file states, number of pieces, flux, efficacy, peak, and places.
impl Serialize for LuminaireGroup {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(serde::Serialize)]
        struct PlaceEntry {
            number: u32,
            position_m: [f64; 3],
            turn_degrees: f64,
            tilt_degrees: f64,
        }
        let LuminaireDescription {
            file, maker, name, catalog_number, lamps, color, rendering, watts, ..
        } = &self.description;
        let places = self.places.iter().map(|place| PlaceEntry {
            number: place.number,
            position_m: place.position.to_array(),
            turn_degrees: place.turn,
            tilt_degrees: place.tilt,
        });
        let mut fields = serializer.serialize_struct("Luminaires", 13)?;
        for (key, text) in [
            ("name", name),
            ("maker", maker),
            ("catalog_number", catalog_number),
            ("file", file),
            ("lamps", lamps),
            ("color", color),
            ("color_rendering", rendering),
        ] {
            fields.serialize_field(key, text)?;
        }
        fields.serialize_field("count", &self.places.len())?;
        fields.serialize_field("flux_lm", &self.flux)?;
        fields.serialize_field("power_w", &(*watts > 0.0).then_some(watts))?;
        fields.serialize_field("efficacy_lm_w", &self.efficacy())?;
        fields.serialize_field("peak_cd", &self.peak)?;
        fields.serialize_field("places", &places.collect::<Vec<_>>())?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::test_luminaires::{downlight, lambertian};
    use glanz_light::intensity::{IntensityDistribution, Symmetry};
    use glanz_math::DMat3;

    #[test]
    fn luminaires_of_one_file_and_flux_are_one_kind() {
        let description = |file: &str| {
            Some(Arc::new(LuminaireDescription {
                file: file.into(),
                watts: 40.0,
                ..LuminaireDescription::default()
            }))
        };
        let lamp = |file: &str, factor: f64, z: f64| {
            // Read anew for each luminaire.
            let lamp = downlight(lambertian(1000.0), DVec3::new(1.0, 2.0, z));
            PlacedLuminaire { description: description(file), factor, ..lamp }
        };
        let wide = LuminousOpening { shape: OpeningShape::Rectangle, size: [1.2, 0.3, 0.0] };
        let wide = PlacedLuminaire { opening: wide, ..lamp("a", 1.0, 2.5) };
        let list = [lamp("a", 1.0, 2.5), lamp("b", 1.0, 2.5), lamp("a", 1.0, 2.8), lamp("a", 0.5, 2.5), wide];
        let [a, b, dimmed, wide] = LuminaireGroup::of(&list).try_into().unwrap();
        assert_eq!(wide.places[0].number, 5);
        let numbers =
            |group: &LuminaireGroup| group.places.iter().map(|place| place.number).collect::<Vec<_>>();
        assert_eq!((numbers(&a), numbers(&b), numbers(&dimmed)), (vec![1, 3], vec![2], vec![4]));
        assert_eq!((a.heights(), b.heights()), ([2.5, 2.8], [2.5, 2.5]));
        // A Lambertian emitter of 1000 cd has pi times as many lumens.
        assert!((a.flux / (1000.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4);
        assert!((a.efficacy().unwrap() - a.flux / 40.0).abs() < 1e-9);
        assert!((dimmed.flux / a.flux - 0.5).abs() < 1e-12 && (dimmed.peak - 500.0).abs() < 1e-9);
    }

    #[test]
    fn peaks_are_found_beside_the_planes_that_are_plotted() {
        // 300 cd at C30, 0.3 degrees from straight down, where the plot has the planes of C0 and C90 with 100 cd.
        let (planes, gammas) = ([0.0, 30.0, 60.0, 90.0], vec![0.0, 0.3, 90.0]);
        let candela =
            [[10.0, 100.0, 0.0], [10.0, 300.0, 0.0], [10.0, 300.0, 0.0], [10.0, 100.0, 0.0]].concat();
        let distribution =
            IntensityDistribution::try_new(AngularSystem::C, Symmetry::Quadrants, &planes, gammas, candela);
        let lamp = downlight(Arc::new(distribution.unwrap()), DVec3::ZERO);
        let [group] = LuminaireGroup::of(std::slice::from_ref(&lamp)).try_into().unwrap();
        let json = serde_json::to_value(&group).unwrap();
        assert_eq!((group.peak, &json["peak_cd"]), (300.0, &300.0.into()));
    }

    #[test]
    fn outlines_are_turned_with_the_luminaire() {
        let mut lamp = downlight(lambertian(1.0), DVec3::new(3.0, 2.0, 2.8));
        lamp.opening = LuminousOpening { shape: OpeningShape::Rectangle, size: [1.2, 0.3, 0.0] };
        lamp.axes = DMat3::from_rotation_z(0.5 * std::f64::consts::PI);
        let [group] = LuminaireGroup::of(std::slice::from_ref(&lamp)).try_into().unwrap();
        let place = &group.places[0];
        assert!((place.turn - 90.0).abs() < 1e-9 && place.tilt.abs() < 1e-6 && place.outline.len() == 4);
        for corner in &place.outline {
            let off = (*corner - DVec2::new(3.0, 2.0)).abs();
            assert!(off.distance(DVec2::new(0.15, 0.6)) < 1e-12, "{corner}");
        }
        let mut straight = lamp.clone();
        straight.axes = DMat3::from_rotation_z(-1e-17);
        assert_eq!(LuminairePlace::of(&straight, 1).turn, 0.0);
        // A light from a point has the outline of its file.
        let description = LuminaireDescription { opening: lamp.opening, ..LuminaireDescription::default() };
        let point = PlacedLuminaire {
            opening: LuminousOpening::POINT,
            description: Some(Arc::new(description)),
            ..lamp.clone()
        };
        assert_eq!(LuminairePlace::of(&point, 1).outline.len(), 4);
        let bare = PlacedLuminaire { opening: LuminousOpening::POINT, ..lamp };
        assert!(LuminairePlace::of(&bare, 1).outline.is_empty());
    }

    #[test]
    fn round_openings_are_round_from_above() {
        for (shape, size, across) in [
            (OpeningShape::Ellipse, [0.4, 0.4, 0.0], [0.2, 0.2]),
            (OpeningShape::VerticalCylinder, [0.4, 0.4, 1.0], [0.2, 0.2]),
            (OpeningShape::Ellipsoid, [0.4, 0.4, 0.4], [0.2, 0.2]),
            (OpeningShape::CylinderAlongX, [1.2, 0.1, 0.1], [0.6, 0.05]),
            (OpeningShape::CylinderAlongY, [0.1, 1.2, 0.1], [0.05, 0.6]),
            (OpeningShape::EllipseFacingX, [0.0, 0.4, 0.4], [0.0, 0.2]),
        ] {
            let points = corners(&LuminousOpening { shape, size });
            let most = points.iter().fold(DVec3::ZERO, |most, p| most.max(p.abs()));
            assert!((most.truncate() - DVec2::from(across)).length() < 1e-12, "{shape:?}: {most}");
        }
    }
}
