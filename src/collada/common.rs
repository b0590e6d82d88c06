//! `<profile_COMMON>`: constant, lambert, phong and blinn, of which a renderer of films keeps colour, light and coverage.

use std::collections::HashMap;

use glam::{Vec3, Vec4};

use crate::document::{Base, Channel4, Encoding, Map, Material, Scalar, SurfaceEmission, Texture, Wrap};

use super::error::Fault;
use super::images;
use super::loader::Loader;
use super::numbers;
use super::xml::Element;

const SHADERS: [&str; 4] = ["constant", "lambert", "phong", "blinn"];

/// Longest chain of parameters that refer to parameters.
const REFERENCE_LIMIT: usize = 16;

/// Parameters by `sid`, as the effect declares them and the material's `<setparam>` overrides them.
type Params<'a> = HashMap<&'a str, Element<'a>>;

/// A colour, or an image.
enum Value {
    Color(Vec4),
    Image(Map),
}

/// Reads an effect without any technique of ours or of CGL. `instance` is the `<instance_effect>`.
pub fn read<'a>(
    loader: &mut Loader<'a>,
    effect: Element<'a>,
    instance: Element<'a>,
    user: &str,
) -> Result<Material, Fault> {
    let mut material = Material::default();
    let profile = effect.child("profile_COMMON");
    let technique = profile.and_then(|profile| profile.child("technique"));
    let shader = technique.and_then(|technique| technique.children().find(|child| SHADERS.contains(&child.name())));
    let (Some(profile), Some(technique), Some(shader)) = (profile, technique, shader) else {
        loader.warnings.add(effect, format!("{user} has no shader that is known here"), "grey diffuse is used");
        return Ok(material);
    };
    let params = parameters(&[effect, profile, technique], instance);
    let property = |loader: &mut Loader<'a>, name: &str| value(loader, &params, shader, name, user);

    let black = Value::Color(Vec4::ZERO);
    let emission = property(loader, "emission")?.unwrap_or(Value::Color(Vec4::ZERO));
    if !emission.is_black() {
        let radiance = emission.texture();
        material.emission = Some(SurfaceEmission { radiance, spectrum: Default::default(), two_sided: true });
    }
    material.base = if shader.name() == "constant" {
        Base::Black
    } else {
        let mut reflectance = property(loader, "diffuse")?.unwrap_or(black).texture();
        if reflectance.value.max_element() > 1.0 || reflectance.value.min_element() < 0.0 {
            loader.warnings.add(shader, format!("the diffuse colour of {user} is outside 0..1"), "it is clamped");
            reflectance.value = reflectance.value.clamp(Vec3::ZERO, Vec3::ONE);
        }
        warn_ignored(loader, &params, shader, user)?;
        Base::Diffuse { reflectance, ior: 1.5 }
    };
    material.opacity = opacity(loader, &params, shader, user)?;
    Ok(material)
}

impl Value {
    fn is_black(&self) -> bool {
        matches!(self, Self::Color(color) if color.truncate().max_element() <= 0.0)
    }

    fn texture(self) -> Texture {
        match self {
            Self::Color(color) => Texture::constant(color.truncate()),
            Self::Image(map) => Texture { value: Vec3::ONE, map: Some(map) },
        }
    }
}

/// What a lambertian surface cannot show is named once for all materials.
fn warn_ignored<'a>(
    loader: &mut Loader<'a>,
    params: &Params<'a>,
    shader: Element<'a>,
    user: &str,
) -> Result<(), Fault> {
    let advice = "the surface is plain diffuse: describe it in profile \"pellicle\" to make it shine";
    // Blender up to 2.79 gave every material a highlight, wanted or not.
    if matches!(shader.name(), "phong" | "blinn") && loader.blender.is_none() {
        let specular = value(loader, params, shader, "specular", user)?;
        if specular.is_some_and(|specular| !specular.is_black()) {
            loader.warnings.add(shader, "a <specular> highlight of a common material", advice);
        }
    }
    let reflectivity = shader.child("reflectivity").and_then(|reflectivity| reflectivity.child("float"));
    if let Some(float) = reflectivity {
        if numbers::single(float)? > 0.0 {
            let source = if loader.blender.is_some() { " (Blender's metallic)" } else { "" };
            loader.warnings.add(shader, format!("a <reflectivity>{source} of a common material"), advice);
        }
    }
    Ok(())
}

