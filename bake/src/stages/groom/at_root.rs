//! `color.at_root`: hair keeps the colour at its root, even where it hangs over another colour.
//!
//! A renderer of layers finds the root of a texel's hair by an offset in the tile ([`RootsInfo`]). It then reads the
//! base colour there, which requires a texture laid out like the tile. So the colours of materials whose hair hangs
//! over other colours are painted into an [`Atlas`] in tile coordinates. The gutter around a chart holds the colours of
//! adjacent patches and materials, which a walk over the surface ([`SurfaceWalk`]) reaches. The walk ends at bare
//! materials and at the boundary of the mesh, because there are no roots beyond.

use super::atlas::{Atlas, linear_image, srgb_image};
use super::canvas::SurfacePoint;
use super::colors::Colors;
use super::maps::GroomTextures;
use super::pattern::{Pattern, assign_textures, material_of_triangles, sample_model_uvs};
use crate::sample::Encoding;
use crate::stages::surface::Surface;
use glam::{DVec2, Vec2, Vec3, Vec4};
use pelage_formats::meaning::linear_to_srgb;
use pelage_formats::meaning::planting::{PlantingMesh, SurfaceWalk, WalkEvents, WalkPosition, same_places};
use pelage_formats::{ROOT_HEIGHTS, RootOffset, RootsInfo};

/// Resolution that suffices, texels per width of a tile. Colour borders in the texture are then sharper than the blur
/// that hair causes.
const ENOUGH_TEXELS: f32 = 16.0;
/// Minimum resolution, texels per width of a tile. Below it, colour borders would be as coarse as hair is long.
const LEAST_TEXELS: f32 = 6.0;
/// Largest difference at which two colours count as equal, in steps of an sRGB byte.
const ONE_COLOR: u8 = 4;
/// Number of roots to sample per area of a tile, to test whether hair hangs over another colour.
const ROOTS_PER_TILE: f32 = 64.0;
/// Maximum number of sampled roots per triangle.
const MOST_ROOTS: usize = 256;

/// Input for painting the colours at the roots.
#[derive(Clone, Copy, Debug)]
pub struct RootColorInput<'a> {
    /// Whether hair grows on each material.
    pub furred: &'a [bool],
    /// Pattern painted over the colours, if any.
    pub pattern: Option<&'a Pattern<'a>>,
    /// Mean displacement of hair from its root at several heights, tiles.
    pub asides: &'a [Vec2],
    /// Largest displacement of hair from its root, tiles.
    pub reach: f32,
    /// Maximum width and height of the texture, texels.
    pub most_side: u32,
}

/// Texture with the colours at the roots.
#[derive(Clone, Debug)]
pub struct RootAtlas {
    atlas: Atlas,
    /// Whether each material is painted into the texture.
    of_material: Vec<bool>,
}

impl RootAtlas {
    /// Lays out all materials whose hair hangs over another colour. Returns `None` if there are none, or if the charts
    /// with gutters as wide as the hair's reach do not fit. On success, vertices of `surface` are duplicated along the
    /// borders of charts.
    ///
    /// * `colors`: colours of `surface`
    pub fn new(surface: &mut Surface, colors: &Colors, rooting: &RootColorInput<'_>) -> Option<Self> {
        let ground = WalkInput::new(surface, rooting.furred);
        let mut of_material = ColoredSurface::new(surface, colors, rooting, &ground).overhanging_materials(rooting);
        if !of_material.contains(&true) {
            return None;
        }
        if rooting.pattern.is_some() {
            // A pattern is in no other texture, so all furred materials are painted.
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

    /// Paints factor, texture, vertex colours and pattern of the materials into the texture, and sets their texture
    /// coordinates to it. Groom textures are converted too.
    ///
    /// * `surface`: as left by [`Self::new`]
    /// * `colors`: colours of `surface`
    ///
    /// Call this after everything that reads the model's own texture coordinates.
    pub fn paint(
        &self,
        rooting: &RootColorInput<'_>,
        surface: &mut Surface,
        colors: &mut Colors,
        grooms: &mut GroomTextures,
    ) {
        let ground = WalkInput::new(surface, rooting.furred);
        let skin = ColoredSurface::new(surface, colors, rooting, &ground);
        let texels = self.atlas.paint(|spot, extent| {
            // Average four samples per texel, for smooth borders.
            let samples = [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)].map(|(dx, dy)| {
                skin.color(skin.on_adjacent_surface(SurfacePoint {
                    weights: spot.weights + extent[0] * dx + extent[1] * dy,
                    ..spot
                }))
            });
            samples.into_iter().sum::<Vec4>() / 4.0
        });
        let color = srgb_image(self.atlas.side, &texels);
        let with_groom =
            self.of_material.iter().zip(&grooms.of_material).any(|(painted, own)| *painted && own.is_some());
        let groom = with_groom.then(|| {
            let texels = self.atlas.paint(|spot, _| {
                let spot = skin.on_adjacent_surface(spot);
                let own = grooms.of_material.get(skin.material_of[spot.triangle]).copied().flatten();
                let own = own.and_then(|image| grooms.images.get(image));
                own.map_or(Vec4::new(1.0, 0.0, 0.0, 1.0), |image| {
                    sample_model_uvs(surface, spot, image, Encoding::Linear)
                })
            });
            linear_image(self.atlas.side, &texels)
        });
        for part in surface.mesh.parts.iter().filter(|part| self.of_material.get(part.material) == Some(&true)) {
            let triangles = &surface.mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count];
            triangles.iter().flatten().for_each(|v| colors.vertices[*v as usize] = [255; 4]);
        }
        let painted = colors.materials.iter_mut().zip(&self.of_material).filter(|(_, painted)| **painted);
        painted.for_each(|(material, _)| material.factor = [1.0; 4]);
        assign_textures(&self.atlas, &self.of_material, (color, groom), surface, colors, grooms);
    }

