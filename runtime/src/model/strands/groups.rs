//! Hair groups of a package. Their hairs are generated at load time.

use super::set::{Guided, HairRoot, Strand, StrandSet, StrandSource, mean_deviation, steps};
use crate::error::RuntimeError;
use crate::gpu::{WORKGROUP, largest_buffer};
use crate::model::upload::Uploader;
use glam::{Vec3, Vec4};
use pelage_formats::meaning::hair_groups::{GrownGroup, HAIR_COLORS, Hair, hair_color, hair_radius, triangle_frame};
use pelage_formats::meaning::hair_motion::gravity_compensation;
use pelage_formats::meaning::{encode_visibility, linear_to_srgb, measured_vertices};
use pelage_formats::{GroupMotion, HairGroup, MeshView, Package};
use std::f32::consts::FRAC_PI_2;
use std::ops::Range;

/// Number of hairs sampled to measure the deviation of simplified hairs.
const SAMPLED_HAIRS: usize = 256;

/// Mesh in the measured pose, in the form that hair groups need.
struct RestMesh {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    parts: Vec<Range<u32>>,
}

/// Generates the hair groups. If the device's buffers cannot hold all hairs of a group, fewer and wider ones are
/// generated.
pub(super) fn load(
    uploader: &Uploader<'_>,
    package: &Package<'_>,
    mesh: &MeshView<'_>,
) -> Result<Vec<StrandSet>, RuntimeError> {
    let groups = package.hair_groups()?;
    if groups.is_empty() {
        return Ok(Vec::new());
    }
    let indices: Vec<u32> = mesh.indices().collect();
    let part = |part: &pelage_formats::Part| part.first_index / 3..(part.first_index + part.index_count) / 3;
    let rest = RestMesh {
        positions: measured_vertices(package, mesh)?.into_iter().map(|v| v.position.into()).collect(),
        triangles: indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        parts: package.manifest().parts.iter().map(part).collect(),
    };
    let motion = package.hair_motion()?;
    let moves = |number: usize| {
        let of_group = *motion.as_ref()?.groups.get(number).filter(|motion| motion.held < 1.0)?;
        let freedom = |guide| motion.as_ref().map_or(1.0, |motion| motion.guide_freedom(number, guide));
        Some((of_group, (0..groups[number].guide_roots.len()).map(freedom).collect()))
    };
    let fibres = package.fibres()?;
    let fibre = |number: usize| fibres.as_ref().and_then(|f| f.of_groups.get(number)).copied().unwrap_or(0).into();
    let each = groups.iter().enumerate();
    each.map(|(number, group)| generate_group(uploader, group, moves(number), fibre(number), &rest)).collect()
}

