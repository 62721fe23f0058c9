//! Tests that all shaders are valid, and that their structs match the Rust structs byte for byte.

use crate::contours::{ContourBlock, ContourNode, LineNode};
use crate::frame::PASSES;
use crate::gpu::WORKGROUP;
use crate::guide_motion::WindBlock;
use crate::ink::{InkFrame, InkModel};
use crate::model::{PoolPoint, PoolStroke, Strand, StrandConstants, SurfacePoint};
use crate::painting::{BrushPoint, PaintedModel, PaintingFrame};
use crate::passes::fur_motion::FurMotion;
use crate::passes::hair_motion::HairMotion;
use crate::passes::ink_normals::{INK_ATTRIBUTES, REST_ATTRIBUTES};
use crate::passes::ink_seal::StampedSeal;
use crate::passes::{
    fins, fur_motion, hair_motion, ink_contours, ink_fur, ink_lines, ink_normals, ink_seal, ink_stroke,
    painting_ribbons, painting_sheet, painting_strokes, painting_wet, pose, shadow_width, shells, skin, strand_blend,
    strand_gather, strand_light, strand_pose, strand_shadow, strands,
};
use crate::scene::{NEAREST, NearestHairBlock, TILE};
use crate::shared::deep_opacity::{self, DeepOpacity};
use crate::shared::shader_struct::ShaderStruct;
use crate::shared::{frame, receiver, scattering, soft_shadow};
use crate::surface::{ATTRIBUTE_ATTRIBUTES, GEOMETRY_ATTRIBUTES, MaterialUniform, SCAN_WORKGROUP};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{ScalarKind, TypeInner, VectorSize};
use pelage_formats::meaning::environment::Environment;
use pelage_formats::meaning::{FIN_CORNERS, LEANING_ROWS};
use pelage_formats::{AttributeVertex, Fin, GeometryVertex, MorphDelta, SkinVertex};
use std::collections::BTreeMap;
use std::mem::offset_of;
use std::path::{Path, PathBuf};

fn parse(name: &str, source: &str) -> naga::Module {
    let module =
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string_with_path(source, name)));
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    if let Err(error) = validator.validate(&module) {
        panic!("{}", error.emit_to_string_with_path(source, name));
    }
    module
}

fn wgsl_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            wgsl_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "wgsl") {
            found.push(path);
        }
    }
}

/// Pairs of alternative shader files: the default form, and the form used by studies. A build includes one of each
/// pair.
const FORMS: [[&str; 2]; 4] = [
    [include_str!("light/forms.wgsl"), include_str!("study/light/forms.wgsl")],
    [include_str!("light/deep_forms.wgsl"), include_str!("study/light/deep_forms.wgsl")],
    [include_str!("ink/line_forms.wgsl"), include_str!("study/ink/line_forms.wgsl")],
    [include_str!("ink/surface_forms.wgsl"), include_str!("study/ink/surface_forms.wgsl")],
];

/// Returns all shaders of the passes and of the application, for this build and with the alternative forms.
fn sources() -> Vec<(String, String)> {
    let mut sources = vec![("the application's own shaders".to_string(), receiver::WGSL.to_string())];
    for shader in PASSES.iter().flat_map(|pass| pass.shaders) {
        let (name, wgsl) = (shader.name, shader.wgsl());
        let (mut without, mut with) = (wgsl.clone(), wgsl.clone());
        for [ours, studied] in FORMS {
            without = without.replace(studied, ours);
            with = with.replace(ours, studied);
        }
        sources.push((name.to_string(), wgsl));
        sources.push((format!("{name}, without study"), without));
        sources.push((format!("{name}, with study"), with));
    }
    sources
}

