// What every pass over a model's surface shares: vertices, placing them and their hair, and base colours.

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) fur_height: f32,
    @location(2) normal: vec3<f32>,
    @location(3) tangent: vec4<f32>,
    @location(4) tile_uv: vec2<f32>,
    @location(5) base_uv: vec2<f32>,
    @location(6) color: vec4<f32>,
    @location(7) lean: f32,
    // Bareness, wetness; what the body leaves open, packed.
    @location(8) groom: vec4<f32>,
}

struct Material {
    base_color: vec4<f32>,
    // 0 cuts nothing.
    alpha_cutoff: f32,
    // 1 over the height of the tile's hair, metres; 0 where there is none.
    share_per_m: f32,
    // How low a light begins to fade in the hair.
    horizon: f32,
    // Which of the package's fibres its coat is.
    fibre: u32,
    // How far behind its skin a body's fur is lit, as the sine for tips: near the outline hair stands above what hides the light.
    rim: f32,
    // At heights spread evenly from the skin to the outermost layer: how far hair lies aside of its root, in coordinates of the base colour, as
    // root_aside takes it.
    asides: array<vec4<f32>, 8>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> instance: Instance;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var base_color_sampler: sampler;

// What a package or a frame does not need is compiled away: a branch on a uniform costs its body on rasterisers that mask
// instead of jump.

// The material has a base-colour texture.
override BASE_COLOR_TEXTURE: bool = false;
// The material cuts away what is less opaque than its alpha_cutoff.
override CUTOUT: bool = false;
// Some vertex leans more than the tile's strands.
override LEAN: bool = false;
// Some vertex has other than the tile's length of hair.
override SHORT: bool = false;

fn normal_ws(v: Vertex) -> vec3<f32> {
    let n = mat3x3(instance.normal_x.xyz, instance.normal_y.xyz, instance.normal_z.xyz) * v.normal;
    return normalize_or(n, vec3(0.0, 1.0, 0.0));
}

fn position_ws(v: Vertex) -> vec3<f32> {
    return (instance.world_from_model * vec4(v.position, 1.0)).xyz;
}

fn tile_frame_of(v: Vertex, normal: vec3<f32>) -> TileFrame {
    let tangent = (instance.world_from_model * vec4(v.tangent.xyz, 0.0)).xyz;
    return tile_frame(normal, tangent, v.tangent.w * instance.handedness);
}

// Place of a vertex at a share of the fur's height, on the hair that grows from it: along the normal, and bent towards the comb
// direction with the square of the height.
fn hair_position(v: Vertex, tile: TileFrame, height: f32) -> vec3<f32> {
    var offset = tile.normal_ws * height;
    if LEAN {
        offset += tile.bitangent_ws * lean_offset(v.lean, height);
    }
    return position_ws(v) + offset * (v.fur_height * instance.scale);
}

// Base colour of the material at a point: factor and vertex colour come interpolated as `tint`.
fn base_color(tint: vec4<f32>, uv: vec2<f32>) -> vec4<f32> {
    if BASE_COLOR_TEXTURE {
        return tint * textureSample(base_color_texture, base_color_sampler, uv);
    }
    return tint;
}

// Whether a texel of that base opacity is cut away.
fn is_cut(alpha: f32) -> bool {
    return CUTOUT && alpha < material.alpha_cutoff;
}
