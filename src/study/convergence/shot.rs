//! A scene compiled for one colour transport, whichever it is.

use std::sync::Arc;

use crate::batch::Transport;
use crate::batch::still::{Prepared, StillPlan, prepare};
use crate::document::Document;
use crate::error::Error;
use crate::mode::{Rgb, Spectral};
use crate::render::{Frame, Unwatched};
use crate::scene::{Camera, Stage};

/// A scene on its stage, before a colour transport.
#[derive(Clone)]
pub struct Setting<'a> {
    pub document: &'a Document,
    pub stage: Arc<Stage>,
    pub camera: Camera,
}

pub(super) enum Shot {
    Rgb(Prepared<Rgb>),
    Four(Prepared<Spectral<4>>),
    Eight(Prepared<Spectral<8>>),
    Sixteen(Prepared<Spectral<16>>),
}

impl Shot {
    /// # Errors
    /// As [`prepare`].
    pub(super) fn new(
        setting: &Setting,
        plan: &StillPlan,
        transport: Transport,
        wavelengths: usize,
    ) -> Result<Self, Error> {
        let Setting { document, stage, camera } = setting;
        Ok(match (transport, wavelengths) {
            (Transport::Rgb, _) => Self::Rgb(prepare(document, plan, stage, camera)?),
            (Transport::Spectral, 4) => Self::Four(prepare(document, plan, stage, camera)?),
            (Transport::Spectral, 16) => Self::Sixteen(prepare(document, plan, stage, camera)?),
            (Transport::Spectral, _) => Self::Eight(prepare(document, plan, stage, camera)?),
        })
    }

    /// # Errors
    /// Threads that the machine cannot give.
    pub(super) fn render(&self, plan: &StillPlan) -> Result<Frame, Error> {
        match self {
            Self::Rgb(scene) => scene.render(plan, &Unwatched),
            Self::Four(scene) => scene.render(plan, &Unwatched),
            Self::Eight(scene) => scene.render(plan, &Unwatched),
            Self::Sixteen(scene) => scene.render(plan, &Unwatched),
        }
    }
}
