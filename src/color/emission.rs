//! Spectral shapes of light sources.

/// The relative spectral power of a light, as a scene names it. The RGB colour beside it gives tint and strength.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Emission {
    /// Equal energy.
    #[default]
    E,
    D65,
    A,
    /// Planckian radiator at this temperature in kelvin.
    Blackbody(f32),
    /// (wavelength in nm, relative power), increasing wavelengths.
    Table(Vec<(f32, f32)>),
}
