//! pellicle: a path tracer for iridescence, light interfering in thin films.
//!
//! From `main` to a fringe: `cli` -> `batch::still` -> `render` -> `integrate::radiances` -> `Bsdf::sample` -> `Mode::split` ->
//! `film`. A room knows only the rooms above it in this list:

pub mod math;

pub mod color;

pub mod film;

pub mod document;

pub mod mode;

pub mod bsdf;

pub mod embree;

pub mod denoise;

pub mod scene;

pub mod integrate;

pub mod render;

pub mod mesh;

pub mod collada;

pub mod studio;

pub mod output;

pub mod error;

pub mod batch;

pub mod study;

pub mod cli;
