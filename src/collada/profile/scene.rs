//! `<environment>`, `<lens>`, `<render>`: what surrounds the scene and how it is looked at.

use glam::Vec3;

use crate::collada::error::Fault;
use crate::collada::images;
use crate::collada::loader::Loader;
use crate::collada::xml::Element;
use crate::document::{Environment, Lens, RenderHints};

use super::spectrum;
use super::strict::{Bounds, Strict, at_most_one, only_children};

/// The technique of a `<visual_scene>`.
pub fn environment<'a>(loader: &mut Loader<'a>, technique: Element<'a>) -> Result<Option<Environment>, Fault> {
    only_children(technique, &["environment"])?;
    let Some(element) = at_most_one(technique, &["environment"])? else { return Ok(None) };
    let mut strict = Strict::new(element);
    let uri = strict.text("image");
    let radiance = strict.rgb("radiance", Bounds::AtLeast(0.0))?;
    if uri.is_none() && radiance.is_none() {
        return Err(element.fault("<environment> has neither `image` nor `radiance`"));
    }
    let environment = Environment {
        image: uri.map(|uri| images::from_attribute(loader, element, uri, "the environment")).transpose()?,
        radiance: radiance.unwrap_or(Vec3::ONE),
        strength: strict.number("strength", Bounds::AtLeast(0.0))?.unwrap_or(1.0),
        rotation_deg: strict.number("rotation_deg", Bounds::Any)?.unwrap_or(0.0),
        spectrum: spectrum::read(&mut strict, "spectrum")?.unwrap_or_default(),
    };
    strict.finish(&[])?;
    Ok(Some(environment))
}

/// The technique of a `<camera>`.
pub fn lens(technique: Element) -> Result<Option<Lens>, Fault> {
    only_children(technique, &["lens"])?;
    let Some(element) = at_most_one(technique, &["lens"])? else { return Ok(None) };
    let mut strict = Strict::new(element);
    let f_number = strict.number("f_number", Bounds::Positive)?;
    let focal_mm = strict.number("focal_mm", Bounds::Positive)?;
    let radius = strict.number("aperture_radius_m", Bounds::AtLeast(0.0))?;
    strict.not_both("f_number", "aperture_radius_m")?;
    let aperture_radius_m = match (radius, f_number, focal_mm) {
        (Some(radius), _, _) => radius,
        // The f-number is focal length over aperture diameter.
        (None, Some(f_number), Some(focal_mm)) => focal_mm / 1000.0 / (2.0 * f_number),
        (None, Some(_), None) => return Err(element.fault("<lens> has `f_number` but no `focal_mm`")),
        (None, None, _) => {
            return Err(element.fault("<lens> has neither `f_number` with `focal_mm` nor `aperture_radius_m`"));
        }
    };
    let focus = strict.number("focus_distance_m", Bounds::Positive)?;
    let focus_distance_m = strict.required("focus_distance_m", focus)?;
    let blades = strict.whole("blades", 0, 64)?.unwrap_or(0);
    strict.finish(&[])?;
    Ok(Some(Lens { aperture_radius_m, focus_distance_m, blades }))
}

/// The technique of `<scene>`.
pub fn render<'a>(loader: &Loader<'a>, technique: Element<'a>) -> Result<RenderHints, Fault> {
    only_children(technique, &["render"])?;
    let Some(element) = at_most_one(technique, &["render"])? else { return Ok(RenderHints::default()) };
    let mut strict = Strict::new(element);
    let hints = RenderHints {
        width: strict.whole("width", 1, 65_535)?,
        height: strict.whole("height", 1, 65_535)?,
        pixel_aspect: strict.number("pixel_aspect", Bounds::Within(0.01, 100.0))?,
        spp: strict.whole("spp", 1, u32::MAX)?,
        seed: strict.whole("seed", 0, u32::MAX)?,
        max_bounces: strict.whole("max_bounces", 0, u32::MAX)?,
        mode: strict.choice("mode", &["auto", "rgb", "spectral"].map(|mode| (mode, mode)))?.map(str::to_owned),
        tolerance: strict.number("tolerance", Bounds::Positive)?,
        exposure_ev: strict.number("exposure_ev", Bounds::Any)?,
        camera: strict.text("camera").map(str::to_owned),
    };
    if let Some(id) = &hints.camera {
        check_camera(loader, element, id)?;
    }
    strict.finish(&[])?;
    Ok(hints)
}

/// A camera hint names a camera, or a node that holds one.
fn check_camera(loader: &Loader, element: Element, id: &str) -> Result<(), Fault> {
    let is_camera = |candidate: Element| {
        candidate.name() == "camera" || (candidate.name() == "node" && candidate.child("instance_camera").is_some())
    };
    if loader.by_id(id, &["camera", "node"]).is_some_and(is_camera) {
        return Ok(());
    }
    let fault = element.fault_at_value("camera", format!("there is no camera with id `{id}`"));
    Err(fault.suggest(id, loader.xml.all().filter(|candidate| is_camera(*candidate)).filter_map(|c| c.attribute("id"))))
}
