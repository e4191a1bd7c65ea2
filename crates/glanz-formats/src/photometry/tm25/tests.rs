//! Complete and damaged ray files.

use super::*;

/// A file of two rays with the columns of `flags` (radiant flux to spectrum index), one additional column and two
/// spectral tables of 1 and 2 pairs.
fn file(identifier: i32, flags: [i32; 6], rays: &[&[f32]]) -> Vec<u8> {
    let mut out = b"TM25".to_vec();
    let int = |out: &mut Vec<u8>, v: i32| out.extend(v.to_le_bytes());
    let float = |out: &mut Vec<u8>, v: f32| out.extend(v.to_le_bytes());
    let text = |out: &mut Vec<u8>, text: &str, bytes: usize| {
        let end = out.len() + bytes;
        out.extend(text.chars().flat_map(|c| u32::from(c).to_le_bytes()));
        out.resize(end, 0);
    };
    int(&mut out, 2013);
    int(&mut out, 1);
    float(&mut out, f32::NAN);
    float(&mut out, 2.5);
    out.extend((rays.len() as u64).to_le_bytes());
    out.extend(b"2013-09-04T08:30:29+01:00\0\0\0");
    int(&mut out, 7);
    int(&mut out, identifier);
    for wavelength in [550.0, 400.0, 700.0] {
        float(&mut out, wavelength);
    }
    int(&mut out, 2);
    int(&mut out, 1);
    int(&mut out, 32);
    out.resize(256, 0);
    for flag in [1, 1].into_iter().chain(flags) {
        int(&mut out, flag);
    }
    for i in 0..9 {
        text(&mut out, &format!("Text {i} \u{3b3}\u{1d6fe}"), 4000);
    }
    assert_eq!(out.len(), 36_288);
    for table in [&[[500.0, 1.0]][..], &[[400.0, 0.5], [700.0, 0.0]]] {
        int(&mut out, table.len() as i32);
        for v in table.iter().flatten() {
            float(&mut out, *v);
        }
    }
    out.resize(out.len().next_multiple_of(32), 0);
    text(&mut out, "Phase", 512);
    text(&mut out, "More", 32);
    for v in rays.iter().copied().flatten() {
        float(&mut out, *v);
    }
    out
}

const ALL: [f32; 16] = [1., 2., 3., 0., 0.6, 0.8, 2., 500., 683., 0.1, 0.2, 0.3, 1., 0., 0., 9.];

#[test]
fn header_and_rays_are_read_as_written() {
    let second: Vec<f32> = ALL.iter().enumerate().map(|(i, v)| if i == 15 { f32::NAN } else { *v }).collect();
    let bytes = file(3, [1, 1, 1, 1, 0, 0], &[&ALL, &second]);
    let mut rays = RayReader::new(&bytes[..]).unwrap();
    let header = rays.header().clone();
    assert_eq!((header.luminous_flux, header.radiant_flux, header.ray_count), (None, Some(2.5), 2));
    assert_eq!((header.creation, header.start_position), (1, 7));
    assert_eq!(header.date, "2013-09-04T08:30:29+01:00");
    assert_eq!(header.spectral_data, SpectralData::Shared);
    assert_eq!(header.descriptions.name, "Text 0 \u{3b3}\u{1d6fe}");
    assert_eq!(header.descriptions.reference, "Text 8 \u{3b3}\u{1d6fe}");
    assert_eq!(header.spectra, [vec![[500.0, 1.0]], vec![[400.0, 0.5], [700.0, 0.0]]]);
    assert_eq!(
        (header.additional_columns, header.additional_text.as_str()),
        (vec!["Phase".to_owned()], "More")
    );
    let ray = rays.next().unwrap().unwrap();
    assert!((ray.position - DVec3::new(0.001, 0.002, 0.003)).length() < 1e-18);
    assert!((ray.direction - DVec3::new(0.0, 0.6, 0.8)).length() < 1e-7 && ray.direction.is_normalized());
    assert_eq!((ray.radiant_flux, ray.wavelength, ray.luminous_flux), (Some(2.0), Some(500.0), Some(683.0)));
    let polarization = Polarization { stokes: [0.1, 0.2, 0.3], axis: [1.0, 0.0, 0.0] };
    assert_eq!((ray.polarization, ray.tristimulus, ray.spectrum), (Some(polarization), None, None));
    assert_eq!(ray.additional, [9.0]);
    // The meaning and the range of an additional column are unknown.
    assert!(rays.next().unwrap().unwrap().additional[0].is_nan());
    assert!(rays.next().is_none());
}

