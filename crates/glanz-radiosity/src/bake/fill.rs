//! Values of texels that have no light of their own.

use glanz_light::Spectrum;

/// Gives texels without a value the mean of their neighbours that have one, repeatedly until all have; black if none has a value.
pub(super) fn filled(mut texels: Vec<Option<Spectrum>>, [width, height]: [usize; 2]) -> Vec<Spectrum> {
    let mut missing: Vec<usize> = (0..texels.len()).filter(|&i| texels[i].is_none()).collect();
    if missing.len() == texels.len() {
        return vec![Spectrum::BLACK; texels.len()];
    }
    while !missing.is_empty() {
        let mean = |&texel: &usize| {
            let (x, y) = (texel % width, texel / width);
            let (mut sum, mut count) = (Spectrum::BLACK, 0.0);
            for j in y.saturating_sub(1)..(y + 2).min(height) {
                for i in x.saturating_sub(1)..(x + 2).min(width) {
                    if let Some(light) = texels[j * width + i] {
                        sum += light;
                        count += 1.0;
                    }
                }
            }
            (count > 0.0).then(|| (texel, sum * (1.0 / count)))
        };
        let found: Vec<(usize, Spectrum)> = missing.iter().filter_map(mean).collect();
        for &(texel, light) in &found {
            texels[texel] = Some(light);
        }
        missing.retain(|&texel| texels[texel].is_none());
    }
    texels.into_iter().flatten().collect()
}
