//! `<map>`, `<normal_map>` and `<opacity>`: references to images.

use crate::collada::error::Fault;
use crate::collada::images;
use crate::collada::loader::Loader;
use crate::collada::xml::Element;
use crate::document::{Channel4, Encoding, Map, NormalMap, Scalar, Wrap};

use super::strict::{Bounds, Strict, at_most_one};

/// The attributes that all image references share.
pub fn image<'a>(loader: &mut Loader<'a>, strict: &mut Strict<'a>, user: &str) -> Result<Map, Fault> {
    let uri = strict.text("image");
    let uri = strict.required("image", uri)?;
    let texcoord = strict.text("texcoord").unwrap_or_default().to_owned();
    let image = images::from_attribute(loader, strict.element, uri, user)?;
    let words = [("wrap", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp), ("border", Wrap::Border)];
    let both = strict.choice("wrap", &words)?.unwrap_or_default();
    let wrap_s = strict.choice("wrap_s", &words)?.unwrap_or(both);
    let wrap_t = strict.choice("wrap_t", &words)?.unwrap_or(both);
    Ok(Map { image, texcoord, slot: 0, encoding: Encoding::Linear, channel: Channel4::G, wrap: [wrap_s, wrap_t] })
}

/// The `channel` attribute.
pub fn channel(strict: &mut Strict) -> Result<Option<Channel4>, Fault> {
    strict.choice("channel", &[("r", Channel4::R), ("g", Channel4::G), ("b", Channel4::B), ("a", Channel4::A)])
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

/// How much of the surface is there: a number, or the channel of an image (alpha, if it names none).
pub fn opacity<'a>(loader: &mut Loader<'a>, element: Element<'a>, user: &str) -> Result<Scalar, Fault> {
    let mut strict = Strict::new(element);
    let value = strict.number("value", Bounds::Within(0.0, 1.0))?;
    strict.not_both("value", "image")?;
    let map = match element.attribute("image") {
        Some(_) => {
            let map = image(loader, &mut strict, user)?;
            Some(Map { channel: channel(&mut strict)?.unwrap_or(Channel4::A), ..map })
        }
        None => None,
    };
    if value.is_none() && map.is_none() {
        return Err(element.fault("<opacity> has neither `value` nor `image`"));
    }
    strict.finish(&[])?;
    Ok(Scalar::mapped(value.unwrap_or(1.0), map))
}

pub fn normal_map<'a>(loader: &mut Loader<'a>, element: Element<'a>, user: &str) -> Result<NormalMap, Fault> {
    let mut strict = Strict::new(element);
    let map = image(loader, &mut strict, user)?;
    let scale = strict.number("scale", Bounds::Any)?.unwrap_or(1.0);
    strict.finish(&[])?;
    Ok(NormalMap { map, scale })
}
