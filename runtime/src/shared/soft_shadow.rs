use bytemuck::{Pod, Zeroable};
use glam::Vec4;

/// WGSL source; does not depend on other topics.
pub const WGSL: &str = include_str!("soft_shadow.wgsl");

/// Scales of the shadow-width map, metres. 16 bytes, in the layout of the WGSL structure of the same name.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SoftShadow {
    /// Distance between depth 0 and depth 1, metres.
    pub range_m: f32,
    /// Width of the penumbra divided by the distance from the occluder; 0 gives a hard shadow. 1 / C_scale of Yang
    /// 2006, §5.
    pub penumbra: f32,
    /// Half the width of the map's blur, metres; for a point light, at a distance of 1 m.
    pub blur: f32,
    /// Width of a texel, in the unit of `blur`.
    pub texel: f32,
}

/// Returns Attenu_Shadow of Yang 2006, §5, with the penumbra inside the hard edge: 1 − `sw` / (`penumbra` · `sd`). The
/// width of the penumbra is clamped, unlike in the paper.
///
/// * `sd` - distance behind the occluder, metres; lit if 0 or less
/// * `sw` - distance from the edge into the shadow, metres, 0..=`blur`
/// * `blur` - maximum of `sw`; wider penumbrae are clamped to it, so that their middle gets dark
pub fn inner_attenuation(sd: f32, sw: f32, penumbra: f32, blur: f32) -> f32 {
    let width = (sd * penumbra).max(1e-6).min(blur);
    if sd <= 0.0 { 1.0 } else { (1.0 - sw / width).clamp(0.0, 1.0) }
}

/// Returns Attenu_Shadow with the penumbra on both sides of the hard edge, as for a round light.
///
/// * `edge` - signed distance from the hard edge, metres, positive in the shadow, −`blur`..=`blur`
pub fn centred_attenuation(sd: f32, edge: f32, penumbra: f32, blur: f32) -> f32 {
    let width = (sd * penumbra).max(1e-6).min(2.0 * blur);
    if sd <= 0.0 { 1.0 } else { (0.5 - edge / width).clamp(0.0, 1.0) }
}

/// Returns the depth bias, metres. A surface that is behind the surface nearest to the light by at most this distance
/// counts as the same surface. Arguments as for [`soft_shadow()`].
pub fn depth_bias(distance: f32, path: f32, s: &SoftShadow) -> f32 {
    s.texel * distance * (0.5 + path)
}

/// Returns Attenu_Shadow of Yang 2006, eq. (3), at a receiver: 1 lit, 0 dark.
///
/// * `texel` - texel of the shadow-width map: blurred occlusion, depth of the occluder times blurred occlusion, depth
///   of the surface nearest to the light
/// * `z` - depth of the receiver in the map's range, 0..=1
/// * `distance` - distance from a point light, metres; 1 for a distant light
/// * `path` - [`crate::shared::layer_shadow::slanted_path`] at the receiver
/// * `centred` - whether the penumbra extends to both sides of the hard edge, not only inwards
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
