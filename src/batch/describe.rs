//! A scene in words, for `pellicle check`.

use std::fmt::Write;
use std::sync::Arc;

use crate::color::Index;
use crate::document::{
    AreaShape, Base, Document, Film, Item, Light, LightKind, Material, Presence, Projection, Shape, Thickness,
};
use crate::error::Error;
use crate::mode::Rgb;
use crate::scene::{FilmOptions, LightGroups, Scene, Stage, cameras};

/// One section per kind of thing; films with the verdict that rendering would use. The scene may take `max_memory` bytes.
///
/// # Errors
/// What [`Stage::new`] and [`Scene::new`] report: a scene that can be described can be rendered.
pub fn describe(document: &Document, tolerance: f32, max_memory: u64) -> Result<String, Error> {
    let name = document.path.display().to_string();
    let failed = |source| Error::Build { scene: name.clone(), source };
    let stage = Arc::new(Stage::movable(document, 0, Vec::new(), LightGroups::default(), max_memory).map_err(failed)?);
    let scene = Scene::<Rgb>::new(stage.clone(), &FilmOptions { tolerance, rung: None }).map_err(failed)?;
    let mut text = String::new();
    // Writing to a String cannot fail.
    let mut line = |indent: usize, content: String| {
        let _ = writeln!(text, "{:indent$}{content}", "");
    };
    let (low, high) = stage.bounds;
    let size = high - low;
    line(0, name.clone());
    line(2, format!("size {:.4} x {:.4} x {:.4} m", size.x, size.y, size.z));

    let placements = document.placements();
    let mut uses = vec![0usize; document.geometries.len()];
    for (node, _) in &placements {
        for item in &document.nodes[*node].items {
            if let Item::Geometry { geometry, .. } = item {
                uses[*geometry] += 1;
            }
        }
    }
    line(0, format!("geometries: {} ({} placed)", document.geometries.len(), uses.iter().sum::<usize>()));
    for (geometry, uses) in document.geometries.iter().zip(&uses) {
        let what = match &geometry.shape {
            Shape::Sphere { radius } => format!("sphere of radius {radius}"),
            Shape::Mesh(mesh) => {
                let normals = if mesh.normals.is_empty() { "flat" } else { "smooth" };
                let uvs = if mesh.uv_sets.is_empty() { "" } else { ", textured" };
                let dropped = match mesh.degenerate {
                    0 => String::new(),
                    count => format!(", {count} without area dropped"),
                };
                format!("{} triangles, {normals}{uvs}{dropped}", mesh.triangles.len())
            }
        };
        line(2, format!("{}: {what}, placed {uses}x", geometry.id));
    }

    line(0, format!("materials: {}", document.materials.len()));
    for material in &document.materials {
        line(2, format!("{}: {}", material.id, base(material)));
        for film in &material.films {
            line(4, format!("film {}", layer(film)));
        }
        if let Some((_, verdict)) = scene.verdicts().find(|(id, _)| *id == material.id) {
            line(4, format!("{verdict}"));
        }
    }

    let emissive = document.materials.iter().filter(|material| material.emission.is_some()).count();
    line(0, format!("lights: {}, and {emissive} materials that emit", document.lights.len()));
    for light in &document.lights {
        line(2, format!("{}: {}", light.id, light_kind(light)));
    }
    if let Some(environment) = &document.environment {
        let what = match environment.image {
            Some(image) => format!("image {}", document.images[image].uri),
            None => format!("radiance {}", environment.radiance * environment.strength),
        };
        line(2, format!("environment: {what}"));
    }

    let placed_cameras = cameras(document);
    line(0, format!("cameras: {}", placed_cameras.len()));
    for place in &placed_cameras {
        let camera = &document.cameras[place.camera];
        let lens = if camera.lens.is_some() { ", thin lens" } else { "" };
        line(2, format!("{} at node {}: {}{lens}", camera.id, place.node_id, projection(&camera.projection)));
    }

    if !document.images.is_empty() {
        line(0, format!("images: {}", document.images.len()));
        for image in &document.images {
            line(2, image.uri.clone());
        }
    }
    if !document.channels.is_empty() {
        let times = document.channels.iter().flat_map(|c| c.times_s.iter().copied());
        let [first, last] = times.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], t| [a.min(t), b.max(t)]);
        line(0, format!("animation: {} channels, {first:.3} to {last:.3} s", document.channels.len()));
        for channel in &document.channels {
            line(2, format!("{}: {} keys", channel.target, channel.times_s.len()));
        }
    }
    Ok(text)
}

