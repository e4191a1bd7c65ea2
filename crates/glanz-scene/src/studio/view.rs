//! Views of a model, and the camera that is fitted to it.

use std::f64::consts::TAU;
use std::str::FromStr;

use glanz_math::glam::{DQuat, DVec4};
use glanz_math::{Bounds3, DMat4, DVec3};

use crate::camera::Screen;
use crate::description::{CameraDescription, CameraKind, Description};

/// Direction from which a model is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StudioView {
    /// From the front, with +x to the right.
    Front,
    /// From the back.
    Back,
    /// From the left, which is -x.
    Left,
    /// From the right, which is +x.
    Right,
    /// From above, with the front at the bottom of the picture.
    Top,
    /// From below, with the front at the top of the picture.
    Bottom,
    /// Three-quarter view, from the front, the right and above.
    #[default]
    Iso,
}

impl StudioView {
    /// All views.
    pub const ALL: [Self; 7] =
        [Self::Front, Self::Back, Self::Left, Self::Right, Self::Top, Self::Bottom, Self::Iso];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Back => "back",
            Self::Left => "left",
            Self::Right => "right",
            Self::Top => "top",
            Self::Bottom => "bottom",
            Self::Iso => "iso",
        }
    }
}

/// A picture of a full turn around the upward axis.
///
/// The viewer goes to the right with the light, so that the model seems to turn to the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TurntableFrame {
    /// Number of the picture, from 0.
    pub number: u32,
    /// Number of all pictures of the turn, at least 1.
    pub count: u32,
}

/// Upward axis of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum UpAxis {
    /// +y; the front faces +z.
    Y,
    /// +z; the front faces -y.
    #[default]
    Z,
}

impl UpAxis {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    /// The unit vector upwards.
    pub(super) fn direction(self) -> DVec3 {
        match self {
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }

    /// The unit vector that the front faces.
    fn front(self) -> DVec3 {
        match self {
            Self::Y => DVec3::Z,
            Self::Z => DVec3::NEG_Y,
        }
    }
}

/// A text that is neither `y` nor `z`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the upward axis is y or z")]
pub struct UpAxisError;

impl FromStr for UpAxis {
    type Err = UpAxisError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        [Self::Y, Self::Z].into_iter().find(|axis| axis.name().eq_ignore_ascii_case(text)).ok_or(UpAxisError)
    }
}

/// Orientation of a view in the world, which is right-handed.
#[derive(Clone, Copy, Debug)]
pub(super) struct ViewFrame {
    /// To the right in the picture.
    pub(super) right: DVec3,
    /// Upwards in the picture.
    pub(super) up: DVec3,
    /// Into the picture.
    pub(super) forward: DVec3,
    /// Horizontal unit vector towards the viewer; towards the front if the view is vertical.
    pub(super) viewer: DVec3,
}

impl ViewFrame {
    pub(super) fn new(view: StudioView, up: UpAxis) -> Self {
        let (front, above, right) = (up.front(), up.direction(), DVec3::X);
        // Towards the viewer, and upwards in the picture before it is made perpendicular.
        let (back, upwards, viewer) = match view {
            StudioView::Front => (front, above, front),
            StudioView::Back => (-front, above, -front),
            StudioView::Left => (-right, above, -right),
            StudioView::Right => (right, above, right),
            StudioView::Top => (above, -front, front),
            StudioView::Bottom => (-above, front, front),
            StudioView::Iso => {
                // Turned by 37 degrees to the right of the front, and 31 degrees above the horizon.
                let viewer = 0.8 * front + 0.6 * right;
                ((viewer + 0.6 * above).normalize(), above, viewer)
            }
        };
        let forward = -back;
        let up = upwards.reject_from_normalized(forward).normalize();
        Self { right: forward.cross(up), up, forward, viewer }
    }

    /// The view of a camera with this frame; `None` if it has no direction.
    pub(super) fn of_camera(to_world: &DMat4, above: DVec3) -> Option<Self> {
        let axis = |column: DVec4| column.truncate().try_normalize();
        let (right, up, forward) = (axis(to_world.x_axis)?, axis(to_world.y_axis)?, axis(to_world.z_axis)?);
        // A vertical camera has its viewer at the lower side of its picture.
        let horizontal = |direction: DVec3| {
            let level = direction.reject_from_normalized(above);
            (level.length() > VERTICAL).then(|| level.normalize())
        };
        let viewer = horizontal(-forward).or_else(|| horizontal(-up))?;
        Some(Self { right, up, forward, viewer })
    }

