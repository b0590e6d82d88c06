//! Cameras: which one, where it stands, and the rays it sends.

use glam::{Affine3A, Mat4, Vec2, Vec3};

use super::{Interior, Raster, Scene, Window};
use crate::document::{Document, Item, Lens, Projection};
use crate::embree::Ray;
use crate::math::warp::square_to_disk;
use crate::mode::Mode;

/// Which rule places the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Framing {
    /// The CS184 rule when the file carries CGL data and its camera stands at or below everything; else as written.
    #[default]
    Auto,
    /// As the file says.
    Scene,
    /// The CS184 course's: only the direction of the camera node counts; the eye moves to see the whole scene.
    Cs184,
}

/// A camera in world space, for one picture size.
#[derive(Clone, Debug)]
pub struct Camera {
    origin: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Half the picture at unit distance (perspective), or in metres (orthographic).
    half: Vec2,
    shift: Vec2,
    orthographic: bool,
    lens: Option<Lens>,
    pub size: [u32; 2],
    /// The part of the picture that is rendered, where it is not all.
    pub crop: Option<Window>,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// What its rays begin in ([`Camera::settled`]).
    pub interior: Interior,
}

/// Distance of the CS184 eye from the centre of the scene, in diagonals of its box.
const CS184_DISTANCE: f32 = 1.5;
/// A camera of the document with the place of its node.
pub struct CameraPlace {
    /// Index into [`Document::cameras`].
    pub camera: usize,
    pub node_id: String,
    pub to_world: Mat4,
}

/// Every placed camera, in file order.
pub fn cameras(document: &Document) -> Vec<CameraPlace> {
    let mut found = Vec::new();
    for (node, to_world) in document.placements() {
        for item in &document.nodes[node].items {
            if let Item::Camera(camera) = item {
                found.push(CameraPlace { camera: *camera, node_id: document.nodes[node].id.clone(), to_world });
            }
        }
    }
    found
}

/// What [`Camera::new`] decided, for the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placed {
    AsWritten,
    Cs184,
    /// No camera in the file: the scene's box is framed.
    Box,
}

impl Camera {
    /// `wanted` is a camera or node id; `raster` overrides the file's size and the default. `bounds` is the scene's box,
    /// world space.
    ///
    /// # Errors
    /// `wanted` names no camera of the file: the message lists them. A crop that leaves the picture.
    pub fn new(
        document: &Document,
        wanted: Option<&str>,
        raster: impl Into<Raster>,
        framing: Framing,
        bounds: (Vec3, Vec3),
    ) -> Result<(Self, Placed), String> {
        let raster = raster.into();
        let mut places = cameras(document);
        if let Some(id) = wanted {
            let names: Vec<String> = places.iter().map(|p| document.cameras[p.camera].id.clone()).collect();
            places.retain(|p| p.node_id == id || document.cameras[p.camera].id == id);
            if places.is_empty() {
                return Err(format!("no camera `{id}` in the scene; it has {}", list(&names)));
            }
        }
        let Some(place) = places.first() else {
            return Ok((Self::around(bounds, &raster).cropped(raster.crop)?, Placed::Box));
        };
        let source = &document.cameras[place.camera];
        let aspect = natural_aspect(&source.projection);
        let size = raster.pixels(aspect);

        // A camera node's scale must not change what it sees.
        let forward = place.to_world.transform_vector3(-Vec3::Z).try_normalize().unwrap_or(-Vec3::Z);
        let up_hint = place.to_world.transform_vector3(Vec3::Y);
        let eye = place.to_world.transform_point3(Vec3::ZERO);
        let scale = document.to_world.x_axis.truncate().length();
        let (half, orthographic) = half_extent(&source.projection, (size, raster.pixel_aspect), scale);

        let low_eye = eye.y <= bounds.0.y + 1e-4 * (bounds.1 - bounds.0).max_element();
        let course = match framing {
            Framing::Scene => false,
            Framing::Cs184 => true,
            Framing::Auto => document.has_cgl && low_eye,
        };
        let mut camera = Self::looking(eye, forward, up_hint, half, orthographic, size);
        if course {
            let centre = 0.5 * (bounds.0 + bounds.1);
            // The course takes position + forward of the node as a direction from the origin.
            let backward =
                place.to_world.transform_point3(Vec3::new(0.0, 0.0, -1.0)).try_normalize().unwrap_or(Vec3::Z);
            let eye = centre + backward * (CS184_DISTANCE * (bounds.1 - bounds.0).length());
            camera = Self::looking(eye, -backward, Vec3::Y, half, orthographic, size);
        }
        camera.shift = source.shift;
        camera.lens = source.lens;
        camera.pixel_aspect = raster.pixel_aspect;
        let camera = camera.cropped(raster.crop)?;
        Ok((camera, if course { Placed::Cs184 } else { Placed::AsWritten }))
    }

