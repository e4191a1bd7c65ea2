//! The choice of instructions.

#[cfg(target_arch = "x86_64")]
use super::{Avx2, Avx512, avx};
use super::{Portable, Task};

/// The instruction sets for which there is a copy of the hot code.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Isa {
    /// Instructions that every processor of the target has.
    Portable(Portable),
    /// AVX2 with fused multiply-add and bit manipulation: x86 processors since 2013.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    /// The same with the registers of AVX-512, of which there are twice as many.
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Isa {
    /// The best instruction set that this processor has.
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(token) = Avx512::detect() {
            return Self::Avx512(token);
        } else if let Some(token) = Avx2::detect() {
            return Self::Avx2(token);
        }
        Self::Portable(Portable)
    }

    /// Every instruction set that this processor has, for tests that compare them.
    #[cfg(test)]
    pub(crate) fn all() -> Vec<Self> {
        let mut all = vec![Self::Portable(Portable)];
        #[cfg(target_arch = "x86_64")]
        all.extend(Avx2::detect().map(Self::Avx2));
        #[cfg(target_arch = "x86_64")]
        all.extend(Avx512::detect().map(Self::Avx512));
        all
    }

    /// Runs `task` with these instructions.
    #[inline(always)]
    pub(crate) fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            Self::Portable(scalar) => task.run(scalar),
            // SAFETY: the token proves that the processor has the features that `run_avx2` is compiled for.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(token) => unsafe { avx::run_avx2(token, task) },
            // SAFETY: the token proves that the processor has the features that `run_avx512` is compiled for.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(token) => unsafe { avx::run_avx512(token, task) },
        }
    }
}
