//! Texture coordinates of groom images, and sampling of the images at vertices.

use super::model_atlas::ModelAtlas;
use super::projection::{ImagePoint, Projection};
use crate::recipe::PatternProjection;
use crate::sample::{Encoding, Wrap, bilinear};
use crate::stages::surface::Surface;
use glam::{Vec3, Vec4};
use pelage_formats::Bounds;
use pelage_import::mesh::{Image, Mesh, MeshPart, RestPose};

/// Vertices at which a groom is evaluated: those of the model or of its laid-out surface.
#[derive(Clone, Copy, Debug)]
pub struct Vertices<'m> {
    /// Mesh of the vertices.
    pub mesh: &'m Mesh,
    /// Rest pose of the mesh.
    pub rest: &'m RestPose,
    /// Original vertex of the model for each vertex; `None` if the vertices are the model's own.
    pub input_vertex: Option<&'m [u32]>,
}

impl<'m> Vertices<'m> {
    /// Selects the vertices of the model itself.
    pub fn of_model(mesh: &'m Mesh, rest: &'m RestPose) -> Self {
        Self { mesh, rest, input_vertex: None }
    }

    /// Returns the model's vertex from which `v` originates.
    pub(super) fn input(&self, v: usize) -> usize {
        self.input_vertex.and_then(|input| input.get(v)).map_or(v, |input| *input as usize)
    }
}

impl<'m> From<&'m Surface> for Vertices<'m> {
    fn from(surface: &'m Surface) -> Self {
        Self { mesh: &surface.mesh, rest: &surface.rest, input_vertex: Some(&surface.input_vertex) }
    }
}

/// Texture coordinates of the images of a groom.
#[derive(Clone, Debug, Default)]
pub enum ImageCoordinates {
    /// The model's own texture coordinates.
    #[default]
    Model,
    /// Atlas of a model.
    Atlas(Box<ModelAtlas>),
    /// Projection through space. Each image is scaled to cover the model at rest exactly once.
    Space {
        /// Axis or axes of the projection.
        along: PatternProjection,
        /// Bounding box of the mesh at rest.
        bounds: Bounds,
    },
}

/// Sampled texel, with the unit directions on the surface or in space that point right and up on its image; zero if
/// unknown.
pub(super) type Texel = (Vec4, [Vec3; 2]);

impl ImageCoordinates {
    /// Whether images are read at vertices only. The runtime can sample images per texel only in the model's own
    /// coordinates.
    pub(super) fn at_vertices(&self) -> bool {
        !matches!(self, Self::Model)
    }

    /// Returns the mean of `read` over the points of an image that correspond to vertex `v`; `None` if the image does
    /// not cover the vertex.
    ///
    /// * `axes`: directions that point right and up on images in the model's own coordinates, one per vertex; may be
    ///   empty if `read` does not use them
    pub(super) fn read<T>(
        &self,
        image: &Image,
        encoding: Encoding,
        (at, part, v): (&Vertices<'_>, &MeshPart, usize),
        axes: &[[Vec3; 2]],
        read: impl Fn(Texel) -> T,
    ) -> Option<T>
    where
        T: Copy + Default + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T> + std::ops::Div<f32, Output = T>,
    {
        let texel = |uv, wrap, axes| read((bilinear(image, uv, wrap, encoding), axes));
        match self {
            Self::Model => {
                part.has_uvs.then(|| texel(at.mesh.uvs[v], Wrap::Repeat, axes.get(v).copied().unwrap_or_default()))
            }
            Self::Atlas(atlas) => {
                let vertices = atlas.standing_for(at.mesh, part.material, v);
                let each = |vertex: &u32| texel(atlas.uv(*vertex), Wrap::Repeat, atlas.axes(*vertex));
                let sum = vertices.iter().map(each).fold(T::default(), |sum, value| sum + value);
                (!vertices.is_empty()).then(|| sum * (vertices.len() as f32).recip())
            }
            Self::Space { along, bounds } => {
                let projection = Projection::new(*along, Wrap::Clamp, image, bounds, None);
                let (position, normal) = (at.rest.positions[v], at.rest.normals[v]);
                Some(projection.read(position, normal, |ImagePoint { uv, axes }| texel(uv, projection.wrap, axes)))
            }
        }
    }
}
