//! The other formats, and the recognition of formats.

use super::*;

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
fn hdr_brings_unsupported_values_into_range() {
    let odd = [[f32::NAN, -1.0, 0.0], [f32::INFINITY, 1.0, f32::MAX], [1e-44, 0.0, 0.0]];
    let pixels = Pixels::try_from_rgb(3, 1, &odd).unwrap();
    let back = linear(&write_default(&pixels, Format::Hdr)).pixels.to_rgb().unwrap();
    assert_eq!(back[0], [0.0; 3]);
    assert!(back[1][0] > 1e38 && back[1][0].is_finite());
    assert!(back[2][0] < 1e-30);
}

#[test]
fn png_stores_display_values() {
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
fn formats_that_are_only_read_give_pictures_written_by_another_library() {
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
fn content_takes_precedence_over_the_extension() {
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
        assert!(matches!(error, ImageError::Unbacked { .. }), "{name}: {error:?}");
    }
}

#[test]
fn errors_of_a_damaged_pfm_have_an_offset() {
    for (file, place) in
        [(&b"PF\nx 2\n-1.0\n"[..], 3), (b"PF\n1 1\n0\n", 7), (b"PF\n1 1\n-1.0\n1234", 16), (b"PF\n1 ", 5)]
    {
        match read(file, None, Encoding::Linear) {
            Err(ImageError::Damaged { offset: Some(offset), .. }) => assert_eq!(offset, place),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn stored_value_of_light_is_decoded_to_the_light() {
    for light in [0.0, 0.01, 0.5, 1.0] {
        assert!((Encoding::Srgb.decode(srgb_encode(light)) - light).abs() < 1e-6);
    }
    assert_eq!(Encoding::Linear.decode(0.3), 0.3);
    assert_eq!(Encoding::Gamma(2.0).decode(0.5), 0.25);
}
