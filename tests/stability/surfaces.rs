//! Scattering: from perfectly smooth over barely rough to rough, seen from above, along the surface and from below.

use glam::Vec3;
use pellicle::bsdf::{BsdfSample, Pdf};
use pellicle::document::Distribution;
use pellicle::mode::{Lanes, Mode, Rgb, Spectral};

use super::Count;
use crate::bsdf::case::{Case, Kind, Recipe};

const ALPHAS: [f32; 6] = [0.0, 1e-6, 1.01e-4, 1e-3, 0.02, 1.0];
const COSINES: [f32; 5] = [1.0, 0.3, 1e-2, 1e-4, 1e-6];
/// The ends of the unit interval and its middle.
const NUMBERS: [f32; 4] = [0.0, 1e-7, 0.5, 0.999_999_94];

fn kinds() -> Vec<Kind> {
    vec![
        Kind::Diffuse,
        Kind::CoatedDiffuse,
        Kind::Conductor { n: 0.2, k: 3.0 },
        Kind::Conductor { n: 0.0, k: 4.0 },
        Kind::Dielectric { eta: 1.0 },
        Kind::Dielectric { eta: 1.000_05 },
        Kind::Dielectric { eta: 1.000_2 },
        Kind::Dielectric { eta: 1.5 },
        Kind::Dielectric { eta: 0.7 },
        Kind::Dielectric { eta: 4.0 },
    ]
}

/// Next to nothing, matched to either side, below 1, opaque, and frustrated total reflection.
fn films() -> Vec<Vec<(f32, f32, f64)>> {
    vec![
        vec![],
        vec![(1.33, 0.0, 1e-3)],
        vec![(1.5, 0.0, 300.0)],
        vec![(1.0, 0.0, 100.0)],
        vec![(0.4, 0.0, 50.0)],
        vec![(1.6, 0.3, 200.0)],
        vec![(2.0, 10.0, 1_000.0)],
    ]
}

fn check<M: Mode>(count: &mut Count, waves: M::Waves) {
    for kind in kinds() {
        for layers in films() {
            for (i, alpha) in ALPHAS.into_iter().enumerate() {
                let distribution = if i % 2 == 0 { Distribution::Ggx } else { Distribution::Beckmann };
                let recipe = Recipe { kind, alpha, distribution, layers: layers.clone() };
                let case = Case::<M>::new(recipe, waves);
                for cos in COSINES {
                    for sign in [1.0, -1.0] {
                        count.combination();
                        check_view(count, &case, Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos * sign));
                    }
                }
            }
        }
    }
}

fn check_view<M: Mode>(count: &mut Count, case: &Case<M>, wo: Vec3) {
    let bsdf = case.bsdf();
    for u in NUMBERS {
        for v in NUMBERS {
            let Some(sample) = bsdf.sample(wo, [u, v, 1.0 - v], &case.waves) else { continue };
            let BsdfSample { wi, weight, pdf, .. } = sample;
            let at = || format!("{} from {wo} with {u}, {v}: to {wi}, {pdf:?}, {weight:?}", case.recipe);
            count.assert(weight.is_finite() && (wi.length() - 1.0).abs() < 1e-3, at);
            // A weight is a share of light, times the square of the index across, over the chance of this lobe. Being
            // scattered at all may be rare; within that, choices are nearly in proportion to light.
            let across = bsdf.compression(wo.z < 0.0).max(bsdf.compression(wo.z >= 0.0));
            let scattered = match (pdf, bsdf.through(wo, &case.waves)) {
                (Pdf::Through(_), _) | (_, None) => 1.0,
                (_, Some((_, chance))) => 1.0 - chance,
            };
            count.assert(weight.max() * scattered <= 32.0 * across, at);
            if let Pdf::SolidAngle(pdf) = pdf {
                count.assert(pdf > 0.0 && pdf.is_finite(), at);
            }
            for other in [wi, Vec3::new(-wo.x, -wo.y, wo.z), -wo, wo, Vec3::X, Vec3::new(0.6, 0.8, 1e-20)] {
                let (value, pdf) = bsdf.eval(wo, other, &case.waves);
                count.assert(value.is_finite() && pdf.is_finite() && pdf >= 0.0, || {
                    format!("{} from {wo} to {other}: {value:?}, {pdf}", case.recipe)
                });
            }
        }
    }
    if let Some((light, chance)) = bsdf.through(wo, &case.waves) {
        let fine = light.is_finite() && light.max() <= 1.3 && (0.0..=1.0).contains(&chance);
        count.assert(fine, || format!("{} through {wo}: {light:?}, {chance}", case.recipe));
    }
}

#[test]
fn scattering_is_physical_at_every_extreme() {
    let mut count = Count::default();
    check::<Rgb>(&mut count, ());
    check::<Spectral<4>>(&mut count, Spectral::<4>::waves(0.2));
    count.finish(2_000);
}

#[test]
fn smooth_and_barely_rough_surfaces_return_the_same_light() {
    let mut count = Count::default();
    for kind in kinds() {
        for layers in films() {
            let albedo = |alpha: f32, wo: Vec3| {
                let recipe = Recipe { kind, alpha, distribution: Distribution::Ggx, layers: layers.clone() };
                Case::<Rgb>::new(recipe, ()).albedo(wo, 2_048)
            };
            for wo in [Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.6, 0.0, -0.8)] {
                count.combination();
                let smooth = albedo(0.0, wo);
                for alpha in [1e-6, 1.01e-4, 1e-3] {
                    let rough = albedo(alpha, wo);
                    let apart = smooth.zip(rough, |a, b| (a - b).abs()).max();
                    count.assert(apart < 0.01, || {
                        format!("{kind:?} under {layers:?}, {alpha} from {wo}: {smooth:?}, {rough:?}")
                    });
                }
            }
        }
    }
    count.finish(100);
}
