//! Differences between the control points of polynomial patches and those that their powers give.

use glanz_math::glam::DVec4;

use super::SurfacePatch;
use super::bicubic::Bicubic;
use crate::bvh::parallel_map;

/// Patches that one thread compares at once.
const CHUNK: usize = 4096;

/// Bytes of the bits that tell which coordinates differ: 16 control points have 48.
const MASK_BYTES: usize = 6;

/// Corrections of restored control points: for each coordinate, how many `f64` lie between the restored value and the given one. Most
/// are zero, and none is lost: neighbouring patches keep common control points to the bit.
#[derive(Clone, Debug)]
pub(super) struct NetCorrections {
    /// Start of those of each patch.
    starts: Vec<u32>,
    /// For each patch a bit for each coordinate that differs, then the differences as zigzag LEB128.
    bytes: Vec<u8>,
}

impl NetCorrections {
    /// Those of `patches` with these powers; `None` if they are too many.
    pub(super) fn new(patches: &[SurfacePatch], powers: &[Bicubic<3>]) -> Option<Self> {
        let chunks: Vec<_> = patches.chunks(CHUNK).zip(powers.chunks(CHUNK)).collect();
        let parts = parallel_map(&chunks, 1, |(patches, powers)| {
            let (mut lengths, mut bytes) = (Vec::with_capacity(patches.len()), Vec::new());
            for (patch, powers) in patches.iter().zip(*powers) {
                let (start, degrees) = (bytes.len(), patch.patch.degrees());
                encode(patch.patch.control_points(), &powers.control_points(degrees), &mut bytes);
                lengths.push((bytes.len() - start) as u32);
            }
            (lengths, bytes)
        });
        let mut all = Self {
            starts: Vec::with_capacity(patches.len()),
            bytes: Vec::with_capacity(parts.iter().map(|(_, bytes)| bytes.len()).sum()),
        };
        let mut start = 0_u32;
        for (lengths, bytes) in parts {
            all.bytes.extend(bytes);
            for length in lengths {
                all.starts.push(start);
                start = start.checked_add(length)?;
            }
        }
        Some(all)
    }

    /// The control points of the patch of this number, given those of its powers.
    pub(super) fn correct(&self, patch: usize, net: &mut [DVec4]) -> Option<()> {
        let (mask, differences) =
            self.bytes.get(*self.starts.get(patch)? as usize..)?.split_at_checked(MASK_BYTES)?;
        let mask = mask.iter().rev().fold(0_u64, |mask, &byte| mask << 8 | u64::from(byte));
        let mut bytes = differences.iter();
        for (i, point) in net.iter_mut().enumerate() {
            for k in 0..3 {
                if mask >> (3 * i + k) & 1 != 0 {
                    point[k] = from_rank(rank(point[k]).wrapping_add(decode(&mut bytes)?));
                }
            }
        }
        Some(())
    }

    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.bytes)
    }
}

/// The position of a number in the order of all of them, in which -0 precedes 0.
fn rank(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    bits ^ (((bits >> 63) as u64) >> 1) as i64
}

fn from_rank(rank: i64) -> f64 {
    f64::from_bits((rank ^ (((rank >> 63) as u64) >> 1) as i64) as u64)
}

/// Appends the corrections of the net `rough` that make it `exact`.
fn encode(exact: &[DVec4], rough: &[DVec4], bytes: &mut Vec<u8>) {
    let (mut mask, start) = (0_u64, bytes.len());
    bytes.extend([0; MASK_BYTES]);
    for (i, (exact, rough)) in exact.iter().zip(rough).enumerate() {
        for k in 0..3 {
            let difference = rank(exact[k]).wrapping_sub(rank(rough[k]));
            if difference != 0 {
                mask |= 1 << (3 * i + k);
                // Zigzag: the sign in the lowest bit, so that small differences of both signs take one byte.
                let mut rest = (difference << 1 ^ difference >> 63) as u64;
                while rest >= 0x80 {
                    bytes.push(rest as u8 | 0x80);
                    rest >>= 7;
                }
                bytes.push(rest as u8);
            }
        }
    }
    for (byte, mask) in bytes.iter_mut().skip(start).zip(mask.to_le_bytes().into_iter().take(MASK_BYTES)) {
        *byte = mask;
    }
}

/// The next difference.
fn decode<'a>(bytes: &mut impl Iterator<Item = &'a u8>) -> Option<i64> {
    let (mut number, mut shift) = (0_u64, 0);
    loop {
        let byte = *bytes.next()?;
        number |= u64::from(byte & 0x7f).checked_shl(shift)?;
        shift += 7;
        if byte < 0x80 {
            return Some((number >> 1) as i64 ^ -((number & 1) as i64));
        }
    }
}
