//! `<animation>`: channels with their samplers, as curves over time.

use glam::Vec2;

use crate::document::{Channel, Interpolation};

use super::error::Fault;
use super::loader::Loader;
use super::sources::Arrays;
use super::targets::{self, Aim};
use super::xml::Element;

/// Names shown of the targets that are missing.
const SHOWN_TARGETS: usize = 3;

/// Reads every channel whose target is part of the scene.
pub fn read(loader: &mut Loader) -> Result<(), Fault> {
    let mut missing: Vec<Element> = Vec::new();
    let mut arrays = Arrays::default();
    for element in loader.xml.all().filter(|element| element.name() == "channel") {
        let target = element.attribute("target").unwrap_or_default();
        let aim = targets::resolve(loader, target);
        if aim.drives.is_empty() {
            missing.push(element);
        } else if let Some(channel) = channel(loader, &mut arrays, element, target, &aim)? {
            let bytes = (channel.times_s.len() + channel.values.len()) * size_of::<f32>()
                + (channel.in_tangents.len() + channel.out_tangents.len()) * size_of::<Vec2>();
            loader.take(element, aim.drives.len() * (size_of::<Channel>() + bytes))?;
            loader.document.channels.extend(aim.drives.iter().map(|&drives| Channel { drives, ..channel.clone() }));
        }
    }
    if let Some(first) = missing.first() {
        let targets = missing.iter().filter_map(|channel| channel.attribute("target"));
        let names: Vec<String> = targets.take(SHOWN_TARGETS).map(|target| format!("`{target}`")).collect();
        let more = if missing.len() > SHOWN_TARGETS { ", ..." } else { "" };
        let seen = format!("animation of {}{more}, which the scene does not have", names.join(", "));
        loader.warnings.add_many(*first, missing.len(), seen, "it is ignored");
    }
    Ok(())
}

/// Rows of numbers of one sampler input.
struct Rows {
    values: Vec<f32>,
    width: usize,
}

/// `None` when the sampler does not fit together, which is reported.
fn channel<'a>(
    loader: &mut Loader<'a>,
    arrays: &mut Arrays,
    element: Element<'a>,
    target: &str,
    aim: &Aim,
) -> Result<Option<Channel>, Fault> {
    let sampler = loader.follow(element, "source", &["sampler"])?;
    let mut input = |loader: &mut Loader<'a>, semantic: &str| -> Result<Option<Rows>, Fault> {
        let Some(input) = input_of(sampler, semantic) else { return Ok(None) };
        let source = loader.follow(input, "source", &["source"])?;
        let accessor = arrays.accessor(loader, source)?;
        Ok(Some(Rows { values: accessor.rows().to_vec(), width: accessor.stride }))
    };
    let times = input(loader, "INPUT")?;
    let output = input(loader, "OUTPUT")?;
    let in_tangents = input(loader, "IN_TANGENT")?;
    let out_tangents = input(loader, "OUT_TANGENT")?;
    let refuse = |loader: &mut Loader<'a>, reason: &str| {
        loader.warnings.add(element, format!("animation of `{target}`: {reason}"), "it is ignored");
        Ok(None)
    };
    let (Some(times), Some(output)) = (times, output) else {
        return refuse(loader, "the sampler lacks INPUT or OUTPUT");
    };
    let (keys, width) = (times.values.len(), output.width);
    if keys == 0 || output.values.len() != keys * width {
        return refuse(loader, "INPUT and OUTPUT have different numbers of keys");
    }
    if !times.values.iter().chain(&output.values).all(|value| value.is_finite()) {
        return refuse(loader, "a value is not finite");
    }
    if times.values.windows(2).any(|pair| pair[0] >= pair[1]) {
        return refuse(loader, "the times do not increase");
    }
    if let Err(reason) = aim.takes(width) {
        return refuse(loader, &reason);
    }
    let interpolation = interpolation(loader, sampler, keys)?;
    let mut channel = Channel {
        target: target.to_owned(),
        drives: aim.drives[0],
        member: aim.member,
        times_s: times.values,
        values: output.values,
        width,
        interpolation,
        in_tangents: Vec::new(),
        out_tangents: Vec::new(),
    };
    if channel.interpolation.iter().any(|kind| matches!(kind, Interpolation::Bezier | Interpolation::Hermite)) {
        let tangents = |rows: Option<Rows>, side: f32| rows.and_then(|rows| tangents(&rows, &channel, side));
        let (Some(inward), Some(outward)) = (tangents(in_tangents, -1.0), tangents(out_tangents, 1.0)) else {
            let seen = format!("animation of `{target}`: its curve has no fitting tangents");
            loader.warnings.add(element, seen, "the keys are joined by straight lines");
            channel.interpolation.fill(Interpolation::Linear);
            return Ok(Some(channel));
        };
        channel.in_tangents = inward;
        channel.out_tangents = outward;
    }
    Ok(Some(channel))
}

