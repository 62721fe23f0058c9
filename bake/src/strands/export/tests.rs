use super::*;
use crate::strands::{CurvePoint, PosedMaterial, PosedMesh, PosedVertex};
use glam::{DVec3, Vec2, Vec3, Vec4};

/// Makes three strands of 2, 4 and 3 points.
fn curves() -> Curves {
    of_groups(["coat"; 3])
}

/// Makes the same strands as `curves`, each in a group with the given name.
fn of_groups(names: [&str; 3]) -> Curves {
    let mut curves = Curves::default();
    for (strand, points) in [2, 4, 3].into_iter().enumerate() {
        curves.begin_group(names[strand]);
        let point = |i: i32| CurvePoint {
            position_ws: Vec3::new(0.1 * strand as f32, i as f32 / 3.0, -1.5e-7 * i as f32),
            radius_m: 1e-4 / (i + 1) as f32,
            color: Vec3::new(0.25, 0.1 * strand as f32, i as f32 * 0.5),
            ..CurvePoint::default()
        };
        curves.push(&(0..points).map(point).collect::<Vec<_>>(), strand == 1, Vec2::new(0.25, 0.5 * strand as f32));
    }
    curves
}

fn written(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(&mut bytes).unwrap();
    bytes
}

#[test]
fn text_export_reads_back_bit_for_bit() {
    let curves = curves();
    let text = String::from_utf8(written(|out| write_text(&curves, out))).unwrap();
    let strands: Vec<Vec<[f32; 4]>> = text
        .split("\n\n")
        .map(|strand| {
            let numbers = |line: &str| line.split(' ').map(|n| n.parse().unwrap()).collect::<Vec<f32>>();
            strand.lines().map(|line| numbers(line).try_into().unwrap()).collect()
        })
        .collect();
    assert_eq!(strands.len(), 3);
    for (i, strand) in strands.iter().enumerate() {
        let expected: Vec<[f32; 4]> =
            curves.strand(i).iter().map(|p| p.position_ws.extend(p.radius_m).to_array()).collect();
        assert_eq!(*strand, expected);
    }
    assert_eq!(written(|out| write_text(&Curves::default(), out)), b"");
}

