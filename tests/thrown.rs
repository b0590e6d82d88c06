//! Light that mirrors and lenses throw: with light paths (shared) and without them (mis) it is the same.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Mat4, Vec2, Vec3};
use pellicle::document::{
    AreaShape, Base, Falloff, Group, Lens, LightKind, Material, Mesh, Presence, Projection, Scalar, Shape, SpotEdge,
};
use pellicle::embree::Ray;
use pellicle::integrate::{PathLimits, Strategy};
use pellicle::math::{Sampler, warp};
use pellicle::mode::{Lanes, Mode, Rgb, Spectral};
use pellicle::render::Frame;
use pellicle::scene::{Aim, FilmOptions, Lamp, Scene, Stage};

use crate::statistics::{normal_tail, sidak};
use crate::transport::{Builder, coated, diffuse, glass, mean, metal, quad, shining};

const SIZE: u32 = 48;
/// Side of the blocks whose means are compared: single pixels have too few finds for their variance to be known.
const BLOCK: usize = 8;

/// Fails where blocks differ by more than their noise allows.
fn assert_same_blocks(a: &Frame, b: &Frame) {
    let side = a.width as usize / BLOCK;
    let block = |frame: &Frame, number: usize| {
        let (x0, y0) = (number % side * BLOCK, number / side * BLOCK);
        let pixels = (0..BLOCK * BLOCK).map(|i| (y0 + i / BLOCK) * frame.width as usize + x0 + i % BLOCK);
        pixels.fold((0.0, 0.0), |(sum, variance), i| {
            (sum + f64::from(frame.rgb[i][1]), variance + f64::from(frame.variance[i][1]))
        })
    };
    let significance = sidak(0.01, side * side);
    for number in 0..side * side {
        let ((sum_a, variance_a), (sum_b, variance_b)) = (block(a, number), block(b, number));
        let z = (sum_a - sum_b) / (variance_a + variance_b + 1e-6 * sum_a * sum_a + 1e-12).sqrt();
        assert!(normal_tail(z) > significance, "block {number}: {sum_a} and {sum_b}, {z} standard deviations");
    }
    let ((mean_a, error_a), (mean_b, error_b)) = (mean(a), mean(b));
    let slack = 4.0 * error_a.hypot(error_b) + 5e-4 * mean_a;
    assert!((mean_a - mean_b).abs() < slack, "{mean_a} +- {error_a}, {mean_b} +- {error_b}");
}

/// The same picture without light paths and with them, which find at least so many times more in its noise.
fn assert_found<M: Mode>(scene: &Builder, max_bounces: u32, gain: f64) {
    let render = |strategy, spp| scene.render_in::<M>(SIZE, spp, PathLimits { max_bounces, strategy }, 0);
    let (mis, shared) = (render(Strategy::Mis, 4096), render(Strategy::Shared, 512));
    assert_same_blocks(&mis, &shared);
    let error2 = |frame: &Frame| mean(frame).1.powi(2) * f64::from(frame.spp);
    assert!(error2(&mis) > gain * error2(&shared), "{} and {}", error2(&mis), error2(&shared));
}

/// A floor and a wall around what throws light.
fn corner() -> Builder {
    let mut scene = Builder::seen_from(Vec3::new(0.0, 1.2, 4.0), 45.0);
    scene.floor(Vec3::ZERO, 3.0, diffuse(0.6));
    let standing = Mat4::from_translation(Vec3::new(0.0, 0.0, -1.5)) * Mat4::from_rotation_x(FRAC_PI_2);
    scene.geometry(standing, quad(3.0), diffuse(0.5));
    scene
}

/// A lamp of this size over the corner, which nothing else is lit by.
fn lamp(scene: &mut Builder, radius: f32) {
    scene.sphere(Vec3::new(0.6, 3.0, 0.3), radius, shining(diffuse(0.0), 1.5 / (radius * radius)));
}

