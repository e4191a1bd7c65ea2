//! Materials and textures.

use super::*;

#[test]
fn materials_of_both_versions_are_lowered() {
    for text in ["\"matte\" \"rgb Kd\" [.1 .2 .3]", "\"diffuse\" \"rgb reflectance\" [.1 .2 .3]"] {
        let MaterialKind::Diffuse(diffuse) = material(text) else { panic!("{text}") };
        assert_eq!(value(&diffuse.reflectance), [0.1, 0.2, 0.3]);
    }
    let MaterialKind::Mirror(mirror) = material("\"mirror\"") else { panic!() };
    assert_eq!(value(&mirror.reflectance), [0.9; 3]);
    for (text, index) in [
        ("\"glass\"", 1.5),
        ("\"glass\" \"float index\" 1.3", 1.3),
        ("\"dielectric\" \"float eta\" 1.8", 1.8),
        // Linear between 500 and 700 nm: at helium's 587.5618 nm it is 1.5 + 0.1 * 87.5618 / 200.
        ("\"dielectric\" \"spectrum eta\" [500 1.5 700 1.6]", 1.543_780_9),
    ] {
        close(f64::from(index_of(&material(text), false)), index);
    }
    assert!(matches!(material("\"interface\""), MaterialKind::Interface));
    assert!(matches!(material("\"\""), MaterialKind::Interface));
    let MaterialKind::Phong(phong) = material("\"phong\" \"float exponent\" 50") else { panic!() };
    assert_eq!(phong.exponent, FloatParameter::Value(50.0));
}

/// The refractive index of solid glass, or of a pane.
fn index_of(material: &MaterialKind, thin: bool) -> f32 {
    match material {
        MaterialKind::Dielectric(glass) if glass.thin == thin => match glass.eta {
            FloatParameter::Value(eta) => eta,
            FloatParameter::Texture(_) => panic!("{glass:?}"),
        },
        other => panic!("{other:?}"),
    }
}

#[test]
fn glass_by_name_has_the_index_of_its_catalogue() {
    // n_d of Schott's data sheets.
    for (name, index) in [("glass-BK7", 1.5168), ("glass-SF11", 1.784_72)] {
        let text = format!("\"dielectric\" \"spectrum eta\" \"{name}\"");
        let eta = index_of(&material(&text), false);
        assert!((f64::from(eta) - index).abs() < 1e-4, "{name}: {eta}");
    }
}

#[test]
fn metals_by_name_keep_their_spectrum_and_copper_is_the_default() {
    for (text, metal) in [
        ("\"conductor\"", "Cu"),
        ("\"metal\" \"float roughness\" 0", "Cu"),
        ("\"conductor\" \"spectrum eta\" \"metal-CuZn-eta\" \"spectrum k\" \"metal-CuZn-k\"", "CuZn"),
    ] {
        let MaterialKind::Conductor(metal_of) = material(text) else { panic!("{text}") };
        for (input, quantity) in [(metal_of.eta, "eta"), (metal_of.k, "k")] {
            let SpectrumParameter::Value(spectrum) = input else { panic!("{text}") };
            assert!(matches!(spectrum, SpectralDistribution::Sampled(_)));
            assert_eq!(Some(spectrum), named::spectrum(&format!("metal-{metal}-{quantity}")));
        }
    }
}

#[test]
fn a_name_that_is_not_built_in_is_an_error_with_the_nearest_ones() {
    for (name, help) in [
        ("metal-Ag-etta", "did you mean the built-in \"metal-Ag-eta\"?"),
        ("metal-Au", "did you mean one of the built-in \"metal-Au-eta\", \"metal-Au-k\"?"),
    ] {
        let text = format!("WorldBegin Material \"conductor\" \"spectrum eta\" \"{name}\"");
        let errors = load_str("test.pbrt", &text, &Options::default()).unwrap_err();
        let found: Vec<_> = errors.iter().map(|d| (d.kind, d.help.as_deref())).collect();
        assert_eq!(found, [("missing-file", Some(help))]);
    }
}

