//! Images on surfaces: decoding and bilinear lookup.

use std::sync::{Arc, LazyLock};

use glam::{Vec2, Vec3, Vec4};
use image::{ColorType, DynamicImage, ImageDecoder, Limits};

use super::BuildError;
use super::surface::{Surface, UV_SLOTS};
use crate::color::view;
use crate::document::{Channel4, Encoding, Image, ImageSource, Map, Scalar, Wrap};

/// A decoded image. Row 0 is the top.
pub struct Texture {
    width: usize,
    height: usize,
    texels: Texels,
}

enum Texels {
    /// These two as stored: sRGB or linear is decided by each [`Map`] that reads them.
    Byte(Vec<[u8; 4]>),
    Word(Vec<[u16; 4]>),
    Float(Vec<[f32; 4]>),
}

/// 8-bit sRGB code to linear value.
static SRGB_TO_LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| view::srgb_decode(code as f32 / 255.0)));

/// The same for 16 bits.
static SRGB16_TO_LINEAR: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=u16::MAX).map(|code| view::srgb_decode(f32::from(code) / 65535.0)).collect());

impl Texture {
    /// Reads and decodes an image file (PNG, JPEG, TGA, BMP, TIFF, HDR, EXR) that takes no more than `max_bytes` on the way:
    /// what it would take is known from its header.
    ///
    /// # Errors
    /// The file cannot be read, is not a picture, or is too large; the message names its URI and who refers to it.
    pub fn load(image: &Image, max_bytes: u64) -> Result<Self, BuildError> {
        let broken = |reason: String| BuildError::Image { uri: image.uri.clone(), user: image.user.clone(), reason };
        let read;
        let bytes = match &image.source {
            ImageSource::File(path) => {
                let size = std::fs::metadata(path).map_err(|e| broken(e.to_string()))?.len();
                check_size(size, max_bytes).map_err(broken)?;
                read = std::fs::read(path).map_err(|e| broken(e.to_string()))?;
                &read
            }
            ImageSource::Bytes(bytes) => bytes,
            ImageSource::Missing => return Ok(Self::magenta()),
        };
        let is_exr = bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]);
        if is_exr { Self::from_exr(bytes, max_bytes) } else { Self::decode(bytes, &image.uri, max_bytes) }
            .map_err(broken)
    }

    /// Anything but EXR.
    fn decode(bytes: &[u8], uri: &str, max_bytes: u64) -> Result<Self, String> {
        let reader = image::ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format();
        let mut reader = reader.map_err(|error| error.to_string())?;
        // TGA has no signature: go by the name.
        if let (None, Ok(format)) = (reader.format(), image::ImageFormat::from_path(uri)) {
            reader.set_format(format);
        }
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(max_bytes);
        reader.limits(limits);
        let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
        let (width, height) = decoder.dimensions();
        if width == 0 || height == 0 {
            return Err("it has no pixels".to_owned());
        }
        let texel_bytes = match decoder.color_type() {
            ColorType::Rgb32F | ColorType::Rgba32F => 16,
            ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => 8,
            _ => 4,
        };
        // As it is decoded, with four channels, and as it stays.
        let texels = u64::from(width) * u64::from(height) * texel_bytes;
        check_size(decoder.total_bytes().saturating_add(2 * texels), max_bytes)?;
        let image = DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())?;
        Ok(Self::from_image(&image))
    }

    fn from_image(image: &DynamicImage) -> Self {
        let (width, height) = (image.width() as usize, image.height() as usize);
        let texels = match image {
            DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
                Texels::Float(image.to_rgba32f().pixels().map(|p| p.0).collect())
            }
            DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_)
            | DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_) => Texels::Word(image.to_rgba16().pixels().map(|p| p.0).collect()),
            _ => Texels::Byte(image.to_rgba8().pixels().map(|p| p.0).collect()),
        };
        Self { width, height, texels }
    }

    /// The first layer with red, green and blue, or of one channel alone (`Y`, or any): a thickness is often written so.
    fn from_exr(bytes: &[u8], max_bytes: u64) -> Result<Self, String> {
        let meta = exr::meta::MetaData::read_from_buffered(std::io::Cursor::new(bytes), false);
        let needed = meta.map_err(|error| error.to_string())?.headers.iter().fold(0u64, |sum, header| {
            let pixels = header.layer_size.area() as u64;
            let channels = header.channels.list.iter().map(|channel| channel.sample_type.bytes_per_sample() as u64);
            // As it is read, and as it stays.
            sum.saturating_add(pixels.saturating_mul(channels.sum::<u64>() + 16))
        });
        check_size(needed, max_bytes)?;
        use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
        let picture = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_buffered(std::io::Cursor::new(bytes))
            .map_err(|error| error.to_string())?;
        let colours = ["R", "G", "B"];
        for layer in &picture.layer_data {
            let channels = &layer.channel_data.list;
            let named = |name: &str| channels.iter().find(|channel| channel.name.eq(name)).map(|c| &c.sample_data);
            let (columns, rows) = (layer.size.width(), layer.size.height());
            if columns == 0 || rows == 0 {
                continue;
            }
            let rgb: Option<Vec<&FlatSamples>> = colours.iter().map(|name| named(name)).collect();
            let grey = named("Y").or_else(|| match channels.as_slice() {
                [only] => Some(&only.sample_data),
                _ => None,
            });
            let Some(rgb) = rgb.or_else(|| grey.map(|grey| vec![grey; 3])) else { continue };
            // Channels of halved resolution are refused by the reader.
            let value = |samples: &FlatSamples, i: usize| samples.value_by_flat_index(i).to_f32();
            let alpha = named("A");
            let texel = |i: usize| {
                let [r, g, b] = [0, 1, 2].map(|channel: usize| value(rgb[channel], i));
                [r, g, b, alpha.map_or(1.0, |alpha| value(alpha, i))]
            };
            return Ok(Self {
                width: columns,
                height: rows,
                texels: Texels::Float((0..columns * rows).map(texel).collect()),
            });
        }
        Err("no layer has channels R, G and B, or one channel alone".to_owned())
    }

    /// One glaring texel in place of a missing image.
    fn magenta() -> Self {
        Self { width: 1, height: 1, texels: Texels::Float(vec![[1.0, 0.0, 1.0, 1.0]]) }
    }

    /// What it keeps in memory.
    pub fn bytes(&self) -> u64 {
        let texel_bytes = match self.texels {
            Texels::Byte(_) => 4,
            Texels::Word(_) => 8,
            Texels::Float(_) => 16,
        };
        (self.width * self.height) as u64 * texel_bytes
    }

    pub fn width(&self) -> usize {
        self.width
    }

    pub fn height(&self) -> usize {
        self.height
    }

    /// The texel in column x of row y, linear. Floating-point images are linear whatever the encoding says.
    pub fn texel(&self, x: usize, y: usize, encoding: Encoding) -> Vec4 {
        let index = y * self.width + x;
        match &self.texels {
            Texels::Float(texels) => Vec4::from_array(texels[index]),
            Texels::Byte(texels) => {
                let [r, g, b, a] = texels[index];
                let decode = |code: u8| match encoding {
                    Encoding::Srgb => SRGB_TO_LINEAR[code as usize],
                    Encoding::Linear => f32::from(code) / 255.0,
                };
                Vec4::new(decode(r), decode(g), decode(b), f32::from(a) / 255.0)
            }
            Texels::Word(texels) => {
                let [r, g, b, a] = texels[index];
                let decode = |code: u16| match encoding {
                    Encoding::Srgb => SRGB16_TO_LINEAR[usize::from(code)],
                    Encoding::Linear => f32::from(code) / 65535.0,
                };
                Vec4::new(decode(r), decode(g), decode(b), f32::from(a) / 65535.0)
            }
        }
    }

    /// Bilinear lookup; (0, 0) is the lower left corner of the image.
    pub fn lookup(&self, uv: Vec2, wrap: [Wrap; 2], encoding: Encoding) -> Vec4 {
        if !uv.is_finite() {
            return Vec4::ZERO;
        }
        let x = uv.x * self.width as f32 - 0.5;
        let y = (1.0 - uv.y) * self.height as f32 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let at =
            |dx: f32, dy: f32| match (wrapped(x0 + dx, self.width, wrap[0]), wrapped(y0 + dy, self.height, wrap[1])) {
                (Some(column), Some(row)) => self.texel(column, row, encoding),
                _ => Vec4::ZERO,
            };
        let top = at(0.0, 0.0).lerp(at(1.0, 0.0), fx);
        let bottom = at(0.0, 1.0).lerp(at(1.0, 1.0), fx);
        top.lerp(bottom, fy)
    }
}

