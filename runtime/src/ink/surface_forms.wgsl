// Surface functions as pelage paints them. A study of Fang 2006 as printed replaces this file.

// Returns the grain, attached to the surface.
fn form_of_grain(on_surface: vec4<f32>, position: vec2<f32>) -> vec4<f32> {
    return on_surface;
}

// Returns the sphere map coordinates: looked up in the frame perpendicular to the view.
fn form_of_sphere_uv(perpendicular: vec2<f32>, normal: vec3<f32>, eye: vec3<f32>) -> vec2<f32> {
    return perpendicular;
}
