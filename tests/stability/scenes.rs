//! Whole pictures of a few pixels: extreme sizes, places, lights, materials and meshes.

use std::sync::Arc;

use glam::{Mat4, Vec3};
use pellicle::document::{AreaShape, Falloff, Group, LightKind, Material, Mesh, Presence, Shape};
use pellicle::integrate::{PathLimits, Strategy};
use pellicle::mode::{Mode, Rgb, Spectral};
use pellicle::render::{Filter, Frame, Plan, Unwatched, render};
use pellicle::scene::{self, FilmOptions, Framing, Scene, Stage};

use super::Count;
use crate::transport::{Builder, coated, diffuse, glass, mean, metal, quad, shining};

const LIMITS: PathLimits = PathLimits { max_bounces: 6, strategy: Strategy::Shared };

fn picture<M: Mode>(scene: &Builder, size: [u32; 2], spp: u32) -> Frame {
    let stage = Arc::new(Stage::new(&scene.0, 1).unwrap());
    let compiled = Scene::<M>::new(stage.clone(), &FilmOptions { tolerance: 1.0, rung: None }).unwrap();
    let size = size.map(Some);
    let (camera, _) = scene::Camera::new(&scene.0, None, size, Framing::Scene, stage.bounds).unwrap();
    let plan = Plan { spp, seed: 1, threads: 1, filter: Filter::Box, limits: LIMITS, clamp: None, noise: None };
    render(&compiled, &camera, &plan, &Unwatched).unwrap()
}

/// Finite, nothing negative that matters, and no more light than `most` on average.
fn physical(count: &mut Count, frame: &Frame, most: f64, at: &dyn Fn() -> String) {
    count.assert(frame.tally.non_finite == 0, || format!("{}: {} samples not finite", at(), frame.tally.non_finite));
    let values = || frame.rgb.iter().flatten();
    count.assert(values().all(|v| v.is_finite()), || format!("{}: not finite", at()));
    let total = values().map(|v| f64::from(*v)).sum::<f64>() / values().count() as f64;
    count.assert(total >= -1e-3 * most && total <= most, || format!("{}: mean {total}, at most {most}", at()));
}

/// Everything that was placed, `scale` times as large and moved by `shift`.
fn transformed(mut scene: Builder, scale: f32, shift: Vec3) -> Builder {
    scene.0.to_world = Mat4::from_translation(shift) * Mat4::from_scale(Vec3::splat(scale));
    scene.0.come_near();
    scene
}

/// The box [-1, 1]^3, closed.
fn closed_box() -> Shape {
    let corner = |i: u32| Vec3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }));
    let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles: Vec<[u32; 3]> = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let groups = vec![Group { symbol: "m".into(), triangles: 0..12 }];
    Shape::Mesh(Mesh { positions: (0..8).map(corner).collect(), triangles, groups, ..Mesh::default() })
}

const SCALES: [f32; 5] = [1e-6, 1e-3, 1.0, 1e3, 1e6];

fn shifts(scale: f32) -> [Vec3; 4] {
    [Vec3::ZERO, Vec3::new(1e6, 0.0, 0.0), Vec3::splat(10.0 * scale), Vec3::new(0.0, 1e6 * scale, 1e6 * scale)]
}

#[test]
fn no_light_leaks_into_closed_bodies_of_any_size_and_place() {
    let mut count = Count::default();
    for scale in SCALES {
        for shift in shifts(scale) {
            for round in [false, true] {
                for turn in [0.0, 0.7] {
                    count.combination();
                    let mut scene = Builder::seen_from(Vec3::new(0.1, 0.2, 0.3), 100.0);
                    if round {
                        scene.sphere(Vec3::ZERO, 1.0, diffuse(0.9));
                    } else {
                        scene.geometry(Mat4::from_rotation_y(turn), closed_box(), diffuse(0.9));
                    }
                    scene.sky(1.0);
                    scene.light(Mat4::IDENTITY, LightKind::Directional { angle_deg: 0.5 }, Vec3::splat(1e6));
                    let frame = picture::<Rgb>(&transformed(scene, scale, shift), [12, 12], 16);
                    let leaked = frame.rgb.iter().flatten().filter(|v| **v != 0.0).count();
                    count.assert(leaked == 0, || {
                        format!("size {scale}, moved by {shift}, round {round}, turned {turn}: {leaked} of 432 leak")
                    });
                }
            }
        }
    }
    count.finish(80);
}

