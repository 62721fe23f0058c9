#![allow(missing_docs, clippy::unwrap_used, reason = "a test fails by panicking")]
//! Tests of a complete bake, from the built-in models to packages.

use pelage_bake::pipeline::{self, BakeInput, Baked, Output, Outputs, STAGES, STEPS, StepEvent};
use pelage_bake::recipe::{HairGroupParams, Recipe, StrandParams};
use pelage_bake::reslice::{Slicer, reslice};
use pelage_bake::stages::groom::MapImages;
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_bake::strands::tile_hair;
use pelage_formats::{Limits, Package};
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use std::path::PathBuf;

pub fn asset(path: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../assets").join(path);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Returns a built-in recipe with fins enabled, so that the package has every optional section.
fn recipe(name: &str) -> Recipe {
    let file = format!("recipes/{name}.toml");
    let mut recipe = Recipe::parse(&file, std::str::from_utf8(&asset(&file)).unwrap()).unwrap();
    recipe.fins.enabled = true;
    recipe
}

/// Returns a recipe without ink and with uncompressed texels, for tests of the fur. Ink and the texture encoders take
/// most of the bake time.
fn fur_recipe(name: &str) -> Recipe {
    let mut recipe = recipe(name);
    for set in ["ink.enabled=false", "pack.shell_format=rgba8", "pack.direction_format=rg8"] {
        recipe.set(set).unwrap();
    }
    recipe
}

/// Imports a model from `assets/models`.
pub fn import_built_in(name: &str, recipe: &Recipe) -> Model {
    let mut no_files = |uri: &str, _: u64| panic!("a built-in model names the file {uri}");
    let bytes = asset(&format!("models/{name}.glb"));
    import(name, &bytes, &mut no_files, &ImportOptions { unit_m: recipe.model.unit_m }).unwrap()
}

fn bake(name: &str, recipe: &Recipe) -> Result<Baked, BakeError> {
    let model = import_built_in(name, recipe);
    pipeline::bake(&BakeInput::new(name, name, recipe, &MapImages::default()), &model, &mut |_| ())
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

#[test]
fn package_bytes_depend_only_on_the_inputs() {
    for (name, threads) in [("hare", 5), ("torus", 2)] {
        let recipe = recipe(name);
        let one = on_threads(1, || bake(name, &recipe).unwrap().package);
        let again = on_threads(threads, || bake(name, &recipe).unwrap().package);
        assert!(one == again, "{name} differs on {threads} threads");
    }
    let [one, other] = [0, 1].map(|more| {
        let mut recipe = fur_recipe("torus");
        recipe.hair.seed += more;
        bake("torus", &recipe).unwrap().package
    });
    assert!(one != other, "another seed must give another package");
}

#[test]
fn the_resolved_recipe_makes_the_same_package_as_the_original() {
    let mut open = recipe("knot");
    (open.hair.length_m, open.surface.tile_size_m) = (None, None);
    let first = bake("knot", &open).unwrap().package;
    let package = Package::open(&first, &Limits::default()).unwrap();
    let resolved = Recipe::parse("resolved", &package.manifest().recipe).unwrap();
    assert!(resolved.hair.length_m.is_some() && resolved.surface.tile_size_m.is_some());
    assert!(first == bake("knot", &resolved).unwrap().package, "the recipe in the manifest is not what was baked");
}

#[test]
fn every_texture_format_gives_a_valid_package() {
    for (shell, direction) in [("bc7", "bc5"), ("rgba8", "rg8"), ("rgba8", "rgba8")] {
        let mut recipe = fur_recipe("torus");
        for set in [format!("pack.shell_format={shell}"), format!("pack.direction_format={direction}")] {
            recipe.set(&set).unwrap();
        }
        (recipe.slice.layers, recipe.slice.tile_texels) = (8, 32);
        let bytes = bake("torus", &recipe).unwrap().package;
        assert_eq!(Package::validate(&bytes, &Limits::default()), []);
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        for index in 0..2 {
            let view = package.texture(index).unwrap();
            // The textures are those of the shells and of the far layer.
            assert_eq!((view.width, view.height, view.layers, view.levels), (32, 32, 9, 6), "{shell} {direction}");
        }
        let fur = package.manifest().fur;
        assert_eq!((fur.layers, fur.tile_texels, fur.strands), (8, 32, recipe.hair.density));
        assert!(fur.height_m > 0.0 && fur.height_m <= recipe.hair.length_m.unwrap() * 1.0001, "{fur:?}");
    }
}

#[test]
fn bare_materials_carry_no_hair() {
    let bytes = bake("hare", &fur_recipe("hare")).unwrap().package;
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let (manifest, mesh) = (package.manifest(), package.mesh().unwrap().unwrap());
    let (vertices, indices): (Vec<_>, Vec<_>) = (mesh.geometry().collect(), mesh.indices().collect());
    let mut seen = [0; 2];
    for part in &manifest.parts {
        let furred = manifest.materials[part.material as usize].furred;
        seen[usize::from(furred)] += 1;
        for index in &indices[part.first_index as usize..][..part.index_count as usize] {
            let height = vertices[*index as usize].fur_height;
            // The hare's vertices store the length of its hair, which is nowhere 0 on furred parts.
            assert!(if furred { height > 0.0 && height <= manifest.fur.height_m } else { height == 0.0 }, "{height}");
        }
    }
    assert!(vertices.iter().any(|v| v.fur_height == manifest.fur.height_m));
    assert!(seen.iter().all(|n| *n > 0), "the hare has furred and bare parts: {seen:?}");
    assert!(package.animation().unwrap().unwrap().clips.iter().any(|c| c.name == "EarBreath"));
}

#[test]
fn detected_bare_materials_are_recorded_and_reproduced() {
    let mut recipe = fur_recipe("hare");
    recipe.model.bare = None;
    let found = bake("hare", &recipe).unwrap();
    let line = found.decisions.iter().find(|d| d.line.starts_with("model.bare")).unwrap().line.clone();
    assert_eq!(line, "model.bare = [\"Eye\", \"Nose\"]");
    let manifest = Package::open(&found.package, &Limits::default()).unwrap().manifest().clone();
    let bare: Vec<&str> = manifest.materials.iter().filter(|m| !m.furred).map(|m| m.name.as_str()).collect();
    assert_eq!(bare, ["Eye", "Nose"]);
    let recorded = Recipe::parse("recorded", &manifest.recipe).unwrap();
    assert_eq!(recorded.model.bare, Some(vec!["Eye".to_owned(), "Nose".to_owned()]));
    // If the recipe contains the line that the decision reports, the package has the same bytes, and the report omits
    // the decision.
    recipe.set(&line).unwrap();
    let said = bake("hare", &recipe).unwrap();
    assert!(said.package == found.package, "the reported line differs from the choice");
    assert!(said.decisions.iter().all(|d| !d.line.starts_with("model.bare")), "{:?}", said.decisions);
    recipe.set("model.bare=[]").unwrap();
    let furred = bake("hare", &recipe).unwrap().package;
    let furred = Package::open(&furred, &Limits::default()).unwrap().manifest().clone();
    assert!(furred.materials.iter().all(|m| m.furred), "an empty list must switch detection off");
}

#[test]
fn hair_grows_short_towards_bare_parts() {
    let heights = |margin: Option<f32>| {
        let mut recipe = fur_recipe("hare");
        recipe.groom.bare_margin_m = margin;
        let bytes = bake("hare", &recipe).unwrap().package;
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        let mesh = package.mesh().unwrap().unwrap();
        mesh.geometry().map(|v| v.fur_height).collect::<Vec<_>>()
    };
    let without = heights(Some(0.0));
    // The margin is set in the recipe or chosen by the bake.
    for margin in [Some(0.02), None] {
        let with = heights(margin);
        assert_eq!(without.len(), with.len());
        assert!(without.iter().zip(&with).all(|(a, b)| b <= a));
        let shorter = without.iter().zip(&with).filter(|(a, b)| b < a).count();
        assert!(shorter > 10 && shorter < without.len() / 4, "{margin:?}: {shorter} of {} vertices", without.len());
    }
}

#[test]
fn base_colours_are_kept_without_color_at_root() {
    let mut recipe = fur_recipe("hare");
    // Colours must be at the vertices here, so painting them into a texture is disabled.
    recipe.color.at_root = false;
    let colors = |recipe: &Recipe| {
        let bytes = bake("hare", recipe).unwrap().package;
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        let mesh = package.mesh().unwrap().unwrap();
        let white = |furred: bool| {
            let mut vertices = mesh.geometry().zip(mesh.attributes()).filter(|(g, _)| (g.fur_height > 0.0) == furred);
            vertices.all(|(_, a)| a.color == [255; 4])
        };
        let materials = package.manifest().materials.clone();
        (white(true), materials.iter().filter(|m| !m.furred).map(|m| m.base_color).collect::<Vec<_>>())
    };
    let (white, bare) = colors(&recipe);
    assert!(!white, "the hare's coat is painted in vertex colours");
    recipe.color.base_color = false;
    assert_eq!(colors(&recipe), (true, bare), "fur white, eyes and nose as they were");
}

#[test]
fn unmatched_patterns_warn_with_the_available_names() {
    let mut recipe = fur_recipe("hare");
    recipe.model.bare = Some(vec!["Hoof*".into()]);
    let warnings = bake("hare", &recipe).unwrap().warnings;
    let warning = warnings.iter().find(|w| w.contains("Hoof*")).unwrap_or_else(|| panic!("{warnings:?}"));
    assert!(warning.contains("Eye") && warning.contains("Coat"), "{warning}");
}

#[test]
fn wet_style_raises_the_specular_terms() {
    let mut wet = fur_recipe("torus");
    wet.set("hair.style=wet").unwrap();
    let shading = |recipe: &Recipe| {
        let package = bake("torus", recipe).unwrap().package;
        Package::open(&package, &Limits::default()).unwrap().manifest().shading
    };
    let (dry, wet) = (shading(&fur_recipe("torus")), shading(&wet));
    assert_eq!(wet, dry.wet());
    assert!(wet.specular[0] > dry.specular[0] && wet.specular_exponent > dry.specular_exponent);
}

/// Checks that every edge of the furred surface has exactly one fin, and no other edge has one. Vertices with equal
/// positions are merged.
#[test]
fn every_edge_has_one_fin() {
    for name in ["hare", "torus", "knot"] {
        let bytes = bake(name, &fur_recipe(name)).unwrap().package;
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        let mesh = package.mesh().unwrap().unwrap();
        let geometry: Vec<_> = mesh.geometry().collect();
        let indices: Vec<_> = mesh.indices().collect();
        let edge = |a: u32, b: u32| {
            let place = |v: u32| geometry[v as usize].position.map(|x| (x + 0.0).to_bits());
            (place(a).min(place(b)), place(a).max(place(b)))
        };
        let manifest = package.manifest();
        let view = package.fins().unwrap().unwrap();
        let mut fins = view.fins();
        let mut seen = std::collections::BTreeSet::new();
        let mut opacities = Vec::new();
        for (part, count) in manifest.parts.iter().zip(view.part_counts()) {
            let furred = manifest.materials[part.material as usize].furred;
            let range = part.first_index as usize..(part.first_index + part.index_count) as usize;
            let sides = indices[range].chunks_exact(3).flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
            let edges: std::collections::BTreeSet<_> = sides.map(|(a, b)| edge(a, b)).collect();
            for fin in fins.by_ref().take(count as usize) {
                let key = edge(fin.a, fin.b);
                assert!(furred && edges.contains(&key), "{name}: {fin:?} is not on an edge of its part");
                assert!(seen.insert(key), "{name}: a second fin on {key:?}");
                let [a, b] = [fin.a, fin.b].map(|v| glam::Vec3::from(geometry[v as usize].position));
                let periods = a.distance(b) / manifest.fur.tile_size_m;
                // Hair slices at 45 degrees have a longer period.
                let expected = periods / if fin.slab % 2 == 1 { std::f32::consts::SQRT_2 } else { 1.0 };
                assert!((fin.length.abs() - expected).abs() < 0.01 * expected, "{name}: {fin:?}, expected {expected}");
                opacities.push(fin.opacity);
            }
            assert_eq!(edges.is_subset(&seen), furred, "{name}: {} edges", edges.len());
        }
        assert_eq!(fins.len(), 0);
        // Closed surfaces have three edges per two triangles. The hare's bare eyes and nose do not count.
        let furred_indices: u32 = manifest
            .parts
            .iter()
            .filter(|p| manifest.materials[p.material as usize].furred)
            .map(|p| p.index_count)
            .sum();
        assert!(2 * seen.len() >= furred_indices as usize, "{name}: {} fins", seen.len());
        // At least a tenth of the fins is in the sparsest areas, where fins show all their hair.
        let full = opacities.iter().filter(|o| **o == 1.0).count();
        assert!(10 * full >= opacities.len() - 10, "{name}: {full} of {}", opacities.len());
        let info = manifest.fur.fins.unwrap();
        assert_eq!((info.width, info.slabs), (2 * manifest.fur.tile_texels, 4));
    }
}

#[test]
fn fins_can_be_disabled_and_their_depth_set() {
    let mut without = fur_recipe("torus");
    without.set("fins.enabled=false").unwrap();
    let bytes = bake("torus", &without).unwrap().package;
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    assert!(package.fins().unwrap().is_none() && package.fin_textures().unwrap().is_none());
    assert_eq!(package.manifest().textures.len(), 4, "colours, directions, visibility and fibres");

    let depth_of = |recipe: &Recipe| {
        let bytes = bake("torus", recipe).unwrap().package;
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        Recipe::parse("resolved", &package.manifest().recipe).unwrap().fins.depth
    };
    let chosen = depth_of(&fur_recipe("torus")).unwrap();
    assert!((0.01..1.0).contains(&chosen), "{chosen}");
    let mut given = fur_recipe("torus");
    given.set("fins.depth=0.5").unwrap();
    assert_eq!(depth_of(&given), Some(0.5));
}

#[test]
fn groom_sets_density_and_direction_of_hair() {
    let baked = |set: &str| {
        let mut recipe = fur_recipe("torus");
        if !set.is_empty() {
            recipe.set(set).unwrap();
        }
        let package = bake("torus", &recipe).unwrap().package;
        let package = Package::open(&package, &Limits::default()).unwrap();
        let mesh = package.mesh().unwrap().unwrap();
        let (geometry, attributes): (Vec<_>, Vec<_>) = (mesh.geometry().collect(), mesh.attributes().collect());
        let indices: Vec<_> = mesh.indices().map(|i| i as usize).collect();
        // Sums over all triangles: area in tiles, and direction of v.
        let (mut area, mut along) = (0.0, glam::Vec3::ZERO);
        for t in indices.chunks_exact(3) {
            let uv = |k: usize| glam::Vec2::from(attributes[t[k]].tile_uv);
            let twice = (uv(1) - uv(0)).perp_dot(uv(2) - uv(0)).abs();
            let v = &geometry[t[0]];
            let tangent = glam::Vec4::from(v.tangent);
            area += twice / 2.0;
            along += glam::Vec3::from(v.normal).cross(tangent.truncate()) * tangent.w * twice;
        }
        (area, along.normalize())
    };
    let (plain, _) = baked("");
    let (dense, _) = baked("groom.density=4");
    let ratio = dense / plain;
    assert!((3.6..4.4).contains(&ratio), "four times as dense is {ratio} times as many tiles");
    for comb in [glam::Vec3::Y, glam::Vec3::NEG_Y] {
        let (_, along) = baked(&format!("groom.comb=[0, {}, 0]", comb.y));
        assert!(along.dot(comb) > 0.9, "combed along {comb}, lies along {along}");
    }
}

#[test]
fn resliced_package_equals_a_full_bake() {
    // Only one of the packages has ink, because it takes most of the bake time.
    let mut tufted = fur_recipe("torus");
    let tuft = HairGroupParams { name: "mop".into(), hairs: Some(40), guides: Some(8), ..HairGroupParams::default() };
    tufted.strands.group.push(tuft);
    tufted.set("shading.model=marschner").unwrap();
    tufted.set("fibre.material=[{ name = \"*\", eta = 1.4 }, { name = \"none such\", eta = 1.3 }]").unwrap();
    for (name, recipe, first_sets) in
        [("hare", fur_recipe("hare"), 4), ("torus", recipe("torus"), 3), ("torus", tufted, 0)]
    {
        let first = bake(name, &recipe).unwrap().package;
        let package = Package::open(&first, &Limits::default()).unwrap();
        let mut other = Recipe::parse("resolved", &package.manifest().recipe).unwrap();
        assert!(reslice(name, &package, &other).unwrap() == first, "{name}: nothing was changed");
        for sets in [
            &["slice.layers=8", "slice.tile_texels=32"][..],
            &["fins.enabled=false", "pack.shell_format=rgba8"],
            &["slice.filter_width=1.0", "detail.enabled=false"],
            &["detail.enabled=true", "detail.simplified=false"],
            &["strands.enabled=true", "strands.points=5"],
        ]
        .into_iter()
        .skip(first_sets)
        {
            sets.iter().try_for_each(|set| other.set(set)).unwrap();
            let (ours, baked) = (reslice(name, &package, &other).unwrap(), bake(name, &other).unwrap().package);
            let textures = |bytes: &[u8]| Package::open(bytes, &Limits::default()).unwrap().manifest().textures.clone();
            assert_eq!(textures(&ours), textures(&baked), "{name}, {sets:?}");
            assert!(ours == baked, "{name}, {sets:?}");
        }
    }
}

#[test]
fn package_strands_match_their_tile() {
    for (name, points, tolerance) in [("hare", 9, 0.004), ("hare", 33, 0.0005), ("torus", 9, 0.01)] {
        let mut recipe = fur_recipe(name);
        recipe.strands.enabled = false;
        assert!(
            Package::open(&bake(name, &recipe).unwrap().package, &Limits::default())
                .unwrap()
                .strands()
                .unwrap()
                .is_none()
        );
        recipe.strands = StrandParams { enabled: true, points, ..StrandParams::default() };
        let bytes = bake(name, &recipe).unwrap().package;
        let package = Package::open(&bytes, &Limits::default()).unwrap();
        let view = package.strands().unwrap().unwrap();
        let hair = tile_hair(name, package.manifest()).unwrap().unwrap().strands;
        assert_eq!((view.strand_count() as usize, view.points_per_strand()), (hair.len(), points));
        let roots: Vec<glam::Vec3> = (0..hair.len()).map(|i| hair.points[hair.range(i).start]).collect();
        let stored: Vec<_> = view.points().collect();
        let mut worst = 0.0f32;
        for (strand, root) in stored.chunks(points as usize).zip(view.roots()) {
            // The tile is periodic, so two roots are the same if their difference is close to an integer number of
            // tiles.
            let apart = |i: &usize| {
                let d = roots[*i].truncate() - glam::Vec2::from(root);
                (d - d.round()).length()
            };
            let own = (0..hair.len()).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap();
            assert!(apart(&own) < 2e-5);
            let place = |p: &pelage_formats::StrandPoint| {
                let [u, v] = p.aside;
                roots[own] + glam::Vec3::new(u, v, p.height * hair.height)
            };
            let curve: Vec<_> = strand.iter().map(place).collect();
            for point in &hair.points[hair.range(own)] {
                let to = |pair: &[glam::Vec3]| {
                    let along = pair[1] - pair[0];
                    let t = ((*point - pair[0]).dot(along) / along.length_squared().max(1e-20)).clamp(0.0, 1.0);
                    point.distance(pair[0] + along * t)
                };
                worst = curve.windows(2).map(to).fold(f32::INFINITY, f32::min).max(worst);
            }
        }
        println!("{name}: {points} points lie within {worst:.5} widths of the tile of the strands");
        assert!(worst < tolerance, "{name}: {worst} with {points} points");
    }
}

#[test]
fn package_has_ink_unless_disabled() {
    let mut recipe = recipe("hare");
    let bytes = bake("hare", &recipe).unwrap().package;
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let (ink, textures) = (package.ink().unwrap().unwrap(), package.ink_textures().unwrap().unwrap());
    assert_eq!(ink.vertices().len(), package.mesh().unwrap().unwrap().vertex_count as usize);
    assert_eq!((textures.stroke.width, textures.wash.width, textures.paper.width), (256, 256, 256));
    assert_eq!(textures.fur.map(|fur| (fur.width, fur.layers)), Some((256, 2)));
    let bounds = package.manifest().bounds;
    assert!((ink.info.grain_size_m / bounds.radius - 0.8).abs() < 1e-4);
    let resolved = Recipe::parse("resolved", &package.manifest().recipe).unwrap().ink;
    let center = glam::Vec3::from(resolved.center.unwrap());
    assert!(center.distance(bounds.center.into()) <= 1.001 * bounds.radius, "{center}");
    assert_eq!(resolved.grain_size_m, Some(ink.info.grain_size_m));
    // The texture must contain dark texels and texels of bare paper.
    let shading = ink.info.shading;
    let grey = |v: pelage_formats::InkVertex| {
        (2.0 * f32::from(v.wash[0]) / 32767.0 * shading.wash_speed + shading.wash_range).clamp(0.0, 1.0)
    };
    let greys: Vec<f32> = ink.vertices().map(grey).collect();
    let share = |of: &dyn Fn(f32) -> bool| greys.iter().filter(|g| of(**g)).count() as f32 / greys.len() as f32;
    assert!(
        share(&|g| g < 0.65) > 0.15 && share(&|g| g > 0.8) > 0.15,
        "{} {}",
        share(&|g| g < 0.65),
        share(&|g| g > 0.8)
    );

    recipe.set("model.bare=*").unwrap();
    let bare = bake("hare", &recipe).unwrap().package;
    assert!(Package::open(&bare, &Limits::default()).unwrap().ink_textures().unwrap().unwrap().fur.is_none());
    recipe.set("ink.enabled=false").unwrap();
    let without = bake("hare", &recipe).unwrap().package;
    assert!(Package::open(&without, &Limits::default()).unwrap().ink().unwrap().is_none());
    assert!(without.len() + 500_000 < bare.len());
}

/// Steps of a bake that have begun and ended. Each must do so once.
#[derive(Default)]
pub struct StageLog {
    begun: Vec<Output>,
    ended: Vec<Output>,
}

impl StageLog {
    pub fn on_event(&mut self, event: StepEvent) {
        match event {
            StepEvent::Begins(step) => {
                assert!(!self.begun.contains(&step.makes), "{:?} is made twice", step.makes);
                let unfinished = self.begun.iter().find(|made| step.reads.contains(made) && !self.ended.contains(made));
                assert_eq!(unfinished, None, "{:?} begins before its input is made", step.makes);
                self.begun.push(step.makes);
            }
            StepEvent::Ends(step) => {
                let waits = self.begun.contains(&step.makes) && !self.ended.contains(&step.makes);
                assert!(waits, "{:?} ends twice or before it begins", step.makes);
                self.ended.push(step.makes);
            }
        }
    }

    /// Returns the stages that ran, in the order of [`STAGES`].
    pub fn stages(&self) -> Vec<&'static str> {
        assert_eq!(self.begun.len(), self.ended.len());
        let ran = |stage: &&str| STEPS.iter().any(|step| step.stage == *stage && self.ended.contains(&step.makes));
        STAGES.into_iter().filter(ran).collect()
    }
}

/// Runs the pipeline to its end. Returns the package, and the stages that ran.
fn run<'a>(input: &BakeInput<'a>, outputs: &mut Outputs<'a>) -> Result<(Vec<u8>, Vec<&'static str>), BakeError> {
    let mut log = StageLog::default();
    pipeline::run(input, outputs, &mut |event| log.on_event(event))?;
    Ok((outputs.package.get().unwrap().bytes.clone(), log.stages()))
}

