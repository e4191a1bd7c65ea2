//! From what elements emit to what they send: B = E + rho F B.

mod gauss_seidel;
pub mod hierarchical;

pub use gauss_seidel::{GaussSeidel, Solved, gauss_seidel};
pub use hierarchical::{Exitance, Hierarchical, hierarchical, hierarchical_with};

#[cfg(test)]
mod tests;
