//! Report of a frame: its passes, and the fur of each instance.

/// Report of a frame: which passes ran, and why the others did not.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FrameReport {
    /// Report of each pass, in order.
    pub passes: Vec<PassReport>,
    /// Level of detail of each instance, in the order in which the instances were given.
    pub instances: Vec<InstanceDetail>,
    /// Whether hair is still moving. If so, a frame at a later time differs even if nothing else changes.
    pub hair_moves: bool,
    /// Number of GPU objects that were created for the frame.
    pub created: CreatedObjects,
    /// Bytes of uniforms and storage that were uploaded; 0 if nothing has changed since an earlier frame.
    pub uploaded_bytes: u64,
    /// Bytes in GPU memory of the textures of the picture's size that passes share, and of the per-pixel lists for
    /// blended strand edges. The renderer keeps them for later frames of the same size.
    pub target_bytes: u64,
}

/// Report of a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassReport {
    /// Name of the pass: [`crate::PassId::name`].
    pub name: &'static str,
    /// Whether the pass had work in this frame.
    pub ran: bool,
    /// Description of what the pass did, or the reason why it was skipped.
    pub reason: String,
}

/// Number of GPU objects created for a frame; all 0 if nothing is new since earlier frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CreatedObjects {
    /// Number of buffers.
    pub buffers: u32,
    /// Number of textures.
    pub textures: u32,
    /// Number of bind groups.
    pub bind_groups: u32,
    /// Number of pipelines.
    pub pipelines: u32,
}

impl CreatedObjects {
    /// Returns the number of objects created since the count `before`.
    pub(crate) fn since(self, before: Self) -> Self {
        Self {
            buffers: self.buffers - before.buffers,
            textures: self.textures - before.textures,
            bind_groups: self.bind_groups - before.bind_groups,
            pipelines: self.pipelines - before.pipelines,
        }
    }
}

/// Level of detail of an instance's fur, as drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InstanceDetail {
    /// Whether any part of the instance may be in the picture. Otherwise it is not drawn, but still casts its shadow.
    pub in_picture: bool,
    /// Index into the package's levels of detail.
    pub level: u32,
    /// Progress of the fade to the next level, 0..1.
    pub fade: f32,
    /// Number of drawn layers, skin excluded; 0 if single strands replace them.
    pub layers: u32,
    /// Number of layers in the package, skin excluded.
    pub of_layers: u32,
    /// Triangle count of the drawn index list: that of the mesh, or a simplified one of the package.
    pub triangles: u32,
    /// Factor on the opacity of fins, 0..=1.
    pub fins: f32,
    /// Progress of the transition to the far fur layer, 0..=1.
    pub coat: f32,
    /// Share of single fur strands that are drawn, 0..=1. If the model has none: share of the first group of guided
    /// hair. Layers are also drawn while `layers` is not 0: they fade after all strands have appeared.
    pub strands: f32,
    /// Number of segments per strand, reduced if the hair is small on screen; 0 if no strands are drawn.
    pub strand_pieces: u32,
    /// Height of the fur on screen at the nearest point of the model, pixels; `None` if the detail does not depend on
    /// it. Infinite if the eye is within the model's bounds.
    pub fur_px: Option<f32>,
}
