//! uses light/baked, light/scatter, shared/detail, shared/opacity, shared/tile_frame, surface/place
// Sampling of the hair volume, for all geometries: dry and wet texels of a layer, groom values, and the resampling of
// layers.

@group(1) @binding(3) var groom_texture: texture_2d<f32>;
@group(2) @binding(0) var shell_colors: texture_2d_array<f32>;
@group(2) @binding(1) var shell_directions: texture_2d_array<f32>;
@group(2) @binding(2) var shell_sampler: sampler;
@group(2) @binding(3) var wet_colors: texture_2d_array<f32>;
@group(2) @binding(4) var wet_directions: texture_2d_array<f32>;
@group(2) @binding(5) var visibility: texture_2d_array<f32>;
@group(2) @binding(6) var wet_visibility: texture_2d_array<f32>;

// Whether the direction texture has two components.
override PLANAR_DIRECTIONS: bool = false;
// Whether the number of drawn layers differs from that of baked layers.
override RESAMPLED: bool = false;
// Whether a level of detail drops or fades some of the layers.
override DETAIL: bool = false;
// Whether at least one vertex is bare or wet.
override GROOM_VERTICES: bool = false;
// Whether the material has a groom texture.
override GROOM_TEXTURE: bool = false;
// Whether the package has wet hair, which is mixed in.
override WET: bool = false;

// Whether hair uses the base colour and groom of the surface at its root.
override AT_ROOT: bool = false;

// Threshold of the alpha test for layers: half a step of an 8-bit texel. Fragments below it are invisible and write no
// depth.
const LEAST_ALPHA: f32 = 0.5 / 255.0;

// Returns the height of a drawn layer: 0 on the skin, 1 for the outermost layer (formulas 4.6).
fn height_of(layer: u32) -> f32 {
    return f32(layer) / f32(instance.drawn_layers - 1u);
}

// Returns the layer that the instance `index` of the draw call shows.
fn drawn_layer(index: u32) -> u32 {
    if !DETAIL {
        return index;
    }
    return detail_layer(index, instance.baked_layers, instance.layer_step, instance.layers_gone);
}

// Returns the number of baked layers per drawn layer if the two layer counts differ (formulas 3.2).
fn resampled_exponent() -> f32 {
    return max(f32(instance.baked_layers) - 1.0, 1.0) / (f32(instance.drawn_layers) - 1.0);
}

// Returns the number of baked layers that a drawn layer represents (formulas 4.7).
fn stands_for(layer: u32) -> f32 {
    if DETAIL {
        let baked = instance.baked_layers;
        return detail_exponent(
            layer, baked, instance.layer_step, instance.layers_gone, instance.detail_here, instance.detail_next,
        );
    }
    if RESAMPLED {
        return resampled_exponent();
    }
    return 1.0;
}

// Returns the groom at a point: share of the hair that grows, and wetness, both 0..=1. `at_vertex`: interpolated
// bareness and wetness.
fn groom_at(at_vertex: vec2<f32>, uv: vec2<f32>) -> vec2<f32> {
    var groom = groom_of_vertex(at_vertex);
    if GROOM_TEXTURE {
        groom = groom_with(groom, textureSample(groom_texture, base_color_sampler, uv));
    }
    return groom;
}

// Returns the groom from vertex attributes alone: share of the hair that grows, and wetness. `at_vertex`: bareness and
// wetness.
fn groom_of_vertex(at_vertex: vec2<f32>) -> vec2<f32> {
    if GROOM_VERTICES {
        return vec2(1.0 - at_vertex.x, at_vertex.y);
    }
    return vec2(1.0, 0.0);
}

// Applies a texel of the groom texture to a groom.
fn groom_with(groom: vec2<f32>, texel: vec4<f32>) -> vec2<f32> {
    return vec2(groom.x * texel.x, min(groom.y + texel.y, 1.0));
}

// Maximum distance over which hair shadows hair where the key light grazes the surface, in lengths of the hair.
const FARTHEST_SHADOW: f32 = 6.0;

