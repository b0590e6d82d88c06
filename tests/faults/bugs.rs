//! A panic in mid-render: an error that names the pixel and the sample, and nothing of the other tiles lost.
//!
//! The program has no panic that anyone knows of. Here a document that no file can give stands for it: a surface of it asks for
//! texture coordinates that there are none of, and that panics where a path meets it.

use std::sync::Arc;

use glam::{Mat4, Vec2, Vec3};
use pellicle::batch::checkpoint::Saver;
use pellicle::document::{
    Base, Channel4, Encoding, Group, Image, ImageSource, Map, Mesh, Shape, SurfaceEmission, Texture, UvSet, Wrap,
};
use pellicle::error::Error;
use pellicle::integrate::{PathLimits, Strategy};
use pellicle::mode::Rgb;
use pellicle::render::{Accumulation, Filter, Plan, RenderError, Unwatched, accumulate};
use pellicle::scene::{Camera, FilmOptions, Framing, Raster, Scene, Stage};

use super::*;
use crate::transport::{Builder, material};

const SIZE: [u32; 2] = [48, 48];

/// A sky, and a speck somewhat left of the middle that few samples meet: all of them panic.
fn treacherous() -> Builder {
    let mut builder = Builder::seen_from(Vec3::new(0.0, 0.0, 1.0), 90.0);
    builder.sky(1.0);
    let source = ImageSource::Missing;
    builder.0.images.push(Image { id: "image".into(), uri: "a.png".into(), user: "material `m`".into(), source });
    let map = Map {
        image: 0,
        texcoord: String::new(),
        slot: 999,
        encoding: Encoding::Linear,
        channel: Channel4::R,
        wrap: [Wrap::Clamp; 2],
    };
    let mut speck = material(Base::Black);
    let radiance = Texture { value: Vec3::ONE, map: Some(map) };
    speck.emission = Some(SurfaceEmission { radiance, spectrum: Default::default(), two_sided: true });
    let mesh = Mesh {
        positions: [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| Vec3::new(x * 3e-3 - 0.2, y * 3e-3, 0.0)).to_vec(),
        uv_sets: vec![UvSet { set: 0, uvs: vec![Vec2::ZERO; 3] }],
        triangles: vec![[0, 1, 2]],
        groups: vec![Group { symbol: "m".into(), triangles: 0..1 }],
        ..Mesh::default()
    };
    builder.geometry(Mat4::IDENTITY, Shape::Mesh(mesh), speck);
    builder
}

#[test]
fn a_panic_names_pixel_and_sample_and_leaves_the_other_tiles() {
    let builder = treacherous();
    let stage = Arc::new(Stage::new(&builder.0, 1).unwrap());
    let raster = Raster::from(SIZE.map(Some));
    let (camera, _) = Camera::new(&builder.0, None, raster, Framing::Scene, stage.bounds).unwrap();
    let scene = Scene::<Rgb>::new(stage, &FilmOptions { tolerance: 1.0, rung: None }).unwrap();
    let limits = PathLimits { max_bounces: 2, strategy: Strategy::Bsdf };
    for threads in [1, 2] {
        let plan = Plan { spp: 4096, seed: 0, threads, filter: Filter::Box, limits, clamp: None, noise: None };
        let mut sums = Accumulation::new(SIZE, 0..plan.spp);
        let error = accumulate(&scene, &camera, &plan, &mut sums, &Unwatched).unwrap_err();
        let text = error.to_string();
        let RenderError::Bug { at: Some(([x, y], sample)), .. } = error else { panic!("{text}") };
        // The speck is at x = -0.2 of -1..1, just above the middle.
        assert_eq!([x, y], [19, 23], "{text}");
        assert!(text.contains(&format!("met at sample {sample} of pixel {x},{y}: ")), "{text}");
        assert!(text.contains("index out of bounds"), "{text}");
        // It was not the first sample: all tiles have what came before, and no tile has half a pass.
        assert!(sums.spp() > 0 && sums.spp() <= sample, "{text} after {} spp", sums.spp());
        let rgb = sums.rgb();
        assert!(rgb.iter().flatten().all(|value| *value == 1.0), "the sky, whole in every tile");
    }
}

/// What is there is saved as after a signal.
#[test]
fn what_was_rendered_before_a_panic_is_in_the_checkpoint() {
    let folder = Folder::new("bug");
    let document = treacherous().0;
    let mut plan = crate::faults::bits::plan(SIZE, 4096);
    plan.render.limits = PathLimits { max_bounces: 2, strategy: Strategy::Bsdf };
    let (stage, camera, _) = pellicle::batch::still::stage(&document, &plan).unwrap();
    let prepared = pellicle::batch::still::prepare::<Rgb>(&document, &plan, &stage, &camera).unwrap();
    let saver = Saver::new(&prepared, &document, &plan, String::new(), Path::new(&folder.file("a.exr"))).unwrap();
    let mut sums = Accumulation::new(SIZE, 0..plan.render.spp);
    let error = saver.accumulate(&mut sums, Duration::from_secs(3600), &Unwatched).unwrap_err();
    assert!(matches!(error, Error::Render(RenderError::Bug { .. })) && error.exit_code() == 1, "{error}");
    let restored = saver.restore(&saver.checkpoint, &(0..plan.render.spp), |_| ()).unwrap().unwrap();
    assert!(restored.spp() > 0);
    assert_eq!((restored.spp(), restored.rgb()), (sums.spp(), sums.rgb()));
}
