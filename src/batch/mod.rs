//! Jobs: load once, build once, render, save.

pub mod checkpoint;
mod choose_mode;
pub mod describe;
pub mod encode;
pub mod frames;
pub mod merge;
pub mod part;
mod stats;
pub mod still;

pub use choose_mode::{Transport, choose_mode};
pub use stats::Stats;
