//! BSDFs: their values and the densities of their samples over angles, and what they give back of a white sky.

use glanz_light::Wavelengths;
use glanz_math::{DVec2, DVec3};
use glanz_report::{Axis, Plot, Series, Table};
use glanz_sampling::sequence::{owen, sobol};
use glanz_shading::model::{
    CoatedDiffuseMaterial, ConductorMaterial, DielectricMaterial, MetalColor, PrincipledMaterial, Roughness,
    RoughnessScale,
};
use glanz_shading::{Bsdf, BsdfSample, Material, TexturePoint, Textures, TransportMode};

use crate::report::Report;
use crate::study::{Settings, StudyError, StudyProgress};

/// Number of samples of each direction.
const SAMPLES: u32 = 1 << 12;

/// Angle of the viewer to the normal in plots of values, degrees.
const VIEW: i32 = 45;

/// Angles of the table, degrees.
const TABLE_ANGLES: [i32; 3] = [0, VIEW, 80];

const COLUMNS: [(&str, &str); 6] = [
    ("bsdf", "BSDF"),
    ("white_sky_0", "scattered at 0 degrees"),
    ("white_sky_45", "at 45 degrees"),
    ("white_sky_80", "at 80 degrees"),
    ("stated_45", "stated albedo at 45 degrees"),
    ("deviation_45", "standard deviation of the weight at 45 degrees"),
];

/// A grey BSDF, with its name in files and in words.
struct PlottedBsdf<'a> {
    name: &'static str,
    title: &'static str,
    bsdf: Bsdf<'a>,
}

/// Runs the study.
///
/// # Errors
/// [`StudyError::Interrupted`].
pub(crate) fn run(settings: &Settings, progress: &mut StudyProgress<'_>) -> Result<Report, StudyError> {
    let materials = plotted_materials();
    let plotted = plotted_bsdfs(&materials);
    let caption =
        format!("Fraction of light that BSDFs scatter, and the weights of samples: {SAMPLES} Sobol' points.");
    let mut summary = Table::new("summary", caption, &COLUMNS);
    for shown in &plotted {
        settings.cancel.check()?;
        let [above, view, grazing] = TABLE_ANGLES.map(|angle| Weights::measure(&shown.bsdf, angle));
        let stated = f64::from(shown.bsdf.albedo(direction(VIEW)).max_component());
        let numbers = [above.total(), view.total(), grazing.total(), stated, view.deviation()];
        summary.push(std::iter::once(shown.title.into()).chain(numbers.map(Into::into)));
    }
    let mut report = Report::new("Study bsdfs: values, densities of samples, white skies", summary);
    report.paragraph(format!(
        "*Values* are f |cos| in the plane of incidence for a viewer at {VIEW} degrees to the normal, *densities* those that \
         samples state; both without delta lobes and divided by their integrals. Where they agree, samples have equal \
         weights. Angles are those to the normal, negative on the side of the viewer, beyond 90 degrees on the other side \
         of the surface. *White sky*: the mean weight of samples, as flux, for a viewer at each angle."
    ));
    for (i, shown) in plotted.iter().enumerate() {
        settings.cancel.check()?;
        progress.report(i as f64 / plotted.len() as f64, shown.title);
        report.heading(shown.title);
        if !shown.bsdf.is_delta() {
            let caption = format!("Values and densities of samples: {}.", shown.title);
            report.plot(format!("{}_values", shown.name), value_plot(shown), caption);
        }
        let caption = format!("Light of a white sky by the angle of the viewer: {}.", shown.title);
        report.plot(format!("{}_sky", shown.name), sky_plot(shown), caption);
    }
    Ok(report)
}

/// A material, with the name of its BSDF in files and in words.
type PlottedMaterial = (&'static str, &'static str, Material);

