//! The model as `import` hands it on: one triangle mesh, its materials, images and motions.

use glam::{Mat3, Vec2, Vec3};
use pelage_formats::meaning::{skin_matrix, transform_normal};
use pelage_formats::{Animation, InputRecord, Pose, SkinVertex};

/// An imported model.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// All primitives of the scene in one mesh.
    pub mesh: Mesh,
    /// Materials; at least one where the mesh has a part.
    pub materials: Vec<Material>,
    /// Base-colour images that a material uses, decoded.
    pub images: Vec<Image>,
    /// Named nodes of the scene: joints, and what authors mark places with. Of an OBJ none.
    pub nodes: Vec<NamedPlace>,
    /// Where somebody drew into the model how its hair is combed. Of an OBJ none.
    pub combs: Vec<DrawnComb>,
    /// Skeleton and clips. Present where anything moves; then every vertex has an entry in [`Mesh::skin`].
    pub animation: Option<Animation>,
    /// What morph targets do to vertices, of a model whose [`Animation::morphs`] has some.
    pub morph_rows: MorphRows,
    /// The files that were read, in the order of reading.
    pub inputs: Vec<InputRecord>,
    /// What was repaired, left out or guessed.
    pub warnings: Vec<String>,
}

/// A place with a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedPlace {
    /// Not empty. Several may have the same.
    pub name: String,
    /// World space at rest, metres.
    pub position_ws: Vec3,
}

/// A line along which hair is combed, or one place of it that an empty node marks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnComb {
    /// Name of its node or mesh.
    pub name: String,
    /// Places in the order of the line with the direction there, world space at rest, metres; at least one, directions of unit length.
    pub places: Vec<(Vec3, Vec3)>,
}

/// A triangle mesh as separate streams, one entry per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions: mesh space where `skin` is not empty, else world space.
    pub positions: Vec<Vec3>,
    /// Unit normals in the same space, outward.
    pub normals: Vec<Vec3>,
    /// The model's texture coordinates; zero in parts without.
    pub uvs: Vec<Vec2>,
    /// Vertex colours, linear RGBA 0..=255; white in parts without.
    pub colors: Vec<[u8; 4]>,
    /// Joints and weights (normalised), or empty.
    pub skin: Vec<SkinVertex>,
    /// What morph targets do to each vertex: index into [`MorphRows`]. Empty where there are none.
    pub morph_rows: Vec<u32>,
    /// Corner indices, counter-clockwise seen from outside in the posed rest state.
    pub triangles: Vec<[u32; 3]>,
    /// Runs of triangles with one material, covering `triangles` in order.
    pub parts: Vec<MeshPart>,
}

impl Mesh {
    /// Copies vertex `v` to the end of all streams and returns the copy's number.
    pub fn copy_vertex(&mut self, v: usize) -> u32 {
        self.positions.push(self.positions[v]);
        self.normals.push(self.normals[v]);
        self.uvs.push(self.uvs[v]);
        self.colors.push(self.colors[v]);
        self.skin.extend(self.skin.get(v).copied());
        self.morph_rows.extend(self.morph_rows.get(v).copied());
        self.positions.len() as u32 - 1
    }
}

/// What morph targets do to vertices: many vertices may share a row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphRows(pub Vec<Vec<RowDelta>>);

/// What a morph target of weight 1 adds to a vertex that it finds at weight 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowDelta {
    /// Index into the targets of [`Animation::morphs`].
    pub target: u32,
    /// In mesh space.
    pub position: Vec3,
    /// To a normal of unit length; `None` where the file does not say.
    pub normal: Option<Vec3>,
}

/// A run of triangles that came from one primitive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshPart {
    /// Where it stands in the input, for messages: `mesh 0 "body", primitive 1`.
    pub source: String,
    /// Names of the node and the mesh that it belongs to, of an OBJ those of its object and group. Empty names are left out.
    pub names: Vec<String>,
    /// Index into [`Model::materials`].
    pub material: usize,
    /// First triangle.
    pub first_triangle: usize,
    /// Number of triangles.
    pub triangle_count: usize,
    /// Whether the primitive has texture coordinates.
    pub has_uvs: bool,
}

/// What `import` keeps of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, may be empty.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    /// Index into [`Model::images`].
    pub base_color_image: Option<usize>,
    /// Alpha below which the skin is cut away (glTF `MASK`).
    pub alpha_cutoff: Option<f32>,
    /// Whether back faces show.
    pub double_sided: bool,
    /// How rough it is, 0 a mirror to 1 dull (glTF `roughnessFactor`). `None` where the file does not say it in one number.
    pub roughness: Option<f32>,
    /// How metallic it is, 0..=1 (glTF `metallicFactor`), likewise.
    pub metallic: Option<f32>,
    /// What of the file's material this is; `None` is all of it, or the rest.
    pub feature: Option<Feature>,
}

/// A part of a body where no hair grows, which shares its material with other parts or whose material's name does not tell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Feature {
    /// The tip of the nose.
    Nose,
    /// What is painted around the eyes, between lids and eyeballs.
    EyeRims,
    /// Claws.
    Claws,
    /// What a node or a mesh of that name shows.
    Named(String),
}

impl Feature {
    /// Its name behind that of the material.
    pub fn name(&self) -> &str {
        match self {
            Self::Nose => "nose",
            Self::EyeRims => "eye rims",
            Self::Claws => "claws",
            Self::Named(name) => name,
        }
    }
}

impl Material {
    /// Its name, and behind a slash that of its feature: `Black/nose`.
    pub fn full_name(&self) -> String {
        self.feature.as_ref().map_or_else(|| self.name.clone(), |feature| format!("{}/{}", self.name, feature.name()))
    }
}

impl Default for Material {
    /// White, opaque, one-sided, without a name: what glTF says of a primitive that names no material.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_image: None,
            alpha_cutoff: None,
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
    /// `width * height` RGBA8 texels, straight alpha, row-major from the top; colours are sRGB-encoded.
    pub rgba: Vec<u8>,
}

/// Positions and normals in world space at rest: no clip playing. All lengths of a bake are judged here, in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RestPose {
    /// One per vertex.
    pub positions: Vec<Vec3>,
    /// One per vertex, unit length.
    pub normals: Vec<Vec3>,
}

impl RestPose {
    /// Poses `mesh` with its skeleton at rest.
    pub fn of(mesh: &Mesh, animation: Option<&Animation>) -> Self {
        let Some(animation) = animation.filter(|_| !mesh.skin.is_empty()) else {
            return Self { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
        };
        let mut pose = Pose::default();
        pose.sample(animation, None, 0.0);
        Self::posed(mesh, &pose)
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
