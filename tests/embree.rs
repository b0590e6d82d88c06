//! Rays against closed forms, and what must not happen.

#![allow(clippy::unwrap_used)]

use glam::{Affine3A, Quat, Vec3};
use pellicle::embree::{Accel, AccelBuilder, BATCH, EmbreeError, Hit, Hits, Ray, Shape};

/// One triangle in the plane z = 0.
fn triangle(builder: &mut AccelBuilder) -> Shape {
    builder.mesh(vec![Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0], vec![[0, 1, 2]]).unwrap()
}

fn unit_sphere() -> Accel {
    let mut builder = AccelBuilder::new(1).unwrap();
    let sphere = builder.sphere(Vec3::new(1.0, 2.0, 3.0), 1.0).unwrap();
    builder.place(sphere).unwrap();
    builder.build().unwrap()
}

/// A closed unit sphere of triangles: `around` x `down` quadrilaterals, cut in two.
fn tessellated(around: u32, down: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for row in 0..=down {
        let (sin, cos) = (std::f32::consts::PI * row as f32 / down as f32).sin_cos();
        let sin = if row == down { 0.0 } else { sin }; // the vertices of a pole coincide, or there is a hole
        positions.extend((0..around).map(|column| {
            let (y, x) = (std::f32::consts::TAU * column as f32 / around as f32).sin_cos();
            Vec3::new(sin * x, sin * y, cos)
        }));
    }
    for row in 0..down {
        for column in 0..around {
            let (left, right) = (row * around + column, row * around + (column + 1) % around);
            triangles.extend([[left, left + around, right], [right, left + around, right + around]]);
        }
    }
    (positions, triangles)
}

/// Points on the unit sphere, evenly spread (Fibonacci lattice).
fn directions(count: usize) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f32 / count as f32;
        let (sin, cos) = (i as f32 * 2.399_963_1).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * cos, r * sin, z)
    })
}

fn near(a: Vec3, b: Vec3, tolerance: f32) -> bool {
    (a - b).length() <= tolerance
}

#[test]
fn a_triangle_is_hit_where_the_plane_says() {
    let mut builder = AccelBuilder::new(1).unwrap();
    let shape = triangle(&mut builder);
    assert_eq!(builder.place(shape), Ok(0));
    let accel = builder.build().unwrap();

    let ray = Ray::new(Vec3::new(0.5, 0.75, 4.0), Vec3::new(0.0, 0.0, -2.0));
    let hit = accel.intersect(&ray).unwrap();
    assert!((hit.t - 2.0).abs() < 1e-6); // in lengths of the direction
    assert!((hit.u - 0.25).abs() < 1e-6 && (hit.v - 0.25).abs() < 1e-6);
    assert_eq!(hit.ng, Vec3::new(0.0, 0.0, 6.0)); // (v1 - v0) x (v2 - v0)
    assert_eq!((hit.prim, hit.geom, hit.instance, hit.place()), (0, 0, u32::MAX, 0));
    assert!(accel.occluded(&ray));

    // From behind the normal is the same; it is not turned.
    let behind = Ray::new(Vec3::new(0.5, 0.75, -4.0), Vec3::Z);
    assert_eq!(accel.intersect(&behind).unwrap().ng, Vec3::new(0.0, 0.0, 6.0));
    assert!(accel.intersect(&Ray::new(Vec3::new(2.0, 2.0, 4.0), Vec3::NEG_Z)).is_none());
}

#[test]
fn only_the_segment_counts() {
    let mut builder = AccelBuilder::new(1).unwrap();
    let shape = triangle(&mut builder);
    builder.place(shape).unwrap();
    let accel = builder.build().unwrap();
    let ray = Ray::new(Vec3::new(0.5, 0.5, 1.0), Vec3::NEG_Z);
    for (tnear, tfar, met) in [(0.0, 0.999, false), (1.001, 9.0, false), (0.5, 1.5, true), (5.0, 1.0, false)] {
        let ray = Ray { tnear, tfar, ..ray };
        assert_eq!(accel.intersect(&ray).is_some(), met, "{ray:?}");
        assert_eq!(accel.occluded(&ray), met, "{ray:?}");
    }
}

