//! Differences between the control points of polynomial patches and those that their powers give.

use glanz_math::glam::DVec4;

/// Bytes of the bits that tell which coordinates differ: 16 control points have 48.
const MASK_BYTES: usize = 6;

/// Corrections of restored control points: for each coordinate, how many `f64` lie between the restored value and the given one. Most
/// are zero, and none is lost: neighbouring patches keep common control points to the bit.
#[derive(Clone, Debug, Default)]
pub(super) struct NetCorrections {
    /// Start of those of each patch.
    starts: Vec<usize>,
    /// For each patch a bit for each coordinate that differs, then the differences as zigzag LEB128.
    bytes: Vec<u8>,
}

impl NetCorrections {
    /// Adds those of a patch with the net `exact`, whose powers give the net `rough`.
    pub(super) fn push(&mut self, exact: &[DVec4], rough: &[DVec4]) {
        self.starts.push(self.bytes.len());
        encode(exact, rough, &mut self.bytes);
    }

    /// Adds those of `other`.
    pub(super) fn append(&mut self, other: &Self) {
        let start = self.bytes.len();
        self.starts.extend(other.starts.iter().map(|other| start + other));
        self.bytes.extend_from_slice(&other.bytes);
    }

    /// Reverses the order of the patches.
    pub(super) fn reverse(&mut self) {
        self.starts.reverse();
    }

    /// The control points of the patch of this number, given those of its powers.
    pub(super) fn correct(&self, patch: usize, net: &mut [DVec4]) -> Option<()> {
        let (mask, differences) = self.bytes.get(*self.starts.get(patch)?..)?.split_at_checked(MASK_BYTES)?;
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
