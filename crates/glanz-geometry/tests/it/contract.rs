//! The contract of `RaySurface`, checked over every kind of surface with random and adversarial rays.
//!
//! To add a surface: write `tests/it/contract/NAME.rs` with one `#[test]` that passes its cases to
//! [`harness::check_kind`], and add the line `mod NAME;` to the list of kinds below. A [`case::ContractCase`] describes the
//! surface independently of its code: an implicit function, the distance to the border of the kept part and, where they
//! exist, the parameterization and the area.
//!
//! `GLANZ_CONTRACT_RAYS=2000000 cargo test --release -p glanz-geometry --test it contract:: -- --nocapture` traces that
//! many rays per family, five families per kind. Seeds are fixed.

mod case;
mod harness;
mod rays;
mod sampling;
mod solver;

// The kinds, one line each.
mod algebraic;
mod bilinear;
mod flat;
mod freeform;
mod mesh;
mod quadrics;
mod torus;
