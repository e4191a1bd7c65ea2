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