fn base(material: &Material) -> String {
    let shine = match &material.emission {
        Some(emission) => format!("emits {} ", emission.radiance.value),
        None => String::new(),
    };
    let what = match &material.base {
        Base::Black => "black".to_owned(),
        Base::Diffuse { reflectance, .. } => match &reflectance.map {
            Some(_) => "diffuse, textured".to_owned(),
            None => format!("diffuse {}", reflectance.value),
        },
        Base::Conductor { index: metal, microfacets } => {
            format!("conductor {}, roughness {}", index(metal), microfacets.roughness.value)
        }
        Base::Dielectric { index: glass, microfacets, priority, .. } => {
            let medium = priority.map(|priority| format!(", a medium of priority {priority}")).unwrap_or_default();
            format!("dielectric {}, roughness {}{medium}", index(glass), microfacets.roughness.value)
        }
    };
    shine + &what
}

fn index(index: &Index) -> String {
    match index {
        Index::Constant { n, k: 0.0 } => format!("n = {n}"),
        Index::Constant { n, k } => format!("n = {n} + {k}i"),
        Index::Rgb { n, k } => format!("n = {n:?}, k = {k:?}"),
        Index::Table(rows) => format!("n, k table of {} rows", rows.len()),
        Index::Named(name) => name.clone(),
    }
}

fn layer(film: &Film) -> String {
    let thickness = match &film.thickness {
        Thickness::Constant { nm } => format!("{nm} nm"),
        Thickness::Noise { nm, amplitude, frequency, octaves, .. } => {
            format!("{nm} nm, noise {amplitude} at {frequency} per unit, {octaves} octaves")
        }
        Thickness::Drain { top_nm, bottom_nm, .. } => format!("draining from {top_nm} nm at the top to {bottom_nm} nm"),
        Thickness::Map { min_nm, max_nm, .. } => format!("{min_nm} to {max_nm} nm by image"),
    };
    format!("{thickness}, {}", index(&film.index))
}

fn light_kind(light: &Light) -> String {
    let color = light.color;
    match light.kind {
        LightKind::Area { shape, presence } => {
            let shape = match shape {
                AreaShape::Rectangle => "rectangle",
                AreaShape::Disk => "disk",
                AreaShape::Sphere => "sphere",
            };
            let presence = match presence {
                Presence::Solid => "",
                Presence::Ghost => ", in nothing's way",
                Presence::Hidden => ", invisible",
            };
            format!("area {shape}, radiance {color}{presence}")
        }
        LightKind::Point { radius_m: 0.0, .. } => format!("point, {color} W/sr"),
        LightKind::Point { radius_m, .. } => format!("sphere of {radius_m} m, {color} W/sr"),
        LightKind::Spot { cone_deg, .. } => format!("spot of {cone_deg} degrees, {color} W/sr"),
        LightKind::Directional { .. } => format!("directional, {color} W/m2"),
        LightKind::Ambient => format!("upper hemisphere, radiance {color}"),
    }
}

fn projection(projection: &Projection) -> String {
    match *projection {
        Projection::Perspective { xfov_deg: Some(x), .. } => format!("perspective, {x:.2} degrees wide"),
        Projection::Perspective { yfov_deg: Some(y), .. } => format!("perspective, {y:.2} degrees high"),
        Projection::Perspective { .. } => "perspective".to_owned(),
        Projection::Orthographic { .. } => "orthographic".to_owned(),
    }
}
