//! Normals: smooth ones from the faces, and repair of those that a file leaves at zero.

use glam::{DVec3, Vec3};

/// Twice the area vector of a triangle, in double precision so that tiny triangles keep theirs.
pub fn area_vector([a, b, c]: [Vec3; 3]) -> DVec3 {
    let a = a.as_dvec3();
    (b.as_dvec3() - a).cross(c.as_dvec3() - a)
}

/// Unit normal, or zero for a triangle without area.
pub fn face_normal(corners: [Vec3; 3]) -> Vec3 {
    area_vector(corners).normalize_or_zero().as_vec3()
}

/// Area-weighted mean of the faces around each of `count` points. Triangles index the points.
pub fn smooth(points: &[Vec3], triangles: impl Iterator<Item = [usize; 3]>) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; points.len()];
    for triangle in triangles {
        let area = area_vector(triangle.map(|corner| points[corner]));
        for corner in triangle {
            sums[corner] += area;
        }
    }
    sums.into_iter().map(|sum| sum.normalize_or_zero().as_vec3()).collect()
}

/// Makes all normals unit length. Those without direction become the mean of the faces around the vertex; returns how
/// many.
pub fn repair(normals: &mut [Vec3], points: &[Vec3], triangles: &[[u32; 3]]) -> usize {
    let mut broken = 0;
    for normal in normals.iter_mut() {
        *normal = normal.as_dvec3().try_normalize().map_or(Vec3::ZERO, |unit| unit.as_vec3());
        broken += usize::from(*normal == Vec3::ZERO);
    }
    if broken > 0 {
        let geometric = smooth(points, triangles.iter().map(|triangle| triangle.map(|corner| corner as usize)));
        for (normal, geometric) in normals.iter_mut().zip(geometric) {
            if *normal == Vec3::ZERO {
                // A vertex that no face uses takes any direction.
                *normal = if geometric == Vec3::ZERO { Vec3::Z } else { geometric };
            }
        }
    }
    broken
}
