//! XML examples load without a warning, and nothing that the loader knows of our profile goes without one.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use pellicle::collada::{LoadOptions, load};
use pellicle::document::Preset;
use quick_xml::Reader;
use quick_xml::events::Event;

use super::{blocks, documents, root};
use crate::cli::Folder;

/// Attributes that several elements share: one example for all of them will do.
const SHARED: [&str; 5] = ["colorspace", "texcoord", "wrap", "wrap_s", "wrap_t"];

/// What fragments are put into, by the names of their gaps.
const SCENE: &str = r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_cameras><camera id="camera"><optics><technique_common><perspective><xfov>40</xfov><aspect_ratio>1</aspect_ratio>
</perspective></technique_common></optics><extra><technique profile="pellicle">{camera}</technique></extra></camera></library_cameras>
<library_lights>{lights}</library_lights><library_effects>{effects}</library_effects><library_materials>{materials}</library_materials>
<library_geometries>{geometries}<geometry id="leaf"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common><accessor source="#pa" count="3" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<source id="t"><float_array id="ta" count="6">0 0 1 0 0 1</float_array><technique_common><accessor source="#ta" count="3" stride="2">
<param name="S" type="float"/><param name="T" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1" material="m">
<input semantic="VERTEX" source="#v" offset="0"/><input semantic="TEXCOORD" source="#t" offset="0" set="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node id="view"><translate>0 0 9</translate><instance_camera url="#camera"/></node>
{nodes}<extra><technique profile="pellicle">{surroundings}</technique></extra></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/><extra><technique profile="pellicle">{scene}</technique></extra></scene></COLLADA>"##;

/// Where a fragment belongs, by the name of its element.
#[derive(Clone, Copy)]
enum Place {
    /// Ours, in the technique of an `<effect>`.
    Base,
    /// A child of an `<effect>`.
    InEffect,
    Effect,
    /// Ours, in the technique of a `<light>`.
    InLight,
    Light,
    Geometry,
    /// Ours, in the technique of the camera, of the visual scene, of the scene.
    InCamera,
    InVisualScene,
    InScene,
    /// In the `<animation>` of the whole scene of docs/format.md.
    Channel,
}

fn place(name: &str) -> Option<Place> {
    Some(match name {
        "diffuse" | "conductor" | "dielectric" | "emitter" | "preset" => Place::Base,
        "extra" => Place::InEffect,
        "effect" => Place::Effect,
        "area" | "spectrum" => Place::InLight,
        "light" => Place::Light,
        "geometry" => Place::Geometry,
        "lens" => Place::InCamera,
        "environment" => Place::InVisualScene,
        "render" => Place::InScene,
        "channel" => Place::Channel,
        _ => return None,
    })
}

impl Place {
    /// Whether the element is one of our profile's.
    fn is_ours(self) -> bool {
        use Place::*;
        matches!(self, Base | InLight | InCamera | InVisualScene | InScene)
    }
}

/// A start tag: its element's name, where it begins and ends, and whether it closes itself.
struct Tag {
    name: String,
    start: usize,
    end: usize,
    is_empty: bool,
    /// The name of the element that it stands in, and its attributes.
    parent: String,
    attributes: Vec<String>,
}

/// All start tags of well-formed XML, and for each top-level element the bytes that it covers.
fn tags(xml: &str) -> (Vec<Tag>, Vec<std::ops::Range<usize>>) {
    let mut reader = Reader::from_str(xml);
    let (mut tags, mut roots, mut open): (Vec<Tag>, Vec<_>, Vec<(String, usize)>) = Default::default();
    loop {
        let start = reader.buffer_position() as usize;
        let event = reader.read_event().unwrap();
        let end = reader.buffer_position() as usize;
        match &event {
            Event::Start(tag) | Event::Empty(tag) => {
                let name = String::from_utf8(tag.name().as_ref().to_vec()).unwrap();
                let keys = tag.attributes().map(|a| String::from_utf8(a.unwrap().key.as_ref().to_vec()).unwrap());
                let is_empty = matches!(event, Event::Empty(_));
                let parent = open.last().map_or(String::new(), |(name, _)| name.clone());
                tags.push(Tag { name: name.clone(), start, end, is_empty, parent, attributes: keys.collect() });
                if !is_empty {
                    open.push((name, start));
                } else if open.is_empty() {
                    roots.push(start..end);
                }
            }
            Event::End(_) => {
                let (_, begun) = open.pop().unwrap();
                if open.is_empty() {
                    roots.push(begun..end);
                }
            }
            Event::Eof => return (tags, roots),
            _ => {}
        }
    }
}

