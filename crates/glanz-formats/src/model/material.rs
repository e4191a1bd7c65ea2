//! Textures that readers of models make.

use glanz_scene::description::{FloatParameter, SpectrumParameter, TextureDescription, TextureKind};

use super::ModelReader;

/// Slope of the ramp that stands for a step of opacity: pictures of 8 bits have steps of 1/255.
const STEEP: f32 = 1e4;

impl ModelReader {
    /// A product of two inputs.
    pub(crate) fn scaled(&mut self, a: SpectrumParameter, b: SpectrumParameter) -> SpectrumParameter {
        SpectrumParameter::Texture(self.add_texture(String::new(), TextureKind::Scale(a, b)))
    }

    /// A number times a factor.
    pub(crate) fn scaled_number(&mut self, number: FloatParameter, factor: f32) -> FloatParameter {
        match number {
            number if factor == 1.0 => number,
            FloatParameter::Value(number) => (number * factor).into(),
            FloatParameter::Texture(_) => {
                let kind = TextureKind::Scale(grey(number), factor.into());
                FloatParameter::Texture(self.add_texture(String::new(), kind))
            }
        }
    }

    /// 1 where a number, as interpolated between pixels, is at least `cutoff`, else at most 0: an opacity, which is clamped.
    pub(crate) fn cut_off(&mut self, number: FloatParameter, cutoff: f32) -> FloatParameter {
        if let FloatParameter::Value(number) = number {
            return f32::from(number >= cutoff).into();
        }
        // 1 + (number - cutoff) STEEP, as a mixture.
        let at = |number: f32| SpectrumParameter::from(1.0 + (number - cutoff) * STEEP);
        let kind = TextureKind::Mix { a: at(0.0), b: at(1.0), amount: number };
        FloatParameter::Texture(self.add_texture(String::new(), kind))
    }

    /// Adds a texture and returns its index.
    pub(crate) fn add_texture(&mut self, name: String, kind: TextureKind) -> usize {
        self.spend_entry::<TextureDescription>(&name);
        let textures = &mut self.description.textures;
        textures.push(TextureDescription { name, kind, location: None });
        textures.len() - 1
    }
}

/// A number as a grey spectrum.
pub(crate) fn grey(number: FloatParameter) -> SpectrumParameter {
    match number {
        FloatParameter::Value(number) => number.into(),
        FloatParameter::Texture(index) => SpectrumParameter::Texture(index),
    }
}
