//! Film, filter, sampler, integrator.

use glanz_scene::description::{GridSettings, GuideBasis, GuideSettings, PhotonSettings};

use super::*;

#[test]
fn silent_files_have_the_defaults_of_their_version() {
    let v3 = read_clean("Camera \"perspective\" WorldBegin WorldEnd").description;
    assert_eq!(v3.film.resolution, [640, 480]);
    assert_eq!((v3.filter.kind, v3.filter.radius), (FilterKind::Box, [0.5, 0.5]));
    let v4 = read_clean("Option \"integer seed\" 1 Camera \"perspective\" WorldBegin").description;
    assert_eq!(v4.film.resolution, [1280, 720]);
    assert_eq!((v4.filter.kind, v4.filter.radius), (FilterKind::Gaussian { sigma: 0.5 }, [1.5, 1.5]));
    for d in [v3, v4] {
        assert_eq!((d.sampler.name.as_str(), d.sampler.samples_per_pixel), ("sobol", 16));
        assert_eq!(d.camera.kind, CameraKind::Perspective { field_of_view: FRAC_PI_2 });
    }
}

#[test]
fn film_takes_size_name_and_cut() {
    let film = read_clean(
        "Film \"rgb\" \"integer xresolution\" 400 \"string filename\" \"a.exr\" \"integer pixelbounds\" [100 200 0 360]",
    )
    .description
    .film;
    assert_eq!((film.resolution, film.file_name.as_deref()), ([400, 720], Some("a.exr")));
    assert_eq!(film.crop, [0.25, 0.5, 0.0, 0.5]);
    let film = read_clean("Film \"image\" \"float cropwindow\" [.75 .25 0 1]").description.film;
    assert_eq!((film.resolution, film.crop), ([640, 480], [0.25, 0.75, 0.0, 1.0]));
}

#[test]
fn sensors_are_exposed_by_scale_speed_and_shutter() {
    let sensor = |text: &str| read_clean(text).description.film.sensor;
    assert_eq!(sensor("Film \"image\""), SensorDescription::default());
    // In version 3 the shutter does not matter, in version 4 the picture is the light that it lets pass.
    let shutter = "Camera \"perspective\" \"float shutteropen\" 1 \"float shutterclose\" 1.5";
    assert_eq!(sensor(&format!("{shutter} Film \"image\" \"float scale\" 3")).exposure, 3.0);
    assert_eq!(sensor(&format!("{shutter} Film \"rgb\"")).exposure, 0.5);
    assert_eq!(sensor(&format!("Film \"rgb\" \"float iso\" 400 {shutter}")).exposure, 2.0);
    let timed = "Film \"rgb\" \"float iso\" 50 \"float exposuretime\" 4";
    assert_eq!(sensor(&format!("{shutter} {timed}")).exposure, 2.0);
    let balanced = sensor("Film \"rgb\" \"string sensor\" \"cie1931\" \"float whitebalance\" 5000");
    assert_eq!(balanced.white_balance, Some(5000.0));
    assert_eq!(sensor("Film \"rgb\" \"float whitebalance\" 0").white_balance, None);
    assert_eq!(sensor("Film \"rgb\" \"float maxcomponentvalue\" 10").limit, SampleLimit::Component(10.0));
    // Limited before it is scaled.
    let limited = sensor("Film \"image\" \"float maxsampleluminance\" 10 \"float scale\" .5");
    assert_eq!((limited.limit, limited.exposure), (SampleLimit::Luminance(5.0), 0.5));
    let limited =
        sensor("Film \"rgb\" \"float maxsampleluminance\" 10 \"float iso\" 200 \"float exposuretime\" 3");
    assert_eq!((limited.limit, limited.exposure), (SampleLimit::Luminance(60.0), 6.0));
    let camera = read("Film \"rgb\" \"string sensor\" \"canon_eos_5d\"");
    assert!(camera.diagnostics.to_string().contains("\"cie1931\" stands in"));
    for text in ["iso", "scale", "exposuretime", "maxcomponentvalue", "diagonal", "whitebalance"] {
        let text = format!("Film \"rgb\" \"float {text}\" -1");
        assert!(load_str("test.pbrt", &text, &Options::default()).is_err(), "{text}");
    }
}

