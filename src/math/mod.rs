//! Shading frames, eight vectors at once, warps beside their densities, the sample stream, discrete distributions, Perlin
//! noise.

pub mod distribution;
mod eight;
mod frame;
mod noise;
mod sampler;
mod sobol;
pub mod trigonometry;
pub mod warp;

pub use eight::{Vec3x8, set_bits};
pub use frame::Frame;
use glam::Vec3;
pub use noise::perlin;
pub use sampler::Sampler;

/// The golden ratio's fraction, (sqrt(5) - 1) / 2: its multiples fill an interval evenly, however many there are.
pub const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Bytes in hexadecimal, as hashes are written.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Lowest and highest coordinates of points; (infinity, -infinity) of none.
pub fn extent(points: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}
