//! Tufts: a few thick hairs around a point, each of them a guide.

use super::body::SurfaceIndex;
use super::ground::{GroomTarget, bytes, parts_of};
use crate::noise::uniform;
use crate::recipe::TuftParams;
use glam::Vec3;
use pelage_formats::{HairGroup, TrianglePoint};
use pelage_params::closest;
use std::collections::BTreeSet;

/// Number of points per stored hair: enough for a hair that only bends.
const POINTS: usize = 4;

/// Maximum number of joints listed in an error.
const NAMED: usize = 5;

fn tuft_position(params: &TuftParams, ground: &GroomTarget<'_>, warnings: &mut Vec<String>) -> Result<Vec3, String> {
    let Some(joint) = &params.joint else {
        let at = params.at.ok_or("at and joint are missing, expected a position near the skin or a joint's name")?;
        return Ok(at.into());
    };
    let mut found = ground.nodes.iter().filter(|node| node.name == *joint);
    let Some(first) = found.next() else {
        let all: BTreeSet<&str> = ground.nodes.iter().map(|node| node.name.as_str()).collect();
        let few = closest(joint, all.iter().copied(), NAMED);
        let names = few.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
        let known = match all.len() {
            0 => "the model has no node with a name".to_owned(),
            all if few.len() < all => format!("expected one of {all} names, such as {names}"),
            _ => format!("expected one of {names}"),
        };
        return Err(format!("no joint or node is named {joint:?}, {known}"));
    };
    let more = found.count();
    if more > 0 {
        warnings.push(format!(
            "strands.tuft {:?}: {} nodes are named {joint:?}; the first of them is used",
            params.name,
            more + 1
        ));
    }
    Ok(first.position_ws + Vec3::from(params.at.unwrap_or_default()))
}

/// Makes the group of a tuft. If several nodes have the name of the tuft's joint, a warning is added to `warnings`. The
/// error is a message saying why the group cannot be made.
pub(super) fn tuft_of(
    params: &TuftParams,
    ground: &GroomTarget<'_>,
    body: &SurfaceIndex<'_>,
    warnings: &mut Vec<String>,
) -> Result<HairGroup, String> {
    let at = tuft_position(params, ground, warnings)?;
    let mut of_material = vec![params.material.is_none(); body.triangles.len()];
    if let Some(pattern) = &params.material {
        for part in parts_of(pattern, ground)? {
            of_material[part.first_triangle..part.first_triangle + part.triangle_count].fill(true);
        }
    }
    let sides: &[f32] = if params.mirrored() { &[1.0, -1.0] } else { &[1.0] };
    let places = sides.iter().map(|side| (at * Vec3::new(*side, 1.0, 1.0), *side));
    let reach_m = 2.0 * ground.radius_m;
    let about = |(middle, side)| tuft_hairs(params, body, middle, reach_m, side, |t| of_material[t as usize]);
    let hairs: Vec<_> = places.flat_map(about).collect();
    if hairs.is_empty() {
        return Err(format!("no skin is near {at}, expected a position on the model"));
    }
    let root_radius_m = params.root_radius_m();
    let mut group = HairGroup {
        name: params.name.clone(),
        points: params.points(),
        seed: params.seed(),
        root_radius_m,
        tip_radius_m: params.tip_radius_m.unwrap_or(root_radius_m / 6.0).min(root_radius_m),
        root_color: bytes(params.root_color()),
        tip_color: bytes(params.tip_color()),
        lock_hairs: 1,
        ..HairGroup::default()
    };
    group.set_guides(&body.in_frames(&hairs));
    Ok(group)
}

/// Returns the hairs of a tuft, each with its root and points. The centre of the tuft is the point nearest to `middle`
/// on the triangles that `of` accepts. `side` is −1 for the mirrored tuft.
fn tuft_hairs(
    params: &TuftParams,
    body: &SurfaceIndex<'_>,
    middle: Vec3,
    reach_m: f32,
    side: f32,
    of: impl Fn(u32) -> bool,
) -> Vec<(TrianglePoint, Vec<Vec3>)> {
    let Some(skin) = body.nearest(middle, reach_m, &of) else { return Vec::new() };
    let (length_m, spread_m) = (params.length_m(), params.spread_m());
    let direction = Vec3::from(params.direction()) * Vec3::new(side, 1.0, 1.0);
    let (fan, bend, count) = (params.fan(), params.bend(), params.hairs());
    let across = skin.normal.any_orthonormal_vector();
    let seed = u64::from(params.seed());
    let hair = |number: u32| {
        // Roots are spread over a disc like the seeds of a sunflower (Vogel 1979). Mirrored tufts are mirror images.
        let radius = libm::sqrtf((number as f32 + 0.5) / count as f32);
        let turn = 2.399_963_2 * number as f32 * side;
        let aside = across * libm::cosf(turn) + skin.normal.cross(across) * libm::sinf(turn);
        let at = body.nearest(skin.place + aside * (radius * spread_m), spread_m.max(reach_m), &of)?;
        let way = skin.normal + direction + aside * (fan * radius);
        let way = way.try_normalize().unwrap_or(skin.normal);
        let shorter = params.length_variation() * uniform(seed, u64::from(number));
        let length_m = length_m * (1.0 - shorter);
        let point = |k: usize| {
            let share = k as f32 / (POINTS - 1) as f32;
            at.place + way * (length_m * share) - Vec3::Y * (bend * length_m * share * share)
        };
        Some((at.at, (0..POINTS).map(point).collect()))
    };
    (0..count).filter_map(hair).collect()
}
