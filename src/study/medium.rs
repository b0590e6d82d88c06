//! Refractive indices as they are written on the command line: `1.33`, `1.6+0.3i`, `Au`, `@measured.csv`.

use std::fs;

use crate::color::{Index, IndexCurve};

use super::error::StudyError;

/// A medium and what it was called.
#[derive(Clone, Debug)]
pub struct Medium {
    pub label: String,
    pub curve: IndexCurve,
    /// First and last wavelength (nm) of a table from a file; outside them the end values are used.
    pub covers_nm: Option<(f64, f64)>,
}

/// Wavelengths below this are micrometres: nothing here is about X-rays.
const LEAST_NM: f64 = 20.0;

impl Medium {
    /// Reads a number n, a complex number n+ki (k >= 0 absorbs), a name that `color` knows or `air`, or `@FILE.csv`.
    ///
    /// # Errors
    /// What is wrong with the text or with the file, with its line.
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let label = text.trim().to_owned();
        if let Some(file) = label.strip_prefix('@') {
            let csv = fs::read_to_string(file)
                .map_err(|error| StudyError::File { file: file.to_owned(), reason: format!("cannot read: {error}") })?;
            let rows = table(file, &csv)?;
            let covers_nm = rows.first().zip(rows.last()).map(|(first, last)| (first.0, last.0));
            return Ok(Self { curve: IndexCurve::table(rows)?, label, covers_nm });
        }
        let curve = if label.eq_ignore_ascii_case("air") {
            IndexCurve::constant(1.0, 0.0)?
        } else if label.starts_with(|c: char| c.is_ascii_digit() || ".+-".contains(c)) || label.is_empty() {
            let (n, k) = complex(&label).ok_or_else(|| StudyError::NotAnIndex(label.clone()))?;
            if k < 0.0 {
                return Err(StudyError::NegativeK(k));
            }
            IndexCurve::constant(n, k)?
        } else {
            Index::Named(label.clone()).curve()?
        };
        Ok(Self { label, curve, covers_nm: None })
    }
}

/// `1.33`, `1.6+0.3i` or `0.3i`.
fn complex(text: &str) -> Option<(f64, f64)> {
    let Some(sum) = text.strip_suffix('i') else { return Some((text.parse().ok()?, 0.0)) };
    // The sign between the parts: not the first character, and not that of an exponent.
    let bytes = sum.as_bytes();
    let sign = (1..bytes.len()).rev().find(|&at| b"+-".contains(&bytes[at]) && !b"eE".contains(&bytes[at - 1]));
    let (n, k) = sum.split_at(sign.unwrap_or(0));
    let n = if n.is_empty() { 0.0 } else { n.trim().parse().ok()? };
    // A space after the sign is not a part of a number.
    let k: String = k.chars().filter(|c| !c.is_whitespace()).collect();
    Some((n, k.parse().ok()?))
}

/// Rows of (nm, n, k) from lines `lambda_nm,n[,k]`; `#` starts a comment, one line of heads may come first.
fn table(file: &str, csv: &str) -> Result<Vec<(f64, f64, f64)>, StudyError> {
    let mut rows: Vec<(f64, f64, f64)> = Vec::new();
    let mut heads = false;
    for (number, line) in csv.lines().enumerate() {
        let fault = |reason: String| StudyError::Row { file: file.to_owned(), line: number + 1, reason };
        let content = line.split('#').next().unwrap_or_default().trim_start_matches('\u{feff}').trim();
        if content.is_empty() {
            continue;
        }
        let fields: Vec<&str> = content.split(',').map(str::trim).collect();
        if rows.is_empty() && !heads && fields[0].parse::<f64>().is_err() {
            heads = true;
            continue;
        }
        let value = |field: &str| field.parse::<f64>().map_err(|_| fault(format!("`{field}` is not a number")));
        let (nm, n, k) = match fields.as_slice() {
            [nm, n] => (value(nm)?, value(n)?, 0.0),
            [nm, n, k] => (value(nm)?, value(n)?, value(k)?),
            _ => {
                let count = fields.len();
                return Err(fault(format!("{count} columns where lambda_nm,n,k are wanted (k may be left out)")));
            }
        };
        if !(nm.is_finite() && nm >= LEAST_NM) {
            return Err(fault(format!("{nm} is not a wavelength in nm; if these are micrometres, multiply by 1000")));
        }
        IndexCurve::constant(n, k).map_err(|error| fault(error.to_string()))?;
        let previous = rows.last().map_or(0.0, |row| row.0);
        if nm <= previous {
            return Err(fault(format!(
                "wavelengths must increase, but {nm} nm comes after {previous} nm; sort the rows"
            )));
        }
        rows.push((nm, n, k));
    }
    if rows.is_empty() {
        return Err(StudyError::File { file: file.to_owned(), reason: "no rows of lambda_nm,n,k".to_owned() });
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::{complex, table};

    #[test]
    fn complex_numbers_are_read_as_written() {
        for (text, value) in [
            ("1.33", Some((1.33, 0.0))),
            ("1.6+0.3i", Some((1.6, 0.3))),
            ("1.6 + 0.3i", Some((1.6, 0.3))),
            ("1e-3+2.5E-1i", Some((1e-3, 0.25))),
            ("1.6-0.3i", Some((1.6, -0.3))),
            ("2i", Some((0.0, 2.0))),
            ("1.6+i", None),
            ("1.6x", None),
            ("", None),
        ] {
            assert_eq!(complex(text), value, "{text}");
        }
    }

    #[test]
    fn tables_may_have_comments_heads_and_no_k() {
        let rows = table("x", "# gold\nlambda_nm,n,k\n400, 1.5, 2\n\n500,1.4,2.5 # green\n").ok();
        assert_eq!(rows, Some(vec![(400.0, 1.5, 2.0), (500.0, 1.4, 2.5)]));
        assert_eq!(table("x", "400,1.5").ok(), Some(vec![(400.0, 1.5, 0.0)]));
    }
}
