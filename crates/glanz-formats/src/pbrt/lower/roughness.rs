//! Roughness of materials.

use glanz_scene::description::{DescriptionForm, FloatParameter};
use glanz_shading::model::{Roughness, RoughnessScale};

use super::Lowering;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::ParameterList;
use crate::source::ParseResult;

/// Names of the parameters for the roughness of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughnessNames {
    both: &'static str,
    u: &'static str,
    v: &'static str,
}

impl RoughnessNames {
    /// Of a material with one rough surface.
    pub(super) const PLAIN: Self = Self { both: "roughness", u: "uroughness", v: "vroughness" };
    /// Of the metal under a coat.
    pub(super) const CONDUCTOR: Self =
        Self { both: "conductor.roughness", u: "conductor.uroughness", v: "conductor.vroughness" };
    /// Of the coat over metal.
    pub(super) const INTERFACE: Self =
        Self { both: "interface.roughness", u: "interface.uroughness", v: "interface.vroughness" };
    /// Of the coat of a principled material.
    pub(super) const COAT: Self = Self { both: "coat.roughness", u: "coat.uroughness", v: "coat.vroughness" };
}

impl Lowering {
    /// The roughness of a surface: `default` along a direction for which the list has none.
    pub(super) fn roughness(
        &mut self,
        list: &mut ParameterList,
        names: RoughnessNames,
        default: f32,
    ) -> ParseResult<Roughness<DescriptionForm>> {
        let scale = self.roughness_scale(list)?;
        self.scaled_roughness(list, names, default, scale)
    }

    /// The meaning of the numbers for roughness in pbrt's materials.
    pub(super) fn roughness_scale(&mut self, list: &mut ParameterList) -> ParseResult<RoughnessScale> {
        let remap = list.boolean("remaproughness", &mut self.reporter)?.unwrap_or(true);
        Ok(match self.dialect {
            _ if !remap => RoughnessScale::Alpha,
            Dialect::V3 => RoughnessScale::Logarithmic,
            Dialect::V4 => RoughnessScale::SquareRoot,
        })
    }

    /// The roughness of version 3's materials other than glass, which are never smooth: 0 counts as 0.001 there.
    pub(super) fn facet_roughness(
        &mut self,
        list: &mut ParameterList,
        default: f32,
    ) -> ParseResult<Roughness<DescriptionForm>> {
        let scale = self.roughness_scale(list)?;
        self.facets(list, RoughnessNames::PLAIN, default, scale)
    }

    /// The roughness of a surface, whose numbers have the meaning of `scale`; it is smooth if both are 0.
    pub(super) fn scaled_roughness(
        &mut self,
        list: &mut ParameterList,
        names: RoughnessNames,
        default: f32,
        scale: RoughnessScale,
    ) -> ParseResult<Roughness<DescriptionForm>> {
        let facets = self.facets(list, names, default, scale)?;
        // The logarithm has no value at 0, which version 3 takes for smooth glass.
        let is_smooth = [facets.u, facets.v] == [FloatParameter::Value(0.0); 2];
        Ok(if is_smooth { Roughness::smooth() } else { facets })
    }

    fn facets(
        &mut self,
        list: &mut ParameterList,
        names: RoughnessNames,
        default: f32,
        scale: RoughnessScale,
    ) -> ParseResult<Roughness<DescriptionForm>> {
        let both = self.float_or(list, names.both, default)?;
        let u = self.optional_float(list, names.u)?.unwrap_or(both);
        let v = self.optional_float(list, names.v)?.unwrap_or(both);
        Ok(Roughness { u, v, scale })
    }

    /// Whether light between facets counts, an extension.
    pub(super) fn multiple_scattering(&mut self, list: &mut ParameterList) -> ParseResult<bool> {
        Ok(list.boolean("multiplescattering", &mut self.reporter)?.unwrap_or(true))
    }
}
