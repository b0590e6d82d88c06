//! Polygons to triangles: a fan where the polygon is convex, ear clipping where it is not, bridges to holes.

use glam::{DVec2, Vec3};

/// Corners above which a concave polygon is not clipped: ear clipping takes quadratic time and more.
const EAR_CLIPPING_LIMIT: usize = 2000;

/// Triangulates one polygon. Triangles are triples of indices into `points`, with the polygon's orientation.
/// Fewer than three points give nothing.
pub fn triangulate(points: &[Vec3], out: &mut Vec<[usize; 3]>) {
    if points.len() == 3 {
        out.push([0, 1, 2]);
        return;
    }
    let flat = flatten(points, newell(points));
    let ring: Vec<usize> = (0..points.len()).collect();
    clip(&flat, ring, out);
}

/// A polygon with holes: `loops[0]` is the outline, each loop a range of `points`.
pub fn triangulate_with_holes(points: &[Vec3], loops: &[std::ops::Range<usize>], out: &mut Vec<[usize; 3]>) {
    let Some((outline, holes)) = loops.split_first() else { return };
    let flat = flatten(points, newell(&points[outline.clone()]));
    let mut ring: Vec<usize> = outline.clone().collect();
    let mut holes: Vec<Vec<usize>> =
        holes.iter().filter(|hole| hole.len() >= 3).map(|hole| hole.clone().collect()).collect();
    for hole in &mut holes {
        // A hole runs against the outline.
        if area(&flat, hole) > 0.0 {
            hole.reverse();
        }
        let rightmost = (0..hole.len()).max_by(|&a, &b| flat[hole[a]].x.total_cmp(&flat[hole[b]].x)).unwrap_or(0);
        hole.rotate_left(rightmost);
    }
    // From right to left, so that a bridge never has to cross a hole that is still to come.
    holes.sort_by(|a, b| flat[b[0]].x.total_cmp(&flat[a[0]].x));
    for hole in holes {
        bridge(&flat, &mut ring, &hole);
    }
    clip(&flat, ring, out);
}

/// Twice the area vector of a closed polygon (Newell's method).
pub fn newell(points: &[Vec3]) -> Vec3 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).fold(Vec3::ZERO, |sum, (&a, &b)| sum + (a - points[0]).cross(b - points[0]))
}

/// Drops the axis in which the polygon is seen largest, keeping its orientation counterclockwise.
fn flatten(points: &[Vec3], normal: Vec3) -> Vec<DVec2> {
    let size = normal.abs();
    points
        .iter()
        .map(|point| {
            let point = point.as_dvec3();
            if size.x >= size.y && size.x >= size.z {
                DVec2::new(point.y, point.z * f64::from(normal.x.signum()))
            } else if size.y >= size.z {
                DVec2::new(point.z, point.x * f64::from(normal.y.signum()))
            } else {
                DVec2::new(point.x, point.y * f64::from(normal.z.signum()))
            }
        })
        .collect()
}

fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn area(flat: &[DVec2], ring: &[usize]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(&a, &b)| flat[a].perp_dot(flat[b])).sum()
}

fn clip(flat: &[DVec2], mut ring: Vec<usize>, out: &mut Vec<[usize; 3]>) {
    if ring.len() < 3 {
        return;
    }
    let corner = |ring: &[usize], i: usize| {
        let n = ring.len();
        [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]]
    };
    let is_turn = |[a, b, c]: [usize; 3], sign: f64| sign * turn(flat[a], flat[b], flat[c]) > 0.0;
    let convex = (0..ring.len()).all(|i| !is_turn(corner(&ring, i), -1.0));
    if convex || ring.len() > EAR_CLIPPING_LIMIT {
        out.extend((1..ring.len() - 1).map(|i| [ring[0], ring[i], ring[i + 1]]));
        return;
    }
    let mut at = 0;
    while ring.len() > 3 {
        let n = ring.len();
        let is_ear = |i: usize| {
            let [a, b, c] = corner(&ring, i);
            is_turn([a, b, c], 1.0) && !ring.iter().any(|&p| blocks(flat, p, [a, b, c]))
        };
        // No ear at all happens only in polygons that cross themselves: any corner keeps the count of triangles right.
        let ear = (0..n).map(|step| (at + step) % n).find(|&i| is_ear(i)).unwrap_or(at % n);
        out.push(corner(&ring, ear));
        ring.remove(ear);
        at = if ear == 0 { ring.len() - 1 } else { ear - 1 };
    }
    out.push([ring[0], ring[1], ring[2]]);
}

/// Whether point `p` lies in the triangle; its own corners, and bridge copies of them, do not count.
fn blocks(flat: &[DVec2], p: usize, [a, b, c]: [usize; 3]) -> bool {
    let (point, a, b, c) = (flat[p], flat[a], flat[b], flat[c]);
    point != a
        && point != b
        && point != c
        && turn(a, b, point) >= 0.0
        && turn(b, c, point) >= 0.0
        && turn(c, a, point) >= 0.0
}

/// Cuts the ring open at the nearest corner that sees the hole's first corner, and runs around the hole.
fn bridge(flat: &[DVec2], ring: &mut Vec<usize>, hole: &[usize]) {
    let from = flat[hole[0]];
    let crosses = |to: DVec2| {
        let n = ring.len();
        (0..n).any(|i| {
            let (a, b) = (flat[ring[i]], flat[ring[(i + 1) % n]]);
            let touches = a == to || b == to || a == from || b == from;
            !touches && turn(from, to, a) * turn(from, to, b) < 0.0 && turn(a, b, from) * turn(a, b, to) < 0.0
        })
    };
    let distance = |i: &usize| flat[ring[*i]].distance_squared(from);
    let mut order: Vec<usize> = (0..ring.len()).collect();
    order.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let Some(at) = order.iter().copied().find(|&i| !crosses(flat[ring[i]])).or(order.first().copied()) else { return };
    let detour: Vec<usize> = hole.iter().copied().chain([hole[0], ring[at]]).collect();
    ring.splice(at + 1..at + 1, detour);
}
