//! Light transport against closed forms, and its strategies against each other.

use std::sync::Arc;

use glam::{Mat4, Vec3};
use pellicle::color::{Emission, Index};
use pellicle::document::{
    AreaShape, Base, Binding, Camera, Document, Environment, Falloff, Film, Geometry, Group, Item, Light, LightKind,
    Material, Mesh, Microfacets, Node, Presence, Projection, Scalar, Shape, SurfaceEmission, Texture, Thickness, Tint,
    Transform, TransformKind,
};
use pellicle::integrate::{PathLimits, Strategy};
use pellicle::mode::{Mode, Rgb, Spectral};
use pellicle::render::{Filter, Frame, Plan, Unwatched, render};
use pellicle::scene::{self, FilmOptions, Framing, Scene, Stage};

use crate::statistics::{normal_tail, sidak};

/// A document that is put together by hand.
pub struct Builder(pub Document);

impl Builder {
    /// A scene seen from `eye` along -z.
    pub fn seen_from(eye: Vec3, xfov_deg: f32) -> Self {
        let mut builder = Self(Document { to_world: Mat4::IDENTITY, ..Document::default() });
        let projection = Projection::Perspective { xfov_deg: Some(xfov_deg), yfov_deg: None, aspect: Some(1.0) };
        builder.0.cameras.push(Camera { id: "cam".into(), projection, lens: None, shift: glam::Vec2::ZERO });
        builder.node(Mat4::from_translation(eye), Item::Camera(0));
        builder
    }

    pub fn node(&mut self, matrix: Mat4, item: Item) {
        let transforms = vec![Transform { sid: String::new(), kind: TransformKind::Matrix(matrix) }];
        self.0.roots.push(self.0.nodes.len());
        self.0.nodes.push(Node { transforms, items: vec![item], ..Node::default() });
    }

    pub fn geometry(&mut self, matrix: Mat4, shape: Shape, material: Material) {
        let bindings = vec![Binding { symbol: "m".into(), material: self.0.materials.len(), uv_sets: Vec::new() }];
        self.0.materials.push(material);
        self.0.geometries.push(Geometry { id: "shape".into(), shape });
        let geometry = self.0.geometries.len() - 1;
        self.node(matrix, Item::Geometry { geometry, bindings });
    }

    pub fn sphere(&mut self, center: Vec3, radius: f32, material: Material) {
        self.geometry(Mat4::from_translation(center), Shape::Sphere { radius }, material);
    }

    /// The square [-size, size]^2 in XZ, facing +Y, moved by `at`.
    pub fn floor(&mut self, at: Vec3, size: f32, material: Material) {
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
        let positions = corners.map(|(x, z)| Vec3::new(x * size, 0.0, z * size)).to_vec();
        let groups = vec![Group { symbol: "m".into(), triangles: 0..2 }];
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], groups, ..Mesh::default() };
        self.geometry(Mat4::from_translation(at), Shape::Mesh(mesh), material);
    }

    pub fn light(&mut self, matrix: Mat4, kind: LightKind, color: Vec3) {
        self.0.lights.push(Light { id: "light".into(), kind, color, spectrum: Emission::E });
        let index = self.0.lights.len() - 1;
        self.node(matrix, Item::Light(index));
    }

    pub fn sky(&mut self, radiance: f32) {
        self.0.environment = Some(Environment {
            image: None,
            radiance: Vec3::splat(radiance),
            strength: 1.0,
            rotation_deg: 0.0,
            spectrum: Emission::E,
        });
    }

    pub fn render(&self, size: u32, spp: u32, max_bounces: u32, strategy: Strategy, threads: usize) -> Frame {
        self.render_in::<Rgb>(size, spp, PathLimits { max_bounces, strategy }, threads)
    }

    pub fn render_in<M: Mode>(&self, size: u32, spp: u32, limits: PathLimits, threads: usize) -> Frame {
        let stage = Arc::new(Stage::new(&self.0, 1).unwrap());
        let scene = Scene::<M>::new(stage.clone(), &FilmOptions { tolerance: 0.01, rung: None }).unwrap();
        let size = [Some(size), Some(size)];
        let (camera, _) = scene::Camera::new(&self.0, None, size, Framing::Scene, stage.bounds).unwrap();
        let plan = Plan { spp, seed: 1, threads, filter: Filter::Box, limits, clamp: None, noise: None };
        let frame = render(&scene, &camera, &plan, &Unwatched).unwrap();
        assert_eq!(frame.tally.non_finite, 0);
        frame
    }
}

