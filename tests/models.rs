//! OBJ and PLY: all their forms give the same mesh, and hostile files are told what is wrong with them.

use std::fs;
use std::path::Path;
use std::time::Instant;

use glam::Vec3;
use pellicle::document::{Base, Mesh};
use pellicle::mesh::{Kind, Note, Options, load, read};

const CORNERS: [[i8; 3]; 8] = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]];
const FACES: [[u8; 4]; 6] = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

fn options(max_bytes: u64) -> Options {
    Options { smooth_normals: false, allow_path: Vec::new(), max_bytes }
}

fn obj(text: &str) -> Mesh {
    read(text.as_bytes(), Path::new("m.obj"), Kind::Obj, &options(1 << 30)).unwrap().0
}

fn ply(bytes: &[u8]) -> Mesh {
    read(bytes, Path::new("m.ply"), Kind::Ply, &options(1 << 30)).unwrap().0
}

fn refusal(kind: Kind, bytes: &[u8]) -> String {
    let name = if kind == Kind::Obj { "m.obj" } else { "m.ply" };
    read(bytes, Path::new(name), kind, &options(1 << 30)).unwrap_err().to_string()
}

/// Corners of all triangles, and the normals there.
fn soup(mesh: &Mesh) -> Vec<[(Vec3, Vec3); 3]> {
    let corner = |index: u32| (mesh.positions[index as usize], mesh.normals[index as usize]);
    mesh.triangles.iter().map(|triangle| triangle.map(corner)).collect()
}

/// The cube as OBJ; faces are written by `face`, from indices counted from 0.
fn obj_cube(face: impl Fn(u8) -> String) -> String {
    let points: String = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let faces: String = FACES.map(|corners| format!("f {}\n", corners.map(&face).join(" "))).concat();
    points + &faces
}

fn header(format: &str, scalar: &str, index: &str) -> String {
    format!(
        "ply\r\nformat {format} 1.0\ncomment a cube\nelement vertex 8\nproperty {scalar} x\nproperty {scalar} y\n\
         property uchar confidence\nproperty {scalar} z\nelement face 6\nproperty list uchar uchar flags\n\
         property list uchar {index} vertex_indices\nend_header\n"
    )
}

fn ply_cube(big: bool) -> Vec<u8> {
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = header(format, "double", "int").into_bytes();
    let double = |x: i8| if big { f64::from(x).to_be_bytes() } else { f64::from(x).to_le_bytes() };
    for [x, y, z] in CORNERS {
        bytes.extend([double(x).as_slice(), &double(y), &[7], &double(z)].concat());
    }
    for corners in FACES {
        bytes.extend([2, 1, 1, 4]);
        bytes.extend(corners.iter().flat_map(|&corner| {
            let index = i32::from(corner);
            if big { index.to_be_bytes() } else { index.to_le_bytes() }
        }));
    }
    bytes
}

#[test]
fn every_form_of_a_cube_is_the_same_cube() {
    let cube = obj(&obj_cube(|i| (i + 1).to_string()));
    assert_eq!((cube.triangles.len(), cube.positions.len(), cube.groups.len()), (12, 24, 1));
    for corners in soup(&cube) {
        let [a, b, c] = corners.map(|corner| corner.0);
        let normal = (b - a).cross(c - a).normalize();
        // Outward, and flat: the edges of a cube are sharp.
        assert!(normal.dot(a + b + c - 3.0) > 0.0 && corners.iter().all(|corner| corner.1 == normal), "{corners:?}");
    }
    let text: String = CORNERS.map(|[x, y, z]| format!("{x} {y} 7 {z}\n")).concat();
    let ascii = header("ascii", "float", "uint") + &text;
    let ascii = ascii + &FACES.map(|[a, b, c, d]| format!("1 9  4 {a} {b} {c} {d}\r\n")).concat();
    let same = [
        ("negative", obj(&obj_cube(|i| (i as i32 - 8).to_string()))),
        ("comments", obj(&format!("\u{feff}# cube\r\n\r\no cube\ns 1\n{}", obj_cube(|i| format!("{}//", i + 1))))),
        ("joined lines", obj(&obj_cube(|i| format!("{} \\\n", i + 1)))),
        ("ascii", ply(ascii.as_bytes())),
        ("little endian", ply(&ply_cube(false))),
        ("big endian", ply(&ply_cube(true))),
    ];
    for (name, mesh) in same {
        assert_eq!(soup(&mesh), soup(&cube), "{name}");
    }
}

