//! Hashed random numbers and smooth noise: stateless functions of seed and position.

use glam::{DVec2, Vec2, Vec3};

/// Returns a well-mixed hash of two numbers: the finaliser of SplitMix64 (Steele, Lea, Flood 2014) applied to each in
/// turn.
pub fn hash(seed: u64, n: u64) -> u64 {
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    mix(mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)) ^ n.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Returns a random number, uniform in 0..1. It uses the top 24 bits of the hash, which an f32 holds exactly.
pub fn uniform(seed: u64, n: u64) -> f32 {
    (hash(seed, n) >> 40) as f32 / (1 << 24) as f32
}

/// Step of [`r2_point`]: powers of the reciprocal of the plastic number, the real root of x³ = x + 1.
pub const R2_STEP: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_2);

/// Returns point `i` of a sequence that covers the unit square evenly at any length (Roberts 2018, "R2"). The sequence
/// is shifted by `shift` and wrapped around.
pub fn r2_point(i: u32, shift: DVec2) -> DVec2 {
    let p = R2_STEP * f64::from(i) + shift;
    p - p.floor()
}

/// Returns a random vector, uniform in the cube -1..1.
pub fn vector(seed: u64, n: u64) -> Vec3 {
    let h = hash(seed, n);
    let component = |shift: u32| ((h >> shift) & 0x1f_ffff) as f32 / (1 << 20) as f32 - 1.0;
    Vec3::new(component(0), component(21), component(42))
}

/// Returns point `index` of `count` stratified random points of the tile. The tile is divided into rows of cells of
/// equal area, with one random point per cell. Unstratified points would leave bald spots.
pub fn stratified(seed: u64, index: u32, count: u32) -> Vec2 {
    let (index, n) = (u64::from(index), u64::from(count));
    let rows = ((n as f64).sqrt().round() as u64).max(1);
    let row = index * rows / n;
    let first = (row * n).div_ceil(rows);
    let cells = ((row + 1) * n).div_ceil(rows) - first;
    let u = ((index - first) as f32 + uniform(seed, index << 8)) / cells as f32;
    let v = (row as f32 + uniform(seed, index << 8 | 1)) / rows as f32;
    Vec2::new(u, v)
}

/// Returns 0 up to `low`, 1 from `high`, with a smooth transition.
pub fn smooth_step(low: f32, high: f32, at: f32) -> f32 {
    let t = ((at - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns the interpolation weight, 0..=1, of the farther of two neighbours at a distance `t`, 0..=1, from the nearer.
/// It has two continuous derivatives (Perlin 2002).
pub fn smooth(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Returns smooth noise in -1..1 along a line, with one random value per unit.
pub fn noise_1d(seed: u64, x: f32) -> Vec3 {
    let cell = x.floor();
    let at = |i: i64| vector(seed, i as u64);
    at(cell as i64).lerp(at(cell as i64 + 1), smooth(x - cell))
}

/// Returns smooth noise in -1..1 at the point `p` = (u, v, h), with `cells` random values per tile width. The noise
/// repeats from tile to tile in u and v, but does not repeat in the height h.
pub fn noise_in_tile(seed: u64, p: Vec3, cells: i64) -> Vec3 {
    let q = p * cells as f32;
    let cell = q.floor();
    let f = (q - cell).map(smooth);
    let (x, y, z) = (cell.x as i64, cell.y as i64, cell.z as i64);
    let at = |i: i64, j: i64, k: i64| {
        let (i, j) = ((x + i).rem_euclid(cells), (y + j).rem_euclid(cells));
        vector(seed, ((z + k) as u64) << 32 ^ (i as u64) << 16 ^ j as u64)
    };
    let row = |j: i64, k: i64| at(0, j, k).lerp(at(1, j, k), f.x);
    let plane = |k: i64| row(0, k).lerp(row(1, k), f.y);
    plane(0).lerp(plane(1), f.z)
}
