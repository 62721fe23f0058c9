// Default form of the surface functions. A study of Fang 2006 in its published form replaces this file.

// Returns the grain at a fragment: here the grain `on_surface`, which is attached to the surface.
fn form_of_grain(on_surface: vec4<f32>, position: vec2<f32>) -> vec4<f32> {
    return on_surface;
}

// Returns the sphere map coordinates, computed in the frame perpendicular to the view.
fn form_of_sphere_uv(perpendicular: vec2<f32>, normal: vec3<f32>, eye: vec3<f32>) -> vec2<f32> {
    return perpendicular;
}
