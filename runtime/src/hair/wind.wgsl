// Wind velocity. Rust counterpart: formats/src/meaning/hair_motion/wind.rs.

// Wind of a frame: mean velocity, m/s; strength and period of gusts; strength and size of eddies.
struct Wind {
    velocity: vec3<f32>,
    gust: f32,
    gust_s: f32,
    turbulence: f32,
    eddy_m: f32,
    // Time at the end of the frame.
    time_s: f32,
}

// Returns an approximate sine of `turns` revolutions. Only exactly reproducible operations are used, so the result is
// the same on every machine.
fn wave(turns: f32) -> f32 {
    let part = turns - floor(turns + 0.5);
    return 8.0 * part * (1.0 - 2.0 * abs(part));
}

// Amplitudes of the two waves of a gust.
const GUST_WAVES: vec2<f32> = vec2(0.6, 0.4);
// Frequency of the second wave of a gust relative to the first; the two are incommensurable.
const GUST_RATIO: f32 = 2.618;
// Phase of the second wave of a gust, turns.
const GUST_PHASE: f32 = 0.3;

// The two waves of each component of an eddy. xyz: wave vector, turns per eddy size; w: phase, turns.
const EDDY_X1: vec4<f32> = vec4(0.31, 0.83, 0.47, 0.1);
const EDDY_X2: vec4<f32> = vec4(-1.1, 0.4, 1.6, 0.7);
const EDDY_Y1: vec4<f32> = vec4(0.79, -0.29, 0.53, 0.4);
const EDDY_Y2: vec4<f32> = vec4(0.9, 1.7, -0.6, 0.2);
const EDDY_Z1: vec4<f32> = vec4(-0.41, 0.57, 0.71, 0.8);
const EDDY_Z2: vec4<f32> = vec4(1.5, -0.7, 1.0, 0.5);

// Returns the velocity of the air for formulas 2.6 and 2.7.
fn wind_at(wind: Wind, place: vec3<f32>, time_s: f32) -> vec3<f32> {
    let moment = time_s / max(wind.gust_s, 1e-3);
    let swell = GUST_WAVES.x * wave(moment) + GUST_WAVES.y * wave(GUST_RATIO * moment + GUST_PHASE);
    let carried = (place - wind.velocity * time_s) / max(wind.eddy_m, 1e-3);
    let eddy = vec3(
        wave(dot(carried, EDDY_X1.xyz) + EDDY_X1.w) + wave(dot(carried, EDDY_X2.xyz) + EDDY_X2.w),
        wave(dot(carried, EDDY_Y1.xyz) + EDDY_Y1.w) + wave(dot(carried, EDDY_Y2.xyz) + EDDY_Y2.w),
        wave(dot(carried, EDDY_Z1.xyz) + EDDY_Z1.w) + wave(dot(carried, EDDY_Z2.xyz) + EDDY_Z2.w),
    );
    return wind.velocity * (1.0 + wind.gust * swell) + eddy * (0.5 * wind.turbulence * length(wind.velocity));
}
