//! Videos, through ffmpeg: pixels go in as 16-bit sRGB codes over a pipe, so that nothing guesses their colour.
//!
//! The recipes name matrix, range, primaries and curve both in the conversion and in the file: left to its defaults ffmpeg
//! converts with BT.601 and tags nothing, and colours come out wrong by some 6 codes of 255 instead of 0.6. They follow
//! the Academy Software Foundation's "Encoding Guidelines".

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use super::atomic::Temporary;
use super::display::Codes;
use super::error::OutputError;

/// What a video is written as, by its extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// H.264, 4:2:0, 8 bits: plays everywhere.
    Mp4,
    /// ProRes 422 HQ, 10 bits: for editing.
    Mov,
    /// VP9, 4:2:0, 10 bits: for the web.
    Webm,
    /// FFV1, RGB, 16 bits: exact, for the archive.
    Mkv,
}

const MATRIX: &str =
    "scale=in_color_matrix=bt709:out_color_matrix=bt709:out_range=tv:flags=spline+accurate_rnd+full_chroma_int";
const TAGS: &str = "-color_range tv -colorspace bt709 -color_primaries bt709 -color_trc iec61966-2-1";
/// ProRes keeps only tags that the frames themselves carry.
const FRAME_TAGS: &str = "setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1";

impl Container {
    /// By the extension, in any case.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "mp4" => Some(Self::Mp4),
            "mov" => Some(Self::Mov),
            "webm" => Some(Self::Webm),
            "mkv" => Some(Self::Mkv),
            _ => None,
        }
    }

    /// The codec's own scale of quality, lower is better: CRF, or ProRes's quantiser; `None` where there is no loss.
    pub fn usual_quality(self) -> Option<u32> {
        match self {
            Self::Mp4 => Some(16),
            Self::Mov => Some(9),
            Self::Webm => Some(20),
            Self::Mkv => None,
        }
    }

    /// Sizes are even: colour is stored at half the resolution.
    pub fn halves_colour(self) -> bool {
        self != Self::Mkv
    }

    fn recipe(self, quality: Option<u32>) -> Vec<String> {
        let quality = quality.or(self.usual_quality()).unwrap_or(0);
        let (filter, codec) = match self {
            Self::Mp4 => (
                format!("{MATRIX},format=yuv420p"),
                format!("-c:v libx264 -preset slow -crf {quality} {TAGS} -movflags +faststart+write_colr -f mp4"),
            ),
            Self::Mov => (
                format!("{MATRIX},format=yuv422p10le,{FRAME_TAGS}"),
                format!("-c:v prores_ks -profile:v 3 -vendor apl0 -qscale:v {quality} -movflags +write_colr -f mov"),
            ),
            Self::Webm => (
                format!("{MATRIX},format=yuv420p10le"),
                format!("-c:v libvpx-vp9 -profile:v 2 -crf {quality} -b:v 0 -row-mt 1 {TAGS} -f webm"),
            ),
            Self::Mkv => {
                (String::new(), "-c:v ffv1 -level 3 -g 1 -slicecrc 1 -pix_fmt gbrp16le -f matroska".to_owned())
            }
        };
        let filter = if filter.is_empty() { Vec::new() } else { vec!["-vf".to_owned(), filter] };
        filter.into_iter().chain(codec.split_whitespace().map(str::to_owned)).collect()
    }
}

/// Proves before any work that ffmpeg and ffprobe can be run.
///
/// # Errors
/// How to get them.
pub fn check_ffmpeg() -> Result<(), OutputError> {
    for program in ["ffmpeg", "ffprobe"] {
        let run = Command::new(program).arg("-version").stdin(Stdio::null()).output();
        if !run.is_ok_and(|output| output.status.success()) {
            return Err(OutputError::NoFfmpeg { program });
        }
    }
    Ok(())
}

