//! Parts of pictures as files: where they lie, and that they can be made in pieces too.

use pellicle::output::{Crop, HeaderValue, PIXEL_ASPECT};

use super::*;

const SIZE: &[&str] = &["--size", "90x60", "--spp", "6", "--float", "--quiet"];
const CROP: &[&str] = &["--crop", "37,9,21,30"];

#[test]
fn a_crop_lies_where_it_was_cut_from() {
    let folder = Folder::new("crop");
    let render = |name: &str, options: &[&str]| {
        let file = folder.file(name);
        succeed(&[&["render", "room.dae", "-o", &file], SIZE, options].concat());
        read_exr(Path::new(&file)).unwrap()
    };
    let whole = render("whole.exr", &[]);
    let stats = folder.file("part.json");
    let part = render("part.exr", &[CROP, &["--pixel-aspect", "1", "--stats", &stats]].concat());
    let stats: serde_json::Value = serde_json::from_str(&fs::read_to_string(stats).unwrap()).unwrap();
    assert_eq!(stats["mean_spp"].as_f64(), Some(6.0));
    assert_eq!(part.crop, Some(Crop { x: 37, y: 9, full_width: 90, full_height: 60 }));
    assert_eq!((part.width, part.height, whole.crop), (21, 30, None));
    for (i, pixel) in part.rgba.iter().enumerate() {
        let (x, y) = (37 + i % 21, 9 + i / 21);
        assert_eq!(pixel, &whole.rgba[y * 90 + x], "{x}, {y}");
    }
    let wide = render("wide.exr", &["--pixel-aspect", "2"]);
    assert!(wide.header.contains(&(PIXEL_ASPECT.to_owned(), HeaderValue::Float(2.0))));
    let outside = run(&[&["render", "room.dae", "-o", &folder.file("x.exr"), "--crop", "80,0,11,5"], SIZE].concat());
    assert!(outside.code == Some(2) && outside.stderr.contains("leaves the picture of 90x60"), "{}", outside.stderr);
}

#[test]
fn crops_are_merged_from_parts() {
    let folder = Folder::new("crop-parts");
    let render = |name: &str, options: &[&str]| {
        let file = folder.file(name);
        let run = succeed(&[&["render", "room.dae", "-o", &file], SIZE, options].concat());
        (file, run.stdout)
    };
    let (_, direct) = render("direct.exr", &[CROP, &["--hash"]].concat());
    let (first, _) = render("a.part", &[CROP, &["--samples", "0:2"]].concat());
    let (rest, _) = render("b.part", &[CROP, &["--samples", "2:6"]].concat());
    let merged = succeed(&["merge", &rest, &first, "-o", &folder.file("merged.exr"), "--hash"]);
    assert_eq!(merged.stdout, direct);
    // Parts of other windows do not belong to it.
    let (other, _) = render("c.part", &["--samples", "2:6"]);
    let refused = run(&["merge", &first, &other, "-o", &folder.file("no.exr")]);
    assert!(refused.code == Some(2) && refused.stderr.contains("crop"), "{}", refused.stderr);
}
