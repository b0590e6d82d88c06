//! One picture.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use super::aov::{Aov, LIGHT_GROUP, Layers};
use super::quick_look::{denoised, quick_looks};
use super::stats::{FilmStats, Stats};
use crate::denoise::{DenoiseError, Denoiser};
use crate::document::{Document, Shape};
use crate::error::Error;
use crate::film::Verdict;
use crate::integrate::Wanted;
use crate::mode::Mode;
use crate::output::{self, Crop, Display, Format, HeaderValue, LayerKind, Picture, PngDepth, Written};
use crate::render::{self, Accumulation, Frame, Plan, Survey, Watch};
use crate::scene::{BuildError, Camera, FilmOptions, Framing, LightGroups, Placed, Raster, Scene, Stage, Window};

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
    pub aovs: Vec<Aov>,
    /// Whether the picture is denoised besides.
    pub denoise: bool,
    /// Most bytes that the scene, and then the picture, may take.
    pub max_memory: u64,
}

impl StillPlan {
    /// True where this layer is to be made.
    pub fn wants(&self, aov: Aov) -> bool {
        self.aovs.contains(&aov)
    }

    /// True where each light has a layer of its own: the colour mode must be a [`Grouped`](crate::mode::Grouped) one then.
    pub fn tells_lights_apart(&self) -> bool {
        self.wants(Aov::Lights)
    }

    /// True where the scene has to be looked at besides rendering it.
    pub fn needs_survey(&self) -> bool {
        self.denoise || self.aovs.iter().any(|aov| aov.needs_survey())
    }
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
    let groups = if plan.tells_lights_apart() { LightGroups::new(document) } else { LightGroups::default() };
    let stage = Stage::movable(document, plan.render.threads, moving, groups, plan.max_memory)
        .map_err(|source| built(document, source))?;
    let (camera, placed) =
        Camera::new(document, plan.camera.as_deref(), plan.raster, plan.framing, stage.bounds).map_err(Error::Usage)?;
    let Window { width, height, .. } = camera.window();
    render::check_memory([width, height], plan.needs_survey() || plan.tells_lights_apart(), plan.max_memory)?;
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

    /// A picture with the variance of every pixel, for those who measure it.
    ///
    /// # Errors
    /// Threads that the machine cannot give.
    pub fn render(&self, plan: &StillPlan, watch: &dyn Watch) -> Result<Frame, Error> {
        Ok(render::render(&self.scene, &self.camera, &plan.render, watch)?)
    }

    /// Sums of these samples of a picture, for [`accumulate`](Self::accumulate).
    pub fn sums(&self, samples: Range<u32>) -> Accumulation {
        Accumulation::cropped(self.camera.size, self.camera.window(), samples)
    }

    /// Adds what `sums` lacks; false where the watch stopped it in the middle. As [`render`](Self::render).
    pub fn accumulate(&self, plan: &StillPlan, sums: &mut Accumulation, watch: &dyn Watch) -> Result<bool, Error> {
        Ok(render::accumulate(&self.scene, &self.camera, &plan.render, sums, watch)?)
    }

    /// Looks at the scene along the camera rays of these samples, where anything of it is wanted.
    ///
    /// # Errors
    /// Threads that the machine cannot give.
    pub fn look(&self, plan: &StillPlan, survey: &mut Option<Survey>, samples: Range<u32>) -> Result<(), Error> {
        if !plan.needs_survey() {
            return Ok(());
        }
        let wanted = Wanted { albedo: plan.wants(Aov::Albedo), film: plan.wants(Aov::Film), clues: plan.denoise };
        let survey = survey.get_or_insert_with(|| Survey::new(self.camera.window(), wanted));
        Ok(survey.add(&self.scene, &self.camera, &plan.render, samples)?)
    }

    /// Everything that goes into the picture's file besides its colours, and the seconds that denoising took, or
    /// why it failed.
    pub fn layers(
        &self,
        document: &Document,
        plan: &StillPlan,
        frame: &Frame,
        survey: Option<&Survey>,
        denoiser: Option<&Denoiser>,
    ) -> (Layers, Result<f64, DenoiseError>) {
        let mut layers = Layers::new(&plan.aovs, frame, survey, document);
        let kind = if plan.look.float { LayerKind::Float } else { LayerKind::Half };
        for (name, part) in self.scene.stage.groups.names.iter().zip(&frame.groups) {
            layers.add_color(&format!("{LIGHT_GROUP}{name}"), kind, part);
        }
        let denoise_s = match (denoiser, survey) {
            (Some(denoiser), Some(survey)) => layers.denoise(denoiser, frame, survey, kind, plan.render.threads),
            _ => Ok(0.0),
        };
        (layers, denoise_s)
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
            survey_s: 0.0,
            survey_cpu_s: 0.0,
            denoise_s: 0.0,
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
pub fn picture(frame: &Frame, layers: Layers, mut header: Vec<(String, HeaderValue)>) -> Picture {
    header.extend([
        ("pellicle/sampleRange".to_owned(), HeaderValue::Text(format!("0-{}", frame.spp))),
        ("samplesPerPixel".to_owned(), HeaderValue::Int(frame.spp as i32)),
        ("pellicle/meanSamplesPerPixel".to_owned(), HeaderValue::Float(frame.mean_spp() as f32)),
        ("renderTimeSeconds".to_owned(), HeaderValue::Float(frame.render_s as f32)),
    ]);
    let rgba = frame.rgb.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
    let Layers { layers, header: of_layers } = layers;
    header.extend(of_layers);
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
    pub display: Display,
    pub png_depth: PngDepth,
    /// 32-bit EXR.
    pub float: bool,
}

/// How the picture's mean differs from the light's, if it does.
fn biased(plan: &Plan) -> Option<String> {
    plan.clamp.map(|limit| format!("samples clamped to {limit}"))
}

/// Writes the picture in the format that its name asks for, and says how long that took. What PNG has no room for goes into
/// files beside it: `NAME.N.png` for the normals. Where there is a denoised picture `NAME.png` is that, and the other one
/// `NAME.noisy.png`.
///
/// # Errors
/// The file cannot be written; an old file of that name is untouched then.
pub fn write(path: &Path, format: Format, picture: &Picture, look: Look) -> Result<(Written, f64), Error> {
    let start = Instant::now();
    let written = match format {
        Format::Exr => output::write_exr(path, picture, look.float)?,
        Format::Png => {
            let beside = |name: &str| path.with_extension(format!("{name}.png"));
            for (name, layers) in quick_looks(picture) {
                let display = if name.starts_with(LIGHT_GROUP) { look.display } else { Display::PLAIN };
                output::write_png(&beside(&name), &layers, display, look.png_depth)?;
            }
            match denoised(picture) {
                Some(denoised) => {
                    output::write_png(&beside("noisy"), picture, look.display, look.png_depth)?;
                    output::write_png(path, &denoised, look.display, look.png_depth)?
                }
                None => output::write_png(path, picture, look.display, look.png_depth)?,
            }
        }
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
