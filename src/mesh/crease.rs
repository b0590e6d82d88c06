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
        // All of them, where there are too many to compare.
        let all: Option<DVec3> = (here.len() > MOST_COMPARED).then(|| areas.iter().sum());
        for (&corner, unit) in here.iter().zip(&units) {
            let index = &mut corners[WIDTH * corner as usize + 1];
            if *index != ABSENT {
                continue;
            }
            let joins = |(_, other): &(&DVec3, &DVec3)| unit.dot(**other) >= cos_crease;
            let sum = all.unwrap_or_else(|| areas.iter().zip(&units).filter(joins).map(|(area, _)| *area).sum());
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
