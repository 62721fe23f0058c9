//! uses hair/constants, hair/posed, hair/strand, light/deep_forms, shared/deep_opacity, shared/frame, surface/place
// Rasterisation of a part's strands into the deep opacity map (formulas 4.10). A share of the strands represents all of
// them. The first round finds the nearest hair of each texel. The second adds the area that hair covers in each slab
// behind it. Strands are traversed in steps of at most one texel.

@group(2) @binding(4) var<storage, read_write> deep: array<atomic<u32>>;
@group(2) @binding(5) var nearest_skin: texture_depth_2d;
@group(2) @binding(6) var<uniform> deep_opacity: DeepOpacity;

@group(1) @binding(3) var groom_texture: texture_2d<f32>;
override GROOM_VERTICES: bool = false;
override GROOM_TEXTURE: bool = false;

// Whether the strands are guided hair.
override GUIDED: bool = false;

// Maximum number of steps per segment. A segment that spans the whole map is drawn with gaps.
const MOST_STEPS: f32 = 256.0;
// Minimum cosine between the surface normal and the light direction at a root; below it, fur is unlit.
const FARTHEST_FROM_LIGHT: f32 = -0.5;

// Rasterises a strand: its nearness, or with `deposits`, the area that it covers (formulas 4.10).
fn rasterise_strand(number: u32, deposits: bool) {
    let strand = strands[number];
    if strand.selection >= strand_groom(strand).x * constants.share {
        return;
    }
    let points = constants.points;
    let first = number * (points + POSED_BEFORE);
    var a = world_place(first + POSED_BEFORE);
    // Fur on a surface that faces away from the light is unlit; other hair extends beyond the surface.
    if !GUIDED && dot(world_normal(first), direction_to(frame.light_ws, a)) < FARTHEST_FROM_LIGHT {
        return;
    }
    let side = f32(deep_opacity.size);
    var place_a = map_texel(a, side);
    for (var i = constants.step; i < points; i += constants.step) {
        let b = world_place(first + POSED_BEFORE + i);
        let place_b = map_texel(b, side);
        let texels = distance(place_a.xy, place_b.xy);
        let steps = clamp(ceil(texels), 1.0, MOST_STEPS);
        let middle = strand.of_tile * points + i - constants.step / 2u;
        let radius = f32(tile[middle].y >> 16u) / 65535.0 * constants.radius * instance.scale;
        for (var k = 0.5; k < steps; k += 1.0) {
            let share = k / steps;
            let p = mix(place_a, place_b, share);
            let texel = vec2<i32>(floor(p.xy));
            if any(texel < vec2(0)) || any(texel >= vec2(i32(deep_opacity.size))) {
                continue;
            }
            let clip = frame.clip_from_world * vec4(mix(a, b, share), 1.0);
            let skin_texel = texel * vec2<i32>(textureDimensions(nearest_skin)) / i32(deep_opacity.size);
            if clip.z / clip.w > textureLoad(nearest_skin, skin_texel, 0) {
                continue;
            }
            let index = u32(texel.y) * deep_opacity.size + u32(texel.x);
            if !deposits {
                atomicMax(&deep[index], nearness(p.z));
                continue;
            }
            let begin = slabs_begin(1.0 - bitcast<f32>(atomicLoad(&deep[index])), deep_opacity.whole_from);
            let behind = (p.z - begin) * deep_opacity.slabs_per_depth;
            if !is_kept(behind, deep_opacity.slabs) {
                continue;
            }
            let slab = slab_of(behind, deep_opacity.slabs);
            let area = 2.0 * radius / (deep_opacity.texel_m * p.w) * (texels / steps);
            let of_texels = deep_opacity.size * deep_opacity.size;
            let opacity = u32(area / OPACITY_STEP + 0.5);
            atomicAdd(&deep[of_texels + index * deep_opacity.slabs + slab], opacity);
            if GUIDED {
                atomicAdd(&deep[of_texels * (1u + deep_opacity.slabs) + index], opacity);
            }
        }
        a = b;
        place_a = place_b;
    }
}

// Returns texel coordinates in the map, depth, and distance from a point light; 1 for a distant one.
fn map_texel(position: vec3<f32>, side: f32) -> vec4<f32> {
    let place = frame.map_from_world * vec4(position, 1.0);
    return vec4(place.xy / place.w * side, place.zw);
}

// Returns a number that increases with nearness to the light; 0 means no hair.
fn nearness(depth: f32) -> u32 {
    return bitcast<u32>(clamp(1.0 - depth, 0.0, 1.0));
}

@compute @workgroup_size(64)
fn find_first(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let number = number_of(id, groups);
    if number < constants.end {
        rasterise_strand(number, false);
    }
}

@compute @workgroup_size(64)
fn add_opacity(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let number = number_of(id, groups);
    if number < constants.end {
        rasterise_strand(number, true);
    }
}
