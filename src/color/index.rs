//! Complex refractive indices n + ik of bases and films.

use std::sync::Arc;

use num_complex::Complex64;
use thiserror::Error;

use super::named;
use super::table::{self, Row};

/// A refractive index as a scene gives it; k >= 0 absorbs.
#[derive(Clone, Debug, PartialEq)]
pub enum Index {
    Constant {
        n: f32,
        k: f32,
    },
    /// One value per colour channel: red, green, blue, taken at 614, 549 and 466 nm.
    Rgb {
        n: [f32; 3],
        k: [f32; 3],
    },
    /// (wavelength in nm, n, k), increasing wavelengths, linear in between.
    Table(Vec<(f32, f32, f32)>),
    /// A material from the measured tables: `Au`, `BK7`, `water`, ...
    Named(String),
}

/// Where a single number stands for a dispersive index: the helium d line, at which glass makers state it, in nm.
pub const NOMINAL_NM: f64 = 587.56;

/// The wavelengths of an RGB triple of indices and of the three-wave film model: red, green, blue, in nm.
pub const CHANNEL_NM: [f64; 3] = [614.0, 549.0, 466.0];

/// A refractive index over wavelength. Cheap to clone.
#[derive(Clone, Debug)]
pub struct IndexCurve(Form);

#[derive(Clone, Debug)]
enum Form {
    Constant(Complex64),
    /// At least one row; linear in between, the end values outside.
    Table(Arc<[Row<2>]>),
}

/// Why an index is not a refractive index.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IndexError {
    #[error("unknown material \"{name}\"{}; known are {}", nearest.as_ref().map(|n| format!(", did you mean \"{n}\"?")).unwrap_or_default(), named::known_index_names().join(", "))]
    Unknown { name: String, nearest: Option<String> },
    #[error("the index table is empty")]
    Empty,
    #[error("wavelengths of an index table must increase: {previous_nm} nm is followed by {nm} nm")]
    NotIncreasing { previous_nm: f64, nm: f64 },
    #[error("n = {n}, k = {k} is not a refractive index: n and k must be finite and not negative, and not both zero")]
    NotAnIndex { n: f64, k: f64 },
}

impl Index {
    /// The index over wavelength.
    ///
    /// # Errors
    /// The name is unknown, a table is empty or unordered, or a value is not an index.
    pub fn curve(&self) -> Result<IndexCurve, IndexError> {
        match self {
            Self::Constant { n, k } => IndexCurve::constant(f64::from(*n), f64::from(*k)),
            Self::Rgb { n, k } => {
                let row = |i: usize| (CHANNEL_NM[i], f64::from(n[i]), f64::from(k[i]));
                IndexCurve::table([row(2), row(1), row(0)])
            }
            Self::Table(rows) => {
                IndexCurve::table(rows.iter().map(|&(nm, n, k)| (f64::from(nm), f64::from(n), f64::from(k))))
            }
            Self::Named(name) => named::curve(name),
        }
    }
}

impl IndexCurve {
    /// The same index at every wavelength.
    ///
    /// # Errors
    /// n or k is negative or not finite, or both are zero.
    pub fn constant(n: f64, k: f64) -> Result<Self, IndexError> {
        check(n, k)?;
        Ok(Self(Form::Constant(Complex64::new(n, k))))
    }

    /// Rows of (wavelength in nm, n, k), linear in between, the end values outside.
    ///
    /// # Errors
    /// No rows, wavelengths that do not increase, or a value that is not an index.
    pub fn table(rows: impl IntoIterator<Item = (f64, f64, f64)>) -> Result<Self, IndexError> {
        let rows: Vec<Row<2>> = rows.into_iter().map(|(nm, n, k)| (nm, [n, k])).collect();
        for &(_, [n, k]) in &rows {
            check(n, k)?;
        }
        for pair in rows.windows(2) {
            // A NaN is neither less nor greater, so it is refused too.
            if pair[0].0.partial_cmp(&pair[1].0) != Some(std::cmp::Ordering::Less) {
                return Err(IndexError::NotIncreasing { previous_nm: pair[0].0, nm: pair[1].0 });
            }
        }
        match rows.first() {
            None => Err(IndexError::Empty),
            Some(first) if rows.iter().all(|row| row.1 == first.1) => Self::constant(first.1[0], first.1[1]),
            Some(_) => Ok(Self(Form::Table(rows.into()))),
        }
    }

    /// n + ik at a wavelength in nm.
    pub fn at(&self, nm: f64) -> Complex64 {
        match &self.0 {
            Form::Constant(index) => *index,
            Form::Table(rows) => {
                let [n, k] = table::interpolate(rows, nm);
                Complex64::new(n, k)
            }
        }
    }

    /// The index where it is the same at every wavelength.
    pub fn as_constant(&self) -> Option<Complex64> {
        match &self.0 {
            Form::Constant(index) => Some(*index),
            Form::Table(_) => None,
        }
    }

    /// The real index over that of a medium around it, by which light bends; exact for constants, else every 5 nm.
    pub fn relative_to(&self, around: &Self) -> Self {
        let ratio = |nm: f64| Complex64::new(self.at(nm).re / around.at(nm).re, 0.0);
        match (self.as_constant(), around.as_constant()) {
            (_, Some(constant)) if constant.re == 1.0 => self.clone(),
            (Some(_), Some(_)) => Self(Form::Constant(ratio(super::MIN_NM))),
            _ => {
                let steps = ((super::MAX_NM - super::MIN_NM) / 5.0) as usize;
                let row = |step: usize| super::MIN_NM + 5.0 * step as f64;
                Self(Form::Table((0..=steps).map(|step| (row(step), [ratio(row(step)).re, 0.0])).collect()))
            }
        }
    }

    /// The largest k over 380..780 nm; 0 is lossless.
    pub fn max_k(&self) -> f64 {
        self.extreme(|index| index.im, f64::max)
    }

    /// The smallest and the largest n over 380..780 nm.
    pub fn range_of_n(&self) -> (f64, f64) {
        (self.extreme(|index| index.re, f64::min), self.extreme(|index| index.re, f64::max))
    }

    /// Linear pieces have their extremes at their ends.
    fn extreme(&self, part: impl Fn(Complex64) -> f64, pick: impl Fn(f64, f64) -> f64) -> f64 {
        let ends = [part(self.at(super::MIN_NM)), part(self.at(super::MAX_NM))];
        let inside: &[Row<2>] = match &self.0 {
            Form::Constant(_) => &[],
            Form::Table(rows) => rows,
        };
        inside
            .iter()
            .filter(|row| (super::MIN_NM..=super::MAX_NM).contains(&row.0))
            .map(|row| part(Complex64::new(row.1[0], row.1[1])))
            .fold(pick(ends[0], ends[1]), pick)
    }
}

fn check(n: f64, k: f64) -> Result<(), IndexError> {
    let good = n.is_finite() && k.is_finite() && n >= 0.0 && k >= 0.0 && n + k > 0.0;
    if good { Ok(()) } else { Err(IndexError::NotAnIndex { n, k }) }
}
