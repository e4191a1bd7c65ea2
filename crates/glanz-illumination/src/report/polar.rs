//! Polar plots of luminous intensity, as the lighting industry draws them.

use glanz_report::Svg;
use glanz_report::number::{concise, significant, tick_label, ticks};
use glanz_report::svg::{escaped, shortened};

/// Largest angle of gamma, degrees, between points of a curve.
const STEP: f64 = 0.5;

/// The upper half is drawn if an intensity above the horizontal exceeds this fraction of the largest.
const UPWARD: f64 = 1e-3;

/// Middle of the drawing, its width, and the radius of the outermost ring; pixels.
const MIDDLE: f64 = 270.0;
const WIDTH: f64 = 540.0;
const RADIUS: f64 = 200.0;
const TOP: f64 = 56.0;

/// How the two planes are drawn: degrees of C from the first one, colour of @okabe2008, dashes.
const PLANES: [(f64, &str, &str); 2] = [(0.0, "#d55e00", ""), (90.0, "#0072b2", " stroke-dasharray=\"7 4\"")];

/// A polar plot of a candela distribution: a plane of C and the one across it over gamma, 0 degrees down, the first half of each plane to
/// the right.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarPlot {
    title: String,
    /// For each plane, C of its first and its opposite half, degrees.
    halves: [[f64; 2]; 2],
    /// Degrees, ascending from 0 to 180.
    gammas: Vec<f64>,
    /// For each plane, cd by gamma in its first and its opposite half.
    planes: [[Vec<f64>; 2]; 2],
    /// Luminous flux, lm, if the rings are to be cd/klm, too.
    flux: Option<f64>,
}

impl PolarPlot {
    /// Samples a distribution in the half planes of C `plane`, `plane` + 180, `plane` + 90 and `plane` + 270 degrees, at every half degree of
    /// gamma and at `gammas`, degrees, where it may bend in between; those outside [0, 180] are left out.
    ///
    /// `candela`: luminous intensity in cd at C in [0, 360) and gamma in [0, 180], both in degrees; negative values and those that are not finite
    /// count as 0.
    #[must_use]
    pub fn sample(
        title: impl Into<String>,
        plane: f64,
        gammas: &[f64],
        candela: impl Fn(f64, f64) -> f64,
    ) -> Self {
        let even = (0..=(180.0 / STEP) as u32).map(|step| STEP * f64::from(step));
        let own = gammas.iter().copied().filter(|gamma| (0.0..=180.0).contains(gamma));
        let mut gammas: Vec<f64> = even.chain(own).collect();
        gammas.sort_by(f64::total_cmp);
        gammas.dedup();
        let halves =
            PLANES.map(|(turn, ..)| [0.0, 180.0].map(|half| (plane + turn + half).rem_euclid(360.0)));
        let bright = |value: f64| if value > 0.0 && value.is_finite() { value } else { 0.0 };
        let half = |c: f64| gammas.iter().map(|&gamma| bright(candela(c, gamma))).collect();
        let planes = halves.map(|halves| halves.map(half));
        Self { title: title.into(), halves, gammas, planes, flux: None }
    }

    /// The plot with rings in cd/klm, and with their cd at the right, for a luminous flux in lm; a flux that is not positive and finite changes nothing.
    #[must_use]
    pub fn with_flux(self, flux: f64) -> Self {
        Self { flux: Some(flux).filter(|flux| *flux > 0.0 && flux.is_finite()), ..self }
    }