pub fn material(base: Base) -> Material {
    Material { id: "m".into(), base, opacity: Scalar::constant(1.0), tint: Tint::default(), ..Material::default() }
}

pub fn diffuse(reflectance: f32) -> Material {
    material(Base::Diffuse { reflectance: Texture::constant(Vec3::splat(reflectance)), ior: 1.5 })
}

pub fn rough(alpha: f32) -> Microfacets {
    Microfacets { roughness: Scalar::constant(alpha), ..Microfacets::default() }
}

pub fn metal(n: f32, k: f32, alpha: f32) -> Material {
    material(Base::Conductor { index: Index::Constant { n, k }, microfacets: rough(alpha) })
}

pub fn glass(ior: f32, alpha: f32) -> Material {
    let index = Index::Constant { n: ior, k: 0.0 };
    let absorption_per_m = Vec3::ZERO;
    material(Base::Dielectric { index, microfacets: rough(alpha), absorption_per_m, fresnel: true, priority: None })
}

pub fn coated(mut material: Material, ior: f32, nm: f32) -> Material {
    let index = Index::Constant { n: ior, k: 0.0 };
    material.films.push(Film { index, thickness: Thickness::Constant { nm }, weight: 1.0 });
    material
}

pub fn shining(mut material: Material, radiance: f32) -> Material {
    let radiance = Texture::constant(Vec3::splat(radiance));
    material.emission = Some(SurfaceEmission { radiance, spectrum: Emission::E, two_sided: true });
    material
}

/// (mean, standard error) of the first channel over the picture.
pub fn mean(frame: &Frame) -> (f64, f64) {
    let n = frame.rgb.len() as f64;
    let mean = frame.rgb.iter().map(|c| f64::from(c[0])).sum::<f64>() / n;
    let variance = frame.variance.iter().map(|c| f64::from(c[0])).sum::<f64>() / (n * n);
    (mean, variance.sqrt())
}

#[test]
fn a_shining_furnace_adds_up_the_geometric_series() {
    // Inside a sphere that emits 1 and reflects a: 1 + a + a^2 + ... one term per bounce allowed.
    for a in [0.3, 0.8] {
        for bounces in [0, 1, 2, 5] {
            for strategy in [Strategy::Bsdf, Strategy::Light, Strategy::Mis, Strategy::Shared] {
                let mut scene = Builder::seen_from(Vec3::new(0.2, 0.1, 0.3), 60.0);
                scene.sphere(Vec3::ZERO, 1.0, shining(diffuse(a), 1.0));
                let (mean, error) = mean(&scene.render(8, 256, bounces, strategy, 2));
                let expected = f64::from((0..=bounces).map(|k| a.powi(k as i32)).sum::<f32>());
                let slack = 4.0 * error + 1e-3 * expected;
                assert!(
                    (mean - expected).abs() < slack,
                    "a {a}, {bounces} bounces, {strategy:?}: {mean} for {expected}"
                );
            }
        }
    }
}

#[test]
fn white_surfaces_vanish_in_a_white_sky() {
    // Nothing is absorbed, so every path ends in the sky and brings back 1. Rough lobes lose what would scatter several
    // times between facets; they are bounded, smooth ones are exact.
    let cases: Vec<(&str, Material, f64)> = vec![
        ("white diffuse", diffuse(1.0), 0.001),
        ("mirror", metal(0.0, 1000.0, 0.0), 0.001),
        ("film on mirror", coated(metal(0.0, 4.0, 0.0), 1.5, 300.0), 0.003),
        ("glass", glass(1.5, 0.0), 0.003),
        ("film on glass", coated(glass(1.5, 0.0), 1.9, 400.0), 0.003),
        ("soap bubble", coated(glass(1.0, 0.0), 1.33, 400.0), 0.003),
        ("film on white diffuse", coated(diffuse(1.0), 2.2, 200.0), 0.005),
    ];
    for (name, material, tolerance) in cases {
        for strategy in [Strategy::Bsdf, Strategy::Mis, Strategy::Shared] {
            let mut scene = Builder::seen_from(Vec3::new(0.0, 0.0, 3.0), 50.0);
            scene.sphere(Vec3::ZERO, 1.0, material.clone());
            scene.sky(1.0);
            let (mean, error) = mean(&scene.render(16, 256, 200, strategy, 2));
            assert!((mean - 1.0).abs() < tolerance + 4.0 * error, "{name}, {strategy:?}: {mean} +- {error}");
        }
    }
}

