//! `pellicle film`: the optics of one stack, as numbers and drawings.

use std::path::{Path, PathBuf};

use clap::Args;

use super::stack_args::{List, MOST_VALUES, StackArgs, angles, ends, illuminant, list, span, thicknesses};
use super::{print, say};
use crate::collada::{self, LoadOptions, MissingTexture};
use crate::color::{Emission, MAX_NM, MIN_NM, Sensor};
use crate::error::Error;
use crate::film::Range;
use crate::output::{self, Display, Format, PngDepth};
use crate::study::{self, Coating, MOST_CURVES, SwatchPlan};

/// What a thin film or a stack reflects and transmits: spectra, colours, swatches, plots
///
/// INDEX is a refractive index: `1.33`, `1.6+0.3i`, a name (`Au`, `SiO2`, see --list; `air`), or `@FILE.csv` with columns
/// lambda_nm,n,k (`#` comments, linear in between). LIST is numbers and ranges with commas: `0,30,60` or `0:85:5`
/// (start:stop:step, both ends included). Light comes through the ambient; where that is the denser medium, this is light
/// from inside.
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle film --layer 1.33,380 --base air --angles 0,30,60 --csv bubble.csv
  pellicle film --layer 2.4,0 --base Au --thickness 0:500:50 --colour
  pellicle film --ambient 1.5 --layer 1.33,100 --base 1 --angles 0:85:5 --wavelengths 400,550,700
  pellicle film --layer TiO2,0 --base Ti --thickness 0:200:200 --swatch titanium.png --plot titanium.svg
  pellicle film --scene scene.dae --material gold --swatch gold.png
  pellicle film --preset anodised-titanium:25 --colour
  pellicle film --list --swatch presets.png

CSV columns:
  theta_deg,thickness,lambda_nm,Rs,Rp,Ts,Tp                with --wavelengths; T is what enters the base
  rung,theta_deg,thickness,R_lin_*,T_lin_*,delta_e         with --colour; linear sRGB, a flat reflector is 1,1,1;
                                                           delta_e is CIEDE2000 of R against the exact row")]
pub struct FilmArgs {
    #[command(flatten)]
    stack: StackArgs,
    /// Take the stack of a material of this scene, in air, instead
    #[arg(long, value_name = "SCENE", requires = "material", conflicts_with = "StackArgs")]
    scene: Option<PathBuf>,
    /// The material of the scene, by its id
    #[arg(long, value_name = "ID", requires = "scene")]
    material: Option<String>,
    /// Angles of incidence in degrees, 0..90, in the ambient [default: 0]
    #[arg(long, value_name = "LIST", value_parser = angles, allow_hyphen_values = true)]
    angles: Option<List>,
    /// Thicknesses in nm that replace the first layer's (of a scene: the varying one's) in turn
    #[arg(long, value_name = "LIST", value_parser = thicknesses, allow_hyphen_values = true)]
    thickness: Option<List>,
    /// Wavelengths in nm [default: 380:780:5]
    #[arg(long, value_name = "LIST", value_parser = wavelengths, allow_hyphen_values = true, conflicts_with = "colour")]
    wavelengths: Option<List>,
    /// Colours by every film model instead of spectra
    #[arg(long, visible_alias = "color")]
    colour: bool,
    /// The light that colours are seen under, taken as white: D65, E, A or blackbody:K
    #[arg(long, value_name = "NAME", value_parser = illuminant, default_value = "D65")]
    illuminant: Emission,
    /// Where to write the numbers; `-` is stdout [default: stdout, unless only drawings are asked for]
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the exact colour over thickness and angle as PNG; over the span of --thickness and --angles where they hold two
    /// or more values, else from 0 to twice the layer's thickness (of a scene: over its range) and from 0 to 90 degrees
    #[arg(long, value_name = "FILE")]
    swatch: Option<PathBuf>,
    /// Brightness of the swatch in stops; at 0 a perfect reflector is white
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f32,
    /// Draw reflectance and transmittance over wavelength as SVG, a curve for each angle and thickness
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// List the presets, and the named indices with n and k at 550 nm, with their sources; with --swatch, draw all presets
    #[arg(long, conflicts_with_all = ["StackArgs", "scene", "csv", "plot", "colour", "angles", "thickness", "wavelengths"])]
    list: bool,
}

pub fn run(args: &FilmArgs) -> Result<(), Error> {
    if args.list {
        return args.list();
    }
    let coating = args.coating()?;
    let angles = args.angles.as_ref().map_or(vec![0.0], |list| list.0.clone());
    let thicknesses = args.thickness.as_ref().map_or_else(|| coating.thicknesses_nm(), |list| list.0.clone());
    let sensor = Sensor::new(&args.illuminant);
    args.check(&coating, angles.len() * thicknesses.len())?;

    if let Some(path) = &args.swatch {
        let picture = study::swatch(&coating, &sensor, &args.swatch_plan(&coating)?);
        output::write_png(path, &picture, Display::PLAIN, PngDepth::Eight)?;
    }
    if let Some(path) = &args.plot {
        let spans = args.wavelengths.as_ref().and_then(|list| span(&list.0)).unwrap_or([MIN_NM, MAX_NM]);
        let svg = study::plot(&coating, &sensor, &angles, &thicknesses, spans[0]..spans[1]);
        output::write_text(path, &svg.map_err(|error| Error::Usage(format!("--plot {}: {error}", path.display())))?)?;
    }
    if !args.wants_rows() {
        return Ok(());
    }
    let csv = if args.colour {
        let whole = (args.thickness.is_none() && coating.varies()).then_some(coating.range);
        let (rows, not_offered) = study::colour_rows(&coating, &angles, &thicknesses, whole, &sensor);
        for (rung, reason) in not_offered {
            say(&format!("note: no `{rung}` rows: {reason}"));
        }
        study::colour_csv(&rows)
    } else {
        study::spectra_csv(&coating, &angles, &thicknesses, &args.wavelengths_nm())
    };
    match args.csv_file() {
        Some(path) => Ok(output::write_text(path, &csv)?),
        None => print(&csv),
    }
}

