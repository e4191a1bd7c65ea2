//! Colours of the command line.

use std::str::FromStr;

use glanz_light::rgb::srgb_decode;

/// An sRGB colour, as screens show it.
///
/// As text: `#rrggbb`, or one of the names `white`, `silver`, `grey`, `black`, `red`, `green`, `blue`, `yellow`, `orange`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SrgbColor(pub [u8; 3]);

/// The names with their colours, mostly those of CSS.
const NAMES: [(&str, [u8; 3]); 9] = [
    ("white", [255, 255, 255]),
    ("silver", [192, 192, 192]),
    ("grey", [128, 128, 128]),
    ("black", [0, 0, 0]),
    ("red", [200, 30, 30]),
    ("green", [30, 130, 60]),
    ("blue", [30, 80, 180]),
    ("yellow", [240, 200, 30]),
    ("orange", [240, 130, 30]),
];

/// A text that is not a colour.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is not a colour; write #rrggbb, or one of {names}", names = NAMES.map(|(name, _)| name).join(", "))]
pub struct SrgbColorError(String);

impl SrgbColor {
    /// Linear Rec. 709, each in [0, 1].
    #[must_use]
    pub fn to_linear(self) -> [f32; 3] {
        self.0.map(|byte| srgb_decode(f32::from(byte) / 255.0))
    }
}

impl FromStr for SrgbColor {
    type Err = SrgbColorError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let named = NAMES.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text)).map(|(_, rgb)| rgb);
        let of_digits = |digits: &str| {
            let is_hex = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
            let [_, r, g, b] = u32::from_str_radix(digits, 16).ok().filter(|_| is_hex)?.to_be_bytes();
            Some([r, g, b])
        };
        named
            .or_else(|| of_digits(text.strip_prefix('#')?))
            .map(Self)
            .ok_or_else(|| SrgbColorError(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_hexadecimal_digits_are_colours() {
        for (text, rgb) in [("#ff8001", [255, 128, 1]), ("White", [255; 3]), ("black", [0; 3])] {
            assert_eq!(text.parse(), Ok(SrgbColor(rgb)), "{text}");
        }
        for text in ["", "#", "#fff", "ff8001", "#ff80011", "#+f8001", "pink-ish"] {
            assert!(text.parse::<SrgbColor>().is_err(), "{text}");
        }
        assert_eq!(SrgbColor([255, 0, 255]).to_linear(), [1.0, 0.0, 1.0]);
        // IEC 61966-2-1: ((188 / 255 + 0.055) / 1.055)^2.4.
        let grey = SrgbColor([188; 3]).to_linear()[0];
        assert!((grey - 0.502_9).abs() < 1e-4, "{grey}");
    }
}
