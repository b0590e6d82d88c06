//! Ray tracing by Embree 4: with `denoise` the only room with unsafe code.
//!
//! [`AccelBuilder`] takes shapes (triangle meshes, spheres) and places them in the world, directly or as instances that
//! share one BVH; [`AccelBuilder::build`] gives an [`Accel`], which answers [`Accel::intersect`] and
//! [`Accel::occluded`], both for [`BATCH`] rays at once, and [`Accel::every_hit`], from any number of threads. This room knows
//! numbers and vectors only; what a hit means is the caller's business, by [`Hit::place`] and [`Hit::prim`].

#![allow(unsafe_code)]

mod accel;
mod batch;
mod builder;
mod error;
mod every;
mod handle;
mod layout;
mod ray;

pub use accel::Accel;
pub use batch::{BATCH, Hits, Rays};
pub use builder::{AccelBuilder, Shape};
pub use error::EmbreeError;
pub use handle::version;
pub use ray::{Hit, Ray};
