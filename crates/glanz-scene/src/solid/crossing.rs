//! Crossings of a line with the boundary of a solid.

use glanz_geometry::Hit;

/// The certainty of a crossing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CrossingKind {
    /// Away from borders: it counts in any case.
    Certain,
    /// Away from borders, but of a surface that runs through the tube of an edge near by, within about its radius: where the line passes between two
    /// faces there, they meet in such a way that it passes back through one of them.
    BesideTube,
    /// In a border, on the kept side.
    Inner,
    /// In a border, on the side that is cut away.
    Outer,
    /// In the tube of an edge: the line may pass between two faces there.
    InTube,
}

impl CrossingKind {
    /// Whether it lies in a border or a tube.
    pub(super) fn is_near_edge(self) -> bool {
        !matches!(self, Self::Certain | Self::BesideTube)
    }

    pub(super) fn is_border(self) -> bool {
        matches!(self, Self::Inner | Self::Outer)
    }
}

/// A crossing of a line with an object that bounds a solid.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundaryCrossing {
    /// Parameter along the line, 0 at the origin of the ray.
    pub(super) t: f64,
    /// Whether the line arrives at the front of the object.
    pub(super) entering: bool,
    /// Whether it may be dropped.
    pub(super) kind: CrossingKind,
    /// In a border or a tube, a distance that is not smaller than the width of the border, or the radius, in units of t.
    pub(super) width: f64,
    /// Cosine of the angle between line and normal, positive.
    pub(super) cos: f64,
    /// Number of the object in its group.
    pub(super) object: u32,
    /// The hit with it.
    pub(super) hit: Hit,
}

impl BoundaryCrossing {
    /// Whether it may be dropped.
    pub(super) fn is_optional(&self) -> bool {
        self.kind != CrossingKind::Certain
    }

    /// Whether its surface, continued straight, runs within twice the radius of a tube in which the line has this contact.
    fn runs_beside(&self, contact: &Self) -> bool {
        contact.kind == CrossingKind::InTube && (self.t - contact.t).abs() * self.cos <= 2.0 * contact.width
    }
}

/// Finds, among crossings in ascending order, those that lie next to one in a tube.
pub(super) fn find_crossings_beside_tubes(crossings: &mut [BoundaryCrossing]) {
    let is_beside = |index: usize, crossing: &BoundaryCrossing| {
        let neighbour = |contact: Option<&BoundaryCrossing>| contact.is_some_and(|c| crossing.runs_beside(c));
        let behind = crossings.get(index + 1..).unwrap_or_default();
        let before = crossings.get(..index).unwrap_or_default();
        neighbour(
            behind.iter().find(|other| other.kind != CrossingKind::InTube || crossing.runs_beside(other)),
        ) || neighbour(
            before.iter().rfind(|other| other.kind != CrossingKind::InTube || crossing.runs_beside(other)),
        )
    };
    let certain = |(index, crossing): &(usize, &BoundaryCrossing)| {
        crossing.kind == CrossingKind::Certain && is_beside(*index, crossing)
    };
    let found: Vec<usize> = crossings.iter().enumerate().filter(certain).map(|(index, _)| index).collect();
    for index in found {
        crossings
            .iter_mut()
            .skip(index)
            .take(1)
            .for_each(|crossing| crossing.kind = CrossingKind::BesideTube);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// `>` enters and `<` leaves away from borders, `i` and `o` enter in the inner and the outer border, `I` and `O` leave there; `t` and `T` do in a
    /// tube, `b` and `B` beside one. All are one apart.
    pub(in crate::solid) fn crossings(text: &str, width: f64) -> Vec<BoundaryCrossing> {
        let crossing = |(index, symbol): (usize, char)| {
            let (entering, kind) = match symbol {
                '>' => (true, CrossingKind::Certain),
                '<' => (false, CrossingKind::Certain),
                other => match other.to_ascii_lowercase() {
                    'i' => (other == 'i', CrossingKind::Inner),
                    'o' => (other == 'o', CrossingKind::Outer),
                    't' => (other == 't', CrossingKind::InTube),
                    'b' => (other == 'b', CrossingKind::BesideTube),
                    _ => panic!("{other}"),
                },
            };
            let hit = Hit::new(index as f64, 0.0, 0.0, 0);
            BoundaryCrossing { t: hit.t, entering, kind, width, cos: 1.0, object: index as u32, hit }
        };
        text.chars().enumerate().map(crossing).collect()
    }

    #[test]
    fn surfaces_through_tubes_run_beside_them() {
        for (text, cos, expected) in [
            (">T>", 0.05, [false, false, true]),
            (">T>", 0.5, [false, false, false]),
            ("<T>", 0.05, [true, false, true]),
            (">IT", 0.05, [false, false, false]),
        ] {
            let mut crossings = crossings(text, 0.05);
            crossings.iter_mut().for_each(|crossing| crossing.cos = cos);
            // Farther away, at the same angle.
            crossings[0].t = if text.starts_with('<') { 0.0 } else { -5.0 };
            find_crossings_beside_tubes(&mut crossings);
            let found = crossings.iter().map(|crossing| crossing.kind == CrossingKind::BesideTube);
            assert!(found.eq(expected), "{text} {cos}: {crossings:?}");
        }
    }
}
