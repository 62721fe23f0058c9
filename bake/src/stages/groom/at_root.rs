//! `color.at_root`: hair that hangs over skin of another colour keeps the colour that it has at its root.
//!
//! A renderer of layers finds the root of a texel's hair by a step in the tile ([`RootsInfo`]), and in the base colour's texture the skin there, where
//! that is laid out as the tile is. So the colours of the materials whose hair hangs over other colours are painted into an
//! [`Atlas`] of the tile's coordinates. Around a chart it holds what a walk over the skin ([`SurfaceWalk`]) comes to there, in other patches and of other
//! materials. Where the walk comes to bare skin or to the end of the mesh it stands still: there are no roots beyond.

use super::atlas::{Atlas, linear_image, srgb_image};
use super::canvas::Spot;
use super::colors::Colors;
use super::maps::GroomTextures;
use super::pattern::{Pattern, hand_over, material_of_triangles, read};
use crate::sample::Encoding;
use crate::stages::surface::Surface;
use glam::{DVec2, Vec2, Vec3, Vec4};
use pelage_formats::meaning::linear_to_srgb;
use pelage_formats::meaning::planting::{Crossed, Footing, Ground, SurfaceWalk, same_places};
use pelage_formats::{Aside, ROOT_HEIGHTS, RootsInfo};

/// Texels in the width of a tile that draw a border between colours finer than hair blurs it.
const ENOUGH_TEXELS: f32 = 16.0;
/// With fewer, the border would be as coarse as hair is long.
const LEAST_TEXELS: f32 = 6.0;
/// Colours that differ by no more than this, in steps of an sRGB byte, count as one.
const ONE_COLOR: u8 = 4;
/// Roots that are looked at in the area of a tile, to know whether hair hangs over another colour.
const ROOTS_PER_TILE: f32 = 64.0;
/// The most of them in a triangle.
const MOST_ROOTS: usize = 256;

/// What the colour of hair at its root is found from.
#[derive(Clone, Copy, Debug)]
pub struct Rooting<'a> {
    /// One per material.
    pub furred: &'a [bool],
    /// Painted over the colours, where there is one.
    pub pattern: Option<&'a Pattern<'a>>,
    /// How far hair lies aside of its root on average, at some heights, tiles.
    pub asides: &'a [Vec2],
    /// The farthest that hair lies aside, tiles.
    pub reach: f32,
    /// Texels each way that the texture has at most.
    pub most_side: u32,
}

/// The texture that holds the colours of roots, and whose they are.
#[derive(Clone, Debug)]
pub struct RootAtlas {
    atlas: Atlas,
    /// One per material: whether it is painted into it.
    of_material: Vec<bool>,
}

impl RootAtlas {
    /// Lays out the skin of all materials whose hair hangs over another colour than it has; `None` where there is none, or where the skin falls into so many
    /// pieces that they cannot be laid out with what hair reaches around them. Where it is laid out, vertices of `surface` are copied along the borders of charts.
    ///
    /// * `colors`: of `surface`
    pub fn new(surface: &mut Surface, colors: &Colors, rooting: &Rooting<'_>) -> Option<Self> {
        let ground = Walkable::new(surface, rooting.furred);
        let mut of_material = Skin::new(surface, colors, rooting, &ground).mixed(rooting);
        if !of_material.contains(&true) {
            return None;
        }
        if rooting.pattern.is_some() {
            // It is in no other texture.
            of_material.iter_mut().zip(rooting.furred).for_each(|(painted, furred)| *painted = *furred);
        }
        let is_painted = |material: usize| of_material.get(material).copied().unwrap_or(false);
        let patches = surface.patch_of_triangle.iter().zip(&ground.material_of);
        let patches: Vec<u32> =
            patches.map(|(patch, material)| if is_painted(*material) { *patch } else { u32::MAX }).collect();
        let has_images = rooting.pattern.is_some()
            || colors.materials.iter().enumerate().any(|(i, m)| is_painted(i) && m.image.is_some());
        let enough = if has_images { f32::INFINITY } else { ENOUGH_TEXELS };
        let mut cut = surface.clone();
        let atlas = Atlas::for_roots(&mut cut, &patches, rooting.reach, [LEAST_TEXELS, enough], rooting.most_side)?;
        *surface = cut;
        Some(Self { atlas, of_material })
    }