    /// Largest intensity in the two planes, cd.
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.planes.iter().flatten().flatten().copied().fold(0.0, f64::max)
    }

    /// The title.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The text of an SVG file; the same distribution gives the same text.
    #[must_use]
    pub fn svg(&self) -> String {
        let all = || self.planes.iter().flatten();
        let peak = self.peak();
        let below = self.gammas.partition_point(|&gamma| gamma <= 90.0);
        let upward = all().flat_map(|half| half.iter().skip(below)).copied().fold(0.0, f64::max);
        let is_full = upward > UPWARD * peak;
        let centre = TOP + if is_full { RADIUS + 30.0 } else { 26.0 };
        let factor = self.flux.map_or(1.0, |flux| 1000.0 / flux);
        let (rings, outermost) = rings(factor * peak);
        let bottom = centre + RADIUS + 34.0;
        let mut svg = Svg::new([WIDTH, bottom + 62.0], &self.title);
        svg.text([12.0, 26.0], "start", "font-size=\"16\"", &shortened(&self.title, 52));
        let unit = if self.flux.is_some() { "cd/klm at the left, cd at the right" } else { "cd" };
        svg.text([12.0, 46.0], "start", "", unit);
        spokes(&mut svg, centre, is_full);
        let pixels = RADIUS / outermost;
        ring_lines(&mut svg, centre, is_full, &rings, pixels);
        for (([first, opposite], name), (_, colour, dashes)) in
            self.planes.iter().zip(self.plane_names()).zip(PLANES)
        {
            let place = |(gamma, value): (&f64, &f64), side: f64| {
                let (sin, cos) = gamma.to_radians().sin_cos();
                let radius = factor * value * pixels;
                [MIDDLE + side * radius * sin, centre + radius * cos]
            };
            let shown = if is_full { first.len() } else { below };
            let right = self.gammas.iter().zip(first).take(shown).map(|at| place(at, 1.0));
            let left = self.gammas.iter().zip(opposite).take(shown).skip(1).map(|at| place(at, -1.0));
            let points: Vec<[f64; 2]> = left.rev().chain(right).collect();
            svg.element(format_args!("<g><title>{}</title>", escaped(&name)));
            svg.line(&points, colour, &format!("stroke-width=\"2.2\" stroke-linejoin=\"round\"{dashes}"));
            svg.element(format_args!("</g>"));
        }
        ring_labels(&mut svg, centre, &rings, -pixels);
        if self.flux.is_some() {
            let candela: Vec<(f64, String)> =
                rings.iter().map(|(value, _)| (*value, concise(value / factor))).collect();
            ring_labels(&mut svg, centre, &candela, pixels);
        }
        self.legend(&mut svg, bottom, peak);
        svg.finish()
    }

    /// Names of the half planes, to a tenth of a degree.
    fn names(&self) -> [[String; 2]; 2] {
        self.halves
            .map(|halves| halves.map(|c| format!("C{}", ((10.0 * c).round() / 10.0).rem_euclid(360.0))))
    }

    /// Names of the planes.
    fn plane_names(&self) -> [String; 2] {
        self.names().map(|names| names.join(" - "))
    }

    fn legend(&self, svg: &mut Svg, bottom: f64, peak: f64) {
        for (((_, colour, dashes), name), left) in
            PLANES.into_iter().zip(self.plane_names()).zip([12.0, 180.0])
        {
            svg.line(&[[left, bottom + 12.0], [left + 36.0, bottom + 12.0]], colour, dashes);
            svg.text([left + 44.0, bottom + 16.5], "start", "", &name);
        }
        let [[first, _], [across, _]] = self.names();
        let per_flux = self.flux.map(|flux| format!(", {} cd/klm", significant(1000.0 * peak / flux)));
        let largest =
            format!("Largest in these planes: {} cd{}.", significant(peak), per_flux.unwrap_or_default());
        let right = format!("0 degrees is down; {first} and {across} are at the right.");
        let words = [&largest, &right];
        for (row, words) in words.into_iter().enumerate() {
            svg.text([12.0, bottom + 38.0 + 16.0 * row as f64], "start", "font-size=\"12\"", words);
        }
    }
}

/// Values of at most five rings with labels, and the value at the outermost, which is at least `peak`.
fn rings(peak: f64) -> (Vec<(f64, String)>, f64) {
    let top = if peak > 0.0 && peak.is_finite() { peak } else { 1.0 };
    let step = ticks(0.0, top, 5.0).into_iter().find(|(value, _)| *value > 0.0).map_or(top, |(step, _)| step);
    let count = (top / step).ceil() as u32;
    let rings: Vec<(f64, String)> =
        (1..=count).map(|i| (f64::from(i) * step, tick_label(f64::from(i) * step, step))).collect();
    (rings, (f64::from(count) * step).max(top))
}

/// Lines at every 15 degrees with the angle at every 30.
fn spokes(svg: &mut Svg, centre: f64, is_full: bool) {
    let last = if is_full { 12 } else { 6 };
    for number in 0..=last {
        let gamma = 15.0 * f64::from(number);
        let (sin, cos) = gamma.to_radians().sin_cos();
        for side in [-1.0, 1.0] {
            if side < 0.0 && (number == 0 || number == 12) {
                continue;
            }
            let end = [MIDDLE + side * RADIUS * sin, centre + RADIUS * cos];
            svg.line(&[[MIDDLE, centre], end], "#c8c8c8", "stroke-width=\"1\"");
            if number % 2 == 0 {
                let place = [MIDDLE + side * (RADIUS + 20.0) * sin, centre + (RADIUS + 16.0) * cos + 4.5];
                svg.text(place, "middle", "font-size=\"12\"", &format!("{gamma:.0}\u{b0}"));
            }
        }
    }
}

/// Draws the rings.
fn ring_lines(svg: &mut Svg, centre: f64, is_full: bool, rings: &[(f64, String)], pixels: f64) {
    for (value, _) in rings {
        let radius = value * pixels;
        let (left, right) = (MIDDLE - radius, MIDDLE + radius);
        let upper = if is_full {
            format!("A{radius:.1} {radius:.1} 0 0 0 {left:.1} {centre:.1}")
        } else {
            String::new()
        };
        svg.element(format_args!(
            "<path d=\"M{left:.1} {centre:.1}A{radius:.1} {radius:.1} 0 0 0 {right:.1} {centre:.1}{upper}\" fill=\"none\" \
             stroke=\"#c8c8c8\"/>"
        ));
    }
}

