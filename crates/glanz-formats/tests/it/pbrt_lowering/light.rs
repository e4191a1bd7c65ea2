//! Lights and colours.

use super::*;

#[test]
fn spot_lights_have_the_angles_and_falloff_of_their_version() {
    let text = |version: &str| {
        format!(
            "{version} WorldBegin LightSource \"spot\" \"rgb I\" [2 3 4] \"float coneangle\" 40 \"float conedeltaangle\" 10"
        )
    };
    for (version, expected) in
        [("Film \"image\"", SpotFalloff::Quartic), ("Film \"rgb\"", SpotFalloff::Smoothstep)]
    {
        let light = read_clean(&text(version)).description.lights.remove(0);
        let LightKind::Spot { from, to, cone_angle, inner_angle, falloff } = light.kind else { panic!() };
        assert_eq!((from, to, falloff), (DVec3::ZERO, DVec3::Z, expected));
        close(cone_angle, 40f64.to_radians());
        close(inner_angle, 30f64.to_radians());
        assert_eq!((light.emission, light.scale), (SpectralDistribution::Rgb([2.0, 3.0, 4.0]), 1.0));
    }
}

#[test]
fn black_bodies_shine_as_their_version_has_it() {
    let v3 = read_clean(
        "WorldBegin LightSource \"distant\" \"blackbody L\" [3000 1.5] \"rgb scale\" [2 2 2] WorldEnd",
    );
    let light = &v3.description.lights[0];
    assert_eq!(light.emission, SpectralDistribution::Blackbody { kelvin: 3000.0, scale: 1.5 });
    assert_eq!(light.scale, 2.0);
    let v4 =
        read_clean("Film \"rgb\" WorldBegin LightSource \"distant\" \"blackbody L\" 3000 \"float scale\" 2");
    let light = &v4.description.lights[0];
    close(f64::from(light.emission.luminance() * light.scale), 2.0);
    // The same for sampled spectra.
    let v4 = read_clean("Film \"rgb\" WorldBegin LightSource \"point\" \"spectrum I\" [400 3 700 9]");
    let light = &v4.description.lights[0];
    close(f64::from(light.emission.luminance() * light.scale), 1.0);
}

#[test]
fn power_and_illuminance_set_the_emission() {
    let light = |text: &str| {
        let loaded = read_clean(&format!("Film \"rgb\" WorldBegin LightSource {text}"));
        let light = loaded.description.lights[0].clone();
        f64::from(light.emission.luminance() * light.scale)
    };
    close(light("\"point\" \"rgb I\" [2 2 2] \"float power\" 100"), 100.0 / (4.0 * PI));
    close(light("\"point\" \"blackbody I\" 4000 \"float power\" 100 \"float scale\" 2"), 200.0 / (4.0 * PI));
    // Lux, 683 of which are a watt per square metre.
    close(light("\"distant\" \"float illuminance\" 20490"), 30.0);
    close(light("\"distant\" \"float illuminance\" 20490 \"float angle\" 5"), 30.0);
    close(light("\"infinite\" \"float illuminance\" 20490"), 30.0 / PI);
    // Cone of 60 degrees without a soft border: 2 pi (1 - 1/2) sr.
    let spot = light("\"spot\" \"float coneangle\" 60 \"float conedeltaangle\" 0 \"float power\" 10");
    close(spot, 10.0 / PI);
    // The same in lumens, 683 of which are a watt; candela are those along the axis.
    close(light("\"point\" \"rgb I\" [2 2 2] \"float lumens\" 68300"), 100.0 / (4.0 * PI));
    close(light("\"point\" \"float candela\" 1366 \"float scale\" 3"), 6.0);
    close(
        light("\"spot\" \"float coneangle\" 60 \"float conedeltaangle\" 0 \"float lumens\" 6830"),
        10.0 / PI,
    );
    close(light("\"spot\" \"blackbody I\" 3000 \"float candela\" 1366"), 2.0);
    close(light("\"point\" \"float lumens\" 0"), 0.0);
}

#[test]
fn coloured_scale_of_version_3_colours_the_light() {
    let loaded = read_clean("WorldBegin LightSource \"infinite\" \"rgb L\" [1 2 3] \"color scale\" [2 1 0]");
    assert_eq!(rgb(&loaded.description.lights[0].emission), [2.0, 2.0, 0.0]);
}

