//! One picture.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use super::stats::{FilmStats, Stats};
use crate::document::{Document, Shape};
use crate::error::Error;
use crate::film::Verdict;
use crate::mode::Mode;
use crate::output::{self, Crop, Format, HeaderValue, Layer, LayerKind, Picture, PngDepth, Written};
use crate::render::{self, Accumulation, Frame, Plan, Watch};
use crate::scene::{BuildError, Camera, FilmOptions, Framing, Placed, Raster, Scene, Stage, Window};

/// What is to be made, with every default filled in.
#[derive(Clone, Debug)]
pub struct StillPlan {
    pub raster: Raster,
    /// Camera or node id; `None`: the first.
    pub camera: Option<String>,
    pub framing: Framing,
    pub films: FilmOptions,
    pub render: Plan,
    pub look: Look,
    /// EXR only.
    pub aovs: Vec<Aov>,
    /// Largest number of bytes for the picture; `None`: what the machine has left.
    pub max_memory: Option<u64>,
}

/// What a picture holds besides its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aov {
    /// `variance.R/G/B`, 32-bit: the variance of each pixel's mean, as if its samples were independent (they are stratified,
    /// which makes the true one smaller); infinite below two samples.
    Variance,
}

/// A scene that is ready to render.
pub struct Prepared<M: Mode> {
    pub(super) scene: Scene<M>,
    pub camera: Camera,
}

/// Shapes, images and lights, and where the camera stands; with what a user should hear of.
///
/// # Errors
/// Images or memory (see [`Stage::new`]), a camera that does not exist, or a picture too large for the memory.
pub fn stage(document: &Document, plan: &StillPlan) -> Result<(Arc<Stage>, Camera, Vec<String>), Error> {
    let (stage, camera, _, notes) = movable_stage(document, plan, Vec::new())?;
    Ok((Arc::new(stage), camera, notes))
}

/// The same for a stage of which parts will move ([`Stage::movable`]), with the rule that placed the camera.
///
/// # Errors
/// As [`stage`].
pub fn movable_stage(
    document: &Document,
    plan: &StillPlan,
    moving: Vec<bool>,
) -> Result<(Stage, Camera, Placed, Vec<String>), Error> {
    let stage = Stage::movable(document, plan.render.threads, moving).map_err(|source| built(document, source))?;
    let (camera, placed) =
        Camera::new(document, plan.camera.as_deref(), plan.raster, plan.framing, stage.bounds).map_err(Error::Usage)?;
    let Window { width, height, .. } = camera.window();
    render::check_memory([width, height], plan.max_memory.unwrap_or_else(render::available_memory))?;
    let mut notes = Vec::new();
    match placed {
        Placed::AsWritten => {}
        Placed::Cs184 => notes.push(
            "framing: CS184 (the file's camera stands under its scene; --framing scene takes it literally)".to_owned(),
        ),
        Placed::Box => notes.push("warning: the scene has no camera; framing everything".to_owned()),
    }
    if stage.lights.emitters.is_empty() {
        notes.push("warning: the scene has no light; the picture will be black".to_owned());
    }
    Ok((stage, camera, placed, notes))
}

/// Compiles the materials for a colour mode.
///
/// # Errors
/// An unknown refractive index.
pub fn prepare<M: Mode>(
    document: &Document,
    plan: &StillPlan,
    stage: &Arc<Stage>,
    camera: &Camera,
) -> Result<Prepared<M>, Error> {
    let scene = Scene::new(stage.clone(), &plan.films).map_err(|source| built(document, source))?;
    Ok(Prepared { scene, camera: camera.clone() })
}

pub(super) fn built(document: &Document, source: BuildError) -> Error {
    Error::Build { scene: document.path.display().to_string(), source }
}

