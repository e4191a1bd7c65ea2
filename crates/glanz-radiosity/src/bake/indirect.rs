//! Indirect light on texels: gathered at corners of blocks of texels, interpolated within.
//!
//! A block is small enough if it is small compared with the distance of other surfaces (@ward1988), and the light at its corners is either
//! even or what the block that it is a part of has there by interpolation.

use std::collections::HashMap;

use glanz_job::JobPart;
use glanz_light::Spectrum;
use glanz_math::DVec2;
use rayon::prelude::*;

use super::BakeError;
use super::direct::{self, luminance};
use super::direct_light::DirectMap;
use super::gather::{FinalGather, GatheredLight};
use super::part::has_piece;
use super::progress::{BakeProgress, PhaseWork};
use super::receiver::BakeReceiver;
use crate::charts::BLOCK_SIDE;

/// Largest side of a block relative to the mean distance of its surroundings, which bounds the change of light within it (@ward1988).
const MAX_SIDE_RATIO: f64 = 0.25;

/// Largest difference between the light at the corner of a block and that between the corners of a block of twice its side, relative to the
/// light. Where light is smooth, its difference within the smaller block is a quarter.
const MAX_DEVIATION: f32 = 0.01;

/// Largest difference between the light at the corners of such a block, relative to its sum.
const MAX_LINEAR_DIFFERENCE: f32 = 0.1;

/// Texels for which light is gathered between two reports of progress.
const TEXELS_AT_ONCE: usize = 4096;

/// A rectangle or line of texels, given by its first and last texel.
#[derive(Clone, Copy, Debug)]
struct TexelBlock {
    chart: usize,
    low: [u32; 2],
    high: [u32; 2],
    /// First and last texel of the block that it is a part of.
    whole: Option<[[u32; 2]; 2]>,
}

impl TexelBlock {
    fn corners(&self) -> [[u32; 2]; 4] {
        let ([a, b], [c, d]) = (self.low, self.high);
        [[a, b], [c, b], [a, d], [c, d]]
    }

    /// The block that it is a part of.
    fn whole(&self) -> Option<Self> {
        self.whole.map(|[low, high]| Self { chart: self.chart, low, high, whole: None })
    }

    /// Position of a texel in the block, from (0, 0) in its first to (1, 1) in its last.
    fn share(&self, texel: [u32; 2]) -> [f32; 2] {
        let share = |axis: usize| {
            let (low, high) = (self.low[axis], self.high[axis]);
            (texel[axis] - low) as f32 / (high - low).max(1) as f32
        };
        [share(0), share(1)]
    }

    fn side(&self) -> u32 {
        (self.high[0] - self.low[0]).max(self.high[1] - self.low[1])
    }

    /// Blocks between the middles of the sides that are longer than a texel.
    fn parts(&self) -> Vec<Self> {
        let cuts = [0, 1].map(|axis| {
            let (low, high) = (self.low[axis], self.high[axis]);
            if high - low > 1 {
                vec![[low, low.midpoint(high)], [low.midpoint(high), high]]
            } else {
                vec![[low, high]]
            }
        });
        let whole = Some([self.low, self.high]);
        let part =
            |x: &[u32; 2], y: &[u32; 2]| Self { low: [x[0], y[0]], high: [x[1], y[1]], whole, ..*self };
        cuts[0].iter().flat_map(|x| cuts[1].iter().map(move |y| part(x, y))).collect()
    }
}

/// Gathered light by chart and texel; `None` where no point is on the surface and outside of all solids.
type GatheredCorners = HashMap<(usize, usize), Option<GatheredLight>>;

/// Indirect light of all texels of all charts; `None` for texels inside solids or off the surface.
///
/// Texels on the borders of charts are computed last, from lines along the borders, so that adjacent charts agree on them.
pub(super) fn light_on_charts(
    gather: &FinalGather<'_>,
    direct: &[DirectMap],
    progress: &mut BakeProgress<'_>,
) -> Result<Vec<Vec<Option<Spectrum>>>, BakeError> {
    let mut filler = TexelFiller::new(gather, direct);
    filler.fill_part(None, progress)?;
    Ok(filler.found)
}