fn parameters<'a>(scopes: &[Element<'a>], instance: Element<'a>) -> Params<'a> {
    let mut params = Params::new();
    for scope in scopes {
        let own = scope.children_named("newparam");
        params.extend(own.filter_map(|param| Some((param.attribute("sid")?, param))));
    }
    let set = instance.children_named("setparam");
    params.extend(set.filter_map(|param| Some((param.attribute("ref")?, param))));
    params
}

fn value<'a>(
    loader: &mut Loader<'a>,
    params: &Params<'a>,
    shader: Element<'a>,
    name: &str,
    user: &str,
) -> Result<Option<Value>, Fault> {
    let Some(property) = shader.child(name) else { return Ok(None) };
    if let Some(color) = property.child("color") {
        return Ok(Some(Value::Color(rgba(color)?)));
    }
    if let Some(texture) = property.child("texture") {
        return Ok(Some(Value::Image(texture_map(loader, params, texture, user)?)));
    }
    let Some(param) = property.child("param") else { return Ok(None) };
    let target = follow_param(params, param)?;
    let color = target.children().find(|child| matches!(child.name(), "color" | "float3" | "float4"));
    match color {
        Some(color) => Ok(Some(Value::Color(rgba(color)?))),
        None => Err(param.fault(format!("<param> of <{name}> does not lead to a colour"))),
    }
}

/// The parameter that `<param ref="..">` means.
fn follow_param<'a>(params: &Params<'a>, param: Element<'a>) -> Result<Element<'a>, Fault> {
    let mut reference = param;
    for _ in 0..REFERENCE_LIMIT {
        let Some(sid) = reference.attribute("ref") else {
            return Err(reference.fault("<param> has no `ref`"));
        };
        let Some(&target) = params.get(sid) else {
            let fault = reference.fault_at_value("ref", format!("there is no parameter `{sid}`"));
            return Err(fault.suggest(sid, params.keys().copied()));
        };
        match target.child("param") {
            Some(next) => reference = next,
            None => return Ok(target),
        }
    }
    Err(param.fault("<param> references run in a circle"))
}

/// A scalar property; `None` when it is absent.
fn float<'a>(params: &Params<'a>, shader: Element<'a>, name: &str) -> Result<Option<f32>, Fault> {
    let Some(property) = shader.child(name) else { return Ok(None) };
    let holder = match property.child("param") {
        Some(param) => follow_param(params, param)?,
        None => property,
    };
    holder.child("float").map(numbers::single).transpose()
}

fn rgba(color: Element) -> Result<Vec4, Fault> {
    match numbers::floats(color)?.len() {
        3 => numbers::fixed::<3>(color).map(|[r, g, b]| Vec4::new(r, g, b, 1.0)),
        _ => numbers::fixed::<4>(color).map(Vec4::from),
    }
}

