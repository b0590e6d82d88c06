//! Options about the picture's pixels: how many, of what shape, and which of them.

use clap::Args;

use crate::document::RenderHints;
use crate::scene::{Raster, Window};

#[derive(Args)]
pub struct RasterArgs {
    /// Picture size in pixels; one of the two may be left out (`1280x`, `x720`)
    #[arg(short = 'r', long, value_name = "WxH", value_parser = parse_size)]
    size: Option<Size>,
    /// Render only W times H pixels from pixel X,Y on (from the upper left); they have the bits that they have in the whole
    /// picture, and EXR notes where in it they lie
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop)]
    crop: Option<Window>,
    /// Width of a pixel over its height, for anamorphic pictures [default: the scene's, or 1]
    #[arg(long, value_name = "RATIO", value_parser = parse_aspect)]
    pixel_aspect: Option<f32>,
}

#[derive(Clone, Copy)]
pub struct Size {
    pub width: Option<u32>,
    pub height: Option<u32>,
}

impl RasterArgs {
    /// What is meant: the command line over the scene's hints.
    pub fn raster(&self, hints: &RenderHints) -> Raster {
        let size = self.size.unwrap_or(Size { width: hints.width, height: hints.height });
        let pixel_aspect = self.pixel_aspect.or(hints.pixel_aspect).unwrap_or(1.0);
        Raster { size: [size.width, size.height], pixel_aspect, crop: self.crop }
    }
}

pub fn parse_size(text: &str) -> Result<Size, String> {
    let (width, height) = text.split_once(['x', 'X']).ok_or("write it as WIDTHxHEIGHT, like 1920x1080")?;
    let side = |digits: &str| match digits {
        "" => Ok(None),
        digits => match digits.parse() {
            Ok(side @ 1..=65_535) => Ok(Some(side)),
            _ => Err(format!("`{digits}` is not a whole number from 1 to 65535")),
        },
    };
    match (side(width)?, side(height)?) {
        (None, None) => Err("write it as WIDTHxHEIGHT, like 1920x1080".to_owned()),
        (width, height) => Ok(Size { width, height }),
    }
}

fn parse_crop(text: &str) -> Result<Window, String> {
    let wanted = || "write it as X,Y,WIDTH,HEIGHT in pixels, like 640,360,200,100".to_owned();
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.map_err(|_| wanted())?.as_slice() {
        &[x, y, width, height] if width > 0 && height > 0 => Ok(Window { x, y, width, height }),
        _ => Err(wanted()),
    }
}

fn parse_aspect(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(aspect) if (0.01..=100.0).contains(&aspect) => Ok(aspect),
        _ => Err("give a ratio from 0.01 to 100, like 2".to_owned()),
    }
}
