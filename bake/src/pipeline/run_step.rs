//! Implementation of the steps. Each step reads its inputs, calls its stage and stores the output.

use super::input::BakeInput;
use super::layout::{Layout, lay_out_model};
use super::outputs::{
    Groomed, Output, Outputs, PackageBytes, Shells, SkinFiles, SkinImages, StrandVisibility, required, store,
};
use crate::recipe::{ColorParams, HairColors, Recipe};
use crate::stages::contours::{ContourTarget, contour_mesh};
use crate::stages::groom::{self, Atlas, BareDistances, Lengths, Pattern, RootAtlas, RootColorInput, Vertices};
use crate::stages::ink::{self, InkTarget, VertexInk};
use crate::stages::pack::{self, ModelResults, PackInput};
use crate::stages::painting::{self, PaintedModel};
use crate::stages::simulate::{LateralOffsets, StyleForces, TileHair};
use crate::stages::surface::Surface;
use crate::stages::{detail, fins, hair_groups, scatter, slice, strand_data, visibility};
use Output::*;
use pelage_formats::Shading;
use pelage_import::BakeError;
use pelage_import::mesh::{Mesh, RestPose};
use std::sync::Arc;

pub(super) fn surface<'a>(input: &BakeInput<'a>, outputs: &Outputs<'a>) -> Result<(), BakeError> {
    let model = required(&outputs.model, Model)?;
    store(&outputs.laid, Layout, lay_out_model(input, model)?)
}

pub(super) fn simulate(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let laid = required(&outputs.laid, Layout)?;
    let HairColors { root, tip, .. } = laid.hair_colors;
    let color = ColorParams { root: Some(root), tip: Some(tip), ..input.recipe.color.clone() };
    let recipe = Recipe { color, ..laid.filled.clone() };
    store(&outputs.hair, Hair, TileHair::grow(&recipe, laid.lengths, laid.maps.fur_wetness())?)
}

pub(super) fn visible(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let (hair, params) = (required(&outputs.hair, Hair)?, &input.recipe.visibility);
    let find = || {
        let dry = visibility::visibility(&hair.strands, params, None)?;
        // Dry and wet hair use the same horizon, because they are blended.
        let wet = |strands| visibility::visibility(strands, params, Some(dry.horizon));
        let wet = hair.wet.as_ref().map(wet).transpose()?;
        Ok::<_, BakeError>(self::StrandVisibility { dry, wet })
    };
    store(&outputs.visible, StrandVisibility, params.enabled.then(find).transpose()?)
}

pub(super) fn slice(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let (hair, recipe) = (required(&outputs.hair, Hair)?, input.recipe);
    let with_coat = detail::has_far_layer(recipe);
    let volumes = 1 + u64::from(hair.wet.is_some());
    input.progress.add("slice", volumes * u64::from(recipe.slice.layers + u32::from(with_coat)));
    let visible = required(&outputs.visible, StrandVisibility)?.as_ref();
    let slice = |strands, visible| {
        let on_layer = &mut || input.progress.step("slice");
        slice::shell_textures(strands, visible, &recipe.slice, &recipe.pack, with_coat, on_layer)
    };
    let dry = slice(&hair.strands, visible.map(|v| &v.dry))?;
    let wet = hair.wet.as_ref().map(|strands| slice(strands, visible.and_then(|v| v.wet.as_ref()))).transpose()?;
    let shells = self::Shells { dry, wet };
    store(&outputs.shells, Shells, shells)
}

pub(super) fn single(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let (hair, params) = (required(&outputs.hair, Hair)?, &input.recipe.strands);
    let visible = required(&outputs.visible, StrandVisibility)?.as_ref();
    let visible = [visible.map(|v| &v.dry), visible.and_then(|v| v.wet.as_ref())];
    store(&outputs.single, Single, params.enabled.then(|| strand_data::strands(hair, visible, params.points)))
}

