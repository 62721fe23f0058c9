//! uses hair/constants, hair/hair, hair/packed_light, hair/posed, hair/strand, light/baked, light/deep_forms,
//! light/environment, light/key, light/point, light/scatter, light/visibility, shared/deep_opacity, shared/environment,
//! shared/frame, shared/skinning, shared/tile_frame, surface/place
// Construction of ribbons (formulas 4.10): selects visible strands, assigns vertex positions to them, and writes their
// lit corners. Strands keep their order, so that pictures are reproducible.

// Visibility mask: one bit per strand, 32 per word.
@group(2) @binding(4) var<storage, read_write> seen: array<atomic<u32>>;
// Indirect draw arguments; then, per 32 strands, the number of visible strands before them.
@group(2) @binding(5) var<storage, read_write> counts: array<u32>;
// Corners of the ribbons: world-space position and light.
@group(2) @binding(6) var<storage, read_write> ribbons: array<vec4<u32>>;
@group(2) @binding(7) var<storage, read> deep: array<u32>;
@group(2) @binding(8) var<uniform> deep_opacity: DeepOpacity;

const DRAW_ARGUMENTS: u32 = 5u;
// Minimum cosine between the surface normal and the eye direction at a root; below it, the surface hides the fur.
const FARTHEST_TURNED: f32 = -0.5;
// Size of the frustum, relative to the picture, against which a strand's first, middle and last points are tested.
const MARGIN: f32 = 1.1;

// Returns the factor on the colour of a strand: that of the surface at its root, or 1 for guided hair.
fn strand_tint(strand: Strand) -> vec4<f32> {
    // Guided hair has its own colour.
    if HANGS {
        return vec4(1.0);
    }
    let tint = unpack4x8unorm(strand.color) * material.base_color;
    if BASE_COLOR_TEXTURE {
        return hair_base(tint * textureSampleLevel(base_color_texture, base_color_sampler, strand.base_uv, 0.0));
    }
    return hair_base(tint);
}

// Returns whether a strand is drawn: it grows, is selected, may be in the picture, and its surface is shown and does
// not hide it.
fn may_be_seen(number: u32) -> bool {
    let strand = strands[number];
    if strand.selection >= strand_groom(strand).x * constants.share || is_cut(strand_tint(strand).a) {
        return false;
    }
    let first = number * (constants.points + POSED_BEFORE);
    if posed[first + 1u].w == 0.0 {
        return false;
    }
    let root = first + POSED_BEFORE;
    let position = world_place(root);
    if !HANGS && dot(world_normal(first), direction_to(frame.eye_ws, position)) < FARTHEST_TURNED {
        return false;
    }
    let a = frame.clip_from_world * vec4(position, 1.0);
    let b = frame.clip_from_world * vec4(world_place(root + constants.points / 2u), 1.0);
    let c = frame.clip_from_world * vec4(world_place(root + constants.points - 1u), 1.0);
    let x = vec3(a.x, b.x, c.x);
    let y = vec3(a.y, b.y, c.y);
    let w = vec3(a.w, b.w, c.w);
    let reach = MARGIN * abs(w);
    let aside = all(x > reach) || all(x < -reach) || all(y > reach) || all(y < -reach);
    return !(aside || all(w <= vec3(0.0)));
}

// Selects the visible strands of a part, with one thread per strand.
@compute @workgroup_size(64)
fn select_strands(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let number = number_of(id, groups);
    if number < constants.end && may_be_seen(number) {
        atomicOr(&seen[number / 32u], 1u << (number % 32u));
    }
}

const SCANNERS: u32 = 256u;

var<workgroup> sums: array<u32, 256>;

// Returns the number of segments of a strand.
fn pieces() -> u32 {
    return (constants.points - 1u) / constants.step;
}

// Returns the number of corners of a strand, two per point.
fn corners() -> u32 {
    return 2u * (pieces() + 1u);
}

