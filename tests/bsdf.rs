//! Every BSDF: what `sample` draws has the density that `eval` states, its weight is value over density, energy is kept,
//! and light may be turned around.

use glam::Vec3;
use pellicle::bsdf::{
    Bsdf, BsdfSample, Coat, CoatedDiffuse, Conductor, Dielectric, Diffuse, Microfacets, Missing, Multiple, Pdf,
    multiple_color,
};
use pellicle::color::{Emission, Index, Sensor};
use pellicle::document::Distribution;
use pellicle::film::{Layer, Range, RgbFilm, Side, Stack};
use pellicle::math::Sampler;
use pellicle::mode::{FilmPlan, Lanes, Mode, Rgb, Wide};

use crate::statistics::{chi_square, sidak};

/// A film and the shape of the surface that it lies on.
struct Case {
    name: String,
    film: RgbFilm,
    kind: Kind,
    alpha: f32,
    distribution: Distribution,
    /// What single scattering loses, from outside and from inside.
    missing: [Option<Missing>; 2],
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Diffuse,
    CoatedDiffuse,
    Conductor,
    Dielectric { eta: f32 },
}

fn film(base: (f32, f32), layers: &[(f32, f64)]) -> RgbFilm {
    let curve = |n: f32, k: f32| Index::Constant { n, k }.curve().unwrap();
    let layers = layers.iter().map(|&(n, thickness_nm)| Layer { index: curve(n, 0.0), thickness_nm }).collect();
    let stack = Stack { outside: curve(1.0, 0.0), layers, base: curve(base.0, base.1), varying: None, weight: 1.0 };
    let sensor = Sensor::new(&Emission::D65);
    let plan = FilmPlan { range: Range { min_nm: 0.0, max_nm: 0.0 }, sensor: &sensor, tolerance: 1.0, forced: None };
    Rgb::film(&stack, &plan).0
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |name: &str, kind, alpha, distribution, base, layers: &[(f32, f64)]| {
        let name = format!("{name}, {distribution:?} {alpha}");
        let film = film(base, layers);
        let eta = match kind {
            Kind::Dielectric { eta } if eta != 1.0 => Some(eta),
            _ => None,
        };
        let facet = |side, cos| match kind {
            Kind::Dielectric { .. } => {
                let split = Rgb::split(&film, side, cos, 0.0, &());
                (split.reflect.mean(), split.transmit.mean())
            }
            _ => (1.0, 0.0),
        };
        let rough = kind == Kind::Conductor || eta.is_some();
        let lost = |side| Missing::new(distribution, Some(alpha), side, eta, &facet).filter(|_| rough);
        let missing = [lost(Side::Outside), lost(Side::Inside)];
        cases.push(Case { name, film, kind, alpha, distribution, missing });
    };
    let soap: &[(f32, f64)] = &[(1.33, 400.0)];
    add("diffuse", Kind::Diffuse, 1.0, Distribution::Ggx, (1.5, 0.0), &[]);
    add("film on diffuse", Kind::CoatedDiffuse, 0.0, Distribution::Ggx, (1.5, 0.0), soap);
    for distribution in [Distribution::Ggx, Distribution::Beckmann] {
        for alpha in [0.0, 0.02, 0.1, 0.3, 0.7, 1.0] {
            add("metal", Kind::Conductor, alpha, distribution, (0.2, 3.0), &[]);
            add("film on metal", Kind::Conductor, alpha, distribution, (0.2, 3.0), soap);
            add("glass", Kind::Dielectric { eta: 1.5 }, alpha, distribution, (1.5, 0.0), &[]);
            add("film on glass", Kind::Dielectric { eta: 1.5 }, alpha, distribution, (1.5, 0.0), &[(1.9, 300.0)]);
            add("soap film", Kind::Dielectric { eta: 1.0 }, alpha, distribution, (1.0, 0.0), soap);
        }
    }
    cases
}

impl Case {
    fn bsdf(&self) -> Bsdf<'_, Rgb> {
        let one = Wide([1.0; 3]);
        let coat = Coat { film: &self.film, thickness_nm: 0.0, reflect_tint: one, transmit_tint: one };
        let microfacets = Microfacets { distribution: self.distribution, alpha: self.alpha };
        match self.kind {
            Kind::Diffuse => Bsdf::Diffuse(Diffuse { albedo: Wide([0.8, 0.5, 0.2]) }),
            Kind::CoatedDiffuse => Bsdf::CoatedDiffuse(CoatedDiffuse {
                coat,
                albedo: one,
                ior: 1.5,
                internal_reflectance: Rgb::average(&self.film, Side::Inside, 0.0, &()),
            }),
            Kind::Conductor => {
                let multiple = self.missing[0].as_ref().map(|missing| {
                    let average = Rgb::average(&self.film, Side::Outside, 0.0, &());
                    (missing, multiple_color(average, missing.mean(self.alpha)))
                });
                Bsdf::Conductor(Conductor { coat, microfacets, multiple })
            }
            Kind::Dielectric { eta } => {
                let multiple = self.missing[0].as_ref().zip(self.missing[1].as_ref()).map(|(outside, inside)| {
                    let averages = [coat.average(Side::Outside, &()), coat.average(Side::Inside, &())];
                    Multiple { outside, inside, averages }
                });
                Bsdf::Dielectric(Dielectric { coat, microfacets, refraction: (eta, false), multiple })
            }
        }
    }

    /// Directions to look from: above, and below where there is a below.
    fn views(&self) -> Vec<Vec3> {
        let above = [8.0f32, 50.0, 85.0].map(|deg: f32| {
            let (sin, cos) = deg.to_radians().sin_cos();
            Vec3::new(sin * 0.6, sin * 0.8, cos)
        });
        let mut views = above.to_vec();
        if matches!(self.kind, Kind::Dielectric { .. }) {
            views.extend(above.map(|w| Vec3::new(w.x, w.y, -w.z)));
        }
        views
    }
}

