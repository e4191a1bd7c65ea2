//! Lists of vectors, stored in `f32` where that loses nothing.

use glanz_math::glam::{Vec2, Vec3};
use glanz_math::{DVec2, DVec3};

use crate::bvh::{PARALLEL_CHUNK, parallel_map};

/// A vector of which lists are made.
pub(super) trait ListVector: Copy + PartialEq + Send + Sync {
    /// The same in `f32`.
    type Single: Copy + Send;
    /// The nearest vector in `f32`.
    fn to_single(self) -> Self::Single;
    /// The vector of these numbers.
    fn from_single(single: Self::Single) -> Self;
}

impl ListVector for DVec3 {
    type Single = Vec3;
    fn to_single(self) -> Vec3 {
        self.as_vec3()
    }
    fn from_single(single: Vec3) -> Self {
        single.as_dvec3()
    }
}

impl ListVector for DVec2 {
    type Single = Vec2;
    fn to_single(self) -> Vec2 {
        self.as_vec2()
    }
    fn from_single(single: Vec2) -> Self {
        single.as_dvec2()
    }
}

/// A list of vectors whose values are those that it was made of.
#[derive(Clone, Debug)]
pub(super) enum VectorList<V: ListVector> {
    /// Every coordinate is an `f32`: half the memory.
    Single(Vec<V::Single>),
    /// Some are not.
    Double(Vec<V>),
}

impl<V: ListVector> VectorList<V> {
    /// The list of these vectors, none of which contains NaN.
    pub(super) fn new(vectors: Vec<V>) -> Self {
        if vectors.iter().all(|&v| V::from_single(v.to_single()) == v) {
            Self::Single(parallel_map(&vectors, PARALLEL_CHUNK, |v| v.to_single()))
        } else {
            Self::Double(vectors)
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Single(list) => list.len(),
            Self::Double(list) => list.len(),
        }
    }

    #[inline]
    pub(super) fn get(&self, index: u32) -> Option<V> {
        match self {
            Self::Single(list) => list.get(index as usize).copied().map(V::from_single),
            Self::Double(list) => list.get(index as usize).copied(),
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = V> + '_ {
        (0..self.len() as u32).filter_map(|index| self.get(index))
    }

    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Single(list) => size_of_val(&**list),
            Self::Double(list) => size_of_val(&**list),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_keep_every_bit_and_are_short_where_f32_suffices() {
        let single = [[0.5, -0.0], [f64::from(f32::MAX), f64::from(f32::MIN_POSITIVE)]].map(DVec2::from);
        let double = [[0.5, 0.1], [1e300, 1e-300]].map(DVec2::from);
        for (vectors, bytes) in [(single, 16), (double, 32)] {
            let list = VectorList::new(vectors.to_vec());
            assert_eq!(list.bytes(), bytes);
            let bits = |v: DVec2| v.to_array().map(f64::to_bits);
            assert!(list.iter().map(bits).eq(vectors.map(bits)));
            assert!(list.get(2).is_none());
        }
    }
}
