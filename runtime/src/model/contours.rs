//! Contour mesh of a package, in GPU memory.

use super::ink::stored_diagonal;
use super::upload::Uploader;
use crate::error::RuntimeError;
use crate::gpu::largest_buffer;
use pelage_formats::{CreasePoint, MeshView, Package};

/// Contour mesh of a model.
#[derive(Debug)]
pub(crate) struct ModelContours {
    /// Buffer of words: edges, faces, crease points, their predecessors, and marks.
    pub(crate) mesh: wgpu::Buffer,
    pub(crate) edges: u32,
    pub(crate) faces: u32,
    pub(crate) creases: u32,
    /// Maximum number of crossed edges in a frame.
    pub(crate) most_nodes: u32,
    /// Diagonal of the stored mesh, in its own unit. With a skeleton, that unit need not be the metre.
    pub(crate) stored_diagonal: f32,
}

impl ModelContours {
    /// Returns the positions of faces, crease points, predecessors and marks in the buffer, words.
    pub(crate) fn layout(&self) -> [u32; 4] {
        let faces = 2 * self.edges;
        let creases = faces + 4 * self.faces;
        let previous = creases + 4 * self.creases;
        [faces, creases, previous, previous + self.creases]
    }

    /// Returns the maximum number of nodes in a frame.
    pub(crate) fn capacity(&self) -> u32 {
        self.creases + self.most_nodes
    }
}

/// Uploads the contour mesh; `None` for a package without one, or with one too large for the device.
pub(super) fn load(
    uploader: &Uploader<'_>,
    package: &Package<'_>,
    mesh: &MeshView<'_>,
) -> Result<Option<ModelContours>, RuntimeError> {
    let Some(view) = package.contours()?.filter(|view| view.faces().len() > 0) else { return Ok(None) };
    let mut previous = vec![CreasePoint::NONE; view.creases().len()];
    for (i, point) in view.creases().enumerate() {
        if let Some(next) = previous.get_mut(point.next as usize) {
            *next = i as u32;
        }
    }
    let words = [view.edges, view.faces, view.creases, bytemuck::cast_slice(&previous), view.marks].concat();
    if words.len() as u64 > largest_buffer(&uploader.gpu.device.limits()) {
        return Ok(None);
    }
    let count = |n: usize| n as u32;
    Ok(Some(ModelContours {
        mesh: uploader.buffer("contour mesh", &words, wgpu::BufferUsages::STORAGE)?,
        edges: count(view.edges().len()),
        faces: count(view.faces().len()),
        creases: count(view.creases().len()),
        most_nodes: view.most_nodes,
        stored_diagonal: stored_diagonal(mesh),
    }))
}
