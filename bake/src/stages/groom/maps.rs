//! Evaluation of values that vary over the model. `[groom]` of the recipe, its tables for single materials and its
//! images are evaluated at every vertex and, where needed, at every texel.

use super::body::BodyGroom;
use super::flow::image_axes;
use super::image_coordinates::{ImageCoordinates, Texel, Vertices};
use super::joints::JointValues;
use super::marks::{MarkValues, blend_marks};
use crate::decision::Decision;
use crate::recipe::{ColorMap, GroomCoordinates, GroomParams, JointGroom, NamedTable, ScalarMap, SrgbColor, VectorMap};
use crate::sample::{Encoding, Wrap, bilinear};
use glam::{Vec2, Vec3};
use pelage_formats::InputRecord;
use pelage_import::BakeError;
use pelage_import::guides::Guides;
use pelage_import::mesh::{Image, Material, Mesh, MeshPart, RestPose};
use pelage_params::glob;
use std::collections::BTreeMap;

/// Decoded images and strands that a recipe names.
#[derive(Clone, Debug, Default)]
pub struct MapImages {
    /// Images by path as written in the recipe.
    pub images: BTreeMap<String, Image>,
    /// Strands by path of their file as written in the recipe.
    pub strands: BTreeMap<String, Guides>,
    /// Records of the files read, in reading order.
    pub inputs: Vec<InputRecord>,
    /// Warnings.
    pub warnings: Vec<String>,
}

impl MapImages {
    /// Returns the image with that path.
    ///
    /// Fails with [`BakeError::Internal`] if it was not read.
    pub fn get(&self, path: &str) -> Result<&Image, BakeError> {
        self.images.get(path).ok_or_else(|| BakeError::Internal(format!("the image {path:?} was not read")))
    }
}

/// Density and comb direction, which determine the layout of the tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayoutMaps {
    /// Hairs per area relative to the rest of the fur, 0.25..=4, one per vertex; `None` if it is 1 everywhere.
    pub density: Option<Vec<f32>>,
    /// Comb direction in world space at rest, one vector per vertex. The length of the vector is the weight of the
    /// direction. `None` if no map sets it.
    pub comb: Option<Vec<Vec3>>,
}

/// Groom values at every vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexGroom {
    /// Hair length as a share of the longest hair, 0..=1; 0 on vertices without a furred material.
    pub length: Vec<f32>,
    /// Extra lean, 0..=1.
    pub lean: Vec<f32>,
    /// Wetness, 0 dry to 1 wet; 0 where a groom texture stores the wetness instead.
    pub wetness: Vec<f32>,
    /// Bareness, 1 where no hair grows; 0 where a groom texture stores the bareness instead.
    pub bareness: Vec<f32>,
}

/// Wetness of the fur as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FurWetness {
    /// Dry everywhere.
    Dry,
    /// Wet everywhere.
    Wet,
    /// Neither dry everywhere nor wet everywhere.
    Mixed,
}

impl FurWetness {
    /// Returns the wetness of the furred materials `names`. All tables for joints are considered, whether or not the
    /// model has such joints, so no skeleton is needed.
    pub fn of(groom: &GroomParams, names: &[&str]) -> Self {
        Self::over(
            names.iter().map(|name| last(&groom.material, name, |t| t.wetness.as_ref()).unwrap_or(&groom.wetness)),
            &groom.joint,
        )
    }

    fn over<'m>(maps: impl Iterator<Item = &'m ScalarMap> + Clone, joints: &[JointGroom]) -> Self {
        let all = |share: f32| {
            maps.clone().all(|map| *map == ScalarMap::Constant(share))
                && joints.iter().filter_map(|table| table.wetness).all(|wetness| wetness == share)
        };
        if all(0.0) {
            Self::Dry
        } else if all(1.0) {
            Self::Wet
        } else {
            Self::Mixed
        }
    }
}

/// Groom textures, which store the presence of hair and its wetness per texel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GroomTextures {
    /// Images. Red is the share of hair that grows, 1 − bareness; green is wetness, blue is 0, and alpha is 255.
    pub images: Vec<Image>,
    /// Index into `images` for each material; `None` without a groom texture.
    pub of_material: Vec<Option<usize>>,
}

