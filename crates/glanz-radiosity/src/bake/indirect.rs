//! Where indirect light is gathered, and what is between.

use std::collections::HashMap;

use glanz_light::Spectrum;
use glanz_math::DVec2;
use rayon::prelude::*;

use super::direct::{self, DirectMap, luminance};
use super::gather::{Gather, Gathered};
use super::{BakeError, Spot, Stage};

/// Side of the largest blocks, texels; a power of two.
const BLOCK: u32 = 8;

/// Largest side of a block per the distance of what is around, which bounds the change within it (@ward1988).
const NEAR: f64 = 0.25;

/// Largest difference of corners of a block per their sum.
const DIFFERENT: f32 = 0.05;

/// Places that are gathered at one after the other before it is asked whether to go on.
const AT_ONCE: usize = 4096;

/// A square of texels by its corners, which belong to it.
#[derive(Clone, Copy, Debug)]
struct Block {
    chart: usize,
    low: [u32; 2],
    high: [u32; 2],
}

impl Block {
    fn corners(&self) -> [[u32; 2]; 4] {
        let ([a, b], [c, d]) = (self.low, self.high);
        [[a, b], [c, b], [a, d], [c, d]]
    }

    fn side(&self) -> u32 {
        (self.high[0] - self.low[0]).max(self.high[1] - self.low[1])
    }

    /// Halves of those sides that are longer than a texel.
    fn parts(&self) -> Vec<Self> {
        let cuts = [0, 1].map(|axis| {
            let (low, high) = (self.low[axis], self.high[axis]);
            if high - low > 1 {
                vec![[low, low.midpoint(high)], [low.midpoint(high), high]]
            } else {
                vec![[low, high]]
            }
        });
        let part = |x: &[u32; 2], y: &[u32; 2]| Self { low: [x[0], y[0]], high: [x[1], y[1]], ..*self };
        cuts[0].iter().flat_map(|x| cuts[1].iter().map(move |y| part(x, y))).collect()
    }
}

/// Gathered light by chart and texel; `None` where no place is on the surface and outside of everything.
type Known = HashMap<(usize, usize), Option<Gathered>>;

/// Indirect light of all texels of all charts; `None` where a texel has none of its own.
pub(super) fn of_charts(
    gather: &Gather<'_>,
    direct: &[DirectMap],
    go_on: &mut dyn FnMut(Stage, f64) -> bool,
) -> Result<Vec<Vec<Option<Spectrum>>>, BakeError> {
    let mut found: Vec<Vec<Option<Spectrum>>> =
        gather.charts.iter().map(|chart| vec![None; chart.texels()]).collect();
    let mut known = Known::new();
    let mut blocks: Vec<Block> = (0..gather.charts.len()).flat_map(|chart| first(gather, chart)).collect();
    let all: usize = gather.charts.iter().map(crate::charts::Chart::texels).sum();
    let mut done = 0;
    while !blocks.is_empty() {
        let mut wanted: Vec<(usize, usize)> = blocks.iter().flat_map(|b| corners(gather, b)).collect();
        wanted.sort_unstable();
        wanted.dedup();
        wanted.retain(|key| !known.contains_key(key));
        for group in wanted.chunks(AT_ONCE) {
            if !go_on(Stage::Gather, done as f64 / all as f64) {
                return Err(BakeError::Stopped);
            }
            let one = |&key: &(usize, usize)| (key, at_texel(gather, direct, key));
            let light: Vec<_> = group.par_iter().map(one).collect();
            known.extend(light);
        }
        let mut rest = Vec::new();
        for block in blocks {
            let keys = corners(gather, &block);
            let corners = keys.map(|key| known.get(&key).copied().flatten());
            let is_fine = block.side() <= 1 || !gather.is_lit(block.chart) && is_dark(&corners);
            if is_fine || is_smooth(gather, &block, &corners) {
                put(gather, &block, &corners, &mut found[block.chart]);
                done += ((block.high[0] - block.low[0]) * (block.high[1] - block.low[1])) as usize;
            } else {
                rest.extend(block.parts());
            }
        }
        blocks = rest;
    }
    Ok(found)
}

