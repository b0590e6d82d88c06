//! Rays and hits, and how they look to Embree.

use glam::Vec3;

use super::layout::{INVALID_ID, LEVELS, RTCHit, RTCRay, RTCRayHit};

/// Of its length, what a ray between two points leaves out at its end.
pub(super) const GAP: f32 = 1e-4;

/// The points `origin + t * dir` with t in `tnear..=tfar`. `dir` need not have unit length: t counts in its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin: Vec3,
    pub dir: Vec3,
    /// Finite and not negative.
    pub tnear: f32,
    /// May be infinite.
    pub tfar: f32,
}

impl Ray {
    /// In place of a ray where there is none.
    pub const NONE: Self = Self { origin: Vec3::ZERO, dir: Vec3::Z, tnear: 0.0, tfar: 0.0 };

    /// The half line from `origin`.
    #[inline]
    pub fn new(origin: Vec3, dir: Vec3) -> Self {
        Self { origin, dir, tnear: 0.0, tfar: f32::INFINITY }
    }

    /// From one point to shortly before another, neither on what it could wrongly be stopped by: leave both surfaces first.
    #[inline]
    pub fn between(from: Vec3, to: Vec3) -> Self {
        let way = to - from;
        let length = way.length();
        Self { tfar: length * (1.0 - GAP), ..Self::new(from, way * (1.0 / length)) }
    }

    /// The point at `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.dir
    }

    /// True when Embree may see the ray: finite origin and direction, `tnear` finite, `tfar` not NaN.
    #[inline]
    pub fn is_finite(&self) -> bool {
        // x * 0 is 0 for finite x and NaN otherwise: three vector operations and no branch.
        let zero = self.origin * 0.0 + self.dir * 0.0;
        (zero.x + zero.y + zero.z + self.tnear * 0.0 == 0.0) & !self.tfar.is_nan()
    }

    #[inline]
    pub(super) fn raw(&self) -> RTCRay {
        RTCRay {
            org_x: self.origin.x,
            org_y: self.origin.y,
            org_z: self.origin.z,
            tnear: self.tnear,
            dir_x: self.dir.x,
            dir_y: self.dir.y,
            dir_z: self.dir.z,
            time: 0.0,
            tfar: self.tfar,
            mask: u32::MAX,
            id: 0,
            flags: 0,
        }
    }

    /// The ray with an empty hit behind it.
    #[inline]
    pub(super) fn query(&self) -> RTCRayHit {
        let hit = RTCHit { geomID: INVALID_ID, instID: [INVALID_ID; LEVELS], ..RTCHit::default() };
        RTCRayHit { ray: self.raw(), hit }
    }
}

/// Where a ray first meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Barycentric: the point is (1 - u - v) v0 + u v1 + v v2. Zero on spheres.
    pub u: f32,
    pub v: f32,
    /// Geometric normal in the *shape's own space*, not normalised, not turned towards the ray. Triangles:
    /// (v1 - v0) x (v2 - v0). Spheres: the vector from the centre to the hit, as long as the radius, which gives the hit
    /// point more exactly than `t` does.
    pub ng: Vec3,
    /// Triangle number; 0 on spheres.
    pub prim: u32,
    /// The directly placed geometry, or 0 in an instance (an instance holds one shape).
    pub geom: u32,
    /// The instance, or `u32::MAX` for a directly placed shape.
    pub instance: u32,
}

impl Hit {
    /// Which placement was hit: the number that [`AccelBuilder::place`](super::AccelBuilder::place) or
    /// [`AccelBuilder::place_instance`](super::AccelBuilder::place_instance) returned.
    #[inline]
    pub fn place(&self) -> u32 {
        if self.instance == INVALID_ID { self.geom } else { self.instance }
    }

    /// Reads the answer to [`Ray::query`].
    #[inline]
    pub(super) fn from_raw(query: &RTCRayHit) -> Option<Self> {
        let hit = &query.hit;
        (hit.geomID != INVALID_ID).then(|| Self {
            t: query.ray.tfar,
            u: hit.u,
            v: hit.v,
            ng: Vec3::new(hit.Ng_x, hit.Ng_y, hit.Ng_z),
            prim: hit.primID,
            geom: hit.geomID,
            instance: hit.instID[0],
        })
    }
}
