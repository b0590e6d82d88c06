//! Ways into the program for bytes from strangers. Each function hands its input to readers that must come back: with a
//! value or with an error, within seconds, and within [`MOST_BYTES`].
//!
//! The fuzz targets call these, and so do the tests that replay what was found.

use std::cell::RefCell;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use pellicle::batch::frames::{FrameList, Pattern, Ring};
use pellicle::batch::merge::Merge;
use pellicle::batch::part::Part;
use pellicle::collada::{LoadOptions, MissingTexture, load};
use pellicle::document::{Changes, Document, Image, ImageSource};
use pellicle::film::Rung;
use pellicle::integrate::{PathLimits, Strategy};
use pellicle::mode::Rgb;
use pellicle::output::{Display, is_complete, note, picture_size, read_codes, read_exr};
use pellicle::render::{Filter, Frame, Plan, Watch, render};
use pellicle::scene::{Camera, FilmOptions, Framing, LightGroups, Raster, Scene, Stage, Texture};
use pellicle::study::Medium;

/// What `--max-memory` stands at.
pub const MOST_BYTES: u64 = 64_000_000;

/// A file of this thread, in memory where that can be.
struct Slot(PathBuf);

impl Slot {
    fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let folder = folder.join(format!("pellicle-feed-{}-{number}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder for the inputs");
        Self(folder)
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

thread_local! {
    static SLOT: RefCell<Slot> = RefCell::new(Slot::new());
}

/// Puts the bytes where a reader of files finds them.
fn with_file<T>(name: &str, bytes: &[u8], read: impl FnOnce(&Path) -> T) -> T {
    SLOT.with_borrow(|slot| {
        let path = slot.0.join(name);
        fs::write(&path, bytes).expect("a file for the input");
        read(&path)
    })
}

/// Strict or lenient, by the number of bytes.
fn options(bytes: &[u8]) -> LoadOptions {
    let other = bytes.len() % 2 == 1;
    let missing_texture = if other { MissingTexture::Magenta } else { MissingTexture::Error };
    LoadOptions {
        lenient: other,
        smooth_normals: other,
        missing_texture,
        max_bytes: MOST_BYTES,
        ..LoadOptions::default()
    }
}

/// COLLADA.
pub fn scene(bytes: &[u8]) {
    with_file("scene.dae", bytes, loaded);
}

/// `.zae`: the same inside a zip file.
pub fn archive(bytes: &[u8]) {
    with_file("scene.zae", bytes, loaded);
}

fn loaded(path: &Path) {
    let options = options(&fs::read(path).unwrap_or_default());
    match load(path, &options) {
        Ok((document, warnings)) => {
            document.placements();
            for warning in warnings {
                assert!(!warning.to_string().is_empty());
            }
            let mut posed = document.clone();
            let mut changes = Changes::default();
            for seconds in [0.0, 0.37, 1e9] {
                let _ = posed.pose(seconds, &mut changes);
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// COLLADA, all the way to some pixels.
pub fn picture(bytes: &[u8]) {
    let loaded = with_file("scene.dae", bytes, |path| load(path, &options(bytes)));
    let Ok((document, _)) = loaded else { return };
    if let Some(frame) = rendered(&document) {
        assert!(frame.rgb.iter().flatten().all(|value| value.is_finite()), "a pixel is not finite");
    }
}

/// Never stops a render.
struct Calm;

impl Watch for Calm {
    fn advanced(&self, _samples: u64) {}

    fn stop(&self) -> bool {
        false
    }
}

fn rendered(document: &Document) -> Option<Frame> {
    let stage = Arc::new(Stage::movable(document, 1, Vec::new(), LightGroups::default(), MOST_BYTES).ok()?);
    let raster = Raster::from([Some(4), Some(4)]);
    let (camera, _) = Camera::new(document, None, raster, Framing::Auto, stage.bounds).ok()?;
    // Choosing among film models takes longer than everything else here.
    let films = FilmOptions { tolerance: 1.0, rung: Some(Rung::ThreeWave) };
    let scene = Scene::<Rgb>::new(stage, &films).ok()?;
    let limits = PathLimits { max_bounces: 4, strategy: Strategy::Mis };
    let plan = Plan { spp: 1, seed: 0, threads: 1, filter: Filter::Box, limits, clamp: None, noise: None };
    render(&scene, &camera, &plan, &Calm).ok()
}

/// Textures and environments of every format.
pub fn image(bytes: &[u8]) {
    // TGA alone has no signature.
    let (id, uri, user) = (String::new(), "image.tga".to_owned(), "the test".to_owned());
    let image = Image { id, uri, user, source: ImageSource::Bytes(bytes.to_vec()) };
    if let Ok(texture) = Texture::load(&image, MOST_BYTES) {
        assert!(texture.width() > 0 && texture.height() > 0);
    }
}

/// Pictures of our own, as `--resume`, `compare` and `encode` read them back.
pub fn frame(bytes: &[u8]) {
    for name in ["frame.exr", "frame.png"] {
        with_file(name, bytes, |path| {
            is_complete(path);
            note(path, "pellicle/settings");
            let pixels = picture_size(path).map(|[width, height]| u64::from(width) * u64::from(height));
            if pixels.is_ok_and(|pixels| pixels <= 1 << 16) {
                let _ = read_codes(path, Display::PLAIN);
                let _ = read_exr(path);
            }
        });
    }
}

/// Parts and checkpoints.
pub fn part(bytes: &[u8]) {
    with_file("a.part", bytes, |path| {
        let Ok(merge) = Merge::plan(&[path.to_owned()], true, MOST_BYTES) else { return };
        let restored = Part::open(path).and_then(Part::restore);
        for sums in [merge.run(|_| {}), restored].into_iter().flatten() {
            sums.into_frame(true);
        }
    });
}

/// A table of refractive indices.
pub fn medium(bytes: &[u8]) {
    with_file("nk.csv", bytes, |path| {
        if let Ok(medium) = Medium::parse(&format!("@{}", path.display())) {
            assert!(medium.curve.at(550.0).is_finite());
        }
    });
}

/// What is written on the command line in languages of its own.
pub fn words(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Ok(frames) = FrameList::parse(&text) {
        assert_eq!(FrameList::parse(&frames.to_string()).as_ref(), Ok(&frames));
    }
    let _ = Ring::parse(&text);
    if let Ok((pattern, _)) = Pattern::parse(Path::new(text.as_ref())) {
        pattern.path(7);
    }
    // Files are the other target's business.
    if !text.trim_start().starts_with('@') {
        let _ = Medium::parse(&text);
    }
}

/// A command line, one argument a line.
pub fn arguments(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let words = std::iter::once("pellicle").chain(text.lines()).map(OsString::from);
    if let Err(error) = pellicle::cli::parse(words) {
        assert!(!error.to_string().is_empty());
    }
}
