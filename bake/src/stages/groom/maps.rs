//! What varies over the model, evaluated: `[groom]` of the recipe, its tables for single materials and the images that it names,
//! at every vertex and, where it matters, at every texel.

use super::glob;
use crate::BakeError;
use crate::guides::Guides;
use crate::mesh::{Image, Material, Mesh, MeshPart, RestPose};
use crate::recipe::{ColorMap, GroomParams, MaterialTable, ScalarMap, VectorMap};
use crate::sample::{Encoding, Wrap, bilinear};
use glam::{Vec2, Vec3};
use pelage_formats::InputRecord;
use std::collections::BTreeMap;

/// The decoded images that a recipe names, by their paths.
#[derive(Clone, Debug, Default)]
pub struct MapImages {
    /// By path as the recipe writes it.
    pub images: BTreeMap<String, Image>,
    /// Strands of files, by path as the recipe writes it.
    pub strands: BTreeMap<String, Guides>,
    /// The files that were read, in the order of reading.
    pub inputs: Vec<InputRecord>,
}

impl MapImages {
    /// The image of that path.
    ///
    /// # Errors
    /// [`BakeError::Internal`] where it was not read.
    pub fn get(&self, path: &str) -> Result<&Image, BakeError> {
        self.images.get(path).ok_or_else(|| BakeError::Internal(format!("the image {path:?} was not read")))
    }
}

/// What decides how hair is laid over the skin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lay {
    /// Hairs per area relative to the rest of the coat, 0.25..=4, one per vertex; `None` for 1 everywhere.
    pub density: Option<Vec<f32>>,
    /// Where the hair is combed to, at rest in world space, one per vertex, its length how much it counts; `None` where no map says it.
    pub comb: Option<Vec<Vec3>>,
}

/// The coat at every vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coat {
    /// Share of the hair's length, 0..=1; 0 on vertices without a furred material.
    pub length: Vec<f32>,
    /// Extra lean, 0..=1.
    pub lean: Vec<f32>,
    /// 0 dry to 1 wet. 0 where a texture says it.
    pub wetness: Vec<f32>,
    /// 1 where no hair grows. 0 where a texture says it.
    pub bareness: Vec<f32>,
}

/// How wet the coat is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Water {
    /// Nowhere.
    Dry,
    /// Everywhere.
    Wet,
    /// Here and there, or half.
    Mixed,
}

impl Water {
    /// How wet furred materials of those names are by that groom.
    pub fn of(groom: &GroomParams, names: &[&str]) -> Self {
        Self::over(
            names.iter().map(|name| last(&groom.material, name, |t| t.wetness.as_ref()).unwrap_or(&groom.wetness)),
        )
    }

    fn over<'m>(maps: impl Iterator<Item = &'m ScalarMap> + Clone) -> Self {
        let all = |share: f32| maps.clone().all(|map| *map == ScalarMap::Constant(share));
        if all(0.0) {
            Self::Dry
        } else if all(1.0) {
            Self::Wet
        } else {
            Self::Mixed
        }
    }
}

/// Groom textures, one texel of hair share and wetness each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GroomTextures {
    /// Red is the share of the hair that grows, green is wetness; blue 0, alpha 255.
    pub images: Vec<Image>,
    /// One per material: index into `images`.
    pub of_material: Vec<Option<usize>>,
}

/// The maps of each material of a model.
#[derive(Clone, Debug)]
pub struct Maps<'a> {
    images: &'a MapImages,
    materials: Vec<MaterialMaps<'a>>,
}

/// The maps of one material.
#[derive(Clone, Copy, Debug)]
struct MaterialMaps<'a> {
    furred: bool,
    length: &'a ScalarMap,
    density: &'a ScalarMap,
    lean: &'a ScalarMap,
    comb: Option<&'a VectorMap>,
    wetness: &'a ScalarMap,
    bare: &'a ScalarMap,
    color: Option<&'a ColorMap>,
}

