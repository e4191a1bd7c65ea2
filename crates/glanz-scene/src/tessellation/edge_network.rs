//! The edges of the patches of a group, their vertices, and the outlines that follow.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glanz_math::{DVec2, DVec3};
use rayon::prelude::*;

use super::closed_sides::{closed_axes, pole_sides};
use super::outline::{Outline, SidePoint, SideRange, Window};
use super::patch::MeshPatch;
use super::patch_side::PatchSide;
use super::progress::PatchStep;
use super::shared_edge::{EdgeKey, EdgePlace, EdgeSampler, EdgeUse, SharedEdge};
use super::vertices::Vertices;
use super::{TessellationProgress, TessellationSettings};
use crate::description::TrimEdgeDescription;

/// The edges of all patches with their samples.
pub(super) struct EdgeNetwork<'a> {
    patches: &'a [MeshPatch],
    progress: &'a TessellationProgress,
    windows: Vec<Window>,
    edges: Vec<SharedEdge>,
    /// Whether all edges were sampled once.
    is_sampled: bool,
    keys: HashMap<EdgeKey, usize>,
    pub(super) vertices: Vertices,
    /// Those of the description, by their numbers there.
    numbered: HashMap<u32, u32>,
    /// Sides of patches that are points.
    poles: Vec<Vec<bool>>,
    /// For each patch, its edges and the indices of its uses of them.
    uses_of: Vec<Vec<[usize; 2]>>,
    /// For each patch, its samples on its sides.
    on_sides: Vec<OnSides>,
    /// For each patch.
    pub(super) outlines: Vec<Outline>,
}

/// Samples of curves on the sides of a patch, and the parts of sides on which curves lie.
type OnSides = (Vec<SidePoint>, Vec<SideRange>);

/// A chord between two pins is never shorter than this power of one half of their part of an edge.
const MAX_DEPTH: u32 = 18;

/// Largest number of samples of all edges, if each lies between two pins.
const MAX_SAMPLES: usize = 1 << 28;

/// Parts of the deviation within which the sides of a window are one line, or a point.
const SIDES: f64 = 1e-3;

impl<'a> EdgeNetwork<'a> {
    pub(super) fn new(patches: &'a [MeshPatch], deviation: f64, progress: &'a TessellationProgress) -> Self {
        let mut network = Self {
            patches,
            progress,
            windows: Vec::with_capacity(patches.len()),
            edges: Vec::new(),
            is_sampled: false,
            keys: HashMap::new(),
            vertices: Vertices::default(),
            numbered: HashMap::new(),
            poles: Vec::new(),
            uses_of: vec![Vec::new(); patches.len()],
            on_sides: vec![OnSides::default(); patches.len()],
            outlines: vec![Outline::default(); patches.len()],
        };
        for (number, patch) in patches.iter().enumerate() {
            if progress.is_cancelled() {
                break;
            }
            let closed = closed_axes(patch, SIDES * deviation);
            network.windows.push(Window::new(patch, closed, SIDES * deviation));
            network.poles.push(pole_sides(patch, SIDES * deviation));
            network.add_sides(number, patch, closed);
            network.add_curves(number, patch);
        }
        network
    }

    fn add_use(&mut self, key: EdgeKey, a_use: EdgeUse) -> usize {
        let next = self.edges.len();
        let number = *self.keys.entry(key).or_insert(next);
        if number == next {
            self.edges.push(SharedEdge::default());
        }
        let uses = &mut self.edges[number].uses;
        uses.push(a_use);
        let index = uses.len() - 1;
        if let Some(uses) = self.uses_of.get_mut(a_use.patch) {
            uses.push([number, index]);
        }
        number
    }

    fn add_sides(&mut self, number: usize, patch: &MeshPatch, closed: [bool; 2]) {
        let mut firsts: [Option<EdgeKey>; 2] = [None, None];
        for (side, curve) in patch.sides.iter().enumerate() {
            let own = EdgeKey::Own(self.edges.len());
            // The sides 0 and 2 run along u and are opposite in v, the sides 1 and 3 along v; the second runs back.
            let seam = patch.sides.len() == 4 && closed[1 - side % 2];
            let (key, range) = match (&firsts[side % 2], curve) {
                (Some(first), _) if seam => (first.clone(), [1.0, 0.0]),
                (None, _) if seam => (own, [0.0, 1.0]),
                (_, Some(curve)) => canonical(curve),
                (_, None) => (own, [0.0, 1.0]),
            };
            if seam && side < 2 {
                firsts[side] = Some(key.clone());
            }
            self.add_use(key, EdgeUse { patch: number, place: EdgePlace::Side(side), range });
        }
    }

