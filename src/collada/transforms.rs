//! The transform elements of a `<node>`, kept apart so that animations can address them.

use glam::{Mat4, Vec3};

use crate::document::{Transform, TransformKind};

use super::error::Fault;
use super::numbers;
use super::xml::Element;

/// The elements that are transforms.
pub const NAMES: [&str; 6] = ["matrix", "translate", "scale", "rotate", "lookat", "skew"];

/// In document order, which is the order of composition.
pub fn read(node: Element) -> Result<Vec<Transform>, Fault> {
    let mut transforms = Vec::new();
    for element in node.children() {
        let kind = match element.name() {
            "matrix" => TransformKind::Matrix(matrix(element)?),
            "translate" => TransformKind::Translate(numbers::fixed::<3>(element)?.into()),
            "scale" => TransformKind::Scale(numbers::fixed::<3>(element)?.into()),
            "rotate" => {
                let [x, y, z, angle_deg] = numbers::fixed::<4>(element)?;
                TransformKind::Rotate { axis: Vec3::new(x, y, z), angle_deg }
            }
            "lookat" => {
                let [eye, target, up] = triples(numbers::fixed::<9>(element)?);
                if (target - eye).cross(up).length_squared() == 0.0 {
                    return Err(
                        element.fault_at_text("the direction and the up vector of <lookat> do not span a plane")
                    );
                }
                TransformKind::LookAt { eye, target, up }
            }
            "skew" => {
                let [angle_deg, rx, ry, rz, tx, ty, tz] = numbers::fixed::<7>(element)?;
                TransformKind::Skew { angle_deg, rotation: Vec3::new(rx, ry, rz), translation: Vec3::new(tx, ty, tz) }
            }
            _ => continue,
        };
        transforms.push(Transform { sid: element.attribute("sid").unwrap_or_default().to_owned(), kind });
    }
    Ok(transforms)
}

/// 16 numbers, row by row, for column vectors.
pub fn matrix(element: Element) -> Result<Mat4, Fault> {
    numbers::fixed::<16>(element).map(|rows| Mat4::from_cols_array(&rows).transpose())
}

fn triples([a, b, c, d, e, f, g, h, i]: [f32; 9]) -> [Vec3; 3] {
    [Vec3::new(a, b, c), Vec3::new(d, e, f), Vec3::new(g, h, i)]
}
