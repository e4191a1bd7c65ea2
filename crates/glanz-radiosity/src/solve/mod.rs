//! Solvers of the radiosity equation B = E + rho F B.

mod gauss_seidel;
pub mod hierarchical;

pub use gauss_seidel::{GaussSeidelSettings, GaussSeidelSolution, gauss_seidel};
pub use hierarchical::{Exitance, HierarchicalSettings, hierarchical, hierarchical_with_exitance};

#[cfg(test)]
mod tests;
