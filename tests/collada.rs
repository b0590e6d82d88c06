//! COLLADA files: bad ones give exactly the error that lies beside them, good ones load to what their author meant.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::f32::consts::PI;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use pellicle::collada::{FalloffRule, LoadOptions, MissingTexture, Warning, load};
use pellicle::color::{Emission, Index};
use pellicle::document::*;

#[path = "collada/shared_scenes.rs"]
mod shared_scenes;

fn data(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(folder)
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

/// With `PELLICLE_BLESS` set, the errors as they are now are written down; read them before they are committed.
#[test]
fn bad_files_give_exactly_their_error() {
    let bless = std::env::var_os("PELLICLE_BLESS").is_some();
    let mut files: Vec<PathBuf> = std::fs::read_dir(data("bad")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "dae"));
    files.sort();
    assert!(files.len() >= 40, "{} bad files", files.len());
    let mut failures = Vec::new();
    for file in &files {
        let name = file.file_name().unwrap().to_str().unwrap();
        let text = match load(file, &LoadOptions::default()) {
            Ok(_) => "loads without an error".to_owned(),
            Err(error) => error.to_string().replace(file.to_str().unwrap(), name) + "\n",
        };
        let expected = file.with_extension("txt");
        if bless {
            std::fs::write(&expected, &text).unwrap();
        } else if std::fs::read_to_string(&expected).unwrap_or_default() != text {
            failures.push(format!("{name} gives\n{text}"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

fn good(name: &str) -> (Document, Vec<Warning>) {
    load_good(name, &LoadOptions::default())
}

fn load_good(name: &str, options: &LoadOptions) -> (Document, Vec<Warning>) {
    load(&data("good").join(name), options).unwrap_or_else(|error| panic!("{error}"))
}

fn mesh<'d>(document: &'d Document, id: &str) -> &'d Mesh {
    match &document.geometries.iter().find(|geometry| geometry.id == id).unwrap().shape {
        Shape::Mesh(mesh) => mesh,
        Shape::Sphere { .. } => panic!("{id} is a sphere"),
    }
}

fn material<'d>(document: &'d Document, id: &str) -> &'d Material {
    document.materials.iter().find(|material| material.id == id).unwrap()
}

fn light<'d>(document: &'d Document, id: &str) -> &'d Light {
    document.lights.iter().find(|light| light.id == id).unwrap()
}

fn node<'d>(document: &'d Document, id: &str) -> &'d Node {
    document.nodes.iter().find(|node| node.id == id).unwrap()
}

/// Sum of the triangles' areas; each must face +z.
fn area_facing_z(mesh: &Mesh) -> f32 {
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
        let doubled = (b - a).cross(c - a);
        assert!(doubled.z > 0.0, "{triangle:?} is turned over");
        doubled.z / 2.0
    };
    mesh.triangles.iter().map(area).sum()
}

fn close(a: Vec3, b: Vec3) -> bool {
    a.distance(b) <= 1e-5 * b.length().max(1.0)
}

#[test]
fn every_kind_of_primitive_becomes_triangles() {
    let (document, warnings) = good("primitives.dae");
    for (id, triangles, area) in [
        ("triangles", 2, 1.0),
        ("polylist", 3, 1.5),
        ("concave", 2, 1.5),
        ("holes", 13, 16.0 - 1.0 - 0.5),
        ("strips", 3, 1.5),
        ("fans", 3, 1.5),
        ("lines", 1, 0.5),
        ("seam", 2, 1.0),
    ] {
        let mesh = mesh(&document, id);
        assert_eq!(mesh.triangles.len(), triangles, "{id}");
        assert!((area_facing_z(mesh) - area).abs() < 1e-5, "{id} has area {}", area_facing_z(mesh));
        assert_eq!(mesh.groups.last().unwrap().triangles.end, triangles, "{id}");
    }
    assert_eq!(mesh(&document, "lines").degenerate, 1);
    assert!(mesh(&document, "triangles").normals.is_empty());
    assert!(warnings.iter().any(|warning| warning.seen.contains("<lines>")));
}