/// A ball of few triangles that is shaded as if it were round.
fn faceted(radius: f32) -> Shape {
    const AROUND: u32 = 14;
    const DOWN: u32 = 8;
    let normal = |i: u32| {
        let (column, row) = (i % AROUND, i / AROUND);
        let (sin, cos) = (PI * row as f32 / DOWN as f32).sin_cos();
        let (across, along) = (2.0 * PI * column as f32 / AROUND as f32).sin_cos();
        Vec3::new(sin * along, cos, sin * across)
    };
    let normals: Vec<Vec3> = (0..AROUND * (DOWN + 1)).map(normal).collect();
    let quad = |i: u32| {
        let (column, row) = (i % AROUND, i / AROUND);
        let at = |column: u32, row: u32| row * AROUND + column % AROUND;
        let [a, b, c, d] = [at(column, row), at(column + 1, row), at(column + 1, row + 1), at(column, row + 1)];
        let (upper, lower) = ([a, b, c], [a, c, d]);
        // At the poles one of the two has no area.
        [(row > 0).then_some(upper), (row + 1 < DOWN).then_some(lower)].into_iter().flatten()
    };
    let triangles: Vec<[u32; 3]> = (0..AROUND * DOWN).flat_map(quad).collect();
    let positions = normals.iter().map(|normal| *normal * radius).collect();
    let groups = vec![Group { symbol: "m".into(), triangles: 0..triangles.len() }];
    Shape::Mesh(Mesh { positions, normals, triangles, groups, ..Mesh::default() })
}

/// A level square that is shaded as if it were tilted towards -z.
fn tilted(size: f32, angle_rad: f32) -> Shape {
    let Shape::Mesh(mesh) = quad(size) else { unreachable!() };
    let (sin, cos) = angle_rad.sin_cos();
    Shape::Mesh(Mesh { normals: vec![Vec3::new(0.0, cos, -sin); mesh.positions.len()], ..mesh })
}

fn absorbing(mut material: Material, per_m: f32, rank: Option<u8>) -> Material {
    if let Base::Dielectric { absorption_per_m, priority, .. } = &mut material.base {
        (*absorption_per_m, *priority) = (Vec3::splat(per_m), rank);
    }
    material
}

#[test]
fn by_a_glass_ball_and_a_mirror() {
    let mut scene = corner();
    scene.sphere(Vec3::new(-0.5, 0.6, 0.3), 0.5, glass(1.5, 0.0));
    scene.sphere(Vec3::new(0.8, 0.5, 0.0), 0.5, metal(0.2, 3.0, 0.0));
    lamp(&mut scene, 0.4);
    assert_found::<Rgb>(&scene, 6, 1.5);
}

#[test]
fn by_filmed_glass_in_wavelengths_onto_varnish() {
    let mut scene = Builder::seen_from(Vec3::new(0.0, 1.2, 4.0), 45.0);
    scene.floor(Vec3::ZERO, 3.0, coated(diffuse(0.7), 1.6, 300.0));
    scene.sphere(Vec3::new(-0.4, 0.7, 0.3), 0.6, coated(glass(1.6, 0.0), 1.35, 400.0));
    scene.sphere(Vec3::new(0.8, 0.5, 0.0), 0.5, coated(glass(1.0, 0.0), 1.33, 350.0));
    lamp(&mut scene, 0.4);
    assert_found::<Spectral<8>>(&scene, 6, 1.3);
}

