//! The skin of an opened package in one pose: what strands stand on and what they throw shadows on.

use super::curves::COAT;
use crate::sample::{Encoding, Wrap, bilinear};
use crate::stages::textures::decode_texture;
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use pelage_formats::meaning::planting::{Ground, same_places};
use pelage_formats::meaning::{groom_of_vertex, groom_with_texel, posed_vertices, tile_axes_f64};
use pelage_formats::{ClipLayer, FormatError, GeometryVertex, Package, Pose, SkinVertex};
use pelage_import::BakeError;
use pelage_import::mesh::Image;

/// A mesh in world space with all that varies over it. Lists of vertices are as long as [`Skin::vertices`], of triangles as [`Skin::triangles`].
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Vertices; the same place stands here once for each patch, part and seam that meets there.
    pub vertices: Vec<SkinPoint>,
    /// For each vertex the first one at the same place that moves alike.
    pub same_place: Vec<u32>,
    /// Corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle an index into `materials`.
    pub material_of: Vec<u32>,
    /// What the triangles are made of.
    pub materials: Vec<SkinMaterial>,
}

/// A vertex of the posed skin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkinPoint {
    /// World space, metres.
    pub position_ws: DVec3,
    /// Unit length, outward.
    pub normal_ws: DVec3,
    /// Unit length, along +u of the tile, perpendicular to the normal.
    pub tangent_ws: DVec3,
    /// Unit length, along +v.
    pub bitangent_ws: DVec3,
    /// Height of the outermost layer, metres; 0 where the skin is bare.
    pub fur_height_m: f64,
    /// Extra lean, 0..=1.
    pub lean: f64,
    /// Hair tile, 1 a tile.
    pub tile_uv: DVec2,
    /// The model's own texture.
    pub base_uv: Vec2,
    /// Linear RGBA, 0..=1.
    pub color: Vec4,
    /// Share of the hair that grows, wetness; 0..=1.
    pub groom: Vec2,
}

/// A material of the skin.
#[derive(Clone, Debug, Default)]
pub struct SkinMaterial {
    /// Name in the model.
    pub name: String,
    /// Linear RGBA.
    pub base_color: Vec4,
    /// Base colour in the model's texture coordinates.
    pub texture: Option<Image>,
    /// Red: share of the hair that grows; green: wetness.
    pub groom: Option<Image>,
    /// Opacity below which the skin is cut away.
    pub alpha_cutoff: Option<f32>,
    /// Whether hair grows on it.
    pub furred: bool,
    /// Whether back faces show.
    pub double_sided: bool,
    /// Which of the package's fibres its coat is.
    pub fibre: u8,
}

impl Skin {
    /// Reads the mesh of a package and poses it.
    ///
    /// * `file`: the package as the user named it, for messages
    /// * `layers`: what its skeleton does, as [`Pose::blend`] takes it; none for the rest pose
    ///
    /// # Errors
    /// [`BakeError::Package`] for a damaged section.
    pub fn posed(file: &str, package: &Package<'_>, layers: &[ClipLayer]) -> Result<Self, BakeError> {
        Self::morphed(file, package, layers, &[])
    }