/// Checks that every step runs with exactly the inputs that it declares, and fails if one of them is missing. A
/// repeated step must give the same output.
#[test]
fn bake_steps_need_exactly_their_declared_inputs() {
    let mut recipe = recipe("ox");
    // The textures are small, because only the dependencies between steps are tested.
    for set in [
        "slice.layers=4",
        "slice.tile_texels=32",
        "ink.stroke_texels=64",
        "ink.wash_texels=64",
        "ink.paper_texels=64",
        "ink.fur_texels=64",
    ] {
        recipe.set(set).unwrap();
    }
    let bytes = asset("models/ox.glb");
    let model = import("ox", &bytes, &mut |_, _| panic!("no files"), &ImportOptions::default()).unwrap();
    let images = MapImages::default();
    let input = BakeInput::new("ox", "ox", &recipe, &images);
    let mut whole = Outputs::of_model(&model);
    let (package, stages) = run(&input, &mut whole).unwrap();
    assert_eq!(stages, STAGES);
    assert!(
        whole.fin_textures.get().unwrap().is_some() && whole.ink.get().unwrap().is_some(),
        "fin textures and ink must be made"
    );
    assert_eq!(run(&input, &mut whole).unwrap(), (package.clone(), vec![]), "no stage may run if all outputs exist");
    assert_eq!(
        STEPS.iter().map(|step| step.makes).collect::<Vec<_>>(),
        Output::ALL[1..],
        "each output must be made by one step, in order"
    );
    for step in STEPS {
        let only = |kept: &[Output]| {
            let mut outputs = whole.clone();
            Output::ALL.iter().filter(|output| !kept.contains(output)).for_each(|output| outputs.clear(*output));
            outputs
        };
        let made = only(step.reads);
        step.run(&input, &made).unwrap_or_else(|error| panic!("{:?}: {error}", step.makes));
        assert!(made.has(step.makes));
        for missing in step.reads {
            let rest: Vec<_> = step.reads.iter().copied().filter(|read| read != missing).collect();
            let error = step.run(&input, &only(&rest)).unwrap_err().to_string();
            assert!(error.contains(&format!("{missing:?} is missing")), "{:?}: {error}", step.makes);
        }
        // A bake that repeats this step must give the same package.
        let mut again = whole.clone();
        again.invalidate(step.makes);
        assert!(!again.has(step.makes) && !again.has(Output::Package));
        let (same, stages) = run(&input, &mut again).unwrap();
        assert!(same == package, "the package differs after {:?} was repeated", step.makes);
        assert_eq!(stages[0], step.stage);
    }
}