/// Gathers the light of a part, which the state of `gather` then has.
pub(super) fn gather_part(
    gather: &FinalGather<'_>,
    direct: &[DirectMap],
    part: JobPart,
    progress: &mut BakeProgress<'_>,
) -> Result<(), BakeError> {
    TexelFiller::new(gather, direct).fill_part(Some(part), progress)
}

/// Indirect light of texels, as far as it is computed.
struct TexelFiller<'a> {
    gather: &'a FinalGather<'a>,
    direct: &'a [DirectMap],
    known: GatheredCorners,
    found: Vec<Vec<Option<Spectrum>>>,
    /// Points that the state had.
    resumed: usize,
}

/// How blocks or lines are divided.
#[derive(Clone, Copy)]
struct Division {
    /// Largest difference of the light at the corners of a block, relative to its sum.
    max_difference: f32,
    /// Parts of a block, and the points that its division adds, on average: adjacent blocks share some.
    parts: f64,
    new_points: f64,
    /// Usual share of the blocks that are divided.
    share: f64,
}

const BLOCKS: Division = Division { max_difference: 0.002, parts: 4.0, new_points: 3.5, share: 0.6 };

/// Lines along borders, which another chart may continue.
const LINES: Division = Division { max_difference: 0.01, parts: 2.0, new_points: 1.0, share: 0.7 };

impl Division {
    /// Estimate of the number of points that divisions of blocks with this side add.
    fn points(&self, blocks: usize, mut side: u32) -> f64 {
        let (mut blocks, mut points) = (blocks as f64, 0.0);
        while side > 1 {
            blocks *= self.share;
            points += blocks * self.new_points;
            blocks *= self.parts;
            side /= 2;
        }
        points
    }
}

impl<'a> TexelFiller<'a> {
    fn new(gather: &'a FinalGather<'a>, direct: &'a [DirectMap]) -> Self {
        let found = gather.charts.iter().map(|chart| vec![None; chart.texels()]).collect();
        Self { gather, direct, known: GatheredCorners::new(), found, resumed: gather.points() }
    }

    /// Fills the blocks and lines of a part, or all of them.
    fn fill_part(&mut self, part: Option<JobPart>, progress: &mut BakeProgress<'_>) -> Result<(), BakeError> {
        let gather = self.gather;
        let of_part = |all: Vec<TexelBlock>| -> Vec<TexelBlock> {
            let count = all.len();
            let own = all.into_iter().enumerate().filter(|(index, _)| has_piece(part, *index, count));
            own.map(|(_, block)| block).collect()
        };
        let charts = || 0..gather.charts.len();
        let blocks = of_part(charts().flat_map(|chart| largest_blocks(gather, chart)).collect());
        let lines = of_part(charts().flat_map(|chart| border_lines(gather, chart)).collect());
        self.fill(blocks, BLOCKS, LINES.points(lines.len(), BLOCK_SIDE), progress)?;
        self.fill(lines, LINES, 0.0, progress)
    }

    /// Fills blocks, divided until the light of their corners differs little and no surface is near for their size. `later`: estimate of the
    /// number of points that follow.
    fn fill(
        &mut self,
        mut blocks: Vec<TexelBlock>,
        mut division: Division,
        later: f64,
        progress: &mut BakeProgress<'_>,
    ) -> Result<(), BakeError> {
        let (gather, direct) = (self.gather, self.direct);
        let mut side = BLOCK_SIDE;
        while !blocks.is_empty() {
            let mut wanted: Vec<(usize, usize)> = blocks.iter().flat_map(|b| corners(gather, b)).collect();
            wanted.sort_unstable();
            wanted.dedup();
            wanted.retain(|key| !self.known.contains_key(key));
            let all = (self.known.len() + wanted.len()) as f64 + division.points(blocks.len(), side) + later;
            for group in wanted.chunks(TEXELS_AT_ONCE) {
                let [resumed, done] = [self.resumed, self.known.len()].map(|count| count as f64);
                progress.report(PhaseWork { resumed: resumed.min(done), done, all }, || gather.state())?;
                let together = group.par_chunks(gather.receivers_at_once());
                let light: Vec<_> = together.map(|keys| gather_at_texels(gather, direct, keys)).collect();
                self.known.extend(group.iter().copied().zip(light.into_iter().flatten()));
            }
            let (mut rest, count) = (Vec::new(), blocks.len());
            let mut divided = 0;
            for block in blocks {
                let known = |block: &TexelBlock| {
                    corners(gather, block).map(|key| self.known.get(&key).copied().flatten())
                };
                let corners = known(&block);
                let is_fine = block.side() <= 1 || !gather.is_lit(block.chart) && is_dark(&corners);
                let is_smooth = || {
                    let whole = block.whole().map(|whole| (whole, known(&whole)));
                    let is_even = differ_by_at_most(&corners, division.max_difference);
                    let is_linear =
                        whole.is_some_and(|(whole, of)| is_bilinear(&block, &corners, &whole, &of));
                    // A step in the middle of the block before is linear in its corners and its middle, too.
                    let is_linear = is_linear && differ_by_at_most(&corners, MAX_LINEAR_DIFFERENCE);
                    (is_even || is_linear) && is_far_from_others(gather, &block, &corners)
                };
                if is_fine || is_smooth() {
                    interpolate(gather, &block, &corners, &mut self.found[block.chart]);
                } else {
                    divided += 1;
                    rest.extend(block.parts());
                }
            }
            division.share = divided as f64 / count as f64;
            side /= 2;
            blocks = rest;
        }
        Ok(())
    }
}