fn plotted_materials() -> [PlottedMaterial; 16] {
    let rough = |alpha: f32| Roughness::isotropic(alpha, RoughnessScale::Alpha);
    let metal = |alpha| ConductorMaterial {
        color: MetalColor::Reflectance(0.9.into()),
        roughness: rough(alpha),
        multiple_scattering: true,
        finish: None,
    };
    let white_metal = ConductorMaterial { color: MetalColor::Reflectance(1.0.into()), ..metal(0.3) };
    let glass = |alpha| DielectricMaterial {
        eta: 1.5.into(),
        reflectance: 1.0.into(),
        transmittance: 1.0.into(),
        thin: false,
        dispersion: None,
        roughness: rough(alpha),
        multiple_scattering: true,
    };
    let varnish = |alpha| CoatedDiffuseMaterial {
        reflectance: 0.8.into(),
        eta: 1.5.into(),
        roughness: rough(alpha),
        multiple_scattering: true,
    };
    let mut paint = PrincipledMaterial::new(0.8, 0.6);
    (paint.coat, paint.coat_roughness) = (1.0.into(), rough(0.05));
    let mut cloth = PrincipledMaterial::new(0.3, 0.8);
    (cloth.sheen, cloth.sheen_roughness) = (0.8.into(), 0.5.into());
    let mut wax = PrincipledMaterial::new(0.8, 0.5);
    wax.transmission = 0.5.into();
    [
        ("lambert", "Lambert's law, reflectance 0.8", Material::diffuse(0.8)),
        ("oren_nayar", "grooves of 20 degrees, reflectance 0.8", Material::oren_nayar(0.8, 20.0)),
        (
            "phong",
            "Phong model, 0.4 diffuse, 0.4 specular, exponent 20",
            Material::phong(0.0, 0.4, 0.4, 20.0),
        ),
        ("mirror", "mirror, reflectance 0.9", Material::mirror(0.9)),
        ("conductor", "smooth metal, reflectance 0.9", metal(0.0).into()),
        ("rough_conductor", "metal with facets of width 0.3, reflectance 0.9", metal(0.3).into()),
        ("white_rough_conductor", "metal with facets of width 0.3, reflectance 1", white_metal.into()),
        ("dielectric", "smooth glass, index 1.5", glass(0.0).into()),
        ("rough_dielectric", "glass with facets of width 0.3, index 1.5", glass(0.3).into()),
        ("thin_dielectric", "pane of glass, index 1.5", Material::thin_dielectric(1.5, 1.0, 1.0)),
        ("coated_diffuse", "smooth coat over a diffuse base of 0.8", varnish(0.0).into()),
        (
            "rough_coated_diffuse",
            "coat with facets of width 0.3 over a diffuse base of 0.8",
            varnish(0.3).into(),
        ),
        (
            "diffuse_transmission",
            "sheet, reflectance 0.5, transmittance 0.3",
            Material::diffuse_transmission(0.5, 0.3),
        ),
        ("principled_paint", "principled: colour 0.8, roughness 0.6, coat", paint.into()),
        ("principled_cloth", "principled: colour 0.3, roughness 0.8, sheen 0.8", cloth.into()),
        ("principled_wax", "principled: colour 0.8, roughness 0.5, transmission 0.5", wax.into()),
    ]
}

fn plotted_bsdfs(materials: &[PlottedMaterial]) -> Vec<PlottedBsdf<'_>> {
    let (textures, at) = (Textures::new(), TexturePoint::new(DVec2::ZERO, DVec3::ZERO));
    let shown = materials.iter().filter_map(|&(name, title, ref material)| {
        let bsdf = material.bsdf(&textures, &at, &Wavelengths::Rgb)?;
        Some(PlottedBsdf { name, title, bsdf })
    });
    shown.collect()
}

/// The unit direction in the plane of incidence at an angle to the normal, degrees, negative on the side of the viewer.
fn direction(degrees: i32) -> DVec3 {
    let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
    DVec3::new(sin, 0.0, cos)
}

/// Sums of the weights of samples, in flux.
#[derive(Default)]
struct Weights {
    reflected: f64,
    transmitted: f64,
    /// Of samples without delta lobes.
    smooth: f64,
    /// Number of samples without delta lobes.
    smooth_count: f64,
    /// Squares of all weights.
    squares: f64,
}

