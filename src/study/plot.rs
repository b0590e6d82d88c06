//! Reflectance and transmittance over wavelength, as an SVG drawing.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::color::{Sensor, view};
use crate::film::{Side, exact};

use super::coating::Coating;
use super::colours::exact_colour;
use super::error::StudyError;
use super::number::{round_step, ten_digits};

/// Pixels of the drawing.
pub const PLOT_SIZE: (u32, u32) = (900, 720);
const LEGEND_WIDTH: u32 = 150;
/// More curves than this cannot be told apart.
pub const MOST_CURVES: usize = 12;
/// Luminance at which a curve stands out from white paper.
const INK: f64 = 0.3;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// R and T of unpolarised light at one angle and thickness.
struct Curve {
    name: String,
    pen: RGBColor,
    reflect: Vec<(f64, f64)>,
    transmit: Vec<(f64, f64)>,
}

/// R above (solid) and T below (dashed) over the wavelengths `nm`, one curve per angle and thickness, in the colour that the
/// film has there under the sensor's white, brightened or darkened to be seen on white.
///
/// # Errors
/// What the drawing library says.
pub fn plot(
    coating: &Coating,
    sensor: &Sensor,
    angles_deg: &[f64],
    thicknesses_nm: &[f64],
    nm: Range<f64>,
) -> Result<String, StudyError> {
    let pairs = angles_deg.iter().flat_map(|&angle| thicknesses_nm.iter().map(move |&nm| (angle, nm)));
    let curves: Vec<Curve> = pairs
        .map(|(angle_deg, thickness_nm)| {
            let angle = format!("{}°", ten_digits(angle_deg));
            let bare = coating.stack.layers.is_empty();
            let name = if bare { angle } else { format!("{angle}, {} nm", ten_digits(thickness_nm)) };
            let pen = pen(exact_colour(coating, angle_deg, thickness_nm, sensor).reflect);
            let cos_i = angle_deg.to_radians().cos();
            let at = |nm: f64| (nm, exact(&coating.stack, Side::Outside, cos_i, thickness_nm, nm).mean());
            // At 1 nm, with the end itself.
            let steps = (nm.end - nm.start).ceil() as usize;
            let samples: Vec<_> = (0..=steps).map(|step| at((nm.start + step as f64).min(nm.end))).collect();
            let reflect = samples.iter().map(|(nm, split)| (*nm, split.reflect)).collect();
            let transmit = samples.iter().map(|(nm, split)| (*nm, split.transmit)).collect();
            Curve { name, pen, reflect, transmit }
        })
        .collect();

    let mut svg = String::new();
    {
        let paper = SVGBackend::with_string(&mut svg, PLOT_SIZE).into_drawing_area();
        paper.fill(&WHITE).map_err(StudyError::drawing)?;
        let page = paper.titled(&coating.label, ("sans-serif", 18)).map_err(StudyError::drawing)?;
        let (panels, margin) = page.split_horizontally(PLOT_SIZE.0 - LEGEND_WIDTH);
        let (upper, lower) = panels.split_vertically(PLOT_SIZE.1 * 3 / 5);
        panel(&upper, "reflectance", &curves, nm.clone(), false)?;
        panel(&lower, "transmittance", &curves, nm, true)?;
        legend(&margin, &curves)?;
        paper.present().map_err(StudyError::drawing)?;
    }
    Ok(svg)
}

fn panel(area: &Area, name: &str, curves: &[Curve], nm: Range<f64>, dashed: bool) -> Result<(), StudyError> {
    let points = |curve: &Curve| if dashed { curve.transmit.clone() } else { curve.reflect.clone() };
    let highest = curves.iter().flat_map(points).map(|point| point.1).fold(1e-3, f64::max);
    // Up to the next line of the mesh.
    let step = round_step(highest, 5.0);
    let top = 1.02 * step * (highest / step - 1e-9).ceil();
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(nm, 0.0..top)
        .map_err(StudyError::drawing)?;
    let mut mesh = chart.configure_mesh();
    mesh.x_desc("wavelength / nm").y_desc(name).y_labels(6).label_style(("sans-serif", 14));
    mesh.axis_desc_style(("sans-serif", 15)).bold_line_style(BLACK.mix(0.15)).light_line_style(TRANSPARENT);
    mesh.x_label_formatter(&|x| ten_digits(*x)).y_label_formatter(&|y| ten_digits(*y));
    mesh.draw().map_err(StudyError::drawing)?;
    for curve in curves {
        let style = curve.pen.stroke_width(2);
        if dashed {
            chart.draw_series(DashedLineSeries::new(points(curve), 8, 5, style)).map_err(StudyError::drawing)?;
        } else {
            chart.draw_series(LineSeries::new(points(curve), style)).map_err(StudyError::drawing)?;
        }
    }
    Ok(())
}

/// Beside the panels, where no curve runs through it.
fn legend(area: &Area, curves: &[Curve]) -> Result<(), StudyError> {
    for (row, curve) in curves.iter().enumerate() {
        let y = 20 + 22 * row as i32;
        let line = PathElement::new([(0, y), (20, y)], curve.pen.stroke_width(3));
        area.draw(&line).map_err(StudyError::drawing)?;
        area.draw(&Text::new(curve.name.as_str(), (28, y - 7), ("sans-serif", 14))).map_err(StudyError::drawing)?;
    }
    Ok(())
}

/// The hue of a linear sRGB colour at a luminance that ink on paper has.
fn pen(rgb: [f64; 3]) -> RGBColor {
    let rgb = rgb.map(|value| value.max(0.0));
    let luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    let gain = if luminance > 0.0 { INK / luminance } else { 0.0 };
    let [r, g, b] = rgb.map(|value| {
        let signal = view::srgb_encode((gain * value).min(1.0) as f32);
        (255.0 * signal).round() as u8
    });
    RGBColor(r, g, b)
}
