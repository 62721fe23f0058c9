//! Fur motion state that the renderer keeps per owner.

use crate::gpu::Gpu;
use crate::guide_motion::GuideMotion;
use pelage_formats::GeometryVertex;

/// Fade-in range of the lean, in pixels of fur height on screen. Below the first value, the lean is invisible and not
/// computed; from the second value on, it has full strength.
const FADE_IN_PX: [f32; 2] = [1.0, 3.0];
/// Bytes per vertex of the tip buffer.
const PARTICLE_BYTES: u64 = 48;
/// Smallest change of strength that is visible.
const MIN_STRENGTH_CHANGE: f32 = 0.01;

#[derive(Debug)]
pub(crate) struct FurState {
    tips: wgpu::Buffer,
    leaned: wgpu::Buffer,
    /// Number of the last motion update applied to the tips.
    life: Option<u64>,
    /// Number of updates since the tips were reset.
    lives: u32,
    /// Strength of the current lean.
    strength: f32,
    /// Largest strength requested by the frames with the current time.
    wanted: f32,
}

/// Fur motion of an instance in a frame.
#[derive(Clone, Debug)]
pub(crate) struct FurUpdate {
    pub(crate) tips: wgpu::Buffer,
    pub(crate) strength: f32,
    /// Reset state: 1 if the fur is reset in this frame, 2 if it was reset in the previous update, otherwise 0.
    pub(crate) begins: u32,
}

/// Returns the strength of the lean in a frame.
///
/// * `of`: full strength, used if the fur is high enough on screen
/// * `height_px`: height of the fur on screen, pixels
pub(crate) fn lean_strength(of: f32, height_px: f32) -> f32 {
    let [none, all] = FADE_IN_PX;
    let way = ((height_px - none) / (all - none)).clamp(0.0, 1.0);
    of * way * way * (3.0 - 2.0 * way)
}

impl FurState {
    /// Creates the state for an instance whose posed vertices are in the buffer `posed`.
    pub(crate) fn new(gpu: &Gpu, posed: &wgpu::Buffer) -> Self {
        use wgpu::BufferUsages as Usage;
        // Tests read the buffer.
        let read = if cfg!(test) { Usage::COPY_SRC } else { Usage::empty() };
        let vertices = posed.size() / size_of::<GeometryVertex>() as u64;
        Self {
            tips: gpu.buffer("pelage tips of fur", vertices * PARTICLE_BYTES, Usage::STORAGE),
            leaned: gpu.buffer("pelage leaned vertices", posed.size(), Usage::STORAGE | Usage::VERTEX | read),
            life: None,
            lives: 0,
            strength: 0.0,
            wanted: 0.0,
        }
    }

    /// Returns the buffer of leaned vertices, which are drawn instead of the posed ones.
    pub(crate) fn leaned(&self) -> &wgpu::Buffer {
        &self.leaned
    }

    pub(crate) fn gpu_bytes(&self) -> u64 {
        self.tips.size() + self.leaned.size()
    }

    /// Whether the fur leans in a frame that requests strength `wanted`. The first of several frames with the same time
    /// decides for all of them. A larger strength requested by the others applies from the next time on.
    pub(crate) fn begin_frame(&mut self, swing: &GuideMotion, wanted: f32) -> bool {
        if self.life == Some(swing.update) {
            self.wanted = self.wanted.max(wanted);
            return true;
        }
        wanted.max(self.wanted) > 0.0
    }

    /// Returns the fur motion of a frame in which the fur leans; `None` if the lean stays the same.
    pub(crate) fn update(&mut self, swing: &GuideMotion, wanted: f32) -> Option<FurUpdate> {
        if self.life == Some(swing.update) {
            return None;
        }
        let is_fresh = swing.previous_update.is_none() || self.life != swing.previous_update;
        self.life = Some(swing.update);
        self.lives = if is_fresh { 0 } else { self.lives.saturating_add(1) };
        let strength = wanted.max(self.wanted);
        self.wanted = wanted;
        if swing.is_at_rest && !is_fresh && (strength - self.strength).abs() < MIN_STRENGTH_CHANGE {
            return None;
        }
        self.strength = strength;
        let begins = match self.lives {
            0 => 1,
            1 => 2,
            _ => 0,
        };
        Some(FurUpdate { tips: self.tips.clone(), strength, begins })
    }
}
