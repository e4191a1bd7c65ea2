//! Discomfort glare: the unified glare rating (UGR) of an observer.
//!
//! ```text
//! UGR = 8 lg( 0.25 / Lb  *  sum of L^2 omega / p^2 )
//! ```
//!
//! with the background luminance Lb = E / pi, cd/m^2, from the illuminance E on a vertical plane at the eye without the direct light of
//! luminaires, and for each luminaire its luminance L, cd/m^2, towards the eye, its solid angle omega, sr, and Guth's position index p (@cie117).
//! With the intensity I, the projected luminous area A and the distance r, L = I / A and omega = A / r^2.
//!
//! # Position index
//! CIE 117 tabulates p by the offsets R along the horizontal line of sight, T to the side and H upwards. Here it is Levin's closed form (@levin1975)
//!
//! ```text
//! ln p = (35.2 - 0.31889 t - 1.22 exp(-2 t / 9)) 1e-3 s + (21 + 0.26667 t - 0.002963 t^2) 1e-5 s^2
//! ```
//!
//! of the angle s between the line of sight and the source and the angle t of its side from above, degrees. It differs from the
//! 606 entries of the table by 4.3 % on average and by up to 10.6 % (T / R = 3, H / R = 0): 0.3 and 0.7 units of UGR for a single luminaire. As in the table,
//! luminaires with T > 3 R or H > 2 R do not count. Below the line of sight, where CIE 117 has no index, it is that of @iwata1997.
//!
//! CIE 117 and CIE 190 themselves were not available: formula, limits of the table and entries that the tests compare are from open secondary literature
//! (documents of lighting programs and makers).

use glanz_math::DVec3;

use super::luminaire::PlacedLuminaire;
use crate::replicates::ReplicateEstimate;
use crate::report::printable;

/// Height of the eye of a seated observer, metres.
pub const SEATED_EYE: f64 = 1.2;

/// Height of the eye of a standing observer, metres: that of cylindrical illuminance in EN 12464-1; CIE 117 has 1.7.
pub const STANDING_EYE: f64 = 1.6;

/// Largest offsets to the side and upwards, over that along the line of sight, of luminaires that count.
const TABLE_LIMITS: [f64; 2] = [3.0, 2.0];

/// Smallest projected area of luminaires that count, over the largest: that of a flat opening 5 degrees from its plane. Where an opening is seen more obliquely, its mean
/// luminance I / A has no meaning: frames hide it, and A is as small as the errors of its sizes.
const SMALLEST_AREA: f64 = 0.087_155_742_747_658_17;

/// An observer with a line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlareObserver {
    eye: DVec3,
    view: DVec3,
    up: DVec3,
}

/// Errors of rating glare.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GlareError {
    /// A line of sight without a horizontal part.
    #[error("the view direction ({}, {}, {}) of an observer is vertical or 0; the position index needs a horizontal part", .0.x, .0.y, .0.z)]
    View(DVec3),
    /// A luminaire without a luminous area.
    #[error(
        "{0} has no luminous area, so that its luminance is unknown: its file states no luminous opening, or the scene does not use it; \
         UGR needs a photometric file with length and width of the opening, and in a scene \"string as\" \"area\""
    )]
    NoArea(String),
}

/// A luminaire as an observer sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlareSource {
    /// Luminance towards the eye, cd/m^2.
    pub luminance: f64,
    /// Solid angle, sr.
    pub solid_angle: f64,
    /// Position index.
    pub position_index: f64,
}

impl GlareSource {
    /// Its part of the sum of UGR, cd^2 / m^4 sr.
    #[must_use]
    pub fn glare(&self) -> f64 {
        (self.luminance / self.position_index).powi(2) * self.solid_angle
    }
}

impl GlareObserver {
    /// An observer with the eye at a point, metres, and a view direction of any length.
    ///
    /// # Errors
    /// [`GlareError::View`] for a vertical direction.
    pub fn try_new(eye: DVec3, view: DVec3) -> Result<Self, GlareError> {
        let error = GlareError::View(view);
        let view = view.try_normalize().ok_or_else(|| error.clone())?;
        let up = DVec3::Z.reject_from_normalized(view).try_normalize().ok_or(error)?;
        Ok(Self { eye, view, up })
    }

    /// The eye, metres.
    #[must_use]
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Unit direction of the line of sight.
    #[must_use]
    pub fn view(&self) -> DVec3 {
        self.view
    }

    /// Unit direction of the view in the horizontal plane: the normal of the vertical plane at the eye.
    #[must_use]
    pub fn horizontal_view(&self) -> DVec3 {
        self.view.reject_from_normalized(DVec3::Z).normalize_or_zero()
    }

