//! View of a package, and the predicted figures.

use glam::Vec3;
use serde::Serialize;

/// View for which a package is diagnosed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position of the eye, metres.
    pub eye: Vec3,
    /// Point that the camera looks at, metres; must differ from `eye`.
    pub target: Vec3,
    /// Vertical field of view, radians.
    pub fov_y_rad: f32,
    /// Width and height of the picture, pixels.
    pub size: (u32, u32),
    /// Number of copies, each as large in the picture as the rasterised one.
    pub instances: u32,
    /// Width and height of the shadow maps, texels; 0 for no shadows.
    pub shadow_map: u32,
}

/// Work of a pass of the runtime.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PassWork {
    /// Name in the runtime's report.
    pub name: &'static str,
    /// Whether it runs.
    pub runs: bool,
    /// Reason why it runs or not.
    pub reason: String,
    /// Minimum runs of its vertex shader: each vertex once per layer.
    pub vertices: u64,
    /// Pixels that it draws; `None` for passes that do not draw the picture.
    pub fragments: Option<u64>,
    /// Pixels in whole blocks of 4 by 4 pixels, as software rasterisers run shaders.
    pub fragments_in_blocks: Option<u64>,
}

/// Memory on the GPU, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Memory {
    /// Textures as they are stored. A software adapter uses four bytes per texel for any format.
    pub textures: u64,
    /// Vertices, indices and fins.
    pub buffers: u64,
    /// Posed vertices of all copies.
    pub posed: u64,
    /// Single strands of the fur, planted on the mesh; when posed and drawn at close range they take the same amount
    /// again.
    pub strands: u64,
    /// Shadow maps of the key light, one set for all copies.
    pub shadow_maps: u64,
}

impl Memory {
    /// Returns the sum of all memory, bytes.
    pub fn total(&self) -> u64 {
        self.textures + self.buffers + self.posed + self.strands + self.shadow_maps
    }
}

/// Sizes on the screen where the fur is nearest to the eye; 0 if nothing is in sight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OnScreen {
    /// Width of a texel of the tile, pixels.
    pub texel_px: f64,
    /// Gap between two layers, pixels, seen from the side.
    pub layer_gap_px: f64,
    /// Height of the fur, pixels, seen from the side.
    pub height_px: f64,
    /// Layers drawn of fur of that height, skin excluded.
    pub layers_drawn: u32,
    /// Distance from the eye, metres; 0 if nothing is in sight.
    pub near_m: f64,
    /// Median area of the visible triangles of the mesh surface, pixels.
    pub triangle_px: f64,
    /// Share of the visible triangles that are smaller than 4 by 4 pixels.
    pub small_triangles: f64,
    /// Number of visible triangles.
    pub triangles: u64,
}

impl OnScreen {
    /// Returns the sizes with the nearest fur at that distance from the eye, metres, above 0; unchanged if nothing is
    /// in sight.
    pub fn at_distance(self, distance_m: f64) -> Self {
        let larger = self.near_m / distance_m;
        Self {
            texel_px: self.texel_px * larger,
            layer_gap_px: self.layer_gap_px * larger,
            height_px: self.height_px * larger,
            near_m: if self.near_m > 0.0 { distance_m } else { 0.0 },
            triangle_px: self.triangle_px * larger * larger,
            ..self
        }
    }
}

/// Result of a diagnosis.
#[derive(Clone, Debug, PartialEq)]
pub struct Prognosis {
    /// Pixels covered by the mesh surface, and by at least one layer of fur.
    pub covered_pixels: [u64; 2],
    /// Mean and largest number of layers on a pixel with fur.
    pub overdraw: (f64, u16),
    /// Passes in execution order.
    pub passes: Vec<PassWork>,
    /// Memory on the GPU.
    pub memory: Memory,
    /// Sizes on the screen.
    pub on_screen: OnScreen,
    /// Recommended changes; empty if there are none.
    pub advice: Vec<Advice>,
}

/// A recommended change and its effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Advice {
    /// Change as `--set` takes it, or what to do to the model.
    pub change: String,
    /// Finding that the advice is based on.
    pub found: String,
    /// Savings of the change, in words.
    pub saves: String,
    /// Cost of the change, in words.
    pub costs: String,
    /// Savings as figures, for all copies; `None` for advice that improves the look and saves nothing.
    pub saved: Option<Saved>,
    /// Whether pictures of the package with and without the change can be compared: slicing it again suffices.
    #[serde(skip)]
    pub can_be_tried: bool,
    /// Error of the picture without and with the change and those above it; `None` if no picture was drawn.
    #[serde(rename = "error")]
    pub measured: Option<ErrorChange>,
}

/// Error ([`crate::likeness`]) of a picture without a change and with it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorChange {
    /// Error without this change, with those above it.
    pub before: f64,
    /// Error with the change and those above it.
    pub after: f64,
}

/// Savings of a change in a frame and on the device. The order is that of advice: work before memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Saved {
    /// Fragments of a frame, all copies.
    pub fragments: u64,
    /// Vertices of a frame, all copies.
    pub vertices: u64,
    /// Bytes on the GPU.
    pub bytes: u64,
}
