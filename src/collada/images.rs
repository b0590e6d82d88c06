//! Image references: URIs to files inside the allowed folders, or members of the archive.

use std::path::Path;

use crate::document::{Image, ImageSource};
use crate::mesh::{self, Refusal};
use crate::scene::Texture;

use super::MissingTexture;
use super::error::Fault;
use super::loader::Loader;
use super::package::Package;
use super::xml::Element;

/// The image of an `<image>` element. `user` names who refers to it, for messages: "material `gold`".
pub fn from_element<'a>(loader: &mut Loader<'a>, image: Element<'a>, user: &str) -> Result<usize, Fault> {
    let id = image.attribute("id").unwrap_or_default();
    let Some(init_from) = image.child("init_from") else {
        return Err(image
            .fault(format!("image `{id}` has no <init_from>"))
            .hint("image data inside the XML is not read"));
    };
    // COLLADA 1.5 wraps the URI in <ref>.
    let place = init_from.child("ref").unwrap_or(init_from);
    let uri = place.text();
    if uri.is_empty() {
        return Err(init_from.fault(format!("image `{id}` names no file")));
    }
    resolve(loader, place, id, &uri, user).map_err(|(message, hint)| Fault { hint, ..place.fault_at_text(message) })
}

/// The image of an `image="..."` attribute of our own profile.
pub fn from_attribute<'a>(
    loader: &mut Loader<'a>,
    element: Element<'a>,
    uri: &str,
    user: &str,
) -> Result<usize, Fault> {
    resolve(loader, element, uri, uri, user)
        .map_err(|(message, hint)| Fault { hint, ..element.fault_at_value("image", message) })
}

fn resolve<'a>(loader: &mut Loader<'a>, place: Element<'a>, id: &str, uri: &str, user: &str) -> Result<usize, Refusal> {
    if let Some(&index) = loader.images.get(uri) {
        return Ok(index);
    }
    let found = locate(loader, uri);
    let source = match found {
        Err((reason, hint)) => return Err((format!("image `{uri}` of {user} {reason}"), hint)),
        Ok(Some(source)) => source,
        Ok(None) if loader.options.missing_texture == MissingTexture::Magenta => {
            let seen = format!("image `{uri}` of {user} is missing");
            loader.warnings.add(place, seen, "it is shown as magenta");
            ImageSource::Missing
        }
        Ok(None) => {
            let beside = beside_scene(loader.package, uri);
            let hint = beside.unwrap_or("--missing-texture=magenta renders without it".to_owned());
            return Err((format!("image `{uri}` of {user} is missing"), Some(hint)));
        }
    };
    let mut image = Image { id: id.to_owned(), uri: uri.to_owned(), user: user.to_owned(), source };
    if loader.options.missing_texture == MissingTexture::Magenta {
        // One that is there but cannot be decoded is as good as missing.
        if let Err(error) = Texture::load(&image, loader.options.max_bytes) {
            loader.warnings.add(place, error.to_string(), "it is shown as magenta");
            image.source = ImageSource::Missing;
        }
    }
    loader.document.images.push(image);
    let index = loader.document.images.len() - 1;
    loader.images.insert(uri.to_owned(), index);
    Ok(index)
}

/// What a URI names: a file, or a member of the archive; `Ok(None)` where there is no such thing.
///
/// # Errors
/// It lies where the scene may not look, or is no file; the reason follows on its name.
pub fn locate(loader: &Loader, uri: &str) -> Result<Option<ImageSource>, Refusal> {
    let path = uri_to_path(uri).map_err(|reason| (reason, None))?;
    match loader.package {
        Package::Archive(archive) => {
            let member = archive.relative(&path);
            member.map(|member| member.map(ImageSource::Bytes)).map_err(|reason| (reason, None))
        }
        Package::Folder(folder) => {
            let file = mesh::find(folder, &loader.options.allow_path, Path::new(&path))?;
            Ok(file.map(ImageSource::File))
        }
    }
}

/// A file of the same name in the scene's own folder is most likely the one that was meant.
pub fn beside_scene(package: &Package, uri: &str) -> Option<String> {
    let Package::Folder(folder) = package else { return None };
    let path = uri_to_path(uri).ok()?;
    let name = path.rsplit('/').next().filter(|name| *name != path)?;
    folder.join(name).is_file().then(|| format!("did you mean `{name}` beside the scene?"))
}

/// Strips `file:`, decodes percent escapes, turns backslashes. Errors: a network or other scheme.
fn uri_to_path(uri: &str) -> Result<String, String> {
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme);
    let is_scheme = |text: &&str| text.len() > 1 && text.bytes().all(|byte| byte.is_ascii_alphanumeric());
    let rest = match scheme.filter(is_scheme) {
        Some(scheme) if scheme.eq_ignore_ascii_case("file") => {
            let rest = &uri[scheme.len() + 1..];
            // file:///C:/x and file://localhost/x: the authority is empty or this machine.
            let rest = rest.strip_prefix("//localhost").or(rest.strip_prefix("//")).unwrap_or(rest);
            let drive = rest.as_bytes().get(2) == Some(&b':');
            if drive { rest.trim_start_matches('/') } else { rest }
        }
        Some(scheme) => return Err(format!("has the scheme `{scheme}:`; only files are read")),
        None => uri,
    };
    Ok(percent_decode(rest).replace('\\', "/"))
}

/// `%20` -> space. Escapes that do not give UTF-8 are left as they are.
pub fn percent_decode(text: &str) -> String {
    let bytes = text.as_bytes();
    let digit = |index: usize| bytes.get(index).and_then(|&byte| char::from(byte).to_digit(16));
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut position = 0;
    while position < bytes.len() {
        match (bytes[position], digit(position + 1), digit(position + 2)) {
            (b'%', Some(high), Some(low)) => {
                // Two hexadecimal digits are below 256.
                decoded.push((high * 16 + low) as u8);
                position += 3;
            }
            (byte, _, _) => {
                decoded.push(byte);
                position += 1;
            }
        }
    }
    String::from_utf8(decoded).unwrap_or_else(|_| text.to_owned())
}
