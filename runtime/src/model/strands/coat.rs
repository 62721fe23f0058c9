//! The strands of a package's coat where they stand on its mesh: planted when it is loaded, because they are many times as many as the tile's.

use super::set::{Growth, Stand, Strand, Strands, mean_bent, steps};
use crate::error::RuntimeError;
use crate::gpu::{WORKGROUP, largest_buffer};
use crate::model::upload::Uploader;
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use pelage_formats::meaning::hair_groups::chance;
use pelage_formats::meaning::planting::{Crossed, Footing, Ground, Roots, SurfaceWalk};
use pelage_formats::{AttributeVertex, GeometryVertex, MeshView, Package, StrandsView};
use std::ops::Range;

/// Plants them; `None` for a package without, where there would be over `most`, or a buffer of the device cannot hold them.
pub(super) fn load(
    uploader: &Uploader<'_>,
    package: &Package<'_>,
    mesh: &MeshView<'_>,
    most: u32,
) -> Result<Option<Strands>, RuntimeError> {
    let Some(view) = package.strands()? else { return Ok(None) };
    let ground = Ground::of_package(package.manifest(), mesh);
    let area = |triangle: usize| {
        let [a, b, c] = ground.corners(triangle, &ground.tile_uv);
        0.5 * (b - a).perp_dot(c - a).abs()
    };
    // As many as the tile's cover: what is too much is not planted to be counted.
    let tiles: f64 = (0..ground.triangles.len()).filter(|t| ground.furred[*t]).map(area).sum();
    if f64::from(view.strand_count()) * tiles > f64::from(most) {
        return Ok(None);
    }
    let planted = Planted::of(package, mesh, &ground, &view);
    if planted.strands.is_empty() {
        return Ok(None);
    }
    use wgpu::BufferUsages as Usage;
    let stands = [&planted.stands[..], &planted.wet_stands].concat();
    let fur = &package.manifest().fur;
    let points = view.points_per_strand();
    let steps = steps(points).map(|step| bent(&view, step as usize, fur.tile_size_m, fur.height_m)).collect();
    let strands = Strands {
        bent_m: steps,
        strands: uploader.buffer("strands", bytemuck::cast_slice(&planted.strands), Usage::STORAGE)?,
        growth: Growth::Coat {
            stands: uploader.buffer("strand stands", bytemuck::cast_slice(&stands), Usage::STORAGE)?,
        },
        tile: uploader.buffer("strands of the tile", view.point_bytes(), Usage::STORAGE)?,
        points,
        count: planted.strands.len() as u32,
        of_parts: planted.of_parts,
        dry_points: points * view.strand_count(),
        radius: view.radius() * fur.tile_size_m,
        mean_width_m: 2.0 * mean_radius(&view) * fur.tile_size_m,
    };
    let fewest = strands.ribbon_bytes(strands.points - 1);
    let fits = strands.posed_bytes().max(fewest) <= largest_buffer(&uploader.gpu.device.limits());
    Ok(fits.then_some(strands))
}

/// How far the mean dry strand of the tile is, at most, from the straight pieces between every `step`th of its points, metres.
fn bent(view: &StrandsView<'_>, step: usize, tile_m: f32, height_m: f32) -> f32 {
    let points: Vec<Vec3> =
        view.points().map(|p| Vec3::new(p.aside[0] * tile_m, p.aside[1] * tile_m, p.height * height_m)).collect();
    let count = view.strand_count() as usize;
    mean_bent(points.chunks_exact(view.points_per_strand() as usize).take(count), step)
}

/// Of the tile's dry strands over all their points, widths of the tile.
fn mean_radius(view: &StrandsView<'_>) -> f32 {
    let count = (view.strand_count() * view.points_per_strand()) as usize;
    view.points().take(count).map(|point| f64::from(point.radius)).sum::<f64>() as f32 / count.max(1) as f32
}

struct Planted {
    strands: Vec<Strand>,
    stands: Vec<Stand>,
    /// Of the same strands when they are wet, where they can be.
    wet_stands: Vec<Stand>,
    of_parts: Vec<Range<u32>>,
}