/// First and last texels of the largest blocks along both axes of a chart.
fn steps(gather: &FinalGather<'_>, chart: usize) -> [Vec<[u32; 2]>; 2] {
    gather.charts[chart].size.map(|n| {
        let starts = (0..n - 1).step_by(BLOCK_SIDE as usize);
        starts.map(|low| [low, (low + BLOCK_SIDE).min(n - 1)]).collect()
    })
}

/// Lines along the borders of a chart.
fn border_lines(gather: &FinalGather<'_>, chart: usize) -> Vec<TexelBlock> {
    let ([x, y], [width, height]) = (steps(gather, chart), gather.charts[chart].size);
    let along_x = [0, height - 1].into_iter().flat_map(|y| x.iter().map(move |x| ([x[0], y], [x[1], y])));
    let along_y = [0, width - 1].into_iter().flat_map(|x| y.iter().map(move |y| ([x, y[0]], [x, y[1]])));
    along_x.chain(along_y).map(|(low, high)| TexelBlock { chart, low, high, whole: None }).collect()
}

/// The largest blocks of a chart.
fn largest_blocks(gather: &FinalGather<'_>, chart: usize) -> Vec<TexelBlock> {
    let lines = steps(gather, chart);
    let block =
        |x: &[u32; 2], y: &[u32; 2]| TexelBlock { chart, low: [x[0], y[0]], high: [x[1], y[1]], whole: None };
    lines[1].iter().flat_map(|y| lines[0].iter().map(move |x| block(x, y))).collect()
}

fn corners(gather: &FinalGather<'_>, block: &TexelBlock) -> [(usize, usize); 4] {
    let width = gather.charts[block.chart].size[0] as usize;
    block.corners().map(|[x, y]| (block.chart, y as usize * width + x as usize))
}

fn is_dark(corners: &[Option<GatheredLight>; 4]) -> bool {
    corners.iter().flatten().all(|corner| corner.light.is_black())
}

/// Whether the light of all corners is known and differs by at most a fraction of its sum.
fn differ_by_at_most(corners: &[Option<GatheredLight>; 4], fraction: f32) -> bool {
    let [Some(a), Some(b), Some(c), Some(d)] = *corners else { return false };
    let lights = [a, b, c, d].map(|corner| luminance(corner.light));
    let (low, high) = lights.iter().fold((f32::INFINITY, 0.0_f32), |(l, h), &x| (l.min(x), h.max(x)));
    high - low <= fraction * (high + low)
}

/// Whether the light at the corners of a block is that between the corners of the block that it is a part of.
fn is_bilinear(
    block: &TexelBlock,
    corners: &[Option<GatheredLight>; 4],
    whole: &TexelBlock,
    of_whole: &[Option<GatheredLight>; 4],
) -> bool {
    let [Some(a), Some(b), Some(c), Some(d)] =
        of_whole.map(|corner| corner.map(|found| luminance(found.light)))
    else {
        return false;
    };
    let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
    block.corners().into_iter().zip(corners).all(|(texel, corner)| {
        let [x, y] = whole.share(texel);
        let between = mix(mix(a, b, x), mix(c, d, x), y);
        corner.is_some_and(|found| {
            let light = luminance(found.light);
            (light - between).abs() <= MAX_DEVIATION * light
        })
    })
}

