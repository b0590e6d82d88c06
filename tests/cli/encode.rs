//! Frames to videos: what is refused before any work, and how far the colours are from the frames'.

use image::{ImageBuffer, Rgb};

use super::*;

/// True, with a printed reason, where the tests of videos cannot run.
fn lacks_ffmpeg() -> bool {
    let lacks = ["ffmpeg", "ffprobe"].iter().any(|name| Command::new(name).arg("-version").output().is_err());
    if lacks {
        println!("skipped: ffmpeg is not installed (apt-get install ffmpeg)");
    }
    lacks
}

/// A smooth picture of many colours that turns with `number` of `count`, as 16-bit codes.
fn colours(number: u32, count: u32, [width, height]: [u32; 2]) -> ImageBuffer<Rgb<u16>, Vec<u16>> {
    let turn = std::f32::consts::TAU * number as f32 / count as f32;
    ImageBuffer::from_fn(width, height, |x, y| {
        let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
        let wave = |phase: f32| 0.5 + 0.3 * (turn + phase + u + v).cos();
        Rgb([0.0, 2.1, 4.2].map(|phase| (wave(phase) * 65_535.0) as u16))
    })
}

/// Writes frames `f.0000.png` and so on.
fn frames(folder: &Folder, numbers: impl Iterator<Item = u32>, size: [u32; 2]) -> String {
    for number in numbers {
        colours(number, 12, size).save(folder.file(&format!("f.{number:04}.png"))).unwrap();
    }
    folder.file("f.####.png")
}

/// All frames of a video as 16-bit codes, as a player that heeds the tags sees them.
fn decode(file: &str) -> Vec<u16> {
    let flags = "scale=flags=spline+accurate_rnd+full_chroma_int";
    let arguments = ["-v", "error", "-i", file, "-vf", flags, "-f", "rawvideo", "-pix_fmt", "rgb48le", "pipe:1"];
    let output = Command::new("ffmpeg").args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}

/// What ffprobe says about the first stream.
fn probe(file: &str, entries: &str) -> String {
    let arguments = ["-v", "error", "-select_streams", "v:0", "-show_entries", entries, "-of", "csv=p=0", file];
    String::from_utf8(Command::new("ffprobe").args(arguments).output().unwrap().stdout).unwrap().trim().to_owned()
}

#[test]
fn videos_keep_their_colours() {
    if lacks_ffmpeg() {
        return;
    }
    let folder = Folder::new("video-colours");
    let size = [320, 192];
    let pattern = frames(&folder, 0..12, size);
    let source: Vec<u16> = (0..12).flat_map(|number| colours(number, 12, size).into_raw()).collect();
    for (name, mean_limit, largest_limit) in
        [("v.mp4", 0.7, 8.0), ("v.mov", 0.6, 5.0), ("v.webm", 0.5, 5.0), ("v.mkv", 0.0, 0.0)]
    {
        let file = folder.file(name);
        let run = succeed(&["encode", &pattern, "-o", &file]);
        assert!(run.stderr.contains("12 frames of 320x192, 0.50 s"), "{}", run.stderr);
        let video = decode(&file);
        assert_eq!(video.len(), source.len(), "{name}");
        // Differences in 8-bit codes.
        let errors: Vec<f64> =
            source.iter().zip(&video).map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs() / 257.0).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let largest = errors.iter().copied().fold(0.0, f64::max);
        println!("{name}: mean {mean:.3}, largest {largest:.1} codes of 255");
        assert!(mean <= mean_limit && largest <= largest_limit, "{name}: mean {mean:.3}, largest {largest:.1}");
        if name != "v.mkv" {
            let tags = probe(&file, "stream=color_range,color_space,color_transfer,color_primaries");
            assert_eq!(tags, "tv,bt709,iec61966-2-1,bt709", "{name}");
        }
    }
    assert_eq!(folder.names().len(), 12 + 4, "nothing else is left");
}

#[test]
fn rendered_exr_frames_go_through_our_own_view_transform() {
    if lacks_ffmpeg() {
        return;
    }
    let folder = Folder::new("video-exr");
    for number in 3..6 {
        let (seed, spp) = (number.to_string(), ["--spp", "4", "--quiet"]);
        let exr = folder.file(&format!("e_{number:02}.exr"));
        succeed(&[&["render", "room.dae", "-o", &exr, "--float", "--seed", &seed][..], &spp].concat());
        let png = folder.file(&format!("p_{number:02}.png"));
        let look = ["--png-depth", "16", "--exposure", "-0.5", "--seed", &seed];
        succeed(&[&["render", "room.dae", "-o", &png][..], &look, &spp].concat());
    }
    let [exr, png] = ["e.mkv", "p.mkv"].map(|name| folder.file(name));
    succeed(&["encode", &folder.file("e_%02d.exr"), "-o", &exr, "--exposure", "-0.5"]);
    succeed(&["encode", &folder.file("p_##.png"), "-o", &png]);
    assert_eq!(decode(&exr), decode(&png));
}

#[test]
fn odd_sizes_are_padded_with_a_message() {
    if lacks_ffmpeg() {
        return;
    }
    let folder = Folder::new("video-odd");
    let pattern = frames(&folder, 0..2, [33, 21]);
    let (mp4, mkv) = (folder.file("v.mp4"), folder.file("v.mkv"));
    let run = succeed(&["encode", &pattern, "-o", &mp4]);
    assert!(run.stderr.contains("33x21 frames become a 34x22 video"), "{}", run.stderr);
    assert_eq!(probe(&mp4, "stream=width,height"), "34,22");
    succeed(&["encode", &pattern, "-o", &mkv]);
    assert_eq!(probe(&mkv, "stream=width,height"), "33,21");
}

