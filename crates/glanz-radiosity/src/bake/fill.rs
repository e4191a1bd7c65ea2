//! Values of texels that have none of their own.

use std::ops::{AddAssign, Mul};

/// Gives texels without a value the mean of their neighbours that have one, repeatedly until all have; the default if none has a value.
///
/// `texels`: row by row, `width` times `height` of them.
#[must_use]
pub fn filled<T>(mut texels: Vec<Option<T>>, [width, height]: [usize; 2]) -> Vec<T>
where
    T: Copy + Default + AddAssign + Mul<f32, Output = T>,
{
    let near = |texel: usize| {
        let (x, y) = (texel % width, texel / width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        rows.flat_map(move |j| (x.saturating_sub(1)..(x + 2).min(width)).map(move |i| j * width + i))
    };
    let mean = |texels: &[Option<T>], texel: usize| {
        let (mut sum, mut count) = (T::default(), 0.0);
        for value in near(texel).filter_map(|i| texels.get(i).copied().flatten()) {
            sum += value;
            count += 1.0;
        }
        (count > 0.0).then(|| (texel, sum * (1.0 / count)))
    };
    // Texels of the next round, which have a neighbour with a value.
    let mut is_next = vec![false; texels.len()];
    let mut found: Vec<(usize, T)> =
        (0..texels.len()).filter(|&i| texels[i].is_none()).filter_map(|i| mean(&texels, i)).collect();
    while !found.is_empty() {
        for &(texel, value) in &found {
            texels[texel] = Some(value);
        }
        let mut next = Vec::new();
        for texel in found.iter().flat_map(|(texel, _)| near(*texel)) {
            if texels[texel].is_none() && !std::mem::replace(&mut is_next[texel], true) {
                next.push(texel);
            }
        }
        found = next.into_iter().filter_map(|texel| mean(&texels, texel)).collect();
    }
    texels.into_iter().map(Option::unwrap_or_default).collect()
}

#[cfg(test)]
mod tests {
    use glanz_light::Spectrum;

    use super::*;

    #[test]
    fn texels_without_light_take_that_of_their_neighbours() {
        let light = |x: f32| Some(Spectrum::splat(x));
        let texels = vec![light(1.0), None, None, light(3.0), None, None];
        let found: Vec<f32> = filled(texels, [3, 2]).iter().map(|l| l.max_component()).collect();
        assert_eq!(found, [1.0, 2.0, 2.0, 3.0, 2.0, 2.0]);
        assert_eq!(filled::<Spectrum>(vec![None; 4], [2, 2]), [Spectrum::BLACK; 4]);
        assert!(filled(Vec::<Option<f32>>::new(), [0, 0]).is_empty());
    }

    /// Fills by rounds over all texels.
    fn filled_slowly(mut texels: Vec<Option<f32>>, width: usize) -> Vec<f32> {
        while texels.iter().any(Option::is_none) {
            let before = texels.clone();
            for (i, texel) in texels.iter_mut().enumerate().filter(|(_, texel)| texel.is_none()) {
                let is_near =
                    |j: usize| (i % width).abs_diff(j % width) <= 1 && (i / width).abs_diff(j / width) <= 1;
                let known: Vec<f32> =
                    (0..before.len()).filter(|&j| is_near(j)).filter_map(|j| before[j]).collect();
                if !known.is_empty() {
                    *texel = Some(known.iter().sum::<f32>() * (1.0 / known.len() as f32));
                }
            }
        }
        texels.into_iter().flatten().collect()
    }

    #[test]
    fn only_texels_beside_known_ones_are_visited_with_the_same_result() {
        for seed in 0..20 {
            let known = |i: u64| glanz_sampling::hash::combine(seed, i);
            let texel = |i: u64| (known(i) % 23 == 0 || i == 5).then(|| (known(i) >> 40) as f32);
            let texels: Vec<Option<f32>> = (0..17 * 29).map(texel).collect();
            assert_eq!(filled(texels.clone(), [17, 29]), filled_slowly(texels, 17));
        }
        // In rounds over all texels this takes 10^10 steps.
        let side = 2000;
        let mut texels = vec![None; side * side];
        texels[0] = Some(2.0_f32);
        assert!(filled(texels, [side, side]).iter().all(|&value| value == 2.0));
    }
}