#[test]
fn hair_export_matches_its_header() {
    let curves = curves();
    let bytes = written(|out| write_hair(&curves, out));
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let f32_at = |at: usize| f32::from_bits(u32_at(at));
    assert_eq!(&bytes[..4], b"HAIR");
    assert_eq!([u32_at(4), u32_at(8), u32_at(12)], [3, 9, 0b10111]);
    assert!(bytes[40..128].starts_with(b"pelage ") && bytes[127] == 0);
    let pieces: Vec<u16> = bytes[128..134].chunks(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
    assert_eq!(pieces, [1, 3, 2]);
    let (points, thickness, colors) = (134, 134 + 9 * 12, 134 + 9 * 16);
    assert_eq!(bytes.len(), colors + 9 * 12);
    for (i, p) in curves.points.iter().enumerate() {
        let vector = |at: usize| Vec3::new(f32_at(at), f32_at(at + 4), f32_at(at + 8));
        assert_eq!(vector(points + 12 * i), p.position_ws);
        assert_eq!(f32_at(thickness + 4 * i), 2.0 * p.radius_m);
        assert_eq!(vector(colors + 12 * i), p.color);
    }
    let long = CurvePoint::default();
    let mut curves = Curves::default();
    curves.push(&vec![long; 65_537], false, Vec2::ZERO);
    let error = write_hair(&curves, &mut io::sink()).unwrap_err();
    assert!(error.kind() == io::ErrorKind::InvalidInput && error.to_string().contains("65536 segments"), "{error}");
}

#[test]
fn pbrt_has_one_curve_per_strand_segment() {
    let curves = curves();
    let text = String::from_utf8(written(|out| write_pbrt(&curves, out))).unwrap();
    let shapes: Vec<&str> = text.lines().filter(|l| l.starts_with("Shape \"curve\"")).collect();
    assert_eq!(shapes.len(), 1 + 3 + 2);
    assert_eq!((text.matches("AttributeBegin").count(), text.matches("AttributeEnd").count()), (1, 1));
    let inside = |line: &str, from: &str, to: &str| {
        let rest = &line[line.find(from).unwrap() + from.len()..];
        let numbers = rest[..rest.find(to).unwrap_or(rest.len())].split_whitespace();
        numbers.map(|n| n.parse::<f32>().unwrap()).collect::<Vec<f32>>()
    };
    // The second segment of the second strand.
    let (a, b) = (&curves.strand(1)[1], &curves.strand(1)[2]);
    let p = inside(shapes[2], "\"point3 P\" [", "]");
    assert_eq!((p.len(), &p[..3], &p[9..]), (12, &a.position_ws.to_array()[..], &b.position_ws.to_array()[..]));
    assert!((Vec3::new(p[3], p[4], p[5]) - a.position_ws.lerp(b.position_ws, 1.0 / 3.0)).length() < 1e-6);
    assert_eq!(inside(shapes[2], "\"float width0\" ", "\""), [2.0 * a.radius_m]);
    assert_eq!(inside(shapes[2], "\"float width1\" ", "\""), [2.0 * b.radius_m]);
}

#[test]
fn text_export_ignores_groups() {
    let text = |curves: &Curves| written(|out| write_text(curves, out));
    assert_eq!(text(&of_groups(["coat", "mane", "tail"])), text(&curves()));
}

#[test]
fn hair_header_lists_as_many_groups_as_fit() {
    let info = |names: [&str; 3]| {
        let bytes = written(|out| write_hair(&of_groups(names), out));
        assert_eq!(bytes[127], 0, "readers in C find the end");
        String::from_utf8(bytes[40..128].to_vec()).unwrap().trim_end_matches('\0').to_owned()
    };
    assert!(info(["coat", "coat", "mane"]).ends_with(": metres, y up, diameters, linear RGB; coat 0; mane 2"));
    let long = "a name for which there is no room beside coat";
    assert!(info(["coat", long, "mane"]).ends_with("; coat 0; ..."), "{}", info(["coat", long, "mane"]));
    assert!(info([&"x".repeat(200), "y", "z"]).ends_with("RGB; ..."));
    // The last name may fill the text to the end, because the ending `; ...` is not needed after it.
    let room = 87 - info(["coat"; 3]).len() - "; ".len() - " 2".len();
    let exact = "é".repeat(room / 2) + &"e".repeat(room % 2);
    assert!(info(["coat", "coat", &exact]).ends_with(&format!("; coat 0; {exact} 2")));
    assert!(info(["coat", "coat", &(exact + "e")]).ends_with("; coat 0; ..."));
}

#[test]
fn pbrt_has_a_block_and_a_material_for_each_group() {
    let text = String::from_utf8(written(|out| write_pbrt(&of_groups(["coat", "a \"b\"\n", "coat"]), out))).unwrap();
    let blocks: Vec<&str> = text.split("\n\n").skip(1).collect();
    let names = ["coat", "a _b__", "coat_2"];
    assert_eq!(blocks.len(), 3, "{text}");
    for ((block, name), pieces) in blocks.iter().zip(names).zip([1, 3, 2]) {
        assert!(block.starts_with(&format!("# group {name}, number of strands: 1\nAttributeBegin\n")), "{block}");
        assert!(
            block.contains(&format!("\nMakeNamedMaterial \"strands/{name}\" \"string type\" \"diffuse\" ")),
            "{block}"
        );
        assert!(block.contains(&format!("\nNamedMaterial \"strands/{name}\"\n")), "{block}");
        assert_eq!(block.matches("Shape \"curve\"").count(), pieces);
        assert!(block.trim_end().ends_with("\nAttributeEnd"), "{block}");
    }
    // Each attribute block has the mean colour of its own points. The green component is a tenth of the strand's index.
    for (block, green) in blocks.iter().zip([0.0, 0.1, 0.2f32]) {
        let rgb = block.split("\"rgb reflectance\" [").nth(1).and_then(|rest| rest.split(']').next()).unwrap();
        assert_eq!(rgb.split(' ').nth(1).unwrap().parse::<f32>().unwrap(), green);
    }
}

#[test]
fn glb_has_a_node_and_a_mesh_for_each_group() {
    let curves = of_groups(["coat", "coat", "mane \"m\""]);
    let bytes = written(|out| write_glb(&curves, out));
    let glb = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = glb.blob.as_deref().unwrap();
    let nodes: Vec<gltf::Node<'_>> = glb.default_scene().or(glb.scenes().next()).unwrap().nodes().collect();
    assert_eq!(nodes.len(), 2);
    for (node, group) in nodes.iter().zip(curves.groups()) {
        let mesh = node.mesh().unwrap();
        assert_eq!((node.name(), mesh.name()), (Some(group.name.as_str()), Some(group.name.as_str())));
        let primitive = mesh.primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(blob));
        let points = curves.points_of(group);
        assert!(reader.read_positions().unwrap().eq(points.iter().map(|p| p.position_ws.to_array())));
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices.len(), 2 * (points.len() - group.strands.len()));
        assert_eq!(indices.iter().max(), Some(&(points.len() as u32 - 1)));
    }
}