#[test]
fn accessors_skip_unnamed_parameters_and_shared_offsets_keep_their_sets() {
    let (document, _) = good("primitives.dae");
    let mesh = mesh(&document, "accessor");
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(mesh.normals, [Vec3::Z; 3], "unit length, and the zero normal replaced by the face's");
    let sets: Vec<u32> = mesh.uv_sets.iter().map(|set| set.set).collect();
    assert_eq!(sets, [1, 4]);
    assert_eq!(mesh.uv_sets[1].uvs, [Vec2::splat(5.0), Vec2::splat(6.0), Vec2::splat(6.0)]);
}

#[test]
fn vertices_are_split_where_normals_differ_and_nowhere_else() {
    let (document, _) = good("primitives.dae");
    let seam = mesh(&document, "seam");
    assert_eq!(seam.positions.len(), 5);
    let symbols: Vec<&str> = seam.groups.iter().map(|group| group.symbol.as_str()).collect();
    assert_eq!(symbols, ["a", "b"]);
    let smooth = LoadOptions { smooth_normals: true, ..LoadOptions::default() };
    let (document, _) = load_good("primitives.dae", &smooth);
    let seam = mesh(&document, "seam");
    assert_eq!((seam.positions.len(), seam.normals.as_slice()), (4, [Vec3::Z; 4].as_slice()));
}

#[test]
fn our_profile_is_read_in_full() {
    let (document, warnings) = good("profile.dae");
    assert!(warnings.is_empty(), "{warnings:?}");
    let Base::Diffuse { reflectance, ior } = &material(&document, "diffuse").base else { panic!() };
    assert_eq!((reflectance.value, *ior), (Vec3::new(0.1, 0.2, 0.3), 1.6));
    let map = reflectance.map.as_ref().unwrap();
    assert_eq!((map.encoding, map.texcoord.as_str()), (Encoding::Srgb, "UV"));
    assert_eq!(document.images[map.image].uri, "a%20dot.png");
    assert_eq!(material(&document, "diffuse").normal_map.as_ref().unwrap().scale, 2.0);
    let film = &material(&document, "diffuse").films[0];
    assert_eq!((&film.index, film.weight), (&Index::Named("SiO2".to_owned()), 0.5));

    let Base::Conductor { index, microfacets } = &material(&document, "table").base else { panic!() };
    assert_eq!(index, &Index::Table(vec![(400.0, 1.0, 3.0), (500.0, 1.5, 3.0), (600.0, 2.0, 4.0)]));
    assert_eq!((microfacets.distribution, microfacets.roughness.value), (Distribution::Beckmann, 0.2));
    assert!(microfacets.roughness.map.is_some());
    let films = &material(&document, "table").films;
    assert_eq!(films[0].index, Index::Constant { n: 1.33, k: 0.01 });
    assert!(matches!(films[0].thickness, Thickness::Noise { nm: 550.0, octaves: 3, seed: 7, .. }));
    assert!(matches!(films[1].thickness, Thickness::Constant { nm: 100.0 }));
    let rgb = material(&document, "rgb");
    assert!(matches!(rgb.films[0].thickness, Thickness::Drain { top_nm: 50.0, bottom_nm: 900.0, exponent: 2.0 }));
    let Thickness::Map { max_nm, map, .. } = &material(&document, "gold").films[0].thickness else { panic!() };
    assert_eq!((*max_nm, map.channel, map.encoding), (700.0, Channel4::R, Encoding::Linear));
    let Base::Dielectric { index, absorption_per_m, fresnel, .. } = &material(&document, "bubble").base else {
        panic!()
    };
    assert_eq!((index, *absorption_per_m), (&Index::Constant { n: 1.0, k: 0.0 }, Vec3::new(1.0, 2.0, 3.0)));
    assert!(*fresnel);
    let emission = material(&document, "lamp").emission.as_ref().unwrap();
    assert_eq!((emission.spectrum.clone(), emission.two_sided), (Emission::Blackbody(3200.0), false));
    assert!(close(emission.radiance.value, Vec3::splat(0.214_041)), "sRGB is decoded");
    assert!(document.materials.iter().all(|material| material.opacity.value == 1.0));
}

