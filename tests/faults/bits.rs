//! The same scene, seed and samples give the same bits, however they are rendered. (Through the program: threads in
//! `cli::gives_the_same_bits_on_any_number_of_threads`, parts in any order and interrupted renders in `cli::merge`, frames in
//! `cli::batches`.)

use std::sync::Arc;

use pellicle::batch::still::{Look, StillPlan, prepare, stage};
use pellicle::collada::{LoadOptions, load};
use pellicle::integrate::{PathLimits, Strategy};
use pellicle::mode::{Mode, Rgb, Spectral};
use pellicle::output::{Display, PngDepth};
use pellicle::render::{Accumulation, Filter, Plan, Unwatched};
use pellicle::scene::{FilmOptions, Framing, Raster};

use super::*;

/// A still without anything special.
pub fn plan(size: [u32; 2], spp: u32) -> StillPlan {
    let limits = PathLimits { max_bounces: 6, strategy: Strategy::Shared };
    StillPlan {
        raster: Raster::from(size.map(Some)),
        camera: None,
        framing: Framing::Auto,
        films: FilmOptions { tolerance: 1.0, rung: None },
        render: Plan { spp, seed: 3, threads: 1, filter: Filter::BlackmanHarris, limits, clamp: None, noise: None },
        look: Look { display: Display::default(), png_depth: PngDepth::Eight, float: true },
        aovs: Vec::new(),
        denoise: false,
        max_memory: 1 << 30,
    }
}

/// The hash of a picture that is rendered with these threads, in these ranges of samples, the odd ones first.
fn hash<M: Mode>(file: &Path, threads: usize, cuts: &[u32]) -> String {
    let mut plan = plan([37, 21], 12);
    plan.render.threads = threads;
    let (document, _) = load(file, &LoadOptions::default()).unwrap();
    let (stage, camera, _) = stage(&document, &plan).unwrap();
    let prepared = prepare::<M>(&document, &plan, &Arc::clone(&stage), &camera).unwrap();
    let mut whole = Accumulation::new([37, 21], 0..12);
    let ranges: Vec<[u32; 2]> = cuts.windows(2).map(|cut| [cut[0], cut[1]]).collect();
    for [start, end] in ranges.iter().skip(1).step_by(2).chain(ranges.iter().step_by(2)) {
        let mut part = Accumulation::new([37, 21], *start..*end);
        assert!(prepared.accumulate(&plan, &mut part, &Unwatched).unwrap());
        let mut blocks: Vec<_> = part.blocks().collect();
        whole.add(&(*start..*end), &mut blocks.drain(..)).unwrap();
    }
    whole.into_frame(false).sha256()
}

/// Scenes with films, caustics and textures, in both colour modes.
#[test]
fn threads_and_parts_do_not_matter_in_any_scene_and_mode() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for name in ["bubbles.dae", "wine.dae", "christmas_balls.dae", "gold_knot.zae", "titanium.dae"] {
        let file = scenes.join(name);
        let rgb = hash::<Rgb>(&file, 1, &[0, 12]);
        for (threads, cuts) in [(2, &[0, 12][..]), (3, &[0, 1, 12]), (8, &[0, 5, 7, 11, 12])] {
            assert_eq!(hash::<Rgb>(&file, threads, cuts), rgb, "{name}, {threads} threads, cut at {cuts:?}");
        }
        let spectral = hash::<Spectral<8>>(&file, 1, &[0, 12]);
        assert_eq!(hash::<Spectral<8>>(&file, 5, &[0, 3, 12]), spectral, "{name}, spectral");
        assert_ne!(rgb, spectral);
    }
}