#[test]
fn a_point_light_lights_a_floor_by_the_inverse_square() {
    // Straight below at distance h: L = rho / pi * I / h^2.
    let mut scene = Builder::seen_from(Vec3::new(0.0, 0.0, 0.0), 0.5);
    let turned = Mat4::from_rotation_x(std::f32::consts::FRAC_PI_2);
    scene.geometry(Mat4::from_translation(Vec3::new(0.0, 0.0, -5.0)) * turned, quad(4.0), diffuse(0.5));
    let point = LightKind::Point { radius_m: 0.0, falloff: Falloff::Physical };
    scene.light(Mat4::from_translation(Vec3::new(0.0, 0.0, -3.0)), point, Vec3::splat(8.0));
    let (mean, _) = mean(&scene.render(4, 4, 1, Strategy::Mis, 1));
    let expected = 0.5 / std::f64::consts::PI * 8.0 / 4.0;
    assert!((mean / expected - 1.0).abs() < 2e-4, "{mean} for {expected}");
}

/// The square [-size, size]^2 in XZ.
pub fn quad(size: f32) -> Shape {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    let positions = corners.map(|(x, z)| Vec3::new(x * size, 0.0, z * size)).to_vec();
    let groups = vec![Group { symbol: "m".into(), triangles: 0..2 }];
    Shape::Mesh(Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], groups, ..Mesh::default() })
}

#[test]
fn lights_of_each_shape_give_the_irradiance_of_their_view_factor() {
    // A floor patch facing a light straight above: E = pi L F, with F from Howell's catalogue.
    let h: f32 = 2.0;
    let disk = |r: f32| f64::from(r * r / (h * h + r * r));
    let rectangle = |a: f32, b: f32| {
        // Four corner rectangles (B-4): F = 2/pi * (x atan y' + y atan x') with half sides over distance.
        let (x, y) = (f64::from(a / h), f64::from(b / h));
        let (sx, sy) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        2.0 / std::f64::consts::PI * (x / sx * (y / sx).atan() + y / sy * (x / sy).atan())
    };
    let lights: [(AreaShape, Vec3, f64); 3] = [
        (AreaShape::Rectangle, Vec3::new(2.0, 1.0, 1.0), rectangle(1.0, 0.5)),
        (AreaShape::Disk, Vec3::new(1.6, 1.6, 1.0), disk(0.8)),
        (AreaShape::Sphere, Vec3::splat(1.0), f64::from(0.5f32 * 0.5 / (h * h))),
    ];
    for (shape, scale, factor) in lights {
        for presence in [Presence::Solid, Presence::Ghost, Presence::Hidden] {
            // Everything is turned so that the camera looks along -z at the patch and the light hangs behind the camera.
            let mut scene = Builder::seen_from(Vec3::new(0.0, 0.0, 0.5), 0.2);
            let turned = Mat4::from_rotation_x(std::f32::consts::FRAC_PI_2);
            scene.geometry(turned, quad(4.0), diffuse(1.0));
            let place = Mat4::from_translation(Vec3::new(0.0, 0.0, h)) * Mat4::from_scale(scale);
            scene.light(place, LightKind::Area { shape, presence }, Vec3::ONE);
            for strategy in [Strategy::Bsdf, Strategy::Light, Strategy::Mis, Strategy::Shared] {
                let (mean, error) = mean(&scene.render(4, 2048, 1, strategy, 2));
                let slack = 4.0 * error + 2e-3 * factor;
                assert!(
                    (mean - factor).abs() < slack,
                    "{shape:?} {presence:?} {strategy:?}: {mean} +- {error} for {factor}"
                );
            }
        }
    }
}

