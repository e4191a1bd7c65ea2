//! Pictures for textures of models.

use glanz_job::{MemoryReservation, ResourceBudget};
use glanz_light::Pixels;
use glanz_math::DVec2;

use crate::image::{self, Encoding};

/// What a texture takes from a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum PictureContent {
    /// Colours for a display, decoded to linear light.
    Color,
    /// One of the channels red, green, blue and alpha, by its number, as data.
    Channel(u8),
    /// Alpha as data, or brightness where there is none.
    Opacity,
    /// Normals as colours, with a factor on red and green as components from -1 to 1.
    Normals {
        /// The bits of the factor, an `f32`.
        scale: u32,
    },
}

/// Coordinates of textures beyond a picture by less than this count as at its border.
const BORDER: f64 = 1e-3;

/// The content of a picture as planes for a texture, with their memory, or the problem.
///
/// Grey pictures have the same red, green and blue; the alpha of pictures without it is 1.
pub(super) fn read_picture(
    bytes: &[u8],
    content: PictureContent,
    budget: &ResourceBudget,
) -> Result<(Pixels, [MemoryReservation; 2]), String> {
    let encoding = if content == PictureContent::Color { Encoding::Srgb } else { Encoding::Linear };
    let (picture, memory) =
        image::read_reserved(bytes, None, encoding, budget).map_err(|error| error.to_string())?;
    let pixels = picture.pixels;
    let grey = pixels.channel("Y").is_some();
    let plane = (pixels.len() * size_of::<f32>()) as u64;
    let reserve = |planes: u64| budget.reserve(planes * plane).map_err(|end| end.to_string());
    let (content, copy) = match content {
        PictureContent::Color => (pixels, reserve(0)?),
        PictureContent::Normals { scale } => {
            // Three planes, and as many values in between.
            let copies = reserve(9)?;
            (normals(&pixels, f32::from_bits(scale))?, copies)
        }
        PictureContent::Channel(number) => {
            let copy = reserve(1)?;
            (split(&pixels, channel(number, grey))?, copy)
        }
        PictureContent::Opacity => {
            let (copy, has_alpha) = (reserve(1)?, pixels.channel("A").is_some());
            (split(&pixels, if has_alpha { "A" } else { channel(1, grey) })?, copy)
        }
    };
    Ok((content, [memory, copy]))
}

/// The name of one of the channels red, green, blue and alpha, by its number.
fn channel(number: u8, grey: bool) -> &'static str {
    match number {
        3 => "A",
        _ if grey => "Y",
        0 => "R",
        1 => "G",
        _ => "B",
    }
}

/// One channel alone; 1 everywhere if there is none.
fn split(pixels: &Pixels, channel: &str) -> Result<Pixels, String> {
    let values = pixels.channel(channel).map_or_else(|| vec![1.0; pixels.len()], <[f32]>::to_vec);
    let split = Pixels::try_new(pixels.width(), pixels.height());
    let mut split = split.map_err(|error| error.to_string())?;
    split.add_channel("Y", values).map_err(|error| error.to_string())?;
    Ok(split)
}

/// Normals with a factor on the first two components.
fn normals(pixels: &Pixels, scale: f32) -> Result<Pixels, String> {
    let scaled = |c: f32| 0.5 + scale * (c - 0.5);
    let mut colors = pixels.to_rgb().ok_or_else(|| "the picture has neither R, G, B nor Y".to_owned())?;
    colors.iter_mut().for_each(|rgb| *rgb = [scaled(rgb[0]), scaled(rgb[1]), rgb[2]]);
    Pixels::try_from_rgb(pixels.width(), pixels.height(), &colors).map_err(|error| error.to_string())
}

/// The whole numbers by which coordinates lie beyond the picture, if all lie in the same repetition of it.
pub(crate) fn repetition(uvs: &[DVec2]) -> Option<DVec2> {
    let min = uvs.iter().copied().reduce(DVec2::min)?;
    let max = uvs.iter().copied().reduce(DVec2::max)?;
    let whole = (min + BORDER).floor();
    (max - whole).cmple(DVec2::splat(1.0 + BORDER)).all().then_some(whole)
}