/// Interpolated normals bend light otherwise than the surface would: both ways by the same rule. Seen through a lens that
/// blurs, beside the axis.
#[test]
fn by_interpolated_normals_seen_through_a_wide_lens() {
    let mut scene = corner();
    let camera = &mut scene.0.cameras[0];
    camera.lens = Some(Lens { aperture_radius_m: 0.15, focus_distance_m: 3.0, blades: 6 });
    camera.shift = Vec2::new(0.07, -0.04);
    scene.geometry(
        Mat4::from_translation(Vec3::new(-0.5, 0.7, 0.3)),
        faceted(0.6),
        absorbing(glass(1.5, 0.0), 0.6, None),
    );
    scene.geometry(Mat4::from_translation(Vec3::new(0.8, 0.4, 0.3)), tilted(0.4, 0.45), metal(0.2, 3.0, 0.0));
    scene.geometry(Mat4::from_translation(Vec3::new(-0.5, 0.01, 0.8)), tilted(0.7, -0.5), diffuse(0.8));
    lamp(&mut scene, 0.4);
    assert_found::<Rgb>(&scene, 6, 1.3);
}

/// Half of the glass is not there, and the camera's rays are parallel.
#[test]
fn by_a_lens_with_holes_under_a_low_sun() {
    let mut scene = corner();
    let projection = Projection::Orthographic { xmag: Some(1.6), ymag: None, aspect: Some(1.0) };
    scene.0.cameras[0].projection = projection;
    let holes = Material { opacity: Scalar::constant(0.5), ..glass(1.5, 0.0) };
    scene.sphere(Vec3::new(-0.4, 0.7, 0.3), 0.6, holes);
    scene.sphere(Vec3::new(0.8, 0.5, 0.0), 0.5, glass(1.7, 0.0));
    let slanting = Mat4::from_rotation_y(0.5) * Mat4::from_rotation_x(-0.8);
    scene.light(slanting, LightKind::Directional { angle_deg: 12.0 }, Vec3::splat(2.0));
    scene.sky(0.2);
    assert_found::<Rgb>(&scene, 6, 2.0);
}

/// Lamps that nothing stands in the way of shine through each other; one of them stands in the water.
#[test]
fn by_water_that_lamps_stand_in_and_over() {
    let mut scene = corner();
    scene.sphere(Vec3::new(-0.5, 0.8, 0.4), 0.7, absorbing(glass(1.33, 0.0), 0.3, Some(1)));
    scene.sphere(Vec3::new(-0.3, 0.9, 0.3), 0.35, absorbing(glass(1.6, 0.0), 0.5, Some(2)));
    for (at, radius_m, intensity) in [
        (Vec3::new(0.6, 3.0, 0.3), 0.4, 6.0),
        (Vec3::new(0.8, 3.6, 0.3), 0.4, 6.0),
        (Vec3::new(-0.7, 0.7, 0.7), 0.2, 0.6),
    ] {
        let kind = LightKind::Point { radius_m, falloff: Falloff::Physical };
        scene.light(Mat4::from_translation(at), kind, Vec3::splat(intensity));
    }
    assert_found::<Rgb>(&scene, 6, 1.0);
}

/// Both lamps shine to one side only; the ball reaches behind one of them, and the ball around the mirror holds both.
#[test]
fn by_a_ball_beside_one_sided_lamps() {
    let mut scene = corner();
    scene.sphere(Vec3::new(-0.2, 1.0, 0.3), 0.7, glass(1.5, 0.0));
    let wall = Mat4::from_translation(Vec3::new(1.7, 1.0, 0.0)) * Mat4::from_rotation_z(FRAC_PI_2);
    scene.geometry(wall, quad(1.8), metal(0.2, 3.0, 0.0));
    let down = Mat4::from_rotation_x(-FRAC_PI_2);
    for at in [Vec3::new(0.9, 2.6, 0.3), Vec3::new(-1.2, 1.3, 0.3)] {
        let kind = LightKind::Area { shape: AreaShape::Rectangle, presence: Presence::Solid };
        scene.light(Mat4::from_translation(at) * down * Mat4::from_scale(Vec3::splat(0.7)), kind, Vec3::splat(4.0));
    }
    assert_found::<Rgb>(&scene, 6, 2.0);
}