#[test]
fn filters_of_both_versions_are_one() {
    for (text, kind, radius) in [
        (
            "\"gaussian\" \"float alpha\" 8 \"float xwidth\" 3",
            FilterKind::Gaussian { sigma: 0.25 },
            [3.0, 2.0],
        ),
        ("\"gaussian\" \"float xradius\" 3", FilterKind::Gaussian { sigma: 0.5 }, [3.0, 1.5]),
        ("\"triangle\"", FilterKind::Triangle, [2.0, 2.0]),
        ("\"mitchell\" \"float B\" 0 \"float C\" .5", FilterKind::Mitchell { b: 0.0, c: 0.5 }, [2.0, 2.0]),
        ("\"box\" \"float ywidth\" 1", FilterKind::Box, [0.5, 1.0]),
        ("\"sinc\"", FilterKind::Sinc { tau: 3.0 }, [4.0, 4.0]),
        ("\"sinc\" \"float xwidth\" 2 \"float tau\" 2", FilterKind::Sinc { tau: 2.0 }, [2.0, 4.0]),
        ("\"cylinder\"", FilterKind::Cylinder, [0.5, 0.5]),
        ("\"pyramid\"", FilterKind::Pyramid, [1.0, 1.0]),
        ("\"cone\"", FilterKind::Cone, [1.0, 1.0]),
    ] {
        let filter = read_clean(&format!("PixelFilter {text}")).description.filter;
        assert_eq!((filter.kind, filter.radius), (kind, radius), "{text}");
    }
}

#[test]
fn samplers_and_integrators_have_the_names_of_the_tables() {
    for (text, name, count) in [
        ("\"halton\" \"integer pixelsamples\" 128", "sobol", 128),
        ("\"zsobol\" \"integer pixelsamples\" 3", "sobol", 3),
        ("\"random\"", "independent", 4),
        (
            "\"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 5 \"bool jitter\" true",
            "stratified",
            15,
        ),
        ("\"stratified\" \"integer pixelsamples\" 64", "stratified", 64),
        ("\"regular\" \"integer xsamples\" 2 \"integer ysamples\" 2", "regular", 4),
        ("\"center\"", "center", 1),
    ] {
        let sampler = read_clean(&format!("Sampler {text}")).description.sampler;
        assert_eq!((sampler.name.as_str(), sampler.samples_per_pixel), (name, count), "{text}");
    }
    for (text, name, depth) in [
        ("Integrator \"path\"", "path", 5),
        ("Integrator \"whitted\" \"integer maxdepth\" 9", "whitted", 9),
        ("Integrator \"radiosity\"", "radiosity", 5),
        ("Integrator \"distributed\" \"integer branching\" 4", "distributed", 5),
        ("SurfaceIntegrator \"path\" \"integer maxdepth\" 0", "path", 0),
        ("Integrator \"light\"", "light", 5),
        ("Integrator \"sppm\"", "sppm", 5),
        ("Integrator \"lightpath\" \"integer maxdepth\" 3", "light", 3),
    ] {
        let integrator = read_clean(text).description.integrator;
        assert_eq!((integrator.name.as_str(), integrator.max_depth), (name, Some(depth)), "{text}");
    }
    let branching = |text: &str| read(text).description.integrator.branching;
    assert_eq!(branching("Integrator \"path\" \"integer branching\" 4"), Some(4));
    assert_eq!(branching("Integrator \"guided\" \"integer branching\" 4"), None);
    let guide = |text: &str| read_clean(text).description.integrator.guide;
    assert_eq!(guide("Integrator \"guided\""), GuideSettings::Tree);
    let grid = GridSettings { cells: 4, basis: GuideBasis::Spline(1), ..GridSettings::default() };
    assert_eq!(
        guide("Integrator \"guided\" \"string guide\" \"grid=4,basis=spline1\""),
        GuideSettings::Grid(grid)
    );
    let photons = |text: &str| read_clean(&format!("Integrator {text}")).description.integrator.photons;
    let settings = |radius, count| PhotonSettings { radius, count };
    assert_eq!(photons("\"sppm\""), settings(None, None));
    assert_eq!(
        photons("\"sppm\" \"float radius\" 0.5 \"integer photonsperiteration\" 9"),
        settings(Some(0.5), Some(9))
    );
    assert_eq!(photons("\"sppm\" \"integer photonsperiteration\" -1"), settings(None, None));
    assert_eq!(photons("\"path\" \"float radius\" 0.5"), settings(None, None));
    // The passes of sppm are the samples per pixel.
    let unused = |name: &str| {
        read(&format!("Integrator \"{name}\" \"integer numiterations\" 9")).diagnostics.iter().count()
    };
    assert_eq!(["sppm", "path"].map(unused), [1, 0]);
    assert_eq!(read("Integrator \"directlighting\"").description.integrator.name, "whitted");
    assert_eq!(read("Integrator \"bdpt\"").description.integrator.name, "path");
}

#[test]
fn guides_that_there_are_not_are_refused_where_they_stand() {
    for (text, told) in [
        ("Integrator \"path\" \"string guide\" \"grid=4\"", "\"path\" has no guide"),
        ("Integrator \"guided\" \"string guide\" \"grid=99\"", "from 1 to 64"),
        ("Integrator \"guided\" \"string guide\" \"grid=4,basis=sine\"", "haar, spline0"),
    ] {
        let errors = load_str("test.pbrt", text, &Options::default()).unwrap_err().to_string();
        assert!(errors.contains(told) && errors.contains("test.pbrt:1:"), "{errors}");
    }
}
