//! Films per wavelength: exact in f32, vectorised over the lanes of a path.

use crate::color::{IndexCurve, MAX_NM, MIN_NM};

use super::average::Averages;
use super::kernels::{self, Beam, Medium, Sheet};
use super::lanes::{at_least, cell};
use super::stack::{Range, Side, Split, Stack};

/// A refractive index for lanes of wavelengths.
#[derive(Clone, Debug)]
enum Curve {
    Constant(f32, f32),
    /// (n, k) at 1 nm, 380..780 nm, linear in between.
    Table(Vec<[f32; 2]>),
}

impl Curve {
    fn new(curve: &IndexCurve) -> Self {
        match curve.as_constant() {
            Some(index) => Self::Constant(index.re as f32, index.im as f32),
            None => {
                let at = |step: usize| curve.at(MIN_NM + step as f64);
                let steps = (MAX_NM - MIN_NM) as usize;
                Self::Table((0..=steps).map(at).map(|index| [index.re as f32, index.im as f32]).collect())
            }
        }
    }

    #[inline(always)]
    fn lanes<const N: usize>(&self, nm: &[f32; N]) -> Medium<N> {
        match self {
            Self::Constant(n, k) => Medium { n: [*n; N], k: [*k; N] },
            Self::Table(rows) => {
                let mut medium = Medium { n: [0.0; N], k: [0.0; N] };
                let cells = nm.map(|nm| cell(nm - MIN_NM as f32, (MAX_NM - MIN_NM) as f32));
                for (i, (low, t)) in cells.into_iter().enumerate() {
                    if let Some([a, b]) = rows.get(low as usize..low as usize + 2) {
                        medium.n[i] = a[0] + t * (b[0] - a[0]);
                        medium.k[i] = a[1] + t * (b[1] - a[1]);
                    }
                }
                medium
            }
        }
    }
}

/// Which form of the optics is the cheapest exact one.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Bare,
    /// One lossless layer; the flag tells whether the base absorbs.
    LosslessFilm {
        metal: bool,
    },
    Layers,
}

/// A stack compiled for lanes of wavelengths. Agrees with `exact` to f32 rounding: 1e-5 typically, 1e-4 within 1 degree of a
/// critical angle or of 89 degrees, 1.3e-3 in the last half degree of grazing.
#[derive(Clone, Debug)]
pub struct SpectralFilm {
    outside: Curve,
    /// Index and thickness in nm.
    layers: Vec<(Curve, f32)>,
    base: Curve,
    varying: Option<usize>,
    weight: f32,
    form: Form,
    averages: Averages,
}

/// Compiles a stack; `range` is that of the varying thickness.
pub fn spectral(stack: &Stack, range: Range) -> SpectralFilm {
    let mut film = SpectralFilm::without_averages(stack);
    film.averages = Averages::new(stack, &film, range.of(stack));
    film
}

impl SpectralFilm {
    /// The optics alone, for the tables that are built from it.
    pub(super) fn without_averages(stack: &Stack) -> Self {
        let layers: Vec<_> =
            stack.layers.iter().map(|layer| (Curve::new(&layer.index), layer.thickness_nm.max(0.0) as f32)).collect();
        let form = match layers.len() {
            0 => Form::Bare,
            1 if stack.lossless_layers() => Form::LosslessFilm { metal: stack.base.max_k() > 0.0 },
            _ => Form::Layers,
        };
        Self {
            outside: Curve::new(&stack.outside),
            layers,
            base: Curve::new(&stack.base),
            varying: stack.varying,
            weight: stack.weight as f32,
            form,
            averages: Averages::default(),
        }
    }

    /// R and T for light from `side` at the cosine `cos_i` (0..1) at N wavelengths in nm (indices hold their end values
    /// outside 380..780). `thickness_nm` is that of the varying layer, ignored when none varies; negative counts as 0.
    #[inline]
    pub fn split<const N: usize>(&self, side: Side, cos_i: f32, thickness_nm: f32, nm: &[f32; N]) -> Split<[f32; N]> {
        let per_nm = nm.map(|nm| 1.0 / nm);
        let ends = [self.outside.lanes(nm), self.base.lanes(nm)];
        let varying = per_nm.map(|per_nm| thickness_nm * per_nm);
        self.evaluate(side, cos_i, &varying, &per_nm, &ends, |layer| self.layers[layer].0.lanes(nm))
    }