#[test]
fn area_lights_are_given_by_lumens_candela_or_nits() {
    let light = |text: &str| {
        let text = format!("Film \"rgb\" WorldBegin AreaLightSource \"diffuse\" {text} Shape \"sphere\"");
        read_clean(&text).description.world.shapes[0].emission.clone().unwrap()
    };
    assert_eq!(light("\"float lumens\" 800").power, Some(EmissionPower::Lumens(800.0)));
    assert_eq!(light("\"float candela\" 50 \"float scale\" 2").power, Some(EmissionPower::Candela(100.0)));
    let screen = light("\"rgb L\" [3 3 3] \"float nits\" 341.5 \"float scale\" 4");
    assert_eq!(screen.power, None);
    close(f64::from(screen.radiance.luminance() * screen.scale), 2.0);
}

#[test]
fn area_lights_hold_for_the_shapes_of_their_block() {
    let text = "WorldBegin AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [4 4 4] \"bool twosided\" \"true\" \
        \"integer nsamples\" 8 Shape \"sphere\" AttributeEnd Shape \"sphere\"";
    let shapes = read_clean(text).description.world.shapes;
    let light = shapes[0].emission.as_ref().unwrap();
    assert_eq!(
        (rgb(&light.radiance), light.scale, light.two_sided, light.power),
        ([4.0; 3], 1.0, true, None)
    );
    assert!(shapes[1].emission.is_none());
    let text = "Film \"rgb\" WorldBegin AreaLightSource \"diffuse\" \"float power\" 60 \"float scale\" 2 Shape \"sphere\"";
    let shapes = read_clean(text).description.world.shapes;
    assert_eq!(shapes[0].emission.as_ref().unwrap().power, Some(EmissionPower::Watts(120.0)));
}

#[test]
fn lights_in_objects_are_kept_but_not_in_objects_of_objects() {
    let object = "WorldBegin ObjectBegin \"lamp\" AreaLightSource \"diffuse\" Shape \"sphere\" ObjectEnd";
    let d = read_clean(&format!("{object} ObjectInstance \"lamp\"")).description;
    assert!(d.groups[0].shapes[0].emission.is_some());
    let text = format!("{object} ObjectBegin \"street\" ObjectInstance \"lamp\" ObjectEnd");
    let errors = load_str("test.pbrt", &text, &Options::default()).unwrap_err();
    assert_eq!(errors.iter().map(|d| d.kind).collect::<Vec<_>>(), ["instance-light"]);
}

#[test]
fn instances_copy_the_lights_of_all_triangles() {
    let mesh = format!(
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [{}]",
        "0 1 2 ".repeat(4096)
    );
    let text = |instances: usize| {
        let copies = "ObjectInstance \"lamp\" ".repeat(instances);
        format!("WorldBegin ObjectBegin \"lamp\" AreaLightSource \"diffuse\" {mesh} ObjectEnd {copies}")
    };
    // Beside the first one, 256 times 4096 are 2^20.
    assert_eq!(read_clean(&text(257)).description.world.instances.len(), 257);
    let errors = load_str("test.pbrt", &text(258), &Options::default()).unwrap_err();
    assert_eq!(errors.iter().map(|d| d.kind).collect::<Vec<_>>(), ["instance-light"]);
}

#[test]
fn light_outside_the_gamut_keeps_its_spectrum_and_takes_none_away_from_colours() {
    for version in ["Film \"image\"", "Film \"rgb\""] {
        let text = format!("{version} WorldBegin LightSource \"point\" \"blackbody I\" 1200");
        let light = read_clean(&text).description.lights.remove(0);
        assert_eq!(light.emission, SpectralDistribution::Blackbody { kelvin: 1200.0, scale: 1.0 });
        assert!(rgb(&light.emission)[2] < 0.0);
        if version.contains("rgb") {
            close(f64::from(light.emission.luminance() * light.scale), 1.0);
        }
    }
    let text = "WorldBegin LightSource \"point\" \"blackbody I\" 1200 \"rgb scale\" [1 2 3]";
    let light = read_clean(text).description.lights.remove(0);
    let [r, g, b] = rgb(&light.emission);
    assert!(r > g && g > 0.0 && b == 0.0);
}

#[test]
fn xyz_and_wide_gamut_colours_become_rec709() {
    // The white of D65 is (1, 1, 1).
    let MaterialKind::Diffuse(diffuse) = material("\"matte\" \"xyz Kd\" [.475 .5 .5445]") else { panic!() };
    for x in value(&diffuse.reflectance) {
        assert!((x - 0.5).abs() < 1e-3, "{x}");
    }
    let text = "WorldBegin ColorSpace \"rec2020\" Material \"diffuse\" \"rgb reflectance\" [.25 .25 .25]";
    let MaterialKind::Diffuse(diffuse) = &read_clean(text).description.materials[0].kind else { panic!() };
    for x in value(&diffuse.reflectance) {
        assert!((x - 0.25).abs() < 1e-6, "{x}");
    }
}

