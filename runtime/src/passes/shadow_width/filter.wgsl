// Filter from depth maps to the shadow-width map (Yang 2006, sec. 4; formulas 4.4). The occlusion is downsampled and
// upsampled, so that its grey measures the distance to a shadow edge. Texel layout as in shared/soft_shadow.wgsl.

struct Filter {
    // Distance of the near clip plane of the light's projection; 0 for a distant light, whose depth is linear.
    near: f32,
    // Distance of the far clip plane of the light's projection.
    far: f32,
    // Side of the square block of texels that the filter reduces to one texel, texels.
    shrink: i32,
    // Minimum depth difference, 0..=1, at which two surfaces in one texel count as different.
    least_gap: f32,
    // Minimum depth difference, 0..=1, at which a texel and its surroundings count as different surfaces.
    clear_gap: f32,
    reserved0: f32,
    reserved1: f32,
    reserved2: f32,
}

@group(0) @binding(0) var<uniform> params: Filter;
@group(0) @binding(1) var nearest: texture_depth_2d;
@group(0) @binding(2) var farthest: texture_depth_2d;
// Transmittance of all hair together.
@group(0) @binding(3) var hair: texture_2d<f32>;
@group(0) @binding(4) var shrunk: texture_2d<f32>;
@group(0) @binding(5) var linear_sampler: sampler;
@group(0) @binding(6) var blocks: texture_2d<f32>;

// Full-screen triangle.
@vertex
fn vs_filter(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Returns the depth 0..=1, linear in distance.
fn even_depth(z: f32) -> f32 {
    if params.near == 0.0 {
        return z;
    }
    let distance = params.near * params.far / (params.far - z * (params.far - params.near));
    return (distance - params.near) / (params.far - params.near);
}

// Returns two depths for each block of texels. The first is the depth of the farthest light-facing surface, or 0 if
// there is none. The second is the maximum, over the texels, of the depth of the surface nearest to the light.
@fragment
fn fs_deepest(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let last = vec2<i32>(textureDimensions(farthest)) - 1;
    let corner = vec2<i32>(position.xy) * params.shrink;
    var deepest = 0.0;
    var first = 0.0;
    for (var y = 0; y < params.shrink; y++) {
        for (var x = 0; x < params.shrink; x++) {
            let at = min(corner + vec2(x, y), last);
            deepest = max(deepest, textureLoad(farthest, at, 0));
            let z = textureLoad(nearest, at, 0);
            // An empty texel casts no shadow.
            first = max(first, select(0.0, z, z < 1.0));
        }
    }
    return vec4(even_depth(deepest), even_depth(first), 0.0, 0.0);
}

// Number of blocks on each side that are searched for surfaces in the shadow of a texel.
const REACH: i32 = 1;

// Slope and offset of the ramp from the blurred hair to the hair over the texel itself. The ramp depends on the depth
// step beside the texel. It begins at a step of 1/2 clear_gap and ends at 3/4 clear_gap.
const STEP_SLOPE: f32 = 4.0;
const STEP_OFFSET: f32 = 2.0;

// Returns the blurred occlusion. A texel casts a shadow if its farthest light-facing surface is not its nearest
// surface. It also casts one if a light-facing surface in this block or a neighbouring one is deeper by more than
// clear_gap. The two are then not one slanted surface. The second condition is needed because an occluder extends
// beyond the outline of the surface that it shades.
@fragment
fn fs_shrink(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let last = vec2<i32>(textureDimensions(nearest)) - 1;
    let block = vec2<i32>(position.xy);
    let last_block = vec2<i32>(textureDimensions(shrunk)) - 1;
    var around = 0.0;
    for (var y = -REACH; y <= REACH; y++) {
        for (var x = -REACH; x <= REACH; x++) {
            around = max(around, textureLoad(shrunk, clamp(block + vec2(x, y), vec2(0), last_block), 0).r);
        }
    }
    let corner = block * params.shrink;
    var sum = vec4(0.0);
    for (var y = 0; y < params.shrink; y++) {
        for (var x = 0; x < params.shrink; x++) {
            let at = min(corner + vec2(x, y), last);
            let z = textureLoad(nearest, at, 0);
            let near = even_depth(z);
            let shades = even_depth(textureLoad(farthest, at, 0)) - near > params.least_gap
                || around - near > params.clear_gap;
            let light = textureLoad(hair, min(at, vec2<i32>(textureDimensions(hair)) - 1), 0).r;
            // Empty texels have no weight.
            sum += vec4(select(vec2(0.0), vec2(1.0, near), shades), select(0.0, 1.0, z < 1.0), light);
        }
    }
    return sum / f32(params.shrink * params.shrink);
}

@fragment
fn fs_stretch(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<i32>(position.xy);
    let uv = position.xy / vec2<f32>(textureDimensions(nearest));
    let blurred = textureSampleLevel(shrunk, linear_sampler, uv, 0.0);
    let first = even_depth(textureLoad(nearest, at, 0));
    // Beside a depth step, blurred hair includes hair over deeper surfaces, which may be behind the surface of this
    // texel. There, only the hair over the texel itself is certain to be above its surface. A slanted surface must not
    // count as a step: clear_gap is the depth that the steepest surface gains over two blocks. The four gathered
    // blocks span one and a half.
    let firsts = textureGather(1, blocks, linear_sampler, uv);
    let deeper = max(max(firsts.x, firsts.y), max(firsts.z, firsts.w)) - first;
    let own = textureLoad(hair, min(at, vec2<i32>(textureDimensions(hair)) - 1), 0).r;
    let light = mix(blurred.w, own, clamp(STEP_SLOPE * deeper / params.clear_gap - STEP_OFFSET, 0.0, 1.0));
    return vec4(blurred.xy / max(blurred.z, 1e-3), first, light);
}
