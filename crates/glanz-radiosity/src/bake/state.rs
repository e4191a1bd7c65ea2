//! What a bake has found so far, to go on with.
//!
//! | bytes | content |
//! |---|---|
//! | 1 | whether elements have found their light |
//! | 4; 12 each | if so: elements; indirect irradiance of each |
//! | 8; 37 each | places of the final gather: key, irradiance, distance, whether lit surroundings are seen |
//!
//! Numbers are little-endian, light is red, green and blue.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use glanz_light::{Spectrum, Wavelengths};
use glanz_sampling::hash::combine;

use super::Spot;
use super::gather::Gathered;

/// Keys of the two halves of a fingerprint.
const KEYS: [u64; 2] = [0x7370_6f74, 0x706c_6163];

/// Bytes of a place.
const PLACE: usize = 37;

/// What was found in a bake that is not finished. It belongs to the same scene, elements and settings only: whoever keeps it
/// keeps their identity beside it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakeState {
    /// Indirect irradiance of each element, when all have found theirs.
    pub(super) indirect: Option<Vec<Spectrum>>,
    /// What was gathered, by the fingerprint of the spot.
    pub(super) gathered: HashMap<u128, Gathered>,
}

impl BakeState {
    /// Places at which light was gathered.
    #[must_use]
    pub fn places(&self) -> usize {
        self.gathered.len()
    }

    /// Whether nothing was found that would not have to be found again.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.indirect.is_none() && self.gathered.is_empty()
    }

    /// In bytes, the same for the same state.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![u8::from(self.indirect.is_some())];
        if let Some(indirect) = &self.indirect {
            bytes.extend((indirect.len() as u32).to_le_bytes());
            indirect.iter().for_each(|&light| put_light(&mut bytes, light));
        }
        let mut places: Vec<(&u128, &Gathered)> = self.gathered.iter().collect();
        places.sort_unstable_by_key(|(key, _)| **key);
        bytes.extend((places.len() as u64).to_le_bytes());
        for (key, found) in places {
            bytes.extend(key.to_le_bytes());
            put_light(&mut bytes, found.light);
            bytes.extend(found.distance.to_le_bytes());
            bytes.push(u8::from(found.sees_out));
        }
        bytes
    }

    /// Reads what [`BakeState::to_bytes`] wrote; `None` if it did not. Takes no more memory than a few times `bytes`.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut rest = bytes;
        let indirect = match take::<1>(&mut rest)? {
            [0] => None,
            [1] => {
                let count = u32::from_le_bytes(take(&mut rest)?);
                Some((0..count).map(|_| take_light(&mut rest)).collect::<Option<Vec<_>>>()?)
            }
            _ => return None,
        };
        let count = u64::from_le_bytes(take(&mut rest)?);
        if count.checked_mul(PLACE as u64) != Some(rest.len() as u64) {
            return None;
        }
        let mut gathered = HashMap::new();
        for _ in 0..count {
            let key = u128::from_le_bytes(take(&mut rest)?);
            let light = take_light(&mut rest)?;
            let distance = f64::from_le_bytes(take(&mut rest)?);
            let sees_out = take::<1>(&mut rest)? != [0];
            if distance.is_nan() {
                return None;
            }
            gathered.insert(key, Gathered { light, distance, sees_out });
        }
        Some(Self { indirect, gathered })
    }
}

/// Appends light.
pub(super) fn put_light(bytes: &mut Vec<u8>, light: Spectrum) {
    light.to_rgb(&Wavelengths::default()).iter().for_each(|value| bytes.extend(value.to_le_bytes()));
}

/// Takes so many bytes from the front.
pub(super) fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (head, tail) = bytes.split_first_chunk()?;
    *bytes = tail;
    Some(*head)
}

/// Takes light, which is finite.
pub(super) fn take_light(bytes: &mut &[u8]) -> Option<Spectrum> {
    let mut value = || take(bytes).map(f32::from_le_bytes).filter(|value| value.is_finite());
    Some(Spectrum::from_rgb([value()?, value()?, value()?]))
}

/// What was gathered before, and since.
#[derive(Debug, Default)]
pub(super) struct Memory {
    before: HashMap<u128, Gathered>,
    since: Mutex<Vec<(u128, Gathered)>>,
}

impl Memory {
    pub(super) fn new(before: HashMap<u128, Gathered>) -> Self {
        Self { before, since: Mutex::default() }
    }

    /// What was found at a spot before, or what `gather` finds now.
    pub(super) fn recall(&self, spot: &Spot, gather: impl FnOnce() -> Gathered) -> Gathered {
        let key = fingerprint(spot);
        if let Some(found) = self.before.get(&key) {
            return *found;
        }
        let found = gather();
        self.since.lock().unwrap_or_else(PoisonError::into_inner).push((key, found));
        found
    }

    pub(super) fn everything(&self) -> HashMap<u128, Gathered> {
        let since = self.since.lock().unwrap_or_else(PoisonError::into_inner);
        self.before.iter().map(|(key, found)| (*key, *found)).chain(since.iter().copied()).collect()
    }
}

/// Of all that the light gathered at a spot depends on, in one scene.
fn fingerprint(spot: &Spot) -> u128 {
    let point = &spot.at.point;
    let vectors = [point.position, point.error, point.normal, spot.normal, spot.shading];
    let words = || vectors.iter().flat_map(|vector| vector.to_array()).map(f64::to_bits);
    let [high, low] = KEYS.map(|key| words().fold(key, combine));
    u128::from(high) << 64 | u128::from(low)
}
