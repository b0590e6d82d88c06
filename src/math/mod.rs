//! Shading frames, warps beside their densities, the sample stream, discrete distributions, Perlin noise.

pub mod distribution;
mod frame;
mod noise;
mod sampler;
mod sobol;
pub mod warp;

pub use frame::Frame;
pub use noise::perlin;
pub use sampler::Sampler;
