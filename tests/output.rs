//! Files: what is in them, and that they are whole or not there.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use pellicle::output::{
    Crop, Display, Format, HeaderValue, Layer, LayerKind, OutputError, Picture, PngDepth, Written, check_picture,
    check_writable, is_complete, read_exr, write_exr, write_png, write_text,
};

/// An empty folder, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("pellicle-output-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn flat(width: u32, height: u32, value: f32) -> Picture {
    Picture { width, height, rgba: vec![[value, value, value, 1.0]; (width * height) as usize], ..Picture::default() }
}

/// 5 x 3, every channel kind, every header kind; all values are exact halves.
fn rich() -> Picture {
    let ramp = |scale: f32| (0..15).map(|i| i as f32 * scale).collect::<Vec<f32>>();
    let layer = |name: &str, kind, data| Layer { name: name.to_string(), kind, data };
    let note = |name: &str, value| (name.to_string(), value);
    Picture {
        width: 5,
        height: 3,
        crop: Some(Crop { x: 7, y: 9, full_width: 64, full_height: 48 }),
        rgba: (0..15).map(|i| [i as f32, -0.25 * i as f32, 0.5, 1.0 - i as f32 / 16.0]).collect(),
        layers: vec![
            layer("Z", LayerKind::Float, ramp(0.1)),
            layer("albedo.R", LayerKind::Half, ramp(0.0625)),
            layer("spp", LayerKind::Uint, ramp(1000.0)),
        ],
        header: vec![
            note("pellicle/argv", HeaderValue::Text("pellicle render Müller.dae -o a.exr".to_string())),
            note("pellicle/renderSeconds", HeaderValue::Float(1.5)),
            note("pellicle/spp", HeaderValue::Int(256)),
        ],
    }
}

#[test]
fn an_exr_comes_back_as_it_was_written() {
    let folder = Folder::new("round-trip");
    let path = folder.file("a.exr");
    for float in [false, true] {
        assert_eq!(write_exr(&path, &rich(), float).unwrap(), Written::default());
        assert_eq!(read_exr(&path).unwrap(), rich());
        assert!(is_complete(&path));
    }
    assert_eq!(folder.names(), ["a.exr"]);
}

#[test]
fn an_exr_is_what_other_programs_expect() {
    use exr::prelude::{AttributeValue, Compression, LineOrder, MetaData, SampleType, Text, Vec2};
    let folder = Folder::new("meta");
    let path = folder.file("a.exr");
    write_exr(&path, &rich(), false).unwrap();
    let meta = MetaData::read_from_file(&path, true).unwrap();
    assert_eq!(meta.headers.len(), 1);
    let header = &meta.headers[0];
    let channels: Vec<_> =
        header.channels.list.iter().map(|channel| (channel.name.to_string(), channel.sample_type)).collect();
    let expected = [
        ("A", SampleType::F16),
        ("B", SampleType::F16),
        ("G", SampleType::F16),
        ("R", SampleType::F16),
        ("Z", SampleType::F32),
        ("albedo.R", SampleType::F16),
        ("spp", SampleType::U32),
    ];
    assert_eq!(channels, expected.map(|(name, kind)| (name.to_string(), kind)));
    assert_eq!((header.compression, header.line_order), (Compression::ZIP16, LineOrder::Increasing));
    assert_eq!((header.own_attributes.layer_position, header.layer_size), (Vec2(7, 9), Vec2(5, 3)));
    assert_eq!(header.shared_attributes.display_window.size, Vec2(64, 48));
    assert_eq!(header.shared_attributes.display_window.position, Vec2(0, 0));
    assert_eq!(header.own_attributes.layer_name, None); // one bare part
    let software = header.own_attributes.software_name.as_ref().unwrap().to_string();
    assert!(software.starts_with("pellicle "), "{software}");
    let chromaticities = header.shared_attributes.chromaticities.unwrap();
    assert_eq!((chromaticities.red, chromaticities.white), (Vec2(0.64, 0.33), Vec2(0.3127, 0.329)));
    let value = |name| {
        let (own, shared) = (&header.own_attributes.other, &header.shared_attributes.other);
        own.get(&Text::from(name)).or_else(|| shared.get(&Text::from(name))).cloned()
    };
    assert_eq!(value("pellicle/spp"), Some(AttributeValue::I32(256)));
    assert_eq!(value("pellicle/renderSeconds"), Some(AttributeValue::F32(1.5)));
}