    /// Paints factor, texture, vertex colours and pattern of the materials into the texture, and moves their texture coordinates into it. Groom textures are
    /// moved along.
    ///
    /// * `surface`: as [`Self::new`] left it
    /// * `colors`: of that
    ///
    /// Call it after everything that reads the model's own texture coordinates.
    pub fn paint(&self, rooting: &Rooting<'_>, surface: &mut Surface, colors: &mut Colors, grooms: &mut GroomTextures) {
        let ground = Walkable::new(surface, rooting.furred);
        let skin = Skin::new(surface, colors, rooting, &ground);
        let texels = self.atlas.paint(|spot, extent| {
            // Four samples a texel, so that borders are smooth.
            let samples = [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)].map(|(dx, dy)| {
                skin.color(skin.continued(Spot { weights: spot.weights + extent[0] * dx + extent[1] * dy, ..spot }))
            });
            samples.into_iter().sum::<Vec4>() / 4.0
        });
        let color = srgb_image(self.atlas.side, &texels);
        let with_groom =
            self.of_material.iter().zip(&grooms.of_material).any(|(painted, own)| *painted && own.is_some());
        let groom = with_groom.then(|| {
            let texels = self.atlas.paint(|spot, _| {
                let spot = skin.continued(spot);
                let own = grooms.of_material.get(skin.material_of[spot.triangle]).copied().flatten();
                let own = own.and_then(|image| grooms.images.get(image));
                own.map_or(Vec4::new(1.0, 0.0, 0.0, 1.0), |image| read(surface, spot, image, Encoding::Linear))
            });
            linear_image(self.atlas.side, &texels)
        });
        for part in surface.mesh.parts.iter().filter(|part| self.of_material.get(part.material) == Some(&true)) {
            let triangles = &surface.mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count];
            triangles.iter().flatten().for_each(|v| colors.vertices[*v as usize] = [255; 4]);
        }
        let painted = colors.materials.iter_mut().zip(&self.of_material).filter(|(_, painted)| **painted);
        painted.for_each(|(material, _)| material.factor = [1.0; 4]);
        hand_over(&self.atlas, &self.of_material, (color, groom), surface, colors, grooms);
    }

    /// What a renderer has to know, of hair that lies as far aside as that.
    pub fn info(&self, asides: [Aside; ROOT_HEIGHTS]) -> RootsInfo {
        let uv_per_tile = self.atlas.scale / self.atlas.side as f32;
        let of_material = |painted: &bool| if *painted { uv_per_tile } else { 0.0 };
        RootsInfo { asides, uv_per_tile: self.of_material.iter().map(of_material).collect() }
    }
}

/// Coloured skin that can be walked on.
struct Skin<'a> {
    surface: &'a Surface,
    colors: &'a Colors,
    pattern: Option<&'a Pattern<'a>>,
    /// One per triangle.
    material_of: &'a [usize],
    walk: SurfaceWalk<'a>,
}

impl<'a> Skin<'a> {
    fn new(surface: &'a Surface, colors: &'a Colors, rooting: &Rooting<'a>, ground: &'a Walkable) -> Self {
        let Walkable { ground, material_of } = ground;
        Self { surface, colors, pattern: rooting.pattern, material_of, walk: SurfaceWalk::new(ground) }
    }

    /// Where a walk from a spot leads, or as far as there is furred skin.
    fn walked(&self, spot: Spot, by: DVec2) -> Spot {
        let mut at = Footing { triangle: spot.triangle, weights: spot.weights.as_dvec3(), beyond: None };
        self.walk.step(&mut at, by, &mut Crossed::default());
        Spot { triangle: at.triangle, weights: at.weights.as_vec3() }
    }

    /// A spot beyond the border of its triangle as the place of the skin that lies there.
    fn continued(&self, spot: Spot) -> Spot {
        let inside = spot.inside();
        if spot.weights.min_element() >= 0.0 {
            return inside;
        }
        let corners = self.surface.mesh.triangles[spot.triangle].map(|v| self.surface.tile_uvs[v as usize].as_dvec2());
        let by = (spot.weights - inside.weights).as_dvec3();
        self.walked(inside, corners[0] * by.x + corners[1] * by.y + corners[2] * by.z)
    }

    /// Linear RGBA at a spot inside its triangle.
    fn color(&self, spot: Spot) -> Vec4 {
        let Self { surface, colors, .. } = self;
        let Some(material) = colors.materials.get(self.material_of[spot.triangle]) else { return Vec4::ONE };
        let [a, b, c] = surface.mesh.triangles[spot.triangle]
            .map(|v| Vec4::from(colors.vertices.get(v as usize).map_or([1.0; 4], |c| c.map(|x| f32::from(x) / 255.0))));
        let tint = (a * spot.weights.x + b * spot.weights.y + c * spot.weights.z) * Vec4::from(material.factor);
        let image = material.image.and_then(|image| colors.images.get(image));
        let own = tint * image.map_or(Vec4::ONE, |image| read(surface, spot, image, Encoding::Srgb));
        let Some(pattern) = self.pattern else { return own };
        let normal = spot.mean(surface, &surface.rest.normals).normalize_or(Vec3::Y);
        own * pattern.color(spot.mean(surface, &surface.rest.positions), normal).extend(1.0)
    }

