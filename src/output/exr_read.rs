//! Reading back what [`write_exr`](super::write_exr) wrote, to compare, merge and resume.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use exr::prelude::{
    AnyChannels, AttributeValue, FlatSamples, IntegerBounds, ReadChannels, ReadLayers, Text, Vec2, read,
};

use super::error::OutputError;
use super::picture::{Crop, HeaderValue, Layer, LayerKind, PIXEL_ASPECT, Picture};

/// Reads an EXR of one flat part. Missing R, G, B are 0, a missing A is 1. Other channels become layers, in the order of
/// their names; text, whole numbers and floats of the header that are not part of the format itself become
/// [`Picture::header`], in the order of their names.
///
/// # Errors
/// A file that is missing, damaged, cut short, or not such an EXR.
pub fn read_exr(path: &Path) -> Result<Picture, OutputError> {
    let file = File::open(path).map_err(OutputError::io("open", path))?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(BufReader::new(file))
        .map_err(|error| OutputError::damaged(path, error))?;
    let layer = image.layer_data;
    let damaged = |reason: &str| OutputError::damaged(path, reason);
    let (width, height) = match (u32::try_from(layer.size.0), u32::try_from(layer.size.1)) {
        (Ok(width), Ok(height)) => (width, height),
        _ => return Err(damaged("too large")),
    };
    let crop = crop(layer.attributes.layer_position, layer.size, image.attributes.display_window)
        .map_err(|()| damaged("pixels before the frame's corner are not supported"))?;

    let mut header = header(image.attributes.other.iter().chain(&layer.attributes.other));
    if image.attributes.pixel_aspect != 1.0 {
        header.push((PIXEL_ASPECT.to_owned(), HeaderValue::Float(image.attributes.pixel_aspect)));
    }
    header.sort_by(|a, b| a.0.cmp(&b.0));
    let (rgba, layers) = channels(layer.channel_data, width as usize * height as usize);
    Ok(Picture { width, height, crop, rgba, layers, header })
}

/// True if every block that the header promises is in the file.
pub(super) fn is_complete(path: &Path) -> bool {
    let walk = || -> exr::error::Result<()> {
        let reader = exr::block::read(BufReader::new(File::open(path)?), true)?;
        for chunk in reader.all_chunks(true)? {
            chunk?;
        }
        Ok(())
    };
    walk().is_ok()
}

fn channels(channels: AnyChannels<FlatSamples>, pixels: usize) -> (Vec<[f32; 4]>, Vec<Layer>) {
    let mut rgba = vec![[0.0, 0.0, 0.0, 1.0]; pixels];
    let mut layers = Vec::new();
    for channel in channels.list {
        let name = utf8(&channel.name);
        match ["R", "G", "B", "A"].iter().position(|&beauty| beauty == name) {
            Some(index) => {
                for (pixel, value) in rgba.iter_mut().zip(channel.sample_data.values_as_f32()) {
                    pixel[index] = value;
                }
            }
            None => {
                let kind = match channel.sample_data {
                    FlatSamples::F16(_) => LayerKind::Half,
                    FlatSamples::F32(_) => LayerKind::Float,
                    FlatSamples::U32(_) => LayerKind::Uint,
                };
                layers.push(Layer { name, kind, data: channel.sample_data.values_as_f32().collect() });
            }
        }
    }
    (rgba, layers)
}

fn header<'a>(attributes: impl Iterator<Item = (&'a Text, &'a AttributeValue)>) -> Vec<(String, HeaderValue)> {
    let value = |value: &AttributeValue| match value {
        AttributeValue::Text(text) => Some(HeaderValue::Text(utf8(text))),
        AttributeValue::I32(number) => Some(HeaderValue::Int(*number)),
        AttributeValue::F32(number) => Some(HeaderValue::Float(*number)),
        _ => None,
    };
    attributes.filter_map(|(name, attribute)| Some((utf8(name), value(attribute)?))).collect()
}

fn utf8(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}

/// Where the data window lies in the display window; none when they are the same.
fn crop(position: Vec2<i32>, size: Vec2<usize>, display: IntegerBounds) -> Result<Option<Crop>, ()> {
    if position == display.position && size == display.size {
        return Ok(None);
    }
    let inside =
        |value: i32, start: i32| value.checked_sub(start).and_then(|offset| u32::try_from(offset).ok()).ok_or(());
    Ok(Some(Crop {
        x: inside(position.0, display.position.0)?,
        y: inside(position.1, display.position.1)?,
        full_width: u32::try_from(display.size.0).map_err(|_| ())?,
        full_height: u32::try_from(display.size.1).map_err(|_| ())?,
    }))
}
