//! The table of UGR of a luminaire in standard rooms.
//!
//! A room of the width X across the line of sight and the depth Y along it, in units of H, the height of the luminaires above the eye, which is 2 m. Its three
//! surfaces are the plane of the luminaires ("ceiling"), the walls between the two planes and the reference plane at eye level. Luminaires fill it on a
//! square grid of the spacing H / 4, half a spacing from the walls. The observer stands in the middle of a wall and looks horizontally at the opposite one; crosswise
//! the axis of the luminaires is across the line of sight, endwise along it. C0 of a luminaire points at the observer crosswise, C90 endwise, if its
//! axis is in the plane C90.
//!
//! The background luminance is that of the walls without their direct light, E / pi. Exchange of light between the three surfaces is that of
//! diffuse surfaces of even brightness, with exact form factors. The direct flux to the reference plane is an integral over the intensities with the
//! luminaires spread evenly over their plane, which the rays leave in proportion to the overlap of the room with itself, shifted by the ray.
//!
//! # Source
//! @cie117, @cie190, which were not available: geometry and rooms are from documents of DIALux and of makers of luminaires. CIE 190 computes the
//! direct flux from four zones with rounded factors, and rounds transfer factors; its values may differ in the first decimal.

use std::f64::consts::PI;
use std::sync::Arc;

use glanz_light::intensity::{AngularSystem, IntensityDistribution, LuminousOpening};
use glanz_math::{DMat3, DVec2, DVec3};
use glanz_radiosity::form_factor::polygon::exchange;
use glanz_report::{Table, TableCell};

use super::glare::{GlareError, GlareObserver, unified_glare_rating};
use super::luminaire::PlacedLuminaire;

/// Height of the luminaires above the eye, metres.
pub const TABLE_HEIGHT: f64 = 2.0;

/// Spacing of the luminaires over their height above the eye.
const SPACING: f64 = 0.25;

/// Sine of the smallest angle between the horizontal and the direction to a luminaire that counts, 5 degrees, whatever its shape. No source of it was found.
const SMALLEST_ELEVATION: f64 = 0.087_155_742_747_658_17;

/// The rooms: X, and Y, in heights.
pub const TABLE_ROOMS: [[f64; 2]; 19] = [
    [2.0, 2.0],
    [2.0, 3.0],
    [2.0, 4.0],
    [2.0, 6.0],
    [2.0, 8.0],
    [2.0, 12.0],
    [4.0, 2.0],
    [4.0, 3.0],
    [4.0, 4.0],
    [4.0, 6.0],
    [4.0, 8.0],
    [4.0, 12.0],
    [8.0, 4.0],
    [8.0, 6.0],
    [8.0, 8.0],
    [8.0, 12.0],
    [12.0, 4.0],
    [12.0, 6.0],
    [12.0, 8.0],
];

/// Reflectances of ceiling, walls and reference plane.
pub const TABLE_REFLECTANCES: [[f64; 3]; 5] =
    [[0.7, 0.5, 0.2], [0.7, 0.3, 0.2], [0.5, 0.5, 0.2], [0.5, 0.3, 0.2], [0.3, 0.3, 0.2]];

/// Axis of a luminaire in its own frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LuminaireAxis {
    /// In the plane C0, as the length of files of LM-63.
    X,
    /// In the plane C90, as the length of EULUMDAT files.
    Y,
}

/// UGR of a luminaire in the standard rooms, with the flux of its file ("corrected").
#[derive(Clone, Debug, PartialEq)]
pub struct UgrTable {
    /// For each of [`TABLE_ROOMS`] and of [`TABLE_REFLECTANCES`] UGR crosswise; `None` without glare.
    pub crosswise: [[Option<f64>; 5]; 19],
    /// The same endwise.
    pub endwise: [[Option<f64>; 5]; 19],
}

