//! Where two pictures differ: errors in false colours, with their scale.

use crate::color::view::srgb_decode;
use crate::output::{HeaderValue, Picture};

use super::canvas::{Anchor, Canvas};
use super::lettering;
use super::number::{round_step, ten_digits};

/// Ends and even steps of the map, sRGB: magma, by van der Walt & Smith 2015 (CC0), dark for no error.
const MAGMA: [[u8; 3]; 9] = [
    [0, 0, 4],
    [28, 16, 68],
    [79, 18, 123],
    [129, 37, 129],
    [181, 54, 122],
    [229, 80, 100],
    [251, 135, 97],
    [254, 194, 135],
    [252, 253, 191],
];
/// Small pictures are enlarged so that the scale has room for its figures.
const LEAST_WIDTH: usize = 320;
const GAP: usize = 8;
const BAR: usize = 14;
const MARGIN: usize = 24;

/// The end of a scale that all of `errors` fit on: the next of 1, 2, 5 times a power of ten.
pub fn scale_of(errors: &[f64]) -> f64 {
    let greatest = errors.iter().copied().filter(|error| error.is_finite()).fold(0.0, f64::max);
    if greatest > 0.0 { round_step(greatest, 1.0) } else { 1.0 }
}

/// `errors` row by row, 0 dark, `top` and above (and what is no number) brightest; a scale with `name` below.
pub fn error_map(errors: &[f64], width: usize, name: &str, top: f64) -> Picture {
    let zoom = LEAST_WIDTH.div_ceil(width);
    let [wide, high] = [width * zoom, errors.len() / width * zoom];
    let below = [high + GAP, high + GAP + BAR + GAP, high + 2 * GAP + BAR + lettering::HEIGHT + GAP];
    let mut canvas = Canvas::new([wide, below[2]]);
    for y in 0..high {
        for x in 0..wide {
            canvas.pixel(x, y, color(errors[y / zoom * width + x / zoom] / top));
        }
    }
    let bar = wide - 2 * MARGIN;
    for x in 0..bar {
        for y in below[0]..below[0] + BAR {
            canvas.pixel(MARGIN + x, y, color(x as f64 / (bar - 1) as f64));
        }
    }
    canvas.text("0", MARGIN, Anchor::Middle, below[1]);
    canvas.text(&ten_digits(top), MARGIN + bar, Anchor::Middle, below[1]);
    canvas.text(name, MARGIN + bar / 2, Anchor::Middle, below[1]);
    let header = [("error".to_owned(), name.to_owned()), ("scale".to_owned(), format!("0..{top}"))];
    canvas.into_picture(header.into_iter().map(|(key, text)| (key, HeaderValue::Text(text))).collect())
}

/// Linear sRGB of a place on the map, 0..1.
fn color(place: f64) -> [f32; 3] {
    let place = if place.is_nan() { 1.0 } else { place.clamp(0.0, 1.0) } * (MAGMA.len() - 1) as f64;
    let low = (place as usize).min(MAGMA.len() - 2);
    let t = (place - low as f64) as f32;
    let channel = |c: usize| f32::from(MAGMA[low][c]) + t * (f32::from(MAGMA[low + 1][c]) - f32::from(MAGMA[low][c]));
    std::array::from_fn(|c| srgb_decode(channel(c) / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers_and_colours_at_the_map_s_ends() {
        assert_eq!([scale_of(&[0.3, 1.7]), scale_of(&[4.0]), scale_of(&[0.0, f64::NAN])], [2.0, 5.0, 1.0]);
        let picture = error_map(&[0.0, f64::NAN, 5.0, 9.0], 2, "x", 5.0);
        assert_eq!(picture.width, 320);
        let bright = [252, 253, 191].map(|code: u8| srgb_decode(f32::from(code) / 255.0));
        let at = |x: usize, y: usize| picture.rgba[y * 320 + x][..3].to_vec();
        assert_eq!(at(0, 0), [0.0, 0.0, srgb_decode(4.0 / 255.0)]);
        assert_eq!([at(319, 0), at(0, 319), at(319, 319)], [bright.to_vec(), bright.to_vec(), bright.to_vec()]);
    }
}
