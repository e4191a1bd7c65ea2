//! Camera of a model.

use serde_json::{Value, json};

/// A camera, which looks along -z of its own axes with +x to the right of its picture and +y up.
#[derive(Clone, Debug, PartialEq)]
pub struct GlbCamera {
    /// Its name.
    pub name: String,
    /// The projection.
    pub projection: Projection,
    /// Range of visible distances, metres: nearest and farthest; the nearest is positive in a central projection.
    pub range: [f32; 2],
    /// Position, metres.
    pub position: [f32; 3],
    /// Rotation: a unit quaternion, real part last.
    pub rotation: [f32; 4],
}

/// The projections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Central projection.
    Perspective {
        /// Full angle from the lower to the upper side of the picture, radians, in (0, pi).
        field_of_view: f32,
        /// Width over height.
        aspect: f32,
    },
    /// Parallel projection: half of width and height, metres.
    Orthographic([f32; 2]),
}

impl GlbCamera {
    /// The camera and its node as JSON of the format; `number`: index of the camera in the list.
    pub(super) fn values(&self, number: usize) -> (Value, Value) {
        let [near, far] = self.range;
        let camera = match self.projection {
            Projection::Perspective { field_of_view, aspect } => json!({
                "name": self.name,
                "type": "perspective",
                "perspective": { "yfov": field_of_view, "aspectRatio": aspect, "znear": near, "zfar": far },
            }),
            Projection::Orthographic([x, y]) => json!({
                "name": self.name,
                "type": "orthographic",
                "orthographic": { "xmag": x, "ymag": y, "znear": near, "zfar": far },
            }),
        };
        let node = json!({
            "name": self.name, "camera": number, "translation": self.position, "rotation": self.rotation
        });
        (camera, node)
    }

    /// Whether the format can represent it.
    pub(super) fn is_valid(&self) -> bool {
        let [near, far] = self.range;
        let positive = |x: f32| x > 0.0 && x.is_finite();
        let projects = match self.projection {
            Projection::Perspective { field_of_view, aspect } => {
                positive(field_of_view)
                    && field_of_view < std::f32::consts::PI
                    && positive(aspect)
                    && positive(near)
            }
            Projection::Orthographic([x, y]) => positive(x) && positive(y) && near >= 0.0,
        };
        let length: f32 = self.rotation.iter().map(|x| x * x).sum();
        projects
            && far > near
            && far.is_finite()
            && self.position.iter().all(|x| x.is_finite())
            // A few rounding errors of numbers of about 1.
            && (length - 1.0).abs() < 16.0 * f32::EPSILON
    }
}