/// Writes the values of the rings at the right, or, with negative `pixels` per value, at the left, between two spokes.
fn ring_labels(svg: &mut Svg, centre: f64, rings: &[(f64, String)], pixels: f64) {
    for (value, label) in rings {
        let (sin, cos) = 67.5_f64.to_radians().sin_cos();
        let place = [MIDDLE + value * pixels * sin, centre + value * pixels.abs() * cos + 4.0];
        let halo = "font-size=\"11\" class=\"halo\" fill=\"none\" stroke=\"white\" stroke-width=\"3\"";
        svg.text(place, "middle", halo, label);
        svg.text(place, "middle", "font-size=\"11\"", label);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The points of the curves, pixels.
    fn curves(svg: &str) -> Vec<Vec<[f64; 2]>> {
        let lines =
            svg.split("<g><title>").skip(1).filter_map(|g| g.split("points=\"").nth(1)?.split('"').next());
        let point = |p: &str| {
            let (x, y) = p.split_once(',').unwrap();
            [x.parse().unwrap(), y.parse().unwrap()]
        };
        lines.map(|l| l.split(' ').map(point).collect()).collect()
    }

    #[test]
    fn a_lambertian_lamp_is_a_circle_below_the_middle() {
        let polar = PolarPlot::sample("disk", 0.0, &[], |_, gamma| 500.0 * gamma.to_radians().cos().max(0.0));
        let svg = polar.svg();
        // The outermost ring of 500 cd has 200 pixels: r = 200 cos gamma is the circle of radius 100 around (270, 182).
        for curve in curves(&svg) {
            assert_eq!(curve.len(), 361);
            assert!(curve.iter().all(|[x, y]| ((x - 270.0).hypot(y - 182.0) - 100.0).abs() < 0.08));
        }
        // The upper half is omitted if no light goes up.
        assert!(
            svg.contains(">500</text>")
                && svg.contains(">90\u{b0}</text>")
                && !svg.contains(">120\u{b0}</text>")
        );
    }

    #[test]
    fn first_half_of_a_plane_is_on_the_right() {
        // 100 cd in one half plane only, also upwards.
        let polar = PolarPlot::sample("<b>", 300.0, &[], |c, _| if c == 300.0 { 100.0 } else { 0.0 });
        let svg = polar.svg();
        assert!(svg.contains("&lt;b&gt;") && svg.contains(">180\u{b0}</text>"));
        for words in [">C300 - C120<", ">C30 - C210<", "C300 and C30 are at the right"] {
            assert!(svg.contains(words), "{words}");
        }
        let [across, along] = &curves(&svg)[..] else { panic!("two curves") };
        // 100 cd on the ring of 100: 200 pixels around (270, 286), all to the right.
        assert_eq!(across.iter().map(|[x, _]| *x).fold(0.0, f64::max), 470.0);
        assert_eq!(across.iter().map(|[x, _]| *x).fold(1e9, f64::min), 270.0);
        assert!(along.iter().all(|p| *p == [270.0, 286.0]));
        assert!(!PolarPlot::sample("dark", 0.0, &[], |_, _| f64::NAN).svg().contains("NaN"));
    }

    #[test]
    fn curves_reach_the_peak_of_a_needle() {
        // Within a tenth of a degree, between the even angles.
        let needle = |_: f64, gamma: f64| if (10.2..10.3).contains(&gamma) { 50.0 } else { 0.0 };
        let found = |gammas: &[f64]| {
            PolarPlot::sample("needle", 0.0, gammas, needle).svg().contains("planes: 50.00 cd")
        };
        assert!(found(&[10.25, 200.0, f64::NAN]) && !found(&[]));
    }

    #[test]
    fn rings_in_candela_per_kilolumen_have_their_candela_at_the_right() {
        // 600 cd of 2000 lm: 300 cd/klm.
        let polar = PolarPlot::sample("lamp", 0.0, &[], |_, _| 600.0).with_flux(2000.0);
        let svg = polar.svg();
        for words in
            [">cd/klm at the left, cd at the right<", ">300<", ">600<", "planes: 600.0 cd, 300.0 cd/klm."]
        {
            assert!(svg.contains(words), "{words}: {svg}");
        }
        // All curves are the outermost ring.
        let on_ring = |[x, y]: &[f64; 2]| ((x - 270.0).hypot(y - 286.0) - 200.0).abs() < 0.08;
        assert!(curves(&svg).iter().flatten().all(on_ring));
        assert!(polar.with_flux(0.0).svg().contains(">cd<"));
        // The ring of 300 cd/klm of 411.3 lm is that of 123.39 cd.
        let odd = PolarPlot::sample("lamp", 0.0, &[], |_, _| 123.4).with_flux(411.3).svg();
        assert!(odd.contains(">123.4</text>"), "{odd}");
    }

    #[test]
    fn outermost_ring_is_a_round_number_not_below_the_peak() {
        for (peak, count, outermost) in
            [(500.0, 5, 500.0), (501.0, 3, 600.0), (0.37, 4, 0.4), (1.2e6, 3, 1.5e6)]
        {
            let (rings, outer) = rings(peak);
            assert_eq!((rings.len(), outer), (count, outermost));
        }
        assert_eq!(rings(0.0).1, 1.0);
    }
}