fn draw(bsdf: &Bsdf<Rgb>, wo: Vec3, index: u32) -> Option<BsdfSample<Rgb>> {
    let mut sampler = Sampler::new(7, index, 11);
    let [a, b, c, _] = sampler.next_4d();
    bsdf.sample(wo, [a, b, c], &())
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
    let tests: Vec<(&Case, Vec3)> = cases
        .iter()
        .filter(|case| case.alpha == 0.0 || case.alpha > NARROWEST)
        .flat_map(|case| case.views().into_iter().map(move |view| (case, view)))
        .collect();
    let significance = sidak(0.01, tests.len());
    let mut failures = Vec::new();
    for (case, wo) in &tests {
        let bsdf = case.bsdf();
        let mut observed = vec![0.0; THETA_BINS * PHI_BINS];
        let mut elsewhere = 0.0;
        for index in 0..DRAWS {
            match draw(&bsdf, *wo, index) {
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
                case.name,
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
                let Some(BsdfSample { wi, weight, pdf: Pdf::SolidAngle(pdf), .. }) = draw(&bsdf, wo, index) else {
                    continue;
                };
                let (value, stated) = bsdf.eval(wo, wi, &());
                assert!((stated / pdf - 1.0).abs() < 2e-2, "{}: sampled {pdf}, stated {stated}, {wo} {wi}", case.name);
                for lane in 0..3 {
                    let quotient = value.0[lane] / stated;
                    let close = (quotient - weight.0[lane]).abs() <= 2e-2 * weight.0[lane].abs().max(1e-3);
                    assert!(close, "{}: weight {weight:?}, value / pdf {quotient}, {wo} {wi}", case.name);
                }
            }
        }
    }
}

/// Mean weight: the share of light from everywhere that the surface returns.
fn albedo(case: &Case, wo: Vec3, draws: u32) -> [f64; 3] {
    let bsdf = case.bsdf();
    let mut sum = [0.0f64; 3];
    for index in 0..draws {
        if let Some(sample) = draw(&bsdf, wo, index) {
            // Radiance into a denser body is compressed; energy is not.
            let crossing = sample.wi.z * wo.z < 0.0;
            let scale = if crossing { bsdf.compression(sample.wi.z < 0.0) } else { 1.0 };
            for (lane, total) in sum.iter_mut().enumerate() {
                *total += f64::from(sample.weight.0[lane] * scale) / f64::from(draws);
            }
        }
    }
    sum
}

/// Saturated colours leave sRGB: single channels may pass 1 or fall below 0 where energy does not. The luminance tells.
fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[test]
fn smooth_lossless_surfaces_keep_all_energy() {
    let white = |kind| matches!(kind, Kind::Dielectric { .. } | Kind::CoatedDiffuse);
    for case in cases().iter().filter(|c| c.alpha == 0.0 && white(c.kind)) {
        for wo in case.views() {
            let albedo = albedo(case, wo, 4096);
            assert!(albedo.iter().all(|a| (a - 1.0).abs() < 0.01), "{} from {wo}: {albedo:?}", case.name);
        }
    }
}

#[test]
fn rough_lossless_surfaces_keep_all_energy_but_a_little() {
    // What bounces between facets comes back by the broad lobe.
    for case in cases().iter().filter(|c| c.alpha > 0.0 && matches!(c.kind, Kind::Dielectric { eta } if eta != 1.0)) {
        for wo in case.views() {
            let albedo = albedo(case, wo, 16_384);
            let kept = luminance(albedo);
            // Nearly smooth surfaces lose only near grazing, and are left alone.
            let tolerance = if case.alpha < 0.05 { 0.04 } else { 0.02 };
            assert!((kept - 1.0).abs() < tolerance, "{} from {wo}: {albedo:?}", case.name);
        }
    }
}

#[test]
fn no_surface_creates_energy() {
    for case in &cases() {
        for wo in case.views() {
            let albedo = albedo(case, wo, 4096);
            // Dielectrics share out what is missing by averages, and a rough sheet that does not bend light transmits by its
            // mean normal: not quite one sum.
            let most = if matches!(case.kind, Kind::Dielectric { .. }) { 1.02 } else { 1.005 };
            assert!((0.0..most).contains(&luminance(albedo)), "{} from {wo}: {albedo:?}", case.name);
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
            let index_at = |w: Vec3| match case.kind {
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
                    case.name
                );
            }
        }
    }
    assert_eq!(Wide::<3>::ZERO.mean(), 0.0);
}