/// A room with everything that light can do.
fn crowded() -> Builder {
    let mut scene = Builder::seen_from(Vec3::new(0.0, 1.0, 4.0), 45.0);
    scene.floor(Vec3::ZERO, 3.0, diffuse(0.6));
    scene.sphere(Vec3::new(-0.9, 0.5, 0.0), 0.5, coated(metal(0.2, 3.0, 0.25), 1.33, 400.0));
    scene.sphere(Vec3::new(0.9, 0.5, 0.0), 0.5, coated(glass(1.5, 0.3), 1.9, 300.0));
    scene.sphere(Vec3::new(0.0, 0.4, 0.8), 0.4, coated(glass(1.0, 0.0), 1.33, 500.0));
    scene.sphere(Vec3::new(0.0, 0.3, 0.8), 0.15, diffuse(0.8));
    scene.sphere(Vec3::new(0.0, 0.5, -1.0), 0.5, coated(diffuse(0.7), 2.2, 150.0));
    scene.sphere(Vec3::new(1.5, 2.2, 0.5), 0.3, shining(diffuse(0.0), 6.0));
    let down = Mat4::from_translation(Vec3::new(-0.5, 2.5, 0.0)) * Mat4::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    scene.light(down, LightKind::Area { shape: AreaShape::Rectangle, presence: Presence::Solid }, Vec3::splat(5.0));
    scene.sky(0.3);
    scene
}

/// Fails where two estimates of one picture differ by more than their noise allows.
pub fn assert_same_picture(a: &Frame, b: &Frame, what: &str) {
    let tests = a.rgb.len() * 3;
    let significance = sidak(0.01, 2 * tests);
    let mut failed = 0;
    for i in 0..a.rgb.len() {
        for channel in 0..3 {
            let variance = a.variance[i][channel] + b.variance[i][channel];
            let difference = f64::from(a.rgb[i][channel] - b.rgb[i][channel]);
            // Fireflies make single variances worthless: a floor keeps dark, lucky pixels from failing.
            let z = difference / (f64::from(variance) + 1e-8).sqrt();
            if normal_tail(z) < significance {
                failed += 1;
            }
        }
    }
    // Low-discrepancy samples are not independent, so z is not quite normal; Mitsuba 3 asks for 99.75 %.
    assert!(failed * 400 <= tests, "{what}: {failed} of {tests} differ");
    let ((mean_a, error_a), (mean_b, error_b)) = (mean(a), mean(b));
    let slack = 4.0 * error_a.hypot(error_b) + 1e-3 * mean_a;
    assert!((mean_a - mean_b).abs() < slack, "{what}: {mean_a} +- {error_a}, {mean_b} +- {error_b}");
}

#[test]
fn all_strategies_see_the_same_picture() {
    let scene = crowded();
    let [mis, light, bsdf, shared] = [Strategy::Mis, Strategy::Light, Strategy::Bsdf, Strategy::Shared]
        .map(|strategy| scene.render(24, 1024, 6, strategy, 0));
    assert_same_picture(&mis, &shared, "mis and shared");
    assert_same_picture(&mis, &light, "mis and light");
    assert_same_picture(&mis, &bsdf, "mis and bsdf");
}

/// Rays leave a wide floor from a little above it: more than the gap that is left before a find where it is near, less where
/// it is far. All light comes from the sphere here.
#[test]
fn finds_are_shared_fairly_where_surfaces_touch() {
    let mut scene = Builder::seen_from(Vec3::new(0.0, 0.4, 3.5), 24.0);
    scene.floor(Vec3::ZERO, 20.0, diffuse(0.6));
    scene.sphere(Vec3::new(0.0, 1.0, 0.0), 1.0, diffuse(0.8));
    scene.light(Mat4::IDENTITY, LightKind::Directional { angle_deg: 0.0 }, Vec3::ONE);
    let [mis, shared] = [Strategy::Mis, Strategy::Shared].map(|strategy| scene.render(40, 1024, 2, strategy, 0));
    assert_same_picture(&mis, &shared, "mis and shared");
}

