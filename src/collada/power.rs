//! Area lights given in watts: radiance once the area in the world is known.

use std::collections::BTreeMap;
use std::f32::consts::PI;

use glam::{Mat4, Vec3};

use crate::document::{AreaShape, Item, LightKind};

use super::loader::Loader;

/// World-space area in m2 of an area light under a matrix.
pub fn area(shape: AreaShape, to_world: &Mat4) -> f32 {
    let (x, y) = (to_world.x_axis.truncate(), to_world.y_axis.truncate());
    match shape {
        AreaShape::Rectangle => x.cross(y).length(),
        AreaShape::Disk => PI / 4.0 * x.cross(y).length(),
        // Unit diameter: 4 pi (|x| / 2)^2.
        AreaShape::Sphere => PI * x.length_squared(),
    }
}

/// Radiance = power / (pi area), for a lambertian emitter. The first instance of a light decides.
pub fn distribute(loader: &mut Loader) {
    let powers: BTreeMap<usize, Vec3> = loader.powers.drain(..).collect();
    if powers.is_empty() {
        return;
    }
    let mut areas: BTreeMap<usize, f32> = BTreeMap::new();
    for (node, to_world) in loader.document.placements() {
        for item in &loader.document.nodes[node].items {
            let &Item::Light(light) = item else { continue };
            let LightKind::Area { shape, .. } = loader.document.lights[light].kind else { continue };
            if !powers.contains_key(&light) {
                continue;
            }
            let own = area(shape, &to_world);
            let first = *areas.entry(light).or_insert(own);
            if (own - first).abs() > 1e-3 * first {
                let seen = format!("light `{}` is instantiated with different areas", loader.document.lights[light].id);
                let advice = "its power is spread over the first; the others have the same radiance";
                loader.warnings.add(loader.light_elements[light], seen, advice);
            }
        }
    }
    for (light, area) in areas {
        let entry = &mut loader.document.lights[light];
        if area > 0.0 {
            entry.color = powers[&light] / (PI * area);
        } else {
            entry.color = Vec3::ZERO;
            loader.warnings.add(
                loader.light_elements[light],
                format!("light `{}` has no area", entry.id),
                "it gives no light",
            );
        }
    }
}
