//! What the renderer keeps of the fur of each owner that leans.

use crate::gpu::Gpu;
use crate::swing::Swing;
use pelage_formats::GeometryVertex;

/// Heights of fur on screen, pixels: lower than the first, nobody sees it lean; from the second on it does as it should.
const SEEN_PX: [f32; 2] = [1.0, 3.0];
/// Bytes of the particle of a vertex.
const TIP_BYTES: u64 = 48;
/// Differences of strength that nobody sees.
const SAME: f32 = 0.01;

/// The fur of an owner.
#[derive(Debug)]
pub(crate) struct Fur {
    tips: wgpu::Buffer,
    leaned: wgpu::Buffer,
    /// The life that the tips went through last, and how many there were since they began.
    life: Option<u64>,
    lives: u32,
    /// How far it leans: what the frame of the last moment wanted that sees most of it.
    strength: f32,
    wanted: f32,
}

/// How the fur of an instance moves in a frame.
#[derive(Clone, Debug)]
pub(crate) struct Lean {
    pub(crate) tips: wgpu::Buffer,
    pub(crate) strength: f32,
    /// 1: hair begins; 2: it began in the frame before; else 0.
    pub(crate) begins: u32,
}

/// How far fur leans in a frame that shows it so high, pixels.
pub(crate) fn strength(of: f32, height_px: f32) -> f32 {
    let [none, all] = SEEN_PX;
    let way = ((height_px - none) / (all - none)).clamp(0.0, 1.0);
    of * way * way * (3.0 - 2.0 * way)
}

impl Fur {
    /// Of an instance that is posed into, or drawn from, that buffer.
    pub(crate) fn new(gpu: &Gpu, posed: &wgpu::Buffer) -> Self {
        use wgpu::BufferUsages as Usage;
        // Tests read it.
        let read = if cfg!(test) { Usage::COPY_SRC } else { Usage::empty() };
        let vertices = posed.size() / size_of::<GeometryVertex>() as u64;
        Self {
            tips: gpu.buffer("pelage tips of fur", vertices * TIP_BYTES, Usage::STORAGE),
            leaned: gpu.buffer("pelage leaned vertices", posed.size(), Usage::STORAGE | Usage::VERTEX | read),
            life: None,
            lives: 0,
            strength: 0.0,
            wanted: 0.0,
        }
    }

    /// What is drawn in place of the posed vertices.
    pub(crate) fn leaned(&self) -> &wgpu::Buffer {
        &self.leaned
    }

    pub(crate) fn gpu_bytes(&self) -> u64 {
        self.tips.size() + self.leaned.size()
    }

    /// Whether fur leans in a frame that wants it to do so that far. Of the frames of a moment, the first says for all; that another saw more of it the
    /// next moment knows.
    pub(crate) fn is_seen(&mut self, swing: &Swing, wanted: f32) -> bool {
        if self.life == Some(swing.life) {
            self.wanted = self.wanted.max(wanted);
            return true;
        }
        wanted.max(self.wanted) > 0.0
    }

    /// How it moves in a frame in which it [is seen](Self::is_seen); `None` where it stays as it leans.
    pub(crate) fn lean(&mut self, swing: &Swing, wanted: f32) -> Option<Lean> {
        if self.life == Some(swing.life) {
            return None;
        }
        let is_fresh = swing.follows.is_none() || self.life != swing.follows;
        self.life = Some(swing.life);
        self.lives = if is_fresh { 0 } else { self.lives.saturating_add(1) };
        let strength = wanted.max(self.wanted);
        self.wanted = wanted;
        if swing.is_at_rest && !is_fresh && (strength - self.strength).abs() < SAME {
            return None;
        }
        self.strength = strength;
        let begins = match self.lives {
            0 => 1,
            1 => 2,
            _ => 0,
        };
        Some(Lean { tips: self.tips.clone(), strength, begins })
    }
}