/// Glass and soap in front of each other and of a varnished floor: what each interface mirrors and what it lets through are
/// followed apart, and come back to the pixel that they belong to.
#[test]
fn what_smooth_interfaces_split_adds_up() {
    let mut scene = Builder::seen_from(Vec3::new(0.0, 1.0, 4.0), 40.0);
    scene.floor(Vec3::ZERO, 3.0, coated(diffuse(0.6), 1.4, 300.0));
    scene.sphere(Vec3::new(-0.6, 0.6, 0.5), 0.55, glass(1.5, 0.0));
    scene.sphere(Vec3::new(0.2, 0.7, 1.2), 0.5, coated(glass(1.0, 0.0), 1.33, 400.0));
    scene.sphere(Vec3::new(0.7, 0.8, 0.0), 0.5, coated(glass(1.0, 0.0), 1.33, 250.0));
    scene.sphere(Vec3::new(0.5, 3.0, 1.5), 0.6, shining(diffuse(0.0), 8.0));
    scene.sky(0.2);
    // What the lamp does in the third mirror is rare where one way is chosen: more samples, until their variance tells.
    let [mis, shared] =
        [(Strategy::Mis, 4096), (Strategy::Shared, 1024)].map(|(strategy, spp)| scene.render(32, spp, 8, strategy, 0));
    assert_same_picture(&mis, &shared, "mis and shared");
}

/// Shadow rays leave a wide floor from a little above it, and aim at the very point that was drawn: one beside it could lie
/// behind the lamp's own surface.
#[test]
fn a_lamp_that_stands_on_a_floor_lights_it_up_to_its_foot() {
    let mut scene = Builder::seen_from(Vec3::new(0.0, 0.15, 3.5), 8.0);
    scene.floor(Vec3::ZERO, 200.0, diffuse(0.6));
    scene.sphere(Vec3::new(0.0, 1.0, 0.0), 1.0, shining(diffuse(0.0), 6.0));
    let [lamp, ray] = [Strategy::Light, Strategy::Bsdf].map(|strategy| scene.render(40, 1024, 1, strategy, 0));
    assert_same_picture(&lamp, &ray, "light and bsdf");
}

/// Lamps of all kinds, near and far from each other, under a sky: however they are chosen, nothing is lost.
#[test]
fn many_lamps_under_a_sky_look_alike_by_every_strategy() {
    let mut scene = Builder::seen_from(Vec3::new(0.0, 1.5, 6.0), 50.0);
    scene.floor(Vec3::ZERO, 5.0, diffuse(0.6));
    scene.sphere(Vec3::new(0.0, 0.5, 1.0), 0.5, metal(1.5, 3.0, 0.3));
    for k in 0..12 {
        let (sin, cos) = (k as f32 * 0.9).sin_cos();
        let at = Vec3::new(3.0 * cos, 0.3 + 0.1 * k as f32, 2.0 * sin);
        match k % 3 {
            0 => scene.sphere(at, 0.15, shining(diffuse(0.0), 3.0)),
            1 => scene.floor(at, 0.2, shining(diffuse(0.3), 2.0)),
            _ => {
                let kind = LightKind::Area { shape: AreaShape::Disk, presence: Presence::Solid };
                scene.light(Mat4::from_translation(at), kind, Vec3::splat(2.0));
            }
        }
    }
    scene.sky(0.1);
    scene.light(Mat4::from_rotation_x(-1.0), LightKind::Directional { angle_deg: 20.0 }, Vec3::splat(0.3));
    let all = [Strategy::Mis, Strategy::Bsdf, Strategy::Light].map(|strategy| scene.render(32, 1024, 3, strategy, 0));
    assert_same_picture(&all[0], &all[1], "mis and bsdf");
    assert_same_picture(&all[0], &all[2], "mis and light");
}

#[test]
fn grey_scenes_look_alike_in_rgb_and_spectral() {
    // Without films and colours every wavelength does what every channel does.
    let mut scene = Builder::seen_from(Vec3::new(0.0, 1.0, 4.0), 45.0);
    scene.floor(Vec3::ZERO, 3.0, diffuse(0.6));
    scene.sphere(Vec3::new(-0.9, 0.5, 0.0), 0.5, metal(1.5, 3.0, 0.25));
    scene.sphere(Vec3::new(0.9, 0.5, 0.0), 0.5, glass(1.5, 0.2));
    scene.sphere(Vec3::new(0.0, 0.4, 0.8), 0.3, glass(1.5, 0.0));
    scene.sphere(Vec3::new(1.5, 2.2, 0.5), 0.3, shining(diffuse(0.0), 6.0));
    scene.sky(0.3);
    let limits = PathLimits { max_bounces: 6, strategy: Strategy::Shared };
    let rgb = scene.render_in::<Rgb>(24, 512, limits, 0);
    assert_same_picture(&rgb, &scene.render_in::<Spectral<4>>(24, 512, limits, 0), "4 wavelengths");
    assert_same_picture(&rgb, &scene.render_in::<Spectral<8>>(24, 512, limits, 0), "8 wavelengths");
    assert_same_picture(&rgb, &scene.render_in::<Spectral<16>>(24, 512, limits, 0), "16 wavelengths");
}

