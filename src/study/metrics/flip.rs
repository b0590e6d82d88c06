//! The LDR-FLIP error: what an observer sees when two pictures are flipped back and forth.
//!
//! Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom & Fairchild 2020, "FLIP: A Difference Evaluator for Alternating
//! Images", section 4, with the constants of NVIDIA's program. The one difference: L*a*b* is the renderer's own, whose D65
//! white has more digits. Edges repeat their pixels, as in that program since version 1.2.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::color::Lab;

use super::image::Image;

/// Pixels per degree of the visual field: 0.7 m before a display 0.7 m wide with 3840 pixels.
const PIXELS_PER_DEGREE: f64 = 0.7 * 3840.0 / 0.7 * PI / 180.0;
/// Exponents of the colour and the feature difference, and where the colour difference is bent: 0.4 of the way reaches 0.95.
const COLOUR_POWER: f64 = 0.7;
const FEATURE_POWER: f64 = 0.5;
const BEND: (f64, f64) = (0.4, 0.95);
/// Width of the edge and point detectors, degrees.
const FEATURE_DEG: f64 = 0.082;

/// FLIP of each pixel, 0..1, between two pictures as a display shows them: linear sRGB in 0..1, the same size.
pub fn flip(shown: &Image, reference: &Image) -> Vec<f64> {
    let (colours, features) =
        rayon::join(|| colour_difference(shown, reference), || feature_difference(shown, reference));
    colours.into_iter().zip(features).map(|(colour, feature)| colour.powf(1.0 - feature)).collect()
}

/// One channel of a picture.
struct Plane<'a> {
    width: usize,
    values: &'a [f64],
}

/// Linear sRGB to XYZ over the white, then to the linear opponent space Y Cx Cz.
fn to_opponent() -> DMat3 {
    let to_xyz = DMat3::from_cols_array(&[
        10_135_552.0 / 23_359_437.0,
        2_613_072.0 / 12_288_897.0,
        1_425_312.0 / 80_288_307.0,
        8_788_810.0 / 23_359_437.0,
        8_788_810.0 / 12_288_897.0,
        8_788_810.0 / 80_288_307.0,
        4_435_075.0 / 23_359_437.0,
        887_015.0 / 12_288_897.0,
        70_074_185.0 / 80_288_307.0,
    ]);
    // Y is short of its constant -16, which no filter changes and the way back cancels.
    DMat3::from_cols_array(&[0.0, 500.0, 0.0, 116.0, -500.0, 200.0, 0.0, 0.0, -200.0]) * to_xyz
}

/// What is left of a colour difference after the eye's blur, 0..1.
fn colour_difference(shown: &Image, reference: &Image) -> Vec<f64> {
    let to_opponent = to_opponent();
    let to_rgb = to_opponent.inverse();
    let seen = |image: &Image| -> Vec<Lab> {
        let opponent: Vec<DVec3> = image.rgb.par_iter().map(|&rgb| to_opponent * DVec3::from(rgb)).collect();
        let planes: Vec<Vec<f64>> = (0..3usize)
            .into_par_iter()
            .map(|channel| {
                let values: Vec<f64> = opponent.iter().map(|pixel| pixel[channel]).collect();
                blurred(&Plane { width: image.width, values: &values }, channel)
            })
            .collect();
        let pixels = (0..opponent.len()).into_par_iter();
        pixels.map(|i| hunt_adjusted(to_rgb * DVec3::new(planes[0][i], planes[1][i], planes[2][i]))).collect()
    };
    let greatest = hyab(hunt_adjusted(DVec3::Y), hunt_adjusted(DVec3::Z)).powf(COLOUR_POWER);
    let (bend, height) = (BEND.0 * greatest, BEND.1);
    let (a, b) = (seen(shown), seen(reference));
    let spread = |(a, b): (&Lab, &Lab)| {
        let difference = hyab(*a, *b).powf(COLOUR_POWER);
        if difference < bend {
            height / bend * difference
        } else {
            height + (difference - bend) / (greatest - bend) * (1.0 - height)
        }
    };
    a.iter().zip(&b).map(spread).collect()
}

/// L*a*b* with chroma that fades in the dark (the Hunt effect).
fn hunt_adjusted(rgb: DVec3) -> Lab {
    let Lab { l, a, b } = Lab::from_linear_srgb(rgb.clamp(DVec3::ZERO, DVec3::ONE).to_array());
    Lab { l, a: 0.01 * l * a, b: 0.01 * l * b }
}

/// City-block in lightness, Euclidean in chroma: made for large differences.
fn hyab(one: Lab, two: Lab) -> f64 {
    (one.l - two.l).abs() + (one.a - two.a).hypot(one.b - two.b)
}

/// A channel of Y Cx Cz through the eye's contrast sensitivity: sums of a sqrt(pi/b) exp(-pi^2 x^2 / b), x in degrees.
fn blurred(plane: &Plane, channel: usize) -> Vec<f64> {
    const TERMS: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
    const WIDEST: f64 = 0.04;
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let mut sum = vec![0.0; plane.values.len()];
    let mut total = 0.0;
    for &(a, b) in TERMS[channel] {
        let kernel = kernel(radius, |x| (-PI * PI * (x / PIXELS_PER_DEGREE).powi(2) / b).exp());
        let height = a * (PI / b).sqrt();
        total += height * kernel.iter().sum::<f64>().powi(2);
        for (sum, value) in sum.iter_mut().zip(filtered(plane, &kernel, &kernel)) {
            *sum += height * value;
        }
    }
    sum.into_iter().map(|value| value / total).collect()
}