#[test]
fn buffers_come_back_as_they_were_given() {
    let mut builder = AccelBuilder::new(1).unwrap();
    let shape = triangle(&mut builder);
    let sphere = builder.sphere(Vec3::ZERO, 1.0).unwrap();
    let accel = builder.build().unwrap();
    assert_eq!(accel.positions(shape), [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0]);
    assert_eq!(accel.triangles(shape), [[0, 1, 2]]);
    assert!(accel.positions(sphere).is_empty() && accel.triangles(sphere).is_empty());
}

#[test]
fn instances_share_a_shape_and_keep_their_own_place() {
    let mut builder = AccelBuilder::new(2).unwrap();
    let shape = triangle(&mut builder);
    assert_eq!(builder.place(shape), Ok(0));
    for i in 1..=100 {
        let transform = Affine3A::from_scale_rotation_translation(
            Vec3::new(2.0, 1.0, 1.0),
            Quat::from_rotation_x(std::f32::consts::PI),
            Vec3::new(10.0 * i as f32, 0.0, 0.0),
        );
        assert_eq!(builder.place_instance(shape, transform), Ok(i));
    }
    let accel = builder.build().unwrap();
    for i in 1..=100 {
        // Local (0.5, 0.6, 0): doubled in x, turned upside down, moved.
        let ray = Ray::new(Vec3::new(10.0 * i as f32 + 1.0, -0.6, 3.0), Vec3::NEG_Z);
        let hit = accel.intersect(&ray).unwrap();
        assert_eq!((hit.instance, hit.geom, hit.prim, hit.place()), (i, 0, 0, i));
        assert!((hit.t - 3.0).abs() < 1e-5 && (hit.u - 0.25).abs() < 1e-4 && (hit.v - 0.2).abs() < 1e-4, "{hit:?}");
        assert_eq!(hit.ng, Vec3::new(0.0, 0.0, 6.0)); // in the shape's own space
    }
    let direct = accel.intersect(&Ray::new(Vec3::new(0.5, 0.5, 1.0), Vec3::NEG_Z)).unwrap();
    assert_eq!((direct.instance, direct.place()), (u32::MAX, 0));
}

#[test]
fn instances_can_be_moved() {
    let mut builder = AccelBuilder::new(1).unwrap();
    let shape = triangle(&mut builder);
    builder.place(shape).unwrap();
    let place = builder.place_instance(shape, Affine3A::from_translation(Vec3::X * 100.0)).unwrap();
    let mut accel = builder.build().unwrap();
    let down = |x: f32| Ray::new(Vec3::new(x + 0.5, 0.5, 1.0), Vec3::NEG_Z);
    assert_eq!(accel.intersect(&down(100.0)).map(|hit| hit.place()), Some(place));

    accel.move_instances(&[(place, Affine3A::from_translation(Vec3::X * -50.0))]).unwrap();
    assert!(accel.intersect(&down(100.0)).is_none());
    assert_eq!(accel.intersect(&down(-50.0)).map(|hit| hit.place()), Some(place));
    assert_eq!(accel.intersect(&down(0.0)).map(|hit| hit.place()), Some(0));

    // A refused move changes nothing.
    assert_eq!(accel.move_instances(&[(0, Affine3A::IDENTITY)]), Err(EmbreeError::NotAnInstance { place: 0 }));
    let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let refused = accel.move_instances(&[(place, Affine3A::IDENTITY), (place, flat)]);
    assert_eq!(refused, Err(EmbreeError::Transform { place }));
    assert_eq!(accel.intersect(&down(-50.0)).map(|hit| hit.place()), Some(place));
}