/// Refuses what would not fit: a failed allocation could only abort the program.
fn check_size(bytes: u64, max_bytes: u64) -> Result<(), String> {
    if bytes <= max_bytes {
        return Ok(());
    }
    Err(format!("it takes {bytes} bytes, but only {max_bytes} are available; make it smaller or raise --max-memory"))
}

/// The texel number for a coordinate outside or inside 0..count; `None` in a border.
fn wrapped(position: f32, count: usize, wrap: Wrap) -> Option<usize> {
    let n = count as f32;
    let inside = match wrap {
        Wrap::Repeat => position.rem_euclid(n),
        Wrap::Clamp => position.clamp(0.0, n - 1.0),
        Wrap::Mirror => {
            let p = position.rem_euclid(2.0 * n);
            if p < n { p } else { 2.0 * n - 1.0 - p }
        }
        Wrap::Border if !(0.0..n).contains(&position) => return None,
        Wrap::Border => position,
    };
    Some((inside as usize).min(count - 1))
}

/// RGB at a surface point with these texture coordinates.
pub fn lookup_rgb(textures: &[Arc<Texture>], map: &Map, uv: &[Vec2; UV_SLOTS]) -> Vec3 {
    textures[map.image].lookup(uv[map.slot], map.wrap, map.encoding).truncate()
}

