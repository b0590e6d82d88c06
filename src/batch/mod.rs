//! Jobs: load once, build once, render, save.

pub mod describe;
mod stats;
pub mod still;

pub use stats::Stats;
