//! What became of each pass of a frame, and of the fur of each instance.

/// Which passes ran, and why the others did not.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FrameReport {
    /// One entry per pass, in order.
    pub passes: Vec<PassReport>,
    /// One entry per instance, in the order given.
    pub instances: Vec<InstanceDetail>,
    /// Whether hair moves by itself: the next moment has another picture, although nobody moves anything.
    pub hair_moves: bool,
    /// What had to be made for the frame.
    pub created: Created,
    /// Bytes of uniforms and storage that the queue was given: none where all is as in a frame before.
    pub uploaded_bytes: u64,
    /// Bytes on the GPU of the textures of the picture's size that the passes hand on, and of the lists of its pixels where strands have blended
    /// edges. The renderer keeps them for the next frames of the same size.
    pub target_bytes: u64,
}

/// What became of one pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassReport {
    /// Name of the pass: [`crate::PassId::name`].
    pub name: &'static str,
    /// Whether it does anything in this frame.
    pub ran: bool,
    /// What it does, or why nothing.
    pub reason: String,
}

/// How many objects of the device a frame had to make: none where nothing is new since the frames before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Created {
    /// Buffers.
    pub buffers: u32,
    /// Textures.
    pub textures: u32,
    /// Bind groups.
    pub bind_groups: u32,
    /// Pipelines.
    pub pipelines: u32,
}

impl Created {
    /// What was made between two counts.
    pub(crate) fn since(self, before: Self) -> Self {
        Self {
            buffers: self.buffers - before.buffers,
            textures: self.textures - before.textures,
            bind_groups: self.bind_groups - before.bind_groups,
            pipelines: self.pipelines - before.pipelines,
        }
    }
}

/// What is drawn of an instance's fur.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InstanceDetail {
    /// Whether any of it can be in the picture. What cannot be is not drawn, and throws its shadow all the same.
    pub in_picture: bool,
    /// Index into the package's levels of detail.
    pub level: u32,
    /// How far it has faded to the next level, 0..1.
    pub fade: f32,
    /// Layers that are drawn, the skin not counted; 0 where single strands are in their place.
    pub layers: u32,
    /// Layers that the package has, the skin not counted.
    pub of_layers: u32,
    /// Triangles of the index list that is drawn: the mesh's own, or one of those that the package simplified.
    pub triangles: u32,
    /// Share of the fins' opacity, 0..=1.
    pub fins: f32,
    /// How far the far coat has taken over, 0..=1.
    pub coat: f32,
    /// Share of the coat's single strands that is drawn, 0..=1; where it has none, of the first group of hair on guides. Layers are as well while `layers` is not 0: they fade when all strands are there.
    pub strands: f32,
    /// Straight pieces that each single strand is drawn in: fewer where it is small on screen; 0 where none is drawn.
    pub strand_pieces: u32,
    /// Height of the fur on screen, pixels, at the nearest point of the model; `None` where nothing depends on it. Infinite where the eye is
    /// within the model's bounds.
    pub fur_px: Option<f32>,
}
