//! `<camera>`.

use glam::Vec2;

use crate::document::{Camera, Projection};

use super::error::Fault;
use super::loader::{Loader, technique};
use super::numbers;
use super::profile;
use super::xml::Element;

/// The camera's index in the document.
pub fn load<'a>(loader: &mut Loader<'a>, camera: Element<'a>) -> Result<usize, Fault> {
    if let Some(&known) = loader.cameras.get(&camera.index()) {
        return Ok(known);
    }
    let Some(optics) = camera.descend(&["optics", "technique_common"]) else {
        return Err(camera.fault("this <camera> has no <optics><technique_common>"));
    };
    let projection = if let Some(perspective) = optics.child("perspective") {
        perspective_of(perspective)?
    } else if let Some(orthographic) = optics.child("orthographic") {
        let (xmag, ymag) = (positive(orthographic, "xmag")?, positive(orthographic, "ymag")?);
        if xmag.is_none() && ymag.is_none() {
            return Err(orthographic.fault("this <orthographic> has neither <xmag> nor <ymag>"));
        }
        Projection::Orthographic { xmag, ymag, aspect: positive(orthographic, "aspect_ratio")? }
    } else {
        return Err(optics.fault("the camera is neither <perspective> nor <orthographic>"));
    };
    let (Projection::Perspective { aspect, .. } | Projection::Orthographic { aspect, .. }) = projection;
    if loader.blender.is_some() && aspect.is_some_and(|aspect| aspect < 1.0) {
        let advice = "Blender writes the extent of its longer side as horizontal: the view is wider than Blender's";
        loader.warnings.add(camera, "a portrait camera from Blender", advice);
    }
    let lens = match profile::of(loader, camera) {
        Some(technique) => profile::scene::lens(technique)?,
        None => None,
    };
    let extra = technique(camera, "blender");
    let shift = |name: &str| extra.and_then(|extra| extra.child(name)).map(numbers::single).transpose();
    let shift = Vec2::new(shift("shiftx")?.unwrap_or(0.0), shift("shifty")?.unwrap_or(0.0));
    let id = camera.attribute("id").unwrap_or_default().to_owned();
    loader.document.cameras.push(Camera { id, projection, lens, shift });
    let index = loader.document.cameras.len() - 1;
    loader.cameras.insert(camera.index(), index);
    Ok(index)
}

fn perspective_of(perspective: Element) -> Result<Projection, Fault> {
    let fov = |name: &str| -> Result<Option<f32>, Fault> {
        let value = positive(perspective, name)?;
        match perspective.child(name).filter(|_| value.is_some_and(|degrees| degrees >= 180.0)) {
            Some(element) => Err(element.fault_at_text(format!("<{name}> must lie between 0 and 180 degrees"))),
            None => Ok(value),
        }
    };
    let (xfov_deg, yfov_deg) = (fov("xfov")?, fov("yfov")?);
    if xfov_deg.is_none() && yfov_deg.is_none() {
        return Err(perspective.fault("this <perspective> has neither <xfov> nor <yfov>"));
    }
    let aspect = positive(perspective, "aspect_ratio")?;
    Ok(Projection::Perspective { xfov_deg, yfov_deg, aspect })
}

fn positive(element: Element, name: &str) -> Result<Option<f32>, Fault> {
    let Some(child) = element.child(name) else { return Ok(None) };
    let value = numbers::single(child)?;
    if value <= 0.0 {
        return Err(child.fault_at_text(format!("<{name}> is {value}; it must be greater than 0")));
    }
    Ok(Some(value))
}
