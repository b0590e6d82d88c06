//! Lights by name, so that each can have a picture of its own.

use std::collections::BTreeSet;

use crate::document::{Document, Item};
use crate::mode::GROUPS;

/// Which group each light belongs to: the environment, each light and each shining material that is placed has its own,
/// called by its id. Where they are more than the modes tell apart, ids that differ in their last number (`window-01`,
/// `window-02`) go together; and if they still are, the last group is the `rest`. Empty: one group, without a name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightGroups {
    pub names: Vec<String>,
    /// By the document's numbers.
    lights: Vec<usize>,
    materials: Vec<usize>,
}

impl LightGroups {
    pub fn new(document: &Document) -> Self {
        let [mut lights, mut materials] = [BTreeSet::new(), BTreeSet::new()];
        for (node, _) in document.placements() {
            for item in &document.nodes[node].items {
                match item {
                    Item::Light(light) => lights.extend([*light]),
                    Item::Geometry { bindings, .. } => materials.extend(bindings.iter().map(|b| b.material)),
                    Item::Camera(_) => {}
                }
            }
        }
        materials.retain(|&material| document.materials[material].emission.is_some());

        let gather = |name: fn(&str) -> String| {
            let mut groups = Self {
                names: document.environment.iter().map(|_| "environment".to_owned()).collect(),
                lights: vec![0; document.lights.len()],
                materials: vec![0; document.materials.len()],
            };
            for &light in &lights {
                groups.lights[light] = groups.group_of(name(&document.lights[light].id));
            }
            for &material in &materials {
                groups.materials[material] = groups.group_of(name(&document.materials[material].id));
            }
            groups
        };
        let mut groups = gather(str::to_owned);
        if groups.names.len() > GROUPS {
            groups = gather(|id| id.trim_end_matches(|c: char| !c.is_alphabetic()).to_owned());
        }
        if groups.names.len() > GROUPS {
            groups.names.truncate(GROUPS - 1);
            groups.names.push("rest".to_owned());
        }
        groups
    }

    /// The group of this name, a new one if need be.
    fn group_of(&mut self, name: String) -> usize {
        // Dots part layers from channels, slashes folders from files.
        let name = if name.is_empty() { "light".to_owned() } else { name.replace(['.', '/', '\\'], "_") };
        let known = self.names.iter().position(|known| *known == name);
        known.unwrap_or_else(|| {
            self.names.push(name);
            self.names.len() - 1
        })
    }

    pub(super) fn of_light(&self, light: usize) -> usize {
        self.lights.get(light).map_or(0, |&group| group.min(GROUPS - 1))
    }

    pub(super) fn of_material(&self, material: usize) -> usize {
        self.materials.get(material).map_or(0, |&group| group.min(GROUPS - 1))
    }

    /// It has the first group, if there is one.
    pub(super) fn of_environment(&self) -> usize {
        0
    }
}