/// Returns the numbers of a list attribute of a USD prim.
fn usd_list(prim: &str, declaration: &str) -> Vec<f32> {
    let rest = prim.split(&format!("{declaration} = [")).nth(1).unwrap();
    let list = rest.split(']').next().unwrap();
    list.split([',', ' ', '\n', '(', ')']).filter(|word| !word.is_empty()).map(|word| word.parse().unwrap()).collect()
}

#[test]
fn usda_has_a_prim_for_each_group() {
    let curves = of_groups(["coat", "coat", "2nd \"m\\a\"\n"]);
    let text = String::from_utf8(written(|out| write_usda(&curves, out))).unwrap();
    assert!(text.starts_with("#usda 1.0\n(\n    defaultPrim = \"strands\"\n"), "{text}");
    assert!(text.contains("metersPerUnit = 1\n") && text.contains("upAxis = \"Y\"\n"), "{text}");
    let prims: Vec<&str> = text.split("    def BasisCurves ").skip(1).collect();
    assert_eq!(prims.len(), 2);
    assert!(prims[0].starts_with("\"coat\"\n    {\n        uniform token type = \"linear\"\n"), "{text}");
    let named = "\"_2nd__m_a__\" (\n        displayName = \"2nd \\\"m\\\\a\\\"_\"\n    )\n    {\n";
    assert!(prims[1].starts_with(named), "{text}");
    for (prim, group) in prims.iter().zip(curves.groups()) {
        let points = curves.points_of(group);
        let strands = group.strands.start as usize..group.strands.end as usize;
        let counts: Vec<f32> = strands.clone().map(|i| curves.strand(i).len() as f32).collect();
        assert_eq!(usd_list(prim, "int[] curveVertexCounts"), counts);
        let flat = |of: &dyn Fn(&CurvePoint) -> Vec3| points.iter().flat_map(|p| of(p).to_array()).collect::<Vec<_>>();
        assert_eq!(usd_list(prim, "point3f[] points"), flat(&|p| p.position_ws));
        assert_eq!(usd_list(prim, "color3f[] primvars:displayColor"), flat(&|p| p.color));
        let widths: Vec<f32> = points.iter().map(|p| 2.0 * p.radius_m).collect();
        assert_eq!(usd_list(prim, "float[] widths"), widths);
        let uv: Vec<f32> = curves.root_uv[strands].iter().flat_map(|uv| [uv.x, 1.0 - uv.y]).collect();
        assert_eq!(usd_list(prim, "float2[] primvars:surface_uv_coordinate"), uv);
        // The extent is that of UsdGeomCurves: the box around the points, extended by half the largest width.
        let [low, high] = [Vec3::min, Vec3::max].map(|f| points.iter().map(|p| p.position_ws).reduce(f).unwrap());
        let extent: Vec<f32> = [low - 1e-4, high + 1e-4].iter().flat_map(Vec3::to_array).collect();
        assert_eq!(usd_list(prim, "float3[] extent"), extent);
        let interpolations: Vec<&str> =
            prim.lines().filter_map(|l| l.trim().strip_prefix("interpolation = ")).collect();
        assert_eq!(interpolations, ["\"vertex\"", "\"vertex\"", "\"uniform\""]);
    }
    let empty = String::from_utf8(written(|out| write_usda(&Curves::default(), out))).unwrap();
    assert!(empty.contains("def Xform \"strands\"") && !empty.contains("BasisCurves"), "{empty}");
}

#[test]
fn usda_names_are_unique_identifiers() {
    let names = |names| {
        let text = String::from_utf8(written(|out| write_usda(&of_groups(names), out))).unwrap();
        let prims = text.split("    def BasisCurves \"").skip(1).map(|prim| prim.split('"').next().unwrap().to_owned());
        (prims.collect::<Vec<_>>(), text.matches("displayName").count())
    };
    assert_eq!(names(["coat", "_x9", "strands"]).1, 0, "what is an identifier stays");
    assert_eq!(names(["a b", "a-b", "a_b"]).0, ["a_b", "a_b_2", "a_b_3"]);
    assert_eq!(names(["1", "_1", ""]), (["_1", "_1_2", "_"].map(str::to_owned).to_vec(), 3));
    assert_eq!(names(["Mähne", "coat", "Mähne"]).0, ["M_hne", "coat", "M_hne_2"]);
}