#[test]
fn a_sphere_is_hit_where_the_quadratic_says() {
    let accel = unit_sphere();
    let center = Vec3::new(1.0, 2.0, 3.0);
    for dir in directions(1000) {
        let side = dir.any_orthonormal_vector() * 0.6; // passes the centre at 0.6: half chord 0.8
        let hit = accel.intersect(&Ray::new(center + side - 5.0 * dir, dir)).unwrap();
        assert!((hit.t - 4.2).abs() < 5e-6, "{}", hit.t);
        assert!(near(hit.ng, side - 0.8 * dir, 5e-6), "{:?}", hit.ng);
        assert_eq!((hit.prim, hit.place()), (0, 0));
        assert!(accel.intersect(&Ray::new(center + side * 1.7 - 5.0 * dir, dir)).is_none());
    }
}

#[test]
fn a_ray_from_inside_a_sphere_meets_the_far_side() {
    let accel = unit_sphere();
    let center = Vec3::new(1.0, 2.0, 3.0);
    for dir in directions(1000) {
        let side = dir.any_orthonormal_vector() * 0.6;
        let hit = accel.intersect(&Ray::new(center + side, dir)).unwrap();
        assert!((hit.t - 0.8).abs() < 2e-6, "{}", hit.t);
        assert!(near(hit.ng, side + 0.8 * dir, 2e-6), "{:?}", hit.ng);

        // From the surface, a hair inside and a hair outside.
        let surface = side - 0.8 * dir;
        let inside = Ray::new(center + surface * 0.99999, dir);
        assert!((accel.intersect(&inside).unwrap().t - 1.6).abs() < 3e-5);
        assert!(accel.intersect(&Ray::new(center + surface * 1.00001, surface)).is_none());
        // The near side lies before tnear, so the far side is the first.
        let skipping = Ray { tnear: 1.0, ..Ray::new(center - 1.5 * dir, dir) };
        assert!((accel.intersect(&skipping).unwrap().t - 2.5).abs() < 3e-6);
    }
}

#[test]
fn a_stretched_instance_of_a_sphere_is_an_exact_ellipsoid() {
    let mut builder = AccelBuilder::new(1).unwrap();
    let sphere = builder.sphere(Vec3::ZERO, 1.0).unwrap();
    builder.place_instance(sphere, Affine3A::from_scale(Vec3::new(3.0, 2.0, 1.0))).unwrap();
    let accel = builder.build().unwrap();
    let t = |dir: Vec3| accel.intersect(&Ray::new(-10.0 * dir, dir)).unwrap().t;
    assert!((t(Vec3::X) - 7.0).abs() < 1e-5 && (t(Vec3::Y) - 8.0).abs() < 1e-5 && (t(Vec3::Z) - 9.0).abs() < 1e-5);
}

#[test]
fn rays_that_are_not_finite_hit_nothing() {
    let accel = unit_sphere();
    let good = Ray::new(Vec3::new(1.0, 2.0, -9.0), Vec3::Z);
    assert!(good.is_finite() && accel.intersect(&good).is_some());
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let poison = Vec3::select(axis.cmpgt(Vec3::ZERO), Vec3::splat(bad), Vec3::ZERO);
            let rays = [
                Ray { origin: good.origin + poison, ..good },
                Ray { dir: good.dir + poison, ..good },
                Ray { tnear: bad, ..good },
                Ray { tfar: f32::NAN, ..good },
            ];
            for ray in rays {
                assert!(!ray.is_finite(), "{ray:?}");
                assert!(accel.intersect(&ray).is_none() && !accel.occluded(&ray), "{ray:?}");
            }
        }
    }
    let still = Ray::new(good.origin, Vec3::ZERO);
    assert!(still.is_finite() && accel.intersect(&still).is_none());
}

#[test]
fn an_empty_scene_is_missed() {
    let accel = AccelBuilder::new(1).unwrap().build().unwrap();
    let ray = Ray::new(Vec3::ZERO, Vec3::Z);
    assert!(accel.intersect(&ray).is_none() && !accel.occluded(&ray));
    assert_eq!(accel.bounds(), None);
}

