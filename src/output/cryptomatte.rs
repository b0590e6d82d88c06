//! Cryptomatte 1.2: mattes by name that compositors select from (Friedman & Jones 2015; the specification is at
//! github.com/Psyop/Cryptomatte).
//!
//! Each name has a 32-bit hash that is stored as the bits of a float. A pixel lists the names that it shows, the largest
//! share first, as pairs of hash and share; a layer holds two pairs. The header tells which hash is whose.

use std::collections::BTreeMap;

use super::picture::{HeaderValue, Layer, LayerKind};

/// Names per pixel: three layers.
const RANKS: usize = 6;

/// The layers `NAME00`, `NAME01`, `NAME02` and their header values. `shares` gives (pixel, id, share of it) with the pixels
/// in rising order; ids of the same name count together. Which names are beyond the sixth of a pixel is lost.
pub fn cryptomatte(
    name: &str,
    pixels: usize,
    shares: impl Iterator<Item = (usize, u32, f32)>,
    name_of: impl Fn(u32) -> String,
) -> (Vec<Layer>, Vec<(String, HeaderValue)>) {
    let mut layers = layers(name, pixels);
    let mut hashes: BTreeMap<u32, u32> = BTreeMap::new();
    let mut manifest = serde_json::Map::new();
    let mut here = (0, Vec::<(u32, f32)>::new());
    for (pixel, id, share) in shares {
        let hash = *hashes.entry(id).or_insert_with(|| {
            let (name, hash) = (name_of(id), hash(&name_of(id)));
            manifest.insert(name, format!("{hash:08x}").into());
            hash
        });
        if pixel != here.0 {
            rank(&mut layers, here.0, &mut here.1);
            here.0 = pixel;
        }
        match here.1.iter_mut().find(|(known, _)| *known == hash) {
            Some((_, sum)) => *sum += share,
            None => here.1.push((hash, share)),
        }
    }
    rank(&mut layers, here.0, &mut here.1);

    let key = format!("{:08x}", murmur3(name.as_bytes()));
    let header = [
        ("name", name.to_owned()),
        ("hash", "MurmurHash3_32".to_owned()),
        ("conversion", "uint32_to_float32".to_owned()),
        ("manifest", serde_json::Value::Object(manifest).to_string()),
    ];
    let header = header.map(|(entry, text)| (format!("cryptomatte/{}/{entry}", &key[..7]), HeaderValue::Text(text)));
    (layers, header.into())
}

fn layers(name: &str, pixels: usize) -> Vec<Layer> {
    let channel = |rank: usize, value: usize| {
        let letter = ["R", "G", "B", "A"][rank % 2 * 2 + value];
        let name = format!("{name}{:02}.{letter}", rank / 2);
        Layer { name, kind: LayerKind::Float, data: vec![0.0; pixels] }
    };
    (0..RANKS).flat_map(|rank| [channel(rank, 0), channel(rank, 1)]).collect()
}

/// Writes what a pixel shows, and forgets it.
fn rank(layers: &mut [Layer], pixel: usize, shares: &mut Vec<(u32, f32)>) {
    // Equal shares in the order of their hashes: the same on every machine.
    shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    for (pair, (hash, share)) in layers.chunks_exact_mut(2).zip(shares.drain(..)) {
        pair[0].data[pixel] = f32::from_bits(hash);
        pair[1].data[pixel] = share;
    }
}

/// A name's hash, changed in one bit where a float of these bits would be no usual number.
fn hash(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    match hash >> 23 & 255 {
        0 | 255 => hash ^ 1 << 23,
        _ => hash,
    }
}

/// MurmurHash3_x86_32 with seed 0. Austin Appleby, public domain.
fn murmur3(bytes: &[u8]) -> u32 {
    let scramble = |block: u32| block.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte));
    let blocks = bytes.chunks_exact(4);
    let rest = blocks.remainder();
    let mixed = blocks.fold(0u32, |hash, block| {
        (hash ^ scramble(word(block))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let hash = mixed ^ scramble(word(rest)) ^ bytes.len() as u32;
    let hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    let hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_the_reference_implementation() {
        for (text, expected) in [
            ("", 0),
            ("a", 0x3c25_69b2),
            ("hello", 0x248b_fa47),
            ("hello, world", 0x149b_bb7f),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
            // One of the names in Gaffer's test picture.
            ("/GAFFERBOT/C_torso_GRP/C_head_GRP/C_head_CPT/C_head001_REN", 4_226_998_693),
        ] {
            assert_eq!(murmur3(text.as_bytes()), expected, "{text:?}");
        }
        // Arnold's object mattes have the key f834d0a.
        assert_eq!(murmur3(b"crypto_object") >> 4, 0x0f83_4d0a);
    }

    #[test]
    fn the_largest_share_comes_first_and_names_count_once() {
        let names = ["red", "blue", "red"];
        let shares = [(1, 0, 0.25), (1, 1, 0.3), (1, 2, 0.25), (2, 1, 1.0)];
        let (layers, header) = cryptomatte("CryptoObject", 4, shares.into_iter(), |id| names[id as usize].to_owned());
        let values = |pixel: usize| layers.iter().map(|layer| layer.data[pixel].to_bits()).collect::<Vec<_>>();
        let [red, blue] = ["red", "blue"].map(hash);
        assert_eq!(values(1)[..6], [red, 0.5f32.to_bits(), blue, 0.3f32.to_bits(), 0, 0]);
        assert_eq!(values(2)[..4], [blue, 1f32.to_bits(), 0, 0]);
        assert_eq!(values(0), [0; 12]);
        let names: Vec<&str> = layers.iter().map(|layer| layer.name.as_str()).collect();
        assert_eq!((names[0], names[3], names[4]), ("CryptoObject00.R", "CryptoObject00.A", "CryptoObject01.R"));
        assert_eq!(header[0].0, "cryptomatte/3ae39a5/name");
        let HeaderValue::Text(manifest) = &header[3].1 else { unreachable!() };
        assert_eq!(*manifest, format!("{{\"blue\":\"{blue:08x}\",\"red\":\"{red:08x}\"}}"));
    }
}
