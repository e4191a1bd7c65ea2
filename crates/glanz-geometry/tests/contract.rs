//! The contract of `RaySurface`, checked over every kind of surface with random and adversarial rays.
//!
//! To add a surface: write `tests/contract/NAME.rs` with one `#[test]` that hands its cases to
//! [`contract::harness::check_kind`], and add the line `mod NAME;` to the list of kinds below. A [`contract::case::Case`]
//! tells what the surface should be, independently of its code: an implicit function, the distance to the border of
//! the kept part and, where they exist, the parametrisation and the area.
//!
//! `GLANZ_CONTRACT_RAYS=2000000 cargo test --release -p glanz-geometry --test contract -- --nocapture` shoots that
//! many rays per family, five families per kind. Seeds are fixed.

// A test may fail by unwrapping and tells its figures; `!(a < b)` holds for NaN, which must be a breach.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::neg_cmp_op_on_partial_ord, unreachable_pub)]

mod contract {
    pub mod case;
    pub mod harness;
    pub mod rays;
    pub mod sampling;
    pub mod solver;

    // The kinds, one line each.
    mod algebraic;
    mod bilinear;
    mod flat;
    mod freeform;
    mod mesh;
    mod quadrics;
    mod torus;
}