// Returns the share of the hair that grows at a point or where the key light passes on its way to it, whichever is
// larger (formulas 4.9). Beside a bare place, the point itself has little hair, but the light has often passed through
// full fur. `height`: relative height of the point; `share`: hair length relative to the tile's. Takes derivatives, so
// control flow must be uniform.
fn kept_towards(at: KeptAt, light_ts: vec3<f32>, height: f32, share: f32) -> f32 {
    if !GROOM_TEXTURE || !BAKED_SHADOW {
        return at.kept;
    }
    // Derivatives of the texture coordinates with respect to those of the tile.
    let x = dpdx(at.tile_uv);
    let y = dpdy(at.tile_uv);
    let area = x.x * y.y - x.y * y.x;
    let along_u = dpdx(at.uv) * y.y - dpdy(at.uv) * x.y;
    let along_v = dpdy(at.uv) * x.x - dpdx(at.uv) * y.x;
    // Path of the light through the hair above the point, in hair lengths, and its middle.
    let slant = light_ts.xy / max(light_ts.z, 1e-3);
    let path = min(length(slant) * (1.0 - height), FARTHEST_SHADOW);
    let middle = slant * (0.5 * path / max(length(slant), 1e-6) * share * material.hair_tiles);
    let aside = (along_u * middle.x + along_v * middle.y) / select(1e20, area, abs(area) > 1e-20);
    // Texels of this mip level are as wide as the distance to the middle.
    let texels = length(aside * vec2<f32>(textureDimensions(groom_texture)));
    let texel = textureSampleLevel(groom_texture, base_color_sampler, at.uv + aside, log2(max(texels, 1.0)));
    let there = groom_with(groom_of_vertex(at.groom), texel).x;
    // Each two lengths of a path block light independently.
    return max(at.kept, 1.0 - pow(1.0 - min(there, 1.0), max(0.5 * path, 1.0)));
}

// Place at which kept_towards looks up hair.
struct KeptAt {
    // Share of the hair that grows at the point.
    kept: f32,
    // Bareness and wetness of the vertices, interpolated.
    groom: vec2<f32>,
    // Texture coordinates of the base colour.
    uv: vec2<f32>,
    tile_uv: vec2<f32>,
}

// Index of the last element of Material.asides.
const LAST_ASIDE: f32 = 7.0;

// Returns the offset of hair from its root at a relative height in the fur, in the form that root_aside expects.
fn aside_at(height: f32) -> vec3<f32> {
    let at = clamp(height, 0.0, 1.0) * LAST_ASIDE;
    let below = min(u32(at), u32(LAST_ASIDE) - 1u);
    return mix(material.asides[below].xyz, material.asides[below + 1u].xyz, at - f32(below));
}

// Returns the base colour and groom of hair that is visible at `uv` and has its root at `root`. The mip level depends
// only on `uv`, because roots change abruptly from hair to hair.
fn base_color_at_root(tint: vec4<f32>, uv: vec2<f32>, root: vec2<f32>) -> vec4<f32> {
    if AT_ROOT && BASE_COLOR_TEXTURE {
        return tint * textureSampleGrad(base_color_texture, base_color_sampler, root, dpdx(uv), dpdy(uv));
    }
    return base_color(tint, uv);
}

// Returns the groom of hair that is visible at `uv` and has its root at `root`, as base_color_at_root does for colour.
fn groom_at_root(at_vertex: vec2<f32>, uv: vec2<f32>, root: vec2<f32>) -> vec2<f32> {
    var groom = groom_of_vertex(at_vertex);
    if GROOM_TEXTURE {
        groom = groom_with(groom, textureSampleGrad(groom_texture, base_color_sampler, root, dpdx(uv), dpdy(uv)));
    }
    return groom;
}

