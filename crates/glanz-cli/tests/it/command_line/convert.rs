//! `glanz convert`.

use std::io::{BufRead, BufReader, Read};

use crate::command_line::small_scene::SCENE;
use crate::command_line::support::{Folder, finish};

/// A cylinder of radius 10 and height 30, in millimetres, with a seam.
const PIN: &str = "ISO-10303-21;HEADER;FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;
#900=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#901=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
#910=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#900,#901))REPRESENTATION_CONTEXT('',''));
#10=CARTESIAN_POINT('',(0.,0.,0.));#11=CARTESIAN_POINT('',(0.,0.,30.));#12=DIRECTION('',(0.,0.,1.));
#13=DIRECTION('',(1.,0.,0.));#14=AXIS2_PLACEMENT_3D('',#10,#12,#13);#15=AXIS2_PLACEMENT_3D('',#11,#12,#13);
#16=CARTESIAN_POINT('',(10.,0.,0.));#17=CARTESIAN_POINT('',(10.,0.,30.));
#20=VERTEX_POINT('',#16);#21=VERTEX_POINT('',#17);#22=CIRCLE('',#14,10.);#23=CIRCLE('',#15,10.);
#24=VECTOR('',#12,1.);#25=LINE('',#16,#24);
#30=EDGE_CURVE('',#20,#20,#22,.T.);#31=EDGE_CURVE('',#21,#21,#23,.T.);#32=EDGE_CURVE('',#20,#21,#25,.T.);
#40=ORIENTED_EDGE('',*,*,#30,.T.);#41=ORIENTED_EDGE('',*,*,#32,.T.);#42=ORIENTED_EDGE('',*,*,#31,.F.);
#43=ORIENTED_EDGE('',*,*,#32,.F.);#44=EDGE_LOOP('',(#40,#41,#42,#43));#45=FACE_OUTER_BOUND('',#44,.T.);
#46=CYLINDRICAL_SURFACE('',#14,10.);#47=ADVANCED_FACE('side',(#45),#46,.T.);
#50=ORIENTED_EDGE('',*,*,#31,.T.);#51=EDGE_LOOP('',(#50));#52=FACE_OUTER_BOUND('',#51,.T.);#53=PLANE('',#15);
#54=ADVANCED_FACE('top',(#52),#53,.T.);
#60=ORIENTED_EDGE('',*,*,#30,.F.);#61=EDGE_LOOP('',(#60));#62=FACE_OUTER_BOUND('',#61,.T.);#63=PLANE('',#14);
#64=ADVANCED_FACE('bottom',(#62),#63,.F.);
#70=CLOSED_SHELL('',(#47,#54,#64));#71=MANIFOLD_SOLID_BREP('pin',#70);
#80=PRODUCT_DEFINITION('','',#84,$);#81=PRODUCT_DEFINITION_SHAPE('','',#80);
#82=SHAPE_REPRESENTATION('',(#71,#14),#910);#83=SHAPE_DEFINITION_REPRESENTATION(#81,#82);
#84=PRODUCT_DEFINITION_FORMATION('','',#85);#85=PRODUCT('id','pin','',());
ENDSEC;END-ISO-10303-21;";

