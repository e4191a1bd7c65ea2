//! Plain arithmetic on arrays, for processors without the instructions of the other tokens.

use super::lanes::{LANES, LaneSimd};
use super::{Lanes8, Simd, Task};

/// Plain arithmetic on arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Portable;

#[inline(always)]
fn mask<const N: usize>(bits: [bool; N]) -> u32 {
    bits.iter().enumerate().fold(0, |m, (i, &b)| m | (u32::from(b) << i))
}

impl Simd for Portable {
    type F32 = [f32; 8];
    type F64 = [f64; 4];

    #[inline(always)]
    fn splat(self, value: f32) -> [f32; 8] {
        [value; 8]
    }
    #[inline(always)]
    fn load(self, lanes: &Lanes8) -> [f32; 8] {
        lanes.0
    }
    #[inline(always)]
    fn store(self, value: [f32; 8]) -> Lanes8 {
        Lanes8(value)
    }
    #[inline(always)]
    fn mul_sub(self, a: [f32; 8], b: [f32; 8], c: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|i| a[i] * b[i] - c[i])
    }
    #[inline(always)]
    fn min(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn max(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn at_most(self, a: [f32; 8], b: [f32; 8]) -> u32 {
        mask::<8>(std::array::from_fn(|i| a[i] <= b[i]))
    }

    #[inline(always)]
    fn splat64(self, value: f64) -> [f64; 4] {
        [value; 4]
    }
    #[inline(always)]
    fn load64(self, lanes: &[f64; 4]) -> [f64; 4] {
        *lanes
    }
    #[inline(always)]
    fn widen(self, lanes: &[f32; 4]) -> [f64; 4] {
        lanes.map(f64::from)
    }
    #[inline(always)]
    fn store64(self, value: [f64; 4]) -> [f64; 4] {
        value
    }
    #[inline(always)]
    fn add64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn sub64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn div64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i] / b[i])
    }
    #[inline(always)]
    fn mul_add64(self, a: [f64; 4], b: [f64; 4], c: [f64; 4]) -> [f64; 4] {
        // Slow where the processor cannot do it in one step, but the same bits everywhere.
        std::array::from_fn(|i| a[i].mul_add(b[i], c[i]))
    }
    #[inline(always)]
    fn transpose64(self, rows: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
        std::array::from_fn(|i| std::array::from_fn(|j| rows[j][i]))
    }
    #[inline(always)]
    fn abs64(self, a: [f64; 4]) -> [f64; 4] {
        a.map(f64::abs)
    }
    #[inline(always)]
    fn copysign64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| a[i].copysign(b[i]))
    }
    #[inline(always)]
    fn narrow(self, a: [f64; 4]) -> [f32; 4] {
        a.map(|x| x as f32)
    }
    #[inline(always)]
    fn min64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn max64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn less64(self, a: [f64; 4], b: [f64; 4]) -> u32 {
        mask::<4>(std::array::from_fn(|i| a[i] < b[i]))
    }
    #[inline(always)]
    fn at_most64(self, a: [f64; 4], b: [f64; 4]) -> u32 {
        mask::<4>(std::array::from_fn(|i| a[i] <= b[i]))
    }

    #[inline(always)]
    fn prefetch<T>(self, _: &T) {}
    #[inline(never)]
    fn outlined<T: Task>(self, task: T) -> T::Output {
        task.run(self)
    }
}

/// Lane by lane.
#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> [f64; LANES] {
    std::array::from_fn(f)
}

/// Moves the lanes in the mask to the front.
#[inline(always)]
fn pack<T: Copy>(mask: u32, lanes: &[T; LANES], out: &mut [T; LANES]) {
    let mut count = 0;
    for (i, &lane) in lanes.iter().enumerate() {
        if let Some(slot) = out.get_mut(count) {
            *slot = lane;
        }
        count += (mask >> i & 1) as usize;
    }
}

impl LaneSimd for Portable {
    type Wide = [f64; LANES];

    #[inline(always)]
    fn splat8(self, value: f64) -> Self::Wide {
        [value; LANES]
    }
    #[inline(always)]
    fn load8(self, lanes: &[f64; LANES]) -> Self::Wide {
        *lanes
    }
    #[inline(always)]
    fn store8(self, value: Self::Wide) -> [f64; LANES] {
        value
    }
    #[inline(always)]
    fn add8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn sub8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn div8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| a[i] / b[i])
    }
    #[inline(always)]
    fn mul_add8(self, a: Self::Wide, b: Self::Wide, c: Self::Wide) -> Self::Wide {
        each(|i| a[i].mul_add(b[i], c[i]))
    }
    #[inline(always)]
    fn sqrt8(self, a: Self::Wide) -> Self::Wide {
        a.map(f64::sqrt)
    }
    #[inline(always)]
    fn abs8(self, a: Self::Wide) -> Self::Wide {
        a.map(f64::abs)
    }
    #[inline(always)]
    fn copysign8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| a[i].copysign(b[i]))
    }
    #[inline(always)]
    fn min8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn max8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn less8(self, a: Self::Wide, b: Self::Wide) -> u32 {
        mask::<LANES>(std::array::from_fn(|i| a[i] < b[i]))
    }
    #[inline(always)]
    fn at_most8(self, a: Self::Wide, b: Self::Wide) -> u32 {
        mask::<LANES>(std::array::from_fn(|i| a[i] <= b[i]))
    }
    #[inline(always)]
    fn select8(self, mask: u32, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| if mask >> i & 1 == 1 { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn compress_ids(self, mask: u32, ids: &[u32; LANES], out: &mut [u32; LANES]) {
        pack(mask, ids, out);
    }
    #[inline(always)]
    fn load7(self, &[a, b, c, d, e, f, g]: &[f64; 7]) -> Self::Wide {
        [a, b, c, d, d, e, f, g]
    }
    #[inline(always)]
    fn narrow_pairs8(self, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        each(|i| {
            let ([a, b, c, d], [e, f, g, h]) = ((a[i] as f32).to_ne_bytes(), (b[i] as f32).to_ne_bytes());
            f64::from_ne_bytes([a, b, c, d, e, f, g, h])
        })
    }
    #[inline(always)]
    fn transpose8(self, rows: [Self::Wide; LANES]) -> [Self::Wide; LANES] {
        std::array::from_fn(|k| each(|i| rows[i][k]))
    }
}