fn attribute<'a>(xml: &'a str, name: &str) -> Option<&'a str> {
    xml.split_once(&format!(" {name}=\""))?.1.split('"').next()
}

/// A scene around fragments; an error names the element whose place nobody knows.
fn wrapped(fragments: &str, whole: &str) -> Result<String, String> {
    let mut gaps: BTreeMap<&str, String> = BTreeMap::new();
    let mut scene = SCENE.to_owned();
    for (i, range) in tags(fragments).1.into_iter().enumerate() {
        let xml = &fragments[range];
        let name: String = xml[1..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let mut put = |gap: &'static str, text: String| *gaps.entry(gap).or_default() += &text;
        let ours = |xml: &str| format!("<extra><technique profile=\"pellicle\">{xml}</technique></extra>");
        let common = "<technique_common><point><color>1 1 1</color></point></technique_common>";
        let leaf = |material: &str| {
            format!(
                "<node id=\"node-{i}\"><instance_geometry url=\"#leaf\"><bind_material><technique_common><instance_material \
                 symbol=\"m\" target=\"#{material}\"><bind_vertex_input semantic=\"UVMap\" input_semantic=\"TEXCOORD\" \
                 input_set=\"0\"/></instance_material></technique_common></bind_material></instance_geometry></node>"
            )
        };
        match place(&name).ok_or(name)? {
            at @ (Place::Base | Place::InEffect | Place::Effect) => {
                let effect = match at {
                    Place::Base => format!("<effect id=\"effect-{i}\">{}</effect>", ours(xml)),
                    Place::InEffect => format!("<effect id=\"effect-{i}\">{xml}</effect>"),
                    _ => xml.to_owned(),
                };
                let id = attribute(&effect, "id").unwrap();
                let material = format!("<material id=\"m-{id}\"><instance_effect url=\"#{id}\"/></material>");
                put("{materials}", material);
                put("{nodes}", leaf(&format!("m-{id}")));
                put("{effects}", effect);
            }
            at @ (Place::InLight | Place::Light) => {
                let light = match at {
                    Place::InLight => format!("<light id=\"light-{i}\">{common}{}</light>", ours(xml)),
                    _ => xml.to_owned(),
                };
                let id = attribute(&light, "id").unwrap();
                let up = "<translate>0 0 3</translate>";
                put("{nodes}", format!("<node id=\"node-{i}\">{up}<instance_light url=\"#{id}\"/></node>"));
                put("{lights}", light);
            }
            Place::Geometry => {
                let id = attribute(xml, "id").unwrap();
                let bound = attribute(xml, "material").map_or(String::new(), |symbol| {
                    put("{effects}", format!("<effect id=\"effect-{i}\">{}</effect>", ours("<diffuse/>")));
                    put(
                        "{materials}",
                        format!("<material id=\"m-{i}\"><instance_effect url=\"#effect-{i}\"/></material>"),
                    );
                    format!(
                        "<bind_material><technique_common><instance_material symbol=\"{symbol}\" target=\"#m-{i}\"/>\
                         </technique_common></bind_material>"
                    )
                });
                let instance = format!("<instance_geometry url=\"#{id}\">{bound}</instance_geometry>");
                put("{nodes}", format!("<node id=\"node-{i}\">{instance}</node>"));
                put("{geometries}", xml.to_owned());
            }
            Place::InCamera => put("{camera}", xml.to_owned()),
            Place::InVisualScene => put("{surroundings}", xml.to_owned()),
            Place::InScene => put("{scene}", xml.to_owned()),
            Place::Channel => scene = whole.replace("</animation>", &format!("{xml}</animation>")),
        }
    }
    for gap in scene_gaps() {
        scene = scene.replace(gap, gaps.get(gap).map_or("", String::as_str));
    }
    // An empty technique is an error of its own.
    Ok(scene.replace("<extra><technique profile=\"pellicle\"></technique></extra>", ""))
}

fn scene_gaps() -> impl Iterator<Item = &'static str> {
    SCENE.match_indices('{').map(|(start, _)| &SCENE[start..start + SCENE[start..].find('}').unwrap() + 1])
}

