//! Isotropic microfacet distributions: GGX and Beckmann, with visible-normal sampling and height-correlated shadowing.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec3};

use crate::document::Distribution;

/// Below this alpha a surface is treated as perfectly smooth: the lobe is narrower than f32 directions resolve.
const SMOOTH_ALPHA: f32 = 1e-4;

/// From this alpha on neighbours who share what they find on metal are better served than by light paths. At 0.1 light paths have
/// 1.07 times the efficiency, and 2.8 in dim regions; at 0.15 they have 0.87 and 1.45.
const BROAD_ALPHA: f32 = 0.12;

#[derive(Clone, Copy, Debug)]
pub struct Microfacets {
    pub distribution: Distribution,
    pub alpha: f32,
}

impl Microfacets {
    #[inline]
    pub fn is_smooth(&self) -> bool {
        self.alpha < SMOOTH_ALPHA
    }

    /// True where neighbouring viewers see much the same of what is reflected.
    #[inline]
    pub fn is_broad(&self) -> bool {
        self.alpha >= BROAD_ALPHA
    }

    /// Density of facet normals per steradian and unit of surface, for `h.z > 0`. Walter et al. 2007, eq. 25 and 33.
    #[inline]
    pub fn d(&self, h: Vec3) -> f32 {
        let alpha2 = self.alpha * self.alpha;
        let cos2 = h.z * h.z;
        // From x and y: 1 - cos^2 has no digits left near the normal.
        let slope2 = (h.x * h.x + h.y * h.y) / cos2;
        let scale = FRAC_1_PI / (alpha2 * cos2 * cos2);
        match self.distribution {
            Distribution::Ggx => {
                let s = 1.0 + slope2 / alpha2;
                scale / (s * s)
            }
            Distribution::Beckmann => scale * (-slope2 / alpha2).exp(),
        }
    }

    /// Smith's Lambda: hidden area per visible area.
    #[inline]
    fn lambda(&self, w: Vec3) -> f32 {
        let slope2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
        match self.distribution {
            Distribution::Ggx => 0.5 * ((1.0 + self.alpha * self.alpha * slope2).sqrt() - 1.0),
            Distribution::Beckmann => {
                // Exact form: Heitz 2014, eq. 68.
                let a = 1.0 / (self.alpha * slope2.sqrt());
                if a > 6.0 { 0.0 } else { 0.5 * ((-a * a).exp() / (a * PI.sqrt()) - erfc(a)) }
            }
        }
    }

    /// Share of facets visible from `w`.
    #[inline]
    pub fn g1(&self, w: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// Share visible from both directions on the same side. Heitz 2014, eq. 99.
    #[inline]
    pub fn g2_reflect(&self, wo: Vec3, wi: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(wo) + self.lambda(wi))
    }

    /// Share visible from both directions on opposite sides of the surface. Walter et al. 2007, eq. 23.
    #[inline]
    pub fn g2_transmit(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.g1(wo) * self.g1(wi)
    }

    /// A facet normal visible from `wo` (`wo.z > 0`), from two numbers in [0, 1).
    #[inline]
    pub fn sample_visible(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        match self.distribution {
            Distribution::Ggx => self.sample_visible_ggx(wo, u),
            Distribution::Beckmann => self.sample_visible_beckmann(wo, u),
        }
    }

    /// Density of [`Microfacets::sample_visible`], 1/sr.
    #[inline]
    pub fn visible_pdf(&self, wo: Vec3, h: Vec3) -> f32 {
        self.g1(wo) * self.d(h) * wo.dot(h).max(0.0) / wo.z
    }

    /// Dupuy & Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
    fn sample_visible_ggx(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(wo.x * self.alpha, wo.y * self.alpha, wo.z).normalize();
        let (sin, cos) = (2.0 * PI * u[0]).sin_cos();
        let z = (1.0 - u[1]).mul_add(1.0 + stretched.z, -stretched.z);
        let radius = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
        let half = Vec3::new(radius * cos, radius * sin, z) + stretched;
        Vec3::new(half.x * self.alpha, half.y * self.alpha, half.z.max(1e-20)).normalize()
    }

