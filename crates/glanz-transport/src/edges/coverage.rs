//! Pixels covered by lines.

use glanz_math::DVec2;

use crate::pixel_rect::PixelRect;

/// Covered shares of the pixels of a window.
pub(super) struct CoverageMap {
    crop: PixelRect,
    width: f64,
    shares: Vec<f32>,
}

impl CoverageMap {
    /// Lines of this `width`, pixels.
    pub(super) fn new(crop: PixelRect, width: f64) -> Self {
        Self { crop, width, shares: vec![0.0; crop.len() as usize] }
    }

    /// Adds a line through points of the film. Where lines meet, the larger share counts.
    pub(super) fn add(&mut self, line: &[DVec2]) {
        if let [point] = line {
            self.segment([*point, *point]);
        }
        line.windows(2).for_each(|pair| self.segment([pair[0], pair[1]]));
    }

    fn segment(&mut self, [start, end]: [DVec2; 2]) {
        let reach = 0.5 * self.width + 0.5;
        let [columns, rows] = [0, 1].map(|axis| {
            let (low, high) = (start[axis].min(end[axis]) - reach, start[axis].max(end[axis]) + reach);
            let (first, count) = (f64::from(self.crop.min[axis]), f64::from(self.crop.size[axis]));
            // The centre of pixel i is at i + 1/2; casts map NaN to 0.
            let begin = (low - first - 0.5).ceil().clamp(0.0, count) as usize;
            begin..((high - first - 0.5).floor() + 1.0).clamp(0.0, count) as usize
        });
        for y in rows {
            for x in columns.clone() {
                let corner = DVec2::new(
                    f64::from(self.crop.min[0]) + x as f64,
                    f64::from(self.crop.min[1]) + y as f64,
                );
                let share = self.share(distance(corner + 0.5, [start, end])) as f32;
                let index = y * self.crop.size[0] as usize + x;
                if let Some(known) = self.shares.get_mut(index) {
                    *known = known.max(share);
                }
            }
        }
    }

    /// The share of a pixel that a line covers whose middle is this far from its centre: that of an interval of length 1.
    fn share(&self, distance: f64) -> f64 {
        let half = 0.5 * self.width;
        ((distance + 0.5).min(half) - (distance - 0.5).max(-half)).clamp(0.0, 1.0)
    }

    /// The shares in 255ths.
    pub(super) fn bytes(&self) -> Vec<u8> {
        self.shares.iter().map(|share| (share * 255.0).round() as u8).collect()
    }
}

fn distance(point: DVec2, [start, end]: [DVec2; 2]) -> f64 {
    let direction = end - start;
    let length2 = direction.length_squared();
    let t = if length2 > 0.0 { ((point - start).dot(direction) / length2).clamp(0.0, 1.0) } else { 0.0 };
    point.distance(start + t * direction)
}
