//! BSDFs, checked from outside.

mod contract;
