//! Layers beside the picture: closed forms of what the camera sees, mattes, pictures of layers, other tools, the denoiser.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use pellicle::output::{HeaderValue, LayerKind, Picture, read_exr};

use crate::cli::{Folder, fail, succeed};

#[path = "layers/denoise.rs"]
mod denoise;
#[path = "layers/tools.rs"]
mod tools;

const ALL: &str = "albedo,N,Ng,Z,P,UV,film,variance,samples,object,material";
const WIDTH: usize = 32;

/// Renders a scene of the tests with all layers.
fn render(folder: &Folder, scene: &str, options: &[&str]) -> Picture {
    let file = folder.file("a.exr");
    succeed(&[&["render", scene, "-o", &file, "--float", "--aov", ALL, "-q"], options].concat());
    read_exr(Path::new(&file)).unwrap()
}

fn layer<'p>(picture: &'p Picture, name: &str) -> &'p [f32] {
    let found = picture.layers.iter().find(|layer| layer.name == name);
    &found.unwrap_or_else(|| panic!("no layer {name}")).data
}

/// The values of several layers in one pixel.
fn at<const N: usize>(picture: &Picture, names: [&str; N], x: usize, y: usize) -> [f32; N] {
    names.map(|name| layer(picture, name)[y * WIDTH + x])
}

fn near<const N: usize>(found: [f32; N], expected: [f32; N]) -> bool {
    found.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 2e-3 * b.abs().max(1.0))
}

/// The camera stands at (0, 1, 4) and looks along -z: the lamp is a square at z = -1, the floor lies at y = 0 before it.
#[test]
fn layers_are_what_the_camera_sees() {
    let folder = Folder::new("sees");
    let picture = render(&folder, "room.dae", &[]);
    // The middle of the lamp.
    assert!(near(at(&picture, ["N.X", "N.Y", "N.Z"], 16, 12), [0.0, 0.0, 1.0]));
    assert_eq!(at(&picture, ["Z"], 16, 12), [5.0]);
    let [x, y, z] = at(&picture, ["P.X", "P.Y", "P.Z"], 16, 12);
    assert!(x.abs() < 0.3 && (y - 1.0).abs() < 0.3 && (z + 1.0).abs() < 1e-5, "{x} {y} {z}");
    assert_eq!(at(&picture, ["albedo.R", "albedo.G", "albedo.B"], 16, 12), [0.0; 3]);
    // The middle of the floor: y = 0 is 1 m below the eye.
    let [x, y, z] = at(&picture, ["P.X", "P.Y", "P.Z"], 16, 20);
    assert!(x.abs() < 0.2 && y.abs() < 1e-5 && z.abs() < 1.0, "{x} {y} {z}");
    assert!((at(&picture, ["Z"], 16, 20)[0] - (4.0 - z)).abs() < 1e-4);
    assert!(near(at(&picture, ["Ng.X", "Ng.Y", "Ng.Z"], 16, 20), [0.0, 1.0, 0.0]));
    assert!(near(at(&picture, ["albedo.R", "albedo.G", "albedo.B"], 16, 20), [0.5; 3]));
    // Nothing.
    assert_eq!(
        at(&picture, ["Z", "P.X", "N.Y", "albedo.R", "CryptoObject00.G", "film.thickness_nm"], 0, 0),
        [1e10, 0.0, 0.0, 0.0, 0.0, 0.0]
    );
    assert!(layer(&picture, "sampleCount").iter().all(|&count| count == 4.0));
    let kind = |name: &str| picture.layers.iter().find(|layer| layer.name == name).map(|layer| layer.kind);
    assert_eq!([kind("albedo.R"), kind("N.X")], [Some(LayerKind::Half); 2]);
    assert_eq!([kind("Z"), kind("P.X"), kind("CryptoObject00.R")], [Some(LayerKind::Float); 3]);
}

#[test]
fn films_show_their_thickness_and_metals_what_they_reflect_straight_on() {
    let folder = Folder::new("films");
    for mode in ["rgb", "spectral"] {
        let picture = render(&folder, "film.dae", &["--mode", mode, "--spp", "16"]);
        assert_eq!(at(&picture, ["film.thickness_nm"], 16, 20), [550.0]);
        assert_eq!(at(&picture, ["film.thickness_nm"], 16, 12), [0.0], "the lamp has none");
        let stdout = succeed(&["film", "--layer", "1.33,550", "--base", "Au", "--angles", "0", "--colour"]).stdout;
        let exact = stdout.lines().find(|line| line.starts_with("exact")).unwrap();
        let row: Vec<f32> = exact.split(',').filter_map(|cell| cell.parse().ok()).collect();
        let albedo = at(&picture, ["albedo.R", "albedo.G", "albedo.B"], 16, 20);
        let wanted = row.windows(3).any(|rgb| rgb.iter().zip(&albedo).all(|(a, b)| (a - b).abs() < 0.02));
        assert!(wanted, "{mode}: {albedo:?} is not in\n{stdout}");
    }
}

