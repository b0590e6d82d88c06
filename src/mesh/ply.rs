//! Stanford PLY: a header that says what follows, then values as text or as bytes in either order.
//!
//! Source: Greg Turk, The PLY Polygon File Format, 1994.

use glam::{Vec2, Vec3};

use super::error::{Fault, Notes};
use super::ply_data::{Data, Encoding, Scalar};
use super::soup::{ABSENT, Soup, WIDTH};

/// One kind of thing in the file.
struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
    line: usize,
}

struct Property {
    name: String,
    kind: Scalar,
    /// The type of the length that lists begin with.
    list: Option<Scalar>,
}

/// What a vertex has, by the places of its values.
const CHANNELS: [&[&str]; 8] =
    [&["x"], &["y"], &["z"], &["nx"], &["ny"], &["nz"], &["u", "s", "texture_u"], &["v", "t", "texture_v"]];

/// Corners beyond which a face is a slip, or an attack.
const MOST_CORNERS: usize = 1 << 20;

/// Reads the whole file.
///
/// # Errors
/// A header that is none, values that are missing or not finite, indices out of range, counts that the file has no room for.
pub fn parse(bytes: &[u8], max_bytes: u64, notes: &mut Notes) -> Result<Soup, Fault> {
    let (encoding, elements, mut data) = header(bytes)?;
    let mut soup = Soup::within(max_bytes);
    let mut with_normals = false;
    let mut vertices_read = false;
    for element in &elements {
        // A count is a promise: nothing is reserved that the file cannot keep.
        let least = element.properties.iter().map(|p| encoding.least_bytes(p.list.unwrap_or(p.kind))).sum::<usize>();
        let room = data.left().checked_div(least).unwrap_or(usize::MAX);
        if element.count > room {
            let message =
                format!("the header promises {} of `{}`, there is room for {room}", element.count, element.name);
            return Err(Fault::at(element.line, message).hint("the file is cut off or damaged"));
        }
        match element.name.as_str() {
            "vertex" if !vertices_read => {
                with_normals = vertices(element, &mut data, &mut soup)?;
                vertices_read = true;
            }
            "face" if vertices_read => faces(element, &mut data, &mut soup, with_normals, notes)?,
            "face" => {
                let fault = Fault::at(element.line, "faces stand before the vertices that they name");
                return Err(fault.hint("save the file again from another program"));
            }
            name => {
                if element.count > 0 && name == "tristrips" {
                    notes.add(element.line, 1, "triangle strips are not supported", "they are ignored");
                }
                skip(element, &mut data)?;
            }
        }
    }
    Ok(soup)
}

/// How the data are written, what they are, and the data.
fn header(bytes: &[u8]) -> Result<(Encoding, Vec<Element>, Data<'_>), Fault> {
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut rest = bytes;
    for line in 1.. {
        let Some(end) = rest.iter().position(|&byte| byte == b'\n') else {
            let (message, hint) = match line {
                1 => ("is no PLY file: it does not begin with the line `ply`", "name the file by what it is"),
                _ => ("the header has no `end_header`", "the file is cut off or damaged"),
            };
            return Err(Fault::at(line, message).hint(hint));
        };
        let text = String::from_utf8_lossy(rest[..end].trim_ascii());
        rest = &rest[end + 1..];
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let bad =
            |message: &str| Fault::at(line, format!("{message}: `{}`", text.chars().take(60).collect::<String>()));
        match (line, words.as_slice()) {
            (1, ["ply"]) => {}
            (1, _) => {
                let fault = Fault::at(line, "is no PLY file: it does not begin with the line `ply`");
                return Err(fault.hint("name the file by what it is"));
            }
            (_, ["format", kind, _]) => {
                let known = Encoding::named(kind);
                let hint = "known are ascii, binary_little_endian, binary_big_endian";
                encoding = Some(known.ok_or_else(|| bad("unknown format").hint(hint))?);
            }
            (_, [] | ["comment" | "obj_info", ..]) => {}
            (_, ["element", name, count]) => {
                let count = count.parse().map_err(|_| bad("a count that is none"))?;
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new(), line });
            }
            (_, ["property", kind @ .., name]) => {
                let Some(element) = elements.last_mut() else { return Err(bad("a property of nothing")) };
                let scalar = |name: &str| Scalar::named(name).ok_or_else(|| bad("unknown type"));
                let (list, kind) = match kind {
                    ["list", count, kind] => (Some(scalar(count)?), scalar(kind)?),
                    [kind] => (None, scalar(kind)?),
                    _ => return Err(bad("a property that is none")),
                };
                element.properties.push(Property { name: (*name).to_owned(), kind, list });
            }
            (_, ["end_header"]) => {
                let encoding = encoding.ok_or_else(|| Fault::at(line, "the header names no `format`"))?;
                return Ok((encoding, elements, Data::new(encoding, rest, line + 1)));
            }
            _ => return Err(bad("no line of a PLY header")),
        }
    }
    Err(Fault::new("the header has no end"))
}

