//! Light from infinitely far away: lat-long images, a constant sky, the CS184 hemisphere.

use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::sync::Arc;

use glam::{DVec3, Mat3, Vec2, Vec3};

use super::light::Source;
use super::texture::Texture;
use crate::document::{Encoding, Wrap};
use crate::math::distribution::Grid;
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
    texture: Arc<Texture>,
    /// Multiplies the texels.
    tint: Source,
    to_image: Mat3,
    /// Luminance times the sine that the projection squeezes.
    density: Option<Grid>,
    /// Of the texels over the sphere.
    mean: Vec3,
}

impl SkyImage {
    /// The image as it is; [`set`](Self::set) gives it tint and rotation.
    pub fn new(texture: Arc<Texture>) -> Self {
        let (width, height) = (texture.width(), texture.height());
        let mut weights = Vec::with_capacity(width * height);
        for y in 0..height {
            let sin = ((y as f32 + 0.5) / height as f32 * PI).sin();
            for x in 0..width {
                // Bilinear lookups reach into the neighbours: a cell's weight is the largest of what it can show.
                let texel = |dx: usize, dy: usize| {
                    let row = (y + dy).clamp(1, height) - 1;
                    texture.texel((x + dx + width - 1) % width, row, Encoding::Linear).truncate().element_sum()
                };
                let mut around = 0.0;
                for dy in 0..3 {
                    for dx in 0..3 {
                        let share = [0.25, 0.5, 0.25][dx] * [0.25, 0.5, 0.25][dy];
                        around += share * texel(dx, dy).max(0.0);
                    }
                }
                weights.push(around * sin);
            }
        }
        let density = Grid::new(&weights, width);
        let mean = mean(&texture);
        let tint = Source { rgb: Vec3::ONE, spectrum: 0 };
        Self { texture, tint, to_image: Mat3::IDENTITY, density, mean }
    }

    /// `rotation_deg` turns the image about world up, anticlockwise seen from above; `turn` comes after it.
    pub fn set(&mut self, tint: Source, rotation_deg: f32, turn: Mat3) {
        self.tint = tint;
        self.to_image = Mat3::from_rotation_y(-rotation_deg.to_radians()) * turn.transpose();
    }

    fn radiance(&self, toward: Vec3) -> Source {
        let uv = self.uv(toward);
        let texel = self.texture.lookup(Vec2::new(uv.x, 1.0 - uv.y), [Wrap::Repeat, Wrap::Clamp], Encoding::Linear);
        Source { rgb: texel.truncate() * self.tint.rgb, ..self.tint }
    }

    fn uv(&self, toward: Vec3) -> Vec2 {
        let d = self.to_image * toward;
        let u = d.x.atan2(-d.z) / TAU;
        Vec2::new(u - u.floor(), d.y.clamp(-1.0, 1.0).acos() * FRAC_1_PI)
    }

    fn sample(&self, u: [f32; 2]) -> Option<(Vec3, f32)> {
        let (point, density) = self.density.as_ref()?.sample(u);
        let (sin_theta, cos_theta) = (point[1] * PI).sin_cos();
        if sin_theta <= 0.0 {
            return None;
        }
        let (sin_phi, cos_phi) = (point[0] * TAU).sin_cos();
        let direction = Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
        Some((self.to_image.transpose() * direction, density / (2.0 * PI * PI * sin_theta)))
    }

    fn pdf(&self, toward: Vec3) -> f32 {
        let Some(density) = &self.density else { return 0.0 };
        let uv = self.uv(toward);
        let sin_theta = (uv.y * PI).sin();
        if sin_theta <= 0.0 { 0.0 } else { density.pdf([uv.x, uv.y]) / (2.0 * PI * PI * sin_theta) }
    }
}

/// Mean texel over the sphere.
fn mean(texture: &Texture) -> Vec3 {
    let (width, height) = (texture.width(), texture.height());
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0f64);
    for y in 0..height {
        let sin = f64::from(((y as f32 + 0.5) / height as f32 * PI).sin());
        for x in 0..width {
            sum += sin * texture.texel(x, y, Encoding::Linear).truncate().as_dvec3();
            weight += sin;
        }
    }
    (sum / weight).as_vec3()
}

impl Sky {
    pub fn radiance(&self, toward: Vec3) -> Source {
        match self {
            Self::Constant(source) => *source,
            Self::Hemisphere(source) if toward.y > 0.0 => *source,
            Self::Hemisphere(source) => Source { rgb: Vec3::ZERO, ..*source },
            Self::Image(image) => image.radiance(toward),
        }
    }

    /// A direction in proportion to radiance, and its density in 1/sr; `None` when everything is black.
    pub fn sample(&self, u: [f32; 2]) -> Option<(Vec3, f32)> {
        match self {
            Self::Constant(_) => Some((square_to_sphere(u), UNIFORM_SPHERE_PDF)),
            Self::Hemisphere(_) => {
                let d = square_to_sphere(u);
                Some((Vec3::new(d.x, d.y.abs(), d.z), 2.0 * UNIFORM_SPHERE_PDF))
            }
            Self::Image(image) => image.sample(u),
        }
    }

    pub fn pdf(&self, toward: Vec3) -> f32 {
        match self {
            Self::Constant(_) => UNIFORM_SPHERE_PDF,
            Self::Hemisphere(_) => {
                if toward.y > 0.0 {
                    2.0 * UNIFORM_SPHERE_PDF
                } else {
                    0.0
                }
            }
            Self::Image(image) => image.pdf(toward),
        }
    }

    /// Mean radiance over the sphere, for choosing between lights.
    pub fn strength(&self) -> f32 {
        match self {
            Self::Constant(source) => source.strength(),
            Self::Hemisphere(source) => 0.5 * source.strength(),
            Self::Image(image) => (image.mean * image.tint.rgb).element_sum() / 3.0,
        }
    }
}
