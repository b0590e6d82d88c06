//! Two pictures side by side, in numbers.

use std::fmt;

use serde::Serialize;

use super::metrics::{
    Exposure, Image, MOST_OUTLIERS, Spread, SquaredErrors, ZTest, delta_e_map, flip, squared_errors, z_test,
};

/// Everything that is measured about a picture against a reference of the same size.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    pub width: usize,
    pub height: usize,
    /// Stops by which both were exposed for what follows the squared errors.
    pub exposure_ev: f64,
    #[serde(flatten)]
    pub squared: SquaredErrors,
    /// CIEDE2000 per pixel.
    pub delta_e: Spread,
    pub flip: Spread,
    /// Values that are not numbers, in either picture.
    pub non_finite: usize,
    /// Where both pictures carry variances.
    pub z_test: Option<ZTest>,
}

impl Comparison {
    /// Also gives CIEDE2000 pixel by pixel. `alpha` is the significance of the z-test.
    pub fn new(image: &Image, reference: &Image, exposure: Exposure, alpha: f64) -> (Self, Vec<f64>) {
        let [shown, wanted] = [image, reference].map(|picture| exposure.show(picture));
        let delta_e = delta_e_map(&shown, &wanted);
        let values = image.rgb.iter().chain(&reference.rgb).flatten();
        let comparison = Self {
            width: image.width,
            height: image.height,
            exposure_ev: exposure.stops(),
            squared: squared_errors(image, reference, None),
            delta_e: Spread::of(&delta_e),
            flip: Spread::of(&flip(&shown, &wanted)),
            non_finite: values.filter(|value| !value.is_finite()).count(),
            z_test: z_test(image, reference, alpha),
        };
        (comparison, delta_e)
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{}x{}, exposed by {:+.2} stops", self.width, self.height, self.exposure_ev)?;
        writeln!(f, "MSE             {:.4e}", self.squared.mse)?;
        writeln!(f, "relMSE          {:.4e}", self.squared.rel_mse)?;
        writeln!(f, "relMSE trimmed  {:.4e}", self.squared.trimmed_rel_mse)?;
        for (name, spread) in [("CIEDE2000     ", self.delta_e), ("FLIP          ", self.flip)] {
            let Spread { mean, p99, max } = spread;
            writeln!(f, "{name}  mean {mean:.4}, 99 % within {p99:.4}, worst {max:.4}")?;
        }
        if self.non_finite > 0 {
            writeln!(f, "not numbers     {} values", self.non_finite)?;
        }
        match &self.z_test {
            Some(test) => writeln!(f, "z-test          {test}"),
            None => writeln!(f, "z-test          none: not both pictures have variance layers (render --aov variance)"),
        }
    }
}

impl fmt::Display for ZTest {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { alpha, alpha_of_value, values, outliers, worst_z, mean_z: [r, g, b], mean_p, passed } = self;
        write!(
            f,
            "{} at {alpha}: {outliers} of {values} values beyond p = {alpha_of_value:.1e} (at most {} % may be), worst \
             |z| {worst_z:.1}; mean of the picture z = {r:+.2} {g:+.2} {b:+.2}, p = {mean_p:.2e}",
            if *passed { "same" } else { "DIFFERENT" },
            100.0 * MOST_OUTLIERS,
        )
    }
}
