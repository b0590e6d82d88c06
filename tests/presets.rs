//! Named surfaces: as scenes and the command line know them, and whether they have the colours that their sources tell of.

use std::fs;
use std::process::Command;

use pellicle::collada::{LoadOptions, load};
use pellicle::color::{Emission, Sensor};
use pellicle::document::{Base, Preset, Thickness};
use pellicle::film::{Side, exact};
use pellicle::study::Coating;

/// Hue in degrees (red 0, yellow 60, green 120, cyan 180, blue 240, magenta 300) and chroma over value, of the colour under
/// daylight.
fn hue(name: &str, value: f32, angle_deg: f64) -> (f64, f64) {
    let coating = Coating::of_preset(Preset::find(name).unwrap(), value).unwrap();
    let sensor = Sensor::new(&Emission::D65);
    let mut rgb = [0.0; 3];
    for nm in (380..=780).map(f64::from) {
        let cos = angle_deg.to_radians().cos();
        let reflect = exact(&coating.stack, Side::Outside, cos, coating.range.min_nm, nm).mean().reflect;
        let weight = sensor.reflectance_weight(nm);
        rgb = std::array::from_fn(|c| rgb[c] + weight[c] * reflect);
    }
    let [r, g, b] = rgb.map(|v: f64| v.max(0.0).powf(1.0 / 2.2));
    let (high, low) = (r.max(g).max(b), r.min(g).min(b));
    let sector = match high {
        v if v == r => (g - b) / (high - low),
        v if v == g => 2.0 + (b - r) / (high - low),
        _ => 4.0 + (r - g) / (high - low),
    };
    ((60.0 * sector).rem_euclid(360.0), (high - low) / high)
}

/// Every (name, number, angle) must have a hue between the two, and be no grey.
fn check(rows: &[(&str, f32, f64, [f64; 2])]) {
    for &(name, value, angle_deg, [low, high]) in rows {
        let (hue, chroma) = hue(name, value, angle_deg);
        assert!(chroma > 0.05, "{name} {value} at {angle_deg}: grey");
        let turned = (hue - low).rem_euclid(360.0);
        assert!(turned <= high - low, "{name} {value} at {angle_deg}: hue {hue:.0}, wanted {low}..{high}");
    }
}

const YELLOW: [f64; 2] = [30.0, 70.0];
const GREEN: [f64; 2] = [75.0, 180.0];
const BLUE: [f64; 2] = [185.0, 265.0];
const PURPLE: [f64; 2] = [260.0, 350.0];

#[test]
fn temper_colours_are_those_that_smiths_know() {
    let steel = "tempered-steel";
    check(&[
        (steel, 205.0, 0.0, YELLOW),
        (steel, 226.0, 0.0, YELLOW),
        // Brown is a dark orange.
        (steel, 260.0, 0.0, [0.0, 50.0]),
        (steel, 282.0, 0.0, PURPLE),
        (steel, 310.0, 0.0, BLUE),
        (steel, 337.0, 0.0, BLUE),
    ]);
}

/// The table of Pliskin & Conrad 1964, where it names one colour.
#[test]
fn oxidised_wafers_have_the_colours_of_the_table() {
    let oxide = "silicon-oxide";
    check(&[
        (oxide, 120.0, 0.0, BLUE),
        (oxide, 150.0, 0.0, BLUE),
        (oxide, 220.0, 0.0, YELLOW),
        (oxide, 270.0, 0.0, PURPLE),
        (oxide, 310.0, 0.0, BLUE),
        (oxide, 350.0, 0.0, GREEN),
        (oxide, 470.0, 0.0, PURPLE),
        (oxide, 520.0, 0.0, GREEN),
    ]);
}

/// Yellow, purple, blue, pale, yellow, pink, blue, green: the order that anodisers know.
#[test]
fn titanium_goes_through_its_colours_in_order() {
    let titanium = "anodised-titanium";
    check(&[
        (titanium, 10.0, 0.0, [15.0, 60.0]),
        (titanium, 15.0, 0.0, PURPLE),
        (titanium, 22.0, 0.0, BLUE),
        (titanium, 47.0, 0.0, YELLOW),
        (titanium, 60.0, 0.0, PURPLE),
        (titanium, 70.0, 0.0, [165.0, 265.0]),
        (titanium, 83.0, 0.0, GREEN),
    ]);
}

/// Green feathers turn purple at an angle, and purple ones green.
#[test]
fn the_two_feathers_of_a_pigeon_swap_their_colours() {
    check(&[
        ("pigeon-neck", 595.0, 0.0, GREEN),
        ("pigeon-neck", 595.0, 60.0, PURPLE),
        ("pigeon-neck", 530.0, 0.0, PURPLE),
        ("pigeon-neck", 530.0, 60.0, GREEN),
    ]);
}