    /// The same camera, knowing the bodies that it stands in.
    pub fn settled<M: Mode>(&self, scene: &Scene<M>) -> Self {
        Self { interior: scene.interior_at(self.origin), ..self.clone() }
    }

    /// The whole view in a picture of another size and about the same aspect.
    pub fn resized(&self, size: [u32; 2]) -> Self {
        Self { size, crop: None, ..self.clone() }
    }

    fn cropped(self, crop: Option<Window>) -> Result<Self, String> {
        match crop {
            Some(window @ Window { x, y, width, height }) if !window.fits(self.size) => Err(format!(
                "the crop of {width}x{height} pixels at {x},{y} leaves the picture of {}x{}",
                self.size[0], self.size[1]
            )),
            _ => Ok(Self { crop, ..self }),
        }
    }

    /// The pixels that are rendered.
    pub fn window(&self) -> Window {
        self.crop.unwrap_or(Window::whole(self.size))
    }

    /// The same camera somewhere else; `motion` neither stretches nor mirrors.
    pub fn moved(&self, motion: &Affine3A) -> Self {
        let turned = |axis: Vec3| motion.transform_vector3(axis);
        Self {
            origin: motion.transform_point3(self.origin),
            right: turned(self.right),
            up: turned(self.up),
            forward: turned(self.forward),
            ..self.clone()
        }
    }

    fn looking(origin: Vec3, forward: Vec3, up_hint: Vec3, half: Vec2, orthographic: bool, size: [u32; 2]) -> Self {
        let any_up = if forward.y.abs() < 0.99 { Vec3::Y } else { Vec3::Z };
        let right =
            forward.cross(up_hint).try_normalize().or_else(|| forward.cross(any_up).try_normalize()).unwrap_or(Vec3::X);
        let up = right.cross(forward);
        Self {
            origin,
            right,
            up,
            forward,
            half,
            shift: Vec2::ZERO,
            orthographic,
            lens: None,
            size,
            crop: None,
            pixel_aspect: 1.0,
            interior: Interior::AIR,
        }
    }

    /// A three-quarter view that holds the whole box.
    fn around(bounds: (Vec3, Vec3), raster: &Raster) -> Self {
        let size = raster.pixels(4.0 / 3.0);
        let projection = Projection::Perspective { xfov_deg: Some(35.0), yfov_deg: None, aspect: Some(4.0 / 3.0) };
        let (half, _) = half_extent(&projection, (size, raster.pixel_aspect), 1.0);
        let (low, high) = bounds;
        let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low).length().max(1e-6));
        let backward = Vec3::new(0.45, 0.35, 1.0).normalize();
        let sin = half.min_element() / (1.0 + half.min_element().powi(2)).sqrt();
        let eye = centre + backward * (radius / sin);
        Self { pixel_aspect: raster.pixel_aspect, ..Self::looking(eye, -backward, Vec3::Y, half, false, size) }
    }

    /// Distance of a point from the eye along the viewing direction, metres.
    pub fn depth_m(&self, position: Vec3) -> f32 {
        (position - self.origin).dot(self.forward)
    }

    /// The ray through a point of the picture, in pixels from the upper left corner; `u` picks the point on the lens.
    #[inline]
    pub fn ray(&self, pixel: Vec2, u: [f32; 2]) -> Ray {
        let size = Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let ndc = (pixel / size - 0.5) * 2.0 + Vec2::new(2.0, -2.0) * self.shift * size.max_element() / size;
        let x = ndc.x * self.half.x;
        let y = -ndc.y * self.half.y;
        if self.orthographic {
            return Ray::new(self.origin + self.right * x + self.up * y, self.forward);
        }
        let direction = self.forward + self.right * x + self.up * y;
        let Some(lens) = &self.lens else { return Ray::new(self.origin, direction.normalize()) };
        let on_lens = aperture_point(lens.blades, u) * lens.aperture_radius_m;
        let origin = self.origin + self.right * on_lens.x + self.up * on_lens.y;
        let focus = self.origin + direction * lens.focus_distance_m;
        Ray::new(origin, (focus - origin).normalize())
    }

    /// Where and how the camera sees a point, through the point of the lens that `u` picks; `None` where it lies behind or
    /// outside of the picture and its margin of two pixels.
    #[inline]
    pub fn see(&self, point: Vec3, u: [f32; 2]) -> Option<View> {
        let size = Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let pixel_at_1 = 4.0 * self.half.x * self.half.y / (size.x * size.y);
        let mut eye = self.origin;
        if let Some(lens) = &self.lens {
            let on_lens = aperture_point(lens.blades, u) * lens.aperture_radius_m;
            eye += self.right * on_lens.x + self.up * on_lens.y;
        }
        let way = point - eye;
        let depth = way.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        // The point of the picture's plane (at unit distance) through which the lens sees it.
        let (on_plane, toward, distance_m, pixel_m2) = if self.orthographic {
            (point - self.origin, -self.forward, depth, pixel_at_1)
        } else {
            let distance_m = way.length();
            let cos = depth / distance_m;
            let focus_m = self.lens.map_or(1.0, |lens| lens.focus_distance_m);
            let on_plane = (eye + way * (focus_m / depth) - self.origin) * (1.0 / focus_m);
            (on_plane, way * (-1.0 / distance_m), distance_m, pixel_at_1 * distance_m * distance_m * cos * cos * cos)
        };
        let x = on_plane.dot(self.right) / self.half.x;
        let y = -on_plane.dot(self.up) / self.half.y;
        let ndc = Vec2::new(x, y) - Vec2::new(2.0, -2.0) * self.shift * size.max_element() / size;
        let at = (0.5 * ndc + 0.5) * size;
        let margin = 2.0;
        let inside = at.cmpge(Vec2::splat(-margin)).all() && at.cmple(size + margin).all();
        inside.then_some(View { at, toward, distance_m, pixel_m2 })
    }
}