/// Groom maps of each material of a model.
#[derive(Clone, Debug)]
pub struct Maps<'a> {
    images: &'a MapImages,
    materials: Vec<MaterialMaps<'a>>,
    tables_of_joints: &'a [JointGroom],
    joints: JointValues,
    body: Option<BodyGroom>,
    marks: MarkValues,
    /// Colour of furred materials that have no other colour source.
    plain: Option<ColorMap>,
    /// Texture coordinates of the images.
    over: ImageCoordinates,
}

/// Groom maps of one material.
#[derive(Clone, Copy, Debug)]
struct MaterialMaps<'a> {
    furred: bool,
    silent: UnsetKeys,
    length: &'a ScalarMap,
    density: &'a ScalarMap,
    lean: &'a ScalarMap,
    comb: Option<&'a VectorMap>,
    wetness: &'a ScalarMap,
    bare: &'a ScalarMap,
    color: Option<&'a ColorMap>,
    hair_color: Option<SrgbColor>,
}

/// Keys that neither `[groom]` nor a table for the material sets.
#[derive(Clone, Copy, Debug)]
struct UnsetKeys {
    length: bool,
    density: bool,
    lean: bool,
}

impl<'a> Maps<'a> {
    /// Resolves the maps of every material.
    ///
    /// * `furred`: whether each material is furred
    ///
    /// Tables whose names match no material are reported in `warnings`. Images on parts without texture coordinates
    /// have no effect, and are reported too.
    pub fn new(
        mesh: &Mesh,
        materials: &[Material],
        furred: &[bool],
        groom: &'a GroomParams,
        images: &'a MapImages,
        warnings: &mut Vec<String>,
    ) -> Self {
        report_unmatched("groom.material", &groom.material, "material", names_of(materials), warnings);
        let convert = |(i, m): (usize, &Material)| MaterialMaps {
            furred: furred.get(i).copied().unwrap_or(false),
            silent: UnsetKeys {
                length: groom.length == ScalarMap::Constant(1.0)
                    && last(&groom.material, &m.name, |t| t.length.as_ref()).is_none(),
                density: groom.density == ScalarMap::Constant(1.0)
                    && last(&groom.material, &m.name, |t| t.density.as_ref()).is_none(),
                lean: groom.lean == ScalarMap::Constant(0.0)
                    && last(&groom.material, &m.name, |t| t.lean.as_ref()).is_none(),
            },
            length: last(&groom.material, &m.name, |t| t.length.as_ref()).unwrap_or(&groom.length),
            density: last(&groom.material, &m.name, |t| t.density.as_ref()).unwrap_or(&groom.density),
            lean: last(&groom.material, &m.name, |t| t.lean.as_ref()).unwrap_or(&groom.lean),
            comb: last(&groom.material, &m.name, |t| t.comb.as_ref()).or(groom.comb.as_ref()),
            wetness: last(&groom.material, &m.name, |t| t.wetness.as_ref()).unwrap_or(&groom.wetness),
            bare: last(&groom.material, &m.name, |t| t.bare.as_ref()).unwrap_or(&groom.bare),
            color: last(&groom.material, &m.name, |t| t.color.as_ref()).or(groom.color.as_ref()),
            hair_color: last(&groom.material, &m.name, |t| t.hair_color.as_ref()).copied().or(groom.hair_color),
        };
        let maps = Self {
            images,
            materials: materials.iter().enumerate().map(convert).collect(),
            tables_of_joints: &groom.joint,
            joints: JointValues::default(),
            body: None,
            marks: MarkValues::default(),
            plain: None,
            over: ImageCoordinates::Model,
        };
        let over_model = groom.coordinates == GroomCoordinates::Model;
        for part in maps.furred_parts(mesh).filter(|(part, _)| over_model && !part.has_uvs) {
            if let Some(path) = part.1.image() {
                warnings.push(format!(
                    "{}: no texture coordinates, so {path:?} and other images of [groom] have no effect on it; \
                     groom.coordinates = \"atlas\" and \"box\" need none",
                    part.0.source
                ));
            }
        }
        maps
    }

    /// Adds the tables for single joints, which override the maps.
    #[must_use]
    pub fn with_joints(self, joints: JointValues) -> Self {
        Self { joints, ..self }
    }

    /// Adds the automatic groom, which applies where no map sets a value.
    #[must_use]
    pub fn with_body(self, body: Option<BodyGroom>) -> Self {
        Self { body, ..self }
    }

    /// Adds the marks, which override everything else.
    #[must_use]
    pub fn with_marks(self, marks: MarkValues) -> Self {
        Self { marks, ..self }
    }

