//! Frames to a video: which files there are, whether they belong together, and what they become.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::frames::{FrameList, Pattern};
use crate::error::Error;
use crate::output::{self, Container, Display, Format, OutputError, VideoPlan};

/// Frames of one size, in the order of their numbers.
pub struct Footage {
    pub frames: Vec<PathBuf>,
    pub size: [u32; 2],
}

/// How a video is made.
#[derive(Clone, Copy, Debug)]
pub struct EncodePlan {
    pub fps: f64,
    /// Instead of the usual quality of the format ([`Container::usual_quality`]).
    pub quality: Option<u32>,
    /// For EXR frames.
    pub display: Display,
}

/// What videos are written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Animated PNG.
    Apng,
    Ffmpeg(Container),
}

impl Target {
    /// By the extension; proves before any work that the file can be written, and that ffmpeg is there where it is needed.
    ///
    /// # Errors
    /// What stands in the way.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let target = match Container::of(path) {
            Some(container) => Self::Ffmpeg(container),
            None if Format::of(path).is_ok_and(|format| format == Format::Png) => Self::Apng,
            None => {
                return Err(Error::Usage(format!(
                    "{}: videos are written as .mp4, .mov, .webm, .mkv, or .png (animated)",
                    path.display()
                )));
            }
        };
        output::check_writable(path)?;
        if let Self::Ffmpeg(_) = target {
            output::check_ffmpeg()?;
        }
        Ok(target)
    }
}

impl Footage {
    /// Finds the frames of a pattern (`f.####.png`, `f.%04d.exr`), or of a folder that holds one sequence.
    ///
    /// # Errors
    /// No frames, missing ones between them, or frames of several sizes.
    pub fn find(frames: &Path) -> Result<Self, Error> {
        let pattern = if frames.is_dir() { only_sequence(frames)? } else { parse(frames)? };
        let numbers = numbers(&pattern)?;
        let (Some(&first), Some(&last)) = (numbers.first(), numbers.last()) else {
            return Err(Error::Usage(format!("there are no frames like {pattern}")));
        };
        let missing: Vec<u32> = (first..=last).filter(|number| numbers.binary_search(number).is_err()).collect();
        if !missing.is_empty() {
            let missing = FrameList(missing);
            return Err(Error::Usage(format!("of {pattern} the frames {missing} are missing: render them first")));
        }
        Self::of(numbers.into_iter().map(|number| pattern.path(number)).collect())
    }

    /// These frames, in this order.
    ///
    /// # Errors
    /// A file that cannot be read, or frames of several sizes.
    pub fn of(frames: Vec<PathBuf>) -> Result<Self, Error> {
        let first = frames.first().ok_or_else(|| Error::Usage("there are no frames".to_owned()))?;
        let size = output::picture_size(first)?;
        for frame in &frames {
            let [width, height] = output::picture_size(frame)?;
            if [width, height] != size {
                return Err(Error::Usage(format!(
                    "{} is {width}x{height}, but {} is {}x{}: a video has one size",
                    frame.display(),
                    first.display(),
                    size[0],
                    size[1]
                )));
            }
        }
        Ok(Self { frames, size })
    }

    /// Writes the video; `tell` hears what a user should know. Gives back the number of frames.
    ///
    /// # Errors
    /// A frame that cannot be read, or what ffmpeg or the system says; the old file is untouched then.
    pub fn encode(
        &self,
        path: &Path,
        target: Target,
        plan: &EncodePlan,
        tell: impl Fn(&str),
    ) -> Result<u64, OutputError> {
        let codes = self.frames.iter().map(|frame| output::read_codes(frame, plan.display));
        let count = self.frames.len() as u64;
        match target {
            Target::Apng => {
                output::write_apng(path, self.size, plan.fps, count as u32, codes)?;
                Ok(count)
            }
            Target::Ffmpeg(container) => {
                let video = VideoPlan { container, size: self.size, fps: plan.fps, quality: plan.quality };
                let ([width, height], [wide, high]) = (self.size, video.padded());
                if video.padded() != self.size {
                    tell(&format!(
                        "{width}x{height} frames become a {wide}x{high} video (it has even sides): the last column or row is repeated"
                    ));
                }
                output::write_video(path, &video, codes)
            }
        }
    }
}

fn parse(frames: &Path) -> Result<Pattern, Error> {
    match Pattern::parse(frames).map_err(Error::Usage)? {
        (pattern, false) => Ok(pattern),
        (_, true) => Err(Error::Usage(format!(
            "{}: name frames by a pattern like f.####.png or f.%04d.exr, or a folder",
            frames.display()
        ))),
    }
}

/// The pattern of the one sequence of pictures in a folder: the last digits of a name are a frame's number.
fn only_sequence(folder: &Path) -> Result<Pattern, Error> {
    // What is before and after the number, the fewest digits, how many files.
    let mut found: BTreeMap<(String, String), (usize, usize)> = BTreeMap::new();
    for name in names(folder)? {
        let is_picture = Format::of(Path::new(&name)).is_ok() && !name.starts_with('.');
        let stem = name.rfind('.').unwrap_or(name.len());
        if let (true, Some(last)) = (is_picture, name[..stem].rfind(|c: char| c.is_ascii_digit())) {
            let before = name[..=last].trim_end_matches(|c: char| c.is_ascii_digit());
            let digits = last + 1 - before.len();
            let entry = found.entry((before.to_owned(), name[last + 1..].to_owned())).or_insert((digits, 0));
            *entry = (entry.0.min(digits), entry.1 + 1);
        }
    }
    let mut patterns = Vec::new();
    for ((before, after), (digits, count)) in found {
        patterns.push((format!("{before}{}{after}", "#".repeat(digits)), count));
    }
    match patterns.as_slice() {
        [(pattern, _)] => parse(&folder.join(pattern)),
        [] => Err(Error::Usage(format!("{}: there are no numbered .png or .exr files in it", folder.display()))),
        _ => {
            let several: Vec<String> = patterns.iter().map(|(pattern, count)| format!("{pattern} ({count})")).collect();
            Err(Error::Usage(format!(
                "{}: there are several sequences in it: {}; name one by its pattern",
                folder.display(),
                several.join(", ")
            )))
        }
    }
}

/// Numbers of the files that a pattern names, in rising order.
fn numbers(pattern: &Pattern) -> Result<Vec<u32>, Error> {
    let mut numbers: Vec<u32> = Vec::new();
    for name in names(pattern.folder())? {
        let runs = name.split(|c: char| !c.is_ascii_digit()).filter_map(|digits| digits.parse().ok());
        let named = |number: &u32| pattern.path(*number).file_name().is_some_and(|file| file == name.as_str());
        numbers.extend(runs.filter(named).take(1));
    }
    numbers.sort_unstable();
    Ok(numbers)
}

fn names(folder: &Path) -> Result<Vec<String>, Error> {
    let entries = std::fs::read_dir(folder)
        .map_err(|source| OutputError::Damaged { path: folder.to_path_buf(), reason: source.to_string() })?;
    Ok(entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect())
}
