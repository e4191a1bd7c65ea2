//! Places of labels that do not cover each other.

use crate::map_frame::LETTER;

/// Boxes of labels, which do not cover each other: middle and half size, pixels.
#[derive(Default)]
pub(crate) struct LabelBoxes(Vec<[f64; 4]>);

impl LabelBoxes {
    /// Adds a box if it covers no other.
    pub(crate) fn add(&mut self, [x, y]: [f64; 2], [across, up]: [f64; 2]) -> bool {
        let is_free = self
            .0
            .iter()
            .all(|other| (other[0] - x).abs() >= other[2] + across || (other[1] - y).abs() >= other[3] + up);
        if is_free {
            self.0.push([x, y, across, up]);
        }
        is_free
    }
}

/// Half of the size of words with `room` around them, pixels.
pub(crate) fn half_size(words: &str, room: f64) -> [f64; 2] {
    [0.5 * LETTER[0] * words.chars().count() as f64 + room, 0.5 * LETTER[1] + room]
}
