//! `Texture` of the types that are computed.

use glanz_math::DVec3;
use glanz_scene::description::{
    FractalKind, MAX_OCTAVES, MappingDescription, SpectrumParameter, TextureKind,
};

use super::spectrum::grey;
use super::{EntityState, Lowering};
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::ParseResult;

impl Lowering {
    /// A texture that is computed, or the substitute for an unknown one.
    pub(super) fn procedural_texture(
        &mut self,
        kind: &str,
        list: &mut ParameterList,
        context: &EntityState,
    ) -> ParseResult<TextureKind> {
        let space = context.color_space;
        Ok(match kind {
            "uv" => TextureKind::Uv(self.mapping(list, context)?),
            "bilerp" => TextureKind::Bilerp {
                corners: [
                    self.spectrum_or(list, "v00", 0.0, space)?,
                    self.spectrum_or(list, "v01", 1.0, space)?,
                    self.spectrum_or(list, "v10", 0.0, space)?,
                    self.spectrum_or(list, "v11", 1.0, space)?,
                ],
                mapping: self.mapping(list, context)?,
            },
            "dots" => TextureKind::Dots {
                inside: self.spectrum_or(list, "inside", 1.0, space)?,
                outside: self.spectrum_or(list, "outside", 0.0, space)?,
                mapping: self.mapping(list, context)?,
            },
            "directionmix" => {
                let direction = list.vec3("dir", &mut self.reporter)?.unwrap_or(DVec3::Y);
                TextureKind::DirectionMix {
                    along: self.spectrum_or(list, "tex1", 0.0, space)?,
                    across: self.spectrum_or(list, "tex2", 1.0, space)?,
                    direction: context.ctm.transform_vector3(direction),
                }
            }
            "fbm" => {
                let (octaves, roughness) = self.octaves(list)?;
                let mapping = self.solid_mapping(list, context)?;
                TextureKind::Fractal { kind: FractalKind::Fbm { octaves, roughness }, mapping }
            }
            "wrinkled" => {
                let (octaves, roughness) = self.octaves(list)?;
                let mapping = self.solid_mapping(list, context)?;
                TextureKind::Fractal { kind: FractalKind::Wrinkled { octaves, roughness }, mapping }
            }
            "windy" => {
                TextureKind::Fractal { kind: FractalKind::Windy, mapping: self.solid_mapping(list, context)? }
            }
            "marble" => {
                let (octaves, roughness) = self.octaves(list)?;
                TextureKind::Marble {
                    octaves,
                    roughness,
                    scale: list.float_or("scale", 1.0, &mut self.reporter)?,
                    variation: list.float_or("variation", 0.2, &mut self.reporter)?,
                    mapping: self.solid_mapping(list, context)?,
                }
            }
            other => self.unknown_texture(other, list),
        })
    }

    /// Octaves of noise and the factor between their amplitudes.
    fn octaves(&mut self, list: &mut ParameterList) -> ParseResult<(u32, f64)> {
        let place = list.value_place("octaves");
        let octaves = list.integer_from("octaves", 0, &mut self.reporter)?.unwrap_or(8);
        if octaves > MAX_OCTAVES {
            let message =
                format!("{}: \"octaves\" is {octaves}; it must be at most {MAX_OCTAVES}", list.subject);
            return Err(self.reporter.error(&place, "parameter-range", message));
        }
        Ok((octaves, list.float_or("roughness", 0.5, &mut self.reporter)?))
    }

    fn solid_mapping(
        &mut self,
        list: &ParameterList,
        context: &EntityState,
    ) -> ParseResult<MappingDescription> {
        Ok(MappingDescription::Solid { to_texture: self.texture_space(list, context)? })
    }

    /// A constant in place of a texture of another type.
    fn unknown_texture(&mut self, kind: &str, list: &mut ParameterList) -> TextureKind {
        list.ignore(&["filename", "encoding", "gamma", "scale"]);
        let what = if kind == "ptex" { "is not available yet" } else { "is unknown" };
        let message = format!("texture {:?} {what}; a constant 0.5 stands in", shortened(kind));
        self.stand_in(&list.place, "stand-in-texture", message);
        TextureKind::Constant(SpectrumParameter::Value(grey(0.5)))
    }
}