/// Checks that a bake with a changed recipe may resume at the first step that reads the change. The result must equal a
/// whole bake.
#[test]
fn continued_bake_equals_a_whole_bake() {
    let first = recipe("torus");
    let mut other = first.clone();
    other.slice.layers = 6;
    other.slice.tile_texels = 32;
    let bytes = asset("models/torus.glb");
    let model = import("torus", &bytes, &mut |_, _| panic!("no files"), &ImportOptions::default()).unwrap();
    let images = MapImages::default();
    let input = |recipe| BakeInput::new("torus", "torus", recipe, &images);
    let mut outputs = Outputs::of_model(&model);
    run(&input(&first), &mut outputs).unwrap();
    outputs.invalidate(Output::Shells);
    outputs.invalidate(Output::FinTextures);
    let (package, stages) = run(&input(&other), &mut outputs).unwrap();
    assert_eq!(stages, ["slice", "fins", "pack"]);
    assert!(package == bake("torus", &other).unwrap().package);
    // No step makes the model, so it must be given.
    let error = run(&input(&first), &mut Outputs::default()).unwrap_err();
    assert!(matches!(&error, BakeError::Internal(reason) if reason.contains("Model is missing")), "{error}");
}

/// Checks that a slicer prepared once for a model gives the same bytes as whole bakes with changed recipes. The changes
/// concern layers, tiles, filters and fins, and other keys.
#[test]
fn slicer_reproduces_full_bakes() {
    let first = fur_recipe("torus");
    let bytes = asset("models/torus.glb");
    let model = import("torus", &bytes, &mut |_, _| panic!("no files"), &ImportOptions::default()).unwrap();
    let images = MapImages::default();
    let slicer = Slicer::new(BakeInput::new("torus", "torus", &first, &images), &model).unwrap();
    for sets in [
        &[][..],
        &["slice.layers=6", "slice.tile_texels=32"],
        &["slice.layers=24", "fins.enabled=false"],
        &["slice.filter_width=1.5", "fins.depth=0.5"],
        &["hair.density=300"],
        &["slice.layers=5", "pack.shell_format=rgba8", "ink.enabled=true"],
    ] {
        let mut other = first.clone();
        sets.iter().for_each(|set| other.set(set).unwrap());
        assert!(slicer.slice(&other).unwrap() == bake("torus", &other).unwrap().package, "{sets:?}");
    }
    let mut wrong = first.clone();
    wrong.slice.layers = 1;
    assert!(slicer.slice(&wrong).is_err());
}