#[test]
fn the_same_picture_gives_the_same_bytes() {
    let folder = Folder::new("bytes");
    let mut picture = rich();
    for i in 0..20 {
        picture.header.push((format!("pellicle/note{i}"), HeaderValue::Int(i)));
    }
    let exr = |name: &str| {
        write_exr(&folder.file(name), &picture, false).unwrap();
        fs::read(folder.file(name)).unwrap()
    };
    let first = exr("0.exr");
    assert!((1..5).all(|i| exr(&format!("{i}.exr")) == first));
    // Sorting the header must not cost a value.
    assert_eq!(read_exr(&folder.file("0.exr")).unwrap().header.len(), 23);
}

#[test]
fn halves_are_clamped_and_counted() {
    let folder = Folder::new("clamp");
    let path = folder.file("a.exr");
    let mut picture = flat(2, 2, 65504.0);
    picture.rgba[0] = [65505.0, -1e9, f32::INFINITY, 1.0];
    assert_eq!(write_exr(&path, &picture, false).unwrap(), Written { clamped: 3, out_of_gamut: 0 });
    assert_eq!(read_exr(&path).unwrap().rgba[0], [65504.0, -65504.0, 65504.0, 1.0]);
    // 32-bit floats hold them all.
    assert_eq!(write_exr(&path, &picture, true).unwrap(), Written::default());
    assert_eq!(read_exr(&path).unwrap().rgba[0], picture.rgba[0]);
}

#[test]
fn pictures_that_contradict_themselves_are_refused() {
    let folder = Folder::new("refused");
    let reason = |picture: &Picture| write_exr(&folder.file("a.exr"), picture, false).unwrap_err().to_string();
    let short = Picture { width: 3, ..flat(2, 2, 0.0) };
    assert!(reason(&short).ends_with("4 pixels for 3x2"), "{}", reason(&short));
    assert!(reason(&Picture::default()).ends_with("a picture of 0x0 has no pixels"));
    assert!(write_png(&folder.file("a.png"), &short, Display::PLAIN, PngDepth::Eight).is_err());
    let mut twice = rich();
    twice.layers[0].name = "R".to_string();
    assert!(reason(&twice).ends_with("the channel R appears twice"));
    let mut noted = rich();
    noted.header[0].0 = "pellicle/spp".to_string();
    assert!(reason(&noted).ends_with("the header value pellicle/spp appears twice"));
    assert!(folder.names().is_empty());
}

#[test]
fn a_cut_exr_is_not_complete() {
    let folder = Folder::new("cut");
    let path = folder.file("a.exr");
    let mut picture = flat(64, 64, 0.0);
    for (i, pixel) in picture.rgba.iter_mut().enumerate() {
        pixel[0] = (i as f32).sin(); // so that it does not compress to nothing
    }
    write_exr(&path, &picture, false).unwrap();
    let whole = fs::read(&path).unwrap();
    for length in [0, 3, 100, whole.len() / 2, whole.len() - 1] {
        fs::write(&path, &whole[..length]).unwrap();
        assert!(!is_complete(&path), "{length} of {} bytes", whole.len());
        assert!(matches!(read_exr(&path), Err(OutputError::Damaged { .. })), "{length}");
    }
    fs::write(&path, &whole).unwrap();
    assert!(is_complete(&path));
    assert!(!is_complete(&folder.file("absent.exr")));
    assert!(matches!(read_exr(&folder.file("absent.exr")), Err(OutputError::Io { .. })));
}

#[test]
fn a_cut_png_is_not_complete() {
    let folder = Folder::new("cut-png");
    let path = folder.file("a.png");
    write_png(&path, &flat(64, 64, 0.18), Display::PLAIN, PngDepth::Eight).unwrap();
    let whole = fs::read(&path).unwrap();
    assert!(is_complete(&path));
    for length in [0, 20, whole.len() / 2, whole.len() - 1] {
        fs::write(&path, &whole[..length]).unwrap();
        assert!(!is_complete(&path), "{length} of {} bytes", whole.len());
    }
}