/// A floor, a ball, glass, a bubble and a lamp.
fn still_life() -> Builder {
    let mut scene = Builder::seen_from(Vec3::new(0.0, 1.0, 4.0), 45.0);
    scene.floor(Vec3::ZERO, 3.0, diffuse(0.6));
    scene.sphere(Vec3::new(-0.9, 0.5, 0.0), 0.5, coated(metal(0.2, 3.0, 0.25), 1.33, 400.0));
    scene.sphere(Vec3::new(0.9, 0.5, 0.0), 0.5, coated(glass(1.5, 0.3), 1.9, 300.0));
    scene.geometry(
        Mat4::from_translation(Vec3::new(0.0, 0.6, 0.8)) * Mat4::from_scale(Vec3::splat(0.3)),
        closed_box(),
        glass(1.5, 0.0),
    );
    scene.sphere(Vec3::new(1.5, 2.2, 0.5), 0.3, shining(diffuse(0.0), 6.0));
    scene.sky(0.3);
    scene
}

#[test]
fn size_and_place_do_not_change_a_picture() {
    let mut count = Count::default();
    let (truth, noise) = mean(&picture::<Rgb>(&still_life(), [16, 16], 64));
    for scale in SCALES {
        for shift in shifts(scale) {
            count.combination();
            let frame = picture::<Rgb>(&transformed(still_life(), scale, shift), [16, 16], 64);
            let at = || format!("size {scale}, moved by {shift}");
            physical(&mut count, &frame, 6.0, &at);
            let (here, error) = mean(&frame);
            // The same random numbers: nearly the same paths.
            count.assert((here - truth).abs() < 3.0 * noise.hypot(error), || {
                format!("{}: {here} for {truth} +- {noise}", at())
            });
        }
    }
    count.finish(20);
}

fn materials() -> Vec<(&'static str, Material)> {
    vec![
        ("white", diffuse(1.0)),
        ("mirror", metal(0.0, 10.0, 0.0)),
        ("barely rough metal", metal(0.2, 3.0, 1e-6)),
        ("rough metal", coated(metal(0.2, 3.0, 1.0), 2.4, 50_000.0)),
        ("glass", glass(1.5, 0.0)),
        ("barely rough glass", glass(1.5, 1e-3)),
        ("coated glass", coated(glass(1.5, 0.4), 0.5, 1e-3)),
        ("dense glass", coated(glass(4.0, 1.0), 1.0, 300.0)),
        ("bubble", coated(glass(1.0, 0.0), 1.33, 400.0)),
        ("rough bubble", coated(glass(1.0, 0.5), 2.4, 400.0)),
        ("lacquer", coated(diffuse(1.0), 10.0, 100.0)),
    ]
}

/// Lamps by name, with the radiance that no surface can exceed, or infinity where a point has none.
fn lamp(scene: &mut Builder, which: usize) -> (&'static str, f64) {
    let above = |scale: f32| {
        Mat4::from_translation(Vec3::new(0.3, 3.0, 1.0))
            * Mat4::from_rotation_x(-1.4)
            * Mat4::from_scale(Vec3::splat(scale))
    };
    let area = |shape| LightKind::Area { shape, presence: Presence::Solid };
    match which {
        0 => {
            scene.sky(1.0);
            ("sky", 1.0)
        }
        1 => {
            scene.light(above(1e-4), area(AreaShape::Rectangle), Vec3::splat(1e8));
            ("a pin of 1e-8 m2", 1e8)
        }
        2 => {
            scene.light(above(1e4), area(AreaShape::Disk), Vec3::ONE);
            ("a disk of 1e8 m2", 1.0)
        }
        3 => {
            scene.light(Mat4::from_rotation_x(-0.8), LightKind::Directional { angle_deg: 0.5 }, Vec3::splat(6e4));
            ("a sun of 1e9 W/(sr m2)", 1.1e9)
        }
        4 => {
            let point = LightKind::Point { radius_m: 0.0, falloff: Falloff::Physical };
            scene.light(above(1.0), point, Vec3::splat(10.0));
            ("a point", f64::INFINITY)
        }
        _ => {
            // In the body itself.
            scene.sphere(Vec3::new(0.0, 1.0, 0.0), 0.2, shining(diffuse(0.5), 5.0));
            ("a lamp inside", 10.0)
        }
    }
}

#[test]
fn any_material_under_any_lamp_from_outside_and_inside() {
    let mut count = Count::default();
    for (name, material) in materials() {
        for which in 0..6 {
            for eye in [Vec3::new(0.0, 1.0, 4.0), Vec3::new(0.0, 1.0, 0.5)] {
                for ball in [true, false] {
                    count.combination();
                    let mut scene = Builder::seen_from(eye, 60.0);
                    scene.floor(Vec3::ZERO, 1e5, diffuse(0.5));
                    let place = Mat4::from_translation(Vec3::Y);
                    if ball {
                        scene.sphere(Vec3::Y, 1.0, material.clone());
                    } else {
                        scene.geometry(place, closed_box(), material.clone());
                    }
                    let (lamp, most) = lamp(&mut scene, which);
                    let at = || format!("{name}, {lamp}, from {eye}, ball {ball}");
                    // Inside dense bodies radiance is up to n^2 of what it is outside.
                    let frame = picture::<Rgb>(&scene, [5, 5], 8);
                    physical(&mut count, &frame, 16.0 * most, &at);
                    if which == 0 || which == 5 {
                        physical(&mut count, &picture::<Spectral<4>>(&scene, [5, 5], 4), 16.0 * most, &at);
                    }
                }
            }
        }
    }
    count.finish(200);
}

