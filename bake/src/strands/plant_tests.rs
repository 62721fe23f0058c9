use super::*;
use crate::strands::{PosedMaterial, PosedVertex, TILE_GROUP};
use glam::{DVec2, Vec2, Vec3, Vec4};

/// Makes a flat sheet in the xz plane of `side` × `side` squares of two triangles, with one tile per metre. Tile
/// coordinates of the squares from column `border` on are shifted by `shift`, which makes them another patch.
fn sheet(side: u32, border: u32, shift: DVec2) -> PosedMesh {
    let mut skin = PosedMesh {
        materials: vec![PosedMaterial { base_color: Vec4::ONE, furred: true, ..PosedMaterial::default() }],
        ..PosedMesh::default()
    };
    let corners = side + 1;
    for patch in 0..2 {
        for (x, y) in (0..corners).flat_map(|y| (0..corners).map(move |x| (x, y))) {
            let uv = DVec2::new(f64::from(x), f64::from(y)) * 0.37 + 0.011;
            skin.same_place.push(y * corners + x);
            skin.vertices.push(PosedVertex {
                position_ws: DVec3::new(uv.x, 0.0, -uv.y),
                normal_ws: DVec3::Y,
                tangent_ws: DVec3::X,
                bitangent_ws: DVec3::NEG_Z,
                fur_height_m: 0.5,
                tile_uv: uv + shift * f64::from(patch),
                base_uv: uv.as_vec2(),
                color: Vec4::ONE,
                groom: Vec2::X,
                ..PosedVertex::default()
            });
        }
    }
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let first = if x >= border { corners * corners } else { 0 } + y * corners + x;
        skin.triangles.extend([[first, first + 1, first + corners], [first + 1, first + corners + 1, first + corners]]);
        skin.material_of.extend([0, 0]);
    }
    skin
}

/// Makes strands that lean far over, with roots spread over the tile.
fn leaning(count: u32) -> TileHair {
    let mut strands = Strands { offsets: vec![0], height: 0.5, root_color: Vec3::ONE, ..Strands::default() };
    for i in 0..count {
        let root = Vec2::new(uniform(1, u64::from(i)), uniform(2, u64::from(i)));
        for j in 0..=6u32 {
            let t = j as f32 / 6.0;
            strands.points.push((root + Vec2::new(0.9, 0.7) * t * t).extend(0.5 * t));
            strands.radii.push(0.01 - 0.009 * t);
            strands.colors.push(Vec3::splat(0.2 + 0.6 * t));
        }
        strands.offsets.push(strands.points.len() as u32);
    }
    TileHair { strands, ..TileHair::default() }
}

#[test]
fn strands_continue_across_patch_borders() {
    let hair = leaning(40);
    let (whole, report) = grow_on(&sheet(6, 99, DVec2::ZERO), &hair, 1.0).unwrap();
    assert!(report.strands > 100 && report.crossed_patch_border == 0, "{report:?}");
    // A shift by whole tiles gives the same roots, but coordinates jump at an edge.
    let (parted, report) = grow_on(&sheet(6, 3, DVec2::new(2.0, 5.0)), &hair, 1.0).unwrap();
    assert!(report.crossed_patch_border > 10 && report.slid_along_border == 0 && report.lost == 0, "{report:?}");
    assert_eq!(whole.len(), parted.len());
    for a in (0..whole.len()).map(|i| whole.strand(i)) {
        let same_root = |b: &&[CurvePoint]| b[0].position_ws.distance(a[0].position_ws) < 1e-5;
        let b = (0..parted.len()).map(|i| parted.strand(i)).find(same_root).unwrap();
        assert_eq!(a.len(), b.len());
        for (p, q) in a.iter().zip(b) {
            assert!(p.position_ws.distance(q.position_ws) < 1e-5, "{p:?} and {q:?}");
        }
    }
    // On a flat surface, the planted strand equals that of the tile, in every tile.
    let strand = whole.strand(whole.len() / 2);
    let (root, tip) = (strand[0], strand[strand.len() - 1]);
    assert!((tip.position_ws - root.position_ws - Vec3::new(0.9, 0.5, -0.7)).length() < 1e-5, "{root:?} {tip:?}");
    assert_eq!((root.height, tip.height), (0.0, 1.0));
}

/// Checks that strands beyond the border of the mesh continue straight in the plane of the last triangle.
#[test]
fn strands_continue_past_the_mesh_border() {
    let (curves, report) = grow_on(&sheet(2, 9, DVec2::ZERO), &leaning(40), 1.0).unwrap();
    assert!(report.crossed_mesh_border > 5, "{report:?}");
    for i in 0..curves.len() {
        let strand = curves.strand(i);
        let (root, tip) = (strand[0].position_ws, strand[strand.len() - 1].position_ws);
        assert!((tip - root - Vec3::new(0.9, 0.5, -0.7)).length() < 1e-5, "strand {i}");
    }
}

