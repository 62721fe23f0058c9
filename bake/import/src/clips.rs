//! Animation clips (glTF 2.0, section 3.11 "Animations").

use super::elements::{Component, REAL};
use super::json::{JsonNode, shorten};
use super::source::Source;
use crate::BakeError;
use pelage_formats::{Channel, Clip, Interpolation, Limits, MorphChannel, Property};
use std::collections::BTreeMap;

/// Animation clips, and the channels that drive morph weights.
pub(super) type Clips = (Vec<Clip>, Vec<MorphChannel>);

/// Parts of a model that channels may move.
struct Movable<'m> {
    /// Package index of each document node that is kept.
    numbers: &'m [Option<u32>],
    /// Nodes with morph targets: document node, index of its first target, number of targets.
    morphed: &'m [(usize, u32, u32)],
}

/// Number of bytes that the curves of a model may still take. Channels may share accessors, so a small file can expand
/// to any number of curves. Faulty curves count as well.
struct Budget(Option<u64>);

impl Budget {
    fn charge(&mut self, channel: &JsonNode<'_>, numbers: usize) -> Result<(), BakeError> {
        self.0 = self.0.and_then(|left| left.checked_sub(4 * numbers as u64));
        let limit = Limits::default().animation_bytes >> 20;
        self.0.map(drop).ok_or_else(|| channel.fault(format!("makes the animation larger than {limit} MiB")))
    }
}

/// Reads all clips. Faulty channels are left out with a warning, and clips without any kept channel are dropped. A
/// channel is kept if it moves:
///
/// * a node with an entry in `numbers` (document index to package index)
/// * the morph weights of a node in `morphed` (document node, index of its first target, number of targets)
///
/// Fails only if the curves exceed the limit of a package.
pub(super) fn read<'a>(
    source: &mut Source<'a, '_>,
    numbers: &[Option<u32>],
    morphed: &[(usize, u32, u32)],
) -> Result<Clips, BakeError> {
    let movable = Movable { numbers, morphed };
    let mut budget = Budget(Some(Limits::default().animation_bytes));
    let (mut clips, mut morphs) = (Vec::new(), Vec::new());
    let list = source.root.get("animations").and_then(|list| source.or_warn(list.entries(), "all clips are left out"));
    for (index, at) in list.into_iter().flatten().enumerate() {
        let name = match at.name() {
            "" => format!("clip_{index}"),
            name => name.to_owned(),
        };
        let left_out = format!("left out of clip \"{}\"", shorten(&name));
        let mut channels: Vec<Channel> = Vec::new();
        let mut driven: BTreeMap<(u32, usize), usize> = BTreeMap::new();
        let mut weights: BTreeMap<u32, MorphChannel> = BTreeMap::new();
        let parts = at.require("samplers").and_then(|samplers| Ok((samplers, at.require("channels")?.entries()?)));
        let Some((samplers, list)) = source.or_warn(parts, "the clip is left out") else { continue };
        for channel_at in list {
            let read = read_channel(source, &channel_at, &samplers, &name, &movable, &mut budget);
            if budget.0.is_none() {
                read?;
                continue;
            }
            let Some(Some((target, curve))) = source.or_warn(read, &left_out) else { continue };
            let Curve { interpolation, times, values } = curve;
            let replaced = match target {
                ChannelTarget::Weights { first, count } => {
                    let clip = clips.len() as u32;
                    let channel = MorphChannel { clip, target: first, count, interpolation, times, values };
                    weights.insert(first, channel).is_some()
                }
                ChannelTarget::Node { node, property } => {
                    let channel = Channel { node, property, interpolation, times, values };
                    let same = driven.get(&(node, property as usize)).and_then(|i| channels.get_mut(*i));
                    let replaced = same.is_some();
                    match same {
                        Some(same) => *same = channel,
                        None => {
                            driven.insert((node, property as usize), channels.len());
                            channels.push(channel);
                        }
                    }
                    replaced
                }
            };
            if replaced {
                source.warn(replaces(&channel_at));
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

/// Target of a channel, in the package.
enum ChannelTarget {
    Node {
        node: u32,
        property: Property,
    },
    /// Weights of `count` morph targets, from `first` on.
    Weights {
        first: u32,
        count: u32,
    },
}

/// Keyframes and their interpolation.
struct Curve {
    interpolation: Interpolation,
    times: Vec<f32>,
    values: Vec<f32>,
}

/// Reads a channel of the clip `clip`; `None` if it moves nothing of the model.
fn read_channel<'a>(
    source: &mut Source<'a, '_>,
    channel: &JsonNode<'a>,
    samplers: &JsonNode<'a>,
    clip: &str,
    movable: &Movable<'_>,
    budget: &mut Budget,
) -> Result<Option<(ChannelTarget, Curve)>, BakeError> {
    let Some(target) = target(source, channel, clip, movable)? else { return Ok(None) };
    let curve = read_curve(source, channel, samplers, &target, budget)?;
    Ok(Some((target, curve)))
}

/// Returns the target of a channel, or `None` if the channel is ignored.
fn target<'a>(
    source: &mut Source<'a, '_>,
    channel: &JsonNode<'a>,
    clip: &str,
    movable: &Movable<'_>,
) -> Result<Option<ChannelTarget>, BakeError> {
    let target = channel.require("target")?;
    let path = target.require("path")?;
    let property = match path.string()? {
        "translation" => Some(Property::Translation),
        "rotation" => Some(Property::Rotation),
        "scale" => Some(Property::Scale),
        "weights" => None,
        other => {
            let pointer = target.extension("KHR_animation_pointer").and_then(|at| at.get("pointer"));
            let hides =
                pointer.and_then(|at| at.string().ok()?.strip_suffix("/extensions/KHR_node_visibility/visible"));
            let clip = shorten(clip);
            source.warn(match hides {
                Some(node) => format!(
                    "clip \"{clip}\" shows or hides {}, which pelage does not support; it stays as at rest",
                    shorten(node)
                ),
                None => {
                    let other = shorten(other);
                    format!("clip \"{clip}\" animates \"{other}\", which pelage does not support; left out")
                }
            });
            return Ok(None);
        }
    };
    // glTF 2.0: "When node isn't defined, channel SHOULD be ignored."
    let Some(reference) = target.get("node") else { return Ok(None) };
    let (node, _) = source.root.follow("nodes", &reference)?;
    Ok(match property {
        Some(property) => {
            let number = movable.numbers.get(node).copied().flatten();
            number.map(|node| ChannelTarget::Node { node, property })
        }
        None => {
            let targets = movable.morphed.iter().find(|(of, ..)| *of == node);
            targets.map(|(_, first, count)| ChannelTarget::Weights { first: *first, count: *count })
        }
    })
}

fn read_curve<'a>(
    source: &mut Source<'a, '_>,
    channel: &JsonNode<'a>,
    samplers: &JsonNode<'a>,
    target: &ChannelTarget,
    budget: &mut Budget,
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
    let times = source.accessor(&input, &[1], &[Component::F32])?;
    budget.charge(channel, times.count)?;
    let times = times.to_f32s(false);
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
    // The weight of each morph target is an element of its own.
    let (width, elements_of_one, fractions) = match *target {
        ChannelTarget::Node { property, .. } => (property.components(), 1, property == Property::Rotation),
        ChannelTarget::Weights { count, .. } => (1, count as usize, true),
    };
    let elements = source.accessor(&output, &[width], REAL)?;
    budget.charge(channel, elements.count * width)?;
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