#[test]
fn lights_camera_and_hints_of_our_profile() {
    let (document, _) = good("profile.dae");
    // 2 x 3 units of 0.1 m.
    let power = light(&document, "power");
    assert!(close(power.color, Vec3::splat(6.0 / (PI * 0.06))), "{}", power.color);
    assert!(matches!(power.kind, LightKind::Area { shape: AreaShape::Rectangle, presence: Presence::Hidden }));
    // 2 per unit of 0.1 m.
    let falloff = Falloff::Attenuation { constant: 1.0, linear: 20.0, quadratic: 0.0 };
    let fading = light(&document, "fading");
    assert!(matches!(fading.kind, LightKind::Point { radius_m: 0.0, falloff: own } if own == falloff));
    let dot = light(&document, "dot");
    assert!(matches!(dot.kind, LightKind::Point { radius_m: 0.25, falloff: Falloff::Physical }));
    let literal = LoadOptions { falloff: FalloffRule::Collada, ..LoadOptions::default() };
    let (_, warnings) = load_good("profile.dae", &literal);
    assert!(warnings.iter().any(|warning| warning.seen.contains("`radius_m` of a point light")), "{warnings:?}");
    assert_eq!(dot.spectrum, Emission::D65);
    assert!(matches!(light(&document, "sun").kind, LightKind::Directional { angle_deg: 0.53 }));
    let lens = document.cameras[0].lens.unwrap();
    assert_eq!((lens.aperture_radius_m, lens.focus_distance_m, lens.blades), (0.0125, 3.0, 6));
    let environment = document.environment.as_ref().unwrap();
    assert_eq!((environment.strength, environment.rotation_deg), (2.0, 90.0));
    let hints = &document.render;
    assert_eq!((hints.width, hints.spp, hints.camera.as_deref()), (Some(64), Some(9), Some("cam-node")));
    assert_eq!(hints.pixel_aspect, Some(2.0));
    assert!(close(document.to_world.transform_point3(Vec3::new(1.0, 2.0, 3.0)), Vec3::new(0.1, 0.3, -0.2)));
    assert!(!document.has_cgl);
}

#[test]
fn the_course_dialect() {
    let (document, warnings) = good("cgl.dae");
    assert!(document.has_cgl);
    let emission = material(&document, "emission").emission.as_ref().unwrap();
    assert!(emission.two_sided && emission.radiance.value == Vec3::new(1.0, 2.0, 3.0));
    let mirror = material(&document, "mirror");
    assert_eq!(mirror.tint.reflect, Vec3::new(1.0, 0.8, 0.4));
    assert!(matches!(mirror.base, Base::Conductor { index: Index::Constant { n: 0.0, .. }, .. }));
    assert!(matches!(material(&document, "refraction").base, Base::Dielectric { fresnel: false, .. }));
    let Base::Conductor { microfacets, .. } = &material(&document, "microfacet").base else { panic!() };
    assert_eq!((microfacets.distribution, microfacets.roughness.value), (Distribution::Beckmann, 0.25));
    let film = material(&document, "film");
    assert_eq!((film.tint.reflect, film.tint.transmit), (Vec3::new(0.5, 0.25, 0.5), Vec3::new(0.5, 1.0, 1.0)));
    assert!(matches!(film.films[0].thickness, Thickness::Constant { nm: 500.0 }));
    let bubble = material(&document, "bubble");
    assert!(matches!(bubble.base, Base::Dielectric { index: Index::Constant { n: 1.0, .. }, fresnel: true, .. }));
    let Item::Geometry { geometry, bindings } = &node(&document, "mirror-node").items[0] else { panic!() };
    assert!(matches!(document.geometries[*geometry].shape, Shape::Sphere { radius: 0.3 }));
    assert_eq!(document.materials[bindings[0].material].id, "mirror");

    let ids: Vec<&str> = document.lights.iter().map(|light| light.id.as_str()).collect();
    assert_eq!(ids, ["l-area2", "l-ambient", "l-dir", "l-point", "l-spot"], "the area light in the mesh is dropped");
    assert!(node(&document, "same-place").items.is_empty());
    assert!(matches!(node(&document, "elsewhere").items[0], Item::Light(0)));
    assert!(warnings.iter().any(|warning| warning.seen.contains("`l-area` lies in an emissive mesh")));
}

