//! `pellicle chart films`.

use std::path::PathBuf;

use clap::Args;

use super::{check_base, write};
use crate::cli::stack_args::{List, StackArgs, illuminant, span, thicknesses};
use crate::cli::{print, say};
use crate::collada::{self, LoadOptions, MissingTexture};
use crate::color::{Emission, MAX_NM, MIN_NM};
use crate::document::Document;
use crate::error::Error;
use crate::film::Range;
use crate::study::{Coating, FilmChart, film_costs, typical_coatings};

/// What every film model costs and how wrong it is
///
/// Times one evaluation of each RGB rung and of 4, 8 and 16 wavelengths (median of repeats, in turns), and measures
/// CIEDE2000 of the reflected colour against the exact film over angles of 0 to 85 degrees and thicknesses. Wavelengths are
/// exact in the mean: their error is the colour noise that is left in one path and in the mean of 64. Of a scene all coated
/// materials are taken; with neither a scene nor a stack, twelve typical films.
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle chart films -o films
  pellicle chart films scenes/titanium.dae -o titanium
  pellicle chart films --layer 1.33,0 --base air --thickness 0,1200 -o bubble")]
pub struct FilmsArgs {
    /// Take the coated materials of this scene, in air
    #[arg(value_name = "SCENE", conflicts_with = "StackArgs")]
    scene: Option<PathBuf>,
    #[command(flatten)]
    stack: StackArgs,
    /// Only this material of the scene, by its id
    #[arg(long, value_name = "ID", requires = "scene")]
    material: Option<String>,
    /// Thicknesses in nm whose span the first layer (of a scene: the varying one) takes [default: its own]
    #[arg(long, value_name = "LIST", value_parser = thicknesses, allow_hyphen_values = true)]
    thickness: Option<List>,
    /// The light that colours are seen under, taken as white: D65, E, A or blackbody:K
    #[arg(long, value_name = "NAME", value_parser = illuminant, default_value = "D65")]
    illuminant: Emission,
    /// Timings of each model
    #[arg(long, value_name = "N", default_value_t = 31, value_parser = clap::value_parser!(u16).range(1..))]
    repeats: u16,
    /// Write NAME.csv, NAME.svg and NAME.png; without it only the table is printed
    #[arg(short, long, value_name = "NAME")]
    output: Option<PathBuf>,
}

pub fn run(args: &FilmsArgs) -> Result<(), Error> {
    if let Some(base) = &args.output {
        check_base(base)?;
    }
    let (title, coatings) = args.coatings()?;
    let mut costs = Vec::new();
    for (coating, range) in &coatings {
        let (measured, not_offered) = film_costs(coating, *range, &args.illuminant, args.repeats.into());
        for (rung, reason) in not_offered {
            say(&format!("note: {}: no `{rung}`: {reason}", coating.label));
        }
        costs.extend(measured);
    }
    let chart = FilmChart::new(costs);
    print(&chart.table())?;
    if let Some(base) = &args.output {
        let (svg, png) = chart.draw(&title).map_err(|error| Error::Usage(error.to_string()))?;
        write(base, &chart.csv(), &svg, &png)?;
    }
    Ok(())
}

impl FilmsArgs {
    /// What to call the chart, and the stacks.
    fn coatings(&self) -> Result<(String, Vec<(Coating, Range)>), Error> {
        let usage = |error: crate::study::StudyError| Error::Usage(error.to_string());
        if let Some(scene) = &self.scene {
            // Images play no part in the optics.
            let options = LoadOptions { missing_texture: MissingTexture::Magenta, ..LoadOptions::default() };
            let (document, _) = collada::load(scene, &options)?;
            let coatings: Result<Vec<_>, _> =
                self.ids(&document).iter().map(|id| Coating::of_material(&document, id)).collect();
            let coatings = coatings.map_err(usage)?;
            if coatings.is_empty() {
                return Err(Error::Usage(format!("{}: no material has a film", scene.display())));
            }
            let name = scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
            return Ok((
                format!("films of {name}"),
                coatings.into_iter().map(|coating| self.ranged(coating)).collect(),
            ));
        }
        if self.stack.is_empty() {
            return Ok(("typical films".to_owned(), typical_coatings().map_err(usage)?));
        }
        let (coating, range) = self.ranged(self.stack.coating([MIN_NM, MAX_NM])?);
        Ok((format!("{}, {}..{} nm", coating.label, range.min_nm, range.max_nm), vec![(coating, range)]))
    }

    fn ids(&self, document: &Document) -> Vec<String> {
        match &self.material {
            Some(id) => vec![id.clone()],
            None => {
                let coated = document.materials.iter().filter(|material| !material.films.is_empty());
                coated.map(|material| material.id.clone()).collect()
            }
        }
    }

    fn ranged(&self, coating: Coating) -> (Coating, Range) {
        let asked = self.thickness.as_ref().map(|list| span(&list.0).unwrap_or([list.0[0]; 2]));
        let range = asked.map_or(coating.range, |[min_nm, max_nm]| Range { min_nm, max_nm });
        (coating, range)
    }
}