#[test]
fn every_wgsl_file_is_valid_and_used() {
    let sources = sources();
    sources.iter().for_each(|(name, source)| drop(parse(name, source)));
    let mut files = Vec::new();
    wgsl_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    for file in &files {
        let source = std::fs::read_to_string(file).unwrap();
        let users = sources.iter().filter(|(_, user)| user.contains(&source)).count();
        assert!(users > 0, "{}: nothing contains it", file.display());
        // Shared files are valid on their own, except the one that includes others.
        if file.parent().is_some_and(|p| p.ends_with("shared")) && !file.ends_with("receiver.wgsl") {
            parse(&file.display().to_string(), &source);
        }
    }
    assert!(files.len() >= 48, "not all are found: {files:?}");
}

/// Returns every WGSL file with comments removed.
fn wgsl_code() -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    wgsl_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    let code = |line: &str| line.split("//").next().unwrap_or_default().to_owned() + "\n";
    let read = |file: PathBuf| {
        let text = std::fs::read_to_string(&file).unwrap();
        (file, text.lines().map(code).collect())
    };
    files.into_iter().map(read).collect()
}

/// Checks that nested shift and bitwise operators are parenthesised: browsers require it, naga does not.
#[test]
fn shifts_in_wgsl_are_parenthesised() {
    for (file, code) in wgsl_code() {
        let found = code.lines().find(|line| mixes_shifts(line));
        assert_eq!(found, None, "{}", file.display());
    }
    for refused in ["a << 9u | b", "(a >> 6u) | b >> 2u", "f(a & b << 1u)", "x[i] & 511u << 2u"] {
        assert!(mixes_shifts(refused), "{refused}");
    }
    for taken in ["(a << 9u) | b", "vec2(a & 1u, a >> 1u)", "a << (b & 3u)", "a && b << 1u < c || d", "a |= b << 1u;"] {
        assert!(!mixes_shifts(taken), "{taken}");
    }
}

/// Checks that `&&` within `||` is parenthesised, also in statements of several lines.
#[test]
fn ands_among_ors_in_wgsl_are_parenthesised() {
    for (file, code) in wgsl_code() {
        let found = code.split([';', '{', '}']).find(|statement| mixes_logic(statement));
        assert_eq!(found, None, "{}", file.display());
    }
    for refused in ["!a || b && c", "a &&\n b == c\n || d", "f(a || b && c)", "(a && b) || c && d"] {
        assert!(mixes_logic(refused), "{refused}");
    }
    for taken in ["!a || (b && c)", "f(a && b, c || d)", "a & b || c", "a || b || (c && d && e)"] {
        assert!(!mixes_logic(taken), "{taken}");
    }
}

fn mixes_shifts(code: &str) -> bool {
    let code = code.replace("&&", ",").replace("||", ",").replace("|=", ",").replace("&=", ",");
    side_by_side(&code, &[',', ';', '='], |before, letter| match letter {
        '<' | '>' if before == letter => Some(0),
        '|' | '&' | '^' => Some(1),
        _ => None,
    })
}

fn mixes_logic(code: &str) -> bool {
    side_by_side(code, &[','], |before, letter| match (before, letter) {
        ('&', '&') => Some(0),
        ('|', '|') => Some(1),
        _ => None,
    })
}

/// Whether operators of both kinds occur side by side: in the same pair of brackets, and without one of the characters
/// `ends` between them. `kind` is called with each pair of adjacent characters. It returns 0 or 1 if they end an
/// operator of that kind.
fn side_by_side(code: &str, ends: &[char], kind: impl Fn(char, char) -> Option<usize>) -> bool {
    // Kinds of operators found so far in each open bracket.
    let mut open = vec![[false; 2]];
    let mut before = ' ';
    for letter in code.chars() {
        let here = open.len() - 1;
        match letter {
            '(' | '[' => open.push([false; 2]),
            ')' | ']' if here > 0 => drop(open.pop()),
            end if ends.contains(&end) => open[here] = [false; 2],
            _ => kind(before, letter).into_iter().for_each(|kind| open[here][kind] = true),
        }
        if open.last() == Some(&[true; 2]) {
            return true;
        }
        before = letter;
    }
    false
}