    /// Returns the data with which a renderer finds roots, for the displacements `asides`.
    pub fn info(&self, asides: [RootOffset; ROOT_HEIGHTS]) -> RootsInfo {
        let uv_per_tile = self.atlas.scale / self.atlas.side as f32;
        let of_material = |painted: &bool| if *painted { uv_per_tile } else { 0.0 };
        RootsInfo { asides, uv_per_tile: self.of_material.iter().map(of_material).collect() }
    }
}

/// Coloured surface to walk on.
struct ColoredSurface<'a> {
    surface: &'a Surface,
    colors: &'a Colors,
    pattern: Option<&'a Pattern<'a>>,
    /// Material of each triangle.
    material_of: &'a [usize],
    walk: SurfaceWalk<'a>,
}

impl<'a> ColoredSurface<'a> {
    fn new(surface: &'a Surface, colors: &'a Colors, rooting: &RootColorInput<'a>, ground: &'a WalkInput) -> Self {
        let WalkInput { ground, material_of } = ground;
        Self { surface, colors, pattern: rooting.pattern, material_of, walk: SurfaceWalk::new(ground) }
    }

    /// Returns the end of a walk from a point by the offset `by`. The walk stops where the furred surface ends.
    fn walk_end(&self, spot: SurfacePoint, by: DVec2) -> SurfacePoint {
        let mut at = WalkPosition { triangle: spot.triangle, weights: spot.weights.as_dvec3(), beyond: None };
        self.walk.step(&mut at, by, &mut WalkEvents::default());
        SurfacePoint { triangle: at.triangle, weights: at.weights.as_vec3() }
    }

    /// Maps a point outside its triangle to the adjacent surface.
    fn on_adjacent_surface(&self, spot: SurfacePoint) -> SurfacePoint {
        let inside = spot.clamped();
        if spot.weights.min_element() >= 0.0 {
            return inside;
        }
        let corners = self.surface.mesh.triangles[spot.triangle].map(|v| self.surface.tile_uvs[v as usize].as_dvec2());
        let by = (spot.weights - inside.weights).as_dvec3();
        self.walk_end(inside, corners[0] * by.x + corners[1] * by.y + corners[2] * by.z)
    }

    /// Returns the linear RGBA at a point inside its triangle.
    fn color(&self, spot: SurfacePoint) -> Vec4 {
        let Self { surface, colors, .. } = self;
        let Some(material) = colors.materials.get(self.material_of[spot.triangle]) else { return Vec4::ONE };
        let [a, b, c] = surface.mesh.triangles[spot.triangle]
            .map(|v| Vec4::from(colors.vertices.get(v as usize).map_or([1.0; 4], |c| c.map(|x| f32::from(x) / 255.0))));
        let tint = (a * spot.weights.x + b * spot.weights.y + c * spot.weights.z) * Vec4::from(material.factor);
        let image = material.image.and_then(|image| colors.images.get(image));
        let own = tint * image.map_or(Vec4::ONE, |image| sample_model_uvs(surface, spot, image, Encoding::Srgb));
        let Some(pattern) = self.pattern else { return own };
        let normal = spot.interpolate(surface, &surface.rest.normals).normalize_or(Vec3::Y);
        own * pattern.color(spot.interpolate(surface, &surface.rest.positions), normal).extend(1.0)
    }

