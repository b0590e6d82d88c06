//! Jobs: load once, build once, render, save.

pub mod animate;
pub mod aov;
pub mod budget;
pub mod checkpoint;
mod choose_mode;
pub mod describe;
pub mod encode;
pub mod frames;
pub mod live;
pub mod merge;
pub mod part;
mod quick_look;
pub mod record;
pub mod resume;
mod row;
pub mod sequence;
pub mod shutter;
mod stats;
pub mod still;
mod summary;
mod thumbnail;
pub mod turntable;

pub use choose_mode::{Transport, choose_mode};
pub use row::Row;
pub use stats::Stats;
pub use summary::{Slow, Summary};
pub use thumbnail::Thumbnail;