/// The largest blocks of a chart.
fn first(gather: &Gather<'_>, chart: usize) -> Vec<Block> {
    let lines = gather.charts[chart].size.map(|n| {
        let starts = (0..n - 1).step_by(BLOCK as usize);
        starts.map(|low| [low, (low + BLOCK).min(n - 1)]).collect::<Vec<[u32; 2]>>()
    });
    let block = |x: &[u32; 2], y: &[u32; 2]| Block { chart, low: [x[0], y[0]], high: [x[1], y[1]] };
    lines[1].iter().flat_map(|y| lines[0].iter().map(move |x| block(x, y))).collect()
}

fn corners(gather: &Gather<'_>, block: &Block) -> [(usize, usize); 4] {
    let width = gather.charts[block.chart].size[0] as usize;
    block.corners().map(|[x, y]| (block.chart, y as usize * width + x as usize))
}

fn is_dark(corners: &[Option<Gathered>; 4]) -> bool {
    corners.iter().flatten().all(|corner| corner.light.is_black())
}

fn is_smooth(gather: &Gather<'_>, block: &Block, corners: &[Option<Gathered>; 4]) -> bool {
    let [Some(a), Some(b), Some(c), Some(d)] = *corners else { return false };
    let of = [a, b, c, d];
    let nearest = of.iter().fold(f64::INFINITY, |least, corner| least.min(corner.distance));
    let lights = of.map(|corner| luminance(corner.light));
    let (low, high) = lights.iter().fold((f32::INFINITY, 0.0_f32), |(l, h), &x| (l.min(x), h.max(x)));
    if high - low > DIFFERENT * (high + low) {
        return false;
    }
    // The longer diagonal.
    let position = |[x, y]: [u32; 2]| {
        let chart = &gather.charts[block.chart];
        let surface = gather.elements.surfaces.get(chart.surface as usize)?;
        let place = chart.place(surface, DVec2::new(f64::from(x), f64::from(y)))?;
        Some(surface.at(place.face, place.uv, place.back)?.at.point.position)
    };
    let [p, q, r, s] = block.corners().map(position);
    match (p, q, r, s) {
        (Some(p), Some(q), Some(r), Some(s)) => p.distance(s).max(q.distance(r)) <= NEAR * 2.0 * nearest,
        _ => false,
    }
}

/// Light between the corners, linear along both sides; where one is missing, corners alone.
fn put(gather: &Gather<'_>, block: &Block, corners: &[Option<Gathered>; 4], into: &mut [Option<Spectrum>]) {
    let width = gather.charts[block.chart].size[0] as usize;
    let [Some(a), Some(b), Some(c), Some(d)] = corners.map(|corner| corner.map(|found| found.light)) else {
        for ([x, y], corner) in block.corners().into_iter().zip(corners) {
            if let Some(found) = corner {
                into[y as usize * width + x as usize] = Some(found.light);
            }
        }
        return;
    };
    let share = |x: u32, axis: usize| {
        let (low, high) = (block.low[axis], block.high[axis]);
        (x - low) as f32 / (high - low) as f32
    };
    for y in block.low[1]..=block.high[1] {
        for x in block.low[0]..=block.high[0] {
            let (s, t) = (share(x, 0), share(y, 1));
            let light = a.lerp(b, s).lerp(c.lerp(d, s), t);
            into[y as usize * width + x as usize] = Some(light);
        }
    }
}

/// Gathers at the middle of a texel, or at the first of its places that does not lie inside of something.
fn at_texel(gather: &Gather<'_>, direct: &[DirectMap], (chart, texel): (usize, usize)) -> Option<Gathered> {
    let own = &gather.charts[chart];
    let lights = direct[chart].at(texel);
    let width = own.size[0] as usize;
    let middle = DVec2::new((texel % width) as f64, (texel / width) as f64);
    let surface = gather.elements.surfaces.get(own.surface as usize)?;
    let is_lit = !lights.iter().any(|light| light.is_black());
    let first = own.place(surface, middle).map(|place| (place, is_lit));
    let others = direct::places(gather.elements, own, texel);
    let others = others.into_iter().zip(lights.iter().map(|light| !light.is_black()));
    let open = first.into_iter().chain(others).find_map(|(place, is_lit)| {
        let spot = Spot::new(gather.elements, &place)?;
        (is_lit || gather.sees_out(&spot)).then_some(spot)
    });
    let found = gather.at(&open?);
    (found.sees_out || is_lit).then_some(found)
}
