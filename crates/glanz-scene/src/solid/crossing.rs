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

    fn is_border(self) -> bool {
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

/// What speaks against a choice of crossings; the first field that differs decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct ParityCost {
    /// Crossings that enter where the line is inside, or leave where it is outside; one more if the line ends inside.
    violations: u32,
    /// Crossings beside tubes that do not count.
    passed: u32,
    /// Crossings in tubes that count: only where the turns lack one.
    between: u32,
    /// Chords and gaps between two borders that are about as short as these are wide: the line passes by, beyond or within rounding of an edge, and what
    /// starts in such a chord in another direction would miss the faces around it.
    slivers: u32,
    /// Crossings in borders that do not count although they might: a chord through the solid is not overlooked.
    dropped: u32,
    /// Crossings that count on the side that their curve cuts away: of two overlapping faces, that within its curves has the true border.
    outer: u32,
}

impl ParityCost {
    fn plus(self, other: Self) -> Self {
        Self {
            violations: self.violations + other.violations,
            passed: self.passed + other.passed,
            between: self.between + other.between,
            slivers: self.slivers + other.slivers,
            dropped: self.dropped + other.dropped,
            outer: self.outer + other.outer,
        }
    }
}

impl BoundaryCrossing {
    fn is_optional(&self) -> bool {
        self.kind != CrossingKind::Certain
    }

    /// The cost if this one counts next after `before`, or first; `None` if it must not.
    fn cost_after(&self, before: Option<&Self>) -> Option<ParityCost> {
        let fits = self.entering != before.is_some_and(|before| before.entering);
        let both = before.filter(|before| before.kind.is_border() && self.kind.is_border());
        // Twice, since at a vertex the borders of three edges meet.
        let is_sliver = both.is_some_and(|before| self.t - before.t <= 2.0 * (before.width + self.width));
        (fits || !self.is_optional()).then(|| ParityCost {
            violations: u32::from(!fits),
            passed: 0,
            between: u32::from(self.kind == CrossingKind::InTube),
            slivers: u32::from(is_sliver),
            dropped: 0,
            outer: u32::from(self.kind == CrossingKind::Outer),
        })
    }

