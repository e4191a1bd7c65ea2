#![doc = include_str!("../README.md")]

pub mod boundary;
pub mod model;
