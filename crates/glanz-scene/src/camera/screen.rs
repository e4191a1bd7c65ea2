//! The window of the projection plane that the film covers.

use glanz_math::DVec2;

/// Maps film coordinates (pixels, y down) to the projection plane (y up).
#[derive(Clone, Copy, Debug)]
pub struct Screen {
    top_left: DVec2,
    per_pixel: DVec2,
}

impl Screen {
    /// The window whose shorter side spans [-1, 1]: smallest and largest x, then y.
    #[must_use]
    pub fn default_window(aspect: f64) -> [f64; 4] {
        if aspect > 1.0 { [-aspect, aspect, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect] }
    }

    /// `window`: smallest and largest x, then y; `resolution`: pixels of the full picture.
    ///
    /// `None` if the window is empty or not finite. A window with exchanged ends mirrors the picture.
    #[must_use]
    pub fn try_new(window: [f64; 4], resolution: [f64; 2]) -> Option<Self> {
        let [x0, x1, y0, y1] = window;
        let ok = window.iter().all(|w| w.is_finite()) && x0 != x1 && y0 != y1;
        ok.then(|| Self {
            top_left: DVec2::new(x0, y1),
            per_pixel: DVec2::new((x1 - x0) / resolution[0], (y0 - y1) / resolution[1]),
        })
    }

    /// The point of the projection plane for the film point `film`.
    #[must_use]
    pub fn from_film(&self, film: DVec2) -> DVec2 {
        self.top_left + film * self.per_pixel
    }
    /// The film point that [`Screen::from_film`] maps to `screen`.
    #[must_use]
    pub fn to_film(&self, screen: DVec2) -> DVec2 {
        (screen - self.top_left) / self.per_pixel
    }

    /// Area of a pixel on the projection plane.
    #[must_use]
    pub fn pixel_area(&self) -> f64 {
        (self.per_pixel.x * self.per_pixel.y).abs()
    }
}
