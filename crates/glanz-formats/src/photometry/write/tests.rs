//! Written files are read back.

use std::f64::consts::PI;

use proptest::prelude::*;

use super::*;
use crate::photometry::{OpeningShape, Photometry, PhotometryFile, read};

/// A distribution of type C from its planes, made by the reader.
fn distribution(azimuths: &[f64], polars: &[f64], candela: &[f64]) -> IntensityDistribution {
    let row = |values: &[f64]| values.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(" ");
    let (n, m) = (polars.len(), azimuths.len());
    let lists = [polars, azimuths, candela].map(row).join("\n");
    let text = format!("IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {n} {m} 1 2 0 0 0\n1 1 0\n{lists}\n");
    read(text.as_bytes()).unwrap().photometry.distribution
}

fn header() -> Header {
    let names = Names {
        manufacturer: "Glanz\r\nTILT=NONE".into(),
        luminaire: "Gr\u{f6}\u{df}e \u{2126}".into(),
        catalog_number: "tilt=include".into(),
        report: String::new(),
        issued: "2026-01-02".into(),
    };
    let opening = LuminousOpening { shape: OpeningShape::Rectangle, size: [0.6, 1.2, 0.0] };
    Header { names, laboratory: "computed".into(), opening, watts: 36.5 }
}

/// Reads a file that must have no errors and no warnings.
fn read_well(file: &[u8]) -> Photometry {
    let PhotometryFile { photometry, warnings } =
        read(file).unwrap_or_else(|fault| panic!("{fault}\n{}", String::from_utf8_lossy(file)));
    assert_eq!(warnings, [], "{}", String::from_utf8_lossy(file));
    photometry
}

#[test]
fn headers_contain_names_numbers_and_flux() {
    // 100 cd into the lower half space.
    let lamp = distribution(&[0.0], &[0.0, 45.0, 90.0], &[100.0; 3]);
    let ies = read_well(&ies(&lamp, &header()).unwrap());
    assert!(ies.is_absolute && ies.lamps[0].lumens.is_none());
    assert_eq!((ies.names.manufacturer.as_str(), ies.names.report.as_str()), ("Glanz  TILT=NONE", "N/A"));
    assert_eq!((ies.names.luminaire.as_str(), ies.input_watts), ("Gr??e ?", 36.5));
    assert_eq!(ies.opening, header().opening);
    assert!(ies.keywords.contains(&("TESTLAB".into(), "computed".into())));
    assert!(ies.keywords.contains(&("OTHER".into(), "Absolute photometry of 628.31853 lm".into())));

    let ldt = read_well(&ldt(&lamp, &header()).unwrap());
    let extra = ldt.eulumdat.clone().unwrap();
    assert!(ldt.is_absolute && (ldt.header_flux().unwrap() - 200.0 * PI).abs() < 1e-9);
    assert_eq!((ldt.names.luminaire.as_str(), ldt.names.report.as_str()), ("Gr\u{f6}\u{df}e ?", ""));
    assert_eq!((extra.downward_fraction, extra.light_output_ratio, extra.luminaire_type), (1.0, 1.0, 1));
    assert_eq!(
        (ldt.names.catalog_number.as_str(), ies.names.catalog_number.as_str()),
        ("tilt include", "tilt=include")
    );
    assert_eq!((ldt.opening, ldt.input_watts), (header().opening, 36.5));
}

#[test]
fn openings_preserve_their_shapes() {
    let lamp = distribution(&[0.0], &[0.0, 90.0], &[1.0; 2]);
    let both = [(OpeningShape::Ellipse, [0.5, 0.5, 0.0]), (OpeningShape::VerticalCylinder, [0.5, 0.5, 0.2])];
    let in_ies = [
        (OpeningShape::Ellipsoid, [0.5, 0.4, 0.3]),
        (OpeningShape::CylinderAlongX, [0.5, 0.1, 0.1]),
        (OpeningShape::CylinderAlongY, [0.1, 0.5, 0.1]),
        (OpeningShape::EllipseFacingX, [0.0, 0.5, 0.4]),
        (OpeningShape::Box, [0.5, 0.4, 0.3]),
        (OpeningShape::Point, [0.0; 3]),
    ];
    for (shape, size) in both.into_iter().chain(in_ies) {
        let opening = LuminousOpening { shape, size };
        let header = Header { opening, ..Header::default() };
        assert_eq!(read_well(&ies(&lamp, &header).unwrap()).opening, opening);
        let from_ldt = read_well(&ldt(&lamp, &header).unwrap()).opening;
        if both.contains(&(shape, size)) || matches!(shape, OpeningShape::Box | OpeningShape::Point) {
            assert_eq!(from_ldt, opening);
        }
    }
}