fn input_of<'a>(sampler: Element<'a>, semantic: &str) -> Option<Element<'a>> {
    sampler.children().find(|child| child.name() == "input" && child.attribute("semantic") == Some(semantic))
}

/// (time, value) pairs, `width` per key. `side`: -1 for in-tangents, 1 for out-tangents. Control points without times lie a
/// third of the way to the neighbouring key, as COLLADA 1.4.1 has it for one-dimensional ones; Hermite tangents without
/// times are as long as the whole way, which is the same curve.
fn tangents(rows: &Rows, channel: &Channel, side: f32) -> Option<Vec<Vec2>> {
    let (times, width) = (&channel.times_s, channel.width);
    let keys = times.len();
    if rows.values.len() == 2 * width * keys {
        return Some(rows.values.chunks_exact(2).map(|pair| Vec2::new(pair[0], pair[1])).collect());
    }
    if rows.values.len() != width * keys {
        return None;
    }
    let time = |key: usize| {
        let neighbour = if side < 0.0 { key.checked_sub(1) } else { Some(key + 1).filter(|&next| next < keys) };
        // At the ends the curve has no segment on that side: the next one's length stands in.
        let other = neighbour.or(if side < 0.0 { Some(key + 1) } else { key.checked_sub(1) }).filter(|&key| key < keys);
        let way = other.map_or(0.0, |other| (times[other] - times[key]).abs());
        // The kind of a segment stands at its first key.
        let first = if side < 0.0 { key.saturating_sub(1) } else { key };
        if channel.interpolation[first] == Interpolation::Hermite { way } else { times[key] + side * way / 3.0 }
    };
    Some(rows.values.iter().enumerate().map(|(i, &value)| Vec2::new(time(i / width), value)).collect())
}

/// One kind per key; LINEAR where the sampler names none.
fn interpolation<'a>(loader: &mut Loader<'a>, sampler: Element<'a>, keys: usize) -> Result<Vec<Interpolation>, Fault> {
    let Some(input) = input_of(sampler, "INTERPOLATION") else { return Ok(vec![Interpolation::Linear; keys]) };
    let source = loader.follow(input, "source", &["source"])?;
    let Some(names) = source.child("Name_array") else {
        return Err(source.fault("this <source> of INTERPOLATION has no <Name_array>"));
    };
    let text = names.text();
    let mut kinds = Vec::new();
    for name in text.split_whitespace() {
        kinds.push(match name {
            "LINEAR" => Interpolation::Linear,
            "STEP" => Interpolation::Step,
            "BEZIER" => Interpolation::Bezier,
            "HERMITE" => Interpolation::Hermite,
            other => {
                let seen = format!("interpolation {other} of an animation");
                loader.warnings.add(names, seen, "the keys are joined by straight lines");
                Interpolation::Linear
            }
        });
    }
    if kinds.len() < keys {
        let seen = format!("an animation with {keys} keys names {} interpolations", kinds.len());
        loader.warnings.add(names, seen, "the other keys are joined by straight lines");
    }
    kinds.resize(keys, Interpolation::Linear);
    Ok(kinds)
}
