//! Numbers of a scene that an inverse design may change, and what their light is to become.

use glanz_math::{DMat4, DVec3};

use super::geometry::GeometryDescription;
use super::light::LightKind;
use super::{Description, Location};

/// The task of an inverse design.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DesignDescription {
    /// What may change.
    pub variables: Vec<VariableDescription>,
    /// What is wanted.
    pub targets: Vec<TargetDescription>,
}

/// Numbers that change together by one displacement, which is 0 in the description.
#[derive(Clone, Debug, PartialEq)]
pub struct VariableDescription {
    /// What moves.
    pub quantity: VariableQuantity,
    /// Unit vector along which it moves, in the frame of the shape or light; without meaning for a radius.
    pub direction: DVec3,
    /// Smallest and largest displacement, metres; infinite: free.
    pub range: [f64; 2],
    /// The numbers in the scene file; `None` for a description built in code.
    pub numbers: Option<VariableNumbers>,
}

/// What a variable moves. Shapes are those of the world, by their index.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum VariableQuantity {
    /// Control points of a freeform shape.
    ControlPoints {
        /// The shape.
        shape: usize,
        /// Indices of the points in the description, counted over all patches.
        points: Vec<usize>,
    },
    /// A shape as a whole.
    ShapeOffset {
        /// The shape.
        shape: usize,
    },
    /// The position of a point light.
    LightPosition {
        /// Index into [`Description::lights`].
        light: usize,
    },
    /// The radius of a sphere, cylinder, cone, paraboloid or disk.
    Radius {
        /// The shape.
        shape: usize,
    },
}

/// The numbers of a variable in the scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct VariableNumbers {
    /// Place of the first number of their list.
    pub first: Location,
    /// Each position among the numbers of the list, with its weight as a factor (1 where the numbers are not weighted): three numbers along the direction, or the
    /// single one of a radius.
    pub positions: Vec<(usize, f64)>,
}

/// What is wanted of the light on a shape of the world, or of the light that it reflects.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetDescription {
    /// Index of the shape in the world.
    pub shape: usize,
    /// What is wanted.
    pub kind: TargetKind,
    /// Factor on its merit, positive.
    pub weight: f64,
    /// Its place in the input.
    pub location: Option<Location>,
}

/// Kinds of targets.
#[derive(Clone, Debug, PartialEq)]
pub enum TargetKind {
    /// The same illuminance everywhere on the shape.
    Even {
        /// The lit area continues beyond each border by this fraction of the width and height, at least 0.
        margin: f64,
    },
    /// Illuminance in proportion to given values.
    Values {
        /// Numbers of cells along both sides.
        cells: [u32; 2],
        /// One per cell, row by row as in lux maps; not negative, not all 0.
        values: Vec<f64>,
    },
    /// All light in the middle of the shape.
    Peak,
    /// All light on the shape, however it is distributed.
    Flux,
    /// All light that the shape reflects in one direction, of unit length, in the world.
    Collimation {
        /// The direction.
        direction: DVec3,
    },
}

impl Description {
    /// The description with its variables displaced, metres; those without a displacement stay.
    #[must_use]
    pub fn displaced(&self, displacements: &[f64]) -> Self {
        let mut displaced = self.clone();
        for (variable, &t) in self.design.variables.iter().zip(displacements) {
            displaced.displace(variable, t);
        }
        displaced
    }

    fn displace(&mut self, variable: &VariableDescription, t: f64) {
        let offset = t * variable.direction;
        match &variable.quantity {
            VariableQuantity::ControlPoints { shape, points } => {
                let Some(shape) = self.world.shapes.get_mut(*shape) else { return };
                for &point in points {
                    if let Some([x, y, z, w]) = shape.geometry.control_point_mut(point) {
                        *x += *w * offset.x;
                        *y += *w * offset.y;
                        *z += *w * offset.z;
                    }
                }
            }
            VariableQuantity::ShapeOffset { shape } => {
                if let Some(shape) = self.world.shapes.get_mut(*shape) {
                    shape.to_parent *= DMat4::from_translation(offset);
                }
            }
            VariableQuantity::LightPosition { light } => {
                let kind = self.lights.get_mut(*light).map(|light| &mut light.kind);
                if let Some(LightKind::Point { from, .. }) = kind {
                    *from += offset;
                }
            }
            VariableQuantity::Radius { shape } => {
                let shape = self.world.shapes.get_mut(*shape);
                if let Some(shape) = shape {
                    shape.geometry.widen(t);
                }
            }
        }
    }
}

