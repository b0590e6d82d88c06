//! Light by name: a studio, a tent, a sky, or an image of some place.

use std::path::{Path, PathBuf};

use glam::Vec3;

use crate::color::Emission;
use crate::document::{self, Document, Image, ImageSource, Quantity};

use super::sky;

/// What lights a model, or a scene besides its own lamps.
#[derive(Clone, Debug, PartialEq)]
pub enum Environment {
    /// Soft boxes in the dark: fringes stand out on what mirrors them.
    Studio,
    /// White all around, as jewellers photograph: a film's colour from everywhere.
    Tent,
    /// Blue sky, and a sun low enough to throw shadows.
    Sky,
    /// A lat-long image.
    Image(PathBuf),
}

/// The names.
const NAMED: [(&str, Environment); 3] =
    [("studio", Environment::Studio), ("tent", Environment::Tent), ("sky", Environment::Sky)];

impl Environment {
    /// A name, or an image file.
    ///
    /// # Errors
    /// Neither.
    pub fn parse(text: &str) -> Result<Self, String> {
        if let Some((_, known)) = NAMED.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text)) {
            return Ok(known);
        }
        let path = Path::new(text);
        if path.is_file() {
            return Ok(Self::Image(path.to_owned()));
        }
        let distance = |name: &str| strsim::damerau_levenshtein(name, text);
        let nearest = NAMED.iter().map(|(name, _)| *name).min_by_key(|name| distance(name));
        Err(match nearest.filter(|name| distance(name) <= 2) {
            Some(name) => format!("did you mean `{name}`?"),
            None => "no such file; known by name are studio, tent and sky".to_owned(),
        })
    }

    /// Reflectance of the floor under a bare model, near it and far away; none where an image shows a place of its own.
    pub fn floor(&self) -> Option<[Vec3; 2]> {
        match self {
            // Graded paper, as photographers hang it behind things.
            Self::Studio => Some([Vec3::splat(0.26), Vec3::splat(0.02)]),
            Self::Tent => Some([Vec3::splat(0.7), Vec3::splat(0.45)]),
            Self::Sky => Some([Vec3::new(0.36, 0.33, 0.29); 2]),
            Self::Image(_) => None,
        }
    }
}

/// Lights a scene from all around, in place of its own environment and what animates that; its lamps, and surfaces that
/// shine, stay.
pub fn light(document: &mut Document, environment: &Environment) {
    let (name, source) = match environment {
        Environment::Studio => ("studio.hdr".to_owned(), sky::painted(sky::studio)),
        Environment::Tent => ("tent.hdr".to_owned(), sky::painted(sky::tent)),
        Environment::Sky => ("sky.hdr".to_owned(), sky::painted(sky::clear_sky)),
        Environment::Image(path) => (path.display().to_string(), ImageSource::File(path.clone())),
    };
    document.channels.retain(|channel| !matches!(channel.drives, Quantity::Environment(_)));
    document.images.push(Image { id: name.clone(), uri: name, user: "--environment".to_owned(), source });
    document.environment = Some(document::Environment {
        image: Some(document.images.len() - 1),
        radiance: Vec3::ONE,
        strength: 1.0,
        rotation_deg: 0.0,
        spectrum: Emission::default(),
    });
}
