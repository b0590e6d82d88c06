//! Why a model file could not be read, and what in it was passed over.

use std::fmt;
use std::path::{Path, PathBuf};

/// Why a model could not be loaded.
#[derive(Debug, thiserror::Error)]
pub struct MeshError {
    /// The file as it was named by the caller.
    pub file: PathBuf,
    /// Counted from 1; absent in binary data and where the file as a whole is meant.
    pub line: Option<usize>,
    pub message: String,
    /// The way out, where there is one.
    pub hint: Option<String>,
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, "{line}:")?;
        }
        write!(f, " {}", self.message)?;
        match &self.hint {
            Some(hint) => write!(f, "\n  {hint}"),
            None => Ok(()),
        }
    }
}

/// An error on its way up, before the file's name is known.
#[derive(Debug)]
pub struct Fault {
    pub line: Option<usize>,
    pub message: String,
    pub hint: Option<String>,
}

impl Fault {
    pub fn new(message: impl Into<String>) -> Self {
        Self { line: None, message: message.into(), hint: None }
    }

    pub fn at(line: usize, message: impl Into<String>) -> Self {
        Self { line: Some(line), ..Self::new(message) }
    }

    pub fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }

    pub fn locate(self, file: &Path) -> MeshError {
        MeshError { file: file.to_owned(), line: self.line, message: self.message, hint: self.hint }
    }
}

/// Something that was ignored or replaced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    pub file: PathBuf,
    /// Line of the first place it was met, counted from 1; 1 for binary data.
    pub line: usize,
    pub seen: String,
    pub advice: String,
    /// How many times.
    pub count: usize,
}

/// Notes in the order in which they were first met, equal ones counted.
pub struct Notes {
    file: PathBuf,
    list: Vec<Note>,
}

/// Kinds of notes that are kept: a file of nonsense would have one for every line.
const MOST_NOTES: usize = 32;

impl Notes {
    pub fn new(file: &Path) -> Self {
        Self { file: file.to_owned(), list: Vec::new() }
    }

    pub fn add(&mut self, line: usize, count: usize, seen: &str, advice: &str) {
        if let Some(note) = self.list.iter_mut().find(|note| note.seen == seen && note.advice == advice) {
            note.count += count;
        } else if self.list.len() < MOST_NOTES {
            let (file, seen, advice) = (self.file.clone(), seen.to_owned(), advice.to_owned());
            self.list.push(Note { file, line, seen, advice, count });
        }
    }

    pub fn finish(self) -> Vec<Note> {
        self.list
    }
}
