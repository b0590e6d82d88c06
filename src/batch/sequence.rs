//! Many pictures of one scene: loaded once, built once, posed for each frame.

use std::ops::AddAssign;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use glam::{Mat3, Vec3};

use super::animate::Animation;
use super::aov::Aov;
use super::budget::{Budget, Limited, Schedule};
use super::frames::Pattern;
use super::row::Row;
use super::shutter::{Shutter, Until};
use super::still::{self, Prepared, StillPlan, built};
use super::thumbnail::Thumbnail;
use super::turntable::{Turning, Turntable};
use crate::denoise::Denoiser;
use crate::document::Document;
use crate::error::Error;
use crate::mode::Mode;
use crate::output::{self, Format, HeaderValue};
use crate::render::{Frame, Plan, Survey, Watch};
use crate::scene::{Camera, Framing, Placed, Pose, Stage};

/// What changes from frame to frame.
pub enum Motion {
    Turntable(Turntable),
    Animation(Animation),
}

impl Motion {
    /// For each placement of the document, whether it will move.
    pub fn moving(&self) -> Vec<bool> {
        let moves = match self {
            Self::Turntable(table) => &table.turns,
            Self::Animation(animation) => &animation.moves,
        };
        if moves.contains(&true) { moves.clone() } else { Vec::new() }
    }
}

/// What all frames have in common besides the picture itself.
pub struct SequencePlan {
    pub pattern: Pattern,
    pub format: Format,
    /// The same sample pattern in every frame; else frame n has the seed plus n.
    pub seed_lock: bool,
    pub budget: Budget,
    /// Motion blur, where it is wanted.
    pub shutter: Option<Shutter>,
    /// Where frames are denoised.
    pub denoiser: Option<Denoiser>,
    /// Stands for everything that decides what a frame looks like; goes into each file, for resuming.
    pub settings: String,
}

/// Seconds that were spent before the first frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Loading {
    pub parse_s: f64,
    /// The choice of the colour mode.
    pub pilot_s: f64,
}

/// A scene that is built, before its colour mode is settled.
pub struct Staged {
    pub document: Document,
    pub plan: SequencePlan,
    pub still: StillPlan,
    pub motion: Motion,
    pub stage: Arc<Stage>,
    /// What the stage was made with, and by which rule.
    pub camera: Camera,
    pub placed: Placed,
    pub loading: Loading,
    /// Of the batch.
    pub start: Instant,
}

impl Staged {
    /// Compiles the materials for a colour mode.
    ///
    /// # Errors
    /// An unknown refractive index.
    pub fn sequence<M: Mode>(self) -> Result<Sequence<M>, Error> {
        let Self { document, plan, mut still, motion, stage, camera, placed, loading, start } = self;
        let bounds = stage.bounds;
        let prepared = still::prepare::<M>(&document, &still, &stage, &camera)?;
        // The rule and the size hold for all frames, whatever the animation does to camera and scene.
        still.framing = if placed == Placed::Cs184 { Framing::Cs184 } else { Framing::Scene };
        still.raster.size = camera.size.map(Some);
        let schedule = Schedule::new(plan.budget, still.render.spp, start);
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default().trim().to_owned();
        let (loading, last) = (Some(loading), None);
        Ok(Sequence { document, plan, still, motion, prepared, rest: camera, bounds, schedule, loading, last, host })
    }
}

/// A scene with its motion, ready to render frames in any order.
pub struct Sequence<M: Mode> {
    document: Document,
    plan: SequencePlan,
    still: StillPlan,
    motion: Motion,
    prepared: Prepared<M>,
    /// As the file has it, before any motion; and the scene's box then.
    rest: Camera,
    bounds: (Vec3, Vec3),
    schedule: Schedule,
    /// What the first frame has to answer for.
    loading: Option<Loading>,
    /// When the last frame was done: what came after it, as reporting it, counts for the next.
    last: Option<Instant>,
    host: String,
}

/// What one frame has become.
pub struct Done {
    pub row: Row,
    /// Of a frame that was written.
    pub thumbnail: Option<Thumbnail>,
}

/// What posing took.
#[derive(Default)]
struct Posed {
    bvh_s: f64,
    materials_s: f64,
    instances_moved: usize,
    materials_compiled: usize,
}

impl AddAssign for Posed {
    fn add_assign(&mut self, more: Self) {
        self.bvh_s += more.bvh_s;
        self.materials_s += more.materials_s;
        self.instances_moved += more.instances_moved;
        self.materials_compiled += more.materials_compiled;
    }
}