#[test]
fn downward_fraction_is_that_of_the_flux_below_the_horizontal() {
    // For 1 + cos gamma over the sphere the fraction is 3/4; for its linear interpolation by 1 degree up to 1e-4.
    let polars: Vec<f64> = (0..=180).map(f64::from).collect();
    let candela: Vec<f64> = polars.iter().map(|gamma| 1.0 + gamma.to_radians().cos()).collect();
    let lamp = distribution(&[0.0], &polars, &candela);
    let extra = read_well(&ldt(&lamp, &Header::default()).unwrap()).eulumdat.unwrap();
    assert!((extra.downward_fraction - 0.75).abs() < 1e-4, "{}", extra.downward_fraction);
    // 3 cd over two steps of 90 degrees in azimuth of four, as linear tents: half of the light is at C90.
    let values = [1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 1.0, 1.0, 1.0];
    let lamp = distribution(&[0.0, 90.0, 180.0, 270.0, 360.0], &[0.0, 90.0, 180.0], &values);
    let extra = read_well(&ldt(&lamp, &Header::default()).unwrap()).eulumdat.unwrap();
    assert_eq!(extra.downward_fraction, 0.5);
}

#[test]
fn unsupported_distributions_are_refused() {
    let header = Header::default();
    let dark = distribution(&[0.0], &[0.0, 90.0], &[0.0; 2]);
    assert_eq!(ldt(&dark, &header), Err(PhotometryWriteError::Dark));
    assert_eq!(read_well(&ies(&dark, &header).unwrap()).flux(), 0.0);
    let part = distribution(&[0.0], &[10.0, 90.0], &[1.0; 2]);
    let refused = PhotometryWriteError::Gammas { count: 2, first: 10.0, last: 90.0 };
    assert_eq!((ies(&part, &header), ldt(&part, &header)), (Err(refused.clone()), Err(refused)));
    // A luminaire with a single plane is axially symmetric.
    let round = distribution(&[0.0, 360.0], &[0.0, 90.0], &[1.0; 4]);
    assert_eq!(read_well(&ldt(&round, &header).unwrap()).distribution.azimuths(), [0.0]);
    let text = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 2 2 2 0 0 0\n1 1 0\n-90 90\n-90 90\n1 1 1 1\n";
    let floodlight = read(text.as_bytes()).unwrap().photometry.distribution;
    assert_eq!(ies(&floodlight, &header), Err(PhotometryWriteError::System(AngularSystem::B)));
}

proptest! {
    #[test]
    fn written_distributions_are_read_back(
        ends in prop::sample::select(vec![(0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (90.0, 270.0), (0.0, 360.0)]),
        between in prop::collection::btree_set(1_u32..36, 1..7),
        gammas in prop::collection::btree_set(1_u32..64, 0..9),
        reach in prop::sample::select(vec![(0.0, 90.0), (0.0, 180.0), (90.0, 180.0)]),
        candela in prop::collection::vec(prop_oneof![Just(0.0), 1e-6..1e7_f64], 9 * 11),
    ) {
        let along = |(from, to): (f64, f64), inner: &std::collections::BTreeSet<u32>, parts: f64| -> Vec<f64> {
            if from == to {
                return vec![from];
            }
            let inner = inner.iter().map(|i| from + (to - from) * f64::from(*i) / parts);
            std::iter::once(from).chain(inner).chain([to]).collect()
        };
        let (azimuths, polars) = (along(ends, &between, 36.0), along(reach, &gammas, 64.0));
        let n = polars.len();
        let mut candela = candela[..n * azimuths.len()].to_vec();
        // Some light, so that EULUMDAT can be written.
        candela[0] += 1.0;
        candela[1] += 1.0;
        if ends.1 == 360.0 {
            let first = candela[..n].to_vec();
            candela[n * (azimuths.len() - 1)..].copy_from_slice(&first);
        }
        let lamp = distribution(&azimuths, &polars, &candela);
        for file in [ies(&lamp, &header()).unwrap(), ldt(&lamp, &header()).unwrap()] {
            let again = read_well(&file).distribution;
            prop_assert_eq!(again.symmetry(), lamp.symmetry());
            prop_assert_eq!(again.azimuths(), lamp.azimuths());
            prop_assert_eq!(again.polars(), lamp.polars());
            for i in 0..lamp.azimuths().len() {
                for (was, is) in lamp.plane(i).iter().zip(again.plane(i)) {
                    // Half a unit in the eighth digit; EULUMDAT also divides and multiplies.
                    prop_assert!((was - is).abs() <= 5.1e-8 * was, "{} {}", was, is);
                }
            }
            prop_assert!((again.flux() - lamp.flux()).abs() <= 1e-7 * lamp.flux());
            prop_assert!(file.split(|b| *b == b'\n').all(|line| line.len() < 256));
        }
    }
}
