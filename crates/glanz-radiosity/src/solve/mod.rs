//! From what elements emit to what they send: B = E + rho F B.

mod gauss_seidel;
mod progressive;

pub use gauss_seidel::{GaussSeidel, Solved, gauss_seidel};
pub use progressive::Progressive;

#[cfg(test)]
mod tests;
