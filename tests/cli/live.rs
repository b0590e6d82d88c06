//! Pictures that are looked at while they are rendered.

use std::net::{TcpListener, TcpStream};

use pellicle::output::Picture;

use super::*;

/// A picture as a viewer has it.
struct Viewed {
    name: String,
    size: [usize; 2],
    pixels: Vec<[f32; 3]>,
    updates: usize,
}

/// Reads a packet's content from the front.
struct Content<'a>(&'a [u8]);

impl Content<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (front, rest) = self.0.split_first_chunk().unwrap();
        self.0 = rest;
        *front
    }

    fn int(&mut self) -> usize {
        usize::try_from(i32::from_le_bytes(self.bytes())).unwrap()
    }

    fn long(&mut self) -> usize {
        usize::try_from(i64::from_le_bytes(self.bytes())).unwrap()
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).unwrap();
        let text = std::str::from_utf8(&self.0[..end]).unwrap().to_owned();
        self.0 = &self.0[end + 1..];
        text
    }

    fn channels(&mut self) {
        let count = self.int();
        let names: Vec<String> = (0..count).map(|_| self.text()).collect();
        assert_eq!(names, ["R", "G", "B"]);
    }
}

/// The next packet; `None` at the end.
fn packet(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let mut length = [0; 4];
    stream.read_exact(&mut length).ok()?;
    let mut content = vec![0; u32::from_le_bytes(length) as usize - 4];
    stream.read_exact(&mut content).unwrap();
    Some(content)
}

/// Does what tev does with what it is sent.
fn view(mut stream: TcpStream) -> Viewed {
    let create = packet(&mut stream).unwrap();
    let mut content = Content(&create);
    let [kind, _focus] = content.bytes();
    assert_eq!(kind, 4);
    let name = content.text();
    let size = [content.int(), content.int()];
    content.channels();
    assert!(content.0.is_empty());
    let mut viewed = Viewed { name, size, pixels: vec![[0.0; 3]; size[0] * size[1]], updates: 0 };
    while let Some(update) = packet(&mut stream) {
        let mut content = Content(&update);
        let [kind, focus] = content.bytes();
        assert_eq!((kind, focus), (6, 0));
        assert_eq!(content.text(), viewed.name);
        content.channels();
        let [x, y, width, height] = std::array::from_fn(|_| content.int());
        let offsets: [usize; 3] = std::array::from_fn(|_| content.long());
        let steps: [usize; 3] = std::array::from_fn(|_| content.long());
        let values: Vec<f32> = content.0.chunks(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect();
        assert_eq!(values.len(), 3 * width * height);
        for i in 0..width * height {
            let pixel = (y + i / width) * size[0] + x + i % width;
            viewed.pixels[pixel] = std::array::from_fn(|channel| values[offsets[channel] + i * steps[channel]]);
        }
        viewed.updates += 1;
    }
    viewed
}

/// Somewhere to connect to, and the viewer behind it.
fn viewer(view: fn(TcpStream) -> Viewed) -> (String, std::thread::JoinHandle<Viewed>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    (address, std::thread::spawn(move || view(listener.accept().unwrap().0)))
}

fn colours(picture: &Picture) -> Vec<[f32; 3]> {
    picture.rgba.iter().map(|&[r, g, b, _]| [r, g, b]).collect()
}

#[test]
fn a_viewer_ends_with_the_pixels_of_the_file() {
    let folder = Folder::new("shown");
    // More than one packet in either direction, the last ones smaller.
    for (command, output, file, options) in [
        ("render", "a.exr", "a.exr", &["--size", "300x270"][..]),
        ("turntable", "f.##.exr", "f.01.exr", &["--frames", "2", "--size", "40x30"]),
    ] {
        let (address, viewer) = viewer(view);
        let output = folder.file(output);
        let start = [command, "room.dae", "-o", &output, "--float", "--spp", "4", "--display", &address];
        let run = succeed(&[&start[..], options].concat());
        assert!(!run.stderr.contains("viewer is gone"), "{}", run.stderr);
        let viewed = viewer.join().unwrap();
        let picture = read_exr(Path::new(&folder.file(file))).unwrap();
        assert!(viewed.name.contains(if command == "render" { "a.exr" } else { "f." }), "{}", viewed.name);
        assert_eq!(viewed.size, [picture.width as usize, picture.height as usize]);
        assert!(viewed.pixels == colours(&picture), "{command}");
        assert!(viewed.updates >= 2);
    }
}

#[test]
fn a_viewer_that_goes_away_is_missed_once() {
    let folder = Folder::new("vanishing");
    let (address, viewer) = viewer(|mut stream| {
        packet(&mut stream);
        Viewed { name: String::new(), size: [0; 2], pixels: Vec::new(), updates: 0 }
    });
    let file = folder.file("a.exr");
    let run = succeed(&["render", "room.dae", "-o", &file, "--spp", "8", "--size", "700x600", "--display", &address]);
    viewer.join().unwrap();
    assert_eq!(run.stderr.matches("warning: the viewer is gone").count(), 1, "{}", run.stderr);
    assert!(is_complete(Path::new(&file)));
}

#[test]
fn a_viewer_that_is_not_there_is_told_before_rendering() {
    let folder = Folder::new("no-viewer");
    // A port that was free a moment ago.
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let stderr = fail(3, &["render", "room.dae", "-o", &folder.file("a.exr"), "--display", &address]);
    assert!(stderr.contains(&format!("error: no viewer at {address}")), "{stderr}");
    assert!(stderr.contains("start tev"), "{stderr}");
    assert!(folder.names().is_empty());
}

#[test]
fn a_preview_is_whole_at_any_moment_and_ends_as_the_picture() {
    let folder = Folder::new("preview");
    let (file, preview) = (folder.file("a.exr"), folder.file("p.exr"));
    let arguments = ["render", "room.dae", "-o", &file, "--float", "--size", "160x120", "--spp", "600"];
    let mut child = command(&[&arguments[..], &["--preview", &preview, "--preview-every", "0.05s", "-q"]].concat())
        .spawn()
        .unwrap();
    let mut seen = Vec::new();
    while child.try_wait().unwrap().is_none() {
        if Path::new(&preview).exists() {
            let picture = read_exr(Path::new(&preview)).unwrap();
            seen.push(colours(&picture));
            seen.dedup();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(child.wait().unwrap().success());
    assert!(seen.len() > 1, "{} versions", seen.len());
    let last = read_exr(Path::new(&preview)).unwrap();
    assert!(colours(&last) == colours(&read_exr(Path::new(&file)).unwrap()));
    assert_eq!(folder.names(), ["a.exr", "p.exr"]);
    let stderr = fail(3, &[&arguments[..], &["--preview", &folder.file("p.jpg")]].concat());
    assert!(stderr.contains("p.jpg"), "{stderr}");
}
