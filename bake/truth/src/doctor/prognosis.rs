//! How a package will be looked at, and what is found out about that.

use glam::Vec3;

/// How the package will be looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Place of the eye, metres.
    pub eye: Vec3,
    /// What it looks at, metres; apart from `eye`.
    pub target: Vec3,
    /// Height of the view, radians.
    pub fov_y_rad: f32,
    /// Width and height of the picture, pixels.
    pub size: (u32, u32),
    /// Copies, each seen as large as the one that is rasterised.
    pub instances: u32,
    /// Width and height of the shadow maps, texels; 0 for no shadows.
    pub shadow_map: u32,
}

/// A pass of the runtime.
#[derive(Clone, Debug, PartialEq)]
pub struct PassWork {
    /// As in the runtime's report.
    pub name: &'static str,
    /// Whether it runs.
    pub runs: bool,
    /// Why, or why not.
    pub reason: String,
    /// Vertices that its shader is run for, at the least: each once a layer.
    pub vertices: u64,
    /// Pixels that it draws; of passes that draw the picture.
    pub fragments: Option<u64>,
    /// The same where a shader runs on blocks of 4 by 4 pixels, as on a software rasteriser.
    pub fragments_in_blocks: Option<u64>,
}

/// Bytes on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// All textures as they are stored. A software adapter holds four bytes a texel of any format.
    pub textures: u64,
    /// Vertices, indices and fins.
    pub buffers: u64,
    /// Posed vertices of all copies.
    pub posed: u64,
    /// Single strands of the coat where they are planted; posed and drawn near by, they take as much again.
    pub strands: u64,
    /// The key light's shadow maps, one set for all.
    pub shadow_maps: u64,
}

impl Memory {
    /// All of it.
    pub fn total(&self) -> u64 {
        self.textures + self.buffers + self.posed + self.strands + self.shadow_maps
    }
}

/// Sizes on the screen, where the fur is nearest to the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OnScreen {
    /// Width of a texel of the tile, pixels.
    pub texel_px: f64,
    /// Gap between two layers, pixels, seen from the side.
    pub layer_gap_px: f64,
    /// Height of the fur, pixels, likewise.
    pub height_px: f64,
    /// Layers that a renderer draws of fur so high, the skin not counted.
    pub layers_drawn: u32,
    /// How far before the eye that is, metres; 0 where nothing is in sight.
    pub near_m: f64,
    /// Median area of the triangles of the skin that are seen, pixels.
    pub triangle_px: f64,
    /// Share of them that are smaller than 4 by 4 pixels.
    pub small_triangles: f64,
    /// How many are seen.
    pub triangles: u64,
}

impl OnScreen {
    /// The same sizes where the fur is nearest at that distance from the eye, metres, above 0. Nothing in sight stays nothing.
    pub fn seen_from(self, distance_m: f64) -> Self {
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

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Prognosis {
    /// Pixels that the skin covers, and that at least one layer of fur does.
    pub covered_pixels: [u64; 2],
    /// Mean and largest number of layers on a pixel with fur.
    pub overdraw: (f64, u16),
    /// The passes, in their order.
    pub passes: Vec<PassWork>,
    /// On the device.
    pub memory: Memory,
    /// Sizes on the screen.
    pub on_screen: OnScreen,
    /// What to change; empty where all is well.
    pub advice: Vec<Advice>,
}

/// What to change, and what for.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// The change, as `--set` takes it; or, where no recipe can change it, what to do.
    pub change: String,
    /// What was found.
    pub found: String,
    /// What the change would save.
    pub saves: String,
    /// What it would cost.
    pub costs: String,
    /// The savings as figures; `None` of what mends the look and saves nothing.
    pub saved: Option<Saved>,
    /// Whether pictures of the package with and without it can be compared: slicing it anew makes the change.
    pub can_be_tried: bool,
    /// The error ([`crate::likeness`]) of the picture before and after, once somebody has drawn both.
    pub measured: Option<[f64; 2]>,
}

/// What a change saves in a frame and on the device. The order is that of advice: work before memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Saved {
    /// Fragments of a frame, all copies.
    pub fragments: u64,
    /// Vertices of a frame, all copies.
    pub vertices: u64,
    /// Bytes on the device.
    pub bytes: u64,
}