impl UgrTable {
    /// The table of a luminaire that hangs in its usual position.
    ///
    /// # Errors
    /// [`GlareError::NoArea`], with `name`, for an opening without area.
    pub fn try_new(
        name: &str,
        distribution: &Arc<IntensityDistribution>,
        opening: LuminousOpening,
        axis: LuminaireAxis,
    ) -> Result<Self, GlareError> {
        let luminaire = PlacedLuminaire {
            name: name.to_owned(),
            description: None,
            distribution: Arc::clone(distribution),
            factor: 1.0,
            opening,
            position: DVec3::ZERO,
            axes: DMat3::IDENTITY,
        };
        let beams = beams(distribution);
        // The observer looks along +y: the plane C0, or C90, faces -y.
        let c0_ahead = DMat3::from_cols(DVec3::NEG_Y, DVec3::X, DVec3::Z);
        let c90_ahead = DMat3::from_cols(DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z);
        let [across, along] = match axis {
            LuminaireAxis::Y => [c0_ahead, c90_ahead],
            LuminaireAxis::X => [c90_ahead, c0_ahead],
        };
        let of = |axes: DMat3| {
            let turned = PlacedLuminaire { axes, ..luminaire.clone() };
            let mut table = [[None; 5]; 19];
            for (row, room) in table.iter_mut().zip(TABLE_ROOMS) {
                *row = row_of(&turned, &beams, room)?;
            }
            Ok(table)
        };
        Ok(Self { crosswise: of(across)?, endwise: of(along)? })
    }

    /// The table for people and programs: a row for each room.
    #[must_use]
    pub fn table(&self) -> Table {
        let columns = [
            ("x_heights", "X/H"),
            ("y_heights", "Y/H"),
            ("crosswise_70_50_20", "across 70/50/20"),
            ("crosswise_70_30_20", "70/30/20"),
            ("crosswise_50_50_20", "50/50/20"),
            ("crosswise_50_30_20", "50/30/20"),
            ("crosswise_30_30_20", "30/30/20"),
            ("endwise_70_50_20", "along 70/50/20"),
            ("endwise_70_30_20", "70/30/20"),
            ("endwise_50_50_20", "50/50/20"),
            ("endwise_50_30_20", "50/30/20"),
            ("endwise_30_30_20", "30/30/20"),
        ];
        let caption =
            "UGR in standard rooms, spacing 0.25 H, by reflectances of ceiling, walls and reference plane";
        let mut table = Table::new("ugr", caption, &columns);
        for ((room, crosswise), endwise) in TABLE_ROOMS.iter().zip(&self.crosswise).zip(&self.endwise) {
            let size = room.iter().map(|heights| TableCell::Precise(*heights));
            let ratings = crosswise.iter().chain(endwise).map(|ugr| TableCell::from(*ugr));
            table.push(size.chain(ratings));
        }
        table
    }
}

/// UGR in a room for all reflectances.
fn row_of(
    luminaire: &PlacedLuminaire,
    beams: &[(DVec3, f64)],
    room: [f64; 2],
) -> Result<[Option<f64>; 5], GlareError> {
    let size = TABLE_HEIGHT * DVec2::from_array(room);
    let observer = GlareObserver::try_new(DVec3::ZERO, DVec3::Y)?;
    let counts = room.map(|length| (length / SPACING).round() as u32);
    let spacing = SPACING * TABLE_HEIGHT;
    let mut glare = 0.0;
    for (i, j) in (0..counts[0]).flat_map(|i| (0..counts[1]).map(move |j| (i, j))) {
        let [x, y] = [i, j].map(|number| (f64::from(number) + 0.5) * spacing);
        let position = DVec3::new(x - 0.5 * size.x, y, TABLE_HEIGHT);
        if position.z < SMALLEST_ELEVATION * position.length() {
            continue;
        }
        let placed = PlacedLuminaire { position, ..luminaire.clone() };
        glare += observer.source(&placed)?.map_or(0.0, |source| source.glare());
    }
    let count = f64::from(counts[0] * counts[1]);
    let direct = direct_flux(luminaire.axes, beams, size);
    let walls = 2.0 * TABLE_HEIGHT * (size.x + size.y);
    let transfer = WallTransfer::new(size);
    Ok(TABLE_REFLECTANCES.map(|reflectances| {
        let flux: f64 =
            transfer.factors(reflectances).iter().zip(direct).map(|(factor, flux)| factor * flux).sum();
        unified_glare_rating(count * flux / walls / PI, glare)
    }))
}