/// One channel at a surface point with these texture coordinates.
pub fn lookup_scalar(textures: &[Arc<Texture>], map: &Map, uv: &[Vec2; UV_SLOTS]) -> f32 {
    let texel = textures[map.image].lookup(uv[map.slot], map.wrap, map.encoding);
    match map.channel {
        Channel4::R => texel.x,
        Channel4::G => texel.y,
        Channel4::B => texel.z,
        Channel4::A => texel.w,
        Channel4::Luminance => texel.truncate().dot(Vec3::new(0.2126, 0.7152, 0.0722)),
    }
}

/// A number that may vary over a surface.
#[inline]
pub fn scalar(value: &Scalar, surface: &Surface, textures: &[Arc<Texture>]) -> f32 {
    match &value.map {
        Some(map) => value.range[0] + (value.range[1] - value.range[0]) * lookup_scalar(textures, map, &surface.uv),
        None => value.value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lookups_blend_and_wrap() {
        let texels = vec![[0, 0, 0, 255], [255, 255, 255, 255]];
        let texture = Texture { width: 2, height: 1, texels: Texels::Byte(texels) };
        let value = |u: f32, wrap| texture.lookup(Vec2::new(u, 0.5), [wrap, Wrap::Clamp], Encoding::Linear).x;
        assert!((value(0.5, Wrap::Clamp) - 0.5).abs() < 1e-6);
        assert_eq!(value(-3.0, Wrap::Clamp), 0.0);
        assert!((value(1.0, Wrap::Repeat) - 0.5).abs() < 1e-6);
        assert_eq!(value(1.0, Wrap::Mirror), 1.0);
        assert_eq!(value(1.8, Wrap::Border), 0.0);
    }
}