impl<M: Mode> Sequence<M> {
    /// The opening line.
    pub fn summary(&self) -> String {
        self.prepared.summary(&self.document, &self.still)
    }

    /// Renders a frame and writes it; `left` frames are to come, itself included. `None` when the watch stopped it: nothing
    /// was written then.
    ///
    /// What is wrong with this frame alone comes back as a row that says so.
    ///
    /// # Errors
    /// A full disk.
    pub fn render(&mut self, frame: u32, left: usize, watch: &dyn Watch) -> Result<Option<Done>, Error> {
        let start = self.last.unwrap_or_else(Instant::now);
        let path = self.plan.pattern.path(frame);
        // Find out before rendering whether it can be written.
        let writable = output::check_picture(&path).map_err(Error::from);
        let made = writable.and_then(|_| self.make(frame, left, watch, &path, start));
        self.last = Some(Instant::now());
        match made {
            Err(Error::Output(error)) if error.is_disk_full() => Err(Error::Output(error)),
            Err(error) => {
                let row =
                    Row { status: "failed".to_owned(), reason: error.to_string(), ..self.row(frame, &path, start) };
                Ok(Some(Done { row, thumbnail: None }))
            }
            Ok(done) => Ok(done),
        }
    }

    fn make(
        &mut self,
        frame: u32,
        left: usize,
        watch: &dyn Watch,
        path: &Path,
        start: Instant,
    ) -> Result<Option<Done>, Error> {
        // Render within the limit.
        let limit = self.schedule.limit(left);
        let seed = if self.plan.seed_lock { 0 } else { frame };
        let mut still = self.still.clone();
        still.render = Plan { spp: limit.spp, seed: still.render.seed.wrapping_add(seed), ..still.render };
        let limited = Limited { watch, limit, start: Instant::now() };
        let (image, survey, posed) = self.expose(frame, &still, &limited)?;
        if watch.stop() && image.spp < limit.spp {
            return Ok(None);
        }

        // Write it with what is needed to recognise it.
        let loading = self.loading.take();
        let parse_s = loading.map_or(0.0, |loading| loading.parse_s);
        let mut stats = self.prepared.stats(&self.document, &still, &image, parse_s);
        let denoiser = self.plan.denoiser.as_ref();
        let (layers, denoised) = self.prepared.layers(&self.document, &still, &image, survey.as_ref(), denoiser);
        let (denoise_s, reason) = denoised.map_or_else(|error| (0.0, error.to_string()), |s| (s, String::new()));
        let mut picture = still::picture(&image, layers, self.prepared.header(&self.document, &still));
        picture.header.push((output::SETTINGS.to_owned(), HeaderValue::Text(self.plan.settings.clone())));
        picture.header.push(("imageCounter".to_owned(), HeaderValue::Int(frame as i32)));
        let (written, write_s) = still::write(path, self.plan.format, &picture, still.look)?;
        stats.finish(&written, write_s);

        // Sum up.
        let first = |seconds: f64| if loading.is_some() { seconds } else { 0.0 };
        let load_s = first(stats.load_s) + loading.map_or(0.0, |loading| loading.pilot_s);
        let mut row = Row {
            threads: stats.threads,
            spp: stats.spp,
            seed: stats.seed,
            budget_s: limit.time_s,
            parse_s,
            textures_s: first(stats.textures_s),
            bvh_s: first(stats.bvh_s) + posed.bvh_s,
            materials_s: first(stats.materials_s) + posed.materials_s,
            pilot_s: loading.map_or(0.0, |loading| loading.pilot_s),
            render_s: stats.render_s,
            render_cpu_s: stats.render_cpu_s,
            reason,
            denoise_s,
            write_s,
            rays: stats.rays,
            shadow_rays: stats.shadow_rays,
            mrays_per_s: stats.mrays_per_s,
            samples_per_s: stats.samples_per_s,
            noise: Some(image.noise).filter(|noise| noise.is_finite()),
            noise_p95: Some(image.noise_p95).filter(|noise| noise.is_finite()),
            non_finite: stats.non_finite,
            clamped: stats.clamped,
            out_of_gamut: stats.out_of_gamut,
            bvh_builds: u32::from(loading.is_some()),
            instances_moved: posed.instances_moved,
            materials_compiled: posed.materials_compiled
                + if loading.is_some() { self.document.materials.len() } else { 0 },
            pixel_sha256: image.sha256(),
            peak_rss_mb: stats.peak_rss_mb,
            ..self.row(frame, path, start)
        };
        let thumbnail = Thumbnail::of(&image.rgb, image.width, self.still.look.display);
        row.total_s = load_s + start.elapsed().as_secs_f64();
        row.settle();
        self.schedule.note(row.spp, row.render_s, row.total_s - load_s);
        Ok(Some(Done { row, thumbnail: Some(thumbnail) }))
    }

