//! Output of `import`: one triangle mesh, with its materials, images and animation.

use glam::{Mat3, Vec2, Vec3};
use pelage_formats::meaning::{measured_pose, skin_matrix, transform_normal};
use pelage_formats::{Animation, InputRecord, Pose, SkinVertex};
use std::sync::Arc;

/// An imported model.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// All primitives of the scene in one mesh.
    pub mesh: Mesh,
    /// Materials; at least one if the mesh has a part.
    pub materials: Vec<Material>,
    /// Decoded base-colour images that the materials use.
    pub images: Vec<Arc<Image>>,
    /// Named nodes of the scene: joints and authors' markers. Empty for an OBJ.
    pub nodes: Vec<NamedPosition>,
    /// Comb lines and comb markers drawn in the model. Empty for an OBJ.
    pub combs: Vec<CombLine>,
    /// Skeleton and clips; `None` if nothing moves. If present, every vertex has an entry in [`Mesh::skin`].
    pub animation: Option<Animation>,
    /// Morph target deltas of the vertices; empty if [`Animation::morphs`] has no targets.
    pub morph_rows: MorphRows,
    /// Files that were read, in the order of reading.
    pub inputs: Vec<InputRecord>,
    /// Warnings: repairs, omissions and guesses.
    pub warnings: Vec<String>,
}

/// A named position.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedPosition {
    /// Name, not empty, not necessarily unique.
    pub name: String,
    /// Position in world space at rest, metres.
    pub position_ws: Vec3,
}

/// A line along which hair is combed; or a single position and direction, given by an empty node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CombLine {
    /// Name of the node or mesh.
    pub name: String,
    /// Positions along the line, at least one, each with the unit comb direction there. World space at rest, metres.
    pub places: Vec<(Vec3, Vec3)>,
}

/// A triangle mesh as separate streams, one entry per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions: in mesh space if `skin` is not empty, else in world space.
    pub positions: Vec<Vec3>,
    /// Unit normals, outward, in the space of `positions`.
    pub normals: Vec<Vec3>,
    /// Unit normals by which bare surface is lit, where hair stands along others. Empty if they are `normals`.
    pub bare_normals: Vec<Vec3>,
    /// Texture coordinates of the model; zero in parts without any.
    pub uvs: Vec<Vec2>,
    /// Vertex colours, linear RGBA 0..=255; white in parts without any.
    pub colors: Vec<[u8; 4]>,
    /// Joints and normalised weights; empty if nothing moves.
    pub skin: Vec<SkinVertex>,
    /// Row of each vertex in [`MorphRows`]. Empty without morph targets.
    pub morph_rows: Vec<u32>,
    /// Corner indices of each triangle, counter-clockwise seen from outside, in the rest pose.
    pub triangles: Vec<[u32; 3]>,
    /// Ranges of triangles with one material, covering `triangles` in order.
    pub parts: Vec<MeshPart>,
}

impl Mesh {
    /// Copies vertex `v` to the end of all streams and returns the index of the copy.
    pub fn copy_vertex(&mut self, v: usize) -> u32 {
        self.positions.push(self.positions[v]);
        self.normals.push(self.normals[v]);
        self.bare_normals.extend(self.bare_normals.get(v).copied());
        self.uvs.push(self.uvs[v]);
        self.colors.push(self.colors[v]);
        self.skin.extend(self.skin.get(v).copied());
        self.morph_rows.extend(self.morph_rows.get(v).copied());
        self.positions.len() as u32 - 1
    }
}

/// Rows of morph target deltas; many vertices may share a row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphRows(pub Vec<Vec<RowDelta>>);

/// Delta that a morph target adds to a vertex at weight 1. At rest the delta is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowDelta {
    /// Index into the targets of [`Animation::morphs`].
    pub target: u32,
    /// Delta of the position, in mesh space.
    pub position: Vec3,
    /// Delta of a unit normal; `None` if the file has none.
    pub normal: Option<Vec3>,
    /// Position where the vertex is hidden at rest, if a clip shows it by this target; else `None`. The mesh has the
    /// vertex where the first of these targets shows it.
    pub hidden_at: Option<Vec3>,
}

/// A range of triangles that came from one primitive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshPart {
    /// Location in the input, for messages: `mesh 0 "body", primitive 1`.
    pub source: String,
    /// Names of the part's node and mesh (OBJ: object and group); empty names are omitted.
    pub names: Vec<String>,
    /// Index into [`Model::materials`].
    pub material: usize,
    /// Index of the first triangle.
    pub first_triangle: usize,
    /// Number of triangles.
    pub triangle_count: usize,
    /// Whether the primitive has texture coordinates.
    pub has_uvs: bool,
}

