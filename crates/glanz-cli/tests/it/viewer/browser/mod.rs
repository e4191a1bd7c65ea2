//! The page in Chromium, driven over its DevTools protocol. `cargo xtask test` runs these tests in a separate step.

mod cad;
mod devtools;
mod lux;
mod page;
mod pixels;
mod printed_report;
mod process;
mod surfaces;
mod user;