#[test]
fn the_common_profile() {
    let (document, warnings) = good("common.dae");
    let Base::Diffuse { reflectance, .. } = &material(&document, "textured").base else { panic!() };
    let map = reflectance.map.as_ref().unwrap();
    assert_eq!((map.encoding, map.wrap), (Encoding::Srgb, [Wrap::Clamp, Wrap::Mirror]));
    assert!(matches!(&document.images[map.image].source, ImageSource::File(path) if path.ends_with("good/a dot.png")));
    assert!(matches!(material(&document, "glow").base, Base::Black));
    assert_eq!(material(&document, "a_one").opacity.value, 0.4);
    assert!((material(&document, "rgb_zero").opacity.value - 0.75).abs() < 1e-4);
    assert_eq!(material(&document, "cutout").opacity.map.as_ref().unwrap().channel, Channel4::A);
    let Base::Diffuse { reflectance, .. } = &material(&document, "param").base else { panic!() };
    assert_eq!(reflectance.value, Vec3::new(0.7, 0.8, 0.9));
    let Item::Geometry { bindings, .. } = &node(&document, "textured-node").items[0] else { panic!() };
    assert_eq!(bindings[0].uv_sets, [("UV".to_owned(), 2)], "the mesh has only set 2");
    for part in ["symbol `m` is not bound", "<specular>", "TEXCOORD set 0"] {
        assert!(warnings.iter().any(|warning| warning.seen.contains(part)), "{part}: {warnings:?}");
    }
    let inverted = LoadOptions { invert_opacity: true, ..LoadOptions::default() };
    assert_eq!(material(&load_good("common.dae", &inverted).0, "a_one").opacity.value, 0.6);
}

#[test]
fn lamps_of_blender_are_in_watts_since_2_80() {
    let (document, _) = good("blender_lights.dae");
    let color = |id: &str| light(&document, id).color;
    let rgb = Vec3::new(4.0, 2.0, 1.0);
    assert!(close(color("point"), rgb / (4.0 * PI)));
    assert!(matches!(light(&document, "point").kind, LightKind::Point { radius_m: 0.1, falloff: Falloff::Physical }));
    assert!(close(color("sun"), Vec3::splat(3.0)));
    assert!(close(color("spot"), Vec3::splat(1.0 / PI)));
    assert!(matches!(
        light(&document, "spot").kind,
        LightKind::Spot { cone_deg: 40.0, edge: SpotEdge::Blend(0.25), .. }
    ));
    // The node scales x by 3.
    assert!(close(color("rect"), rgb / (PI * 3.0)));
    assert!(close(color("disk"), rgb / (PI * 3.0 * PI)));
    let child = &document.nodes[node(&document, "rect-node").children[0]];
    assert!(matches!(child.transforms[0].kind, TransformKind::Scale(size) if size == Vec3::new(2.0, 0.5, 1.0)));

    let (document, warnings) = good("blender_lights_old.dae");
    assert_eq!(light(&document, "point").color, rgb);
    assert_eq!(light(&document, "rect").color, rgb, "radiance as written");
    assert!(warnings.iter().any(|warning| warning.seen.starts_with("attenuation 1 0 0.0016")));
}