impl Weights {
    /// For a viewer at this angle to the normal, degrees.
    fn measure(bsdf: &Bsdf<'_>, angle: i32) -> Self {
        let mut sums = Self::default();
        for i in 0..SAMPLES {
            let [x, y, lobe] =
                [0, 1, 2].map(|k| owen::unit(sobol::coordinate(i, k)) + 0.5 / f64::from(SAMPLES));
            let sample = bsdf.sample(direction(-angle), DVec2::new(x, y), lobe, TransportMode::Importance);
            sample.iter().for_each(|sample| sums.add(sample));
        }
        sums
    }

    fn add(&mut self, sample: &BsdfSample) {
        let weight = f64::from(sample.weight.max_component());
        *(if sample.lobe.transmission { &mut self.transmitted } else { &mut self.reflected }) += weight;
        self.squares += weight * weight;
        if !sample.lobe.is_delta() {
            self.smooth += weight;
            self.smooth_count += 1.0;
        }
    }

    fn total(&self) -> f64 {
        (self.reflected + self.transmitted) / f64::from(SAMPLES)
    }

    fn deviation(&self) -> f64 {
        (self.squares / f64::from(SAMPLES) - self.total().powi(2)).max(0.0).sqrt()
    }
}

fn value_plot(shown: &PlottedBsdf<'_>) -> Plot {
    let (bsdf, wo, weights) = (&shown.bsdf, direction(-VIEW), Weights::measure(&shown.bsdf, VIEW));
    let end = if bsdf.transmits() { 180 } else { 90 };
    let curve = |name: &str, share: f64, value: &dyn Fn(DVec3) -> f64| Series {
        name: name.to_owned(),
        // Along the surface the cosine is 0 but for rounding.
        points: (1 - end..end)
            .filter(|angle: &i32| angle.abs() != 90)
            .map(|angle| [f64::from(angle), value(direction(angle)) * f64::from(SAMPLES) / share])
            .collect(),
    };
    let flux = |wi: DVec3| f64::from((bsdf.eval(wo, wi) * bsdf.eta_scale(wo, wi)).max_component());
    Plot {
        title: shown.title.to_owned(),
        x: Axis::linear("angle of the light to the normal, degrees"),
        y: Axis::logarithmic("per steradian"),
        series: vec![
            curve("value", weights.smooth, &flux),
            curve("density of samples", weights.smooth_count, &|wi| bsdf.pdf(wo, wi).0),
        ],
        reference_lines: Vec::new(),
    }
}

fn sky_plot(shown: &PlottedBsdf<'_>) -> Plot {
    let angles = || (0..90).step_by(3).chain([89]);
    let measured: Vec<_> =
        angles().map(|angle| (f64::from(angle), Weights::measure(&shown.bsdf, angle))).collect();
    let curve = |name: &str, value: &dyn Fn(&Weights) -> f64| Series {
        name: name.to_owned(),
        points: measured
            .iter()
            .map(|(angle, weights)| [*angle, value(weights) / f64::from(SAMPLES)])
            .collect(),
    };
    let mut series = vec![curve("reflected", &|weights| weights.reflected)];
    if measured.iter().any(|(_, weights)| weights.transmitted > 0.0) {
        series.push(curve("transmitted", &|weights| weights.transmitted));
        series.push(curve("both", &|weights| weights.reflected + weights.transmitted));
    }
    Plot {
        title: shown.title.to_owned(),
        x: Axis::linear("angle of the viewer to the normal, degrees"),
        y: Axis::linear("fraction of the light"),
        series,
        reference_lines: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lambert_has_its_cosine_and_glass_gives_back_the_sky() {
        let materials = plotted_materials();
        let plotted = plotted_bsdfs(&materials);
        let find = |name: &str| plotted.iter().find(|shown| shown.name == name).unwrap();
        let plot = value_plot(find("lambert"));
        for series in &plot.series {
            let [angle, value] = series.points[149];
            assert_eq!(angle, 60.0);
            assert!((value - 0.5 / std::f64::consts::PI).abs() < 1e-6, "{}: {value}", series.name);
        }
        for (name, curve) in
            [("dielectric", 2), ("thin_dielectric", 2), ("rough_dielectric", 2), ("white_rough_conductor", 0)]
        {
            let plot = sky_plot(find(name));
            assert!(plot.series[curve].points.iter().all(|point| (point[1] - 1.0).abs() < 0.04), "{name}");
        }
    }
}
