//! Materials and their textures.

use glanz_job::{Resource, ResourceLimits};

use super::*;
use crate::load_str;

/// One colour of a picture.
fn plane(image: &glanz_scene::description::ImageDescription, colour: usize) -> Vec<f32> {
    image.picture.to_rgb().unwrap().iter().map(|rgb| rgb[colour]).collect()
}

#[test]
fn the_factor_of_the_specular_extension_applies_to_the_limited_colour() {
    let specular = json!({ "specularFactor": 0.5, "specularColorFactor": [50, 1, 0] });
    let pbr = json!({ "metallicFactor": 0, "baseColorFactor": [1, 1, 1, 1] });
    let material =
        json!({ "pbrMetallicRoughness": pbr, "extensions": { "KHR_materials_specular": specular } });
    let loaded = load(&with_material(material, json!({})));
    let MaterialKind::Principled(found) =
        &loaded.description.materials[loaded.description.world.shapes[0].material].kind
    else {
        panic!()
    };
    let SpectrumParameter::Value(SpectralDistribution::Rgb(factor)) = found.specular else { panic!() };
    let FloatParameter::Value(eta) = found.eta else { panic!() };
    let reflected = factor.map(|factor| factor * ((eta - 1.0) / (eta + 1.0)).powi(2));
    // min(0.04 * 50, 1) / 2, 0.04 / 2; the largest index is 1000.
    assert!(reflected.iter().zip([0.5, 0.02, 0.0]).all(|(a, b)| (a - b).abs() < 3e-3), "{reflected:?}");
}

#[test]
fn a_texture_may_show_one_pixel_of_its_picture_everywhere() {
    let info = json!({ "index": 0, "extensions": { "KHR_texture_transform": { "scale": [0, 0], "offset": [0.5, 0.25] } } });
    let pbr = json!({ "baseColorTexture": info, "metallicFactor": 0 });
    let textures = json!({ "textures": [{ "source": 0 }], "images": [picture()] });
    let loaded = load(&with_material(json!({ "pbrMetallicRoughness": pbr }), textures));
    assert_eq!(warnings(&loaded), "");
    assert_eq!(triangles(&loaded, 0).3.unwrap(), [DVec2::new(0.5, 0.75); 3]);
}