/// Returns offset and size of each member of a struct, and the struct's size.
fn members(source: &str, name: &str) -> (Vec<(String, u32, u32)>, u32) {
    let module = parse(name, source);
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).unwrap();
    let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).unwrap();
    let TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is not a struct") };
    let members = members.iter().map(|m| (m.name.clone().unwrap(), m.offset, layouter[m.ty].size)).collect();
    (members, *span)
}

/// Name, offset and size of the fields of a Rust struct, in the format of `members`.
macro_rules! fields {
    ($ty:ty, $($field:ident),+ $(,)?) => {{
        fn size<T, F>(_: fn(&T) -> &F) -> u32 { size_of::<F>() as u32 }
        let fields = vec![
            $((stringify!($field).to_string(), offset_of!($ty, $field) as u32, size(|v: &$ty| &v.$field))),+
        ];
        (fields, size_of::<$ty>() as u32)
    }};
}

/// Returns the fields of a Rust struct in the format of `members`.
fn struct_fields<T: ShaderStruct>() -> (Vec<(String, u32, u32)>, u32) {
    let field = |(name, offset, size): &(&str, usize, usize)| ((*name).to_string(), *offset as u32, *size as u32);
    (T::FIELDS.iter().map(field).collect(), size_of::<T>() as u32)
}

#[test]
fn uniform_structs_match_wgsl() {
    assert_eq!(members(frame::WGSL, "Frame"), struct_fields::<frame::Frame>());
    assert_eq!(members(&ink_stroke::SHADER.wgsl(), "InkFrame"), struct_fields::<InkFrame>());
    for source in [&ink_contours::SHADER.wgsl(), &ink_contours::CHAINS.wgsl(), &ink_lines::SHADER.wgsl()] {
        assert_eq!(members(source, "Contours"), struct_fields::<ContourBlock>());
        assert_eq!(members(source, "ContourNode"), struct_fields::<ContourNode>());
        assert_eq!(members(source, "LineNode"), struct_fields::<LineNode>());
    }
    for shader in [painting_strokes::SHADER, painting_ribbons::SHADER, painting_wet::SHADER, painting_sheet::SHADER] {
        assert_eq!(members(&shader.wgsl(), "PaintingFrame"), struct_fields::<PaintingFrame>(), "{}", shader.name);
    }
    for shader in [painting_strokes::SHADER, painting_ribbons::SHADER] {
        assert_eq!(members(&shader.wgsl(), "PaintedModel"), struct_fields::<PaintedModel>(), "{}", shader.name);
    }
    assert_eq!(members(&ink_seal::SHADER.wgsl(), "StampedSeal"), struct_fields::<StampedSeal>());
    let (wgsl, size) = members(&ink_fur::SHADER.wgsl(), "InkModel");
    let (fields, rust_size) = struct_fields::<InkModel>();
    assert_eq!((&wgsl[..16], wgsl[16].1, size), (&fields[..16], fields[16].1, rust_size));
    assert_eq!(members(frame::WGSL, "FillLight"), fields!(frame::FillLight, light_ws, color));
    assert_eq!(members(&shadow_width::FILTER.wgsl(), "Filter"), struct_fields::<shadow_width::Filter>());
    assert_eq!(members(frame::WGSL, "Instance"), struct_fields::<frame::Instance>());
    for source in [&strand_pose::SHADER.wgsl(), &strand_shadow::SHADER.wgsl(), &strand_light::SHADER.wgsl()] {
        assert_eq!(
            members(source, "StrandConstants"),
            fields!(StrandConstants, points, count, dry_points, radius, first, end, share, step)
        );
    }
    for source in [deep_opacity::WGSL, &strand_shadow::SHADER.wgsl(), &strand_light::SHADER.wgsl()] {
        let (wgsl, size) = members(source, "DeepOpacity");
        let (fields, rust_size) =
            fields!(DeepOpacity, size, slabs, slabs_per_depth, texel_m, density, whole_from, reserved);
        assert_eq!((&wgsl[..6], wgsl[6].1, size), (&fields[..6], fields[6].1, rust_size));
    }
    for source in [&strand_gather::SHADER.wgsl(), &strand_blend::SHADER.wgsl()] {
        assert_eq!(members(source, "NearestHair"), fields!(NearestHairBlock, area, size, pieces, round));
    }
    // These shaders declare only the part of the frame block that positions corners.
    for source in [&strands::SHADER.wgsl(), &strand_gather::SHADER.wgsl()] {
        let (frame, _) = members(source, "Frame");
        assert_eq!(frame[..], fields!(frame::Frame, clip_from_world).0[..]);
        assert_eq!(frame[0].1 as usize, offset_of!(frame::Frame, clip_from_world));
    }
    assert_eq!(
        members(soft_shadow::WGSL, "SoftShadow"),
        fields!(soft_shadow::SoftShadow, range_m, penumbra, blur, texel)
    );
    let (wgsl, size) = members(receiver::WGSL, "ShadowReceiver");
    let (fields, rust_size) = fields!(receiver::ShadowReceiver, map_from_world, soft_shadow, centred, reserved);
    assert_eq!((&wgsl[..3], wgsl[3].1, size), (&fields[..3], fields[3].1, rust_size));
    assert_eq!(members(scattering::WGSL, "Fibre"), fields!(scattering::Fibre, optics, on, back));
    let (members, size) = members(&skin::SHADER.wgsl(), "Material");
    let (mut fields, rust_size) = struct_fields::<MaterialUniform>();
    fields.retain(|field| field.0 != "reserved");
    assert_eq!((members, size), (fields, rust_size));
}