    /// Sets a colour that replaces the model's on furred materials without `groom.color`.
    #[must_use]
    pub fn with_plain_color(self, color: SrgbColor) -> Self {
        Self { plain: Some(ColorMap::Constant(color)), ..self }
    }

    /// Returns the values of the marks.
    pub fn marks(&self) -> &MarkValues {
        &self.marks
    }

    /// Whether a map sets the comb direction.
    pub fn has_comb(&self) -> bool {
        self.materials.iter().any(|m| m.furred && m.comb.is_some())
    }

    /// Describes the automatic groom, if it determines the hair length of any furred material. Arguments are as in
    /// [`BodyGroom::decision`].
    pub fn decision(&self, share: f32, length_m: f32) -> Option<Decision> {
        let body = self.body.as_ref()?;
        self.materials.iter().any(|m| m.furred && m.silent.length).then(|| body.decision(share, length_m))
    }

    /// Whether a groom map of any furred material is an image.
    pub fn has_images(&self) -> bool {
        self.materials.iter().any(|m| m.furred && m.image().is_some())
    }

    /// Sets the texture coordinates of images. By default, images use the model's own.
    #[must_use]
    pub fn over(self, over: ImageCoordinates) -> Self {
        Self { over, ..self }
    }

    fn furred_parts<'m>(&'m self, mesh: &'m Mesh) -> impl Iterator<Item = (&'m MeshPart, &'m MaterialMaps<'a>)> {
        mesh.parts.iter().filter_map(|p| self.materials.get(p.material).filter(|m| m.furred).map(|m| (p, m)))
    }

    /// Evaluates density and comb direction at the vertices of `mesh`, whose rest pose is `rest`. Materials without a
    /// comb direction get the direction `elsewhere`.
    ///
    /// Fails with [`BakeError::Internal`] if an image was not read.
    pub fn layout_maps(&self, mesh: &Mesh, rest: &RestPose, elsewhere: Vec3) -> Result<LayoutMaps, BakeError> {
        let at = &Vertices::of_model(mesh, rest);
        let furred = || self.materials.iter().filter(|m| m.furred);
        let mut lay = LayoutMaps::default();
        let by_body = self.body.as_ref().and_then(|body| body.density.as_ref());
        let by_body = by_body.filter(|_| furred().any(|m| m.silent.density));
        let says = furred().any(|m| *m.density != ScalarMap::Constant(1.0)) || self.joints.has_key(|t| t.density);
        if says || by_body.is_some() || !self.marks.density.is_empty() {
            // Densities in images and vertex colours are logarithmic: equal steps of a value multiply the density by
            // equal factors.
            let hairs = |map: &ScalarMap, v: f32| {
                if matches!(map, ScalarMap::Constant(_)) { v } else { libm::exp2f(4.0 * v - 2.0) }
            };
            let each = |part: &MeshPart, m: &MaterialMaps<'a>, v: usize| {
                let on_body = by_body.filter(|_| m.silent.density).and_then(|density| density.get(v)).copied();
                let mapped = hairs(m.density, self.scalar(at, part, m.density, v)?.unwrap_or(0.5));
                let of_joints = self.joints.blend(mesh.skin.get(v), |t| t.density, on_body.unwrap_or(mapped));
                Ok(blend_marks(&self.marks.density, at.input(v), of_joints))
            };
            lay.density = Some(self.average(mesh, 1.0, each)?);
        }
        if self.has_comb() {
            let flow = |m: &MaterialMaps<'a>| matches!(m.comb, Some(VectorMap::Image { flow: true, .. }));
            let flows =
                if !self.over.at_vertices() && furred().any(flow) { image_axes(mesh, rest) } else { Vec::new() };
            let each = |part: &MeshPart, m: &MaterialMaps<'a>, v: usize| {
                m.comb.map_or(Ok(elsewhere), |map| self.vector(at, part, map, v, &flows))
            };
            lay.comb = Some(self.average(mesh, Vec3::ZERO, each)?);
        }
        Ok(lay)
    }

    /// Evaluates length, lean, wetness and bareness at vertices.
    ///
    /// Fails with [`BakeError::Internal`] if an image was not read.
    pub fn vertex_groom(&self, at: &Vertices<'_>) -> Result<VertexGroom, BakeError> {
        let mesh = at.mesh;
        let at_vertices = |map: &ScalarMap| self.over.at_vertices() || map.image().is_none();
        let on_body = |values: fn(&BodyGroom) -> &Vec<f32>, v: usize| {
            let values = values(self.body.as_ref()?);
            values.get(at.input(v)).copied()
        };
        let skin = |v: usize| mesh.skin.get(v);
        Ok(VertexGroom {
            length: self.average(mesh, 0.0, |part, m, v| {
                let by_body = m.silent.length.then(|| on_body(|body| &body.length, v)).flatten();
                let mapped = self.scalar(at, part, m.length, v)?.unwrap_or(1.0);
                let of_joints = self.joints.blend(skin(v), |t| t.length, by_body.unwrap_or(mapped));
                Ok(blend_marks(&self.marks.length, at.input(v), of_joints))
            })?,
            lean: self.average(mesh, 0.0, |part, m, v| {
                let by_body = m.silent.lean.then(|| on_body(|body| &body.lean, v)).flatten();
                let mapped = self.scalar(at, part, m.lean, v)?.unwrap_or(0.0);
                let of_joints = self.joints.blend(skin(v), |t| t.lean, by_body.unwrap_or(mapped));
                Ok(blend_marks(&self.marks.lean, at.input(v), of_joints))
            })?,
            wetness: self.average(mesh, 0.0, |part, m, v| {
                let mapped = if at_vertices(m.wetness) { self.scalar(at, part, m.wetness, v)? } else { None };
                Ok(self.joints.blend(skin(v), |t| t.wetness, mapped.unwrap_or(0.0)))
            })?,
            bareness: self.average(mesh, 0.0, |part, m, v| {
                let mapped = if at_vertices(m.bare) { self.scalar(at, part, m.bare, v)? } else { None };
                Ok(self.joints.blend(skin(v), |t| t.bare, mapped.unwrap_or(0.0)))
            })?,
        })
    }

    /// Returns the wetness of the furred materials.
    pub fn fur_wetness(&self) -> FurWetness {
        FurWetness::over(self.materials.iter().filter(|m| m.furred).map(|m| m.wetness), self.tables_of_joints)
    }

    /// Returns the colour map that replaces the model's colour on a material, if there is one.
    pub(super) fn color(&self, material: usize) -> Option<&ColorMap> {
        let furred = self.materials.get(material).filter(|m| m.furred)?;
        furred.color.or(self.plain.as_ref())
    }

    /// Returns the colour of the hair alone on a furred material, if the recipe sets one.
    pub(super) fn hair_color(&self, material: usize) -> Option<SrgbColor> {
        self.materials.get(material).filter(|m| m.furred)?.hair_color
    }

    /// Returns the decoded image with that path.
    pub(super) fn image(&self, path: &str) -> Result<&'a Image, BakeError> {
        self.images.get(path)
    }

    /// Combines the images of bareness and wetness into textures, one for each distinct pair of images.
    ///
    /// Fails with [`BakeError::Internal`] if an image was not read.
    pub fn textures(&self) -> Result<GroomTextures, BakeError> {
        let mut textures = GroomTextures::default();
        let mut known: Vec<(Option<&ScalarMap>, Option<&ScalarMap>)> = Vec::new();
        for m in &self.materials {
            let textured = m.furred && !self.over.at_vertices();
            let image = |map: &'a ScalarMap| Some(map).filter(|map| textured && map.image().is_some());
            let pair = (image(m.bare), image(m.wetness));
            if pair == (None, None) {
                textures.of_material.push(None);
                continue;
            }
            let index = known.iter().position(|k| *k == pair).unwrap_or(known.len());
            if index == known.len() {
                known.push(pair);
                textures.images.push(self.combined_image(pair.0, pair.1)?);
            }
            textures.of_material.push(Some(index));
        }
        Ok(textures)
    }

    /// Combines the maps of bareness and wetness into one image. Its width and height are those of the larger map.
    fn combined_image(&self, bare: Option<&ScalarMap>, wetness: Option<&ScalarMap>) -> Result<Image, BakeError> {
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

    /// Returns the mean of a value over the furred parts that contain a vertex, for each vertex. The value is `outside`
    /// if no furred part contains the vertex.
    fn average<T: Averaged>(
        &self,
        mesh: &Mesh,
        outside: T,
        each: impl Fn(&MeshPart, &MaterialMaps<'a>, usize) -> Result<T, BakeError>,
    ) -> Result<Vec<T>, BakeError> {
        let parts = self.furred_parts(mesh).map(|(part, maps)| (part, *maps));
        average(mesh, parts, outside, |part, maps, v| each(part, maps, v))
    }

    /// Returns the value of a map at vertex `v`; `None` if the map is an image that does not cover the vertex.
    fn scalar(&self, at: &Vertices<'_>, part: &MeshPart, map: &ScalarMap, v: usize) -> Result<Option<f32>, BakeError> {
        let ScalarMap::Image { path, channel } = map else { return scalar_at(self.images, at.mesh, part, map, v) };
        let read = |(texel, _): Texel| texel[channel.index()];
        Ok(self.over.read(self.images.get(path)?, Encoding::Linear, (at, part, v), &[], read))
    }

    /// Returns the direction of a map at vertex `v`; zero if the map is an image that does not cover the vertex. `axes`
    /// is as in [`ImageCoordinates::read`].
    fn vector(
        &self,
        at: &Vertices<'_>,
        part: &MeshPart,
        map: &VectorMap,
        v: usize,
        axes: &[[Vec3; 2]],
    ) -> Result<Vec3, BakeError> {
        let signed = |rgb: Vec3| rgb * 2.0 - 1.0;
        Ok(match map {
            VectorMap::Constant(direction) => Vec3::from(*direction),
            VectorMap::Vertex => {
                let [r, g, b, _] = at.mesh.colors[v].map(|byte| f32::from(byte) / 255.0);
                signed(Vec3::new(r, g, b))
            }
            VectorMap::Image { path, flow } => {
                let read = |(texel, [right, up]): Texel| {
                    let direction = signed(texel.truncate());
                    if *flow { right * direction.x + up * direction.y } else { direction }
                };
                let image = self.images.get(path)?;
                self.over.read(image, Encoding::Linear, (at, part, v), axes, read).unwrap_or_default()
            }
        })
    }

    /// Returns the colour of an image at vertex `v`, linear RGB, for images that are read at the vertices. Returns
    /// `None` if the image does not cover the vertex.
    pub(super) fn color_at(&self, image: &Image, at: &Vertices<'_>, part: &MeshPart, v: usize) -> Option<Vec3> {
        self.over.read(image, Encoding::Srgb, (at, part, v), &[], |(texel, _)| texel.truncate())
    }

    /// Whether images are read at the vertices only.
    pub(super) fn at_vertices(&self) -> bool {
        self.over.at_vertices()
    }
}

impl MaterialMaps<'_> {
    /// Returns the path of the first map that is an image.
    fn image(&self) -> Option<&str> {
        let scalars = [self.length, self.density, self.lean, self.wetness, self.bare];
        let vector = || self.comb.and_then(VectorMap::image);
        scalars.into_iter().find_map(ScalarMap::image).or_else(vector).or_else(|| self.color.and_then(ColorMap::image))
    }
}

