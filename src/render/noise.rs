//! How noisy a picture is, from the spread of its own samples.

/// Linear sRGB to luminance.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];
/// Darker pixels are judged as if they had this share of the mean luminance.
const DARKEST: f64 = 0.1;

/// Luminance and its standard error, from mean and variance of the mean per channel. The channels' errors are added as if
/// they rose and fell together: exact for greys, too much for colours, never too little.
fn luminance(pixel: [(f64, f64); 3]) -> (f64, f64) {
    let sum = |part: fn((f64, f64)) -> f64| (0..3).map(|c| LUMINANCE[c] * part(pixel[c])).sum();
    (sum(|(mean, _)| mean), sum(|(_, variance)| variance.sqrt()))
}

/// Root mean square of the standard errors over the mean luminance.
pub(super) fn of_picture(pixels: impl Iterator<Item = [(f64, f64); 3]>) -> f64 {
    let (mut count, mut light, mut squares) = (0.0f64, 0.0f64, 0.0f64);
    for (mean, error) in pixels.map(luminance) {
        count += 1.0;
        light += mean;
        squares += error * error;
    }
    // A black picture without spread is exact.
    if squares == 0.0 { 0.0 } else { (squares / count).sqrt() / (light / count) }
}

/// The relative standard error that 95 % of the pixels stay below.
pub(super) fn p95(pixels: impl Iterator<Item = [(f64, f64); 3]> + Clone) -> f64 {
    let (count, light) = pixels.clone().map(luminance).fold((0usize, 0.0), |(n, sum), (mean, _)| (n + 1, sum + mean));
    if count == 0 {
        return 0.0;
    }
    let least = DARKEST * light / count as f64;
    let relative = |(mean, error): (f64, f64)| if error == 0.0 { 0.0 } else { error / mean.max(least) };
    let mut errors: Vec<f64> = pixels.map(luminance).map(relative).collect();
    let rank = (count * 95).div_ceil(100) - 1;
    *errors.select_nth_unstable_by(rank, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_have_the_noise_of_their_one_channel() {
        // Half the pixels 1 +- 0.1, half 3 +- 0.3: the root mean square is sqrt(0.05), the mean 2.
        let picture = [[(1.0, 0.01); 3], [(3.0, 0.09); 3]].repeat(20);
        assert!((of_picture(picture.iter().copied()) - 0.05f64.sqrt() / 2.0).abs() < 1e-12);
        assert!((p95(picture.iter().copied()) - 0.1).abs() < 1e-12);
        assert_eq!(of_picture([[(0.0, 0.0); 3]].into_iter()), 0.0);
        assert_eq!(of_picture([[(1.0, f64::INFINITY); 3]].into_iter()), f64::INFINITY);
    }
}
