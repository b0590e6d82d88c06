//! White furnaces: a surface in a uniformly white world returns exactly what its optics say.

use glam::Vec3;
use pellicle::bsdf::{Microfacets, multiple_color};
use pellicle::document::Distribution;
use pellicle::film::Side;
use pellicle::math::Sampler;
use pellicle::mode::{Lanes, Mode, Rgb, Spectral, Wide};

use super::case::{Case, Kind, Recipe};

const ALPHAS: [f32; 6] = [0.0, 0.02, 0.1, 0.3, 0.7, 1.0];
const DRAWS: u32 = 16_384;
/// Largest error of any lane.
const TOLERANCE: f32 = 0.005;

fn films() -> [Vec<(f32, f32, f64)>; 5] {
    [vec![], vec![(1.9, 0.0, 50.0)], vec![(1.33, 0.0, 300.0)], vec![(1.9, 0.0, 900.0)], vec![(1.33, 0.0, 1500.0)]]
}

/// Worst deviation of a lane.
fn deviation<L: Lanes>(albedo: L, expected: L) -> f32 {
    albedo.zip(expected, |a, e| (a - e).abs()).max()
}

/// Every base, roughness and film from both sides: whether `expected(case, view)` comes back, in every lane.
fn failures<M: Mode>(kinds: &[Kind], waves: M::Waves, expected: &dyn Fn(&Case<M>, Vec3) -> M::Light) -> Vec<String> {
    let mut failures = Vec::new();
    for &kind in kinds {
        for distribution in [Distribution::Ggx, Distribution::Beckmann] {
            for alpha in ALPHAS {
                for layers in films() {
                    let case = Case::<M>::new(Recipe { kind, alpha, distribution, layers }, waves);
                    for wo in case.views() {
                        // Narrow lobes near grazing are the noisiest.
                        let draws = if (0.001..0.05).contains(&alpha) { 4 * DRAWS } else { DRAWS };
                        let (albedo, expected) = (case.albedo(wo, draws), expected(&case, wo));
                        let error = deviation(albedo, expected);
                        if error.is_nan() || error > TOLERANCE {
                            failures.push(format!("{} from {wo}: {albedo:?} for {expected:?}", case.recipe));
                        }
                    }
                }
            }
        }
    }
    failures
}

const LOSSLESS: [Kind; 4] = [
    Kind::CoatedDiffuse,
    Kind::Conductor { n: 0.0, k: 4.0 },
    Kind::Dielectric { eta: 1.5 },
    Kind::Dielectric { eta: 1.0 },
];

#[test]
fn lossless_surfaces_return_all_light_in_rgb() {
    let failures = failures::<Rgb>(&LOSSLESS, (), &|_, _| Wide::ONE);
    assert!(failures.is_empty(), "{}:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn lossless_surfaces_return_all_light_at_every_wavelength() {
    let waves = Spectral::<8>::waves(0.37);
    let failures = failures::<Spectral<8>>(&LOSSLESS, waves, &|_, _| Wide::ONE);
    assert!(failures.is_empty(), "{}:\n{}", failures.len(), failures.join("\n"));
}

/// What single scattering returns, and with it what Kulla & Conty's broad lobe adds, by brute force.
fn metal<M: Mode>(case: &Case<M>, wo: Vec3) -> M::Light {
    let Recipe { alpha, distribution, .. } = case.recipe;
    let microfacets = Microfacets { distribution, alpha };
    if microfacets.is_smooth() {
        return case.reflectance(wo.z);
    }
    let (mut single, kept) = single_scattering(case, &microfacets, wo, 64);
    // The mean over the hemisphere, by midpoints of mu^2.
    let steps = 64;
    let mean: f32 = (0..steps)
        .map(|i| {
            let mu = ((i as f32 + 0.5) / steps as f32).sqrt();
            single_scattering(case, &microfacets, Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu), 32).1 / steps as f32
        })
        .sum();
    single += multiple_color(case.average(Side::Outside), 1.0 - mean) * (1.0 - kept);
    single
}

/// (Light returned by the facets alone, and if they were perfect mirrors).
fn single_scattering<M: Mode>(case: &Case<M>, microfacets: &Microfacets, wo: Vec3, side: u32) -> (M::Light, f32) {
    let (mut returned, mut kept) = (M::Light::ZERO, 0.0);
    let share = 1.0 / (side * side) as f32;
    for index in 0..side * side {
        let [u, v, ..] = Sampler::new(1, index, 2).next_4d();
        let h = microfacets.sample_visible(wo, [u, v]);
        let wi = h * (2.0 * wo.dot(h)) - wo;
        if wi.z > 0.0 {
            let through = share * microfacets.g2_reflect(wo, wi) / microfacets.g1(wo);
            kept += through;
            returned += case.reflectance(wo.dot(h)) * through;
        }
    }
    (returned, kept)
}

#[test]
fn metals_return_what_their_facets_and_their_average_say() {
    let metals = [Kind::Conductor { n: 0.2, k: 3.0 }, Kind::Conductor { n: 2.8, k: 3.3 }];
    let failures = failures::<Rgb>(&metals, (), &metal);
    assert!(failures.is_empty(), "{}:\n{}", failures.len(), failures.join("\n"));
}