/// A tetrahedron of polygons whose faces all name the plane of its base.
const WEDGE: &str = "ISO-10303-21;HEADER;FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;
#900=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));#901=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
#910=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#900,#901))REPRESENTATION_CONTEXT('',''));
#1=FACETED_BREP_SHAPE_REPRESENTATION('',(#2,#10),#910);#2=FACETED_BREP('',#3);#3=CLOSED_SHELL('',(#31,#32,#33,#34));
#10=AXIS2_PLACEMENT_3D('',#21,$,$);#11=PLANE('',#10);#21=CARTESIAN_POINT('',(0.,0.,0.));#22=CARTESIAN_POINT('',(12.,0.,0.));
#23=CARTESIAN_POINT('',(2.,9.,0.));#24=CARTESIAN_POINT('',(3.,2.,14.));
#31=FACE_SURFACE('',(#41),#11,.T.);#32=FACE_SURFACE('',(#42),#11,.T.);#33=FACE_SURFACE('',(#43),#11,.T.);#34=FACE_SURFACE('',(#44),#11,.T.);
#41=FACE_OUTER_BOUND('',#51,.T.);#42=FACE_OUTER_BOUND('',#52,.T.);#43=FACE_OUTER_BOUND('',#53,.T.);#44=FACE_OUTER_BOUND('',#54,.T.);
#51=POLY_LOOP('',(#21,#23,#22));#52=POLY_LOOP('',(#21,#22,#24));#53=POLY_LOOP('',(#21,#24,#23));#54=POLY_LOOP('',(#22,#23,#24));
ENDSEC;END-ISO-10303-21;";

fn with_pin() -> Folder {
    let folder = Folder::new();
    folder.write("pin.step", PIN);
    folder
}

#[test]
fn a_cad_file_becomes_watertight_triangles_within_the_tolerance() {
    let folder = with_pin();
    for (tolerance, metres) in [("0.05mm", 5e-5), ("0.001in", 2.54e-5)] {
        for name in ["pin.glb", "pin.obj", "pin.ply"] {
            let line = format!("convert pin.step {name} --tolerance {tolerance} --angle 180 --json -q");
            let report = folder.succeed(&line).json();
            assert_eq!((&report["solids"], &report["watertight_solids"]), (&1.into(), &1.into()), "{report}");
            assert_eq!((&report["left_out"], &report["warnings"]), (&0.into(), &serde_json::json!([])));
            assert!((report["tolerance"].as_f64().unwrap() - metres).abs() < 1e-12);
            assert!(report["deviation"].as_f64().unwrap() <= metres, "{report}");
            assert!(folder.has(name));
        }
    }
    assert!(folder.has("pin.mtl"));
}

#[test]
fn faces_between_polygons_become_watertight_triangles() {
    let folder = Folder::new();
    folder.write("wedge.step", WEDGE);
    let report = folder.succeed("convert wedge.step wedge.obj --json -q").json();
    assert_eq!((&report["solids"], &report["watertight_solids"]), (&1.into(), &1.into()), "{report}");
    assert_eq!(report["triangles"], 4, "{report}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_conversion_writes_nothing_and_says_so() {
    let folder = Folder::new();
    let ball = |i: u32| format!("AttributeBegin Translate {} 0 0 Shape \"sphere\" AttributeEnd\n", 3 * i);
    folder.write("balls.pbrt", format!("WorldBegin\n{}", (0..4000).map(ball).collect::<String>()));
    for output in ["balls.obj", "balls.glb", "balls.ply"] {
        let line = format!("convert balls.pbrt {output} --tolerance 0.01mm --threads 1");
        let mut child = folder.start(&line);
        let mut messages = BufReader::new(child.stderr.take().unwrap());
        let mut text = String::new();
        while !text.contains("converting ") {
            assert!(messages.read_line(&mut text).unwrap() > 0, "{text}");
        }
        let id = child.id().to_string();
        assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        messages.read_to_string(&mut text).unwrap();
        let code = finish(child, &line).code;
        assert!(code == Some(130) && text.contains("interrupted; nothing was written"), "{code:?} {text}");
        assert_eq!(folder.names(), ["balls.pbrt"]);
    }
}

#[test]
fn a_file_has_the_same_bytes_by_whichever_path_it_is_named() {
    let folder = with_pin();
    let absolute = folder.path("pin.step").display().to_string();
    for (number, path) in ["pin.step", "./pin.step", &absolute].into_iter().enumerate() {
        folder.succeed(&format!("convert {path} {number}.glb -q"));
        assert_eq!(folder.bytes("0.glb"), folder.bytes(&format!("{number}.glb")), "{path}");
    }
}

#[test]
fn triangles_render_as_the_exact_surfaces_do() {
    let folder = with_pin();
    folder.succeed("convert pin.step pin.ply --tolerance 0.002mm --angle 5 -q");
    for (name, shape) in [
        ("exact", "\"step\" \"string filename\" \"pin.step\""),
        ("triangles", "\"plymesh\" \"string filename\" \"pin.ply\""),
    ] {
        let scene = format!(
            "LookAt .06 -.08 .06  0 0 .015  0 0 1 Camera \"perspective\" \"float fov\" 25 WorldBegin\n\
             LightSource \"infinite\" \"float L\" 1 Material \"diffuse\" \"float reflectance\" .5\n\
             Shape {shape}\n"
        );
        folder.write(&format!("{name}.pbrt"), scene);
        folder.succeed(&format!("render {name}.pbrt -o {name}.exr --size 48x27 --spp 32 -q"));
    }
    let [a, b] = ["exact.exr", "triangles.exr"].map(|name| folder.picture(name).to_rgb().unwrap());
    let sum: f32 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).sum();
    let mean = sum / (3 * a.len()) as f32;
    assert!(mean < 2e-3 && a.iter().any(|pixel| pixel[0] < 0.7), "{mean}");
}

