//! Converged pictures, with an estimate of how converged they are.

use std::fs;
use std::path::PathBuf;

use sha2::{Digest, Sha256};

use super::shot::{Setting, Shot};
use crate::batch::Transport;
use crate::batch::aov::VARIANCE;
use crate::batch::still::StillPlan;
use crate::error::Error;
use crate::film::Rung;
use crate::math::hex;
use crate::output::{HeaderValue, Layer, LayerKind, Picture, read_exr, write_exr};
use crate::render::{Filter, Plan};
use crate::study::metrics::{Exposure, Image, Spread, SquaredErrors, delta_e_map, flip, squared_errors};

/// Independent renders that a reference is the mean of; their spread is its error.
const BATCHES: u32 = 8;
/// Seeds of references start here, far from those of what is measured.
const FIRST_SEED: u32 = 0x8000_0000;
/// Wavelengths per path of spectral references.
const WAVELENGTHS: usize = 16;

/// What decides the picture that a configuration converges to; the strategy and the number of wavelengths do not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    pub spectral: bool,
    /// RGB: the rung that is forced, and the tolerance of the ladder.
    pub film: Option<(Option<Rung>, f32)>,
    pub max_bounces: u32,
    pub filter: Filter,
}

impl Mean {
    pub fn of(plan: &StillPlan, transport: Transport) -> Self {
        let spectral = transport == Transport::Spectral;
        let film = (!spectral).then_some((plan.films.rung, plan.films.tolerance));
        Self { spectral, film, max_bounces: plan.render.limits.max_bounces, filter: plan.render.filter }
    }

    /// In a table.
    pub fn label(&self) -> String {
        match self.film {
            None => "spectral".to_owned(),
            Some((None, _)) => "rgb".to_owned(),
            Some((Some(rung), _)) => format!("rgb {rung}"),
        }
    }
}

/// Where references are kept between runs, and what tells them apart besides their [`Mean`].
pub struct Cache {
    pub folder: PathBuf,
    /// The scene's hash, its options, the program's hash.
    pub key: String,
}

/// A picture and its own error.
pub struct Reference {
    pub label: String,
    pub image: Image,
    pub spp: u32,
    /// What its own noise adds to squared errors, in the mean.
    pub squared: Option<SquaredErrors>,
    /// Mean CIEDE2000 and mean FLIP that its noise makes, estimated from its two halves.
    pub seen: Option<[f64; 2]>,
    pub cached: bool,
}

/// Names of the errors in the header of a cached reference.
const SEEN: [&str; 2] = ["pellicle/reference/deltaE", "pellicle/reference/flip"];

impl Reference {
    /// Renders `spp` samples per pixel in batches of different seeds, or takes them from the cache. `base` gives all that
    /// `mean` does not. `exposure` is what [`Self::seen`] is measured at; `None`: the picture's own.
    ///
    /// # Errors
    /// As rendering; a cache that cannot be written.
    pub fn new(
        setting: &Setting,
        base: &StillPlan,
        mean: &Mean,
        spp: u32,
        exposure: Option<Exposure>,
        cache: Option<&Cache>,
    ) -> Result<Self, Error> {
        let path = cache.map(|cache| cache.path(setting, mean, spp, exposure));
        if let Some(picture) = path.as_ref().and_then(|path| read_exr(path).ok()) {
            return Ok(Self { cached: true, ..Self::of_picture(&picture, mean.label(), spp) });
        }
        let reference = Self::rendered(setting, base, mean, spp, exposure)?;
        if let Some(path) = path {
            if let Some(folder) = path.parent() {
                fs::create_dir_all(folder)
                    .map_err(|error| Error::Usage(format!("--cache {}: {error}", folder.display())))?;
            }
            write_exr(&path, &reference.picture(), true)?;
        }
        Ok(reference)
    }

    /// A picture from elsewhere; its errors are known where it carries variances.
    pub fn of_picture(picture: &Picture, label: String, spp: u32) -> Self {
        let image = Image::from(picture);
        let number = |name: &str| {
            picture.header.iter().find(|(key, _)| key == name).and_then(|(_, value)| match value {
                HeaderValue::Float(number) => Some(f64::from(*number)),
                HeaderValue::Int(_) | HeaderValue::Text(_) => None,
            })
        };
        let seen = number(SEEN[0]).zip(number(SEEN[1])).map(|(delta_e, flip)| [delta_e, flip]);
        Self { label, squared: image.variance.is_some().then(|| noise_of(&image)), image, spp, seen, cached: false }
    }

