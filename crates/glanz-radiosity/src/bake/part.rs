//! Parts of a bake.

use std::collections::BTreeMap;

use glanz_job::JobPart;

use super::state::{BakeState, read_bytes};

/// Strips into which the work of a part is divided, so that all parts get a bit of everything: of walls that are smooth, and of corners
/// that take many points.
const STRIPS: usize = 16;

/// A part of a bake by a final gather, see [`bake_part`](super::bake_part).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakePart {
    /// Its number and the number of all parts.
    pub part: JobPart,
    /// Whether it ends with the direct light.
    pub direct_only: bool,
}

/// Whether piece number `index` of `count` pieces of work, neighbours of which have light in common, is one of `part`; each piece is one of
/// exactly one of the parts, and of the whole, `None`.
pub(super) fn has_piece(part: Option<JobPart>, index: usize, count: usize) -> bool {
    part.is_none_or(|part| {
        let parts = part.count() as usize;
        let strips = count.min(parts.saturating_mul(STRIPS)) as u128;
        let strip = index as u128 * strips / count.max(1) as u128;
        strip % parts as u128 == u128::from(part.number() - 1)
    })
}

/// The parts of a bake whose light a state has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BakeParts {
    /// Number of all parts.
    pub count: u32,
    /// Whether parts end with the direct light.
    pub direct_only: bool,
    /// The parts by their numbers from 1, and whether each is finished.
    pub finished: BTreeMap<u32, bool>,
}

impl BakeParts {
    /// A part alone.
    #[must_use]
    pub fn of(BakePart { part, direct_only }: BakePart, is_finished: bool) -> Self {
        let finished = BTreeMap::from([(part.number(), is_finished)]);
        Self { count: part.count(), direct_only, finished }
    }

    /// Whether these are `part` alone, finished or not.
    #[must_use]
    pub fn is_only(&self, BakePart { part, direct_only }: BakePart) -> bool {
        (self.count, self.direct_only) == (part.count(), direct_only)
            && self.finished.keys().eq([&part.number()])
    }

    /// Parts that are missing or not finished, each with whether it has begun.
    pub fn missing(&self) -> impl Iterator<Item = (JobPart, bool)> {
        let open = |number| match self.finished.get(&number) {
            Some(true) => None,
            begun => Some((JobPart::try_new(number, self.count)?, begun.is_some())),
        };
        (1..=self.count).filter_map(open)
    }

    /// Appends the parts: their number, 4 bytes, whether they end with the direct light, the number of those listed, 4 bytes, and for each
    /// its number, 4 bytes, and whether it is finished.
    pub(super) fn write(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.count.to_le_bytes());
        bytes.push(u8::from(self.direct_only));
        bytes.extend((self.finished.len() as u32).to_le_bytes());
        for (number, is_finished) in &self.finished {
            bytes.extend(number.to_le_bytes());
            bytes.push(u8::from(*is_finished));
        }
    }

    /// Reads the bytes of [`BakeParts::write`] from the front; `None` if they are no parts.
    pub(super) fn read(bytes: &mut &[u8]) -> Option<Self> {
        let count = u32::from_le_bytes(read_bytes(bytes)?);
        let direct_only = read_bytes::<1>(bytes)? != [0];
        let listed = u32::from_le_bytes(read_bytes(bytes)?);
        let mut finished = BTreeMap::new();
        for _ in 0..listed {
            let number = u32::from_le_bytes(read_bytes(bytes)?);
            JobPart::try_new(number, count)?;
            finished.insert(number, read_bytes::<1>(bytes)? != [0]);
        }
        (finished.len() == listed as usize && listed > 0).then_some(Self { count, direct_only, finished })
    }
}

/// Why two states cannot be joined: what both have, or how they differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BakeConflict {
    /// A part, by its number.
    Part(u32),
    /// Parts of another division: another number of parts, or parts that end elsewhere.
    Division,
    /// Light that differs, though scene and settings are the same.
    Light(&'static str),
}

impl BakeState {
    /// Adds the light of other parts of the same bake. Light that both have is the same.
    ///
    /// # Errors
    /// [`BakeConflict`] for a part that both have, for parts of another division, and for light that differs.
    pub fn merge(&mut self, other: Self) -> Result<(), BakeConflict> {
        if let (Some(mine), Some(theirs)) = (&mut self.parts, other.parts) {
            if (mine.count, mine.direct_only) != (theirs.count, theirs.direct_only) {
                return Err(BakeConflict::Division);
            }
            if let Some(&number) = theirs.finished.keys().find(|number| mine.finished.contains_key(number)) {
                return Err(BakeConflict::Part(number));
            }
            mine.finished.extend(theirs.finished);
        }
        for (number, run) in other.direct {
            if self.direct.entry(number).or_insert_with(|| run.clone()) != &run {
                return Err(BakeConflict::Light("direct light"));
            }
        }
        match (&mut self.indirect, other.indirect) {
            (Some(mine), Some(theirs)) if *mine != theirs => {
                return Err(BakeConflict::Light("light between surfaces"));
            }
            (mine @ None, theirs) => *mine = theirs,
            _ => {}
        }
        self.rows = None;
        for (key, light) in other.gathered {
            if *self.gathered.entry(key).or_insert(light) != light {
                return Err(BakeConflict::Light("gathered light"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_is_one_of_exactly_one_part() {
        for parts in [1, 3, 16, 100] {
            let all = || (1..=parts).map(|number| JobPart::try_new(number, parts).unwrap());
            for count in [0, 1, 7, 100, 12_345] {
                let mut lengths = vec![0; parts as usize];
                for index in 0..count {
                    let owners: Vec<JobPart> =
                        all().filter(|&part| has_piece(Some(part), index, count)).collect();
                    assert_eq!(owners.len(), 1, "{index} of {count} in {parts} parts");
                    lengths[owners[0].number() as usize - 1] += 1;
                    assert!(has_piece(None, index, count));
                }
                // Strips differ by a piece at most.
                let (most, least) = (lengths.iter().max().unwrap(), lengths.iter().min().unwrap());
                assert!(most - least <= STRIPS, "{lengths:?}");
            }
        }
    }
}