/// Directions in the luminaire's frame with the flux of their cells, lm.
fn beams(distribution: &IntensityDistribution) -> Vec<(DVec3, f64)> {
    // Between whole degrees files rarely bend.
    let (gammas, planes) = (360, 144);
    let mut beams = Vec::with_capacity(gammas * planes);
    for i in 0..gammas {
        let [from, gamma, to] = [0.0, 0.5, 1.0].map(|part| (i as f64 + part) * 180.0 / gammas as f64);
        let zone = (from.to_radians().cos() - to.to_radians().cos()) * 2.0 * PI / planes as f64;
        for j in 0..planes {
            let direction = AngularSystem::C.direction((j as f64 + 0.5) * 360.0 / planes as f64, gamma);
            let candela = distribution.intensity(direction);
            if candela > 0.0 {
                beams.push((direction, candela * zone));
            }
        }
    }
    let sum: f64 = beams.iter().map(|beam| beam.1).sum();
    let whole = if sum > 0.0 { distribution.flux() / sum } else { 1.0 };
    beams.iter_mut().for_each(|beam| beam.1 *= whole);
    beams
}

/// Direct flux of a luminaire to the reference plane, the walls and the ceiling, lm, as a mean over all places in the room.
fn direct_flux(axes: DMat3, beams: &[(DVec3, f64)], size: DVec2) -> [f64; 3] {
    let mut flux = [0.0; 3];
    for &(direction, lumens) in beams {
        let direction = axes * direction;
        if direction.z >= 0.0 {
            flux[2] += lumens;
            continue;
        }
        let shift = direction.truncate().abs() * (TABLE_HEIGHT / -direction.z);
        let overlap = (DVec2::ONE - shift / size).max(DVec2::ZERO);
        let share = overlap.x * overlap.y;
        flux[0] += share * lumens;
        flux[1] += (1.0 - share) * lumens;
    }
    flux
}

/// Exchange of light in a room of three surfaces: reference plane, walls, ceiling.
struct WallTransfer {
    /// Form factors from surface to surface.
    form_factors: DMat3,
    /// Areas over that of the walls.
    areas: DVec3,
}

impl WallTransfer {
    /// `size`: of the plane, metres.
    fn new(size: DVec2) -> Self {
        let corner = |x: f64, y: f64, z: f64| DVec3::new(x * size.x, y * size.y, z * TABLE_HEIGHT);
        let plane =
            [corner(0.0, 0.0, 0.0), corner(1.0, 0.0, 0.0), corner(1.0, 1.0, 0.0), corner(0.0, 1.0, 0.0)];
        let ceiling =
            [corner(0.0, 0.0, 1.0), corner(0.0, 1.0, 1.0), corner(1.0, 1.0, 1.0), corner(1.0, 0.0, 1.0)];
        let area = size.x * size.y;
        let walls = 2.0 * TABLE_HEIGHT * (size.x + size.y);
        let opposite = exchange(&plane, &ceiling) / area;
        let to_walls = 1.0 - opposite;
        let from_walls = to_walls * area / walls;
        // Columns: to the plane, to the walls, to the ceiling.
        let form_factors = DMat3::from_cols(
            DVec3::new(0.0, from_walls, opposite),
            DVec3::new(to_walls, 1.0 - 2.0 * from_walls, to_walls),
            DVec3::new(opposite, from_walls, 0.0),
        );
        Self { form_factors, areas: DVec3::new(area / walls, 1.0, area / walls) }
    }

