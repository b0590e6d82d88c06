//! Light from infinitely far away: lat-long images, a constant sky, the CS184 hemisphere.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{Mat3, Vec3, Vec4};

use super::light::Source;
use super::texture::Texture;
use crate::document::Encoding;
use crate::math::distribution::Grid;
use crate::math::trigonometry::{atan2, sin_cos_turn};
use crate::math::warp::{UNIFORM_SPHERE_PDF, square_to_sphere};

pub enum Sky {
    /// The same radiance from everywhere.
    Constant(Source),
    /// The same radiance from everywhere above the horizon (+Y).
    Hemisphere(Source),
    Image(Box<SkyImage>),
}

/// Radiance by direction: v = 0 at +y, u = atan2(x, -z) / 2 pi, turned by the environment's rotation.
pub struct SkyImage {
    width: usize,
    height: usize,
    /// Radiance, and the density on the unit square with which the texel is drawn: whoever sees the sky asks for both.
    texels: Vec<Vec4>,
    /// Multiplies the texels.
    tint: Source,
    to_image: Mat3,
    /// Over the image, for drawing directions.
    grid: Option<Grid>,
    /// Of the texels over the sphere.
    mean: Vec3,
}

/// Share of the drawn directions that follow the image's radiance; the others follow what exceeds its mean.
const PLAIN_SHARE: f32 = 0.02;

impl SkyImage {
    /// The image as it is; [`set`](Self::set) gives it tint and rotation.
    ///
    /// Scattered rays find the broad parts of a sky well enough by themselves: light sampling sees to what is brighter than
    /// its mean (Karlik et al. 2019, "MIS Compensation"), with a share for the rest so that it also works alone.
    pub fn new(texture: &Texture) -> Self {
        let (width, height) = (texture.width(), texture.height());
        let texel = |i: usize| texture.texel(i % width, i / width, Encoding::Linear);
        let mut texels: Vec<Vec4> = (0..width * height).map(texel).collect();
        let sines: Vec<f32> = (0..height).map(|y| ((y as f32 + 0.5) / height as f32 * PI).sin()).collect();
        // Bilinear lookups reach into the neighbours: a cell has the mean of what it can show.
        let strength: Vec<f32> = texels.iter().map(|t| t.truncate().element_sum().max(0.0)).collect();
        let blend = |a: f32, b: f32, c: f32| 0.25 * a + 0.5 * b + 0.25 * c;
        let across = |x: usize, y: usize| {
            let row = &strength[y * width..(y + 1) * width];
            blend(row[(x + width - 1) % width], row[x], row[(x + 1) % width])
        };
        let mut blurred: Vec<f32> = Vec::with_capacity(strength.len());
        for y in 0..height {
            let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
            blurred.extend((0..width).map(|x| blend(across(x, above), across(x, y), across(x, below))));
        }
        let (mut sum, mut weight) = (0.0f64, 0.0f64);
        for (y, row) in blurred.chunks_exact(width).enumerate() {
            sum += f64::from(sines[y]) * row.iter().map(|&b| f64::from(b)).sum::<f64>();
            weight += f64::from(sines[y]) * width as f64;
        }
        let mean = (sum / weight) as f32;
        let weigh = |x: usize, y: usize| {
            let b = blurred[y * width + x];
            (PLAIN_SHARE * b + (1.0 - PLAIN_SHARE) * (b - mean).max(0.0)) * sines[y]
        };
        let total: Vec3 = texels.iter().enumerate().map(|(i, texel)| texel.truncate() * sines[i / width]).sum();
        let grid = Grid::new(width, height, weigh);
        for (i, texel) in texels.iter_mut().enumerate() {
            texel.w = grid.as_ref().map_or(0.0, |grid| grid.pdf(i % width, i / width));
        }
        Self {
            width,
            height,
            texels,
            mean: total / weight as f32,
            grid,
            tint: Source { rgb: Vec3::ONE, spectrum: 0 },
            to_image: Mat3::IDENTITY,
        }
    }

    /// `rotation_deg` turns the image about world up, anticlockwise seen from above; `turn` comes after it.
    pub fn set(&mut self, tint: Source, rotation_deg: f32, turn: Mat3) {
        self.tint = tint;
        self.to_image = Mat3::from_rotation_y(-rotation_deg.to_radians()) * turn.transpose();
    }