#[test]
fn storage_structs_match_wgsl() {
    for source in [&pose::SHADER.wgsl(), &fins::SHADER.wgsl()] {
        assert_eq!(
            members(source, "GeometryVertex"),
            fields!(GeometryVertex, position, fur_height, normal, lean, tangent)
        );
    }
    assert_eq!(members(&fins::SHADER.wgsl(), "Fin"), fields!(Fin, a, b, start, length, slab, opacity));
    // Four bytes in Rust are one 32-bit word in the shader.
    assert_eq!(
        members(&fins::SHADER.wgsl(), "AttributeVertex"),
        fields!(AttributeVertex, tile_uv, base_uv, color, groom)
    );
    assert_eq!(
        members(&strand_pose::SHADER.wgsl(), "GeometryVertex"),
        fields!(GeometryVertex, position, fur_height, normal, lean, tangent)
    );
    for source in [&strand_pose::SHADER.wgsl(), &strand_shadow::SHADER.wgsl(), &strand_light::SHADER.wgsl()] {
        assert_eq!(
            members(source, "Strand"),
            fields!(Strand, base_uv, color, groom, of_tile, selection, lean, fur_height)
        );
    }
    let (stand, size) = members(&strand_pose::SHADER.wgsl(), "Stand");
    assert_eq!((stand[3].1 as usize, size as usize), (offset_of!(SurfacePoint, weights), size_of::<SurfacePoint>()));
    let (members, size) = members(&pose::SHADER.wgsl(), "SkinVertex");
    assert_eq!(size as usize, size_of::<SkinVertex>());
    let offset = |name: &str| members.iter().find(|m| m.0 == name).map(|m| m.1 as usize);
    assert_eq!(offset("joints_xy"), Some(offset_of!(SkinVertex, joints)));
    assert_eq!(offset("joints_zw"), Some(offset_of!(SkinVertex, joints) + 4));
    for (k, name) in ["weight_x", "weight_y", "weight_z", "weight_w"].into_iter().enumerate() {
        assert_eq!(offset(name), Some(offset_of!(SkinVertex, weights) + 4 * k));
    }
}

