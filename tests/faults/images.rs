//! Images that are not there, are broken, or unpack to more than the memory holds.

use std::io::Cursor;

use image::{ColorType, ImageEncoder, ImageFormat};

use super::*;

fn scene(image: &str) -> String {
    let map = format!("<diffuse reflectance=\"0.5\"><map for=\"reflectance\" image=\"{image}\"/></diffuse>");
    room(&[("<diffuse reflectance=\"0.5\"/>", &map)])
}

/// A grey square.
fn encoded(format: ImageFormat, side: u32) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let image = image::DynamicImage::ImageRgb8(image::RgbImage::from_pixel(side, side, image::Rgb([128; 3])));
    match format {
        ImageFormat::Hdr => image.to_rgb32f().write_to(&mut bytes, format).unwrap(),
        _ => image.write_to(&mut bytes, format).unwrap(),
    }
    bytes.into_inner()
}

fn exr(side: usize) -> Vec<u8> {
    use exr::prelude::{SpecificChannels, WritableImage};
    let mut bytes = Cursor::new(Vec::new());
    let channels = SpecificChannels::rgb(|_| (0.5f32, 0.5f32, 0.5f32));
    exr::prelude::Image::from_channels((side, side), channels).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// Replaces the first run of bytes.
fn patched(mut bytes: Vec<u8>, old: &[u8], new: &[u8]) -> Vec<u8> {
    let at = bytes.windows(old.len()).position(|window| window == old).expect("the bytes to be replaced");
    bytes.splice(at..at + old.len(), new.iter().copied());
    bytes
}

/// Small files that claim to be some 30 000 pixels square.
fn claims() -> Vec<(&'static str, Vec<u8>)> {
    const SIDE: u32 = 29_999;
    let (little, big) = (SIDE.to_le_bytes(), SIDE.to_be_bytes());
    let mut png = encoded(ImageFormat::Png, 7);
    png[16..20].copy_from_slice(&big);
    png[20..24].copy_from_slice(&big);
    let checksum = crc(&png[12..29]);
    png[29..33].copy_from_slice(&checksum.to_be_bytes());
    let mut bmp = encoded(ImageFormat::Bmp, 7);
    bmp[18..22].copy_from_slice(&little);
    bmp[22..26].copy_from_slice(&little);
    let mut tga = encoded(ImageFormat::Tga, 7);
    tga[12..14].copy_from_slice(&little[..2]);
    tga[14..16].copy_from_slice(&little[..2]);
    let jpeg = encoded(ImageFormat::Jpeg, 7);
    let frame = jpeg.windows(2).position(|bytes| bytes == [0xFF, 0xC0]).expect("a frame header");
    let mut jpeg = jpeg;
    jpeg[frame + 5..frame + 7].copy_from_slice(&big[2..]);
    jpeg[frame + 7..frame + 9].copy_from_slice(&big[2..]);
    let tag = |number: u16, value: u32| [&number.to_le_bytes()[..], &[4, 0, 1, 0, 0, 0], &value.to_le_bytes()].concat();
    // Grey, 8 bits, one strip as long as promised.
    let tags =
        [(256, SIDE), (257, SIDE), (258, 8), (259, 1), (262, 1), (273, 8), (277, 1), (278, SIDE), (279, SIDE * SIDE)];
    let entries: Vec<u8> = tags.iter().flat_map(|&(number, value)| tag(number, value)).collect();
    let tiff = [&b"II*\0\x08\0\0\0\x09\0"[..], &entries, &[0; 4]].concat();
    let hdr = patched(encoded(ImageFormat::Hdr, 7), b"-Y 7 +X 7", b"-Y 29999 +X 29999");
    let mut window = b"dataWindow\0box2i\0\x10\0\0\0".to_vec();
    let old = [window.clone(), [0, 0, 6, 6].iter().flat_map(|n: &i32| n.to_le_bytes()).collect()].concat();
    window.extend([0, 0, 29_998, 29_998].iter().flat_map(|n: &i32| n.to_le_bytes()));
    let exr = patched(exr(7), &old, &window);
    vec![
        ("a.png", png),
        ("a.bmp", bmp),
        ("a.tga", tga),
        ("a.jpg", jpeg),
        ("a.tif", tiff),
        ("a.hdr", hdr),
        ("a.exr", exr),
    ]
}

/// CRC-32, as PNG has it.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 })
    })
}

#[test]
fn images_that_unpack_beyond_the_limit_are_refused_with_their_bytes() {
    let folder = Folder::new("image-bombs");
    for (name, bytes) in claims() {
        fs::write(folder.file(name), bytes).unwrap();
        let refusal = [&format!("image `{name}` of material `grey`: it takes "), "bytes, but only "];
        refuses(&folder, scene(name), &["--max-memory", "500M"], &refusal);
    }
    // All images together have the limit that each has alone.
    let mut bytes = Vec::new();
    let pixels = vec![7; 1000 * 1000 * 3];
    image::codecs::png::PngEncoder::new(&mut bytes).write_image(&pixels, 1000, 1000, ColorType::Rgb8.into()).unwrap();
    let maps: String = (0..20).map(|i| format!("<effect id=\"fx{i}\"><extra><technique profile=\"pellicle\"><diffuse reflectance=\"1\"><map for=\"reflectance\" image=\"{i}.png\"/></diffuse></technique></extra></effect>")).collect();
    let materials: String =
        (0..20).map(|i| format!("<material id=\"m{i}\"><instance_effect url=\"#fx{i}\"/></material>")).collect();
    let bound: String = (0..20)
        .map(|i| {
            fs::write(folder.file(&format!("{i}.png")), &bytes).unwrap();
            format!("<node><instance_geometry url=\"#floor\"><bind_material><technique_common><instance_material symbol=\"m\" target=\"#m{i}\"/></technique_common></bind_material></instance_geometry></node>")
        })
        .collect();
    let text = room(&[
        ("<library_effects>", &format!("<library_effects>{maps}")),
        ("<library_materials>", &format!("<library_materials>{materials}")),
        ("<node id=\"front\">", &format!("{bound}<node id=\"front\">")),
    ]);
    refuses(&folder, &text, &["--max-memory", "50M"], &["it takes 11000000 bytes, but only "]);
    assert_eq!(confined(&["check", &folder.file("scene.dae"), "--max-memory", "200M"]).code, Some(0));
}

#[test]
fn broken_images_name_their_material_or_turn_magenta() {
    let folder = Folder::new("broken-images");
    let whole = encoded(ImageFormat::Png, 64);
    for (name, bytes) in [
        ("cut.png", &whole[..whole.len() / 2]),
        ("text.png", b"no image"),
        ("empty.png", b""),
        ("cut.exr", &exr(64)[..300]),
        ("none.png", b"removed"),
    ] {
        fs::write(folder.file(name), bytes).unwrap();
        if name == "none.png" {
            fs::remove_file(folder.file(name)).unwrap();
        }
        refuses(&folder, scene(name), &[], &[&format!("image `{name}` of material `grey`")]);
        let picture = folder.file("a.png");
        let options = ["--missing-texture", "magenta", "--spp", "1", "-o", &picture];
        let run = confined(&[&["render", &folder.file("scene.dae")], &options[..]].concat());
        assert_eq!(run.code, Some(0), "{name}: {}", run.stderr);
        assert!(run.stderr.contains("it is shown as magenta"), "{name}: {}", run.stderr);
    }
}