/// What is shot from a lamp is as likely as is said of light that comes back the same way.
#[test]
fn shots_have_the_density_that_their_lamps_are_asked_for() {
    let mut scene = corner();
    scene.sphere(Vec3::new(-0.5, 0.6, 0.3), 0.5, glass(1.5, 0.0));
    scene.geometry(Mat4::from_translation(Vec3::new(0.8, 0.5, 0.0)), faceted(0.4), metal(0.2, 3.0, 0.0));
    lamp(&mut scene, 0.3);
    let kind = LightKind::Area { shape: AreaShape::Rectangle, presence: Presence::Solid };
    let down = Mat4::from_translation(Vec3::new(-0.5, 2.6, 0.3)) * Mat4::from_rotation_x(-1.4);
    scene.light(down, kind, Vec3::splat(4.0));
    scene.sky(0.5);
    let stage = Arc::new(Stage::new(&scene.0, 1).unwrap());
    let scene = Scene::<Rgb>::new(stage, &FilmOptions { tolerance: 0.01, rung: None }).unwrap();
    let (aim, waves) = (Aim::new(&scene).unwrap(), Rgb::waves(0.0));
    let (mut near, mut far) = (0, 0);
    for index in 0..2000 {
        let mut sampler = Sampler::new(1, index, 0);
        let u = [sampler.next_4d(), sampler.next_4d()];
        let Some(shot) = aim.shoot(&scene, u, &waves) else { continue };
        let Some(met) = scene.intersect(&shot.ray).filter(|met| met.place.number == shot.place) else { continue };
        let back = Ray::new(met.leave(-shot.ray.dir), -shot.ray.dir);
        let (radiance, lamp) = match scene.intersect(&back) {
            // Rays that graze either are known less well.
            Some(lamp) if lamp.place.number == shot.place || shot.ray.dir.dot(lamp.ng) < 0.1 => continue,
            Some(lamp) => {
                near += 1;
                let cos = shot.ray.dir.dot(lamp.ng);
                (scene.emitted(&lamp, cos, &waves), Lamp::Surface(lamp.lamp()))
            }
            None => {
                far += 1;
                let mut sky = <Rgb as Mode>::Light::ZERO;
                scene.escape(met.position, back.dir, &waves, |light, _| sky += light);
                (sky, Lamp::Beyond)
            }
        };
        assert_eq!(radiance, shot.light);
        let density = aim.density(&scene, shot.place, met.position, &lamp, back.dir, &waves);
        assert!((density / shot.density - 1.0).abs() < 2e-3, "{density} for {}", shot.density);
    }
    assert!(near > 200 && far > 200, "{near} {far}");
}

/// Camera paths draw the lamp at each rough surface, too.
#[test]
fn by_frosted_glass_and_nearly_smooth_metal() {
    let mut scene = corner();
    scene.sphere(Vec3::new(-0.5, 0.6, 0.3), 0.5, glass(1.5, 0.1));
    scene.sphere(Vec3::new(0.8, 0.5, 0.0), 0.5, metal(0.2, 3.0, 0.03));
    lamp(&mut scene, 0.2);
    assert_found::<Rgb>(&scene, 6, 1.5);
}

/// One after the other, with smooth ones between, in absorbing bodies and under a sky with a sun in it.
#[test]
fn by_rough_lenses_in_a_row_under_a_sun() {
    let mut scene = corner();
    scene.sphere(Vec3::new(-0.6, 1.3, 0.4), 0.4, absorbing(glass(1.5, 0.03), 0.5, None));
    scene.sphere(Vec3::new(-0.5, 0.5, 0.3), 0.35, coated(glass(1.3, 0.3), 1.6, 300.0));
    scene.sphere(Vec3::new(0.6, 0.5, 0.3), 0.45, glass(1.5, 0.0));
    scene.geometry(Mat4::from_translation(Vec3::new(0.8, 1.4, 0.0)), faceted(0.4), glass(1.4, 0.15));
    let slanting = Mat4::from_rotation_y(0.2) * Mat4::from_rotation_x(-1.2);
    scene.light(slanting, LightKind::Directional { angle_deg: 12.0 }, Vec3::splat(2.0));
    scene.sky(0.2);
    assert_found::<Spectral<4>>(&scene, 8, 1.0);
}