/// Layers cost no light: the picture is what it is without them, on any number of threads.
#[test]
fn the_picture_and_its_layers_have_the_same_bits_however_they_are_made() {
    let folder = Folder::new("same");
    let with = render(&folder, "room.dae", &["--threads", "1"]);
    let other = render(&folder, "room.dae", &["--threads", "3"]);
    assert!(other.rgba == with.rgba && other.layers == with.layers);
    let plain = folder.file("plain.exr");
    succeed(&["render", "room.dae", "-o", &plain, "--float", "-q"]);
    assert!(read_exr(Path::new(&plain)).unwrap().rgba == with.rgba);
}

/// The header's manifest: name and the float that its hash is stored as.
fn manifest(picture: &Picture, name: &str) -> BTreeMap<String, f32> {
    let text = |value: &HeaderValue| match value {
        HeaderValue::Text(text) => text.clone(),
        other => panic!("{other:?}"),
    };
    let named = picture.header.iter().find(|(key, value)| key.ends_with("/name") && text(value) == name).unwrap();
    let prefix = named.0.strip_suffix("name").unwrap();
    let entry = |key: &str| text(&picture.header.iter().find(|(name, _)| *name == format!("{prefix}{key}")).unwrap().1);
    assert_eq!([entry("hash"), entry("conversion")], ["MurmurHash3_32", "uint32_to_float32"]);
    let manifest: BTreeMap<String, String> = serde_json::from_str(&entry("manifest")).unwrap();
    let id = |hex: String| f32::from_bits(u32::from_str_radix(&hex, 16).unwrap());
    manifest.into_iter().map(|(name, hex)| (name, id(hex))).collect()
}

/// The matte of one name, as a compositor finds it.
fn matte(picture: &Picture, set: &str, id: f32) -> Vec<f32> {
    let mut sum = vec![0.0; picture.rgba.len()];
    for number in 0..3 {
        for [ids, shares] in [["R", "G"], ["B", "A"]] {
            let [ids, shares] = [ids, shares].map(|letter| layer(picture, &format!("{set}{number:02}.{letter}")));
            for (sum, (&found, &share)) in sum.iter_mut().zip(ids.iter().zip(shares)) {
                *sum += if found.to_bits() == id.to_bits() { share } else { 0.0 };
            }
        }
    }
    sum
}

#[test]
fn mattes_select_what_their_names_say() {
    let folder = Folder::new("mattes");
    let picture = render(&folder, "room.dae", &["--spp", "64"]);
    for (set, lamp, floor) in [("CryptoObject", "lamp-node", "floor-node"), ("CryptoMaterial", "glow", "grey")] {
        let manifest = manifest(&picture, set);
        assert_eq!(manifest.keys().collect::<Vec<_>>(), [lamp.min(floor), lamp.max(floor)], "{set}");
        let [lamp, floor] = [lamp, floor].map(|name| matte(&picture, set, manifest[name]));
        assert_eq!([lamp[12 * WIDTH + 16], floor[12 * WIDTH + 16]], [1.0, 0.0]);
        assert_eq!([lamp[20 * WIDTH + 16], floor[20 * WIDTH + 16]], [0.0, 1.0]);
        assert!(lamp.iter().zip(&floor).all(|(lamp, floor)| (0.0..=1.0 + 1e-6).contains(&(lamp + floor))));
        // 1 m at 5 m, of a picture that is 2 * 5 * tan(25 deg) wide there.
        let side = 32.0 / (10.0 * 25f32.to_radians().tan());
        let area: f32 = lamp.iter().sum();
        assert!((area / (side * side) - 1.0).abs() < 0.02, "{set}: {area} of {}", side * side);
    }
}

/// A crop's layers are those of the whole picture.
#[test]
fn crops_have_their_part_of_the_layers() {
    let folder = Folder::new("cropped-layers");
    let whole = render(&folder, "room.dae", &[]);
    let part = render(&folder, "room.dae", &["--crop", "10,6,9,14"]);
    assert_eq!((part.width, part.height), (9, 14));
    for (of_part, of_whole) in part.layers.iter().zip(&whole.layers) {
        assert_eq!(of_part.name, of_whole.name);
        let found = of_part.data.iter().map(|value| value.to_bits());
        let wanted = (0..14 * 9).map(|i| of_whole.data[(6 + i / 9) * WIDTH + 10 + i % 9].to_bits());
        assert!(found.eq(wanted), "{}", of_part.name);
    }
}

