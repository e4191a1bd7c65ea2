//! State of a bake, from which it can be resumed.
//!
//! | bytes | content |
//! |---|---|
//! | 1 | 1 if the light of the given elements is known, 2 or 3 if the elements of the hierarchical solver are, 0 otherwise; plus 4 with direct light, plus 8 with parts, plus 16 while rays of elements are traced |
//! | 8 | if 3: largest error of a link of the solver, which is above its bound for lack of memory |
//! | 4; 12 each | if 1: elements; indirect irradiance of each |
//! | 4; 41, 57, 53 or 69 each | if 2 or 3: elements; surface, face, bits 1 for the back, 2 for a triangle and 4 for light, then four parameters of a rectangle or six of a triangle, and indirect irradiance if there is light |
//! | | if 8: parts, as `BakeParts::write` writes them |
//! | | if 4: direct light, as `write_runs` does |
//! | 4; 12, 4 and 16 each | if 16: elements whose rays are traced; for each the light that does not depend on others, the number of its links, and for each the number of the other element and its factor |
//! | 8; 37 each | points of the final gather: key, irradiance, distance, whether light is visible |
//!
//! Numbers are little-endian, light is red, green and blue.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec2;
use glanz_sampling::hash::combine;

use super::direct_light::{self, DirectRuns, read_runs, write_runs};
use super::gather::{ElementRow, GatheredLight};
use super::part::BakeParts;
use super::receiver::BakeReceiver;
use super::solution::Solution;
use crate::elements::{ParameterPatch, Patch};

/// Keys of the two halves of a fingerprint.
const KEYS: [u64; 2] = [0x7370_6f74, 0x706c_6163];

/// Bits of the kind of a state.
const HAS_DIRECT: u8 = 4;
const HAS_PARTS: u8 = 8;
const HAS_ROWS: u8 = 16;

/// Bytes of light, of a link of an element, of a part, of a point of the final gather, and most bytes of an element of the solver.
const LIGHT: usize = 12;
const LINK: usize = 16;
const PART: usize = 5;
const POINT: usize = 37;
const MAX_ELEMENT: usize = 69;

/// More than all bytes of fixed length, and those that follow a state in a file.
const HEAD: usize = 64;

/// State of an unfinished bake. It is valid for the same scene, elements and settings only, whose identity has to be stored with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakeState {
    /// The parts whose light it has, if it is not that of a whole bake.
    pub parts: Option<BakeParts>,
    /// Direct light, as far as it is known.
    pub(super) direct: DirectRuns,
    /// Rays of the first elements, while those of all are traced.
    pub(super) rows: Option<Vec<Arc<ElementRow>>>,
    /// Indirect irradiance of each element, once it is known.
    pub(super) indirect: Option<Vec<Spectrum>>,
    /// Gathered light by the fingerprint of the receiver.
    pub(super) gathered: HashMap<u128, GatheredLight>,
    /// Elements of the hierarchical solver, once they are known; with their light unless `rows` is known.
    pub(super) solution: Option<Solution>,
    /// Largest error of a link of that solver, if it is above the bound for lack of memory.
    pub(super) coarse_error: Option<f64>,
}

impl BakeState {
    /// Number of points at which light was gathered.
    #[must_use]
    pub fn points(&self) -> usize {
        self.gathered.len()
    }

    /// Number of texels whose direct light is known.
    #[must_use]
    pub fn direct_texels(&self) -> usize {
        self.direct.values().map(|run| run.texels()).sum()
    }

