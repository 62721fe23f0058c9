//! uses shared/frame, shared/skinning, shared/tile_frame
// Vertices, positions of vertices and hair, and base colours; shared by all passes over a model's surface.

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) fur_height: f32,
    @location(2) normal: vec3<f32>,
    @location(3) tangent: vec4<f32>,
    @location(4) tile_uv: vec2<f32>,
    @location(5) base_uv: vec2<f32>,
    @location(6) color: vec4<f32>,
    @location(7) lean: f32,
    // Bareness and wetness, then the packed openness of the body.
    @location(8) groom: vec4<f32>,
}

struct Material {
    base_color: vec4<f32>,
    // Minimum opacity of fragments that are not discarded; 0 discards none.
    alpha_cutoff: f32,
    // Reciprocal of the height of the tile's hair, 1/m; 0 if there is none.
    share_per_m: f32,
    // Coefficient k with which lights fade near the horizon, 1 - exp(-k z).
    horizon: f32,
    // Index of the fur's fibre in the package.
    fibre: u32,
    // Sine of the angle behind the terminator up to which hair tips are lit. Near the outline, hair extends beyond the
    // surface that blocks the light.
    rim: f32,
    // Height of the tile's hair, in widths of the tile.
    hair_tiles: f32,
    // Colour of hair in place of the base colour, if HAIR_COLOR.
    hair_color: vec4<f32>,
    // Roughness, reflectance and metalness of bare surface; then 1 if it is wet, else 0. Used if GLOSS.
    gloss: vec4<f32>,
    // Sideways offsets of hair from its root, in texture coordinates of the base colour, in the form that root_aside
    // expects. They are sampled at evenly spaced heights from the mesh surface to the outermost layer.
    asides: array<vec4<f32>, 8>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> instance: Instance;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var base_color_sampler: sampler;

// Overrides compile away features that a package or frame does not need. On rasterisers that mask instead of branching,
// a branch on a uniform costs as much as its body.

// Whether the material has a base-colour texture.
override BASE_COLOR_TEXTURE: bool = false;
// Whether the material discards fragments whose opacity is below its alpha_cutoff.
override CUTOUT: bool = false;
// Whether hair of the material has a colour of its own in place of the base colour.
override HAIR_COLOR: bool = false;
// Whether at least one vertex leans more than the tile's strands.
override LEAN: bool = false;
// Whether at least one vertex has hair of another length than the tile's.
override SHORT: bool = false;

// Returns the vertex with the normal by which bare surface is lit. `bare`: its components along +u and +v of the tile.
fn with_bare_normal(v: Vertex, bare: vec2<f32>) -> Vertex {
    let tile = tile_frame(normalize_or(v.normal, vec3(0.0, 1.0, 0.0)), v.tangent.xyz, v.tangent.w);
    let along = sqrt(max(1.0 - dot(bare, bare), 0.0));
    var out = v;
    out.normal = tile.tangent_ws * bare.x + tile.bitangent_ws * bare.y + tile.normal_ws * along;
    return out;
}

// Returns the unit normal of a vertex in world space.
fn normal_ws(v: Vertex) -> vec3<f32> {
    let n = mat3x3(instance.normal_x.xyz, instance.normal_y.xyz, instance.normal_z.xyz) * v.normal;
    return normalize_or(n, vec3(0.0, 1.0, 0.0));
}

// Returns the position of a vertex in world space.
fn position_ws(v: Vertex) -> vec3<f32> {
    return (instance.world_from_model * vec4(v.position, 1.0)).xyz;
}

// Returns the tile frame at a vertex. `normal`: its unit normal in world space.
fn tile_frame_of(v: Vertex, normal: vec3<f32>) -> TileFrame {
    let tangent = (instance.world_from_model * vec4(v.tangent.xyz, 0.0)).xyz;
    return tile_frame(normal, tangent, v.tangent.w * instance.handedness);
}

// Returns the world-space position of a point of the hair that grows from a vertex: P(h) of formulas 2.5. `height`:
// height relative to the fur height. The offset is along the normal, and bends towards the comb direction with the
// square of the height.
fn hair_position(v: Vertex, tile: TileFrame, height: f32) -> vec3<f32> {
    var offset = tile.normal_ws * height;
    if LEAN {
        offset += tile.bitangent_ws * lean_offset(v.lean, height);
    }
    return position_ws(v) + offset * (v.fur_height * instance.scale);
}

// Returns the base colour of the material at a point. `tint`: interpolated product of the base colour factor and the
// vertex colour.
fn base_color(tint: vec4<f32>, uv: vec2<f32>) -> vec4<f32> {
    if BASE_COLOR_TEXTURE {
        return tint * textureSample(base_color_texture, base_color_sampler, uv);
    }
    return tint;
}

// Returns the factor on the colour of hair where the surface has the base colour `base`. Opacity is that of the
// surface.
fn hair_base(base: vec4<f32>) -> vec4<f32> {
    if HAIR_COLOR {
        return vec4(material.hair_color.rgb, base.a);
    }
    return base;
}

// Returns whether a texel with this opacity is discarded.
fn is_cut(alpha: f32) -> bool {
    return CUTOUT && alpha < material.alpha_cutoff;
}
