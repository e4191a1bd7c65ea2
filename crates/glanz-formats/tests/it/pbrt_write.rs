//! Models as scene files.

use glanz_formats::pbrt::write;
use glanz_formats::{Loaded, Options, load_str};
use glanz_geometry::curve::CurveShading;
use glanz_light::SpectralDistribution;
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::Description;
use glanz_scene::description::*;
use glanz_scene::studio::UpAxis;
use glanz_shading::model::{
    ConductorMaterial, DielectricMaterial, FinishModel, MetalColor, MirrorMaterial, PrincipledMaterial,
    Roughness, RoughnessScale, SurfaceFinish,
};
use proptest::prelude::*;

use crate::step_shape::lamp;

fn read(text: &str) -> Loaded {
    let loaded = load_str("model.pbrt", text, &Options::default()).unwrap_or_else(|d| panic!("{d}\n{text}"));
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
    loaded
}

/// All that counts of a description: its text form without places and names of materials and occurrences. Two texts are the same if all numbers have
/// the same bits, but for the sign of zero.
fn content(description: &Description) -> String {
    let mut plain = description.clone();
    plain.files.clear();
    plain.film.location = None;
    plain.camera.location = None;
    for medium in &mut plain.media {
        (medium.name, medium.location) = (String::new(), None);
    }
    for material in &mut plain.materials {
        (material.name, material.location) = (String::new(), None);
    }
    for group in plain.groups.iter_mut().chain([&mut plain.world]) {
        group.shapes.iter_mut().for_each(|shape| shape.location = None);
        for instance in &mut group.instances {
            (instance.name, instance.location) = (String::new(), None);
        }
    }
    format!("{plain:?}")
}

fn assert_same(description: &Description) {
    let text = write(description, UpAxis::Z).unwrap();
    let loaded = read(&text);
    assert_eq!(content(&loaded.description), content(description), "{text}");
    assert_eq!(loaded.studio.unwrap().up, Some(UpAxis::Z));
}

fn model(shapes: Vec<ShapeDescription>) -> Description {
    Description {
        materials: vec![MaterialDescription::from(MaterialKind::diffuse(0.3))],
        world: GroupDescription { shapes, ..GroupDescription::default() },
        ..Description::default()
    }
}

/// A shape of every kind with these numbers, which are positive and below 6.
fn shapes(n: [f64; 6]) -> Vec<ShapeDescription> {
    let [a, b, c, d, e, phi_max] = n;
    let z = [-a, b];
    let (p, q, r) = (DVec3::new(a, -b, c), DVec3::new(-d, e, a), DVec3::new(b, c, -d));
    let point = |p: DVec3, w: f64| (p * w).extend(w).to_array();
    let net = |count: usize| (0..count).map(|i| point(p * (i + 1) as f64, a + i as f64)).collect::<Vec<_>>();
    let knots = vec![0.0, 0.0, 0.0, a, a + b, a + b, a + b];
    let nurbs = NurbsDescription {
        degree_u: 2,
        degree_v: 1,
        knots_u: knots,
        knots_v: vec![-c, -c, d, d],
        points: net(8),
        domain: Some([[0.0, a], [-c, 0.5 * d]]),
    };
    let patches = BezierPatchesDescription { degree_u: 2, degree_v: 1, patches: vec![net(6), net(6)] };
    let triangles = BezierTrianglesDescription { degree: 2, patches: vec![net(6)] };
    let positions = vec![p, q, r, p + q];
    let kinds = vec![
        GeometryDescription::Sphere { radius: a + b, z, phi_max },
        GeometryDescription::Cylinder { radius: a, z, phi_max },
        GeometryDescription::Cone { radius: a, height: b, phi_max },
        GeometryDescription::Paraboloid { radius: a, z: [b, b + c], phi_max },
        GeometryDescription::Hyperboloid { p1: p, p2: q, phi_max },
        GeometryDescription::TwoSheetedHyperboloid { a, c, z: [c, c + d], phi_max },
        GeometryDescription::Disk { height: -a, radius: b + c, inner_radius: c, phi_max },
        GeometryDescription::Plane { x: z, y: [c, c + d] },
        GeometryDescription::Plane { x: [f64::NEG_INFINITY, f64::INFINITY], y: z },
        GeometryDescription::Algebraic {
            terms: vec![([2, 0, 1], a), ([0, 0, 0], -b)],
            clip: [-p.abs(), q.abs()],
        },
        GeometryDescription::Torus { major_radius: a, minor_radius: b, phi_max },
        GeometryDescription::Polyhedron { half_spaces: vec![(p, a), (q, b), (r, c)] },
        GeometryDescription::Cuboid { min: -p.abs(), max: q.abs() },
        GeometryDescription::Triangles {
            positions: positions.clone(),
            indices: vec![[0, 1, 2], [1, 3, 2]],
            normals: Some(positions.clone()),
            uvs: Some(vec![DVec2::new(a, -b); 4]),
        },
        GeometryDescription::Bilinear { positions, indices: vec![[0, 1, 2, 3]] },
        GeometryDescription::Nurbs(nurbs),
        GeometryDescription::BezierPatches(patches),
        GeometryDescription::BezierTriangles(triangles),
        GeometryDescription::Curve {
            points: vec![p, q, r, p],
            widths: [b, c],
            shading: CurveShading::Cylinder,
        },
    ];
    kinds.into_iter().map(ShapeDescription::from).collect()
}

