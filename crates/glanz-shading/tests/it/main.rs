//! Tests of BSDFs through the public interface.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its BSDFs has failed")]

mod contract;
