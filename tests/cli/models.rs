//! Bare models on the command line: a picture at once, surfaces in one line, light by name.

use std::f32::consts::TAU;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use pellicle::output::read_exr;

use super::{Folder, fail, is_black, render, succeed};

/// A ring of some thickness, without normals, as OBJ text.
fn torus(thickness: f32) -> String {
    torus_at(thickness, 1.0, 0.0)
}

/// The same in another unit and somewhere else.
fn torus_at(thickness: f32, scale: f32, offset: f32) -> String {
    let (around, across) = (32, 16);
    let mut text = String::new();
    for i in 0..around {
        for j in 0..across {
            let ((sin_a, cos_a), (sin_b, cos_b)) =
                ((TAU * i as f32 / around as f32).sin_cos(), (TAU * j as f32 / across as f32).sin_cos());
            let r = 1.0 + thickness * cos_b;
            let [x, y, z] = [r * cos_a, thickness * sin_b, r * sin_a].map(|x| scale * x + offset);
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
    }
    let index = |i: usize, j: usize| i % around * across + j % across + 1;
    for i in 0..around {
        for j in 0..across {
            writeln!(text, "f {} {} {} {}", index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j))
                .unwrap();
        }
    }
    text
}

const SIZE: [usize; 2] = [64, 48];
/// Upright.
const PORTRAIT: [usize; 2] = [48, 64];

/// The pixels of a small picture of a model in the folder.
fn picture(folder: &Folder, model: &str, [width, height]: [usize; 2], options: &[&str]) -> Vec<[f32; 4]> {
    let (model, file, size) = (folder.file(model), folder.file("picture.exr"), format!("{width}x{height}"));
    let fixed = ["render", &model, "-o", &file, "--float", "--spp", "4", "--size", &size, "--mode", "rgb"];
    succeed(&[fixed.as_slice(), options].concat());
    read_exr(Path::new(&file)).unwrap().rgba
}

/// Share of the picture that a shining model fills, and whether it touches the border.
fn extent(pixels: &[[f32; 4]], [width, height]: [usize; 2]) -> (f32, bool) {
    // The lamps give less than 10.
    let shines: Vec<bool> = pixels.iter().map(|pixel| pixel[0] > 500.0).collect();
    let is_border = |i: usize| i % width == 0 || i % width == width - 1 || i / width == 0 || i / width == height - 1;
    let count = shines.iter().filter(|shines| **shines).count();
    (count as f32 / shines.len() as f32, (0..shines.len()).any(|i| shines[i] && is_border(i)))
}

#[test]
fn models_of_all_shapes_and_units_are_in_frame() {
    let folder = Folder::new("framing");
    let pole: String = "v -1 0 -1\nv 1 0 -1\nv 0 20 0\nv 0 0 1\nf 1 2 3\nf 2 4 3\nf 4 1 3\nf 1 4 2\n".to_owned();
    let (far, small) = (torus_at(0.4, 1e3, 5e5), torus_at(0.4, 1e-6, 0.0));
    let models = [("thin.obj", torus(0.02)), ("pole.obj", pole), ("far.obj", far), ("small.obj", small)];
    for (name, text) in models {
        fs::write(folder.file(name), text).unwrap();
        for (size, up) in [(SIZE, "y"), (SIZE, "z"), (PORTRAIT, "y")] {
            let pixels = picture(&folder, name, size, &["--material", "emitter 1000", "--up-axis", up]);
            let (share, touches) = extent(&pixels, size);
            assert!(share > 0.005 && share < 0.75 && !touches, "{name} {size:?} {up}: {share} {touches}");
        }
    }
}

#[test]
fn every_environment_lights_model_and_floor() {
    let folder = Folder::new("environments");
    fs::write(folder.file("ring.obj"), torus(0.4)).unwrap();
    for environment in ["studio", "tent", "sky"] {
        let gold = ["--material", "conductor Au roughness=0.2; film 550nm n=1.33", "--environment", environment];
        let pixels = picture(&folder, "ring.obj", SIZE, &gold);
        let dark = pixels.iter().filter(|pixel| pixel[1] < 1e-3).count();
        assert!(dark * 50 < pixels.len(), "{environment}: {dark} pixels are black");
        let mean = |channel: usize| pixels.iter().map(|pixel| pixel[channel]).sum::<f32>() / pixels.len() as f32;
        assert!(mean(1) > 0.02 && mean(1) < 2.0, "{environment}: {}", mean(1));
    }
    // A constant image is a furnace: a white body disappears in it, floor there is none.
    let image = folder.file("white.png");
    image::RgbImage::from_pixel(8, 4, image::Rgb([255; 3])).save(&image).unwrap();
    let pixels = picture(
        &folder,
        "ring.obj",
        SIZE,
        &["--material", "diffuse 1", "--environment", &image, "--max-bounces", "99"],
    );
    let mean = pixels.iter().map(|pixel| pixel[1]).sum::<f32>() / pixels.len() as f32;
    assert!((mean - 1.0).abs() < 0.01 && (pixels[0][1] - 1.0).abs() < 1e-3, "{mean} {:?}", pixels[0]);
}