/// `<texture>` -> sampler -> (surface ->) image. Some exporters name the image directly.
fn texture_map<'a>(
    loader: &mut Loader<'a>,
    params: &Params<'a>,
    texture: Element<'a>,
    user: &str,
) -> Result<Map, Fault> {
    let name = texture.attribute("texture").unwrap_or_default();
    let sampler = params.get(name).and_then(|param| param.child("sampler2D"));
    let image = match sampler {
        Some(sampler) => sampled_image(loader, params, sampler)?,
        None => match loader.by_id(name, &["image"]) {
            Some(image) => image,
            None => {
                let fault = texture.fault_at_value("texture", format!("there is no sampler `{name}`"));
                return Err(fault.suggest(name, params.keys().copied()));
            }
        },
    };
    let wrap = |name: &str| match sampler.and_then(|sampler| sampler.child(name)).map(|wrap| wrap.text()).as_deref() {
        Some("MIRROR") => Wrap::Mirror,
        Some("CLAMP") => Wrap::Clamp,
        Some("BORDER" | "NONE") => Wrap::Border,
        _ => Wrap::Repeat,
    };
    Ok(Map {
        image: images::from_element(loader, image, user)?,
        texcoord: texture.attribute("texcoord").unwrap_or_default().to_owned(),
        slot: 0,
        encoding: Encoding::Srgb,
        channel: Channel4::G,
        wrap: [wrap("wrap_s"), wrap("wrap_t")],
    })
}

fn sampled_image<'a>(loader: &Loader<'a>, params: &Params<'a>, sampler: Element<'a>) -> Result<Element<'a>, Fault> {
    // COLLADA 1.5.
    if let Some(instance) = sampler.child("instance_image") {
        return loader.follow(instance, "url", &["image"]);
    }
    let Some(source) = sampler.child("source") else {
        return Err(sampler.fault("this <sampler2D> has neither <source> nor <instance_image>"));
    };
    let sid = source.text();
    let surface = params.get(sid.as_ref()).and_then(|param| param.child("surface"));
    let Some(init_from) = surface.and_then(|surface| surface.child("init_from")) else {
        let fault = source.fault_at_text(format!("there is no surface `{sid}` with an <init_from>"));
        return Err(fault.suggest(&sid, params.keys().copied()));
    };
    let id = init_from.text();
    match loader.by_id(&id, &["image"]) {
        Some(image) => Ok(image),
        None => {
            let images = loader.xml.all().filter(|element| element.name() == "image");
            let fault = init_from.fault_at_text(format!("there is no <image> with id `{id}`"));
            Err(fault.suggest(&id, images.filter_map(|image| image.attribute("id"))))
        }
    }
}

/// Rec. 709, with the digits of the specification.
const LUMINANCE: Vec3 = Vec3::new(0.212671, 0.715160, 0.072169);

/// COLLADA 1.4.1 chapter 7, "Determining transparency"; 1.5 adds `A_ZERO` and `RGB_ONE`.
fn opacity<'a>(loader: &mut Loader<'a>, params: &Params<'a>, shader: Element<'a>, user: &str) -> Result<Scalar, Fault> {
    let transparency = float(params, shader, "transparency")?;
    let transparent = value(loader, params, shader, "transparent", user)?;
    if transparency.is_none() && transparent.is_none() {
        return Ok(Scalar::constant(1.0));
    }
    let factor = transparency.unwrap_or(1.0);
    let mode = shader.child("transparent").and_then(|element| element.attribute("opaque")).unwrap_or("A_ONE");
    let channel = if mode.starts_with("RGB") { Channel4::Luminance } else { Channel4::A };
    // Opacity where the channel is 0 and where it is 1.
    let range = match mode {
        "A_ZERO" | "RGB_ZERO" => [1.0, 1.0 - factor],
        _ => [0.0, factor],
    };
    let range = if loader.options.invert_opacity { range.map(|opacity| 1.0 - opacity) } else { range };
    let (opacity, map) = match transparent.unwrap_or(Value::Color(Vec4::ONE)) {
        Value::Color(color) => {
            let share = if channel == Channel4::A { color.w } else { color.truncate().dot(LUMINANCE) };
            (range[0] + (range[1] - range[0]) * share, None)
        }
        Value::Image(map) => (1.0, Some(Map { channel, encoding: Encoding::Linear, ..map })),
    };
    if opacity <= 0.0 && map.is_none() {
        let advice = "if it should be seen, its exporter means the opposite: --invert-opacity";
        loader.warnings.add(shader, format!("{user} is fully transparent"), advice);
    }
    Ok(Scalar { value: opacity.clamp(0.0, 1.0), map, range })
}