fn sky(parameters: &str) -> Vec<LightDescription> {
    read_clean(&format!("WorldBegin LightSource \"sky\" {parameters} WorldEnd")).description.lights
}

#[test]
fn sun_stands_where_the_algorithm_of_its_position_has_it() {
    // The example of @reda2003, table A5.1, without refraction: 39.872 degrees high at an azimuth of 194.340 degrees.
    let place = "\"float latitude\" 39.742476 \"float longitude\" -105.1786";
    let lights = sky(&format!("{place} \"string time\" \"2003-10-17T12:30:30-07:00\" \"float scale\" 2"));
    let [sky, sun] = &lights[..] else { panic!("{} lights", lights.len()) };
    let LightKind::Sky(description) = sky.kind else { panic!() };
    let towards = description.towards_sun;
    assert!((towards.z.asin().to_degrees() - 39.872).abs() < 3e-3, "{towards}");
    // From north over east.
    assert!((towards.x.atan2(towards.y).to_degrees() - (194.340 - 360.0)).abs() < 3e-3, "{towards}");
    let LightKind::Sun { from, to, angular_radius } = sun.kind else { panic!() };
    assert_eq!((from, to, sky.scale, sun.scale), (towards, DVec3::ZERO, 2.0, 2.0));
    assert!((2.0 * angular_radius.to_degrees() - 0.5331).abs() < 1e-4, "{angular_radius}");
    // 127.5 klx exp(-0.21 / sin 39.9 degrees) = 91.9 klx for a sky clearer than this one; at most a quarter less for haze.
    let lux = 683.0 * f64::from(sun.emission.luminance());
    assert!(lux > 69_000.0 && lux < 92_000.0, "{lux}");
}

#[test]
fn skies_are_no_more_than_16() {
    let skies = |count: usize| {
        let text = "LightSource \"sky\" \"vector3 direction\" [0 0 1]\n".repeat(count);
        load_str("test.pbrt", &format!("WorldBegin\n{text}"), &Options::default())
    };
    assert_eq!(skies(16).unwrap().description.lights.len(), 32);
    let errors = skies(17).unwrap_err().to_string();
    assert!(errors.contains("test.pbrt:18:1: light \"sky\": there are more than 16 skies"), "{errors}");
}

#[test]
fn sky_without_its_sun_is_one_light() {
    let lights = sky(
        "\"vector3 direction\" [0 3 4] \"bool sun\" false \"rgb albedo\" [.1 .2 .3] \"float turbidity\" 5",
    );
    let [LightDescription { kind: LightKind::Sky(sky), .. }] = lights[..] else { panic!() };
    close(sky.towards_sun.z, 0.8);
    assert_eq!((sky.turbidity, sky.albedo, sky.is_ground_sunlit), (5.0, [0.1, 0.2, 0.3], false));
}

#[test]
fn skies_without_a_sun_above_the_horizon_are_refused_with_their_place() {
    for (parameters, expected) in [
        ("", "the position of the sun is missing, incomplete or given twice"),
        ("\"float latitude\" 48 \"string time\" \"2026-06-21T12:00:00Z\"", "given twice"),
        ("\"vector3 direction\" [0 0 1] \"float latitude\" 48", "given twice"),
        ("\"vector3 direction\" [0 0 0]", "must not be 0"),
        ("\"vector3 direction\" [1 0 -.1]", "5.71 degrees below the horizon"),
        ("\"vector3 direction\" [0 0 1] \"float turbidity\" 11", "from 1 to 10"),
        ("\"vector3 direction\" [0 0 1] \"float albedo\" 2", "albedo"),
        ("\"float latitude\" 91 \"float longitude\" 0 \"string time\" \"2026-06-21T12:00:00Z\"", "atitude"),
        ("\"float latitude\" 48 \"float longitude\" 11 \"string time\" \"noon\"", "\"noon\""),
        (
            "\"float latitude\" 48 \"float longitude\" 11 \"string time\" \"2026-06-21T23:00:00Z\"",
            "below the horizon",
        ),
    ] {
        let text = format!("WorldBegin\nLightSource \"sky\" {parameters}\nWorldEnd");
        let message = load_str("test.pbrt", &text, &Options::default()).unwrap_err().to_string();
        assert!(message.contains(expected) && message.contains(":2:"), "{parameters}: {message}");
    }
}