    /// Poses and renders: once, or for each sample where the shutter takes its time.
    fn expose(
        &mut self,
        frame: u32,
        still: &StillPlan,
        limited: &Limited,
    ) -> Result<(Frame, Option<Survey>, Posed), Error> {
        let frame = f64::from(frame);
        let mut survey = None;
        let wants_variance = still.wants(Aov::Variance);
        let Some(shutter) = self.plan.shutter else {
            let posed = self.pose(frame)?;
            let mut sums = self.prepared.sums(0..limited.limit.spp);
            self.prepared.accumulate(still, &mut sums, limited)?;
            let image = sums.into_frame(wants_variance);
            self.prepared.look(still, &mut survey, 0..image.spp)?;
            return Ok((image, survey, posed));
        };
        let mut posed = Posed::default();
        let mut sums = self.prepared.sums(0..limited.limit.spp);
        for index in 0..limited.limit.spp {
            posed += self.pose(frame + shutter.moment(index))?;
            self.prepared.accumulate(still, &mut sums, &Until { watch: limited, spp: index + 1 })?;
            if sums.spp() <= index {
                break;
            }
            self.prepared.look(still, &mut survey, index..index + 1)?;
        }
        Ok((sums.into_frame(wants_variance), survey, posed))
    }

    /// Brings the scene to a frame, or between two; builds no more anew than has changed.
    fn pose(&mut self, frame: f64) -> Result<Posed, Error> {
        let Self { document, prepared, motion, still, .. } = self;
        match motion {
            Motion::Turntable(table) => {
                let motion = table.motion(frame);
                if table.turning == Turning::Camera {
                    prepared.camera = self.rest.moved(&motion);
                    return Ok(Posed::default());
                }
                let clock = Instant::now();
                let sky = if table.turning == Turning::Light { motion.matrix3.into() } else { Mat3::IDENTITY };
                let pose = Pose { placements: table.placements(&motion), sky };
                let moved = prepared.scene.pose(document, &pose).map_err(|e| built(document, e))?;
                Ok(Posed { bvh_s: clock.elapsed().as_secs_f64(), instances_moved: moved, ..Posed::default() })
            }
            Motion::Animation(animation) => {
                animation.pose(document, frame)?;
                let changes = &animation.changes;
                let mut posed = Posed::default();
                if changes.cameras || changes.nodes {
                    let wanted = still.camera.as_deref();
                    let camera = Camera::new(document, wanted, still.raster, still.framing, self.bounds);
                    prepared.camera = camera.map_err(Error::Usage)?.0;
                }
                let clock = Instant::now();
                if changes.lights || !changes.materials.is_empty() || (changes.nodes && animation.moves.contains(&true))
                {
                    let pose = Pose { placements: document.placements(), sky: Mat3::IDENTITY };
                    posed.instances_moved = prepared.scene.pose(document, &pose).map_err(|e| built(document, e))?;
                    posed.bvh_s = clock.elapsed().as_secs_f64();
                }
                let clock = Instant::now();
                posed.materials_compiled = changes.materials.len();
                prepared.scene.recompile(document, &changes.materials, &still.films).map_err(|e| built(document, e))?;
                posed.materials_s = clock.elapsed().as_secs_f64();
                animation.changes = Default::default();
                Ok(posed)
            }
        }
    }

    /// What is known of a frame before it is made.
    fn row(&self, frame: u32, path: &Path, start: Instant) -> Row {
        let moment = match &self.motion {
            Motion::Turntable(table) => table.angle_deg(f64::from(frame)),
            Motion::Animation(animation) => animation.time_s(f64::from(frame)),
        };
        Row {
            frame,
            moment,
            file: path.display().to_string(),
            status: "ok".to_owned(),
            width: self.rest.size[0],
            height: self.rest.size[1],
            mode: M::NAME.to_owned(),
            host: self.host.clone(),
            scene_sha256: self.document.sha256.clone(),
            settings: self.plan.settings.clone(),
            total_s: start.elapsed().as_secs_f64(),
            ..Row::default()
        }
    }
}
