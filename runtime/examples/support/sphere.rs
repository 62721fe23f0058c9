//! A furry sphere as a package, made in code; a crude stand-in for `pelage bake`.

use pelage_runtime::formats::{
    Animation, AttributeVertex, Bounds, Channel, Clip, FurInfo, GeometryVertex, InkData, InkInfo, InkShading,
    InkVertex, Interpolation, Joint, Manifest, Material, MeshData, Node, PackageWriter, Part, Property, Shading,
    SkinVertex, TextureEntry, TextureFormat, encode_direction,
};
use pelage_runtime::glam::{Quat, Vec2, Vec3};

/// Parameters of the sphere.
#[derive(Clone, Debug)]
pub struct SphereParams {
    /// Quads along an edge of the cube that is projected to the sphere; `12 * quads * quads` triangles.
    pub quads: u32,
    /// Radius of the mesh surface, metres.
    pub radius_m: f32,
    /// Height of the fur, metres.
    pub height_m: f32,
    /// Layers of the hair volume, skin layer included.
    pub layers: u32,
    /// Texels along an edge of the tile.
    pub texels: u32,
    /// Hairs in the tile.
    pub strands: u32,
    /// Tiles along an edge of the cube.
    pub tiles: u32,
    /// Lean of the hairs at their tips, in heights of the fur.
    pub lean: f32,
    /// Whether directions have two components; else three.
    pub planar_directions: bool,
    /// Whether the base colour is a texture of stripes; else it is plain.
    pub stripes: bool,
    /// Whether the base colour is an all-white texture: the same fur through another shader.
    pub white_texture: bool,
    /// Whether there is a skeleton: two joints, the upper of which bends in the clip `bend`.
    pub skeleton: bool,
    /// Whether there is a bare band around the equator with its own material.
    pub bare_band: bool,
    /// Whether the ink style is included: a wash that fades from the top, a hard rim, plain paper.
    pub ink: bool,
}

impl Default for SphereParams {
    fn default() -> Self {
        Self {
            quads: 21,
            radius_m: 0.1,
            height_m: 0.025,
            layers: 16,
            texels: 64,
            strands: 260,
            tiles: 4,
            lean: 0.9,
            planar_directions: true,
            stripes: false,
            white_texture: false,
            skeleton: false,
            bare_band: false,
            ink: false,
        }
    }
}

/// A small reproducible generator of random numbers in 0..1 (Steele's SplitMix64).
pub struct Random(pub u64);