#[test]
fn stroke_structs_match_wgsl() {
    for shader in [painting_strokes::SHADER, painting_ribbons::SHADER] {
        let source = shader.wgsl();
        assert_eq!(members(&source, "PoolStroke"), fields!(PoolStroke, kind, rank, seed, pigment), "{}", shader.name);
        assert_eq!(members(&source, "BrushPoint"), fields!(BrushPoint, place, brush), "{}", shader.name);
    }
    // A surface point is one vector of 32-bit words in the shader: three vertices, then both weights.
    assert_eq!((size_of::<SurfacePoint>(), offset_of!(SurfacePoint, weights)), (16, 12));
    let (points, size) = members(&painting_strokes::SHADER.wgsl(), "PoolPoint");
    let sides = offset_of!(PoolPoint, sides) as u32;
    let expected = [("one", sides, 16), ("other", sides + 16, 16), ("brush", offset_of!(PoolPoint, brush) as u32, 16)];
    assert_eq!(points, expected.map(|(name, offset, size)| (name.to_owned(), offset, size)));
    assert_eq!(size as usize, size_of::<PoolPoint>());
}

#[test]
fn motion_structs_match_wgsl() {
    assert_eq!(members(&hair_motion::SHADER.wgsl(), "HairMotion"), struct_fields::<HairMotion>());
    assert_eq!(members(&fur_motion::SHADER.wgsl(), "Wind"), struct_fields::<WindBlock>());
    assert_eq!(members(&fur_motion::SHADER.wgsl(), "FurMotion"), struct_fields::<FurMotion>());
}

#[test]
fn morph_delta_struct_is_tightly_packed() {
    let (members, size) = members(&pose::MORPHED.wgsl(), "MorphDelta");
    assert_eq!(size as usize, size_of::<MorphDelta>());
    let offset = |name: &str| members.iter().find(|m| m.0 == name).map(|m| m.1 as usize);
    assert_eq!(offset("morph"), Some(offset_of!(MorphDelta, target)));
    let vectors = [
        ("position", offset_of!(MorphDelta, position)),
        ("normal", offset_of!(MorphDelta, normal)),
        ("tangent", offset_of!(MorphDelta, tangent)),
    ];
    for (name, first) in vectors {
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            assert_eq!(offset(&format!("{name}_{axis}")), Some(first + 4 * k), "{name}_{axis}");
        }
    }
}

/// Returns location and number of components of each input of a vertex shader.
fn inputs(source: &str, name: &str) -> BTreeMap<u32, u32> {
    let module = parse(name, source);
    let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).unwrap();
    let TypeInner::Struct { members, .. } = &ty.inner else { panic!("{name} is not a struct") };
    members
        .iter()
        .map(|m| {
            let Some(naga::Binding::Location { location, .. }) = m.binding else { panic!("{m:?} has no location") };
            let components = match module.types[m.ty].inner {
                TypeInner::Scalar(s) if s.kind == ScalarKind::Float => 1,
                TypeInner::Vector { size: VectorSize::Bi, .. } => 2,
                TypeInner::Vector { size: VectorSize::Tri, .. } => 3,
                TypeInner::Vector { size: VectorSize::Quad, .. } => 4,
                ref other => panic!("{other:?}"),
            };
            (location, components)
        })
        .collect()
}

#[test]
fn vertex_inputs_match_wgsl() {
    let components = |format| match format {
        wgpu::VertexFormat::Float32 => 1,
        wgpu::VertexFormat::Float32x2 | wgpu::VertexFormat::Snorm16x2 => 2,
        wgpu::VertexFormat::Float32x3 => 3,
        wgpu::VertexFormat::Float32x4 | wgpu::VertexFormat::Unorm8x4 => 4,
        other => panic!("{other:?}"),
    };
    let given = |buffers: &[&[wgpu::VertexAttribute]]| -> BTreeMap<u32, u32> {
        buffers.iter().copied().flatten().map(|a| (a.shader_location, components(a.format))).collect()
    };
    let two: [&[_]; 2] = [&GEOMETRY_ATTRIBUTES, &ATTRIBUTE_ATTRIBUTES];
    assert_eq!(inputs(&shells::SHADER.wgsl(), "Vertex"), given(&two));
    assert_eq!(inputs(&ink_fur::SHADER.wgsl(), "Vertex"), given(&two));
    let four: [&[_]; 4] = [two[0], two[1], &REST_ATTRIBUTES, &INK_ATTRIBUTES];
    let [mut all, own] = ["Vertex", "InkVertex"].map(|name| inputs(&ink_normals::SHADER.wgsl(), name));
    all.extend(own);
    assert_eq!(all, given(&four));
}

