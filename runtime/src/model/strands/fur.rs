//! Fur strands of a package. They are placed on the mesh at load time, because the mesh has many times more strands
//! than the stored tile.

use super::set::{Strand, StrandSet, StrandSource, SurfacePoint, mean_deviation, steps};
use crate::error::RuntimeError;
use crate::gpu::{WORKGROUP, largest_buffer};
use crate::model::upload::Uploader;
use crate::shared::environment::pack_openness;
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use pelage_formats::meaning::hair_groups::hash_unit;
use pelage_formats::meaning::openness::Openness;
use pelage_formats::meaning::planting::{PlantingMesh, Roots, SurfaceWalk, WalkEvents, WalkPosition};
use pelage_formats::{AttributeVertex, GeometryVertex, MeshView, Package, StrandsView};
use std::ops::Range;

/// Places the strands. Returns `None` for a package without strands, or if a buffer of the device cannot hold them.
///
/// If there would be more than `most`, only a share of them is placed, each correspondingly wider. If that share would
/// be too small, none are placed.
pub(super) fn load(
    uploader: &Uploader<'_>,
    package: &Package<'_>,
    mesh: &MeshView<'_>,
    most: u32,
) -> Result<Option<StrandSet>, RuntimeError> {
    let Some(view) = package.strands()? else { return Ok(None) };
    let ground = PlantingMesh::of_package(package, mesh)?;
    let area = |triangle: usize| {
        let [a, b, c] = ground.corners(triangle, &ground.tile_uv);
        0.5 * (b - a).perp_dot(c - a).abs()
    };
    // Estimate the count from the area that the tile covers. Otherwise, too many strands would be placed only to be
    // counted.
    let tiles: f64 = (0..ground.triangles.len()).filter(|t| ground.furred[*t]).map(area).sum();
    let Some(share) = placed_share(f64::from(view.strand_count()) * tiles, most) else { return Ok(None) };
    let planted = PlacedStrands::of(package, mesh, &ground, &view, share);
    if planted.strands.is_empty() {
        return Ok(None);
    }
    use wgpu::BufferUsages as Usage;
    let stands = [&planted.stands[..], &planted.wet_stands].concat();
    let fur = &package.manifest().fur;
    let points = view.points_per_strand();
    let steps =
        steps(points).map(|step| mean_deviation_m(&view, step as usize, fur.tile_size_m, fur.height_m)).collect();
    let widened = share.recip() * fur.tile_size_m;
    let strands = StrandSet {
        deviation_m: steps,
        strands: uploader.buffer("strands", bytemuck::cast_slice(&planted.strands), Usage::STORAGE)?,
        growth: StrandSource::Fur {
            stands: uploader.buffer("strand stands", bytemuck::cast_slice(&stands), Usage::STORAGE)?,
        },
        tile: uploader.buffer("strands of the tile", view.point_bytes(), Usage::STORAGE)?,
        points,
        count: planted.strands.len() as u32,
        of_parts: planted.of_parts,
        dry_points: points * view.strand_count(),
        radius: view.radius() * widened,
        mean_width_m: 2.0 * mean_radius(&view) * widened,
        least_chances: least_chances(&planted.strands),
    };
    let fewest = strands.ribbon_bytes(strands.points - 1);
    let fits = strands.posed_bytes().max(fewest) <= largest_buffer(&uploader.gpu.device.limits());
    Ok(fits.then_some(strands))
}

/// Minimum share of strands that are placed. Fewer and wider strands would leave holes in dense short fur; layers do
/// not.
const FEWEST_PLANTED: f32 = 0.5;

/// Returns the share of `strands` to place if at most `most` are allowed; `None` if it is too small.
fn placed_share(strands: f64, most: u32) -> Option<f32> {
    let share = (f64::from(most) / strands.max(1.0)).min(1.0) as f32;
    (share >= FEWEST_PLANTED).then_some(share)
}