    /// The cost if it does not count.
    fn cost_if_dropped(&self) -> ParityCost {
        ParityCost {
            passed: u32::from(self.kind == CrossingKind::BesideTube),
            dropped: u32::from(self.kind.is_border()),
            ..ParityCost::default()
        }
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

/// The best choice of crossings after one that counts.
#[derive(Clone, Copy, Default)]
struct ParityChoice {
    cost: ParityCost,
    /// How many are dropped before the next that counts.
    dropped: usize,
}

impl ParityChoice {
    /// The best choice among `rest` after `before`, or from the start. `choices`: those after each of the rest, last first.
    fn best(before: Option<&BoundaryCrossing>, rest: &[BoundaryCrossing], choices: &[Self]) -> Self {
        let mut best: Option<Self> = None;
        let mut offer = |choice: Self, replaces_equal: bool| {
            if best.is_none_or(|best| choice.cost < best.cost || replaces_equal && choice.cost == best.cost) {
                best = Some(choice);
            }
        };
        let mut before_next = ParityCost::default();
        for (dropped, (next, after)) in rest.iter().zip(choices.iter().rev()).enumerate() {
            if let Some(cost) = next.cost_after(before) {
                let cost = before_next.plus(cost).plus(after.cost);
                // Of equal ones the line enters at the last and leaves at the first: at a convex edge these lie within the curves.
                offer(Self { cost, dropped }, next.entering);
            }
            if !next.is_optional() {
                return best.unwrap_or_default();
            }
            before_next = before_next.plus(next.cost_if_dropped());
        }
        let violations = u32::from(before.is_some_and(|before| before.entering));
        let dropped = rest.len();
        let none = ParityCost { violations, ..before_next };
        offer(Self { cost: none, dropped }, before.is_none_or(|before| !before.entering));
        best.unwrap_or_default()
    }
}

/// Which of the crossings of a line, in ascending order, count: those that make the line, outside at both ends, enter and leave in turns.
///
/// All certain crossings count. Of the others, the choice is that of the least number of violations of the turns; then that of the most that count
/// beside tubes; then that of the fewest in tubes; then that of the fewest slivers; then that of the most crossings in borders; then that of the fewest
/// beyond their curves.
pub(super) fn accepted_crossings(crossings: &[BoundaryCrossing]) -> Vec<bool> {
    let mut choices: Vec<ParityChoice> = Vec::with_capacity(crossings.len());
    for (index, crossing) in crossings.iter().enumerate().rev() {
        let rest = crossings.get(index + 1..).unwrap_or_default();
        choices.push(ParityChoice::best(Some(crossing), rest, &choices));
    }
    let mut accepted = vec![false; crossings.len()];
    let mut next = ParityChoice::best(None, crossings, &choices).dropped;
    while let Some(counts) = accepted.get_mut(next) {
        *counts = true;
        next += 1 + choices.get(crossings.len() - 1 - next).map_or(0, |choice| choice.dropped);
    }
    accepted
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `>` enters and `<` leaves away from borders, `i` and `o` enter in the inner and the outer border, `I` and `O` leave there; `t` and `T` do in a
    /// tube, `b` and `B` beside one.
    fn crossings(text: &str, width: f64) -> Vec<BoundaryCrossing> {
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

    fn accepted(text: &str, width: f64) -> String {
        let accepted = accepted_crossings(&crossings(text, width));
        text.chars().zip(accepted).map(|(symbol, accepted)| if accepted { symbol } else { '.' }).collect()
    }

    #[test]
    fn crossings_next_to_edges_count_as_the_solid_has_them() {
        for (text, expected) in [
            ("", ""),
            ("><", "><"),
            // Beyond an edge before a face, and behind one.
            ("o><", ".><"),
            ("><O", "><."),
            // Slits: the only border counts.
            ("o<", "o<"),
            (">O", ">O"),
            // A line that passes by.
            ("o", "."),
            ("O", "."),
            ("I", "."),
            // Two overlapping faces: the one within its curves, else that of a convex edge.
            ("oi<", ".i<"),
            ("io<", "i.<"),
            ("oo<", ".o<"),
            ("ii<", ".i<"),
            (">IO", ">I."),
            (">OI", ">.I"),
            (">OO", ">O."),
            // From edge to edge.
            ("iI", "iI"),
            ("oO", "oO"),
            ("ooOO", ".oO."),
            ("oioIOI", ".i.I.."),
            // Two prongs of a fork, and one whose gap lies beside the line.
            ("iIiI", "iIiI"),
            ("iI>I", "iI>I"),
            ("i<o<", "i<o<"),
            (">oO<", ">..<"),
            (">Oo<", ">Oo<"),
            // Between faces: only where one is missing.
            (">T", ">T"),
            ("t<", "t<"),
            (">T<", ">.<"),
            (">TO", ">.O"),
            (">TT", ">T."),
            ("tT", ".."),
            (">TtI", ">..I"),
            (">T>", ">T>"),
            (">T><", ">T><"),
            // A step between faces that meet smoothly: both faces lie on one side of the line, then on the other.
            (">tb<", ">..<"),
            (">tb", ">.."),
            (">BTB", ">B.."),
            (">b<", ">.<"),
            // A tube beside the entry does not explain a missing exit.
            ("tbT", ".bT"),
            ("bB", "bB"),
            // Open shells: what is certain counts.
            (">>", ">>"),
            ("<<", "<<"),
            ("><>", "><>"),
        ] {
            assert_eq!(accepted(text, 0.05), expected, "{text}");
        }
    }

    #[test]
    fn chords_and_gaps_as_short_as_borders_are_wide_do_not_count() {
        // Neighbours are slivers; others are far apart.
        for (text, expected) in [
            ("iI", ".."),
            ("oO", ".."),
            (">Oo<", ">..<"),
            (">Ii<", ">..<"),
            ("i<", "i<"),
            (">I", ">I"),
            ("iIi<", "..i<"),
            // A line along an edge, from border to border.
            ("ooOO", ".o.O"),
            ("oOO", "o.O"),
            ("OoO", "..."),
        ] {
            assert_eq!(accepted(text, 0.3), expected, "{text}");
        }
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

    /// Cost of a choice, by bits, or `None` if it is not allowed.
    fn slow_cost(crossings: &[BoundaryCrossing], choice: u32) -> Option<[u32; 6]> {
        let (mut before, mut cost) = (None::<&BoundaryCrossing>, [0; 6]);
        for (i, crossing) in crossings.iter().enumerate() {
            let (counts, optional) = (choice >> i & 1 != 0, crossing.kind != CrossingKind::Certain);
            if !counts {
                if !optional {
                    return None;
                }
                cost[1] += u32::from(crossing.kind == CrossingKind::BesideTube);
                cost[4] += u32::from(crossing.kind.is_border());
                continue;
            }
            let inside = before.is_some_and(|before| before.entering);
            if crossing.entering == inside {
                cost[0] += 1;
                if optional {
                    return None;
                }
            }
            if let Some(before) = before {
                let is_between_borders = crossing.kind.is_border() && before.kind.is_border();
                cost[3] += u32::from(
                    is_between_borders && crossing.t - before.t <= 2.0 * (before.width + crossing.width),
                );
            }
            cost[2] += u32::from(crossing.kind == CrossingKind::InTube);
            cost[5] += u32::from(crossing.kind == CrossingKind::Outer);
            before = Some(crossing);
        }
        cost[0] += u32::from(before.is_some_and(|before| before.entering));
        Some(cost)
    }

    #[test]
    fn choices_are_the_best_of_all() {
        let symbols = ['>', '<', 'i', 'o', 'I', 'O', 't', 'T', 'b', 'B'];
        let cases =
            (0..=5_u32).flat_map(|length| (0..10_u32.pow(length)).map(move |number| (length, number)));
        for (length, number) in cases {
            let text: String = (0..length).map(|i| symbols[(number / 10_u32.pow(i) % 10) as usize]).collect();
            for width in [0.05, 0.3] {
                let crossings = crossings(&text, width);
                let bit = |(i, &accepted): (usize, &bool)| u32::from(accepted) << i;
                let found: u32 = accepted_crossings(&crossings).iter().enumerate().map(bit).sum();
                let costs: Vec<([u32; 6], u32)> = (0..1 << length)
                    .filter_map(|choice| Some((slow_cost(&crossings, choice)?, choice)))
                    .collect();
                let least = costs.iter().map(|(cost, _)| *cost).min().unwrap();
                let best = costs.iter().filter(|(cost, _)| *cost == least).map(|(_, choice)| *choice);
                // Of equal ones: the first that differs counts if it leaves.
                let expected = best.reduce(|a, b| {
                    let first = (a ^ b).trailing_zeros();
                    let counts = !crossings[first as usize].entering;
                    if (a >> first & 1 != 0) == counts { a } else { b }
                });
                assert_eq!(Some(found), expected, "{text} {width}");
            }
        }
    }
}