#[test]
fn thin_glass_is_a_pane() {
    let text =
        "Film \"rgb\" WorldBegin Material \"thindielectric\" \"float eta\" 1.3 Material \"thindielectric\"";
    let materials = read_clean(text).description.materials;
    for (material, index) in materials.iter().zip([1.3, 1.5]) {
        assert_eq!(index_of(&material.kind, true), index);
    }
}

#[test]
fn metal_of_a_reflectance_reflects_that_much_straight_back() {
    let MaterialKind::Conductor(metal) = material("\"conductor\" \"rgb reflectance\" [.2 .5 .9]") else {
        panic!()
    };
    for (lane, r) in [0.2, 0.5, 0.9].into_iter().enumerate() {
        let (n, k) = (f64::from(value(&metal.eta)[lane]), f64::from(value(&metal.k)[lane]));
        // Fresnel at normal incidence: ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2).
        close(((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k), r);
    }
}

#[test]
fn stand_ins_cause_warnings_and_strict_mode_refuses_them() {
    for (text, kind) in [
        ("Material \"plastic\"", "stand-in-material"),
        ("Material \"conductor\" \"float roughness\" .1", "stand-in-material"),
        ("Material \"matte\" \"float sigma\" 20", "stand-in-material"),
        ("Material \"uber\"", "stand-in-material"),
        ("Material \"hair\"", "stand-in-material"),
        ("Material \"fluff\"", "stand-in-material"),
        ("Shape \"curve\"", "stand-in-shape"),
        (
            "Shape \"loopsubdiv\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]",
            "stand-in-shape",
        ),
        ("Shape \"sphere\" \"float alpha\" 0", "stand-in-alpha"),
        ("LightSource \"projection\"", "stand-in-light"),
        ("LightSource \"infinite\" \"string mapname\" \"no.exr\"", "missing-file"),
        ("Texture \"t\" \"color\" \"marble\"", "stand-in-texture"),
        ("Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"no.png\"", "missing-file"),
        ("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"", "stand-in-medium"),
        ("ActiveTransform EndTime Translate 0 0 1 ActiveTransform All", "stand-in-motion"),
    ] {
        let text = format!("WorldBegin {text}");
        let loaded = read(&text);
        let kinds: Vec<_> = loaded.diagnostics.iter().map(|d| d.kind).collect();
        assert_eq!(kinds, [kind], "{text}: {}", loaded.diagnostics);
        let strict = Options { strict: true, ..Options::default() };
        let errors = load_str("test.pbrt", &text, &strict).unwrap_err();
        assert!(errors.has_errors() && errors.iter().all(|d| d.kind == kind), "{text}");
    }
}

#[test]
fn plastic_becomes_a_phong_lobe_of_equal_width() {
    let text = "\"plastic\" \"rgb Kd\" [.5 .5 .5] \"rgb Ks\" [.5 .5 .5] \"float roughness\" .1 \"bool remaproughness\" \"false\"";
    let MaterialKind::Phong(plastic) = material(text) else { panic!() };
    // alpha = 0.1: (2 / 0.01 - 2) / 4; the surface of index 1.5 reflects 4 %.
    let FloatParameter::Value(exponent) = plastic.exponent else { panic!() };
    close(f64::from(exponent), 49.5);
    assert_eq!(value(&plastic.diffuse), [0.5; 3]);
    close(f64::from(value(&plastic.specular)[0]), 0.02);
    // Light of all directions reaches the base as well.
    assert_eq!(value(&plastic.ambient), [0.5; 3]);
    let text = "\"substrate\" \"rgb Kd\" [.4 .6 .8] \"rgb Ks\" [.5 .5 .5]";
    let MaterialKind::Phong(coated) = material(text) else { panic!() };
    assert_eq!((value(&coated.ambient), value(&coated.diffuse)), ([0.2, 0.3, 0.4], [0.2, 0.3, 0.4]));
}

#[test]
fn named_materials_may_come_after_their_use() {
    let text = "Film \"rgb\" WorldBegin NamedMaterial \"later\" Shape \"sphere\" \
        MakeNamedMaterial \"later\" \"string type\" \"interface\" NamedMaterial \"later\" Shape \"sphere\"";
    let d = read_clean(text).description;
    assert_eq!(d.world.shapes[0].material, d.world.shapes[1].material);
    assert!(matches!(d.materials[d.world.shapes[0].material].kind, MaterialKind::Interface));
}

#[test]
fn a_material_made_again_leaves_earlier_shapes_alone() {
    let text = "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"mirror\" NamedMaterial \"a\" Shape \"sphere\" \
        MakeNamedMaterial \"a\" \"string type\" \"matte\" NamedMaterial \"a\" Shape \"sphere\"";
    let d = read_clean(text).description;
    let kind = |i: usize| &d.materials[d.world.shapes[i].material].kind;
    assert!(matches!(kind(0), MaterialKind::Mirror(_)));
    assert!(matches!(kind(1), MaterialKind::Diffuse(_)));
}

#[test]
fn textures_are_found_by_name_and_mapped() {
    let text = "WorldBegin Translate 1 0 0 Texture \"c\" \"color\" \"checkerboard\" \"string mapping\" \"planar\" \
        \"vector v1\" [2 0 0] \"vector v2\" [0 0 3] \"float udelta\" .5 \"rgb tex1\" [1 0 0] \
        Texture \"s\" \"color\" \"scale\" \"texture tex1\" \"c\" \"color tex2\" [.5 .5 .5] \
        Texture \"m\" \"color\" \"mix\" \"texture tex1\" \"s\" \"float amount\" .25 \
        Material \"matte\" \"texture Kd\" \"m\"";
    let d = read_clean(text).description;
    assert_eq!(d.materials[0].kind, MaterialKind::diffuse(SpectrumParameter::Texture(2)));
    let TextureKind::Checkerboard { even, odd, mapping } = &d.textures[0].kind else { panic!() };
    assert_eq!((value(even), value(odd)), ([1.0, 0.0, 0.0], [0.0; 3]));
    let MappingDescription::Planar { v1, v2, offset, to_texture } = mapping else { panic!() };
    assert_eq!((*v1, *v2, *offset), (2.0 * DVec3::X, 3.0 * DVec3::Z, DVec2::new(0.5, 0.0)));
    assert_eq!(to_texture.transform_point3(DVec3::X), DVec3::ZERO);
    assert!(matches!(&d.textures[1].kind, TextureKind::Scale(SpectrumParameter::Texture(0), _)));
    assert!(matches!(
        &d.textures[2].kind,
        TextureKind::Mix { a: SpectrumParameter::Texture(1), amount: FloatParameter::Value(0.25), .. }
    ));
}

#[test]
fn textures_of_numbers_and_colours_may_share_a_name() {
    let text = "WorldBegin Texture \"t\" \"float\" \"constant\" \"float value\" 2 Texture \"t\" \"color\" \"constant\" \
        Material \"phong\" \"texture exponent\" \"t\" \"texture Kd\" \"t\"";
    let d = read_clean(text).description;
    let MaterialKind::Phong(phong) = &d.materials[0].kind else { panic!() };
    assert_eq!(phong.diffuse, SpectrumParameter::Texture(1));
    assert_eq!(phong.exponent, FloatParameter::Texture(0));
}

#[test]
fn attributes_are_defaults_for_the_objects_of_their_block() {
    let text = "Film \"rgb\" WorldBegin AttributeBegin Attribute \"shape\" \"float radius\" 2 Shape \"sphere\" \
        Shape \"sphere\" \"float radius\" 3 AttributeEnd Shape \"sphere\"";
    let shapes = read_clean(text).description.world.shapes;
    let radius = |i: usize| match shapes[i].geometry {
        GeometryDescription::Sphere { radius, .. } => radius,
        _ => panic!(),
    };
    assert_eq!([radius(0), radius(1), radius(2)], [2.0, 3.0, 1.0]);
}