#[test]
fn any_number_of_wavelengths_converges_to_one_picture() {
    // Films, and a dispersive ball through which only one wavelength of each path goes on.
    let mut scene = crowded();
    let index = Index::Named("SF10".into());
    let ball = Base::Dielectric {
        index,
        microfacets: rough(0.0),
        absorption_per_m: Vec3::ZERO,
        fresnel: true,
        priority: None,
    };
    scene.sphere(Vec3::new(-0.5, 0.25, 1.2), 0.25, material(ball));
    let limits = PathLimits { max_bounces: 6, strategy: Strategy::Shared };
    let four = scene.render_in::<Spectral<4>>(24, 1024, limits, 0);
    let sixteen = scene.render_in::<Spectral<16>>(24, 1024, limits, 0);
    assert_same_picture(&four, &sixteen, "4 and 16 wavelengths");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = crowded();
    let one = scene.render(20, 4, 5, Strategy::Shared, 1);
    for threads in [2, 3, 7] {
        let many = scene.render(20, 4, 5, Strategy::Shared, threads);
        assert!(one.rgb == many.rgb && one.variance == many.variance, "{threads} threads");
        assert_eq!(one.tally, many.tally);
    }
}

#[test]
fn instances_look_like_copies() {
    // The same sphere-like mesh, once placed twice (instanced when large) and once as two geometries.
    let mesh = icosphere(6);
    assert!(mesh.triangles.len() * 2 > 20_000, "large enough to be instanced");
    let places = [Vec3::new(-0.6, 0.0, 0.0), Vec3::new(0.6, 0.1, 0.0)];
    let turn = Mat4::from_rotation_z(0.5) * Mat4::from_scale(Vec3::new(0.5, -0.4, 0.45));
    let mut copies = Builder::seen_from(Vec3::new(0.0, 0.0, 3.0), 50.0);
    let mut instances = Builder::seen_from(Vec3::new(0.0, 0.0, 3.0), 50.0);
    for (i, place) in places.into_iter().enumerate() {
        let matrix = Mat4::from_translation(place) * turn;
        copies.geometry(matrix, Shape::Mesh(mesh.clone()), glass(1.5, 0.2));
        if i == 0 {
            instances.geometry(matrix, Shape::Mesh(mesh.clone()), glass(1.5, 0.2));
        } else {
            let bindings = vec![Binding { symbol: "m".into(), material: 0, uv_sets: Vec::new() }];
            instances.node(matrix, Item::Geometry { geometry: 0, bindings });
        }
    }
    for scene in [&mut copies, &mut instances] {
        scene.sky(0.5);
        scene.light(Mat4::IDENTITY, LightKind::Directional { angle_deg: 10.0 }, Vec3::ONE);
    }
    let (a, ea) = mean(&copies.render(24, 128, 6, Strategy::Shared, 0));
    let (b, eb) = mean(&instances.render(24, 128, 6, Strategy::Shared, 0));
    assert!((a - b).abs() < 4.0 * (ea * ea + eb * eb).sqrt(), "{a} +- {ea}, {b} +- {eb}");
}

/// A unit sphere of 20 * 4^level triangles with its own normals.
fn icosphere(level: u32) -> Mesh {
    let t = 0.5 * (1.0 + 5.0f32.sqrt());
    let mut positions: Vec<Vec3> = Vec::new();
    for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
        positions.push(Vec3::new(a, b, 0.0).normalize());
    }
    for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
        positions.push(Vec3::new(0.0, a, b).normalize());
    }
    for (a, b) in [(t, -1.0), (t, 1.0), (-t, -1.0), (-t, 1.0)] {
        positions.push(Vec3::new(a, 0.0, b).normalize());
    }
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..level {
        let mut middles = std::collections::HashMap::new();
        let mut finer = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    positions.push((positions[i as usize] + positions[j as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    let groups = vec![Group { symbol: "m".into(), triangles: 0..triangles.len() }];
    Mesh { normals: positions.clone(), positions, triangles, groups, ..Mesh::default() }
}
