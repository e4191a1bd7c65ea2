//! The choice of the crossings of a line with the boundary of a solid that count.

use super::crossing::{BoundaryCrossing, CrossingKind};

/// What speaks against a choice of crossings; the first field that differs decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct ParityCost {
    /// Crossings that enter where the line is inside, or leave where it is outside; one more if the line ends inside.
    violations: u32,
    /// Gaps between crossings that lie on another side than is known.
    contradictions: u32,
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
            contradictions: self.contradictions + other.contradictions,
            passed: self.passed + other.passed,
            between: self.between + other.between,
            slivers: self.slivers + other.slivers,
            dropped: self.dropped + other.dropped,
            outer: self.outer + other.outer,
        }
    }
}

impl BoundaryCrossing {
    /// The cost if this one counts next after `before`, or first; `None` if it must not.
    fn cost_after(&self, before: Option<&Self>) -> Option<ParityCost> {
        let fits = self.entering != before.is_some_and(|before| before.entering);
        let both = before.filter(|before| before.kind.is_border() && self.kind.is_border());
        // Twice, since at a vertex the borders of three edges meet.
        let is_sliver = both.is_some_and(|before| self.t - before.t <= 2.0 * (before.width + self.width));
        (fits || !self.is_optional()).then(|| ParityCost {
            violations: u32::from(!fits),
            between: u32::from(self.kind == CrossingKind::InTube),
            slivers: u32::from(is_sliver),
            outer: u32::from(self.kind == CrossingKind::Outer),
            ..ParityCost::default()
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
}

/// The crossings of a line, in ascending order, and what is known of the gaps between them.
#[derive(Clone, Copy)]
pub(super) struct LineCrossings<'a> {
    pub(super) crossings: &'a [BoundaryCrossing],
    /// For the gap after each crossing, whether it is inside, if that is known; gaps without an entry are not.
    pub(super) sides: &'a [Option<bool>],
}

/// The best choice of crossings after one that counts.
#[derive(Clone, Copy, Default)]
struct ParityChoice {
    cost: ParityCost,
    /// How many are dropped before the next that counts.
    dropped: usize,
}

impl ParityChoice {
    /// The best choice among the crossings from number `from` on, of which the one before that counts, if there is one. `choices`: those after each
    /// of them, last first.
    fn best(line: LineCrossings, from: usize, choices: &[Self]) -> Self {
        let before = from.checked_sub(1).and_then(|index| line.crossings.get(index));
        let is_inside = before.is_some_and(|before| before.entering);
        let rest = line.crossings.get(from..).unwrap_or_default();
        let contradictions = |gap: Option<usize>| ParityCost {
            contradictions: gap.map_or(0, |gap| u32::from(line.side_after(gap) == Some(!is_inside))),
            ..ParityCost::default()
        };
        let mut best: Option<Self> = None;
        let mut offer = |choice: Self, replaces_equal: bool| {
            if best.is_none_or(|best| choice.cost < best.cost || replaces_equal && choice.cost == best.cost) {
                best = Some(choice);
            }
        };
        let mut before_next = contradictions(from.checked_sub(1));
        for (dropped, (next, after)) in rest.iter().zip(choices.iter().rev()).enumerate() {
            if let Some(cost) = next.cost_after(before) {
                let cost = before_next.plus(cost).plus(after.cost);
                // Of equal ones the line enters at the last and leaves at the first: at a convex edge these lie within the curves.
                offer(Self { cost, dropped }, next.entering);
            }
            if !next.is_optional() {
                return best.unwrap_or_default();
            }
            before_next = before_next.plus(next.cost_if_dropped()).plus(contradictions(Some(from + dropped)));
        }
        let (violations, dropped) = (u32::from(is_inside), rest.len());
        let none = ParityCost { violations, ..before_next };
        offer(Self { cost: none, dropped }, !is_inside);
        best.unwrap_or_default()
    }
}

impl LineCrossings<'_> {
    fn side_after(&self, crossing: usize) -> Option<bool> {
        self.sides.get(crossing).copied().flatten()
    }

    /// Which of the crossings count: those that make the line, outside at both ends, enter and leave in turns.
    ///
    /// All certain crossings count. Of the others, the choice is that of the least number of violations of the turns; then that of the fewest
    /// contradictions to what is known; then that of the most that count beside tubes; then that of the fewest in tubes; then that of the fewest slivers;
    /// then that of the most crossings in borders; then that of the fewest beyond their curves.
    pub(super) fn accepted(&self) -> Vec<bool> {
        let count = self.crossings.len();
        let mut choices: Vec<ParityChoice> = Vec::with_capacity(count);
        for from in (1..=count).rev() {
            choices.push(ParityChoice::best(*self, from, &choices));
        }
        let mut accepted = vec![false; count];
        let mut next = ParityChoice::best(*self, 0, &choices).dropped;
        while let Some(counts) = accepted.get_mut(next) {
            *counts = true;
            next += 1 + choices.get(count - 1 - next).map_or(0, |choice| choice.dropped);
        }
        accepted
    }

    /// The gaps of unknown side, by the crossing before each, that would be on the other side by another choice of as few violations, if one in a border
    /// or a tube on either side of the gap did not count, or did: lines just above a face, from one face beyond its edge to another, are not told from
    /// lines through two slits by their turns. Gaps about as short as borders are wide are slivers; where nothing else is in a chord from border to border,
    /// the longest of them stands for all.
    pub(super) fn doubtful_gaps(&self, accepted: &[bool]) -> Vec<usize> {
        let counts = |index: usize| accepted.get(index).is_some_and(|accepted| *accepted);
        let length = |gap: usize| self.crossings[gap + 1].t - self.crossings[gap].t;
        let is_sliver =
            |gap: usize| length(gap) <= 2.0 * (self.crossings[gap].width + self.crossings[gap + 1].width);
        // Whether the gap is the longest of the slivers from one crossing that counts to the next.
        let stands_for_chord = |gap: usize| {
            let first = (0..=gap).rev().find(|&index| counts(index));
            let Some(chord) = first.zip((gap + 1..self.crossings.len()).find(|&index| counts(index))) else {
                return false;
            };
            let [from, to] = [&self.crossings[chord.0], &self.crossings[chord.1]];
            let is_chord = from.entering && from.kind.is_border() && to.kind.is_border();
            let mut gaps = chord.0..chord.1;
            gaps.len() == 1
                || is_chord && gaps.clone().all(is_sliver) && gaps.all(|other| length(other) <= length(gap))
        };
        let mut doubtful = Vec::new();
        let mut is_inside = false;
        for (index, before) in self.crossings.iter().enumerate().take(self.crossings.len().saturating_sub(1))
        {
            is_inside = if counts(index) { before.entering } else { is_inside };
            if self.side_after(index).is_some() || is_sliver(index) && !stands_for_chord(index) {
                continue;
            }
            // On either side, up to the next that counts, one that does not count would turn the line to the other side, or that one would not.
            let can_turn = |other: usize, entering: bool| {
                let crossing = self.crossings.get(other)?;
                let turns = counts(other) || crossing.is_optional() && crossing.entering == entering;
                turns.then(|| crossing.kind.is_near_edge())
            };
            let before = (0..=index).rev().find_map(|other| can_turn(other, !is_inside));
            let after = (index + 1..self.crossings.len()).find_map(|other| can_turn(other, is_inside));
            if before == Some(true) && after == Some(true) {
                doubtful.push(index);
            }
        }
        doubtful
    }
}

#[cfg(test)]
mod tests {
    use super::super::crossing::tests::crossings;
    use super::*;

