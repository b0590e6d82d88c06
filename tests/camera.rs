//! The camera: parts of pictures, pixels that are not square, apertures.

use glam::{Vec2, Vec3};
use pellicle::document::{Lens, Projection};
use pellicle::integrate::{PathLimits, Strategy};
use pellicle::mode::{Mode, Rgb, Spectral};
use pellicle::render::{Filter, Frame, Plan, Unwatched, render};
use pellicle::scene::{Camera, FilmOptions, Framing, Raster, Scene, Stage, Window};
use std::sync::Arc;

use crate::transport::{Builder, coated, diffuse, glass, metal, shining};

/// Something of everything that pixels share: an edge of a lamp, indirect light, a film, light paths.
fn scene() -> Builder {
    let mut builder = Builder::seen_from(Vec3::new(0.0, 0.5, 4.0), 50.0);
    builder.floor(Vec3::new(0.0, -1.0, 0.0), 3.0, diffuse(0.6));
    builder.sphere(Vec3::new(-0.8, 0.0, 0.0), 0.7, coated(metal(1.0, 3.0, 0.2), 1.5, 350.0));
    builder.sphere(Vec3::new(0.2, -0.5, 0.8), 0.4, glass(1.5, 0.0));
    builder.sphere(Vec3::new(0.9, 0.6, 0.0), 0.3, shining(diffuse(0.0), 5.0));
    builder
}

fn picture<M: Mode>(builder: &Builder, raster: Raster) -> Frame {
    let stage = Arc::new(Stage::new(&builder.0, 1).unwrap());
    let scene = Scene::<M>::new(stage.clone(), &FilmOptions { tolerance: 1.0, rung: None }).unwrap();
    let (camera, _) = Camera::new(&builder.0, None, raster, Framing::Scene, stage.bounds).unwrap();
    let limits = PathLimits { max_bounces: 4, strategy: Strategy::Shared };
    let plan = Plan { spp: 3, seed: 5, threads: 2, filter: Filter::BlackmanHarris, limits, clamp: None, noise: None };
    render(&scene, &camera, &plan, &Unwatched).unwrap()
}

fn crops_are_pieces<M: Mode>() {
    let builder = scene();
    let size = [70, 45];
    let raster = Raster::from(size.map(Some));
    let whole = picture::<M>(&builder, raster);
    for (x, y, width, height) in [(0, 0, 70, 45), (69, 44, 1, 1), (13, 7, 25, 30), (16, 16, 16, 16), (31, 0, 2, 45)] {
        let crop = Window { x, y, width, height };
        let part = picture::<M>(&builder, Raster { crop: Some(crop), ..raster });
        assert_eq!((part.width, part.height, part.size, part.window), (width, height, size, crop));
        for (i, (rgb, variance)) in part.rgb.iter().zip(&part.variance).enumerate() {
            let index = ((y + i as u32 / width) * size[0] + x + i as u32 % width) as usize;
            assert_eq!((rgb, variance), (&whole.rgb[index], &whole.variance[index]), "pixel {i} of {crop:?}");
        }
    }
}

#[test]
fn pixels_of_a_crop_have_the_bits_of_the_whole() {
    crops_are_pieces::<Rgb>();
    crops_are_pieces::<Spectral<4>>();
}

#[test]
fn a_crop_must_lie_in_the_picture() {
    let builder = scene();
    let stage = Stage::new(&builder.0, 1).unwrap();
    for (x, y, width, height) in [(60, 0, 11, 1), (0, 40, 1, 6), (70, 0, 1, 1), (u32::MAX, 0, 2, 1)] {
        let raster = Raster { crop: Some(Window { x, y, width, height }), ..Raster::from([Some(70), Some(45)]) };
        let refused = Camera::new(&builder.0, None, raster, Framing::Scene, stage.bounds);
        assert!(refused.is_err_and(|reason| reason.contains("leaves the picture of 70x45")));
    }
}

/// Pixels twice as wide as high: the same view in half as many columns.
#[test]
fn wide_pixels_squeeze_the_picture() {
    let mut builder = Builder::seen_from(Vec3::new(0.0, 0.0, 5.0), 30.0);
    builder.sphere(Vec3::ZERO, 0.8, shining(diffuse(0.0), 1.0));
    let lit = |raster| {
        let frame = picture::<Rgb>(&builder, raster);
        let total: f32 = frame.rgb.iter().map(|pixel| pixel[0]).sum();
        ([frame.width, frame.height], total)
    };
    let (square, count) = lit(Raster::from([Some(80), None]));
    let (wide, fewer) = lit(Raster { pixel_aspect: 2.0, ..Raster::from([None, Some(80)]) });
    assert_eq!((square, wide), ([80, 80], [40, 80]));
    assert!((count / fewer - 2.0).abs() < 0.03, "{count} and {fewer}");
}