/// A triangle whose sides are two edges and a line without one.
fn trim([a, b, c, d, ..]: [f64; 6]) -> TrimDescription {
    let corners = [[0.0, 0.0], [a, 0.0], [0.0, b]];
    let curve = |i: usize, edge: Option<TrimEdgeDescription>| TrimCurveDescription {
        degree: 1,
        knots: vec![-c, -c, d, d],
        points: [corners[i], corners[(i + 1) % 3]].map(|[u, v]| [u, v, 1.0]).to_vec(),
        width: Some(1e-7 * a),
        edge,
    };
    let edge = |edge: u32, range| Some(TrimEdgeDescription { edge, vertices: [3, edge], range });
    let curves = vec![curve(0, edge(7, [1.0, 0.125 * b])), curve(1, None), curve(2, edge(0, [0.0, 1.0]))];
    TrimDescription {
        loops: vec![TrimLoopDescription { curves }],
        scale: [c, d],
        domain: Some([[-a, -b], [c, d]]),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn shapes_of_every_kind_read_back_to_the_same_bits(
        n in prop::array::uniform6(0.01_f64..6.0),
        angle in 0.0_f64..6.0,
        reversed: bool,
    ) {
        let trim = trim(n);
        let placed = shapes(n).into_iter().enumerate().map(|(i, shape)| {
            let matrix = DMat4::from_rotation_y(angle) * DMat4::from_translation(DVec3::splat(n[i % 6]));
            let shape = ShapeDescription { reverse_orientation: reversed, ..shape.transformed(matrix) };
            if i % 2 == 0 { shape.trimmed(trim.clone()).bounding(i as u32) } else { shape }
        });
        assert_same(&model(placed.collect()));
    }

    #[test]
    fn materials_read_back_to_the_same_bits(n in prop::array::uniform6(0.0_f32..1.0)) {
        let [a, b, c, d, e, f] = n;
        // One of both is above 0: else the surface is smooth.
        let facets = Roughness { u: (0.1 + a).into(), v: b.into(), scale: RoughnessScale::Alpha };
        let finish = |model| SurfaceFinish::try_new(model).unwrap();
        let kinds = [
            MaterialKind::diffuse([a, b, c]),
            MaterialKind::oren_nayar([a, b, c], 30.0 * a),
            MaterialKind::mirror(d),
            MaterialKind::conductor([a, b, c], [d, e, f]),
            MaterialKind::dielectric(1.0 + a, b, [c, d, e]),
            MaterialKind::thin_dielectric(1.0 + a, 1.0, [c, d, e]),
            MaterialKind::phong([a, b, c], [d, e, f], 0.04, 100.0 * a),
            MaterialKind::coated_diffuse([a, b, c], 1.0 + d),
            MaterialKind::diffuse_transmission([a, b, c], [d, e, f]),
            MaterialKind::Principled(PrincipledMaterial {
                metallic: b.into(),
                roughness: Roughness { u: c.into(), v: d.into(), scale: RoughnessScale::Alpha },
                transmission: e.into(),
                thin: f > 0.5,
                coat: d.into(),
                coat_roughness: Roughness::isotropic(f, RoughnessScale::Alpha),
                sheen: [c, d, e].into(),
                multiple_scattering: a > 0.5,
                ..PrincipledMaterial::new([a, b, c], 0.0)
            }),
            MaterialKind::Conductor(ConductorMaterial {
                color: MetalColor::Reflectance([a, b, c].into()),
                roughness: facets.clone(),
                multiple_scattering: false,
                finish: None,
            }),
            MaterialKind::Conductor(ConductorMaterial {
                color: MetalColor::Index { eta: [a, b, c].into(), k: [d, e, f].into() },
                roughness: facets.clone(),
                multiple_scattering: true,
                finish: None,
            }),
            MaterialKind::Mirror(MirrorMaterial {
                reflectance: [a, b, c].into(),
                // Of fraction 0 it would be left out.
                finish: Some(finish(FinishModel::Gaussian {
                    sigma: 0.1 + f64::from(d) / 3.0,
                    fraction: (1.0 - e).into(),
                })),
            }),
            MaterialKind::Conductor(ConductorMaterial {
                color: MetalColor::Reflectance(a.into()),
                roughness: Roughness::smooth(),
                multiple_scattering: true,
                finish: Some(finish(FinishModel::Abg {
                    a: 0.01,
                    b: 0.1 + f64::from(e) / 3.0,
                    g: 3.0 * f64::from(f),
                })),
            }),
            MaterialKind::Dielectric(DielectricMaterial {
                eta: (1.0 + a).into(),
                // At the d line the index of red, green and blue.
                dispersion: SpectralDistribution::try_sampled(vec![
                    (400.0, 1.2 + a),
                    (500.0, 1.0 + a),
                    (700.0, 1.0 + a),
                ])
                .ok(),
                reflectance: [a, b, c].into(),
                transmittance: [d, e, f].into(),
                thin: false,
                roughness: facets,
                multiple_scattering: false,
            }),
            MaterialKind::Principled(PrincipledMaterial {
                metal: Some(MetalColor::Index { eta: [a, b, c].into(), k: [d, e, f].into() }),
                roughness: Roughness::isotropic(b, RoughnessScale::Alpha),
                ..PrincipledMaterial::new(a, 0.0)
            }),
            MaterialKind::Principled(PrincipledMaterial {
                metal: Some(MetalColor::Reflectance([d, e, f].into())),
                roughness: Roughness::isotropic(b, RoughnessScale::Alpha),
                ..PrincipledMaterial::new(a, 0.0)
            }),
            MaterialKind::Interface,
        ];
        let materials = kinds.map(MaterialDescription::from).to_vec();
        assert_same(&Description { materials, ..model(vec![ShapeDescription::sphere(1.0)]) });
    }
}

#[test]
fn media_read_back_to_the_same_bits() {
    let sampled = SpectralDistribution::try_sampled(vec![(400.0, 0.1), (700.0, 0.3)]).unwrap();
    let fog = MediumDescription {
        scale: 0.1,
        g: -0.3,
        emission: [0.1, 0.2, 0.7].into(),
        emission_scale: 0.3,
        ..MediumDescription::new([0.1, 0.2, 0.3], sampled)
    };
    let smoke = MediumDescription {
        density: Some(DensityDescription {
            resolution: [2, 1, 3],
            values: [0.1, 0.0, 0.7, 1.1, 2.3, 1e-3].into(),
            corners: [DVec3::splat(-0.1), DVec3::new(0.3, 0.7, 1.1)],
            to_world: DMat4::from_rotation_y(0.7),
        }),
        ..MediumDescription::new(0.1, 0.7)
    };
    let placed = |inside, outside| ShapeDescription {
        media: SurfaceMedia { inside, outside },
        ..ShapeDescription::sphere(1.0)
    };
    let shapes =
        vec![placed(Some(1), Some(0)), placed(None, Some(1)), placed(None, None), placed(Some(0), Some(0))];
    let model = Description { media: vec![fog, smoke], ..model(shapes.clone()) };
    assert_same(&model);
    let part = GroupDescription { name: "part".to_owned(), shapes, ..GroupDescription::default() };
    assert_same(&Description { groups: vec![part], ..model.clone() });
    // What a studio replaces of the camera is reported.
    let seen = Description { camera_medium: Some(1), ..model };
    let text = write(&seen, UpAxis::Z).unwrap();
    let loaded = load_str("model.pbrt", &text, &Options::default()).unwrap_or_else(|d| panic!("{d}\n{text}"));
    assert_eq!(loaded.diagnostics.iter().map(|d| d.kind).collect::<Vec<_>>(), ["stand-in-studio"]);
    let read = Description { camera: seen.camera.clone(), ..loaded.description };
    assert_eq!(content(&read), content(&seen), "{text}");
}

#[test]
fn assemblies_read_back_with_their_instances_and_names() {
    let loaded = load_str("lamp.step", &lamp(), &Options::default()).unwrap();
    assert_same(&loaded.description);
    assert!(!loaded.description.groups.is_empty());
}

#[test]
fn names_that_occur_twice_get_numbers() {
    let group = |name: &str, shape: ShapeDescription| GroupDescription {
        name: name.to_owned(),
        shapes: vec![shape],
        ..GroupDescription::default()
    };
    let instance = |group| InstanceDescription {
        name: String::new(),
        group,
        to_parent: DMat4::IDENTITY,
        location: None,
    };
    let mut description = model(Vec::new());
    description.groups = vec![
        group("bolt \"M6\"", ShapeDescription::sphere(1.0)),
        group("bolt \"M6\"", ShapeDescription::sphere(2.0)),
        group("", ShapeDescription::sphere(3.0)),
    ];
    description.world.instances = vec![instance(2), instance(0), instance(1)];
    let loaded = read(&write(&description, UpAxis::Y).unwrap()).description;
    let names: Vec<&str> = loaded.groups.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["bolt \"M6\"", "bolt \"M6\" 2", "part 3"]);
    let order: Vec<usize> = loaded.world.instances.iter().map(|instance| instance.group).collect();
    assert_eq!(order, [2, 0, 1]);
}

