//! What a picture file says about itself, without its pixels.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use exr::meta::MetaData;
use exr::prelude::{AttributeValue, Text};

use super::picture::Format;

/// The text that the header of an EXR or PNG file has under a name; `None` also where there is no such file.
pub fn note(path: &Path, name: &str) -> Option<String> {
    match Format::of(path).ok()? {
        Format::Exr => {
            let meta = MetaData::read_from_file(path, false).ok()?;
            let header = meta.headers.first()?;
            let name = Text::new_or_none(name)?;
            let (own, shared) = (&header.own_attributes.other, &header.shared_attributes.other);
            match shared.get(&name).or_else(|| own.get(&name))? {
                AttributeValue::Text(text) => Some(String::from_utf8_lossy(text.bytes()).into_owned()),
                _ => None,
            }
        }
        Format::Png => {
            let reader = png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
            reader.info().utf8_text.iter().find(|chunk| chunk.keyword == name)?.get_text().ok()
        }
    }
}