pub(super) fn groom(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let (laid, recipe) = (required(&outputs.laid, Layout)?, input.recipe);
    let model = laid.model(required(&outputs.model, Model)?);
    let self::Layout { bounds, furred, maps, .. } = laid;
    let mut surface = laid.surface.clone();
    let pattern = Pattern::new(&recipe.color, input.images, bounds)?;
    let asides = LateralOffsets::from_strands(&required(&outputs.hair, Hair)?.strands);
    let rooting = RootColorInput {
        furred,
        pattern: pattern.as_ref(),
        asides: &asides.mean,
        reach: asides.reach(),
        most_side: recipe.color.pattern_texels,
    };
    let colored =
        |surface: &Surface| groom::colors(model, &Vertices::from(surface), maps, furred, recipe.color.base_color);
    let roots = if recipe.color.at_root {
        let uncut = colored(&surface)?;
        RootAtlas::new(&mut surface, &uncut, &rooting)
    } else {
        None
    };
    let plain = pattern.as_ref().filter(|_| roots.is_none());
    let atlas = plain.map(|_| Atlas::new(&mut surface, recipe.color.pattern_texels)).transpose()?;
    let mut coat = maps.vertex_groom(&Vertices::from(&surface))?;
    let (skin, longest_m) = ((&surface.mesh, &surface.rest), laid.lengths.length_m);
    let chosen_m = || groom::chosen_margin_m(skin, furred, &coat.length, longest_m, bounds.radius);
    let bare_margin_m = recipe.groom.bare_margin_m.or_else(chosen_m);
    if let Some(margin_m) = bare_margin_m.filter(|margin_m| *margin_m > 0.0) {
        BareDistances::new(skin.0, skin.1, furred, margin_m).shorten(&mut coat.length);
    }
    let open = recipe.groom.bare_margin_m.is_none();
    let decisions = bare_margin_m.filter(|_| open).map(groom::margin_decision).into_iter().collect();
    let mut colors = colored(&surface)?;
    let mut grooms = maps.textures()?;
    if let Some(roots) = &roots {
        roots.paint(&rooting, &mut surface, &mut colors, &mut grooms);
    }
    if let (Some(pattern), Some(atlas)) = (plain, &atlas) {
        pattern.paint(atlas, furred, &mut surface, &mut colors, &mut grooms);
    }
    colors.lighten(furred, laid.hair_colors.gain);
    let warnings = atlas.as_ref().and_then(Atlas::warning).into_iter().collect();
    let pattern_size_m = pattern.as_ref().map(Pattern::width_m);
    let roots = roots.map(|roots| roots.info(asides.at));
    let made =
        self::Groomed { surface, coat, colors, grooms, pattern_size_m, roots, bare_margin_m, decisions, warnings };
    store(&outputs.groomed, Groomed, Arc::new(made))
}

/// Returns the height of the fur, metres.
fn height_m(hair: &TileHair, lengths: Lengths) -> f32 {
    hair.strands.height * lengths.tile_size_m
}

pub(super) fn guided(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let (laid, groomed) = (required(&outputs.laid, Layout)?, required(&outputs.groomed, Groomed)?);
    let model = laid.model(required(&outputs.model, Model)?);
    let ground = hair_groups::GroomTarget {
        file: input.file,
        mesh: &groomed.surface.mesh,
        rest: &groomed.surface.rest,
        radius_m: laid.bounds.radius,
        materials: &model.materials,
        nodes: &model.nodes,
        files: input.images,
    };
    store(&outputs.guided, Guided, hair_groups::groups(&input.recipe.strands, &ground)?)
}

pub(super) fn fins(_: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let (laid, hair) = (required(&outputs.laid, Layout)?, required(&outputs.hair, Hair)?);
    let groomed = required(&outputs.groomed, Groomed)?;
    let (height_m, tile_size_m) = (height_m(hair, laid.lengths), laid.lengths.tile_size_m);
    let fins = fins::fins(&groomed.surface, &laid.furred, &groomed.coat, height_m, tile_size_m);
    store(&outputs.fins, Fins, pack::model_fins(&groomed.surface, &fins))
}