// Counts, for each group of 32 strands, the visible strands before it, and writes the draw arguments. One workgroup.
@compute @workgroup_size(256)
fn scan_strands(@builtin(local_invocation_index) local: u32) {
    let of_all = constants.count / 32u;
    let each = (of_all + SCANNERS - 1u) / SCANNERS;
    let low = min(local * each, of_all);
    let high = min(low + each, of_all);
    var sum = 0u;
    for (var i = low; i < high; i++) {
        sum += countOneBits(atomicLoad(&seen[i]));
    }
    sums[local] = sum;
    workgroupBarrier();
    var before = 0u;
    for (var i = 0u; i < local; i++) {
        before += sums[i];
    }
    for (var i = low; i < high; i++) {
        counts[DRAW_ARGUMENTS + i] = before;
        before += countOneBits(atomicLoad(&seen[i]));
    }
    if local == SCANNERS - 1u {
        // Index count, two triangles per segment; one instance. First index, base vertex and first instance are 0.
        counts[0] = before * pieces() * 6u;
        counts[1] = 1u;
        counts[2] = 0u;
        counts[3] = 0u;
        counts[4] = 0u;
    }
}

// Returns the share of the key light that reaches a position through the hair in front of it (formulas 4.10). `place`:
// position in the maps.
fn visible_through_strands(place: vec4<f32>) -> f32 {
    if !DEEP_SHADOW {
        return 1.0;
    }
    let at = place.xy / place.w * f32(deep_opacity.size) - 0.5;
    let corner = floor(at);
    let share = at - corner;
    let low = vec2<i32>(corner);
    let x = mix(deep_texel(low, place.z), deep_texel(low + vec2(1, 0), place.z), share.x);
    let y = mix(deep_texel(low + vec2(0, 1), place.z), deep_texel(low + vec2(1, 1), place.z), share.x);
    return mix(x, y, share.y);
}

// Returns the transmittance of the hair in front of a depth, at a texel of the deep opacity map.
fn deep_texel(at: vec2<i32>, depth: f32) -> f32 {
    let texel = vec2<u32>(clamp(at, vec2(0), vec2(i32(deep_opacity.size) - 1)));
    let index = texel.y * deep_opacity.size + texel.x;
    let begin = slabs_begin(1.0 - bitcast<f32>(deep[index]), deep_opacity.whole_from);
    let behind = (depth - begin) * deep_opacity.slabs_per_depth;
    let first = deep_opacity.size * deep_opacity.size + index * deep_opacity.slabs;
    var sum = 0.0;
    for (var i = 0u; i < deep_opacity.slabs; i++) {
        sum += f32(deep[first + i]) * slab_share(behind, i);
    }
    return exp(-deep_opacity.density * OPACITY_STEP * sum * shadowing(behind, deep_opacity.slabs));
}

// Weight of the surface normal at the root in the outward direction of hanging hair (formulas 4.15).
const OUTWARD_NORMAL: f32 = 0.5;

// Returns the outward direction of hanging hair, perpendicular to the hair (formulas 4.15). It is the sum of the offset
// from its root and the surface normal at the root. That side is open; the body is on the other side.
fn outwards(from_root: vec3<f32>, normal: vec3<f32>, tangent: vec3<f32>) -> vec3<f32> {
    let out = from_root + normal * (OUTWARD_NORMAL * length(from_root) + 1e-6);
    return normalize_or(out - tangent * dot(out, tangent), normal);
}

// Converts an sRGB-encoded colour, 0..=1, to linear light (formulas 1.2).
fn srgb_channels(c: vec3<f32>) -> vec3<f32> {
    return select(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, c <= vec3(0.04045));
}

