//! Uniform blocks of a frame and of its instances.

use crate::error::RuntimeError;
use crate::hair::InstanceDrawing;
use crate::instance::Instance;
use crate::light::ShadowMaps;
use crate::params::{FrameParams, MAX_FILL_LIGHTS};
use crate::shared::kajiya_kay::BACK_ATTENUATION_OFF;
use crate::shared::{detail, frame as blocks, skinning};
use crate::study;
use crate::surface::Lights;
use glam::{Mat3, Mat4, Vec3, Vec4};
use pelage_formats::{FarLayerInfo, Shading};

/// Returns the frame block for the eye. `maps`: shadow maps that it refers to; `sky_most`: peak irradiance of the
/// environment divided by π.
pub(super) fn frame_block(
    params: &FrameParams,
    clip_from_world: Mat4,
    eye_ws: Vec4,
    light_ws: Vec4,
    maps: Option<&ShadowMaps>,
    sky_most: f32,
) -> blocks::Frame {
    blocks::Frame {
        clip_from_world: clip_from_world.to_cols_array_2d(),
        eye_ws: eye_ws.to_array(),
        light_ws: light_ws.to_array(),
        map_from_world: maps.map_or(Mat4::IDENTITY, |maps| maps.view().map_from_world).to_cols_array_2d(),
        soft_shadow: maps.map_or([0.0; 4], |maps| {
            let s = maps.soft_shadow();
            [s.range_m, s.penumbra, s.blur, s.texel]
        }),
        last_map_layer: maps.map_or(0.0, |maps| (maps.key.map_layers - 1) as f32),
        fill_lights: params.fill_lights.len() as u32,
        // This value also applies to far fur layers, which have no shadow maps.
        hair_density: if params.self_shadow() { params.shadows.density } else { 0.0 },
        environment_most: sky_most,
        environment_even: params.environment.as_ref().map_or([0.0; 3], |environment| environment.even),
        environment_lobes: params.environment.as_ref().map_or(0, |environment| environment.lobes.len() as u32),
    }
}

/// Returns the fill lights in shader layout, followed by the lobes of the environment.
pub(super) fn fill_lights(params: &FrameParams) -> Result<Lights, RuntimeError> {
    let mut lights: Lights = [Default::default(); _];
    for (slot, light) in lights.iter_mut().zip(&params.fill_lights) {
        *slot = blocks::FillLight {
            light_ws: light.homogeneous("FrameParams::fill_lights")?.to_array(),
            color: light.color().extend(0.0).to_array(),
        };
    }
    let lobes = params.environment.iter().flat_map(|environment| &environment.lobes);
    for (slot, lobe) in lights.iter_mut().skip(MAX_FILL_LIGHTS).zip(lobes) {
        let light = lobe.light();
        let axis = light.towards.as_vec3().extend(light.sharpness as f32);
        *slot =
            blocks::FillLight { light_ws: axis.to_array(), color: Vec3::from(lobe.radiance).extend(0.0).to_array() };
    }
    Ok(lights)
}

/// Returns the mip level at which an instance's hair texels match those of the shadow maps in size. It is rounded, so
/// that only one level is sampled.
pub(super) fn map_level(instance: &Instance, maps: &ShadowMaps) -> f32 {
    let fur = &instance.model.manifest().fur;
    let scale = Mat3::from_mat4(instance.transform).determinant().abs().cbrt();
    let hair_m = scale * fur.tile_size_m / fur.tile_texels.max(1) as f32;
    let level = (maps.texel_m() / hair_m).log2().round();
    // The level of hair of size zero is not finite.
    if level.is_finite() { level.max(0.0) } else { 0.0 }
}

/// Returns the uniform block of an instance. `drawn`: layer count, mesh surface included; 1 if no fur is visible.
pub(super) fn instance_block(
    instance: &Instance,
    params: &FrameParams,
    drawing: &InstanceDrawing,
    drawn: u32,
) -> blocks::Instance {
    let manifest = instance.model.manifest();
    let shading = params.shading.unwrap_or(manifest.shading);
    let linear = Mat3::from_mat4(instance.transform);
    let handedness = skinning::handedness_of(linear);
    let cofactor = |a: Vec3, b: Vec3| -> [f32; 4] { (a.cross(b) * handedness).extend(0.0).to_array() };
    let constant = |k: [f32; 3], light: Vec3| (Vec3::from(k) * light).to_array();
    // Fibre scattering uses tables; of the shading constants, it needs only the ambient one. `specular` then holds the
    // colour of the key light.
    let scattered = instance.scattering(params).is_some();
    let shading = if scattered { Shading { diffuse: [1.0; 3], specular: [1.0; 3], ..shading } } else { shading };
    let unit = Shading { specular: [1.0; 3], ..shading };
    let baked = manifest.fur.layers;
    let coat = manifest.coat.unwrap_or_default();
    let [coat_light_base, coat_light_slope] = coat_light(&coat, params);
    blocks::Instance {
        world_from_model: instance.transform.to_cols_array_2d(),
        normal_x: cofactor(linear.y_axis, linear.z_axis),
        normal_y: cofactor(linear.z_axis, linear.x_axis),
        normal_z: cofactor(linear.x_axis, linear.y_axis),
        // An environment map replaces the ambient light.
        ambient: if params.environment.is_some() { [0.0; 3] } else { constant(shading.ambient, params.ambient) },
        diffuse_half_exponent: 0.5 * shading.diffuse_exponent,
        diffuse: constant(shading.diffuse, if scattered { Vec3::ONE } else { params.light.color() }),
        specular_half_exponent: 0.5 * shading.specular_exponent,
        specular: constant(shading.specular, params.light.color()),
        back_light_range: if study::back_attenuation(params) { shading.back_light_range } else { BACK_ATTENUATION_OFF },
        ambient_floor: if study::ambient_attenuation(params) { shading.ambient_floor } else { 1.0 },
        scale: linear.determinant().abs().cbrt(),
        handedness,
        layer_share: drawing.layer_share,
        baked_layers: baked,
        // At least 2, because the shaders divide by this value minus one.
        drawn_layers: drawn.max(2),
        wet_specular: unit.wet().specular[0],
        wet_specular_half_exponent: 0.5 * shading.wet().specular_exponent,
        diffuse_constant: shading.diffuse,
        map_level: 0.0,
        specular_constant: shading.specular,
        detail_here: drawing.weights[0],
        // At least 1, because the shaders divide by this value; a level without layers draws none.
        layer_step: drawing.step.max(1),
        layers_gone: drawing.gone,
        detail_next: drawing.weights[1],
        fin_share: drawing.detail.fins,
        coat_height: coat.height,
        coat_ambient_height: coat.ambient_height,
        coat_light_base,
        coat_light_slope,
    }
}

/// Returns the arguments `base` and `slope` of `coat_light` in the shaders: attenuation of the key light in the far fur
/// layer.
fn coat_light(coat: &FarLayerInfo, params: &FrameParams) -> [f32; 2] {
    if !params.self_shadow() {
        return [1.0, 0.0];
    }
    let [base, slope] = detail::far_layer_light_coefficients(coat);
    let slope = slope * params.shadows.density;
    // If the light's inclination has no effect, all light is treated as perpendicular.
    if study::light_is_slanted(params) { [base, slope] } else { [base + slope, 0.0] }
}