pub(super) fn fin_textures(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let (hair, fins, recipe) = (required(&outputs.hair, Hair)?, required(&outputs.fins, Fins)?, input.recipe);
    let depth = recipe.fins.depth.or(fins.depth).filter(|_| recipe.fins.enabled && fins.section.is_some());
    let make = |depth| slice::fin_textures(&hair.strands, depth, &recipe.slice, &recipe.pack);
    store(&outputs.fin_textures, FinTextures, depth.map(make).transpose()?)
}

pub(super) fn scatter(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let (skin, guided) = (required(&outputs.skin, Skin)?, required(&outputs.guided, Guided)?);
    let materials = skin.manifest.materials.iter().map(|material| material.name.as_str());
    let groups = guided.groups.iter().map(|group| group.name.as_str());
    let scatters = input.recipe.shading.scatters();
    store(
        &outputs.fibres,
        Fibres,
        scatters.then(|| scatter::tables(&input.recipe.fibre, materials, groups)).transpose()?,
    )
}

pub(super) fn ink(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let laid = required(&outputs.laid, Layout)?;
    let model = laid.model(required(&outputs.model, Model)?);
    let self::Groomed { surface, .. } = &**required(&outputs.groomed, Groomed)?;
    let (mesh, rest, radius) = (&surface.mesh, &surface.rest, laid.bounds.radius);
    // The wash is on bare surface.
    let bare = (!mesh.bare_normals.is_empty()).then(|| {
        let (positions, normals) = (mesh.positions.clone(), mesh.bare_normals.clone());
        RestPose::of(&Mesh { positions, normals, skin: mesh.skin.clone(), ..Mesh::default() }, model.animation.as_ref())
    });
    let rest = bare.as_ref().unwrap_or(rest);
    let canvas = InkTarget { mesh, rest, radius, materials: &model.materials, images: input.images };
    let params = &input.recipe.ink;
    let fur = ink::fur_strength(input.recipe, model, &laid.furred);
    store(&outputs.ink, Ink, params.enabled.then(|| ink::vertex_ink(params, fur, &canvas)).transpose()?)
}

pub(super) fn painting(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let (laid, groomed) = (required(&outputs.laid, Layout)?, required(&outputs.groomed, Groomed)?);
    let model = laid.model(required(&outputs.model, Model)?);
    let (guided, ink) = (required(&outputs.guided, Guided)?, required(&outputs.ink, Ink)?);
    let hair_m: Vec<f32> = groomed.coat.length.iter().map(|share| share * laid.lengths.length_m).collect();
    let paint = || {
        Arc::new(painting::painting(&PaintedModel {
            surface: &groomed.surface,
            colors: &groomed.colors,
            bounds: &laid.bounds,
            materials: &model.materials,
            furred: &laid.furred,
            hair_m: &hair_m,
            head: laid.head.as_ref(),
            ink: ink.as_ref().map_or(&[], |ink| &ink.vertices),
            groups: &guided.groups,
            seed: input.recipe.ink.seed,
        }))
    };
    store(&outputs.painting, Painting, input.recipe.ink.enabled.then(paint))
}

pub(super) fn ink_textures(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let (laid, hair, recipe) = (required(&outputs.laid, Layout)?, required(&outputs.hair, Hair)?, input.recipe);
    let painting = &outputs.kept.painting;
    let paint = |skin: &VertexInk| {
        let strokes = laid.furred.contains(&true) && skin.shading.fur > 0.0;
        let strands = strokes.then_some(&hair.strands);
        ink::textures_with_memo(&recipe.ink, &recipe.pack, input.images, strands, input.progress, painting)
    };
    store(&outputs.ink_textures, InkTextures, required(&outputs.ink, Ink)?.as_ref().map(paint).transpose()?)
}

