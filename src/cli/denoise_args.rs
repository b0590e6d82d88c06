//! Whether pictures are denoised.

use std::path::PathBuf;

use clap::Args;

use super::render::TalkArgs;
use crate::denoise::{DenoiseError, Denoiser};
use crate::error::Error;

#[derive(Args)]
pub struct DenoiseArgs {
    /// Denoise by Open Image Denoise [default library: $PELLICLE_OIDN_LIB, else the system's]: in EXR the layer `denoised`
    /// beside the noisy picture; a PNG is denoised, and NAME.noisy.png beside it is not
    #[arg(long = "denoise", value_name = "LIBRARY", num_args = 0..=1, require_equals = true)]
    library: Option<Option<PathBuf>>,
}

impl DenoiseArgs {
    pub fn is_wanted(&self) -> bool {
        self.library.is_some()
    }

    /// The denoiser, if one is wanted and there is one: a picture without it is better than none, so its absence is only
    /// told.
    ///
    /// # Errors
    /// Parts cannot be denoised.
    pub fn load(&self, is_part: bool, talk: &TalkArgs) -> Result<Option<Denoiser>, Error> {
        let Some(library) = &self.library else { return Ok(None) };
        if is_part {
            return Err(Error::Usage("a part of the samples cannot be denoised; leave out --denoise".to_owned()));
        }
        let denoiser: Result<Denoiser, DenoiseError> = Denoiser::load(library.as_deref());
        match &denoiser {
            Ok(denoiser) => talk.inform(&format!("denoising by {}", denoiser.version())),
            Err(error) => talk.inform(&format!("warning: {error}; the picture stays noisy")),
        }
        Ok(denoiser.ok())
    }
}
