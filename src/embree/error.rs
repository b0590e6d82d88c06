//! What can go wrong between us and Embree.

use thiserror::Error;

#[derive(Clone, Debug, Error, PartialEq)]
pub enum EmbreeError {
    /// The library loaded at run time is not the one whose header the program was built with.
    #[error("built for Embree {built}, but the library found is Embree {found}: rebuild pellicle")]
    Version { built: String, found: String },
    #[error("Embree could not start: {reason}")]
    Start { reason: String },
    /// Embree reported an error; `reason` begins with its code ("out of memory", ...).
    #[error("Embree could not {task}: {reason}")]
    Embree { task: &'static str, reason: String },
    #[error("triangle {triangle} names vertex {vertex}, but there are {vertices}")]
    Index { triangle: usize, vertex: u32, vertices: usize },
    #[error("a mesh of {count} {what} is too large for Embree (2^32 - 1)")]
    TooLarge { count: usize, what: &'static str },
    #[error("a sphere needs a finite centre and a positive finite radius, not {radius}")]
    Sphere { radius: f32 },
    #[error("placement {place} has a transform that is not finite or cannot be inverted")]
    Transform { place: u32 },
    #[error("placement {place} is not an instance")]
    NotAnInstance { place: u32 },
    #[error("this shape belongs to another builder")]
    ForeignShape,
}
