//! Pictures of every kind.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use ::exr::image::write::WritableImage;
use ::exr::prelude::{Blocks, Compression, LayerAttributes, LineOrder, f16};
use glanz::formats::image::{self as reader, Format};
use glanz::job::{CancelFlag, ResourceBudget};
use glanz::light::{Pixels, Tone};
use image::{DynamicImage, ImageFormat, RgbaImage};

use super::{ReadOutcome, Target, of_both};
use crate::limits;
use crate::mutation::{RandomStream, Syntax};

/// A target of pictures whose files have this name.
macro_rules! picture {
    ($name:literal, $file:literal, $syntax:expr, $seeds:expr) => {
        Target {
            name: $name,
            syntax: $syntax,
            seeds: $seeds,
            run: |bytes| read(bytes, $file),
            memory_factor: 16,
            divisor: 1,
        }
    };
}

pub(super) const TARGETS: &[Target] = &[
    picture!("exr", "a.exr", Syntax::Binary(400), exr_seeds),
    picture!("hdr", "a.hdr", Syntax::Binary(80), || vec![written(Format::Hdr)]),
    picture!("pfm", "a.pfm", Syntax::Binary(16), || vec![
        written(Format::Pfm),
        b"Pf 2 1 1.0\n\0\0\0\0\0\0\0\0".to_vec()
    ]),
    Target {
        name: "png",
        syntax: Syntax::Binary(64),
        seeds: || vec![written(Format::Png), foreign(true, ImageFormat::Png)],
        run: |bytes| of_both(bytes, &sealed_png(bytes), |bytes| read(bytes, "a.png")),
        memory_factor: 16,
        divisor: 1,
    },
    picture!("jpeg", "a.jpg", Syntax::Binary(700), || vec![foreign(false, ImageFormat::Jpeg)]),
    picture!("bmp", "a.bmp", Syntax::Binary(60), || vec![foreign(false, ImageFormat::Bmp)]),
    picture!("tga", "a.tga", Syntax::Binary(20), || vec![foreign(true, ImageFormat::Tga)]),
    picture!("qoi", "a.qoi", Syntax::Binary(16), || vec![foreign(true, ImageFormat::Qoi)]),
    picture!("pnm", "a.ppm", Syntax::Text(&["P1", "P2", "P3", "P5", "P6", "P7", "#", "65535"]), || vec![
        foreign(false, ImageFormat::Pnm),
        b"P2 2 2 15 1 2 3 15".to_vec(),
        b"P1\n# bits\n4 2\n1 0 1 0 0 1 1 0".to_vec(),
    ]),
];

/// A picture is complete.
fn read(bytes: &[u8], name: &str) -> ReadOutcome {
    let budget = ResourceBudget::new(limits::of_reading(), CancelFlag::default());
    let result = reader::read_with(bytes, Some(Path::new(name)), reader::Encoding::Srgb, &budget);
    if let Ok(image) = &result {
        let pixels = &image.pixels;
        assert!(pixels.channels().iter().all(|channel| channel.values.len() == pixels.len()));
        return ReadOutcome::Read(format!("{} {}", image.format, "c".repeat(pixels.channels().len().min(9))));
    }
    result.into()
}

/// The bytes with the checksums of all whole chunks corrected, without which no mutant of a chunk is decoded.
fn sealed_png(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    // A chunk is its length, its kind, its data, and the checksum of the last two.
    let mut rest = bytes.get_mut(8..).unwrap_or_default();
    while let Some((length, chunk)) = rest.split_first_chunk_mut::<4>() {
        let covered = usize::try_from(u32::from_be_bytes(*length)).unwrap_or(usize::MAX).saturating_add(4);
        let Some((covered, behind)) = chunk.split_at_mut_checked(covered) else { break };
        let Some((crc, next)) = behind.split_first_chunk_mut::<4>() else { break };
        *crc = crc32fast::hash(covered).to_be_bytes();
        rest = next;
    }
    bytes
}

/// A picture of this size in random colours, some of them bright.
fn pixels(width: u32, height: u32) -> Option<Pixels> {
    let mut random = RandomStream::new(7);
    let mut unit = || (random.bits() >> 40) as f32 / (1_u32 << 24) as f32;
    let rgb: Vec<[f32; 3]> = (0..width * height).map(|_| [unit(), 8.0 * unit(), unit().powi(4)]).collect();
    Pixels::try_from_rgb(width, height, &rgb).ok()
}

fn written(format: Format) -> Vec<u8> {
    let bytes = pixels(19, 11)
        .and_then(|pixels| reader::write(&pixels, format, &Tone::default(), &BTreeMap::new()).ok());
    bytes.unwrap_or_default()
}

/// A file by the crate `image`.
fn foreign(has_alpha: bool, format: ImageFormat) -> Vec<u8> {
    let rgba = RgbaImage::from_fn(17, 9, |x, y| image::Rgba([(x * 9) as u8, (y * 7) as u8, 3, 200]));
    let picture = DynamicImage::from(rgba);
    let picture = if has_alpha { picture } else { picture.to_rgb8().into() };
    let mut bytes = Cursor::new(Vec::new());
    let is_written = picture.write_to(&mut bytes, format).is_ok();
    if is_written { bytes.into_inner() } else { Vec::new() }
}

/// Files of all compressions, in lines and in tiles.
fn exr_seeds() -> Vec<Vec<u8>> {
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
    ];
    let blocks = [Blocks::ScanLines, Blocks::Tiles(::exr::math::Vec2(8, 8))];
    let kinds = compressions.iter().flat_map(|compression| blocks.map(|blocks| (*compression, blocks)));
    kinds
        .filter_map(|(compression, blocks)| exr_file(compression, blocks))
        .chain([written(Format::Exr)])
        .collect()
}

/// A file of one channel of 16 bits; `None` for what the crate cannot write.
fn exr_file(compression: Compression, blocks: Blocks) -> Option<Vec<u8>> {
    use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
    use ::exr::prelude::SmallVec;
    let mut random = RandomStream::new(3);
    let halves: Vec<f16> =
        (0..21 * 13).map(|_| f16::from_f32((random.bits() >> 48) as f32 / 65_536.0)).collect();
    let channels =
        AnyChannels::sort(SmallVec::from_vec(vec![AnyChannel::new("Y", FlatSamples::F16(halves))]));
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let layer = Layer::new((21, 13), LayerAttributes::default(), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).ok()?;
    Some(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changed_chunks_get_their_checksum() {
        let png = written(Format::Png);
        assert_eq!(sealed_png(&png), png);
        // The head begins with the width, and ends with its checksum.
        let mut wrong = png.clone();
        wrong[29..33].fill(0);
        assert_eq!(sealed_png(&wrong), png);
        for length in 0..png.len() {
            assert_eq!(sealed_png(&png[..length]).len(), length);
        }
    }
}
