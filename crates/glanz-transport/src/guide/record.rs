//! Records of a path's vertices until their incident light is known.

use glanz_light::{Spectrum, Wavelengths};

use super::survival::brightness;

/// Records of all vertices of a path.
#[derive(Debug, Default)]
pub(crate) struct PathRecords {
    pub(crate) directions: Vec<DirectionRecord>,
    pub(crate) light_groups: Vec<LightGroupRecord>,
    /// Whether the last direction leads to the current vertex.
    leads_here: bool,
}

impl PathRecords {
    /// Removes all records.
    pub(crate) fn clear(&mut self) {
        self.directions.clear();
        self.light_groups.clear();
        self.leads_here = false;
    }

    /// Records the direction in which the path continues.
    pub(crate) fn push(&mut self, record: DirectionRecord) {
        self.directions.push(record);
        self.leads_here = true;
    }

    /// Sets the data of the current vertex before the path continues: the expected luminance from there, beyond the light found at the
    /// vertex itself, if it is known. Must be called once at each vertex.
    pub(crate) fn expect(&mut self, expect: Option<f64>) {
        let leads_here = std::mem::take(&mut self.leads_here);
        if let Some(record) = self.directions.last_mut().filter(|_| leads_here) {
            record.next = expect.map(|beyond| NextVertex { light: None, beyond });
        }
    }

    /// The path continues from the current vertex, with `light` so far.
    pub(crate) fn leave(&mut self, light: Spectrum) {
        if let Some(next) = self.directions.last_mut().and_then(|record| record.next.as_mut()) {
            next.light.get_or_insert(light);
        }
    }
}

/// A light sampled at a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightGroupRecord {
    /// The cell of the vertex.
    pub(crate) cell: u32,
    /// The group of the light.
    pub(crate) group: u32,
    /// Its luminance at the viewer, not divided by the probability of the group.
    pub(crate) luminance: f64,
    /// Probability of the group.
    pub(crate) probability: f64,
}

/// A direction in which a path continued from a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirectionRecord {
    /// The cell of the vertex.
    pub(crate) cell: u32,
    /// The leaf of the direction.
    pub(crate) leaf: u32,
    /// |cos| between direction and shading normal.
    pub(crate) cosine: f64,
    /// Densities per steradian of the guide, of the BSDF, and of the mixture from which the direction was sampled.
    pub(crate) guide_pdf: f64,
    pub(crate) bsdf_pdf: f64,
    pub(crate) pdf: f64,
    /// Light of the path before this vertex.
    pub(crate) light: Spectrum,
    /// Throughput up to the vertex, and beyond it.
    pub(crate) throughput: Spectrum,
    pub(crate) beyond: Spectrum,
    /// Whether the hero alone is left in both throughputs.
    pub(crate) is_dispersed: bool,
    /// Data of the vertex to which the direction leads; `None` if unknown.
    pub(crate) next: Option<NextVertex>,
}

/// Data of the next vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NextVertex {
    /// Light of the path up to and at the next vertex; `None` if the path ended there.
    light: Option<Spectrum>,
    /// Expected luminance from beyond the vertex.
    beyond: f64,
}

impl DirectionRecord {
    /// The incident luminance along the direction, and the luminance that continues to the viewer divided by the density of the direction.
    /// `all`: the light of the whole path.
    ///
    /// If data of the next vertex are known, the light is that found there plus the expected light from beyond, instead of the light that this
    /// path found beyond: the expectation averages many paths, so that the guide needs fewer of them (@dahm2017).
    ///
    /// A surface that scatters no red gives no information on incident red, which counts as zero.
    pub(crate) fn found(&self, all: Spectrum, wavelengths: &Wavelengths) -> (f64, f64) {
        let over = |light: Spectrum, throughput: Spectrum| {
            incident(light, throughput, self.is_dispersed).luminance(wavelengths).into()
        };
        let Some(NextVertex { light, beyond }) = self.next else {
            let found = all - self.light;
            return (over(found, self.beyond), over(found, self.throughput));
        };
        let arrived = over(light.unwrap_or(all) - self.light, self.beyond) + beyond;
        let scattered = incident(self.beyond, self.throughput, self.is_dispersed);
        (arrived, arrived * brightness(scattered, wavelengths))
    }
}

