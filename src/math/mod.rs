//! Shading frames, warps beside their densities, the sample stream, discrete distributions, Perlin noise.

pub mod distribution;
mod frame;
mod noise;
mod sampler;
pub mod warp;

pub use frame::Frame;
pub use noise::perlin;
pub use sampler::Sampler;

/// True when all components are numbers.
pub fn all_finite(values: &[f32]) -> bool {
    values.iter().all(|value| value.is_finite())
}
