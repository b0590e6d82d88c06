//! Reflectance and transmittance over wavelength, as CSV.

use std::fmt::Write;

use rayon::prelude::*;

use crate::film::{Side, exact};

use super::coating::Coating;
use super::number::ten_digits;

/// One row per angle, thickness and wavelength, in this order; `film::exact` in ten significant digits.
pub fn spectra_csv(coating: &Coating, angles_deg: &[f64], thicknesses_nm: &[f64], wavelengths_nm: &[f64]) -> String {
    let pairs: Vec<(f64, f64)> =
        angles_deg.iter().flat_map(|&angle| thicknesses_nm.iter().map(move |&nm| (angle, nm))).collect();
    let blocks: Vec<String> = pairs
        .into_par_iter()
        .map(|(angle_deg, thickness_nm)| {
            let cos_i = angle_deg.to_radians().cos();
            let place = format!("{},{}", ten_digits(angle_deg), ten_digits(thickness_nm));
            let mut block = String::new();
            for &nm in wavelengths_nm {
                let got = exact(&coating.stack, Side::Outside, cos_i, thickness_nm, nm);
                let values = [nm, got.s.reflect, got.p.reflect, got.s.transmit, got.p.transmit].map(ten_digits);
                // Writing to a String cannot fail.
                let _ = writeln!(block, "{place},{}", values.join(","));
            }
            block
        })
        .collect();
    format!("theta_deg,thickness,lambda_nm,Rs,Rp,Ts,Tp\n{}", blocks.concat())
}