#[test]
fn normals_and_texture_coordinates_are_the_files_own() {
    let extras = "vn 0 0 3\nvn 0 0 -1\nvt 0.25 0.75\nvt 0.5 0.5 9\n";
    let mesh = obj(&format!("v 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1\n{extras}f 1/1/1 2/2/1 3/-1/-1\n"));
    assert_eq!(mesh.normals, [Vec3::Z, Vec3::Z, -Vec3::Z]);
    assert_eq!(mesh.uv_sets[0].uvs[0].to_array(), [0.25, 0.75]);
    assert_eq!(mesh.uv_sets[0].uvs[2].to_array(), [0.5, 0.5]);
    // One corner without a normal takes the face's, the others keep theirs.
    let mesh = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2//1 3\n");
    assert_eq!(mesh.normals, [Vec3::X, Vec3::X, Vec3::Z]);

    let names = "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n\
                 property float nz\nproperty float s\nproperty float t\n";
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\n{names}element face 1\nproperty list uchar int vertex_index\n\
         end_header\n0 0 0 1 0 0 0.5 1\n1 0 0 0 0 0 0 0\n0 1 0 0 0 2 0 0\n3 0 1 2\n"
    );
    let mesh = ply(text.as_bytes());
    // What has no length takes the face's.
    assert_eq!(mesh.normals, [Vec3::X, Vec3::Z, Vec3::Z]);
    assert_eq!(mesh.uv_sets[0].uvs[0].to_array(), [0.5, 1.0]);
}

#[test]
fn smooth_shapes_without_normals_are_smooth() {
    let mut text = String::new();
    let (around, up) = (24, 12);
    for i in 0..around {
        for j in 0..=up {
            let (sin_a, cos_a) = (std::f32::consts::TAU * i as f32 / around as f32).sin_cos();
            let (sin_b, cos_b) = (std::f32::consts::PI * j as f32 / up as f32).sin_cos();
            // Exactly at the poles, where the sine of pi is not 0.
            let sin_b = if j == up { 0.0 } else { sin_b };
            text += &format!("v {} {cos_b} {}\n", sin_b * cos_a, -sin_b * sin_a);
        }
    }
    let index = |i: usize, j: usize| i % around * (up + 1) + j + 1;
    for i in 0..around {
        for j in 0..up {
            text += &format!("f {} {} {} {}\n", index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j));
        }
    }
    let (mesh, notes) = read(text.as_bytes(), Path::new("m.obj"), Kind::Obj, &options(1 << 30)).unwrap();
    for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
        assert!(position.dot(*normal) > 0.99, "{position} {normal}");
    }
    // The poles of each segment are in one place.
    assert_eq!(mesh.degenerate, 2 * around);
    assert_eq!((notes.len(), notes[0].count), (1, 2 * around));
}

/// Two squares along the x axis that meet at an angle; the normals at the first square's corners.
fn fold(degrees: f32) -> [Vec3; 4] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let mesh = obj(&format!(
        "v 0 -1 0\nv 1 -1 0\nv 1 0 0\nv 0 0 0\nv 1 {cos} {}\nv 0 {cos} {}\nf 1 2 3 4\nf 4 3 5 6\n",
        -sin, -sin
    ));
    let [[a, b, c], [_, _, d]] = [soup(&mesh)[0], soup(&mesh)[1]];
    [a.1, b.1, c.1, d.1]
}

#[test]
fn blunt_edges_are_smooth_and_sharp_ones_are_kept() {
    let blunt = fold(30.0);
    assert_eq!(blunt[..2], [Vec3::Z; 2]);
    assert!(blunt[2..].iter().all(|normal| normal.z < 0.99 && normal.z > 30f32.to_radians().cos()), "{blunt:?}");
    assert!(fold(60.0).iter().all(|normal| normal.abs_diff_eq(Vec3::Z, 1e-6)));
}

