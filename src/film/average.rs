//! Average Fresnel reflectance per wavelength: 2 * integral of R mu dmu over the hemisphere, tabulated at load.

use super::lane_table::{LaneTable, WIDTH};
use super::quadrature::gauss_legendre;
use super::spectral::{Gathered, SpectralFilm};
use super::stack::{Range, Side, Stack};

/// (outside, inside).
#[derive(Clone, Debug, Default)]
pub(super) struct Averages(LaneTable<2>);

impl Averages {
    pub(super) fn new(stack: &Stack, film: &SpectralFilm, range: Range) -> Self {
        Self(LaneTable::new(stack, film, range, |media, depths| {
            let ends = Ends::new(stack, media);
            depths.iter().map(|depths| ends.averages(media, depths)).collect()
        }))
    }

    #[inline]
    pub(super) fn lanes<const N: usize>(&self, side: Side, thickness_nm: f32, nm: &[f32; N]) -> [f32; N] {
        self.0.lanes(thickness_nm, nm).map(|pair| pair[(side == Side::Inside) as usize])
    }
}

/// The media on both sides, and how the average of one follows from the other.
struct Ends {
    /// The rarer medium, whose cosine is the variable of integration: it covers all directions that are transmitted.
    rare: Side,
    /// (n_rare / n_dense)^2 of each lane, at most 1.
    ratio: [f64; WIDTH],
    lossless: bool,
    opaque: bool,
}

impl Ends {
    fn new(stack: &Stack, media: &Gathered<WIDTH>) -> Self {
        let opaque = stack.opaque_base();
        let index = |nm: f32| (stack.outside.at(f64::from(nm)).re, stack.base.at(f64::from(nm)).re);
        let rare = stack.rarer_side();
        let ratio = media.nm().map(|nm| {
            let (outside, base) = index(nm);
            let ratio = if rare == Side::Outside { outside / base } else { base / outside };
            (ratio * ratio).min(1.0)
        });
        Self { rare, ratio, lossless: stack.lossless_layers(), opaque }
    }

    /// (outside, inside) of each lane at thickness / wavelength.
    fn averages(&self, media: &Gathered<WIDTH>, depths: &[f32; WIDTH]) -> [[f32; 2]; WIDTH] {
        let mut rare = [0.0; WIDTH];
        for &(mu, weight) in gauss_legendre() {
            let reflect = media.split_depths(self.rare, mu as f32, depths).reflect;
            rare = std::array::from_fn(|i| rare[i] + 2.0 * weight * mu * f64::from(reflect[i]));
        }
        let dense: [f64; WIDTH] = if self.opaque {
            [1.0; WIDTH]
        } else if self.lossless {
            // What enters one way leaves the other: n_dense^2 (1 - F_dense) = n_rare^2 (1 - F_rare).
            std::array::from_fn(|i| 1.0 - self.ratio[i] * (1.0 - rare[i]))
        } else {
            self.dense(media, depths)
        };
        std::array::from_fn(|i| {
            let (rare, dense) = (rare[i] as f32, dense[i] as f32);
            if self.rare == Side::Outside { [rare, dense] } else { [dense, rare] }
        })
    }

    /// The denser side of absorbing layers: directions that are transmitted, by the conjugate cosine; then total reflection,
    /// by nu with mu^2 = mu_critical^2 - nu^2, in which R is smooth at the critical angle.
    fn dense(&self, media: &Gathered<WIDTH>, depths: &[f32; WIDTH]) -> [f64; WIDTH] {
        let side = if self.rare == Side::Outside { Side::Inside } else { Side::Outside };
        // The angles of a block follow its first lane; its 8 wavelengths have practically one index ratio.
        let (ratio, critical) = (self.ratio[0], 1.0 - self.ratio[0]);
        let mut sum = [0.0; WIDTH];
        for &(t, weight) in gauss_legendre() {
            let below = media.split_depths(side, (1.0 - ratio * (1.0 - t * t)).sqrt() as f32, depths).reflect;
            let beyond = media.split_depths(side, (critical * (1.0 - t * t)).sqrt() as f32, depths).reflect;
            sum = std::array::from_fn(|i| {
                sum[i] + 2.0 * weight * t * (ratio * f64::from(below[i]) + critical * f64::from(beyond[i]))
            });
        }
        sum
    }
}
