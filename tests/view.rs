//! Views: what a display is sent for colours inside and outside of its reach.

use glam::Vec3;
use pellicle::color::view::{View, srgb_decode, srgb_encode};

use crate::cli::{Folder, fail, succeed};

const VIEWS: [View; 4] = [View::Srgb, View::Agx, View::Filmic, View::None];

fn grey(view: View, value: f32) -> f32 {
    let (signal, outside) = view.show(Vec3::splat(value));
    assert!((signal.max_element() - signal.min_element()).abs() < 2e-3, "{view:?} tints {value}: {signal}");
    assert_eq!(outside, value > 1.0 && matches!(view, View::Srgb | View::None), "{view:?} {value}");
    signal.y
}

#[test]
fn greys_stay_grey_and_rise_from_black_to_white() {
    for view in VIEWS {
        let mut last = -1.0;
        for step in -20..=10 {
            let signal = grey(view, 2f32.powi(step));
            assert!(signal >= last - 1e-6 && (0.0..=1.0).contains(&signal), "{view:?}: {signal} after {last}");
            last = signal;
        }
        assert!(grey(view, 0.0).abs() < 2e-3 && grey(view, 1000.0) > 0.99, "{view:?}");
    }
}

#[test]
fn mid_grey_is_where_each_view_puts_it() {
    for view in [View::Srgb, View::None, View::Filmic] {
        assert!((grey(view, 0.18) - srgb_encode(0.18)).abs() < 1e-3, "{view:?}: {}", grey(view, 0.18));
    }
    // AgX: 0.18 becomes half the signal; 16 stops are told apart where sRGB has long been white.
    assert!((grey(View::Agx, 0.18) - 0.49).abs() < 0.02, "{}", grey(View::Agx, 0.18));
    assert!((0.8..0.95).contains(&grey(View::Agx, 4.0)), "{}", grey(View::Agx, 4.0));
}

#[test]
fn colours_that_srgb_holds_are_shown_as_they_are() {
    for rgb in [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.2, 0.7, 0.4), Vec3::new(0.0, 1.0, 1.0)] {
        for view in [View::Srgb, View::None] {
            let (signal, outside) = view.show(rgb);
            assert!(!outside && (signal.map(srgb_decode) - rgb).abs().max_element() < 1e-5, "{rgb}: {signal}");
        }
    }
}

/// An angle of hue, by the opponent colours of CIELAB: independent of what the mapping works in.
fn hue_deg(rgb: Vec3) -> f64 {
    let lab = pellicle::color::Lab::from_linear_srgb(rgb.to_array().map(f64::from));
    lab.b.atan2(lab.a).to_degrees()
}

#[test]
fn colours_beyond_srgb_keep_their_hue_where_clipping_turns_it() {
    // A bright orange that clipping makes yellow, a film's green and magenta.
    for rgb in [Vec3::new(3.0, 1.0, 0.1), Vec3::new(-0.3, 0.8, 0.1), Vec3::new(0.9, -0.25, 0.6)] {
        let turned = |view: View| {
            let (signal, outside) = view.show(rgb);
            assert!(outside);
            let turn = hue_deg(signal.map(srgb_decode)) - hue_deg(rgb);
            ((turn + 540.0).rem_euclid(360.0) - 180.0).abs()
        };
        let [kept, clipped] = [turned(View::Srgb), turned(View::None)];
        assert!(kept < 8.0 && kept < clipped, "{rgb}: {kept} against {clipped} degrees");
    }
    for view in VIEWS {
        assert_eq!(view.show(Vec3::NAN), (Vec3::ZERO, true));
        let (signal, outside) = view.show(Vec3::new(f32::INFINITY, 1.0, -0.1));
        assert!(
            outside && !signal.is_nan() && signal.min_element() >= 0.0 && signal.max_element() <= 1.0,
            "{view:?} {signal}"
        );
    }
}

#[test]
fn pictures_and_videos_take_the_view_that_is_asked_for() {
    let folder = Folder::new("view");
    let codes = |name: &str| image::open(folder.file(name)).unwrap().to_rgb16().into_raw();
    let mut shown = Vec::new();
    for view in ["srgb", "agx", "filmic", "none"] {
        let file = folder.file(&format!("{view}.png"));
        let run = succeed(&["render", "room.dae", "-o", &file, "--view", view, "--png-depth", "16"]);
        // The lamp is brighter than white: views with a curve have room for it.
        let told = run.stderr.contains("pixels are outside sRGB and were brought inside");
        assert_eq!(told, ["srgb", "none"].contains(&view), "{view}: {}", run.stderr);
        shown.push(codes(&format!("{view}.png")));
    }
    assert!(shown.windows(2).all(|pair| pair[0] != pair[1]));
    // An EXR that is made a video is shown by the same view.
    succeed(&["render", "room.dae", "-o", &folder.file("f.0001.exr"), "--float", "-q"]);
    succeed(&["encode", &folder.file("f.####.exr"), "-o", &folder.file("v.png"), "--view", "agx", "-q"]);
    let eight = |codes: &[u16]| codes.iter().map(|&code| f32::from(code) / 257.0).collect::<Vec<f32>>();
    let (still, video) = (eight(&shown[1]), eight(&codes("v.png")));
    assert!(still.iter().zip(&video).all(|(a, b)| (a - b).abs() <= 1.0), "the video's first frame differs");
    assert!(fail(2, &["render", "room.dae", "-o", &folder.file("a.png"), "--view", "aces"]).contains("filmic"));
}
