//! Small pictures for contact sheets.

use std::path::Path;

use crate::color::view;
use crate::output::{self, Display, Format};

/// Of the longer side, pixels.
const SIDE: u32 = 112;
/// Rows and columns of a block of pixels that are looked at, at most: enough for a mean.
const LINES: u32 = 6;

/// sRGB, 8 bits per channel, rows from the top.
pub struct Thumbnail {
    pub width: u32,
    pub height: u32,
    pub rgb: Vec<u8>,
}

impl Thumbnail {
    /// Of linear pixels, as bright as a PNG of them would be.
    pub fn of(pixels: &[[f32; 3]], width: u32, display: Display) -> Self {
        let height = pixels.len() as u32 / width.max(1);
        let shrink = (width.max(height) as f32 / SIDE as f32).max(1.0);
        let side = |length: u32| ((length as f32 / shrink).round() as u32).max(1);
        let (small_width, small_height) = (side(width), side(height));
        let mut rgb = Vec::with_capacity(3 * (small_width * small_height) as usize);
        for y in 0..small_height {
            let rows = lines(y, height, small_height);
            for x in 0..small_width {
                let columns = lines(x, width, small_width);
                let block =
                    rows.clone().flat_map(|row| columns.clone().map(move |column| (row * width + column) as usize));
                let (mut sum, mut count) = ([0.0f32; 3], 0.0f32);
                for index in block {
                    // What a screen cannot show must not outshine its neighbours.
                    let shown = display.show(pixels[index]).0.map(view::srgb_decode);
                    sum.iter_mut().zip(shown).for_each(|(sum, value)| *sum += value);
                    count += 1.0;
                }
                rgb.extend(sum.map(|value| (255.0 * view::srgb_encode(value / count)).round() as u8));
            }
        }
        Self { width: small_width, height: small_height, rgb }
    }

    /// Of a picture file; `None` if it cannot be read.
    pub fn read(path: &Path, display: Display) -> Option<Self> {
        match Format::of(path).ok()? {
            Format::Exr => {
                let picture = output::read_exr(path).ok()?;
                let pixels: Vec<[f32; 3]> = picture.rgba.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
                Some(Self::of(&pixels, picture.width, display))
            }
            Format::Png => {
                let image = image::open(path).ok()?.to_rgb8();
                let linear = |code: u8| view::srgb_decode(f32::from(code) / 255.0);
                let pixels: Vec<[f32; 3]> = image.pixels().map(|pixel| pixel.0.map(linear)).collect();
                Some(Self::of(&pixels, image.width(), Display::PLAIN))
            }
        }
    }
}

/// The rows or columns of a picture, `length` of them, that are looked at for number `at` of the `small` ones here.
fn lines(at: u32, length: u32, small: u32) -> impl Iterator<Item = u32> + Clone {
    let start = at * length / small;
    let end = ((at + 1) * length / small).max(start + 1);
    (start..end).step_by((end - start).div_ceil(LINES) as usize)
}