#[test]
fn tristimulus_and_spectrum_index_have_their_columns() {
    let tristimulus = file(0, [0, 0, 1, 0, 1, 0], &[&[0., 0., 0., 0., 0., 1., 10., 8., 3., 0.]]);
    let ray = RayReader::new(&tristimulus[..]).unwrap().next().unwrap().unwrap();
    assert_eq!((ray.luminous_flux, ray.tristimulus), (Some(10.0), Some([8.0, 3.0])));
    let index = |i: f32| file(4, [1, 0, 0, 0, 0, 1], &[&[0., 0., 0., 0., 0., 1., 10., i, 0.]]);
    assert_eq!(RayReader::new(&index(2.0)[..]).unwrap().next().unwrap().unwrap().spectrum, Some(1));
    let error = RayReader::new(&index(3.0)[..]).unwrap().next().unwrap().unwrap_err();
    assert_eq!(
        error.to_string(),
        "byte 36864: the spectrum index of ray 0 is 3; it must be the number of a spectral table, from 1"
    );
}

#[test]
fn errors_have_their_offset() {
    let good = file(3, [1, 1, 1, 1, 0, 0], &[&ALL, &ALL]);
    let with = |at: usize, four: [u8; 4]| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&four);
        RayReader::new(&bytes[..])
            .and_then(|rays| rays.collect::<Result<Vec<_>, _>>())
            .unwrap_err()
            .to_string()
    };
    for (message, at, four) in [
        ("byte 4: not a TM-25 ray file: it does not begin with \"TM25\"", 0, *b"TM26"),
        (
            "byte 8: version 2020 is not known, only 2013 is; save the rays in that version",
            4,
            2020i32.to_le_bytes(),
        ),
        ("byte 20: the radiant flux is -1; it must be 0 or more, or not a number", 16, (-1f32).to_le_bytes()),
        ("byte 64: the spectral data identifier is 5; it must be 0 to 4", 60, 5i32.to_le_bytes()),
        ("byte 80: the number of spectral tables is -1; it must be 0 to 65536", 76, (-1i32).to_le_bytes()),
        ("byte 288: Stokes parameters need a radiant flux", 264, [0; 4]),
        (
            "byte 36292: the number of pairs of a spectral table is 2147483647; it must be 1 to 4194304 in all tables",
            36_288,
            i32::MAX.to_le_bytes(),
        ),
        // The length of (0.8, 0.6, 0.8) is the root of 1.64.
        (
            "byte 36864: the length of the direction of ray 0 is 1.2806249; it must be 1",
            36_864 + 12,
            0.8f32.to_le_bytes(),
        ),
        (
            "byte 36928: the radiant flux of ray 1 is NaN; it must be finite and not below 0",
            36_928 + 24,
            f32::NAN.to_le_bytes(),
        ),
        ("byte 36992: the file ends within ray 2 of 3; fetch it again", 20, 3i32.to_le_bytes()),
    ] {
        assert_eq!(with(at, four), message);
    }
}

#[test]
fn written_rays_are_read_back_in_single_precision() {
    let descriptions = SourceDescriptions {
        name: "Lamp \u{3b3}".to_owned(),
        // More than fits.
        information: "x".repeat(1500),
        ..SourceDescriptions::default()
    };
    let rays: Vec<(DVec3, DVec3, f32)> = (0..1000_u32)
        .map(|i| {
            let t = f64::from(i);
            let direction = DVec3::new(t.sin(), t.cos(), 0.01 * t - 3.0).normalize();
            (DVec3::new(0.1 * t, -1.0 / 3.0, t.sqrt()), direction, 0.1 + (i % 7) as f32)
        })
        .collect();
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer =
        RayWriter::new(&mut file, &descriptions, "2026-11-26T16:05:00Z and more than fits").unwrap();
    for &(position, direction, lumens) in &rays {
        writer.ray(position, direction, lumens).unwrap();
    }
    let (count, flux) = writer.finish().unwrap();
    let bytes = file.into_inner();
    assert_eq!(bytes.len(), 36_288 + 1000 * 28);
    let read = RayReader::new(&bytes[..]).unwrap();
    let header = read.header().clone();
    assert_eq!((header.ray_count, count, header.creation, header.start_position), (1000, 1000, 0, 0));
    assert_eq!(
        (header.descriptions.name.as_str(), header.descriptions.information.len()),
        ("Lamp \u{3b3}", 999)
    );
    assert_eq!((header.date.as_str(), header.radiant_flux), ("2026-11-26T16:05:00Z and mo", None));
    let sum: f64 = rays.iter().map(|ray| f64::from(ray.2)).sum();
    assert!((flux / sum - 1.0).abs() < 1e-12);
    assert!((f64::from(header.luminous_flux.unwrap()) / sum - 1.0).abs() < 1e-7);
    for (found, &(position, direction, lumens)) in read.zip(&rays) {
        let found = found.unwrap();
        assert_eq!(found.luminous_flux, Some(lumens));
        // Half a unit in the last place of the largest numbers.
        assert!((found.position - position).abs().max_element() <= 6e-8 * position.abs().max_element());
        assert!((found.direction - direction).length() < 1e-7);
    }
}

#[test]
fn unfinished_files_have_no_rays() {
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = RayWriter::new(&mut file, &SourceDescriptions::default(), "").unwrap();
    writer.ray(DVec3::ZERO, DVec3::Z, 1.0).unwrap();
    drop(writer);
    let bytes = file.into_inner();
    assert_eq!(RayReader::new(&bytes[..]).unwrap().count(), 0);
}
