//! Many instances: memory goes by meshes, and nested ones are the same picture.

use std::f32::consts::{PI, TAU};
use std::fmt::Write;
use std::fs;

use super::{Folder, succeed};

/// `groups` times `each` instances of a ball of about 2000 triangles, in the groups by way of `<instance_node>` or not.
fn scene(groups: usize, each: usize, nested: bool) -> String {
    let (rings, columns) = (32usize, 32usize);
    let mut points = String::new();
    for j in 0..=rings {
        for i in 0..columns {
            let (a, b) = (j as f32 / rings as f32 * PI, i as f32 / columns as f32 * TAU);
            let _ = write!(points, "{} {} {} ", a.sin() * b.cos(), -a.cos(), a.sin() * b.sin());
        }
    }
    let mut triangles = String::new();
    for j in 0..rings {
        for i in 0..columns {
            let (p, q) = (j * columns + i, j * columns + (i + 1) % columns);
            let _ = write!(triangles, "{p} {} {} {p} {} {q} ", p + columns, q + columns, q + columns);
        }
    }
    let ball = "<instance_geometry url=\"#ball\"/>";
    let mut leaves = String::new();
    for k in 0..each {
        let _ = write!(leaves, "<node><translate>{} 0 {}</translate>{ball}</node>", k % 10 * 3, k / 10 * 3);
    }
    let mut nodes = String::new();
    for k in 0..groups {
        let content = if nested { "<instance_node url=\"#group\"/>" } else { &leaves };
        let _ = write!(nodes, "<node><translate>{} 0 {}</translate>{content}</node>", k % 10 * 30, k / 10 * 30);
    }
    let points_count = (rings + 1) * columns;
    format!(
        r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
        <asset><unit meter="1"/><up_axis>Y_UP</up_axis></asset>
        <library_geometries><geometry id="ball"><mesh><source id="p"><float_array id="pa" count="{}">{points}</float_array>
        <technique_common><accessor source="#pa" count="{points_count}" stride="3"><param type="float"/><param type="float"/>
        <param type="float"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION"
        source="#p"/></vertices><triangles count="{}"><input semantic="VERTEX" source="#v" offset="0"/><p>{triangles}</p>
        </triangles></mesh></geometry></library_geometries><library_nodes><node id="group">{leaves}</node></library_nodes>
        <library_visual_scenes><visual_scene id="s">{nodes}<extra><technique profile="pellicle"><environment radiance="1"/>
        </technique></extra></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"##,
        3 * points_count,
        2 * rings * columns,
    )
}

struct Rendered {
    hash: String,
    peak_mb: f64,
}

fn render(folder: &Folder, name: &str, text: &str) -> Rendered {
    let (file, stats) = (folder.file(&format!("{name}.dae")), folder.file(&format!("{name}.json")));
    fs::write(&file, text).unwrap();
    let picture = folder.file(&format!("{name}.png"));
    let run = succeed(&[
        "render", &file, "-o", &picture, "--size", "48x32", "--spp", "2", "--mode", "rgb", "--stats", &stats, "--hash",
    ]);
    let stats: serde_json::Value = serde_json::from_str(&fs::read_to_string(stats).unwrap()).unwrap();
    Rendered { hash: run.stdout, peak_mb: stats["peak_rss_mb"].as_f64().unwrap() }
}

#[test]
fn memory_goes_by_meshes_and_not_by_instances() {
    let folder = Folder::new("instances");
    let few = render(&folder, "few", &scene(1, 100, true));
    let many = render(&folder, "many", &scene(200, 100, true));
    // 20 000 instances of 2048 triangles: as meshes they would take 4 GB.
    let per_instance = (many.peak_mb - few.peak_mb) * 1e6 / 19_900.0;
    assert!(per_instance < 2000.0, "{per_instance:.0} bytes per instance");
}

#[test]
fn nested_instances_make_the_picture_of_those_that_are_written_out() {
    let folder = Folder::new("nested");
    let nested = render(&folder, "nested", &scene(20, 20, true));
    let flat = render(&folder, "flat", &scene(20, 20, false));
    assert_eq!(nested.hash, flat.hash);
}
