//! `ink_fur`: fins and outer shells as dry strokes of a brush, blended over the sheet in the application's pass, with depth tested and not written.

use super::ink::ink_surface_wgsl;
use super::{draw_part, fins};
use crate::frame::Drawn;

/// The shader.
pub(crate) const WGSL: &str =
    concat!(include_str!("../../shared/srgb.wgsl"), ink_surface_wgsl!("../fins/fin_corner.wgsl", "ink_fur.wgsl"));

/// Shells that strokes are drawn on, as in the shader.
pub(crate) const SHELLS: u32 = 2;

/// Records the draws of one instance; groups 0 and 2 and the vertex buffers are set.
pub(crate) fn record(pass: &mut wgpu::RenderPass<'_>, instance: &Drawn) {
    let Some(draws) = &instance.ink else { return };
    pass.set_bind_group(2, draws.group(), &[]);
    for (part, pipeline) in draws.shells() {
        draw_part(pass, &instance.model.parts()[*part], pipeline, 0..SHELLS);
    }
    if let Some(fins) = draws.fins() {
        fins::record_with(pass, &instance.model, fins, Some(draws.group()));
    }
}
