//! CAD files in scenes.

use std::fs;

use glanz_formats::{Diagnostics, Loaded, Options, load};
use glanz_math::{DMat4, DVec3};
use glanz_scene::description::{GeometryDescription, GroupDescription};
use tempfile::TempDir;

/// A product with the numbers from `n` on, whose representation n + 2 has these items.
fn product(n: usize, name: &str, items: &str) -> String {
    let [p, r, s, f, product] = [n + 1, n + 2, n + 3, n + 4, n + 5];
    format!(
        "#{n}=PRODUCT_DEFINITION('','',#{f},$);#{p}=PRODUCT_DEFINITION_SHAPE('','',#{n});
         #{r}=SHAPE_REPRESENTATION('',({items}),#910);#{s}=SHAPE_DEFINITION_REPRESENTATION(#{p},#{r});
         #{f}=PRODUCT_DEFINITION_FORMATION('','',#{product});#{product}=PRODUCT('id','{name}','',());\n"
    )
}

/// A usage `n` of the product 200 or 300 in 100, placed from the frame #10 to the frame `to`.
fn usage(n: usize, name: &str, child: usize, to: usize) -> String {
    let [d, r, t, p] = [n + 1, n + 2, n + 3, n + 4];
    format!(
        "#{n}=NEXT_ASSEMBLY_USAGE_OCCURRENCE('id','{name}','',#100,#{child},$);
         #{d}=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{r},#{p});#{p}=PRODUCT_DEFINITION_SHAPE('','',#{n});
         #{r}=(REPRESENTATION_RELATIONSHIP('','',#{},#102)REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{t})
         SHAPE_REPRESENTATION_RELATIONSHIP());#{t}=ITEM_DEFINED_TRANSFORMATION('','',#10,#{to});\n",
        child + 2
    )
}

/// A lamp in millimetres: a red bulb of radius 50 with the face `glass`, at the origin; two knobs of radius 10 without color, `left` at x = -1000 and
/// `right` at x = 1000.
pub(crate) fn lamp() -> String {
    format!(
        "ISO-10303-21;HEADER;FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;
         #900=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
         #901=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
         #910=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#900,#901))REPRESENTATION_CONTEXT('',''));
         #10=AXIS2_PLACEMENT_3D('',#11,$,$);#11=CARTESIAN_POINT('',(0.,0.,0.));
         #20=AXIS2_PLACEMENT_3D('',#21,$,$);#21=CARTESIAN_POINT('',(-1000.,0.,0.));
         #30=AXIS2_PLACEMENT_3D('',#31,$,$);#31=CARTESIAN_POINT('',(1000.,0.,0.));
         #1=ADVANCED_FACE('glass',(),#2,.T.);#2=SPHERICAL_SURFACE('',#10,50.);
         #3=MANIFOLD_SOLID_BREP('',#4);#4=CLOSED_SHELL('',(#1));
         #5=ADVANCED_FACE('',(),#6,.T.);#6=SPHERICAL_SURFACE('',#10,10.);
         #7=MANIFOLD_SOLID_BREP('grip',#8);#8=CLOSED_SHELL('',(#5));
         #65=STYLED_ITEM('',(#66),#3);#66=PRESENTATION_STYLE_ASSIGNMENT((#67));#67=SURFACE_STYLE_USAGE(.BOTH.,#68);
         #68=SURFACE_SIDE_STYLE('',(#69));#69=SURFACE_STYLE_FILL_AREA(#70);#70=FILL_AREA_STYLE('',(#71));
         #71=FILL_AREA_STYLE_COLOUR('',#72);#72=COLOUR_RGB('',1.,0.,0.);
         {}{}{}{}{}{}ENDSEC;END-ISO-10303-21;",
        product(100, "lamp", "#10"),
        product(200, "bulb", "#3,#10"),
        product(300, "knob", "#7,#10"),
        usage(400, "", 200, 10),
        usage(500, "left", 300, 20),
        usage(600, "right", 300, 30)
    )
}

/// A folder with the file `lamp.step`.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("lamp.step"), lamp()).unwrap();
    folder
}

fn load_in(folder: &TempDir, scene: &str) -> Result<Loaded, Diagnostics> {
    let path = folder.path().join("scene.pbrt");
    fs::write(&path, format!("WorldBegin\n{scene}\n")).unwrap();
    load(&path, &Options { confined: true, ..Options::default() })
}

