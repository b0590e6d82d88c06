//! How far a picture is from another: plain functions of two pictures, in f64.

mod flip;
mod image;
mod perceived;
mod spread;
mod squared;
mod z_test;

pub use flip::flip;
pub use image::Image;
pub use perceived::{Exposure, delta_e_map};
pub use spread::Spread;
pub use squared::{SquaredErrors, squared_errors};
pub use z_test::{MOST_OUTLIERS, ZTest, z_test};
