//! Skin weights of a primitive: reads any number of sets and keeps four joints per vertex.

use super::elements::{WHOLE, grouped};
use super::json::JsonNode;
use super::per_vertex::{check_count, read_per_vertex};
use super::source::Source;
use crate::BakeError;

/// Four joints of a skin (indices into its `joints`) and their weights, which sum to 1.
pub(super) type Influence = ([u32; 4], [f32; 4]);

/// Maximum deviation of a vertex's weight sum from 1 without a warning. It allows for the rounding of u8 weights: four
/// halves of 1/255.
const ROUNDING: f64 = 0.01;

/// Maximum number of weight sets that are read. A set has four weights, so this allows 32 joints per vertex.
pub(super) const MAX_SETS: u32 = 8;

/// Reads `JOINTS_n` and `WEIGHTS_n`, keeps the four largest weights of each vertex and scales them to sum to 1.
///
/// A vertex whose weights are all zero follows the first joint that it names.
pub(super) fn read<'a>(
    source: &mut Source<'a, '_>,
    attributes: &JsonNode<'a>,
    label: &str,
    vertices: usize,
) -> Result<Option<Vec<Influence>>, BakeError> {
    let mut sets = Vec::new();
    for n in 0..MAX_SETS {
        let pair = (attributes.get(&format!("JOINTS_{n}")), attributes.get(&format!("WEIGHTS_{n}")));
        let (joints_at, weights_at) = match pair {
            (Some(joints), Some(weights)) => (joints, weights),
            (None, None) => break,
            _ => {
                source.warn(format!(
                    "{label} has only one of JOINTS_{n} and WEIGHTS_{n}; both are needed, so it is ignored"
                ));
                break;
            }
        };
        check_count(source, &joints_at, vertices)?;
        let joints = source.accessor(&joints_at, &[4], WHOLE)?;
        let weights = read_per_vertex(source, &weights_at, &[4], vertices, true)?;
        sets.push((joints.to_u32s(), weights));
    }
    if attributes.get(&format!("JOINTS_{MAX_SETS}")).is_some() {
        source.warn(format!("{label} has more than {MAX_SETS} sets of joints; the rest are ignored"));
    }
    if sets.is_empty() {
        return Ok(None);
    }
    let (mut bad, mut dropped, mut unbound, mut unnormalized) = (0, 0, 0, 0);
    let mut influences = Vec::with_capacity(vertices);
    let mut pairs = Vec::new();
    for vertex in 0..vertices {
        pairs.clear();
        for (joints, weights) in &sets {
            let weights = grouped::<4>(weights).nth(vertex).unwrap_or_default();
            pairs.extend(joints.iter().copied().skip(vertex * 4).zip(weights));
        }
        let first = pairs.first().map_or(0, |(joint, _)| *joint);
        for (_, weight) in &mut pairs {
            if !weight.is_finite() || *weight < 0.0 {
                *weight = 0.0;
                bad += 1;
            }
        }
        let total: f64 = pairs.iter().map(|(_, w)| f64::from(*w)).sum();
        // The sort is stable, so equal weights keep the order of the file.
        pairs.sort_by(|a, b| b.1.total_cmp(&a.1));
        dropped += usize::from(pairs.get(4).is_some_and(|(_, w)| *w > 0.0));
        let kept: f64 = pairs.iter().take(4).map(|(_, w)| f64::from(*w)).sum();
        let mut influence = ([first, 0, 0, 0], [1.0, 0.0, 0.0, 0.0]);
        if kept > 0.0 {
            unnormalized += usize::from((total - 1.0).abs() > ROUNDING);
            influence = ([0; 4], [0.0; 4]);
            for (slot, (joint, weight)) in pairs.iter().take(4).filter(|(_, w)| *w > 0.0).enumerate() {
                influence.0[slot] = *joint;
                influence.1[slot] = (f64::from(*weight) / kept) as f32;
            }
        } else {
            unbound += 1;
        }
        influences.push(influence);
    }
    for (count, text) in [
        (bad, "weights are negative or not finite; taken as 0"),
        (dropped, "vertices follow more than four joints; the four largest weights are kept"),
        (unbound, "vertices have no weight; each follows the first joint that it names"),
        (unnormalized, "vertices have weights that do not sum to 1; normalised"),
    ] {
        if count > 0 {
            source.warn(format!("{label}: {count} {text}"));
        }
    }
    Ok(Some(influences))
}