#[test]
fn a_mesh_without_triangles_is_missed() {
    let mut builder = AccelBuilder::new(1).unwrap();
    for positions in [vec![], vec![Vec3::ZERO; 3]] {
        let shape = builder.mesh(positions, vec![]).unwrap();
        builder.place(shape).unwrap();
        builder.place_instance(shape, Affine3A::IDENTITY).unwrap();
    }
    let accel = builder.build().unwrap();
    assert!(accel.intersect(&Ray::new(Vec3::NEG_Z, Vec3::Z)).is_none());
    assert_eq!(accel.bounds(), None);
}

#[test]
fn bounds_hold_everything() {
    let mut builder = AccelBuilder::new(1).unwrap();
    let shape = triangle(&mut builder);
    let sphere = builder.sphere(Vec3::new(0.0, 0.0, 5.0), 0.5).unwrap();
    builder.place(shape).unwrap();
    builder.place(sphere).unwrap();
    builder.place_instance(shape, Affine3A::from_translation(Vec3::new(-7.0, 0.0, 0.0))).unwrap();
    let (min, max) = builder.build().unwrap().bounds().unwrap();
    assert!(near(min, Vec3::new(-7.0, -0.5, 0.0), 1e-5) && near(max, Vec3::new(2.0, 3.0, 5.5), 1e-5), "{min} {max}");
}

#[test]
fn what_embree_could_not_read_is_refused() {
    let mut builder = AccelBuilder::new(1).unwrap();
    let beyond = builder.mesh(vec![Vec3::ZERO; 3], vec![[0, 1, 2], [0, 3, 1]]);
    assert_eq!(beyond, Err(EmbreeError::Index { triangle: 1, vertex: 3, vertices: 3 }));
    for radius in [0.0, -1.0, f32::INFINITY, f32::NAN] {
        assert!(matches!(builder.sphere(Vec3::ZERO, radius), Err(EmbreeError::Sphere { .. })));
    }
    assert!(builder.sphere(Vec3::NAN, 1.0).is_err());
    let shape = triangle(&mut builder);
    for transform in [Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0)), Affine3A::from_translation(Vec3::NAN)] {
        assert_eq!(builder.place_instance(shape, transform), Err(EmbreeError::Transform { place: 0 }));
    }
    assert_eq!(AccelBuilder::new(1).unwrap().place(shape), Err(EmbreeError::ForeignShape));
    assert_eq!(builder.place(shape), Ok(0)); // refused placements take no number
}

#[test]
fn vertices_that_are_not_finite_spoil_only_their_triangles() {
    let mut builder = AccelBuilder::new(1).unwrap();
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN, Vec3::INFINITY];
    let shape = builder.mesh(positions, vec![[0, 1, 3], [0, 1, 2], [4, 1, 2]]).unwrap();
    builder.place(shape).unwrap();
    let accel = builder.build().unwrap();
    assert_eq!(accel.intersect(&Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z)).unwrap().prim, 1);
    assert_eq!(accel.bounds().map(|(_, max)| max.max_element() < 2.0), Some(true));
}

#[test]
fn a_closed_mesh_is_watertight_and_threads_do_not_matter() {
    let (positions, triangles) = tessellated(200, 100);
    let origin = Vec3::new(0.3, -0.2, 0.1);
    let trace = |threads, targets: &[Vec3]| {
        let mut builder = AccelBuilder::new(threads).unwrap();
        let shape = builder.mesh(positions.clone(), triangles.clone()).unwrap();
        builder.place(shape).unwrap();
        let accel = builder.build().unwrap();
        let key = |hit: Hit| (hit.prim, hit.t.to_bits());
        let hit = |target: &Vec3| accel.intersect(&Ray::new(origin, *target - origin)).map(key);
        targets.iter().map(hit).collect::<Vec<_>>()
    };
    let edges = triangles.iter().map(|&[a, b, _]| (positions[a as usize] + positions[b as usize]) / 2.0);
    let targets: Vec<Vec3> = edges.chain(directions(200_000)).collect();
    let one = trace(1, &targets);
    assert!(one.iter().all(Option::is_some), "a ray got out");
    assert!(one == trace(2, &targets) && one == trace(4, &targets));

    // Aimed at a vertex to the last bit, where many triangles tie, a few slip through; always the same ones.
    let one = trace(1, &positions);
    let lost = one.iter().filter(|hit| hit.is_none()).count();
    assert!(lost * 50 < positions.len(), "{lost} of {} got out", positions.len());
    assert!(one == trace(2, &positions) && one == trace(4, &positions));
}

