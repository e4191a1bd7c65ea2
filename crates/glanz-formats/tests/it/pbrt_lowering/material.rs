//! Materials and textures.

use glanz_scene::description::DescriptionForm;
use glanz_shading::model::{MetalColor, PrincipledMaterial, Roughness, RoughnessScale};

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
        let MetalColor::Index { eta, k } = metal_of.color else { panic!() };
        for (input, quantity) in [(eta, "eta"), (k, "k")] {
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
fn metal_has_its_reflectance() {
    let MaterialKind::Conductor(metal) = material("\"conductor\" \"rgb reflectance\" [.2 .5 .9]") else {
        panic!()
    };
    assert_eq!(metal.color, MetalColor::Reflectance([0.2, 0.5, 0.9].into()));
}

/// Widths of the facets of a metal along both directions.
fn widths(text: &str) -> [f64; 2] {
    let MaterialKind::Conductor(metal) = material(text) else { panic!("{text}") };
    [metal.roughness.u, metal.roughness.v].map(|roughness| match roughness {
        FloatParameter::Value(x) => metal.roughness.scale.alpha(x),
        FloatParameter::Texture(_) => panic!(),
    })
}

#[test]
fn roughness_has_the_meaning_of_its_version() {
    assert_eq!(widths("\"conductor\""), [0.0; 2]);
    // Version 4: the square root.
    for (found, root) in widths("\"conductor\" \"float roughness\" .25").into_iter().zip([0.5, 0.5]) {
        close(found, root);
    }
    assert_eq!(widths("\"conductor\" \"float vroughness\" .25 \"bool remaproughness\" false"), [0.0, 0.25]);
    // Version 3: ln 0.1 = -2.302585: 1.62142 - 1.888017 + 0.919340 - 0.209003 + 0.018010 = 0.461750.
    let both = "\"metal\" \"float uroughness\" .1 \"float vroughness\" 1";
    for (found, alpha) in widths(both).into_iter().zip([0.46175, 1.62142]) {
        assert!((found - alpha).abs() < 2e-5, "{found}");
    }
    // Not given: 0.01.
    assert!((widths("\"metal\"")[0] - RoughnessScale::Logarithmic.alpha(0.01)).abs() < 1e-9);
    // Version 3's logarithm has no value at 0, which counts as 0.001; the width is
    // 1.62142 - 0.819955 * 6.907755 + 0.1734 * 47.71708 - 0.0171201 * 329.6179 + 0.000640711 * 2276.920 = 0.047.
    for (found, alpha) in widths("\"metal\" \"float roughness\" 0").into_iter().zip([0.047_47; 2]) {
        assert!((found - alpha).abs() < 1e-3, "{found}");
    }
    for (name, smooth) in [("plastic", false), ("uber", false), ("substrate", false), ("principled", true)] {
        let surface = principled(&format!("\"{name}\" \"float roughness\" 0")).roughness;
        assert_eq!(surface.scale.alpha(0.0) == 0.0, smooth, "{name}");
    }
    let MaterialKind::Dielectric(glass) = material("\"glass\" \"float uroughness\" 0") else { panic!() };
    assert_eq!(glass.roughness, Roughness::smooth());
}

#[test]
fn mixtures_name_their_parts_before_or_after_these() {
    let parts = "MakeNamedMaterial \"a\" \"string type\" \"mirror\" MakeNamedMaterial \"b\" \"string type\" \"diffuse\"";
    let version4 = "\"mix\" \"string materials\" [ \"a\" \"b\" ] \"float amount\" .25";
    let version3 =
        "\"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"float amount\" .75";
    for (text, film) in [(version4, "rgb"), (version3, "image")] {
        for text in [format!("Material {text} {parts}"), format!("{parts} Material {text}")] {
            let loaded = read_clean(&format!("Film \"{film}\" WorldBegin {text} Shape \"sphere\""));
            let materials = &loaded.description.materials;
            let mix = materials.iter().find_map(|material| match &material.kind {
                MaterialKind::Mix(mix) => Some(mix.clone()),
                _ => None,
            });
            let mix = mix.unwrap();
            let names = mix.materials.map(|part| materials[part].name.as_str());
            assert_eq!((names, mix.amount), (["a", "b"], 0.25.into()), "{text}");
        }
    }
    let text =
        "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"a\" ]";
    let endless = read_clean(&format!("Film \"rgb\" {text} NamedMaterial \"a\" Shape \"sphere\""));
    let error = glanz_scene::Scene::resolve(endless.description).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("a mixture of itself"), "{error}");
}

