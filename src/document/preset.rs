//! Surfaces by name: soap bubbles, anodised titanium, beetles. Each is a base under films that follows one number.
//!
//! What is simplified is said beside the source: layers are flat, even and isotropic here, in shells and wings they are not.

use glam::Vec3;

use super::material::{Base, Film, Microfacets, Thickness};
use super::texture::Texture;
use crate::color::Index;

/// A named surface.
pub struct Preset {
    pub name: &'static str,
    /// What it is, in a few words.
    pub about: &'static str,
    /// Where its numbers come from, and what is simplified.
    pub source: &'static str,
    pub knob: Knob,
    base: fn() -> Base,
    /// Outermost first, from the knob's value.
    films: fn(f32) -> Vec<Film>,
}

/// The number that a preset follows.
pub struct Knob {
    /// As its attribute in scene files, with the unit.
    pub name: &'static str,
    pub least: f32,
    pub most: f32,
    pub default: f32,
}

impl Preset {
    /// Every preset, in the order in which they are listed.
    pub fn all() -> &'static [Self] {
        PRESETS
    }

    /// By its name, in any case.
    pub fn find(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name.eq_ignore_ascii_case(name))
    }

    pub fn base(&self) -> Base {
        (self.base)()
    }

    /// The films for a value within the knob's range, outermost first.
    pub fn films(&self, value: f32) -> Vec<Film> {
        (self.films)(value)
    }
}

const fn knob(name: &'static str, [least, most]: [f32; 2], default: f32) -> Knob {
    Knob { name, least, most, default }
}

fn named(name: &str) -> Index {
    Index::Named(name.to_owned())
}

fn layer(index: Index, nm: f32) -> Film {
    Film { index, thickness: Thickness::Constant { nm }, weight: 1.0 }
}

/// A layer a quarter of a wavelength thick inside, where its index is `n`.
fn quarter_wave(index: Index, n: f32, centre_nm: f32) -> Film {
    layer(index, centre_nm / (4.0 * n))
}

fn metal(index: Index) -> Base {
    Base::Conductor { index, microfacets: Microfacets::default() }
}

fn clear(index: Index) -> Base {
    Base::Dielectric {
        index,
        microfacets: Microfacets::default(),
        absorption_per_m: Vec3::ZERO,
        fresnel: true,
        priority: None,
    }
}

fn matte(reflectance: [f32; 3], ior: f32) -> Base {
    Base::Diffuse { reflectance: Texture::constant(reflectance.into()), ior }
}

/// Linear between the rows (x, y), which cover the knob's range.
fn between(rows: &[(f32, f32)], x: f32) -> f32 {
    let pair = rows.windows(2).find(|pair| x <= pair[1].0).or(rows.windows(2).next_back());
    pair.map_or(0.0, |pair| {
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        y0 + (y1 - y0) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0)
    })
}

/// Oxide on steel over temperature in degrees Celsius, nm: the thickness at which its computed colour is the one that smiths
/// know the temperature by: light straw, dark straw, brown, purple, dark blue, light blue.
const TEMPER_NM: [(f32, f32); 7] =
    [(176.0, 8.0), (205.0, 21.0), (226.0, 29.0), (260.0, 36.0), (282.0, 41.0), (310.0, 50.0), (337.0, 63.0)];

