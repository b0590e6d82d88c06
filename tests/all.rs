//! All tests, one binary. Each module says what it proves.

// Clippy's own exception for tests does not reach their helper functions.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod animation; // what channels drive, and what a posed document holds
mod blender; // the add-on: scenes of Blender read and rendered, against Cycles
mod bsdf; // sampling agrees with densities; energy; reciprocity
mod camera; // parts of pictures have the bits of the whole; wide pixels; apertures
mod chart; // `pellicle chart`: what is charted is what was measured
mod cli; // the program as it is run: exit codes, messages, signals
mod collada; // files load to what they say; bad ones give exactly the error that helps
mod compare; // `pellicle compare`, variance layers, and what says that it is biased
mod dependencies; // licences, and where the code comes from
mod documents; // examples load and commands run, as the documents say
mod embree; // layouts and hits against closed forms
mod faults; // files from strangers, full disks, stopped processes: nothing lost, nothing let in
mod film; // the optics against independent truth tables
mod film_command; // `pellicle film` against the same tables; errors that help; drawings
mod golden; // shipped scenes against stored pictures
mod house; // the order of the rooms, where unsafe may be, files that stay readable
mod layers; // layers beside the picture, mattes, the denoiser, what other tools make of our files
mod models; // OBJ and PLY: all their forms, and what hostile ones are told
mod nesting; // bodies in, beside and across each other
mod output; // files are whole or absent
mod presets; // named surfaces and the colours that their sources tell of
mod stability; // where methods fail: finite, bounded, continuous at every extreme
mod statistics; // the tests' own tools
mod textures; // images as they reach the picture
mod thrown; // caustics by light paths and without them
mod transport; // closed forms, strategies agree, threads do not matter
mod view; // what a display is sent for colours inside and outside of its reach