    /// One per material: whether its hair hangs over skin of another colour than its own, or that of others over it.
    fn mixed(&self, rooting: &Rooting<'_>) -> Vec<bool> {
        let mut mixed = vec![false; self.colors.materials.len()];
        if self.is_of_one_color(rooting.furred) {
            return mixed;
        }
        // The farthest, and half of it.
        let farthest =
            rooting.asides.iter().copied().fold(Vec2::ZERO, |far, a| if a.length() > far.length() { a } else { far });
        for triangle in (0..self.material_of.len()).filter(|t| self.walk.is_furred(*t)) {
            let material = self.material_of[triangle];
            if mixed.get(material) != Some(&false) {
                continue;
            }
            mixed[material] = spots(self.surface, triangle).any(|spot| {
                let own = self.color(spot);
                [0.5, 1.0].iter().any(|share| {
                    let root = self.walked(spot, -(farthest * *share).as_dvec2());
                    differ(own, self.color(root))
                })
            });
        }
        mixed
    }

    /// Whether all furred materials have one colour, and their vertices none of their own.
    fn is_of_one_color(&self, furred: &[bool]) -> bool {
        let mut materials = self.colors.materials.iter().zip(furred).filter(|(_, furred)| **furred).map(|(m, _)| m);
        let first = materials.next();
        let plain = first.is_none_or(|first| first.image.is_none() && materials.all(|m| m == first));
        let corners = || {
            let furred = (0..self.material_of.len()).filter(|t| self.walk.is_furred(*t));
            furred.flat_map(|t| self.surface.mesh.triangles[t]).filter_map(|v| self.colors.vertices.get(v as usize))
        };
        let color = corners().next();
        self.pattern.is_none() && plain && corners().all(|v| Some(v) == color)
    }
}

/// The skin as a walk needs it.
struct Walkable {
    ground: Ground,
    /// One per triangle.
    material_of: Vec<usize>,
}

impl Walkable {
    /// * `furred`: one per material
    fn new(surface: &Surface, furred: &[bool]) -> Self {
        let mesh = &surface.mesh;
        let material_of = material_of_triangles(surface);
        let moved_by = |v: usize| mesh.skin.get(v).map(|skin| (skin.joints, skin.weights));
        // Adding zero turns -0 into +0.
        let vertices = mesh.positions.iter().enumerate().map(|(v, p)| ((*p + Vec3::ZERO).to_array(), moved_by(v)));
        let ground = Ground {
            triangles: mesh.triangles.clone(),
            furred: material_of.iter().map(|m| furred.get(*m).copied().unwrap_or(false)).collect(),
            positions: surface.rest.positions.iter().map(|p| p.as_dvec3()).collect(),
            tile_uv: surface.tile_uvs.iter().map(|uv| uv.as_dvec2()).collect(),
            same_place: same_places(vertices),
        };
        Self { ground, material_of }
    }
}

/// Places spread over a triangle, as many as its area in the tile asks for.
fn spots(surface: &Surface, triangle: usize) -> impl Iterator<Item = Spot> {
    let [a, b, c] = surface.mesh.triangles[triangle].map(|v| surface.tile_uvs[v as usize]);
    let area = 0.5 * (b - a).perp_dot(c - a).abs();
    let rows = ((ROOTS_PER_TILE * area).ceil() as usize).clamp(1, MOST_ROOTS).isqrt().max(1);
    // The middles of rows² equal triangles, half of which stand on their heads.
    (0..rows).flat_map(move |i| (0..2 * (rows - i) - 1).map(move |j| (i, j))).map(move |(i, j)| {
        let third = if j % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
        let (y, x) = ((i as f32 + third) / rows as f32, ((j / 2) as f32 + third) / rows as f32);
        Spot { triangle, weights: Vec3::new(1.0 - x - y, x, y) }
    })
}

/// Whether two linear colours can be told apart.
fn differ(a: Vec4, b: Vec4) -> bool {
    let bytes = |c: Vec4| [c.x, c.y, c.z].map(linear_to_srgb);
    bytes(a).into_iter().zip(bytes(b)).any(|(a, b)| a.abs_diff(b) > ONE_COLOR)
}

#[cfg(test)]
#[path = "at_root_tests.rs"]
mod tests;