#[test]
fn every_root_lies_in_exactly_one_triangle() {
    // Roots are on the grid lines: at points where four triangles meet, and at points where two triangles meet.
    let side = 8u32;
    let lattice = |shift: f32| {
        let mut strands = Strands { offsets: vec![0], height: 0.1, ..Strands::default() };
        for (x, y) in (0..4 * side).flat_map(|y| (0..4 * side).map(move |x| (x, y))) {
            let root = (Vec2::new(x as f32, y as f32) + shift) / (4 * side) as f32;
            strands.points.extend([root.extend(0.0), root.extend(0.1)]);
            strands.radii.extend([0.01; 2]);
            strands.colors.extend([Vec3::ONE; 2]);
            strands.offsets.push(strands.points.len() as u32);
        }
        strands
    };
    let mut skin = sheet(side, 99, DVec2::ZERO);
    for v in &mut skin.vertices {
        // Tile coordinates are from 0 to 2 in steps of a quarter.
        v.tile_uv = ((v.tile_uv - 0.011) / 0.37).round() * 0.25;
    }
    for shift in [0.0, 0.5] {
        let hair = TileHair { strands: lattice(shift), ..TileHair::default() };
        let (curves, report) = grow_on(&skin, &hair, 1.0).unwrap();
        let mut roots: Vec<[u32; 3]> =
            (0..curves.len()).map(|i| curves.strand(i)[0].position_ws.to_array().map(f32::to_bits)).collect();
        let found = roots.len();
        roots.sort_unstable();
        roots.dedup();
        assert_eq!(roots.len(), found, "a root occurs twice");
        // The sheet covers two by two tiles, half open. Each strand of the tile occurs four times, and strands on the
        // outer rim are counted once.
        assert_eq!(report.strands, u64::from(4 * 16 * side * side), "{report:?}");
    }
}

#[test]
fn planted_strands_are_one_group_with_root_coordinates() {
    let (curves, report) = grow_on(&sheet(6, 3, DVec2::new(5.0, 7.0)), &leaning(40), 1.0).unwrap();
    let groups = curves.groups();
    assert_eq!(
        (groups.len(), groups[0].name.as_str(), u64::from(groups[0].strands.end)),
        (1, TILE_GROUP, report.strands)
    );
    for (i, uv) in curves.root_uv.iter().enumerate() {
        let root = curves.strand(i)[0].position_ws;
        assert!(uv.distance(Vec2::new(root.x, -root.z)) < 1e-5, "{uv} at {root}");
    }
}

/// Checks that the fur of a material with another fibre forms a group of its own, with the same strands.
#[test]
fn materials_with_other_fibres_form_their_own_groups() {
    let hair = leaning(40);
    let mut skin = sheet(6, 99, DVec2::ZERO);
    let (alike, all) = grow_on(&skin, &hair, 1.0).unwrap();
    let belly = PosedMaterial { name: "belly".into(), fibre: 3, ..skin.materials[0].clone() };
    skin.materials.push(belly);
    skin.material_of.iter_mut().step_by(3).for_each(|material| *material = 1);
    let (curves, report) = grow_on(&skin, &hair, 1.0).unwrap();
    let names: Vec<_> = curves.groups().iter().map(|group| group.name.as_str()).collect();
    assert_eq!((names, report), (vec![TILE_GROUP, "coat/belly"], all));
    let roots = |curves: &Curves| {
        let mut roots: Vec<_> =
            (0..curves.len()).map(|i| curves.strand(i)[0].position_ws.to_array().map(f32::to_bits)).collect();
        roots.sort_unstable();
        roots
    };
    assert_eq!(roots(&curves), roots(&alike));
}

#[test]
fn bareness_thins_strands_and_length_shortens_them() {
    let hair = leaning(400);
    let grow = |change: &dyn Fn(&mut PosedVertex)| {
        let mut skin = sheet(6, 99, DVec2::ZERO);
        skin.vertices.iter_mut().for_each(change);
        grow_on(&skin, &hair, 1.0).unwrap()
    };
    let (all, full) = grow(&|_| ());
    let (_, half) = grow(&|v| v.groom.x = 0.5);
    let share = half.strands as f64 / full.strands as f64;
    assert!((share - 0.5).abs() < 0.05 && half.strands + half.dropped_thinned == full.strands, "{half:?}");
    assert_eq!(grow(&|v| v.groom.x = 0.0).1.strands, 0);
    let (_, bare) = grow(&|v| v.fur_height_m = 0.0);
    assert_eq!((bare.strands, bare.dropped_bare), (0, full.strands));
    // Half the length gives half the height, but the same radius.
    let (short, _) = grow(&|v| v.fur_height_m = 0.25);
    let tip = |curves: &Curves| curves.strand(7)[curves.strand(7).len() - 1];
    assert!((tip(&short).position_ws.y - 0.5 * tip(&all).position_ws.y).abs() < 1e-6);
    assert_eq!(short.strand(7)[0].radius_m, all.strand(7)[0].radius_m);
    // A point is displaced along the comb by the square of its share of the height.
    let (leant, _) = grow(&|v| v.lean = 1.0);
    let moved = tip(&leant).position_ws - tip(&all).position_ws;
    assert!(moved.distance(Vec3::new(0.0, 0.0, -0.5)) < 1e-5, "{moved}");
}

