//! What channels drive, and the values that a posed document has.

use std::path::{Path, PathBuf};

use glam::{Mat4, Vec3};
use pellicle::collada::{self, LoadOptions};
use pellicle::document::{Base, Changes, Document, LightKind, Projection, Thickness, TransformKind};

fn load(path: &Path) -> Document {
    let (document, warnings) = collada::load(path, &LoadOptions::default()).unwrap();
    let text: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert!(!text.iter().any(|warning| warning.contains("animation of `flag")), "{text:?}");
    document
}

fn moving() -> Document {
    load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cli/moving.dae"))
}

fn posed(document: &Document, time_s: f64) -> (Document, Changes) {
    let (mut document, mut changes) = (document.clone(), Changes::default());
    document.pose(time_s, &mut changes).unwrap();
    (document, changes)
}

fn node<'a>(document: &'a Document, id: &str) -> &'a [pellicle::document::Transform] {
    &document.nodes.iter().find(|node| node.id == id).unwrap().transforms
}

#[test]
fn every_kind_of_target_takes_its_value() {
    let document = moving();
    // Tangents as long as the way, without times of their own: a straight line.
    for (time_s, degrees) in [(0.25, 47.5), (0.5, 45.0), (0.75, 42.5)] {
        let (document, _) = posed(&document, time_s);
        let Projection::Perspective { xfov_deg, .. } = document.cameras[0].projection else { panic!("a perspective") };
        assert!((xfov_deg.unwrap() - degrees).abs() < 1e-4, "{xfov_deg:?} at {time_s} s");
    }
    let (_, changes) = posed(&document, 0.5);
    assert_eq!(changes, Changes { cameras: true, ..Changes::default() });

    let (half, changes) = posed(&document, 1.5);
    let flag = node(&half, "flag-node");
    assert!(matches!(flag[0].kind, TransformKind::Translate(at) if at.abs_diff_eq(Vec3::new(0.0, 0.45, 0.0), 1e-6)));
    assert!(matches!(flag[1].kind, TransformKind::Rotate { angle_deg, .. } if angle_deg == 15.0));
    assert!(changes.nodes && !changes.lights && changes.materials.is_empty());

    // Column 3, row 0 of a matrix is where x goes.
    let (half, _) = posed(&document, 4.5);
    let TransformKind::Matrix(stand) = node(&half, "flag-node")[2].kind else { panic!("a matrix") };
    assert_eq!(stand, Mat4::from_translation(Vec3::new(0.2, 0.0, 0.0)) * Mat4::from_scale(Vec3::splat(0.3)));

    let (half, changes) = posed(&document, 2.5);
    let gold = half.materials.iter().position(|material| material.id == "gold").unwrap();
    assert!(matches!(half.materials[gold].films[0].thickness, Thickness::Constant { nm: 400.0 }));
    assert_eq!(changes.materials.into_iter().collect::<Vec<_>>(), [gold]);

    let (half, changes) = posed(&document, 3.5);
    let bulb = half.lights.iter().find(|light| matches!(light.kind, LightKind::Point { .. })).unwrap();
    assert_eq!(bulb.color, Vec3::new(0.75, 0.625, 0.5625));
    assert!(changes.lights);

    let (half, changes) = posed(&document, 5.5);
    let glow = half.materials.iter().find_map(|material| material.emission.as_ref()).unwrap();
    assert_eq!(glow.radiance.value, Vec3::new(3.0, 1.5, 0.75));
    assert!(changes.lights);
}

#[test]
fn a_pose_does_not_depend_on_the_pose_before() {
    let document = moving();
    let (mut wandering, mut changes) = (document.clone(), Changes::default());
    for time_s in [3.5, 0.0, 5.2, 1.25] {
        wandering.pose(time_s, &mut changes).unwrap();
    }
    let (straight, _) = posed(&document, 1.25);
    assert_eq!(format!("{:?}", wandering.nodes), format!("{:?}", straight.nodes));
    assert_eq!(format!("{:?}", wandering.cameras), format!("{:?}", straight.cameras));
    assert_eq!(format!("{:?}", wandering.materials), format!("{:?}", straight.materials));
}

#[test]
fn a_curve_that_leaves_the_range_is_refused_with_its_target() {
    let mut document = moving();
    let error = document.pose(7.0, &mut Changes::default()).unwrap_err().to_string();
    assert!(error.contains("`grey-fx/reflectance` at 7.0000 s") && error.contains("0..1"), "{error}");
    // The curve is in range at its keys, and the document can be posed again.
    document.pose(6.0, &mut Changes::default()).unwrap();
    let Base::Diffuse { reflectance, .. } = &document.materials.iter().find(|m| m.id == "grey").unwrap().base else {
        panic!("a diffuse base")
    };
    assert_eq!(reflectance.value, Vec3::splat(0.5));
}

fn blender(name: &str) -> Option<Document> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/blender").join(name);
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(load(&path))
}

/// Degrees about z in the turntable's own transforms.
fn turned_deg(document: &Document, id: &str) -> f32 {
    let rotation = document.nodes.iter().find(|node| node.id == id).unwrap().local();
    rotation.x_axis.y.atan2(rotation.x_axis.x).to_degrees()
}

/// Two keys, at frames 1 and 24: 0 and 168.7565 degrees.
#[test]
fn blenders_turntable_of_keys_runs_straight_or_eases() {
    for (name, at_quarter) in [
        ("c_turntable_keys_decomposed.dae", 0.25),
        // Control points at a third of the time, values at the ends: v(s) = 3 s^2 - 2 s^3 with s the time.
        ("c_turntable_keys_smooth.dae", 3.0 / 16.0 - 2.0 / 64.0),
    ] {
        let Some(document) = blender(name) else { return };
        for (share, value) in [(0.0, 0.0), (0.25, at_quarter), (0.5, 0.5), (1.0, 1.0), (2.0, 1.0)] {
            let time_s = 1.0 / 24.0 + share * 23.0 / 24.0;
            let (document, _) = posed(&document, time_s);
            let wanted = 168.7565 * value as f32;
            assert!((turned_deg(&document, "Turntable") - wanted).abs() < 0.01, "{name} at {share}");
        }
    }
}

/// 48 samples of the same motion, as matrices and as angles.
#[test]
fn blenders_sampled_turntables_agree() {
    let (Some(matrices), Some(angles)) =
        (blender("c_turntable_sample_matrix.dae"), blender("c_turntable_sample_decomposed.dae"))
    else {
        return;
    };
    for frame in 1..=48 {
        let time_s = f64::from(frame) / 24.0;
        let ((matrices, _), (angles, _)) = (posed(&matrices, time_s), posed(&angles, time_s));
        for id in ["Turntable", "CamPivot"] {
            let difference = turned_deg(&matrices, id) - turned_deg(&angles, id);
            assert!(difference.abs() < 0.01, "{id} at frame {frame}: {difference}");
        }
    }
}