/// Pixels as (8 or 16 bit) codes, and the names of the chunks.
fn decode(path: &Path) -> (Vec<u16>, Vec<String>) {
    let bytes = fs::read(path).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgb);
    let codes = match info.bit_depth {
        png::BitDepth::Eight => data.iter().map(|&byte| byte.into()).collect(),
        _ => data.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect(),
    };
    let (mut chunks, mut at) = (Vec::new(), 8);
    while let Some(head) = bytes.get(at..at + 8) {
        chunks.push(String::from_utf8_lossy(&head[4..]).into_owned());
        at += 12 + u32::from_be_bytes(head[..4].try_into().unwrap()) as usize;
    }
    (codes, chunks)
}

#[test]
fn png_values_follow_the_srgb_curve() {
    let folder = Folder::new("curve");
    // Linear value, 16-bit code: IEC 61966-2-1, computed in double precision.
    let known: [(f32, u16); 6] = [(0.0, 0), (0.003_130_8, 2651), (0.18, 30235), (1.0, 65535), (4.0, 65535), (-0.5, 0)];
    for (value, code) in known {
        let path = folder.file("a.png");
        let clipped = if (0.0..=1.0).contains(&value) { 0 } else { 16 };
        let written = write_png(&path, &flat(4, 4, value), Display::PLAIN, PngDepth::Sixteen).unwrap();
        assert_eq!(written, Written { clamped: 0, out_of_gamut: clipped }, "{value}");
        let (codes, _) = decode(&path);
        assert!(codes.len() == 48 && codes.iter().all(|&found| found == code), "{value}: {codes:?}");

        write_png(&path, &flat(4, 4, value), Display::PLAIN, PngDepth::Eight).unwrap();
        let exact = f32::from(code) / 257.0;
        let (codes, _) = decode(&path);
        assert!(codes.iter().all(|&found| (f32::from(found) - exact).abs() < 1.0), "{value}: {codes:?}");
    }
}

#[test]
fn exposure_comes_before_the_curve() {
    let folder = Folder::new("exposure");
    let path = folder.file("a.png");
    assert_eq!(
        write_png(&path, &flat(2, 2, 0.045), Display { exposure_ev: 2.0, ..Display::PLAIN }, PngDepth::Sixteen)
            .unwrap()
            .out_of_gamut,
        0
    );
    assert!(decode(&path).0.iter().all(|&code| code == 30235)); // 0.18
    assert_eq!(
        write_png(&path, &flat(2, 2, 0.5), Display { exposure_ev: 1.5, ..Display::PLAIN }, PngDepth::Sixteen)
            .unwrap()
            .out_of_gamut,
        4
    );
    let mut nan = flat(2, 2, 0.5);
    nan.rgba[3][1] = f32::NAN;
    assert_eq!(write_png(&path, &nan, Display::PLAIN, PngDepth::Eight).unwrap().out_of_gamut, 1);
    assert_eq!(decode(&path).0[10], 0);
}

#[test]
fn dither_is_repeatable_unbiased_and_quiet() {
    let folder = Folder::new("dither");
    let path = folder.file("a.png");
    for i in 1..20 {
        let picture = flat(128, 128, i as f32 / 20.0);
        write_png(&path, &picture, Display::PLAIN, PngDepth::Sixteen).unwrap();
        let exact = f64::from(decode(&path).0[0]) / 257.0;
        write_png(&path, &picture, Display::PLAIN, PngDepth::Eight).unwrap();
        let (codes, _) = decode(&path);
        for channel in 0..3 {
            let sum: f64 = codes.iter().skip(channel).step_by(3).map(|&code| f64::from(code)).sum();
            let mean = sum / (128.0 * 128.0);
            assert!((mean - exact).abs() < 0.01, "channel {channel}: {mean} for {exact}");
        }
        write_png(&path, &picture, Display::PLAIN, PngDepth::Eight).unwrap();
        assert_eq!(decode(&path).0, codes);
    }
    // Codes that 8 bits hold exactly are not touched.
    for (value, code) in [(0.0, 0), (1.0, 255)] {
        write_png(&path, &flat(64, 64, value), Display::PLAIN, PngDepth::Eight).unwrap();
        assert!(decode(&path).0.iter().all(|&found| found == code));
    }
}

