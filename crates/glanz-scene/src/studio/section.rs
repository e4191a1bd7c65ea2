//! Sections through models.

use std::str::FromStr;

use glanz_math::{Bounds3, DMat4, DVec3};

use super::color::SrgbColor;
use super::view::ViewFrame;
use crate::description::{
    Description, GroupDescription, InstanceDescription, MaterialKind, SectionDescription,
};

/// A plane that cuts a model open.
///
/// As text: `x=0.01`, `y=-2`, `z=50%`, or four numbers `nx,ny,nz,d`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SectionPlane {
    /// Across an axis (0, 1, 2 for x, y, z), without the part that faces the viewer.
    Axis {
        /// The axis.
        axis: usize,
        /// Coordinate of the plane, metres.
        at: f64,
    },
    /// The same at a share of the model's size along the axis.
    Share {
        /// The axis.
        axis: usize,
        /// 0 for the smallest, 1 for the largest coordinate.
        share: f64,
    },
    /// Any plane, without the points with `normal . p > offset`.
    General {
        /// Normal, of any length but 0.
        normal: DVec3,
        /// Metres times the length of the normal.
        offset: f64,
    },
}

/// A text that is not a plane.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is not a plane; write x=0.01 (metres), z=50% or nx,ny,nz,d")]
pub struct SectionPlaneError(String);

impl FromStr for SectionPlane {
    type Err = SectionPlaneError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let of_axis = || {
            let (axis, at) = text.split_once('=')?;
            let axis = ["x", "y", "z"].into_iter().position(|name| name == axis.trim())?;
            Some(match at.strip_suffix('%') {
                Some(share) => Self::Share { axis, share: number(share)? / 100.0 },
                None => Self::Axis { axis, at: number(at)? },
            })
        };
        let general = || {
            let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
            let [x, y, z, offset] = numbers?.try_into().ok()?;
            let normal = DVec3::new(x, y, z);
            normal.try_normalize().map(|_| Self::General { normal, offset })
        };
        of_axis().or_else(general).ok_or_else(|| SectionPlaneError(text.to_owned()))
    }
}

/// Colour of the faces.
const FACE: SrgbColor = SrgbColor([214, 84, 58]);

/// Moves the model into a group of its own and cuts that open. `bounds`: of the model; `view`: decides which part is left out.
pub(super) fn cut(description: &mut Description, plane: SectionPlane, bounds: Bounds3, view: &ViewFrame) {
    let across = |axis: usize, at: f64| {
        let normal = DVec3::AXES.get(axis).copied().unwrap_or(DVec3::X);
        let side = if normal.dot(view.forward) > 0.0 { -1.0 } else { 1.0 };
        (side * normal, side * at)
    };
    let (normal, offset) = match plane {
        SectionPlane::Axis { axis, at } => across(axis, at),
        SectionPlane::Share { axis, share } => {
            let end = |corner: DVec3| corner.to_array().get(axis).copied().unwrap_or_default();
            let (low, high) = (end(bounds.min), end(bounds.max));
            across(axis, low + share * (high - low))
        }
        SectionPlane::General { normal, offset } => (normal, offset),
    };
    let world = std::mem::take(&mut description.world);
    let group = description.groups.len();
    description.groups.push(world);
    let instance =
        InstanceDescription { name: String::new(), group, to_parent: DMat4::IDENTITY, location: None };
    description.world = GroupDescription { instances: vec![instance], ..GroupDescription::default() };
    let material = description.materials.len();
    description.materials.push(MaterialKind::diffuse(FACE.to_linear()).into());
    description.section = Some(SectionDescription { group, normal, offset, material });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_read() {
        let plane = |text: &str| text.parse::<SectionPlane>().unwrap();
        assert_eq!(plane("x=0.01"), SectionPlane::Axis { axis: 0, at: 0.01 });
        assert_eq!(plane("y=-2"), SectionPlane::Axis { axis: 1, at: -2.0 });
        assert_eq!(plane("z=50%"), SectionPlane::Share { axis: 2, share: 0.5 });
        let general = SectionPlane::General { normal: DVec3::new(1.0, -1.0, 0.0), offset: 0.5 };
        assert_eq!(plane("1,-1,0, 0.5"), general);
        for text in ["", "x", "x=", "w=1", "x=inf", "1,2,3", "0,0,0,1", "1,2,3,4,5", "x=1%%"] {
            assert!(text.parse::<SectionPlane>().is_err(), "{text}");
        }
    }
}
