//! The times of all frames in a few numbers.

use serde::Serialize;

use super::frames::FrameList;
use super::row::Row;

/// How many of the slowest frames are named.
const SLOWEST: usize = 5;

/// Seconds are totals per frame, of those frames that are done and recorded.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    pub frames: usize,
    pub done: usize,
    /// In the form that `--frames` reads.
    pub failed: String,
    pub missing: String,
    pub min_s: f64,
    pub median_s: f64,
    pub p95_s: f64,
    pub max_s: f64,
    pub total_s: f64,
    /// Share of the total that was neither rendering nor writing nor loading.
    pub overhead: f64,
    /// Slowest first.
    pub slowest: Vec<Slow>,
    pub bvh_builds: u32,
    pub instances_moved: usize,
    pub materials_compiled: usize,
}

/// A slow frame with its modified z-score, 0.6745 (t - median) / MAD, which an odd frame does not hide by being odd; beyond
/// 3.5 it counts as an outlier. Iglewicz & Hoaglin 1993, "How to Detect and Handle Outliers".
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Slow {
    pub frame: u32,
    pub total_s: f64,
    pub score: f64,
}

impl Summary {
    /// `rows` holds at most one row per frame.
    pub fn new<'a>(wanted: &FrameList, rows: impl Iterator<Item = &'a Row> + Clone) -> Self {
        let in_list = |row: &&Row| wanted.0.binary_search(&row.frame).is_ok();
        let rows = rows.filter(in_list);
        let done: Vec<&Row> = rows.clone().filter(|row| row.is_ok()).collect();
        let failed = FrameList(rows.clone().filter(|row| row.is_failed()).map(|row| row.frame).collect());
        let has_row = |frame: &&u32| !rows.clone().any(|row| row.frame == **frame);
        let missing = FrameList(wanted.0.iter().filter(has_row).copied().collect());
        let mut times: Vec<f64> = done.iter().map(|row| row.total_s).collect();
        times.sort_by(f64::total_cmp);
        let total_s: f64 = times.iter().sum();
        let aside: f64 = done
            .iter()
            .map(|row| row.other_s + if row.bvh_builds == 0 { row.bvh_s + row.materials_s } else { 0.0 })
            .sum();
        Self {
            frames: wanted.0.len(),
            done: rows.clone().filter(|row| !row.is_failed()).count(),
            failed: failed.to_string(),
            missing: missing.to_string(),
            min_s: quantile(&times, 0.0),
            median_s: quantile(&times, 0.5),
            p95_s: quantile(&times, 0.95),
            max_s: quantile(&times, 1.0),
            total_s,
            overhead: if total_s > 0.0 { aside / total_s } else { 0.0 },
            slowest: slowest(&done, &times),
            bvh_builds: done.iter().map(|row| row.bvh_builds).sum(),
            instances_moved: done.iter().map(|row| row.instances_moved).sum(),
            materials_compiled: done.iter().map(|row| row.materials_compiled).sum(),
        }
    }

    /// The closing line of a batch.
    pub fn line(&self) -> String {
        let mut line = format!("{} of {} frames", self.done, self.frames);
        if self.total_s > 0.0 {
            line.push_str(&format!(
                ": {:.2} s in all; a frame takes {:.2} s (min {:.2}, p95 {:.2}, max {:.2}), {:.1} % of it beside rendering, \
                 writing and loading",
                self.total_s,
                self.median_s,
                self.min_s,
                self.p95_s,
                self.max_s,
                100.0 * self.overhead
            ));
        }
        for (frames, what) in [(&self.failed, "failed"), (&self.missing, "missing")] {
            if !frames.is_empty() {
                line.push_str(&format!("; {what}: {frames}"));
            }
        }
        line
    }
}

fn slowest(done: &[&Row], times: &[f64]) -> Vec<Slow> {
    let median = quantile(times, 0.5);
    let mut deviations: Vec<f64> = times.iter().map(|time| (time - median).abs()).collect();
    deviations.sort_by(f64::total_cmp);
    let mad = quantile(&deviations, 0.5);
    let score = |time: f64| if mad > 0.0 { 0.6745 * (time - median) / mad } else { 0.0 };
    let mut slow: Vec<Slow> =
        done.iter().map(|row| Slow { frame: row.frame, total_s: row.total_s, score: score(row.total_s) }).collect();
    slow.sort_by(|a, b| b.total_s.total_cmp(&a.total_s));
    slow.truncate(SLOWEST);
    slow
}

/// Between the neighbours in rank, linearly; 0 of nothing. Hyndman & Fan 1996, definition 7.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    let rank = share * last as f64;
    let (low, high) = (sorted[rank as usize], sorted[(rank as usize + 1).min(last)]);
    low + rank.fract() * (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(times: &[f64]) -> Vec<Row> {
        let row = |(frame, &total_s): (u32, &f64)| Row { frame, total_s, status: "ok".to_owned(), ..Row::default() };
        (0..).zip(times).map(row).collect()
    }

    #[test]
    fn ranks_and_scores() {
        let rows = rows(&[1.0, 2.0, 3.0, 4.0, 10.0]);
        let summary = Summary::new(&FrameList((0..7).collect()), rows.iter());
        assert_eq!((summary.min_s, summary.median_s, summary.max_s, summary.total_s), (1.0, 3.0, 10.0, 20.0));
        // Rank 3.8 of 0..4.
        assert!((summary.p95_s - 8.8).abs() < 1e-12);
        assert_eq!(summary.missing, "5-6");
        // The deviations are 2, 1, 0, 1, 7: their median is 1.
        assert_eq!(summary.slowest[0], Slow { frame: 4, total_s: 10.0, score: 0.6745 * 7.0 });
        assert_eq!(summary.slowest.len(), 5);
    }

    #[test]
    fn nothing_is_nothing() {
        let summary = Summary::new(&FrameList(vec![3]), [].iter());
        assert_eq!((summary.done, summary.median_s, summary.missing.as_str()), (0, 0.0, "3"));
        assert_eq!(summary.line(), "0 of 1 frames; missing: 3");
    }
}
