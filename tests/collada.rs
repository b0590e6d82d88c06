//! COLLADA files: bad ones give exactly the error that lies beside them, good ones load to what their author meant.

use std::path::{Path, PathBuf};

use pellicle::collada::{LoadOptions, MissingTexture, Warning, load};
use pellicle::document::{Document, Item, Shape};

fn data(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(folder)
}

/// Scenes that are too large for this repository; `None`, with a printed reason, when they are not there.
fn shared(folder: &str) -> Option<PathBuf> {
    let root = match std::env::var_os("PELLICLE_SHARED") {
        Some(root) => PathBuf::from(root),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
    };
    let folder = root.join("scenes").join(folder);
    if !folder.is_dir() {
        println!("skipped: {} is not there (set PELLICLE_SHARED)", folder.display());
        return None;
    }
    Some(folder)
}

/// Triangles of the scene, each instance counted.
fn instanced_triangles(document: &Document) -> usize {
    let items = document.placements().into_iter().flat_map(|(node, _)| &document.nodes[node].items);
    items
        .map(|item| match item {
            Item::Geometry { geometry, .. } => match &document.geometries[*geometry].shape {
                Shape::Mesh(mesh) => mesh.triangles.len(),
                Shape::Sphere { .. } => 0,
            },
            _ => 0,
        })
        .sum()
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
#[ignore = "timing, not truth"]
fn parse_times() {
    let Some(folder) = shared("bench") else { return };
    for name in ["A_cornell", "B_gold_dragon", "C_glass", "D_env", "E_film", "paper_dragon_550nm"] {
        let file = folder.join(format!("{name}.dae"));
        let options = LoadOptions::default();
        for _ in 0..3 {
            let start = std::time::Instant::now();
            let (document, warnings) = load(&file, &options).unwrap_or_else(|error| panic!("{error}"));
            println!("{name}: {} triangles, {:.1} ms, {warnings:?}", instanced_triangles(&document), start.elapsed().as_secs_f64() * 1e3);
        }
    }
}
