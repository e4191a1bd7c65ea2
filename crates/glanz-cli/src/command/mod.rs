//! One file per command.

pub(crate) mod bake;
mod cad;
pub(crate) mod compare;
pub(crate) mod convert;
pub(crate) mod demo;
mod files;
pub(crate) mod illuminate;
pub(crate) mod info;
pub(crate) mod luminaire;
pub(crate) mod merge;
pub(crate) mod optimize;
pub(crate) mod plan;
pub(crate) mod render;
pub(crate) mod road;
pub(crate) mod shell;
pub(crate) mod turntable;
pub(crate) mod view;