/// Material properties that `import` reads.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, possibly empty.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    /// Index into [`Model::images`].
    pub base_color_image: Option<usize>,
    /// Alpha below which the surface is cut away (glTF `MASK`).
    pub alpha_cutoff: Option<f32>,
    /// Whether alpha mixes the surface with what is behind it (glTF `BLEND`). Such a surface is drawn opaque, and clear
    /// texels take the colour of visible ones.
    pub blends: bool,
    /// Whether back faces are visible.
    pub double_sided: bool,
    /// Roughness, 0 (mirror) to 1 (dull), glTF `roughnessFactor`. `None` if the file does not give a single number.
    pub roughness: Option<f32>,
    /// Metalness, 0..=1 (glTF `metallicFactor`). `None` if the file does not give a single number.
    pub metallic: Option<f32>,
    /// Feature for which this material was split off from a material of the file. `None` if it covers all of that
    /// material, or what remains after splitting.
    pub feature: Option<Feature>,
}

/// A hairless feature of a body, which shares its material with other parts or has a material whose name does not
/// identify it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Feature {
    /// The tip of the nose.
    Nose,
    /// Painted area around the eyes, between lids and eyeballs.
    EyeRims,
    /// Claws.
    Claws,
    /// Pairs of small dark patches or balls in the face, and what they enclose.
    Eyes,
    /// Connected components inside the head: eyeballs, teeth and tongue.
    InHead,
    /// Surface shown by a node or mesh with this name.
    Named(String),
    /// Surface that follows a joint with this name.
    Joint(String),
}

impl Feature {
    /// Returns the suffix of the material's name that identifies the feature.
    pub fn name(&self) -> &str {
        match self {
            Self::Nose => "nose",
            Self::EyeRims => "eye rims",
            Self::Claws => "claws",
            Self::Eyes => "eyes",
            Self::InHead => "in the head",
            Self::Named(name) | Self::Joint(name) => name,
        }
    }
}

impl Material {
    /// Returns the material's name. A feature is appended after a slash: `Black/nose`.
    pub fn full_name(&self) -> String {
        self.feature.as_ref().map_or_else(|| self.name.clone(), |feature| format!("{}/{}", self.name, feature.name()))
    }
}

impl Default for Material {
    /// Returns a white, opaque, one-sided material without a name: glTF's default for a primitive without material.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_image: None,
            alpha_cutoff: None,
            blends: false,
            double_sided: false,
            roughness: None,
            metallic: None,
            feature: None,
        }
    }
}

/// A decoded image of a model or a recipe.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Width, texels.
    pub width: u32,
    /// Height, texels.
    pub height: u32,
    /// Pixels: `width * height` RGBA8 texels, straight alpha, row-major from the top. Colours are sRGB-encoded.
    pub rgba: Vec<u8>,
}

/// Positions and normals in world space at rest, with no clip playing. All lengths of a bake refer to this pose, in
/// metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RestPose {
    /// Positions, one per vertex.
    pub positions: Vec<Vec3>,
    /// Unit normals, one per vertex.
    pub normals: Vec<Vec3>,
}

impl RestPose {
    /// Poses `mesh` with its skeleton at rest.
    pub fn of(mesh: &Mesh, animation: Option<&Animation>) -> Self {
        let Some(animation) = animation.filter(|_| !mesh.skin.is_empty()) else {
            return Self { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
        };
        Self::posed(mesh, &Self::pose(animation))
    }

    /// Returns the skeleton's pose at rest. Nodes that are hidden at rest by a scale of zero have the largest scale
    /// that they reach in any clip, so that hair fits them where they are visible.
    pub fn pose(animation: &Animation) -> Pose {
        measured_pose(animation)
    }

    /// Poses a skinned `mesh`: the CPU twin of the runtime's `pose` pass.
    pub fn posed(mesh: &Mesh, pose: &Pose) -> Self {
        let mut rest = Self::default();
        for ((position, normal), skin) in mesh.positions.iter().zip(&mesh.normals).zip(&mesh.skin) {
            let matrix = skin_matrix(pose, skin);
            rest.positions.push(matrix.transform_point3(*position));
            rest.normals.push(transform_normal(Mat3::from_mat4(matrix), *normal));
        }
        rest
    }
}