impl<M: Mode> Prepared<M> {
    /// The opening line of a render.
    pub fn summary(&self, document: &Document, plan: &StillPlan) -> String {
        let [width, height] = self.camera.size;
        let crop = match self.camera.crop {
            Some(Window { x, y, width, height }) => format!(" (of which {width}x{height} at {x},{y})"),
            None => String::new(),
        };
        let biased = biased(&plan.render).map(|how| format!(", biased: {how}")).unwrap_or_default();
        let until = plan.render.noise.map(|noise| format!(" at most, to a noise of {noise}")).unwrap_or_default();
        format!(
            "{}: {} triangles, {} materials, {} emitters; {width}x{height}{crop}, {} spp{until}, {} bounces{biased}",
            document.path.display(),
            triangles(document),
            document.materials.len(),
            self.scene.stage.lights.emitters.len(),
            plan.render.spp,
            plan.render.limits.max_bounces
        )
    }

    /// # Errors
    /// Threads that the machine cannot give.
    pub fn render(&self, plan: &StillPlan, watch: &dyn Watch) -> Result<Frame, Error> {
        Ok(render::render(&self.scene, &self.camera, &plan.render, watch)?)
    }

    /// Adds what `sums` lacks; false where the watch stopped it in the middle. As [`render`](Self::render).
    pub fn accumulate(&self, plan: &StillPlan, sums: &mut Accumulation, watch: &dyn Watch) -> Result<bool, Error> {
        Ok(render::accumulate(&self.scene, &self.camera, &plan.render, sums, watch)?)
    }

    /// All that is known before the picture is written; [`Stats::finish`] adds the rest.
    pub fn stats(&self, document: &Document, plan: &StillPlan, frame: &Frame, parse_s: f64) -> Stats {
        let stage = &self.scene.stage;
        let load_s = parse_s + stage.textures_s + self.scene.materials_s + stage.bvh_s;
        let rays = frame.tally.rays + frame.tally.shadow_rays;
        Stats {
            version: env!("CARGO_PKG_VERSION"),
            scene: document.path.display().to_string(),
            scene_sha256: document.sha256.clone(),
            width: frame.width,
            height: frame.height,
            spp: frame.spp,
            mean_spp: frame.mean_spp(),
            noise: Some(frame.noise).filter(|noise| noise.is_finite()),
            seed: plan.render.seed,
            mode: M::NAME,
            max_bounces: plan.render.limits.max_bounces,
            threads: frame.threads,
            triangles: triangles(document),
            parse_s,
            textures_s: stage.textures_s,
            materials_s: self.scene.materials_s,
            bvh_s: stage.bvh_s,
            load_s,
            render_s: frame.render_s,
            render_cpu_s: frame.render_cpu_s,
            write_s: 0.0,
            total_s: load_s + frame.render_s,
            rays: frame.tally.rays,
            shadow_rays: frame.tally.shadow_rays,
            samples_per_s: frame.total as f64 / frame.render_s,
            mrays_per_s: rays as f64 * 1e-6 / frame.render_s,
            non_finite: frame.tally.non_finite,
            beyond_range: frame.tally.beyond_range,
            clamped_samples: frame.tally.clamped,
            clamped: 0,
            out_of_gamut: 0,
            peak_rss_mb: render::peak_rss_mb(),
            films: self.films(),
        }
    }

    /// What the picture's file will tell of how it was made, but for samples and times.
    pub fn header(&self, document: &Document, plan: &StillPlan) -> Vec<(String, HeaderValue)> {
        let text = |value: &str| HeaderValue::Text(value.to_owned());
        let mut header = vec![
            ("pellicle/version".to_owned(), text(env!("CARGO_PKG_VERSION"))),
            ("pellicle/scene".to_owned(), text(&document.path.display().to_string())),
            ("pellicle/sceneHash".to_owned(), text(&document.sha256)),
            ("pellicle/mode".to_owned(), text(M::NAME)),
            ("pellicle/seed".to_owned(), HeaderValue::Int(plan.render.seed as i32)),
            ("pellicle/films".to_owned(), text(&serde_json::to_string(&self.films()).unwrap_or_default())),
        ];
        if self.camera.pixel_aspect != 1.0 {
            header.push((output::PIXEL_ASPECT.to_owned(), HeaderValue::Float(self.camera.pixel_aspect)));
        }
        if let Some(noise) = plan.render.noise {
            header.push(("pellicle/noiseTarget".to_owned(), HeaderValue::Float(noise as f32)));
        }
        if let Some(how) = biased(&plan.render) {
            header.push(("pellicle/biased".to_owned(), text(&how)));
        }
        header
    }