    /// Whether it contains no results but direct light.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_none() && self.indirect.is_none() && self.gathered.is_empty() && self.solution.is_none()
    }

    /// Bytes of the state.
    #[cfg(test)]
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.write(&mut bytes);
        assert!(bytes.len() <= self.max_length());
        bytes
    }

    /// Largest length of the bytes of the state, with a little space.
    fn max_length(&self) -> usize {
        let elements = self.indirect.as_ref().map_or(0, |light| light.len() * LIGHT)
            + self.solution.as_ref().map_or(0, |solution| solution.len() * MAX_ELEMENT);
        let parts = self.parts.as_ref().map_or(0, |parts| parts.finished.len() * PART);
        let rows = self.rows.iter().flatten().map(|row| LINK * (1 + row.links.len())).sum::<usize>();
        HEAD + elements + parts + rows + direct_light::length(&self.direct) + self.gathered.len() * POINT
    }

    /// Appends the bytes of the state; equal states have equal bytes.
    pub fn write(&self, bytes: &mut Vec<u8>) {
        bytes.reserve(self.max_length());
        let kind = match (&self.indirect, &self.solution) {
            (Some(_), _) => 1,
            (None, Some(_)) if self.coarse_error.is_some() => 3,
            (None, Some(_)) => 2,
            (None, None) => 0,
        };
        let direct = if self.direct.is_empty() { 0 } else { HAS_DIRECT };
        let parts = if self.parts.is_some() { HAS_PARTS } else { 0 };
        bytes.push(kind | direct | parts | if self.rows.is_some() { HAS_ROWS } else { 0 });
        if let Some(indirect) = &self.indirect {
            bytes.extend((indirect.len() as u32).to_le_bytes());
            indirect.iter().for_each(|&light| write_light(bytes, light));
        } else if let Some(solution) = &self.solution {
            self.coarse_error.iter().for_each(|error| bytes.extend(error.to_le_bytes()));
            bytes.extend((solution.len() as u32).to_le_bytes());
            solution.iter().for_each(|(patch, light)| write_element(bytes, patch, *light));
        }
        self.parts.iter().for_each(|parts| parts.write(bytes));
        if !self.direct.is_empty() {
            write_runs(bytes, &self.direct);
        }
        self.rows.iter().for_each(|rows| write_rows(bytes, rows));
        let mut places: Vec<(&u128, &GatheredLight)> = self.gathered.iter().collect();
        places.sort_unstable_by_key(|(key, _)| **key);
        bytes.extend((places.len() as u64).to_le_bytes());
        for (key, found) in places {
            bytes.extend(key.to_le_bytes());
            write_light(bytes, found.light);
            bytes.extend(found.distance.to_le_bytes());
            bytes.push(u8::from(found.sees_light));
        }
    }

    /// Reads the bytes of [`BakeState::write`]; `None` if they are no state. Uses at most a few times the memory of `bytes`.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut rest = bytes;
        let (mut indirect, mut solution, mut coarse_error) = (None, None, None);
        let [kind @ 0..32] = read_bytes(&mut rest)? else { return None };
        match kind % HAS_DIRECT {
            0 => {}
            1 => {
                let count = u32::from_le_bytes(read_bytes(&mut rest)?);
                indirect = Some((0..count).map(|_| read_light(&mut rest)).collect::<Option<Vec<_>>>()?);
            }
            solved => {
                if solved == 3 {
                    let error = f64::from_le_bytes(read_bytes(&mut rest)?);
                    coarse_error = Some(error).filter(|error| error.is_finite());
                    coarse_error?;
                }
                let count = u32::from_le_bytes(read_bytes(&mut rest)?);
                solution = Some((0..count).map(|_| read_element(&mut rest)).collect::<Option<Vec<_>>>()?);
            }
        }
        let parts = if kind & HAS_PARTS == 0 { None } else { Some(BakeParts::read(&mut rest)?) };
        let direct = if kind & HAS_DIRECT == 0 { DirectRuns::new() } else { read_runs(&mut rest)? };
        let rows = if kind & HAS_ROWS == 0 { None } else { Some(read_rows(&mut rest)?) };
        let count = u64::from_le_bytes(read_bytes(&mut rest)?);
        if count.checked_mul(POINT as u64) != Some(rest.len() as u64) {
            return None;
        }
        let mut gathered = HashMap::new();
        for _ in 0..count {
            let key = u128::from_le_bytes(read_bytes(&mut rest)?);
            let light = read_light(&mut rest)?;
            let distance = f64::from_le_bytes(read_bytes(&mut rest)?);
            let sees_light = read_bytes::<1>(&mut rest)? != [0];
            if distance.is_nan() {
                return None;
            }
            gathered.insert(key, GatheredLight { light, distance, sees_light });
        }
        Some(Self { parts, direct, rows, indirect, gathered, solution, coarse_error })
    }
}

/// Appends a spectrum as three `f32`.
pub(super) fn write_light(bytes: &mut Vec<u8>, light: Spectrum) {
    light.to_rgb(&Wavelengths::default()).iter().for_each(|value| bytes.extend(value.to_le_bytes()));
}

fn write_rows(bytes: &mut Vec<u8>, rows: &[Arc<ElementRow>]) {
    bytes.extend((rows.len() as u32).to_le_bytes());
    for row in rows {
        write_light(bytes, row.direct);
        bytes.extend((row.links.len() as u32).to_le_bytes());
        for &(other, factor) in &row.links {
            bytes.extend(other.to_le_bytes());
            write_light(bytes, factor);
        }
    }
}

fn read_rows(bytes: &mut &[u8]) -> Option<Vec<Arc<ElementRow>>> {
    let count = u32::from_le_bytes(read_bytes(bytes)?);
    let row = |_| {
        let (direct, count) = (read_light(bytes)?, u32::from_le_bytes(read_bytes(bytes)?));
        let mut link = || Some((u32::from_le_bytes(read_bytes(bytes)?), read_light(bytes)?));
        let links = (0..count).map(|_| link()).collect::<Option<Vec<_>>>()?;
        Some(Arc::new(ElementRow { direct, links }))
    };
    (0..count).map(row).collect()
}

