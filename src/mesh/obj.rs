//! Wavefront OBJ: points, texture coordinates, normals, polygons and the materials they name.
//!
//! Source: Wavefront Advanced Visualizer manual, appendix B1. Free-form curves and surfaces are passed over with a note.

use glam::{Vec2, Vec3};

use super::error::{Fault, Notes};
use super::soup::{ABSENT, Soup, WIDTH};

/// A material library that the file names.
pub struct Library {
    pub line: usize,
    pub name: String,
}

/// Names that change nothing here: objects, groups, smoothing groups, display attributes.
const IRRELEVANT: [&str; 13] =
    ["o", "g", "s", "mg", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "usemap", "maplib", "vp"];

/// Reads the whole file.
///
/// # Errors
/// What is not a number or an index, points out of range, with the line.
pub fn parse(bytes: &[u8], max_bytes: u64, notes: &mut Notes) -> Result<(Soup, Vec<Library>), Fault> {
    let mut soup = Soup::within(max_bytes);
    let mut libraries = Vec::new();
    let mut corners: Vec<[u32; WIDTH]> = Vec::new();
    // Windows editors begin UTF-8 with a mark.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut lines = (1..).zip(bytes.split(|&byte| byte == b'\n'));
    let mut joined = Vec::new();
    while let Some((line, text)) = lines.next() {
        // A backslash at the end goes on in the next line.
        let mut text = text.trim_ascii_end();
        if text.ends_with(b"\\") {
            joined.clear();
            joined.extend_from_slice(text);
            while joined.ends_with(b"\\") {
                joined.pop();
                joined.push(b' ');
                let Some((_, more)) = lines.next() else { break };
                joined.extend_from_slice(more.trim_ascii_end());
            }
            text = &joined;
        }
        let mut words = words(text);
        let Some(keyword) = words.next() else { continue };
        let rest = || String::from_utf8_lossy(&text[keyword.len() + skipped(text)..]).trim().to_owned();
        match keyword {
            b"v" => soup.points.push(Vec3::from(numbers(line, "a point", &mut words)?)),
            b"vn" => soup.normals.push(Vec3::from(numbers(line, "a normal", &mut words)?)),
            b"vt" => soup.uvs.push(texture_coordinates(line, &mut words)?),
            b"f" | b"fo" => {
                corners.clear();
                for word in words {
                    corners.push(corner(line, word, &soup)?);
                }
                if corners.len() < 3 {
                    notes.add(line, 1, "a face of fewer than 3 corners", "it is ignored");
                } else {
                    soup.polygon(&corners).map_err(|fault| Fault { line: Some(line), ..fault })?;
                }
            }
            b"usemtl" => soup.use_material(&rest()),
            b"mtllib" => libraries.push(Library { line, name: rest() }),
            b"p" | b"l" => notes.add(line, 1, "points and lines, which are not surfaces", "they are ignored"),
            _ if keyword.starts_with(b"#") => {}
            _ => other(line, keyword, notes)?,
        }
    }
    Ok((soup, libraries))
}

/// Anything that is neither shape nor material.
fn other(line: usize, keyword: &[u8], notes: &mut Notes) -> Result<(), Fault> {
    let shown = shown(keyword);
    if IRRELEVANT.contains(&shown.as_str()) {
        return Ok(());
    }
    if !keyword.iter().all(|byte| byte.is_ascii_alphanumeric() || *byte == b'_') || keyword.len() > 16 {
        return Err(Fault::at(line, format!("`{shown}` is no word of OBJ")).hint("the file is damaged, or no OBJ"));
    }
    notes.add(line, 1, &format!("`{shown}` is not supported"), "it is ignored");
    Ok(())
}

/// Words between blanks.
fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty())
}

/// Blanks at the start.
fn skipped(text: &[u8]) -> usize {
    text.len() - text.trim_ascii_start().len()
}

/// A word for messages.
fn shown(word: &[u8]) -> String {
    String::from_utf8_lossy(word).chars().take(24).map(|c| if c.is_control() { '?' } else { c }).collect()
}

/// A finite number.
pub fn number(line: usize, word: &[u8]) -> Result<f32, Fault> {
    match std::str::from_utf8(word).ok().and_then(|text| text.parse::<f32>().ok()) {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(Fault::at(line, format!("`{}` is not a finite number", shown(word)))
            .hint("models that a solver left with NaN or infinity have to be mended where they come from")),
        None if word.contains(&b',') => Err(Fault::at(line, format!("`{}` has a decimal comma", shown(word)))
            .hint("export with decimal points, as OBJ wants them")),
        None => Err(Fault::at(line, format!("`{}` is not a number", shown(word)))),
    }
}

/// The first three numbers; what comes after them (weights, colours) is passed over.
fn numbers<'a>(line: usize, what: &str, words: &mut impl Iterator<Item = &'a [u8]>) -> Result<[f32; 3], Fault> {
    let mut values = [0.0; 3];
    for (i, value) in values.iter_mut().enumerate() {
        let Some(word) = words.next() else {
            return Err(Fault::at(line, format!("{what} takes 3 numbers, here are {i}")));
        };
        *value = number(line, word)?;
    }
    Ok(values)
}

/// One or two numbers; a third is depth.
fn texture_coordinates<'a>(line: usize, words: &mut impl Iterator<Item = &'a [u8]>) -> Result<Vec2, Fault> {
    let Some(u) = words.next() else {
        return Err(Fault::at(line, "texture coordinates take 2 numbers, here are 0"));
    };
    let v = words.next().map_or(Ok(0.0), |word| number(line, word))?;
    Ok(Vec2::new(number(line, u)?, v))
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`, each counted from 1, or backwards from -1.
fn corner(line: usize, word: &[u8], soup: &Soup) -> Result<[u32; WIDTH], Fault> {
    let known = [("point", soup.points.len()), ("normal", soup.normals.len()), ("texture coordinate", soup.uvs.len())];
    let mut indices = [ABSENT; WIDTH];
    for (field, digits) in word.split(|&byte| byte == b'/').enumerate() {
        // In the file texture coordinates come before normals.
        let Some(&channel) = [0, 2, 1].get(field) else {
            return Err(Fault::at(line, format!("`{}` has more than 3 indices", shown(word))));
        };
        if digits.is_empty() && field > 0 {
            continue;
        }
        let (name, count) = known[channel];
        let written = std::str::from_utf8(digits).ok().and_then(|text| text.parse::<i64>().ok());
        let Some(written) = written else {
            let fault = Fault::at(line, format!("`{}` is not an index", shown(word)));
            return Err(fault.hint("corners of a face are written v, v/vt, v//vn or v/vt/vn, whole numbers from 1"));
        };
        let index = match written {
            1.. => usize::try_from(written - 1).ok(),
            0 => return Err(Fault::at(line, "an index is 0").hint("OBJ counts from 1, or backwards from -1")),
            _ => usize::try_from(written.unsigned_abs()).ok().and_then(|back| count.checked_sub(back)),
        };
        let in_range = index.filter(|&index| index < count).and_then(|index| u32::try_from(index).ok());
        indices[channel] = in_range.filter(|&index| index != ABSENT).ok_or_else(|| {
            let message = format!("{name} {written} does not exist: up to here the file has {count}");
            Fault::at(line, message).hint("the file is cut off or damaged")
        })?;
    }
    Ok(indices)
}
