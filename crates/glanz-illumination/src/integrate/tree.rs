//! Search for the parts of mirrors that can show an emitter.

use std::f64::consts::{FRAC_PI_2, PI};

use glanz_math::{DVec2, DVec3};

use super::contour::ReceivingPoint;
use super::emitter_shape::EmitterShape;
use super::extent::{DerivativeBounds, MirrorExtent, MirrorPart};
use super::mirror::{MirrorFace, Mirrors};
use super::region::IntegrationRect;

/// Largest number of divisions of a face in advance.
const LEVELS: u32 = 4;
/// Half angle, radians, of the normals of a part that is not subdivided in advance.
const ALMOST_FLAT: f64 = 0.02;
/// A flat part is not quartered in advance if the derivatives of the points in every quarter are at least this fraction of the largest.
const STEADY: f64 = 0.6;
/// Largest number of divisions of a part for one point.
const DEEPEST: u32 = 40;
/// Largest number of parts that are examined for one point and one emitter.
const BUDGET: usize = 1 << 16;
/// Largest angle between mirrored rays of a cell, as a multiple of the half angle of the inner ball of the emitter, so that no image falls
/// between the samples.
const FINENESS: f64 = 1.5;

/// A hierarchy over all mirrors and their parts.
#[derive(Debug, Default)]
pub(super) struct MirrorTree {
    nodes: Vec<MirrorNode>,
    root: Option<MirrorNode>,
}

#[derive(Clone, Copy, Debug)]
struct MirrorNode {
    extent: MirrorExtent,
    content: NodeContent,
}

#[derive(Clone, Copy, Debug)]
enum NodeContent {
    /// The child nodes.
    Inner {
        first: u32,
        count: u32,
    },
    SearchCell(SearchCell),
}

/// A part of a face.
#[derive(Clone, Copy, Debug)]
struct SearchCell {
    face: u32,
    rect: IntegrationRect,
    rates: DerivativeBounds,
    depth: u32,
}

/// Parts that show, or may show, an emitter.
#[derive(Debug, Default)]
pub(super) struct ImageCandidates {
    /// Parts small enough for integration, with the number of their face.
    pub(super) cells: Vec<(u32, IntegrationRect)>,
    /// Bound on the projected solid angle, sr, of parts on which the search gave up.
    pub(super) undecided: f64,
}

/// Classification of a part.
enum PartClass {
    /// No ray reflected by the part hits the emitter.
    Dark,
    /// The directions of mirrored rays differ by less than the limit.
    Fine,
    Coarse,
}

impl MirrorTree {
    pub(super) fn over(mirrors: &Mirrors<'_>) -> Self {
        let mut tree = Self::default();
        let mut roots = Vec::with_capacity(mirrors.faces().len());
        for (number, face) in (0..).zip(mirrors.faces()) {
            let Some((placed, map)) = mirrors.surface(face) else { continue };
            // Triangles have other parameters than patches.
            let part = if face.is_square() {
                MirrorPart::of_face(placed.surface(), face.number(), map)
            } else {
                MirrorPart::Estimated
            };
            let at = |uv: DVec2| mirrors.place(face, uv);
            roots.push(tree.face_node(number, &part, IntegrationRect::UNIT, 0, face.is_square(), &at));
        }
        tree.root = tree.group(&mut roots);
        tree
    }

    fn face_node(
        &mut self,
        face: u32,
        part: &MirrorPart,
        rect: IntegrationRect,
        depth: u32,
        is_patch: bool,
        at: &impl Fn(DVec2) -> Option<(DVec3, DVec3)>,
    ) -> MirrorNode {
        let (extent, rates) = part.bounds(&rect, at);
        let cell =
            MirrorNode { extent, content: NodeContent::SearchCell(SearchCell { face, rect, rates, depth }) };
        let is_flat = extent.angle < ALMOST_FLAT;
        if depth == LEVELS || is_flat && !is_patch {
            return cell;
        }
        let parts = part.quarters().into_iter().zip(rect.quarters());
        let quarters: Vec<(MirrorPart, IntegrationRect)> = parts.collect();
        if is_flat {
            let steady = |(part, rect): &(MirrorPart, IntegrationRect)| {
                let (_, here) = part.bounds(rect, at);
                here.points.cmpge(STEADY * rates.points).all()
            };
            if quarters.iter().all(steady) {
                return cell;
            }
        }
        let nodes: Vec<MirrorNode> = quarters
            .iter()
            .map(|(part, rect)| self.face_node(face, part, *rect, depth + 1, is_patch, at))
            .collect();
        MirrorNode { extent, content: self.push(&nodes) }
    }

    fn push(&mut self, nodes: &[MirrorNode]) -> NodeContent {
        let first = self.nodes.len() as u32;
        self.nodes.extend_from_slice(nodes);
        NodeContent::Inner { first, count: nodes.len() as u32 }
    }