/// The light that the factor `throughput` made `light`; zero where nothing is left. `is_dispersed`: whether the hero alone is left in both, which stands for all wavelengths.
pub(super) fn incident(light: Spectrum, throughput: Spectrum, is_dispersed: bool) -> Spectrum {
    let ratio = light.zip(throughput, |l, t| if t > 0.0 { l / t } else { 0.0 });
    // The factor by which the hero is brighter in both is not in their ratio.
    if is_dispersed { ratio.hero_alone() } else { ratio }
}

#[cfg(test)]
mod tests {
    use glanz_light::SampledWavelengths;

    use super::*;

    /// A record with light 1 before, throughput 1/2 at the vertex and 1/8 beyond it.
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
            is_dispersed: false,
            next: None,
        }
    }

    #[test]
    fn incident_light_does_not_depend_on_the_throughput() {
        let wavelengths = Wavelengths::default();
        let rgb = Spectrum::from_rgb;
        // The incident radiance is 6; the throughput to the vertex is 1/2, and f |cos| / p is 1/4.
        let record = record();
        let (arrived, went_on) = record.found(rgb([1.75; 3]), &wavelengths);
        assert!((arrived - 6.0).abs() < 1e-5 && (went_on - 1.5).abs() < 1e-6, "{arrived} {went_on}");
        let green = DirectionRecord { beyond: rgb([0.0, 0.125, 0.0]), ..record };
        let (arrived, _) = green.found(rgb([1.0, 1.75, 1.0]), &wavelengths);
        assert!((arrived - 6.0 * 0.715_169).abs() < 1e-5, "{arrived}");
    }

    #[test]
    fn hero_of_a_dispersed_path_stands_for_all_wavelengths() {
        let hero = |x: f32| Spectrum::splat(x).hero_alone();
        let dispersed = DirectionRecord {
            light: Spectrum::BLACK,
            throughput: hero(0.5),
            beyond: hero(0.125),
            is_dispersed: true,
            ..record()
        };
        // Radiance 6 at all wavelengths has luminance 6; f |cos| / p is 1/4. Half of it is found at the next vertex, the other half is expected from beyond.
        let next = NextVertex { light: Some(hero(0.375)), beyond: 3.0 };
        for record in [dispersed, DirectionRecord { next: Some(next), ..dispersed }] {
            let count = 256;
            let mut mean = [0.0; 2];
            for i in 0..count {
                let sampled = SampledWavelengths::sample((f64::from(i) + 0.5) / f64::from(count));
                let (arrived, went_on) = record.found(hero(0.75), &Wavelengths::Sampled(sampled));
                mean[0] += arrived / f64::from(count);
                mean[1] += went_on / f64::from(count);
            }
            assert!((mean[0] - 6.0).abs() < 0.01 && (mean[1] - 1.5).abs() < 0.003, "{mean:?}");
        }
    }

    #[test]
    fn expected_light_replaces_the_light_found_beyond_the_next_vertex() {
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
        // Light of 0.25 at the next vertex: radiance 2 from there, plus the expected 3.
        let at_next = |records: &mut PathRecords| {
            records.expect(Some(3.0));
            records.leave(rgb([1.25; 3]));
            // Vertices after the next one do not change the record.
            records.expect(Some(9.0));
            records.leave(rgb([1.5; 3]));
        };
        assert!(close(found(&at_next), (5.0, 1.25)));
        // If the path ended there, all its light was found there.
        assert!(close(found(&|records| records.expect(Some(3.0))), (9.0, 2.25)));
        // Without data of the next vertex, or if the ray escaped, the light that the path found counts.
        let unknown = |records: &mut PathRecords| {
            records.expect(None);
            records.leave(rgb([1.25; 3]));
        };
        assert!(close(found(&unknown), (6.0, 1.5)));
        assert!(close(found(&|_| ()), (6.0, 1.5)));
    }
}
