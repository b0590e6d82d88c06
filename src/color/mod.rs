//! Colour and spectra: CIE tables, XYZ <-> linear sRGB, illuminants, measured refractive indices, colour differences,
//! view transforms.

mod emission;
mod index;

pub use emission::Emission;
pub use index::Index;
