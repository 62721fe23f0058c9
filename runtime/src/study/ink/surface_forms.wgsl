//! uses ink/model, shared/ink
// Surface functions in pelage's own form and in the published form of Fang 2006 (formulas 5.1), selected by override
// constants. Replaces ink/surface_forms.wgsl in studies.

// Sphere map lookup. 0: perpendicular to the view; 1: by reflection; 2: as published.
override SPHERE_MAP: u32 = 0u;
// Whether the grain is attached to the picture instead of the surface, to measure how much worse that is.
override ON_SCREEN: bool = false;

// Period of grain that is attached to the picture, pixels.
const GRAIN_PERIOD_PX: f32 = 160.0;

fn form_of_grain(on_surface: vec4<f32>, position: vec2<f32>) -> vec4<f32> {
    if ON_SCREEN {
        return textureSample(wash_tile, tile_sampler, position / GRAIN_PERIOD_PX);
    }
    return on_surface;
}

fn form_of_sphere_uv(perpendicular: vec2<f32>, normal: vec3<f32>, eye: vec3<f32>) -> vec2<f32> {
    // View space is the frame of the eye at the centre of the picture.
    let view = mat3x3(model.right_ws, model.up_ws, cross(model.right_ws, model.up_ws));
    if SPHERE_MAP == 1u {
        return ink_sphere_uv_reflected(normal * view, eye * view);
    }
    if SPHERE_MAP == 2u {
        return ink_sphere_uv_printed(normal * view, eye * view);
    }
    return perpendicular;
}
