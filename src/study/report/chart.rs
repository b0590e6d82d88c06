//! Where the time of each frame went, and how the frames' times are distributed.

use super::canvas::{Anchor, Canvas, Color, FAINT, INK};
use crate::batch::Row;
use crate::study::number::{round_step, ten_digits};

/// The parts of [`Row::parts`], in that order. Okabe & Ito 2008, "Color Universal Design": told apart by everyone.
pub const COLORS: [Color; 6] =
    [[153, 153, 153], [230, 159, 0], [204, 121, 167], [86, 180, 233], [0, 158, 115], [213, 94, 0]];

const SIZE: [u32; 2] = [1080, 420];
/// Edges of the bars, and of the distribution to their right, pixels.
const LEFT: f64 = 84.0;
const MIDDLE: f64 = 880.0;
const RIGHT: f64 = 1064.0;
const TOP: f64 = 56.0;
const BOTTOM: f64 = 360.0;
const BINS: usize = 24;

/// Bars of seconds, one per frame, stacked by part; to the right how many frames fall into each span of seconds, on the same
/// scale. A bar that is much longer than the others, as that of a first frame that loads, is cut and says its length.
pub fn draw(rows: &[&Row]) -> Canvas {
    let mut canvas = Canvas::new(SIZE[0], SIZE[1]);
    let done: Vec<&Row> = rows.iter().copied().filter(|row| row.is_ok()).collect();
    legend(&mut canvas);
    let (Some(first), Some(last)) = (done.first(), done.last()) else {
        canvas.text([0.5 * f64::from(SIZE[0]), 200.0], Anchor::Middle, "no frame is done");
        return canvas;
    };
    let mut times: Vec<f64> = done.iter().map(|row| row.total_s).collect();
    times.sort_by(f64::total_cmp);
    let usual = times[(times.len() - 1) * 9 / 10];
    let longest = times.last().copied().unwrap_or(usual);
    let top_s = if longest > 1.6 * usual { 1.3 * usual } else { 1.05 * longest }.max(1e-6);
    let height = |seconds: f64| (BOTTOM - TOP) * (seconds / top_s).min(1.0);

    // Draw the scale.
    let step = round_step(top_s, 6.0);
    for tick in 0..=(top_s / step) as usize {
        let y = BOTTOM - height(tick as f64 * step);
        canvas.rect([LEFT, y], [RIGHT - LEFT, 1.0], FAINT);
        canvas.text([LEFT - 8.0, y], Anchor::End, ten_digits(tick as f64 * step));
    }
    canvas.text([LEFT - 8.0, TOP - 24.0], Anchor::End, "s");

    // Stack the bars.
    let span = f64::from(last.frame - first.frame) + 1.0;
    let pitch = (MIDDLE - LEFT) / span;
    let gap = if pitch > 4.0 { 1.0 } else { 0.0 };
    for row in &done {
        let x = LEFT + f64::from(row.frame - first.frame) * pitch;
        let mut below_s = 0.0;
        for ((_, seconds), color) in row.parts().into_iter().zip(COLORS) {
            let (low, high) = (height(below_s), height(below_s + seconds));
            canvas.rect([x, BOTTOM - high], [pitch - gap, high - low], color);
            below_s += seconds;
        }
        if row.total_s > top_s {
            canvas.text([x + 0.5 * pitch, TOP - 10.0], Anchor::Start, format!("{:.1}", row.total_s));
        }
    }
    let every = round_step(span, 8.0).max(1.0);
    for number in (0..=last.frame).filter(|n| *n >= first.frame && n % every as u32 == 0) {
        let x = LEFT + (f64::from(number - first.frame) + 0.5) * pitch;
        canvas.text([x, BOTTOM + 18.0], Anchor::Middle, number.to_string());
    }
    canvas.text([0.5 * (LEFT + MIDDLE), BOTTOM + 42.0], Anchor::Middle, "frame");

    // Count the frames in each span of seconds.
    let mut counts = [0usize; BINS];
    for seconds in times.iter().filter(|seconds| **seconds <= top_s) {
        counts[((seconds / top_s * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(1).max(1);
    let bin = (BOTTOM - TOP) / BINS as f64;
    for (number, count) in counts.into_iter().enumerate().filter(|(_, count)| *count > 0) {
        let length = (RIGHT - MIDDLE - 16.0) * count as f64 / most as f64;
        canvas.rect([MIDDLE + 16.0, BOTTOM - (number as f64 + 1.0) * bin], [length, bin - 1.0], INK);
    }
    canvas.text([0.5 * (MIDDLE + 16.0 + RIGHT), BOTTOM + 18.0], Anchor::Middle, format!("0 to {most}"));
    canvas.text([0.5 * (MIDDLE + 16.0 + RIGHT), BOTTOM + 42.0], Anchor::Middle, "frames");
    canvas
}

fn legend(canvas: &mut Canvas) {
    let mut x = LEFT;
    for ((name, _), color) in Row::default().parts().into_iter().zip(COLORS) {
        canvas.rect([x, 12.0], [14.0, 14.0], color);
        canvas.text([x + 22.0, 19.0], Anchor::Start, name);
        x += 46.0 + 12.0 * name.len() as f64;
    }
}
