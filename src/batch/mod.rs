//! Jobs: load once, build once, render, save.

mod choose_mode;
pub mod describe;
mod stats;
pub mod still;

pub use choose_mode::{Transport, choose_mode};
pub use stats::Stats;
