//! The colour of a film over thickness and angle, as a picture.

use rayon::prelude::*;

use crate::color::{MAX_NM, MIN_NM, Sensor};
use crate::film::{Range, Side, SpectralFilm, spectral};
use crate::output::{HeaderValue, Picture};

use super::canvas::{Anchor, Canvas};
use super::coating::Coating;
use super::lettering;
use super::number::{round_step, ten_digits};

/// What to draw.
#[derive(Clone, Copy, Debug)]
pub struct SwatchPlan {
    /// Along x, left to right.
    pub thickness: Range,
    /// Along y, bottom to top: first and last.
    pub angles_deg: [f64; 2],
    /// Brightness of the colours in stops; at 0 a perfect reflector is white.
    pub exposure_ev: f32,
}

/// Pixels of the whole picture and of the coloured field in it.
pub const SWATCH_SIZE: [usize; 2] = [LEFT + FIELD[0] + RIGHT, TOP + FIELD[1] + BOTTOM];
const FIELD: [usize; 2] = [900, 480];
const LEFT: usize = 56;
const RIGHT: usize = 32;
const TOP: usize = 40;
const BOTTOM: usize = 64;
/// Pixels from the field to its figures.
const TICK: usize = 6;
const GAP: usize = 10;
/// Rows of pixels between the angles that are computed; linear in between.
const ROW_STEP: usize = 4;
/// Wavelengths that are evaluated together.
const LANES: usize = 8;

/// The exact colour of R (f32 to 1e-5, integrated at 1 nm) on axes with figures, on white. Values beyond sRGB are left for
/// the file to clip.
pub fn swatch(coating: &Coating, sensor: &Sensor, plan: &SwatchPlan) -> Picture {
    let mut canvas = Canvas::new(SWATCH_SIZE);
    // A line of ink around the field, for the colours that are white.
    canvas.box_of(LEFT - 1..LEFT + FIELD[0] + 1, TOP - 1..TOP + FIELD[1] + 1);
    fill(&mut canvas, coating, sensor, plan);

    let [low, high] = plan.angles_deg;
    let Range { min_nm, max_nm } = plan.thickness;
    let (bottom, word_row) = (TOP + FIELD[1], TOP + FIELD[1] + GAP + lettering::HEIGHT + GAP);
    for (share, text) in ticks(min_nm, max_nm) {
        let x = LEFT + (share * (FIELD[0] - 1) as f64).round() as usize;
        canvas.box_of(x..x + 2, bottom..bottom + TICK);
        canvas.text(&text, x, Anchor::Middle, bottom + GAP);
    }
    canvas.text("film thickness / nm", LEFT + FIELD[0] / 2, Anchor::Middle, word_row);
    for (share, text) in ticks(low, high) {
        let y = bottom - 1 - (share * (FIELD[1] - 1) as f64).round() as usize;
        canvas.box_of(LEFT - TICK..LEFT, y - 1..y + 1);
        canvas.text(&text, LEFT - GAP, Anchor::End, y - lettering::HEIGHT / 2);
    }
    canvas.text("angle / degrees", LEFT, Anchor::Start, GAP);

    let note = |name: &str, text: String| (name.to_owned(), HeaderValue::Text(text));
    let header = vec![
        note("stack", coating.label.clone()),
        note("thickness_nm", format!("{min_nm}..{max_nm}")),
        note("angle_deg", format!("{low}..{high}")),
    ];
    canvas.into_picture(header)
}

/// The coloured field.
fn fill(canvas: &mut Canvas, coating: &Coating, sensor: &Sensor, plan: &SwatchPlan) {
    let integral = Integral::new(coating, sensor);
    let gain = plan.exposure_ev.exp2();
    let [width, height] = FIELD;
    let thickness = |x: usize| {
        let share = (x as f64 + 0.5) / width as f64;
        (plan.thickness.min_nm + share * (plan.thickness.max_nm - plan.thickness.min_nm)) as f32
    };
    let rows: Vec<Vec<[f32; 3]>> = (0..=height / ROW_STEP)
        .into_par_iter()
        .map(|row| {
            let share = (row * ROW_STEP) as f64 / height as f64;
            let angle_deg = plan.angles_deg[0] + share * (plan.angles_deg[1] - plan.angles_deg[0]);
            let mu = angle_deg.to_radians().cos() as f32;
            (0..width).map(|x| integral.colour(mu, thickness(x)).map(|value| gain * value)).collect()
        })
        .collect();
    for y in 0..height {
        let place = (height as f32 - y as f32 - 0.5) / ROW_STEP as f32;
        let (below, t) = (place as usize, place.fract());
        for (x, (a, b)) in rows[below].iter().zip(&rows[below + 1]).enumerate() {
            let [r, g, b]: [f32; 3] = std::array::from_fn(|c| a[c] + t * (b[c] - a[c]));
            canvas.pixel(LEFT + x, TOP + y, [r, g, b]);
        }
    }
}

/// The integral of R over 380..780 nm, ready for many angles and thicknesses.
pub(super) struct Integral {
    film: SpectralFilm,
    /// Wavelengths and their weights; what is left of the last lanes has none.
    blocks: Vec<([f32; LANES], [[f32; 3]; LANES])>,
}

impl Integral {
    pub(super) fn new(coating: &Coating, sensor: &Sensor) -> Self {
        let steps = (MAX_NM - MIN_NM) as usize;
        let block = |first: usize| {
            let nm = |i: usize| MIN_NM + (first + i).min(steps) as f64;
            let weight = |i: usize| if first + i <= steps { sensor.reflectance_weight(nm(i)) } else { [0.0; 3] };
            (std::array::from_fn(|i| nm(i) as f32), std::array::from_fn(|i| weight(i).map(|w| w as f32)))
        };
        let blocks = (0..=steps).step_by(LANES).map(block).collect();
        // The range only matters for averages over the hemisphere, which are not used.
        Self { film: spectral(&coating.stack, Range::constant(0.0)), blocks }
    }

    pub(super) fn colour(&self, mu: f32, thickness_nm: f32) -> [f32; 3] {
        let mut rgb = [0.0; 3];
        for (nm, weights) in &self.blocks {
            let reflect = self.film.split(Side::Outside, mu, thickness_nm, nm).reflect;
            for (value, weight) in reflect.iter().zip(weights) {
                rgb = std::array::from_fn(|c| rgb[c] + value * weight[c]);
            }
        }
        rgb
    }
}

/// Round values between two ends: the share of the way, and the figures.
pub(super) fn ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    let step = round_step(high - low, 10.0);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    let tick = |i: i64| ((i as f64 * step - low) / (high - low), ten_digits(i as f64 * step));
    (first..=last).map(tick).collect()
}
