//! Animation clips (glTF 2.0, section 3.11 "Animations").

use super::elements::{Component, REAL};
use super::json::{JsonNode, shorten};
use super::source::Source;
use crate::BakeError;
use pelage_formats::{Channel, Clip, Interpolation, Limits, MorphChannel, Property};
use std::collections::BTreeMap;

/// Animation clips, and the channels that drive morph weights.
pub(super) type Clips = (Vec<Clip>, Vec<MorphChannel>);

/// Reads all clips. Clips without any kept channel are dropped. A channel is kept if it moves:
///
/// * a node with an entry in `numbers` (document index to package index)
/// * the morph weights of a node in `morphed` (document node, index of its first target, number of targets)
pub(super) fn read<'a>(
    source: &mut Source<'a, '_>,
    numbers: &[Option<u32>],
    morphed: &[(usize, u32, u32)],
) -> Result<Clips, BakeError> {
    let Some(list) = source.root.get("animations") else { return Ok(Clips::default()) };
    // Channels may share accessors, so a small file can expand to any number of curves.
    let mut budget = Limits::default().animation_bytes;
    let (mut clips, mut morphs) = (Vec::new(), Vec::new());
    for (index, at) in list.entries()?.enumerate() {
        let name = match at.name() {
            "" => format!("clip_{index}"),
            name => name.to_owned(),
        };
        let mut channels: Vec<Channel> = Vec::new();
        let mut driven: BTreeMap<(u32, usize), usize> = BTreeMap::new();
        let mut weights: BTreeMap<u32, MorphChannel> = BTreeMap::new();
        let samplers = at.require("samplers")?;
        for channel_at in at.require("channels")?.entries()? {
            let Some((node, moves)) = target(source, &channel_at, &name)? else { continue };
            let mut charge = |curve: &Curve| {
                let bytes = 4 * (curve.times.len() + curve.values.len()) as u64;
                budget = budget.checked_sub(bytes).ok_or_else(|| {
                    let limit = Limits::default().animation_bytes >> 20;
                    channel_at.fault(format!("makes the animation larger than {limit} MiB"))
                })?;
                Ok::<_, BakeError>(())
            };
            let property = match moves {
                ChannelTarget::Node(property) => property,
                ChannelTarget::Weights => {
                    let Some((_, first, count)) = morphed.iter().copied().find(|(of, ..)| *of == node) else {
                        continue;
                    };
                    let curve = read_curve(source, &channel_at, &samplers, Width::Weights(count as usize))?;
                    charge(&curve)?;
                    let Curve { interpolation, times, values } = curve;
                    let clip = clips.len() as u32;
                    let channel = MorphChannel { clip, target: first, count, interpolation, times, values };
                    if weights.insert(first, channel).is_some() {
                        source.warn(replaces(&channel_at));
                    }
                    continue;
                }
            };
            let Some(node) = numbers.get(node).copied().flatten() else { continue };
            let curve = read_curve(source, &channel_at, &samplers, Width::Property(property))?;
            charge(&curve)?;
            let Curve { interpolation, times, values } = curve;
            let channel = Channel { node, property, interpolation, times, values };
            let key = (node, property as usize);
            if let Some(same) = driven.get(&key).and_then(|i| channels.get_mut(*i)) {
                source.warn(replaces(&channel_at));
                *same = channel;
            } else {
                driven.insert(key, channels.len());
                channels.push(channel);
            }
        }
        if !(channels.is_empty() && weights.is_empty()) {
            let times = channels.iter().map(|c| &c.times).chain(weights.values().map(|c| &c.times));
            let duration_s = times.filter_map(|times| times.last()).fold(0.0_f32, |a, b| a.max(*b));
            clips.push(Clip { name, duration_s, channels });
            morphs.extend(weights.into_values());
        }
    }
    Ok((clips, morphs))
}