impl FilmArgs {
    fn list(&self) -> Result<(), Error> {
        let usage = |error: String| Error::Usage(error);
        let Some(path) = &self.swatch else {
            let indices = study::list_indices().map_err(|error| usage(error.to_string()))?;
            return print(&format!("{}\n{indices}", study::list_presets()));
        };
        self.check_swatch(path)?;
        let sheet = study::preset_sheet(&Sensor::new(&self.illuminant), self.exposure);
        let sheet = sheet.map_err(|error| usage(error.to_string()))?;
        output::write_png(path, &sheet, Display::PLAIN, PngDepth::Eight)?;
        Ok(())
    }

    fn coating(&self) -> Result<Coating, Error> {
        if let (Some(scene), Some(id)) = (&self.scene, &self.material) {
            // Images play no part in the optics.
            let options = LoadOptions { missing_texture: MissingTexture::Magenta, ..LoadOptions::default() };
            let (document, _) = collada::load(scene, &options)?;
            return Coating::of_material(&document, id)
                .map_err(|error| Error::Usage(format!("--material {id}: {error}")));
        }
        let used = self.wavelengths.as_ref().map_or([MIN_NM, MAX_NM], |list| ends(&list.0));
        self.stack.coating(used)
    }

    /// Finds out before any work whether what is asked for makes sense and can be written; `pairs` is the number of angles
    /// times thicknesses.
    fn check(&self, coating: &Coating, pairs: usize) -> Result<(), Error> {
        if coating.stack.layers.is_empty() && (self.thickness.is_some() || self.swatch.is_some()) {
            let flag = if self.thickness.is_some() { "--thickness" } else { "--swatch" };
            return Err(Error::Usage(format!("{flag}: this surface is bare; give a film, like `--layer 1.33,300`")));
        }
        if self.wants_rows() {
            let rows = pairs.saturating_mul(if self.colour { 5 } else { self.wavelengths_nm().len() });
            if rows > MOST_VALUES {
                let problem = format!("--angles, --thickness and --wavelengths together ask for {rows} rows");
                return Err(Error::Usage(format!("{problem}; at most {MOST_VALUES} are written: give fewer")));
            }
        }
        if let Some(path) = self.csv_file() {
            output::check_writable(path)?;
        }
        if let Some(path) = &self.swatch {
            self.check_swatch(path)?;
        }
        if let Some(path) = &self.plot {
            if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg")) {
                return Err(Error::Usage(format!("--plot {}: plots are written as .svg", path.display())));
            }
            if pairs > MOST_CURVES {
                let problem = format!("--plot {}: {pairs} curves (angles times thicknesses)", path.display());
                return Err(Error::Usage(format!("{problem} cannot be told apart; give at most {MOST_CURVES}")));
            }
            output::check_writable(path)?;
        }
        Ok(())
    }

    fn check_swatch(&self, path: &Path) -> Result<(), Error> {
        if output::check_picture(path)? != Format::Png {
            return Err(Error::Usage(format!("--swatch {}: swatches are written as .png", path.display())));
        }
        if !(self.exposure.is_finite() && self.exposure.abs() <= 30.0) {
            return Err(Error::Usage(format!("--exposure {}: give stops from -30 to 30", self.exposure)));
        }
        Ok(())
    }

    fn wants_rows(&self) -> bool {
        self.csv.is_some() || self.colour || (self.swatch.is_none() && self.plot.is_none())
    }

    fn csv_file(&self) -> Option<&Path> {
        self.csv.as_deref().filter(|path| *path != Path::new("-"))
    }

    fn wavelengths_nm(&self) -> Vec<f64> {
        match &self.wavelengths {
            Some(list) => list.0.clone(),
            None => (0..=80).map(|step| MIN_NM + 5.0 * f64::from(step)).collect(),
        }
    }

    fn swatch_plan(&self, coating: &Coating) -> Result<SwatchPlan, Error> {
        let asked = self.thickness.as_ref().and_then(|list| span(&list.0));
        let [min_nm, max_nm] = match asked {
            Some(span) => span,
            None if coating.varies() => [coating.range.min_nm, coating.range.max_nm],
            None => {
                let given = self.thickness.as_ref().and_then(|list| list.0.first().copied());
                [0.0, 2.0 * given.unwrap_or(coating.range.max_nm)]
            }
        };
        if max_nm <= min_nm {
            let problem = "--swatch: the layer has no thickness to draw over; give a span, like `--thickness 0,1000`";
            return Err(Error::Usage(problem.to_owned()));
        }
        let angles_deg = self.angles.as_ref().and_then(|list| span(&list.0)).unwrap_or([0.0, 90.0]);
        Ok(SwatchPlan { thickness: Range { min_nm, max_nm }, angles_deg, exposure_ev: self.exposure })
    }
}

fn wavelengths(text: &str) -> Result<List, String> {
    list(text, |nm| nm >= 1.0, "is not a wavelength in nm; if it is in micrometres, multiply by 1000")
}
