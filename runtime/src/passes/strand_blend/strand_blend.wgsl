//! uses debug/false_color, hair/nearest, hair/packed_light
// Blending of the gathered hair segments over the picture (formulas 4.11), layer by layer in each tile, the farthest
// first.

@group(0) @binding(0) var<storage, read> keys: array<u32>;
@group(0) @binding(1) var<storage, read> lights: array<u32>;
// Indirect draw arguments, then the tile and layer of each instance.
@group(0) @binding(2) var<storage, read> layers: array<u32>;
@group(0) @binding(3) var<uniform> nearest: NearestHair;

const DRAW_ARGUMENTS: u32 = 4u;

struct TileVarying {
    @builtin(position) position: vec4<f32>,
    // Offset from the corner of the area, pixels.
    @location(0) @interpolate(linear) at: vec2<f32>,
    @location(1) @interpolate(flat) layer: u32,
}

// Returns a corner of the tile that an instance draws. With `first_alone`, only the first layer of a tile is drawn; the
// others collapse into a point.
fn tile_corner(vertex: u32, instance: u32, first_alone: bool) -> TileVarying {
    let tile_and_layer = layers[DRAW_ARGUMENTS + instance];
    let tile = tile_and_layer / NEAREST;
    let layer = tile_and_layer % NEAREST;
    let across = nearest.area.z / TILE;
    // Corners of the two triangles: 0 1 2, 2 1 3.
    let corner = select(5u - vertex, vertex, vertex < 3u);
    let turned = select(corner, 3u, vertex == 5u);
    var at = vec2<f32>(TILE * (vec2(tile % across, tile / across) + vec2(turned & 1u, turned >> 1u)));
    if first_alone && layer != 0u {
        at = vec2(0.0);
    }
    let ndc = vec2(2.0, -2.0) * (at + vec2<f32>(nearest.area.xy)) / nearest.size + vec2(-1.0, 1.0);
    return TileVarying(vec4(ndc, 0.5, 1.0), at, layer);
}

@vertex
fn vs_blend(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> TileVarying {
    return tile_corner(vertex, instance, false);
}

struct Blended {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fs_blend(in: TileVarying) -> Blended {
    let pixel = pixel_number(vec2<u32>(in.at));
    let key = keys[OF_A_PIXEL * pixel + in.layer];
    if key == 0u {
        discard;
    }
    var through = 1.0 - covered_by(key);
    if in.layer == NEAREST - 1u {
        // The last layer also represents all segments behind it.
        through *= exp(-f32(keys[OF_A_PIXEL * pixel + NEAREST]) / OPTICAL_DEPTH);
    }
    let covered = 1.0 - through;
    let color = vec4(covered * unpacked_light(lights[NEAREST * pixel + in.layer]), covered);
    return Blended(false_color_with(color, geometry_color(4u), false), depth_of(key));
}

@vertex
fn vs_depth(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> TileVarying {
    return tile_corner(vertex, instance, true);
}

struct Depth {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

// Writes the depth of the segment at which hair covers more than half of the pixel.
@fragment
fn fs_depth(in: TileVarying) -> Depth {
    let place = OF_A_PIXEL * pixel_number(vec2<u32>(in.at));
    var through = 1.0;
    for (var k = 0u; k < NEAREST; k++) {
        let key = keys[place + k];
        through *= 1.0 - covered_by(key);
        if through < 0.5 {
            return Depth(vec4(0.0), depth_of(key));
        }
    }
    discard;
    return Depth(vec4(0.0), 1.0);
}
