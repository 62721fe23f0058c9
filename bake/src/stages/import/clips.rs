//! Animation clips (glTF 2.0, section 3.11 "Animations").

use super::elements::{Component, REAL};
use super::json::{At, shorten};
use super::source::Source;
use crate::BakeError;
use pelage_formats::{Channel, Clip, Interpolation, Limits, Property};
use std::collections::BTreeMap;

/// Reads all clips. Only channels that move a node with a number in `numbers` (from the document's nodes to the package's) are
/// kept, and only clips with such a channel.
pub(super) fn read<'a>(source: &mut Source<'a, '_>, numbers: &[Option<u32>]) -> Result<Vec<Clip>, BakeError> {
    let Some(list) = source.root.get("animations") else { return Ok(Vec::new()) };
    // Channels may share accessors, so a small file can unfold into any number of curves.
    let mut budget = Limits::default().animation_bytes;
    let mut clips = Vec::new();
    for (index, at) in list.entries()?.enumerate() {
        let name = match at.name() {
            "" => format!("clip_{index}"),
            name => name.to_owned(),
        };
        let mut channels: Vec<Channel> = Vec::new();
        let mut driven: BTreeMap<(u32, usize), usize> = BTreeMap::new();
        let samplers = at.require("samplers")?;
        for channel_at in at.require("channels")?.entries()? {
            let Some((node, property)) = target(source, &channel_at, &name)? else { continue };
            let Some(node) = numbers.get(node).copied().flatten() else { continue };
            let channel = read_channel(source, &channel_at, &samplers, node, property)?;
            let bytes = 4 * (channel.times.len() + channel.values.len()) as u64;
            budget = budget.checked_sub(bytes).ok_or_else(|| {
                let limit = Limits::default().animation_bytes >> 20;
                channel_at.fault(format!("takes the animation past {limit} MiB"))
            })?;
            let key = (node, property as usize);
            if let Some(same) = driven.get(&key).and_then(|i| channels.get_mut(*i)) {
                source.warn(format!(
                    "{} moves the same property as a channel before; it replaces that",
                    channel_at.place
                ));
                *same = channel;
            } else {
                driven.insert(key, channels.len());
                channels.push(channel);
            }
        }
        if !channels.is_empty() {
            let duration_s = channels.iter().filter_map(|c| c.times.last()).fold(0.0_f32, |a, b| a.max(*b));
            clips.push(Clip { name, duration_s, channels });
        }
    }
    Ok(clips)
}

/// Node and property that a channel drives, or `None` for one that is left out.
fn target<'a>(
    source: &mut Source<'a, '_>,
    channel: &At<'a>,
    clip: &str,
) -> Result<Option<(usize, Property)>, BakeError> {
    let target = channel.require("target")?;
    let path = target.require("path")?;
    let property = match path.string()? {
        "translation" => Property::Translation,
        "rotation" => Property::Rotation,
        "scale" => Property::Scale,
        "weights" => {
            source.warn(format!("clip \"{}\" moves morph weights; morph animation is left out", shorten(clip)));
            return Ok(None);
        }
        other => {
            let (clip, other) = (shorten(clip), shorten(other));
            source.warn(format!("clip \"{clip}\" moves \"{other}\", which pelage does not know; left out"));
            return Ok(None);
        }
    };
    // "When node isn't defined, channel SHOULD be ignored."
    let Some(reference) = target.get("node") else { return Ok(None) };
    Ok(Some((source.root.referred("nodes", &reference)?.0, property)))
}

fn read_channel<'a>(
    source: &mut Source<'a, '_>,
    channel: &At<'a>,
    samplers: &At<'a>,
    node: u32,
    property: Property,
) -> Result<Channel, BakeError> {
    let reference = channel.require("sampler")?;
    let index = reference.unsigned()?;
    let sampler = usize::try_from(index).ok().and_then(|i| samplers.entry(i));
    let count = samplers.len()?;
    let sampler = sampler
        .ok_or_else(|| reference.fault(format!("is {index}, expected less than {count}, the number of samplers")))?;
    let interpolation = match sampler.get("interpolation") {
        None => Interpolation::Linear,
        Some(at) => match at.string()? {
            "LINEAR" => Interpolation::Linear,
            "STEP" => Interpolation::Step,
            "CUBICSPLINE" => Interpolation::Cubic,
            _ => return Err(at.expected("LINEAR, STEP or CUBICSPLINE")),
        },
    };
    let input = sampler.require("input")?;
    let times = source.accessor(&input, &[1], &[Component::F32])?.reals(false);
    if times.is_empty() {
        return Err(input.fault("has no keys, expected at least one"));
    }
    if let Some(i) = times.iter().position(|t| !t.is_finite()) {
        return Err(input.fault(format!("element {i} is {}, expected a time in seconds", times[i])));
    }
    if times.iter().any(|t| *t < 0.0) {
        source.warn(format!("{} begins before 0 s; what lies before is not played", input.place));
    }
    let output = sampler.require("output")?;
    let width = property.components();
    let elements = source.accessor(&output, &[width], REAL)?;
    let per_key = if interpolation == Interpolation::Cubic { 3 } else { 1 };
    if elements.count != times.len() * per_key {
        let (found, expected) = (elements.count, times.len() * per_key);
        return Err(output.fault(format!("has {found} elements, expected {expected} for {} keys", times.len())));
    }
    // Rotations in integers are fractions of 1 by definition; other integers only where the accessor says so.
    let values = elements.reals(property == Property::Rotation && elements.component != Component::F32);
    if let Some(i) = values.iter().position(|v| !v.is_finite()) {
        return Err(output.fault(format!("element {} is not finite, expected finite numbers", i / width)));
    }
    let (times, values) = rising(source, &input, times, values, width * per_key);
    Ok(Channel { node, property, interpolation, times, values })
}

/// Drops keys that do not come after the key before them.
fn rising<'a>(
    source: &mut Source<'a, '_>,
    input: &At<'a>,
    times: Vec<f32>,
    values: Vec<f32>,
    per_key: usize,
) -> (Vec<f32>, Vec<f32>) {
    if times.windows(2).all(|w| w[0] < w[1]) {
        return (times, values);
    }
    let (mut kept_times, mut kept_values) = (Vec::new(), Vec::new());
    for (time, value) in times.iter().zip(values.chunks_exact(per_key)) {
        if kept_times.last().is_none_or(|last| last < time) {
            kept_times.push(*time);
            kept_values.extend_from_slice(value);
        }
    }
    let dropped = times.len() - kept_times.len();
    source.warn(format!("{}: {dropped} keys do not come after the key before them; dropped", input.place));
    (kept_times, kept_values)
}
