//! Figures of lighting planners.

use crate::command_line::support::Folder;

/// A square panel of 0.6 m, or a point, of 1000 cd straight down and less to the sides, 30 W.
fn panel(folder: &Folder, name: &str, side: &str) {
    let head = "IESNA:LM-63-2002\n[MANUFAC] Maker\n[LUMINAIRE] Panel\nTILT=NONE\n1 -1 1 7 1 1 2";
    folder.write(
        name,
        format!("{head} {side} {side} 0 1 1 30\n0 15 30 45 60 75 90\n0\n1000 966 866 707 500 259 0\n"),
    );
}

#[test]
fn info_rates_the_glare_of_a_luminaire_in_standard_rooms() {
    let folder = Folder::new();
    panel(&folder, "panel.ies", "0.6");
    panel(&folder, "point.ies", "0");
    let report = folder.succeed("info panel.ies --ugr --json").json();
    let rows = report["ugr"].as_array().unwrap();
    assert_eq!(rows.len(), 19);
    let of = |row: usize, key: &str| rows[row][key].as_f64().unwrap();
    assert_eq!((of(10, "x_heights"), of(10, "y_heights")), (4.0, 8.0));
    // Symmetric: the same across and along. Darker rooms glare more, by 8 lg of the background luminances: 72 % of the light to the plane and 28 % to
    // the walls are 0.72 * 0.115 + 0.28 * 0.211 = 0.142 and 0.72 * 0.081 + 0.28 * 0.092 = 0.084 on the walls (CIE 190, table 5), 1.8 units.
    assert_eq!(of(10, "crosswise_70_50_20"), of(10, "endwise_70_50_20"));
    let darker = of(10, "crosswise_30_30_20") - of(10, "crosswise_70_50_20");
    assert!((darker - 1.8).abs() < 0.1, "{darker}");
    assert!(of(5, "crosswise_70_50_20") > of(0, "crosswise_70_50_20"));
    let shown = folder.succeed("info panel.ies --ugr").stdout;
    assert!(shown.contains("across 70/50/20") && shown.contains("UGR in standard rooms"), "{shown}");
    assert!(folder.succeed("info panel.ies --json").json().get("ugr").is_none());
    folder.run("info point.ies --ugr").refused(1, &["point.ies", "no luminous area"]);
    folder.write("scene.pbrt", "WorldBegin\n");
    folder.run("info scene.pbrt --ugr").refused(2, &["--ugr", ".ldt"]);
}

#[test]
fn room_is_planned_from_a_photometric_file_alone() {
    let folder = Folder::new();
    panel(&folder, "panel.ies", "0.6");
    panel(&folder, "point.ies", "0");
    let room = "illuminate --room 6 4 3 --grid 3x2 --rays 100000 --directions 256";
    let line =
        format!("{room} --luminaire panel.ies --task 34.2 --maintenance 0.9x1x0.95x0.94 -o lux --json");
    let report = folder.succeed(&line).json();
    let plan = &report["designs"][0]["plan"];
    let facts = &plan["facts"];
    assert_eq!(facts["maintenance_factor"], 0.9 * 0.95 * 0.94);
    assert_eq!(facts["maintenance_parts"], "0.9 x 1 x 0.95 x 0.94");
    assert_eq!((&facts["power_density_w_m2"], &facts["luminaires"]), (&7.5.into(), &6.into()));
    assert_eq!(facts["maker"], "Maker");
    // Work plane, ceiling, four walls and cylinders with mean and uniformity each, and UGR.
    let verdicts = plan["verdicts"].as_array().unwrap();
    assert_eq!(verdicts.len(), 15);
    let task = &verdicts[0];
    assert_eq!((&task["zone"], &task["criterion"]), (&"work plane".into(), &"mean_illuminance".into()));
    assert_eq!(task["source"], "EN 12464-1:2021, 34.2");
    let maps = report["designs"][0]["receivers"].as_array().unwrap();
    let mean = maps.iter().find(|map| map["name"] == "work plane").unwrap()["mean_lux"].as_f64().unwrap();
    assert!((task["value"].as_f64().unwrap() / (mean * 0.8037) - 1.0).abs() < 1e-9);
    assert_eq!(task["outcome"], "not_met");
    assert_eq!(
        (plan["observers"].as_array().unwrap().len(), plan["cylindrical"].as_array().unwrap().len()),
        (180, 45)
    );
    let page = String::from_utf8(folder.bytes("lux/report.html")).unwrap();
    assert!(page.contains("Requirements") && page.contains("power per area and 100 lx (task area)"));

    // Without an opening everything else is rated.
    let told = folder.succeed(&format!("{room} --luminaire point.ies --task 34.2 -o point"));
    assert!(told.stderr.contains("UGR is not rated") && told.stdout.contains("undecided"), "{}", told.stdout);
    for (options, parts) in [
        ("--luminaire panel.ies --height 3.5 -o x", &["height of the luminaires is 3.5 m", "3 m"][..]),
        ("--luminaire panel.ies --reflectances 0.7 1.5 0.2 -o x", &["reflectance of the walls is 1.5"]),
        ("--luminaire panel.ies --maintenance 0.9x1.2x1x1 -o x", &["LSF is 1.2"]),
        ("--luminaire panel.ies --task 99 -o x", &["34.2 (writing"]),
        ("--luminaire panel.ies scene.pbrt -o x", &["--luminaire"]),
        ("--luminaire panel.ies --margin 2 -o x", &["smaller margin"]),
    ] {
        folder.run(&format!("{room} {options}")).refused(2, parts);
    }
    // Six luminaires.
    folder
        .run(&format!("{room} --luminaire panel.ies --limit objects=3 -o x"))
        .refused(1, &["the limit of 3 objects", "raise it with --limit objects=6"]);
    folder.run("illuminate --luminaire panel.ies --grid 3x2 -o x").refused(2, &["--room"]);
    folder.run("illuminate -o x").refused(2, &["SCENE"]);
}

