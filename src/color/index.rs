//! Complex refractive indices n + ik of bases and films.

/// A refractive index as a scene gives it; k >= 0 absorbs.
#[derive(Clone, Debug, PartialEq)]
pub enum Index {
    Constant { n: f32, k: f32 },
    /// One value per colour channel: red, green, blue, taken at 614, 549 and 466 nm.
    Rgb { n: [f32; 3], k: [f32; 3] },
    /// (wavelength in nm, n, k), increasing wavelengths, linear in between.
    Table(Vec<(f32, f32, f32)>),
    /// A material from the measured tables: `Au`, `BK7`, `water`, ...
    Named(String),
}