#[test]
fn glb_opens_in_another_reader() {
    let curves = curves();
    let bytes = written(|out| write_glb(&curves, out));
    let glb = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = glb.blob.as_deref().unwrap();
    let mesh = glb.meshes().next().unwrap();
    let primitive = mesh.primitives().next().unwrap();
    assert_eq!(primitive.mode(), gltf::mesh::Mode::Lines);
    let reader = primitive.reader(|_| Some(blob));
    let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    assert_eq!(positions, curves.points.iter().map(|p| p.position_ws.to_array()).collect::<Vec<_>>());
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    assert_eq!(indices, [0, 1, 2, 3, 3, 4, 4, 5, 6, 7, 7, 8]);
    let colors: Vec<[f32; 3]> = reader.read_colors(0).unwrap().into_rgb_f32().collect();
    let clamped = curves.points.iter().map(|p| p.color.clamp(Vec3::ZERO, Vec3::ONE).to_array());
    assert_eq!(colors, clamped.collect::<Vec<_>>());
    let (semantic, radii) = primitive.attributes().find(|(s, _)| s.to_string() == "_RADIUS").unwrap();
    assert_eq!((semantic.to_string(), radii.count()), ("_RADIUS".to_owned(), 9));
    assert_eq!(primitive.bounding_box().max, [0.2, 1.0, 0.0]);
    // Without strands, the file has no mesh.
    let empty = written(|out| write_glb(&Curves::default(), out));
    assert_eq!(gltf::Gltf::from_slice(&empty).unwrap().meshes().len(), 0);
}

#[test]
fn obj_opens_in_another_reader() {
    let vertex = |x: f64, y: f64| PosedVertex {
        position_ws: DVec3::new(x, y, 0.25),
        normal_ws: DVec3::Z,
        base_uv: Vec2::new(x as f32, 0.25),
        color: Vec4::new(0.5, 1.0, 1.0, 1.0),
        ..PosedVertex::default()
    };
    let material = |name: &str| PosedMaterial { name: name.into(), base_color: Vec4::splat(0.8), ..Default::default() };
    let skin = PosedMesh {
        measured_ws: Vec::new(),
        vertices: vec![vertex(0.0, 0.0), vertex(1.0, 0.0), vertex(0.0, 1.0), vertex(1.0, 1.0)],
        same_place: vec![0, 1, 2, 3],
        triangles: vec![[0, 1, 2], [1, 3, 2]],
        material_of: vec![0, 1],
        materials: vec![material("Fur, brown"), material("Fur, brown")],
    };
    let obj = written(|out| write_obj(&skin, "a b.mtl", out));
    let mtl = written(|out| write_mtl(&skin, out));
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    let (models, materials) = tobj::load_obj_buf(&mut obj.as_slice(), &options, |path| {
        assert_eq!(path.to_str(), Some("a b.mtl"));
        tobj::load_mtl_buf(&mut mtl.as_slice())
    })
    .unwrap();
    let materials = materials.unwrap();
    let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["0_Fur__brown", "1_Fur__brown"]);
    assert_eq!(materials[0].diffuse, Some([0.4, 0.8, 0.8]));
    assert_eq!(models.len(), 2);
    let mesh = &models[0].mesh;
    assert_eq!(mesh.positions, [0.0, 0.0, 0.25, 1.0, 0.0, 0.25, 0.0, 1.0, 0.25]);
    assert_eq!((&mesh.normals[..3], &mesh.texcoords[..2]), (&[0.0, 0.0, 1.0][..], &[0.0, 0.75][..]));
    assert_eq!((mesh.indices.as_slice(), models[1].mesh.material_id), (&[0, 1, 2][..], Some(1)));
}

#[test]
fn exported_strands_read_back_as_guides() {
    use crate::guides::read::GuideFormat;
    let mut curves = Curves::default();
    let point = |x: f32| CurvePoint {
        position_ws: Vec3::X * x,
        radius_m: 0.5 * x,
        color: Vec3::splat(x),
        ..CurvePoint::default()
    };
    curves.push(&[point(1.0), point(2.0), point(4.0)], false, Vec2::ZERO);
    for (extension, format) in [("hair", GuideFormat::Hair), ("txt", GuideFormat::Text)] {
        let mut written = Vec::new();
        StrandFormat::of_extension(extension).unwrap().write(&curves, &mut written).unwrap();
        let guides = GuideFormat::of_extension(extension).unwrap().read("a", &written).unwrap();
        assert_eq!((format, guides.strand(0)), (format, &[Vec3::X, 2.0 * Vec3::X, 4.0 * Vec3::X][..]));
        assert_eq!(guides.radii, [0.5, 1.0, 2.0]);
    }
}