// Returns the baked lighting data at a point of a layer (formulas 4.9).
fn baked_at(uv: vec2<f32>, layer: u32, wetness: f32, kept: f32, length: f32, slope: f32) -> Baked {
    var texel = vec4(1.0);
    if BAKED_SHADOW {
        let level = instance.map_level;
        texel = textureSampleLevel(visibility, shell_sampler, uv, layer, level);
        if WET {
            texel = mix(texel, textureSampleLevel(wet_visibility, shell_sampler, uv, layer, level), wetness);
        }
    }
    var baked: Baked;
    baked.texel = texel;
    baked.kept = kept;
    baked.length = length;
    baked.slope = slope;
    baked.within = 1.0;
    return baked;
}

// Sample of the hair volume.
struct Hair {
    // Premultiplied colour and opacity.
    color: vec4<f32>,
    // Direction in the tile frame.
    direction: vec3<f32>,
}

// Returns the dry hair of a layer. For fins, `layer` is the array layer of the fin texture.
fn dry_hair_at(uv: vec2<f32>, layer: u32) -> Hair {
    let color = textureSample(shell_colors, shell_sampler, uv, layer);
    let direction = decode_direction(textureSample(shell_directions, shell_sampler, uv, layer), PLANAR_DIRECTIONS);
    return Hair(color, direction);
}

// Returns the mean colour of the dry hair of a layer, or `known` if multiple scattering is off.
fn mean_of_layer(layer: u32, known: vec3<f32>) -> vec3<f32> {
    if !MULTIPLE {
        return known;
    }
    let mean = mean_texel(shell_colors, layer);
    return mean.rgb / max(mean.a, 1e-3);
}

// Loads the mean of a layer from its last mip level.
fn mean_texel(texture: texture_2d_array<f32>, layer: u32) -> vec4<f32> {
    return textureLoad(texture, vec2(0), layer, textureNumLevels(texture) - 1u);
}

// Returns the mean of the hair of a layer.
fn mean_hair_of_layer(layer: u32, wetness: f32) -> Hair {
    let direction = decode_direction(mean_texel(shell_directions, layer), PLANAR_DIRECTIONS);
    let dry = Hair(mean_texel(shell_colors, layer), direction);
    if !WET {
        return dry;
    }
    let wet = decode_direction(mean_texel(wet_directions, layer), PLANAR_DIRECTIONS);
    return Hair(mix(dry.color, mean_texel(wet_colors, layer), wetness), mix(dry.direction, wet, wetness));
}

// Returns the mean of the baked visibility of a layer, for full hair of the tile's length.
fn mean_baked_of_layer(layer: u32, wetness: f32) -> Baked {
    var texel = vec4(1.0);
    if BAKED_SHADOW {
        texel = mean_texel(visibility, layer);
        if WET {
            texel = mix(texel, mean_texel(wet_visibility, layer), wetness);
        }
    }
    return Baked(texel, 1.0, 1.0, 0.0, 1.0);
}

// Returns the hair of a layer, mixed from dry and wet hair.
fn hair_at(uv: vec2<f32>, layer: u32, wetness: f32) -> Hair {
    let dry = dry_hair_at(uv, layer);
    if !WET {
        return dry;
    }
    let wet_color = textureSample(wet_colors, shell_sampler, uv, layer);
    let wet = decode_direction(textureSample(wet_directions, shell_sampler, uv, layer), PLANAR_DIRECTIONS);
    return Hair(mix(dry.color, wet_color, wetness), mix(dry.direction, wet, wetness));
}

// Returns the length of the hair that grows from a vertex, relative to the tile's hair.
fn length_share(v: Vertex) -> f32 {
    return v.fur_height * material.share_per_m;
}

// Returns the direction of hair, adjusted to the length and lean of the vertices (formulas 2.5). `share`: length
// relative to the tile's hair; `slope`: slope that the lean adds.
fn grown(direction: vec3<f32>, share: f32, slope: f32) -> vec3<f32> {
    if SHORT || LEAN {
        return hair_direction(direction, select(1.0, share, SHORT), slope);
    }
    return direction;
}

// Returns the path length through layers, relative to their thickness, for hair of relative length `share` (formulas
// 4.2). `path`: the same for hair of full length.
fn path_through(path: f32, share: f32) -> f32 {
    if SHORT {
        return shortened_path(path, share);
    }
    return path;
}