#[test]
fn stand_ins_cause_warnings_and_strict_mode_refuses_them() {
    for (text, kind) in [
        ("Material \"coateddiffuse\" \"rgb albedo\" [.1 .1 .1]", "stand-in-material"),
        ("Material \"matte\" \"float sigma\" 20", "stand-in-material"),
        ("Material \"uber\" \"float opacity\" .5", "stand-in-material"),
        ("Material \"hair\"", "stand-in-material"),
        ("Material \"fluff\"", "stand-in-material"),
        ("Shape \"curve\"", "stand-in-shape"),
        (
            "Shape \"loopsubdiv\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]",
            "stand-in-shape",
        ),
        ("LightSource \"projection\"", "stand-in-light"),
        ("LightSource \"infinite\" \"string mapname\" \"no.exr\"", "missing-file"),
        ("Texture \"t\" \"color\" \"ptex\"", "stand-in-texture"),
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
fn plastic_is_a_diffuse_base_under_its_highlight() {
    let text = "\"plastic\" \"rgb Kd\" [.5 .4 .3] \"rgb Ks\" [.2 .2 .1] \"float roughness\" .1 \"bool remaproughness\" \"false\"";
    let MaterialKind::Principled(plastic) = material(text) else { panic!() };
    assert_eq!((value(&plastic.base_color), value(&plastic.specular)), ([0.5, 0.4, 0.3], [0.2, 0.2, 0.1]));
    assert_eq!(plastic.roughness, Roughness::isotropic(0.1, RoughnessScale::Alpha));
    let MaterialKind::Principled(coated) = material("\"substrate\" \"rgb Ks\" [.04 .04 .04]") else {
        panic!()
    };
    // ((n - 1) / (n + 1))^2 = 0.04 for n = 1.5.
    let FloatParameter::Value(eta) = coated.eta else { panic!() };
    close(f64::from(eta), 1.5);
}

/// The principled material that a material becomes.
fn principled(text: &str) -> PrincipledMaterial<DescriptionForm> {
    match material(text) {
        MaterialKind::Principled(found) => found,
        other => panic!("{text}: {other:?}"),
    }
}

/// The messages about the materials of a world.
fn stand_ins(text: &str) -> Vec<String> {
    read(&format!("WorldBegin {text}")).diagnostics.iter().map(|d| d.to_string()).collect()
}

#[test]
fn coloured_substrate_reflects_its_colour_at_normal_incidence() {
    let text = "\"substrate\" \"rgb Ks\" [.01 .04 .02]";
    let coated = principled(text);
    assert_eq!(coated.eta, FloatParameter::Value(1.5));
    for (found, tint) in value(&coated.specular).into_iter().zip([0.25, 1.0, 0.5]) {
        close(found.into(), tint);
    }
    assert!(stand_ins(&format!("Material {text}")).is_empty());
    assert_eq!(principled("\"substrate\" \"float Ks\" 0").eta, FloatParameter::Value(1.0));
    let textured = "Texture \"t\" \"color\" \"checkerboard\" Material \"substrate\" \"texture Ks\" \"t\"";
    let messages = stand_ins(textured);
    assert!(messages.len() == 1 && messages[0].contains("a textured \"Ks\""), "{messages:?}");
}

#[test]
fn uber_has_an_index_by_either_name() {
    for (text, eta) in [
        ("", 1.5),
        ("\"float eta\" 1.4", 1.4),
        ("\"float index\" 1.3", 1.3),
        ("\"float index\" 1.3 \"float eta\" 1.4", 1.4),
    ] {
        let uber = principled(&format!("\"uber\" \"rgb Kd\" [.1 .2 .3] {text}"));
        assert_eq!((uber.eta, value(&uber.base_color)), (eta.into(), [0.1, 0.2, 0.3]), "{text}");
    }
}

#[test]
fn shiny_metal_is_a_rough_metal_of_its_mirror() {
    let text = "\"shinymetal\" \"rgb Kr\" [.2 .5 .9] \"float roughness\" .1";
    let MaterialKind::Conductor(metal) = material(text) else { panic!() };
    assert_eq!(metal.color, MetalColor::Reflectance([0.2, 0.5, 0.9].into()));
    assert_eq!(metal.roughness, Roughness::isotropic(0.1, RoughnessScale::Logarithmic));
    assert_eq!(stand_ins(&format!("Material {text}")).len(), 1);
}

#[test]
fn principled_material_has_its_parameters_and_defaults() {
    assert_eq!(principled("\"principled\""), PrincipledMaterial::new(0.8, 0.5));
    let text = "\"principled\" \"rgb basecolor\" [.1 .2 .3] \"float metallic\" .25 \"rgb reflectance\" [.2 .5 .9] \
        \"float uroughness\" .3 \"float vroughness\" .4 \"float eta\" 1.4 \"float specular\" .5 \"float transmission\" .75 \
        \"bool thin\" true \"float coat\" .5 \"float coat.uroughness\" .1 \"float coat.vroughness\" .2 \"float coat.eta\" 1.6 \
        \"float sheen\" .125 \"float sheen.roughness\" .4 \"bool remaproughness\" false \"bool multiplescattering\" false";
    let alpha = |u: f32, v: f32| Roughness { u: u.into(), v: v.into(), scale: RoughnessScale::Alpha };
    let expected = PrincipledMaterial {
        base_color: [0.1, 0.2, 0.3].into(),
        metallic: 0.25.into(),
        roughness: alpha(0.3, 0.4),
        eta: 1.4.into(),
        specular: 0.5.into(),
        metal: Some(MetalColor::Reflectance([0.2, 0.5, 0.9].into())),
        transmission: 0.75.into(),
        thin: true,
        coat: 0.5.into(),
        coat_roughness: alpha(0.1, 0.2),
        coat_eta: 1.6.into(),
        sheen: 0.125.into(),
        sheen_roughness: 0.4.into(),
        multiple_scattering: false,
    };
    assert_eq!(principled(text), expected);
}

#[test]
fn disney_keeps_what_the_principled_material_has() {
    let text = "\"disney\" \"rgb color\" [.25 .5 1] \"float metallic\" .5 \"float roughness\" .4 \"float eta\" 1.4 \
        \"float clearcoat\" 1 \"float clearcoatgloss\" 0 \"float sheen\" .5 \"float anisotropic\" 1";
    let made = principled(text);
    assert_eq!(
        (value(&made.base_color), made.metallic, made.eta),
        ([0.25, 0.5, 1.0], 0.5.into(), 1.4.into())
    );
    assert_eq!((made.coat, made.sheen), (0.25.into(), 0.5.into()));
    assert_eq!(made.coat_roughness, Roughness::isotropic(0.1, RoughnessScale::Alpha));
    // An aspect of sqrt(1 - 0.9): widths 0.16 / aspect and 0.16 aspect.
    let aspect = 0.1_f64.sqrt();
    for (roughness, alpha) in
        [made.roughness.u, made.roughness.v].into_iter().zip([0.16 / aspect, 0.16 * aspect])
    {
        let FloatParameter::Value(roughness) = roughness else { panic!() };
        close(RoughnessScale::Square.alpha(roughness), alpha);
    }
    assert!(stand_ins(&format!("Material {text}")).is_empty());
}

#[test]
fn a_face_of_disney_glass_transmits_the_root_of_its_colour() {
    let glass = principled("\"disney\" \"rgb color\" [.25 1 0] \"float spectrans\" 1");
    assert_eq!(value(&glass.base_color), [0.5, 1.0, 0.0]);
    for rest in ["\"float spectrans\" .5", "\"float spectrans\" 1 \"float metallic\" .5", ""] {
        assert_eq!(
            value(&principled(&format!("\"disney\" \"rgb color\" [.25 1 0] {rest}")).base_color),
            [0.25, 1.0, 0.0]
        );
    }
}

#[test]
fn what_disney_leaves_out_is_reported() {
    let texture = "Texture \"t\" \"float\" \"checkerboard\"";
    for (parameters, reported) in [
        ("", None),
        ("\"float difftrans\" .5 \"float flatness\" .5", None),
        ("\"bool thin\" true", Some("\"difftrans\"")),
        ("\"bool thin\" true \"float difftrans\" 0", None),
        ("\"bool thin\" true \"float difftrans\" 0 \"float flatness\" 1", Some("\"flatness\"")),
        ("\"float sheentint\" .5", None),
        ("\"float sheentint\" 1", Some("\"sheentint\"")),
        ("\"texture anisotropic\" \"t\"", Some("a textured \"anisotropic\"")),
        ("\"texture clearcoat\" \"t\"", Some("a textured \"clearcoat\"")),
        ("\"texture clearcoatgloss\" \"t\"", Some("a textured \"clearcoatgloss\"")),
        ("\"texture sheen\" \"t\"", Some("a textured \"sheen\"")),
        ("\"texture roughness\" \"t\"", None),
        (
            "\"texture roughness\" \"t\" \"float anisotropic\" .5",
            Some("\"anisotropic\" with a textured roughness"),
        ),
    ] {
        let messages = stand_ins(&format!("{texture} Material \"disney\" {parameters}"));
        assert_eq!(messages.len(), usize::from(reported.is_some()), "{parameters}: {messages:?}");
        assert!(messages.iter().zip(reported).all(|(message, part)| message.contains(part)), "{messages:?}");
    }
}

#[test]
fn metal_under_a_coat_has_its_index_relative_to_the_coat() {
    let metal = |text: &str| principled(&format!("\"coatedconductor\" {text}")).metal.unwrap();
    for constants in [
        "\"float conductor.eta\" .6 \"float conductor.k\" 3",
        "\"spectrum conductor.eta\" [500 .6] \"spectrum conductor.k\" [500 3]",
    ] {
        let MetalColor::Index { eta, k } = metal(&format!("{constants} \"float interface.eta\" 1.5")) else {
            panic!()
        };
        for (found, expected) in [(eta, 0.4), (k, 2.0)] {
            let SpectrumParameter::Value(found) = found else { panic!() };
            close(found.unbounded(&Wavelengths::Rgb).max_component().into(), expected);
        }
    }
    let under = metal("\"rgb reflectance\" [.2 .5 .9] \"float interface.eta\" 1.5");
    assert_eq!(under, MetalColor::Reflectance([0.2, 0.5, 0.9].into()));
}

#[test]
fn roughness_of_a_pane_is_an_unused_parameter() {
    for name in ["roughness", "remaproughness", "multiplescattering"] {
        let value =
            if name == "roughness" { "\"float roughness\" .1" } else { &format!("\"bool {name}\" false") };
        let messages = stand_ins(&format!("Material \"thindielectric\" {value}"));
        assert!(messages.len() == 1 && messages[0].contains(name), "{messages:?}");
        assert!(stand_ins(&format!("Material \"dielectric\" {value}")).is_empty());
    }
}

#[test]
fn coats_and_sheets_have_their_parameters() {
    let text = "\"coateddiffuse\" \"rgb reflectance\" [.1 .2 .3] \"float eta\" 1.7 \"float roughness\" .04";
    let MaterialKind::CoatedDiffuse(paint) = material(text) else { panic!() };
    assert_eq!((value(&paint.reflectance), paint.eta), ([0.1, 0.2, 0.3], FloatParameter::Value(1.7)));
    assert_eq!(paint.roughness, Roughness::isotropic(0.04, RoughnessScale::SquareRoot));
    let text = "\"coatedconductor\" \"float interface.roughness\" .09 \"float interface.eta\" 1.4";
    let MaterialKind::Principled(metal) = material(text) else { panic!() };
    assert!(matches!(metal.metal, Some(MetalColor::Index { .. })));
    assert_eq!((metal.metallic, metal.coat, metal.coat_eta), (1.0.into(), 1.0.into(), 1.4.into()));
    assert_eq!(metal.coat_roughness, Roughness::isotropic(0.09, RoughnessScale::SquareRoot));
    let text = "\"diffusetransmission\" \"rgb reflectance\" [.2 .4 .2] \"float scale\" .5";
    let MaterialKind::DiffuseTransmission(leaf) = material(text) else { panic!() };
    assert_eq!((value(&leaf.reflectance), value(&leaf.transmittance)), ([0.1, 0.2, 0.1], [0.125; 3]));
    let text = "\"translucent\" \"rgb Kd\" [.5 .5 .5] \"rgb reflect\" [.2 .4 .2] \"float Ks\" 0";
    let MaterialKind::DiffuseTransmission(paper) = material(text) else { panic!() };
    assert_eq!((value(&paper.reflectance), value(&paper.transmittance)), ([0.1, 0.2, 0.1], [0.25; 3]));
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
fn computed_textures_have_their_parameters_and_defaults() {
    let text = "WorldBegin Translate 1 0 0 Scale 2 2 2 Texture \"n\" \"float\" \"fbm\" \"integer octaves\" 3 \
        Texture \"d\" \"color\" \"dots\" \"texture inside\" \"n\" \"float uscale\" 4 \
        Texture \"x\" \"color\" \"directionmix\" \"vector3 dir\" [0 0 3] Texture \"b\" \"color\" \"bilerp\" \"rgb v10\" [1 0 0] \
        Texture \"m\" \"color\" \"marble\" \"float variation\" 0.5 Texture \"w\" \"float\" \"windy\" Texture \"u\" \"color\" \"uv\"";
    let textures = read_clean(text).description.textures;
    let TextureKind::Fractal { kind, mapping: MappingDescription::Solid { to_texture } } = &textures[0].kind
    else {
        panic!()
    };
    assert_eq!(*kind, FractalKind::Fbm { octaves: 3, roughness: 0.5 });
    assert_eq!(to_texture.transform_point3(DVec3::new(3.0, 2.0, 0.0)), DVec3::new(1.0, 1.0, 0.0));
    let TextureKind::Dots { inside: SpectrumParameter::Texture(0), outside, mapping } = &textures[1].kind
    else {
        panic!()
    };
    assert_eq!(value(outside), [0.0; 3]);
    assert!(matches!(mapping, MappingDescription::Uv { scale, .. } if scale.x == 4.0));
    let TextureKind::DirectionMix { along, across, direction } = &textures[2].kind else { panic!() };
    assert_eq!((value(along), value(across), direction.normalize()), ([0.0; 3], [1.0; 3], DVec3::Z));
    let TextureKind::Bilerp { corners, .. } = &textures[3].kind else { panic!() };
    let red = [1.0, 0.0, 0.0];
    assert_eq!(corners.each_ref().map(value), [[0.0; 3], [1.0; 3], red, [1.0; 3]]);
    let marble = (8, 0.5, 1.0, 0.5);
    assert!(matches!(textures[4].kind, TextureKind::Marble { octaves, roughness, scale, variation, .. }
        if (octaves, roughness, scale, variation) == marble));
    assert!(matches!(textures[5].kind, TextureKind::Fractal { kind: FractalKind::Windy, .. }));
    assert!(matches!(textures[6].kind, TextureKind::Uv(_)));
}

#[test]
fn every_material_may_have_bumps_and_every_shape_an_opacity() {
    let text = "WorldBegin Texture \"h\" \"float\" \"fbm\" Texture \"a\" \"float\" \"constant\" \"float value\" 0.5 \
        Material \"matte\" \"texture bumpmap\" \"h\" Shape \"sphere\" \"texture alpha\" \"a\" \"float shadowalpha\" 0 \
        MakeNamedMaterial \"m\" \"string type\" \"mirror\" \"texture displacement\" \"h\" NamedMaterial \"m\" \
        Shape \"sphere\" \"float alpha\" .25 Material \"matte\" \"float bumpmap\" 2 Shape \"sphere\"";
    let d = read_clean(text).description;
    let details: Vec<_> =
        d.world.shapes.iter().map(|shape| d.materials[shape.material].surface_detail).collect();
    let bump = Some(SurfaceDetailDescription::Bump(FloatParameter::Texture(0)));
    assert_eq!(details, [bump, bump, None]);
    let alphas: Vec<_> = d.world.shapes.iter().map(|shape| shape.alpha).collect();
    let first = AlphaDescription { opacity: FloatParameter::Texture(1), shadow: FloatParameter::Value(0.0) };
    assert_eq!(alphas, [Some(first), Some(FloatParameter::Value(0.25).into()), None]);
    let missing = read("WorldBegin Material \"matte\" \"string normalmap\" \"no.png\"");
    let messages = missing.diagnostics.to_string();
    assert!(messages.contains("the smooth surface stands in"), "{messages}");
    assert_eq!(missing.description.materials[0].surface_detail, None);
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
