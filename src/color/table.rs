//! Reading and interpolating the tables under `data/`.

/// A wavelength in nm and its values.
pub type Row<const N: usize> = (f64, [f64; N]);

/// The rows of a CSV table. Comments (`#`), the column heads and rows that are not N + 1 numbers are passed over; the tests
/// pin the number of rows of every table that the program carries.
pub fn parse<const N: usize>(csv: &str) -> Vec<Row<N>> {
    csv.lines().filter_map(row).collect()
}

fn row<const N: usize>(line: &str) -> Option<Row<N>> {
    let mut numbers = line.split(',').map(|field| field.trim().parse::<f64>().ok());
    let nm = numbers.next()??;
    let mut values = [0.0; N];
    for value in &mut values {
        *value = numbers.next()??;
    }
    Some((nm, values))
}

/// Linear interpolation; the end values outside the table, zero in an empty one.
pub fn interpolate<const N: usize>(rows: &[Row<N>], nm: f64) -> [f64; N] {
    let above = rows.partition_point(|row| row.0 <= nm);
    let (Some(low), Some(high)) =
        (rows.get(above.saturating_sub(1)), rows.get(above.min(rows.len().saturating_sub(1))))
    else {
        return [0.0; N];
    };
    let span = high.0 - low.0;
    let t = if span > 0.0 { ((nm - low.0) / span).clamp(0.0, 1.0) } else { 0.0 };
    std::array::from_fn(|i| low.1[i] + t * (high.1[i] - low.1[i]))
}
