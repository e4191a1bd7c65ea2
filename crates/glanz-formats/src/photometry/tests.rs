//! Small files of every kind compared with closed forms, and damaged copies of them.

use std::f64::consts::PI;

use glanz_math::DVec3;
use glanz_scene::Severity;

use super::*;

const HEAD: &str = "IESNA:LM-63-2002\r\n[TEST] 17\r\n[MANUFAC] Glanz\r\n[LUMINAIRE] TILT=INCLUDE in name only\r\n\
    [MORE] and more\r\n[LUMCAT] G-1\r\nTILT=NONE\r\n";

/// A file of edition 2002 with `lamp_line`, 13 numbers, and what follows.
fn ies_text(lamp_line: &str, rest: &str) -> String {
    format!("{HEAD}{lamp_line}\r\n{rest}\r\n")
}

fn read_ies(text: &str) -> PhotometryFile {
    ies::read(text.as_bytes()).unwrap_or_else(|fault| panic!("{fault}\n{text}"))
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{a} against {b}");
}

fn along(azimuth: f64, gamma: f64) -> DVec3 {
    let ((s, c), (sa, ca)) = (gamma.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    DVec3::new(s * ca, s * sa, -c)
}

#[test]
fn axial_file_is_read_with_its_whole_header() {
    let text = ies_text("2 600 1.5 3 1 1 1 -2 -2 0  0.5 1 40", "0,90,180 0 100 100\n100");
    let PhotometryFile { photometry: p, warnings } = read_ies(&text);
    assert_eq!(warnings, []);
    assert_eq!(p.format, PhotometryFormat::Ies(2002));
    assert_eq!((p.multiplier, p.ballast_factor, p.input_watts, p.is_absolute), (1.5, 0.5, 40.0, false));
    assert_eq!((p.names.manufacturer.as_str(), p.names.report.as_str()), ("Glanz", "17"));
    assert_eq!(p.names.luminaire, "TILT=INCLUDE in name only\nand more");
    assert_eq!(p.opening, LuminousOpening { shape: OpeningShape::Ellipse, size: [0.6096, 0.6096, 0.0] });
    assert_eq!((p.lamps[0].count, p.lamps[0].lumens), (2.0, Some(1200.0)));
    // 100 cd times 1.5 times 0.5 everywhere; two lamps of 600 lm at half their flux.
    close(p.flux(), 4.0 * PI * 75.0);
    assert_eq!(p.header_flux(), Some(600.0));
    assert_eq!(p.intensity(DVec3::new(1.0, -2.0, 3.0)), 75.0);
    let scaled = p.scaled_to(1000.0).unwrap();
    close(scaled.flux(), 1000.0);
    close(scaled.intensity(DVec3::X), 1000.0 / (4.0 * PI));
    assert_eq!((p.scaled_to(-1.0), p.scaled_to(f64::NAN)), (None, None));
    assert_eq!(p.scaled_by(0.0).unwrap().scaled_to(10.0), None);
}

#[test]
fn every_symmetry_of_type_c_is_expanded() {
    // Intensity at gamma 90 by plane; 10 per plane in order of the file, 7 at the poles.
    for (angles, symmetry, at) in [
        ("0 45 90", Symmetry::Quadrants, [10., 20., 30., 20., 10., 20., 30., 20.]),
        ("0 45 90 135 180", Symmetry::AcrossY, [10., 20., 30., 40., 50., 40., 30., 20.]),
        ("90 135 180 225 270", Symmetry::AcrossX, [30., 20., 10., 20., 30., 40., 50., 40.]),
        ("0 45 90 135 180 225 270 315 360", Symmetry::None, [10., 20., 30., 40., 50., 60., 70., 80.]),
        ("0 45 90 135 180 225 270 315", Symmetry::None, [10., 20., 30., 40., 50., 60., 70., 80.]),
    ] {
        let count = angles.split(' ').count();
        let planes: Vec<String> =
            (1..=count).map(|i| format!("7 {} 7", if i == 9 { 10 } else { 10 * i })).collect();
        let lamp_line = format!("1 1000 1 3 {count} 1 2 1 2 0 1 1 10");
        let file = read_ies(&ies_text(&lamp_line, &format!("0 90 180\n{angles}\n{}", planes.join("\n"))));
        let p = file.photometry;
        assert_eq!(p.distribution.symmetry(), symmetry);
        assert_eq!(p.opening, LuminousOpening { shape: OpeningShape::Rectangle, size: [2.0, 1.0, 0.0] });
        for (i, expected) in at.into_iter().enumerate() {
            close(p.intensity(along(45.0 * i as f64, 90.0)), expected);
        }
        close(p.intensity(along(22.5, 90.0)), 0.5 * (at[0] + at[1]));
        close(p.intensity(along(337.5, 45.0)), 0.25 * (at[0] + at[7]) + 3.5);
        // Linear from the poles: 7 everywhere, and (I - 7) times a tent in gamma, whose integral with sin is 4 / pi.
        let mean = at.iter().sum::<f64>() / 8.0;
        close(p.flux(), 2.0 * PI * (2.0 * 7.0 + (mean - 7.0) * 4.0 / PI));
        let told: Vec<&PhotometryErrorKind> = file.warnings.iter().map(|w| &w.kind).collect();
        assert_eq!(told, if count == 8 { vec![&PhotometryErrorKind::Open(315.0)] } else { vec![] });
    }
}

#[test]
fn types_a_and_b_are_rotated_to_the_frame_of_the_luminaire() {
    // Value 100 + 10 H + V, with H in {-90, 0, 90} and V in {-90, 0, 90} counted in units of 90.
    let rows = "89 90 91  99 100 101  109 110 111";
    let angles = "-90 0 90  -90 0 90";
    let of = |kind: u8| {
        let text = ies_text(&format!("1 1000 1 3 3 {kind} 2 0 0 0 1 1 10"), &format!("{angles} {rows}"));
        read_ies(&text).photometry
    };
    let a = of(3);
    assert_eq!(a.distribution.system(), AngularSystem::A);
    close(a.intensity(DVec3::X), 100.0);
    close(a.intensity(DVec3::NEG_Y), 110.0);
    close(a.intensity(DVec3::Y), 90.0);
    // Halfway up in the plane of H = 0.
    close(a.intensity(DVec3::new(1.0, 0.0, 1.0)), 100.5);
    assert_eq!(a.intensity(DVec3::NEG_X), 0.0);
    let b = of(2);
    assert_eq!(b.distribution.system(), AngularSystem::B);
    close(b.intensity(DVec3::NEG_Z), 100.0);
    close(b.intensity(DVec3::X), 101.0);
    close(b.intensity(DVec3::NEG_X), 99.0);
    close(b.intensity(DVec3::new(0.0, -1.0, -1.0)), 105.0);
    close(b.intensity(DVec3::new(0.0, 1.0, -1.0)), 95.0);
    // By oddness of the rest, 100 cd over a hemisphere.
    close(a.flux(), 200.0 * PI);
    close(b.flux(), 200.0 * PI);
}

#[test]
fn types_a_and_b_from_0_to_90_are_symmetric() {
    for kind in [2, 3] {
        let lamp_line = format!("1 1000 1 2 2 {kind} 2 0 0 0 1 1 10");
        let p = read_ies(&ies_text(&lamp_line, "-90 90 0 90 10 10 20 20")).photometry;
        assert_eq!(p.distribution.symmetry(), Symmetry::AcrossY);
        let side = DVec3::new(1.0, 1.0, 0.0);
        close(p.intensity(side), 15.0);
        close(p.intensity(DVec3::new(1.0, -1.0, 0.0)), 15.0);
        // Type A: the mean over H is 15. Type B: 10 + 10 times |beta| / 90 with cos beta: 2 pi (10 + 10 (1 - 2 / pi)).
        let expected = if kind == 3 { 30.0 * PI } else { 2.0 * PI * (20.0 - 20.0 / PI) };
        close(p.flux(), expected);
    }
}

#[test]
fn tilt_is_read_from_the_file_or_another_one_and_not_applied() {
    let body = "1 1000 1 2 1 1 2 0 0 0 1 1 10 0 180 0 5 5";
    let with = |tilt: &str| format!("IESNA91\n[TEST] x\nTILT={tilt}\n{body}");
    let records = "2\n3\n0 45, 90\n1 .9 0.5\n";
    let included = read_ies(&with(&format!("INCLUDE\n{records}"))).photometry;
    let tilt = included.tilt.clone().unwrap();
    assert_eq!(tilt.geometry, LampGeometry::Horizontal);
    assert_eq!((tilt.factor(0.0), tilt.factor(45.0), tilt.factor(120.0)), (1.0, 0.9, 0.5));
    close(tilt.factor(-22.5), 0.95);
    close(included.flux(), 20.0 * PI);
    close(included.scaled_by(tilt.factor(90.0)).unwrap().flux(), 10.0 * PI);

    let named = with("lamp.tlt");
    let mut asked = Vec::new();
    let mut give = |name: &str| {
        asked.push(name.to_owned());
        Ok(records.as_bytes().to_vec())
    };
    let other = ies::read_with(named.as_bytes(), &mut give).unwrap().photometry;
    assert_eq!((other, asked), (included, vec!["lamp.tlt".to_owned()]));
    assert_eq!(
        ies::read(named.as_bytes()).unwrap_err().to_string(),
        "3:1: the tilt data in \"lamp.tlt\" cannot be read: other files cannot be read here"
    );
    assert_eq!(
        ies::read_with(named.as_bytes(), &mut |_| Ok(b"1 2 0".to_vec())).unwrap_err().kind,
        PhotometryErrorKind::TiltFile {
            name: "lamp.tlt".to_owned(),
            reason: "1:3: 2 tilt angles are declared; the file has room for 1".to_owned()
        }
    );
}

#[test]
fn editions_differ_in_their_factors_and_openings() {
    let body = "TILT=NONE\n1 1000 1 2 1 1 2 -3 0 -3 1 0.5 10 0 180 0 8 8";
    let of = |head: &str| read_ies(&format!("{head}{body}"));
    for (head, year, intensity, shape) in [
        ("A luminaire\nwithout an edition\n", 1986, 4.0, OpeningShape::Ellipsoid),
        ("IESNA91\n[TEST] 1\n", 1991, 4.0, OpeningShape::Ellipsoid),
        ("IESNA:LM-63-1995\n", 1995, 8.0, OpeningShape::Ellipsoid),
        ("IESNA:LM-63-2002\n", 2002, 8.0, OpeningShape::EllipseFacingX),
        ("IES:LM-63-2019\n", 2019, 8.0, OpeningShape::EllipseFacingX),
    ] {
        let PhotometryFile { photometry: p, warnings } = of(head);
        assert_eq!(p.format, PhotometryFormat::Ies(year));
        assert_eq!((p.intensity(DVec3::X), p.opening.shape), (intensity, shape), "{head}");
        assert_eq!(p.generation, (year == 2019).then_some(0.5));
        let told = matches!(year, 1995 | 2002);
        assert_eq!(warnings.iter().any(|w| w.kind == PhotometryErrorKind::FutureUse(0.5)), told);
    }
    let old = of("First line\n").photometry.keywords;
    assert_eq!(old, [(String::new(), "First line".to_owned())]);
    let odd = of("IES:LM-63-2031\n");
    assert_eq!(
        odd.warnings[0].to_string(),
        "1:1: the edition \"IES:LM-63-2031\" of LM-63 is unknown; the file is read as that of 2019"
    );
}

#[test]
fn absolute_photometry_and_latin_letters_are_supported() {
    let body = b"TILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 10 0 180 0 8 8\x1a";
    for (maker, name) in [
        (&b"[MANUFAC] L\xfcster \x80\n"[..], "L\u{fc}ster \u{20ac}"),
        ("[MANUFAC] Lüster\n".as_bytes(), "Lüster"),
    ] {
        let bytes = [b"IESNA:LM-63-2002\n", maker, body].concat();
        let p = ies::read(&bytes).unwrap().photometry;
        assert_eq!(p.names.manufacturer, name);
        assert!(p.is_absolute && p.header_flux().is_none());
        close(p.flux(), 32.0 * PI);
    }
}

/// An EULUMDAT file of 8 planes 45 degrees apart and gamma 0, 90, 180; `lamps`: lines of the sets.
fn ldt_text(symmetry: u8, sets: &str, ratios: bool, planes: usize) -> String {
    let mut text = format!(
        "Glanz\n1\n{symmetry}\n8\n45\n3\n90\nR1\nLamp\nN1\nf.ldt\ntoday\n1200\n300\n80\n1100\n250\n0\n0\n0\n0\n50\n80,0\n1.0\n0\n{sets}"
    );
    if ratios {
        text.push_str(&"0.5\n".repeat(10));
    }
    for i in 0..8 {
        text.push_str(&format!("{}\n", 45 * i));
    }
    text.push_str("0\n90\n180\n");
    for i in 1..=planes {
        text.push_str(&format!("7\n{},0\n7\n", 10 * i));
    }
    text
}

const ONE_SET: &str = "1\n2\nT16\n2000\n3000K\n1B\n60\n";

#[test]
fn every_symmetry_of_eulumdat_is_expanded() {
    for (symmetry, planes, at) in [
        (0, 8, [10., 20., 30., 40., 50., 60., 70., 80.]),
        (1, 1, [10.; 8]),
        (2, 5, [10., 20., 30., 40., 50., 40., 30., 20.]),
        (3, 5, [30., 40., 50., 40., 30., 20., 10., 20.]),
        (4, 3, [10., 20., 30., 20., 10., 20., 30., 20.]),
    ] {
        let file = ldt::read(ldt_text(symmetry, ONE_SET, true, planes).as_bytes()).unwrap();
        assert_eq!(file.warnings, []);
        let p = file.photometry;
        // Per 1000 lm of 2000 lm.
        for (i, expected) in at.into_iter().enumerate() {
            close(p.intensity(along(45.0 * i as f64, 90.0)), 2.0 * expected);
        }
        let mean = at.iter().sum::<f64>() / 8.0;
        close(p.flux(), 4.0 * PI * (2.0 * 7.0 + (mean - 7.0) * 4.0 / PI));
        close(p.header_flux().unwrap(), 1600.0);
        // The length is along y, because C0 is the plane across.
        assert_eq!(p.opening, LuminousOpening { shape: OpeningShape::Rectangle, size: [0.25, 1.1, 0.0] });
        assert_eq!(p.eulumdat.unwrap().direct_ratios, Some([0.5; 10]));
    }
}

#[test]
fn eulumdat_without_direct_ratios_or_of_several_sets_or_absolute_is_read() {
    let missing = ldt::read(ldt_text(1, ONE_SET, false, 1).as_bytes()).unwrap();
    // Expected position: after 26 lines and 6 of the only set.
    assert_eq!(missing.warnings[0].to_string(), "33:1: the ten direct ratios are missing");
    let whole = ldt::read(ldt_text(1, ONE_SET, true, 1).as_bytes()).unwrap();
    assert_eq!(missing.photometry.distribution, whole.photometry.distribution);

    let by_set = "2\n1\nA\n1000\nw\n1B\n10\n2\nB\n3000\nc\n2A\n25\n";
    let by_field = "2\n1\n2\nA\nB\n1000\n3000\nw\nc\n1B\n2A\n10\n25\n";
    let one = ldt::read(ldt_text(1, by_set, true, 1).as_bytes()).unwrap();
    let other = ldt::read(ldt_text(1, by_field, true, 1).as_bytes()).unwrap();
    assert_eq!(other.photometry, one.photometry);
    assert_eq!(other.warnings[0].kind, PhotometryErrorKind::FieldByField);
    close(one.photometry.intensity(along(0.0, 90.0)), 10.0);
    let second = one.photometry.with_lamps(1).unwrap();
    close(second.intensity(along(0.0, 90.0)), 30.0);
    assert_eq!((second.lamps[0].name.as_str(), second.input_watts), ("B", 25.0));
    assert_eq!(one.photometry.with_lamps(2), None);

    let absolute = ldt::read(ldt_text(1, "1\n-1\nLED\n500\n\n\n5\n", true, 1).as_bytes()).unwrap().photometry;
    assert!(absolute.is_absolute && absolute.lamps[0].count == 1.0);
    close(absolute.intensity(DVec3::NEG_Z), 3.5);
}

#[test]
fn errors_have_a_position_and_a_remedy() {
    let good = ies_text("1 1000 1 3 1 1 2 0 0 0 1 1 10", "0 90 180\n0\n1 2 3");
    let replaced = |from: &str, to: &str| good.replacen(from, to, 1);
    for (text, message) in [
        (replaced("TILT=NONE", "TILTED"), "11:1: there is no line that begins with \"TILT=\""),
        (replaced("1 2 3", "1 two 3"), "11:3: \"two\" is not a number; the intensity is expected here"),
        (replaced("1 2 3", "1 inf 3"), "11:3: \"inf\" is not a number; the intensity is expected here"),
        (replaced("1 2 3", "1 2"), "12:1: the file ends before the intensity"),
        (replaced("0 90 180", "0 90 90"), "9:6: the vertical angle must ascend, but 90 follows 90"),
        (
            replaced("0 90 180", "0 90 181"),
            "9:6: the vertical angles run from 0 to 181; they must run within 0 and 180",
        ),
        (
            replaced(" 3 1 1 2", " 999999999 1 1 2"),
            "8:10: 999999999 vertical angles are declared; the file has room for 20",
        ),
        (
            replaced(" 3 1 1 2", " 3 1 4 2"),
            "8:14: the photometric type is 4; it must be 1 (C), 2 (B) or 3 (A)",
        ),
        (
            replaced(" 3 1 1 2", " 3.5 1 1 2"),
            "8:10: the number of angles is 3.5; it must be a whole number from 2",
        ),
    ] {
        assert_eq!(ies::read(text.as_bytes()).unwrap_err().to_string(), message);
    }
    let text = replaced("1 2 3", "1 two 3");
    let fault = ies::read(text.as_bytes()).unwrap_err();
    assert_eq!(
        fault.diagnostic(Severity::Error, "a.ies", text.as_bytes()).to_string(),
        "error: a.ies:11:3: \"two\" is not a number; the intensity is expected here\n  11 | 1 two 3\n     |   ^^^\n  \
         help: a value before it may be missing or one too many\n"
    );
    assert_eq!(ies::read(b"\xff\xfeI\0E\0").unwrap_err().to_string(), "1:1: the file is UTF-16 text");
    let odd = read_ies(&replaced("1 2 3", "1 -2 3 4"));
    let kinds: Vec<PhotometryErrorKind> = odd.warnings.into_iter().map(|w| w.kind).collect();
    assert_eq!(kinds, [PhotometryErrorKind::Negative(1), PhotometryErrorKind::Trailing]);
    let ldt = ldt_text(3, ONE_SET, true, 5);
    // The room after the line: a digit and a line end for each value.
    let room = (ldt.len() - ldt.find("45\n").unwrap()).div_ceil(2);
    let fault =
        |from: &str, to: &str| ldt::read(ldt.replacen(from, to, 1).as_bytes()).unwrap_err().to_string();
    assert_eq!(
        fault("3\n8\n45", "3\n99999999999\n45"),
        format!("4:1: 99999999999 C planes are declared; the file has room for {room}")
    );
    assert_eq!(
        fault("270\n", "271\n"),
        "50:1: the C angles run from 0 to 315; they must run from 0 to below 360, with planes on those of the symmetry"
    );
}

#[test]
fn flux_is_the_sum_of_intensities_over_small_solid_angles() {
    // A grid without any symmetry, three times four values.
    let values = "5 1 9 2  7 3 8 1  4 6 2 9";
    for (kind, angles) in
        [(1, "0 20 100 180  0 90 360"), (2, "-90 -30 10 90  -90 20 90"), (3, "-90 -30 10 90  -90 20 90")]
    {
        let p =
            read_ies(&ies_text(&format!("1 -1 1 4 3 {kind} 2 0 0 0 1 1 1"), &format!("{angles} {values}")))
                .photometry;
        // Points at the centres of equal areas; the grid's borders do not fall on their lattice, so the error is of
        // the order of a line of cells where the intensity jumps to zero (types A and B), else of a cell.
        let n = 500;
        let mut sum = 0.0;
        for i in 0..n {
            let z = -1.0 + (i as f64 + 0.5) * 2.0 / f64::from(n);
            for j in 0..2 * n {
                let (s, c) = ((f64::from(j) + 0.5) * PI / f64::from(n)).sin_cos();
                let r = (1.0 - z * z).sqrt();
                sum += p.intensity(DVec3::new(r * c, r * s, z));
            }
        }
        let slow = sum * 4.0 * PI / f64::from(2 * n * n);
        assert!((slow / p.flux() - 1.0).abs() < 2e-4, "type {kind}: {slow} {}", p.flux());
    }
}

#[test]
fn the_format_is_recognised_by_content() {
    let ies = ies_text("1 1000 1 2 1 1 2 0 0 0 1 1 10", "0 180 0 1 1");
    assert_eq!(read(ies.as_bytes()).unwrap().photometry.format, PhotometryFormat::Ies(2002));
    let old = ies.replacen("IESNA:LM-63-2002", "Our lamp", 1);
    assert_eq!(read(old.as_bytes()).unwrap().photometry.format, PhotometryFormat::Ies(1986));
    let ldt = ldt_text(1, ONE_SET, true, 1);
    assert_eq!(read(ldt.as_bytes()).unwrap().photometry.format, PhotometryFormat::Eulumdat);
}