#[test]
fn road_is_rated_by_a_table_of_its_surface() {
    let folder = Folder::new();
    panel(&folder, "lantern.ies", "0.6");
    folder.write("dull.txt", "tan 0 180\n0 700 700\n1 247.5 247.5\n2 62.6 62.6\n4 10 10\n12 0.4 0.4\n");
    let road = "road lantern.ies --spacing 25 --height 8 --surface dull.txt --class M5 --maintenance 0.8";
    let report = folder.succeed(&format!("{road} --json")).json();
    let verdicts = report["verdicts"].as_array().unwrap();
    let criteria: Vec<&str> = verdicts.iter().map(|verdict| verdict["criterion"].as_str().unwrap()).collect();
    let expected = [
        "mean_luminance",
        "overall_uniformity",
        "longitudinal_uniformity",
        "threshold_increment",
        "edge_illuminance_ratio",
    ];
    assert_eq!(criteria, expected);
    assert_eq!(report["observers"].as_array().unwrap().len(), 2);
    assert_eq!((&report["facts"]["stations"], &report["facts"]["class"]), (&10.into(), &"M5".into()));
    // A diffuse surface of q = 0.07: the luminance is about 0.07 times the illuminance.
    let luminance = report["observers"][0]["mean_luminance_cd_m2"].as_f64().unwrap();
    let lux = report["facts"]["mean_lux"].as_f64().unwrap();
    assert!((luminance / (0.07 * lux) - 1.0).abs() < 0.15, "{luminance} {lux}");
    let shown = folder.succeed(road).stdout;
    assert!(shown.contains("fTI, %") && shown.contains("EN 13201-2:2015, M5"), "{shown}");
    let shown = folder.succeed("road lantern.ies --spacing 25 --height 8 --class P2").stdout;
    assert!(shown.contains("Emin, lx") && !shown.contains("fTI"), "{shown}");

    folder.write("bad.txt", "tan 0 180\n0 1 x\n");
    folder
        .run("road lantern.ies --spacing 25 --height 8 --surface bad.txt")
        .refused(1, &["bad.txt:2:5", "\"x\""]);
    // A digit at the beginning makes it no list of patches.
    folder.write("digits.txt", "0 180 x\n0 1 2\n");
    let ran = folder.run("road lantern.ies --spacing 25 --height 8 --surface digits.txt");
    ran.refused(1, &["digits.txt:1:"]);
    assert!(!ran.stderr.contains("patches"), "{}", ran.stderr);
    folder.run("road lantern.ies --spacing 25 --height 8 --class M5").refused(2, &["class M5", "--surface"]);
    folder.run("road lantern.ies --spacing 25 --height 1").refused(2, &["height of the luminaires"]);
    folder.run("road lantern.ies --spacing 25 --height 8 --class Z9").refused(2, &["M1 to M6"]);
    folder.run("road none.ies --spacing 25 --height 8").refused(1, &["none.ies"]);
}

#[test]
fn floor_of_a_room_is_judged_as_an_open_area() {
    let folder = Folder::new();
    panel(&folder, "panel.ies", "0.6");
    let room = "illuminate --room 4 4 3 --grid 1x1 --luminaire panel.ies --rays 20000 --directions 16 --emergency -o lux --json";
    let report = folder.succeed(room).json();
    let verdicts = report["designs"][0]["plan"]["verdicts"].as_array().unwrap();
    let of =
        |i: usize| (verdicts[i]["criterion"].as_str().unwrap(), verdicts[i]["outcome"].as_str().unwrap());
    assert_eq!(verdicts.len(), 3);
    assert_eq!(
        (of(0), of(1), of(2)),
        (("least_illuminance", "met"), ("maximum_to_minimum", "met"), ("intensity", "met"))
    );
    // 500 cd at 60 degrees, and 3 m up: the limit is 1600 cd.
    assert_eq!(verdicts[2]["limit"], 1600.0);
    assert!((verdicts[2]["value"].as_f64().unwrap() - 500.0).abs() < 1.0);
    // The border of the open area is that of the standard.
    let narrow =
        "illuminate --room 4 1 3 --grid 1x1 --luminaire panel.ies --margin 0.1 --emergency -o narrow";
    folder.run(narrow).refused(2, &["a room of 4 x 1 m has no open area"]);
    let direct = "illuminate --room 4 4 3 --grid 1x1 --luminaire panel.ies --method integrate -o direct";
    folder.run(direct).refused(1, &["integration leaves out the light between surfaces"]);
}