/// Returns the smallest selection number of the strands in each workgroup.
fn least_chances(strands: &[Strand]) -> Vec<f32> {
    let least = |group: &[Strand]| group.iter().map(|strand| strand.selection).fold(1.0, f32::min);
    strands.chunks(WORKGROUP as usize).map(least).collect()
}

/// Returns the greatest distance between the tile's mean dry strand and the straight segments that connect every
/// `step`th point, metres.
fn mean_deviation_m(view: &StrandsView<'_>, step: usize, tile_m: f32, height_m: f32) -> f32 {
    let points: Vec<Vec3> =
        view.points().map(|p| Vec3::new(p.aside[0] * tile_m, p.aside[1] * tile_m, p.height * height_m)).collect();
    let count = view.strand_count() as usize;
    mean_deviation(points.chunks_exact(view.points_per_strand() as usize).take(count), step)
}

/// Returns the mean radius of the tile's dry strands over all their points, as a fraction of the tile's width.
fn mean_radius(view: &StrandsView<'_>) -> f32 {
    let count = (view.strand_count() * view.points_per_strand()) as usize;
    view.points().take(count).map(|point| f64::from(point.radius)).sum::<f64>() as f32 / count.max(1) as f32
}

struct PlacedStrands {
    strands: Vec<Strand>,
    stands: Vec<SurfacePoint>,
    /// Surface points of the same strands when wet, if the package has wet hair.
    wet_stands: Vec<SurfacePoint>,
    of_parts: Vec<Range<u32>>,
}

/// Strand whose points have not yet been placed on the surface.
struct RootedStrand {
    strand: Strand,
    root: WalkPosition,
}

impl PlacedStrands {
    /// Places the strands whose selection number is below `share`. Adjacent parts with the same material are merged,
    /// because they are drawn as one. Within them, strands are sorted by selection number, so that drawing any share of
    /// them means drawing the first ones.
    fn of(
        package: &Package<'_>,
        mesh: &MeshView<'_>,
        ground: &PlantingMesh,
        view: &StrandsView<'_>,
        share: f32,
    ) -> Self {
        let parts = &package.manifest().parts;
        let walk = SurfaceWalk::new(ground);
        let rooted = RootedStrand::on_parts(package, mesh, ground, view, &walk);
        let asides: Vec<DVec2> = view.points().map(|p| Vec2::from(p.aside).as_dvec2()).collect();
        let per_strand = view.points_per_strand() as usize;
        let of_dry = view.strand_count() as usize * per_strand;
        let (dry, wet) = asides.split_at(of_dry);
        let mut out = Self { strands: Vec::new(), stands: Vec::new(), wet_stands: Vec::new(), of_parts: Vec::new() };
        let mut rooted = parts.iter().zip(rooted).peekable();
        while let Some((part, mut run)) = rooted.next() {
            let first = out.strands.len() as u32;
            let mut others = 0;
            while let Some((_, more)) = rooted.next_if(|(next, _)| next.material == part.material) {
                run.extend(more);
                others += 1;
            }
            run.retain(|rooted| rooted.strand.selection < share);
            run.sort_by(|a, b| a.strand.selection.total_cmp(&b.strand.selection));
            for RootedStrand { strand, root } in run {
                let number = strand.of_tile as usize;
                // Selection numbers are rescaled to 0..1, so that any share of the remaining strands is again a uniform
                // sample.
                out.strands.push(Strand { selection: strand.selection / share, ..strand });
                for (asides, stands) in [(dry, &mut out.stands), (wet, &mut out.wet_stands)] {
                    let of_strand = asides.get(number * per_strand..(number + 1) * per_strand).unwrap_or_default();
                    stands.extend(surface_points(ground, &walk, root, of_strand));
                }
            }
            // Strands that pad the last workgroup never grow.
            let fill = out.strands.len().next_multiple_of(WORKGROUP as usize);
            out.strands.resize(fill, Strand { selection: 1.0, ..Strand::default() });
            out.stands.resize(fill * per_strand, SurfacePoint::default());
            out.wet_stands.resize(if wet.is_empty() { 0 } else { fill * per_strand }, SurfacePoint::default());
            let end = out.strands.len() as u32;
            out.of_parts.push(first..end);
            out.of_parts.extend(std::iter::repeat_n(end..end, others));
        }
        out
    }
}