    /// Position index of a source in a direction of any length; `None` if it does not count: behind the observer or beyond the table of CIE 117.
    #[must_use]
    pub fn position_index(&self, towards: DVec3) -> Option<f64> {
        let (along, up) = (towards.dot(self.view), towards.dot(self.up));
        let side = (towards - along * self.view - up * self.up).length();
        if along <= 0.0 || side > TABLE_LIMITS[0] * along || up > TABLE_LIMITS[1] * along {
            return None;
        }
        let tangent = side.hypot(up) / along;
        if up < 0.0 {
            let factor = if tangent > 0.6 { 1.2 } else { 0.8 };
            return Some(1.0 + factor * tangent.min(3.0));
        }
        let [s, t] = [tangent.atan(), side.atan2(up)].map(f64::to_degrees);
        let linear = (35.2 - 0.31889 * t - 1.22 * (-2.0 * t / 9.0).exp()) * 1e-3;
        let square = (21.0 + 0.26667 * t - 0.002963 * t * t) * 1e-5;
        Some((linear * s + square * s * s).exp())
    }

    /// The luminaire as the observer sees it; `None` if it sends no light to the eye or does not count, see the module's documentation.
    ///
    /// # Errors
    /// [`GlareError::NoArea`] for a luminaire without a luminous area.
    pub fn source(&self, luminaire: &PlacedLuminaire) -> Result<Option<GlareSource>, GlareError> {
        let offset = luminaire.position - self.eye;
        let Some(position_index) = self.position_index(offset) else { return Ok(None) };
        let intensity = luminaire.intensity_towards(self.eye);
        let squared = offset.length_squared();
        if intensity == 0.0 {
            return Ok(None);
        }
        let (area, largest) = (luminaire.area_towards(self.eye), luminaire.largest_area());
        if largest <= 0.0 {
            return Err(GlareError::NoArea(printable(&luminaire.name)));
        }
        if area < SMALLEST_AREA * largest {
            return Ok(None);
        }
        Ok(Some(GlareSource { luminance: intensity / area, solid_angle: area / squared, position_index }))
    }
}

/// UGR for a background luminance, cd/m^2, and the sum of [`GlareSource::glare`] over all luminaires; `None` without glare, which no number expresses, and
/// infinite without a background.
#[must_use]
pub fn unified_glare_rating(background: f64, glare: f64) -> Option<f64> {
    (glare > 0.0).then(|| 8.0 * (0.25 * glare / background).log10())
}

/// UGR of an observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlareRating {
    /// The observer.
    pub observer: GlareObserver,
    /// Background luminance, cd/m^2.
    pub background: ReplicateEstimate,
    /// Number of photometric luminaires that count.
    pub sources: usize,
    /// Sum of [`GlareSource::glare`] over luminaires and over the parts of luminous surfaces.
    pub glare: ReplicateEstimate,
}

impl GlareRating {
    /// UGR; `None` without glare.
    #[must_use]
    pub fn ugr(&self) -> Option<f64> {
        unified_glare_rating(self.background.value, self.glare.value)
    }

