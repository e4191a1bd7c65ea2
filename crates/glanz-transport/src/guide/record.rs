//! Records of a path's vertices until their incident light is known.

use glanz_light::{Spectrum, Wavelengths};

/// Records of all vertices of a path.
#[derive(Debug, Default)]
pub(crate) struct PathRecords {
    pub(crate) directions: Vec<DirectionRecord>,
    pub(crate) lamps: Vec<LightGroupRecord>,
    /// True if the last direction leads to the current vertex.
    leads_here: bool,
}

impl PathRecords {
    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        self.directions.clear();
        self.lamps.clear();
        self.leads_here = false;
    }

    /// Notes the direction in which the path goes on.
    pub(crate) fn push(&mut self, record: DirectionRecord) {
        self.directions.push(record);
        self.leads_here = true;
    }

    /// Sets the data of the current vertex before the path continues: the luminance to `expect` from there beyond what the path finds at the
    /// vertex itself, if that is known. To be called once at each vertex.
    pub(crate) fn expect(&mut self, expect: Option<f64>) {
        let leads_here = std::mem::take(&mut self.leads_here);
        if let Some(record) = self.directions.last_mut().filter(|_| leads_here) {
            record.next = expect.map(|beyond| NextVertex { light: None, beyond });
        }
    }

    /// The path goes on from the vertex where it is and has found `light` so far.
    pub(crate) fn leave(&mut self, light: Spectrum) {
        if let Some(next) = self.directions.last_mut().and_then(|record| record.next.as_mut()) {
            next.light.get_or_insert(light);
        }
    }
}

/// A lamp sampled at a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightGroupRecord {
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
pub(crate) struct DirectionRecord {
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
    /// Data of the vertex to which the direction leads; `None` if unknown.
    pub(crate) next: Option<NextVertex>,
}

/// Data of the next vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NextVertex {
    /// Light that the path had found when it went on from there; `None` if it ended.
    light: Option<Spectrum>,
    /// Luminance that is expected from there besides.
    beyond: f64,
}

impl DirectionRecord {
    /// The luminance that arrived along the direction, and that which went on to the viewer over the density of the direction;
    /// `all`: the light of the whole path.
    ///
    /// Where something is known of the next vertex, only what was found there counts, and what is expected from beyond instead of what this one
    /// path brought from there: the expectation rests on many paths, and so the guide learns from fewer (@dahm2017).
    ///
    /// A surface that scatters no red gives no information on incident red: it counts as none.
    pub(crate) fn found(&self, all: Spectrum, wavelengths: &Wavelengths) -> (f64, f64) {
        let over = |light: Spectrum, throughput: Spectrum| {
            let ratio = light.zip(throughput, |l, t| if t > 0.0 { l / t } else { 0.0 });
            f64::from(ratio.luminance(wavelengths))
        };
        let Some(NextVertex { light, beyond }) = self.next else {
            let found = all - self.light;
            return (over(found, self.beyond), over(found, self.throughput));
        };
        let arrived = over(light.unwrap_or(all) - self.light, self.beyond) + beyond;
        (arrived, arrived * over(self.beyond, self.throughput))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light 1 was found before; half of what comes counts at the vertex, an eighth beyond it.
    fn record() -> DirectionRecord {
        let rgb = Spectrum::from_rgb;
        DirectionRecord {
            cell: 0,
            leaf: 0,
            cosine: 0.5,
            guide_pdf: 1.0,
            bsdf_pdf: 1.0,
            pdf: 1.0,
            light: rgb([1.0; 3]),
            throughput: rgb([0.5; 3]),
            beyond: rgb([0.125; 3]),
            next: None,
        }
    }

    #[test]
    fn light_is_told_apart_from_what_the_path_did_with_it() {
        let wavelengths = Wavelengths::default();
        let rgb = Spectrum::from_rgb;
        // Radiance 6 arrives; the way to the vertex takes half, and f |cos| / p = 1/4 a quarter of that.
        let record = record();
        let (arrived, went_on) = record.found(rgb([1.75; 3]), &wavelengths);
        assert!((arrived - 6.0).abs() < 1e-5 && (went_on - 1.5).abs() < 1e-6, "{arrived} {went_on}");
        let green = DirectionRecord { beyond: rgb([0.0, 0.125, 0.0]), ..record };
        let (arrived, _) = green.found(rgb([1.0, 1.75, 1.0]), &wavelengths);
        assert!((arrived - 6.0 * 0.715_169).abs() < 1e-5, "{arrived}");
    }

    #[test]
    fn what_is_expected_replaces_what_one_path_found_beyond_the_next_vertex() {
        let rgb = Spectrum::from_rgb;
        let record = record();
        let found = |steps: &dyn Fn(&mut PathRecords)| {
            let mut records = PathRecords::default();
            records.expect(Some(7.0));
            records.push(record);
            steps(&mut records);
            records.directions[0].found(rgb([1.75; 3]), &Wavelengths::default())
        };
        let close = |(a, b): (f64, f64), (c, d): (f64, f64)| (a - c).abs() < 1e-5 && (b - d).abs() < 1e-5;
        // 0.25 was found at the next vertex: radiance 2 from there, and 3 expected.
        let at_next = |records: &mut PathRecords| {
            records.expect(Some(3.0));
            records.leave(rgb([1.25; 3]));
            // Vertices after that one say nothing more of it.
            records.expect(Some(9.0));
            records.leave(rgb([1.5; 3]));
        };
        assert!(close(found(&at_next), (5.0, 1.25)));
        // A path that ended there had found all it has.
        assert!(close(found(&|records| records.expect(Some(3.0))), (9.0, 2.25)));
        // Nothing is known of the vertex, or it was the sky: what the path found.
        let unknown = |records: &mut PathRecords| {
            records.expect(None);
            records.leave(rgb([1.25; 3]));
        };
        assert!(close(found(&unknown), (6.0, 1.5)));
        assert!(close(found(&|_| ()), (6.0, 1.5)));
    }
}