#[test]
fn workgroup_sizes_match_wgsl() {
    let module = parse("pose", &pose::SHADER.wgsl());
    assert_eq!(module.entry_points[0].workgroup_size, [WORKGROUP, 1, 1]);
    for source in [&strand_pose::SHADER.wgsl(), &strand_shadow::SHADER.wgsl(), &strand_light::SHADER.wgsl()] {
        for entry in &parse("strands", source).entry_points {
            let expected = if entry.name == "scan_strands" { SCAN_WORKGROUP } else { WORKGROUP };
            assert_eq!(entry.workgroup_size, [expected, 1, 1], "{}", entry.name);
        }
    }
    for source in [&ink_contours::SHADER.wgsl(), &ink_contours::CHAINS.wgsl()] {
        for entry in &parse("contours", source).entry_points {
            let expected = if entry.name == "count_crossed" { SCAN_WORKGROUP } else { WORKGROUP };
            assert_eq!(entry.workgroup_size, [expected, 1, 1], "{}", entry.name);
        }
    }
    let gather = parse("gather", &strand_gather::SHADER.wgsl());
    assert!(gather.entry_points.iter().all(|entry| entry.workgroup_size == [WORKGROUP, 1, 1]));
    assert_eq!(WORKGROUP, TILE * TILE, "a workgroup is a tile of pixels");
    let module = parse("fins", &fins::SHADER.wgsl());
    let lights = parse("lights", &shells::SHADER.wgsl());
    let module_of_strokes = parse("ink_fur", &ink_fur::SHADER.wgsl());
    let (_, shells) =
        module_of_strokes.constants.iter().find(|(_, c)| c.name.as_deref() == Some("STROKE_SHELLS")).unwrap();
    let naga::Expression::Literal(naga::Literal::U32(found)) = module_of_strokes.global_expressions[shells.init] else {
        panic!("STROKE_SHELLS is not a number")
    };
    assert_eq!(found, ink_fur::SHELLS);
    let of_fins = [("CORNERS", FIN_CORNERS), ("LEANING_ROWS", LEANING_ROWS)].map(|named| (&module, named));
    let of_lists = [("NEAREST", NEAREST), ("TILE", TILE)].map(|named| (&gather, named));
    let of_lights = [
        ("MAX_FILL_LIGHTS", crate::MAX_FILL_LIGHTS),
        ("MAX_LOBES", Environment::MOST_LOBES),
        ("MOST_PARTS", crate::light::PARTS),
    ];
    let of_lights = of_lights.map(|(name, count)| (&lights, (name, count as u32)));
    for (module, (name, expected)) in of_fins.into_iter().chain(of_lists).chain(of_lights) {
        let (_, constant) = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name)).unwrap();
        let naga::Expression::Literal(naga::Literal::U32(found)) = module.global_expressions[constant.init] else {
            panic!("{name} is not a number")
        };
        assert_eq!(found, expected, "{name}");
    }
}

/// Checks that debug views and the study name existing shaders of passes. They select pipelines by shader name, so an
/// unknown name would change nothing.
#[test]
fn amended_pipelines_name_shaders_that_passes_have() {
    let names: Vec<_> = PASSES.iter().flat_map(|pass| pass.shaders).map(|shader| shader.name).collect();
    for (source, least) in [(include_str!("study/amend.rs"), 8), (include_str!("debug/mod.rs"), 6)] {
        let amended: Vec<_> = source.split('"').filter(|text| text.starts_with("pelage ")).collect();
        assert!(amended.len() >= least, "{amended:?}");
        assert!(amended.iter().all(|name| names.contains(name)), "{amended:?} of {names:?}");
    }
}
