//! `--mode auto`: RGB where it is exact enough for this scene, spectral where it is not, by measurement.

use std::sync::Arc;

use super::still::{StillPlan, built};
use crate::color::{Emission, Index, Lab, delta_e_2000};
use crate::document::{Base, Document};
use crate::error::Error;
use crate::mode::Paired;
use crate::render::{Filter, Frame, Plan, Unwatched, render};
use crate::scene::{Camera, Scene, Stage};

/// The pilot: long side in pixels, samples per pixel, side of the blocks that are compared.
const PILOT_SIDE: u32 = 32;
const PILOT_SPP: u32 = 16;
const BLOCK: u32 = 4;
/// Spread of refraction between 400 and 700 nm at 45 degrees that a picture would show, degrees.
const VISIBLE_SPREAD_DEG: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    Rgb,
    Spectral,
}

/// The transport that this scene needs, and why in a few words.
///
/// Where anything in the scene depends on wavelength, a small pilot carries RGB and 16 wavelengths along the same paths and
/// compares the two pictures. Reflectances that the file gives as RGB count as grey in both: their spectra are anybody's
/// guess, so a difference there would not be an error of RGB. Deterministic: the same scene gives the same answer on every
/// machine.
///
/// # Errors
/// As rendering.
pub fn choose_mode(
    document: &Document,
    plan: &StillPlan,
    stage: &Arc<Stage>,
    camera: &Camera,
) -> Result<(Transport, String), Error> {
    let spread_deg = widest_spread_deg(document);
    if spread_deg > VISIBLE_SPREAD_DEG {
        return Ok((Transport::Spectral, format!("a body spreads colours by {spread_deg:.2} degrees")));
    }
    if !knows_wavelengths(document, stage) {
        return Ok((Transport::Rgb, "nothing in the scene depends on wavelength".to_owned()));
    }
    let error = pilot_error(document, plan, stage, camera)?;
    let tolerance = f64::from(plan.films.tolerance);
    let (transport, compared) =
        if error > tolerance { (Transport::Spectral, "above") } else { (Transport::Rgb, "within") };
    let reason = format!("a pilot finds RGB off by {error:.2} CIEDE2000, {compared} the tolerance of {tolerance}");
    Ok((transport, reason))
}

/// The largest difference of refraction angles over the visible range, at 45 degrees.
fn widest_spread_deg(document: &Document) -> f64 {
    let mut widest = 0.0f64;
    for material in &document.materials {
        let Base::Dielectric { index, .. } = &material.base else { continue };
        let Ok(curve) = index.curve() else { continue };
        let angle_deg = |nm| (std::f64::consts::FRAC_1_SQRT_2 / curve.at(nm).re.max(1.0)).asin().to_degrees();
        widest = widest.max((angle_deg(400.0) - angle_deg(700.0)).abs());
    }
    widest
}

/// True when a film, a measured index or a light's spectrum makes wavelengths matter.
fn knows_wavelengths(document: &Document, stage: &Stage) -> bool {
    let measured = |index: &Index| !matches!(index, Index::Constant { .. });
    let materials = document.materials.iter().any(|material| {
        let base = match &material.base {
            Base::Conductor { index, .. } | Base::Dielectric { index, .. } => measured(index),
            Base::Black | Base::Diffuse { .. } => false,
        };
        base || !material.films.is_empty()
    });
    let mut spectra = stage.spectra.iter().map(|(spectrum, _)| spectrum);
    let first: Option<&Emission> = spectra.next();
    materials || spectra.any(|spectrum| Some(spectrum) != first)
}

/// CIEDE2000 that RGB costs where it is worst: two films that face each other may fill a small part of the picture.
fn pilot_error(document: &Document, plan: &StillPlan, stage: &Arc<Stage>, camera: &Camera) -> Result<f64, Error> {
    let [width, height] = camera.size;
    let scale = PILOT_SIDE as f32 / width.max(height) as f32;
    let side = |pixels: u32| ((pixels as f32 * scale).round() as u32).max(1);
    let camera = camera.resized([side(width), side(height)]);
    let pilot = Plan { spp: PILOT_SPP, seed: 0, filter: Filter::Box, noise: None, ..plan.render };
    let spectral = Scene::<Paired<true>>::new(stage.clone(), &plan.films).map_err(|e| built(document, e))?;
    let rgb = Scene::<Paired<false>>::new(stage.clone(), &plan.films).map_err(|e| built(document, e))?;
    let truth = blocks(&render(&spectral, &camera, &pilot, &Unwatched)?);
    let tried = blocks(&render(&rgb, &camera, &pilot, &Unwatched)?);

    // Expose so that the mean is a mid grey.
    let mean = truth.iter().map(|c| c[1]).sum::<f64>() / truth.len() as f64;
    let exposure = if mean > 0.0 { 0.18 / mean } else { 1.0 };
    let lab = |color: &[f64; 3]| Lab::from_linear_srgb(color.map(|c| (c * exposure).min(1.0)));
    let errors = truth.iter().zip(&tried).map(|(a, b)| delta_e_2000(lab(a), lab(b)));
    Ok(errors.fold(0.0, f64::max))
}

/// Mean colours of square blocks of pixels.
fn blocks(frame: &Frame) -> Vec<[f64; 3]> {
    let (columns, rows) = (frame.width.div_ceil(BLOCK), frame.height.div_ceil(BLOCK));
    let mut sums = vec![([0.0f64; 3], 0u32); (columns * rows) as usize];
    for (i, rgb) in (0u32..).zip(&frame.rgb) {
        let (x, y) = (i % frame.width, i / frame.width);
        let (sum, count) = &mut sums[(y / BLOCK * columns + x / BLOCK) as usize];
        *count += 1;
        for (total, value) in sum.iter_mut().zip(rgb) {
            *total += f64::from(*value);
        }
    }
    sums.into_iter().map(|(sum, count)| sum.map(|c| c / f64::from(count))).collect()
}