/// Appends the patch of an element with its light.
fn write_element(bytes: &mut Vec<u8>, patch: &Patch, light: Option<Spectrum>) {
    let (is_triangle, corners) = match patch.domain {
        ParameterPatch::Rectangle { min, max } => (false, vec![min, max]),
        ParameterPatch::Triangle(corners) => (true, corners.to_vec()),
    };
    bytes.extend(patch.surface.to_le_bytes());
    bytes.extend(patch.face.to_le_bytes());
    bytes.push(u8::from(patch.back) + 2 * u8::from(is_triangle) + 4 * u8::from(light.is_some()));
    corners.iter().flat_map(|corner| corner.to_array()).for_each(|x| bytes.extend(x.to_le_bytes()));
    light.into_iter().for_each(|light| write_light(bytes, light));
}

/// Reads the patch of an element with its light; `None` unless its parameters are finite.
fn read_element(bytes: &mut &[u8]) -> Option<(Patch, Option<Spectrum>)> {
    let (surface, face) = (u32::from_le_bytes(read_bytes(bytes)?), u32::from_le_bytes(read_bytes(bytes)?));
    let [bits @ 0..8] = read_bytes(bytes)? else { return None };
    let mut corner = || {
        let corner =
            DVec2::new(f64::from_le_bytes(read_bytes(bytes)?), f64::from_le_bytes(read_bytes(bytes)?));
        Some(corner).filter(|corner| corner.is_finite())
    };
    let part = if bits & 2 == 0 {
        ParameterPatch::Rectangle { min: corner()?, max: corner()? }
    } else {
        ParameterPatch::Triangle([corner()?, corner()?, corner()?])
    };
    let light = if bits & 4 == 0 { None } else { Some(read_light(bytes)?) };
    Some((Patch { surface, face, back: bits & 1 == 1, domain: part }, light))
}

/// Reads `N` bytes from the front; `None` if there are fewer.
pub(super) fn read_bytes<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (head, tail) = bytes.split_first_chunk()?;
    *bytes = tail;
    Some(*head)
}

/// Reads a spectrum; `None` unless it is finite.
pub(super) fn read_light(bytes: &mut &[u8]) -> Option<Spectrum> {
    let mut value = || read_bytes(bytes).map(f32::from_le_bytes).filter(|value| value.is_finite());
    Some(Spectrum::from_rgb([value()?, value()?, value()?]))
}

/// Gathered light of an earlier bake, and that added since.
#[derive(Debug, Default)]
pub(super) struct GatherCache {
    before: HashMap<u128, GatheredLight>,
    since: Mutex<Vec<(u128, GatheredLight)>>,
}

impl GatherCache {
    pub(super) fn new(before: HashMap<u128, GatheredLight>) -> Self {
        Self { before, since: Mutex::default() }
    }

    /// Number of points of the earlier bake.
    pub(super) fn resumed(&self) -> usize {
        self.before.len()
    }

    /// Light at receivers: that of the earlier bake, or that which `gather` returns for those that it lacks.
    pub(super) fn get_or_gather(
        &self,
        receivers: &[BakeReceiver],
        gather: impl FnOnce(&[&BakeReceiver]) -> Vec<GatheredLight>,
    ) -> Vec<GatheredLight> {
        let keys: Vec<u128> = receivers.iter().map(fingerprint).collect();
        let is_new = |key: &u128| !self.before.contains_key(key);
        let new: Vec<&BakeReceiver> = receivers
            .iter()
            .zip(&keys)
            .filter(|(_, key)| is_new(key))
            .map(|(receiver, _)| receiver)
            .collect();
        let mut gathered = gather(&new).into_iter();
        let light = |key: &u128| self.before.get(key).copied().or_else(|| gathered.next());
        let found: Vec<GatheredLight> = keys.iter().filter_map(light).collect();
        let since = keys.iter().copied().zip(found.iter().copied()).filter(|(key, _)| is_new(key));
        self.since.lock().unwrap_or_else(PoisonError::into_inner).extend(since);
        found
    }

    pub(super) fn to_map(&self) -> HashMap<u128, GatheredLight> {
        let since = self.since.lock().unwrap_or_else(PoisonError::into_inner);
        self.before.iter().map(|(key, found)| (*key, *found)).chain(since.iter().copied()).collect()
    }
}

/// Hash of everything that the light gathered at a receiver depends on within a scene.
fn fingerprint(receiver: &BakeReceiver) -> u128 {
    let point = &receiver.at.point;
    let vectors = [point.position, point.error, point.normal, receiver.normal, receiver.shading];
    let words = || vectors.iter().flat_map(|vector| vector.to_array()).map(f64::to_bits);
    let [high, low] = KEYS.map(|key| words().fold(key, combine));
    u128::from(high) << 64 | u128::from(low)
}
