//! Helpers shared by several tests: a minimal .ktx2 writer (the real one is in bake) and a package with every kind of
//! section.
#![allow(dead_code, reason = "the tests of the command include this module too, and each uses its own part of it")]
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

pub mod random;

use pelage_formats::*;

/// Returns a .ktx2 file whose data are the bytes `seed`, `seed + 1`, … in file order. With `layers` 0 the texture is
/// not an array.
pub fn ktx2_file(format: TextureFormat, width: u32, height: u32, layers: u32, levels: u32, seed: u8) -> Vec<u8> {
    let (basic, type_size) = ktx2::dfd::Basic::from_format(format.ktx2()).unwrap();
    let descriptor = ktx2::dfd::Block::Basic(basic).to_vec();
    let descriptor_at = ktx2::Header::LENGTH + ktx2::LevelIndex::LENGTH * levels as usize;
    let descriptor_length = descriptor.len() + 4;
    let header = ktx2::Header {
        format: Some(format.ktx2()),
        type_size,
        pixel_width: width,
        pixel_height: height,
        pixel_depth: 0,
        layer_count: layers,
        face_count: 1,
        level_count: levels,
        supercompression_scheme: None,
        index: ktx2::Index {
            dfd_byte_offset: descriptor_at as u32,
            dfd_byte_length: descriptor_length as u32,
            kvd_byte_offset: 0,
            kvd_byte_length: 0,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let mut out = header.as_bytes().to_vec();
    out.resize(descriptor_at, 0);
    out.extend_from_slice(&(descriptor_length as u32).to_le_bytes());
    out.extend_from_slice(&descriptor);
    let alignment = format.block_bytes().max(4) as usize;
    for level in (0..levels).rev() {
        let bytes = format.layer_bytes((width >> level).max(1), (height >> level).max(1)) * u64::from(layers.max(1));
        out.resize(out.len().next_multiple_of(alignment), 0);
        let entry =
            ktx2::LevelIndex { byte_offset: out.len() as u64, byte_length: bytes, uncompressed_byte_length: bytes };
        let at = ktx2::Header::LENGTH + ktx2::LevelIndex::LENGTH * level as usize;
        out[at..at + ktx2::LevelIndex::LENGTH].copy_from_slice(&entry.as_bytes());
        out.extend((0..bytes).map(|i| (i as u8).wrapping_add(seed)));
    }
    out
}

pub fn sample_mesh(skinned: bool) -> MeshData {
    let vertex = |x: f32, y: f32| GeometryVertex {
        position: [x, y, 0.25],
        fur_height: 0.5 * x,
        normal: [0.0, 0.0, 1.0],
        lean: 0.75 * y,
        tangent: [1.0, 0.0, 0.0, -1.0],
    };
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 0.5)];
    let attribute = |(x, y): (f32, f32)| AttributeVertex {
        tile_uv: [4.0 * x, 4.0 * y],
        base_uv: [x, 1.0 - y],
        color: [255, 128, 64, 255],
        groom: [(64.0 * x) as u8, (255.0 * y) as u8, 0, 0],
    };
    MeshData {
        geometry: corners.iter().map(|(x, y)| vertex(*x, *y)).collect(),
        attributes: corners.iter().copied().map(attribute).collect(),
        skin: (0..if skinned { 5 } else { 0 })
            .map(|i| SkinVertex { joints: [i % 2, 1, 0, 0], weights: [0.75, 0.25, 0.0, 0.0] })
            .collect(),
        indices: vec![0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4],
    }
}

