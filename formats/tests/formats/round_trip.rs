//! Round trips of generated packages: after writing and reading they are equal, value for value and byte for byte.

use crate::common::{self, ktx2_file};
use pelage_formats::*;
use proptest::collection::vec;
use proptest::prelude::*;

fn finite() -> impl Strategy<Value = f32> {
    prop_oneof![any::<f32>().prop_filter("finite", |v| v.is_finite()), Just(-0.0), Just(f32::MIN_POSITIVE / 2.0)]
}

fn text() -> impl Strategy<Value = String> {
    // Include control characters, quotes and other Unicode planes, because nothing in a string may be special.
    vec(any::<char>(), 0..12).prop_map(String::from_iter)
}

prop_compose! {
    fn geometry()(position in [finite(), finite(), finite()], normal in [finite(), finite(), finite()],
        tangent in [finite(), finite(), finite(), finite()], fur_height in 0.0f32..1e6,
        lean in 0.0f32..=1.0) -> GeometryVertex {
        GeometryVertex { position, fur_height, normal, lean, tangent }
    }
}

prop_compose! {
    fn attribute()(tile_uv in [finite(), finite()], base_uv in [finite(), finite()], color in any::<[u8; 4]>(),
        groom in any::<[u8; 2]>()) -> AttributeVertex {
        AttributeVertex { tile_uv, base_uv, color, groom: [groom[0], groom[1], 0, 0] }
    }
}

prop_compose! {
    fn skin(joints: u16)(joints in [0..joints, 0..joints, 0..joints, 0..joints], a in 0.0f32..=0.5, b in 0.0f32..=0.5)
        -> SkinVertex {
        SkinVertex { joints, weights: [a, b, 1.0 - a - b, 0.0] }
    }
}

/// Generates a mesh, with joint weights if there are joints.
fn mesh(joints: u16) -> impl Strategy<Value = MeshData> {
    (1usize..12, 0usize..9).prop_flat_map(move |(vertices, triangles)| {
        let skinned = if joints > 0 { vertices } else { 0 };
        (
            vec(geometry(), vertices),
            vec(attribute(), vertices),
            vec(skin(joints.max(1)), skinned),
            vec(0..vertices as u32, 3 * triangles),
        )
            .prop_map(|(geometry, attributes, skin, indices)| MeshData { geometry, attributes, skin, indices })
    })
}

fn channel(nodes: u32) -> impl Strategy<Value = Channel> {
    use {Interpolation::*, Property::*};
    let property = prop_oneof![Just(Translation), Just(Rotation), Just(Scale)];
    let interpolation = prop_oneof![Just(Step), Just(Linear), Just(Cubic)];
    (0..nodes, property, interpolation, 1usize..6, finite()).prop_map(|(node, property, interpolation, keys, seed)| {
        let numbers = keys * property.components() * if interpolation == Cubic { 3 } else { 1 };
        let times = (0..keys).map(|k| k as f32 * 0.25).collect();
        Channel { node, property, interpolation, times, values: vec![seed; numbers] }
    })
}

fn animation() -> impl Strategy<Value = Animation> {
    let node = (text(), any::<prop::sample::Index>(), any::<bool>(), [finite(), finite(), finite()]);
    (vec(node, 1..6), any::<[u8; 4]>()).prop_flat_map(|(nodes, joints)| {
        let count = nodes.len();
        let nodes: Vec<_> = nodes
            .into_iter()
            .enumerate()
            .map(|(i, (name, parent, child, translation))| Node {
                name,
                parent: (child && i > 0).then(|| parent.index(i) as u32),
                translation,
                rotation: [0.0, 0.0, 0.6, 0.8],
                scale: [1.0, -1.0, 0.0],
            })
            .collect();
        let joints: Vec<_> = joints
            .iter()
            .map(|j| Joint { node: u32::from(*j) % count as u32, inverse_bind: [f32::from(*j); 16] })
            .collect();
        let clips = vec((text(), 0.0f32..1e3, vec(channel(count as u32), 0..4)), 0..3);
        clips.prop_map(move |clips| Animation {
            nodes: nodes.clone(),
            joints: joints.clone(),
            clips: clips.into_iter().map(|(name, duration_s, channels)| Clip { name, duration_s, channels }).collect(),
            ..Animation::default()
        })
    })
}

fn texture() -> impl Strategy<Value = Vec<u8>> {
    let format = prop::sample::select(TextureFormat::ALL.to_vec());
    (format, 1u32..5, 1u32..5, 0u32..4, any::<u8>()).prop_flat_map(|(format, w, h, layers, seed)| {
        let (w, h) = (w * format.block_size(), h * format.block_size());
        (1..=32 - w.max(h).leading_zeros()).prop_map(move |levels| ktx2_file(format, w, h, layers, levels, seed))
    })
}

