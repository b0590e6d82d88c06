//! Parts: the exact sums of some samples of a picture, to be merged with others or to be gone on from.
//!
//! A file of our own rather than EXR, which has no integers of more than 32 bits and whose encoder wants the whole picture
//! twice in memory. All numbers are little-endian:
//!
//! | bytes | what |
//! |---|---|
//! | 16 | `pellicle part 2\n` |
//! | 8 | length of the header |
//! | that many | the header, JSON |
//! | blocks | pixels (u32; 0 ends the list), next (u32), then for each of six columns its width (u8: 0 to 16) and all pixels' values, two's complement, in that many bytes; then the length of a note (u32) and the note |
//! | 32 | SHA-256 of everything before |
//!
//! A column is as wide as its largest value needs: a quarter less than 64 bits for usual pictures, and no limit at 64.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::atomic::Temporary;
use super::error::OutputError;

const MAGIC: &[u8; 16] = b"pellicle part 2\n";
/// No header of ours comes near; a larger one is damage.
const LARGEST_HEADER: u64 = 1 << 26;
/// Nor a block.
const LARGEST_BLOCK: u32 = 1 << 20;
/// Nor its note.
const LARGEST_NOTE: u32 = 1 << 24;

/// Some neighbouring pixels' sums.
pub struct PartBlock {
    /// The sample index that these pixels go on with.
    pub next: u32,
    pub values: Vec<[i128; 6]>,
    /// What else is needed to go on, in a form of the writer's own.
    pub note: Vec<u8>,
}

/// Writes a part, whole or not at all.
///
/// # Errors
/// What the system says; the old file is untouched then.
pub fn write_part(path: &Path, header: &str, blocks: impl Iterator<Item = PartBlock>) -> Result<(), OutputError> {
    let temporary = Temporary::create(path)?;
    let mut file = Hashing { inner: BufWriter::new(temporary.file()), hash: Sha256::new() };
    let encode = || -> io::Result<()> {
        file.write_all(MAGIC)?;
        file.write_all(&(header.len() as u64).to_le_bytes())?;
        file.write_all(header.as_bytes())?;
        for block in blocks {
            file.write_all(&(block.values.len() as u32).to_le_bytes())?;
            file.write_all(&block.next.to_le_bytes())?;
            for column in 0..6 {
                let values = block.values.iter().map(|pixel| pixel[column]);
                let width = values.clone().map(bytes_needed).max().unwrap_or(0);
                file.write_all(&[width as u8])?;
                let mut bytes = Vec::with_capacity(width * block.values.len());
                for value in values {
                    bytes.extend_from_slice(&value.to_le_bytes()[..width]);
                }
                file.write_all(&bytes)?;
            }
            file.write_all(&(block.note.len() as u32).to_le_bytes())?;
            file.write_all(&block.note)?;
        }
        file.write_all(&0u32.to_le_bytes())?;
        let digest = file.hash.finalize_reset();
        file.inner.write_all(&digest)?;
        file.inner.flush()
    };
    encode().map_err(OutputError::io("write", path))?;
    drop(file);
    temporary.commit()
}

/// A part that is being read, block by block: memory for one.
pub struct PartReader {
    path: PathBuf,
    file: Hashing<BufReader<File>>,
    pub header: String,
    ended: bool,
}

