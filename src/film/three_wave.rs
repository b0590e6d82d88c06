//! One wavelength per colour channel: the model of the 2020 report, kept so that its error can be shown.

use crate::color::CHANNEL_NM;

use super::spectral::{SpectralFilm, spectral};
use super::stack::{Range, Side, Split, Stack};

/// Exact optics at 614, 549 and 466 nm, taken as red, green and blue. The fourth lane is idle.
#[derive(Clone, Debug)]
pub(super) struct ThreeWave {
    film: SpectralFilm,
}

const NM: [f32; 4] = [CHANNEL_NM[0] as f32, CHANNEL_NM[1] as f32, CHANNEL_NM[2] as f32, CHANNEL_NM[2] as f32];

impl ThreeWave {
    pub(super) fn new(stack: &Stack, range: Range) -> Self {
        Self { film: spectral(stack, range) }
    }

    /// Never inlined: its many registers would be saved for every look-up in a table, too.
    #[inline(never)]
    pub(super) fn split(&self, side: Side, cos_i: f32, thickness_nm: f32) -> Split<[f32; 3]> {
        let split = self.film.split(side, cos_i, thickness_nm, &NM);
        Split { reflect: channels(split.reflect), transmit: channels(split.transmit) }
    }

    #[inline]
    pub(super) fn average(&self, side: Side, thickness_nm: f32) -> [f32; 3] {
        channels(self.film.average(side, thickness_nm, &NM))
    }
}

fn channels([r, g, b, _]: [f32; 4]) -> [f32; 3] {
    [r, g, b]
}