    /// Interval of UGR that follows from those of glare and background; `None` without glare.
    #[must_use]
    pub fn interval(&self) -> Option<[f64; 2]> {
        let [low, high] = self.background.interval.map(|luminance| luminance.max(0.0));
        let [least, most] = self.glare.interval;
        let lower = unified_glare_rating(high, least).unwrap_or(f64::NEG_INFINITY);
        Some([lower, unified_glare_rating(low, most)?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::test_luminaires::{downlight, uniform};
    use glanz_light::intensity::{LuminousOpening, OpeningShape};

    fn index(t: f64, h: f64) -> Option<f64> {
        let observer = GlareObserver::try_new(DVec3::ZERO, DVec3::Y).unwrap();
        observer.position_index(DVec3::new(t, 1.0, h))
    }

    #[test]
    fn position_index_agrees_with_the_table_of_cie_117() {
        // T / R, H / R and the entry of table 4.1.
        for (t, h, entry) in [
            (0.0, 0.0, 1.00),
            (0.0, 0.5, 2.86),
            (0.0, 1.0, 7.00),
            (0.0, 1.5, 13.15),
            (0.2, 0.2, 1.50),
            (0.5, 0.5, 2.91),
            (1.0, 0.0, 2.11),
            (1.0, 0.5, 3.91),
            (1.0, 1.0, 7.00),
            (1.0, 1.5, 11.90),
            (2.0, 0.0, 3.50),
            (2.0, 1.9, 16.00),
            (3.0, 0.5, 6.60),
        ] {
            let found = index(t, h).unwrap();
            assert!((found / entry - 1.0).abs() < 0.04, "{t} {h}: {found}, {entry}");
            assert_eq!(index(-t, h), Some(found));
        }
        // The largest difference of the entries compared.
        assert!((index(3.0, 0.0).unwrap() / 4.22 - 1.106).abs() < 0.001);
        // Beyond the table, behind, and below the line of sight.
        assert_eq!((index(3.1, 0.0), index(0.0, 2.1)), (None, None));
        let observer = GlareObserver::try_new(DVec3::ZERO, DVec3::Y).unwrap();
        assert_eq!(observer.position_index(DVec3::new(0.0, -1.0, 0.1)), None);
        assert_eq!((index(0.0, -0.5), index(0.0, -1.0)), (Some(1.4), Some(2.2)));
    }

    #[test]
    fn ugr_of_a_single_luminaire_agrees_with_the_calculation_by_hand() {
        // docs/lighting.md, "One luminaire": 2 m above the eye and 4 m ahead, opening 0.6 m x 0.6 m, 200 cd towards the eye, Lb = 20 cd/m^2.
        // A = 0.36 * 2 / sqrt(20) = 0.16100 m^2, L = 1242.3 cd/m^2, omega = A / 20 = 0.0080498 sr, p = 2.8602 at s = 26.565 degrees, t = 0;
        // sum = 1242.26^2 * 0.0080498 / 2.8602^2 = 1518.6, UGR = 8 lg(0.25 * 1518.6 / 20) = 10.227.
        let luminaire = downlight(uniform(200.0), DVec3::new(0.0, 4.0, 3.2));
        let observer = GlareObserver::try_new(DVec3::new(0.0, 0.0, SEATED_EYE), DVec3::Y).unwrap();
        let source = observer.source(&luminaire).unwrap().unwrap();
        assert!((source.luminance - 1242.26).abs() < 0.01, "{source:?}");
        assert!((source.solid_angle - 0.0080498).abs() < 1e-7, "{source:?}");
        assert!((source.position_index - 2.8602).abs() < 1e-4, "{source:?}");
        let ugr = unified_glare_rating(20.0, source.glare()).unwrap();
        assert!((ugr - 10.227).abs() < 0.001, "{ugr}");
    }

    #[test]
    fn luminaires_without_an_area_are_named_and_those_seen_edge_on_do_not_count() {
        let observer = GlareObserver::try_new(DVec3::ZERO, DVec3::Y).unwrap();
        // Openings that look down, at 0, 4.3 and 5.7 degrees above the eye.
        for (height, counts) in [(0.0, false), (0.3, false), (0.4, true)] {
            let level = downlight(uniform(1.0), DVec3::new(0.0, 4.0, height));
            assert_eq!(observer.source(&level).unwrap().is_some(), counts, "{height}");
        }
        // A sphere counts at any height, also on the level of the eye.
        let size = [0.2; 3];
        let lamp = downlight(uniform(1.0), DVec3::new(0.0, 4.0, 0.0));
        let opening = LuminousOpening { shape: OpeningShape::Ellipsoid, size };
        let source = observer.source(&PlacedLuminaire { opening, ..lamp }).unwrap().unwrap();
        assert!((source.luminance - 1.0 / (0.01 * std::f64::consts::PI)).abs() < 1e-9, "{source:?}");
        let point = PlacedLuminaire {
            opening: LuminousOpening::POINT,
            ..downlight(uniform(1.0), DVec3::new(0.0, 4.0, 2.0))
        };
        assert_eq!(observer.source(&point), Err(GlareError::NoArea("luminaire 1".to_owned())));
        let hostile = PlacedLuminaire { name: "\u{1b}[2J".to_owned(), ..point.clone() };
        assert!(!observer.source(&hostile).unwrap_err().to_string().contains('\u{1b}'));
        let dark = PlacedLuminaire { factor: 0.0, ..point };
        assert_eq!(observer.source(&dark), Ok(None));
        assert!(GlareObserver::try_new(DVec3::ZERO, 2.0 * DVec3::Z).is_err());
        assert!(GlareObserver::try_new(DVec3::ZERO, DVec3::ZERO).is_err());
    }

    #[test]
    fn rating_has_the_interval_of_its_background() {
        let observer = GlareObserver::try_new(DVec3::ZERO, DVec3::Y).unwrap();
        let background = ReplicateEstimate { value: 10.0, error: 1.0, interval: [5.0, 20.0] };
        let rating = GlareRating {
            observer,
            background,
            sources: 1,
            glare: ReplicateEstimate::default().plus(4000.0),
        };
        assert!((rating.ugr().unwrap() - 16.0).abs() < 1e-12);
        // Half and twice the background are 8 lg 2 units.
        let [low, high] = rating.interval().unwrap();
        assert!((low - (16.0 - 2.408_24)).abs() < 1e-5 && (high - (16.0 + 2.408_24)).abs() < 1e-5);
        // A glare between nothing and twice as much.
        let glare = ReplicateEstimate { value: 4000.0, error: 1.0, interval: [-1.0, 8000.0] };
        let [low, high] = GlareRating { glare, ..rating }.interval().unwrap();
        assert!(low == f64::NEG_INFINITY && (high - (16.0 + 2.0 * 2.408_24)).abs() < 1e-5);
        assert_eq!(GlareRating { glare: ReplicateEstimate::default(), ..rating }.ugr(), None);
    }
}
