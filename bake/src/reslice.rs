//! A package sliced anew: other layers, tile, filter, formats or fins of the same strands on the same skin, without the model that it was baked from.
//!
//! Skin, materials and motions stay byte for byte; the strands grow again from the package's own recipe, and only what `slice` makes of them is new.

use crate::BakeError;
use crate::recipe::Recipe;
use crate::stages::detail;
use crate::stages::groom::MapImages;
use crate::stages::hair::Strands;
use crate::stages::ink::{self, InkTextures};
use crate::stages::pack::Textures;
use crate::stages::textures::{self, SLABS};
use crate::strands::tile_hair;
use pelage_formats::{FinInfo, FurInfo, InkData, Manifest, Package, PackageWriter, Tag};

/// The textures of the ink style anew, where `recipe` has them in another format than the package; `None` where they stay, also where a scan would be
/// needed that is no part of the package.
fn repainted(
    file: &str,
    old: &Manifest,
    recipe: &Recipe,
    strands: Option<&Strands>,
) -> Result<Option<InkTextures>, BakeError> {
    let own = Recipe::parse(file, &old.recipe)?;
    let format = |recipe: &Recipe| (recipe.pack.shell_format, recipe.pack.bc_quality);
    let scanned = own.ink.stroke_image.is_some() || own.ink.wash_image.is_some();
    if scanned || format(&own) == format(recipe) {
        return Ok(None);
    }
    ink::textures(&own.ink, &recipe.pack, &MapImages::default(), strands).map(Some)
}

/// Slices a package as the sections `[slice]`, `[fins]`, `[detail]` and `[pack]` of `recipe` say; what else it says should be the package's own.
/// A package without fins gets none: on which edges they stand is known from the model alone.
///
/// # Errors
///
/// As [`tile_hair`]; [`BakeError::Params`] for values out of their ranges, [`BakeError::Input`] for a package without fur.
pub fn reslice(file: &str, package: &Package<'_>, recipe: &Recipe) -> Result<Vec<u8>, BakeError> {
    recipe.validate()?;
    let fault = |source| BakeError::Package { file: file.to_owned(), source };
    let old = package.manifest();
    let Some(hair) = tile_hair(file, old)? else {
        let reason = "there is none, expected a package with hair to slice".into();
        return Err(BakeError::Input { file: file.into(), place: "the manifest's fur".into(), reason });
    };
    let with_coat = detail::has_coat(recipe);
    let slice = |strands| textures::shell_textures(strands, &recipe.slice, &recipe.pack, with_coat);
    let (mut shells, wet) = (slice(&hair.strands)?, hair.wet.as_ref().map(slice).transpose()?);
    let coat = shells.coat.take();
    let fins = match (&old.fur.fins, recipe.fins.depth) {
        (Some(_), Some(depth)) if recipe.fins.enabled => {
            Some(textures::fin_textures(&hair.strands, depth, &recipe.slice, &recipe.pack)?)
        }
        _ => None,
    };

    let mut textures = Textures::default();
    let new_shells = textures.add_shells("shell", &shells);
    // What materials name moves along.
    let mut moved = vec![None; old.textures.len()];
    let mut keep = |textures: &mut Textures<'_>, index: Option<u32>| {
        let Some(index) = index else { return Ok(None) };
        let slot = &mut moved[index as usize];
        if slot.is_none() {
            let sections = package.sections().iter().enumerate().filter(|(_, s)| s.tag == Tag::TEXTURE);
            let nth = sections.map(|(i, _)| i).nth(index as usize).unwrap_or(usize::MAX);
            let bytes = package.section_bytes(nth).map_err(fault)?.to_vec();
            *slot = Some(textures.add(old.textures[index as usize].name.as_str(), bytes));
        }
        Ok::<_, BakeError>(*slot)
    };
    let mut materials = old.materials.clone();
    for material in &mut materials {
        material.base_color_texture = keep(&mut textures, material.base_color_texture)?;
        material.groom_texture = keep(&mut textures, material.groom_texture)?;
    }
    let wet = wet.as_ref().map(|shells| textures.add_shells("wet_shell", shells));
    let fin_info = fins.as_ref().map(|fins| {
        let (width, height) = (fins.width, fins.height);
        let indices = textures.add_shells("fin", &fins.textures);
        FinInfo {
            width,
            height,
            slabs: SLABS.len() as u32,
            color_texture: indices.color_texture,
            direction_texture: indices.direction_texture,
        }
    });
    let with_fins = fin_info.is_some();
    let mut ink = package.ink().map_err(fault)?.map(|ink| ink.to_data());
    if let Some(InkData { info, .. }) = &mut ink {
        // Ink is painted on the skin and after the strands, and neither changes; its textures' format may.
        let kept = [&mut info.stroke_texture, &mut info.wash_texture, &mut info.paper_texture];
        if let Some(new) = repainted(file, old, recipe, info.fur_texture.and(Some(&hair.strands)))? {
            let files = [("ink_stroke", new.stroke), ("ink_wash", new.wash), ("ink_paper", new.paper)];
            for (index, (name, file)) in kept.into_iter().zip(files) {
                *index = textures.add(name, file);
            }
            info.fur_texture = new.fur.map(|file| textures.add("ink_fur", file));
        } else {
            for index in kept {
                *index = keep(&mut textures, Some(*index))?.unwrap_or(*index);
            }
            info.fur_texture = keep(&mut textures, info.fur_texture)?;
        }
    }
    let manifest = Manifest {
        recipe: recipe.to_toml(),
        fur: FurInfo {
            layers: recipe.slice.layers,
            tile_texels: recipe.slice.tile_texels,
            color_texture: new_shells.color_texture,
            direction_texture: new_shells.direction_texture,
            wet,
            fins: fin_info,
            ..old.fur
        },
        materials,
        textures: textures.entries,
        coat: coat.as_ref().map(|coat| coat.info),
        detail: detail::levels(&recipe.detail, recipe.slice.layers, coat.as_ref()),
        choice: None,
        ..old.clone()
    };
    let mut writer = PackageWriter::new(manifest);
    let sections = || package.sections().iter().enumerate();
    let made = [Tag::MANIFEST, Tag::TEXTURE, Tag::FINS, Tag::INK];
    for (index, section) in sections().filter(|(_, s)| !made.contains(&s.tag)) {
        writer = writer.section(section.tag, package.section_bytes(index).map_err(fault)?);
    }
    for file in textures.files {
        writer = writer.texture(file);
    }
    for (index, section) in sections().filter(|(_, s)| with_fins && s.tag == Tag::FINS) {
        writer = writer.section(section.tag, package.section_bytes(index).map_err(fault)?);
    }
    if let Some(ink) = &ink {
        writer = writer.ink(ink);
    }
    writer.finish().map_err(|fault| BakeError::Internal(format!("the package sliced anew does not read back: {fault}")))
}
