//! What the images of a groom lie over, and how a vertex reads them.

use super::model_atlas::ModelAtlas;
use super::projection::{OnImage, Projection};
use crate::recipe::PatternProjection;
use crate::sample::{Encoding, Wrap, bilinear};
use crate::stages::surface::Surface;
use glam::{Vec3, Vec4};
use pelage_formats::Bounds;
use pelage_import::mesh::{Image, Mesh, MeshPart, RestPose};

/// Vertices that a groom is evaluated at: the model's, or those of its surface.
#[derive(Clone, Copy, Debug)]
pub struct Vertices<'m> {
    /// The mesh that they are of.
    pub mesh: &'m Mesh,
    /// Its rest pose.
    pub rest: &'m RestPose,
    /// For each of them the vertex of the model that it came from; `None` where they are the model's.
    pub input_vertex: Option<&'m [u32]>,
}

impl<'m> Vertices<'m> {
    /// A model's own.
    pub fn of_model(mesh: &'m Mesh, rest: &'m RestPose) -> Self {
        Self { mesh, rest, input_vertex: None }
    }

    /// The vertex of the model that `v` came from.
    pub(super) fn input(&self, v: usize) -> usize {
        self.input_vertex.and_then(|input| input.get(v)).map_or(v, |input| *input as usize)
    }
}

impl<'m> From<&'m Surface> for Vertices<'m> {
    fn from(surface: &'m Surface) -> Self {
        Self { mesh: &surface.mesh, rest: &surface.rest, input_vertex: Some(&surface.input_vertex) }
    }
}

/// What the images of a groom lie over.
#[derive(Clone, Debug, Default)]
pub enum Over {
    /// The model's own texture coordinates.
    #[default]
    Model,
    /// An atlas of the model.
    Atlas(Box<ModelAtlas>),
    /// Space: each image is laid through the model at rest, which it spans once.
    Space {
        /// Which way.
        along: PatternProjection,
        /// Box about the skin at rest.
        bounds: Bounds,
    },
}

/// A texel, with the unit directions on the skin or in space that point right and up on its image; zero where that is not known.
pub(super) type Texel = (Vec4, [Vec3; 2]);

impl Over {
    /// Whether images are read at vertices alone: the runtime, which could follow them texel by texel, knows the model's own coordinates only.
    pub(super) fn at_vertices(&self) -> bool {
        !matches!(self, Self::Model)
    }

    /// The mean of what `read` makes of an image's texels where it lies on vertex `v`; `None` where it does not reach.
    ///
    /// * `axes`: one per vertex, what points right and up on the model's own coordinates; may be empty where `read` does not ask
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
                Some(projection.read(position, normal, |OnImage { uv, axes }| texel(uv, projection.wrap, axes)))
            }
        }
    }
}