/// What a video is made like.
#[derive(Clone, Copy, Debug)]
pub struct VideoPlan {
    pub container: Container,
    /// Width and height of the frames.
    pub size: [u32; 2],
    /// Frames per second.
    pub fps: f64,
    /// Instead of [`Container::usual_quality`].
    pub quality: Option<u32>,
}

impl VideoPlan {
    /// Width and height of the video: even where the container wants that.
    pub fn padded(&self) -> [u32; 2] {
        if self.container.halves_colour() { self.size.map(|side| side.next_multiple_of(2)) } else { self.size }
    }
}

/// Writes a video; gives back how many frames it has, as counted in the file. Where the size is padded, the last column and
/// row are repeated.
///
/// # Errors
/// The first frame that cannot be read, what ffmpeg or the system says, or a file with another number of frames than went
/// in. The old file is untouched then.
pub fn write_video(
    path: &Path,
    plan: &VideoPlan,
    frames: impl Iterator<Item = Result<Codes, OutputError>>,
) -> Result<u64, OutputError> {
    let temporary = Temporary::create(path)?;
    let [width, height] = plan.padded();
    let mut command = Command::new("ffmpeg");
    command.args(["-nostdin", "-hide_banner", "-nostats", "-v", "error", "-y"]);
    command.args(["-f", "rawvideo", "-pix_fmt", "rgb48le", "-video_size", &format!("{width}x{height}")]);
    command.args(["-framerate", &plan.fps.to_string(), "-i", "pipe:0"]);
    command.args(plan.container.recipe(plan.quality)).arg(temporary.path());
    let mut ffmpeg = command
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|_| OutputError::NoFfmpeg { program: "ffmpeg" })?;
    // Read as it comes: a full pipe would stop ffmpeg.
    let messages = ffmpeg.stderr.take().map(|mut stderr| {
        std::thread::spawn(move || {
            let mut text = Vec::new();
            let _ = stderr.read_to_end(&mut text);
            String::from_utf8_lossy(&text).trim().to_owned()
        })
    });
    let fed = match ffmpeg.stdin.take() {
        Some(pixels) => feed(pixels, frames, plan.padded()),
        None => Ok(0),
    };
    let ended = ffmpeg.wait().map_err(OutputError::io("wait for ffmpeg to write", path))?;
    let messages = messages.and_then(|thread| thread.join().ok()).unwrap_or_default();
    let fed = fed?;
    if !ended.success() {
        return Err(OutputError::picture(path, format!("ffmpeg says: {messages}")));
    }
    let counted = count_frames(temporary.path());
    if counted != Some(fed) {
        let counted = counted.map_or("none".to_owned(), |count| count.to_string());
        return Err(OutputError::picture(path, format!("of {fed} frames {counted} are in the video")));
    }
    temporary.commit()?;
    Ok(fed)
}

/// Gives ffmpeg its frames. Should it go away, it says why when asked for the end.
fn feed(
    mut pixels: impl Write,
    frames: impl Iterator<Item = Result<Codes, OutputError>>,
    [width, height]: [u32; 2],
) -> Result<u64, OutputError> {
    let mut count = 0;
    for frame in frames {
        let codes = frame?;
        let mut bytes = Vec::with_capacity(width as usize * height as usize * 6);
        for y in 0..height.min(codes.height + 1) {
            let row = codes.row(y.min(codes.height - 1));
            let more = row.last().into_iter().cycle().take((width as usize).saturating_sub(row.len()));
            bytes.extend(row.iter().chain(more).flatten().flat_map(|code| code.to_le_bytes()));
        }
        if pixels.write_all(&bytes).is_err() {
            break;
        }
        count += 1;
    }
    Ok(count)
}

/// By decoding; `None` where that fails.
fn count_frames(path: &Path) -> Option<u64> {
    let mut command = Command::new("ffprobe");
    command.args(["-v", "error", "-count_frames", "-select_streams", "v:0"]);
    command.args(["-show_entries", "stream=nb_read_frames", "-of", "csv=p=0"]).arg(path);
    let output = command.stdin(Stdio::null()).output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().trim_end_matches(',').parse().ok()
}