    /// 2 * integral of R mu dmu over the hemisphere on `side`, at N wavelengths in nm: the average Fresnel reflectance.
    #[inline]
    pub fn average<const N: usize>(&self, side: Side, thickness_nm: f32, nm: &[f32; N]) -> [f32; N] {
        self.averages.lanes(side, thickness_nm, nm)
    }

    /// The media at N fixed wavelengths, looked up once for many angles and thicknesses.
    pub(super) fn gather<const N: usize>(&self, nm: &[f32; N]) -> Gathered<'_, N> {
        Gathered {
            film: self,
            nm: *nm,
            per_nm: nm.map(|nm| 1.0 / nm),
            ends: [self.outside.lanes(nm), self.base.lanes(nm)],
            layers: self.layers.iter().map(|layer| layer.0.lanes(nm)).collect(),
        }
    }

    /// `varying` is thickness / wavelength of the varying layer; `ends` are the media outside and of the base.
    #[inline(always)]
    fn evaluate<const N: usize>(
        &self,
        side: Side,
        cos_i: f32,
        varying: &[f32; N],
        per_nm: &[f32; N],
        ends: &[Medium<N>; 2],
        layer: impl Fn(usize) -> Medium<N>,
    ) -> Split<[f32; N]> {
        let [outside, base] = ends;
        let (incident, last) = if side == Side::Outside { (outside, base) } else { (base, outside) };
        let beam = Beam::new(incident, cos_i);
        let depth = |j: usize| -> [f32; N] {
            if self.varying == Some(j) {
                varying.map(|depth| at_least(depth, 0.0))
            } else {
                per_nm.map(|per_nm| self.layers[j].1 * per_nm)
            }
        };
        let kept = |reflect: [f32; N]| Split { reflect, transmit: reflect.map(|r| 1.0 - r) };
        let coated = match self.form {
            Form::Bare => return kernels::interface(&beam, last),
            Form::LosslessFilm { metal: true } if side == Side::Outside => {
                kept(kernels::film_on_metal(&beam, &layer(0), &depth(0), last))
            }
            Form::LosslessFilm { .. } => kept(kernels::dielectric_film(&beam, &layer(0), &depth(0), last)),
            Form::Layers => {
                let count = self.layers.len();
                let sheet = |step: usize| {
                    let j = if side == Side::Outside { step } else { count - 1 - step };
                    Sheet { medium: layer(j), depth: depth(j) }
                };
                kernels::layers(&beam, count, sheet, last)
            }
        };
        if self.weight >= 1.0 {
            return coated;
        }
        let bare = kernels::interface(&beam, last);
        let weight = self.weight.max(0.0);
        let mix = |a: [f32; N], b: [f32; N]| std::array::from_fn(|i| b[i] + weight * (a[i] - b[i]));
        Split { reflect: mix(coated.reflect, bare.reflect), transmit: mix(coated.transmit, bare.transmit) }
    }
}

/// See [`SpectralFilm::gather`].
pub(super) struct Gathered<'a, const N: usize> {
    film: &'a SpectralFilm,
    nm: [f32; N],
    per_nm: [f32; N],
    ends: [Medium<N>; 2],
    layers: Vec<Medium<N>>,
}

impl<const N: usize> Gathered<'_, N> {
    pub(super) fn nm(&self) -> &[f32; N] {
        &self.nm
    }

    pub(super) fn split(&self, side: Side, cos_i: f32, thickness_nm: f32) -> Split<[f32; N]> {
        self.split_depths(side, cos_i, &self.per_nm.map(|per_nm| thickness_nm * per_nm))
    }

    /// With the varying layer's thickness / wavelength of each lane.
    pub(super) fn split_depths(&self, side: Side, cos_i: f32, varying: &[f32; N]) -> Split<[f32; N]> {
        self.film.evaluate(side, cos_i, varying, &self.per_nm, &self.ends, |j| self.layers[j])
    }
}
