//! Cost against size: how time, memory and noise grow with triangles, lights, pixels, depth and lanes.
//!
//! Scenes are made in memory, so that of each only the one thing grows that is charted.

mod report;
mod scenes;
mod series;
mod trial;

pub use report::GrowthChart;
pub use series::{Kind, Reach, Series, Step, step};
pub use trial::{Cost, Machine};