/// Triangles that are not quite triangles.
fn meshes() -> Vec<(&'static str, Vec<Vec3>)> {
    let v = Vec3::new;
    vec![
        ("a point", vec![v(0.0, 1.0, 0.0); 3]),
        ("a line", vec![v(0.0, 1.0, 0.0), v(1.0, 1.0, 0.0), v(2.0, 1.0, 0.0)]),
        ("a sliver", vec![v(-1.0, 1.0, 0.0), v(1.0, 1.0, 0.0), v(0.0, 1.0 + 1e-7, 0.0)]),
        ("a thin one", vec![v(-1.0, 1.0, 0.0), v(1.0, 1.0, 0.0), v(0.0, 1.001, 0.0)]),
        ("a huge one", vec![v(-1e8, 0.5, -1e8), v(1e8, 0.5, -1e8), v(0.0, 0.5, 1e8)]),
        ("a speck", vec![v(0.0, 1.0, 0.0), v(1e-6, 1.0, 0.0), v(0.0, 1.0 + 1e-6, 0.0)]),
        ("three at once", [[v(-1.0, 0.5, 0.0), v(1.0, 0.5, 0.0), v(0.0, 2.0, 0.0)]; 3].concat()),
    ]
}

#[test]
fn degenerate_coincident_and_huge_triangles() {
    let mut count = Count::default();
    for (mesh, positions) in meshes() {
        for (name, material) in materials() {
            for shines in [false, true] {
                for normals in [false, true] {
                    count.combination();
                    let mut scene = Builder::seen_from(Vec3::new(0.0, 1.0, 4.0), 40.0);
                    let material = if shines { shining(material.clone(), 2.0) } else { material.clone() };
                    let triangles: Vec<[u32; 3]> =
                        (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
                    let groups = vec![Group { symbol: "m".into(), triangles: 0..triangles.len() }];
                    // Normals that cancel out in the middle.
                    let normals =
                        if normals { [Vec3::X, -Vec3::X, Vec3::ZERO].repeat(triangles.len()) } else { Vec::new() };
                    let shape = Mesh { positions: positions.clone(), triangles, groups, normals, ..Mesh::default() };
                    scene.geometry(Mat4::IDENTITY, Shape::Mesh(shape), material);
                    scene.floor(Vec3::ZERO, 5.0, diffuse(0.5));
                    scene.sky(1.0);
                    let frame = picture::<Rgb>(&scene, [5, 5], 4);
                    physical(&mut count, &frame, 10.0, &|| format!("{mesh}, {name}, shines {shines}"));
                }
            }
        }
    }
    count.finish(200);
}

#[test]
fn pictures_of_one_pixel_and_of_one_row_and_very_many_samples() {
    let mut count = Count::default();
    let scene = still_life();
    for size in [[1, 1], [4096, 1], [1, 2048], [17, 3]] {
        count.combination();
        physical(&mut count, &picture::<Rgb>(&scene, size, 2), 6.0, &|| format!("{size:?}"));
    }
    // Beyond one Sobol sequence of 2^16 samples the next begins: no repetition, so the error goes on falling.
    let mut white = Builder::seen_from(Vec3::new(0.2, 0.1, 0.3), 60.0);
    white.sphere(Vec3::ZERO, 1.0, shining(diffuse(0.5), 1.0));
    count.combination();
    let (many, _) = mean(&picture::<Rgb>(&white, [1, 1], 70_000));
    let expected = f64::from((0..=LIMITS.max_bounces).map(|k| 0.5f32.powi(k as i32)).sum::<f32>());
    count.assert((many / expected - 1.0).abs() < 1e-3, || format!("70,000 samples: {many} for {expected}"));
    count.finish(5);
}

#[test]
fn mirrored_flattened_and_sheared_bodies() {
    let mut count = Count::default();
    let matrices = [
        Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)),
        Mat4::from_scale(Vec3::new(1.0, 1e-6, 1.0)),
        Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0)),
        Mat4::from_scale(Vec3::new(1e4, 1e-4, 1.0)),
        Mat4::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 100.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
    ];
    for matrix in matrices {
        for (name, material) in materials() {
            for plane in [false, true] {
                count.combination();
                let mut scene = Builder::seen_from(Vec3::new(0.0, 0.5, 4.0), 40.0);
                scene.geometry(matrix, if plane { quad(1.0) } else { closed_box() }, material.clone());
                scene.sky(1.0);
                let frame = picture::<Rgb>(&scene, [5, 5], 4);
                physical(&mut count, &frame, 16.0, &|| format!("{name}, {matrix}"));
            }
        }
    }
    count.finish(100);
}
