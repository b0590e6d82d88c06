//! `pellicle compare`: how far a picture is from another.

use std::path::{Path, PathBuf};

use clap::Args;

use super::print;
use crate::error::Error;
use crate::output::{self, Display, Format, PngDepth, read_exr};
use crate::study::metrics::{Exposure, Image};
use crate::study::{Comparison, error_map, scale_of};

/// Significance of the z-test where none is asked for.
const ALPHA: f64 = 0.01;

/// How far a picture is from a reference: squared errors, colour differences, FLIP, a z-test
///
/// Colour differences and FLIP are those of the pictures as a display shows them: exposed so that the reference's mean
/// luminance is a mid grey of 0.18 (or by --exposure), clipped to 0..1. The z-test needs variance layers in both files
/// (`pellicle render --aov variance`).
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle compare noisy.exr reference.exr
  pellicle compare noisy.exr reference.exr --diff errors.png --json
  pellicle compare today.exr yesterday.exr --alpha 0.01 --max-de 0.5

Exit codes: 0 within all limits (or none given), 1 beyond one, 2 usage (pictures of different sizes, ...),
3 a file that cannot be read or written")]
pub struct CompareArgs {
    /// The picture to judge, EXR
    #[arg(value_name = "A.exr")]
    image: PathBuf,
    /// What it is compared to
    #[arg(value_name = "B.exr")]
    reference: PathBuf,
    /// Draw CIEDE2000 of each pixel in false colours, with a scale, as PNG
    #[arg(long, value_name = "FILE")]
    diff: Option<PathBuf>,
    /// Where the scale of --diff ends [default: the next round number above the worst pixel]
    #[arg(long, value_name = "DE", value_parser = positive, requires = "diff")]
    diff_max: Option<f64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Brightness of colour differences and FLIP in stops, instead of the automatic one
    #[arg(long, value_name = "EV", allow_negative_numbers = true)]
    exposure: Option<f32>,
    /// Limit of the mean squared error
    #[arg(long, value_name = "X", value_parser = positive, help_heading = "Limits")]
    max_mse: Option<f64>,
    /// Limit of the squared error relative to reference^2 + 0.01
    #[arg(long, value_name = "X", value_parser = positive, help_heading = "Limits")]
    max_relmse: Option<f64>,
    /// Limit of the mean CIEDE2000
    #[arg(long, value_name = "X", value_parser = positive, help_heading = "Limits")]
    max_de: Option<f64>,
    /// Limit of the mean FLIP
    #[arg(long, value_name = "X", value_parser = positive, help_heading = "Limits")]
    max_flip: Option<f64>,
    /// The z-test must find no difference at this significance
    #[arg(long, value_name = "P", value_parser = probability, help_heading = "Limits")]
    alpha: Option<f64>,
}

pub fn run(args: &CompareArgs) -> Result<(), Error> {
    if let Some(path) = &args.diff {
        if output::check_picture(path)? != Format::Png {
            return Err(Error::Usage(format!("--diff {}: error maps are written as .png", path.display())));
        }
    }
    let [image, reference] = [&args.image, &args.reference].map(|path| image(path));
    let (image, reference) = (image?, reference?);
    if (image.width, image.height) != (reference.width, reference.height) {
        let size = |path: &Path, image: &Image| format!("{} is {}x{}", path.display(), image.width, image.height);
        let sizes = [size(&args.image, &image), size(&args.reference, &reference)].join(", ");
        return Err(Error::Usage(format!("{sizes}: only pictures of the same size can be compared")));
    }

    let exposure = args.exposure.map_or_else(|| Exposure::of(&reference), Exposure::from_stops);
    let (comparison, delta_e) = Comparison::new(&image, &reference, exposure, args.alpha.unwrap_or(ALPHA));
    if args.json {
        let text = serde_json::to_string_pretty(&comparison).unwrap_or_default();
        print(&format!("{text}\n"))?;
    } else {
        print(&comparison.to_string())?;
    }
    if let Some(path) = &args.diff {
        let top = args.diff_max.unwrap_or_else(|| scale_of(&delta_e));
        output::write_png(path, &error_map(&delta_e, image.width, "CIEDE2000", top), Display::PLAIN, PngDepth::Eight)?;
    }
    args.judge(&comparison)
}

fn image(path: &Path) -> Result<Image, Error> {
    Ok(Image::from(&read_exr(path)?))
}

impl CompareArgs {
    fn judge(&self, comparison: &Comparison) -> Result<(), Error> {
        let mut beyond = Vec::new();
        for (name, value, limit) in [
            ("MSE", comparison.squared.mse, self.max_mse),
            ("relMSE", comparison.squared.rel_mse, self.max_relmse),
            ("mean CIEDE2000", comparison.delta_e.mean, self.max_de),
            ("mean FLIP", comparison.flip.mean, self.max_flip),
        ] {
            // What is no number is within no limit.
            if let Some(limit) = limit.filter(|&limit| value.is_nan() || value > limit) {
                beyond.push(format!("{name} {value:.4e} is above {limit}"));
            }
        }
        match (self.alpha, &comparison.z_test) {
            (Some(alpha), None) => {
                let fix = "needs variance layers in both files; render them with `--aov variance`";
                return Err(Error::Usage(format!("--alpha {alpha} {fix}")));
            }
            (Some(alpha), Some(test)) if !test.passed => {
                beyond.push(format!("the z-test finds a difference at {alpha}"));
            }
            _ => {}
        }
        if beyond.is_empty() { Ok(()) } else { Err(Error::Beyond(beyond.join("; "))) }
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("give a number above 0".to_owned()),
    }
}

fn probability(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("give a probability between 0 and 1, like 0.01".to_owned()),
    }
}
