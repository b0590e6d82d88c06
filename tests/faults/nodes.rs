//! Nodes that contain each other, and few that stand for many.

use super::*;

/// Nodes `n0` to `n(levels - 1)`, each ten times in the one after; the last one ten times in the scene.
fn tenfold(levels: usize, content: &str) -> String {
    let instances = |level: usize| format!("<instance_node url=\"#n{level}\"/>").repeat(10);
    let mut nodes = format!("<node id=\"n0\">{content}</node>");
    for level in 1..levels {
        nodes += &format!("<node id=\"n{level}\">{}</node>", instances(level - 1));
    }
    let library = format!("<library_nodes>{nodes}</library_nodes><library_visual_scenes>");
    let placed = format!("<node>{}</node><node id=\"front\">", instances(levels - 1));
    room(&[("<library_visual_scenes>", &library), ("<node id=\"front\">", &placed)])
}

#[test]
fn cycles_name_their_chain() {
    let folder = Folder::new("cycles");
    let with = |nodes: &str| room(&[("<node id=\"front\">", &format!("{nodes}<node id=\"front\">"))]);
    let own = with("<node id=\"a\"><instance_node url=\"#a\"/></node>");
    refuses(&folder, own, &[], &["nodes contain each other: a -> a"]);
    let three = with(
        "<node id=\"a\"><instance_node url=\"#b\"/></node><node id=\"b\"><node id=\"c\"><instance_node url=\"#a\"/></node></node>",
    );
    refuses(&folder, three, &[], &["nodes contain each other: a -> b -> c -> a"]);
}

#[test]
fn a_billion_instances_are_refused() {
    let folder = Folder::new("tenfold");
    for levels in [9, 20, 200] {
        refuses(&folder, tenfold(levels, ""), &[], &["expands to more than 1000000 instances"]);
    }
    let chain: String =
        (1..20_000).map(|i| format!("<node id=\"n{i}\"><instance_node url=\"#n{}\"/></node>", i - 1)).collect();
    let text = tenfold(1, "").replace("</library_nodes>", &format!("{chain}</library_nodes>"));
    refuses(&folder, text.replace("url=\"#n0\"/></node>", "url=\"#n19999\"/></node>"), &[], &["deeper than 256"]);
}

#[test]
fn instances_of_a_lamp_are_counted_in_bytes() {
    let folder = Folder::new("lamps");
    let lamp = "<instance_geometry url=\"#lamp\"><bind_material><technique_common>\
                <instance_material symbol=\"m\" target=\"#glow\"/></technique_common></bind_material></instance_geometry>";
    let file = folder.file("scene.dae");
    fs::write(&file, tenfold(5, lamp)).unwrap();
    let stderr = refused(&file, &["--max-memory", "100M"], &["the scene needs about ", "bytes of memory, but only "]);
    assert!(stderr.contains("raise --max-memory"), "{stderr}");
    let picture = folder.file("a.png");
    let render = ["render", &file, "-o", &picture, "--max-memory", "100M"];
    assert_eq!(confined(&render).code, Some(1));
    fs::write(&file, tenfold(3, lamp)).unwrap();
    assert_eq!(confined(&[&render[..], &["--spp", "1"]].concat()).code, Some(0));
}

/// Sources, effects and samplers can be shared: a small file must not become a large scene without being asked.
#[test]
fn meshes_of_one_shared_array_are_counted_in_bytes() {
    let folder = Folder::new("shared");
    let points = "0 1 2 ".repeat(100_000);
    let array = format!("<float_array id=\"big\" count=\"300000\">{points}</float_array>");
    let source =
        format!("<source id=\"floor-pos\">{array}").replace("<source id=\"floor-pos\">", "<source id=\"other\">");
    let geometry = |i: usize| {
        format!(
            "<geometry id=\"g{i}\"><mesh><source id=\"s{i}\"><technique_common><accessor source=\"#big\" count=\"100000\" stride=\"3\"/>\
             </technique_common></source><vertices id=\"v{i}\"><input semantic=\"POSITION\" source=\"#s{i}\"/></vertices>\
             <triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v{i}\" offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry>"
        )
    };
    let geometries: String = (0..200).map(geometry).collect();
    let placed: String = (0..200).map(|i| format!("<node><instance_geometry url=\"#g{i}\"/></node>")).collect();
    let text = room(&[
        (
            "<library_geometries>",
            &format!("<library_geometries>{geometries}<geometry id=\"x\"><mesh>{source}</source></mesh></geometry>"),
        ),
        ("<node id=\"front\">", &format!("{placed}<node id=\"front\">")),
    ]);
    refuses(
        &folder,
        text,
        &["--max-memory", "50M"],
        &["the file and its scene take more than 50000000 bytes of memory"],
    );
}