/// A coat mirrors little of the light, but that little comes from a lamp.
#[test]
fn by_coats_on_matte_bodies() {
    let mut scene = corner();
    scene.sphere(Vec3::new(-0.5, 0.6, 0.3), 0.5, coated(diffuse(0.3), 1.8, 250.0));
    let slanting = Mat4::from_translation(Vec3::new(0.8, 0.3, 0.3)) * Mat4::from_rotation_x(0.5);
    scene.geometry(slanting, quad(0.6), coated(diffuse(0.6), 1.6, 0.0));
    lamp(&mut scene, 0.15);
    assert_found::<Rgb>(&scene, 6, 2.0);
}

/// A large lamp, rough surfaces and a small part of a wall: all ways to find the light are about as likely.
#[test]
fn by_very_rough_glass_and_metal_onto_a_near_wall() {
    let mut scene = Builder::seen_from(Vec3::new(0.0, 0.5, 2.5), 14.0);
    scene.geometry(
        Mat4::from_translation(Vec3::new(0.0, 0.0, -1.5)) * Mat4::from_rotation_x(FRAC_PI_2),
        quad(3.0),
        diffuse(0.5),
    );
    scene.sphere(Vec3::new(0.8, 0.6, -0.3), 0.4, glass(1.5, 0.3));
    scene.sphere(Vec3::new(-0.7, 0.5, -0.6), 0.3, metal(0.2, 3.0, 0.1));
    scene.sphere(Vec3::new(2.2, 1.0, 2.5), 0.8, shining(diffuse(0.0), 3.0));
    assert_found::<Rgb>(&scene, 6, 0.5);
}

/// The lamp is drawn at metal that is seen through frosted glass, and others look at what the metal reflects.
#[test]
fn by_metal_behind_frosted_glass() {
    let mut scene = corner();
    scene.sphere(Vec3::new(0.3, 1.1, 2.0), 0.5, glass(1.1, 0.3));
    let facing = Mat4::from_translation(Vec3::new(0.3, 1.0, -0.3)) * Mat4::from_rotation_x(0.93);
    scene.geometry(facing, quad(0.7), metal(0.2, 3.0, 0.1));
    scene.sphere(Vec3::new(-0.9, 0.5, 0.3), 0.4, glass(1.5, 0.0));
    lamp(&mut scene, 0.5);
    assert_found::<Rgb>(&scene, 6, 1.0);
}

/// What a lamp of this kind throws into the corner by a glass ball and a mirror above the view.
fn from_above(kind: LightKind, at: Mat4, color: f32) -> Frame {
    let mut scene = corner();
    scene.sphere(Vec3::new(-0.5, 3.3, 0.3), 0.5, glass(1.5, 0.0));
    scene.geometry(Mat4::from_translation(Vec3::new(0.9, 3.2, 0.2)), tilted(0.5, 0.7), metal(0.2, 3.0, 0.0));
    scene.light(at, kind, Vec3::splat(color));
    scene.render_in::<Rgb>(SIZE, 512, PathLimits { max_bounces: 6, strategy: Strategy::Shared }, 0)
}

fn spot(cone_deg: f32, falloff: Falloff) -> LightKind {
    LightKind::Spot { cone_deg, edge: SpotEdge::Exponent(0.0), radius_m: 0.0, falloff }
}

/// Points throw light as small balls do, which camera paths find, too; spots as points, into their cone.
#[test]
fn by_points_and_spots() {
    let point = |radius_m| LightKind::Point { radius_m, falloff: Falloff::Physical };
    let at = Mat4::from_translation(Vec3::new(0.3, 5.0, 1.2)) * Mat4::from_rotation_x(-1.2);
    let by_point = from_above(point(0.0), at, 8.0);
    assert_same_blocks(&by_point, &from_above(point(0.02), at, 8.0));
    assert_same_blocks(&by_point, &from_above(spot(150.0, Falloff::Physical), at, 8.0));
}