#[test]
fn animals_and_glasses_have_their_colours() {
    check(&[
        ("jewel-beetle", 530.0, 0.0, GREEN),
        ("morpho-butterfly", 195.0, 0.0, BLUE),
        ("dichroic-mirror", 450.0, 0.0, BLUE),
    ]);
    // An antireflection film dims all colours, green the most.
    let (hue, _) = hue("lens-coating", 550.0, 0.0);
    assert!((230.0..350.0).contains(&hue), "{hue}");
}

#[test]
fn scenes_take_surfaces_and_films_by_name() {
    let folder = std::env::temp_dir().join(format!("pellicle-presets-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let file = folder.join("scene.dae");
    let read = |base: &str| {
        let own = format!("<extra><technique profile=\"pellicle\">{base}</technique></extra>");
        fs::write(&file, include_str!("data/textured_screen.xml").replace("EFFECT", &own).replace("SKY", "0")).unwrap();
        load(&file, &LoadOptions::default()).map(|(document, _)| document.materials[0].clone())
    };
    for preset in Preset::all() {
        let knob = &preset.knob;
        let material = read(&format!("<preset name=\"{}\" {}=\"{}\"/>", preset.name, knob.name, knob.most)).unwrap();
        let told =
            |films: &[pellicle::document::Film]| films.iter().map(|film| format!("{film:?}")).collect::<Vec<_>>();
        assert_eq!(told(&material.films), told(&preset.films(knob.most)), "{}", preset.name);
        assert_eq!(format!("{:?}", material.base), format!("{:?}", preset.base()), "{}", preset.name);
        let default = read(&format!("<preset name=\"{}\"/>", preset.name)).unwrap();
        assert_eq!(told(&default.films), told(&preset.films(knob.default)), "{}", preset.name);
    }

    // On a base of one's own, below another film, thinner here than there.
    let material = read(
        "<conductor metal=\"Al\"><film thickness_nm=\"10\" ior=\"1.5\"/><film preset=\"anodised-titanium\" \
         voltage_v=\"30\"><noise amplitude=\"0.1\"/></film></conductor>",
    );
    let material = material.unwrap();
    let [_, film] = material.films.as_slice() else { panic!("{} films", material.films.len()) };
    let Thickness::Noise { nm, amplitude, .. } = film.thickness else { panic!("{:?}", film.thickness) };
    assert_eq!((nm, amplitude), (75.0, 0.1));

    // Bases of presets can be rough; what cannot be is said.
    let rough = read("<preset name=\"tempered-steel\" roughness=\"0.3\"/>").unwrap();
    assert!(matches!(rough.base, Base::Conductor { microfacets, .. } if microfacets.roughness.value == 0.3));
    for (bad, words) in [
        ("<preset name=\"soap-buble\"/>", "soap-bubble"),
        ("<preset/>", "no `name`"),
        ("<preset name=\"anodised-titanium\" voltage=\"3\"/>", "voltage_v"),
        ("<preset name=\"anodised-titanium\" voltage_v=\"300\"/>", "1..110"),
        ("<preset name=\"jewel-beetle\"><noise/></preset>", "16 layers"),
        ("<diffuse><opacity/></diffuse>", "neither `value` nor `image`"),
        ("<dielectric priority=\"-1\"/>", "0..255"),
    ] {
        let error = read(bad).err().unwrap().to_string();
        assert!(error.contains(words), "{bad}: {error}");
    }
    let _ = fs::remove_dir_all(folder);
}

#[test]
fn the_command_line_knows_them() {
    let film = |args: &[&str]| Command::new(env!("CARGO_BIN_EXE_pellicle")).arg("film").args(args).output().unwrap();
    let listed = String::from_utf8(film(&["--list"]).stdout).unwrap();
    for preset in Preset::all() {
        assert!(listed.contains(preset.name) && listed.contains(preset.source), "{}", preset.name);
    }
    // 20 V are 50 nm of TiO2 on titanium.
    let spectra = |args: &[&str]| String::from_utf8(film(args).stdout).unwrap();
    let same = [
        ["--preset", "anodised-titanium:20", "--wavelengths", "500"].as_slice(),
        &["--layer", "TiO2,50", "--base", "Ti", "--wavelengths", "500"],
    ];
    let last = |text: String| text.lines().last().unwrap_or_default().to_owned();
    assert_eq!(last(spectra(same[0])), last(spectra(same[1])));
    let sheet = std::env::temp_dir().join(format!("pellicle-sheet-{}.png", std::process::id()));
    assert!(film(&["--list", "--swatch", sheet.to_str().unwrap()]).status.success());
    assert!(image::open(&sheet).unwrap().width() > 1000);
    let _ = fs::remove_file(sheet);
    for (bad, words) in
        [("soap", "known are"), ("anodised-titanium:500", "1..110"), ("soap-bubble:thick", "not a number")]
    {
        let output = film(&["--preset", bad]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && told.contains(words), "{bad}: {told}");
    }
}