impl Planted {
    fn of(package: &Package<'_>, mesh: &MeshView<'_>, ground: &Ground, view: &StrandsView<'_>) -> Self {
        let manifest = package.manifest();
        let geometry: Vec<GeometryVertex> = mesh.geometry().collect();
        let attributes: Vec<AttributeVertex> = mesh.attributes().collect();
        let walk = SurfaceWalk::new(ground);
        let roots = Roots::new(view.roots().zip(0..).map(|(root, i)| (Vec2::from(root).as_dvec2(), i)));
        let asides: Vec<DVec2> = view.points().map(|p| Vec2::from(p.aside).as_dvec2()).collect();
        let per_strand = view.points_per_strand() as usize;
        let of_dry = view.strand_count() as usize * per_strand;
        let (dry, wet) = asides.split_at(of_dry);
        let mut out = Self { strands: Vec::new(), stands: Vec::new(), wet_stands: Vec::new(), of_parts: Vec::new() };
        for part in &manifest.parts {
            let first = out.strands.len() as u32;
            let triangles = part.first_index as usize / 3..(part.first_index + part.index_count) as usize / 3;
            for triangle in triangles.filter(|t| walk.is_furred(*t)) {
                let corners = ground.triangles[triangle].map(|v| v as usize);
                roots.for_each_in(corners.map(|v| ground.tile_uv[v]), |strand, weights| {
                    let w = weights.as_vec3();
                    let mix =
                        |of: &dyn Fn(usize) -> Vec4| of(corners[0]) * w.x + of(corners[1]) * w.y + of(corners[2]) * w.z;
                    let unorm = |bytes: [u8; 4]| Vec4::from(bytes.map(f32::from));
                    let bytes = |v: Vec4| u32::from_le_bytes(v.to_array().map(|x| x.round() as u8));
                    let rest = mix(&|v| {
                        let [u, t] = attributes[v].base_uv;
                        Vec4::new(u, t, geometry[v].lean, geometry[v].fur_height)
                    });
                    if rest.w <= 0.0 {
                        return;
                    }
                    let number = [triangle as u32, strand as u32, w.x.to_bits(), w.y.to_bits()];
                    out.strands.push(Strand {
                        base_uv: [rest.x, rest.y],
                        color: bytes(mix(&|v| unorm(attributes[v].color))),
                        groom: bytes(mix(&|v| unorm(attributes[v].groom))),
                        of_tile: strand as u32,
                        chance: chance(number),
                        lean: rest.z,
                        fur_height: rest.w,
                    });
                    let root = Footing { triangle, weights, beyond: None };
                    for (asides, stands) in [(dry, &mut out.stands), (wet, &mut out.wet_stands)] {
                        let of_strand = asides.get(strand * per_strand..(strand + 1) * per_strand).unwrap_or_default();
                        stands.extend(stands_along(ground, &walk, root, of_strand));
                    }
                });
            }
            // What fills up the last workgroup never grows.
            let fill = out.strands.len().next_multiple_of(WORKGROUP as usize);
            out.strands.resize(fill, Strand { chance: 1.0, ..Strand::default() });
            out.stands.resize(fill * per_strand, Stand::default());
            out.wet_stands.resize(if wet.is_empty() { 0 } else { fill * per_strand }, Stand::default());
            out.of_parts.push(first..out.strands.len() as u32);
        }
        out
    }
}

/// Where the points of a strand stand that lie so far aside of its root.
fn stands_along(ground: &Ground, walk: &SurfaceWalk<'_>, root: Footing, asides: &[DVec2]) -> Vec<Stand> {
    let (mut at, mut from) = (root, DVec2::ZERO);
    let stand = |aside: &DVec2| {
        walk.step(&mut at, *aside - from, &mut Crossed::default());
        from = *aside;
        let place: DVec3 = walk.place_weights(&at);
        Stand { vertices: ground.triangles[at.triangle], weights: [quarter(place.y), quarter(place.z)] }
    };
    asides.iter().map(stand).collect()
}

fn quarter(weight: f64) -> i16 {
    (weight * 8191.75).round().clamp(-32767.0, 32767.0) as i16
}
