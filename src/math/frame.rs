//! The shading frame: an orthonormal basis whose z axis is the surface normal.

use glam::Vec3;

#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub tangent: Vec3,
    pub bitangent: Vec3,
    pub normal: Vec3,
}

impl Frame {
    /// A frame around a unit normal, continuous except at the south pole.
    /// Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
    #[inline]
    pub fn new(normal: Vec3) -> Self {
        let sign = 1.0f32.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.normal))
    }

    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_invertible() {
        for normal in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(0.6, -0.48, 0.64), Vec3::new(1e-4, 0.0, -1.0).normalize()]
        {
            let frame = Frame::new(normal);
            assert!(frame.tangent.dot(frame.bitangent).abs() < 1e-6);
            assert!((frame.tangent.cross(frame.bitangent) - normal).length() < 1e-5);
            let v = Vec3::new(0.3, -0.7, 0.2);
            assert!((frame.to_world(frame.to_local(v)) - v).length() < 1e-5);
        }
    }
}