/// The scene that docs/format.md shows whole.
pub fn whole_scene() -> String {
    let blocks = blocks("docs/format.md");
    blocks.into_iter().find(|block| block.text.starts_with("<COLLADA")).unwrap().text
}

/// Puts the images and models there that an example names.
fn add_files(folder: &Folder, xml: &str) {
    for name in xml.split("<mesh file=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        fs::write(folder.file(name), TRIANGLE).unwrap();
    }
    for name in xml.split(" image=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        let path = folder.file(name);
        if Path::new(&path).exists() {
            continue;
        }
        match Path::new(name).extension().and_then(|extension| extension.to_str()) {
            Some("exr") => exr::prelude::write_rgb_file(&path, 4, 2, |_, _| (1.0f32, 0.8, 0.6)).unwrap(),
            _ => drop(fs::copy(root().join("tests/data/good/dot.png"), &path).unwrap()),
        }
    }
}

/// Loads the text; `Err` has the error or the warnings.
fn loads(folder: &Folder, xml: &str) -> Result<(), String> {
    let path = folder.file("example.dae");
    fs::write(&path, xml).unwrap();
    match load(Path::new(&path), &LoadOptions::default()) {
        Err(error) => Err(error.to_string()),
        Ok((_, warnings)) if warnings.is_empty() => Ok(()),
        Ok((_, warnings)) => Err(warnings.iter().map(|warning| format!("warning: {warning}\n")).collect()),
    }
}

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn every_example_loads_without_a_warning() {
    let folder = Folder::new("examples");
    let whole = whole_scene();
    let (mut failures, mut count) = (Vec::new(), 0);
    for document in documents() {
        for block in blocks(&document).into_iter().filter(super::Block::is_xml) {
            count += 1;
            add_files(&folder, &block.text);
            let xml = match block.text.starts_with("<COLLADA") {
                true => Ok(block.text),
                false => wrapped(&block.text, &whole)
                    .map_err(|name| format!("where does <{name}> stand? tell `place` in tests/documents/examples.rs")),
            };
            if let Err(message) = xml.and_then(|xml| loads(&folder, &xml)) {
                failures.push(format!("{}: {message}", block.place));
            }
        }
    }
    assert!(count >= 25, "{count} examples");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Words between quotation marks in the source of our profile: whatever the loader asks for is among them.
fn words_of_the_loader() -> BTreeSet<String> {
    let mut words: BTreeSet<String> = Preset::all().iter().map(|preset| preset.knob.name.to_owned()).collect();
    for file in super::files("src/collada/profile", "rs") {
        for line in fs::read_to_string(file).unwrap().lines().filter(|line| !line.trim_start().starts_with("//")) {
            let quoted = line.split('"').skip(1).step_by(2);
            let is_name = |word: &&str| {
                !matches!(*word, "" | "xmlns") && word.chars().all(|c| c.is_ascii_lowercase() || c == '_')
            };
            words.extend(quoted.filter(is_name).map(str::to_owned));
        }
    }
    words
}

/// The name under which an element is known; maps of films and of bases have different attributes.
fn key(tag: &Tag) -> String {
    if tag.name == "map" && tag.parent == "film" { "film/map".to_owned() } else { tag.name.clone() }
}

/// Every word is tried as an attribute and as a child of every element, and alone in every place: what the loader does not
/// call unknown needs an example.
#[test]
fn whatever_our_profile_knows_has_an_example() {
    let folder = Folder::new("examples-known");
    let words = words_of_the_loader();
    let mut shown: BTreeSet<String> = BTreeSet::new();
    let mut known: BTreeSet<String> = BTreeSet::new();
    let mut probed: BTreeSet<String> = BTreeSet::new();
    let is_known = |text: &str, unknown: String| {
        let scene = wrapped(text, "").unwrap();
        // <film> in <emitter> is refused in words of its own.
        let refused = |message: &String| message.contains(&unknown) || message.contains("can have no <film>");
        !loads(&folder, &scene).err().is_some_and(|message| refused(&message))
    };
    for block in blocks("docs/format.md").into_iter().filter(super::Block::is_xml) {
        let text = block.text;
        let (tags, _) = tags(&text);
        for tag in &tags {
            shown.extend(tag.attributes.iter().map(|name| format!("{} {name}=", key(tag))));
            shown.insert(format!("{} <{}>", tag.parent, tag.name));
            shown.insert(format!("<{}>", tag.name));
        }
        if !place(&tags[0].name).is_some_and(Place::is_ours) {
            continue;
        }
        add_files(&folder, &text);
        for tag in tags {
            let key = key(&tag);
            if !probed.insert(format!("{key} {:?}", attribute(&text[tag.start..tag.end], "name"))) {
                continue;
            }
            let name_end = tag.start + 1 + tag.name.len();
            for word in &words {
                if !tag.attributes.contains(word) {
                    let probe = format!("{} {word}=\"1\"{}", &text[..name_end], &text[name_end..]);
                    if is_known(&probe, format!("unknown attribute `{word}` of <{}>", tag.name)) {
                        known.insert(format!("{key} {word}="));
                    }
                }
                let opened = match tag.is_empty {
                    true => format!("{}><{word}/></{}>", &text[..tag.end - 2], tag.name),
                    false => format!("{}<{word}/>", &text[..tag.end]),
                };
                let probe = opened + &text[tag.end..];
                if is_known(&probe, format!("unknown element <{word}> in <{}>", tag.name)) {
                    known.insert(format!("{} <{word}>", tag.name));
                }
            }
        }
    }
    for (gap, word) in scene_gaps().flat_map(|gap| words.iter().map(move |word| (gap, word))) {
        let in_technique = match gap {
            "{camera}" | "{surroundings}" | "{scene}" => true,
            "{effects}" | "{lights}" => false,
            _ => continue,
        };
        let probe = match in_technique {
            true => SCENE.replace(gap, &format!("<{word}/>")),
            false => {
                let root = if gap == "{effects}" { "diffuse" } else { "area" };
                wrapped(&format!("<{root}/>"), "").unwrap().replace(&format!("<{root}/>"), &format!("<{word}/>"))
            }
        };
        let scene = scene_gaps().fold(probe, |scene, gap| scene.replace(gap, ""));
        let scene = scene.replace("<extra><technique profile=\"pellicle\"></technique></extra>", "");
        let message = loads(&folder, &scene).err().unwrap_or_default();
        if !message.contains(&format!("unknown element <{word}>")) {
            known.insert(format!("<{word}>"));
        }
    }
    // The first <area> shows no radiance, so it is the loader that knows of it.
    assert!(known.contains("area radiance=") && known.contains("<lens>"), "the loader seems to know only {known:?}");
    let missing: Vec<&String> = known
        .iter()
        .filter(|name| !shown.contains(*name))
        .filter(|name| {
            let shared = SHARED.iter().find(|shared| name.ends_with(&format!(" {shared}=")));
            shared.is_none_or(|shared| !shown.iter().any(|other| other.ends_with(&format!(" {shared}="))))
        })
        .collect();
    assert!(missing.is_empty(), "docs/format.md has no example of {missing:#?}");
}

#[test]
fn every_material_of_the_course_has_an_example() {
    let source = fs::read_to_string(root().join("src/collada/cgl.rs")).unwrap();
    let kinds = source.lines().find(|line| line.starts_with("const KINDS")).unwrap();
    let format = fs::read_to_string(root().join("docs/format.md")).unwrap();
    let names: Vec<&str> = kinds.split('"').skip(1).step_by(2).collect();
    assert!(names.len() >= 6, "{kinds}");
    for name in names {
        assert!(format.contains(&format!("</{name}>")), "docs/format.md has no example of CGL's <{name}>");
    }
}
