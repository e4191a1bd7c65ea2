//! Pictures for textures of models.

use glanz_light::Pixels;

use crate::image::{self, Encoding};

/// What a texture takes from a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum PictureContent {
    /// Colours for a display, decoded to linear light.
    Color,
    /// One of the channels red, green, blue and alpha, by its number, as data.
    Channel(u8),
}

/// The content of a picture as planes for a texture, or the problem.
///
/// Grey pictures have the same red, green and blue; the alpha of pictures without it is 1.
pub(crate) fn read_picture(bytes: &[u8], content: PictureContent) -> Result<Pixels, String> {
    let encoding = match content {
        PictureContent::Color => Encoding::Srgb,
        PictureContent::Channel(_) => Encoding::Linear,
    };
    let pixels = image::read(bytes, None, encoding).map_err(|error| error.to_string())?.pixels;
    let grey = pixels.channel("Y").is_some();
    let channel = match content {
        PictureContent::Color if grey || pixels.channel("R").is_some() => return Ok(pixels),
        PictureContent::Color => return Err("the picture has neither R, G, B nor Y".to_owned()),
        PictureContent::Channel(3) => "A",
        PictureContent::Channel(_) if grey => "Y",
        PictureContent::Channel(0) => "R",
        PictureContent::Channel(1) => "G",
        PictureContent::Channel(_) => "B",
    };
    let values = pixels.channel(channel).map_or_else(|| vec![1.0; pixels.len()], <[f32]>::to_vec);
    let split = Pixels::try_new(pixels.width(), pixels.height());
    let mut split = split.map_err(|error| error.to_string())?;
    split.add_channel("Y", values).map_err(|error| error.to_string())?;
    Ok(split)
}

/// Mean of a picture's red, green and blue.
pub(crate) fn mean(pixels: &Pixels) -> [f32; 3] {
    let mean = |name: &str| {
        let values = pixels.channel(name).or_else(|| pixels.channel("Y")).unwrap_or_default();
        let sum: f64 = values.iter().map(|&x| f64::from(x)).sum();
        if values.is_empty() { 0.0 } else { (sum / values.len() as f64) as f32 }
    };
    ["R", "G", "B"].map(mean)
}