prop_compose! {
    fn material(textures: usize)(name in text(), base_color in [finite(), finite(), finite(), finite()],
        cutoff in any::<Option<u8>>(), furred: bool, double_sided: bool,
        texture in 0..textures.max(1) as u32) -> Material {
        // In these packages, only the first texture is suitable as base colour.
        let base_color_texture = (textures > 0 && texture == 0).then_some(0);
        let alpha_cutoff = cutoff.map(|c| f32::from(c) / 255.0);
        Material { name, base_color, base_color_texture, groom_texture: None, alpha_cutoff, furred, double_sided }
    }
}

#[derive(Debug, Clone)]
struct Parts {
    manifest: Manifest,
    mesh: Option<MeshData>,
    animation: Option<Animation>,
    textures: Vec<Vec<u8>>,
    unknown: Vec<([u8; 4], Vec<u8>)>,
}

prop_compose! {
    fn package(skinned: bool)(
        animation in animation(),
        has_mesh in prop::bool::weighted(0.8),
        mesh in mesh(if skinned { 4 } else { 0 }),
        textures in vec(texture(), 0..4),
        unknown in vec((any::<[u8; 4]>(), vec(any::<u8>(), 0..40)), 0..3),
        texts in vec(text(), 7),
        numbers in vec(finite(), 8),
        inputs in vec((text(), text(), any::<u64>(), any::<[u8; 32]>()), 0..3),
        warnings in vec(text(), 0..3),
        figures in vec((text(), any::<f64>().prop_filter("finite", |v| v.is_finite()), text()), 0..3),
        cut in any::<prop::sample::Index>(),
    )(
        materials in vec(material(textures.len()), 2),
        animation in Just(animation), has_mesh in Just(has_mesh), mesh in Just(mesh),
        textures in Just(textures), unknown in Just(unknown), texts in Just(texts), numbers in Just(numbers),
        inputs in Just(inputs), warnings in Just(warnings), figures in Just(figures), cut in Just(cut),
    ) -> Parts {
        let mut textures = textures;
        if let Some(first) = textures.first_mut() {
            *first = ktx2_file(TextureFormat::Rgba8Srgb, 3, 5, 0, 2, 0);
        }
        let indices = mesh.indices.len() as u32;
        let first = 3 * cut.index(mesh.indices.len() / 3 + 1) as u32;
        let parts = [(0, first), (first, indices - first)]
            .map(|(first_index, index_count)| Part { material: (first_index > 0).into(), first_index, index_count });
        let warnings_count = warnings.len();
        let manifest = Manifest {
            generator: texts[0].clone(),
            model: texts[1].clone(),
            recipe: texts[2].clone(),
            inputs: inputs.into_iter()
                .map(|(role, name, bytes, sha256)| InputRecord { role, name, bytes, sha256 }).collect(),
            bounds: Bounds {
                min: [numbers[0].min(numbers[1]); 3],
                max: [numbers[0].max(numbers[1]); 3],
                center: [numbers[2], numbers[3], numbers[4]],
                radius: numbers[5].abs(),
            },
            fur: FurInfo { strands: texts[0].len() as u32, patches: 7, ..FurInfo::default() },
            shading: Shading { ambient: [numbers[6]; 3], specular: [numbers[7]; 3], ..Shading::default() },
            materials,
            parts: if has_mesh { parts.to_vec() } else { Vec::new() },
            textures: (0..textures.len()).map(|k| TextureEntry { name: format!("texture-{k}") }).collect(),
            quality: figures.into_iter().map(|(name, value, unit)| QualityFigure { name, value, unit }).collect(),
            warnings,
            coat: None,
            detail: Vec::new(),
            choice: (warnings_count % 2 == 1).then(|| Choice {
                limits: ChoiceLimits { max_bytes: Some(1), ..ChoiceLimits::default() },
                width: 1,
                height: 1,
                views: vec![texts[3].clone()],
                trials: vec![Trial { settings: texts[4..].to_vec(), ..Trial::default() }],
                ..Choice::default()
            }),
        };
        let unknown = unknown
            .into_iter()
            .filter(|(tag, _)| ![*b"MANI", *b"MESH", *b"ANIM", *b"FINS", *b"KTX2", *b"head"].contains(tag))
            .collect();
        Parts { manifest, mesh: has_mesh.then_some(mesh), animation: skinned.then_some(animation), textures, unknown }
    }
}

