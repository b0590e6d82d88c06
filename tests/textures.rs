//! Images on surfaces, as they reach the picture.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use glam::{Mat4, Vec2, Vec3};
use image::{DynamicImage, ImageFormat};
use pellicle::collada::{LoadOptions, load};
use pellicle::document::{
    Base, Channel4, Encoding, Group, Image, ImageSource, Map, Mesh, Shape, SurfaceEmission, Texture, UvSet, Wrap,
};
use pellicle::integrate::{PathLimits, Strategy};
use pellicle::mode::Rgb;

use crate::transport::{Builder, material};

/// One picture of a screen [-1, 1]^2 that fills the view and shines with an image: the mean of each of `cells`^2 parts.
fn screen(bytes: Vec<u8>, name: &str, encoding: Encoding, cells: usize) -> Vec<Vec3> {
    let mut builder = Builder::seen_from(Vec3::new(0.0, 0.0, 1.0), 90.0);
    let source = ImageSource::Bytes(bytes);
    builder.0.images.push(Image { id: "image".into(), uri: name.into(), user: "material `m`".into(), source });
    let map =
        Map { image: 0, texcoord: String::new(), slot: 0, encoding, channel: Channel4::G, wrap: [Wrap::Clamp; 2] };
    let radiance = Texture { value: Vec3::ONE, map: Some(map) };
    let mut shining = material(Base::Black);
    shining.emission = Some(SurfaceEmission { radiance, spectrum: Default::default(), two_sided: true });
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mesh = Mesh {
        positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
        uv_sets: vec![UvSet { set: 0, uvs: corners.map(|(x, y)| Vec2::new(x, y) * 0.5 + 0.5).to_vec() }],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        groups: vec![Group { symbol: "m".into(), triangles: 0..2 }],
        ..Mesh::default()
    };
    builder.geometry(Mat4::IDENTITY, Shape::Mesh(mesh), shining);
    let limits = PathLimits { max_bounces: 1, strategy: Strategy::Bsdf };
    let frame = builder.render_in::<Rgb>(cells as u32, 4, limits, 1);
    frame.rgb.iter().map(|rgb| Vec3::from_array(*rgb)).collect()
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

#[test]
fn sixteen_bits_arrive_as_sixteen_bits() {
    // Eight bits would make 0.18837 or 0.18431 of it.
    let code = 12_222u16;
    let image = DynamicImage::ImageRgb16(image::ImageBuffer::from_pixel(2, 2, image::Rgb([code, code + 1, 40_000])));
    let linear = screen(encoded(&image, ImageFormat::Png), "a.png", Encoding::Linear, 1)[0];
    let wanted = Vec3::new(12_222.0, 12_223.0, 40_000.0) / 65_535.0;
    assert!((linear - wanted).abs().max_element() < 3e-7, "{linear}");
    let srgb = screen(encoded(&image, ImageFormat::Png), "a.png", Encoding::Srgb, 1)[0];
    let decoded = wanted.to_array().map(|v| ((v + 0.055) / 1.055).powf(2.4));
    assert!((srgb - Vec3::from(decoded)).abs().max_element() < 1e-6, "{srgb}");
    let grey = DynamicImage::ImageLuma16(image::ImageBuffer::from_pixel(2, 2, image::Luma([code])));
    let grey = screen(encoded(&grey, ImageFormat::Png), "a.png", Encoding::Linear, 1)[0];
    assert!((grey - Vec3::splat(wanted.x)).abs().max_element() < 3e-7, "{grey}");
}

#[test]
fn every_format_shows_the_same_picture() {
    // Black and white quarters, white at the upper left and the lower right.
    let tile = |x: u32, y: u32| if (x / 8 + y / 8) % 2 == 0 { 255 } else { 0 };
    let bytes = DynamicImage::ImageRgb8(image::ImageBuffer::from_fn(16, 16, |x, y| image::Rgb([tile(x, y); 3])));
    let quarters = |bytes, name: &str| {
        let cells = screen(bytes, name, Encoding::Linear, 4);
        // Away from the edges between quarters.
        [0, 3, 12, 15].map(|cell: usize| (cells[cell].y * 100.0).round())
    };
    for (format, name) in [
        (ImageFormat::Png, "a.png"),
        (ImageFormat::Jpeg, "a.jpg"),
        (ImageFormat::Tga, "a.tga"),
        (ImageFormat::Bmp, "a.bmp"),
        (ImageFormat::Tiff, "a.tif"),
    ] {
        assert_eq!(quarters(encoded(&bytes, format), name), [100.0, 0.0, 0.0, 100.0], "{name}");
    }
    let floats = DynamicImage::ImageRgb32F(bytes.to_rgb32f());
    assert_eq!(quarters(encoded(&floats, ImageFormat::Hdr), "a.hdr"), [100.0, 0.0, 0.0, 100.0]);
}

#[test]
fn exr_channels_are_found_by_name_or_alone() {
    use exr::prelude::*;
    let write = |channels: &[(&str, f32)]| {
        let channel = |&(name, value): &(&str, f32)| AnyChannel::new(name, FlatSamples::F32(vec![value; 4]));
        let list: SmallVec<[AnyChannel<FlatSamples>; 4]> = channels.iter().map(channel).collect();
        let attributes = LayerAttributes::default();
        let layer = Layer::new((2, 2), attributes, Encoding::FAST_LOSSLESS, AnyChannels::sort(list));
        let mut file = Cursor::new(Vec::new());
        exr::prelude::Image::from_layer(layer).write().to_buffered(&mut file).unwrap();
        screen(file.into_inner(), "a.exr", pellicle::document::Encoding::Srgb, 1)[0]
    };
    // Linear, whatever the map says.
    assert_eq!(write(&[("R", 0.25), ("G", 3.5), ("B", 0.125), ("A", 1.0)]), Vec3::new(0.25, 3.5, 0.125));
    assert_eq!(write(&[("Y", 0.375)]), Vec3::splat(0.375));
    assert_eq!(write(&[("thickness", 0.75)]), Vec3::splat(0.75));
}

/// A folder of one test, with images that are left black and right white, and a scene that looks at a unit screen.
fn scene_file(name: &str, effect: &str) -> (PathBuf, PathBuf) {
    let folder = std::env::temp_dir().join(format!("pellicle-textures-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let half = |x: u32| if x < 8 { 0 } else { 255 };
    let ramp = image::ImageBuffer::from_fn(16, 16, |x, _| image::Rgba([half(x), half(x), half(x), half(x)]));
    DynamicImage::ImageRgba8(ramp).save(folder.join("half.png")).unwrap();
    let file = folder.join("scene.dae");
    fs::write(&file, include_str!("data/textured_screen.xml").replace("EFFECT", effect).replace("SKY", "0")).unwrap();
    (folder, file)
}

fn common(shader: &str) -> String {
    let sampler = r#"<newparam sid="surface"><surface type="2D"><init_from>half</init_from></surface></newparam>
        <newparam sid="half"><sampler2D><source>surface</source><wrap_s>CLAMP</wrap_s><wrap_t>CLAMP</wrap_t></sampler2D>
        </newparam>"#;
    format!(r#"<profile_COMMON>{sampler}<technique sid="t">{shader}</technique></profile_COMMON>"#)
}

/// Light from each quarter of the screen: upper left, upper right, lower left, lower right.
fn quarters(file: &Path) -> [f32; 4] {
    let (document, _) = load(file, &LoadOptions::default()).unwrap();
    let limits = PathLimits { max_bounces: 4, strategy: Strategy::Bsdf };
    let frame = Builder(document).render_in::<Rgb>(4, 64, limits, 1);
    [0, 3, 12, 15].map(|pixel: usize| (frame.rgb[pixel][1] * 100.0).round() / 100.0)
}

#[test]
fn each_map_has_its_own_texture_coordinates() {
    // The second set is turned by 90 degrees: what shines is bright on the right, what is there lies below.
    let shader = r#"<constant><emission><texture texture="half" texcoord="UP"/></emission>
        <transparent opaque="A_ONE"><texture texture="half" texcoord="TURNED"/></transparent></constant>"#;
    let (folder, file) = scene_file("sets", &common(shader));
    assert_eq!(quarters(&file), [0.0, 0.0, 0.0, 1.0]);
    let own = r#"<profile_COMMON><technique sid="t"><lambert/></technique></profile_COMMON>
        <extra><technique profile="pellicle"><diffuse reflectance="1">
        <map for="reflectance" image="half.png" texcoord="TURNED" wrap="clamp"/>
        <opacity image="half.png" texcoord="UP" wrap="clamp"/></diffuse></technique></extra>
        </effect><effect id="unused"><profile_COMMON><technique sid="t"><lambert/></technique></profile_COMMON>"#;
    fs::write(&file, include_str!("data/textured_screen.xml").replace("EFFECT", own).replace("SKY", "1")).unwrap();
    // Through holes the sky is seen, which the white half reflects as well.
    assert_eq!(quarters(&file), [1.0, 0.0, 1.0, 1.0]);
    let _ = fs::remove_dir_all(folder);
}

#[test]
fn transparency_follows_the_rules_of_the_format() {
    let opacity = |mode: &str, color: &str, transparency: &str, invert_opacity: bool| {
        let shader = format!(
            r#"<constant><transparent {mode}><color>{color}</color></transparent>
            <transparency><float>{transparency}</float></transparency></constant>"#
        );
        let (folder, file) = scene_file("rules", &common(&shader));
        let (document, _) = load(&file, &LoadOptions { invert_opacity, ..LoadOptions::default() }).unwrap();
        let _ = fs::remove_dir_all(folder);
        document.materials[0].opacity.value
    };
    for (mode, color, transparency, inverted, wanted) in [
        ("", "0 0 0 0.25", "1", false, 0.25),
        (r#"opaque="A_ONE""#, "1 1 1 0.5", "0.5", false, 0.25),
        (r#"opaque="A_ZERO""#, "1 1 1 0.5", "0.5", false, 0.75),
        (r#"opaque="RGB_ZERO""#, "1 1 1 0", "0.25", false, 0.75),
        (r#"opaque="RGB_ONE""#, "0 1 0 0", "1", false, 0.71516),
        ("", "0 0 0 0.25", "1", true, 0.75),
        (r#"opaque="RGB_ZERO""#, "1 1 1 0", "0.25", true, 0.25),
    ] {
        let found = opacity(mode, color, transparency, inverted);
        assert!((found - wanted).abs() < 1e-5, "{mode} {color} {transparency} {inverted}: {found}, wanted {wanted}");
    }
}

#[test]
fn transparency_images_are_scaled_and_turned_over() {
    // White (light 1) is there where the image says 0, and half of it where it says 1.
    let shader = r#"<constant><emission><color>1 1 1 1</color></emission><transparent opaque="RGB_ZERO">
        <texture texture="half" texcoord="UP"/></transparent><transparency><float>1</float></transparency></constant>"#;
    let (folder, file) = scene_file("images", &common(shader));
    assert_eq!(quarters(&file), [1.0, 0.0, 1.0, 0.0]);
    let (document, _) = load(&file, &LoadOptions::default()).unwrap();
    let opacity = &document.materials[0].opacity;
    assert_eq!((opacity.range, opacity.map.as_ref().map(|map| map.channel)), ([1.0, 0.0], Some(Channel4::Luminance)));
    let _ = fs::remove_dir_all(folder);
}