#[test]
fn the_light_of_a_name_lights_dark_scenes() {
    assert!(is_black(&render("dark.dae", &["--spp", "1", "--size", "16x12"]).0));
    let (lit, said) = render("dark.dae", &["--spp", "1", "--size", "16x12", "--environment", "studio"]);
    assert!(!is_black(&lit) && !said.contains("no light"), "{said}");
}

#[test]
fn a_turntable_needs_no_scene_either() {
    let folder = Folder::new("model-turntable");
    fs::write(folder.file("ring.obj"), torus(0.4)).unwrap();
    let frames = folder.file("f.##.exr");
    let said = succeed(&[
        "turntable",
        &folder.file("ring.obj"),
        "-o",
        &frames,
        "--frames",
        "4",
        "--mode",
        "object",
        "--material",
        "emitter 1000",
        "--size",
        "64x48",
        "--spp",
        "2",
    ]);
    for name in ["f.00.exr", "f.03.exr"] {
        let (share, touches) = extent(&read_exr(Path::new(&folder.file(name))).unwrap().rgba, SIZE);
        assert!(share > 0.1 && !touches, "{name}: {share}; {}", said.stderr);
    }
}

/// `check` names what a surface in one line became.
#[test]
fn surfaces_are_said_in_one_line() {
    let folder = Folder::new("surfaces");
    let model = folder.file("ring.obj");
    fs::write(&model, torus(0.4)).unwrap();
    for (line, wanted) in [
        ("conductor Au", vec!["model: conductor Au"]),
        ("conductor au roughness=0.2; film 550nm n=1.33", vec!["conductor Au", "roughness 0.2", "550 nm", "1.33"]),
        ("conductor eta=0.2,0.4,1.4 k=3,2.4,1.8", vec!["conductor"]),
        ("dielectric BK7; film MgF2 100nm; film 50nm TiO2", vec!["dielectric BK7", "MgF2", "100 nm", "TiO2"]),
        ("dielectric 1.7 roughness=0.1 absorption_per_m=1,2,3", vec!["dielectric", "1.7"]),
        ("diffuse 0.8,0.2,0.1 ; film oil thickness_nm=300nm;", vec!["diffuse", "0.8, 0.2, 0.1", "300 nm"]),
        ("diffuse; opacity 0.5; film 300nm n=1.4; noise amplitude=0.5 seed=3", vec!["diffuse", "noise"]),
        ("film-less=diffuse", vec![]),
        ("preset anodised-titanium voltage_v=30; noise", vec!["conductor Ti", "TiO2", "noise"]),
        ("model=dielectric ior=1; film soap; drain top_nm=50 bottom_nm=900", vec!["dielectric", "50", "900"]),
        ("emitter 3 spectrum=D65", vec!["1 materials that emit"]),
    ] {
        if wanted.is_empty() {
            let error = fail(1, &["check", &model, "--material", line]);
            assert_eq!(error, "error: --material: the scene has no material `film-less`\n  valid here: `model`\n");
            continue;
        }
        let said = succeed(&["check", &model, "--material", line]).stdout;
        for words in wanted {
            assert!(said.contains(words), "{line}: `{words}` is not in\n{said}");
        }
    }
}

#[test]
fn mistakes_in_a_surface_are_pointed_at() {
    let folder = Folder::new("surface-mistakes");
    let model = folder.file("ring.obj");
    fs::write(&model, torus(0.4)).unwrap();
    for (line, wanted) in [
        (
            "",
            "--material:1:1: no base\n  1 | \n    | ^\n  begin with one of diffuse, conductor, dielectric, emitter, preset",
        ),
        (
            "conducter Au",
            "--material:1:1: unknown base `conducter`\n  1 | conducter Au\n    | ^^^^^^^^^\n  did you mean `conductor`?",
        ),
        (
            "conductor Auu; film 5nm n=1.3",
            "--material:1:11: unknown metal `Auu`\n  1 | conductor Auu; film 5nm n=1.3\n    |           ^^^\n  did you mean `Au`?",
        ),
        (
            "conductor Au; film 550 n=1.33",
            "--material:1:20: `550` has no unit\n  1 | conductor Au; film 550 n=1.33\n    |                    ^^^\n  \
             write `550nm` for a thickness, `n=550` for an index",
        ),
        (
            "conductor Au; film 0.55nm n=1.33",
            "--material:1:20: `thickness_nm` is 0.55; it must be 0 or lie in 1..50000\n  1 | conductor Au; film 0.55nm n=1.33\n    \
             |                    ^^^^\n  did you mean um? 0.55 um are 550 nm",
        ),
        (
            "conductor Au rougness=0.2",
            "--material:1:14: unknown attribute `rougness` of <conductor>\n  1 | conductor Au rougness=0.2\n    \
             |              ^^^^^^^^\n  did you mean `roughness`?",
        ),
        ("conductor Au; flim 5nm n=2", "--material:1:15: unknown layer `flim`"),
        ("conductor Au; film 5nm n=2 ior=3", "--material:1:28: `ior` of `film` is given twice"),
        ("conductor Au; film 5nm n=2 SiO2", "--material:1:24: `material` and `ior` exclude each other"),
        ("dielectric BK7 glassy", "--material:1:16: `glass` of `dielectric` is given twice"),
        ("diffuse 0.5; noise", "unknown element <noise> in <diffuse>"),
        ("nobody=diffuse", "--material: the scene has no material `nobody`\n  valid here: `model`"),
    ] {
        let error = fail(1, &["check", &model, "--material", line]);
        assert!(error.starts_with("error: --material") && error.contains(wanted), "{line}:\n{error}");
    }
}

