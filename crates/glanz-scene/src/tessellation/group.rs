//! The triangles of the shapes of a group.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::edge_network::EdgeNetwork;
use super::patch::MeshPatch;
use super::polygons::{add_polygons, polygons};
use super::progress::PatchStep;
use super::triangulation::{PatchTriangulation, TriangulatedPatch};
use super::{
    GroupMesh, MeshVertex, ShapeMesh, TessellationFaultKind, TessellationProgress, TessellationSettings,
};
use crate::description::ShapeDescription;

/// The mesh of a group, its largest deviation, and faults by shape.
#[derive(Default)]
pub(super) struct GroupOutcome {
    pub(super) mesh: GroupMesh,
    pub(super) deviation: f64,
    pub(super) faults: Vec<(usize, TessellationFaultKind)>,
}

/// How often edges are divided whose chords cross.
const ROUNDS: usize = 12;

/// Parts of the deviation by which chords may be moved where they cross.
const MOVED: f64 = 0.02;

/// The edges of patches, and the triangulations of their outlines; edges are sampled more closely where chords cross.
fn triangulations<'a>(
    patches: &'a [MeshPatch],
    settings: TessellationSettings,
    progress: &'a TessellationProgress,
) -> (EdgeNetwork<'a>, Vec<PatchTriangulation>) {
    let mut network = EdgeNetwork::new(patches, settings.deviation, progress);
    network.sample_all(settings);
    let mut changed: Vec<usize> = (0..patches.len()).collect();
    let mut triangulations: BTreeMap<usize, PatchTriangulation> = BTreeMap::new();
    for round in 0.. {
        let made: Vec<(usize, PatchTriangulation)> = changed
            .par_iter()
            .filter_map(|&number| {
                if progress.is_cancelled() {
                    return None;
                }
                let (patch, outline) = (patches.get(number)?, network.outlines.get(number)?);
                let made = PatchTriangulation::new(patch, outline, &network.vertices.positions, settings);
                if round == 0 {
                    progress.advance(PatchStep::Outline, 1, 1);
                }
                Some((number, made))
            })
            .collect();
        triangulations.extend(made);
        let mut divisions: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for &number in changed.iter().filter(|_| round < ROUNDS) {
            let (Some(made), Some(outline)) = (triangulations.get(&number), network.outlines.get(number))
            else {
                continue;
            };
            let conflicts = made.outline.conflicts.iter();
            let high = conflicts.filter(|conflict| conflict.height > MOVED * settings.deviation);
            let segments =
                high.flat_map(|conflict| &conflict.segments).filter_map(|&i| outline.segments.get(i));
            for segment in segments.filter(|segment| segment.curved) {
                let [from, to] = segment.fractions;
                divisions.entry(segment.edge).or_default().push(0.5 * (from + to));
            }
        }
        if divisions.is_empty() || progress.is_cancelled() {
            break;
        }
        changed = network.divide(&divisions, settings).into_iter().collect();
    }
    let mut made: Vec<PatchTriangulation> = triangulations.into_values().collect();
    made.iter_mut().for_each(|made| made.rename(|vertex| network.vertices.representative(vertex)));
    (network, made)
}

/// The patches of shapes. Polygons are added to the outcome, as are faults of shapes without patches.
fn patches(
    shapes: &[ShapeDescription],
    outcome: &mut GroupOutcome,
    progress: &TessellationProgress,
) -> Vec<MeshPatch> {
    let made: Vec<_> = shapes
        .par_iter()
        .enumerate()
        .map(|(number, shape)| {
            if progress.is_cancelled() {
                return (Ok(None), Ok(Vec::new()));
            }
            match polygons(shape) {
                Some(polygons) => (polygons.map(Some), Ok(Vec::new())),
                None => (Ok(None), MeshPatch::of_shape(number, shape)),
            }
        })
        .collect();
    let mut patches = Vec::new();
    for (number, (shape, (polygons, made))) in shapes.iter().zip(made).enumerate() {
        if progress.is_cancelled() {
            break;
        }
        if !matches!(&made, Ok(made) if !made.is_empty()) {
            progress.skip(shape);
        }
        match (polygons, made) {
            (Ok(Some(polygons)), _) => add_polygons(&mut outcome.mesh, number, polygons),
            (Ok(None), Ok(made)) => patches.extend(made),
            (Err(fault), _) | (_, Err(fault)) => outcome.faults.push((number, fault)),
        }
    }
    patches
}

/// Triangles of all shapes, in the frame of the group; lengths of the settings are in this frame, too. Those of some are missing if `progress` is
/// cancelled.
pub(super) fn mesh(
    shapes: &[ShapeDescription],
    settings: TessellationSettings,
    progress: &TessellationProgress,
) -> GroupOutcome {
    let mut outcome = GroupOutcome::default();
    outcome.mesh.shapes = vec![ShapeMesh::default(); shapes.len()];
    let patches = patches(shapes, &mut outcome, progress);
    if patches.is_empty() {
        return outcome;
    }
    let (network, triangulations) = triangulations(&patches, settings, progress);
    if progress.is_cancelled() {
        // Some patches have no triangulation, so that the others would be paired wrongly.
        return outcome;
    }
    let filled: Vec<TriangulatedPatch> = triangulations
        .into_par_iter()
        .zip(&patches)
        .map(|(triangulation, patch)| {
            if progress.is_cancelled() {
                return TriangulatedPatch::default();
            }
            let filled = triangulation.fill(patch, settings, progress.cancel());
            progress.advance(PatchStep::Filling, 1, 1);
            filled
        })
        .collect();
    for (number, deviation) in network.patch_deviations() {
        outcome.deviation = outcome.deviation.max(deviation);
        let patch = patches.get(number).filter(|_| deviation > settings.deviation);
        outcome.faults.extend(patch.map(|patch| (patch.shape, TessellationFaultKind::Coarse { deviation })));
    }
    let base = outcome.mesh.positions.len() as u32;
    outcome.mesh.positions.extend(&network.vertices.positions);
    for (patch, filled) in patches.iter().zip(filled) {
        outcome.deviation = outcome.deviation.max(filled.deviation);
        outcome.faults.extend(filled.fault.map(|fault| (patch.shape, fault)));
        let Some(shape) = outcome.mesh.shapes.get_mut(patch.shape) else { continue };
        let first = shape.vertices.len() as u32;
        for site in &filled.vertices {
            let position = site.vertex.map_or(outcome.mesh.positions.len() as u32, |vertex| base + vertex);
            if site.vertex.is_none() {
                outcome.mesh.positions.push(site.point);
            }
            shape.vertices.push(MeshVertex { position, normal: site.normal });
        }
        let turned = |[a, b, c]: [u32; 3]| if patch.flipped { [a, c, b] } else { [a, b, c] };
        shape.triangles.extend(filled.triangles.iter().map(|&corners| turned(corners).map(|i| first + i)));
    }
    compact(&mut outcome.mesh);
    outcome
}

/// Removes positions without triangles.
fn compact(mesh: &mut GroupMesh) {
    let mut numbers = vec![u32::MAX; mesh.positions.len()];
    let mut kept = Vec::new();
    for vertex in mesh.shapes.iter_mut().flat_map(|shape| &mut shape.vertices) {
        let Some(number) = numbers.get_mut(vertex.position as usize) else { continue };
        if *number == u32::MAX {
            *number = kept.len() as u32;
            kept.extend(mesh.positions.get(vertex.position as usize));
        }
        vertex.position = *number;
    }
    mesh.positions = kept;
}