#[test]
fn zones_and_observers_of_a_scene_are_rated() {
    let folder = Folder::new();
    panel(&folder, "panel.ies", "0.6");
    let scene = r#"
WorldBegin
AttributeBegin
Translate 1.5 2 2.9
LightSource "photometric" "string filename" "panel.ies" "string as" "area"
AttributeEnd
Material "diffuse" "float reflectance" .6
AttributeBegin
Translate 1.5 2 1.5
Shape "box" "vector3 size" [ 3 4 3 ]
AttributeEnd
Material "interface"
Shape "bilinearmesh" "point3 P" [ 1 1.5 .75  2 1.5 .75  1 2.5 .75  2 2.5 .75 ] "string receiver" "desk" "integer cells" [ 4 4 ] "string zone" "task"
Shape "bilinearmesh" "point3 P" [ .5 1.5 .75  1 1.5 .75  .5 2.5 .75  1 2.5 .75 ] "string receiver" "around" "integer cells" [ 2 4 ] "string zone" "surrounding"
Shape "bilinearmesh" "point3 P" [ 2 1.5 .75  2.5 1.5 .75  2 2.5 .75  2.5 2.5 .75 ] "string receiver" "around" "integer cells" [ 2 4 ] "string zone" "surrounding"
Observer "glare" "point3 P" [ 1.5 .3 1.2 ] "vector3 view" [ 0 1 0 ]
Observer "cylinder" "point3 P" [ 1.5 2 1.2  1 1 1.2 ]
"#;
    folder.write("room.pbrt", scene);
    let line = "illuminate room.pbrt --rays 200000 --directions 1024 -o lux --json";
    let plan =
        |options: &str| folder.succeed(&format!("{line} {options}")).json()["designs"][0]["plan"].clone();
    let found = plan("--task 34.1 --maintenance 0.5");
    let verdicts = found["verdicts"].as_array().unwrap();
    let zones: Vec<(&str, &str)> =
        verdicts.iter().map(|v| (v["zone"].as_str().unwrap(), v["criterion"].as_str().unwrap())).collect();
    // Both strips are one zone.
    let expected = [
        ("desk", "mean_illuminance"),
        ("desk", "uniformity"),
        ("around", "mean_illuminance"),
        ("around", "uniformity"),
        ("observers", "glare_rating"),
        ("cylinders", "cylindrical_illuminance"),
        ("cylinders", "uniformity"),
    ];
    assert_eq!(zones, expected);
    assert_eq!((&verdicts[0]["limit"], &verdicts[2]["limit"]), (&300.0.into(), &200.0.into()));
    assert_eq!(found["observers"][0]["luminaires"], 1);
    assert!(found["observers"][0]["ugr"].as_f64().unwrap() > 5.0);
    // Without options the figures are there, and no verdicts.
    let plain = plan("");
    assert_eq!(plain["verdicts"], serde_json::json!([]));
    let lux = |plan: &serde_json::Value| plan["facts"]["task_mean_lux"].as_f64().unwrap();
    assert!((lux(&found) / lux(&plain) - 0.5).abs() < 1e-9);
    assert_eq!(plain["cylindrical"].as_array().unwrap().len(), 2);
    // Behind a screen nothing glares; it reflects light to the eye.
    folder.write("screen.pbrt", [scene, "Material \"diffuse\"\nTranslate 0 1.1 1.7\nShape \"bilinearmesh\" \"point3 P\" [ 0 0 0  3 0 0  0 0 1.3  3 0 1.3 ]\n"].concat());
    let report = folder.succeed("illuminate screen.pbrt --rays 20000 --directions 256 -o lux --json").json();
    let observer = &report["designs"][0]["plan"]["observers"][0];
    assert_eq!((&observer["luminaires"], &observer["ugr"]), (&0.into(), &serde_json::Value::Null));
    // Light of the sky alone is not judged.
    let day = folder.succeed("illuminate room.pbrt --rays 20000 --daylight -o day --json").json();
    assert!(day["designs"][0]["daylight_factors"].is_array() && day["designs"][0].get("plan").is_none());
    let page = String::from_utf8(folder.bytes("day/report.html")).unwrap();
    assert!(!page.contains("EN 12464") && page.contains("not judged by daylight alone"));
    for option in ["--task 34.1", "--maintenance 0.8"] {
        let line = format!("illuminate room.pbrt --daylight {option} -o day");
        folder.run(&line).refused(2, &["cannot be used with"]);
    }
    // As a point, the luminaire has no luminance.
    folder.write("point.pbrt", scene.replace("\"string as\" \"area\"", ""));
    let told = folder.succeed("illuminate point.pbrt --rays 20000 -o lux");
    assert!(told.stderr.contains("luminaire 1 has no luminous area"), "{}", told.stderr);
}
