//! Pictures written, read and damaged.

mod damage;
mod exr;
mod others;

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
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
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