impl<'a> Maps<'a> {
    /// Finds the maps of every material.
    ///
    /// * `furred`: one per material
    ///
    /// Names that match no material, and images on parts without texture coordinates, where they have no effect, are reported in
    /// `warnings`.
    pub fn new(
        mesh: &Mesh,
        materials: &[Material],
        furred: &[bool],
        groom: &'a GroomParams,
        images: &'a MapImages,
        warnings: &mut Vec<String>,
    ) -> Self {
        report_unmatched("groom.material", &groom.material, materials, warnings);
        let convert = |(i, m): (usize, &Material)| MaterialMaps {
            furred: furred.get(i).copied().unwrap_or(false),
            length: last(&groom.material, &m.name, |t| t.length.as_ref()).unwrap_or(&groom.length),
            density: last(&groom.material, &m.name, |t| t.density.as_ref()).unwrap_or(&groom.density),
            lean: last(&groom.material, &m.name, |t| t.lean.as_ref()).unwrap_or(&groom.lean),
            comb: last(&groom.material, &m.name, |t| t.comb.as_ref()).or(groom.comb.as_ref()),
            wetness: last(&groom.material, &m.name, |t| t.wetness.as_ref()).unwrap_or(&groom.wetness),
            bare: last(&groom.material, &m.name, |t| t.bare.as_ref()).unwrap_or(&groom.bare),
            color: last(&groom.material, &m.name, |t| t.color.as_ref()).or(groom.color.as_ref()),
        };
        let maps = Self { images, materials: materials.iter().enumerate().map(convert).collect() };
        for part in maps.furred_parts(mesh).filter(|(part, _)| !part.has_uvs) {
            if let Some(path) = part.1.image() {
                warnings.push(format!(
                    "{}: no texture coordinates, so that {path:?} and other images of [groom] have no effect on it",
                    part.0.source
                ));
            }
        }
        maps
    }