fn generate_group(
    uploader: &Uploader<'_>,
    group: &HairGroup,
    motion: Option<(GroupMotion, Vec<f32>)>,
    fibre: u32,
    rest: &RestMesh,
) -> Result<StrandSet, RuntimeError> {
    use wgpu::BufferUsages as Usage;
    let points = group.points;
    let (motion, freedom) = motion.unzip();
    let of_buffer = largest_buffer(&uploader.gpu.device.limits()) / (u64::from(points + 2) * 16);
    // Reserve room for the padding of each part's workgroups.
    let filled = u64::from(WORKGROUP) * rest.parts.len() as u64;
    let most = u32::try_from(of_buffer.saturating_sub(filled)).unwrap_or(u32::MAX);
    let planted = GrownGroup::new(group, &rest.positions, &rest.triangles, most);
    let widened = group.hair_count() as f32 / planted.hairs.len().max(1) as f32;
    let (mut strands, mut roots, mut of_parts) = (Vec::new(), Vec::new(), Vec::new());
    for part in &rest.parts {
        let first = strands.len() as u32;
        let here = planted.hairs.iter().enumerate().filter(|(_, hair)| part.contains(&hair.root.triangle));
        for (number, hair) in here {
            // With evenly spaced selection numbers, any prefix of the hairs is an even sample.
            let chance = (number as f32 + 0.5) / planted.hairs.len() as f32;
            strands.push(Strand { color: u32::MAX, of_tile: hair.color, selection: chance, ..Strand::default() });
            roots.push(root(hair, rest));
        }
        // Strands that pad the last workgroup never grow.
        let fill = strands.len().next_multiple_of(WORKGROUP as usize);
        strands.resize(fill, Strand { selection: 1.0, ..Strand::default() });
        roots.resize(fill, HairRoot::default());
        of_parts.push(first..fill as u32);
    }
    if strands.is_empty() {
        // A buffer cannot be empty.
        strands.push(Strand { selection: 1.0, ..Strand::default() });
        roots.push(HairRoot::default());
    }
    let corners = |triangle: u32| rest.triangles[triangle as usize].map(|v| rest.positions[v as usize]);
    let at_rest = planted.posed_guides(corners);
    let measured: Vec<Vec<Vec3>> = planted
        .hairs
        .iter()
        .take(SAMPLED_HAIRS)
        .map(|hair| hair.points(corners(hair.root.triangle), &at_rest).collect())
        .collect();
    let length = |points: &Vec<Vec3>| points.windows(2).map(|ends| ends[0].distance(ends[1])).sum::<f32>();
    let as_groomed = |step: u32| mean_deviation(measured.iter().map(Vec::as_slice), step as usize);
    // Moving hair does not stay straight. The deviation of a segment from a quarter-turn arc is proportional to the
    // square of its share of the hair's length.
    let longest = planted.guides.iter().map(length).fold(0.0, f32::max);
    let swinging = |step: u32| longest * FRAC_PI_2 / 8.0 * (step as f32 / (points - 1) as f32).powi(2);
    let bent = |step: u32| as_groomed(step).max(if motion.is_some() { swinging(step) } else { 0.0 });
    let triangle = |(triangle, (_, [b, c])): (&u32, &(u32, [u16; 2]))| {
        let [v, w, x] = rest.triangles[*triangle as usize];
        [v, w, x, u32::from(*b) | u32::from(*c) << 16]
    };
    let triangles: Vec<[u32; 4]> = planted.guide_triangles.iter().zip(&group.guide_roots).map(triangle).collect();
    let held_up =
        |(triangle, points): (&u32, &Vec<Vec3>)| gravity_compensation(points, triangle_frame(corners(*triangle)));
    // The buffer also stores how freely the guide moves; the value is unused if no guide moves.
    let freedom = freedom.unwrap_or_default();
    let of_guide = |(number, guide)| {
        let free = freedom.get(number).copied().unwrap_or_default();
        held_up(guide).into_iter().map(move |p| p.extend(free).to_array())
    };
    let in_rest = planted.guide_triangles.iter().zip(&planted.guides).enumerate().flat_map(of_guide);
    let in_rest: Vec<[f32; 4]> = in_rest.collect();
    // Moving hair may be fully stretched.
    let reach_m = if motion.is_some() { group.reach().max(longest * (1.0 + group.stray)) } else { group.reach() };
    let guides: Vec<[f32; 4]> = planted.guides.iter().flatten().map(|p| p.extend(0.0).to_array()).collect();
    let profiles = profiles(group);
    let mean_radius_m = (0..points).map(|k| hair_radius(group, share(k, points))).sum::<f32>() / points as f32;
    let guided = Guided {
        triangles: uploader.buffer("guide triangles", bytemuck::cast_slice(&triangles), Usage::STORAGE)?,
        guides: uploader.buffer("guides", bytemuck::cast_slice(&guides), Usage::STORAGE)?,
        guide_count: planted.guides.len() as u32,
        hairs: uploader.buffer("hair roots", bytemuck::cast_slice(&roots), Usage::STORAGE)?,
        ballast: uploader.buffer("guides' ballast", bytemuck::cast_slice(&in_rest), Usage::STORAGE)?,
        motion,
        reach_m,
        fibre,
    };
    Ok(StrandSet {
        strands: uploader.buffer("hairs", bytemuck::cast_slice(&strands), Usage::STORAGE)?,
        growth: StrandSource::Guided(guided),
        tile: uploader.buffer("hair profiles", bytemuck::cast_slice(&profiles), Usage::STORAGE)?,
        points,
        count: of_parts.last().map_or(0, |range: &Range<u32>| range.end),
        of_parts,
        least_chances: Vec::new(),
        dry_points: HAIR_COLORS * points,
        radius: group.root_radius_m * widened,
        mean_width_m: 2.0 * mean_radius_m * widened,
        deviation_m: steps(points).map(bent).collect(),
    })
}

fn root(hair: &Hair, rest: &RestMesh) -> HairRoot {
    let unorm = |w: f32| (w.clamp(0.0, 1.0) * 65535.0).round() as u16;
    HairRoot {
        vertices: rest.triangles[hair.root.triangle as usize],
        weights: [unorm(hair.root.weights[1]), unorm(hair.root.weights[2])],
        guides: hair.follow.guides.map(|guide| guide as u16),
        shares: hair.follow.weights.map(|w| (w * 255.0).round() as u8),
        length: hair.length,
        aside: hair.tip_offset.to_array(),
        reserved: 0,
    }
}

fn share(k: u32, points: u32) -> f32 {
    k as f32 / (points - 1) as f32
}

/// Returns radius and colour along the hairs, one profile for each colour, in the format of tile strand points.
fn profiles(group: &HairGroup) -> Vec<[u32; 4]> {
    let point = |color: u32, k: u32| {
        let share = share(k, group.points);
        let unorm = |x: f32| (x.clamp(0.0, 1.0) * 65535.0).round() as u32;
        let radius = unorm(hair_radius(group, share) / group.root_radius_m);
        let [r, g, b] = hair_color(group, color, share).to_array().map(linear_to_srgb);
        // The visibility of light at the hair is unknown.
        let visible = u32::from_le_bytes(encode_visibility(Vec4::X));
        [0, unorm(share) | radius << 16, u32::from_le_bytes([r, g, b, 0]), visible]
    };
    (0..HAIR_COLORS).flat_map(|color| (0..group.points).map(move |k| point(color, k))).collect()
}
