//! View of a package, and the predicted figures.

use glam::Vec3;
use serde::Serialize;

/// View for which a package is diagnosed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrognosisView {
    /// Position of the eye, metres.
    pub eye: Vec3,
    /// Point that the camera looks at, metres; must differ from `eye`.
    pub target: Vec3,
    /// Vertical field of view, radians.
    pub fov_y_rad: f32,
    /// Width and height of the picture, pixels.
    pub size: (u32, u32),
    /// Number of instances, each as large in the picture as the rasterised one.
    pub instances: u32,
    /// Width and height of the shadow maps, texels; 0 for no shadows.
    pub shadow_map: u32,
}

/// Work of a render or compute pass of the runtime.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PassWork {
    /// Name in the runtime's report.
    pub name: &'static str,
    /// Whether the pass runs.
    pub runs: bool,
    /// Reason why the pass runs or does not run.
    pub reason: String,
    /// Lower bound of vertex shader invocations: each vertex once per layer.
    pub vertices: u64,
    /// Number of fragments that the pass shades; `None` for passes that do not draw the picture.
    pub fragments: Option<u64>,
    /// Fragments rounded up to whole blocks of 4 by 4 pixels, in which software rasterisers run shaders.
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
    /// Posed vertices of all instances.
    pub posed: u64,
    /// Single strands of the fur, planted on the mesh. At close range, posing and drawing them takes the same amount
    /// again.
    pub strands: u64,
    /// Shadow maps of the key light, one set for all instances.
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
    /// Number of layers drawn if the fur has that height, skin excluded.
    pub layers_drawn: u32,
    /// Distance from the eye, metres; 0 if nothing is in sight.
    pub near_m: f64,
    /// Median area of the visible triangles of the mesh surface, pixels.
    pub triangle_px: f64,
    /// Fraction of the visible triangles that are smaller than 4 by 4 pixels.
    pub small_triangles: f64,
    /// Number of visible triangles.
    pub triangles: u64,
}

impl OnScreen {
    /// Returns the sizes for a camera whose distance from the nearest fur is `distance_m`, metres, above 0. If nothing
    /// is in sight, returns the sizes unchanged.
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
    /// Number of pixels covered by the mesh surface, and number covered by at least one layer of fur.
    pub covered_pixels: [u64; 2],
    /// Mean and maximum number of layers over the pixels with fur.
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
    /// Change as an argument of `--set`, or instruction for editing the model.
    pub change: String,
    /// Finding that the advice is based on.
    pub found: String,
    /// Savings of the change, in words.
    pub saves: String,
    /// Cost of the change, in words.
    pub costs: String,
    /// Savings as figures, for all instances. `None` for advice that improves the look and saves nothing.
    pub saved: Option<Saved>,
    /// Whether the effect of the change on the picture can be measured: possible if slicing the package again applies
    /// it.
    #[serde(skip)]
    pub can_be_tried: bool,
    /// Error of the picture before and after the change, with all previous changes applied. `None` if no picture was
    /// rendered.
    #[serde(rename = "error")]
    pub measured: Option<ErrorChange>,
}

/// Error ([`crate::likeness`]) of a picture before and after a change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorChange {
    /// Error without this change, with all previous changes applied.
    pub before: f64,
    /// Error with this change and all previous ones applied.
    pub after: f64,
}

/// Savings of a change, per frame and on the device. Ordered like advice: work before memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Saved {
    /// Fragments per frame, all instances.
    pub fragments: u64,
    /// Vertices per frame, all instances.
    pub vertices: u64,
    /// Bytes on the GPU.
    pub bytes: u64,
}
