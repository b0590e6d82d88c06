//! Every BSDF: what `sample` draws has the density that `eval` states, its weight is value over density, energy is kept,
//! and light may be turned around.

pub mod case;
mod furnace;

use glam::Vec3;
use pellicle::bsdf::{Bsdf, BsdfSample, Pdf};
use pellicle::document::Distribution;
use pellicle::math::Sampler;
use pellicle::mode::{Lanes, Rgb, Wide};

use self::case::{Case, Kind, Recipe};
use crate::statistics::{chi_square, sidak};

fn cases() -> Vec<Case<Rgb>> {
    let mut cases = Vec::new();
    let mut add = |kind, alpha, distribution, layers: &[(f32, f32, f64)]| {
        cases.push(Case::new(Recipe { kind, alpha, distribution, layers: layers.to_vec() }, ()));
    };
    let soap: &[(f32, f32, f64)] = &[(1.33, 0.0, 400.0)];
    add(Kind::Diffuse, 1.0, Distribution::Ggx, &[]);
    add(Kind::CoatedDiffuse, 0.0, Distribution::Ggx, soap);
    let metal = Kind::Conductor { n: 0.2, k: 3.0 };
    for distribution in [Distribution::Ggx, Distribution::Beckmann] {
        for alpha in [0.0, 0.02, 0.1, 0.3, 0.7, 1.0] {
            add(metal, alpha, distribution, &[]);
            add(metal, alpha, distribution, soap);
            add(Kind::Dielectric { eta: 1.5 }, alpha, distribution, &[]);
            add(Kind::Dielectric { eta: 1.5 }, alpha, distribution, &[(1.9, 0.0, 300.0)]);
            add(Kind::Dielectric { eta: 1.5 }, alpha, distribution, &[(1.6, 0.3, 80.0)]);
            add(Kind::Dielectric { eta: 1.0 }, alpha, distribution, soap);
        }
    }
    cases
}

const THETA_BINS: usize = 20;
const PHI_BINS: usize = 32;

fn bin(w: Vec3) -> usize {
    // Equal steps of the polar angle: equal steps of its cosine would put a whole lobe at the pole into one row.
    let theta = w.truncate().length().atan2(w.z);
    let row = ((theta / std::f32::consts::PI * THETA_BINS as f32) as usize).min(THETA_BINS - 1);
    let turn = w.y.atan2(w.x) / std::f32::consts::TAU;
    let column = (((turn - turn.floor()) * PHI_BINS as f32) as usize).min(PHI_BINS - 1);
    row * PHI_BINS + column
}

/// Integral of the density over each bin. Narrow lobes need fine steps: the bin is subdivided `fine` times.
fn expected(bsdf: &Bsdf<Rgb>, wo: Vec3, fine: usize) -> Vec<f64> {
    let cell = 2.0 * std::f64::consts::PI.powi(2) / (THETA_BINS * PHI_BINS * fine * fine) as f64;
    let mut cells = vec![0.0; THETA_BINS * PHI_BINS];
    for row in 0..THETA_BINS * fine {
        let (radius, z) = (std::f32::consts::PI * (row as f32 + 0.5) / (THETA_BINS * fine) as f32).sin_cos();
        let area = cell * f64::from(radius);
        for column in 0..PHI_BINS * fine {
            let phi = std::f32::consts::TAU * (column as f32 + 0.5) / (PHI_BINS * fine) as f32;
            let w = Vec3::new(radius * phi.cos(), radius * phi.sin(), z);
            cells[row / fine * PHI_BINS + column / fine] += f64::from(bsdf.eval(wo, w, &()).1) * area;
        }
    }
    cells
}

/// Lobes narrower than this cannot be integrated on a grid in reasonable time.
const NARROWEST: f32 = 0.05;