#[test]
fn pictures_are_taken_off_the_budget() {
    let normal = |scale: u32| json!({ "normalTexture": { "index": 0, "scale": scale } });
    let mut file = with_material(normal(1), json!({ "textures": [{ "source": 0 }], "images": [picture()] }));
    file["materials"] = json!([normal(1), normal(2), normal(3)]);
    let primitive = file["meshes"][0]["primitives"][0].clone();
    for material in 1..3 {
        let mut primitive = primitive.clone();
        primitive["material"] = json!(material);
        file["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    }
    let read = |pixels: u64| {
        let limits = ResourceLimits { pixels, ..ResourceLimits::default() };
        load_str("m", &file.to_string(), &Options { limits, ..Options::default() })
    };
    // Two pixels, three times.
    assert!(read(6).is_ok());
    let end = read(5).unwrap_err();
    assert_eq!(
        end.to_string(),
        "error: m: the limit of 5 pixels is exceeded\n  help: raise ResourceLimits::pixels\n"
    );
    assert_eq!(end.limit().unwrap().resource, Resource::Pixels);
}

#[test]
fn textures_are_upright_and_their_channels_are_split() {
    let metal = json!({ "index": 0, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } });
    let pbr = json!({
        "baseColorTexture": { "index": 0 }, "baseColorFactor": [0.5, 1, 1, 1],
        "metallicRoughnessTexture": metal, "metallicFactor": 1, "roughnessFactor": 0.5
    });
    let textures = json!({ "textures": [{ "source": 0, "sampler": 0 }], "images": [picture()], "samplers": [{ "wrapS": 33071, "wrapT": 33071 }] });
    let loaded = load(&with_material(json!({ "pbrMetallicRoughness": pbr, "name": "paint" }), textures));
    assert_eq!(warnings(&loaded), "");
    // v points down in the file, up here.
    let (.., uvs) = triangles(&loaded, 0);
    assert_eq!(uvs.unwrap(), [DVec2::new(0.0, 0.75), DVec2::new(1.0, 1.0), DVec2::new(0.0, 0.0)]);
    let description = &loaded.description;
    let shape = &description.world.shapes[0];
    assert_eq!(description.materials[shape.material].name, "paint");
    let [color, metallic, roughness] = &description.images[..] else { panic!("each content is read once") };
    assert_eq!(plane(color, 0), [1.0, 0.0]);
    // Blue and green as data: 102 / 255, 51 / 255.
    assert_eq!(plane(metallic, 0), [0.0, 0.4]);
    assert_eq!(plane(roughness, 0), [0.0, 0.2]);
    let images: Vec<_> = description
        .textures
        .iter()
        .filter_map(|texture| match texture.kind {
            TextureKind::Image { image, mapping, .. } => Some((image, mapping)),
            _ => None,
        })
        .collect();
    let uv = |scale: f64, offset: [f64; 2]| glanz_scene::description::MappingDescription::Uv {
        scale: DVec2::splat(scale),
        offset: offset.into(),
    };
    // 1 - 2 (1 - v) = 2 v - 1.
    let doubled = uv(2.0, [0.0, -1.0]);
    assert_eq!(images, [(0, uv(1.0, [0.0, 0.0])), (1, doubled), (2, doubled)]);
    let MaterialKind::Principled(found) = &description.materials[shape.material].kind else { panic!() };
    let factors: Vec<_> = description
        .textures
        .iter()
        .filter_map(|texture| match &texture.kind {
            TextureKind::Scale(_, factor) => Some(factor.clone()),
            _ => None,
        })
        .collect();
    assert_eq!(factors, [[0.5, 1.0, 1.0].into(), 0.5.into()], "of the colour and of the roughness");
    assert!(matches!(found.base_color, SpectrumParameter::Texture(_)));
    assert!(matches!(
        (found.metallic, found.roughness.u),
        (FloatParameter::Texture(_), FloatParameter::Texture(_))
    ));
}

/// The material of the only shape.
fn principled(material: Value) -> PrincipledMaterial<DescriptionForm> {
    let loaded = load(&with_material(material, json!({})));
    assert_eq!(warnings(&loaded), "");
    match &loaded.description.materials[loaded.description.world.shapes[0].material].kind {
        MaterialKind::Principled(material) => material.clone(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_parameters_of_materials_are_those_of_the_principled_one() {
    let default = principled(json!({}));
    // The default of the format is white, rough metal.
    assert_eq!(
        default,
        PrincipledMaterial {
            metallic: 1.0.into(),
            thin: true,
            sheen_roughness: 0.0.into(),
            sheen: [0.0; 3].into(),
            specular: [1.0; 3].into(),
            coat_roughness: Roughness::isotropic(0.0, RoughnessScale::Square),
            ..PrincipledMaterial::new([1.0; 3], 1.0)
        }
    );
    let extensions = json!({
        "KHR_materials_transmission": { "transmissionFactor": 0.25 },
        "KHR_materials_ior": { "ior": 1.25 },
        "KHR_materials_volume": { "thicknessFactor": 0.5 },
        "KHR_materials_specular": { "specularFactor": 0.5, "specularColorFactor": [1, 0.5, 0] },
        "KHR_materials_clearcoat": { "clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.125 },
        "KHR_materials_sheen": { "sheenColorFactor": [0.5, 0.25, 0], "sheenRoughnessFactor": 0.375 },
    });
    let pbr = json!({ "baseColorFactor": [1, 0.5, 0, 1], "metallicFactor": 0.5, "roughnessFactor": 0.625 });
    let found = principled(json!({ "pbrMetallicRoughness": pbr, "extensions": extensions }));
    let expected = PrincipledMaterial {
        metallic: 0.5.into(),
        eta: 1.25.into(),
        specular: [0.5, 0.25, 0.0].into(),
        transmission: 0.25.into(),
        thin: false,
        coat: 0.75.into(),
        coat_roughness: Roughness::isotropic(0.125, RoughnessScale::Square),
        sheen: [0.5, 0.25, 0.0].into(),
        sheen_roughness: 0.375.into(),
        ..PrincipledMaterial::new([1.0, 0.5, 0.0], 0.625)
    };
    assert_eq!(found, expected);
}

#[test]
fn glass_with_a_thickness_absorbs_to_its_colour_over_its_distance() {
    let volume = |transmission: f64, volume: Value| {
        let extensions = json!({
            "KHR_materials_transmission": { "transmissionFactor": transmission }, "KHR_materials_volume": volume
        });
        load(&with_material(json!({ "extensions": extensions }), json!({}))).description
    };
    let amber =
        json!({ "thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [1, 0.25, 0.0625] });
    let description = volume(1.0, amber.clone());
    let media: Vec<_> = description.world.shapes.iter().map(|shape| shape.media).collect();
    assert_eq!(media, [SurfaceMedia { inside: Some(0), outside: None }]);
    // 2 ln 4 and 2 ln 16 per metre.
    let absorption = description.media[0].absorption.unbounded(&Wavelengths::Rgb).to_rgb(&Wavelengths::Rgb);
    for (found, expected) in absorption.into_iter().zip([0.0, 4.0, 8.0].map(|x| x * 2.0_f32.ln())) {
        assert!((found - expected).abs() < 1e-6, "{absorption:?}");
    }
    // Without light inside, without a thickness, without an absorption.
    let thin = json!({ "attenuationDistance": 0.5, "attenuationColor": [0, 0, 0] });
    let clear = json!({ "thicknessFactor": 1, "attenuationColor": [0, 0, 0] });
    for (transmission, without) in [(0.0, amber), (1.0, thin), (1.0, clear)] {
        assert!(volume(transmission, without).media.is_empty());
    }
}

#[test]
fn the_textures_of_extensions_have_their_channels() {
    let texture = json!({ "index": 0 });
    let extensions = json!({
        "KHR_materials_transmission": { "transmissionFactor": 1, "transmissionTexture": texture },
        "KHR_materials_clearcoat": { "clearcoatFactor": 1, "clearcoatRoughnessFactor": 1, "clearcoatRoughnessTexture": texture },
        "KHR_materials_specular": { "specularColorTexture": texture },
    });
    let loaded = load(&with_material(
        json!({ "extensions": extensions }),
        json!({ "textures": [{ "source": 0 }], "images": [picture()] }),
    ));
    assert_eq!(warnings(&loaded), "");
    let description = &loaded.description;
    let MaterialKind::Principled(found) = &description.materials[1].kind else { panic!() };
    let values = |texture: usize, channel: usize| match description.textures[texture].kind {
        TextureKind::Image { image, .. } => plane(&description.images[image], channel),
        ref other => panic!("{other:?}"),
    };
    let (FloatParameter::Texture(transmission), FloatParameter::Texture(roughness)) =
        (found.transmission, found.coat_roughness.u)
    else {
        panic!()
    };
    let SpectrumParameter::Texture(specular) = found.specular else { panic!() };
    assert_eq!((values(transmission, 0), values(roughness, 0)), (vec![1.0, 0.0], vec![0.0, 0.2]));
    assert_eq!(values(specular, 0), [1.0, 0.0]);
}

#[test]
fn emission_is_the_factor_times_the_strength_times_the_texture() {
    let strength = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 8 } });
    let material = json!({
        "emissiveFactor": [0.5, 0, 0], "emissiveTexture": { "index": 0 }, "extensions": strength, "doubleSided": true
    });
    let mut file = with_material(material, json!({ "textures": [{ "source": 0 }], "images": [picture()] }));
    let loaded = load(&file);
    let emission = loaded.description.world.shapes[0].emission.clone().unwrap();
    assert_eq!(
        (emission.radiance, emission.scale, emission.two_sided),
        (SpectralDistribution::Rgb([4.0, 0.0, 0.0]), 1.0, true)
    );
    let image = emission.image.unwrap();
    assert_eq!(plane(&loaded.description.images[image], 0), [1.0, 0.0]);
    assert_eq!(warnings(&loaded), "");
    // Moved by 3 and -2 pictures, it has the same coordinates; over more than one picture, it does not repeat.
    let transform = |scale: f64, offset: [f64; 2]| json!({ "KHR_texture_transform": { "scale": [scale, scale], "offset": offset } });
    file["materials"][0]["emissiveTexture"]["extensions"] = transform(1.0, [3.0, -2.0]);
    let moved = load(&file);
    assert_eq!((triangles(&moved, 0).3, warnings(&moved).as_str()), (triangles(&loaded, 0).3, ""));
    file["materials"][0]["emissiveTexture"]["extensions"] = transform(2.0, [0.0, 0.0]);
    assert!(warnings(&load(&file)).contains("/attributes: the emissive texture does not repeat"));
}

#[test]
fn black_pictures_emit_no_light() {
    let png = crate::image::write_srgb8(1, 1, &[[0, 0, 0]]).unwrap();
    let black = json!({ "uri": format!("data:image/png;base64,{}", BASE64.encode(&png)) });
    let material = json!({ "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 } });
    let loaded = load(&with_material(material, json!({ "textures": [{ "source": 0 }], "images": [black] })));
    assert!(loaded.description.world.shapes[0].emission.is_none());
}

#[test]
fn alpha_is_an_opacity_or_decides_by_a_cutoff() {
    let alpha = |mode: &str, alpha: f64, cutoff: f64| {
        let material = json!({
            "alphaMode": mode, "alphaCutoff": cutoff, "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, alpha] }
        });
        load(&with_material(material, json!({}))).description.world.shapes[0].alpha.map(|alpha| alpha.opacity)
    };
    let value = |x: f32| Some(FloatParameter::Value(x));
    assert_eq!(alpha("OPAQUE", 0.25, 0.5), None);
    assert_eq!((alpha("BLEND", 0.25, 0.5), alpha("BLEND", 1.0, 0.5)), (value(0.25), None));
    assert_eq!((alpha("MASK", 0.5, 0.5), alpha("MASK", 0.49, 0.5)), (None, value(0.0)));
    // Of a picture: 1 + 10^4 (alpha - cutoff), which is 1 or more, or 0 or less, for alpha in steps of 1/255.
    let info = json!({ "baseColorTexture": { "index": 0 } });
    let picture = rgba_picture();
    let textures = json!({ "textures": [{ "source": 0 }], "images": [picture] });
    let material = json!({ "alphaMode": "MASK", "alphaCutoff": 0.25, "pbrMetallicRoughness": info });
    let loaded = load(&with_material(material, textures));
    let description = &loaded.description;
    let Some(FloatParameter::Texture(mask)) = description.world.shapes[0].alpha.map(|alpha| alpha.opacity)
    else {
        panic!()
    };
    let TextureKind::Mix { a, b, amount: FloatParameter::Texture(amount) } = &description.textures[mask].kind
    else {
        panic!()
    };
    assert_eq!((a, b), (&(-2499.0).into(), &7501.0.into()));
    let TextureKind::Image { image, .. } = description.textures[*amount].kind else { panic!() };
    assert_eq!(plane(&description.images[image], 0), [0.2, 1.0]);
}

/// A picture of two pixels, of alpha 51 / 255 and 1.
fn rgba_picture() -> Value {
    let mut bytes = Vec::new();
    let image = ::image::RgbaImage::from_raw(2, 1, vec![255, 255, 255, 51, 255, 255, 255, 255]).unwrap();
    image.write_to(&mut std::io::Cursor::new(&mut bytes), ::image::ImageFormat::Png).unwrap();
    json!({ "uri": format!("data:image/png;base64,{}", BASE64.encode(&bytes)) })
}

#[test]
fn maps_of_normals_are_scaled_and_share_coordinates() {
    let material = |extensions: Value| {
        json!({
            "normalTexture": { "index": 0, "scale": 2, "extensions": extensions },
            "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 },
        })
    };
    let textures = json!({ "textures": [{ "source": 0 }], "images": [picture()] });
    let loaded = load(&with_material(material(json!({})), textures.clone()));
    let description = &loaded.description;
    let Some(SurfaceDetailDescription::NormalMap(image)) = description.materials[1].surface_detail else {
        panic!()
    };
    // Components from -1 to 1: twice 1 is (3 + 1) / 2 - 1/2; green of 1/5 is -3/5, so that -6/5 is -1/10; blue stays.
    let near = |channel: usize, expected: [f32; 2]| {
        let found = plane(&description.images[image], channel);
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{channel}: {found:?}");
    };
    near(0, [1.5, -0.5]);
    near(1, [-0.5, -0.1]);
    near(2, [0.0, 0.4]);
    assert_eq!(warnings(&loaded), "");
    let other = json!({ "KHR_texture_transform": { "scale": [2, 2] } });
    let loaded = load(&with_material(material(other), textures));
    assert!(loaded.description.materials[1].surface_detail.is_none());
    assert!(warnings(&loaded).contains("/materials/0: the normal map has other coordinates"));
}
