//! Film thickness over a surface.

use std::sync::Arc;

use super::surface::Surface;
use super::texture::{Texture, lookup_scalar};
use crate::document::Thickness;
use crate::film::Range;
use crate::math::perlin;

impl Thickness {
    /// Thickness at a surface point, nm; never negative and never NaN.
    pub(super) fn at(&self, surface: &Surface, textures: &[Arc<Texture>]) -> f32 {
        let nm = match self {
            Self::Constant { nm } => *nm,
            Self::Noise { nm, amplitude, frequency, octaves, seed } => {
                let mut p = surface.object_position() * *frequency;
                let (mut sum, mut share) = (0.0, 1.0);
                for octave in 0..*octaves {
                    sum += share * perlin(p, seed.wrapping_add(octave));
                    p *= 2.0;
                    share *= 0.5;
                }
                nm * (1.0 + amplitude * sum)
            }
            Self::Drain { top_nm, bottom_nm, exponent } => {
                let [low, high] = surface.place.height_m;
                let fallen =
                    if high > low { ((high - surface.position.y) / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
                top_nm + (bottom_nm - top_nm) * fallen.powf(*exponent)
            }
            Self::Map { min_nm, max_nm, map } => {
                min_nm + (max_nm - min_nm) * lookup_scalar(textures, map, &surface.uv).clamp(0.0, 1.0)
            }
        };
        // `max` also turns NaN into 0.
        nm.max(0.0)
    }

    /// The thicknesses that a surface of this film can have, nm.
    pub fn range(&self) -> Range {
        let (a, b) = match *self {
            Self::Constant { nm } => (nm, nm),
            Self::Noise { nm, amplitude, octaves, .. } => {
                let reach = amplitude.abs() * (2.0 - 0.5f32.powi(octaves.saturating_sub(1) as i32));
                (nm * (1.0 - reach), nm * (1.0 + reach))
            }
            Self::Drain { top_nm, bottom_nm, .. } => (top_nm, bottom_nm),
            Self::Map { min_nm, max_nm, .. } => (min_nm, max_nm),
        };
        Range { min_nm: f64::from(a.min(b).max(0.0)), max_nm: f64::from(a.max(b).max(0.0)) }
    }

    pub(super) fn varies(&self) -> bool {
        !matches!(self, Self::Constant { .. })
    }
}
