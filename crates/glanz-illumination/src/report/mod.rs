//! What reports are written with: [`table`]s, drawings in [`svg`], [`lettering`] of pictures. Studies use them too.

pub mod lettering;
pub mod svg;
pub mod table;