/// How the camera sees a point.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Pixels from the upper left corner.
    pub at: Vec2,
    /// Unit vector from the point to the camera.
    pub toward: Vec3,
    pub distance_m: f32,
    /// What a pixel there covers of a surface that faces the camera.
    pub pixel_m2: f32,
}

/// A uniform point of the unit aperture: a disc, or a regular polygon with a corner at the top.
fn aperture_point(blades: u32, u: [f32; 2]) -> Vec2 {
    if blades < 3 {
        return square_to_disk(u);
    }
    let position = u[0] * blades as f32;
    let sector = position.floor();
    let corner = |k: f32| {
        let angle = std::f32::consts::TAU * k / blades as f32;
        Vec2::new(angle.sin(), angle.cos())
    };
    let root = (position - sector).sqrt();
    corner(sector) * (root * (1.0 - u[1])) + corner(sector + 1.0) * (root * u[1])
}

/// Width over height that the camera itself asks for.
fn natural_aspect(projection: &Projection) -> f32 {
    let (x, y, aspect) = match *projection {
        Projection::Perspective { xfov_deg, yfov_deg, aspect } => {
            (xfov_deg.map(tan_half), yfov_deg.map(tan_half), aspect)
        }
        Projection::Orthographic { xmag, ymag, aspect } => (xmag, ymag, aspect),
    };
    match (x, y, aspect) {
        (Some(x), Some(y), _) if x > 0.0 && y > 0.0 => x / y,
        (_, _, Some(aspect)) if aspect > 0.0 => aspect,
        _ => 4.0 / 3.0,
    }
}

/// The picture's half extents: the file's frame, widened in one direction to the picture's aspect, never cropped.
fn half_extent(projection: &Projection, (size, pixel_aspect): ([u32; 2], f32), scale: f32) -> (Vec2, bool) {
    let picture = size[0] as f32 * pixel_aspect / size[1] as f32;
    let (x, y, aspect, orthographic) = match *projection {
        Projection::Perspective { xfov_deg, yfov_deg, aspect } => {
            (xfov_deg.map(tan_half), yfov_deg.map(tan_half), aspect, false)
        }
        Projection::Orthographic { xmag, ymag, aspect } => {
            (xmag.map(|m| m * scale), ymag.map(|m| m * scale), aspect, true)
        }
    };
    // Without an aspect of its own the camera takes the picture's.
    let aspect = aspect.filter(|&a| a > 0.0).unwrap_or(picture);
    let frame = match (x, y) {
        (Some(x), Some(y)) => Vec2::new(x, y),
        (Some(x), None) => Vec2::new(x, x / aspect),
        (None, Some(y)) => Vec2::new(y * aspect, y),
        (None, None) => Vec2::new(aspect, 1.0) * 0.5,
    };
    let half = if frame.x / frame.y < picture {
        Vec2::new(frame.y * picture, frame.y)
    } else {
        Vec2::new(frame.x, frame.x / picture)
    };
    (half, orthographic)
}

fn tan_half(degrees: f32) -> f32 {
    (0.5 * degrees.to_radians()).tan()
}

fn list(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        names => names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", "),
    }
}
