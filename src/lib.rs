//! pellicle: a path tracer for iridescence, light interfering in thin films.

pub mod color;
pub mod document;
pub mod film;