    /// The same view from another side, turned about the unit vector `above`.
    pub(super) fn turned(self, turntable: Option<TurntableFrame>, above: DVec3) -> Self {
        let Some(TurntableFrame { number, count }) = turntable else { return self };
        let angle = TAU * f64::from(number) / f64::from(count.max(1));
        let rotation = DQuat::from_axis_angle(above, angle);
        let Self { right, up, forward, viewer } = self;
        let [right, up, forward, viewer] = [right, up, forward, viewer].map(|axis| rotation * axis);
        Self { right, up, forward, viewer }
    }
}

/// Sine of the angle to the vertical below which a direction counts as vertical.
const VERTICAL: f64 = 1e-3;

/// Half the shorter side of the picture at distance 1: a field of view of 28 degrees.
const HALF_SIDE: f64 = 0.25;

/// Share of the half picture that stays free on each side.
const MARGIN: f64 = 0.05;

/// Smallest distance of camera and model, in diagonals of the model: very wide pictures would need a camera within it.
const NEAREST: f64 = 0.5;

/// A camera with this orientation from which all of the model is in the picture, as large as the margin allows, or the
/// default one for an empty model.
///
/// `bounds`: of the model; `aspect`: width over height of the picture; `turned_about`: a unit vector about which the model may be turned by any angle and
/// is still in the picture.
pub(super) fn fitted_camera(
    description: &Description,
    bounds: Bounds3,
    frame: &ViewFrame,
    aspect: f64,
    turned_about: Option<DVec3>,
) -> CameraDescription {
    if bounds.is_empty() {
        return CameraDescription::default();
    }
    let window = Screen::default_window(aspect).map(|side| side * HALF_SIDE * (1.0 - MARGIN));
    let [_, half_width, _, half_height] = window;
    let middle = bounds.center();
    let extent = |direction| Extent::new(direction, turned_about);
    let mut nearest = extent(-frame.forward);
    let mut across = TangentPlanes::new(frame.right, frame.forward, half_width, extent);
    let mut along = TangentPlanes::new(frame.up, frame.forward, half_height, extent);
    description.visit_extent(&mut |point| {
        let from_middle = point - middle;
        nearest.include(from_middle);
        across.sides.iter_mut().chain(&mut along.sides).for_each(|side| side.include(from_middle));
    });
    // The unit of a model that is a single point is unknown.
    let size = bounds.diagonal().length();
    let size = if size > 0.0 { size } else { 1.0 };
    let depth = across.depth().min(along.depth()).min(-nearest.largest - NEAREST * size);
    let eye = middle + across.middle() * frame.right + along.middle() * frame.up + depth * frame.forward;
    let column = |axis: DVec3| axis.extend(0.0);
    let to_world =
        DMat4::from_cols(column(frame.right), column(frame.up), column(frame.forward), eye.extend(1.0));
    let field_of_view = 2.0 * HALF_SIDE.atan();
    CameraDescription {
        kind: CameraKind::Perspective { field_of_view },
        to_world,
        ..CameraDescription::default()
    }
}

/// Largest coordinate of points along a direction, also of all points that a turn about an axis makes of them.
struct Extent {
    direction: DVec3,
    /// The axis, and the length of the direction across it.
    turn: Option<(DVec3, f64)>,
    largest: f64,
}

impl Extent {
    fn new(direction: DVec3, turned_about: Option<DVec3>) -> Self {
        let turn = turned_about.map(|axis| (axis, direction.reject_from_normalized(axis).length()));
        Self { direction, turn, largest: f64::NEG_INFINITY }
    }

    fn include(&mut self, point: DVec3) {
        let coordinate = match self.turn {
            None => self.direction.dot(point),
            Some((axis, across)) => {
                let height = axis.dot(point);
                height * axis.dot(self.direction) + across * (point - height * axis).length()
            }
        };
        self.largest = self.largest.max(coordinate);
    }
}

/// The two planes through the eye that bound the picture on opposite sides, as close to the model as possible.
///
/// An eye at (x, z) sees a point at (px, pz) if |px - x| <= tangent (pz - z). So x - tangent z is at least the largest px - tangent pz, and
/// -x - tangent z at least the largest -px - tangent pz.
struct TangentPlanes {
    tangent: f64,
    sides: [Extent; 2],
}

impl TangentPlanes {
    fn new(axis: DVec3, forward: DVec3, tangent: f64, extent: impl Fn(DVec3) -> Extent) -> Self {
        Self { tangent, sides: [axis, -axis].map(|axis| extent(axis - tangent * forward)) }
    }

    /// Largest depth of an eye that sees all points.
    fn depth(&self) -> f64 {
        let [a, b] = &self.sides;
        -0.5 * (a.largest + b.largest) / self.tangent
    }

    /// Position of the eye with the same free space on both sides.
    fn middle(&self) -> f64 {
        let [a, b] = &self.sides;
        0.5 * (a.largest - b.largest)
    }
}