/// Rough surfaces draw such a lamp, which is and light paths come from there, too.
#[test]
fn by_frosted_glass_and_nearly_smooth_metal_under_points() {
    let mut scene = corner();
    scene.sphere(Vec3::new(-0.5, 0.6, 0.3), 0.5, glass(1.5, 0.1));
    scene.sphere(Vec3::new(0.8, 0.5, 0.0), 0.5, metal(0.2, 3.0, 0.03));
    let at = Mat4::from_translation(Vec3::new(0.6, 3.0, 0.3));
    scene.light(at, LightKind::Point { radius_m: 0.0, falloff: Falloff::Physical }, Vec3::splat(3.0));
    let slanting = Mat4::from_rotation_y(0.2) * Mat4::from_rotation_x(-1.2);
    scene.light(slanting, LightKind::Directional { angle_deg: 0.0 }, Vec3::splat(0.5));
    let linear = Falloff::Attenuation { constant: 0.2, linear: 0.5, quadratic: 0.1 };
    let down = Mat4::from_translation(Vec3::new(-0.2, 3.0, 0.3)) * Mat4::from_rotation_x(-FRAC_PI_2);
    scene.light(down, spot(40.0, linear), Vec3::splat(1.0));
    assert_found::<Rgb>(&scene, 6, 1.2);
}

/// A narrow beam shines on a large ball and nothing else, and not on its middle.
#[test]
fn by_a_spot_beside_the_middle() {
    let at = Mat4::from_translation(Vec3::new(-0.25, 6.0, 0.3)) * Mat4::from_rotation_x(-FRAC_PI_2);
    let physical = from_above(spot(8.0, Falloff::Physical), at, 8.0);
    let brightest = physical.rgb.iter().map(|rgb| rgb[1]).fold(0.0, f32::max);
    assert!(brightest > 0.02, "{brightest}");

    // It fades as it will until it is thrown, here after 2.2 to 2.5 m.
    let linear = Falloff::Attenuation { constant: 0.0, linear: 1.0, quadratic: 0.0 };
    let ratio = mean(&from_above(spot(8.0, linear), at, 8.0)).0 / mean(&physical).0;
    assert!((2.2..2.5).contains(&ratio), "{ratio}");
}

#[test]
fn by_parallel_light() {
    let sun = |angle_deg| LightKind::Directional { angle_deg };
    let at = Mat4::from_rotation_y(0.4) * Mat4::from_rotation_x(-1.2);
    assert_same_blocks(&from_above(sun(0.0), at, 1.0), &from_above(sun(0.4), at, 1.0));
}

/// Rays from far away that a ball refracts do not meet it again where they are.
#[test]
fn balls_far_from_where_rays_begin() {
    let mut scene = Builder::seen_from(Vec3::new(0.0, 0.0, 4.0), 45.0);
    scene.sphere(Vec3::ZERO, 0.7, glass(1.5, 0.0));
    let stage = Arc::new(Stage::new(&scene.0, 1).unwrap());
    let scene = Scene::<Rgb>::new(stage, &FilmOptions { tolerance: 0.01, rung: None }).unwrap();
    for index in 0..2000 {
        let [x, y, ..] = Sampler::new(0, index, 3).next_4d();
        let on_disc = 0.69 * warp::square_to_disk([x, y]);
        let met = scene.intersect(&Ray::new(on_disc.extend(50.0), Vec3::NEG_Z)).unwrap();
        let inward = Ray::new(met.leave(Vec3::NEG_Z), Vec3::NEG_Z);
        let next = scene.intersect(&inward).unwrap();
        assert!(next.position.z < 0.0, "{on_disc}: {} and {}", met.position, next.position);
    }
}