/// Blender takes a unit for a metre: its lamps light a scene alike at any scale.
#[test]
fn lamps_of_blender_follow_the_unit() {
    let text = std::fs::read_to_string(data("good/blender_lights.dae")).unwrap();
    let file = std::env::temp_dir().join(format!("pellicle-unit-{}.dae", std::process::id()));
    std::fs::write(&file, text.replace(r#"meter="1""#, r#"meter="0.01""#)).unwrap();
    let (small, warnings) = load(&file, &LoadOptions::default()).unwrap();
    std::fs::remove_file(&file).unwrap();
    assert!(!warnings.iter().any(|warning| warning.seen.contains("watts")), "{warnings:?}");
    let (large, _) = good("blender_lights.dae");
    for (id, ratio) in [("point", 1e-4), ("spot", 1e-4), ("sun", 1.0), ("rect", 1.0), ("disk", 1.0)] {
        let relative = light(&small, id).color / light(&large, id).color;
        assert!(relative.abs_diff_eq(Vec3::splat(ratio), 1e-5 * ratio), "{id}: {relative}");
    }
    assert!(
        matches!(light(&small, "point").kind, LightKind::Point { radius_m, .. } if (radius_m - 0.001).abs() < 1e-9)
    );
}

#[test]
fn nodes_compose_in_order_and_are_shared() {
    let (document, warnings) = good("nodes.dae");
    assert_eq!(instanced_triangles(&document), 5);
    assert_eq!(node(&document, "turntable").children[0], node(&document, "turntable").children[1]);
    let local = node(&document, "turntable").local();
    assert!(close(local.transform_point3(Vec3::new(1.0, 1.0, 0.0)), Vec3::new(1.0, 4.0, 2.0)));
    let kinds = node(&document, "all").transforms.iter().map(|transform| transform.kind);
    assert!(matches!(
        kinds.collect::<Vec<_>>()[..],
        [TransformKind::LookAt { .. }, TransformKind::Skew { .. }, TransformKind::Matrix(_)]
    ));
    assert_eq!(document.cameras[0].shift, Vec2::new(0.1, -0.2));
    assert!(warnings.iter().any(|warning| warning.advice.contains("bind pose")));

    let [turn, zoom] = &document.channels[..] else { panic!("{:?}", document.channels) };
    assert_eq!((turn.target.as_str(), turn.times_s.len(), turn.width), ("turntable/spin.ANGLE", 3, 1));
    assert_eq!(turn.out_tangents[1], Vec2::new(1.0 + 2.0 / 3.0, 100.0), "a third of the way to the next key");
    assert_eq!(zoom.interpolation, [Interpolation::Step, Interpolation::Linear]);
    for part in ["interpolation CARDINAL", "`nobody/xfov`"] {
        assert!(warnings.iter().any(|warning| warning.seen.contains(part)), "{part}");
    }
}

#[test]
fn archives_and_the_newer_version() {
    for name in ["collada15.dae", "archive.zae"] {
        let (document, _) = good(name);
        assert_eq!(instanced_triangles(&document), 1);
        let is_bytes = matches!(document.images[0].source, ImageSource::Bytes(_));
        assert_eq!(is_bytes, name.ends_with("zae"));
    }
    let error = load(&data("good/escape.zae"), &LoadOptions::default()).unwrap_err();
    assert!(error.message.ends_with("leads out of the archive"), "{error}");
    let small = LoadOptions { max_bytes: 1_000_000, ..LoadOptions::default() };
    let error = load(&data("good/bomb.zae"), &small).unwrap_err();
    assert!(error.message.contains("more bytes than the limit"), "{error}");
    assert!(load(&data("good/primitives.dae"), &LoadOptions { max_bytes: 100, ..small }).is_err());
}

#[test]
fn lenient_drops_what_is_broken_and_says_so() {
    assert!(load(&data("good/lenient.dae"), &LoadOptions::default()).is_err());
    let (document, warnings) = load_good("lenient.dae", &LoadOptions { lenient: true, ..LoadOptions::default() });
    assert_eq!((instanced_triangles(&document), document.cameras.len()), (1, 0));
    for part in ["position 2 is not finite", "here are 15"] {
        assert!(warnings.iter().any(|warning| warning.seen.contains(part)), "{part}: {warnings:?}");
    }
}

#[test]
fn images_outside_the_folder_need_permission() {
    let scene = data("bad/map_outside.dae");
    let error = load(&scene, &LoadOptions::default()).unwrap_err();
    assert!(error.message.contains("outside the scene's folder"), "{error}");
    let allowed = LoadOptions { allow_path: vec![data("good")], ..LoadOptions::default() };
    assert!(load(&scene, &allowed).is_ok());
    let magenta = LoadOptions { missing_texture: MissingTexture::Magenta, ..LoadOptions::default() };
    let (document, warnings) = load(&data("bad/map_missing_image.dae"), &magenta).unwrap();
    assert!(matches!(document.images[0].source, ImageSource::Missing));
    assert_eq!(warnings.len(), 1);
}