#[test]
fn wet_places_have_wet_strands() {
    let mut hair = leaning(400);
    let mut wet = hair.strands.clone();
    wet.colors.iter_mut().for_each(|color| *color = Vec3::X);
    hair.wet = Some(wet);
    let grow = |wetness: f32| {
        let mut skin = sheet(6, 99, DVec2::ZERO);
        skin.vertices.iter_mut().for_each(|v| v.groom.y = wetness);
        grow_on(&skin, &hair, 1.0).unwrap().0
    };
    for wetness in [0.0, 0.3, 1.0] {
        let curves = grow(wetness);
        let share = curves.wet.iter().filter(|wet| **wet).count() as f32 / curves.len() as f32;
        assert!((share - wetness).abs() < 0.05 && (0.1..0.9).contains(&wetness) != (share == wetness), "{share}");
        assert!((0..curves.len()).all(|i| (curves.strand(i)[0].color.y < 0.01) == curves.wet[i]));
    }
}

#[test]
fn simplified_strands_stay_near_the_full_ones() {
    let mut hair = leaning(60);
    hair.strands.radii.iter_mut().for_each(|radius| *radius = 0.2);
    let (curves, _) = grow_on(&sheet(4, 99, DVec2::ZERO), &hair, 1.0).unwrap();
    assert!(curves.segments() < curves.len() * 6, "nothing was left out");
    let full = hair.strands.range(0).map(|i| hair.strands.points[i]).collect::<Vec<_>>();
    let points: Vec<CurvePoint> =
        full.iter().map(|p| CurvePoint { position_ws: *p, radius_m: 0.2, ..CurvePoint::default() }).collect();
    let few = simplified(&points, 0.1);
    assert!(few.len() < points.len());
    for p in &points {
        let near = few.windows(2).map(|w| {
            let (a, b) = (w[0].position_ws, w[1].position_ws);
            let t = ((p.position_ws - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            p.position_ws.distance(a.lerp(b, t))
        });
        assert!(near.fold(f32::INFINITY, f32::min) <= 0.1 * 0.2 + 1e-6);
    }
    assert_eq!(simplified(&points, 0.0).len(), points.len(), "without tolerance all stay");
}

#[test]
fn recorded_recipe_that_contradicts_the_manifest_is_refused() {
    let recipe = "[hair]\ndensity = 50\nlength_m = 0.02\n[surface]\ntile_size_m = 0.1\n";
    let hair = TileHair::grow(
        &Recipe::parse_recorded("r", recipe).unwrap(),
        Lengths { length_m: 0.02, tile_size_m: 0.1 },
        FurWetness::Dry,
    )
    .unwrap();
    let fur = pelage_formats::FurInfo {
        layers: 4,
        tile_size_m: 0.1,
        height_m: hair.strands.height * 0.1,
        strands: 50,
        ..Default::default()
    };
    let manifest = Manifest { recipe: recipe.into(), fur, ..Manifest::default() };
    assert_eq!(tile_hair("a.pelage", &manifest).unwrap(), Some(hair));
    let refused = |manifest: Manifest, what: &str| {
        let error = tile_hair("a.pelage", &manifest).unwrap_err();
        assert!(matches!(error, BakeError::Input { .. }) && error.to_string().contains(what), "{error}");
        assert!(error.to_string().starts_with("a.pelage: "), "{error}");
    };
    refused(Manifest { recipe: "[hair".into(), ..manifest.clone() }, "pelage bake");
    refused(Manifest { recipe: "[hair]\ndensity = 50\n".into(), ..manifest.clone() }, "hair.length_m");
    refused(Manifest { recipe: recipe.replace("50", "51"), ..manifest.clone() }, "51 strands");
    refused(Manifest { recipe: recipe.replace("0.02", "0.03"), ..manifest.clone() }, "expected the 50 strands");
    let bald = Manifest { fur: Default::default(), ..manifest };
    assert_eq!(tile_hair("a.pelage", &bald).unwrap(), None);
}
