//! Sequences and warps, checked from outside.

mod sequence;
mod warps;
