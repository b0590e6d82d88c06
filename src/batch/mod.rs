//! Jobs: load once, build once, render, save.

pub mod still;
mod stats;

pub use stats::Stats;
