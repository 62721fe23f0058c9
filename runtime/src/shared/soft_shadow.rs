use bytemuck::{Pod, Zeroable};
use glam::Vec4;

/// The shader source; needs nothing else.
pub const WGSL: &str = include_str!("soft_shadow.wgsl");

/// What the map's numbers mean in metres. 16 bytes, as the WGSL structure of the same name.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SoftShadow {
    /// Metres from depth 0 to depth 1.
    pub range_m: f32,
    /// Width of the penumbra over the distance from what throws the shadow: 1 / C_scale of Yang 2006, §5. 0 is a hard shadow.
    pub penumbra: f32,
    /// Half the width of the map's blur, metres at distance 1 from a point light, metres everywhere for a distant one.
    pub blur: f32,
    /// Size of a texel, in the same unit.
    pub texel: f32,
}

/// Attenu_Shadow of Yang 2006, §5, made safe: 1 − `sw` / (`penumbra` · `sd`), with the penumbra inside the hard edge.
///
/// * `sd` - metres behind what throws the shadow; up to 0 is lit
/// * `sw` - metres from the edge into the shadow, 0..=`blur`
/// * `blur` - the greatest `sw`; wider penumbrae are cut to it, so that their middle gets dark
pub fn inner_attenuation(sd: f32, sw: f32, penumbra: f32, blur: f32) -> f32 {
    let width = (sd * penumbra).max(1e-6).min(blur);
    if sd <= 0.0 { 1.0 } else { (1.0 - sw / width).clamp(0.0, 1.0) }
}

/// Attenu_Shadow with the penumbra on both sides of the hard edge, where a round light has it.
///
/// * `edge` - metres from the hard edge, positive in the shadow, −`blur`..=`blur`
pub fn centred_attenuation(sd: f32, edge: f32, penumbra: f32, blur: f32) -> f32 {
    let width = (sd * penumbra).max(1e-6).min(2.0 * blur);
    if sd <= 0.0 { 1.0 } else { (0.5 - edge / width).clamp(0.0, 1.0) }
}

/// Metres that a surface may lie behind the first one and still be it; arguments as of [`soft_shadow()`].
pub fn depth_bias(distance: f32, path: f32, s: &SoftShadow) -> f32 {
    s.texel * distance * (0.5 + path)
}

/// Attenu_Shadow of Yang 2006, eq. (3), at a receiver: 1 lit, 0 dark.
///
/// * `texel` - of the shadow-width map: blurred occlusion, depth of what throws the shadow times that, depth of the first surface
/// * `z` - depth of the receiver in the map's range, 0..=1
/// * `distance` - from a point light, metres; 1 for a distant one
/// * `path` - [`crate::shared::layer_shadow::slanted_path`] at the receiver
/// * `centred` - the penumbra lies on both sides of the hard edge, not inside it alone
pub fn soft_shadow(texel: Vec4, z: f32, distance: f32, path: f32, s: &SoftShadow, centred: bool) -> f32 {
    let blur = s.blur * distance;
    let bias = depth_bias(distance, path, s);
    let behind_first = (z - texel.z) * s.range_m - bias;
    let edge = (2.0 * texel.x - 1.0) * blur;
    if !centred {
        return inner_attenuation(behind_first, edge.max(0.0), s.penumbra, blur);
    }
    let sd = ((z - texel.y / texel.x.max(1e-3)) * s.range_m).max(behind_first);
    let slack = bias + blur * path;
    let outside = (sd / slack - 1.0).clamp(0.0, 1.0);
    let share = if behind_first > 0.0 { 1.0 } else { outside };
    1.0 + (centred_attenuation(sd, edge, s.penumbra, blur) - 1.0) * share
}
