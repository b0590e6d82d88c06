//! pellicle: a path tracer for iridescence, light interfering in thin films.

pub mod collada;
pub mod color;
pub mod document;
