//! The parts of a scene that each variable moves.

use glanz_math::DVec3;
use glanz_scene::description::{VariableDescription, VariableQuantity};
use glanz_scene::{Description, Light, PlacedSurface, Scene};

use super::ray_sources::world_shape;
use super::surface_basis::PointFactors;

/// How a variable moves a point of a mirror.
#[derive(Clone, Copy, Debug)]
pub(super) struct SensitivityTerm {
    pub(super) variable: usize,
    pub(super) position: f64,
    pub(super) tangents: [f64; 2],
}

/// The variables of one mirror.
pub(super) struct MirrorVariables {
    /// For each control point its variables.
    points: Vec<Vec<usize>>,
    /// Those of the mirror as a whole.
    pub(super) offsets: Vec<usize>,
}

impl MirrorVariables {
    pub(super) fn of(description: &Description, mirror: usize) -> Self {
        let mut variables = Self { points: Vec::new(), offsets: Vec::new() };
        for (number, variable) in description.design.variables.iter().enumerate() {
            match &variable.quantity {
                VariableQuantity::ControlPoints { shape, points } if *shape == mirror => {
                    for &point in points {
                        if point >= variables.points.len() {
                            variables.points.resize(point + 1, Vec::new());
                        }
                        variables.points[point].push(number);
                    }
                }
                VariableQuantity::ShapeOffset { shape } if *shape == mirror => variables.offsets.push(number),
                _ => {}
            }
        }
        variables
    }

    /// Adds what the variables of the control points do, one term for each.
    pub(super) fn add_terms(
        &self,
        factors: impl Iterator<Item = PointFactors>,
        terms: &mut Vec<SensitivityTerm>,
    ) {
        let first = terms.len();
        for factor in factors {
            for &variable in self.points.get(factor.point).map(Vec::as_slice).unwrap_or_default() {
                let own = terms.get_mut(first..).unwrap_or_default();
                match own.iter_mut().find(|term| term.variable == variable) {
                    Some(term) => {
                        term.position += factor.position;
                        term.tangents[0] += factor.tangents[0];
                        term.tangents[1] += factor.tangents[1];
                    }
                    None => terms.push(SensitivityTerm {
                        variable,
                        position: factor.position,
                        tangents: factor.tangents,
                    }),
                }
            }
        }
    }
}

/// Direction of each variable in the world.
pub(super) fn directions(description: &Description) -> Vec<DVec3> {
    let direction = |variable: &VariableDescription| {
        let frame = match variable.quantity {
            VariableQuantity::ControlPoints { shape, .. }
            | VariableQuantity::ShapeOffset { shape }
            | VariableQuantity::Radius { shape } => {
                description.world.shapes.get(shape).map(|shape| shape.to_parent)
            }
            VariableQuantity::LightPosition { light } => {
                description.lights.get(light).map(|light| light.to_world)
            }
        };
        frame.unwrap_or_default().transform_vector3(variable.direction)
    };
    description.design.variables.iter().map(direction).collect()
}

/// For each light of the scene the variables that move it.
pub(super) fn light_variables(
    description: &Description,
    scene: &Scene,
    placed: &[PlacedSurface<'_>],
) -> Vec<Vec<usize>> {
    let mut variables = vec![Vec::new(); scene.lights().len()];
    // Lights that are no shapes come after those that are.
    let areas = scene.lights().iter().filter(|light| matches!(light, Light::Area(_))).count();
    for (number, variable) in description.design.variables.iter().enumerate() {
        let mut lights: Vec<usize> = match variable.quantity {
            VariableQuantity::LightPosition { light } => vec![areas + light],
            VariableQuantity::ShapeOffset { shape } => {
                // A shape of several patches is several surfaces, each with a light.
                let own = |surface: &&PlacedSurface<'_>| world_shape(description, surface, 0) == Some(shape);
                let lights = placed.iter().filter(own).filter_map(PlacedSurface::light);
                lights.map(|id| id.0 as usize).collect()
            }
            VariableQuantity::ControlPoints { .. } | VariableQuantity::Radius { .. } => Vec::new(),
        };
        lights.dedup();
        for light in lights {
            if let Some(list) = variables.get_mut(light) {
                list.push(number);
            }
        }
    }
    variables
}