/// Rays of a thin lens start evenly all over its aperture and meet in the plane of focus.
#[test]
fn lenses_are_round_or_have_blades() {
    let (radius, focus) = (0.25f32, 4.0);
    for blades in [0, 3, 6] {
        let mut builder = Builder::seen_from(Vec3::ZERO, 30.0);
        builder.0.cameras[0].lens = Some(Lens { aperture_radius_m: radius, focus_distance_m: focus, blades });
        let bounds = (Vec3::NEG_ONE, Vec3::ONE);
        let (camera, _) = Camera::new(&builder.0, None, [Some(64); 2], Framing::Scene, bounds).unwrap();
        let (mut farthest, mut squares) = (Vec2::ZERO, 0.0);
        for i in 0..128 * 128u32 {
            let u = [(i % 128) as f32 + 0.5, (i / 128) as f32 + 0.5].map(|u| u / 128.0);
            let ray = camera.ray(Vec2::new(20.0, 50.0), u);
            let on_lens = ray.origin.truncate() / radius;
            farthest = farthest.max(on_lens.abs());
            squares += on_lens.length_squared() / (128.0 * 128.0);
            // The same point of the plane, wherever the ray started.
            let sharp = camera.ray(Vec2::new(20.0, 50.0), [0.5; 2]);
            let meets = |ray: &pellicle::embree::Ray| ray.at((-focus - ray.origin.z) / ray.dir.z);
            assert!(meets(&ray).distance(meets(&sharp)) < 1e-5, "{blades} blades");
        }
        // Second moments of a disc and of polygons with a corner at the top.
        let (sides, turn) = (blades as f32, std::f32::consts::TAU / blades.max(1) as f32);
        let moment = if blades == 0 { 0.5 } else { (2.0 + turn.cos()) / 6.0 };
        let width = if blades == 0 { 1.0 } else { (turn * (sides / 4.0).round()).sin() };
        assert!((squares - moment).abs() < 2e-3, "{blades} blades: {squares} for {moment}");
        assert!((farthest - Vec2::new(width, 1.0)).abs().max_element() < 0.02, "{blades} blades: {farthest}");
    }
}

/// A point is seen where the ray that goes through it starts, from the same side; a pixel covers what its corners enclose.
#[test]
fn points_are_seen_where_rays_come_from() {
    let lens = Lens { aperture_radius_m: 0.2, focus_distance_m: 2.5, blades: 5 };
    let orthographic = Projection::Orthographic { xmag: Some(1.5), ymag: None, aspect: Some(1.4) };
    for (projection, lens) in [(None, None), (None, Some(lens)), (Some(orthographic), None)] {
        let mut builder = scene();
        let source = &mut builder.0.cameras[0];
        (source.lens, source.shift) = (lens, Vec2::new(0.1, -0.2));
        source.projection = projection.unwrap_or(source.projection);
        let bounds = (Vec3::splat(-1.0), Vec3::ONE);
        let (camera, _) = Camera::new(&builder.0, None, [Some(70), Some(50)], Framing::Scene, bounds).unwrap();
        for (pixel, u, t) in
            [([0.5, 0.5], [0.3, 0.9], 0.7), ([69.9, 20.0], [0.8, 0.1], 2.5), ([31.0, 49.0], [0.5; 2], 40.0)]
        {
            let pixel = Vec2::from(pixel);
            let ray = camera.ray(pixel, u);
            let seen = camera.see(ray.at(t), u).unwrap();
            assert!(seen.at.distance(pixel) < 1e-3, "{:?} for {pixel}", seen.at);
            assert!(seen.toward.distance(-ray.dir) < 1e-5 && (seen.distance_m / t - 1.0).abs() < 1e-5);
            // The square of the pixel around it on the plane through the point that faces the viewer.
            let on_plane = |x: f32, y: f32| {
                let corner = camera.ray(pixel + Vec2::new(x, y), u);
                corner.at((ray.at(t) - corner.origin).dot(ray.dir) / corner.dir.dot(ray.dir))
            };
            let (across, down) = (on_plane(0.5, 0.0) - on_plane(-0.5, 0.0), on_plane(0.0, 0.5) - on_plane(0.0, -0.5));
            let area_m2 = across.cross(down).length();
            assert!((seen.pixel_m2 / area_m2 - 1.0).abs() < 2e-3, "{} for {area_m2}", seen.pixel_m2);
            assert!(camera.see(ray.at(-t), u).is_none() || camera.depth_m(ray.at(-t)) > 0.0);
        }
    }
}
