//! What a bake has found so far, to go on with.
//!
//! | bytes | content |
//! |---|---|
//! | 1 | 1 if elements have found their light by gathering it, 2 if the hierarchical solver has, 0 otherwise |
//! | 4; 12 each | if 1: elements; indirect irradiance of each |
//! | 4; 41, 57, 53 or 69 each | if 2: elements; surface, face, bits 1 for its back, 2 for a triangle and 4 for light, then four parameters of a rectangle or six of a triangle, and indirect irradiance if there is light |
//! | 8; 37 each | places of the final gather: key, irradiance, distance, whether lit surroundings are seen |
//!
//! Numbers are little-endian, light is red, green and blue.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec2;
use glanz_sampling::hash::combine;

use super::Spot;
use super::gather::Gathered;
use super::solution::Solution;
use crate::elements::{Part, Patch};

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
    /// Of the hierarchical solver.
    pub(super) solution: Option<Solution>,
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
        self.indirect.is_none() && self.gathered.is_empty() && self.solution.is_none()
    }

    /// In bytes, the same for the same state.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![match (&self.indirect, &self.solution) {
            (Some(_), _) => 1,
            (None, Some(_)) => 2,
            (None, None) => 0,
        }];
        if let Some(indirect) = &self.indirect {
            bytes.extend((indirect.len() as u32).to_le_bytes());
            indirect.iter().for_each(|&light| put_light(&mut bytes, light));
        } else if let Some(solution) = &self.solution {
            bytes.extend((solution.len() as u32).to_le_bytes());
            solution.iter().for_each(|(patch, light)| put_solved(&mut bytes, patch, *light));
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
        let (mut indirect, mut solution) = (None, None);
        match take::<1>(&mut rest)? {
            [0] => {}
            [1] => {
                let count = u32::from_le_bytes(take(&mut rest)?);
                indirect = Some((0..count).map(|_| take_light(&mut rest)).collect::<Option<Vec<_>>>()?);
            }
            [2] => {
                let count = u32::from_le_bytes(take(&mut rest)?);
                solution = Some((0..count).map(|_| take_solved(&mut rest)).collect::<Option<Vec<_>>>()?);
            }
            _ => return None,
        }
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
        Some(Self { indirect, gathered, solution })
    }
}

/// Appends light.
pub(super) fn put_light(bytes: &mut Vec<u8>, light: Spectrum) {
    light.to_rgb(&Wavelengths::default()).iter().for_each(|value| bytes.extend(value.to_le_bytes()));
}

/// Appends an element with its light.
fn put_solved(bytes: &mut Vec<u8>, patch: &Patch, light: Option<Spectrum>) {
    let (is_triangle, corners) = match patch.part {
        Part::Rectangle { min, max } => (false, vec![min, max]),
        Part::Triangle(corners) => (true, corners.to_vec()),
    };
    bytes.extend(patch.surface.to_le_bytes());
    bytes.extend(patch.face.to_le_bytes());
    bytes.push(u8::from(patch.back) + 2 * u8::from(is_triangle) + 4 * u8::from(light.is_some()));
    corners.iter().flat_map(|corner| corner.to_array()).for_each(|x| bytes.extend(x.to_le_bytes()));
    light.into_iter().for_each(|light| put_light(bytes, light));
}

/// Takes an element with its light, whose parameters are finite.
fn take_solved(bytes: &mut &[u8]) -> Option<(Patch, Option<Spectrum>)> {
    let (surface, face) = (u32::from_le_bytes(take(bytes)?), u32::from_le_bytes(take(bytes)?));
    let [bits @ 0..8] = take(bytes)? else { return None };
    let mut corner = || {
        let corner = DVec2::new(f64::from_le_bytes(take(bytes)?), f64::from_le_bytes(take(bytes)?));
        Some(corner).filter(|corner| corner.is_finite())
    };
    let part = if bits & 2 == 0 {
        Part::Rectangle { min: corner()?, max: corner()? }
    } else {
        Part::Triangle([corner()?, corner()?, corner()?])
    };
    let light = if bits & 4 == 0 { None } else { Some(take_light(bytes)?) };
    Some((Patch { surface, face, back: bits & 1 == 1, part }, light))
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
