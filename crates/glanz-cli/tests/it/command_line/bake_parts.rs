//! Parts of `glanz bake` and `glanz merge` of them.

use crate::command_line::support::Folder;

/// A room with a lamp and a ball.
const ROOM: &str = r#"
LookAt 1 -3 1  1 1 1  0 0 1
Camera "perspective"
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [5 5 4]
  Translate 1 1 1.8
  Shape "sphere" "float radius" .1
AttributeEnd
Material "diffuse" "rgb reflectance" [.7 .6 .5]
Shape "bilinearmesh" "point3 P" [0 0 0  2 0 0  0 2 0  2 2 0]
Shape "bilinearmesh" "point3 P" [0 0 0  0 2 0  0 0 2  0 2 2]
Translate .6 .8 .3
Shape "sphere" "float radius" .3
"#;

const LINE: &str = "bake room.pbrt --texels-per-metre 12 --rays 64 -q";

#[test]
fn merged_parts_give_the_model_of_one_bake() {
    let folder = Folder::new();
    folder.write("room.pbrt", ROOM);
    folder.succeed(&format!("{LINE} -o one.glb --checkpoint one.light"));
    let parts = |folder: &Folder, count: u32, options: &str, name: &str| {
        let names: Vec<String> = (1..=count).rev().map(|number| format!("{name}-{number}-{count}")).collect();
        for (number, file) in (1..=count).rev().zip(&names) {
            let threads = 1 + number % 2;
            folder.succeed(&format!(
                "{LINE} --part {number}/{count} {options} --checkpoint {file} --threads {threads}"
            ));
        }
        folder.succeed(&format!("merge {} --checkpoint {name}-{count} --json", names.join(" "))).json()
    };
    for count in [1, 3, 5] {
        let merged = parts(&folder, count, "", "all");
        assert!(merged["kind"] == "light" && merged["points"].as_u64().unwrap() > 100, "{merged}");
        // With the direct light of parts that went before, to the same bits.
        let direct = parts(&folder, count, "--direct-only", "direct");
        assert_eq!(direct["direct_texels"], merged["direct_texels"]);
        assert_eq!(direct["points"], 0);
        parts(&folder, count, &format!("--light-in direct-{count}"), "later");
        assert_eq!(folder.bytes(&format!("all-{count}")), folder.bytes(&format!("later-{count}")));
        folder.write("merged", folder.bytes(&format!("all-{count}")));
        folder.succeed(&format!("{LINE} -o joined.glb --checkpoint all-{count} --resume"));
        for (joined, one) in [("joined.glb", "one.glb"), ("joined.exr", "one.exr")] {
            assert_eq!(folder.bytes(joined), folder.bytes(one), "{count}");
        }
        assert_eq!(folder.bytes(&format!("all-{count}")), folder.bytes("one.light"));
    }
    // A tree of merges.
    folder.succeed("merge all-1-5 all-4-5 --checkpoint group-1 --partial");
    folder.succeed("merge all-2-5 all-3-5 all-5-5 --checkpoint group-2 --partial");
    folder.succeed("merge group-1 group-2 --checkpoint tree");
    assert_eq!(folder.bytes("tree"), folder.bytes("merged"));
    // A part that is finished stays as it is.
    let before = folder.bytes("all-2-5");
    folder.succeed(&format!("{LINE} --part 2/5 --checkpoint all-2-5 --resume"));
    assert_eq!(folder.bytes("all-2-5"), before);
    // Light that is finished shows as ever, and is no part.
    folder.succeed("render room.pbrt --integrator radiosity --light-in all-3 --size 8x8 --spp 1 -o m.exr -q");
    let line = "render room.pbrt --integrator radiosity --light-in all-3 --size 8x8 --spp 4 -q";
    folder.succeed(&format!("{line} -o whole.exr"));
    (1..=3).for_each(|k| {
        folder.succeed(&format!("{line} --part {k}/3 --checkpoint {k}.glanz"));
    });
    folder.succeed("merge 3.glanz 1.glanz 2.glanz -o parts.exr -q");
    assert_eq!(folder.bytes("parts.exr"), folder.bytes("whole.exr"));
    folder.run("merge all-1-3 one.light --checkpoint w").refused(1, &["one.light is no part"]);
}

#[test]
fn parts_of_a_bake_that_are_missing_doubled_or_foreign_are_named() {
    let folder = Folder::new();
    folder.write("room.pbrt", ROOM);
    for number in 1..=3 {
        folder.succeed(&format!("{LINE} --part {number}/3 --checkpoint {number}.light"));
    }
    folder.run("merge 1.light 3.light --checkpoint w").refused(1, &["part 2/3", "is missing", "--partial"]);
    let doubled = ["2.light and 2.light both have part 2/3"];
    folder.run("merge 1.light 2.light 2.light --checkpoint w").refused(1, &doubled);
    folder.succeed("bake room.pbrt --texels-per-metre 13 --rays 64 -q --part 2/3 --checkpoint fine.light");
    folder
        .run("merge 1.light fine.light --checkpoint w")
        .refused(1, &["1.light and fine.light", "texels per metre is 12 in 1.light and 13 in fine.light"]);
    folder.succeed(&format!("{LINE} --part 2/3 --direct-only --checkpoint direct.light"));
    folder.run("merge 1.light direct.light --checkpoint w").refused(1, &["the light of the parts"]);
    folder
        .run(&format!("{LINE} --part 1/3 --checkpoint 2.light --resume"))
        .refused(1, &["2.light", "the part is 2/3, not 1/3"]);
    let line = "bake room.pbrt --part 1/3";
    folder
        .run(&format!("{line} --checkpoint new --method radiosity"))
        .refused(2, &["the hierarchical solver is one computation", "--method"]);
    folder.run(line).refused(2, &["--checkpoint"]);
    folder.run(&format!("{line} --checkpoint new -o m.glb")).refused(2, &["--output"]);
    folder.run("bake room.pbrt --direct-only -o m.glb").refused(2, &["--part"]);
    let mut flipped = folder.bytes("2.light");
    let middle = flipped.len() / 2;
    flipped[middle] ^= 1;
    folder.write("bad.light", &flipped);
    folder.run("merge 1.light bad.light 3.light --checkpoint w").refused(1, &["bad.light", "damaged"]);
    assert!(!folder.has("w") && !folder.has("new"));
    // What is there is completed.
    folder.succeed("merge 1.light 3.light --checkpoint w --partial -q");
    folder.succeed(&format!("{LINE} -o rest.glb --checkpoint w --resume"));
    folder.succeed(&format!("{LINE} -o one.glb"));
    assert_eq!(folder.bytes("rest.glb"), folder.bytes("one.glb"));
}
