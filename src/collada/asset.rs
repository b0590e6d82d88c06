//! `<asset>`: the unit, the up axis, and the program that wrote the file.

use glam::{Mat3, Mat4, Vec3};

use super::UpAxis;
use super::blender;
use super::error::Fault;
use super::loader::Loader;
use super::xml::Element;

/// Reads the file's `<asset>` and the override in the `<visual_scene>`; sets `to_world`.
pub fn read<'a>(loader: &mut Loader<'a>, visual_scene: Element<'a>) -> Result<(), Fault> {
    let root = loader.xml.root();
    let asset = root.child("asset");
    let mut up_axis = None;
    let mut meter = None;
    if let Some(asset) = asset {
        up_axis = read_up_axis(asset)?;
        meter = read_unit(asset)?;
        loader.blender =
            asset.descend(&["contributor", "authoring_tool"]).and_then(|tool| blender::version(&tool.text()));
    }
    if up_axis.is_none() && loader.options.up_axis.is_none() {
        loader.warnings.add(asset.unwrap_or(root), "the file names no <up_axis>", "Y_UP is assumed");
    }
    if meter.is_none() {
        loader.warnings.add(asset.unwrap_or(root), "the file names no <unit>", "1 unit = 1 m is assumed");
    }
    if let Some(nested) = visual_scene.child("asset") {
        up_axis = read_up_axis(nested)?.or(up_axis);
        meter = read_unit(nested)?.or(meter);
    }
    let up_axis = loader.options.up_axis.or(up_axis).unwrap_or(UpAxis::Y);
    loader.meter = meter.unwrap_or(1.0);
    loader.document.to_world = Mat4::from_scale(Vec3::splat(loader.meter)) * Mat4::from_mat3(up_axis.to_y_up());
    warn_nested(loader, up_axis)
}

/// Overrides further down would make one scene of several frames; they are reported where they differ.
fn warn_nested(loader: &mut Loader, up_axis: UpAxis) -> Result<(), Fault> {
    for asset in loader.xml.all().filter(|element| element.name() == "asset") {
        let Some(owner) = asset.parent().map(|parent| parent.name()) else { continue };
        if matches!(owner, "COLLADA" | "visual_scene") {
            continue;
        }
        let differs = read_up_axis(asset)?.is_some_and(|own| own != up_axis)
            || read_unit(asset)?.is_some_and(|own| own != loader.meter);
        if differs {
            let seen = format!("a <{owner}> has its own <unit> or <up_axis>");
            loader.warnings.add(asset, seen, "it is ignored: those of the file count");
        }
    }
    Ok(())
}

impl UpAxis {
    /// Rotation that makes this axis world +Y.
    fn to_y_up(self) -> Mat3 {
        match self {
            Self::X => Mat3::from_cols(Vec3::Y, Vec3::NEG_X, Vec3::Z),
            Self::Y => Mat3::IDENTITY,
            Self::Z => Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y),
        }
    }
}

fn read_up_axis(asset: Element) -> Result<Option<UpAxis>, Fault> {
    let Some(element) = asset.child("up_axis") else { return Ok(None) };
    let text = element.text();
    match text.as_ref() {
        "X_UP" => Ok(Some(UpAxis::X)),
        "Y_UP" => Ok(Some(UpAxis::Y)),
        "Z_UP" => Ok(Some(UpAxis::Z)),
        other => {
            let fault = element.fault_at_text(format!("unknown up axis `{other}`"));
            Err(fault.suggest(other, ["X_UP", "Y_UP", "Z_UP"]))
        }
    }
}

fn read_unit(asset: Element) -> Result<Option<f32>, Fault> {
    let Some(unit) = asset.child("unit") else { return Ok(None) };
    let Some(text) = unit.attribute("meter") else { return Ok(None) };
    match text.trim().parse::<f32>() {
        Ok(meter) if meter > 0.0 && meter.is_finite() => Ok(Some(meter)),
        _ => Err(unit.fault_at_value("meter", format!("a unit of `{text}` m is not a positive number"))),
    }
}