    /// The same with morph targets at weights of the caller's, as [`Pose::morph`] takes them.
    ///
    /// # Errors
    /// As [`Skin::posed`].
    pub fn morphed(
        file: &str,
        package: &Package<'_>,
        layers: &[ClipLayer],
        weights: &[(usize, f32)],
    ) -> Result<Self, BakeError> {
        let fault = |source: FormatError| BakeError::Package { file: file.to_owned(), source };
        let Some(mesh) = package.mesh().map_err(fault)? else { return Ok(Self::default()) };
        let mut pose = Pose::default();
        if let Some(animation) = package.animation().map_err(fault)? {
            pose.blend(&animation, layers);
            pose.morph(&animation, weights);
        }
        let skin: Vec<SkinVertex> = mesh.skin().collect();
        let moved_by = |i: usize| skin.get(i).map(|v| (v.joints, v.weights));
        let stored = mesh.geometry().enumerate().map(|(i, v)| (v.position, moved_by(i)));
        let mut out = Self { same_place: same_places(stored), ..Self::default() };
        let morphs = package.morphs().map_err(fault)?;
        for (posed, attributes) in posed_vertices(&mesh, morphs.as_deref(), &pose).zip(mesh.attributes()) {
            let share = |byte: u8| f32::from(byte) / 255.0;
            out.vertices.push(SkinPoint {
                tile_uv: Vec2::from(attributes.tile_uv).as_dvec2(),
                base_uv: attributes.base_uv.into(),
                color: Vec4::from(attributes.color.map(share)),
                groom: groom_of_vertex(attributes.groom),
                ..point(&posed)
            });
        }
        let indices: Vec<u32> = mesh.indices().collect();
        out.triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        for part in &package.manifest().parts {
            out.material_of.extend(std::iter::repeat_n(part.material, part.index_count as usize / 3));
        }
        let fibres = package.fibres().map_err(fault)?;
        for (index, material) in package.manifest().materials.iter().enumerate() {
            let read = |view: Option<pelage_formats::TextureView<'_>>| {
                view.map(|view| {
                    let rgba = decode_texture(&view, 0, 0)?;
                    Ok::<_, BakeError>(Image { width: view.width, height: view.height, rgba })
                })
                .transpose()
            };
            out.materials.push(SkinMaterial {
                name: material.name.clone(),
                base_color: material.base_color.into(),
                texture: read(package.base_color_texture(index).map_err(fault)?)?,
                groom: read(package.groom_texture(index).map_err(fault)?)?,
                alpha_cutoff: material.alpha_cutoff,
                furred: material.furred,
                double_sided: material.double_sided,
                fibre: fibres.as_ref().and_then(|info| info.of_materials.get(index)).copied().unwrap_or(0),
            });
        }
        Ok(out)
    }

    /// What planting asks of it.
    pub fn ground(&self) -> Ground {
        Ground {
            triangles: self.triangles.clone(),
            furred: (0..self.triangles.len()).map(|t| self.material(t).furred).collect(),
            positions: self.vertices.iter().map(|v| v.position_ws).collect(),
            tile_uv: self.vertices.iter().map(|v| v.tile_uv).collect(),
            same_place: self.same_place.clone(),
        }
    }

    /// Corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [&SkinPoint; 3] {
        self.triangles[triangle].map(|v| &self.vertices[v as usize])
    }

    /// Name of the group that coat strands of that fibre are: by the first material that has it, where it is not the coat's own.
    pub fn coat_of(&self, fibre: u8) -> String {
        match self.materials.iter().find(|material| material.furred && material.fibre == fibre) {
            Some(material) if fibre > 0 => format!("{COAT}/{}", material.name),
            _ => COAT.to_owned(),
        }
    }

    /// The material of a triangle.
    pub fn material(&self, triangle: usize) -> &SkinMaterial {
        &self.materials[self.material_of[triangle] as usize]
    }

    /// Linear RGBA of the skin at a point of a triangle.
    pub fn base_color(&self, triangle: usize, weights: DVec3) -> Vec4 {
        let (corners, material) = (self.corners(triangle), self.material(triangle));
        let tint = mix(weights, corners.map(|c| c.color)) * material.base_color;
        match &material.texture {
            Some(image) => {
                tint * bilinear(image, mix(weights, corners.map(|c| c.base_uv)), Wrap::Repeat, Encoding::Srgb)
            }
            None => tint,
        }
    }

    /// Whether the skin is cut away where its base colour has that opacity.
    pub fn is_cut(&self, triangle: usize, alpha: f32) -> bool {
        self.material(triangle).alpha_cutoff.is_some_and(|cutoff| alpha < cutoff)
    }

    /// Share of the hair that grows at a point of a triangle, and its wetness; both 0..=1.
    pub fn groom(&self, triangle: usize, weights: DVec3) -> Vec2 {
        let corners = self.corners(triangle);
        let groom = mix(weights, corners.map(|c| c.groom));
        match &self.material(triangle).groom {
            Some(image) => {
                let uv = mix(weights, corners.map(|c| c.base_uv));
                let texel = bilinear(image, uv, Wrap::Repeat, Encoding::Linear);
                groom_with_texel(groom, texel.truncate().truncate())
            }
            None => groom,
        }
    }
}

/// A value at a point of a triangle from those at its corners.
pub(super) fn mix<T>(weights: DVec3, corners: [T; 3]) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    let [a, b, c] = corners;
    a * weights.x as f32 + b * weights.y as f32 + c * weights.z as f32
}

fn point(v: &GeometryVertex) -> SkinPoint {
    let [x, y, z, handedness] = v.tangent;
    let normal = Vec3::from(v.normal).as_dvec3().normalize_or(DVec3::Y);
    let [tangent_ws, bitangent_ws] = tile_axes_f64(normal, Vec3::new(x, y, z).as_dvec3(), f64::from(handedness));
    SkinPoint {
        position_ws: Vec3::from(v.position).as_dvec3(),
        normal_ws: normal,
        tangent_ws,
        bitangent_ws,
        fur_height_m: f64::from(v.fur_height),
        lean: f64::from(v.lean),
        ..SkinPoint::default()
    }
}
