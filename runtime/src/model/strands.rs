//! The strands of a package where they stand on its mesh: planted when it is loaded, because they are many times as many as the tile's.

use super::upload::Uploader;
use crate::error::RuntimeError;
use crate::gpu::largest_buffer;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use pelage_formats::meaning::planting::{Crossed, Footing, Ground, Roots, SurfaceWalk};
use pelage_formats::{AttributeVertex, GeometryVertex, MeshView, Package, SkinVertex, StrandsView};
use std::collections::HashMap;
use std::ops::Range;

/// Strands of a model.
#[derive(Debug)]
pub(crate) struct Strands {
    /// What each is, [`Strand`].
    pub(crate) strands: wgpu::Buffer,
    /// Where each point of each stands, [`Stand`].
    pub(crate) stands: wgpu::Buffer,
    /// Points of the tile's strands as the package stores them, dry, and wet behind those.
    pub(crate) tile: wgpu::Buffer,
    /// Of how many points each is.
    pub(crate) points: u32,
    /// How many there are.
    pub(crate) count: u32,
    /// Which of them each part of the manifest has: whole workgroups.
    pub(crate) of_parts: Vec<Range<u32>>,
    /// Of the tile's strands: points of all that are dry, and the largest radius in metres.
    dry_points: u32,
    radius: f32,
    /// Width of the tile's dry strands over all their points, metres.
    pub(crate) mean_width_m: f32,
    /// How far the mean dry strand of the tile bends away from what is left of it when every so many points is drawn, metres, for each of
    /// [`Self::steps`].
    pub(crate) bent_m: Vec<f32>,
}

impl Strands {
    /// What the strands of a part have in common of which that share is drawn.
    pub(crate) fn constants(&self, part: &Range<u32>, share: f32) -> StrandConstants {
        StrandConstants {
            points: self.points,
            count: self.count,
            dry_points: self.dry_points,
            radius: self.radius,
            first: part.start,
            end: part.end,
            share,
            reserved: 0,
        }
    }

    /// Bytes of their posed points: two vectors of the skin's frame, then the points.
    pub(crate) fn posed_bytes(&self) -> u64 {
        u64::from(self.count) * u64::from(self.points + 2) * 16
    }

    /// Corners of the ribbon of a strand of which every `step`th point is drawn: two a point.
    fn corners(&self, step: u32) -> u32 {
        2 * (self.pieces(step) + 1)
    }

    /// Pieces of such a ribbon, each of two triangles.
    pub(crate) fn pieces(&self, step: u32) -> u32 {
        (self.points - 1) / step
    }

    /// Every how many points may be drawn: what a strand's pieces can be divided by.
    pub(crate) fn steps(&self) -> impl DoubleEndedIterator<Item = u32> {
        steps(self.points)
    }

    /// Bytes of the ribbons of all.
    pub(crate) fn ribbon_bytes(&self, step: u32) -> u64 {
        u64::from(self.count) * u64::from(self.corners(step)) * CORNER_BYTES
    }

    /// Bytes on the GPU.
    pub(super) fn gpu_bytes(&self) -> u64 {
        self.strands.size() + self.stands.size() + self.tile.size()
    }
}

/// Bytes of a corner of a ribbon: where it is, and its light.
pub(crate) const CORNER_BYTES: u64 = 16;

/// Strands of a workgroup: those of a part are filled up to whole ones.
pub(crate) const STRAND_WORKGROUP: u32 = 64;

/// What a strand is, whatever the pose.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Strand {
    pub(crate) base_uv: [f32; 2],
    /// Of the vertices, unorm.
    pub(crate) color: u32,
    /// Bareness, wetness, unorm.
    pub(crate) groom: u32,
    /// Which of the tile's it is.
    pub(crate) of_tile: u32,
    /// 0..1, for what is true of a share of all strands.
    pub(crate) chance: f32,
    pub(crate) lean: f32,
    pub(crate) fur_height: f32,
}

/// Where a point of a strand stands: on a triangle of the mesh, or beside it on its plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Stand {
    /// Corners.
    pub(crate) vertices: [u32; 3],
    /// Weights of the second and the third, snorm of a quarter.
    pub(crate) weights: [i16; 2],
}

/// What the strands of a part have in common.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct StrandConstants {
    pub(crate) points: u32,
    /// Of the model.
    pub(crate) count: u32,
    /// Points of the tile's dry strands.
    pub(crate) dry_points: u32,
    /// Metres.
    pub(crate) radius: f32,
    /// Of the part.
    pub(crate) first: u32,
    pub(crate) end: u32,
    /// Of them that is drawn.
    pub(crate) share: f32,
    pub(crate) reserved: u32,
}