    fn accepted(text: &str, width: f64) -> String {
        let accepted = LineCrossings { crossings: &crossings(text, width), sides: &[] }.accepted();
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

    /// Cost of a choice, by bits, or `None` if it is not allowed.
    fn slow_cost(line: LineCrossings, choice: u32) -> Option<[u32; 7]> {
        let crossings = line.crossings;
        let (mut before, mut cost) = (None::<&BoundaryCrossing>, [0; 7]);
        for (i, crossing) in crossings.iter().enumerate() {
            let (counts, optional) = (choice >> i & 1 != 0, crossing.kind != CrossingKind::Certain);
            if !counts {
                if !optional {
                    return None;
                }
                cost[2] += u32::from(crossing.kind == CrossingKind::BesideTube);
                cost[5] += u32::from(crossing.kind.is_border());
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
                cost[4] += u32::from(
                    is_between_borders && crossing.t - before.t <= 2.0 * (before.width + crossing.width),
                );
            }
            cost[3] += u32::from(crossing.kind == CrossingKind::InTube);
            cost[6] += u32::from(crossing.kind == CrossingKind::Outer);
            before = Some(crossing);
        }
        cost[0] += u32::from(before.is_some_and(|before| before.entering));
        for (i, side) in line.sides.iter().enumerate() {
            let last = (0..=i).rev().find(|k| choice >> k & 1 != 0).and_then(|k| crossings.get(k));
            let inside = last.is_some_and(|last| last.entering);
            cost[1] += u32::from(side.is_some_and(|side| side != inside));
        }
        Some(cost)
    }

    #[test]
    fn choices_are_the_best_of_all() {
        let symbols = ['>', '<', 'i', 'o', 'I', 'O', 't', 'T', 'b', 'B'];
        let cases =
            (0..=5_u32).flat_map(|length| (0..10_u32.pow(length)).map(move |number| (length, number)));
        for (length, number) in cases {
            let text: String = (0..length).map(|i| symbols[(number / 10_u32.pow(i) % 10) as usize]).collect();
            let sides: Vec<_> =
                (0..length).map(|i| [None, Some(true), Some(false)][(number / 7 + i) as usize % 3]).collect();
            for (width, sides) in [(0.05, &[][..]), (0.3, &[][..]), (0.05, &sides[..])] {
                let crossings = crossings(&text, width);
                let line = LineCrossings { crossings: &crossings, sides };
                let bit = |(i, &accepted): (usize, &bool)| u32::from(accepted) << i;
                let found: u32 = line.accepted().iter().enumerate().map(bit).sum();
                let costs: Vec<([u32; 7], u32)> =
                    (0..1 << length).filter_map(|choice| Some((slow_cost(line, choice)?, choice))).collect();
                let least = costs.iter().map(|(cost, _)| *cost).min().unwrap();
                let best = costs.iter().filter(|(cost, _)| *cost == least).map(|(_, choice)| *choice);
                // Of equal ones: the first that differs counts if it leaves.
                let expected = best.reduce(|a, b| {
                    let first = (a ^ b).trailing_zeros();
                    let counts = !crossings[first as usize].entering;
                    if (a >> first & 1 != 0) == counts { a } else { b }
                });
                assert_eq!(Some(found), expected, "{text} {width} {sides:?}");
            }
        }
    }

    #[test]
    fn gaps_that_another_choice_would_turn_are_doubtful() {
        for (text, expected) in [
            // From edge to edge: over a face, or through the solid.
            ("iO", &[0][..]),
            ("iT", &[0]),
            ("iTT", &[0, 1]),
            // The only choice.
            ("><", &[]),
            (">T<", &[]),
            (">TT<", &[]),
            ("o<", &[]),
            // The line enters at the one border or at the other.
            ("ii<", &[0]),
            // It leaves and enters again, or does not.
            (">Tt<", &[1]),
        ] {
            let crossings = crossings(text, 0.05);
            let line = LineCrossings { crossings: &crossings, sides: &[] };
            assert_eq!(line.doubtful_gaps(&line.accepted()), expected, "{text}");
            let sides = vec![Some(true); crossings.len()];
            let line = LineCrossings { sides: &sides, ..line };
            assert!(line.doubtful_gaps(&line.accepted()).is_empty(), "{text}");
        }
    }

    #[test]
    fn chord_of_slivers_is_doubtful_once() {
        // From border to border, with a crossing in a tube between that does not count.
        let mut crossings = crossings("oTO", 0.3);
        crossings[1].t = crossings[0].t + 0.9;
        let line = LineCrossings { crossings: &crossings, sides: &[] };
        assert_eq!(line.accepted(), [true, false, true]);
        assert_eq!(line.doubtful_gaps(&line.accepted()), [1]);
    }

    #[test]
    fn known_sides_decide_between_choices_of_as_few_violations() {
        let (inside, outside) = (Some(true), Some(false));
        for (text, sides, expected) in [
            ("iT", [inside, None, None, None], "iT"),
            ("iO", [outside, None, None, None], ".."),
            ("iIi<", [inside, None, None, None], "iIi<"),
            ("ii<", [inside, None, None, None], "i.<"),
            (">Tt<", [None, outside, None, None], ">Tt<"),
            // Certain crossings count whatever seems to be known.
            ("><", [outside, None, None, None], "><"),
        ] {
            let accepted = LineCrossings { crossings: &crossings(text, 0.05), sides: &sides }.accepted();
            let found: String =
                text.chars().zip(accepted).map(|(c, counts)| if counts { c } else { '.' }).collect();
            assert_eq!(found, expected, "{text} {sides:?}");
        }
    }
}
