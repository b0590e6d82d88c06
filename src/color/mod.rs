//! Colour and spectra: CIE tables, XYZ <-> linear sRGB, illuminants, measured refractive indices, colour differences,
//! view transforms.

mod cie;
mod difference;
mod emission;
mod gamut;
mod index;
mod named;
mod sensor;
mod table;
mod uplift;
pub mod view;

pub use cie::{MAX_NM, MIN_NM};
pub use difference::{Lab, delta_e_2000};
pub use emission::{Emission, Spectrum};
pub use index::{CHANNEL_NM, Index, IndexCurve, IndexError, NOMINAL_NM};
pub use named::{Kind, kind_of_index, known_index_names, source_of_index};
pub use sensor::Sensor;
pub use uplift::{Uplift, UpliftLanes};
