use super::*;
use glanz_light::rgb::srgb_encode;

/// A reproducible stream of numbers: splitmix64 (Steele, Lea, Flood 2014).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1_u32 << 24) as f32
    }
}

fn picture(width: u32, height: u32) -> Pixels {
    let mut numbers = Numbers(7);
    let rgb: Vec<[f32; 3]> =
        (0..width * height).map(|_| [numbers.unit(), 8.0 * numbers.unit(), numbers.unit().powi(4)]).collect();
    Pixels::try_from_rgb(width, height, &rgb).unwrap()
}

fn no_attributes() -> BTreeMap<String, String> {
    BTreeMap::new()
}

fn linear(bytes: &[u8]) -> Image {
    read(bytes, None, Encoding::Linear).unwrap()
}

fn write_default(pixels: &Pixels, format: Format) -> Vec<u8> {
    write(pixels, format, &Tone::default(), &no_attributes()).unwrap()
}

/// A file of `format` made by the `image` crate, for the formats that are only read.
fn foreign(picture: &image::DynamicImage, format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

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

/// A layer with one channel `Y` of the given samples.
fn layer(
    name: Option<&str>,
    (width, height): (usize, usize),
    compression: ::exr::prelude::Compression,
    samples: ::exr::image::FlatSamples,
) -> ::exr::image::Layer<::exr::image::AnyChannels<::exr::image::FlatSamples>> {
    use ::exr::prelude::*;
    let attributes = LayerAttributes { layer_name: name.map(Text::from), ..Default::default() };
    let encoding =
        ::exr::image::Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let channels = AnyChannels::sort(SmallVec::from_vec(vec![AnyChannel::new("Y", samples)]));
    Layer::new((width, height), attributes, encoding, channels)
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
            let mut bytes = std::io::Cursor::new(Vec::new());
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
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    let read = linear(bytes.get_ref());
    assert_eq!(read.pixels.channel("direct.Y"), Some(&[1.0; 6][..]));
    assert_eq!(read.pixels.channel("indirect.Y"), Some(&[3.0; 6][..]));
    assert_eq!(read.skipped_layers, ["small"]);
}

#[test]
fn pfm_returns_every_value_bit_by_bit() {
    for (width, height) in [(1, 1), (5, 3), (16, 9)] {
        let pixels = picture(width, height);
        assert_eq!(linear(&write_default(&pixels, Format::Pfm)).pixels, pixels);
    }
    let mut grey = Pixels::try_new(2, 3).unwrap();
    grey.add_channel("Y", vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
    assert_eq!(linear(&write_default(&grey, Format::Pfm)).pixels, grey);
}

#[test]
fn pfm_of_big_endian_numbers_starts_at_the_bottom_and_is_scaled() {
    let mut file = b"Pf\n1 2\n2.0\n".to_vec();
    file.extend(1.5_f32.to_be_bytes());
    file.extend(7.0_f32.to_be_bytes());
    assert_eq!(linear(&file).pixels.channel("Y"), Some(&[14.0, 3.0][..]));
}

#[test]
fn hdr_keeps_colours_to_one_part_in_128_of_the_brightest_channel() {
    let pixels = picture(33, 7);
    let back = linear(&write_default(&pixels, Format::Hdr));
    assert_eq!(back.format, Format::Hdr);
    for (a, b) in pixels.to_rgb().unwrap().iter().zip(back.pixels.to_rgb().unwrap()) {
        let brightest = a.iter().fold(0.0_f32, |m, &v| m.max(v));
        for i in 0..3 {
            assert!((a[i] - b[i]).abs() <= brightest / 128.0, "{a:?} {b:?}");
        }
    }
}

#[test]
fn hdr_brings_what_it_cannot_hold_into_range() {
    let odd = [[f32::NAN, -1.0, 0.0], [f32::INFINITY, 1.0, f32::MAX], [1e-44, 0.0, 0.0]];
    let pixels = Pixels::try_from_rgb(3, 1, &odd).unwrap();
    let back = linear(&write_default(&pixels, Format::Hdr)).pixels.to_rgb().unwrap();
    assert_eq!(back[0], [0.0; 3]);
    assert!(back[1][0] > 1e38 && back[1][0].is_finite());
    assert!(back[2][0] < 1e-30);
}

#[test]
fn png_stores_what_the_display_shows() {
    let pixels =
        Pixels::try_from_rgb(3, 1, &[[0.0, 0.5, 1.0], [2.0, -1.0, f32::NAN], [0.214_041; 3]]).unwrap();
    let bytes = write_default(&pixels, Format::Png);
    let stored = linear(&bytes).pixels.to_rgb().unwrap();
    // 0.5 encodes to 187.5 of 255 and rounds to 188; 0.214041 is the light of 127.5, which rounds to 127 or 128.
    assert_eq!(stored[0], [0.0, 188.0 / 255.0, 1.0]);
    assert_eq!(stored[1], [1.0, 0.0, 0.0]);
    assert!((stored[2][0] * 255.0 - 127.5).abs() <= 0.5 + 1e-4);
    let light = read(&bytes, None, Encoding::Srgb).unwrap().pixels.to_rgb().unwrap();
    assert!((light[0][1] - 0.5).abs() < 0.005 && light[0][0] == 0.0 && light[0][2] == 1.0);
}

#[test]
fn png_of_every_depth_and_colour_type_is_read() {
    use image::{DynamicImage, ImageFormat, Luma, LumaA, Rgb, Rgba};
    let grey8 = DynamicImage::from(image::ImageBuffer::from_pixel(2, 2, Luma([51_u8])));
    let grey_alpha16 = DynamicImage::from(image::ImageBuffer::from_pixel(2, 2, LumaA([13107_u16, 39321])));
    let rgb16 = DynamicImage::from(image::ImageBuffer::from_pixel(2, 2, Rgb([0_u16, 13107, 65535])));
    let rgba8 = DynamicImage::from(image::ImageBuffer::from_pixel(2, 2, Rgba([0_u8, 51, 255, 153])));
    // 51 / 255 = 13107 / 65535 = 0.2 and 39321 / 65535 = 0.6.
    for (picture, expected) in [
        (grey8, vec![("Y", 0.2)]),
        (grey_alpha16, vec![("Y", 0.2), ("A", 0.6)]),
        (rgb16, vec![("R", 0.0), ("G", 0.2), ("B", 1.0)]),
        (rgba8, vec![("R", 0.0), ("G", 0.2), ("B", 1.0), ("A", 0.6)]),
    ] {
        let bytes = foreign(&picture, ImageFormat::Png);
        for encoding in [Encoding::Linear, Encoding::Srgb, Encoding::Gamma(2.2)] {
            let pixels = read(&bytes, None, encoding).unwrap().pixels;
            assert_eq!(pixels.channels().len(), expected.len());
            for &(name, stored) in &expected {
                let light = if name == "A" { stored } else { encoding.decode(stored) };
                let found = pixels.channel(name).unwrap()[3];
                assert!((found - light).abs() < 1e-6, "{name} {encoding:?}: {found}, expected {light}");
            }
        }
    }
}

#[test]
fn formats_that_are_only_read_give_the_picture_written_by_others() {
    use image::ImageFormat;
    let mut buffer = image::RgbImage::new(24, 16);
    for (x, y, pixel) in buffer.enumerate_pixels_mut() {
        *pixel = image::Rgb([(x * 10) as u8, (y * 15) as u8, 77]);
    }
    let expected: Vec<[f32; 3]> = buffer.pixels().map(|p| p.0.map(|b| f32::from(b) / 255.0)).collect();
    let picture = image::DynamicImage::from(buffer);
    for (format, theirs, tolerance) in [
        (Format::Bmp, ImageFormat::Bmp, 0.0),
        (Format::Tga, ImageFormat::Tga, 0.0),
        (Format::Qoi, ImageFormat::Qoi, 0.0),
        (Format::Pnm, ImageFormat::Pnm, 0.0),
        (Format::Jpeg, ImageFormat::Jpeg, 0.06),
    ] {
        let bytes = foreign(&picture, theirs);
        let name = std::path::PathBuf::from("picture.TGA");
        let read = read(&bytes, Some(&name), Encoding::Linear).unwrap();
        assert_eq!(read.format, format);
        for (a, b) in expected.iter().zip(read.pixels.to_rgb().unwrap()) {
            assert!((0..3).all(|i| (a[i] - b[i]).abs() <= tolerance), "{format}: {a:?} {b:?}");
        }
        let refused = write(&read.pixels, format, &Tone::default(), &no_attributes());
        assert!(matches!(refused, Err(ImageError::NotWritable { .. })));
    }
}

#[test]
fn content_decides_over_the_extension() {
    let bytes = write_default(&picture(2, 2), Format::Exr);
    assert_eq!(read(&bytes, Some(Path::new("a.png")), Encoding::Srgb).unwrap().format, Format::Exr);
    assert_eq!(Format::from_path(Path::new("x/y.JPeG")), Some(Format::Jpeg));
    assert_eq!(Format::from_path(Path::new("png")), None);
    assert_eq!(Format::from_content(b"P5 1 1"), Some(Format::Pnm));
    assert_eq!(Format::from_content(b"Pf\n"), Some(Format::Pfm));
    assert!(matches!(read(b"hello world", None, Encoding::Srgb), Err(ImageError::Unknown { .. })));
    assert!(matches!(read(b"", None, Encoding::Srgb), Err(ImageError::Unknown { .. })));
}

#[test]
fn a_few_bytes_that_claim_a_huge_picture_are_refused() {
    let claims: &[(&[u8], &str)] = &[
        (b"PF\n1000000 1000000\n-1.0\n", "pfm"),
        (b"PF\n16384 16384\n-1.0\n", "pfm"),
        (b"PF\n18446744073709551615 2\n-1.0\n", "pfm"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100000 +X 100000\n", "hdr"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16000 +X 16000\n", "hdr"),
        (b"P6 16000 16000 255\n", "ppm"),
        (b"P6 100000 100000 255\n", "ppm"),
        (b"qoif\x00\x00\x3f\xff\x00\x00\x3f\xff\x03\x00", "qoi"),
    ];
    for (bytes, name) in claims {
        let error = read(bytes, None, Encoding::Linear).unwrap_err();
        assert!(
            matches!(error, ImageError::TooLarge { .. } | ImageError::Unbacked { .. }),
            "{name}: {error:?}"
        );
    }
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

#[test]
fn errors_of_a_damaged_pfm_say_where() {
    for (file, place) in
        [(&b"PF\nx 2\n-1.0\n"[..], 3), (b"PF\n1 1\n0\n", 7), (b"PF\n1 1\n-1.0\n1234", 16), (b"PF\n1 ", 5)]
    {
        match read(file, None, Encoding::Linear) {
            Err(ImageError::Damaged { offset: Some(offset), .. }) => assert_eq!(offset, place),
            other => panic!("{other:?}"),
        }
    }
}

/// One small file of every format, some in several flavours.
fn corpus() -> Vec<(Vec<u8>, &'static str)> {
    use ::exr::prelude::*;
    use image::ImageFormat;
    let small = picture(19, 11);
    let mut files = vec![
        (write_default(&small, Format::Exr), "a.exr"),
        (write_default(&small, Format::Hdr), "a.hdr"),
        (write_default(&small, Format::Pfm), "a.pfm"),
        (write_default(&small, Format::Png), "a.png"),
    ];
    let noise = |i: usize| ((i * 2_654_435_761) >> 16) as f32 / 65_536.0;
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
        Compression::DWAA(None),
    ] {
        let halves: Vec<f16> = (0..21 * 13).map(|i| f16::from_f32(noise(i))).collect();
        let image =
            ::exr::image::Image::from_layer(layer(None, (21, 13), compression, FlatSamples::F16(halves)));
        let mut bytes = std::io::Cursor::new(Vec::new());
        if image.write().to_buffered(&mut bytes).is_ok() {
            files.push((bytes.into_inner(), "b.exr"));
        }
    }
    let colour = image::RgbaImage::from_fn(17, 9, |x, y| image::Rgba([(x * 9) as u8, (y * 7) as u8, 3, 200]));
    let colour = image::DynamicImage::from(colour);
    let opaque = image::DynamicImage::from(colour.to_rgb8());
    files.push((foreign(&colour, ImageFormat::Png), "c.png"));
    files.push((foreign(&colour, ImageFormat::Tga), "c.tga"));
    files.push((foreign(&colour, ImageFormat::Qoi), "c.qoi"));
    files.push((foreign(&opaque, ImageFormat::Bmp), "c.bmp"));
    files.push((foreign(&opaque, ImageFormat::Jpeg), "c.jpg"));
    files.push((foreign(&opaque, ImageFormat::Pnm), "c.ppm"));
    files.push((b"P2 2 2 15 1 2 3 15".to_vec(), "d.pgm"));
    files
}

/// How many damaged files of each kind are tried; `GLANZ_FUZZ` raises it by a factor.
fn rounds(base: usize) -> usize {
    base * std::env::var("GLANZ_FUZZ").ok().and_then(|v| v.parse().ok()).unwrap_or(1)
}

/// Must come back, with a picture or an error; a picture must be whole.
fn survive(bytes: &[u8], name: &str) {
    if let Ok(image) = read(bytes, Some(Path::new(name)), Encoding::Srgb) {
        assert!(image.pixels.channels().iter().all(|c| c.values.len() == image.pixels.len()));
    }
}

#[test]
fn every_truncated_file_gives_a_picture_or_an_error() {
    for (bytes, name) in corpus() {
        survive(&bytes, name);
        let step = (bytes.len() / rounds(200)).max(1);
        for length in (0..bytes.len()).step_by(step) {
            survive(&bytes[..length], name);
        }
    }
}

#[test]
fn every_mutated_file_gives_a_picture_or_an_error() {
    let mut numbers = Numbers(42);
    for (bytes, name) in corpus() {
        for _ in 0..rounds(300) {
            let mut damaged = bytes.clone();
            // Headers are where sizes are: half of the damage goes there.
            for _ in 0..1 + numbers.below(6) {
                let reach =
                    if numbers.below(2) == 0 { damaged.len().min(64 + 16 * 20) } else { damaged.len() };
                let at = numbers.below(reach);
                damaged[at] = match numbers.below(5) {
                    0 => 0,
                    1 => 0xff,
                    2 => damaged[at] ^ (1 << numbers.below(8)),
                    3 => damaged[at].wrapping_add(1),
                    _ => numbers.next() as u8,
                };
            }
            if numbers.below(4) == 0 {
                let at = numbers.below(damaged.len());
                damaged.drain(at..(at + numbers.below(9)).min(bytes.len()));
            }
            survive(&damaged, name);
        }
    }
}

#[test]
fn random_bytes_behind_every_mark_give_an_error_or_a_picture() {
    let mut numbers = Numbers(3);
    let marks: &[&[u8]] = &[
        &[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0],
        b"#?RADIANCE\n\n-Y 3 +X 40\n",
        b"PF\n3 3\n-1\n",
        b"\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR",
        &[0xff, 0xd8, 0xff, 0xdb],
        b"qoif\x00\x00\x00\x09\x00\x00\x00\x09\x03\x00",
        b"BM",
        b"P6 3 3 255\n",
        b"",
    ];
    for mark in marks {
        for _ in 0..rounds(200) {
            let length = numbers.below(300);
            let tail: Vec<u8> = (0..length).map(|_| numbers.next() as u8).collect();
            survive(&[*mark, tail.as_slice()].concat(), "a.tga");
        }
    }
}

/// An empty folder, removed at the end.
struct Folder(std::path::PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("glanz-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn entries(&self) -> usize {
        std::fs::read_dir(&self.0).unwrap().count()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn atomic_write_makes_and_replaces_a_file_and_leaves_nothing_else() {
    let folder = Folder::new("replace");
    let file = folder.0.join("picture.exr");
    write_atomically(&file, b"first").unwrap();
    write_atomically(&file, b"second").unwrap();
    assert_eq!(std::fs::read(&file).unwrap(), b"second");
    assert_eq!(folder.entries(), 1);
}

#[test]
fn atomic_write_into_a_missing_folder_or_over_a_folder_fails() {
    let folder = Folder::new("missing");
    assert!(matches!(write_atomically(&folder.0.join("no/file"), b"x"), Err(ImageError::Io { .. })));
    std::fs::create_dir(folder.0.join("taken")).unwrap();
    assert!(write_atomically(&folder.0.join("taken"), b"x").is_err());
    assert_eq!(folder.entries(), 1);
}

#[cfg(unix)]
#[test]
fn atomic_write_keeps_permissions_and_links_and_respects_read_only_files() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = Folder::new("permissions");
    let (file, link) = (folder.0.join("file"), folder.0.join("link"));
    write_atomically(&file, b"old").unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o640)).unwrap();
    symlink("file", &link).unwrap();
    write_atomically(&link, b"new").unwrap();
    assert!(link.is_symlink());
    assert_eq!(std::fs::read(&file).unwrap(), b"new");
    assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o440)).unwrap();
    assert!(write_atomically(&file, b"newer").is_err());
    assert_eq!(std::fs::read(&file).unwrap(), b"new");
    assert_eq!(folder.entries(), 2);
}

#[test]
fn stored_value_of_light_is_decoded_to_the_light() {
    for light in [0.0, 0.01, 0.5, 1.0] {
        assert!((Encoding::Srgb.decode(srgb_encode(light)) - light).abs() < 1e-6);
    }
    assert_eq!(Encoding::Linear.decode(0.3), 0.3);
    assert_eq!(Encoding::Gamma(2.0).decode(0.5), 0.25);
}