#[test]
fn drawn_directions_have_the_stated_density() {
    const DRAWS: u32 = 40_000;
    let cases = cases();
    let tests: Vec<(&Case<Rgb>, Vec3)> = cases
        .iter()
        .filter(|case| case.recipe.alpha == 0.0 || case.recipe.alpha > NARROWEST)
        .flat_map(|case| case.views().into_iter().map(move |view| (case, view)))
        .collect();
    let significance = sidak(0.01, tests.len());
    let mut failures = Vec::new();
    for (case, wo) in &tests {
        let bsdf = case.bsdf();
        let mut observed = vec![0.0; THETA_BINS * PHI_BINS];
        let mut elsewhere = 0.0;
        for index in 0..DRAWS {
            match case.draw(&bsdf, *wo, index) {
                Some(BsdfSample { wi, pdf: Pdf::SolidAngle(_), .. }) => observed[bin(wi)] += 1.0,
                _ => elsewhere += 1.0,
            }
        }
        let mut expected: Vec<f64> = expected(&bsdf, *wo, 16).iter().map(|p| p * f64::from(DRAWS)).collect();
        let mass: f64 = expected.iter().sum();
        // Everything that is not in a bin is delta, straight through, or absorbed.
        expected.push((f64::from(DRAWS) - mass).max(0.0));
        observed.push(elsewhere);
        let p = chi_square(&observed, &expected);
        if p < significance || mass > 1.002 * f64::from(DRAWS) {
            failures.push(format!(
                "{} from {wo}: p = {p:.1e}, density integrates to {:.4}",
                case.recipe,
                mass / f64::from(DRAWS)
            ));
        }
    }
    assert!(failures.is_empty(), "{} of {}:\n{}", failures.len(), tests.len(), failures.join("\n"));
}

#[test]
fn weights_are_value_over_density() {
    for case in &cases() {
        let bsdf = case.bsdf();
        for wo in case.views() {
            for index in 0..500 {
                let Some(BsdfSample { wi, weight, pdf: Pdf::SolidAngle(pdf), .. }) = case.draw(&bsdf, wo, index) else {
                    continue;
                };
                let (value, stated) = bsdf.eval(wo, wi, &());
                assert!(
                    (stated / pdf - 1.0).abs() < 2e-2,
                    "{}: sampled {pdf}, stated {stated}, {wo} {wi}",
                    case.recipe
                );
                for lane in 0..3 {
                    let quotient = value.0[lane] / stated;
                    let close = (quotient - weight.0[lane]).abs() <= 2e-2 * weight.0[lane].abs().max(1e-3);
                    assert!(close, "{}: weight {weight:?}, value / pdf {quotient}, {wo} {wi}", case.recipe);
                }
            }
        }
    }
}

/// Saturated colours leave sRGB: single channels may pass 1 or fall below 0 where energy does not. The luminance tells.
fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[test]
fn no_surface_creates_energy() {
    for case in &cases() {
        for wo in case.views() {
            let albedo = case.albedo(wo, 16_384);
            assert!((0.0..1.005).contains(&luminance(albedo.0)), "{} from {wo}: {albedo:?}", case.recipe);
        }
    }
}

#[test]
fn light_may_be_turned_around() {
    for case in &cases() {
        let bsdf = case.bsdf();
        for index in 0..2_000 {
            let mut sampler = Sampler::new(3, index, 5);
            let [a, b, c, d] = sampler.next_4d();
            let wo = pellicle::math::warp::square_to_sphere([a, b]);
            let wi = pellicle::math::warp::square_to_sphere([c, d]);
            if wo.z.abs() < 0.02 || wi.z.abs() < 0.02 {
                continue;
            }
            // f(wo, wi) / eta_o^2 is symmetric, eta being the index on the light's side.
            let index_at = |w: Vec3| match case.recipe.kind {
                Kind::Dielectric { eta } if w.z < 0.0 => eta * eta,
                _ => 1.0,
            };
            let forth = bsdf.eval(wo, wi, &()).0 * (1.0 / (wi.z.abs() * index_at(wo)));
            let back = bsdf.eval(wi, wo, &()).0 * (1.0 / (wo.z.abs() * index_at(wi)));
            for lane in 0..3 {
                let (f, g) = (forth.0[lane], back.0[lane]);
                assert!(
                    (f - g).abs() <= 1e-3 + 0.02 * f.abs().max(g.abs()),
                    "{}: {f} and {g} for {wo} {wi}",
                    case.recipe
                );
            }
        }
    }
    assert_eq!(Wide::<3>::ZERO.mean(), 0.0);
}
