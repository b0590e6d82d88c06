//! Bodies in, beside and across each other: media with priorities against closed forms.

use glam::{Mat4, Vec3};
use pellicle::color::{Emission, Index, Sensor};
use pellicle::document::{Base, Film, Group, Material, Mesh, Shape, Thickness};
use pellicle::film::{Layer, Side, Stack, exact};
use pellicle::integrate::{PathLimits, Strategy};
use pellicle::mode::{Mode, Rgb, Spectral};
use pellicle::render::Frame;

use crate::transport::{Builder, coated, diffuse, glass, mean, rough, shining};

/// A medium.
fn medium(ior: f32, priority: u8, absorption: f32) -> Material {
    let mut material = glass(ior, 0.0);
    if let Base::Dielectric { absorption_per_m, priority: rank, .. } = &mut material.base {
        (*absorption_per_m, *rank) = (Vec3::splat(absorption), Some(priority));
    }
    material
}

/// A block 200 m wide between two heights along z.
fn slab(builder: &mut Builder, low: f32, high: f32, material: Material) {
    let corner = |i: usize| {
        let side = |bit: usize, low: f32, high: f32| if i >> bit & 1 == 1 { high } else { low };
        Vec3::new(side(0, -100.0, 100.0), side(1, -100.0, 100.0), side(2, low, high))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let groups = vec![Group { symbol: "m".into(), triangles: 0..12 }];
    let mesh = Mesh { positions: (0..8).map(corner).collect(), triangles, groups, ..Mesh::default() };
    builder.geometry(Mat4::IDENTITY, Shape::Mesh(mesh), material);
}

fn looking_down(z: f32) -> Builder {
    let mut builder = Builder::seen_from(Vec3::new(0.31, 0.17, z), 0.01);
    builder.sky(1.0);
    builder
}

/// Of several interfaces at normal incidence, from above: incoherent reflectance and transmittance from both sides.
#[derive(Clone, Copy)]
struct Pile {
    down: [f64; 2],
    up: [f64; 2],
}

impl Pile {
    fn interface(reflect: f64) -> Self {
        Self { down: [reflect, 1.0 - reflect], up: [reflect, 1.0 - reflect] }
    }

    fn between(above: f64, below: f64) -> Self {
        Self::interface(((above - below) / (above + below)).powi(2))
    }

    fn path(transmit: f64) -> Self {
        Self { down: [0.0, transmit], up: [0.0, transmit] }
    }

    /// All orders of reflection between the two: the adding method.
    fn on(self, below: Self) -> Self {
        let echo = 1.0 / (1.0 - self.up[0] * below.down[0]);
        Self {
            down: [
                self.down[0] + self.down[1] * below.down[0] * self.up[1] * echo,
                self.down[1] * below.down[1] * echo,
            ],
            up: [below.up[0] + below.up[1] * self.up[0] * below.down[1] * echo, below.up[1] * self.up[1] * echo],
        }
    }

    /// Under a white sky above and below.
    fn radiance(self) -> f64 {
        self.down[0] + self.down[1]
    }
}

fn assert_close((mean, error): (f64, f64), wanted: f64) {
    assert!((mean - wanted).abs() < 4.5 * error + 1e-4, "{mean} +- {error}, wanted {wanted}");
}

const SPECULAR: PathLimits = PathLimits { max_bounces: 200, strategy: Strategy::Mis };

fn seen(builder: &Builder) -> (f64, f64) {
    mean(&builder.render_in::<Rgb>(32, 64, SPECULAR, 0))
}

/// A layer of liquid that absorbs, between two panes: touching, overlapping the panes, or taking their place.
#[test]
fn liquid_between_panes_reflects_and_absorbs_as_a_pile_of_interfaces() {
    let pile = |half: f64| {
        let liquid = Pile::path((-0.7 * 2.0 * half).exp());
        let pane = Pile::between(1.0, 1.5);
        pane.on(Pile::between(1.5, 1.2)).on(liquid).on(Pile::between(1.2, 1.5)).on(pane).radiance()
    };
    for (reach, liquid_priority, half) in [(0.5, 1, 0.5), (0.8, 1, 0.5), (0.8, 9, 0.8)] {
        // The order of the file must not matter.
        for liquid_first in [true, false] {
            let mut builder = looking_down(5.0);
            let liquid = medium(1.2, liquid_priority, 0.7);
            if liquid_first {
                slab(&mut builder, -reach, reach, liquid.clone());
            }
            slab(&mut builder, 0.5, 1.0, medium(1.5, 2, 0.0));
            slab(&mut builder, -1.0, -0.5, medium(1.5, 3, 0.0));
            if !liquid_first {
                slab(&mut builder, -reach, reach, liquid);
            }
            assert_close(seen(&builder), pile(half));
        }
    }
}

/// An air bubble is a medium of index 1 that takes the place of the glass.
#[test]
fn air_takes_the_place_of_glass() {
    let mut builder = looking_down(5.0);
    slab(&mut builder, -1.0, 1.0, medium(1.8, 1, 0.4));
    slab(&mut builder, -0.5, 0.5, medium(1.0, 2, 0.0));
    let (face, glass) = (Pile::between(1.0, 1.8), Pile::path((-0.4f64 * 0.5).exp()));
    assert_close(seen(&builder), face.on(glass).on(face).on(face).on(glass).on(face).radiance());
}

/// Two bodies of one medium are one body, and what has no priority is in air wherever it is.
#[test]
fn overlapping_bodies_of_one_medium_are_one() {
    let mut builder = looking_down(5.0);
    slab(&mut builder, -1.0, 0.25, medium(1.5, 1, 0.4));
    slab(&mut builder, -0.25, 1.0, medium(1.5, 1, 0.4));
    // Both shapes shall have the very same material.
    let placed = builder.0.nodes.len() - 1;
    if let pellicle::document::Item::Geometry { bindings, .. } = &mut builder.0.nodes[placed].items[0] {
        bindings[0].material -= 1;
    }
    let face = Pile::between(1.0, 1.5);
    assert_close(seen(&builder), face.on(Pile::path((-0.8f64).exp())).on(face).radiance());
}

/// A film between water and glass is computed between these two.
#[test]
fn a_film_under_water_has_water_on_its_outside() {
    let (water, base, film) = (1.33, 1.6, 2.2);
    let mut builder = looking_down(5.0);
    // The glass reaches into the water and is black inside.
    slab(&mut builder, 0.0, 2.0, medium(water, 1, 0.0));
    slab(&mut builder, -2.0, 1.0, coated(medium(base, 2, 1e6), film, 110.0));
    let curve = |n: f32| Index::Constant { n, k: 0.0 }.curve().unwrap();
    let stack = Stack {
        layers: vec![Layer { index: curve(film), thickness_nm: 110.0 }],
        ..Stack::bare(curve(water), curve(base))
    };
    let sensor = Sensor::new(&Emission::E);
    let mut wanted = [0.0; 3];
    for nm in (380..=780).map(f64::from) {
        let reflect = exact(&stack, Side::Outside, 1.0, 0.0, nm).mean().reflect;
        let pile = Pile::between(1.0, f64::from(water)).on(Pile { down: [reflect, 0.0], up: [0.0, 0.0] });
        let weight = sensor.reflectance_weight(nm);
        wanted = std::array::from_fn(|c| wanted[c] + weight[c] * pile.radiance());
    }
    check_colour(&builder.render_in::<Rgb>(48, 64, SPECULAR, 0), wanted, 2e-3);
    check_colour(&builder.render_in::<Spectral<8>>(48, 64, SPECULAR, 0), wanted, 1e-4);
}

fn check_colour(frame: &Frame, wanted: [f64; 3], slack: f64) {
    let n = frame.rgb.len() as f64;
    for (c, wanted) in wanted.into_iter().enumerate() {
        let mean = frame.rgb.iter().map(|p| f64::from(p[c])).sum::<f64>() / n;
        let error = frame.variance.iter().map(|p| f64::from(p[c])).sum::<f64>().sqrt() / n;
        assert!((mean - wanted).abs() < 4.5 * error + slack, "channel {c}: {mean} +- {error}, wanted {wanted}");
    }
}

#[test]
fn a_camera_knows_the_bodies_around_it() {
    let mut builder = looking_down(0.25);
    slab(&mut builder, -1.0, 1.0, medium(1.5, 2, 0.5));
    // A lower medium everywhere, which must not show.
    slab(&mut builder, -3.0, 0.75, medium(1.2, 1, 9.0));
    slab(&mut builder, -3.0, -0.75, medium(1.5, 3, 0.0));
    // From the camera down 1 m through glass that absorbs, then through clear glass of the same index and out at -3; what
    // the bottom returns passes the 1.75 m that absorb and is out at the top, or comes again from there.
    let (reflect, pass) = (Pile::between(1.5, 1.0).down[0], Pile::between(1.5, 1.0).down[1]);
    let through = (-0.5f64 * 1.75).exp();
    let returned = through * (pass + reflect * through * pass) / (1.0 - (reflect * through).powi(2));
    let wanted = (-0.5f64).exp() * (pass + reflect * returned);
    // Radiance is denser inside by the square of the index.
    assert_close(seen(&builder), 1.5 * 1.5 * wanted);
}

/// Soap films beside and inside bodies: sheets, no media. Nothing is lost, nothing gained.
#[test]
fn bubbles_in_and_around_media_keep_white_white() {
    let film = |nm| coated(glass(1.0, 0.0), 1.33, nm);
    let mut builder = Builder::seen_from(Vec3::new(0.0, 0.0, 4.0), 40.0);
    builder.sky(1.0);
    for (x, y) in [(-0.6, 0.0), (0.1, 0.3), (0.5, -0.4)] {
        builder.sphere(Vec3::new(x, y, 0.0), 0.7, film(400.0));
    }
    builder.sphere(Vec3::new(0.0, 0.0, -0.2), 1.1, medium(1.5, 2, 0.0));
    builder.sphere(Vec3::new(0.9, 0.0, 0.3), 0.7, medium(1.33, 1, 0.0));
    builder.sphere(Vec3::new(0.6, 0.2, 0.1), 0.5, coated(medium(1.0, 3, 0.0), 2.0, 300.0));
    assert_close(mean(&builder.render(24, 64, 400, Strategy::Mis, 0)), 1.0);
}

/// A rough bubble of air in glass: the thinner medium is inside, and nothing is lost.
#[test]
fn rough_bubbles_keep_white_white() {
    let mut bubble = medium(1.0, 2, 0.0);
    if let Base::Dielectric { microfacets, .. } = &mut bubble.base {
        *microfacets = rough(0.5);
    }
    let mut builder = Builder::seen_from(Vec3::new(0.0, 0.0, 4.0), 25.0);
    builder.sky(1.0);
    builder.sphere(Vec3::ZERO, 1.0, medium(1.5, 1, 0.0));
    builder.sphere(Vec3::new(0.1, 0.2, 0.0), 0.6, bubble);
    let (mean, error) = mean(&builder.render(16, 256, 400, Strategy::Mis, 0));
    assert!((mean - 1.0).abs() < 4.5 * error + 2e-3, "{mean} +- {error}");
}

/// Shadow rays go the same way as paths: through hidden and index-matched interfaces, with what each medium absorbs.
#[test]
fn light_inside_media_is_found_alike_by_all_strategies() {
    fn build() -> Builder {
        let mut builder = Builder::seen_from(Vec3::new(0.0, 0.6, 4.0), 40.0);
        builder.floor(Vec3::new(0.0, -0.5, 0.0), 0.6, diffuse(0.8));
        builder.sphere(Vec3::new(0.1, 0.5, 0.1), 0.15, shining(diffuse(0.0), 4.0));
        builder.sphere(Vec3::ZERO, 1.2, medium(1.3, 4, 0.6));
        // Hidden in the first, and one of its own index that takes its place.
        builder.sphere(Vec3::new(0.2, 0.3, 0.0), 0.5, medium(1.7, 1, 5.0));
        builder.sphere(Vec3::new(-0.3, 0.0, 0.2), 0.4, medium(1.3, 7, 2.0));
        // A rough body that light crosses before it is absorbed.
        let mut milky = medium(1.6, 9, 0.5);
        if let Base::Dielectric { microfacets, .. } = &mut milky.base {
            *microfacets = rough(0.4);
        }
        builder.sphere(Vec3::new(0.5, -0.3, 0.5), 0.3, milky);
        builder
    }
    fn compare<M: Mode>() {
        let builder = build();
        let measure =
            |strategy, spp| mean(&builder.render_in::<M>(24, spp, PathLimits { max_bounces: 6, strategy }, 0));
        let by_light = measure(Strategy::Light, 256);
        for (strategy, spp) in [(Strategy::Bsdf, 1024), (Strategy::Mis, 256), (Strategy::Shared, 256)] {
            let found = measure(strategy, spp);
            let error = (found.1 * found.1 + by_light.1 * by_light.1).sqrt();
            assert!((found.0 - by_light.0).abs() < 4.5 * error, "{strategy:?}: {found:?}, light: {by_light:?}");
        }
    }
    compare::<Rgb>();
    compare::<Spectral<4>>();
}

/// A varying film keeps its thickness between any two media.
#[test]
fn scenes_without_media_render_as_if_there_were_no_priorities() {
    let film = |mut material: Material| {
        let index = Index::Constant { n: 1.4, k: 0.0 };
        let thickness = Thickness::Noise { nm: 300.0, amplitude: 0.5, frequency: 3.0, octaves: 2, seed: 1 };
        material.films.push(Film { index, thickness, weight: 1.0 });
        material
    };
    let render = |material: Material| {
        let mut builder = Builder::seen_from(Vec3::new(0.0, 0.0, 3.0), 40.0);
        builder.sky(1.0);
        builder.floor(Vec3::new(0.0, -1.0, 0.0), 2.0, diffuse(0.5));
        builder.sphere(Vec3::ZERO, 0.8, film(material));
        builder.render(16, 64, 8, Strategy::Bsdf, 0).sha256()
    };
    assert_eq!(
        render(medium(1.5, 3, 0.2)),
        render({
            let mut plain = medium(1.5, 3, 0.2);
            if let Base::Dielectric { priority, .. } = &mut plain.base {
                *priority = None;
            }
            plain
        })
    );
}
