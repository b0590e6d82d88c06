//! The colours of all presets on one sheet.

use rayon::prelude::*;

use super::canvas::{Anchor, Canvas};
use super::coating::Coating;
use super::error::StudyError;
use super::lettering;
use super::number::ten_digits;
use super::swatch::{Integral, ticks};
use crate::color::Sensor;
use crate::document::Preset;
use crate::output::{HeaderValue, Picture};

/// Pixels of a preset's field, of the letters above and the figures below it, and of the margins.
const FIELD: [usize; 2] = [560, 64];
const ABOVE: usize = lettering::HEIGHT + 8;
const BELOW: usize = lettering::HEIGHT + 34;
const MARGIN: usize = 36;
/// Angles from the normal at the bottom and at the top of a field, degrees.
const ANGLES_DEG: [f64; 2] = [0.0, 80.0];
/// Rows and columns of pixels that share a colour.
const STEP: usize = 4;
/// Presets side by side.
const COLUMNS: usize = 2;

/// A field for each preset: its number from left to right, the angle upwards; the reflected colour of the films alone, under
/// the sensor's white, `exposure_ev` stops brighter than a perfect reflector being white.
///
/// # Errors
/// Never for the presets that the program carries.
pub fn preset_sheet(sensor: &Sensor, exposure_ev: f32) -> Result<Picture, StudyError> {
    let presets = Preset::all();
    let (width, height) = (FIELD[0] + 2 * MARGIN, ABOVE + FIELD[1] + BELOW);
    let mut canvas = Canvas::new([COLUMNS * width, MARGIN + presets.len().div_ceil(COLUMNS) * height]);
    for (i, preset) in presets.iter().enumerate() {
        let [x, y] = [i % COLUMNS * width + MARGIN, MARGIN + i / COLUMNS * height];
        canvas.text(preset.name, x, Anchor::Start, y);
        field(&mut canvas, preset, [x, y + ABOVE], sensor, exposure_ev.exp2())?;
    }
    let note = |name: &str, text: String| (name.to_owned(), HeaderValue::Text(text));
    let [low, high] = ANGLES_DEG;
    Ok(canvas.into_picture(vec![note("angle_deg", format!("{low}..{high}"))]))
}

fn field(
    canvas: &mut Canvas,
    preset: &Preset,
    [left, top]: [usize; 2],
    sensor: &Sensor,
    gain: f32,
) -> Result<(), StudyError> {
    let [low, high] = [preset.knob.least, preset.knob.most].map(f64::from);
    canvas.box_of(left - 1..left + FIELD[0] + 1, top - 1..top + FIELD[1] + 1);
    let [across, up] = FIELD.map(|side| side / STEP);
    let columns: Result<Vec<Vec<[f32; 3]>>, StudyError> = (0..across)
        .into_par_iter()
        .map(|column| {
            let value = low + (high - low) * (column as f64 + 0.5) / across as f64;
            let coating = Coating::of_preset(preset, value as f32)?;
            let integral = Integral::new(&coating, sensor);
            let colour = |row: usize| {
                let share = (row as f64 + 0.5) / up as f64;
                let angle_deg = ANGLES_DEG[0] + share * (ANGLES_DEG[1] - ANGLES_DEG[0]);
                let mu = angle_deg.to_radians().cos() as f32;
                integral.colour(mu, coating.range.min_nm as f32).map(|value| gain * value)
            };
            Ok((0..up).map(colour).collect())
        })
        .collect();
    for (column, colours) in columns?.iter().enumerate() {
        for (row, &colour) in colours.iter().enumerate() {
            for pixel in 0..STEP * STEP {
                let [dx, dy] = [pixel % STEP, pixel / STEP];
                canvas.pixel(left + column * STEP + dx, top + FIELD[1] - 1 - row * STEP - dy, colour);
            }
        }
    }
    let bottom = top + FIELD[1];
    for (share, text) in ticks(low, high) {
        let x = left + (share * (FIELD[0] - 1) as f64).round() as usize;
        canvas.box_of(x..x + 2, bottom..bottom + 5);
        canvas.text(&text, x, Anchor::Middle, bottom + 8);
    }
    let knob = format!("{} (default {})", preset.knob.name, ten_digits(preset.knob.default.into()));
    canvas.text(&knob, left + FIELD[0], Anchor::End, top - ABOVE);
    Ok(())
}