    /// Splits the nodes at the middle of the axis along which their centres spread the most.
    fn group(&mut self, nodes: &mut [MirrorNode]) -> Option<MirrorNode> {
        if nodes.len() <= 1 {
            return nodes.first().copied();
        }
        let low = nodes.iter().fold(DVec3::INFINITY, |low, n| low.min(n.extent.center));
        let high = nodes.iter().fold(DVec3::NEG_INFINITY, |high, n| high.max(n.extent.center));
        let size = high - low;
        let axis = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
        nodes.sort_by(|a, b| a.extent.center[axis].total_cmp(&b.extent.center[axis]));
        let (left, right) = nodes.split_at_mut(nodes.len() / 2);
        let halves = [self.group(left)?, self.group(right)?];
        let extent = halves[0].extent.union(&halves[1].extent);
        Some(MirrorNode { extent, content: self.push(&halves) })
    }

    /// The parts in which the emitter may be seen from the receiver.
    pub(super) fn showing(
        &self,
        mirrors: &Mirrors<'_>,
        receiver: &ReceivingPoint,
        emitter: &EmitterShape,
    ) -> ImageCandidates {
        let mut found = ImageCandidates::default();
        let mut open: Vec<MirrorNode> = self.root.into_iter().collect();
        let mut examined = 0_usize;
        while let Some(node) = open.pop() {
            examined += 1;
            let verdict = judge(&node.extent, receiver, emitter);
            if matches!(verdict, PartClass::Dark) {
                continue;
            }
            match node.content {
                NodeContent::Inner { first, count } => {
                    let range = first as usize..(first + count) as usize;
                    open.extend_from_slice(self.nodes.get(range).unwrap_or_default());
                }
                NodeContent::SearchCell(cell) if matches!(verdict, PartClass::Fine) => {
                    found.cells.push((cell.face, cell.rect));
                }
                NodeContent::SearchCell(cell) if cell.depth >= DEEPEST || examined >= BUDGET => {
                    found.undecided += largest_share(&node.extent, receiver);
                }
                NodeContent::SearchCell(cell) => {
                    let Some(face) = mirrors.faces().get(cell.face as usize) else { continue };
                    open.extend(
                        cell.rect.quarters().into_iter().filter_map(|rect| part(mirrors, face, &cell, rect)),
                    );
                }
            }
        }
        found
    }
}

/// A part of a cell, with the derivative bounds of the cell.
fn part(
    mirrors: &Mirrors<'_>,
    face: &MirrorFace,
    cell: &SearchCell,
    rect: IntegrationRect,
) -> Option<MirrorNode> {
    let (center, axis) = mirrors.place(face, rect.center())?;
    let half = 0.5 * rect.size();
    let (radius, angle) = (cell.rates.points.dot(half), cell.rates.normals.dot(half));
    let angle = if angle < FRAC_PI_2 { angle } else { PI };
    let content = NodeContent::SearchCell(SearchCell { rect, depth: cell.depth + 1, ..*cell });
    Some(MirrorNode { extent: MirrorExtent { center, radius, axis, angle }, content })
}

/// Classifies a part by whether rays from the receiver that it reflects can hit the emitter.
///
/// The directions to a ball of radius rho at distance D are within asin(rho / D) of the direction to its centre. Reflection at one normal preserves their angles;
/// normals that differ by an angle a change the reflected directions by 2 a at most, because two reflections are a rotation by twice the angle between the mirrors. And
/// the emitter, within R of its centre at distance E, is seen from all of the ball within asin((rho + R) / E) of one direction.
fn judge(extent: &MirrorExtent, receiver: &ReceivingPoint, emitter: &EmitterShape) -> PartClass {
    let MirrorExtent { center, radius, axis, angle } = *extent;
    let to = center - receiver.point;
    if to.dot(receiver.normal) <= -radius || emitter.is_dark_in(center, radius) {
        return PartClass::Dark;
    }
    let on = emitter.center() - center;
    let (distance, way) = (to.length(), on.length());
    let reach = emitter.outer_radius();
    if distance <= radius || angle >= FRAC_PI_2 || way <= radius {
        return PartClass::Coarse;
    }
    let direction = to / distance;
    let mirrored = direction - 2.0 * direction.dot(axis) * axis;
    let slack = (radius / distance).asin() + 2.0 * angle;
    if way > radius + reach {
        let allowed = slack + ((radius + reach) / way).asin();
        if allowed < PI && mirrored.dot(on) < way * allowed.cos() {
            return PartClass::Dark;
        }
    }
    let smallest = (emitter.inner_radius() / way).min(1.0).asin();
    let spread = slack + (radius / way).asin();
    if spread <= FINENESS * smallest { PartClass::Fine } else { PartClass::Coarse }
}

/// Bound on the projected solid angle of a ball, sr.
fn largest_share(extent: &MirrorExtent, receiver: &ReceivingPoint) -> f64 {
    let squared = extent.center.distance_squared(receiver.point);
    // That of a ball is largest if it is on the normal: pi times the square of the sine of its half angle.
    PI * (extent.radius * extent.radius / squared).min(1.0)
}
