//! OpenEXR.

use super::*;

#[test]
fn exr_returns_every_channel_bit_by_bit_and_sorted() {
    let mut pixels = picture(37, 21);
    let count = pixels.len();
    let odd = [f32::NAN, f32::INFINITY, -0.0, 1e-42, f32::MAX];
    for name in ["Z", "id", "u", "Albedo.R", "P.X", "Ns.X", "Variance.R", "N.Z"] {
        pixels.add_channel(name, (0..count).map(|i| odd[i % odd.len()] * i as f32).collect()).unwrap();
    }
    let read = linear(&write_default(&pixels, Format::Exr));
    assert_eq!(read.format, Format::Exr);
    let names: Vec<_> = read.pixels.channels().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["Albedo.R", "B", "G", "N.Z", "Ns.X", "P.X", "R", "Variance.R", "Z", "id", "u"]);
    for channel in pixels.channels() {
        let found = read.pixels.channel(&channel.name).unwrap();
        assert!(
            channel.values.iter().zip(found).all(|(a, b)| a.to_bits() == b.to_bits()),
            "{}",
            channel.name
        );
    }
}

#[test]
fn exr_keeps_attributes_and_the_same_picture_gives_the_same_bytes() {
    let attributes: BTreeMap<String, String> = [
        ("software", "Glanz 0.1"),
        ("samples", "64"),
        ("seed", "7"),
        ("scene", "Würfel.pbrt"),
        ("time", "1 s"),
    ]
    .map(|(a, b)| (a.to_owned(), b.to_owned()))
    .into();
    let bytes = write(&picture(5, 4), Format::Exr, &Tone::default(), &attributes).unwrap();
    assert_eq!(linear(&bytes).attributes, attributes);
    for _ in 0..8 {
        assert_eq!(write(&picture(5, 4), Format::Exr, &Tone::default(), &attributes).unwrap(), bytes);
    }
}

#[test]
fn exr_of_a_long_channel_name_is_read_again() {
    let mut pixels = Pixels::try_new(2, 2).unwrap();
    let name = "a".repeat(255);
    pixels.add_channel(&name, vec![1.0; 4]).unwrap();
    assert!(linear(&write_default(&pixels, Format::Exr)).pixels.channel(&name).is_some());
    for bad in ["", "a\0b", &"a".repeat(256)] {
        let mut pixels = Pixels::try_new(1, 1).unwrap();
        pixels.add_channel(bad, vec![1.0]).unwrap();
        let result = write(&pixels, Format::Exr, &Tone::default(), &no_attributes());
        assert!(matches!(result, Err(ImageError::NotWritable { .. })), "{bad:?}");
    }
}

#[test]
fn exr_of_halves_and_integers_in_every_lossless_compression_is_read() {
    use ::exr::prelude::*;
    let halves: Vec<f16> = (0..64 * 40).map(|i| f16::from_f32(i as f32 / 16.0)).collect();
    let integers: Vec<u32> = (0..64 * 40).map(|i| i * 3).collect();
    for compression in
        [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ]
    {
        for samples in [FlatSamples::F16(halves.clone()), FlatSamples::U32(integers.clone())] {
            let expected: Vec<f32> = samples.values_as_f32().collect();
            let mut bytes = Cursor::new(Vec::new());
            ::exr::image::Image::from_layer(layer(None, (64, 40), compression, samples))
                .write()
                .to_buffered(&mut bytes)
                .unwrap();
            let read = linear(bytes.get_ref());
            assert_eq!(read.pixels.channel("Y").unwrap(), expected, "{compression:?}");
        }
    }
}

#[test]
fn exr_layers_of_one_size_are_merged_under_their_names() {
    use ::exr::prelude::*;
    let of = |name, size: (usize, usize), value| {
        layer(Some(name), size, Compression::ZIP16, FlatSamples::F32(vec![value; size.0 * size.1]))
    };
    let layers = vec![of("direct", (3, 2), 1.0), of("small", (1, 1), 2.0), of("indirect", (3, 2), 3.0)];
    let image = ::exr::image::Image::from_layers(ImageAttributes::with_size((3, 2)), layers);
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    let read = linear(bytes.get_ref());
    assert_eq!(read.pixels.channel("direct.Y"), Some(&[1.0; 6][..]));
    assert_eq!(read.pixels.channel("indirect.Y"), Some(&[3.0; 6][..]));
    assert_eq!(read.skipped_layers, ["small"]);
}

#[test]
fn exr_whose_data_window_grew_is_refused() {
    let bytes = write_default(&picture(4, 4), Format::Exr);
    let at = bytes.windows(11).position(|w| w == b"dataWindow\0").unwrap() + 11 + b"box2i\0".len() + 4;
    for corner in [16_000_i32, 1_000_000, i32::MAX] {
        let mut grown = bytes.clone();
        grown[at + 8..at + 12].copy_from_slice(&corner.to_le_bytes());
        grown[at + 12..at + 16].copy_from_slice(&corner.to_le_bytes());
        let error = read(&grown, None, Encoding::Linear).unwrap_err();
        assert!(!matches!(error, ImageError::Unknown { .. }), "{error:?}");
    }
}
