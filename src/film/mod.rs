//! Thin-film optics: Fresnel reflection of bare and coated surfaces, exact and in cheaper rungs, and the ladder that
//! chooses between them by measured error.

mod average;
mod bare;
mod exact;
mod gaussian;
mod grid;
mod kernels;
mod ladder;
mod lane_table;
mod lanes;
mod profile;
mod quadrature;
mod rgb;
mod spectral;
mod stack;
mod table;
mod three_wave;

pub use exact::exact;
pub use ladder::{Rung, Trial, Verdict, choose};
pub use profile::{Profile, RgbProfile, SpectralProfile, TERMS, term_means, terms};
pub use rgb::RgbFilm;
pub use spectral::{SpectralFilm, spectral};
pub use stack::{Layer, Polarised, Range, Side, Split, Stack};