    /// Returns for each material whether its hair hangs over another colour, or whether hair of another colour hangs
    /// over it.
    fn overhanging_materials(&self, rooting: &RootColorInput<'_>) -> Vec<bool> {
        let mut mixed = vec![false; self.colors.materials.len()];
        if self.is_uniform(rooting.furred) {
            return mixed;
        }
        // Test the largest displacement and half of it.
        let farthest =
            rooting.asides.iter().copied().fold(Vec2::ZERO, |far, a| if a.length() > far.length() { a } else { far });
        for triangle in (0..self.material_of.len()).filter(|t| self.walk.is_furred(*t)) {
            let material = self.material_of[triangle];
            if mixed.get(material) != Some(&false) {
                continue;
            }
            mixed[material] = sample_points(self.surface, triangle).any(|spot| {
                let own = self.color(spot);
                [0.5, 1.0].iter().any(|share| {
                    let root = self.walk_end(spot, -(farthest * *share).as_dvec2());
                    differ(own, self.color(root))
                })
            });
        }
        mixed
    }

    /// Whether all furred surfaces have the same colour: without a pattern or textures, and with equal material and
    /// vertex colours.
    fn is_uniform(&self, furred: &[bool]) -> bool {
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

/// Mesh for surface walks.
struct WalkInput {
    ground: PlantingMesh,
    /// Material of each triangle.
    material_of: Vec<usize>,
}

impl WalkInput {
    /// Prepares the surface for walks.
    ///
    /// * `furred`: one per material
    fn new(surface: &Surface, furred: &[bool]) -> Self {
        let mesh = &surface.mesh;
        let material_of = material_of_triangles(surface);
        let moved_by = |v: usize| mesh.skin.get(v).map(|skin| (skin.joints, skin.weights));
        // Adding zero turns -0 into +0.
        let vertices = mesh.positions.iter().enumerate().map(|(v, p)| ((*p + Vec3::ZERO).to_array(), moved_by(v)));
        let ground = PlantingMesh {
            triangles: mesh.triangles.clone(),
            furred: material_of.iter().map(|m| furred.get(*m).copied().unwrap_or(false)).collect(),
            positions: surface.rest.positions.iter().map(|p| p.as_dvec3()).collect(),
            tile_uv: surface.tile_uvs.iter().map(|uv| uv.as_dvec2()).collect(),
            same_place: same_places(vertices),
        };
        Self { ground, material_of }
    }
}

/// Returns points spread over a triangle. Their number is proportional to its area in the tile.
fn sample_points(surface: &Surface, triangle: usize) -> impl Iterator<Item = SurfacePoint> {
    let [a, b, c] = surface.mesh.triangles[triangle].map(|v| surface.tile_uvs[v as usize]);
    let area = 0.5 * (b - a).perp_dot(c - a).abs();
    let rows = ((ROOTS_PER_TILE * area).ceil() as usize).clamp(1, MOST_ROOTS).isqrt().max(1);
    // Divide the triangle into rows² equal triangles, about half of them upside down. The points are their centres.
    (0..rows).flat_map(move |i| (0..2 * (rows - i) - 1).map(move |j| (i, j))).map(move |(i, j)| {
        let third = if j % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
        let (y, x) = ((i as f32 + third) / rows as f32, ((j / 2) as f32 + third) / rows as f32);
        SurfacePoint { triangle, weights: Vec3::new(1.0 - x - y, x, y) }
    })
}

/// Whether two linear colours are distinguishable.
fn differ(a: Vec4, b: Vec4) -> bool {
    let bytes = |c: Vec4| [c.x, c.y, c.z].map(linear_to_srgb);
    bytes(a).into_iter().zip(bytes(b)).any(|(a, b)| a.abs_diff(b) > ONE_COLOR)
}

#[cfg(test)]
#[path = "at_root_tests.rs"]
mod tests;
