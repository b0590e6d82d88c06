//! What grows, over which sizes, and how each size is rendered.

use serde::{Deserialize, Serialize};

use super::scenes;
use super::trial::{Cost, Machine, Shots, measure};
use crate::error::Error;
use crate::mode::{Rgb, Spectral};

/// The one thing that grows in a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Triangles,
    Lights,
    Pixels,
    Bounces,
    Lanes,
}

/// How far sizes go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// 10 million triangles, 10 000 lights, 4096 x 4096 pixels, 64 bounces: minutes, and about 2 GB.
    Full,
    /// The small end, with few samples: seconds.
    Quick,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Step {
    /// The colour mode.
    pub mode: String,
    /// Triangles, lights, pixels, bounces, lanes: as many as there are, where that is not what was asked for.
    pub size: u64,
    pub cost: Cost,
}

#[derive(Clone, Debug)]
pub struct Series {
    pub kind: Kind,
    /// By growing size.
    pub steps: Vec<Step>,
}

/// Pixels of small pictures together, over all renders.
const SAMPLES: u64 = 1 << 18;
/// Triangles where these do not grow.
const TRIANGLES: u64 = 10_000;
/// Bounces, as where nobody says otherwise.
const BOUNCES: u32 = 16;

impl Kind {
    pub const ALL: [Self; 5] = [Self::Triangles, Self::Lights, Self::Pixels, Self::Bounces, Self::Lanes];

    /// In tables and on axes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Triangles => "triangles",
            Self::Lights => "lights",
            Self::Pixels => "pixels",
            Self::Bounces => "bounces",
            Self::Lanes => "lanes",
        }
    }

    /// In rising order. Pixels are sides of squares here, and lanes wavelengths; 3 are the channels of RGB.
    pub fn sizes(self, reach: Reach) -> Vec<u64> {
        let up = |first: u64, factor: u64, full: u32, quick: u32| {
            let count = if reach == Reach::Full { full } else { quick };
            (0..count).map(|i| first * factor.pow(i)).collect()
        };
        match self {
            Self::Triangles => up(1000, 10, 5, 3),
            Self::Lights => up(1, 10, 5, 3),
            Self::Pixels => up(64, 2, 7, 3),
            Self::Bounces => up(1, 2, 7, 4),
            Self::Lanes => vec![3, 4, 8, 16],
        }
    }

    /// One of the [`sizes`](Self::sizes), in words.
    pub fn label(self, size: u64) -> String {
        match (self, size) {
            (Self::Lanes, 3) => "RGB".to_owned(),
            (Self::Lanes, _) => format!("{size} wavelengths"),
            (Self::Pixels, _) => format!("{size} x {size} pixels"),
            (Self::Lights | Self::Bounces, 1) => format!("1 {}", self.name().trim_end_matches('s')),
            _ => format!("{size} {}", self.name()),
        }
    }
}

/// Measures one of the sizes of a series: in a process that has done nothing before, lest what that has left behind counts.
///
/// # Errors
/// More memory than there may be; threads that the machine cannot give.
pub fn step(kind: Kind, size: u64, reach: Reach, machine: &Machine) -> Result<Step, Error> {
    let label = kind.label(size);
    let (side, spp, renders) = if reach == Reach::Full { (256, 16, 3) } else { (32, 2, 2) };
    let shots = Shots { side, spp, max_bounces: BOUNCES, renders };
    let surface = |triangles: u64| move || scenes::surface(triangles, scenes::metal());
    let anodised = || scenes::surface(TRIANGLES, scenes::anodised());
    let number = u32::try_from(size).unwrap_or(u32::MAX);
    let (mode, size, cost) = match (kind, size) {
        (Kind::Triangles, _) => {
            ("rgb", scenes::triangles_of(size), measure::<Rgb>(machine, &label, surface(size), &shots)?)
        }
        (Kind::Lights, _) => {
            let shots = Shots { renders: 2 * renders, ..shots };
            ("rgb", size, measure::<Rgb>(machine, &label, || scenes::hall(number), &shots)?)
        }
        (Kind::Pixels, _) => {
            let renders = (SAMPLES / (size * size)).clamp(1, 8) as u32;
            let shots = Shots { side: number, spp: 4, renders, ..shots };
            ("rgb", size * size, measure::<Rgb>(machine, &label, surface(TRIANGLES), &shots)?)
        }
        (Kind::Bounces, _) => {
            let shots = Shots { spp: shots.spp.div_ceil(4), max_bounces: number, ..shots };
            ("rgb", size, measure::<Rgb>(machine, &label, scenes::room, &shots)?)
        }
        (Kind::Lanes, 3) => ("rgb", 3, measure::<Rgb>(machine, &label, anodised, &shots)?),
        (Kind::Lanes, 4) => ("spectral", 4, measure::<Spectral<4>>(machine, &label, anodised, &shots)?),
        (Kind::Lanes, 8) => ("spectral", 8, measure::<Spectral<8>>(machine, &label, anodised, &shots)?),
        (Kind::Lanes, _) => ("spectral", 16, measure::<Spectral<16>>(machine, &label, anodised, &shots)?),
    };
    Ok(Step { mode: mode.to_owned(), size, cost })
}