pub fn sample_animation() -> Animation {
    let mut inverse_bind = [0.0; 16];
    for diagonal in [0, 5, 10, 15] {
        inverse_bind[diagonal] = 1.0;
    }
    let node = |name: &str, parent| Node {
        name: name.into(),
        parent,
        translation: [0.0, 1.0, 0.0],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [1.0, 2.0, -1.0],
    };
    let channel = |property, interpolation, values: Vec<f32>| Channel {
        node: 1,
        property,
        interpolation,
        times: vec![0.0, 0.5],
        values,
    };
    Animation {
        nodes: vec![node("root", None), node("ear", Some(0))],
        joints: vec![Joint { node: 0, inverse_bind }, Joint { node: 1, inverse_bind }],
        clips: vec![Clip {
            name: "breathe".into(),
            duration_s: 0.5,
            channels: vec![
                channel(Property::Translation, Interpolation::Step, vec![0.0, 1.0, 0.0, 0.0, 1.5, 0.0]),
                channel(Property::Rotation, Interpolation::Linear, vec![0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
                channel(Property::Scale, Interpolation::Cubic, (0..18).map(|i| i as f32 * 0.25).collect()),
            ],
        }],
        ..Animation::default()
    }
}

/// Returns a manifest for [`sample_mesh`] and the textures of [`sample_package`]; no field has its default.
pub fn sample_manifest() -> Manifest {
    Manifest {
        generator: "pelage 0.1.0".into(),
        model: "häre".into(),
        recipe: "[strands]\nlength = 0.03\n".into(),
        inputs: vec![
            InputRecord { role: "model".into(), name: "hare.glb".into(), bytes: 123_456, sha256: [0xab; 32] },
            InputRecord { role: "image".into(), name: String::new(), bytes: 1 << 40, sha256: [7; 32] },
        ],
        bounds: Bounds { min: [0.0, 0.0, 0.25], max: [1.0, 1.0, 0.25], center: [0.5, 0.5, 0.25], radius: 0.75 },
        fur: FurInfo {
            layers: 2,
            tile_texels: 4,
            tile_size_m: 0.25,
            height_m: 0.03,
            strands: 12,
            patches: 3,
            color_texture: 0,
            direction_texture: 1,
            wet: Some(ShellTextures { color_texture: 3, direction_texture: 4 }),
            fins: Some(FinInfo { width: 8, height: 4, slabs: 2, color_texture: 5, direction_texture: 6 }),
        },
        // All values are written out, because golden files must not depend on defaults.
        shading: Shading {
            ambient: [0.25, 0.5, 0.75],
            diffuse: [0.9; 3],
            specular: [0.12; 3],
            diffuse_exponent: 3.5,
            ..Shading::default()
        },
        materials: vec![
            Material {
                name: "fur".into(),
                base_color: [0.5, 0.25, 0.125, 1.0],
                base_color_texture: Some(2),
                groom_texture: Some(7),
                alpha_cutoff: None,
                furred: true,
                double_sided: false,
            },
            Material {
                name: "eyes".into(),
                base_color: [0.0, 0.0, 0.0, 1.0],
                base_color_texture: None,
                groom_texture: None,
                alpha_cutoff: Some(0.5),
                furred: false,
                double_sided: true,
            },
        ],
        parts: vec![
            Part { material: 0, first_index: 0, index_count: 9 },
            Part { material: 1, first_index: 9, index_count: 3 },
        ],
        textures: [
            "shell_color",
            "shell_direction",
            "base-color",
            "wet_color",
            "wet_direction",
            "fin_color",
            "fin_direction",
            "groom",
        ]
        .map(|name| TextureEntry { name: name.into() })
        .to_vec(),
        quality: vec![QualityFigure { name: "angle_distortion".into(), value: 0.0625, unit: "1".into() }],
        warnings: vec!["3 triangles without area were left out".into()],
        coat: Some(FarLayerInfo { height: 0.75, ambient_height: 0.625, light_straight: 0.5, light_slanted: 0.25 }),
        detail: vec![
            DetailLevel { step: 1, full_px: 24.0, gone_px: 18.0, fins: 1.0, density: 1.0 },
            DetailLevel { step: 2, full_px: 12.0, gone_px: 8.0, fins: 0.5, density: 1.25 },
            DetailLevel { step: 0, full_px: 0.0, gone_px: 0.0, fins: 0.0, density: 1.0 },
        ],
        choice: Some(Choice {
            limits: ChoiceLimits { max_error: Some(0.1), max_frame_ms: None, max_bytes: Some(1 << 40) },
            binding: "max_error".into(),
            adapter: "an adapter".into(),
            width: 640,
            height: 480,
            samples: 64,
            views: vec!["--camera front".into(), "--camera 45,10".into()],
            trials: vec![
                Trial {
                    settings: vec!["slice.layers=8".into()],
                    error: Some(0.125),
                    frame_ms: None,
                    bytes: 4096,
                    predicted: true,
                },
                Trial {
                    settings: vec!["slice.layers=16".into(), "slice.tile_texels=64".into()],
                    error: Some(0.0625),
                    frame_ms: Some(3.5),
                    bytes: 65_536,
                    predicted: false,
                },
            ],
            chosen: 1,
            next_better: None,
            next_cheaper: Some(0),
        }),
    }
}

/// Returns [`sample_manifest`] reduced to version 2: the manifest of the golden package of version 2.
pub fn sample_manifest_v2() -> Manifest {
    let mut manifest = sample_manifest();
    manifest.coat = None;
    manifest.detail.clear();
    manifest.choice = None;
    manifest
}

/// Returns [`sample_mesh`] reduced to version 1.
pub fn sample_mesh_v1(skinned: bool) -> MeshData {
    let mut mesh = sample_mesh(skinned);
    mesh.geometry.iter_mut().for_each(|v| v.lean = 0.0);
    mesh.attributes.iter_mut().for_each(|v| v.groom = [0; 4]);
    mesh
}

/// Returns [`sample_manifest`] reduced to version 1: the manifest of the golden package of version 1.
pub fn sample_manifest_v1() -> Manifest {
    let mut manifest = sample_manifest_v2();
    manifest.fur.wet = None;
    manifest.fur.fins = None;
    manifest.materials[0].groom_texture = None;
    manifest.textures.truncate(3);
    manifest
}

/// Returns fins for [`sample_manifest`] and [`sample_mesh`].
pub fn sample_fins() -> FinData {
    let fin = |a, b, start, length, slab| Fin { a, b, start, length, slab, opacity: 0.5 + 0.5 * start };
    FinData {
        part_counts: vec![2, 1],
        fins: vec![fin(0, 1, 0.0, 0.5, 0), fin(2, 1, 0.25, -1.5, 1), fin(4, 0, 1.0, 3.0, 0)],
    }
}

/// Returns a package of version 1 with every kind of section, including one with an unknown tag.
pub fn sample_package_v1() -> Vec<u8> {
    let writer = PackageWriter::new(sample_manifest_v1()).version(1).mesh(&sample_mesh_v1(true));
    first_sections(writer, 2).finish().unwrap()
}

/// Returns a package of version 2 with every kind of section. It begins with the sections of version 1.
pub fn sample_package_v2() -> Vec<u8> {
    let writer = PackageWriter::new(sample_manifest_v2()).version(2).mesh(&sample_mesh(true));
    all_sections(writer, 2).finish().unwrap()
}

/// Returns the sample package with an appended section.
pub fn sample_with(add: impl FnOnce(PackageWriter<'_>) -> PackageWriter<'_>) -> Result<Vec<u8>, FormatError> {
    changed_sample_with(|_| (), add)
}

/// Returns the sample package with a changed manifest and an appended section.
pub fn changed_sample_with(
    change: impl FnOnce(&mut Manifest),
    add: impl FnOnce(PackageWriter<'_>) -> PackageWriter<'_>,
) -> Result<Vec<u8>, FormatError> {
    let bytes = sample_package();
    let package = open(&bytes);
    let mut manifest = package.manifest().clone();
    change(&mut manifest);
    let mut writer = PackageWriter::new(manifest);
    for (index, section) in package.sections().iter().enumerate().skip(1) {
        writer = writer.section(section.tag, package.section_bytes(index)?);
    }
    add(writer).finish()
}

/// Opens a package with the default limits.
pub fn open(bytes: &[u8]) -> Package<'_> {
    Package::open(bytes, &Limits::default()).unwrap()
}

/// Returns the contents of the first section with the tag.
pub fn section_bytes<'a>(package: &Package<'a>, tag: Tag) -> &'a [u8] {
    package.section_bytes(package.sections().iter().position(|s| s.tag == tag).unwrap()).unwrap()
}

/// Change of a sample, and text that the resulting error contains.
pub type Refusal<T> = (fn(&mut T), &'static str);

/// Checks that each change of the sample makes `pack` fail with an error in the section that contains the text.
pub fn assert_refused<T>(
    tag: Tag,
    sample: impl Fn() -> T,
    cases: &[Refusal<T>],
    pack: impl Fn(&T) -> Result<Vec<u8>, FormatError>,
) {
    for (change, expected) in cases {
        let mut changed = sample();
        change(&mut changed);
        let error = pack(&changed).unwrap_err();
        assert_eq!(error.section(), Some(tag), "{error}");
        let error = error.to_string();
        assert!(error.contains(expected), "expected {expected:?} in: {error}");
    }
}

/// Returns a package with every kind of section: the sections of version 2, those added since, one with an unknown tag,
/// and the far layer in the shell textures.
pub fn sample_package() -> Vec<u8> {
    all_sections(PackageWriter::new(sample_manifest()).mesh(&sample_mesh(true)), 3).finish().unwrap()
}

/// Returns two morph targets of the sample's five vertices; the first has weight 0.5 at rest. One curve drives both,
/// another only the second.
pub fn sample_morphs() -> Morphs {
    let delta = |target, position, normal| MorphDelta { target, position, normal, tangent: [0.0, 0.25, 0.0] };
    let target = |name: &str, weight| MorphTarget { name: name.into(), node: 1, weight };
    let channel = |clip, target, count, interpolation, values: &[f32]| MorphChannel {
        clip,
        target,
        count,
        interpolation,
        times: vec![1.0, 2.0],
        values: values.to_vec(),
    };
    Morphs {
        motion: MorphMotion {
            targets: vec![target("smile", 0.5), target("blink", 0.0)],
            channels: vec![
                channel(0, 0, 2, Interpolation::Linear, &[0.5, 0.0, 1.5, 1.0]),
                channel(0, 1, 1, Interpolation::Step, &[0.25, 0.75]),
            ],
        },
        first: vec![0, 2, 2, 3, 3, 3],
        deltas: vec![
            delta(0, [1.0, 0.0, 0.0], [0.0; 3]),
            delta(1, [0.0, 2.0, 0.0], [1.0, 0.0, 0.0]),
            delta(1, [0.0, 0.0, -1.0], [0.0; 3]),
        ],
    }
}

/// Returns [`sample_manifest`] without fur and textures.
pub fn furless_manifest() -> Manifest {
    let mut manifest = sample_manifest();
    (manifest.fur, manifest.coat) = (FurInfo::default(), None);
    manifest.detail.clear();
    manifest.textures.clear();
    for material in &mut manifest.materials {
        material.furred = false;
        (material.base_color_texture, material.groom_texture) = (None, None);
    }
    manifest
}

/// Returns a package of version 3 with the morph targets `morphs`.
pub fn morphed_package(morphs: &Morphs) -> Result<Vec<u8>, FormatError> {
    let writer = PackageWriter::new(furless_manifest()).mesh(&sample_mesh(true)).animation(&sample_animation());
    writer.morphs(morphs).finish()
}

fn all_sections(writer: PackageWriter<'_>, shell_layers: u32) -> PackageWriter<'_> {
    first_sections(writer, shell_layers)
        .fins(&sample_fins())
        .texture(ktx2_file(TextureFormat::Rgba8Srgb, 4, 4, shell_layers, 3, 4))
        .texture(ktx2_file(TextureFormat::Rg8Unorm, 4, 4, shell_layers, 3, 5))
        .texture(ktx2_file(TextureFormat::Bc7Srgb, 8, 4, 2, 1, 6))
        .texture(ktx2_file(TextureFormat::Rgba8Unorm, 8, 4, 2, 1, 7))
        .texture(ktx2_file(TextureFormat::Rg8Unorm, 3, 2, 0, 1, 8))
}

fn first_sections(writer: PackageWriter<'_>, shell_layers: u32) -> PackageWriter<'_> {
    writer
        .animation(&sample_animation())
        .texture(ktx2_file(TextureFormat::Rgba8Srgb, 4, 4, shell_layers, 3, 1))
        .texture(ktx2_file(TextureFormat::Bc5Unorm, 4, 4, shell_layers, 1, 2))
        .section(Tag(*b"XTRA"), &b"a section of a later version"[..])
        .texture(ktx2_file(TextureFormat::Bc7Srgb, 8, 4, 0, 2, 3))
}