impl RootedStrand {
    /// Returns the strands of every part of the manifest, in triangle order.
    fn on_parts(
        package: &Package<'_>,
        mesh: &MeshView<'_>,
        ground: &PlantingMesh,
        view: &StrandsView<'_>,
        walk: &SurfaceWalk<'_>,
    ) -> Vec<Vec<Self>> {
        let geometry: Vec<GeometryVertex> = mesh.geometry().collect();
        let attributes: Vec<AttributeVertex> = mesh.attributes().collect();
        // Errors are ignored, because the package was validated when the model was loaded.
        let openness = package.openness().ok().flatten();
        let opened = |vertex: usize| {
            let of = openness.and_then(|all| all.get(4 * vertex..4 * vertex + 4));
            of.map_or(Vec4::ZERO, |of| Openness::from_bytes([of[0], of[1], of[2], of[3]]).vector().extend(0.0))
        };
        let roots = Roots::new(view.roots().zip(0..).map(|(root, i)| (Vec2::from(root).as_dvec2(), i)));
        let mut of_parts = Vec::new();
        for part in &package.manifest().parts {
            let mut planted = Vec::new();
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
                    let strand = Strand {
                        base_uv: [rest.x, rest.y],
                        color: bytes(mix(&|v| unorm(attributes[v].color))),
                        groom: with_openness(bytes(mix(&|v| unorm(attributes[v].groom))), mix(&opened).truncate()),
                        of_tile: strand as u32,
                        selection: hash_unit(number),
                        lean: rest.z,
                        fur_height: rest.w,
                    };
                    planted.push(Self { strand, root: WalkPosition { triangle, weights, beyond: None } });
                });
            }
            of_parts.push(planted);
        }
        of_parts
    }
}

/// Returns the packed groom with the openness of the body, a vector interpolated between the triangle's corners.
/// Unchanged if the openness is unknown.
fn with_openness(groom: u32, open: Vec3) -> u32 {
    let share = open.length();
    if share <= 0.0 {
        return groom;
    }
    let packed = pack_openness(Openness { share, tangential: [open.x / share, open.y / share] });
    groom & 0xffff | u32::from(u16::from_le_bytes(packed)) << 16
}

/// Returns the surface positions of a strand's points, given their offsets from its root.
fn surface_points(
    ground: &PlantingMesh,
    walk: &SurfaceWalk<'_>,
    root: WalkPosition,
    asides: &[DVec2],
) -> Vec<SurfacePoint> {
    let (mut at, mut from) = (root, DVec2::ZERO);
    let stand = |aside: &DVec2| {
        walk.step(&mut at, *aside - from, &mut WalkEvents::default());
        from = *aside;
        let place: DVec3 = walk.place_weights(&at);
        SurfacePoint { vertices: ground.triangles[at.triangle], weights: [quarter(place.y), quarter(place.z)] }
    };
    asides.iter().map(stand).collect()
}

fn quarter(weight: f64) -> i16 {
    (weight * 8191.75).round().clamp(-32767.0, 32767.0) as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excess_strands_are_thinned_to_at_least_half() {
        let most = 300;
        assert_eq!([0.0, 300.0, 400.0, 600.0].map(|n| placed_share(n, most)), [1.0, 1.0, 0.75, 0.5].map(Some));
        assert_eq!([placed_share(601.0, most), placed_share(5.0, 0)], [None; 2]);
    }

    #[test]
    fn workgroups_store_their_least_chance() {
        let strand = |selection| Strand { selection, ..Strand::default() };
        let mut strands: Vec<Strand> = (0..100u16).map(|i| strand(f32::from(i) / 100.0)).collect();
        strands.resize(128, strand(1.0));
        assert_eq!(least_chances(&strands), [0.0, 0.64]);
        assert_eq!(least_chances(&[strand(1.0); 64]), [1.0], "nothing grows there");
    }
}