    /// Flux that comes to the walls after reflection, for direct flux of 1 to the plane, to the walls and to the ceiling; `reflectances` of ceiling, walls, plane.
    fn factors(&self, [ceiling, walls, plane]: [f64; 3]) -> [f64; 3] {
        let reflectance = DMat3::from_diagonal(DVec3::new(plane, walls, ceiling));
        // Illuminance E = direct + F rho E: reflected light is F rho (1 - F rho)^-1 of the direct one. Reflectances are below 1.
        let once = self.form_factors * reflectance;
        let reflected = once * (DMat3::IDENTITY - once).inverse();
        // Fluxes instead of illuminances.
        std::array::from_fn(|from| reflected.col(from).y / self.areas[from])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::test_luminaires::{lambertian, of_gamma};
    use glanz_light::intensity::OpeningShape;

    const SQUARE: LuminousOpening = LuminousOpening { shape: OpeningShape::Rectangle, size: [0.6, 0.6, 0.0] };

    #[test]
    fn transfer_to_the_walls_agrees_with_table_5_of_cie_190() {
        // The row of the room index 2.67 (4H x 8H): from the plane, the walls and the ceiling, rounded to three digits.
        let transfer = WallTransfer::new(TABLE_HEIGHT * DVec2::new(4.0, 8.0));
        for (reflectances, expected) in TABLE_REFLECTANCES.into_iter().zip([
            [0.115, 0.211, 0.307],
            [0.106, 0.117, 0.283],
            [0.100, 0.187, 0.211],
            [0.093, 0.104, 0.196],
            [0.081, 0.092, 0.114],
        ]) {
            for (found, expected) in transfer.factors(reflectances).into_iter().zip(expected) {
                assert!((found - expected).abs() < 0.0005, "{reflectances:?}: {found}, {expected}");
            }
        }
    }

    #[test]
    fn flux_of_a_lambertian_luminaire_is_shared_by_the_form_factor() {
        let size = TABLE_HEIGHT * DVec2::new(4.0, 8.0);
        let flux = direct_flux(DMat3::IDENTITY, &beams(&lambertian(1.0)), size);
        let form_factor = WallTransfer::new(size).form_factors.col(2).x;
        assert!((flux[0] / flux.iter().sum::<f64>() - form_factor).abs() < 2e-4, "{flux:?} {form_factor}");
        // Straight down: all of it.
        let narrow = of_gamma(vec![0.0, 0.5, 0.6], vec![1.0, 1.0, 0.0]);
        let flux = direct_flux(DMat3::IDENTITY, &beams(&narrow), size);
        assert!(flux[0] / flux.iter().sum::<f64>() > 0.998, "{flux:?}");
    }

    /// UGR of a Lambertian luminaire by the formulas of CIE 117 and 190 in C, gamma, written out.
    fn twin(room: [f64; 2], [ceiling, walls, plane]: [f64; 3], candela: f64) -> f64 {
        let (h, [x, y]) = (2.0_f64, room.map(|length| 2.0 * length));
        let mut sum = 0.0;
        let mut count = 0.0;
        let steps = |length: f64| (0..(length / 0.5) as usize).map(|i| 0.25 + 0.5 * i as f64);
        for t in steps(x).map(|t| t - 0.5 * x) {
            for r in steps(y) {
                count += 1.0;
                if t.abs() / r > 3.0 || h / r > 2.0 {
                    continue;
                }
                let gamma = (t.hypot(r) / h).atan();
                if gamma.to_degrees() > 85.0 {
                    continue;
                }
                // Of the constant luminance I / A.
                let luminance = candela / 0.36;
                let distance = (r * r + t * t + h * h).sqrt();
                let omega = 0.36 * gamma.cos() / distance.powi(2);
                let sigma = (r / distance).acos().to_degrees();
                let tau = (t.abs() / h).atan().to_degrees();
                let p = ((35.2 - 0.31889 * tau - 1.22 * (-2.0 * tau / 9.0).exp()) * 1e-3 * sigma
                    + (21.0 + 0.26667 * tau - 0.002963 * tau * tau) * 1e-5 * sigma * sigma)
                    .exp();
                sum += luminance * luminance * omega / (p * p);
            }
        }
        // Form factor of opposite rectangles by its closed form, and the exchange by iteration.
        let (a, b) = (x / h, y / h);
        let (a2, b2) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        let f = 2.0 / (PI * a * b)
            * ((a2 * b2 / (1.0 + a * a + b * b).sqrt()).ln()
                + a * b2 * (a / b2).atan()
                + b * a2 * (b / a2).atan()
                - a * a.atan()
                - b * b.atan());
        let (area, wall_area) = (x * y, 2.0 * h * (x + y));
        let back = (1.0 - f) * area / wall_area;
        let flux = PI * candela * count;
        let direct = [flux * f / area, flux * (1.0 - f) / wall_area, 0.0];
        let mut e = direct;
        for _ in 0..200 {
            let m = [plane * e[0], walls * e[1], ceiling * e[2]];
            e = [
                direct[0] + (1.0 - f) * m[1] + f * m[2],
                direct[1] + back * (m[0] + m[2]) + (1.0 - 2.0 * back) * m[1],
                direct[2] + f * m[0] + (1.0 - f) * m[1],
            ];
        }
        8.0 * (0.25 / ((e[1] - direct[1]) / PI) * sum).log10()
    }

    #[test]
    fn table_of_a_lambertian_luminaire_agrees_with_the_formulas_written_out() {
        let table = UgrTable::try_new("panel", &lambertian(1000.0), SQUARE, LuminaireAxis::Y).unwrap();
        for (row, room) in TABLE_ROOMS.into_iter().enumerate() {
            for (column, reflectances) in TABLE_REFLECTANCES.into_iter().enumerate() {
                let expected = twin(room, reflectances, 1000.0);
                for found in [table.crosswise[row][column], table.endwise[row][column]] {
                    let found = found.unwrap();
                    assert!(
                        (found - expected).abs() < 0.01,
                        "{room:?} {reflectances:?}: {found}, {expected}"
                    );
                }
            }
        }
        // Ten times the light is 8 units more.
        let bright = UgrTable::try_new("panel", &lambertian(10_000.0), SQUARE, LuminaireAxis::Y).unwrap();
        let more = bright.crosswise[10][0].unwrap() - table.crosswise[10][0].unwrap();
        assert!((more - 8.0).abs() < 1e-9, "{more}");
    }

    #[test]
    fn axes_turn_a_luminaire_and_one_without_an_area_is_refused() {
        // Light in the plane of C0 alone: with the axis in C90 it comes to the eye crosswise.
        let candela = |c: f64| if c == 0.0 || c == 180.0 || c == 360.0 { 1000.0 } else { 100.0 };
        let planes = [0.0, 30.0, 60.0, 90.0];
        let values: Vec<f64> = planes.iter().flat_map(|&c| vec![candela(c); 2]).collect();
        let distribution = IntensityDistribution::try_new(
            AngularSystem::C,
            glanz_light::intensity::Symmetry::Quadrants,
            &planes,
            vec![0.0, 90.0],
            values,
        );
        let distribution = Arc::new(distribution.unwrap());
        let [by_y, by_x] = [LuminaireAxis::Y, LuminaireAxis::X]
            .map(|axis| UgrTable::try_new("strip", &distribution, SQUARE, axis).unwrap());
        assert!(by_y.crosswise[8][0].unwrap() > by_y.endwise[8][0].unwrap() + 3.0);
        assert_eq!((by_y.crosswise, by_y.endwise), (by_x.endwise, by_x.crosswise));
        let refused = UgrTable::try_new("strip", &distribution, LuminousOpening::POINT, LuminaireAxis::Y);
        assert_eq!(refused, Err(GlareError::NoArea("strip".to_owned())));
    }
}