#[test]
fn a_scene_file_of_a_model_renders_to_the_same_pixels() {
    let folder = with_pin();
    folder.succeed("convert pin.step pin.pbrt -q");
    for options in ["", "--view top --material steel"] {
        for name in ["pin.step", "pin.pbrt"] {
            folder.succeed(&format!("render {name} -o {name}.exr --size 48x27 --spp 4 {options} -q"));
        }
        let [a, b] = ["pin.step.exr", "pin.pbrt.exr"].map(|name| folder.picture(name).to_rgb().unwrap());
        assert_eq!(a, b, "{options}");
    }
    // The numbers of edges are in the scene file, too.
    let report = folder.succeed("convert pin.pbrt pin.glb --json -q").json();
    assert_eq!((&report["solids"], &report["watertight_solids"]), (&1.into(), &1.into()), "{report}");
}

#[test]
fn wrong_conversions_are_refused() {
    let folder = with_pin();
    folder.write("small.pbrt", SCENE);
    folder.run("convert pin.step pin.stl").refused(2, &["pin.stl", ".glb", ".obj", ".ply", ".pbrt"]);
    folder.run("convert pin.step none/pin.glb").refused(1, &["none"]);
    folder.run("convert small.pbrt other.pbrt").refused(2, &["small.pbrt", "model"]);
    folder.run("convert pin.step pin.glb --tolerance 1").refused(2, &["--tolerance", "0.1mm"]);
    folder.run("convert pin.step pin.glb --angle 0").refused(2, &["--angle"]);
    folder.run("convert missing.step pin.glb").refused(1, &["missing.step"]);
    assert!(!folder.has("pin.glb"));
    folder.succeed("convert pin.step pin.ply");
    folder.run("convert pin.ply ./pin.ply").refused(2, &["pin.ply", "another name"]);
    folder.run("render pin.step -o pin.png --edges=1e6").refused(2, &["--edges", "64"]);
    let ran = folder.succeed("convert small.pbrt small.obj");
    assert!(ran.stderr.contains("lights and textures are not converted"), "{}", ran.stderr);
}

#[test]
fn settings_of_triangles_without_triangles_are_noted() {
    let folder = with_pin();
    let report = folder.succeed("convert pin.step pin.pbrt --tolerance 1mm --json -q").json();
    assert!(report["warnings"][0].as_str().is_some_and(|text| text.contains("no effect")), "{report}");
    let report = folder.succeed("convert pin.step pin.pbrt --json -q").json();
    assert_eq!(report["warnings"], serde_json::json!([]));
}
