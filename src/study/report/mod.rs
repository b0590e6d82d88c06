//! The report of a batch for people: where the time went, as a chart, and one HTML page with everything.

mod canvas;
mod chart;
mod html;

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageError};

use crate::batch::Thumbnail;
use crate::batch::frames::Pattern;
use crate::batch::record::Record;
use crate::error::Error;
use crate::output::{self, OutputError};

/// Of the small pictures on the contact sheet, 1 to 100.
const JPEG_QUALITY: u8 = 88;

/// Writes `base.svg` and `base.png`, the chart, and `base.html`, which needs neither: chart, contact sheet and table.
///
/// # Errors
/// Files that cannot be written.
pub fn write(record: &Record, thumbnails: &[(u32, Thumbnail)], pattern: &Pattern) -> Result<(), Error> {
    let rows: Vec<_> = record.rows().collect();
    let canvas = chart::draw(&rows);
    let svg = canvas.to_svg();
    output::write_text(&record.path("svg"), &svg)?;
    let (png, html) = (record.path("png"), record.path("html"));
    output::write_bytes(&png, &canvas.to_png().map_err(failed(&png))?)?;
    let pictures = thumbnails.iter().map(|(frame, thumbnail)| Ok((*frame, data_uri(thumbnail)?)));
    let pictures: Vec<(u32, String)> = pictures.collect::<Result<_, ImageError>>().map_err(failed(&html))?;
    output::write_text(&html, &html::page(record, &rows, &svg, &pictures, pattern))?;
    Ok(())
}

/// The picture as text that stands in a page.
fn data_uri(thumbnail: &Thumbnail) -> Result<String, ImageError> {
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY).encode(
        &thumbnail.rgb,
        thumbnail.width,
        thumbnail.height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(format!("data:image/jpeg;base64,{}", STANDARD.encode(jpeg)))
}

fn failed(path: &Path) -> impl Fn(ImageError) -> OutputError {
    |error| OutputError::Picture { path: path.to_owned(), reason: error.to_string() }
}