/// Around one point comparing each face with each would take quadratic time.
#[test]
fn a_fan_of_many_faces_takes_no_long_time() {
    let rim = 100_000;
    let angle = |i: usize| (i as f32 / rim as f32 * std::f32::consts::TAU).sin_cos();
    let points: String = (0..rim).map(angle).map(|(sin, cos)| format!("v {sin} 0 {cos}\n")).collect();
    let faces: String = (0..rim).map(|i| format!("f 1 {} {}\n", 2 + i, 2 + (i + 1) % rim)).collect();
    let start = Instant::now();
    let mesh = obj(&format!("v 0 1 0\n{points}{faces}"));
    assert!(mesh.normals.iter().zip(&mesh.positions).any(|(n, p)| *p == Vec3::Y && n.y > 0.999));
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn concave_polygons_keep_their_area() {
    let mesh = obj("v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf 1 2 3 4 5\n");
    let area = |&[a, b, c]: &[u32; 3]| {
        let [a, b, c] = [a, b, c].map(|i| mesh.positions[i as usize]);
        0.5 * (b - a).cross(c - a).z
    };
    assert_eq!(mesh.triangles.iter().map(area).sum::<f32>(), 10.0);
    assert!(mesh.triangles.iter().all(|triangle| area(triangle) > 0.0));
}

/// The symbols of the groups, the bases of the materials, and the notes.
type Loaded = (Vec<String>, Vec<Base>, Vec<Note>);

/// Loads an OBJ with files beside it.
fn with_files(name: &str, text: &str, files: &[(&str, &str)]) -> Result<Loaded, String> {
    let folder = std::env::temp_dir().join(format!("pellicle-models-{}-{name}", std::process::id()));
    fs::create_dir_all(folder.join("inside")).unwrap();
    let path = folder.join("inside/m.obj");
    fs::write(&path, text).unwrap();
    for (name, text) in files {
        fs::write(folder.join("inside").join(name), text).unwrap();
    }
    let loaded = load(&path, Kind::Obj, &options(1 << 20));
    fs::remove_dir_all(&folder).unwrap();
    let model = loaded.map_err(|error| error.to_string().replace(folder.to_str().unwrap(), ""))?;
    let symbols = model.mesh.groups.iter().map(|group| group.symbol.clone()).collect();
    Ok((symbols, model.materials.into_iter().map(|material| material.base).collect(), model.notes))
}

#[test]
fn libraries_give_colours_images_and_glass() {
    let text = "mtllib a lib.mtl\nmtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl pane\nusemtl red stone\nf 1 2 3\n\
                usemtl pane\nf 3 2 1\nf 2 1 3\n";
    let library = "# x\nnewmtl red stone\nKd 0.5 0.25 0.125\nKs 1 1 1\nmap_Kd -s 1 1 1 t.png\nnewmtl pane\nNi 1.33\nd 0.1\nillum 7\n\
                   newmtl grey\nKd 0.5\nmap_Kd gone.png\n";
    let (symbols, bases, notes) = with_files("libraries", text, &[("a lib.mtl", library), ("t.png", "")]).unwrap();
    assert_eq!(symbols, ["", "red stone", "pane"]);
    let [Base::Diffuse { reflectance: red, .. }, Base::Dielectric { .. }, Base::Diffuse { reflectance: grey, .. }] =
        bases.as_slice()
    else {
        panic!("{bases:?}")
    };
    assert!(red.map.is_some() && red.value == Vec3::ONE);
    assert!(grey.map.is_none() && grey.value == Vec3::splat(0.5));
    let seen: Vec<(usize, &str)> = notes.iter().map(|note| (note.line, note.seen.as_str())).collect();
    let missing = ("the image `gone.png` is missing", "the material library `none.mtl` is missing");
    assert_eq!(seen, [(12, missing.0), (2, missing.1)]);
}

#[test]
fn libraries_lie_in_the_folder_and_hold_numbers() {
    let with = |library: &str, text: &str| with_files("bad-libraries", library, &[("l.mtl", text)]).unwrap_err();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let outside = with(&format!("mtllib ../../../../../../../../etc/hostname\n{triangle}"), "");
    assert!(
        outside.starts_with("/inside/m.obj:1: the material library") && outside.contains("lies outside"),
        "{outside}"
    );
    let inside = format!("mtllib l.mtl\n{triangle}");
    for (library, wanted) in [
        ("newmtl a\nKd 1 0\n", "/inside/l.mtl:2: a colour takes 3 numbers, or 1 for all"),
        ("newmtl a\nKd 1 nan 0\n", "/inside/l.mtl:2: `nan` is not a finite number"),
        ("newmtl a\n\nNi\n", "/inside/l.mtl:3: `` is not a number"),
        ("newmtl a\nmap_Kd ../../../../../../../etc/hostname\n", "/inside/l.mtl:2: the image"),
    ] {
        let error = with(&inside, library);
        assert!(error.starts_with(wanted), "{error}");
    }
}

#[test]
fn broken_objs_are_told_their_line() {
    let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, wanted) in [
        ("v 0 0\n".to_owned(), "m.obj:1: a point takes 3 numbers, here are 2"),
        ("\nv 0 nan 0\n".to_owned(), "m.obj:2: `nan` is not a finite number\n  models that"),
        ("v 0 1e99 0\n".to_owned(), "m.obj:1: `1e99` is not a finite number"),
        ("v 0,5 1 0\n".to_owned(), "m.obj:1: `0,5` has a decimal comma\n  export with decimal points"),
        ("v x 1 0\n".to_owned(), "m.obj:1: `x` is not a number"),
        (
            format!("{three}f 1 2 4\n"),
            "m.obj:4: point 4 does not exist: up to here the file has 3\n  the file is cut off",
        ),
        (format!("{three}f 1 2 -4\n"), "m.obj:4: point -4 does not exist"),
        (format!("{three}f 0 1 2\n"), "m.obj:4: an index is 0\n  OBJ counts from 1"),
        (format!("{three}f 1/1 2 3\n"), "m.obj:4: texture coordinate 1 does not exist: up to here the file has 0"),
        (format!("{three}f 1//9223372036854775807 2 3\n"), "m.obj:4: normal 9223372036854775807 does not exist"),
        (format!("{three}f -9223372036854775808 2 3\n"), "m.obj:4: point -9223372036854775808 does not exist"),
        (format!("{three}f 99999999999999999999 2 3\n"), "m.obj:4: `99999999999999999999` is not an index"),
        (format!("{three}f 1///1 2 3\n"), "m.obj:4: `1///1` has more than 3 indices"),
        (three.to_owned(), "m.obj: holds no triangle\n  clouds of points"),
        (String::new(), "m.obj: holds no triangle"),
        ("\u{1}\u{2}\u{3}\n".to_owned(), "m.obj:1: `???` is no word of OBJ"),
    ] {
        let error = refusal(Kind::Obj, text.as_bytes());
        assert!(error.starts_with(wanted), "{text:?}: {error}");
    }
    let odd = format!("{three}curv 1 2\ncurv 3\nf 1 2\nl 1 2\nf 1 2 3\n");
    let (_, notes) = read(odd.as_bytes(), Path::new("m.obj"), Kind::Obj, &options(1 << 30)).unwrap();
    let seen: Vec<(usize, usize, &str)> =
        notes.iter().map(|note| (note.line, note.count, note.seen.as_str())).collect();
    assert_eq!(seen[0], (4, 2, "`curv` is not supported"));
    assert_eq!(seen.len(), 3);
}

