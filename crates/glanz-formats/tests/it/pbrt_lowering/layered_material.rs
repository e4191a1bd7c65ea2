//! Materials of several layers.

use glanz_scene::SceneBuilder;
use glanz_scene::description::{DescriptionForm, ShapeDescription};
use glanz_shading::model::{MetalColor, PrincipledMaterial, Roughness, RoughnessScale};
use glanz_shading::texture::TexturePoint;

use super::*;

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
pub(super) fn principled(text: &str) -> PrincipledMaterial<DescriptionForm> {
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

/// The parts of the first material that is a mixture, with the probability of the second.
fn parts(text: &str) -> ([MaterialKind; 2], f32) {
    let materials = read_clean(&format!("WorldBegin Material {text}")).description.materials;
    let mix = materials.iter().rev().find_map(|m| match &m.kind {
        MaterialKind::Mix(mix) => Some(mix.clone()),
        _ => None,
    });
    let mix = mix.unwrap();
    let FloatParameter::Value(amount) = mix.amount else { panic!("{mix:?}") };
    (mix.materials.map(|index| materials[index].kind.clone()), amount)
}

fn closes(found: [f32; 3], expected: [f32; 3]) {
    found.into_iter().zip(expected).for_each(|(a, b)| close(a.into(), b.into()));
}

#[test]
fn opacity_of_uber_lets_light_pass_straight() {
    let ([opaque, pane], amount) = parts("\"uber\" \"rgb Kd\" [.4 .3 .2] \"rgb opacity\" [.8 .8 .8]");
    close(amount.into(), 0.2);
    let (MaterialKind::Principled(opaque), MaterialKind::Dielectric(pane)) = (opaque, pane) else { panic!() };
    assert_eq!(value(&opaque.base_color), [0.4, 0.3, 0.2]);
    assert_eq!((pane.thin, pane.eta, value(&pane.transmittance)), (true, 1.0.into(), [1.0; 3]));
}

/// Light that a mixture reflects and passes in all, seen along its normal, by the mean of its parts.
fn albedo_of_mix(text: &str) -> [f32; 3] {
    let (materials, amount) = parts(text);
    let albedo = materials.map(|kind| {
        let (scene, _) = SceneBuilder::new().shape(ShapeDescription::sphere(1.0), kind).resolve().unwrap();
        let at = TexturePoint::new(DVec2::ZERO, DVec3::ZERO);
        let bsdf = scene.materials()[0].bsdf(scene.textures(), &at, &Wavelengths::Rgb).unwrap();
        bsdf.albedo(DVec3::Z).to_rgb(&Wavelengths::Rgb)
    });
    [0, 1, 2].map(|i| (1.0 - amount) * albedo[0][i] + amount * albedo[1][i])
}

#[test]
fn coloured_opacity_of_uber_passes_and_scatters_what_version_3_adds_up() {
    // 1 - opacity passes, and opacity times Kd is scattered.
    closes(
        albedo_of_mix("\"uber\" \"float Kd\" .4 \"float Ks\" 0 \"rgb opacity\" [.3 .5 .7]"),
        [0.3, 0.5, 0.7].map(|opacity| 1.0 - opacity + opacity * 0.4),
    );
    // The pane would have to be selected with a probability of .9, the rest with one of .9.
    let messages = stand_ins("Material \"uber\" \"float Kd\" 1 \"rgb opacity\" [.1 .9 .9]");
    assert!(messages.len() == 1 && messages[0].contains("coloured opacity"), "{messages:?}");
}

#[test]
fn parts_of_sums_have_their_colours_divided_by_their_probability() {
    let ([plastic, glass], amount) = parts(
        "\"uber\" \"rgb Kd\" [.2 .1 .1] \"rgb Ks\" [.3 .3 .3] \"rgb Kr\" [.1 .2 .2] \"rgb Kt\" [.1 0 .1] \"float index\" 1.4",
    );
    let (MaterialKind::Principled(plastic), MaterialKind::Dielectric(glass)) = (plastic, glass) else {
        panic!()
    };
    closes(value(&plastic.base_color).map(|x| x * (1.0 - amount)), [0.2, 0.1, 0.1]);
    closes(value(&plastic.specular).map(|x| x * (1.0 - amount)), [0.3; 3]);
    closes(value(&glass.reflectance).map(|x| x * amount), [0.1, 0.2, 0.2]);
    closes(value(&glass.transmittance).map(|x| x * amount), [0.1, 0.0, 0.1]);
    assert_eq!((glass.eta, plastic.eta), (1.4.into(), 1.4.into()));
    let ([sheet, glass], amount) = parts("\"translucent\" \"rgb Kd\" [.5 .3 .3] \"float transmit\" .25");
    let (MaterialKind::DiffuseTransmission(sheet), MaterialKind::Dielectric(glass)) = (sheet, glass) else {
        panic!()
    };
    closes(value(&sheet.reflectance).map(|x| x * (1.0 - amount)), [0.25, 0.15, 0.15]);
    closes(value(&sheet.transmittance).map(|x| x * (1.0 - amount)), [0.125, 0.075, 0.075]);
    closes(value(&glass.reflectance).map(|x| x * amount), [0.125; 3]);
    closes(value(&glass.transmittance).map(|x| x * amount), [0.0625; 3]);
    assert_eq!(
        (glass.eta, glass.roughness),
        (1.5.into(), Roughness::isotropic(0.1, RoughnessScale::Logarithmic))
    );
    // What would create light is scaled down.
    let ([plastic, glass], amount) = parts("\"uber\" \"rgb Kd\" [.8 .2 .1] \"float Kr\" .8");
    let (MaterialKind::Principled(plastic), MaterialKind::Dielectric(glass)) = (plastic, glass) else {
        panic!()
    };
    close(amount.into(), 0.5);
    closes(value(&plastic.base_color), [1.0, 0.25, 0.125]);
    closes(value(&glass.reflectance), [1.0; 3]);
    // Of textures it is clamped where it is used.
    let text =
        "Texture \"t\" \"color\" \"checkerboard\" Material \"uber\" \"texture Kd\" \"t\" \"float Kr\" 1";
    let d = read_clean(&format!("WorldBegin {text}")).description;
    let scales = d.textures.iter().filter_map(|texture| match &texture.kind {
        TextureKind::Scale(_, SpectrumParameter::Value(factor)) => Some(rgb(factor)),
        _ => None,
    });
    assert_eq!(scales.collect::<Vec<_>>(), [[2.0; 3]]);
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