/// Without ffmpeg; a folder stands for the one sequence in it, wherever its numbers begin.
#[test]
fn animated_png_loops_the_frames_exactly() {
    let folder = Folder::new("apng");
    fs::create_dir(folder.file("frames")).unwrap();
    for number in 98..103 {
        let picture = image::DynamicImage::from(colours(number, 12, [25, 15])).into_rgb8();
        picture.save(folder.file(&format!("frames/turn{number}_a.png"))).unwrap();
    }
    fs::write(folder.file("frames/frames.csv"), "frame\n98\n").unwrap();
    let file = folder.file("v.png");
    let without_path =
        command(&["encode", &folder.file("frames"), "-o", &file, "--fps", "12.5"]).env("PATH", "").output();
    assert!(without_path.unwrap().status.success());

    let mut decoder = png::Decoder::new(BufReader::new(fs::File::open(&file).unwrap())).read_info().unwrap();
    let control = *decoder.info().animation_control().unwrap();
    assert_eq!((control.num_frames, control.num_plays), (5, 0));
    let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
    for number in 98..103 {
        decoder.next_frame(&mut pixels).unwrap();
        let delay = decoder.info().frame_control().unwrap();
        assert_eq!((delay.delay_num, delay.delay_den), (1000, 12_500));
        assert_eq!(pixels, image::DynamicImage::from(colours(number, 12, [25, 15])).into_rgb8().into_raw());
    }
}

#[test]
fn sequences_that_are_no_video_are_refused_with_the_reason() {
    let folder = Folder::new("video-refused");
    let file = folder.file("v.png");
    let refused = |frames: &str| fail(2, &["encode", frames, "-o", &file]);
    let pattern = frames(&folder, [0, 1, 4, 5, 7].into_iter(), [8, 6]);
    let stderr = refused(&pattern);
    assert!(stderr.contains("the frames 2-3,6 are missing"), "{stderr}");
    frames(&folder, [2, 3].into_iter(), [8, 6]);
    frames(&folder, [6].into_iter(), [8, 5]);
    let stderr = refused(&pattern);
    assert!(stderr.contains("f.0006.png is 8x5, but") && stderr.contains("f.0000.png is 8x6"), "{stderr}");
    frames(&folder, [6].into_iter(), [8, 6]);
    let exactly = Folder::new("video-exact");
    assert!(refused(&exactly.0.to_string_lossy()).contains("no numbered .png or .exr files"));
    assert!(refused(&folder.file("g.####.png")).contains("there are no frames like"));
    assert!(refused(&folder.file("f.0000.png")).contains("name frames by a pattern"));
    fs::copy(folder.file("f.0000.png"), folder.file("g_1.png")).unwrap();
    let stderr = refused(&folder.0.to_string_lossy());
    assert!(stderr.contains("f.####.png (8), g_#.png (1)"), "{stderr}");
    assert!(fail(2, &["encode", &pattern, "-o", &folder.file("v.avi")]).contains(".mp4, .mov, .webm, .mkv"));
    assert!(fail(2, &["encode", &pattern, "-o", &file, "--quality", "3"]).contains("loses nothing"));
    assert!(fail(3, &["encode", &pattern, "-o", &folder.file("nowhere/v.png")]).contains("does not exist"));
    let bytes = fs::read(folder.file("f.0003.png")).unwrap();
    fs::write(folder.file("f.0003.png"), &bytes[..bytes.len() / 2]).unwrap();
    fs::write(&file, "old").unwrap();
    assert!(fail(1, &["encode", &pattern, "-o", &file]).contains("f.0003.png"));
    assert_eq!(fs::read_to_string(&file).unwrap(), "old");
}

#[test]
fn a_missing_ffmpeg_is_told_with_the_remedy() {
    let folder = Folder::new("no-ffmpeg");
    let pattern = frames(&folder, 0..1, [8, 6]);
    let output = command(&["encode", &pattern, "-o", &folder.file("v.mp4")]).env("PATH", "").output().unwrap();
    let run: Run = output.into();
    assert_eq!(run.code, Some(3));
    assert!(run.stderr.contains("apt-get install ffmpeg"), "{}", run.stderr);
    assert_eq!(folder.names(), ["f.0000.png"]);
}

/// What a failing ffmpeg says reaches the user, and no file does; nor does one with other frames than went in.
#[cfg(unix)]
#[test]
fn ffmpegs_failures_are_shown() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("ffmpeg-fails");
    let pattern = frames(&folder, 0..3, [8, 6]);
    fs::create_dir(folder.file("bin")).unwrap();
    let run_with = |ffmpeg: &str| -> Run {
        let scripts = [("ffmpeg", ffmpeg), ("ffprobe", "[ $1 = -version ] || echo 2")];
        for (name, script) in scripts {
            let file = folder.file(&format!("bin/{name}"));
            fs::write(&file, format!("#!/bin/sh\n{script}\n")).unwrap();
            fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
        }
        let path = format!("{}:/usr/bin:/bin", folder.file("bin"));
        command(&["encode", &pattern, "-o", &folder.file("v.mp4")]).env("PATH", path).output().unwrap().into()
    };
    for (ffmpeg, message) in [
        ("[ $1 = -version ] || { echo the encoder is missing >&2; exit 1; }", "ffmpeg says: the encoder is missing"),
        ("[ $1 = -version ] || cat > /dev/null", "of 3 frames 2 are in the video"),
    ] {
        let run = run_with(ffmpeg);
        assert_eq!(run.code, Some(3));
        assert!(run.stderr.contains(message), "{}", run.stderr);
        assert_eq!(folder.names(), ["bin", "f.0000.png", "f.0001.png", "f.0002.png"]);
    }
}