pub(super) fn contours(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let laid = required(&outputs.laid, Layout)?;
    let model = laid.model(required(&outputs.model, Model)?);
    let self::Groomed { surface, colors, .. } = &**required(&outputs.groomed, Groomed)?;
    let ink = required(&outputs.ink, Ink)?;
    let target = ContourTarget {
        mesh: &surface.mesh,
        rest: &surface.rest,
        radius: laid.bounds.radius,
        colors,
        furred: &laid.furred,
        animation: model.animation.as_ref(),
        ink: ink.as_ref().map_or(&[], |ink| &ink.vertices),
        painting: required(&outputs.painting, Painting)?.as_deref(),
    };
    let made = input.recipe.ink.enabled.then(|| Arc::new(contour_mesh(&target)));
    store(&outputs.contours, Contours, made)
}

pub(super) fn skin(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let laid = required(&outputs.laid, Layout)?;
    let model = laid.model(required(&outputs.model, Model)?);
    let (hair, groomed, recipe) = (required(&outputs.hair, Hair)?, required(&outputs.groomed, Groomed)?, input.recipe);
    let images = SkinImages { groomed: groomed.clone(), pack: recipe.pack.clone() };
    let files = outputs.kept.skin.make(images, SkinFiles::encode)?;
    let mut warnings = [&laid.warnings[..], &groomed.warnings].concat();
    let gloss = groom::gloss(model, &laid.furred, &recipe.shading, &mut warnings);
    let pieces = ModelResults {
        name: input.name,
        progress: input.progress,
        model,
        inputs: &input.images.inputs,
        surface: &groomed.surface,
        furred: &laid.furred,
        coat: &groomed.coat,
        colors: &groomed.colors,
        bounds: laid.bounds,
        bare: &laid.bare,
        bare_margin_m: groomed.bare_margin_m,
        lengths: laid.lengths,
        filled: &laid.filled,
        hair_colors: laid.hair_colors,
        height_m: height_m(hair, laid.lengths),
        strands: laid.filled.strands_in_tile(),
        pattern_size_m: groomed.pattern_size_m,
        roots: groomed.roots.as_ref(),
        base_colors: &files.base_colors,
        groom_textures: &files.grooms,
        groom_of_material: &groomed.grooms.of_material,
        gloss: &gloss,
        simplified: recipe.detail.has_lists(),
        warnings: &warnings,
    };
    store(&outputs.skin, Skin, pack::model_part(&pieces, &outputs.kept.of_skin))
}

pub(super) fn pack(input: &BakeInput<'_>, outputs: &Outputs<'_>) -> Result<(), BakeError> {
    let shells = required(&outputs.shells, Shells)?;
    let ink = required(&outputs.ink, Ink)?.as_ref().zip(required(&outputs.ink_textures, InkTextures)?.as_ref());
    let (skin, hair) = (required(&outputs.skin, Skin)?, required(&outputs.hair, Hair)?);
    let shading = Shading::from(&input.recipe.shading);
    // Without a furred material, the strands are unused.
    let furred = skin.manifest.materials.iter().any(|material| material.furred);
    let packed = pack::pack(&PackInput {
        recipe: input.recipe,
        shading: if StyleForces::of(hair.style).wet { shading.wet() } else { shading },
        skin,
        shells: &shells.dry,
        wet_shells: shells.wet.as_ref(),
        strands: required(&outputs.single, Single)?.as_ref().filter(|_| furred),
        hair: required(&outputs.guided, Guided)?,
        fins: required(&outputs.fins, Fins)?,
        fin_textures: required(&outputs.fin_textures, FinTextures)?.as_ref(),
        fibres: required(&outputs.fibres, Fibres)?.as_ref(),
        ink,
        painting: required(&outputs.painting, Painting)?.as_ref(),
        contours: required(&outputs.contours, Contours)?.as_ref(),
    });
    let (bytes, warnings) = packed.map_err(|error| match error {
        BakeError::Params { what, reason } => BakeError::Input {
            file: input.file.to_owned(),
            place: "whole model".to_owned(),
            reason: format!(
                "{what} follows from the model's size: {reason}; set it in the recipe, or \
                 correct the unit of the model with model.unit_m"
            ),
        },
        other => other,
    })?;
    store(&outputs.package, Package, PackageBytes { bytes, warnings })
}
