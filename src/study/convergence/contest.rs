//! The measurement itself.

use std::path::{Path, PathBuf};

use super::external::{SeriesFile, Timed, run_other};
use super::reference::{Mean, Reference};
use super::shot::{Setting, Shot};
use crate::batch::Transport;
use crate::batch::still::StillPlan;
use crate::error::Error;
use crate::study::metrics::{Exposure, Image, Spread, SquaredErrors, delta_e_map, flip, squared_errors};

/// One configuration.
pub struct Contender {
    pub name: String,
    pub how: How,
    /// What it converges to; `None` for pictures from elsewhere.
    pub mean: Option<Mean>,
}

pub enum How {
    /// In this process.
    Own { plan: Box<StillPlan>, transport: Transport, wavelengths: usize },
    /// By another `pellicle`, with these arguments after `render`; samples and seed are added.
    Other { binary: PathBuf, words: Vec<String> },
    /// Rendered before.
    Series(Vec<SeriesFile>),
}

/// One picture: what it cost and how wrong it is.
#[derive(Clone, Debug)]
pub struct Row {
    /// Place of the contender.
    pub contender: usize,
    pub repeat: u32,
    /// 0 where it is not known.
    pub spp: u32,
    pub wall_s: f64,
    /// User + system seconds of all threads.
    pub cpu_s: Option<f64>,
    pub threads: usize,
    /// Against the reference of its own mean: noise.
    pub noise: Option<SquaredErrors>,
    /// Against the spectral reference: noise, and what its colour model gets wrong.
    pub colour: SquaredErrors,
    /// Mean CIEDE2000 and mean FLIP against the spectral reference.
    pub delta_e: f64,
    pub flip: f64,
}

/// What takes part, and what it is measured against.
pub struct Contest<'a> {
    pub setting: Setting<'a>,
    pub contenders: Vec<Contender>,
    /// The reference for colours first, then those of other means.
    pub references: Vec<(Mean, Reference)>,
    pub exposure: Exposure,
    pub spps: Vec<u32>,
    pub repeats: u32,
}

impl Contest<'_> {
    /// Renders every contender at every number of samples, `repeats` times with new seeds. Contenders take turns, in an
    /// order that rotates, so that what disturbs the machine disturbs all alike; only rendering is on the clock. `report`
    /// hears what comes next.
    ///
    /// # Errors
    /// As rendering; what another program says; pictures of another size.
    pub fn run(&self, folder: &Path, report: impl Fn(&str)) -> Result<Vec<Row>, Error> {
        let mut shots = Vec::new();
        for contender in &self.contenders {
            shots.push(match &contender.how {
                How::Own { plan, transport, wavelengths } => {
                    let shot = Shot::new(&self.setting, plan, *transport, *wavelengths)?;
                    // The first render after loading pays for memory that all others find ready.
                    let mut first = plan.clone();
                    first.render.spp = 1;
                    shot.render(&first)?;
                    Some(shot)
                }
                How::Other { .. } | How::Series(_) => None,
            });
        }
        let mut rows = Vec::new();
        for repeat in 0..self.repeats {
            for (step, &spp) in self.spps.iter().enumerate() {
                report(&format!("repeat {} of {}, {spp} spp", repeat + 1, self.repeats));
                let seed = 1 + repeat * self.spps.len() as u32 + step as u32;
                for turn in 0..self.contenders.len() {
                    let contender = (turn + repeat as usize + step) % self.contenders.len();
                    let timed = match (&self.contenders[contender].how, &shots[contender]) {
                        (How::Own { plan, .. }, Some(shot)) => {
                            let mut plan = plan.clone();
                            (plan.render.spp, plan.render.seed) = (spp, seed);
                            let frame = shot.render(&plan)?;
                            let (wall_s, cpu_s) = (frame.render_s, Some(frame.render_cpu_s));
                            Timed { image: Image::from(&frame), spp, wall_s, cpu_s, threads: frame.threads }
                        }
                        (How::Other { binary, words }, _) => {
                            let [spp, seed] = [spp, seed].map(|number| number.to_string());
                            let more = ["--spp".to_owned(), spp, "--seed".to_owned(), seed];
                            run_other(binary, &[words.as_slice(), &more].concat(), folder)?
                        }
                        _ => continue,
                    };
                    rows.push(self.row(contender, repeat, &timed)?);
                }
            }
        }
        for (contender, entry) in self.contenders.iter().enumerate() {
            if let How::Series(files) = &entry.how {
                for file in files {
                    rows.push(self.row(contender, 0, &file.read()?)?);
                }
            }
        }
        Ok(rows)
    }

    fn row(&self, contender: usize, repeat: u32, timed: &Timed) -> Result<Row, Error> {
        let Timed { image, spp, wall_s, cpu_s, threads } = timed;
        let Contender { name, mean, .. } = &self.contenders[contender];
        let reference = |wanted: &Mean| self.references.iter().find(|(mean, _)| mean == wanted).map(|(_, r)| r);
        let Some((_, colour)) = self.references.first() else {
            return Err(Error::Usage("a contest needs a reference".to_owned()));
        };
        if (image.width, image.height) != (colour.image.width, colour.image.height) {
            let sizes =
                format!("{}x{} instead of {}x{}", image.width, image.height, colour.image.width, colour.image.height);
            return Err(Error::Usage(format!("{name}: pictures of {sizes} cannot be compared; give --size")));
        }
        let squared =
            |reference: &Reference| squared_errors(image, &reference.image, reference.image.variance.as_deref());
        let [shown, wanted] = [image, &colour.image].map(|picture| self.exposure.show(picture));
        Ok(Row {
            contender,
            repeat,
            spp: *spp,
            wall_s: *wall_s,
            cpu_s: *cpu_s,
            threads: *threads,
            noise: mean.as_ref().and_then(reference).map(squared),
            colour: squared(colour),
            delta_e: Spread::of(&delta_e_map(&shown, &wanted)).mean,
            flip: Spread::of(&flip(&shown, &wanted)).mean,
        })
    }
}
