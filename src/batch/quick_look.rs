//! Layers as pictures to look at, for PNG, which has no layers.

use super::aov::DENOISED;
use crate::color::view::srgb_decode as signal;
use crate::output::{Layer, Picture};
use crate::render::FAR_M;

/// Where a scale ends: this share of the pixels may be beyond it.
const BEYOND: f32 = 0.01;

/// A picture of each group of layers (`N` of `N.X`, `N.Y`, `N.Z`), with its name. Values are mapped to what a screen can
/// show: normals from -1..1 to 0..1, depth from near white to far grey (and black where there is nothing), positions over
/// the box of what is seen, others over 0 to the largest; mattes get a colour for each name.
pub fn quick_looks(picture: &Picture) -> Vec<(String, Picture)> {
    let mut names: Vec<&str> = Vec::new();
    for layer in &picture.layers {
        let name = group(layer);
        if !names.contains(&name) && name != DENOISED {
            names.push(name);
        }
    }
    let look = |name: &str| {
        let layers: Vec<&Layer> = picture.layers.iter().filter(|layer| group(layer) == name).collect();
        let rgba = pixels(name, &layers).into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect();
        let (width, height) = (picture.width, picture.height);
        (name.to_owned(), Picture { width, height, crop: picture.crop, rgba, ..Picture::default() })
    };
    names.into_iter().map(look).collect()
}

/// The picture with the colours of its denoised layers, if it has them.
pub fn denoised(picture: &Picture) -> Option<Picture> {
    let layers: Vec<&Layer> = picture.layers.iter().filter(|layer| group(layer) == DENOISED).collect();
    let [r, g, b] = layers.as_slice() else { return None };
    let mut denoised = Picture { layers: Vec::new(), ..picture.clone() };
    for (index, pixel) in denoised.rgba.iter_mut().enumerate() {
        pixel[..3].copy_from_slice(&[r.data[index], g.data[index], b.data[index]]);
    }
    Some(denoised)
}

/// Layers of one matte count as one.
fn group(layer: &Layer) -> &str {
    let name = layer.name.split('.').next().unwrap_or_default();
    if name.starts_with("Crypto") { name.trim_end_matches(|c: char| c.is_ascii_digit()) } else { name }
}

/// The linear values of a group's picture.
fn pixels(name: &str, layers: &[&Layer]) -> Vec<[f32; 3]> {
    if name.starts_with("Crypto") {
        return mattes(layers);
    }
    let count = layers.first().map_or(0, |layer| layer.data.len());
    // What has one channel is grey, what has two lacks blue.
    let value = |index: usize, channel: usize| match (layers.len(), layers.get(channel)) {
        (1, _) => layers[0].data[index],
        (_, Some(layer)) => layer.data[index],
        (_, None) => 0.0,
    };
    let values = (0..count).map(|index| std::array::from_fn::<f32, 3, _>(|channel| value(index, channel)));
    match name {
        "N" | "Ng" => values.map(|n| if n == [0.0; 3] { n } else { n.map(|x| signal(0.5 + 0.5 * x)) }).collect(),
        "UV" => values.map(|uv| uv.map(|x| signal(x - x.floor()))).collect(),
        "Z" => {
            let there = |z: &f32| *z < FAR_M;
            // Inverse depth, so that a far horizon leaves room for what is near.
            let inverse = |z: f32| 1.0 / z.max(f32::MIN_POSITIVE);
            let (far, near) = range(layers[0].data.iter().copied().filter(there).map(inverse));
            let grey = |z: f32| if there(&z) { signal(0.1 + 0.9 * share(inverse(z), far, near)) } else { 0.0 };
            values.map(|z| z.map(grey)).collect()
        }
        "P" => {
            let there = |p: &[f32; 3]| *p != [0.0; 3];
            let ranges: [_; 3] =
                std::array::from_fn(|axis| range(values.clone().filter(there).map(|position| position[axis])));
            let place =
                |p: [f32; 3]| std::array::from_fn(|axis| signal(share(p[axis], ranges[axis].0, ranges[axis].1)));
            values.map(|p| if there(&p) { place(p) } else { p }).collect()
        }
        "variance" => scaled(values.map(|variance| variance.map(f32::sqrt)).collect(), BEYOND),
        "film" | "sampleCount" => scaled(values.collect(), 0.0),
        _ => values.collect(),
    }
}

/// From 0 to the largest value, but for this share of the values.
fn scaled(values: Vec<[f32; 3]>, beyond: f32) -> Vec<[f32; 3]> {
    let mut sorted: Vec<f32> = values.iter().flatten().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f32::total_cmp);
    let last = sorted.len().saturating_sub(1);
    let top = sorted.get(last - (beyond * last as f32) as usize).copied().unwrap_or(0.0);
    values.into_iter().map(|value| value.map(|x| signal(share(x, 0.0, top)))).collect()
}

/// Names in colours that their hashes give, mixed by their shares.
fn mattes(layers: &[&Layer]) -> Vec<[f32; 3]> {
    let count = layers.first().map_or(0, |layer| layer.data.len());
    let mut mixed = vec![[0.0; 3]; count];
    for pair in layers.chunks_exact(2) {
        for (pixel, (hash, share)) in mixed.iter_mut().zip(pair[0].data.iter().zip(&pair[1].data)) {
            let bytes = hash.to_bits().to_le_bytes();
            for (value, byte) in pixel.iter_mut().zip(bytes) {
                *value += share * signal(0.2 + 0.8 * f32::from(byte) / 255.0);
            }
        }
    }
    mixed
}

fn range(values: impl Iterator<Item = f32>) -> (f32, f32) {
    values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// Where a value lies between two others, 0..1.
fn share(value: f32, low: f32, high: f32) -> f32 {
    if high > low { ((value - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 }
}