impl Random {
    /// Returns the next number.
    pub fn next_f32(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// Returns the package of the sphere, as bytes.
pub fn package(params: &SphereParams) -> Vec<u8> {
    let mesh = mesh(params);
    let bare = if params.bare_band { bare_indices(params) } else { 0 };
    let manifest = manifest(params, mesh.indices.len() as u32, bare);
    let (colors, directions) = hair(params);
    let mut writer = PackageWriter::new(manifest).mesh(&mesh).texture(colors).texture(directions);
    if params.stripes || params.white_texture {
        let white = |x: u32| params.white_texture || (x / 4).is_multiple_of(2);
        let row = |x: u32| if white(x) { [255, 255, 255, 255] } else { [60, 40, 30, 255] };
        let texels = (0..64u32 * 64).flat_map(|i| row(i % 64)).collect();
        writer = writer.texture(super::ktx2::write(TextureFormat::Rgba8Srgb, 64, 64, 1, &[texels]));
    }
    if params.skeleton {
        writer = writer.animation(&skeleton());
    }
    if params.ink {
        let first = 2 + u32::from(params.stripes || params.white_texture);
        writer = ink_textures().into_iter().fold(writer.ink(&ink(params, &mesh, first)), PackageWriter::texture);
    }
    writer.finish().unwrap()
}

/// Returns the manifest for a mesh of `index_count` indices, the last `bare` of which are the band's.
pub fn manifest(params: &SphereParams, index_count: u32, bare: u32) -> Manifest {
    let outer = params.radius_m;
    let material = |name: &str, base_color, furred| Material {
        name: name.into(),
        base_color,
        groom_texture: None,
        base_color_texture: ((params.stripes || params.white_texture) && furred).then_some(2),
        alpha_cutoff: None,
        furred,
        double_sided: false,
    };
    let mut texture_names = vec!["shell_color", "shell_direction"];
    if params.stripes || params.white_texture {
        texture_names.push("stripes");
    }
    if params.ink {
        texture_names.extend(["ink_stroke", "ink_wash", "ink_paper", "ink_fur"]);
    }
    let mut parts = vec![Part { material: 0, first_index: 0, index_count: index_count - bare }];
    if bare > 0 {
        parts.push(Part { material: 1, first_index: index_count - bare, index_count: bare });
    }
    Manifest {
        generator: "furry sphere".into(),
        model: "sphere".into(),
        bounds: Bounds { min: [-outer; 3], max: [outer; 3], center: [0.0; 3], radius: outer },
        fur: FurInfo {
            layers: params.layers,
            tile_texels: params.texels,
            tile_size_m: params.radius_m * std::f32::consts::FRAC_PI_2 / params.tiles as f32,
            height_m: params.height_m,
            strands: params.strands,
            patches: 6,
            color_texture: 0,
            direction_texture: 1,
            ..FurInfo::default()
        },
        shading: Shading::default(),
        materials: vec![material("fur", [1.0; 4], true), material("band", [0.1, 0.2, 0.6, 1.0], false)],
        parts,
        textures: texture_names.into_iter().map(|name| TextureEntry { name: name.into() }).collect(),
        ..Manifest::default()
    }
}

/// Returns the number of indices of the band: two rows of quads on each of the four upright sides.
fn bare_indices(params: &SphereParams) -> u32 {
    4 * 2 * params.quads * 6
}

/// Returns the mesh: a cube projected to a sphere by equal angles. Each side has whole tiles of its own, so that hair
/// is rotated at the edges, but never cut.
fn mesh(params: &SphereParams) -> MeshData {
    let n = params.quads;
    let mut mesh = MeshData::default();
    let mut band = Vec::new();
    for side in 0..6 {
        // Outward axis, and the two axes of the side with u × v = outward.
        let axis = [Vec3::X, Vec3::Y, Vec3::Z][side % 3] * if side < 3 { 1.0 } else { -1.0 };
        let v_axis = if side % 3 == 1 { Vec3::NEG_Z } else { Vec3::Y };
        let u_axis = v_axis.cross(axis);
        let first = mesh.geometry.len() as u32;
        for j in 0..=n {
            for i in 0..=n {
                let uv = Vec2::new(i as f32, j as f32) / n as f32;
                let tan = ((uv - 0.5) * std::f32::consts::FRAC_PI_2).map(f32::tan);
                let normal = (axis + u_axis * tan.x + v_axis * tan.y).normalize();
                let tangent = (u_axis - normal * normal.dot(u_axis)).normalize();
                mesh.geometry.push(GeometryVertex {
                    position: (normal * params.radius_m).to_array(),
                    fur_height: params.height_m,
                    normal: normal.to_array(),
                    lean: 0.0,
                    tangent: tangent.extend(1.0).to_array(),
                });
                mesh.attributes.push(AttributeVertex {
                    tile_uv: (uv * params.tiles as f32).to_array(),
                    base_uv: uv.to_array(),
                    color: [255; 4],
                    groom: [0; 4],
                });
                if params.skeleton {
                    let upper = (0.5 + 0.5 * normal.y).clamp(0.0, 1.0);
                    mesh.skin.push(SkinVertex { joints: [0, 1, 0, 0], weights: [1.0 - upper, upper, 0.0, 0.0] });
                }
            }
        }
        for j in 0..n {
            for i in 0..n {
                let a = first + j * (n + 1) + i;
                let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
                let in_band = params.bare_band && side % 3 != 1 && j >= n / 2 && j < n / 2 + 2;
                let list = if in_band { &mut band } else { &mut mesh.indices };
                list.extend([a, b, c, a, c, d]);
            }
        }
    }
    mesh.indices.extend(band);
    mesh
}

/// Returns the ink style, with textures from index `first` on.
fn ink(params: &SphereParams, mesh: &MeshData, first: u32) -> InkData {
    let center = Vec3::Y * params.radius_m;
    let vertex = |v: &GeometryVertex| {
        let product = (Vec3::from(v.position) - center).dot(Vec3::from(v.normal)) / params.radius_m;
        let wash = |x: f32| (32767.0 * x.clamp(-1.0, 1.0)).round() as i16;
        let angle = product / ((Vec3::from(v.position) - center).length() / params.radius_m).max(1e-6);
        InkVertex { wash: [wash(0.5 * product), wash(angle)], amount: 255, solid: 0, line: 255, reserved: 0 }
    };
    InkData {
        info: InkInfo {
            stroke_texture: first,
            wash_texture: first + 1,
            paper_texture: first + 2,
            fur_texture: Some(first + 3),
            grain_size_m: params.radius_m,
            shading: InkShading { fur: 0.0, ..InkShading::default() },
        },
        vertices: mesh.geometry.iter().map(vertex).collect(),
    }
}

/// Returns the textures: stroke, wash, paper and fur.
fn ink_textures() -> [Vec<u8>; 4] {
    let write = |n: u32, layers: u32, texel: &dyn Fn(f32, f32) -> [u8; 4]| {
        let at = |i: u32| texel((i % n) as f32 / (n - 1).max(1) as f32, (i / n) as f32 / (n - 1).max(1) as f32);
        let texels = (0..layers).flat_map(|_| (0..n * n).flat_map(at)).collect();
        super::ktx2::write(TextureFormat::Rgba8Unorm, n, n, layers, &[texels])
    };
    let rim = |u: f32, v: f32| {
        let r = 2.0 * Vec2::new(u - 0.5, v - 0.5).length();
        let grey = if r > 0.92 { 0 } else { 255 };
        [grey, grey, 128, 255]
    };
    let mut random = Random(3);
    let speckles: Vec<u8> = (0..64).map(|_| (255.0 * random.next_f32()) as u8).collect();
    let speckle = |u: f32, v: f32| speckles[((7.0 * u) as usize + 8 * (7.0 * v) as usize).min(63)];
    [
        write(64, 1, &rim),
        write(8, 1, &|u, v| [speckle(u, v), speckle(v, u), speckle(1.0 - u, v), 128]),
        write(8, 1, &|u, v| [speckle(v, 1.0 - u), 128, 255, speckle(u, v)]),
        write(8, 2, &|u, _| if u < 0.3 { [255; 4] } else { [0; 4] }),
    ]
}

/// Returns a fixed lower joint, and an upper one that bends to the right and back within a second.
fn skeleton() -> Animation {
    let node = |name: &str, parent| Node {
        name: name.into(),
        parent,
        translation: [0.0; 3],
        rotation: Quat::IDENTITY.to_array(),
        scale: [1.0; 3],
    };
    let mut identity = [0.0; 16];
    identity.iter_mut().step_by(5).for_each(|v| *v = 1.0);
    let turns = [0.0, -0.9, 0.0].map(Quat::from_rotation_z);
    Animation {
        nodes: vec![node("lower", None), node("upper", Some(0))],
        joints: (0..2).map(|node| Joint { node, inverse_bind: identity }).collect(),
        clips: vec![Clip {
            name: "bend".into(),
            duration_s: 1.0,
            channels: vec![Channel {
                node: 1,
                property: Property::Rotation,
                interpolation: Interpolation::Linear,
                times: vec![0.0, 0.5, 1.0],
                values: turns.iter().flat_map(Quat::to_array).collect(),
            }],
        }],
        ..Animation::default()
    }
}

/// A hair: root and lean in the tile, length and shade.
struct Strand {
    root: Vec2,
    lean: Vec2,
    length: f32,
    shade: f32,
}

/// Returns the colour and direction textures of the shells as KTX2.
fn hair(params: &SphereParams) -> (Vec<u8>, Vec<u8>) {
    let mut random = Random(7);
    let strands: Vec<Strand> = (0..params.strands)
        .map(|_| Strand {
            root: Vec2::new(random.next_f32(), random.next_f32()),
            lean: Vec2::new(0.35 * (random.next_f32() - 0.5), -params.lean * (0.7 + 0.6 * random.next_f32())),
            length: 0.7 + 0.3 * random.next_f32(),
            shade: 0.7 + 0.3 * random.next_f32(),
        })
        .collect();
    let n = params.texels as usize;
    // Height of the fur in units of the tile.
    let height = params.height_m / (params.radius_m * std::f32::consts::FRAC_PI_2 / params.tiles as f32);
    let format = if params.planar_directions { TextureFormat::Rg8Unorm } else { TextureFormat::Rgba8Unorm };
    let mut colors = vec![0.0f32; params.layers as usize * n * n * 4];
    let mut directions = vec![0.0f32; params.layers as usize * n * n * 3];
    for layer in 0..params.layers as usize {
        let z = layer as f32 / (params.layers - 1) as f32;
        let mut weights = vec![(0.0f32, 0.0f32, Vec3::ZERO); n * n];
        for strand in strands.iter().filter(|s| s.length >= z) {
            // Lean grows with the square of the height: hairs rise, then bow.
            let center = strand.root + strand.lean * (z * z * height);
            let direction = (strand.lean * (2.0 * z)).extend(1.0).normalize();
            let sigma = (0.9 - 0.45 * z / strand.length).max(0.3);
            let reach = (3.0 * sigma).ceil() as i32;
            let at = center * n as f32 - 0.5;
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    let texel = at.round() + Vec2::new(dx as f32, dy as f32);
                    let w = 2.0 * (-texel.distance_squared(at) / (2.0 * sigma * sigma)).exp();
                    let wrap = |v: f32| (v as i64).rem_euclid(n as i64) as usize;
                    let slot = &mut weights[wrap(texel.y) * n + wrap(texel.x)];
                    *slot = (slot.0 + w, slot.1 + w * strand.shade, slot.2 + direction * w);
                }
            }
        }
        for (texel, (weight, shade, direction)) in weights.into_iter().enumerate() {
            let at = layer * n * n + texel;
            let alpha = if layer == 0 { 1.0 } else { 1.0 - (-weight).exp() };
            let tip = Vec3::new(0.62, 0.47, 0.31).lerp(Vec3::new(0.95, 0.82, 0.62), z);
            let color = tip * if weight > 1e-6 { shade / weight } else { 0.6 } * alpha;
            colors[at * 4..at * 4 + 4].copy_from_slice(&color.extend(alpha).to_array());
            directions[at * 3..at * 3 + 3].copy_from_slice(&direction.try_normalize().unwrap_or(Vec3::Z).to_array());
        }
    }
    let color_bytes = |texels: &[f32]| texels.iter().map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8).collect();
    let direction_bytes = |texels: &[f32]| {
        let encode = |d: &[f32]| encode_direction(Vec3::from_slice(d), format);
        texels.chunks_exact(3).flat_map(|d| encode(d).into_iter().take(format.block_bytes() as usize)).collect()
    };
    let write =
        |format, levels: &[Vec<u8>]| super::ktx2::write(format, params.texels, params.texels, params.layers, levels);
    let color_levels: Vec<_> = mips(colors, n, 4).iter().map(|l| color_bytes(l)).collect();
    let direction_levels: Vec<_> = mips(directions, n, 3).iter().map(|l| direction_bytes(l)).collect();
    (write(TextureFormat::Rgba8Unorm, &color_levels), write(format, &direction_levels))
}

/// Returns the mip levels, means of 2 × 2 texels down to one, layer by layer. The texture is square, its size a power
/// of two.
fn mips(level: Vec<f32>, size: usize, channels: usize) -> Vec<Vec<f32>> {
    let mut levels = vec![level];
    let mut size = size;
    while size > 1 {
        let last = &levels[levels.len() - 1];
        let half = size / 2;
        let layers = last.len() / (size * size * channels);
        let mut next = Vec::with_capacity(last.len() / 4);
        for (layer, y, x) in (0..layers * half * half).map(|i| (i / (half * half), i / half % half, i % half)) {
            let at = |dx: usize, dy: usize| ((layer * size + 2 * y + dy) * size + 2 * x + dx) * channels;
            let quad = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            next.extend((0..channels).map(|c| quad.iter().map(|q| last[q + c]).sum::<f32>() / 4.0));
        }
        levels.push(next);
        size = half;
    }
    levels
}
