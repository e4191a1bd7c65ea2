//! Mixtures of materials.

use glanz_scene::description::{FloatParameter, MaterialKind, TextureKind};

use super::Lowering;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::{Parameter, ParameterList};
use crate::source::ParseResult;

impl Lowering {
    /// One of two materials by name. `amount` is the weight of the second, in version 3 that of the first.
    pub(super) fn mix(&mut self, list: &mut ParameterList) -> ParseResult<MaterialKind> {
        let Some((place, [first, second])) = self.mixed_names(list)? else {
            let message = "material \"mix\" does not name two materials";
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let amount = self.float_or(list, "amount", 0.5)?;
        let names = [&first, &second];
        if let Some(passing) =
            names.iter().position(|name| self.dialect == Dialect::V4 && *name == "interface")
        {
            let message = "material \"mix\": a mixture with \"interface\" is not available yet; the other material stands in";
            self.stand_in(&place.value_place, "stand-in-material", message);
            let other = self.use_material(names[1 - passing], &place.value_place);
            return Ok(MaterialKind::mix([other; 2], 0.5));
        }
        let materials = names.map(|name| self.use_material(name, &place.value_place));
        let amount = match (self.dialect, amount) {
            (Dialect::V4, amount) => amount,
            (Dialect::V3, FloatParameter::Value(x)) => FloatParameter::Value(1.0 - x),
            (Dialect::V3, amount) => {
                let kind = TextureKind::Mix { a: 1.0.into(), b: 0.0.into(), amount };
                FloatParameter::Texture(self.add_texture(kind, list))
            }
        };
        Ok(MaterialKind::mix(materials, amount))
    }

    /// The names of the two materials, with a parameter that has one.
    fn mixed_names(&mut self, list: &mut ParameterList) -> ParseResult<Option<(Parameter, [String; 2])>> {
        if let Some((place, names)) = list.texts("materials", &mut self.reporter)? {
            return Ok(<[String; 2]>::try_from(names).ok().map(|names| (place, names)));
        }
        let first = list.text_parameter("namedmaterial1", &mut self.reporter)?;
        let second = list.text_parameter("namedmaterial2", &mut self.reporter)?;
        Ok(first.zip(second).map(|((place, first), (_, second))| (place, [first, second])))
    }
}