impl PartReader {
    /// Reads the header.
    ///
    /// # Errors
    /// A file that is missing, is not a part, or ends too early.
    pub fn open(path: &Path) -> Result<Self, OutputError> {
        let file = File::open(path).map_err(|error| OutputError::damaged(path, error))?;
        let mut file = Hashing { inner: BufReader::new(file), hash: Sha256::new() };
        let mut magic = [0; 16];
        if file.read_exact(&mut magic).is_err() || magic != *MAGIC {
            let reason = "it is not a part as `pellicle render --samples` writes them";
            return Err(OutputError::damaged(path, reason));
        }
        let damaged = |_| OutputError::damaged(path, CUT_SHORT);
        let mut length = [0; 8];
        file.read_exact(&mut length).map_err(damaged)?;
        let length = u64::from_le_bytes(length);
        if length > LARGEST_HEADER {
            return Err(OutputError::damaged(path, "its header is damaged"));
        }
        let mut header = vec![0; length as usize];
        file.read_exact(&mut header).map_err(damaged)?;
        let header = String::from_utf8(header).map_err(|_| OutputError::damaged(path, "its header is not text"))?;
        Ok(Self { path: path.to_path_buf(), file, header, ended: false })
    }

    /// `None` at the end, where the whole file has proved to be what was written.
    fn block(&mut self) -> io::Result<Option<PartBlock>> {
        let count = self.number()?;
        if count == 0 {
            let expected = self.file.hash.finalize_reset();
            let (mut digest, mut more) = ([0; 32], [0]);
            self.file.read_exact(&mut digest)?;
            let ends = self.file.inner.read(&mut more)? == 0;
            return if ends && digest == *expected { Ok(None) } else { Err(io::ErrorKind::InvalidData.into()) };
        }
        let next = self.number()?;
        if count > LARGEST_BLOCK {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let mut values = vec![[0; 6]; count as usize];
        for column in 0..6 {
            let mut width = [0];
            self.file.read_exact(&mut width)?;
            let width = usize::from(width[0]);
            if width > 16 {
                return Err(io::ErrorKind::InvalidData.into());
            }
            let mut bytes = vec![0; width * count as usize];
            self.file.read_exact(&mut bytes)?;
            if width > 0 {
                for (pixel, bytes) in values.iter_mut().zip(bytes.chunks_exact(width)) {
                    pixel[column] = extended(bytes);
                }
            }
        }
        let length = self.number()?;
        if length > LARGEST_NOTE {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let mut note = vec![0; length as usize];
        self.file.read_exact(&mut note)?;
        Ok(Some(PartBlock { next, values, note }))
    }

    fn number(&mut self) -> io::Result<u32> {
        let mut bytes = [0; 4];
        self.file.read_exact(&mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    }
}

const CUT_SHORT: &str = "it is damaged or cut short";

impl Iterator for PartReader {
    type Item = Result<PartBlock, OutputError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let block = self.block();
        self.ended = !matches!(block, Ok(Some(_)));
        block.map_err(|_| OutputError::damaged(&self.path, CUT_SHORT)).transpose()
    }
}

/// Bytes that hold a value in two's complement.
fn bytes_needed(value: i128) -> usize {
    if value == 0 {
        return 0;
    }
    let magnitude = if value < 0 { !value } else { value };
    (128 - magnitude.leading_zeros() as usize) / 8 + 1
}

/// A little-endian value of 1 to 16 bytes, its sign carried on.
fn extended(bytes: &[u8]) -> i128 {
    let sign = if bytes.last().is_some_and(|&last| last >= 0x80) { 0xff } else { 0 };
    let mut all = [sign; 16];
    all[..bytes.len()].copy_from_slice(bytes);
    i128::from_le_bytes(all)
}

/// Hashes what passes.
struct Hashing<F> {
    inner: F,
    hash: Sha256,
}

impl<F: Write> Write for Hashing<F> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<F: Read> Read for Hashing<F> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(bytes)?;
        self.hash.update(&bytes[..read]);
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_take_as_few_bytes_as_hold_them() {
        for value in [0, 1, -1, 127, 128, -128, -129, 32_767, 32_768, 1 << 62, -(1 << 63), i128::MAX, i128::MIN] {
            let width = bytes_needed(value);
            assert_eq!(extended(&value.to_le_bytes()[..width]), value);
            assert!(width == 0 || extended(&value.to_le_bytes()[..width - 1]) != value, "{value} in {width}");
        }
    }
}
