//! `<map>` and `<normal_map>`: references to images.

use crate::collada::error::Fault;
use crate::collada::images;
use crate::collada::loader::Loader;
use crate::collada::xml::Element;
use crate::document::{Channel4, Encoding, Map, NormalMap, Wrap};

use super::strict::{Bounds, Strict, at_most_one};

/// The attributes that all image references share.
pub fn image<'a>(loader: &mut Loader<'a>, strict: &mut Strict<'a>, user: &str) -> Result<Map, Fault> {
    let uri = strict.text("image");
    let uri = strict.required("image", uri)?;
    let texcoord = strict.text("texcoord").unwrap_or_default().to_owned();
    let image = images::from_attribute(loader, strict.element, uri, user)?;
    Ok(Map { image, texcoord, encoding: Encoding::Linear, channel: Channel4::G, wrap: [Wrap::Repeat; 2] })
}

/// The `<map for="property">` of a base, of which each has one property that can be mapped. `encoding` holds where the map
/// names no `colorspace`.
pub fn base_map<'a>(
    loader: &mut Loader<'a>,
    base: Element<'a>,
    property: &str,
    encoding: Encoding,
    user: &str,
) -> Result<Option<Map>, Fault> {
    let Some(element) = at_most_one(base, &["map"])? else { return Ok(None) };
    let mut strict = Strict::new(element);
    let purpose = strict.choice("for", &[(property, ())])?;
    strict.required("for", purpose)?;
    let mut map = image(loader, &mut strict, user)?;
    let words = [("srgb", Encoding::Srgb), ("linear", Encoding::Linear)];
    map.encoding = strict.choice("colorspace", &words)?.unwrap_or(encoding);
    strict.finish(&[])?;
    Ok(Some(map))
}

pub fn normal_map<'a>(loader: &mut Loader<'a>, element: Element<'a>, user: &str) -> Result<NormalMap, Fault> {
    let mut strict = Strict::new(element);
    let map = image(loader, &mut strict, user)?;
    let scale = strict.number("scale", Bounds::Any)?.unwrap_or(1.0);
    strict.finish(&[])?;
    Ok(NormalMap { map, scale })
}
