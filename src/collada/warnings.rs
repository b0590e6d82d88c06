//! What the loader noticed and went on from.

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

use super::xml::{Element, Xml};

/// Something in the file that was ignored, replaced or doubtful.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    pub file: PathBuf,
    /// Line of the first place it was met, counted from 1.
    pub line: usize,
    /// What was seen.
    pub seen: String,
    /// What the loader did, or what the author can do.
    pub advice: String,
    /// How many times; equal warnings are merged.
    pub count: usize,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.file.display(), self.line, self.seen)?;
        if self.count > 1 {
            write!(f, " ({} times)", self.count)?;
        }
        write!(f, "; {}", self.advice)
    }
}

/// Collects warnings while the file is read; lines are worked out at the end.
#[derive(Default)]
pub struct Warnings {
    entries: Vec<Entry>,
    known: HashMap<(String, String), usize>,
}

struct Entry {
    offset: usize,
    seen: String,
    advice: String,
    count: usize,
}

impl Warnings {
    pub fn add(&mut self, element: Element, seen: impl Into<String>, advice: impl Into<String>) {
        self.add_many(element, 1, seen, advice);
    }

    /// A warning about `count` things at once, the first of them in `element`.
    pub fn add_many(&mut self, element: Element, count: usize, seen: impl Into<String>, advice: impl Into<String>) {
        let (seen, advice) = (seen.into(), advice.into());
        if let Some(&index) = self.known.get(&(seen.clone(), advice.clone())) {
            self.entries[index].count += count;
            return;
        }
        self.known.insert((seen.clone(), advice.clone()), self.entries.len());
        self.entries.push(Entry { offset: element.offset(), seen, advice, count });
    }

    /// In the order in which they were met.
    pub fn finish(self, file: &Path, xml: &Xml) -> Vec<Warning> {
        // Files may earn as many warnings as they have lines: one look at the text serves all.
        let ends: Vec<usize> = match self.entries.is_empty() {
            true => Vec::new(),
            false => xml.source.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect(),
        };
        let finished = |entry: Entry| Warning {
            file: file.to_owned(),
            line: 1 + ends.partition_point(|&end| end < entry.offset),
            seen: entry.seen,
            advice: entry.advice,
            count: entry.count,
        };
        self.entries.into_iter().map(finished).collect()
    }
}