#[test]
fn png_has_its_layers_in_files_beside_it() {
    let folder = Folder::new("beside");
    let png = folder.file("a.png");
    succeed(&["render", "room.dae", "-o", &png, "--aov", "N,Z,object,variance", "--filter", "box", "-q"]);
    assert_eq!(folder.names(), ["a.CryptoObject.png", "a.N.png", "a.Z.png", "a.png", "a.variance.png"]);
    let code = |name: &str, x, y| image::open(folder.file(name)).unwrap().to_rgb8().get_pixel(x, y).0;
    // (0, 0, 1) and (0, 1, 0) on the scale from -1 to 1, give or take the dither; nothing is black.
    let close = |found: [u8; 3], wanted: [u8; 3]| found.iter().zip(wanted).all(|(&a, b)| a.abs_diff(b) <= 1);
    assert!(close(code("a.N.png", 16, 12), [128, 128, 255]), "{:?}", code("a.N.png", 16, 12));
    assert!(close(code("a.N.png", 16, 20), [128, 255, 128]));
    assert_eq!(code("a.N.png", 0, 0), [0; 3]);
    assert!(code("a.Z.png", 16, 23)[0] > code("a.Z.png", 16, 12)[0], "near is bright");
}

#[test]
fn frames_have_layers_too_and_blur_with_their_shutter() {
    let folder = Folder::new("frames");
    let output = folder.file("f.####.exr");
    let common = ["--frames", "1/8", "--mode", "camera", "--spp", "16", "--size", "32x24", "-q", "--float"];
    let options = ["turntable", "moving.dae", "-o", &output, "--aov", "object,N,samples"];
    succeed(&[&options[..], &common].concat());
    let file = folder.file("f.0001.exr");
    let sharp = read_exr(Path::new(&file)).unwrap();
    assert!(layer(&sharp, "sampleCount").iter().all(|&count| count == 16.0));
    let lamp = manifest(&sharp, "CryptoObject")["lamp-node"];
    succeed(&[&options[..], &common, &["--shutter", "360"]].concat());
    let blurred = read_exr(Path::new(&file)).unwrap();
    let partly = |picture: &Picture| {
        let shares = matte(picture, "CryptoObject", lamp);
        shares.iter().filter(|share| (0.01..0.99).contains(*share)).count()
    };
    assert!(2 * partly(&blurred) > 3 * partly(&sharp), "{} {}", partly(&blurred), partly(&sharp));
}

/// A point light and a shining square: what each gives is the other's missing part.
#[test]
fn light_groups_add_up_to_the_picture() {
    let folder = Folder::new("lights");
    for mode in ["rgb", "spectral"] {
        for strategy in ["shared", "mis"] {
            let common = ["moving.dae", "--float", "-q", "--spp", "16", "--mode", mode, "--strategy", strategy, "-o"];
            let [file, plain] = ["a.exr", "b.exr"].map(|name| folder.file(name));
            succeed(&[&["render"], &common[..], &[&file, "--aov", "lights"]].concat());
            succeed(&[&["render"], &common[..], &[&plain]].concat());
            let [picture, plain] = [&file, &plain].map(|file| read_exr(Path::new(file)).unwrap());
            let mut shares = [0.0; 2];
            for (index, pixel) in picture.rgba.iter().enumerate() {
                for (channel, letter) in ["R", "G", "B"].into_iter().enumerate() {
                    let parts = ["bulb", "glow"].map(|name| layer(&picture, &format!("lg_{name}.{letter}"))[index]);
                    let sum = parts[0] + parts[1];
                    assert!((sum - pixel[channel]).abs() <= 1e-5 * pixel[channel].abs().max(1e-3), "{sum} {pixel:?}");
                    let alone = plain.rgba[index][channel];
                    assert!((sum - alone).abs() <= 1e-4 * alone.abs().max(1e-3), "{mode} {strategy}: {sum} is {alone}");
                    shares.iter_mut().zip(parts).for_each(|(share, part)| *share += part);
                }
            }
            assert!(shares.iter().all(|&share| share > 0.0), "{shares:?}");
        }
    }
    let file = folder.file("c.exr");
    let refuse =
        |options: &[&str]| fail(2, &[&["render", "room.dae", "-o", &file, "--aov", "lights"], options].concat());
    assert!(refuse(&["--checkpoint", "5m"]).contains("--checkpoint"));
    assert!(refuse(&["--wavelengths", "16"]).contains("8 wavelengths"));
}

#[test]
fn what_has_no_scene_says_so() {
    let folder = Folder::new("no-scene");
    let [part, file] = ["a.part", "a.exr"].map(|name| folder.file(name));
    let error = fail(2, &["render", "room.dae", "-o", &part, "--samples", "0:4", "--aov", "N"]);
    assert!(error.contains("--max-bounces 0"), "{error}");
    succeed(&["render", "room.dae", "-o", &part, "--samples", "0:4", "-q"]);
    assert!(fail(2, &["merge", &part, "-o", &file, "--aov", "N"]).contains("parts know nothing of N"));
    succeed(&["merge", &part, "-o", &file, "--aov", "variance,samples", "-q"]);
    assert!(layer(&read_exr(Path::new(&file)).unwrap(), "sampleCount").iter().all(|&count| count == 4.0));
}

/// True where a program can be run; prints why not.
fn has(program: &str, package: &str) -> bool {
    let found = Command::new("sh").args(["-c", &format!("command -v {program}")]).output();
    let there = found.is_ok_and(|output| output.status.success());
    if !there {
        println!("skipped: needs {program} ({package})");
    }
    there
}