#[test]
fn a_png_says_how_to_read_it() {
    let folder = Folder::new("chunks");
    let path = folder.file("a.png");
    write_png(&path, &rich(), Display::PLAIN, PngDepth::Eight).unwrap();
    let (_, chunks) = decode(&path);
    for name in ["sRGB", "gAMA", "cHRM", "tEXt", "iTXt", "IEND"] {
        assert!(chunks.iter().any(|chunk| chunk == name), "{name} is not in {chunks:?}");
    }
    let reader = png::Decoder::new(std::io::Cursor::new(fs::read(&path).unwrap())).read_info().unwrap();
    let notes: Vec<_> =
        reader.info().utf8_text.iter().map(|chunk| (chunk.keyword.clone(), chunk.get_text().unwrap())).collect();
    assert!(notes.contains(&("pellicle/spp".to_string(), "256".to_string())), "{notes:?}");
    assert!(notes.contains(&("pellicle/argv".to_string(), "pellicle render Müller.dae -o a.exr".to_string())));
}

#[test]
fn only_pictures_that_can_be_written_are_promised() {
    let folder = Folder::new("promise");
    assert_eq!(check_picture(&folder.file("a.EXR")).unwrap(), Format::Exr);
    assert_eq!(check_picture(&folder.file("a.png")).unwrap(), Format::Png);
    for name in ["a.jpg", "a", ".exr"] {
        let message = check_picture(&folder.file(name)).unwrap_err().to_string();
        assert!(message.ends_with("pictures are written as .exr or .png"), "{message}");
    }
    let missing = folder.file("none/a.exr");
    let message = check_picture(&missing).unwrap_err().to_string();
    assert!(message.contains("the folder") && message.ends_with("none does not exist"), "{message}");
    fs::write(folder.file("plain"), "").unwrap();
    let message = check_writable(&folder.file("plain/a.exr")).unwrap_err().to_string();
    assert!(message.contains("cannot create a file for") && message.contains("Not a directory"), "{message}");
    fs::create_dir(folder.file("folder.exr")).unwrap();
    assert!(matches!(check_writable(&folder.file("folder.exr")), Err(OutputError::IsFolder { .. })));
    assert_eq!(folder.names(), ["folder.exr", "plain"]); // the proof leaves nothing
}

#[test]
fn leftovers_of_dead_processes_go() {
    let folder = Folder::new("stale");
    let mut child = Command::new("true").spawn().unwrap();
    let dead = child.id();
    child.wait().unwrap();
    let (own, alive) = (std::process::id(), 1); // the first process of any machine lives
    for name in [format!(".a.txt.tmp.{dead}"), format!(".a.txt.tmp.{own}"), format!(".a.txt.tmp.{alive}")] {
        fs::write(folder.file(&name), "half").unwrap();
    }
    fs::write(folder.file(&format!(".b.txt.tmp.{dead}")), "another file's").unwrap();
    fs::write(folder.file(".a.txt.tmp.note"), "not ours").unwrap();
    write_text(&folder.file("a.txt"), "whole").unwrap();
    let mut expected = vec![
        ".a.txt.tmp.note".to_string(),
        format!(".a.txt.tmp.{alive}"),
        format!(".b.txt.tmp.{dead}"),
        "a.txt".to_string(),
    ];
    expected.sort();
    assert_eq!(folder.names(), expected);
    assert_eq!(fs::read_to_string(folder.file("a.txt")).unwrap(), "whole");
}

/// A file system of 2 MB, unmounted at the end.
struct SmallDisk(Folder);

impl SmallDisk {
    fn mount(name: &str) -> Option<Self> {
        let folder = Folder::new(name);
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", "size=2m", "none"]).arg(&folder.0).output();
        match mounted {
            Ok(output) if output.status.success() => Some(Self(folder)),
            Ok(output) => {
                println!("skipped, as this user may not mount: {}", String::from_utf8_lossy(&output.stderr).trim());
                None
            }
            Err(error) => {
                println!("skipped, as mount cannot be run: {error}");
                None
            }
        }
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0.0).status();
    }
}

#[test]
fn a_full_disk_leaves_the_old_file() {
    let Some(SmallDisk(ref folder)) = SmallDisk::mount("full") else { return };
    let path = folder.file("a.txt");
    write_text(&path, "old").unwrap();
    let error = write_text(&path, &"x".repeat(3_000_000)).unwrap_err();
    assert!(error.is_disk_full());
    let message = error.to_string();
    assert!(message.contains("a.txt") && message.contains("No space left on device"), "{message}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(folder.names(), ["a.txt"]);
}
