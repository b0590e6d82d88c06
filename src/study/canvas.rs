//! Pixels to draw on, for the PNGs: by hand, or as a backend of the library that draws the SVGs.

use std::convert::Infallible;
use std::ops::Range;

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontTransform,
};

use crate::color::view::srgb_decode;
use crate::output::{HeaderValue, Picture};

use super::lettering;

pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// White paper, in linear sRGB.
pub(super) struct Canvas {
    size: [usize; 2],
    rgba: Vec<[f32; 4]>,
}

impl Canvas {
    pub(super) fn new(size: [usize; 2]) -> Self {
        Self { size, rgba: vec![[1.0; 4]; size[0] * size[1]] }
    }

    /// Outside the canvas nothing happens.
    pub(super) fn pixel(&mut self, x: usize, y: usize, [r, g, b]: [f32; 3]) {
        if x < self.size[0] && y < self.size[1] {
            self.rgba[y * self.size[0] + x] = [r, g, b, 1.0];
        }
    }

    /// In black.
    pub(super) fn box_of(&mut self, xs: Range<usize>, ys: Range<usize>) {
        for y in ys {
            for x in xs.clone() {
                self.pixel(x, y, [0.0; 3]);
            }
        }
    }

    /// In black; `y` is the top of the letters.
    pub(super) fn text(&mut self, text: &str, x: usize, anchor: Anchor, y: usize) {
        let width = text.chars().count() * lettering::ADVANCE;
        let start = match anchor {
            Anchor::Start => x,
            Anchor::Middle => x.saturating_sub(width / 2),
            Anchor::End => x.saturating_sub(width),
        };
        for (dx, dy) in lettering::pixels(text) {
            self.pixel(start + dx, y + dy, [0.0; 3]);
        }
    }

    pub(super) fn into_picture(self, header: Vec<(String, HeaderValue)>) -> Picture {
        let [width, height] = self.size.map(|side| side as u32);
        Picture { width, height, crop: None, rgba: self.rgba, layers: Vec::new(), header }
    }
}

/// Draws on a canvas for `plotters`. Letters have one size.
pub(super) struct Brush<'a>(pub(super) &'a mut Canvas);

type Outcome<T = ()> = Result<T, DrawingErrorKind<Infallible>>;

fn text_width(text: &str) -> i32 {
    (text.chars().count() * lettering::ADVANCE) as i32
}

impl DrawingBackend for Brush<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.0.size[0] as u32, self.0.size[1] as u32)
    }

    fn ensure_prepared(&mut self) -> Outcome {
        Ok(())
    }

    fn present(&mut self) -> Outcome {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Outcome {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return Ok(()) };
        if x >= self.0.size[0] || y >= self.0.size[1] {
            return Ok(());
        }
        let (r, g, b) = color.rgb;
        let ink = [r, g, b].map(|code| srgb_decode(f32::from(code) / 255.0));
        let under = self.0.rgba[y * self.0.size[0] + x];
        let alpha = color.alpha as f32;
        self.0.pixel(x, y, std::array::from_fn(|c| under[c] + alpha * (ink[c] - under[c])));
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Outcome {
        let (width, height) = (text_width(text), lettering::HEIGHT as i32);
        let anchor = style.anchor();
        let dx = match anchor.h_pos {
            HPos::Left => 0,
            HPos::Center => -width / 2,
            HPos::Right => -width,
        };
        let dy = match anchor.v_pos {
            VPos::Top => 0,
            VPos::Center => -height / 2,
            // Off the line that it stands on.
            VPos::Bottom => -height - 3,
        };
        let transform = style.transform();
        for (u, v) in lettering::pixels(text) {
            let (u, v) = transform.transform(dx + u as i32, dy + v as i32);
            self.draw_pixel((x + u, y + v), style.color())?;
        }
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(&self, text: &str, style: &S) -> Outcome<(u32, u32)> {
        let (width, height) = (text_width(text) as u32, lettering::HEIGHT as u32);
        Ok(match style.transform() {
            FontTransform::None | FontTransform::Rotate180 => (width, height),
            FontTransform::Rotate90 | FontTransform::Rotate270 => (height, width),
        })
    }

    /// Ink by how much of a pixel the line covers: the library's own lines are ragged.
    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Outcome {
        let color = style.color();
        let radius = 0.5 * f64::from(style.stroke_width());
        let reach = radius.ceil() as i32;
        let (start, step) = ((f64::from(from.0), f64::from(from.1)), (to.0 - from.0, to.1 - from.1));
        let (dx, dy) = (f64::from(step.0), f64::from(step.1));
        let length_squared = (dx * dx + dy * dy).max(1e-9);
        for y in from.1.min(to.1) - reach..=from.1.max(to.1) + reach {
            for x in from.0.min(to.0) - reach..=from.0.max(to.0) + reach {
                let (px, py) = (f64::from(x) - start.0, f64::from(y) - start.1);
                let along = ((px * dx + py * dy) / length_squared).clamp(0.0, 1.0);
                let distance = (px - along * dx).hypot(py - along * dy);
                let coverage = (radius + 0.5 - distance).clamp(0.0, 1.0);
                if coverage > 0.0 {
                    self.draw_pixel((x, y), color.mix(coverage))?;
                }
            }
        }
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Outcome {
        let points: Vec<BackendCoord> = path.into_iter().collect();
        for pair in points.windows(2) {
            self.draw_line(pair[0], pair[1], style)?;
        }
        Ok(())
    }
}