fn write(parts: &Parts) -> Vec<u8> {
    let mut writer = PackageWriter::new(parts.manifest.clone());
    let mut unknown = parts.unknown.iter();
    // Unknown sections are placed between known ones, and their positions are kept too.
    if let Some((tag, bytes)) = unknown.next() {
        writer = writer.section(Tag(*tag), bytes);
    }
    if let Some(mesh) = &parts.mesh {
        writer = writer.mesh(mesh);
    }
    if let Some(animation) = &parts.animation {
        writer = writer.animation(animation);
    }
    writer = parts.textures.iter().fold(writer, PackageWriter::texture);
    unknown.fold(writer, |w, (tag, bytes)| w.section(Tag(*tag), bytes)).finish().unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn packages_survive_a_round_trip(parts in any::<bool>().prop_flat_map(package)) {
        let bytes = write(&parts);
        prop_assert_eq!(&bytes, &write(&parts), "the same package twice");
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        prop_assert_eq!(package.manifest(), &parts.manifest);
        prop_assert_eq!(package.mesh().unwrap().map(|m| m.to_data()), parts.mesh.clone());
        let animation = package.animation().unwrap();
        prop_assert_eq!(animation.as_deref(), parts.animation.as_ref());
        for (k, texture) in parts.textures.iter().enumerate() {
            let view = package.texture(k as u32).unwrap();
            prop_assert_eq!(view.ktx2, &texture[..]);
            // The `ktx2` crate's own reader finds the same levels.
            let reader = ktx2::Reader::new(&texture[..]).unwrap();
            for (level, data) in reader.levels().enumerate() {
                prop_assert_eq!(view.level(level as u32), data.data);
            }
        }
        let known = [Tag::MANIFEST, Tag::MESH, Tag::ANIMATION, Tag::TEXTURE];
        let kept: Vec<_> = package.sections().iter().enumerate().filter(|(_, s)| !known.contains(&s.tag)).collect();
        prop_assert_eq!(kept.len(), parts.unknown.len());
        for ((index, section), (tag, bytes)) in kept.into_iter().zip(&parts.unknown) {
            prop_assert_eq!(section.tag, Tag(*tag));
            prop_assert_eq!(package.section_bytes(index).unwrap(), &bytes[..]);
        }
        for section in package.sections() {
            prop_assert!(section.offset.is_multiple_of(16));
        }

        // A copy made section by section, as `unpack` and `pack` make it, has the same bytes.
        let mut copy = PackageWriter::new(package.manifest().clone());
        for (index, section) in package.sections().iter().enumerate().skip(1) {
            copy = copy.section(section.tag, package.section_bytes(index).unwrap());
        }
        prop_assert_eq!(copy.finish().unwrap(), bytes.clone());
    }

    #[test]
    fn no_byte_string_makes_the_reader_panic(bytes in vec(any::<u8>(), 0..200), magic: bool, version in 1u32..=3) {
        let bytes = if magic { [&MAGIC[..], &version.to_le_bytes(), &bytes].concat() } else { bytes };
        prop_assert!(!Package::validate(&bytes, &Limits::default()).is_empty());
    }
}

/// Vertex, index and texture data are returned as slices of the input.
#[test]
fn reading_copies_no_section() {
    let bytes = common::sample_package();
    let range = bytes.as_ptr_range();
    let inside = |slice: &[u8]| {
        let part = slice.as_ptr_range();
        assert!(!slice.is_empty() && range.start <= part.start && part.end <= range.end);
    };
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let mesh = package.mesh().unwrap().unwrap();
    for stream in [mesh.geometry, mesh.attributes, mesh.skin, mesh.indices] {
        inside(stream);
        // Streams are aligned within the file, for mapping and uploading in place.
        assert!((stream.as_ptr() as usize - range.start as usize).is_multiple_of(16));
    }
    inside(package.fins().unwrap().unwrap().fins);
    for texture in (0..8).map(|k| package.texture(k).unwrap()) {
        inside(texture.ktx2);
        (0..texture.levels).for_each(|level| inside(texture.level(level)));
    }
    inside(package.section_bytes(5).unwrap());
}

/// A failed `unwrap_err` or a `dbg!` must not print a whole texture.
#[test]
fn debug_output_is_short() {
    let bytes = common::sample_package();
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let texture = format!("{:?}", package.texture(0).unwrap());
    assert!(texture.starts_with("TextureView(rgba8unorm-srgb 4x4, 3 layers, 3 levels, "), "{texture}");
    assert_eq!(format!("{:?}", package.mesh().unwrap().unwrap()), "MeshView(5 vertices, 12 indices, skin)");
    assert!(!format!("{package:?}").contains("137, 80"), "the magic's bytes");
}

#[test]
fn sections_that_a_package_lacks_are_read_as_none() -> Result<(), FormatError> {
    let bytes = common::sample_package();
    let package = common::open(&bytes);
    assert!(package.roots()?.is_none() && package.simplified()?.is_none() && package.strands()?.is_none());
    assert!(package.visibility()?.is_none() && package.visibility_textures()?.is_none());
    assert!(package.ink()?.is_none() && package.ink_textures()?.is_none());
    assert!(package.fibres()?.is_none() && package.fibre_tables()?.is_none());
    assert!(package.openness()?.is_none() && package.bare_normals()?.is_none());
    assert!(package.gloss()?.is_empty() && package.hair_colors()?.is_empty() && package.hair_groups()?.is_empty());
    Ok(())
}
