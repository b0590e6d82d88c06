//! The CIE 1931 2 degree observer and linear sRGB.

use std::sync::LazyLock;

use super::table::{self, Row};

/// First and last wavelength of every spectral integral in the program, in nm. What lies outside changes colours by less
/// than 0.02 CIEDE2000.
pub const MIN_NM: f64 = 380.0;
pub const MAX_NM: f64 = 780.0;
/// Number of 1 nm steps between them; the integrals use STEPS + 1 samples.
pub const STEPS: usize = 400;

/// Colour-matching functions at 1 nm, 360..830 nm.
static OBSERVER: LazyLock<Vec<Row<3>>> = LazyLock::new(|| table::parse(include_str!("../../data/cie_1931_2deg.csv")));

/// Chromaticities of the sRGB primaries, Rec. ITU-R BT.709.
const PRIMARIES_XY: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];
/// Cone responses of XYZ, Bradford (Lam 1985).
const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

pub type Vector = [f64; 3];
pub type Matrix = [[f64; 3]; 3];

/// Colour-matching functions (x, y, z) at a wavelength in nm; the end values outside 360..830 nm.
pub fn observer(nm: f64) -> Vector {
    table::interpolate(&OBSERVER, nm)
}

/// XYZ of a spectrum, summed at 1 nm over 380..780 nm and scaled so that Y of `white` is 1.
pub fn xyz(spectrum: impl Fn(f64) -> f64, white: impl Fn(f64) -> f64) -> Vector {
    let (mut sum, mut luminance) = ([0.0; 3], 0.0);
    for step in 0..=STEPS {
        let nm = MIN_NM + step as f64;
        let matching = observer(nm);
        let power = spectrum(nm);
        sum = std::array::from_fn(|i| sum[i] + power * matching[i]);
        luminance += white(nm) * matching[1];
    }
    sum.map(|value| value / luminance)
}

/// XYZ (Y of the white = 1) to linear sRGB, for the white point `white`, which becomes exactly (1, 1, 1).
pub fn srgb_matrix(white: Vector) -> Matrix {
    let primaries: [Vector; 3] = PRIMARIES_XY.map(|[x, y]| [x / y, 1.0, (1.0 - x - y) / y]);
    let to_xyz = transpose(primaries);
    let scale = apply(invert(to_xyz), white);
    invert(to_xyz.map(|row| std::array::from_fn(|i| row[i] * scale[i])))
}

/// Bradford adaptation of XYZ from one white to another.
pub fn adapt(from: Vector, to: Vector) -> Matrix {
    let (from, to) = (apply(BRADFORD, from), apply(BRADFORD, to));
    let scaled = std::array::from_fn(|i| BRADFORD[i].map(|value| value * to[i] / from[i]));
    multiply(invert(BRADFORD), scaled)
}

pub fn apply(matrix: Matrix, v: Vector) -> Vector {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

pub fn multiply(a: Matrix, b: Matrix) -> Matrix {
    let columns = transpose(b).map(|column| apply(a, column));
    transpose(columns)
}

fn transpose(m: Matrix) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| m[column][row]))
}

/// Inverse by cofactors; the matrices here are far from singular.
pub fn invert(m: Matrix) -> Matrix {
    let cofactor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| m[0][c] * cofactor(0, c)).sum();
    std::array::from_fn(|row| std::array::from_fn(|column| cofactor(column, row) / determinant))
}