/// Reads a scene without a warning.
fn read(scene: &str) -> Loaded {
    let loaded = load_in(&folder(), scene).unwrap_or_else(|d| panic!("{d}"));
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
    loaded
}

fn messages(scene: &str) -> String {
    match load_in(&folder(), scene) {
        Ok(loaded) => loaded.diagnostics.to_string(),
        Err(diagnostics) => diagnostics.to_string(),
    }
}

/// Of each sphere of a scene, from left to right: its center, its radius, its material (`file` for colors of the file) and whether it emits light.
fn balls(loaded: &Loaded) -> Vec<(DVec3, f64, String, bool)> {
    fn add(
        loaded: &Loaded,
        group: &GroupDescription,
        to_world: DMat4,
        balls: &mut Vec<(DVec3, f64, String, bool)>,
    ) {
        for shape in &group.shapes {
            let GeometryDescription::Sphere { radius, .. } = shape.geometry else { panic!("{shape:?}") };
            let material = &loaded.description.materials[shape.material];
            let name = if material.location.is_none() { "file" } else { &material.name };
            let center = (to_world * shape.to_parent).transform_point3(DVec3::ZERO);
            let radius = radius * to_world.x_axis.length();
            balls.push((center, radius, name.to_owned(), shape.emission.is_some()));
        }
        for instance in &group.instances {
            let inner = &loaded.description.groups[instance.group];
            add(loaded, inner, to_world * instance.to_parent, balls);
        }
    }
    let mut balls = Vec::new();
    add(loaded, &loaded.description.world, DMat4::IDENTITY, &mut balls);
    balls.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
    balls
}

fn materials(loaded: &Loaded) -> Vec<String> {
    balls(loaded).into_iter().map(|(_, _, material, _)| material).collect()
}

const NAMED: &str = "MakeNamedMaterial \"steel\" \"string type\" \"conductor\"
    MakeNamedMaterial \"opal\" \"string type\" \"diffuse\"
    MakeNamedMaterial \"rubber\" \"string type\" \"diffuse\"";

/// The lamp with these parameters, where three named materials are known.
fn shape(parameters: &str) -> String {
    format!("{NAMED}\nShape \"step\" \"string filename\" \"lamp.step\" {parameters}")
}

#[test]
fn assembly_is_an_instance_in_metres_with_the_current_transformation() {
    let loaded = read("Translate 0 0 3 Scale 2 2 2 Shape \"step\" \"string filename\" \"lamp.step\"");
    let found = balls(&loaded);
    let expected = [(-2.0, 0.02), (0.0, 0.1), (2.0, 0.02)];
    assert_eq!(found.len(), expected.len());
    for ((center, radius, material, emits), (x, expected)) in found.into_iter().zip(expected) {
        assert!(center.distance(DVec3::new(x, 0.0, 3.0)) < 1e-12 && (radius - expected).abs() < 1e-12);
        assert_eq!((material.as_str(), emits), ("file", false));
    }
    // Two parts and the assembly; both knobs are the same group.
    assert_eq!((loaded.description.groups.len(), loaded.description.world.instances.len()), (3, 1));
    let location = loaded.description.world.instances[0].location.unwrap();
    assert_eq!((location.line, location.column), (2, 29));
    // The scene resolves.
    let scene = glanz_scene::Scene::resolve(loaded.description).map(|_| ());
    assert!(scene.is_ok(), "{scene:?}");
}

#[test]
fn colors_of_the_file_give_way_to_a_material() {
    let file = read(&shape(""));
    assert_eq!(materials(&file), ["file"; 3]);
    let group = |i: usize| &file.description.groups[i];
    assert_ne!(group(0).shapes[0].material, group(1).shapes[0].material, "red and grey");
    assert_eq!(materials(&read(&format!("Material \"mirror\" {}", shape("")))), [""; 3]);
    assert_eq!(
        materials(&read(&format!("Material \"mirror\" {}", shape("\"bool colors\" true")))),
        ["file"; 3]
    );
    assert_eq!(materials(&read(&shape("\"bool colors\" false"))), [""; 3]);
}

