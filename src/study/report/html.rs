//! The page: one file that shows everything in any browser, without a network.

use std::fmt::Write;

use crate::batch::frames::Pattern;
use crate::batch::record::Record;
use crate::batch::{Row, Summary};

const STYLE: &str = "\
body{font:15px/1.45 system-ui,sans-serif;color:#282c34;background:#fff;margin:2rem auto;max-width:1100px;padding:0 1rem}\
h1{font-size:1.5rem}h2{font-size:1.15rem;margin-top:2.2rem}svg{max-width:100%;height:auto}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums}td,th{padding:.15rem .6rem;text-align:right;white-space:nowrap}\
th{font-weight:600;border-bottom:1px solid #999;position:sticky;top:0;background:#fff}tr:nth-child(even) td{background:#f5f6f8}\
td:first-child,th:first-child{text-align:left}.sheet{display:flex;flex-wrap:wrap;gap:6px}\
.sheet figure{margin:0;font-size:11px;text-align:center;color:#667}.sheet img{display:block;background:#eee}\
.bad{color:#b00020}.facts td:first-child{color:#667}.scroll{overflow-x:auto}";

/// `chart` is SVG, `pictures` are data URIs by frame.
pub fn page(record: &Record, rows: &[&Row], chart: &str, pictures: &[(u32, String)], pattern: &Pattern) -> String {
    let summary = record.summary();
    let mut page = String::new();
    let mut put = |text: &str| page.push_str(text);
    let title = escape(&pattern.to_string());
    put(&format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title>\n\
         <meta name=\"viewport\" content=\"width=device-width\"><style>{STYLE}</style></head><body>\n<h1>{title}</h1>\n"
    ));
    put(&facts(&summary, rows));
    put("<h2>Seconds per frame</h2>\n");
    put(chart);
    put(&slowest(&summary));
    put(&sheet(rows, pictures, pattern));
    put(&table(rows));
    put(&format!("<p>pellicle {}</p>\n</body></html>\n", env!("CARGO_PKG_VERSION")));
    page
}

fn facts(summary: &Summary, rows: &[&Row]) -> String {
    let mut text = "<table class=\"facts\">\n".to_owned();
    let mut fact = |name: &str, value: String| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "<tr><td>{name}</td><td>{value}</td></tr>");
    };
    fact("frames", format!("{} of {}", summary.done, summary.frames));
    for (name, frames) in [("failed", &summary.failed), ("missing", &summary.missing)] {
        if !frames.is_empty() {
            fact(name, format!("<span class=\"bad\">{frames}</span>"));
        }
    }
    fact("seconds per frame, median", format!("{:.3}", summary.median_s));
    fact("min, p95, max", format!("{:.3}, {:.3}, {:.3}", summary.min_s, summary.p95_s, summary.max_s));
    fact("in all", format!("{:.1} s", summary.total_s));
    fact("beside rendering, writing and loading", format!("{:.2} %", 100.0 * summary.overhead));
    fact("frames that built BVHs; instances moved", format!("{}; {}", summary.bvh_builds, summary.instances_moved));
    fact("materials compiled", summary.materials_compiled.to_string());
    if let Some(row) = rows.iter().find(|row| row.is_ok()) {
        fact(
            "picture",
            format!("{}x{}, {}, seed of frame {}: {}", row.width, row.height, row.mode, row.frame, row.seed),
        );
        fact("machine", format!("{}, {} threads", escape(&row.host), row.threads));
        fact("scene, settings", format!("{}, {}", &row.scene_sha256[..row.scene_sha256.len().min(16)], row.settings));
    }
    text + "</table>\n"
}

fn slowest(summary: &Summary) -> String {
    let mut text =
        "<h2>Slowest</h2>\n<p>With modified z-scores (Iglewicz &amp; Hoaglin 1993): beyond 3.5 a frame is odd.</p>\n\
                    <table><tr><th>frame</th><th>s</th><th>score</th></tr>\n"
            .to_owned();
    for slow in &summary.slowest {
        let class = if slow.score > 3.5 { " class=\"bad\"" } else { "" };
        let _ = writeln!(
            text,
            "<tr{class}><td>{}</td><td>{:.3}</td><td>{:.1}</td></tr>",
            slow.frame, slow.total_s, slow.score
        );
    }
    text + "</table>\n"
}

fn sheet(rows: &[&Row], pictures: &[(u32, String)], pattern: &Pattern) -> String {
    let mut text = "<h2>Frames</h2>\n<div class=\"sheet\">\n".to_owned();
    for (frame, uri) in pictures {
        let row = rows.iter().find(|row| row.frame == *frame);
        let time = row.filter(|row| row.is_ok()).map(|row| format!(", {:.2} s", row.total_s)).unwrap_or_default();
        let path = pattern.path(*frame);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let _ = writeln!(
            text,
            "<figure><a href=\"{0}\"><img src=\"{uri}\" alt=\"frame {frame}\" title=\"{0}{time}\"></a>{frame}</figure>",
            escape(&name)
        );
    }
    text + "</div>\n"
}

fn table(rows: &[&Row]) -> String {
    let mut text =
        "<h2>Table</h2>\n<div class=\"scroll\"><table>\n<tr><th>frame</th><th>at</th><th>spp</th>".to_owned();
    for (name, _) in Row::default().parts() {
        let _ = write!(text, "<th>{name} s</th>");
    }
    text.push_str(
        "<th>total s</th><th>Mrays/s</th><th>noise</th><th>MB</th><th>not finite</th><th>out of gamut</th></tr>\n",
    );
    for row in rows {
        if !row.is_ok() {
            let reason = escape(&row.reason);
            let class = if row.is_failed() { " class=\"bad\"" } else { "" };
            let _ = writeln!(text, "<tr{class}><td>{}</td><td colspan=\"14\">{reason}</td></tr>", row.frame);
            continue;
        }
        let _ = write!(text, "<tr><td>{}</td><td>{:.3}</td><td>{}</td>", row.frame, row.moment, row.spp);
        for (_, seconds) in row.parts() {
            let _ = write!(text, "<td>{seconds:.3}</td>");
        }
        let noise = row.noise.map(|noise| format!("{:.2} %", 100.0 * noise)).unwrap_or_default();
        let _ = writeln!(
            text,
            "<td>{:.3}</td><td>{:.2}</td><td>{noise}</td><td>{:.0}</td><td>{}</td><td>{}</td></tr>",
            row.total_s, row.mrays_per_s, row.peak_rss_mb, row.non_finite, row.out_of_gamut
        );
    }
    text + "</table></div>\n"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
