//! uses shared/frame, shared/skinning, shared/tile_frame
// Vertices, placement of vertices and hair, and base colours, shared by all passes over a model's surface.

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) fur_height: f32,
    @location(2) normal: vec3<f32>,
    @location(3) tangent: vec4<f32>,
    @location(4) tile_uv: vec2<f32>,
    @location(5) base_uv: vec2<f32>,
    @location(6) color: vec4<f32>,
    @location(7) lean: f32,
    // Bareness, wetness; openness of the body, packed.
    @location(8) groom: vec4<f32>,
}

struct Material {
    base_color: vec4<f32>,
    // Smallest opacity that is kept; 0 cuts nothing.
    alpha_cutoff: f32,
    // 1 / height of the tile's hair, metres; 0 if there is none.
    share_per_m: f32,
    // Coefficient k of the fade of lights near the horizon, 1 - exp(-k z).
    horizon: f32,
    // Index of the fur's fibre in the package.
    fibre: u32,
    // Sine of the angle behind the terminator up to which hair tips are lit. Near the outline, hair extends beyond the
    // surface that hides the light.
    rim: f32,
    // Sideways offset of hair from its root, in coordinates of the base colour, as root_aside takes it. Sampled at
    // heights spread evenly from the mesh surface to the outermost layer.
    asides: array<vec4<f32>, 8>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> instance: Instance;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var base_color_sampler: sampler;

// Overrides compile away features that a package or frame does not need. A branch on a uniform costs its body on
// rasterisers that mask instead of jump.

// The material has a base-colour texture.
override BASE_COLOR_TEXTURE: bool = false;
// The material discards fragments less opaque than its alpha_cutoff.
override CUTOUT: bool = false;
// At least one vertex leans more than the tile's strands.
override LEAN: bool = false;
// At least one vertex has a hair length other than the tile's.
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

// Returns the world-space position of a point of the hair that grows from a vertex: P(h) of formulas 2.5. height: share
// of the fur height. The offset is along the normal, and bent towards the comb direction by the square of the height.
fn hair_position(v: Vertex, tile: TileFrame, height: f32) -> vec3<f32> {
    var offset = tile.normal_ws * height;
    if LEAN {
        offset += tile.bitangent_ws * lean_offset(v.lean, height);
    }
    return position_ws(v) + offset * (v.fur_height * instance.scale);
}

// Returns the base colour of the material at a point. tint: factor times vertex colour, interpolated.
fn base_color(tint: vec4<f32>, uv: vec2<f32>) -> vec4<f32> {
    if BASE_COLOR_TEXTURE {
        return tint * textureSample(base_color_texture, base_color_sampler, uv);
    }
    return tint;
}

// Returns whether a texel of that base opacity is discarded.
fn is_cut(alpha: f32) -> bool {
    return CUTOUT && alpha < material.alpha_cutoff;
}