    /// Radiance, bilinear, and the density of the texel around the point; the image closes around the vertical axis.
    #[inline]
    fn at(&self, uv: [f32; 2]) -> (Source, f32) {
        // At the middle of a texel to the right: its number.
        let x = uv[0] * self.width as f32 + 0.5;
        let y = (uv[1] * self.height as f32 - 0.5).clamp(0.0, (self.height - 1) as f32);
        let (x1, y0) = (x as usize, y as usize);
        let (fx, fy) = (x - x1 as f32, y - y0 as f32);
        let left = if x1 == 0 { self.width - 1 } else { x1 - 1 };
        let right = if x1 == self.width { 0 } else { x1 };
        let row = |y: usize| {
            let row = &self.texels[y * self.width..(y + 1) * self.width];
            [row[left], row[right]]
        };
        let [above, below] = [row(y0), row((y0 + 1).min(self.height - 1))];
        let nearer = if fy < 0.5 { above } else { below };
        let density = if fx < 0.5 { nearer[0] } else { nearer[1] }.w;
        let texel = above[0].lerp(above[1], fx).lerp(below[0].lerp(below[1], fx), fy);
        (Source { rgb: texel.truncate() * self.tint.rgb, ..self.tint }, density)
    }

    /// Where on the image a direction lies, and its sine to the vertical axis.
    fn uv(&self, toward: Vec3) -> ([f32; 2], f32) {
        let d = self.to_image * toward;
        let u = atan2(d.x, -d.z) / TAU;
        // The arc cosine has no digits left near the poles.
        let sin = (d.x * d.x + d.z * d.z).sqrt();
        ([u - u.floor(), atan2(sin, d.y) * FRAC_1_PI], sin)
    }

    fn sample(&self, u: [f32; 2]) -> Option<(Vec3, f32, Source)> {
        let (point, density) = self.grid.as_ref()?.sample(u);
        let (sin_theta, cos_theta) = sin_cos_turn(0.5 * point[1]);
        if sin_theta <= 0.0 {
            return None;
        }
        let (sin_phi, cos_phi) = sin_cos_turn(point[0]);
        let direction = Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
        let pdf = density / (2.0 * PI * PI * sin_theta);
        Some((self.to_image.transpose() * direction, pdf, self.at(point).0))
    }

    /// What comes from a direction, and the density of drawing it.
    fn seen(&self, toward: Vec3) -> (Source, f32) {
        let (uv, sin_theta) = self.uv(toward);
        let (source, density) = self.at(uv);
        let pdf = if sin_theta > 0.0 { density / (2.0 * PI * PI * sin_theta) } else { 0.0 };
        (source, pdf)
    }
}

impl Sky {
    /// A direction, its density in 1/sr, and the radiance from there; `None` when everything is black.
    pub fn sample(&self, u: [f32; 2]) -> Option<(Vec3, f32, Source)> {
        match self {
            Self::Constant(source) => Some((square_to_sphere(u), UNIFORM_SPHERE_PDF, *source)),
            Self::Hemisphere(source) => {
                let d = square_to_sphere(u);
                Some((Vec3::new(d.x, d.y.abs(), d.z), 2.0 * UNIFORM_SPHERE_PDF, *source))
            }
            Self::Image(image) => image.sample(u),
        }
    }

    /// Radiance from a direction, and the density with which [`Sky::sample`] draws it.
    pub fn seen(&self, toward: Vec3) -> (Source, f32) {
        match self {
            Self::Constant(source) => (*source, UNIFORM_SPHERE_PDF),
            Self::Hemisphere(source) if toward.y > 0.0 => (*source, 2.0 * UNIFORM_SPHERE_PDF),
            Self::Hemisphere(source) => (Source { rgb: Vec3::ZERO, ..*source }, 0.0),
            Self::Image(image) => image.seen(toward),
        }
    }

    /// Irradiance on a surface that all of it shines on, were it even; mean over the colours. For choosing between lights.
    pub fn irradiance(&self) -> f32 {
        let radiance = match self {
            Self::Constant(source) | Self::Hemisphere(source) => source.strength(),
            Self::Image(image) => (image.mean * image.tint.rgb).element_sum() / 3.0,
        };
        PI * radiance
    }
}
