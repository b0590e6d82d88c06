//! RGB reflectances to spectra.
//!
//! Mallett and Yuksel, "Spectral Primary Decomposition for Rendering with sRGB Reflectance", EGSR 2019: three basis
//! spectra that sum to 1, so that the uplift is linear and never creates energy. The table is BSD-3-Clause data of the
//! Colour Developers (colour-science); see the head of `data/mallett_yuksel_2019.csv`.

use std::sync::LazyLock;

use super::cie;
use super::table;

/// The basis at 5 nm, 380..780 nm; the fourth lane is padding.
static BASIS: LazyLock<Vec<[f32; 4]>> = LazyLock::new(|| {
    let rows = table::parse::<3>(include_str!("../../data/mallett_yuksel_2019.csv"));
    let node = |i: usize| table::interpolate(&rows, cie::MIN_NM + STEP_NM * i as f64);
    (0..=INTERVALS).map(node).map(|[r, g, b]| [r as f32, g as f32, b as f32, 0.0]).collect()
});
const STEP_NM: f64 = 5.0;
const INTERVALS: usize = 80;

/// Turns linear sRGB into spectra.
#[derive(Clone, Copy, Debug)]
pub struct Uplift {
    basis: &'static [[f32; 4]],
}

/// The three basis spectra at one path's wavelengths: uplifts any number of colours at three multiplications a lane.
#[derive(Clone, Copy, Debug)]
pub struct UpliftLanes<const N: usize> {
    red: [f32; N],
    green: [f32; N],
    blue: [f32; N],
}

impl Default for Uplift {
    fn default() -> Self {
        Self::new()
    }
}

impl Uplift {
    pub fn new() -> Self {
        Self { basis: &BASIS }
    }

    /// The reflectance spectrum of a linear sRGB colour at wavelengths in nm (end values outside 380..780). Stays in [0, 1]
    /// for channels in [0, 1]; linear, so a light's colour may exceed 1.
    #[inline]
    pub fn uplift<const N: usize>(&self, rgb: [f32; 3], nm: &[f32; N]) -> [f32; N] {
        self.lanes(nm).apply(rgb)
    }

    /// The basis at these wavelengths in nm.
    #[inline]
    pub fn lanes<const N: usize>(&self, nm: &[f32; N]) -> UpliftLanes<N> {
        let mut lanes = UpliftLanes { red: [0.0; N], green: [0.0; N], blue: [0.0; N] };
        for (i, &nm) in nm.iter().enumerate() {
            let x = ((nm - cie::MIN_NM as f32) / STEP_NM as f32).clamp(0.0, INTERVALS as f32);
            let low = (x as usize).min(INTERVALS - 1);
            let t = x - low as f32;
            let (a, b) = (self.basis[low], self.basis[low + 1]);
            lanes.red[i] = a[0] + t * (b[0] - a[0]);
            lanes.green[i] = a[1] + t * (b[1] - a[1]);
            lanes.blue[i] = a[2] + t * (b[2] - a[2]);
        }
        lanes
    }
}

impl<const N: usize> UpliftLanes<N> {
    #[inline]
    pub fn apply(&self, [r, g, b]: [f32; 3]) -> [f32; N] {
        std::array::from_fn(|i| r * self.red[i] + g * self.green[i] + b * self.blue[i])
    }
}
