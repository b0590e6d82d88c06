//! Boxes and words that can be drawn as SVG and as PNG.

use std::fmt::Write;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

use crate::study::lettering;

pub type Color = [u8; 3];

pub const INK: Color = [40, 44, 52];
pub const FAINT: Color = [226, 228, 232];

/// Which point of a text its position is.
#[derive(Clone, Copy)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

enum Mark {
    Rect {
        x: f64,
        y: f64,
        width: f64,
        height: f64,
        color: Color,
    },
    /// `y` is the middle of the letters.
    Text {
        x: f64,
        y: f64,
        anchor: Anchor,
        text: String,
    },
}

/// Marks on white, later ones on top; the origin is the upper left corner.
pub struct Canvas {
    width: u32,
    height: u32,
    marks: Vec<Mark>,
}

impl Canvas {
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, marks: Vec::new() }
    }

    pub fn rect(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], color: Color) {
        self.marks.push(Mark::Rect { x, y, width, height, color });
    }

    pub fn text(&mut self, [x, y]: [f64; 2], anchor: Anchor, text: impl Into<String>) {
        self.marks.push(Mark::Text { x, y, anchor, text: text.into() });
    }

    pub fn to_svg(&self) -> String {
        let Self { width, height, .. } = self;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
             font-family=\"sans-serif\" font-size=\"14\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
        );
        for mark in &self.marks {
            // Writing to a String cannot fail.
            let _ = match mark {
                Mark::Rect { x, y, width, height, color } => writeln!(
                    svg,
                    "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{}\"/>",
                    hex(*color)
                ),
                Mark::Text { x, y, anchor, text } => {
                    let anchor = match anchor {
                        Anchor::Start => "start",
                        Anchor::Middle => "middle",
                        Anchor::End => "end",
                    };
                    let (y, fill) = (y + 5.0, hex(INK));
                    writeln!(
                        svg,
                        "<text x=\"{x:.2}\" y=\"{y:.2}\" text-anchor=\"{anchor}\" fill=\"{fill}\">{text}</text>"
                    )
                }
            };
        }
        svg.push_str("</svg>\n");
        svg
    }

    pub fn to_png(&self) -> Result<Vec<u8>, ImageError> {
        let (width, height) = (self.width as usize, self.height as usize);
        let mut rgb = vec![255u8; 3 * width * height];
        let mut ink = |x: usize, y: usize, color: Color| {
            if x < width && y < height {
                rgb[3 * (y * width + x)..][..3].copy_from_slice(&color);
            }
        };
        for mark in &self.marks {
            match mark {
                Mark::Rect { x, y, width, height, color } => {
                    // Whole pixels, and at least one: thin bars must not vanish.
                    let span = |start: f64, length: f64| {
                        let first = start.round().max(0.0) as usize;
                        first..((start + length).round() as usize).max(first + usize::from(length > 0.0))
                    };
                    for y in span(*y, *height) {
                        span(*x, *width).for_each(|x| ink(x, y, *color));
                    }
                }
                Mark::Text { x, y, anchor, text } => {
                    let length = (text.chars().count() * lettering::ADVANCE) as f64;
                    let left = match anchor {
                        Anchor::Start => *x,
                        Anchor::Middle => x - 0.5 * length,
                        Anchor::End => x - length,
                    };
                    let (left, top) = (left.max(0.0) as usize, (y - 0.5 * lettering::HEIGHT as f64).max(0.0) as usize);
                    lettering::pixels(text).for_each(|(dx, dy)| ink(left + dx, top + dy, INK));
                }
            }
        }
        let mut png = Vec::new();
        PngEncoder::new(&mut png).write_image(&rgb, self.width, self.height, ExtendedColorType::Rgb8)?;
        Ok(png)
    }
}

pub fn hex([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