    fn films(&self) -> Vec<FilmStats> {
        let named = |(material, verdict): (&str, &Verdict)| FilmStats {
            material: material.to_owned(),
            verdict: verdict.clone(),
        };
        self.scene.verdicts().map(named).collect()
    }
}

/// The frame with its further layers, and what is known of how it was made ([`Prepared::header`]).
pub fn picture(frame: &Frame, aovs: &[Aov], mut header: Vec<(String, HeaderValue)>) -> Picture {
    header.extend([
        ("pellicle/sampleRange".to_owned(), HeaderValue::Text(format!("0-{}", frame.spp))),
        ("samplesPerPixel".to_owned(), HeaderValue::Int(frame.spp as i32)),
        ("pellicle/meanSamplesPerPixel".to_owned(), HeaderValue::Float(frame.mean_spp() as f32)),
        ("renderTimeSeconds".to_owned(), HeaderValue::Float(frame.render_s as f32)),
    ]);
    let rgba = frame.rgb.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
    let layers = aovs.iter().flat_map(|aov| aov.layers(frame)).collect();
    let Frame { width, height, size: [full_width, full_height], window, .. } = *frame;
    let is_part = window != Window::whole(frame.size);
    let crop = is_part.then_some(Crop { x: window.x, y: window.y, full_width, full_height });
    Picture { width, height, crop, rgba, layers, header }
}

/// What a picture that is on its way tells of itself.
pub fn progress(sums: &Accumulation) -> Vec<(String, HeaderValue)> {
    vec![
        ("samplesPerPixel".to_owned(), HeaderValue::Int(sums.spp() as i32)),
        ("renderTimeSeconds".to_owned(), HeaderValue::Float(sums.render_s as f32)),
    ]
}

/// How pictures are written.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// PNG only.
    pub exposure_ev: f32,
    pub png_depth: PngDepth,
    /// 32-bit EXR.
    pub float: bool,
}

impl Aov {
    /// The names of its channels.
    pub fn channels(self) -> [&'static str; 3] {
        match self {
            Self::Variance => ["variance.R", "variance.G", "variance.B"],
        }
    }

    fn layers(self, frame: &Frame) -> [Layer; 3] {
        let values = match self {
            Self::Variance => &frame.variance,
        };
        let layer = |channel: usize| Layer {
            name: self.channels()[channel].to_owned(),
            kind: LayerKind::Float,
            data: values.iter().map(|value| value[channel]).collect(),
        };
        std::array::from_fn(layer)
    }
}

/// How the picture's mean differs from the light's, if it does.
fn biased(plan: &Plan) -> Option<String> {
    plan.clamp.map(|limit| format!("samples clamped to {limit}"))
}

/// Writes the picture in the format that its name asks for, and says how long that took.
///
/// # Errors
/// The file cannot be written; an old file of that name is untouched then.
pub fn write(path: &Path, format: Format, picture: &Picture, look: Look) -> Result<(Written, f64), Error> {
    let start = Instant::now();
    let written = match format {
        Format::Exr => output::write_exr(path, picture, look.float)?,
        Format::Png => output::write_png(path, picture, look.exposure_ev, look.png_depth)?,
    };
    Ok((written, start.elapsed().as_secs_f64()))
}

fn triangles(document: &Document) -> u64 {
    let count = |shape: &Shape| match shape {
        Shape::Mesh(mesh) => mesh.triangles.len() as u64,
        Shape::Sphere { .. } => 0,
    };
    document.geometries.iter().map(|geometry| count(&geometry.shape)).sum()
}