fn quarter(weight: f64) -> i16 {
    (weight * 8191.75).round().clamp(-32767.0, 32767.0) as i16
}

/// Plants them; `None` for a package without, or where a buffer of the device cannot hold them.
pub(super) fn load(
    uploader: &Uploader<'_>,
    package: &Package<'_>,
    mesh: &MeshView<'_>,
) -> Result<Option<Strands>, RuntimeError> {
    let Some(view) = package.strands()? else { return Ok(None) };
    let planted = Planted::of(package, mesh, &view);
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
        stands: uploader.buffer("strand stands", bytemuck::cast_slice(&stands), Usage::STORAGE)?,
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

fn steps(points: u32) -> impl DoubleEndedIterator<Item = u32> {
    let pieces = points - 1;
    (1..=pieces).filter(move |step| pieces.is_multiple_of(*step))
}

/// How far the mean dry strand of the tile is, at most, from the straight pieces between every `step`th of its points, metres.
fn bent(view: &StrandsView<'_>, step: usize, tile_m: f32, height_m: f32) -> f32 {
    let points: Vec<Vec3> =
        view.points().map(|p| Vec3::new(p.aside[0] * tile_m, p.aside[1] * tile_m, p.height * height_m)).collect();
    let count = view.strand_count() as usize;
    let strands = points.chunks_exact(view.points_per_strand() as usize).take(count);
    let off_piece = |piece: &[Vec3]| {
        let (from, along) = (piece[0], piece[piece.len() - 1] - piece[0]);
        let off = |p: &Vec3| {
            let share = ((*p - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            (*p - from).distance(share * along)
        };
        piece.iter().map(off).fold(0.0, f32::max)
    };
    let farthest = |strand: &[Vec3]| {
        let starts = (0..strand.len() - 1).step_by(step);
        starts.map(|k| off_piece(&strand[k..=k + step])).fold(0.0, f32::max)
    };
    (strands.map(|strand| f64::from(farthest(strand))).sum::<f64>() / count.max(1) as f64) as f32
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
    fn of(package: &Package<'_>, mesh: &MeshView<'_>, view: &StrandsView<'_>) -> Self {
        let manifest = package.manifest();
        let geometry: Vec<GeometryVertex> = mesh.geometry().collect();
        let attributes: Vec<AttributeVertex> = mesh.attributes().collect();
        let indices: Vec<u32> = mesh.indices().collect();
        let skin: Vec<SkinVertex> = mesh.skin().collect();
        let mut ground = Ground {
            triangles: indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
            positions: geometry.iter().map(|v| glam::Vec3::from(v.position).as_dvec3()).collect(),
            tile_uv: attributes.iter().map(|v| Vec2::from(v.tile_uv).as_dvec2()).collect(),
            ..Ground::default()
        };
        let mut first_at = HashMap::new();
        for (i, vertex) in geometry.iter().enumerate() {
            let moved_by = skin.get(i).map(|v| (v.joints, v.weights.map(f32::to_bits)));
            let key = (vertex.position.map(f32::to_bits), moved_by);
            ground.same_place.push(*first_at.entry(key).or_insert(i as u32));
        }
        for part in &manifest.parts {
            let furred = manifest.materials[part.material as usize].furred;
            ground.furred.extend(std::iter::repeat_n(furred, part.index_count as usize / 3));
        }
        let walk = SurfaceWalk::new(&ground);
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
                        stands.extend(stands_along(&ground, &walk, root, of_strand));
                    }
                });
            }
            // What fills up the last workgroup never grows.
            let fill = out.strands.len().next_multiple_of(STRAND_WORKGROUP as usize);
            out.strands.resize(fill, Strand { chance: 1.0, ..Strand::default() });
            out.stands.resize(fill * per_strand, Stand::default());
            out.wet_stands.resize(if wet.is_empty() { 0 } else { fill * per_strand }, Stand::default());
            out.of_parts.push(first..out.strands.len() as u32);
        }
        out
    }
}

/// A number in 0..1 that is another for each place, and the same every time: as well mixed as it is cheap (Mueller's hash of 32 bits).
fn chance(number: [u32; 4]) -> f32 {
    let mixed = number.into_iter().fold(0u32, |sum, part| {
        let x = sum.wrapping_mul(0x9e37_79b9) ^ part;
        let x = (x ^ (x >> 16)).wrapping_mul(0x045d_9f3b);
        let x = (x ^ (x >> 16)).wrapping_mul(0x045d_9f3b);
        x ^ (x >> 16)
    });
    (mixed >> 8) as f32 / (1 << 24) as f32
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