#[test]
fn a_studio_in_a_scene_with_camera_or_lights_is_reported() {
    let load = |text: &str, strict: bool| {
        let text = format!("Option \"string studio\" \"y\" {text} Shape \"sphere\"");
        load_str("model.pbrt", &text, &Options { strict, ..Options::default() })
    };
    for (text, reported) in [
        ("WorldBegin", false),
        ("Camera \"perspective\" WorldBegin", true),
        ("WorldBegin LightSource \"point\"", true),
    ] {
        let loaded = load(text, false).unwrap();
        let warnings = loaded.diagnostics.to_string();
        assert_eq!(
            warnings.contains("1:24: Option \"studio\": the scene is a model"),
            reported,
            "{warnings}"
        );
        assert_eq!(loaded.studio.unwrap().up, Some(UpAxis::Y));
        assert_eq!(load(text, true).is_err(), reported, "{text}");
    }
    let error = load_str("model.pbrt", "Option \"string studio\" \"x\"", &Options::default()).unwrap_err();
    assert!(error.to_string().contains("Option \"studio\" is \"x\"; it must be \"y\" or \"z\""), "{error}");
}

#[test]
fn what_the_language_cannot_say_is_refused() {
    let emitting = model(vec![ShapeDescription::sphere(1.0).emitting(1.0)]);
    let infinite = model(vec![ShapeDescription::rectangle([0.0, f64::INFINITY], [0.0, 1.0])]);
    let mut lit = model(vec![ShapeDescription::sphere(1.0)]);
    lit.lights.push(LightDescription::infinite(1.0));
    let mut burning = model(vec![ShapeDescription::sphere(1.0)]);
    let flame = SpectralDistribution::try_sampled(vec![(400.0, 0.1), (700.0, 0.3)]).unwrap();
    burning.media.push(MediumDescription { emission: flame, ..MediumDescription::new(1.0, 1.0) });
    for (description, word) in
        [(emitting, "emission"), (infinite, "not finite"), (lit, "a light"), (burning, "by wavelength")]
    {
        let error = write(&description, UpAxis::Z).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}