fn replaces(channel: &JsonNode<'_>) -> String {
    format!("{} animates the same property as an earlier channel and replaces it", channel.place)
}

/// Target property of a channel.
enum ChannelTarget {
    Node(Property),
    /// Weights of the node's morph targets.
    Weights,
}

/// Size of one value of a curve.
#[derive(Clone, Copy)]
enum Width {
    Property(Property),
    /// Number of morph targets; each weight is stored as an element of its own.
    Weights(usize),
}

/// Keyframes and their interpolation.
struct Curve {
    interpolation: Interpolation,
    times: Vec<f32>,
    values: Vec<f32>,
}

/// Returns the target node (document index) and property of a channel, or `None` if the channel is ignored.
fn target<'a>(
    source: &mut Source<'a, '_>,
    channel: &JsonNode<'a>,
    clip: &str,
) -> Result<Option<(usize, ChannelTarget)>, BakeError> {
    let target = channel.require("target")?;
    let path = target.require("path")?;
    let moves = match path.string()? {
        "translation" => ChannelTarget::Node(Property::Translation),
        "rotation" => ChannelTarget::Node(Property::Rotation),
        "scale" => ChannelTarget::Node(Property::Scale),
        "weights" => ChannelTarget::Weights,
        other => {
            let (clip, other) = (shorten(clip), shorten(other));
            source.warn(format!("clip \"{clip}\" animates \"{other}\", which pelage does not support; left out"));
            return Ok(None);
        }
    };
    // glTF 2.0: "When node isn't defined, channel SHOULD be ignored."
    let Some(reference) = target.get("node") else { return Ok(None) };
    Ok(Some((source.root.follow("nodes", &reference)?.0, moves)))
}

fn read_curve<'a>(
    source: &mut Source<'a, '_>,
    channel: &JsonNode<'a>,
    samplers: &JsonNode<'a>,
    width: Width,
) -> Result<Curve, BakeError> {
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
            _ => return Err(at.unexpected("LINEAR, STEP or CUBICSPLINE")),
        },
    };
    let input = sampler.require("input")?;
    let times = source.accessor(&input, &[1], &[Component::F32])?.to_f32s(false);
    if times.is_empty() {
        return Err(input.fault("has no keys, expected at least one"));
    }
    if let Some(i) = times.iter().position(|t| !t.is_finite()) {
        return Err(input.fault(format!("element {i} is {}, expected a time in seconds", times[i])));
    }
    if times.iter().any(|t| *t < 0.0) {
        source.warn(format!("{} begins before 0 s; the part before 0 s is not played", input.place));
    }
    let output = sampler.require("output")?;
    let (width, elements_of_one, fractions) = match width {
        Width::Property(property) => (property.components(), 1, property == Property::Rotation),
        Width::Weights(count) => (1, count, true),
    };
    let elements = source.accessor(&output, &[width], REAL)?;
    let per_key = elements_of_one * if interpolation == Interpolation::Cubic { 3 } else { 1 };
    if elements.count != times.len() * per_key {
        let (found, expected) = (elements.count, times.len() * per_key);
        return Err(output.fault(format!("has {found} elements, expected {expected} for {} keys", times.len())));
    }
    // Integer rotations and weights are fractions of 1 by definition; other integers only if the accessor says so.
    let values = elements.to_f32s(fractions && elements.component != Component::F32);
    if let Some(i) = values.iter().position(|v| !v.is_finite()) {
        return Err(output.fault(format!("element {} is not finite, expected finite numbers", i / width)));
    }
    let (times, values) = drop_unordered_keys(source, &input, times, values, width * per_key);
    Ok(Curve { interpolation, times, values })
}

/// Drops keys whose time is not after that of the previous key.
fn drop_unordered_keys<'a>(
    source: &mut Source<'a, '_>,
    input: &JsonNode<'a>,
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
    source.warn(format!("{}: {dropped} keys are not later than the key before them; dropped", input.place));
    (kept_times, kept_values)
}
