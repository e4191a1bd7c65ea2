//! Contours of equal illuminance.

use glanz_report::number::significant;
use glanz_report::{ColourScale, HeatMap, levels};

use super::scale::{logarithmic_note, lux_field};
use crate::LuxMap;

/// A lux map as SVG: the colours of `scale`, contours at [`levels`] of the map's own values with their numbers, axes in
/// metres, the scale in lx, and minimum, mean, maximum and uniformity below.
///
/// The first direction of the receiver goes to the right, the second one up, as if the receiver were flat and its
/// cells of equal size; [`HeatMap`] describes the contours. The file is smaller than a megabyte.
#[must_use]
pub fn isolux(map: &LuxMap, scale: &ColourScale) -> String {
    let summary = map.summary();
    isolux_at(map, scale, &levels(summary.minimum, summary.maximum))
}

/// The drawing of [`isolux`] with contours at given levels, lx, with their labels.
#[must_use]
pub fn isolux_at(map: &LuxMap, scale: &ColourScale, levels: &[(f64, String)]) -> String {
    let drawing = HeatMap::new(&map.name, "lx", lux_field(map), *scale);
    HeatMap { levels: levels.to_vec(), caption: caption(map, scale), ..drawing }.svg()
}

/// Sentences below the map: its summary and the range of its colours.
fn caption(map: &LuxMap, scale: &ColourScale) -> Vec<String> {
    let summary = map.summary();
    let [width, height] = map.size.map(significant);
    let mut lines = vec![
        format!(
            "Minimum {} lx, mean {} lx, maximum {} lx.",
            significant(summary.minimum),
            significant(summary.mean),
            significant(summary.maximum)
        ),
        format!(
            "U0 = {} ({} to {}), U1 = {}.",
            significant(summary.u0),
            significant(summary.u0_interval[0]),
            significant(summary.u0_interval[1]),
            significant(summary.u1)
        ),
        format!("{width} m x {height} m, {} x {} cells.", map.cells[0], map.cells[1]),
    ];
    lines.extend(logarithmic_note(scale, "lx"));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::lux_scale;
    use glanz_math::DVec3;

    fn map(cells: [u32; 2], size: [f64; 2], lux: impl Fn(f64, f64) -> f64) -> LuxMap {
        let count = (cells[0] * cells[1]) as usize;
        let middle = |i: u32, axis: usize| (f64::from(i) + 0.5) / f64::from(cells[axis]) * size[axis];
        let value = |n: usize| lux(middle(n as u32 % cells[0], 0), middle(n as u32 / cells[0], 1));
        LuxMap {
            name: "a < b".into(),
            cells,
            size,
            positions: vec![DVec3::ZERO; count],
            areas: vec![size[0] * size[1] / count as f64; count],
            lux: (0..count).map(value).collect(),
            errors: vec![0.0; count],
            statistics: None,
        }
    }

    fn drawn(map: &LuxMap) -> String {
        isolux(map, &lux_scale(&[map]))
    }

    /// The points of all polylines of one stroke width, pixels.
    fn polylines(svg: &str) -> Vec<Vec<[f64; 2]>> {
        let contours = svg.split("stroke-width=\"1.1\">\n").skip(1).flat_map(|g| g.split("</g>").next());
        let lines = contours.flat_map(str::lines).filter_map(|l| l.split('"').nth(1));
        let point = |p: &str| {
            let (x, y) = p.split_once(',').unwrap();
            [x.parse().unwrap(), y.parse().unwrap()]
        };
        lines.map(|l| l.split(' ').map(point).collect()).collect()
    }

    #[test]
    fn contours_of_a_point_source_are_drawn_as_circles() {
        // 800 cd at 1 m over the middle of 4 m x 4 m, 560 pixels wide: r = sqrt((800 / E)^(2/3) - 1) metres.
        let map = map([256, 256], [4.0, 4.0], |x, y| {
            800.0 / (1.0 + (x - 2.0).powi(2) + (y - 2.0).powi(2)).powf(1.5)
        });
        let svg = drawn(&map);
        assert!(svg.len() < 1_000_000 && !svg.contains("cells are taken"), "{}", svg.len());
        let mut levels = vec![30.0_f64, 50.0, 75.0, 100.0, 150.0, 200.0, 300.0, 500.0, 750.0];
        for line in polylines(&svg) {
            // Values are constant in the outer half of the cells at the border.
            let inside = line.iter().filter(|[x, y]| (x - 346.0).abs().max((y - 332.0).abs()) < 278.0);
            let radius: Vec<f64> = inside.map(|[x, y]| (x - 346.0).hypot(y - 332.0) / 140.0).collect();
            let Some(first) = radius.first() else { continue };
            let nearest = |level: &f64| (((800.0 / level).powf(2.0 / 3.0) - 1.0).sqrt() - first).abs();
            let level = *levels.iter().min_by(|a, b| nearest(a).total_cmp(&nearest(b))).unwrap();
            let expected = ((800.0 / level).powf(2.0 / 3.0) - 1.0).sqrt();
            // A tenth of a pixel for rounding along both axes, and a margin for interpolation over cells of 2 pixels.
            assert!(
                radius.iter().all(|r| (r - expected).abs() * 140.0 < 0.15),
                "{level} {expected}: {radius:?}"
            );
            levels.retain(|l| *l != level || expected > 2.0);
        }
        // The border cuts circles of a radius above 2 m into four arcs.
        assert_eq!(levels, [30.0, 50.0]);
    }

    #[test]
    fn noise_is_averaged_with_a_note_and_drawn_in_less_than_a_megabyte() {
        // A congruential generator is random enough here.
        let seed = std::cell::Cell::new(1_u64);
        let noise = map([256, 256], [1.0, 1.0], |_, _| {
            seed.set(
                seed.get().wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407),
            );
            1.0 + (seed.get() >> 40) as f64
        });
        let svg = drawn(&noise);
        assert!(svg.len() < 1_000_000, "{}", svg.len());
        assert!(svg.contains("Contours of means over"));
    }

    #[test]
    fn maps_of_all_kinds_are_drawn() {
        let ramp = |x: f64, _: f64| 100.0 * x;
        for (cells, size, lines) in
            [([1, 9], [0.1, 3.0], 0), ([9, 1], [3.0, 0.01], 6), ([1, 1], [1.0, 1.0], 0)]
        {
            let svg = drawn(&map(cells, size, ramp));
            assert!(svg.contains("a &lt; b") && svg.contains("first direction, m"));
            assert!(polylines(&svg).len() >= lines, "{cells:?}");
        }
        let mut dark = map([8, 8], [1.0, 1.0], |_, _| 0.0);
        assert_eq!(polylines(&drawn(&dark)).len(), 0);
        dark.lux[9] = f64::NAN;
        dark.size = [0.0, f64::INFINITY];
        dark.areas.truncate(30);
        // The mean of values that are not numbers is not a number, as the caption shows; coordinates in the drawing are numbers.
        assert!(!drawn(&dark).split("Minimum").next().unwrap().contains("NaN"));
        assert!(drawn(&map([0, 0], [1.0, 1.0], ramp)).ends_with("</svg>\n"));
    }
}