static PRESETS: &[Preset] = &[
    Preset {
        name: "soap-bubble",
        about: "a soap film with air on both sides",
        source: "index: water (Daimon & Masumura 2007), which it is but for 1 % surfactant; thickness: some ten nm where black \
                 to above 1000 nm, Isenberg 1992, The Science of Soap Films and Soap Bubbles",
        knob: knob("thickness_nm", [5.0, 1500.0], 350.0),
        base: || clear(Index::Constant { n: 1.0, k: 0.0 }),
        films: |nm| vec![layer(named("soap"), nm)],
    },
    Preset {
        name: "oil-on-water",
        about: "a film of oil on clear water",
        source: "thickness: Bonn Agreement Oil Appearance Code, sheen 40 to 300 nm, rainbow 300 to 5000 nm; index: oleic acid \
                 (Jones, King & Ward 2015) stands for oils in general",
        knob: knob("thickness_nm", [5.0, 1500.0], 400.0),
        base: || clear(named("water")),
        films: |nm| vec![layer(named("oil"), nm)],
    },
    Preset {
        name: "anodised-titanium",
        about: "titanium under the oxide that a voltage grows",
        source: "2.5 nm of oxide per volt: Ohtsuka, Masuda & Sato 1985, J. Electrochem. Soc. 132, 787, measured in sulphuric \
                 acid up to 7.5 V; other electrolytes give 1.5 to 2.8, so voltages are nominal above that. Index: amorphous \
                 TiO2 (Siefke 2016)",
        knob: knob("voltage_v", [1.0, 110.0], 20.0),
        base: || metal(named("Ti")),
        films: |volts| vec![layer(named("TiO2"), 2.5 * volts)],
    },
    Preset {
        name: "tempered-steel",
        about: "polished carbon steel after minutes at a temperature in air",
        source: "temperatures of the temper colours: ASM Handbook 4D (2014), p. 550; thickness chosen here so that the \
                 computed colour is the one of that table, the oxide taken as Fe3O4 and the steel as iron",
        knob: knob("temperature_c", [176.0, 337.0], 282.0),
        base: || metal(named("Fe")),
        films: |celsius| vec![layer(named("Fe3O4"), between(&TEMPER_NM, celsius))],
    },
    Preset {
        name: "silicon-oxide",
        about: "a silicon wafer under thermal oxide",
        source: "Pliskin & Conrad 1964, IBM J. Res. Dev. 8, 43, whose table of colours this follows; indices: fused silica \
                 (Malitson 1965) and the table of silicon",
        knob: knob("thickness_nm", [5.0, 1500.0], 300.0),
        base: || metal(named("Si")),
        films: |nm| vec![layer(named("SiO2"), nm)],
    },
    Preset {
        name: "lens-coating",
        about: "crown glass under a quarter wave of MgF2, against reflections",
        source: "Macleod 2010, Thin-Film Optical Filters, chapter 4; indices: MgF2 (Dodge 1984), BK7 (Schott)",
        knob: knob("centre_nm", [350.0, 900.0], 550.0),
        base: || clear(named("BK7")),
        films: |centre_nm| vec![quarter_wave(named("MgF2"), 1.379, centre_nm)],
    },
    Preset {
        name: "dichroic-mirror",
        about: "glass that reflects one colour and lets its complement pass: eleven quarter waves of TiO2 and SiO2",
        source: "Macleod 2010, Thin-Film Optical Filters, chapter 6; indices: TiO2 (Siefke 2016), SiO2 (Malitson 1965)",
        knob: knob("centre_nm", [350.0, 900.0], 450.0),
        base: || clear(named("BK7")),
        films: |centre_nm| {
            let high = quarter_wave(named("TiO2"), 2.45, centre_nm);
            let low = quarter_wave(named("SiO2"), 1.46, centre_nm);
            (0..11).map(|i| if i % 2 == 0 { high.clone() } else { low.clone() }).collect()
        },
    },
    Preset {
        name: "mother-of-pearl",
        about: "nacre: tablets of aragonite with thin sheets of protein and chitin between them, on pale shell",
        source: "tablets of 250 to 500 nm, sheets of some ten: Salman et al. 2021, PNAS 118, e2023623118. Eight tablets, \
                 all alike; the sheets are taken as 30 nm of chitin",
        knob: knob("tablet_nm", [200.0, 600.0], 330.0),
        base: || matte([0.75, 0.72, 0.68], 1.6),
        films: |nm| {
            (0..16)
                .map(|i| if i % 2 == 0 { layer(named("aragonite"), nm) } else { layer(named("chitin"), 30.0) })
                .collect()
        },
    },
    Preset {
        name: "jewel-beetle",
        about: "the wing case of a jewel beetle: sixteen layers of cuticle on melanin",
        source: "layers and a peak at 530 nm (green; 700 nm in its purple stripes): Stavenga et al. 2011, Phil. Trans. R. Soc. B 366, 709; indices \
                 1.68 + 0.03i and 1.55 + 0.14i: Noyes, Vukusic & Hooper 2007, Opt. Express 15, 4351. Quarter waves all",
        knob: knob("peak_nm", [400.0, 800.0], 530.0),
        base: || matte([0.02, 0.015, 0.01], 1.65),
        films: |peak_nm| {
            let dense = quarter_wave(Index::Constant { n: 1.68, k: 0.03 }, 1.68, peak_nm);
            let light = quarter_wave(Index::Constant { n: 1.55, k: 0.14 }, 1.55, peak_nm);
            (0..16).map(|i| if i % 2 == 0 { dense.clone() } else { light.clone() }).collect()
        },
    },
    Preset {
        name: "morpho-butterfly",
        about: "the wing scale of a Morpho: chitin shelves with air between them, above brown pigment",
        source: "index 1.56 + 0.06i and shelves: Vukusic et al. 1999, Proc. R. Soc. B 266, 1403; a period of about 0.2 um: \
                 Kinoshita et al. 2002, Proc. R. Soc. B 269, 1417. Six shelves, a third of the period each; real ones are \
                 narrow and diffract, so that the blue hardly depends on the angle",
        knob: knob("period_nm", [150.0, 260.0], 195.0),
        base: || matte([0.06, 0.04, 0.025], 1.56),
        films: |period_nm| {
            let shelf = layer(Index::Constant { n: 1.56, k: 0.06 }, period_nm / 3.0);
            let air = layer(Index::Constant { n: 1.0, k: 0.0 }, period_nm * 2.0 / 3.0);
            (0..12).map(|i| if i % 2 == 0 { shelf.clone() } else { air.clone() }).collect()
        },
    },
    Preset {
        name: "pigeon-neck",
        about: "the cortex of a pigeon's neck feather over its airy core; about 595 nm on green feathers, 530 nm on purple",
        source: "Yin et al. 2006, Phys. Rev. E 74, 051916; Yoshioka et al. 2007, J. Phys. Soc. Jpn. 76, 013801; index: \
                 Leertouwer, Wilts & Stavenga 2011. The core is taken as a dark body of index 1.2",
        knob: knob("thickness_nm", [300.0, 900.0], 595.0),
        base: || matte([0.03, 0.03, 0.03], 1.2),
        films: |nm| vec![layer(named("keratin"), nm)],
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_complete_over_its_range() {
        for preset in PRESETS {
            let Knob { least, most, default, .. } = preset.knob;
            assert!(least < default && default < most, "{}", preset.name);
            for value in [least, default, most] {
                for film in preset.films(value) {
                    assert!(film.index.curve().is_ok(), "{}", preset.name);
                    let Thickness::Constant { nm } = film.thickness else { panic!("{}", preset.name) };
                    assert!((1.0..5001.0).contains(&nm), "{}: {nm}", preset.name);
                }
            }
        }
    }
}
