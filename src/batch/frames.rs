//! Lists of frames as people write them, and the files that the frames go to.

use std::fmt;
use std::path::{Path, PathBuf};

/// Most frames that one list may have.
const MOST_FRAMES: usize = 1_000_000;
/// Digits of a frame's number where the pattern does not say.
const USUAL_DIGITS: usize = 4;

/// Frame numbers, each once, in rising order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameList(pub Vec<u32>);

impl FrameList {
    /// Reads `1-240`, `1..240`, `1,5,10-20x2` (every second one from 10).
    ///
    /// # Errors
    /// What is wrong with which part.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut frames = Vec::new();
        for part in text.split(',') {
            let wrong = || format!("`{part}` is no frame; write them like 1-240 or 1,5,10-20x2");
            let number = |digits: &str| digits.trim().parse::<u32>().map_err(|_| wrong());
            let (range, step) = match part.split_once('x') {
                Some((range, step)) => (range, number(step)?),
                None => (part, 1),
            };
            let (first, last) = match range.split_once("..").or_else(|| range.split_once('-')) {
                Some((first, last)) => (number(first)?, number(last)?),
                None => (number(range)?, number(range)?),
            };
            if first > last || step == 0 {
                return Err(wrong());
            }
            if frames.len() + ((last - first) / step) as usize >= MOST_FRAMES {
                return Err(format!("with `{part}` these are more than {MOST_FRAMES} frames"));
            }
            frames.extend((first..=last).step_by(step as usize));
        }
        frames.sort_unstable();
        frames.dedup();
        Ok(Self(frames))
    }
}

impl fmt::Display for FrameList {
    /// The shortest form that [`FrameList::parse`] reads, without steps.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let runs = self.0.chunk_by(|a, b| a + 1 == *b);
        for (number, run) in runs.enumerate() {
            let comma = if number > 0 { "," } else { "" };
            match run {
                [only] => write!(f, "{comma}{only}")?,
                [first, .., last] => write!(f, "{comma}{first}-{last}")?,
                [] => {}
            }
        }
        Ok(())
    }
}

/// The frames of a ring that are wanted, and how many the whole ring has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ring {
    pub frames: FrameList,
    pub count: u32,
}

impl Ring {
    /// Reads `120` (a ring of 120: frames 0 to 119) or `LIST/120` (some of them).
    ///
    /// # Errors
    /// As [`FrameList::parse`], or a ring without frames.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (list, count) = match text.split_once('/') {
            Some((list, count)) => (Some(list), count),
            None => (None, text),
        };
        let count = match count.trim().parse::<u32>() {
            Ok(count) if count > 0 && count as usize <= MOST_FRAMES => count,
            _ => {
                return Err(format!(
                    "`{count}` is no number of frames; write 120 for a whole ring, 0-9/120 for a part of one"
                ));
            }
        };
        let frames = match list {
            Some(list) => FrameList::parse(list)?,
            None => FrameList((0..count).collect()),
        };
        Ok(Self { frames, count })
    }
}

/// Where the frames go: `folder/name.####.png`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl Pattern {
    /// Reads `f.####.png` or `f.%04d.png`. A name without either gets `.####` before its extension; the flag tells.
    ///
    /// # Errors
    /// Two places for a number, or a path without a file name.
    pub fn parse(path: &Path) -> Result<(Self, bool), String> {
        let shown = path.display();
        let Some(name) = path.file_name() else { return Err(format!("`{shown}` names no file")) };
        let Some(name) = name.to_str() else { return Err(format!("`{shown}` is not UTF-8")) };
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let marks: Vec<(usize, usize, usize)> = hashes(name).into_iter().chain(printf(name)).collect();
        let pattern = |start: usize, end: usize, digits: usize| Self {
            folder: folder.clone(),
            before: name[..start].to_owned(),
            digits,
            after: name[end..].to_owned(),
        };
        match marks.as_slice() {
            [] => {
                let dot = name.rfind('.').filter(|&dot| dot > 0).unwrap_or(name.len());
                let mut named = pattern(dot, dot, USUAL_DIGITS);
                named.before.push('.');
                Ok((named, true))
            }
            [(start, end, digits)] => Ok((pattern(*start, *end, *digits), false)),
            _ => Err(format!("`{shown}` has more than one place for the frame's number")),
        }
    }

    pub fn path(&self, frame: u32) -> PathBuf {
        let Self { before, digits, after, .. } = self;
        self.folder.join(format!("{before}{frame:0digits$}{after}"))
    }

    pub fn folder(&self) -> &Path {
        if self.folder == Path::new("") { Path::new(".") } else { &self.folder }
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let name = format!("{}{}{}", self.before, "#".repeat(self.digits), self.after);
        write!(f, "{}", self.folder.join(name).display())
    }
}

