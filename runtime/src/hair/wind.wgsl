// Wind velocity. Rust counterpart: formats/src/meaning/hair_motion/wind.rs.

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

fn wind_at(wind: Wind, place: vec3<f32>, time_s: f32) -> vec3<f32> {
    let moment = time_s / max(wind.gust_s, 1e-3);
    let swell = 0.6 * wave(moment) + 0.4 * wave(2.618 * moment + 0.3);
    let carried = (place - wind.velocity * time_s) / max(wind.eddy_m, 1e-3);
    let eddy = vec3(
        wave(dot(carried, vec3(0.31, 0.83, 0.47)) + 0.1) + wave(dot(carried, vec3(-1.1, 0.4, 1.6)) + 0.7),
        wave(dot(carried, vec3(0.79, -0.29, 0.53)) + 0.4) + wave(dot(carried, vec3(0.9, 1.7, -0.6)) + 0.2),
        wave(dot(carried, vec3(-0.41, 0.57, 0.71)) + 0.8) + wave(dot(carried, vec3(1.5, -0.7, 1.0)) + 0.5),
    );
    return wind.velocity * (1.0 + wind.gust * swell) + eddy * (0.5 * wind.turbulence * length(wind.velocity));
}