/// Reads the vertices; true where they have normals.
fn vertices(element: &Element, data: &mut Data, soup: &mut Soup) -> Result<bool, Fault> {
    let place =
        |names: &[&str]| element.properties.iter().position(|p| p.list.is_none() && names.contains(&p.name.as_str()));
    let places = CHANNELS.map(place);
    if places[..3].contains(&None) {
        return Err(Fault::at(element.line, "its vertices have no x, y and z"));
    }
    let (with_normals, with_uvs) = (!places[3..6].contains(&None), !places[6..].contains(&None));
    // Where a value goes, for each property.
    let channels: Vec<Option<usize>> =
        (0..element.properties.len()).map(|i| places.iter().position(|&place| place == Some(i))).collect();
    soup.points.reserve_exact(element.count);
    let mut values = [0.0f32; CHANNELS.len()];
    for number in 0..element.count {
        data.begin(&element.name, number)?;
        for (property, channel) in element.properties.iter().zip(&channels) {
            match channel {
                Some(channel) => {
                    // f64 holds every type; what f32 cannot is as good as infinite.
                    values[*channel] = data.next(property.kind)? as f32;
                    if !values[*channel].is_finite() {
                        let fault = data.fault(format!("`{}` is not a finite number", property.name));
                        return Err(fault.hint("the model has to be mended where it comes from"));
                    }
                }
                None => skip_property(property, data)?,
            }
        }
        data.end()?;
        let [x, y, z, nx, ny, nz, u, v] = values;
        soup.points.push(Vec3::new(x, y, z));
        if with_normals {
            soup.normals.push(Vec3::new(nx, ny, nz));
        }
        if with_uvs {
            soup.uvs.push(Vec2::new(u, v));
        }
    }
    Ok(with_normals)
}

fn faces(
    element: &Element,
    data: &mut Data,
    soup: &mut Soup,
    with_normals: bool,
    notes: &mut Notes,
) -> Result<(), Fault> {
    let is_outline = |p: &Property| p.list.is_some() && matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
    let Some(outline) = element.properties.iter().position(is_outline) else {
        return Err(Fault::at(element.line, "its faces have no list `vertex_indices`"));
    };
    let with_uvs = !soup.uvs.is_empty();
    let mut corners: Vec<[u32; WIDTH]> = Vec::new();
    for number in 0..element.count {
        data.begin(&element.name, number)?;
        for (place, property) in element.properties.iter().enumerate() {
            let Some(length) = property.list.filter(|_| place == outline) else {
                skip_property(property, data)?;
                continue;
            };
            let length = data.length(length, property.kind)?;
            if length > MOST_CORNERS {
                return Err(data.fault(format!("a face of {length} corners")).hint("the file is damaged"));
            }
            corners.clear();
            for _ in 0..length {
                let index = data.next(property.kind)?;
                let count = soup.points.len();
                if !(index >= 0.0 && index < count as f64 && index.fract() == 0.0) {
                    let message = format!("a face names vertex {index}, there are {count}, counted from 0");
                    return Err(data.fault(message).hint("the file is damaged"));
                }
                // Below 2^32: points are numbered by what the file has room for.
                let index = index as u32;
                let or_absent = |is_there: bool| if is_there { index } else { ABSENT };
                corners.push([index, or_absent(with_normals), or_absent(with_uvs)]);
            }
        }
        data.end()?;
        match corners.len() {
            0..3 => notes.add(element.line, 1, "a face of fewer than 3 corners", "it is ignored"),
            _ => soup.polygon(&corners)?,
        }
    }
    Ok(())
}

fn skip(element: &Element, data: &mut Data) -> Result<(), Fault> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for number in 0..element.count {
        data.begin(&element.name, number)?;
        for property in &element.properties {
            skip_property(property, data)?;
        }
        data.end()?;
    }
    Ok(())
}

fn skip_property(property: &Property, data: &mut Data) -> Result<(), Fault> {
    let count = match property.list {
        Some(length) => data.length(length, property.kind)?,
        None => 1,
    };
    for _ in 0..count {
        data.next(property.kind)?;
    }
    Ok(())
}
