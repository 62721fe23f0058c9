// A layer of hair as the key light sees it: what it leaves of the light that the layers above left (Yang 2006, sec. 3.1).

// The map of the layer above, texel for texel: along the light a ray is one texel.
@group(3) @binding(0) var above: texture_2d<f32>;

struct LayerVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) tile_uv: vec2<f32>,
    @location(1) tint: vec4<f32>,
    @location(2) base_uv: vec2<f32>,
    @location(3) @interpolate(flat, either) layer: u32,
    @location(4) groom: vec2<f32>,
    @location(5) n_dot_l: f32,
    // 1 where fur grows, 0 where its height is 0 and all layers lie on the skin.
    @location(6) coat: f32,
}

@vertex
fn vs_layer(v: Vertex, @builtin(instance_index) layer: u32) -> LayerVarying {
    let height = f32(layer) / f32(instance.drawn_layers - 1u);
    let tile = tile_frame_of(v, normal_ws(v));
    let position = hair_position(v, tile, height);
    var out: LayerVarying;
    out.position = frame.clip_from_world * vec4(position, 1.0);
    out.tile_uv = v.tile_uv;
    out.tint = v.color * material.base_color;
    out.base_uv = v.base_uv;
    out.layer = baked_layer(layer, instance.baked_layers, instance.drawn_layers);
    out.groom = v.groom.xy;
    out.n_dot_l = dot(tile.normal_ws, direction_to(frame.light_ws, position));
    out.coat = select(0.0, 1.0, v.fur_height > 0.0);
    return out;
}

@fragment
fn fs_layer(in: LayerVarying) -> @location(0) vec4<f32> {
    let groom = groom_at(in.groom, in.base_uv);
    var alpha = textureSample(shell_colors, shell_sampler, in.tile_uv, in.layer).a;
    if WET {
        alpha = mix(alpha, textureSample(wet_colors, shell_sampler, in.tile_uv, in.layer).a, groom.y);
    }
    // What is cut away leaves all light, but its texel must still pass on what the layers above took.
    alpha *= groom.x * in.coat;
    if CUTOUT {
        alpha = select(alpha, 0.0, is_cut(base_color(in.tint, in.base_uv).a));
    }
    if RESAMPLED {
        alpha = resampled_opacity(alpha, instance.opacity_exponent);
    }
    let path = select(1.0, slanted_path(in.n_dot_l), SLANTED);
    let left = textureLoad(above, vec2<i32>(in.position.xy), 0).r * layer_transmittance(alpha, path);
    return vec4(left, 0.0, 0.0, 1.0);
}