#[test]
fn table_gives_materials_to_faces_bodies_occurrences_and_parts() {
    for (table, expected) in [
        ("\"knob\" \"steel\"", ["steel", "file", "steel"]),
        ("\"left\" \"steel\"", ["steel", "file", "file"]),
        ("\"knob\" \"steel\" \"right\" \"opal\"", ["steel", "file", "opal"]),
        ("\"lamp\" \"steel\" \"bulb\" \"opal\"", ["steel", "opal", "steel"]),
        ("\"bulb\" \"opal\" \"glass\" \"rubber\"", ["file", "rubber", "file"]),
        ("\"left\" \"opal\" \"grip\" \"rubber\"", ["rubber", "file", "rubber"]),
        ("\"left\" \"opal\" \"*\" \"rubber\"", ["opal", "rubber", "rubber"]),
        ("\"left\" \"opal\" \"left\" \"rubber\"", ["opal", "file", "file"]),
    ] {
        assert_eq!(materials(&read(&shape(&format!("\"string materials\" [{table}]")))), expected, "{table}");
    }
    let others = read(&format!("Material \"mirror\" {}", shape("\"string materials\" [\"left\" \"opal\"]")));
    assert_eq!(materials(&others), ["opal", "", ""]);
    // A material may be defined later.
    let later = format!(
        "Shape \"step\" \"string filename\" \"lamp.step\" \"string materials\" [\"*\" \"opal\"] {NAMED}"
    );
    assert_eq!(materials(&read(&later)), ["opal"; 3]);
}

#[test]
fn part_is_shown_where_it_is_in_the_assembly() {
    let x = |parameters: &str| -> Vec<f64> {
        balls(&read(&shape(parameters))).into_iter().map(|(center, ..)| center.x).collect()
    };
    assert_eq!(x("\"string part\" \"bulb\""), [0.0]);
    assert_eq!(x("\"string part\" \"knob\""), [-1.0, 1.0]);
    assert_eq!(x("\"string part\" \"right\""), [1.0]);
    assert_eq!(x("\"string part\" \"lamp\""), [-1.0, 0.0, 1.0]);
}

#[test]
fn file_is_read_once_and_same_shapes_share_a_group() {
    let one = read(&shape(""));
    let text = format!(
        "{0} Translate 0 5 0 {0} Material \"mirror\" {0}",
        "Shape \"step\" \"string filename\" \"lamp.step\""
    );
    let three = read(&text);
    let of = |loaded: &Loaded| loaded.description.world.instances.iter().map(|i| i.group).collect::<Vec<_>>();
    assert_eq!(of(&one), [2]);
    assert_eq!(of(&three), [2, 2, 5]);
    assert_eq!(three.sources.paths().len(), 2);
    assert_eq!(balls(&three).len(), 9);
    // The hash has the bytes of each file once.
    let folder = folder();
    let hash = |folder: &TempDir| load_in(folder, &text).unwrap().content_hash;
    let before = hash(&folder);
    assert_eq!(hash(&folder), before);
    fs::write(folder.path().join("lamp.step"), lamp().replace(",50.)", ",51.)")).unwrap();
    assert_ne!(hash(&folder), before);
}

#[test]
fn faces_emit_radiance_and_share_no_power() {
    let light = "AreaLightSource \"diffuse\" \"rgb L\" [5 5 5]";
    let lit = read(&format!("{light} {}", shape("\"string part\" \"bulb\"")));
    assert_eq!(balls(&lit).into_iter().map(|ball| ball.3).collect::<Vec<_>>(), [true]);
    assert!(balls(&read(&format!("{light} {}", shape("")))).iter().all(|ball| ball.3));
    let scene = glanz_scene::Scene::resolve(lit.description).unwrap().0;
    assert_eq!(scene.lights().len(), 1);
    let lumens = "AreaLightSource \"diffuse\" \"float lumens\" 800";
    assert!(load_in(&folder(), &format!("{lumens} {}", shape("\"string part\" \"bulb\""))).is_ok());
    let text = messages(&format!("{lumens} {}", shape("")));
    assert!(text.contains("it has 3 surfaces, which cannot share one power"), "{text}");
    let text = messages(&format!("ObjectBegin \"o\" {light} {} ObjectEnd", shape("")));
    assert!(text.contains("an object that emits light cannot be part of another"), "{text}");
}