#[test]
fn many_threads_may_trace_one_accel() {
    let accel = unit_sphere();
    let rays: Vec<Ray> = directions(10_000).map(|dir| Ray::new(Vec3::new(1.0, 2.0, 3.0) - 3.0 * dir, dir)).collect();
    let alone: Vec<_> = rays.iter().map(|ray| accel.intersect(ray)).collect();
    std::thread::scope(|scope| {
        let run = || rays.iter().map(|ray| accel.intersect(ray)).collect::<Vec<_>>();
        let workers: Vec<_> = (0..4).map(|_| scope.spawn(run)).collect();
        assert!(workers.into_iter().all(|worker| worker.join().unwrap() == alone));
    });
}

#[test]
fn batches_answer_like_single_rays() {
    let (positions, triangles) = tessellated(60, 30);
    let mut builder = AccelBuilder::new(1).unwrap();
    let shape = builder.mesh(positions, triangles).unwrap();
    builder.place(shape).unwrap();
    builder
        .place_instance(
            shape,
            Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), Quat::IDENTITY, Vec3::X * 3.0),
        )
        .unwrap();
    let sphere = builder.sphere(Vec3::Y * 3.0, 1.0).unwrap();
    builder.place(sphere).unwrap();
    let accel = builder.build().unwrap();

    // Outside the shapes: some rays meet one, some none; some end too soon; some are not finite.
    let origin = Vec3::new(1.1, 1.3, 0.1);
    let rays: Vec<Ray> = directions(8000)
        .enumerate()
        .map(|(i, dir)| match i % 37 {
            0 => Ray { tnear: f32::NAN, ..Ray::new(origin, dir) },
            1 => Ray { tfar: 0.01, ..Ray::new(origin, dir) },
            _ => Ray::new(origin, dir),
        })
        .collect();
    let (mut met, mut hits) = (0, Hits::default());
    for (i, batch) in rays.chunks_exact(BATCH).enumerate() {
        let batch: &[Ray; BATCH] = batch.try_into().unwrap();
        let active = !(1 << (i % 9)) as u8;
        accel.intersect_batch(batch, active, &mut hits);
        let blocked = accel.occluded_batch(batch, active);
        for (lane, ray) in batch.iter().enumerate() {
            let single = if active >> lane & 1 == 1 { accel.intersect(ray) } else { None };
            assert_eq!(blocked >> lane & 1 == 1, single.is_some(), "{ray:?}");
            assert_eq!(hits.get(lane).is_some(), single.is_some(), "{ray:?}");
            if let (Some(hit), Some(single)) = (hits.get(lane), single) {
                met += 1;
                assert_eq!((hit.place(), hit.prim), (single.place(), single.prim));
                assert!((hit.t - single.t).abs() < 1e-5 && near(hit.ng, single.ng, 1e-5), "{hit:?} {single:?}");
                assert!((hit.u - single.u).abs() < 1e-3 && (hit.v - single.v).abs() < 1e-3, "{hit:?} {single:?}");
            }
        }
    }
    assert!((1000..7000).contains(&met), "{met}");
    let everywhere: [Ray; BATCH] = std::array::from_fn(|i| rays[2 + i]);
    let empty = AccelBuilder::new(1).unwrap().build().unwrap();
    empty.intersect_batch(&everywhere, 0xff, &mut hits);
    assert!((0..BATCH).all(|lane| hits.get(lane).is_none()) && empty.occluded_batch(&everywhere, 0xff) == 0);
}

#[test]
fn denormals_are_left_alone() {
    let accel = unit_sphere();
    accel.intersect(&Ray::new(Vec3::ZERO, Vec3::Z));
    // Embree would like FTZ and DAZ set; that is undefined behaviour in Rust, so we do not.
    assert!(std::hint::black_box(1e-40f32) * std::hint::black_box(0.5) > 0.0);
}
