//! Mesh of an opened package in one pose: the surface for strands, and a receiver and caster of shadows.

use super::curves::TILE_GROUP;
use crate::sample::{Encoding, Wrap, bilinear};
use crate::stages::slice::decode_texture;
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use pelage_formats::meaning::planting::{PlantingMesh, same_places};
use pelage_formats::meaning::{
    decode_bare_normal, groom_of_vertex, groom_with_texel, measured_vertices, posed_vertices, shown_vertices,
    tile_axes_f64,
};
use pelage_formats::{ClipLayer, FormatError, GeometryVertex, Gloss, Package, Pose, SkinVertex, stored_bare_normals};
use pelage_import::BakeError;
use pelage_import::mesh::Image;

/// Mesh in world space with its per-vertex data. Per-vertex lists are as long as [`PosedMesh::vertices`], and
/// per-triangle lists as long as [`PosedMesh::triangles`].
#[derive(Clone, Debug, Default)]
pub struct PosedMesh {
    /// Vertices. A position occurs once for each patch, part and seam that meets there.
    pub vertices: Vec<PosedVertex>,
    /// Positions in the pose at which lengths are measured ([`pelage_formats::meaning::measured_pose`]), metres.
    pub measured_ws: Vec<Vec3>,
    /// Index of the first vertex with the same position and motion, for each vertex.
    pub same_place: Vec<u32>,
    /// Vertex indices of the corners of each triangle, counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials` for each triangle.
    pub material_of: Vec<u32>,
    /// Materials used by the triangles.
    pub materials: Vec<PosedMaterial>,
}

/// Vertex of the posed mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PosedVertex {
    /// Position, world space, metres.
    pub position_ws: DVec3,
    /// Unit normal, pointing outwards.
    pub normal_ws: DVec3,
    /// Components along the tangent and the bitangent of the unit normal by which bare surface is lit.
    pub bare_normal: DVec2,
    /// Unit tangent along +u of the tile, perpendicular to the normal.
    pub tangent_ws: DVec3,
    /// Unit vector along +v of the tile.
    pub bitangent_ws: DVec3,
    /// Height of the outermost layer, metres; 0 where the mesh surface is bare.
    pub fur_height_m: f64,
    /// Lean of the hair in addition to that of the tile, 0..=1.
    pub lean: f64,
    /// Coordinates in the hair tile; 1 is one tile.
    pub tile_uv: DVec2,
    /// Coordinates in the model's own texture.
    pub base_uv: Vec2,
    /// Colour, linear RGBA, 0..=1.
    pub color: Vec4,
    /// Share of the hair that grows, and wetness; both 0..=1.
    pub groom: Vec2,
}

/// Material of the mesh.
#[derive(Clone, Debug, Default)]
pub struct PosedMaterial {
    /// Name in the model.
    pub name: String,
    /// Base colour, linear RGBA.
    pub base_color: Vec4,
    /// Colour of hair in place of the base colour, linear RGB.
    pub hair_color: Option<Vec3>,
    /// Image of the base colour, in the texture coordinates of the model.
    pub texture: Option<Image>,
    /// Image of the groom. Red: share of the hair that grows; green: wetness.
    pub groom: Option<Image>,
    /// Opacity below which the mesh surface is cut away.
    pub alpha_cutoff: Option<f32>,
    /// Gloss of bare surface; `None` for matt surface.
    pub gloss: Option<Gloss>,
    /// Whether hair grows on the material.
    pub furred: bool,
    /// Whether back faces are visible.
    pub double_sided: bool,
    /// Index of the fur's fibre in the list of the package.
    pub fibre: u8,
}

impl PosedVertex {
    /// Returns the unit normal by which bare surface is lit, in world space.
    pub fn bare_normal_ws(&self) -> DVec3 {
        let DVec2 { x, y } = self.bare_normal;
        self.tangent_ws * x + self.bitangent_ws * y + self.normal_ws * (1.0 - x * x - y * y).max(0.0).sqrt()
    }
}

impl PosedMesh {
    /// Reads the mesh of a package and poses it.
    ///
    /// * `file`: the package's name as the user gave it, for messages
    /// * `layers`: clips of the skeleton, as for [`Pose::blend`]; an empty list for the rest pose
    ///
    /// Fails with [`BakeError::Package`] for a damaged section.
    pub fn posed(file: &str, package: &Package<'_>, layers: &[ClipLayer]) -> Result<Self, BakeError> {
        Self::morphed(file, package, layers, &[])
    }

