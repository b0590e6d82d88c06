//! The picture that a camera fills: how many pixels, of what shape, and which of them are wanted.

use serde::{Deserialize, Serialize};

/// Default picture when nobody says: the long side, pixels.
const DEFAULT_LONG_SIDE: f32 = 960.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// Width and height in pixels; what is missing follows from the camera's aspect.
    pub size: [Option<u32>; 2],
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// The part that is rendered, where it is not all.
    pub crop: Option<Window>,
}

/// A rectangle of a picture, in pixels from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

impl From<[Option<u32>; 2]> for Raster {
    /// Square pixels, all of them.
    fn from(size: [Option<u32>; 2]) -> Self {
        Self { size, pixel_aspect: 1.0, crop: None }
    }
}

impl Raster {
    /// Pixels, for a camera that by itself asks for this width over height.
    pub(super) fn pixels(&self, aspect: f32) -> [u32; 2] {
        // Of pixels that are wide fewer fill the width.
        let aspect = aspect / self.pixel_aspect;
        let pixels = |length: f32| (length.round() as u32).max(1);
        match self.size {
            [Some(width), Some(height)] => [width, height],
            [Some(width), None] => [width, pixels(width as f32 / aspect)],
            [None, Some(height)] => [pixels(height as f32 * aspect), height],
            [None, None] if aspect >= 1.0 => [pixels(DEFAULT_LONG_SIDE), pixels(DEFAULT_LONG_SIDE / aspect)],
            [None, None] => [pixels(DEFAULT_LONG_SIDE * aspect), pixels(DEFAULT_LONG_SIDE)],
        }
    }
}

impl Window {
    /// All of a picture.
    pub fn whole([width, height]: [u32; 2]) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    pub fn fits(&self, [width, height]: [u32; 2]) -> bool {
        let within = |at: u32, length: u32, side: u32| length > 0 && at < side && length <= side - at;
        within(self.x, self.width, width) && within(self.y, self.height, height)
    }

    /// Where a pixel of the picture lies in the window, row by row; `None` outside.
    pub fn index_of(&self, [x, y]: [u32; 2]) -> Option<usize> {
        let (column, row) = (x.checked_sub(self.x)?, y.checked_sub(self.y)?);
        (column < self.width && row < self.height).then(|| row as usize * self.width as usize + column as usize)
    }

    /// True where the two share a pixel.
    pub fn touches(&self, other: &Self) -> bool {
        let meet = |a: u32, a_length: u32, b: u32, b_length: u32| a < b + b_length && b < a + a_length;
        meet(self.x, self.width, other.x, other.width) && meet(self.y, self.height, other.y, other.height)
    }
}