    /// Heitz & d'Eon 2014 in the plane of incidence, with the inversion of Jakob 2014, "An Improved Visible Normal
    /// Sampling Routine for the Beckmann Distribution".
    fn sample_visible_beckmann(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(wo.x * self.alpha, wo.y * self.alpha, wo.z).normalize();
        let sin = stretched.truncate().length();
        let slope = if sin < 1e-6 * stretched.z {
            // Seen from above the slopes are an isotropic Gaussian.
            let radius = (-(1.0 - u[0]).ln()).sqrt();
            let (s, c) = (2.0 * PI * u[1]).sin_cos();
            Vec2::new(radius * c, radius * s)
        } else {
            let local = visible_beckmann_slope(sin / stretched.z, u);
            let (cos_phi, sin_phi) = (stretched.x / sin, stretched.y / sin);
            Vec2::new(cos_phi * local.x - sin_phi * local.y, sin_phi * local.x + cos_phi * local.y)
        };
        Vec3::new(-slope.x * self.alpha, -slope.y * self.alpha, 1.0).normalize()
    }
}

/// Slope of a visible facet for unit roughness, the incident direction at `tan_theta` in the xz plane.
fn visible_beckmann_slope(tan_theta: f32, u: [f32; 2]) -> Vec2 {
    let cot = 1.0 / tan_theta;
    let largest = erf(cot);
    let u0 = u[0].clamp(1e-6, 1.0 - 1e-6);
    let scale = FRAC_1_PI.sqrt() * tan_theta;
    // Solve C(b) = u0 * C(largest) for b = erf(slope) by Newton's method, from a guess that is close everywhere.
    let target = u0 * (1.0 + largest + scale * (-cot * cot).exp());
    let mut b = largest - (largest + 1.0) * erf((-u0.ln()).sqrt());
    for _ in 0..3 {
        let slope = erf_inv(b);
        let value = 1.0 + b + scale * (-slope * slope).exp() - target;
        let derivative = 1.0 - slope * tan_theta;
        b = (b - value / derivative).clamp(-1.0 + 1e-6, largest);
    }
    Vec2::new(erf_inv(b), erf_inv(2.0 * u[1].clamp(1e-6, 1.0 - 1e-6) - 1.0))
}

/// Error function, absolute error below 2e-7. Abramowitz & Stegun 7.1.26.
fn erf(x: f32) -> f32 {
    (1.0 - erfc(x.abs())).copysign(x)
}

/// 1 - erf(x) for x >= 0.
fn erfc(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let poly = t * (0.254_829_6 + t * (-0.284_496_74 + t * (1.421_413_7 + t * (-1.453_152 + t * 1.061_405_4))));
    poly * (-x * x).exp()
}

/// Inverse of [`erf`] for |x| < 1. Giles 2010, "Approximating the erfinv function", single precision.
fn erf_inv(x: f32) -> f32 {
    let w = -((1.0 - x) * (1.0 + x)).ln();
    let horner = |w: f32, coefficients: [f32; 9]| coefficients.iter().fold(0.0, |sum, c| sum * w + c);
    let poly = if w < 5.0 {
        let c = [
            2.810_226_4e-8,
            3.432_739_4e-7,
            -3.523_387_7e-6,
            -4.391_506_5e-6,
            2.185_808_7e-4,
            -1.253_725e-3,
            -4.177_681_6e-3,
            2.466_407_3e-1,
            1.501_409_4,
        ];
        horner(w - 2.5, c)
    } else {
        let c = [
            -2.002_142_6e-4,
            1.009_505_6e-4,
            1.349_343_2e-3,
            -3.673_428_4e-3,
            5.739_507_7e-3,
            -7.622_461_3e-3,
            9.438_870_5e-3,
            1.001_674,
            2.832_976_8,
        ];
        horner(w.sqrt() - 3.0, c)
    };
    poly * x
}
