//! The state of one load: the parsed file, its ids, what has been read so far.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use crate::document::{Document, Material};

use super::LoadOptions;
use super::blender::Version;
use super::error::Fault;
use super::lights::LoadedLight;
use super::nodes::NodeMemo;
use super::package::Package;
use super::warnings::Warnings;
use super::xml::{Element, Xml};

pub struct Loader<'a> {
    pub xml: &'a Xml,
    pub options: &'a LoadOptions,
    pub package: &'a Package,
    pub document: Document,
    pub warnings: Warnings,
    /// The Blender that wrote the file, if one did.
    pub blender: Option<Version>,
    /// Metres per file unit.
    pub meter: f32,
    /// (element name, id) -> element: exporters reuse an id for things of different kinds.
    ids: HashMap<(&'a str, &'a str), usize>,
    /// `<technique profile="pellicle">` elements that have been read.
    pub profile_read: HashSet<usize>,
    /// Element index -> index in the document; `None` for what has no shape.
    pub geometries: HashMap<usize, Option<usize>>,
    pub materials: HashMap<usize, usize>,
    pub effects_read: HashSet<usize>,
    pub images: HashMap<String, usize>,
    pub lights: HashMap<usize, LoadedLight>,
    /// The element of each light in the document.
    pub light_elements: Vec<Element<'a>>,
    /// Light index -> total power in W per channel, to become radiance once the area is known.
    pub powers: Vec<(usize, glam::Vec3)>,
    /// Lights that came from a CGL `<area>`.
    pub cgl_areas: HashSet<usize>,
    pub cameras: HashMap<usize, usize>,
    pub nodes: HashMap<usize, NodeMemo>,
    default_material: Option<usize>,
    /// Bytes that the document may still take.
    memory: u64,
}

impl<'a> Loader<'a> {
    pub fn new(xml: &'a Xml, options: &'a LoadOptions, package: &'a Package) -> Self {
        let mut loader = Self {
            xml,
            options,
            package,
            document: Document::default(),
            warnings: Warnings::default(),
            blender: None,
            meter: 1.0,
            ids: HashMap::new(),
            profile_read: HashSet::new(),
            geometries: HashMap::new(),
            materials: HashMap::new(),
            effects_read: HashSet::new(),
            images: HashMap::new(),
            lights: HashMap::new(),
            light_elements: Vec::new(),
            powers: Vec::new(),
            cgl_areas: HashSet::new(),
            cameras: HashMap::new(),
            nodes: HashMap::new(),
            default_material: None,
            memory: xml.left_bytes,
        };
        for element in xml.all() {
            let Some(id) = element.attribute("id") else { continue };
            match loader.ids.entry((element.name(), id)) {
                Entry::Vacant(entry) => {
                    entry.insert(element.index());
                }
                Entry::Occupied(_) => {
                    let seen = format!("id `{id}` is used by more than one <{}>", element.name());
                    loader.warnings.add(element, seen, "the first one counts");
                }
            }
        }
        loader
    }

    /// The first element of one of these names with that id.
    pub fn by_id(&self, id: &str, names: &[&str]) -> Option<Element<'a>> {
        let index = names.iter().find_map(|name| self.ids.get(&(*name, id)))?;
        Some(Element::new(self.xml, *index))
    }

    /// Resolves `attribute="#id"` of `element` to an element of one of the `wanted` names.
    pub fn follow(&self, element: Element<'a>, attribute: &str, wanted: &[&str]) -> Result<Element<'a>, Fault> {
        let Some(reference) = element.attribute(attribute) else {
            return Err(element.fault(format!("<{}> has no `{attribute}`", element.name())));
        };
        let kind = wanted.join("> or <");
        let fault = |message: String| element.fault_at_value(attribute, message);
        let Some(id) = reference.strip_prefix('#') else {
            if reference.contains('#') {
                let hint = "references into other files are not followed: copy the element into this file";
                return Err(fault(format!("`{reference}` lies in another file")).hint(hint));
            }
            return Err(fault(format!("`{reference}` is not a reference")).hint(format!("write `#{reference}`")));
        };
        if let Some(target) = self.by_id(id, wanted) {
            return Ok(target);
        }
        match self.xml.all().find(|other| other.attribute("id") == Some(id)) {
            Some(other) => Err(fault(format!("`{reference}` is a <{}>, wanted is a <{kind}>", other.name()))),
            None => {
                let ids = self.ids.keys().filter(|(name, _)| wanted.contains(name));
                Err(fault(format!("there is no <{kind}> with id `{id}`")).suggest(id, ids.map(|(_, id)| *id)))
            }
        }
    }

    /// Counts what `element` has added to the document: few bytes of a file can stand for many, as several elements may
    /// refer to the same data.
    pub fn take(&mut self, element: Element, bytes: usize) -> Result<(), Fault> {
        let most = self.options.max_bytes;
        self.memory = self.memory.checked_sub(bytes as u64).ok_or_else(|| {
            element
                .fault(format!(
                    "with this <{}> the file and its scene take more than {most} bytes of memory",
                    element.name()
                ))
                .hint("raise --max-memory if the file is right")
        })?;
        Ok(())
    }

    /// The index of the grey diffuse material for surfaces that name none.
    pub fn default_material(&mut self) -> usize {
        match self.default_material {
            Some(index) => index,
            None => {
                self.document.materials.push(Material::default());
                let index = self.document.materials.len() - 1;
                self.default_material = Some(index);
                index
            }
        }
    }
}

/// The `<technique>` of that profile in any `<extra>` directly below.
pub fn technique<'a>(element: Element<'a>, profile: &str) -> Option<Element<'a>> {
    element
        .children_named("extra")
        .flat_map(|extra| extra.children_named("technique"))
        .find(|technique| technique.attribute("profile") == Some(profile))
}
