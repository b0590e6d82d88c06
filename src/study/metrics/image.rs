//! A picture as the metrics see it.

use crate::batch::aov::VARIANCE;
use crate::output::Picture;
use crate::render::Frame;

/// Linear sRGB, row by row from the upper left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    pub width: usize,
    pub height: usize,
    pub rgb: Vec<[f64; 3]>,
    /// Variance of each pixel's mean, per channel, where it is known.
    pub variance: Option<Vec<[f64; 3]>>,
}

impl From<&Picture> for Image {
    fn from(picture: &Picture) -> Self {
        let layer = |name: &str| picture.layers.iter().find(|layer| layer.name == name).map(|layer| &layer.data);
        let variance = match VARIANCE.map(layer) {
            [Some(r), Some(g), Some(b)] => {
                Some(r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b].map(f64::from)).collect())
            }
            _ => None,
        };
        let rgb = picture.rgba.iter().map(|&[r, g, b, _]| [r, g, b].map(f64::from)).collect();
        Self { width: picture.width as usize, height: picture.height as usize, rgb, variance }
    }
}

impl From<&Frame> for Image {
    fn from(frame: &Frame) -> Self {
        let wide = |values: &[[f32; 3]]| values.iter().map(|value| value.map(f64::from)).collect();
        Self {
            width: frame.width as usize,
            height: frame.height as usize,
            rgb: wide(&frame.rgb),
            variance: Some(wide(&frame.variance)),
        }
    }
}

#[cfg(test)]
impl Image {
    /// A picture of one row.
    pub(super) fn row(rgb: &[[f64; 3]]) -> Self {
        Self { width: rgb.len(), height: 1, rgb: rgb.to_vec(), variance: None }
    }
}