/// Value that can be averaged.
pub(crate) trait Averaged: Copy + Default + std::ops::AddAssign + std::ops::Mul<f32, Output = Self> {}

impl<T: Copy + Default + std::ops::AddAssign + std::ops::Mul<f32, Output = T>> Averaged for T {}

/// Returns, for each vertex, the mean of `each` over those of `parts` that contain the vertex; `outside` if no part
/// does. Each part is paired with data that is passed on to `each`.
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

/// Returns the value of a map at a vertex; `None` if the map is an image and the part has no texture coordinates.
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

/// Returns the value from the last table that matches the material and has the key.
pub(crate) fn last<'a, M: NamedTable, T>(
    tables: &'a [M],
    material: &str,
    key: impl Fn(&'a M) -> Option<&'a T>,
) -> Option<&'a T> {
    tables.iter().rev().filter(|t| glob(t.table_name(), material)).find_map(key)
}

/// Reports tables whose name matches none of `names`; `key` is the recipe key of the tables.
///
/// * `what`: kind of things that the tables name, such as "material"
pub(crate) fn report_unmatched<'n, M: NamedTable>(
    key: &str,
    tables: &[M],
    what: &str,
    names: impl Iterator<Item = &'n str>,
    warnings: &mut Vec<String>,
) {
    let names: Vec<_> = names.collect();
    for table in tables.iter().filter(|t| !names.iter().any(|name| glob(t.table_name(), name))) {
        warnings.push(format!("{key}: {:?} matches no {what}; the model has {names:?}", table.table_name()));
    }
}

/// Returns the names of materials, in order.
pub(crate) fn names_of(materials: &[Material]) -> impl Iterator<Item = &str> + Clone {
    materials.iter().map(|material| material.name.as_str())
}

#[cfg(test)]
#[path = "maps_tests.rs"]
mod tests;
