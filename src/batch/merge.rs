//! Putting the parts of a still together: the same bits as one render of all samples.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::part::{Part, PartHeader};
use crate::error::Error;
use crate::render::{self, Accumulation};

/// Parts that belong together, in the order of their samples.
pub struct Merge {
    paths: Vec<PathBuf>,
    /// Of the first part, with the samples and costs of all.
    pub header: PartHeader,
    /// Samples per pixel that the parts hold together.
    pub spp: u32,
}

impl Merge {
    /// Reads the parts' headers. All must have the same settings, and no two the same samples; unless `partial`, they must
    /// hold all of them. The picture may take `max_memory` bytes.
    ///
    /// # Errors
    /// Parts that do not belong together, each with the fix; a picture too large for the memory.
    pub fn plan(paths: &[PathBuf], partial: bool, max_memory: u64) -> Result<Self, Error> {
        let mut parts = Vec::new();
        for path in paths {
            parts.push((path, Part::open(path)?.header));
        }
        parts.sort_by_key(|(_, header)| (header.samples.start, header.samples.end));
        let Some((first_path, first)) = parts.first() else {
            return Err(Error::Usage("there are no parts to merge".to_owned()));
        };
        render::check_memory(first.settings.size, false, max_memory)?;
        for (path, header) in &parts {
            if let Some((name, ours, theirs)) = first.settings.difference(&header.settings) {
                return Err(Error::Usage(format!(
                    "{} and {} are not parts of one picture: {name} is {ours} there, {theirs} here; render one of them again with the settings of the other",
                    first_path.display(),
                    path.display()
                )));
            }
        }
        let mut missing = Vec::new();
        let (mut end, mut last) = (0, *first_path);
        for (path, header) in &parts {
            let Range { start, end: next } = header.samples;
            if start < end {
                return Err(Error::Usage(format!(
                    "{} and {} both hold the samples {start}:{}; leave one of them out, or render it again with other --samples",
                    last.display(),
                    path.display(),
                    end.min(next)
                )));
            }
            if start > end {
                missing.push(end..start);
            }
            (end, last) = (next, path);
        }
        if end < first.settings.spp {
            missing.push(end..first.settings.spp);
        }
        if !(partial || missing.is_empty()) {
            let ranges: Vec<String> =
                missing.iter().map(|gap| format!("--samples {}:{}", gap.start, gap.end)).collect();
            return Err(Error::Usage(format!(
                "samples are missing: render {} as well, or add --partial to merge what is there",
                ranges.join(" and ")
            )));
        }
        let spp = parts.iter().map(|(_, header)| header.samples.end - header.samples.start).sum();
        Ok(Self { header: first.clone(), spp, paths: parts.into_iter().map(|(path, _)| path.clone()).collect() })
    }

    /// Adds everything up, one part in memory at a time; `tell` hears of each file before it is read.
    ///
    /// # Errors
    /// A part that is damaged or cut short.
    pub fn run(&self, mut tell: impl FnMut(&Path)) -> Result<Accumulation, Error> {
        let mut sums = self.header.settings.accumulation(0..self.spp);
        for path in &self.paths {
            tell(path);
            Part::open(path)?.add_to(&mut sums)?;
        }
        Ok(sums)
    }
}