    fn add_curves(&mut self, number: usize, patch: &MeshPatch) {
        let Some(trim) = &patch.trim else { return };
        for (loop_number, curves) in trim.loops.iter().enumerate() {
            for (index, curve) in curves.iter().enumerate() {
                let places = curve.places();
                let points: Vec<DVec2> = places.iter().map(|&t| curve.at(t)).collect();
                let Some(window) = self.windows.get(number) else { continue };
                if !window.meets(&points) {
                    continue;
                }
                // A part of an edge without length, or a number, says nothing about the places on it.
                let shared = curve.edge.filter(|TrimEdgeDescription { range: [from, to], .. }| {
                    from.is_finite() && to.is_finite() && from != to
                });
                let (key, range) = match shared {
                    Some(edge) => (EdgeKey::Numbered(edge.edge), edge.range),
                    None => (EdgeKey::Own(self.edges.len()), [0.0, 1.0]),
                };
                let place = EdgePlace::Curve { number: loop_number, curve: index };
                let edge = self.add_use(key, EdgeUse { patch: number, place, range });
                if let Some(shared) = shared {
                    self.edges[edge].vertices = Some(shared.vertices);
                }
            }
        }
    }
}

/// The key of a side's curve whichever way it runs, and the way.
fn canonical(curve: &PatchSide) -> (EdgeKey, [f64; 2]) {
    let reversed = curve.reversed();
    if *curve <= reversed {
        (EdgeKey::Side(curve.clone()), [0.0, 1.0])
    } else {
        (EdgeKey::Side(reversed), [1.0, 0.0])
    }
}

