//! OpenEXR: one part, scan lines, ZIP; bare R, G, B, A and extra channels by their full names.

use std::collections::{BTreeSet, HashMap};
use std::io::Cursor;
use std::path::Path;

use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image, ImageAttributes,
    IntegerBounds, LayerAttributes, LineOrder, Text, Vec2, WritableImage, f16,
};

use super::atomic;
use super::error::OutputError;
use super::picture::{HeaderValue, Layer, LayerKind, PIXEL_ASPECT, Picture, Written};

/// Rec. 709 with D65, the space of [`Picture::rgba`].
const CHROMATICITIES: Chromaticities =
    Chromaticities { red: Vec2(0.64, 0.33), green: Vec2(0.3, 0.6), blue: Vec2(0.15, 0.06), white: Vec2(0.3127, 0.329) };

/// Writes a picture; R, G, B, A are half floats, or 32-bit if `float`. The same picture gives the same bytes.
///
/// # Errors
/// Sizes that do not fit, names that appear twice, or what the system says; the old file is untouched then.
pub fn write_exr(path: &Path, picture: &Picture, float: bool) -> Result<Written, OutputError> {
    let mut written = Written::default();
    let bytes = encode(picture, float, &mut written).map_err(|reason| OutputError::picture(path, reason))?;
    atomic::save(path, &bytes)?;
    Ok(written)
}

fn encode(picture: &Picture, float: bool, written: &mut Written) -> Result<Vec<u8>, String> {
    picture.check()?;
    let beauty = if float { LayerKind::Float } else { LayerKind::Half };
    let mut channels = Vec::with_capacity(4 + picture.layers.len());
    for (index, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
        channels.push(channel(name, beauty, picture.rgba.iter().map(|pixel| pixel[index]), written)?);
    }
    for Layer { name, kind, data } in &picture.layers {
        channels.push(channel(name, *kind, data.iter().copied(), written)?);
    }
    let mut names = BTreeSet::new();
    if let Some(twice) = channels.iter().find(|channel| !names.insert(channel.name.bytes().to_vec())) {
        return Err(format!("the channel {} appears twice", twice.name));
    }

    let size = Vec2(picture.width as usize, picture.height as usize);
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        // Not the order in which threads finish.
        line_order: LineOrder::Increasing,
    };
    let mut layer = exr::prelude::Layer::new(
        size,
        LayerAttributes { software_name: Some(text(&software())?), ..LayerAttributes::default() },
        encoding,
        AnyChannels::sort(channels.into()),
    );
    let mut display_window = IntegerBounds::from_dimensions(size);
    if let Some(crop) = picture.crop {
        layer.attributes.layer_position = Vec2(signed(crop.x)?, signed(crop.y)?);
        display_window = IntegerBounds::from_dimensions((crop.full_width as usize, crop.full_height as usize));
    }
    let mut image = Image::from_layer(layer);
    image.attributes = ImageAttributes {
        display_window,
        pixel_aspect: picture.pixel_aspect(),
        chromaticities: Some(CHROMATICITIES),
        time_code: None,
        other: header(&picture.header)?,
    };

    let mut file = Cursor::new(Vec::new());
    image.write().to_buffered(&mut file).map_err(|error| error.to_string())?;
    let mut bytes = file.into_inner();
    sort_attributes(&mut bytes).ok_or("the header that was encoded cannot be read")?;
    Ok(bytes)
}

fn software() -> String {
    format!("pellicle {}", env!("CARGO_PKG_VERSION"))
}

fn channel(
    name: &str,
    kind: LayerKind,
    values: impl Iterator<Item = f32>,
    written: &mut Written,
) -> Result<AnyChannel<FlatSamples>, String> {
    let samples = match kind {
        LayerKind::Half => FlatSamples::F16(values.map(|value| half(value, &mut written.clamped)).collect()),
        LayerKind::Float => FlatSamples::F32(values.collect()),
        LayerKind::Uint => FlatSamples::U32(values.map(|value| value as u32).collect()),
    };
    Ok(AnyChannel::new(text(name)?, samples))
}

/// The nearest half; beyond the largest one the largest one, counted.
fn half(value: f32, clamped: &mut u64) -> f16 {
    let limit = f16::MAX.to_f32();
    if value.abs() > limit {
        *clamped += 1;
    }
    // NaN stays NaN.
    f16::from_f32(value.clamp(-limit, limit))
}

fn header(values: &[(String, HeaderValue)]) -> Result<HashMap<Text, AttributeValue>, String> {
    let mut attributes = HashMap::new();
    // EXR has a place of its own for the pixels' aspect.
    for (name, value) in values.iter().filter(|(name, _)| name != PIXEL_ASPECT) {
        let value = match value {
            HeaderValue::Text(value) => AttributeValue::Text(text(value)?),
            HeaderValue::Int(value) => AttributeValue::I32(*value),
            HeaderValue::Float(value) => AttributeValue::F32(*value),
        };
        if attributes.insert(text(name)?, value).is_some() {
            return Err(format!("the header value {name} appears twice"));
        }
    }
    Ok(attributes)
}

/// EXR strings are bytes; UTF-8 by convention.
fn text(value: &str) -> Result<Text, String> {
    if value.contains('\0') {
        return Err(format!("{value:?} holds a NUL"));
    }
    Ok(Text::from_slice_unchecked(value.as_bytes()))
}

fn signed(value: u32) -> Result<i32, String> {
    i32::try_from(value).map_err(|_| format!("a crop at {value} is too far out"))
}

/// Puts the header's attributes into the order of their names: the encoder keeps some in a hash map, and the same picture
/// would give other bytes in each run. A header is a list of (name NUL, type NUL, i32 size, value), ended by a NUL, after
/// 8 bytes of magic number and version; offsets that follow do not change, as the length stays.
fn sort_attributes(file: &mut [u8]) -> Option<()> {
    const START: usize = 8;
    let mut attributes: Vec<&[u8]> = Vec::new();
    let mut rest = file.get(START..)?;
    while *rest.first()? != 0 {
        let name = rest.iter().position(|&byte| byte == 0)? + 1;
        let kind = rest.get(name..)?.iter().position(|&byte| byte == 0)? + 1;
        let size = rest.get(name + kind..name + kind + 4)?;
        let length = name + kind + 4 + usize::try_from(i32::from_le_bytes(size.try_into().ok()?)).ok()?;
        let (attribute, after) = rest.split_at_checked(length)?;
        attributes.push(attribute);
        rest = after;
    }
    // The NUL after the name sorts before every other byte, so whole attributes compare like their names.
    attributes.sort_unstable();
    let sorted = attributes.concat();
    file.get_mut(START..START + sorted.len())?.copy_from_slice(&sorted);
    Some(())
}
