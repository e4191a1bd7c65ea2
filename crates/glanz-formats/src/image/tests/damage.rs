//! Truncated files, and signatures without a file; for mutants see the package `glanz-fuzz`.

use super::*;

/// One small file of every format, of some several variants.
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
        let mut bytes = Cursor::new(Vec::new());
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

/// Number of damaged files of each kind; `GLANZ_FUZZ` multiplies it.
fn rounds(base: usize) -> usize {
    base * std::env::var("GLANZ_FUZZ").ok().and_then(|v| v.parse().ok()).unwrap_or(1)
}

/// Reading must return a picture or an error; a picture must be complete.
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
fn random_bytes_after_every_signature_give_an_error_or_a_picture() {
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