impl EdgeNetwork<'_> {
    /// Samples all edges and makes the outlines of all patches.
    pub(super) fn sample_all(&mut self, settings: TessellationSettings) {
        let (sides, curves): (Vec<usize>, Vec<usize>) =
            (0..self.edges.len()).partition(|&number| self.is_side(number));
        self.pin_crossings(&curves, settings);
        self.sample(&curves, settings);
        let all: Vec<usize> = (0..self.patches.len()).collect();
        self.outline(&all, &sides, settings);
        self.is_sampled = true;
    }

    /// Samples edges at further fractions, and makes the outlines of the patches that have them anew. Returns these patches.
    pub(super) fn divide(
        &mut self,
        fractions: &BTreeMap<usize, Vec<f64>>,
        settings: TessellationSettings,
    ) -> BTreeSet<usize> {
        for (&number, fractions) in fractions {
            if let Some(edge) = self.edges.get_mut(number) {
                edge.divisions.extend(fractions);
            }
        }
        let patches_of = |network: &Self, numbers: &[usize]| -> BTreeSet<usize> {
            let edges = numbers.iter().filter_map(|&number| network.edges.get(number));
            edges.flat_map(|edge| edge.uses.iter().map(|a_use| a_use.patch)).collect()
        };
        let (mut sides, curves): (Vec<usize>, Vec<usize>) =
            fractions.keys().partition(|&&number| self.is_side(number));
        let edges: Vec<usize> = fractions.keys().copied().collect();
        let mut patches = patches_of(self, &edges);
        let own = patches.iter().filter_map(|&patch| self.uses_of.get(patch)).flatten();
        sides.extend(own.map(|&[edge, _]| edge).filter(|&edge| self.is_side(edge)));
        sides.sort_unstable();
        sides.dedup();
        patches.extend(patches_of(self, &sides));
        self.sample(&curves, settings);
        let changed: Vec<usize> = patches.iter().copied().collect();
        self.outline(&changed, &sides, settings);
        patches
    }

    fn is_side(&self, number: usize) -> bool {
        let first = self.edges.get(number).and_then(|edge| edge.uses.first());
        first.is_some_and(|a_use| matches!(a_use.place, EdgePlace::Side(_)))
    }

    /// Makes the outlines of patches whose curves are sampled, and samples these sides.
    fn outline(&mut self, patches: &[usize], sides: &[usize], settings: TessellationSettings) {
        self.add_to_outlines(patches, false, settings);
        self.pin_sides(sides);
        self.sample(sides, settings);
        self.add_to_outlines(patches, true, settings);
        self.join(patches);
    }

    /// Adds the samples of the sides of patches to their outlines, or those of their curves to new ones.
    fn add_to_outlines(&mut self, patches: &[usize], sides: bool, settings: TessellationSettings) {
        let added: Vec<(usize, Outline, OnSides)> = patches
            .par_iter()
            .filter_map(|&number| {
                if self.progress.is_cancelled() {
                    return None;
                }
                let (patch, window) = (self.patches.get(number)?, self.windows.get(number)?);
                let mut outline = if sides { self.outlines.get(number)?.clone() } else { Outline::default() };
                let mut on_sides = OnSides::default();
                for &[edge_number, number] in self.uses_of.get(number)? {
                    let Some(edge) = self.edges.get(edge_number) else { continue };
                    if self.is_side(edge_number) != sides {
                        continue;
                    }
                    let sampler = EdgeSampler::new(self.patches, edge, settings);
                    let numbers = [edge_number, number];
                    if sides {
                        outline.add_side(patch, window, edge, numbers, &sampler);
                    } else {
                        let (points, covered) = outline.add_curve(patch, window, edge, numbers, &sampler);
                        on_sides.0.extend(points);
                        on_sides.1.extend(covered);
                    }
                }
                Some((number, outline, on_sides))
            })
            .collect();
        for (number, outline, on_sides) in added {
            self.outlines[number] = outline;
            if !sides {
                self.on_sides[number] = on_sides;
            }
        }
    }

    /// Curves are sampled where they cross the sides of a window.
    fn pin_crossings(&mut self, curves: &[usize], settings: TessellationSettings) {
        for &number in curves {
            let Some(edge) = self.edges.get(number).filter(|_| !self.progress.is_cancelled()) else { return };
            let sampler = EdgeSampler::new(self.patches, edge, settings);
            let mut pinned = Vec::new();
            for (index, a_use) in edge.uses.iter().enumerate() {
                let (Some(patch), Some(window), EdgePlace::Curve { number, curve }) =
                    (self.patches.get(a_use.patch), self.windows.get(a_use.patch), a_use.place)
                else {
                    continue;
                };
                let Some(curve) = patch.trim.as_ref().and_then(|trim| trim.loops.get(number)?.get(curve))
                else {
                    continue;
                };
                for t in window.crossings(&curve.places(), |t| curve.at(t)) {
                    pinned.push((index, sampler.fraction(index, t), t));
                }
            }
            pinned.sort_by(|a: &(usize, f64, f64), b| a.1.total_cmp(&b.1));
            // A seam is crossed at the same point on both of its sides.
            for i in 1..pinned.len() {
                let first = pinned[i - 1].1;
                let mut known = pinned[..i].iter().rev().take_while(|pin| pin.1 == first);
                let is_other = known.all(|pin| pin.0 != pinned[i].0);
                let apart = sampler.point(first).distance(sampler.point(pinned[i].1));
                if is_other && apart <= SIDES * settings.deviation {
                    pinned[i].1 = first;
                }
            }
            if let Some(edge) = self.edges.get_mut(number) {
                edge.pins = pinned.iter().map(|&(_, fraction, _)| (fraction, None)).collect();
                edge.pinned = pinned;
            }
        }
    }

    /// Sides are sampled where curves meet them, and not where curves lie on them.
    fn pin_sides(&mut self, sides: &[usize]) {
        let on_sides = &self.on_sides;
        for &number in sides {
            let Some(edge) = self.edges.get_mut(number) else { continue };
            (edge.pins, edge.covered) = (Vec::new(), Vec::new());
            for a_use in edge.uses.clone() {
                let EdgePlace::Side(side) = a_use.place else { continue };
                let Some((points, covered)) = on_sides.get(a_use.patch) else { continue };
                let here = points.iter().filter(|point| point.0 == side);
                edge.pins
                    .extend(here.map(|&(_, t, vertex)| (a_use.fraction_at(t.clamp(0.0, 1.0)), Some(vertex))));
                let ranges = covered.iter().filter(|range| range.0 == side);
                edge.covered.extend(ranges.map(|&(_, ends)| {
                    let [a, b] = ends.map(|t| a_use.fraction_at(t.clamp(0.0, 1.0)));
                    [a.min(b), a.max(b)]
                }));
            }
            edge.pins.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
    }

    /// Samples edges.
    fn sample(&mut self, numbers: &[usize], settings: TessellationSettings) {
        let depth = MAX_SAMPLES.checked_div(self.edges.len()).and_then(usize::checked_ilog2).unwrap_or(0);
        let sampled: Vec<(Vec<(f64, DVec3)>, f64)> = numbers
            .par_iter()
            .map(|&number| {
                let Some(edge) = self.edges.get(number).filter(|_| !self.progress.is_cancelled()) else {
                    return Default::default();
                };
                if !self.is_sampled {
                    self.progress.advance(PatchStep::Edges, self.patches.len(), self.edges.len());
                }
                let sampler = EdgeSampler::new(self.patches, edge, settings);
                let (fractions, deviation) = if self.is_pole(edge) {
                    (pole_fractions(edge), 0.0)
                } else {
                    sampler.fractions(depth.min(MAX_DEPTH))
                };
                let samples = fractions.into_iter().map(|fraction| (fraction, sampler.point(fraction)));
                // Where no patch has the edge, there is nothing to sample.
                (samples.filter(|(_, point)| point.is_finite()).collect(), deviation)
            })
            .collect();
        for (&number, (sampled, deviation)) in numbers.iter().zip(sampled) {
            let Some(edge) = self.edges.get(number).cloned() else { continue };
            let mut samples: Vec<(f64, u32)> = Vec::with_capacity(sampled.len());
            for (fraction, position) in sampled {
                let first = edge.pins.partition_point(|pin| pin.0 < fraction);
                let pins = edge.pins.iter().skip(first).take_while(|pin| pin.0 == fraction);
                let mut here: Vec<u32> = pins.filter_map(|pin| pin.1).collect();
                if let Some([start, end]) = edge.vertices.filter(|_| fraction == 0.0 || fraction == 1.0) {
                    let vertex = if fraction == 0.0 { start } else { end };
                    here.push(*self.numbered.entry(vertex).or_insert_with(|| self.vertices.add(position)));
                }
                let vertex = match here.first() {
                    Some(&first) => first,
                    None => self.vertices.add(position),
                };
                here.iter().for_each(|&other| self.vertices.unite(vertex, other));
                samples.push((fraction, vertex));
            }
            if let Some(edge) = self.edges.get_mut(number) {
                (edge.samples, edge.deviation) = (samples, deviation);
            }
        }
    }

    /// For each use of an edge, its patch and the largest distance of a chord from the edge, metres.
    pub(super) fn patch_deviations(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.edges.iter().flat_map(|edge| edge.uses.iter().map(|a_use| (a_use.patch, edge.deviation)))
    }

    fn is_pole(&self, edge: &SharedEdge) -> bool {
        edge.uses.iter().any(|a_use| match a_use.place {
            EdgePlace::Side(side) => {
                self.poles.get(a_use.patch).and_then(|poles| poles.get(side)).is_some_and(|&pole| pole)
            }
            EdgePlace::Curve { .. } => false,
        })
    }

    /// Joins vertices at the same parameters of patches, and those of sides that are points.
    fn join(&mut self, patches: &[usize]) {
        let outlines = patches.iter().filter_map(|&patch| self.outlines.get(patch));
        let same: Vec<[u32; 2]> = outlines.flat_map(|outline| &outline.same).copied().collect();
        same.into_iter().for_each(|[a, b]| self.vertices.unite(a, b));
        let poles: Vec<Vec<u32>> = self
            .edges
            .iter()
            .filter(|edge| self.is_pole(edge))
            .map(|edge| edge.samples.iter().map(|sample| sample.1).collect())
            .collect();
        for vertices in poles {
            vertices.windows(2).for_each(|pair| self.vertices.unite(pair[0], pair[1]));
        }
    }
}

/// Fractions of an edge that is a point: triangles that meet in it have corners beside each other.
fn pole_fractions(edge: &SharedEdge) -> Vec<f64> {
    const PARTS: u32 = 32;
    let even = (0..=PARTS).map(|i| f64::from(i) / f64::from(PARTS));
    let mut fractions: Vec<f64> = edge.pins.iter().map(|pin| pin.0).chain(even).collect();
    fractions.retain(|fraction| (0.0..=1.0).contains(fraction));
    fractions.sort_by(f64::total_cmp);
    fractions.dedup();
    fractions
}
