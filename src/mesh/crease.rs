//! Normals for corners that have none: the mean of the faces around a point that meet at a blunt angle.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::normals::area_vector;
use super::soup::{ABSENT, WIDTH};

/// Faces whose normals differ by more than this keep the edge between them: a cylinder of twelve sides looks round, a cube
/// does not.
const CREASE_DEG: f64 = 40.0;

/// Faces around a point above which all are averaged: comparing each with each takes quadratic time.
const MOST_COMPARED: usize = 1024;

/// Gives each corner without a normal one, appended to `normals`. `corners` holds [`WIDTH`] indices each; no triangle is
/// without area.
pub fn fill(points: &[Vec3], normals: &mut Vec<Vec3>, corners: &mut [u32]) {
    if corners.chunks_exact(WIDTH).all(|corner| corner[1] != ABSENT) {
        return;
    }
    let welded = weld(points);
    let around = Around::new(&welded, corners);
    let area = |triangle: usize, corners: &[u32]| {
        area_vector([0, 1, 2].map(|corner| points[corners[WIDTH * (3 * triangle + corner)] as usize]))
    };
    let cos_crease = (CREASE_DEG / 180.0 * PI).cos();
    let (mut areas, mut units): (Vec<DVec3>, Vec<DVec3>) = (Vec::new(), Vec::new());
    let mut own: Vec<(DVec3, u32)> = Vec::new();
    for point in 0..points.len() {
        let here = around.corners(point);
        if here.iter().all(|&corner| corners[WIDTH * corner as usize + 1] != ABSENT) {
            continue;
        }
        areas.clear();
        areas.extend(here.iter().map(|&corner| area(corner as usize / 3, corners)));
        units.clear();
        units.extend(areas.iter().map(|area| area.normalize_or_zero()));
        own.clear();
        for (&corner, unit) in here.iter().zip(&units) {
            let index = &mut corners[WIDTH * corner as usize + 1];
            if *index != ABSENT {
                continue;
            }
            let joins = |(_, other): &(&DVec3, &DVec3)| here.len() > MOST_COMPARED || unit.dot(**other) >= cos_crease;
            let sum: DVec3 = areas.iter().zip(&units).filter(joins).map(|(area, _)| *area).sum();
            // The same faces give the same sum to the last bit: the corner shares its vertex with theirs.
            *index = match own.iter().find(|(known, _)| *known == sum) {
                Some(&(_, known)) => known,
                None => {
                    let number = normals.len() as u32;
                    let fallback = if *unit == DVec3::ZERO { DVec3::Y } else { *unit };
                    normals.push(sum.try_normalize().unwrap_or(fallback).as_vec3());
                    own.push((sum, number));
                    number
                }
            };
        }
    }
}

/// For each point the first one in the same place: many files repeat points where textures or faces part.
fn weld(points: &[Vec3]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(points.len());
    let place = |point: &Vec3| (*point + Vec3::ZERO).to_array().map(f32::to_bits);
    (0..).zip(points).map(|(number, point)| *first.entry(place(point)).or_insert(number)).collect()
}

/// The corners around each point.
struct Around {
    /// Where each point's corners begin; one more at the end.
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl Around {
    fn new(welded: &[u32], corners: &[u32]) -> Self {
        let mut starts = vec![0u32; welded.len() + 1];
        let point = |corner: &[u32]| welded[corner[0] as usize] as usize;
        corners.chunks_exact(WIDTH).for_each(|corner| starts[point(corner) + 1] += 1);
        (0..welded.len()).for_each(|i| starts[i + 1] += starts[i]);
        let mut next = starts.clone();
        let mut sorted = vec![0; corners.len() / WIDTH];
        for (number, corner) in (0..).zip(corners.chunks_exact(WIDTH)) {
            let slot = &mut next[point(corner)];
            sorted[*slot as usize] = number;
            *slot += 1;
        }
        Self { starts, corners: sorted }
    }

    fn corners(&self, point: usize) -> &[u32] {
        &self.corners[self.starts[point] as usize..self.starts[point + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals_of(points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
        let mut corners: Vec<u32> = triangles.iter().flatten().flat_map(|&point| [point, ABSENT, ABSENT]).collect();
        let mut normals = Vec::new();
        fill(points, &mut normals, &mut corners);
        corners.chunks_exact(WIDTH).map(|corner| normals[corner[1] as usize]).collect()
    }

    /// Two squares along the x axis that meet at an angle.
    fn fold(degrees: f32) -> Vec<Vec3> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let points = [(0.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)];
        let mut points: Vec<Vec3> = points.into_iter().map(Vec3::from).collect();
        points.extend([Vec3::new(1.0, cos, -sin), Vec3::new(0.0, cos, -sin)]);
        normals_of(&points, &[[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]])
    }

    #[test]
    fn blunt_edges_are_smooth_and_sharp_ones_are_kept() {
        let blunt = fold(30.0);
        // Areas are equal, so that the normal on the edge halves the angle... but for the corner that has two triangles.
        assert!(blunt[2].dot(Vec3::Z) < 0.999 && blunt[2].dot(Vec3::Z) > 30f32.to_radians().cos());
        assert_eq!(blunt[0], Vec3::Z);
        assert!(fold(60.0)[..6].iter().all(|normal| normal.abs_diff_eq(Vec3::Z, 1e-6)));
    }

    #[test]
    fn points_that_are_repeated_are_one() {
        let corner = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ZERO, Vec3::Y, Vec3::new(-1.0, 0.0, 0.2)];
        let normals = normals_of(&corner, &[[0, 1, 2], [3, 4, 5]]);
        assert_eq!(normals[0], normals[3]);
        assert_ne!(normals[0], normals[1]);
    }

    #[test]
    fn a_fan_of_many_faces_takes_no_quadratic_time() {
        let rim = 200_000;
        let mut points = vec![Vec3::Y];
        points.extend((0..rim).map(|i| {
            let (sin, cos) = (i as f32 / rim as f32 * std::f32::consts::TAU).sin_cos();
            Vec3::new(sin, 0.0, cos)
        }));
        let triangles: Vec<[u32; 3]> = (0..rim).map(|i| [0, 1 + i, 1 + (i + 1) % rim]).collect();
        let start = std::time::Instant::now();
        let normals = normals_of(&points, &triangles);
        assert!(normals[0].dot(Vec3::Y) > 0.999);
        assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    }
}
