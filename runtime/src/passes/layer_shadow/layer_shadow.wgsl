//! uses hair/hair, light/forms, shared/frame, shared/layer_shadow, shared/opacity, surface/place
// Transmittance of one hair layer, seen from the key light (Yang 2006, sec. 3.1). Blending multiplies it by the
// transmittance of the layers above; each texel is one light ray.

// Interpolants are as few as the fur needs, as in shells/varying.wgsl.
struct LayerVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // Tile coordinates; N.L; hair length relative to the tile's.
    @location(0) uv_light: vec4<f32>,
    @location(1) @interpolate(flat, either) layer: u32,
}

// Interpolants of LayerVarying, with additional inputs for material textures and maps.
struct MappedLayerVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) uv_light: vec4<f32>,
    @location(1) @interpolate(flat, either) layer: u32,
    @location(2) base_uv_groom: vec4<f32>,
    @location(3) tint: vec4<f32>,
}

// Returns the interpolants of a vertex for a drawn layer.
fn layer_of(v: Vertex, layer: u32) -> LayerVarying {
    let height = height_of(layer);
    let tile = tile_frame_of(v, normal_ws(v));
    let position = hair_position(v, tile, height);
    let n_dot_l = dot(tile.normal_ws, direction_to(frame.light_ws, position));
    return LayerVarying(
        frame.clip_from_world * vec4(position, 1.0),
        vec4(v.tile_uv, n_dot_l, length_share(v)),
        baked_layer(layer, instance.baked_layers, instance.drawn_layers),
    );
}

@vertex
fn vs_layer(v: Vertex, @builtin(instance_index) layer: u32) -> LayerVarying {
    return layer_of(v, layer);
}

@vertex
fn vs_layer_mapped(v: Vertex, @builtin(instance_index) layer: u32) -> MappedLayerVarying {
    let plain = layer_of(v, layer);
    var out: MappedLayerVarying;
    out.position = plain.position;
    out.uv_light = plain.uv_light;
    out.layer = plain.layer;
    out.base_uv_groom = vec4(v.base_uv, v.groom.xy);
    out.tint = v.color * material.base_color;
    return out;
}

// Returns the transmittance of the layer (formulas 4.2). `kept`: share of the hair that grows; `wetness`: wetness of
// that hair.
fn transmitted_light(in: LayerVarying, kept: f32, wetness: f32) -> vec4<f32> {
    let uv = in.uv_light.xy;
    // All triangles use the same mip level. A level chosen for each triangle by its slant would double the cost of
    // reads. It would also blur detail that the maps can hold.
    var alpha = textureSampleLevel(shell_colors, shell_sampler, uv, in.layer, instance.map_level).a;
    if WET {
        alpha = mix(alpha, textureSampleLevel(wet_colors, shell_sampler, uv, in.layer, instance.map_level).a, wetness);
    }
    alpha *= kept;
    if RESAMPLED {
        alpha = resampled_opacity(alpha, resampled_exponent());
    }
    let slanted = path_through(slanted_path(in.uv_light.z), in.uv_light.w);
    let path = frame.hair_density * select(1.0, slanted, LIGHT_SLANTED);
    return vec4(layer_transmittance(alpha, path), 0.0, 0.0, 1.0);
}

@fragment
fn fs_layer(in: LayerVarying) -> @location(0) vec4<f32> {
    return transmitted_light(in, 1.0, 0.0);
}

@fragment
fn fs_layer_mapped(in: MappedLayerVarying) -> @location(0) vec4<f32> {
    let groom = groom_at(in.base_uv_groom.zw, in.base_uv_groom.xy);
    var kept = groom.x;
    if CUTOUT {
        kept = select(kept, 0.0, is_cut(base_color(in.tint, in.base_uv_groom.xy).a));
    }
    return transmitted_light(LayerVarying(in.position, in.uv_light, in.layer), kept, groom.y);
}
