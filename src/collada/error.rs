//! Scene errors: where, what, the line itself with a pointer, and the name that was probably meant.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::xml::{Element, Xml};

/// Columns of source shown around the place of an error.
const EXCERPT_COLUMNS: usize = 80;

/// Why a scene could not be loaded.
#[derive(Debug, thiserror::Error)]
pub struct SceneError {
    /// The file as it was named by the caller.
    pub file: PathBuf,
    /// Absent when the file could not be read as text at all.
    pub place: Option<Box<Place>>,
    pub message: String,
    /// The nearest valid name, the list of valid names, or the way out.
    pub hint: Option<String>,
}

/// Where in the file an error lies.
#[derive(Debug)]
pub struct Place {
    /// Counted from 1.
    pub line: usize,
    /// In characters, counted from 1.
    pub column: usize,
    /// `COLLADA/library_effects/effect[@id='x']/...`; empty when the XML itself is broken.
    pub element_path: String,
    /// The source line, cropped to about 80 columns.
    pub excerpt: String,
    /// Characters of `excerpt` that the pointer underlines.
    pub pointer: Range<usize>,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            None => write!(f, "{}: {}", self.file.display(), self.message)?,
            Some(place) => {
                write!(f, "{}:{}:{}: {}", self.file.display(), place.line, place.column, self.message)?;
                if !place.element_path.is_empty() {
                    write!(f, "\n  in {}", place.element_path)?;
                }
                let number = place.line.to_string();
                write!(f, "\n  {number} | {}", place.excerpt)?;
                let indent = " ".repeat(place.pointer.start);
                write!(f, "\n  {} | {indent}{}", " ".repeat(number.len()), "^".repeat(place.pointer.len().max(1)))?;
            }
        }
        match &self.hint {
            Some(hint) => write!(f, "\n  {hint}"),
            None => Ok(()),
        }
    }
}

/// An error on its way up: a byte span of the source; line and column are worked out only if it reaches the caller.
#[derive(Debug)]
pub struct Fault {
    pub span: Range<usize>,
    /// Index of the element it belongs to.
    pub element: Option<usize>,
    pub message: String,
    pub hint: Option<String>,
}

impl Fault {
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Adds the nearest of `valid`, or all of them when none is near.
    pub fn suggest<'n>(self, given: &str, valid: impl IntoIterator<Item = &'n str>) -> Self {
        match suggestion(given, valid) {
            Some(hint) => self.hint(hint),
            None => self,
        }
    }

    pub fn locate(self, file: &Path, xml: &Xml) -> SceneError {
        let element_path = self.element.map(|index| Element::new(xml, index).path()).unwrap_or_default();
        let place = Place::of(&xml.source, self.span, element_path);
        SceneError { file: file.to_owned(), place: Some(Box::new(place)), message: self.message, hint: self.hint }
    }
}

impl Place {
    pub fn of(source: &str, span: Range<usize>, element_path: String) -> Self {
        let start = floor_boundary(source, span.start);
        let (line, line_start) = line_at(source, start);
        let rest = source.get(line_start..).unwrap_or_default();
        let text = rest.split('\n').next().unwrap_or_default().trim_end_matches('\r');
        let before = source.get(line_start..start).unwrap_or_default().chars().count();
        let end = floor_boundary(source, span.end.max(start)).min(line_start + text.len());
        let width = source.get(start..end).unwrap_or_default().chars().count().clamp(1, EXCERPT_COLUMNS / 2);
        let (excerpt, shift) = crop(text, before, width);
        let pointer = before + shift.added - shift.removed..before + width + shift.added - shift.removed;
        Self { line, column: before + 1, element_path, excerpt, pointer }
    }
}

/// 1-based line of a byte offset, and where that line begins.
pub fn line_at(source: &str, offset: usize) -> (usize, usize) {
    let before = &source.as_bytes()[..offset.min(source.len())];
    let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
    let start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |position| position + 1);
    (line, start)
}

/// How cropping moved the text, in characters.
struct Shift {
    removed: usize,
    added: usize,
}

/// Keeps the part of a long line around the pointer; tabs become single spaces so that the pointer stays below its text.
fn crop(line: &str, pointer: usize, width: usize) -> (String, Shift) {
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    let length = line.chars().take(pointer + EXCERPT_COLUMNS + 1).count();
    if length <= EXCERPT_COLUMNS {
        return (line.chars().map(plain).collect(), Shift { removed: 0, added: 0 });
    }
    let removed = (pointer + width / 2).saturating_sub(EXCERPT_COLUMNS / 2).min(pointer);
    let mut excerpt = String::new();
    if removed > 0 {
        excerpt.push_str("...");
    }
    let added = excerpt.len();
    excerpt.extend(line.chars().skip(removed).take(EXCERPT_COLUMNS).map(plain));
    if length > removed + EXCERPT_COLUMNS {
        excerpt.push_str("...");
    }
    (excerpt, Shift { removed, added })
}

fn floor_boundary(source: &str, offset: usize) -> usize {
    let mut offset = offset.min(source.len());
    while !source.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}

/// Longer names are not compared: that takes time and memory by the product of their lengths.
const LONGEST_NAME: usize = 100;

/// "did you mean" for one near name, the whole list for none; nothing when there are no names at all.
pub fn suggestion<'n>(given: &str, valid: impl IntoIterator<Item = &'n str>) -> Option<String> {
    let mut valid: Vec<&str> = valid.into_iter().collect();
    valid.sort_unstable();
    valid.dedup();
    let comparable = |name: &&&str| name.len().max(given.len()) <= LONGEST_NAME;
    let nearest = valid
        .iter()
        .filter(comparable)
        .map(|name| (strsim::damerau_levenshtein(&given.to_lowercase(), &name.to_lowercase()), *name))
        .min_by_key(|&(distance, _)| distance);
    match nearest {
        _ if valid.is_empty() => None,
        Some((distance, name)) if distance <= 1 + name.len() / 4 => Some(format!("did you mean `{name}`?")),
        _ => {
            let brief = |name: &&str| format!("`{}`", name.chars().take(LONGEST_NAME).collect::<String>());
            let shown: Vec<String> = valid.iter().take(20).map(brief).collect();
            let more = if valid.len() > 20 { ", ..." } else { "" };
            Some(format!("valid here: {}{more}", shown.join(", ")))
        }
    }
}
