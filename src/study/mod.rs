//! What can be learned besides pictures. Thin films on their own, without a scene to render: what a stack reflects and
//! transmits, as numbers, swatches and plots. And where the time of a batch went (`report`).
//!
//! Wavelengths and thicknesses are in nm, angles in degrees from the normal in the medium that the light comes from.

mod canvas;
mod coating;
mod colours;
mod comparison;
pub mod convergence;
mod decades;
mod error;
mod error_map;
mod exponent;
mod film_chart;
mod film_cost;
pub mod growth;
mod lettering;
mod listing;
mod log_chart;
mod medium;
pub mod metrics;
mod number;
mod plot;
mod preset_sheet;
pub mod report;
mod spectra;
mod swatch;

pub use coating::Coating;
pub use colours::{colour_csv, colour_rows};
pub use comparison::Comparison;
pub use error::StudyError;
pub use error_map::{error_map, scale_of};
pub use film_chart::{FilmChart, typical_coatings};
pub use film_cost::{FilmCost, film_costs};
pub use listing::{list_indices, list_presets};
pub use medium::Medium;
pub use plot::{MOST_CURVES, PLOT_SIZE, plot};
pub use preset_sheet::preset_sheet;
pub use spectra::spectra_csv;
pub use swatch::{SWATCH_SIZE, SwatchPlan, swatch};
