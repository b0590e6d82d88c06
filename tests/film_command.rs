//! `pellicle film` as its users meet it: numbers against the truth tables, colours, drawings, errors.
//!
//! Own rows are in `tests/data/film`; the full tables are used where `../shared/film` (or `$PELLICLE_SHARED/film`) is
//! present.

use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::film::shared;
use pellicle::color::{Lab, delta_e_2000, known_index_names};
use pellicle::study::{PLOT_SIZE, SWATCH_SIZE};

fn film(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pellicle")).arg("film").args(args).output().unwrap()
}

/// What is printed; the command must succeed.
fn printed(args: &[&str]) -> String {
    let output = film(args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// What is said on stderr; the command must end with exit code 2.
fn refused(args: &[&str]) -> String {
    let output = film(args);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{args:?}: {text}");
    assert!(output.stdout.is_empty(), "{args:?}");
    text
}

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("pellicle-film-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

fn own(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// Comma-separated fields without comments and heads.
fn fields(csv: &str) -> Vec<Vec<String>> {
    let rows = csv.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn numbers(csv: &str) -> Vec<Vec<f64>> {
    fields(csv).iter().map(|row| row.iter().filter_map(|field| field.parse().ok()).collect()).collect()
}

/// `film` arguments of a system of the truth tables, and whether their indices are measured. `nk` holds the files with the
/// indices that were used; without it they are taken by name.
fn system(name: &str, value: f64, nk: Option<&Path>) -> Option<(Vec<String>, bool)> {
    let measured = |name: &str, file: &str| match nk {
        Some(folder) => format!("@{}", folder.join(format!("nk_{file}.csv")).display()),
        None => name.to_owned(),
    };
    let simple = |a: &str, b: &str, c: &str| (a.to_owned(), vec![format!("{b},{value}")], c.to_owned());
    let (ambient, layers, base) = match name {
        "soap_bubble" => simple("1", "1.33", "1"),
        "soap_on_glass" => simple("1", "1.33", "1.5"),
        "film15_on_water" => simple("1", "1.5", "1.33"),
        "film15_from_water" => simple("1.33", "1.5", "1"),
        "glass_from_inside" => simple("1.5", "1.33", "1"),
        "ftir_gap" => simple("1.5", "air", "1.5"),
        "tio2_on_gold" => simple("1", "2.4", &measured("Au", "Au_Johnson")),
        "sio2_on_al" => simple("1", "1.46", &measured("al", "Al_Rakic")),
        "mgf2_on_glass" => simple("1", "1.38", "1.5"),
        "oxide_on_ti" => simple("1", &measured("tio2", "TiO2_Siefke"), &measured("Ti", "Ti_Johnson")),
        "index_match" => simple("1", "1.5", "1.5"),
        "absorbing_on_glass" => simple("1", "1.6+0.3i", "1.5"),
        // The thickness column is the design wavelength.
        "qw5_on_glass" => {
            let layer = |n: f64| format!("{n},{}", value / 4.0 / n);
            let layers = [2.35, 1.46, 2.35, 1.46, 2.35].map(layer);
            ("1".to_owned(), layers.to_vec(), "1.5".to_owned())
        }
        _ => return None,
    };
    let mut args = vec!["--ambient".to_owned(), ambient, "--base".to_owned(), base];
    args.extend(layers.into_iter().flat_map(|layer| ["--layer".to_owned(), layer]));
    Some((args, ["tio2_on_gold", "sio2_on_al", "oxide_on_ti"].contains(&name)))
}

/// The values of a column, once each, as a list for the command line.
fn distinct<'a>(rows: impl Iterator<Item = &'a Vec<f64>>, column: usize) -> String {
    let values: BTreeSet<String> = rows.map(|row| row[column].to_string()).collect();
    values.into_iter().collect::<Vec<_>>().join(",")
}

/// Worst difference between the rows of a table and the command's, by angle, thickness and, with three keys, wavelength.
fn worst_difference(truth: &[Vec<f64>], name: &str, nk: Option<&Path>, keys: usize, more: &[&str]) -> f64 {
    let mut worst = 0.0f64;
    // The layers of a quarter-wave stack all follow its design wavelength: one run each.
    let stacked = name == "qw5_on_glass";
    let values: BTreeSet<String> =
        truth.iter().map(|row| if stacked { row[1].to_string() } else { String::new() }).collect();
    for value in values {
        let here = |row: &&Vec<f64>| !stacked || row[1].to_string() == value;
        let (mut args, _) = system(name, value.parse().unwrap_or(0.0), nk).unwrap();
        args.extend(["--angles".to_owned(), distinct(truth.iter().filter(here), 0)]);
        if !stacked {
            args.extend(["--thickness".to_owned(), distinct(truth.iter(), 1)]);
        }
        if keys == 3 {
            args.extend(["--wavelengths".to_owned(), distinct(truth.iter().filter(here), 2)]);
        }
        let args: Vec<&str> = args.iter().map(String::as_str).chain(more.iter().copied()).collect();
        let key = |row: &[f64], thickness: f64| {
            let wavelength = if keys == 3 { row[2].to_string() } else { String::new() };
            (row[0].to_string(), thickness.to_string(), wavelength)
        };
        let got: HashMap<_, Vec<f64>> = fields(&printed(&args))
            .iter()
            .filter(|row| keys == 3 || row[0] == "exact")
            .map(|row| row.iter().filter_map(|field| field.parse().ok()).collect::<Vec<f64>>())
            .map(|row| (key(&row, if stacked { 0.0 } else { row[1] }), row))
            .collect();
        for row in truth.iter().filter(here) {
            let found = &got[&key(row, if stacked { 0.0 } else { row[1] })];
            for (a, b) in row[keys..].iter().zip(&found[keys..]) {
                worst = worst.max((a - b).abs());
            }
        }
    }
    worst
}

/// Rows of our own tables that belong to a system, without its name.
fn own_rows(file: &str, name: &str) -> Vec<Vec<f64>> {
    let csv = fs::read_to_string(own(file)).unwrap();
    let rows = fields(&csv).into_iter().filter(|row| row[0] == name);
    rows.map(|row| row[1..].iter().map(|field| field.parse().unwrap()).collect()).collect()
}

const SYSTEMS: [&str; 13] = [
    "soap_bubble",
    "soap_on_glass",
    "film15_on_water",
    "film15_from_water",
    "glass_from_inside",
    "ftir_gap",
    "tio2_on_gold",
    "sio2_on_al",
    "mgf2_on_glass",
    "oxide_on_ti",
    "index_match",
    "absorbing_on_glass",
    "qw5_on_glass",
];

#[test]
fn spectra_agree_with_our_own_share_of_the_truth_tables() {
    for name in SYSTEMS {
        let worst = worst_difference(&own_rows("film/rt.csv", name), name, None, 3, &[]);
        let measured = system(name, 0.0, None).unwrap().1;
        println!("{name:20} {worst:.1e}");
        assert!(worst < if measured { 1e-5 } else { 1e-9 }, "{name}: {worst:e}");
    }
}

#[test]
fn spectra_agree_with_every_row_of_the_shared_tables() {
    let Some(folder) = shared() else { return };
    for name in SYSTEMS {
        let truth = numbers(&fs::read_to_string(folder.join(format!("rt_{name}.csv"))).unwrap());
        let worst = worst_difference(&truth, name, Some(&folder), 3, &[]);
        let measured = system(name, 0.0, None).unwrap().1;
        println!("{name:20} {} rows, worst {worst:.1e}", truth.len());
        assert!(worst < if measured { 1e-5 } else { 1e-9 }, "{name}: {worst:e}");
    }
}

#[test]
fn exact_colours_agree_with_the_truth_tables() {
    for name in SYSTEMS {
        let mut truth = own_rows("film/colour.csv", name);
        let mut nk = None;
        if let Some(folder) = shared() {
            let csv = fs::read_to_string(folder.join(format!("colour_{name}.csv"))).unwrap();
            // theta, thickness, R_lin under D65, T_lin under D65.
            let columns = [0, 1, 5, 6, 7, 17, 18, 19];
            truth.extend(numbers(&csv).iter().map(|row| columns.map(|c| row[c]).to_vec()));
            nk = Some(folder);
        }
        let worst = worst_difference(&truth, name, nk.as_deref(), 2, &["--colour"]);
        println!("{name:20} {} colours, worst {worst:.1e}", truth.len());
        assert!(worst < 1e-5, "{name}: {worst:e}");
    }
}

#[test]
fn delta_e_is_the_distance_to_the_exact_row() {
    let csv = printed(&["--layer", "2.4,0", "--base", "Au", "--thickness", "100,250", "--angles", "0,60", "--colour"]);
    assert!(csv.starts_with("rung,theta_deg,thickness,R_lin_r,R_lin_g,R_lin_b,T_lin_r,T_lin_g,T_lin_b,delta_e\n"));
    let rows = fields(&csv);
    let lab = |row: &[String]| Lab::from_linear_srgb([3, 4, 5].map(|c| row[c].parse().unwrap()));
    for (i, row) in rows.iter().enumerate() {
        let delta_e: f64 = row[9].parse().unwrap();
        assert!((delta_e_2000(lab(&rows[i % 4]), lab(row)) - delta_e).abs() < 1e-6, "{row:?}");
        assert_eq!(row[1..3], rows[i % 4][1..3], "every rung has the same angles and thicknesses");
        assert!(row[0] != "table" || delta_e < 0.1, "{row:?}");
    }
    let rungs: Vec<&str> = rows.iter().step_by(4).map(|row| row[0].as_str()).collect();
    assert_eq!(rungs, ["exact", "table", "three-wave", "gaussian"]);
}

#[test]
fn rungs_that_do_not_apply_are_named_with_the_reason() {
    let output = film(&["--layer", "1.6+0.3i,100", "--base", "Au", "--colour"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("no `bare` rows: a medium absorbs"), "{said}");
    assert!(
        said.contains("no `gaussian` rows: Belcour and Barla's model is for a layer that does not absorb"),
        "{said}"
    );
}

#[test]
fn white_stays_white_under_every_illuminant() {
    for illuminant in ["D65", "e", "A", "blackbody:3200"] {
        let csv =
            printed(&["--ambient", "1.5", "--base", "1", "--angles", "60", "--colour", "--illuminant", illuminant]);
        let row = &fields(&csv)[0];
        for field in &row[3..6] {
            assert!((field.parse::<f64>().unwrap() - 1.0).abs() < 1e-9, "{illuminant}: {row:?}");
        }
    }
}

#[test]
fn the_default_is_a_spectrum_at_normal_incidence() {
    let csv = printed(&["--layer", "1.33,380", "--base", "air"]);
    assert!(csv.starts_with("theta_deg,thickness,lambda_nm,Rs,Rp,Ts,Tp\n0,380,380,"));
    assert_eq!(csv.lines().count(), 82);
    assert_eq!(csv, printed(&["--layer", "1.33,380", "--base", "1", "--wavelengths", "380:780:5", "--csv", "-"]));
    // Bare glass.
    let csv = printed(&["--base", "1.5", "--wavelengths", "550", "--angles", "0:90:45"]);
    assert_eq!(csv.lines().nth(1), Some("0,0,550,0.04,0.04,0.96,0.96"));
    assert_eq!(csv.lines().count(), 4);
}

#[test]
fn a_material_of_a_scene_is_a_stack() {
    let scene = own("good/profile.dae");
    let scene = scene.to_str().unwrap();
    let csv = printed(&["--scene", scene, "--material", "gold", "--wavelengths", "500,600", "--angles", "0,45"]);
    let by_hand = ["--layer", "1.5,0", "--base", "Au", "--thickness", "100,400,700"];
    assert_eq!(csv, printed(&[&by_hand[..], &["--wavelengths", "500,600", "--angles", "0,45"]].concat()));
    let said = refused(&["--scene", scene, "--material", "golt"]);
    assert!(said.contains("--material golt: no material `golt` in the scene, did you mean `gold`?"), "{said}");
    let said = refused(&["--scene", scene, "--material", "lamp"]);
    assert!(said.contains("only emits"), "{said}");
}

#[test]
fn drawings_have_the_size_that_they_say() {
    let folder = folder("drawings");
    let [swatch, plot] = ["swatch.png", "plot.svg"].map(|name| folder.join(name));
    let files = ["--swatch", swatch.to_str().unwrap(), "--plot", plot.to_str().unwrap()];
    let args = ["--layer", "1.33,0", "--base", "1", "--thickness", "0,1000", "--angles", "0,80"];
    assert_eq!(printed(&[&args[..], &files[..]].concat()), "", "drawings alone print no numbers");

    let picture = image::open(&swatch).unwrap().to_rgb8();
    assert_eq!([picture.width() as usize, picture.height() as usize], SWATCH_SIZE);
    assert_eq!(picture.get_pixel(0, 0).0, [255; 3], "paper");
    // Just above the field's lower edge: a film of no thickness is black, one of 1000 nm is not.
    let [left, right] = [60, SWATCH_SIZE[0] as u32 - 40].map(|x| picture.get_pixel(x, 510).0);
    assert!(left.iter().all(|&value| value < 20) && right.iter().any(|&value| value > 40), "{left:?} {right:?}");

    let svg = fs::read_to_string(&plot).unwrap();
    assert!(svg.contains(&format!("width=\"{}\" height=\"{}\"", PLOT_SIZE.0, PLOT_SIZE.1)), "{}", &svg[..300]);
    for word in ["1 / 1.33 / 1", "0°, 1000 nm", "80°, 0 nm", "wavelength / nm"] {
        assert!(svg.contains(word), "{word}");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn names_are_listed_with_their_sources() {
    let list = printed(&["--list"]);
    for name in known_index_names() {
        assert!(list.lines().any(|line| line.trim_start().starts_with(&format!("{name} "))), "{name}");
    }
    assert!(list.contains("main/Au/nk/Johnson"));
    assert!(list.lines().all(|line| !line.ends_with("  ")), "every line has its source");
}

#[test]
fn errors_name_the_flag_the_value_and_the_fix() {
    let folder = folder("errors");
    let table = |name: &str, text: &str| {
        let file = folder.join(name);
        fs::write(&file, text).unwrap();
        format!("@{}", file.display())
    };
    let unordered = table("unordered.csv", "# n,k\nlambda_nm,n,k\n400,1.5,0\n390,1.5,0\n");
    let negative = table("negative.csv", "400,1.5,0\n500,1.5,-1\n");
    let micrometres = table("micrometres.csv", "0.4,1.5\n0.5,1.4\n");
    let wordy = table("wordy.csv", "400,1.5\n500,high\n");
    let empty = table("empty.csv", "lambda_nm,n,k\n");
    let cases: &[(&[&str], &[&str])] = &[
        (&["--base", "Gould"], &["'Gould' for '--base <INDEX>'", "unknown material \"Gould\""]),
        (&["--base", "TiO3"], &["--base", "did you mean \"TiO2\"?"]),
        (&["--base", "1.5x"], &["`1.5x` is not an index", "1.6+0.3i"]),
        (&["--base", "1.5-2i"], &["--base", "k = -2 is negative", "1.6+0.3i"]),
        (&["--base", "-1.5"], &["--base", "n = -1.5"]),
        (&["--layer", "1.33,", "--base", "1"], &["'1.33,' for '--layer <INDEX,NM>'", "thickness missing"]),
        (&["--layer", "1.33", "--base", "1"], &["--layer", "thickness missing", "1.33,250"]),
        (&["--layer", "1.33,-5", "--base", "1"], &["--layer", "-5 nm is negative"]),
        (&["--layer", "1.33,thin", "--base", "1"], &["--layer", "`thin` is not a number"]),
        (&["--layer", "1.33,5"], &["--base missing", "--base Au"]),
        (&["--base", "1.5", "--angles", "95"], &["--angles", "95 is not an angle", "0 to 90"]),
        (&["--base", "1.5", "--angles", "-5"], &["--angles", "-5 is not an angle"]),
        (&["--base", "1.5", "--angles", "0,,5"], &["--angles", "a number is missing"]),
        (&["--base", "1.5", "--angles", "0:85:0"], &["--angles", "`0:85:0` is empty", "380:780:5"]),
        (&["--base", "1.5", "--wavelengths", "0.55"], &["--wavelengths", "multiply by 1000"]),
        (&["--base", "1.5", "--thickness", "5"], &["--thickness", "bare", "--layer"]),
        (&["--base", "1.5", "--swatch", "x.png"], &["--swatch", "bare"]),
        (&["--layer", "1.3,0", "--base", "1", "--swatch", "x.png"], &["--swatch", "no thickness to draw over"]),
        (&["--base", "1.5", "--plot", "x.png"], &["--plot x.png", ".svg"]),
        (&["--base", "1.5", "--plot", "x.svg", "--angles", "0:85:5"], &["--plot x.svg", "18 curves", "12"]),
        (&["--ambient", "Au", "--base", "1"], &["--ambient Au", "absorbing"]),
        (&["--base", "1.5", "--illuminant", "D50"], &["--illuminant", "D65, E, A and blackbody:K"]),
        (&["--base", "1.5", "--colour", "--wavelengths", "500"], &["--colour", "--wavelengths", "cannot be used with"]),
        (&["--base", "@none.csv"], &["--base", "none.csv: cannot read"]),
        (&["--base", &unordered], &["unordered.csv, line 4", "390 nm comes after 400 nm"]),
        (&["--base", &negative], &["negative.csv, line 2", "k = -1"]),
        (&["--base", &micrometres], &["micrometres.csv, line 1", "multiply by 1000"]),
        (&["--base", &wordy], &["wordy.csv, line 2", "`high` is not a number"]),
        (&["--base", &empty], &["empty.csv: no rows"]),
    ];
    for (args, words) in cases {
        let said = refused(args);
        for word in *words {
            assert!(said.contains(word), "{args:?} should say {word:?}, says: {said}");
        }
    }
    fs::remove_dir_all(folder).unwrap();
}