#[test]
fn surfaces_replace_those_of_scenes() {
    let said = succeed(&["check", "room.dae", "--material", "conductor Ag"]).stdout;
    assert!(said.contains("conductor Ag") && !said.contains("diffuse"), "{said}");
    let error = fail(2, &["check", "room.dae", "--environment", "studo"]);
    assert!(error.contains("did you mean `studio`?"), "{error}");
    let error = fail(2, &["check", "room.dae", "--environment", "nowhere.hdr"]);
    assert!(error.contains("known by name are studio, tent and sky"), "{error}");
}

/// A scene with a model in a file beside it.
fn composed(folder: &Folder, reference: &str) -> String {
    let scene = folder.file("scene.dae");
    let text = format!(
        r##"<COLLADA version="1.4.1"><asset><up_axis>Y_UP</up_axis></asset>
<library_effects><effect id="e"><extra><technique profile="pellicle"><emitter radiance="1000"/></technique></extra></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="ring"><extra><technique profile="pellicle">
{reference}
</technique></extra></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#ring"><bind_material><technique_common>
<instance_material symbol="skin" target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##
    );
    fs::write(&scene, text).unwrap();
    scene
}

#[test]
fn scenes_refer_to_models_in_their_folder() {
    let folder = Folder::new("composed");
    fs::write(folder.file("ring.obj"), torus(0.4)).unwrap();
    composed(&folder, r#"<mesh file="ring.obj" material="skin"/>"#);
    let (share, touches) = extent(&picture(&folder, "scene.dae", SIZE, &[]), SIZE);
    assert!(share > 0.1 && !touches, "{share}");

    fs::write(folder.file("broken.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    for (reference, wanted) in [
        (r#"<mesh file="../ring.obj"/>"#, "did you mean `ring.obj` beside the scene?"),
        (r#"<mesh file="/etc/hostname.ply"/>"#, "mesh `/etc/hostname.ply` is missing"),
        (r#"<mesh file="ring.stl"/>"#, "`ring.stl` is neither .obj nor .ply"),
        (r#"<mesh fill="ring.obj"/>"#, "<mesh> has no `file`"),
        (r#"<mash file="ring.obj"/>"#, "unknown element <mash> in <technique>"),
        (r#"<mesh file="broken.obj"/>"#, "mesh `broken.obj`: line 2: point 2 does not exist"),
    ] {
        let error = fail(1, &["check", &composed(&folder, reference)]);
        assert!(error.contains(wanted) && error.contains("scene.dae:5:"), "{reference}:\n{error}");
    }
    let outside = Folder::new("composed-outside");
    fs::write(outside.file("ring.obj"), torus(0.4)).unwrap();
    let reference = format!(r#"<mesh file="{}"/>"#, outside.file("ring.obj"));
    let error = fail(1, &["check", &composed(&folder, &reference)]);
    assert!(error.contains("lies outside the scene's folder"), "{error}");
}

/// Frames of another model are not frames of the scene, though its own file is the same.
#[test]
fn frames_are_rendered_anew_when_a_model_changes() {
    let folder = Folder::new("composed-changed");
    fs::write(folder.file("ring.obj"), torus(0.4)).unwrap();
    let scene = composed(&folder, r#"<mesh file="ring.obj" material="skin"/>"#);
    let output = folder.file("f.####.exr");
    let frames = ["turntable", &scene, "-o", &output, "--frames", "2", "--size", "16x16", "--spp", "1"];
    let missing = || succeed(&[&frames[..], &["--missing"]].concat()).stdout;
    succeed(&frames);
    assert_eq!(missing(), "");
    fs::write(folder.file("ring.obj"), torus(0.3)).unwrap();
    assert_eq!(missing(), "0-1/2\n");
}

#[test]
fn rings_have_the_colours_of_their_libraries() {
    let folder = Folder::new("libraries");
    let text = format!("mtllib ring.mtl\nusemtl red\n{}usemtl other\nf 1 2 3\n", torus(0.4));
    fs::write(folder.file("ring.obj"), text).unwrap();
    fs::write(folder.file("ring.mtl"), "newmtl red\nKd 0.7 0.1 0.1\nNs 50\n").unwrap();
    let pixels = picture(&folder, "ring.obj", SIZE, &["--environment", "tent"]);
    let middle = pixels[SIZE[0] * (SIZE[1] * 3 / 5) + SIZE[0] / 4];
    assert!(middle[0] > 2.0 * middle[1], "{middle:?}");
}