#[test]
fn broken_plys_are_told_what_is_missing() {
    let ascii = |vertices: &str, count: &str, faces: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n{vertices}{faces}"
        )
    };
    let three = "0 0 0\n1 0 0\n0 1 0\n";
    for (text, wanted) in [
        ("solid x\n".to_owned(), "m.ply:1: is no PLY file"),
        (String::new(), "m.ply:1: is no PLY file"),
        ("ply\nformat ascii 1.0\n".to_owned(), "m.ply:3: the header has no `end_header`"),
        ("ply\nformat text 1.0\n".to_owned(), "m.ply:2: unknown format: `format text 1.0`\n  known are ascii"),
        ("ply\nelement vertex many\n".to_owned(), "m.ply:2: a count that is none"),
        ("ply\nelement vertex 3\nproperty half x\n".to_owned(), "m.ply:3: unknown type"),
        ("ply\nproperty float x\n".to_owned(), "m.ply:2: a property of nothing"),
        ("ply\nend_header\n".to_owned(), "m.ply:2: the header names no `format`"),
        (
            ascii(three, "4000000000", "3 0 1 2\n"),
            "m.ply:3: the header promises 4000000000 of `vertex`, there is room for",
        ),
        (ascii(three, "18446744073709551615", ""), "m.ply:3: the header promises 18446744073709551615"),
        (ascii("0 0 0\n1 0 nan\n", "3", "0 0 0"), "m.ply:11: `z` is not a finite number"),
        (ascii("0 0 0\n1 0 1e60\n", "3", "0 0 0"), "m.ply:11: `z` is not a finite number"),
        (ascii("0 0 0\n1 0\n", "3", "0 1 0\n3 0 1 2\n"), "m.ply:11: fewer values than a vertex has"),
        (ascii("0 0 0\n1 0 0 5\n", "3", "0 1 0\n3 0 1 2\n"), "m.ply:11: more values than the header names: `5`"),
        (ascii(three, "3", "3 0 1 3\n"), "m.ply:13: a face names vertex 3, there are 3, counted from 0"),
        (ascii(three, "3", "3 0 1 -1\n"), "m.ply:13: a face names vertex -1"),
        (ascii(three, "3", "3 0 1 0.5\n"), "m.ply:13: a face names vertex 0.5"),
        (ascii(three, "3", "4000000 0 1 2\n"), "m.ply:13: a list of 4000000 values, where there is room for 5"),
        (ascii(three, "3", "-1 0 1 2\n"), "m.ply:13: a list of -1 values"),
        (ascii(three, "3", "x 0 1 2\n"), "m.ply:13: `x` is not a number"),
        (ascii(three, "3", "\n \n"), "m.ply: the file ends in face 0"),
        (ascii(three, "3", "2 0 1\n"), "m.ply: holds no triangle"),
    ] {
        let error = refusal(Kind::Ply, text.as_bytes());
        assert!(error.starts_with(wanted), "{text:?}: {error}");
    }
}

