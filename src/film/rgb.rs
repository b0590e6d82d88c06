//! A film compiled for RGB transport.

use super::bare::Bare;
use super::gaussian::Gaussian;
use super::ladder::Rung;
use super::stack::{Side, Split};
use super::table::Table;
use super::three_wave::ThreeWave;

/// R and T of a coated or bare surface as linear sRGB under the sensor's white, unclamped: saturated reflectances have
/// channels below 0 or above 1.
#[derive(Clone, Debug)]
pub struct RgbFilm(pub(super) Form);

#[derive(Clone, Debug)]
pub(super) enum Form {
    Bare(Bare),
    Table(Table),
    ThreeWave(Box<ThreeWave>),
    Gaussian(Box<Gaussian>),
}

impl RgbFilm {
    /// R and T for light from `side` at the cosine `cos_i` (0..1, in the medium that it comes from). `thickness_nm` is that
    /// of the varying layer, ignored when none varies; it is clamped to the range that the film was built for. Inside an
    /// opaque base everything is reflected: nothing travels there.
    #[inline]
    pub fn split(&self, side: Side, cos_i: f32, thickness_nm: f32) -> Split<[f32; 3]> {
        match &self.0 {
            Form::Bare(bare) => bare.split(side, cos_i),
            Form::Table(table) => table.split(side, cos_i, thickness_nm),
            Form::ThreeWave(waves) => waves.split(side, cos_i, thickness_nm),
            Form::Gaussian(gaussian) => gaussian.split(side, cos_i, thickness_nm),
        }
    }

    /// The average Fresnel reflectance on `side`, 2 * integral of R mu dmu, for multiple scattering.
    #[inline]
    pub fn average(&self, side: Side, thickness_nm: f32) -> [f32; 3] {
        match &self.0 {
            Form::Bare(bare) => bare.average(side),
            Form::Table(table) => table.average(side, thickness_nm),
            Form::ThreeWave(waves) => waves.average(side, thickness_nm),
            Form::Gaussian(gaussian) => gaussian.average(side, thickness_nm),
        }
    }

    /// Which rung this is.
    pub fn rung(&self) -> Rung {
        match &self.0 {
            Form::Bare(_) => Rung::Bare,
            Form::Table(_) => Rung::Table,
            Form::ThreeWave(_) => Rung::ThreeWave,
            Form::Gaussian(_) => Rung::Gaussian,
        }
    }
}