    fn furred_parts<'m>(&'m self, mesh: &'m Mesh) -> impl Iterator<Item = (&'m MeshPart, &'m MaterialMaps<'a>)> {
        mesh.parts.iter().filter_map(|p| self.materials.get(p.material).filter(|m| m.furred).map(|m| (p, m)))
    }

    /// Evaluates density and comb direction at the vertices of `mesh`, whose rest pose is `rest`. Materials without a comb direction of
    /// their own get `elsewhere`.
    ///
    /// # Errors
    /// [`BakeError::Internal`] where an image was not read.
    pub fn lay(&self, mesh: &Mesh, rest: &RestPose, elsewhere: Vec3) -> Result<Lay, BakeError> {
        let furred = || self.materials.iter().filter(|m| m.furred);
        let mut lay = Lay::default();
        if furred().any(|m| *m.density != ScalarMap::Constant(1.0)) {
            // Of a map, equal steps are equal ratios.
            let hairs = |map: &ScalarMap, v: f32| {
                if matches!(map, ScalarMap::Constant(_)) { v } else { libm::exp2f(4.0 * v - 2.0) }
            };
            let each = |part: &MeshPart, m: &MaterialMaps<'a>, v: usize| {
                Ok(hairs(m.density, self.scalar(mesh, part, m.density, v)?.unwrap_or(0.5)))
            };
            lay.density = Some(self.average(mesh, 1.0, each)?);
        }
        if furred().any(|m| m.comb.is_some()) {
            let flows = if furred().any(|m| matches!(m.comb, Some(VectorMap::Image { flow: true, .. }))) {
                image_axes(mesh, rest)
            } else {
                Vec::new()
            };
            let each = |part: &MeshPart, m: &MaterialMaps<'a>, v: usize| {
                m.comb.map_or(Ok(elsewhere), |map| self.vector(mesh, part, map, v, &flows))
            };
            lay.comb = Some(self.average(mesh, Vec3::ZERO, each)?);
        }
        Ok(lay)
    }

    /// Evaluates length, lean, wetness and bareness at the vertices of `mesh`.
    ///
    /// # Errors
    /// [`BakeError::Internal`] where an image was not read.
    pub fn coat(&self, mesh: &Mesh) -> Result<Coat, BakeError> {
        let scalar =
            |map: fn(&MaterialMaps<'a>) -> &'a ScalarMap, without_uvs: f32, per_vertex: fn(&ScalarMap) -> bool| {
                self.average(mesh, 0.0, |part, m, v| {
                    let map = map(m);
                    if per_vertex(map) { Ok(self.scalar(mesh, part, map, v)?.unwrap_or(without_uvs)) } else { Ok(0.0) }
                })
            };
        let no_image = |map: &ScalarMap| map.image().is_none();
        Ok(Coat {
            length: scalar(|m| m.length, 1.0, |_| true)?,
            lean: scalar(|m| m.lean, 0.0, |_| true)?,
            wetness: scalar(|m| m.wetness, 0.0, no_image)?,
            bareness: scalar(|m| m.bare, 0.0, no_image)?,
        })
    }

    /// How wet the furred materials are.
    pub fn water(&self) -> Water {
        Water::over(self.materials.iter().filter(|m| m.furred).map(|m| m.wetness))
    }

    /// Source of the hair's colour on a material in place of the model's, if there is one.
    pub(super) fn color(&self, material: usize) -> Option<&'a ColorMap> {
        self.materials.get(material).filter(|m| m.furred).and_then(|m| m.color)
    }

    /// The decoded image of that path.
    pub(super) fn image(&self, path: &str) -> Result<&'a Image, BakeError> {
        self.images.get(path)
    }

    /// Joins the images that say where hair grows and where it is wet into one texture per pair of them.
    ///
    /// # Errors
    /// [`BakeError::Internal`] where an image was not read.
    pub fn textures(&self) -> Result<GroomTextures, BakeError> {
        let mut textures = GroomTextures::default();
        let mut known: Vec<(Option<&ScalarMap>, Option<&ScalarMap>)> = Vec::new();
        for m in &self.materials {
            let image = |map: &'a ScalarMap| Some(map).filter(|map| m.furred && map.image().is_some());
            let pair = (image(m.bare), image(m.wetness));
            if pair == (None, None) {
                textures.of_material.push(None);
                continue;
            }
            let index = known.iter().position(|k| *k == pair).unwrap_or(known.len());
            if index == known.len() {
                known.push(pair);
                textures.images.push(self.join(pair.0, pair.1)?);
            }
            textures.of_material.push(Some(index));
        }
        Ok(textures)
    }

    /// One image of hair share and wetness, as large as the larger of the two both ways.
    fn join(&self, bare: Option<&ScalarMap>, wetness: Option<&ScalarMap>) -> Result<Image, BakeError> {
        let source = |map: Option<&ScalarMap>| -> Result<_, BakeError> {
            match map {
                Some(ScalarMap::Image { path, channel }) => Ok(Some((self.images.get(path)?, channel.index()))),
                _ => Ok(None),
            }
        };
        let sources = [source(bare)?, source(wetness)?];
        let side = |of: fn(&Image) -> u32| sources.iter().flatten().map(|(image, _)| of(image)).max().unwrap_or(1);
        let (width, height) = (side(|i| i.width), side(|i| i.height));
        let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let uv = Vec2::new((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
            let [bare, wet] = sources.map(|source| {
                source.map_or(0.0, |(image, channel)| bilinear(image, uv, Wrap::Repeat, Encoding::Linear)[channel])
            });
            rgba.extend([1.0 - bare, wet, 0.0, 1.0].map(|share| (255.0 * share).round() as u8));
        }
        Ok(Image { width, height, rgba })
    }

    /// A value per vertex: the mean over the furred parts that it belongs to, `outside` where there is none.
    fn average<T: Averaged>(
        &self,
        mesh: &Mesh,
        outside: T,
        each: impl Fn(&MeshPart, &MaterialMaps<'a>, usize) -> Result<T, BakeError>,
    ) -> Result<Vec<T>, BakeError> {
        let parts = self.furred_parts(mesh).map(|(part, maps)| (part, *maps));
        average(mesh, parts, outside, |part, maps, v| each(part, maps, v))
    }

    /// As [`scalar_at`].
    fn scalar(&self, mesh: &Mesh, part: &MeshPart, map: &ScalarMap, v: usize) -> Result<Option<f32>, BakeError> {
        scalar_at(self.images, mesh, part, map, v)
    }

    fn vector(
        &self,
        mesh: &Mesh,
        part: &MeshPart,
        map: &VectorMap,
        v: usize,
        axes: &[[Vec3; 2]],
    ) -> Result<Vec3, BakeError> {
        let signed = |rgb: Vec3| rgb * 2.0 - 1.0;
        Ok(match map {
            VectorMap::Constant(direction) => Vec3::from(*direction),
            VectorMap::Vertex => {
                let [r, g, b, _] = mesh.colors[v].map(|byte| f32::from(byte) / 255.0);
                signed(Vec3::new(r, g, b))
            }
            VectorMap::Image { .. } if !part.has_uvs => Vec3::ZERO,
            VectorMap::Image { path, flow } => {
                let texel = bilinear(self.images.get(path)?, mesh.uvs[v], Wrap::Repeat, Encoding::Linear);
                let direction = signed(texel.truncate());
                match axes.get(v).filter(|_| *flow) {
                    Some([right, up]) => *right * direction.x + *up * direction.y,
                    None => direction,
                }
            }
        })
    }
}

impl MaterialMaps<'_> {
    /// The first image among the maps.
    fn image(&self) -> Option<&str> {
        let scalars = [self.length, self.density, self.lean, self.wetness, self.bare];
        let vector = || self.comb.and_then(VectorMap::image);
        scalars.into_iter().find_map(ScalarMap::image).or_else(vector).or_else(|| self.color.and_then(ColorMap::image))
    }
}

