//! The light of luminaires: intensities and rays.

use glanz::formats::Severity;
use glanz::formats::photometry::tm25::RayReader;
use glanz::formats::photometry::{PhotometryError, PhotometryFile, ies, ldt};
use glanz::math::DVec3;

use super::{ReadOutcome, Target};
use crate::mutation::Syntax;

const WORDS: &[&str] = &[
    "TILT=INCLUDE\n",
    "TILT=NONE\n",
    "TILT=x\n",
    "[MORE]",
    "[LUMINAIRE]",
    "IESNA:LM-63-1995\n",
    "0\n",
    "360",
    ",,",
    "\n",
    "\0",
    "-90",
];

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "ies",
        syntax: Syntax::Text(WORDS),
        seeds: ies_seeds,
        run: |bytes| photometry(bytes, ies::read(bytes)),
        memory_factor: 2000,
        divisor: 1,
    },
    Target {
        name: "ldt",
        syntax: Syntax::Text(WORDS),
        seeds: ldt_seeds,
        run: |bytes| photometry(bytes, ldt::read(bytes)),
        memory_factor: 2000,
        divisor: 1,
    },
    Target {
        name: "tm25",
        syntax: Syntax::Binary(288),
        seeds: ray_seeds,
        run: rays,
        memory_factor: 100,
        divisor: 1,
    },
];

/// A distribution has a flux and intensities up to its peak; an error is on a line of the file.
fn photometry(bytes: &[u8], result: Result<PhotometryFile, PhotometryError>) -> ReadOutcome {
    match &result {
        Ok(PhotometryFile { photometry, warnings }) => {
            let distribution = &photometry.distribution;
            assert!(distribution.azimuths().len() <= 4 * bytes.len() && warnings.len() <= 200);
            assert!(
                distribution.azimuths().windows(2).all(|pair| pair[0] < pair[1]),
                "angles do not increase"
            );
            assert!(photometry.flux().is_finite() && photometry.flux() >= 0.0, "flux {}", photometry.flux());
            for direction in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_ONE] {
                let (candela, peak) = (photometry.intensity(direction), distribution.peak());
                assert!((0.0..=peak * (1.0 + 1e-12)).contains(&candela), "{candela} of {peak}");
            }
            ReadOutcome::Read(warnings.first().map(ToString::to_string).unwrap_or_default())
        }
        Err(fault) => {
            let lines = bytes.iter().filter(|&&byte| byte == b'\n').count() + 1;
            assert!((1..=lines).contains(&(fault.line as usize)), "line {} of {lines}", fault.line);
            assert!(!fault.diagnostic(Severity::Error, "x", bytes).to_string().is_empty());
            result.into()
        }
    }
}

/// A ray has seven columns of four bytes at least.
fn rays(bytes: &[u8]) -> ReadOutcome {
    let mut count = 0;
    let result = RayReader::new(bytes).and_then(|rays| {
        for ray in rays {
            let ray = ray?;
            assert!(ray.position.is_finite() && ray.direction.is_normalized(), "{ray:?}");
            count += 1;
        }
        Ok(())
    });
    assert!(28 * count <= bytes.len(), "{count} rays of {} bytes", bytes.len());
    result.into()
}

fn ies_seeds() -> Vec<Vec<u8>> {
    let text = |numbers: &str, rest: &str| {
        format!(
            "IESNA:LM-63-2002\r\n[TEST] 7\r\n[MANUFAC] Glanz\r\n[LUMINAIRE] Globe\r\n[MORE] of glass\r\nTILT=NONE\r\n{numbers}\r\n{rest}\r\n"
        )
        .into_bytes()
    };
    vec![
        text("1 1000 1 3 3 1 2 1 2 0 1 1 10", "0 90 180 0 45 90 1 2 3 4 5 6 7 8 9"),
        text("1 1000 1 3 3 2 2 1 2 0 1 1 10", "-90 0 90 -90 0 90 1 2 3 4 5 6 7 8 9"),
        text("1 1000 1 3 3 3 2 -.1 -.1 -.1 1 1 10", "-90 0 90 -90 0 90 1 2 3 4 5 6 7 8 9"),
        b"IESNA91\nTILT=INCLUDE\n1\n2\n0 90\n1 .5\n1 9 1 2 1 1 1 0 0 0 1 1 1 0 90 0 1 1".to_vec(),
    ]
}

fn ldt_seeds() -> Vec<Vec<u8>> {
    let text = |symmetry: u8, sets: &str, ratios: usize, planes: usize| {
        let head = "8\n45\n3\n90\nR1\nLamp\nN1\nf.ldt\ntoday\n1200\n300\n80\n1100\n250\n0\n0\n0\n0\n50\n80,0\n1.0\n0\n";
        let angles: String = (0..8).map(|i| format!("{}\n", 45 * i)).collect();
        let values: String = (1..=planes).map(|i| format!("7\n{},0\n7\n", 10 * i)).collect();
        let ratios = "0.5\n".repeat(ratios);
        format!("Glanz\n1\n{symmetry}\n{head}{sets}{ratios}{angles}0\n90\n180\n{values}").into_bytes()
    };
    let one = "1\n2\nT16\n2000\n3000K\n1B\n60\n";
    let two = "2\n1\nA\n1000\nw\n1B\n10\n2\nB\n3000\nc\n2A\n25\n";
    vec![text(0, one, 10, 8), text(1, one, 10, 1), text(3, two, 0, 5), text(4, one, 10, 3)]
}

/// Eight rays with all columns, two spectral tables and an additional column.
fn ray_seeds() -> Vec<Vec<u8>> {
    let mut out = b"TM25".to_vec();
    let words =
        |out: &mut Vec<u8>, words: &[u32]| out.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    words(&mut out, &[2013, 1, f32::NAN.to_bits(), 2.5_f32.to_bits(), 8, 0]);
    out.extend(b"2013-09-04T08:30:29+01:00\0\0\0");
    words(&mut out, &[7, 4]);
    words(&mut out, &[550.0_f32, 400.0, 700.0].map(f32::to_bits));
    words(&mut out, &[2, 1, 32]);
    out.resize(256, 0);
    words(&mut out, &[1, 1, 1, 1, 1, 1, 0, 1]);
    // Nine descriptions of 4000 bytes, one of them with a text.
    words(&mut out, &[u32::from('L'), u32::from('\u{3b3}')]);
    out.resize(36_288, 0);
    words(&mut out, &[1, 500.0_f32.to_bits(), 1.0_f32.to_bits()]);
    words(&mut out, &[2]);
    words(&mut out, &[400.0_f32, 0.5, 700.0, 0.0].map(f32::to_bits));
    out.resize(out.len().next_multiple_of(32), 0);
    out.resize(out.len() + 512 + 32, 0);
    let ray = [1.0_f32, 2., 3., 0., 0., 1., 2., 500., 6., 0., 0., 0., 1., 0., 0., 1., 0.];
    (0..8).for_each(|_| words(&mut out, &ray.map(f32::to_bits)));
    vec![out]
}
