//! Tests of BSDFs through the public interface.

mod contract;
