// The forms that pelage paints surfaces with. A study of others puts another file in the place of this one.

// What varies holds on to the surface.
fn form_of_grain(on_surface: vec4<f32>, position: vec2<f32>) -> vec4<f32> {
    return on_surface;
}

// The sphere map is looked up in the frame perpendicular to the view.
fn form_of_sphere_uv(perpendicular: vec2<f32>, normal: vec3<f32>, eye: vec3<f32>) -> vec2<f32> {
    return perpendicular;
}