#[test]
fn objects_contain_assemblies() {
    let loaded = read(&format!(
        "{NAMED} ObjectBegin \"pair\" {0} Translate 0 0 1 {0} ObjectEnd ObjectInstance \"pair\"",
        "Shape \"step\" \"string filename\" \"lamp.step\""
    ));
    assert_eq!(balls(&loaded).len(), 6);
    assert!(glanz_scene::Scene::resolve(loaded.description).is_ok());
}

#[test]
fn errors_have_a_position_in_the_scene() {
    let step = |rest: &str| format!("  Shape \"step\" {rest}");
    for (scene, expected) in [
        (step(""), "error: scene.pbrt:2:3: shape \"step\" has no \"string filename\""),
        (
            step("\"string filename\" \"no.step\""),
            "error: scene.pbrt:2:34: shape \"step\": file \"no.step\" is not there",
        ),
        (
            step("\"string filename\" \"scene.pbrt\""),
            "error: scene.pbrt:2:34: shape \"step\": scene.pbrt: the file does not begin with ISO-10303-21; it is no STEP file",
        ),
        (
            step("\"string filename\" \"lamp.step\" \"string part\" \"nob\""),
            "error: scene.pbrt:2:60: shape \"step\": \"lamp.step\" has no part \"nob\"",
        ),
        (
            step("\"string filename\" \"lamp.step\" \"string materials\" [\"knob\"]"),
            "error: scene.pbrt:2:66: shape \"step\": \"materials\" has 1 values",
        ),
        (
            step("\"string filename\" \"lamp.step\" \"string materials\" [\"knob\" \"gold\"]"),
            "error: scene.pbrt:2:66: there is no material \"gold\"",
        ),
        (
            step("\"string filename\" \"lamp.step\" \"string receiver\" \"r\""),
            "error: scene.pbrt:2:64: shape \"step\" cannot be receiver \"r\"",
        ),
        (
            format!("ReverseOrientation\n{}", step("\"string filename\" \"lamp.step\"")),
            "warning: scene.pbrt:3:3: shape \"step\": ReverseOrientation has no effect; normals of solids point outwards",
        ),
    ] {
        let text = messages(&scene);
        assert!(text.starts_with(expected), "{expected}\n{text}");
    }
    let text = messages(&step("\"string filename\" \"lamp.step\" \"string part\" \"nob\""));
    let help = "help: did you mean \"knob\"? its parts are \"bulb\", \"knob\", \"lamp\", \"id\", \"left\", \"right\"";
    assert!(text.contains(help), "{text}");
}

#[test]
fn names_without_a_part_are_warned_about() {
    let text = messages(&shape("\"string materials\" [\"nob\" \"steel\"]"));
    assert!(text.starts_with("warning: scene.pbrt:5:"), "{text}");
    assert!(
        text.contains("\"lamp.step\" has no part \"nob\"") && text.contains("did you mean \"knob\"?"),
        "{text}"
    );
}

#[test]
fn what_is_left_out_of_the_file_is_reported_once_with_its_name() {
    let folder = folder();
    let broken = lamp().replace("SPHERICAL_SURFACE('',#10,10.)", "SPHERICAL_SURFACE('',#10,-1.)");
    fs::write(folder.path().join("lamp.step"), broken).unwrap();
    let use_it = "Shape \"step\" \"string filename\" \"lamp.step\"";
    let loaded = load_in(&folder, &format!("{use_it}\n{use_it}")).unwrap();
    let warnings = loaded.diagnostics.to_string();
    assert_eq!(
        warnings.matches("warning: scene.pbrt:2:32: shape \"step\": lamp.step: #").count(),
        loaded.diagnostics.iter().count()
    );
    assert!(warnings.contains("#5"), "{warnings}");
    assert_eq!(balls(&loaded).len(), 2);
    // Nothing of the knobs is left.
    let text = load_in(&folder, &format!("{use_it} \"string part\" \"left\"")).unwrap_err().to_string();
    assert!(text.contains("#5: #6: the radius is -1"), "{text}");
    assert!(text.contains("\"lamp.step\" has no part \"left\""), "{text}");
    fs::write(
        folder.path().join("lamp.step"),
        lamp().replace("#2=SPHERICAL", "#2=UNKNOWN").replace("#6=SPH", "#6=NO"),
    )
    .unwrap();
    let text = load_in(&folder, use_it).unwrap_err().to_string();
    assert!(text.contains("\"lamp.step\" shows no surface that can be read"), "{text}");
}
