//! What a path remembers of a vertex until it knows how much light came.

use glanz_light::{Spectrum, Wavelengths};

/// What a path remembers of all its vertices.
#[derive(Debug, Default)]
pub(crate) struct Records {
    pub(crate) directions: Vec<Record>,
    pub(crate) lamps: Vec<LampRecord>,
}

impl Records {
    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        self.directions.clear();
        self.lamps.clear();
    }
}

/// A lamp sampled at a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LampRecord {
    /// The cell of the vertex.
    pub(crate) cell: u32,
    /// The group of the lamp.
    pub(crate) group: u32,
    /// Luminance that came from it to the viewer, not divided by the probability of the group.
    pub(crate) luminance: f64,
    /// That probability.
    pub(crate) probability: f64,
}

/// A direction taken at a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record {
    /// The cell of the vertex.
    pub(crate) cell: u32,
    /// The leaf of the direction.
    pub(crate) leaf: u32,
    /// |cos| between direction and shading normal.
    pub(crate) cosine: f64,
    /// Densities per steradian: of the guide, of the BSDF, and that which drew.
    pub(crate) guide_pdf: f64,
    pub(crate) bsdf_pdf: f64,
    pub(crate) pdf: f64,
    /// Light that the path had found before.
    pub(crate) light: Spectrum,
    /// Throughput up to the vertex, and beyond it.
    pub(crate) throughput: Spectrum,
    pub(crate) beyond: Spectrum,
}

impl Record {
    /// The luminance that arrived along the direction, and that which went on to the viewer over the density of the direction;
    /// `all`: the light of the whole path.
    ///
    /// What scatters no red says nothing of the red that arrives: it counts as none.
    pub(crate) fn found(&self, all: Spectrum, wavelengths: &Wavelengths) -> (f64, f64) {
        let found = all - self.light;
        let over =
            |t: Spectrum| found.zip(t, |l, t| if t > 0.0 { l / t } else { 0.0 }).luminance(wavelengths);
        (f64::from(over(self.beyond)), f64::from(over(self.throughput)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_told_apart_from_what_the_path_did_with_it() {
        let wavelengths = Wavelengths::default();
        let rgb = Spectrum::from_rgb;
        // Radiance 6 arrives; the way to the vertex takes half, and f |cos| / p = 1/4 a quarter of that.
        let record = Record {
            cell: 0,
            leaf: 0,
            cosine: 0.5,
            guide_pdf: 1.0,
            bsdf_pdf: 1.0,
            pdf: 1.0,
            light: rgb([1.0; 3]),
            throughput: rgb([0.5; 3]),
            beyond: rgb([0.125, 0.125, 0.125]),
        };
        let (arrived, went_on) = record.found(rgb([1.75; 3]), &wavelengths);
        assert!((arrived - 6.0).abs() < 1e-5 && (went_on - 1.5).abs() < 1e-6, "{arrived} {went_on}");
        let green = Record { beyond: rgb([0.0, 0.125, 0.0]), ..record };
        let (arrived, _) = green.found(rgb([1.0, 1.75, 1.0]), &wavelengths);
        assert!((arrived - 6.0 * 0.715_169).abs() < 1e-5, "{arrived}");
    }
}