@compute @workgroup_size(64)
fn light_strands(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let number = number_of(id, groups);
    if number >= constants.end {
        return;
    }
    let of_its = atomicLoad(&seen[number / 32u]);
    let bit = 1u << (number % 32u);
    if (of_its & bit) == 0u {
        return;
    }
    let rank = counts[DRAW_ARGUMENTS + number / 32u] + countOneBits(of_its & (bit - 1u));
    let out = rank * corners();
    let strand = strands[number];
    let first = number * (constants.points + POSED_BEFORE);
    let tint = strand_tint(strand);
    let grows = strand_groom(strand).x;
    let wetness = posed[first].w;
    let normal = world_normal(first);
    let along_u = posed[first + 1u];
    let handedness = along_u.w * instance.handedness;
    let skin = tile_frame(normal, (instance.world_from_model * vec4(along_u.xyz, 0.0)).xyz, handedness);
    let length = strand.fur_height * material.share_per_m;
    let root = first + POSED_BEFORE;
    let last = pieces();
    var open = unpack_openness(unpack4x8unorm(strand.groom).zw);
    let at_skin = Spot(world_place(root), skin.normal_ws, vec4(skin.tangent_ws, handedness), open);
    var sky: Sky;
    if !HANGS {
        sky = sky_at(at_skin, skin);
    }

    for (var i = 0u; i <= last; i++) {
        let k = root + i * constants.step;
        let height = posed[k].w;
        let position = world_place(k);
        let before = posed[select(k, k - constants.step, i > 0u)].xyz;
        let after = posed[select(k, k + constants.step, i < last)].xyz;
        let tangent = normalize_or((instance.world_from_model * vec4(after - before, 0.0)).xyz, normal);
        let eye = direction_to(frame.eye_ws, position);

        let of_tile = strand.of_tile * constants.points + i * constants.step;
        let point = tile[of_tile];
        var radius = f32(point.y >> 16u);
        var color = srgb_channels(unpack4x8unorm(point.z).rgb);
        var deeper = color;
        if MULTIPLE && !HANGS {
            let far_below = strand.of_tile * constants.points + i * constants.step / 4u;
            deeper = srgb_channels(unpack4x8unorm(tile[far_below].z).rgb) * tint.rgb;
        }
        var seen_by = unpack4x8unorm(point.w);
        if WET {
            let wet = tile[constants.dry_points + of_tile];
            radius = mix(radius, f32(wet.y >> 16u), wetness);
            color = mix(color, srgb_channels(unpack4x8unorm(wet.z).rgb), wetness);
            seen_by = mix(seen_by, unpack4x8unorm(wet.w), wetness);
        }
        radius *= constants.radius * instance.scale / 65535.0;
        let aside = normalize_or(cross(tangent, eye), skin.tangent_ws) * radius;

        let light = direction_to(frame.light_ws, position);
        let light_ts = to_tile(skin, light);
        let half_ts = to_tile(skin, half_vector(light, eye));
        let place = map_place(position + eye * (radius * radii_towards_eye()));
        let receiver = Receiver(place, height * frame.last_map_layer, true, light_ts.z);
        let past = visible_past_things(receiver);
        if HANGS {
            open = to_tile(skin, outwards(position - world_place(root), normal, tangent));
            sky = sky_at(Spot(position, skin.normal_ws, at_skin.tangent, open), skin);
        }
        sky.eye = to_tile(skin, eye);
        var hair: HairPoint;
        hair.spot = Spot(position, skin.normal_ws, at_skin.tangent, open);
        hair.direction = to_tile(skin, tangent);
        hair.color = color * tint.rgb;
        hair.opacity = 1.0;
        hair.tint = vec3(1.0);
        hair.deeper = deeper;
        hair.wetness = wetness;
        hair.arriving = arriving_at(height, light_ts, half_ts, visible_through_strands(place), past);
        hair.baked.texel = seen_by;
        hair.baked.kept = grows;
        hair.baked.length = length;
        hair.baked.slope = lean_slope(strand.lean, height);
        hair.baked.within = 1.0;
        hair.sky = sky;
        let lit = packed_light(light_hair(hair));
        let left = vec4(bitcast<vec3<u32>>(position - aside), lit);
        let right = vec4(bitcast<vec3<u32>>(position + aside), lit);
        ribbons[out + 2u * i] = left;
        ribbons[out + 2u * i + 1u] = right;
    }
}