/// Runs of `#`: start, end, digits.
fn hashes(name: &str) -> Vec<(usize, usize, usize)> {
    let mut found: Vec<(usize, usize, usize)> = Vec::new();
    for (at, _) in name.match_indices('#') {
        match found.last_mut() {
            Some((_, end, digits)) if *end == at => (*end, *digits) = (at + 1, *digits + 1),
            _ => found.push((at, at + 1, 1)),
        }
    }
    found
}

/// `%d` and `%04d`: start, end, digits.
fn printf(name: &str) -> Vec<(usize, usize, usize)> {
    let mark = |(at, _): (usize, &str)| {
        let rest = &name[at + 1..];
        let width: String = rest.chars().take_while(char::is_ascii_digit).collect();
        let is_number = rest[width.len()..].starts_with('d');
        is_number.then(|| (at, at + width.len() + 2, width.parse().unwrap_or(1).clamp(1, 20)))
    };
    name.match_indices('%').filter_map(mark).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_and_written() {
        for (text, shown, count) in [
            ("1-240", "1-240", 240),
            ("1..3", "1-3", 3),
            ("7", "7", 1),
            ("1,5,10-20x2", "1,5,10,12,14,16,18,20", 8),
            ("5,1-3,2", "1-3,5", 4),
            ("0..10x5", "0,5,10", 3),
        ] {
            let list = FrameList::parse(text).unwrap();
            assert_eq!((list.to_string().as_str(), list.0.len()), (shown, count), "{text}");
            assert_eq!(FrameList::parse(shown).unwrap(), list);
        }
        for text in ["", "a", "3-1", "1-", "-3", "1,,2", "1-5x0", "1-5x", "0-4294967295"] {
            assert!(FrameList::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn rings_are_whole_or_parts() {
        let ring = Ring::parse("4").unwrap();
        assert_eq!((ring.frames.to_string().as_str(), ring.count), ("0-3", 4));
        let part = Ring::parse("1,3-4/4").unwrap();
        assert_eq!((part.frames.to_string().as_str(), part.count), ("1,3-4", 4));
        for text in ["0", "x", "1-3", "1/0", "/4"] {
            assert!(Ring::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn patterns_take_hashes_and_printf() {
        for (text, seventh, added) in [
            ("out/f.####.png", "out/f.0007.png", false),
            ("f_%03d.exr", "f_007.exr", false),
            ("f%d.exr", "f7.exr", false),
            ("#.png", "7.png", false),
            ("a.b/turn.png", "a.b/turn.0007.png", true),
            ("50%.png", "50%.0007.png", true),
        ] {
            let (pattern, inserted) = Pattern::parse(Path::new(text)).unwrap();
            assert_eq!((pattern.path(7), inserted), (PathBuf::from(seventh), added), "{text}");
        }
        assert_eq!(Pattern::parse(Path::new("f.##.png")).unwrap().0.path(12_345), PathBuf::from("f.12345.png"));
        assert!(Pattern::parse(Path::new("#.##.png")).is_err());
        assert!(Pattern::parse(Path::new("/")).is_err());
    }
}
