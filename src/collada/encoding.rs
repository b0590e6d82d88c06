//! Bytes of the file to text: UTF-8 with or without byte order mark, UTF-16 with one.

/// The text without its byte order mark. A declared encoding other than UTF-8 is fine as long as every byte is ASCII.
pub fn decode(bytes: Vec<u8>) -> Result<String, String> {
    match bytes.as_slice() {
        [0xFF, 0xFE, rest @ ..] => return utf16(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => return utf16(rest, u16::from_be_bytes),
        _ => {}
    }
    let declared = declared_encoding(&bytes);
    let foreign = declared.filter(|name| !matches!(name.to_ascii_lowercase().as_str(), "utf-8" | "utf8" | "us-ascii"));
    if let Some(name) = foreign {
        if let Some(offset) = bytes.iter().position(|byte| !byte.is_ascii()) {
            return Err(format!(
                "encoding `{name}` is not supported: byte {offset} is not ASCII; save the file as UTF-8"
            ));
        }
    }
    let mut text = String::from_utf8(bytes).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        format!("byte {offset} is not UTF-8; save the file as UTF-8")
    })?;
    strip_marks(&mut text);
    Ok(text)
}

/// The XML reader passes over a mark without counting its bytes, and offsets would be wrong: files may begin with several.
fn strip_marks(text: &mut String) {
    let marks = text.len() - text.trim_start_matches('\u{FEFF}').len();
    text.drain(..marks);
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String, String> {
    let bad = |units: usize| {
        let offset = 2 + 2 * units;
        format!("byte {offset} is not UTF-16; save the file as UTF-8")
    };
    if bytes.len() % 2 != 0 {
        return Err(bad(bytes.len() / 2));
    }
    let mut text = String::with_capacity(bytes.len() / 2);
    let mut units = 0;
    let source = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    for character in char::decode_utf16(source) {
        let character = character.map_err(|_| bad(units))?;
        units += character.len_utf16();
        text.push(character);
    }
    strip_marks(&mut text);
    Ok(text)
}

/// The `encoding` pseudo-attribute of the XML declaration.
fn declared_encoding(bytes: &[u8]) -> Option<String> {
    let head = &bytes[..bytes.len().min(256)];
    let head = String::from_utf8_lossy(head);
    let declaration = head.trim_start_matches('\u{FEFF}').strip_prefix("<?xml")?.split("?>").next()?.to_owned();
    let value = declaration.split("encoding").nth(1)?.trim_start().strip_prefix('=')?.trim_start();
    let quote = value.chars().next().filter(|c| matches!(c, '"' | '\''))?;
    value[1..].split(quote).next().map(str::to_owned)
}