    fn rendered(
        setting: &Setting,
        base: &StillPlan,
        mean: &Mean,
        spp: u32,
        exposure: Option<Exposure>,
    ) -> Result<Self, Error> {
        let mut plan = base.clone();
        plan.films.rung = mean.film.and_then(|(rung, _)| rung);
        plan.render.limits.max_bounces = mean.max_bounces;
        let transport = if mean.spectral { Transport::Spectral } else { Transport::Rgb };
        let shot = Shot::new(setting, &plan, transport, WAVELENGTHS)?;
        let per_batch = spp.div_ceil(BATCHES);
        let (mut sums, mut squares) = (Vec::new(), Vec::new());
        let mut halves = [Vec::new(), Vec::new()];
        for batch in 0..BATCHES {
            let seed = FIRST_SEED + batch;
            plan.render = Plan { spp: per_batch, seed, filter: mean.filter, clamp: None, ..plan.render };
            let frame = shot.render(&plan)?;
            let size = frame.rgb.len();
            let half = &mut halves[(batch % 2) as usize];
            for values in [&mut sums, &mut squares, &mut *half] {
                values.resize(size, [0.0f64; 3]);
            }
            for (i, rgb) in frame.rgb.iter().enumerate() {
                for (c, value) in rgb.map(f64::from).into_iter().enumerate() {
                    sums[i][c] += value;
                    squares[i][c] += value * value;
                    half[i][c] += value;
                }
            }
        }
        let count = f64::from(BATCHES);
        let variance = sums.iter().zip(&squares).map(|(sum, square): (&[f64; 3], &[f64; 3])| {
            // Of the mean of the batches.
            std::array::from_fn(|c| ((square[c] - sum[c] * sum[c] / count) / (count * (count - 1.0))).max(0.0))
        });
        let [width, height] = setting.camera.size.map(|side| side as usize);
        let picture = |sums: &[[f64; 3]], count: f64, variance: Option<Vec<[f64; 3]>>| {
            let rgb = sums.iter().map(|sum| sum.map(|value| value / count)).collect();
            Image { width, height, rgb, variance }
        };
        let image = picture(&sums, count, Some(variance.collect()));
        let exposure = exposure.unwrap_or_else(|| Exposure::of(&image));
        let [one, two] = halves.map(|sums| exposure.show(&picture(&sums, 0.5 * count, None)));
        // Two halves differ by sqrt(4) times as much as their mean differs from the truth.
        let seen = [delta_e_map(&one, &two), flip(&one, &two)].map(|errors| 0.5 * Spread::of(&errors).mean);
        let squared = Some(noise_of(&image));
        Ok(Self { label: mean.label(), image, spp: per_batch * BATCHES, squared, seen: Some(seen), cached: false })
    }

    fn picture(&self) -> Picture {
        let rgba = self.image.rgb.iter().map(|&[r, g, b]| [r as f32, g as f32, b as f32, 1.0]).collect();
        let variance = self.image.variance.iter().flat_map(|variance| {
            VARIANCE.into_iter().enumerate().map(|(c, name)| Layer {
                name: name.to_owned(),
                kind: LayerKind::Float,
                data: variance.iter().map(|value| value[c] as f32).collect(),
            })
        });
        let seen = SEEN.iter().zip(self.seen.iter().flatten());
        let header = seen.map(|(&name, &value)| (name.to_owned(), HeaderValue::Float(value as f32))).collect();
        let [width, height] = [self.image.width, self.image.height].map(|side| side as u32);
        Picture { width, height, crop: None, rgba, layers: variance.collect(), header }
    }
}

/// What a picture's own variance adds to squared errors against it.
fn noise_of(image: &Image) -> SquaredErrors {
    let deviation = image.variance.iter().flatten().map(|variance| variance.map(f64::sqrt));
    let off = image.rgb.iter().zip(deviation).map(|(rgb, d)| std::array::from_fn(|c| rgb[c] + d[c]));
    squared_errors(&Image { rgb: off.collect(), variance: None, ..*image }, image, None)
}

impl Cache {
    fn path(&self, setting: &Setting, mean: &Mean, spp: u32, exposure: Option<Exposure>) -> PathBuf {
        let text = format!("{} {:?} {mean:?} {spp} {exposure:?}", self.key, setting.camera.size);
        let name = hex(&Sha256::digest(text.as_bytes())[..16]);
        self.folder.join(format!("{name}.exr"))
    }
}