#[test]
fn meshes_keep_to_the_memory_that_they_may_take() {
    let cube = obj_cube(|i| (i + 1).to_string());
    let error = read(cube.as_bytes(), Path::new("m.obj"), Kind::Obj, &options(1500)).unwrap_err().to_string();
    assert_eq!(
        error,
        "m.obj:13: the model takes more than 1500 bytes of memory\n  raise --max-memory if the file is right"
    );
}

/// Every prefix, and every byte with each of its bits turned, is read or refused, without a panic and at once.
#[test]
fn no_damage_hangs_or_panics() {
    let start = Instant::now();
    let cubes = [
        (Kind::Ply, ply_cube(false)),
        (Kind::Ply, ply_cube(true)),
        (Kind::Obj, obj_cube(|i| (i + 1).to_string()).into_bytes()),
    ];
    for (kind, whole) in cubes {
        for length in 0..whole.len() {
            let cut = read(&whole[..length], Path::new("m"), kind, &options(1 << 30));
            assert!(kind == Kind::Obj || cut.is_err(), "{length} bytes of {}", whole.len());
        }
        for i in 0..8 * whole.len() {
            let mut damaged = whole.clone();
            damaged[i / 8] ^= 1 << (i % 8);
            if let Ok((mesh, _)) = read(&damaged, Path::new("m"), kind, &options(1 << 30)) {
                let count = mesh.positions.len() as u32;
                assert!(mesh.triangles.iter().flatten().all(|&index| index < count));
                assert!(mesh.positions.iter().all(|p| p.is_finite()));
                assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-3), "{i}: {:?}", mesh.normals);
            }
        }
    }
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}
