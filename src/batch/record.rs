//! The report as it grows: `frames.csv`, a row appended for each frame, and `frames.json`, the same with a summary.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::frames::{FrameList, Pattern};
use super::row::Row;
use super::summary::Summary;
use crate::error::Error;
use crate::output::{self, OutputError};

/// Least time between two writings of the JSON file before the end.
const JSON_EVERY: Duration = Duration::from_secs(2);

/// The rows of one batch, in the CSV file after every frame.
pub struct Record {
    base: PathBuf,
    scene: String,
    settings: String,
    frames: FrameList,
    /// The last row of each frame with these settings.
    rows: BTreeMap<u32, Row>,
    /// When the JSON file was written last.
    json_at: Option<Instant>,
}

#[derive(Serialize)]
struct Report<'a> {
    version: &'static str,
    scene: &'a str,
    settings: &'a str,
    /// The frames that were asked for.
    wanted: String,
    summary: Summary,
    frames: Vec<&'a Row>,
}

impl Record {
    /// Takes up the report at `base` (`base.csv`, `base.json`). Rows of other settings go, and so do those of the frames
    /// that are `anew`, about to be made; processes that share a folder and its frames see each other's rows.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn open(base: &Path, scene: &str, settings: &str, frames: &FrameList, anew: &FrameList) -> Result<Self, Error> {
        let record = Self {
            base: base.to_owned(),
            scene: scene.to_owned(),
            settings: settings.to_owned(),
            frames: frames.clone(),
            rows: BTreeMap::new(),
            json_at: None,
        };
        let found = record.read();
        let kept: Vec<&Row> = found.iter().filter(|row| record.keeps(row, anew)).collect();
        let path = record.path("csv");
        // Where nothing goes, nothing is written: another process may be appending.
        if kept.len() < found.len() || !record.has_header() {
            let mut text = header();
            kept.iter().for_each(|row| text.push_str(&line(row)));
            output::write_text(&path, &text)?;
        } else {
            output::check_writable(&path)?;
        }
        let rows = kept.into_iter().map(|row| (row.frame, row.clone())).collect();
        Ok(Self { rows, ..record })
    }

    fn keeps(&self, row: &Row, anew: &FrameList) -> bool {
        row.settings == self.settings && anew.0.binary_search(&row.frame).is_err()
    }

    pub fn path(&self, extension: &str) -> PathBuf {
        let mut name = self.base.clone().into_os_string();
        name.push(".");
        name.push(extension);
        name.into()
    }

    pub fn rows(&self) -> impl Iterator<Item = &Row> + Clone {
        self.rows.values()
    }

    pub fn summary(&self) -> Summary {
        Summary::new(&self.frames, self.rows())
    }

    /// Appends a row and flushes it.
    ///
    /// # Errors
    /// What the system says.
    pub fn add(&mut self, row: Row) -> Result<(), Error> {
        let path = self.path("csv");
        append(&path, &line(&row)).map_err(|source| OutputError::Io { task: "append to", path, source })?;
        self.rows.insert(row.frame, row);
        // The whole of it each time would take quadratic time over many small frames.
        if self.json_at.is_some_and(|at| at.elapsed() < JSON_EVERY) {
            return Ok(());
        }
        self.json_at = Some(Instant::now());
        self.write_json()
    }

    /// Adds a row for each of these frames that has none: they are there, but nobody knows what they took.
    ///
    /// # Errors
    /// As [`add`](Self::add).
    pub fn fill(&mut self, there: impl Iterator<Item = u32>, pattern: &Pattern) -> Result<(), Error> {
        for frame in there {
            if self.rows.get(&frame).is_none_or(Row::is_failed) {
                self.add(Row {
                    frame,
                    file: pattern.path(frame).display().to_string(),
                    status: "unrecorded".to_owned(),
                    reason: "the frame is whole; the program ended before it could note the time".to_owned(),
                    settings: self.settings.clone(),
                    ..Row::default()
                })?;
            }
        }
        Ok(())
    }

    /// Takes in what other processes have added meanwhile, and writes everything once more.
    ///
    /// # Errors
    /// What the system says.
    pub fn finish(&mut self) -> Result<(), Error> {
        for row in self.read() {
            if row.settings == self.settings {
                self.rows.insert(row.frame, row);
            }
        }
        self.write_json()
    }

    fn write_json(&self) -> Result<(), Error> {
        let report = Report {
            version: env!("CARGO_PKG_VERSION"),
            scene: &self.scene,
            settings: &self.settings,
            wanted: self.frames.to_string(),
            summary: self.summary(),
            frames: self.rows.values().collect(),
        };
        let mut text = serde_json::to_string_pretty(&report).unwrap_or_default();
        text.push('\n');
        Ok(output::write_text(&self.path("json"), &text)?)
    }

    /// Rows that cannot be read, as the last one after a crash, are left out.
    fn read(&self) -> Vec<Row> {
        let Ok(reader) = csv::ReaderBuilder::new().flexible(true).from_path(self.path("csv")) else {
            return Vec::new();
        };
        reader.into_deserialize().filter_map(Result::ok).collect()
    }

    fn has_header(&self) -> bool {
        fs::read_to_string(self.path("csv")).is_ok_and(|text| text.starts_with(&header()))
    }
}

/// One write, so that rows of several processes do not mix; after a crash in mid-row on a line of its own.
fn append(path: &Path, line: &str) -> std::io::Result<()> {
    let mut file = OpenOptions::new().append(true).read(true).create(true).open(path)?;
    let text = if ends_in_mid_line(&mut file)? { format!("\n{line}") } else { line.to_owned() };
    file.write_all(text.as_bytes())?;
    file.sync_data()
}

fn ends_in_mid_line(file: &mut File) -> std::io::Result<bool> {
    if file.metadata()?.len() == 0 {
        return Ok(false);
    }
    let mut last = [0u8];
    file.seek(SeekFrom::End(-1))?;
    file.read_exact(&mut last)?;
    Ok(last[0] != b'\n')
}

fn line(row: &Row) -> String {
    write(row, false)
}

fn header() -> String {
    let both = write(&Row::default(), true);
    both.lines().next().map(|line| format!("{line}\n")).unwrap_or_default()
}

fn write(row: &Row, with_header: bool) -> String {
    let mut writer = csv::WriterBuilder::new().has_headers(with_header).from_writer(Vec::new());
    // A row is numbers and text: neither this nor writing to memory fails.
    let _ = writer.serialize(row);
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}