/// What can be averaged.
pub(crate) trait Averaged: Copy + Default + std::ops::AddAssign + std::ops::Mul<f32, Output = Self> {}

impl<T: Copy + Default + std::ops::AddAssign + std::ops::Mul<f32, Output = T>> Averaged for T {}

/// A value per vertex: the mean over those of `parts` that it belongs to, `outside` where there is none. Each part comes with what `each` wants to
/// know of it.
pub(crate) fn average<'m, M, T: Averaged>(
    mesh: &'m Mesh,
    parts: impl Iterator<Item = (&'m MeshPart, M)>,
    outside: T,
    each: impl Fn(&MeshPart, &M, usize) -> Result<T, BakeError>,
) -> Result<Vec<T>, BakeError> {
    let mut sums = vec![(T::default(), 0u32); mesh.positions.len()];
    let mut seen_in = vec![0; mesh.positions.len()];
    for (number, (part, about)) in parts.enumerate() {
        let triangles = &mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count];
        for v in triangles.iter().flatten().map(|v| *v as usize) {
            if seen_in[v] != number + 1 {
                seen_in[v] = number + 1;
                sums[v].0 += each(part, &about, v)?;
                sums[v].1 += 1;
            }
        }
    }
    Ok(sums.into_iter().map(|(sum, n)| if n == 0 { outside } else { sum * (n as f32).recip() }).collect())
}

/// Value of a map at a vertex; `None` for an image where there are no texture coordinates.
pub(crate) fn scalar_at(
    images: &MapImages,
    mesh: &Mesh,
    part: &MeshPart,
    map: &ScalarMap,
    v: usize,
) -> Result<Option<f32>, BakeError> {
    Ok(match map {
        ScalarMap::Constant(value) => Some(*value),
        ScalarMap::Vertex(channel) => Some(f32::from(mesh.colors[v][channel.index()]) / 255.0),
        ScalarMap::Image { .. } if !part.has_uvs => None,
        ScalarMap::Image { path, channel } => {
            Some(bilinear(images.get(path)?, mesh.uvs[v], Wrap::Repeat, Encoding::Linear)[channel.index()])
        }
    })
}

/// What the last table that matches a material of that name and has the key says.
pub(crate) fn last<'a, M: MaterialTable, T>(
    tables: &'a [M],
    material: &str,
    key: impl Fn(&'a M) -> Option<&'a T>,
) -> Option<&'a T> {
    tables.iter().rev().filter(|t| glob(t.material_name(), material)).find_map(key)
}

/// Reports tables whose name matches no material; `key` is theirs in the recipe.
pub(crate) fn report_unmatched<M: MaterialTable>(
    key: &str,
    tables: &[M],
    materials: &[Material],
    warnings: &mut Vec<String>,
) {
    for table in tables.iter().filter(|t| !materials.iter().any(|m| glob(t.material_name(), &m.name))) {
        let names: Vec<_> = materials.iter().map(|m| m.name.as_str()).collect();
        warnings.push(format!("{key}: {:?} matches no material; the model has {names:?}", table.material_name()));
    }
}

/// Per vertex the unit directions on the skin, at rest, that point right and up on the model's images: the mean over its triangles
/// of the gradients of the texture coordinates, zero where there is none.
fn image_axes(mesh: &Mesh, rest: &RestPose) -> Vec<[Vec3; 2]> {
    let mut axes = vec![[Vec3::ZERO; 2]; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| v as usize);
        let (p1, p2) = (rest.positions[b] - rest.positions[a], rest.positions[c] - rest.positions[a]);
        let (t1, t2) = (mesh.uvs[b] - mesh.uvs[a], mesh.uvs[c] - mesh.uvs[a]);
        let area = t1.perp_dot(t2);
        if area == 0.0 {
            continue;
        }
        // Images have v downwards.
        let (right, down) = ((p1 * t2.y - p2 * t1.y) / area, (p2 * t1.x - p1 * t2.x) / area);
        for v in [a, b, c] {
            axes[v][0] += right.normalize_or_zero();
            axes[v][1] -= down.normalize_or_zero();
        }
    }
    axes.iter_mut().flatten().for_each(|axis| *axis = axis.normalize_or_zero());
    axes
}

#[cfg(test)]
#[path = "maps_tests.rs"]
mod tests;