    /// Reads and poses the mesh like [`PosedMesh::posed`]. Morph target weights are given as for [`Pose::morph`].
    ///
    /// Fails like [`PosedMesh::posed`].
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
        let stored = shown_vertices(package, &mesh).map_err(fault)?;
        let stored = stored.iter().enumerate().map(|(i, v)| (v.position, moved_by(i)));
        let measured = measured_vertices(package, &mesh).map_err(fault)?;
        let measured_ws = measured.into_iter().map(|v| v.position.into()).collect();
        let mut out = Self { same_place: same_places(stored), measured_ws, ..Self::default() };
        let morphs = package.morphs().map_err(fault)?;
        let mut bare_normals = stored_bare_normals(package.bare_normals().map_err(fault)?.unwrap_or_default());
        for (posed, attributes) in posed_vertices(&mesh, morphs.as_deref(), &pose).zip(mesh.attributes()) {
            let share = |byte: u8| f32::from(byte) / 255.0;
            let bare = decode_bare_normal(bare_normals.next().unwrap_or_default());
            out.vertices.push(PosedVertex {
                tile_uv: Vec2::from(attributes.tile_uv).as_dvec2(),
                base_uv: attributes.base_uv.into(),
                color: Vec4::from(attributes.color.map(share)),
                groom: groom_of_vertex(attributes.groom),
                bare_normal: bare.truncate().as_dvec2(),
                ..point(&posed)
            });
        }
        let indices: Vec<u32> = mesh.indices().collect();
        out.triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        for part in &package.manifest().parts {
            out.material_of.extend(std::iter::repeat_n(part.material, part.index_count as usize / 3));
        }
        let fibres = package.fibres().map_err(fault)?;
        let gloss = package.gloss().map_err(fault)?;
        let hair_colors = package.hair_colors().map_err(fault)?;
        for (index, material) in package.manifest().materials.iter().enumerate() {
            let read = |view: Option<pelage_formats::TextureView<'_>>| {
                view.map(|view| {
                    let rgba = decode_texture(&view, 0, 0)?;
                    Ok::<_, BakeError>(Image { width: view.width, height: view.height, rgba })
                })
                .transpose()
            };
            out.materials.push(PosedMaterial {
                name: material.name.clone(),
                base_color: material.base_color.into(),
                hair_color: hair_colors.get(index).copied().flatten().map(Vec3::from),
                texture: read(package.base_color_texture(index).map_err(fault)?)?,
                groom: read(package.groom_texture(index).map_err(fault)?)?,
                alpha_cutoff: material.alpha_cutoff,
                gloss: gloss.get(index).copied().flatten(),
                furred: material.furred,
                double_sided: material.double_sided,
                fibre: fibres.as_ref().and_then(|info| info.of_materials.get(index)).copied().unwrap_or(0),
            });
        }
        Ok(out)
    }

    /// Returns the data of the mesh that planting needs.
    pub fn ground(&self) -> PlantingMesh {
        PlantingMesh {
            triangles: self.triangles.clone(),
            furred: (0..self.triangles.len()).map(|t| self.material(t).furred).collect(),
            positions: self.vertices.iter().map(|v| v.position_ws).collect(),
            tile_uv: self.vertices.iter().map(|v| v.tile_uv).collect(),
            same_place: self.same_place.clone(),
        }
    }

    /// Returns the corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [&PosedVertex; 3] {
        self.triangles[triangle].map(|v| &self.vertices[v as usize])
    }

    /// Returns the group name for strands of the tile with the given fibre. It contains the name of the first material
    /// with that fibre, unless the fibre is the default of the fur.
    pub fn fibre_group_name(&self, fibre: u8) -> String {
        match self.materials.iter().find(|material| material.furred && material.fibre == fibre) {
            Some(material) if fibre > 0 => format!("{TILE_GROUP}/{}", material.name),
            _ => TILE_GROUP.to_owned(),
        }
    }

    /// Returns the material of a triangle.
    pub fn material(&self, triangle: usize) -> &PosedMaterial {
        &self.materials[self.material_of[triangle] as usize]
    }

    /// Returns the base colour at a point of a triangle, linear RGBA.
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

    /// Returns the factor on the colour of hair on a triangle where the surface has the base colour `base`.
    pub fn hair_base(&self, triangle: usize, base: Vec4) -> Vec4 {
        self.material(triangle).hair_color.map_or(base, |color| color.extend(base.w))
    }

    /// Returns whether the mesh surface is cut away where the base colour has the opacity `alpha`.
    pub fn is_cut(&self, triangle: usize, alpha: f32) -> bool {
        self.material(triangle).alpha_cutoff.is_some_and(|cutoff| alpha < cutoff)
    }

    /// Returns the share of the hair that grows at a point of a triangle, and its wetness; both 0..=1.
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

/// Interpolates values at a point of a triangle from the values at its corners. `weights`: barycentric coordinates of
/// the point.
pub(super) fn mix<T>(weights: DVec3, corners: [T; 3]) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    let [a, b, c] = corners;
    a * weights.x as f32 + b * weights.y as f32 + c * weights.z as f32
}

fn point(v: &GeometryVertex) -> PosedVertex {
    let [x, y, z, handedness] = v.tangent;
    let normal = Vec3::from(v.normal).as_dvec3().normalize_or(DVec3::Y);
    let [tangent_ws, bitangent_ws] = tile_axes_f64(normal, Vec3::new(x, y, z).as_dvec3(), f64::from(handedness));
    PosedVertex {
        position_ws: Vec3::from(v.position).as_dvec3(),
        normal_ws: normal,
        tangent_ws,
        bitangent_ws,
        fur_height_m: f64::from(v.fur_height),
        lean: f64::from(v.lean),
        ..PosedVertex::default()
    }
}