/// Differences of edges and points in the lightness, 0..1.
fn feature_difference(shown: &Image, reference: &Image) -> Vec<f64> {
    let to_opponent = to_opponent();
    let lightness = |image: &Image| -> Vec<f64> {
        image.rgb.iter().map(|&rgb| (to_opponent * DVec3::from(rgb)).x / 116.0).collect()
    };
    let deviation = 0.5 * FEATURE_DEG * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let bell = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
    let smooth = unit_halves(kernel(radius, bell));
    let edge = unit_halves(kernel(radius, |x| -x * bell(x)));
    let point = unit_halves(kernel(radius, |x| (x * x / (deviation * deviation) - 1.0) * bell(x)));
    let strength = |values: &[f64], detector: &[f64]| -> Vec<f64> {
        let plane = Plane { width: shown.width, values };
        let (across, down) = (filtered(&plane, detector, &smooth), filtered(&plane, &smooth, detector));
        across.iter().zip(&down).map(|(x, y)| x.hypot(*y)).collect()
    };
    let (a, b) = (lightness(shown), lightness(reference));
    let [edges, points] = [edge, point].map(|detector| -> Vec<f64> {
        strength(&a, &detector).iter().zip(strength(&b, &detector)).map(|(a, b)| (a - b).abs()).collect()
    });
    edges.iter().zip(points).map(|(edge, point)| (FRAC_1_SQRT_2 * edge.max(point)).powf(FEATURE_POWER)).collect()
}

fn kernel(radius: i32, value: impl Fn(f64) -> f64) -> Vec<f64> {
    (-radius..=radius).map(|x| value(f64::from(x))).collect()
}

/// Scaled so that what is above zero sums to 1 and what is below to -1.
fn unit_halves(kernel: Vec<f64>) -> Vec<f64> {
    let (above, below) = kernel.iter().fold((0.0, 0.0), |(a, b), &v| (a + v.max(0.0), b - v.min(0.0)));
    kernel
        .into_iter()
        .map(|v| {
            if v > 0.0 {
                v / above
            } else if v < 0.0 {
                v / below
            } else {
                0.0
            }
        })
        .collect()
}

/// Convolution with a kernel along x and one along y; beyond the edges their pixels repeat.
fn filtered(plane: &Plane, along_x: &[f64], along_y: &[f64]) -> Vec<f64> {
    let (width, height) = (plane.width, plane.values.len() / plane.width);
    let tap = |at: usize, step: usize, radius: usize, end: usize| (at + step).saturating_sub(radius).min(end - 1);
    let (rx, ry) = (along_x.len() / 2, along_y.len() / 2);
    let mut rows = vec![0.0; plane.values.len()];
    for (row, values) in rows.chunks_mut(width).zip(plane.values.chunks(width)) {
        for (x, sum) in row.iter_mut().enumerate() {
            *sum = along_x.iter().enumerate().map(|(i, weight)| weight * values[tap(x, i, rx, width)]).sum();
        }
    }
    let mut result = vec![0.0; rows.len()];
    for (y, row) in result.chunks_mut(width).enumerate() {
        for (i, weight) in along_y.iter().enumerate() {
            let source = tap(y, i, ry, height) * width;
            for (sum, value) in row.iter_mut().zip(&rows[source..source + width]) {
                *sum += weight * value;
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waves(phase: f64) -> Image {
        let (width, height) = (40, 30);
        let pixel = |i: usize| {
            let (x, y) = (i % width, i / width);
            let blue = if (x / 5 + y / 7) % 2 == 1 { 0.3 } else { 0.7 };
            [0.5 + 0.4 * (0.35 * x as f64 + phase).sin(), 0.5 + 0.4 * (0.22 * y as f64 - phase).cos(), blue]
        };
        Image { width, height, rgb: (0..width * height).map(pixel).collect(), variance: None }
    }

    /// Expected values: the same pictures through `flip-evaluator` 1.7 from PyPI (LDR, default viewing distance), NVIDIA's
    /// own program in f32.
    #[test]
    fn values_are_those_of_the_published_program() {
        let reference = waves(0.0);
        let mut spotted = reference.clone();
        for (x, y) in [(20, 12), (21, 12), (22, 12), (20, 13), (21, 13), (22, 13)] {
            spotted.rgb[y * 40 + x] = [1.0, 0.0, 0.0];
        }
        for (image, mean, max, at) in [
            (waves(0.3), 0.358_179_75, 0.493_128_33, [0.288_080_33, 0.196_018_31, 0.178_750_47]),
            (spotted, 0.008_102_935, 0.295_374_99, [0.0, 0.078_045_18, 0.0]),
        ] {
            let map = flip(&image, &reference);
            let got_mean = map.iter().sum::<f64>() / map.len() as f64;
            let got_max = map.iter().copied().fold(0.0, f64::max);
            assert!((got_mean - mean).abs() < 1e-4 && (got_max - max).abs() < 2e-4, "{got_mean} {got_max}");
            for ((x, y), value) in [(0, 0), (20, 15), (39, 29)].into_iter().zip(at) {
                assert!((map[y * 40 + x] - value).abs() < 2e-4, "({x}, {y}): {}", map[y * 40 + x]);
            }
        }
        assert!(flip(&reference, &reference).iter().all(|&error| error == 0.0));
    }
}