impl GeometryDescription {
    /// A homogeneous control point of a freeform surface, by its index over all patches.
    #[must_use]
    pub fn control_point_mut(&mut self, index: usize) -> Option<&mut [f64; 4]> {
        match self {
            Self::Nurbs(nurbs) => nurbs.points.get_mut(index),
            Self::BezierPatches(patches) => patches.patches.iter_mut().flatten().nth(index),
            Self::BezierTriangles(triangles) => triangles.patches.iter_mut().flatten().nth(index),
            _ => None,
        }
    }

    /// Adds `t`, metres, to the radius of a sphere, cylinder, cone, paraboloid or disk. A whole sphere stays whole.
    fn widen(&mut self, t: f64) {
        match self {
            Self::Sphere { radius, z, .. } => {
                let is_whole = *z == [-*radius, *radius];
                *radius += t;
                if is_whole {
                    *z = [-*radius, *radius];
                }
            }
            Self::Cylinder { radius, .. }
            | Self::Cone { radius, .. }
            | Self::Paraboloid { radius, .. }
            | Self::Disk { radius, .. } => *radius += t,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{BezierPatchesDescription, LightDescription, ShapeDescription};

    fn variable(quantity: VariableQuantity, direction: DVec3) -> VariableDescription {
        VariableDescription { quantity, direction, range: [f64::NEG_INFINITY, f64::INFINITY], numbers: None }
    }

    #[test]
    fn displacements_move_what_their_variables_name_and_nothing_else() {
        let patch =
            vec![[0.0, 0.0, 0.0, 1.0], [0.0, 2.0, 0.0, 2.0], [1.0, 0.0, 0.0, 1.0], [1.0, 1.0, 0.0, 1.0]];
        let patches = BezierPatchesDescription { degree_u: 1, degree_v: 1, patches: vec![patch; 2] };
        let mut description = Description::default();
        description.world.shapes = vec![
            GeometryDescription::BezierPatches(patches).into(),
            ShapeDescription::sphere(0.5).scaled([2.0, 2.0, 2.0]),
        ];
        description.lights = vec![LightDescription::point([1.0, 2.0, 3.0], 1.0)];
        description.design.variables = vec![
            variable(VariableQuantity::ControlPoints { shape: 0, points: vec![1, 7] }, DVec3::Z),
            variable(VariableQuantity::ShapeOffset { shape: 1 }, DVec3::X),
            variable(VariableQuantity::LightPosition { light: 0 }, DVec3::Y),
            variable(VariableQuantity::Radius { shape: 1 }, DVec3::ZERO),
            variable(VariableQuantity::ControlPoints { shape: 9, points: vec![1] }, DVec3::Z),
        ];
        let moved = description.displaced(&[0.25, 0.5, -1.0, 0.125, 7.0]);
        let GeometryDescription::BezierPatches(patches) = &moved.world.shapes[0].geometry else { panic!() };
        // The weight of the first one is 2.
        let z: Vec<f64> = patches.patches.iter().flatten().map(|point| point[2]).collect();
        assert_eq!(z, [0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25]);
        // Along the axis of the shape's own frame, which is scaled.
        assert_eq!(moved.world.shapes[1].to_parent.w_axis.truncate(), DVec3::X);
        let GeometryDescription::Sphere { radius, z, .. } = moved.world.shapes[1].geometry else { panic!() };
        assert_eq!((radius, z), (0.625, [-0.625, 0.625]));
        let LightKind::Point { from, .. } = moved.lights[0].kind else { panic!() };
        assert_eq!(from, DVec3::new(1.0, 1.0, 3.0));
    }
}