/// Whether a block is small compared with the distance of other surfaces.
fn is_far_from_others(
    gather: &FinalGather<'_>,
    block: &TexelBlock,
    corners: &[Option<GatheredLight>; 4],
) -> bool {
    let nearest = corners.iter().flatten().fold(f64::INFINITY, |least, corner| least.min(corner.distance));
    // The longer diagonal.
    let position = |[x, y]: [u32; 2]| {
        let chart = &gather.charts[block.chart];
        let surface = gather.elements.surfaces.get(chart.surface as usize)?;
        let place = chart.surface_point(surface, DVec2::new(f64::from(x), f64::from(y)))?;
        Some(surface.at(place.face, place.uv, place.back)?.at.point.position)
    };
    let [p, q, r, s] = block.corners().map(position);
    match (p, q, r, s) {
        (Some(p), Some(q), Some(r), Some(s)) => {
            p.distance(s).max(q.distance(r)) <= MAX_SIDE_RATIO * 2.0 * nearest
        }
        _ => false,
    }
}

/// Interpolates the light of the corners bilinearly; if that of a corner is missing, only the other corners are set.
fn interpolate(
    gather: &FinalGather<'_>,
    block: &TexelBlock,
    corners: &[Option<GatheredLight>; 4],
    into: &mut [Option<Spectrum>],
) {
    let width = gather.charts[block.chart].size[0] as usize;
    let [Some(a), Some(b), Some(c), Some(d)] = corners.map(|corner| corner.map(|found| found.light)) else {
        for ([x, y], corner) in block.corners().into_iter().zip(corners) {
            if let Some(found) = corner {
                into[y as usize * width + x as usize] = Some(found.light);
            }
        }
        return;
    };
    for y in block.low[1]..=block.high[1] {
        for x in block.low[0]..=block.high[0] {
            let [s, t] = block.share([x, y]);
            let light = a.lerp(b, s).lerp(c.lerp(d, s), t);
            into[y as usize * width + x as usize] = Some(light);
        }
    }
}

/// Light gathered at texels, by their charts and numbers; `None` where no point is on the surface and outside of all solids.
fn gather_at_texels(
    gather: &FinalGather<'_>,
    direct: &[DirectMap],
    keys: &[(usize, usize)],
) -> Vec<Option<GatheredLight>> {
    let points: Vec<_> = keys.iter().map(|&key| gather_point(gather, direct, key)).collect();
    let receivers: Vec<BakeReceiver> = points.iter().flatten().map(|(receiver, _)| *receiver).collect();
    let mut found = gather.gather(&receivers).into_iter();
    let mut light = |is_lit: bool| found.next().filter(|light| light.sees_light || is_lit);
    points.iter().map(|point| point.as_ref().and_then(|&(_, is_lit)| light(is_lit))).collect()
}

/// The middle of a texel, or the first of its points that is not inside a solid, and whether light reaches all of the texel.
fn gather_point(
    gather: &FinalGather<'_>,
    direct: &[DirectMap],
    (chart, texel): (usize, usize),
) -> Option<(BakeReceiver, bool)> {
    let own = &gather.charts[chart];
    let lights = direct[chart].at(texel);
    let width = own.size[0] as usize;
    let middle = DVec2::new((texel % width) as f64, (texel / width) as f64);
    let surface = gather.elements.surfaces.get(own.surface as usize)?;
    let is_lit = !lights.iter().any(|light| light.is_black());
    let first = own.surface_point(surface, middle).map(|place| (place, is_lit));
    let others = direct::texel_points(gather.elements, own, texel);
    let others = others.into_iter().zip(lights.iter().map(|light| !light.is_black()));
    let open = first.into_iter().chain(others).find_map(|(place, is_lit)| {
        let receiver = BakeReceiver::new(gather.elements, &place)?;
        (is_lit || gather.sees_light(&receiver)).then_some(receiver)
    });
    Some((open?, is_lit))
}
