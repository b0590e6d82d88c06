//! Course and Blender scenes against their manifests, and how long large files take.

use super::*;

/// Scenes that are too large for this repository; `None`, with a printed reason, when they are not there.
fn shared(folder: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("PELLICLE_SHARED") else {
        println!("skipped: PELLICLE_SHARED does not name a folder with scenes/{folder}");
        return None;
    };
    Some(PathBuf::from(root).join("scenes").join(folder))
}

/// Rows of a MANIFEST.md: file, triangles instanced in the scene.
fn manifest(folder: &Path) -> Vec<(PathBuf, usize)> {
    let text = std::fs::read_to_string(folder.join("MANIFEST.md")).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let triangles = cells.get(3)?.split('/').nth(1)?.trim().parse().ok()?;
        Some((folder.join(cells[1]), triangles))
    };
    text.lines().filter_map(row).collect()
}

fn texts(warnings: &[Warning], folder: &Path) -> Vec<String> {
    warnings.iter().map(|warning| warning.to_string().replace(&format!("{}/", folder.display()), "")).collect()
}

/// (scene, part of what was seen): all the warnings that the shared scenes give.
const EXPECTED_WARNINGS: [(&str, &str); 20] = [
    ("CBbunny", "lies in an emissive mesh"),
    ("CBbunny_microfacet_cu", "lies in an emissive mesh"),
    ("CBspheres", "lies in an emissive mesh"),
    ("CBspheres_lambertian", "lies in an emissive mesh"),
    ("CBspheres_microfacet_al_ag", "lies in an emissive mesh"),
    ("CBmaxplanck_microfacet_au", "lies in an emissive mesh"),
    ("plane", "attenuation 1 0 0.001599907"),
    ("spheres_thinfilm2", "<lambertian>"),
    ("a_suzanne_notri_yup", "upright for Y up"),
    ("a_suzanne_yup_noapply", "upright for Y up"),
    ("b_materials_default", "<reflectivity>"),
    ("b_materials_noinst_active", "<reflectivity>"),
    ("b_materials_noinst_active", "checker%20img.png"),
    ("c_turntable_keys_decomposed", "scales and rotates its translation"),
    ("c_turntable_keys_smooth", "scales and rotates its translation"),
    ("c_turntable_sample_decomposed", "scales and rotates its translation"),
    ("c_turntable_sample_decomposed", "animation of"),
    ("c_turntable_sample_matrix", "animation of"),
    ("cam_port", "portrait"),
    ("cam_ortho_port", "portrait"),
];

#[test]
fn shared_scenes_have_the_triangles_of_their_manifest() {
    for name in ["cs184", "blender"] {
        let Some(folder) = shared(name) else { return };
        let rows = manifest(&folder);
        assert!(rows.len() > 10, "{}", folder.display());
        for (file, triangles) in rows {
            let options = LoadOptions { missing_texture: MissingTexture::Magenta, ..LoadOptions::default() };
            let start = std::time::Instant::now();
            let (document, warnings) = load(&file, &options).unwrap_or_else(|error| panic!("{error}"));
            println!("{} {:.1} ms", file.file_name().unwrap().display(), start.elapsed().as_secs_f64() * 1e3);
            texts(&warnings, &folder).iter().for_each(|warning| println!("    {warning}"));
            let stem = file.file_stem().unwrap().to_str().unwrap();
            for (name, part) in EXPECTED_WARNINGS.iter().filter(|(name, _)| *name == stem) {
                assert!(warnings.iter().any(|warning| warning.seen.contains(part)), "{name}: {part}");
            }
            let expected = EXPECTED_WARNINGS.iter().filter(|(name, _)| *name == stem).count();
            assert_eq!(warnings.len(), expected, "{stem}: {warnings:?}");
            let dropped: usize = document
                .geometries
                .iter()
                .map(|geometry| match &geometry.shape {
                    Shape::Mesh(mesh) => mesh.degenerate,
                    Shape::Sphere { .. } => 0,
                })
                .sum();
            assert_eq!(instanced_triangles(&document) + dropped, triangles, "{}", file.display());
        }
    }
}

#[test]
fn the_same_scene_in_centimetres_is_lit_alike() {
    let Some(folder) = shared("blender") else { return };
    let [(large, _), (small, _)] = ["a_suzanne_default.dae", "a_suzanne_cm.dae"]
        .map(|name| load(&folder.join(name), &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}")));
    assert_eq!(small.lights.len(), large.lights.len());
    assert!(!large.lights.is_empty());
    for (small, large) in small.lights.iter().zip(&large.lights) {
        let ratio = match large.kind {
            LightKind::Point { .. } | LightKind::Spot { .. } => 1e-4,
            _ => 1.0,
        };
        assert!(small.color.abs_diff_eq(large.color * ratio, 1e-5 * ratio * large.color.max_element()), "{}", large.id);
    }
}

#[test]
#[ignore = "timing, not truth"]
fn parse_times() {
    let quads = 707;
    let line = |y: usize| (0..quads).map(move |x| format!("{x}.125 0.{y} {y}.75 ")).collect::<String>();
    let points: String = (0..quads).map(line).collect();
    let quad = |i: usize| {
        let corner = i / (quads - 1) * quads + i % (quads - 1);
        let [a, b, c, d] = [corner, corner + 1, corner + quads + 1, corner + quads];
        format!("{a} {a} {b} {b} {c} {c} {a} {a} {c} {c} {d} {d} ")
    };
    let indices: String = (0..(quads - 1) * (quads - 1)).map(quad).collect();
    let text = format!(
        r##"<COLLADA version="1.4.1"><library_geometries><geometry id="grid"><mesh>
        <source id="p"><float_array id="a">{points}</float_array><technique_common><accessor source="#a" stride="3"/>
        </technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles>
        <input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#p" offset="1"/><p>{indices}</p>
        </triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node>
        <instance_geometry url="#grid"/></node></visual_scene></library_visual_scenes></COLLADA>"##
    );
    let file = std::env::temp_dir().join(format!("pellicle-{}.dae", std::process::id()));
    std::fs::write(&file, &text).unwrap();
    for _ in 0..3 {
        let start = std::time::Instant::now();
        let (document, _) = load(&file, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "made: {} MB, {} triangles, {:.1} ms",
            text.len() >> 20,
            instanced_triangles(&document),
            seconds * 1e3
        );
    }
    std::fs::remove_file(&file).unwrap();
    let Some(folder) = shared("bench") else { return };
    for name in ["A_cornell", "B_gold_dragon", "C_glass", "D_env", "E_film", "paper_dragon_550nm"] {
        let file = folder.join(format!("{name}.dae"));
        let options = LoadOptions::default();
        for _ in 0..3 {
            let start = std::time::Instant::now();
            let (document, warnings) = load(&file, &options).unwrap_or_else(|error| panic!("{error}"));
            println!(
                "{name}: {} triangles, {:.1} ms, {warnings:?}",
                instanced_triangles(&document),
                start.elapsed().as_secs_f64() * 1e3
            );
        }
    }
}
