//! Package as a folder of files, which `unpack` writes and `pack` reads. This module works in memory, without file
//! access.
//!
//! * `manifest.json`: the manifest and the list of sections with the file of each
//! * `recipe.toml`: the recipe, which the manifest omits to avoid a duplicate
//! * `<name>.ktx2`: the textures
//! * `mesh.glb`: the mesh
//! * `animation.json`: skeleton and clips
//! * `strands.hair`, `strands.json`: the strands of the tile
//! * `hair_<k>_<name>.hair`, `hair.json`: the guides of each group
//! * `fins.bin`, `ink.bin`: the fins and the ink style, as `FORMAT.md` defines their sections
//! * `section_<k>_<TAG>.bin`: sections that this version does not know, or cannot write in another form without loss

mod hair;
mod json;
mod strands;
mod tile;

use super::mesh_glb;
pub use json::File;
use json::{deserialize, json_value, known_keys, parse, shorten_floats, to_text};
use pelage_bake::hexadecimal::{from_hex, hex};
use pelage_bake::recipe::Recipe;
use pelage_bake::recipe_mismatch::{Mismatch, mismatches};
use pelage_bake::stages::assemble::{Content, assemble};
use pelage_bake::stages::hair_groups::RestMesh;
use pelage_formats::{
    Animation, FORMAT_VERSION, FormatError, Limits, Manifest, MorphMotion, Package, Tag, TextureEntry,
};
use pelage_import::BakeError;
use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

/// Name of the file that every unpacked folder has.
pub const MANIFEST: &str = "manifest.json";
const RECIPE: &str = "recipe.toml";
const MESH: &str = "mesh.glb";
const ANIMATION: &str = "animation.json";
const FINS: &str = "fins.bin";
const INK: &str = "ink.bin";
/// Key and value that identify the version of the folder's layout.
const FORM: (&str, u64) = ("pelage_unpacked", 3);
/// Key of the package's format version; an old package is packed in its own version.
const VERSION: &str = "format_version";
/// Key of the SHA-256 of recipe.toml when it was unpacked, from which `pack` detects edits. Missing in folders of older
/// versions.
const RECIPE_DIGEST: &str = "recipe_sha256";
/// Key of the disagreements between recipe and package that existed when it was unpacked; `pack` accepts these. Missing
/// in folders of older versions.
const RECIPE_DISAGREES: &str = "recipe_disagrees";

/// Key of the names of a section's `.hair` files.
const STRANDS: &str = "strands";

/// Returns the contents of the file with the given name; `None` if it does not exist.
pub type Read<'a> = dyn FnMut(&str) -> Result<Option<Vec<u8>>, BakeError> + 'a;

/// Converts a package to files. `name` is the package's file name, for messages.
pub fn unpack(name: &str, package: &Package<'_>) -> Result<Vec<File>, BakeError> {
    let damaged = |source| BakeError::Package { file: name.to_owned(), source };
    let internal = |e: serde_json::Error| BakeError::Internal(format!("writing JSON: {e}"));
    let manifest = package.manifest();
    let mut files = vec![(RECIPE.to_owned(), manifest.recipe.clone().into_bytes())];
    let mut list = Vec::new();
    let mut textures = manifest.textures.iter();
    for (index, section) in package.sections().iter().enumerate() {
        let bytes = package.section_bytes(index).map_err(damaged)?;
        let alone = |file| vec![file];
        let found: Option<Vec<File>> = match section.tag {
            Tag::MANIFEST => None,
            Tag::MESH => package.mesh().map_err(damaged)?.and_then(|mesh| {
                let mesh = mesh.to_data();
                let glb = mesh_glb::write(&mesh, manifest)?;
                let same = mesh_glb::read(MESH, &glb).is_ok_and(|back| back == mesh);
                same.then(|| alone((MESH.to_owned(), glb)))
            }),
            Tag::ANIMATION => match package.animation().map_err(damaged)? {
                Some(animation) => {
                    let mut value = serde_json::to_value(&*animation).map_err(internal)?;
                    shorten_floats(&mut value);
                    let text = to_text(&value);
                    // The motion of morph targets is omitted, because it has its own section.
                    let own = Animation { morphs: MorphMotion::default(), ..(*animation).clone() };
                    let same = parse::<Animation>(ANIMATION, text.as_bytes()).is_ok_and(|back| back == own);
                    same.then(|| alone((ANIMATION.to_owned(), text.into_bytes())))
                }
                None => None,
            },
            Tag::STRANDS => match package.strands().map_err(damaged)? {
                Some(view) => strands::write(&view.stored(), &manifest.fur)?,
                None => None,
            },
            Tag::HAIR => {
                let groups = package.hair_groups().map_err(damaged)?;
                // In older versions, another kind of section may have no groups.
                if groups.is_empty() { None } else { hair::write(&groups, &RestMesh::of(package).map_err(damaged)?)? }
            }
            Tag::FINS if package.fins().map_err(damaged)?.is_some() => Some(alone((FINS.to_owned(), bytes.to_vec()))),
            Tag::INK if package.ink().map_err(damaged)?.is_some() => Some(alone((INK.to_owned(), bytes.to_vec()))),
            Tag::TEXTURE => textures.next().map(|t| alone((format!("{}.ktx2", t.name), bytes.to_vec()))),
            _ => None,
        };
        let tag = tag_to_json(section.tag);
        if section.tag == Tag::MANIFEST {
            list.push(json!({ "tag": tag }));
            continue;
        }
        let found = found.unwrap_or_else(|| alone((raw_name(index, section.tag), bytes.to_vec())));
        let mut names = found.iter().map(|(name, _)| name.as_str());
        let mut entry = json!({ "tag": tag, "file": names.next() });
        if let [_, _, ..] = found[..] {
            entry[STRANDS] = names.collect();
        }
        list.push(entry);
        files.extend(found);
    }
    let document = json!({
        FORM.0: FORM.1,
        VERSION: package.version(),
        RECIPE_DIGEST: digest_of(&manifest.recipe),
        RECIPE_DISAGREES: mismatches(manifest, &manifest.recipe).iter().map(in_words).collect::<Vec<_>>(),
        "sections": list,
        "manifest": manifest_to_json(manifest).map_err(internal)?,
    });
    files.insert(0, (MANIFEST.to_owned(), to_text(&document).into_bytes()));
    // `pack` must restore the same bytes. This is checked here, while the package is available for comparison.
    let back = pack(name, &mut |file| {
        let found = files.iter().find(|(name, _)| name == file);
        Ok(found.map(|(_, bytes)| bytes.clone()))
    })?;
    if back != package.bytes() {
        return Err(BakeError::Internal(format!("{name}: packing the unpacked files gives other bytes")));
    }
    Ok(files)
}

/// Converts a folder to a package. `folder` is its name for messages; `read` returns its files.
pub fn pack(folder: &str, read: &mut Read<'_>) -> Result<Vec<u8>, BakeError> {
    let path = |file: &str| std::path::Path::new(folder).join(file).display().to_string();
    let fail = |file: &str, place: &str, reason: String| BakeError::Input {
        file: path(file),
        place: if place.is_empty() { "whole file".into() } else { place.to_owned() },
        reason,
    };
    let text = read(MANIFEST)?
        .ok_or_else(|| fail(MANIFEST, "", "missing, expected a folder written by `pelage unpack`".into()))?;
    let mut document: Value = json_value(&path(MANIFEST), &text)?;
    let at = format!("/{}", FORM.0);
    if document[FORM.0] != FORM.1 {
        return Err(fail(MANIFEST, &at, format!("found {}, expected {}", document[FORM.0], FORM.1)));
    }
    let recipe =
        read(RECIPE)?.ok_or_else(|| fail(RECIPE, "", "missing, expected the recipe (the file may be empty)".into()))?;
    let recipe = String::from_utf8(recipe)
        .map_err(|e| fail(RECIPE, &format!("byte {}", e.utf8_error().valid_up_to()), "expected UTF-8".into()))?;
    let edited = document[RECIPE_DIGEST] != digest_of(&recipe);
    let manifest = manifest_from_json(&path(MANIFEST), document["manifest"].take(), recipe)?;
    if edited {
        // The recipe only records how the fur was made, so an edit could make the record wrong.
        Recipe::parse_recorded(&path(RECIPE), &manifest.recipe)?;
    }
    let advice = "`pelage pack` does not bake fur: undo the edit, or bake the model with this recipe";
    let known = match document.get(RECIPE_DISAGREES) {
        None => None,
        Some(Value::Array(list)) => Some(list),
        Some(other) => {
            return Err(fail(MANIFEST, &format!("/{RECIPE_DISAGREES}"), format!("found {other}, expected a list")));
        }
    };
    for found in mismatches(&manifest, &manifest.recipe) {
        if edited {
            return Err(fail(RECIPE, found.key, format!("{}; {advice}", found.reason)));
        }
        if known.is_some_and(|known| !known.contains(&in_words(&found).into())) {
            return Err(fail(MANIFEST, "/manifest/fur", format!("{RECIPE}: {}; {advice}", in_words(&found))));
        }
    }
    let list = document["sections"].take();
    let mut expected = json!({ FORM.0: FORM.1, VERSION: FORMAT_VERSION, "sections": null, "manifest": null });
    for key in [RECIPE_DIGEST, RECIPE_DISAGREES] {
        if let Some(there) = document.get(key) {
            expected[key] = there.clone();
        }
    }
    known_keys(&path(MANIFEST), "", &document, &expected)?;
    let version =
        document[VERSION].as_u64().and_then(|v| u32::try_from(v).ok()).filter(|v| (1..=FORMAT_VERSION).contains(v));
    let version = version.ok_or_else(|| {
        let reason = format!("found {}, expected 1..={FORMAT_VERSION}", document[VERSION]);
        fail(MANIFEST, &format!("/{VERSION}"), reason)
    })?;
    let list = list.as_array().ok_or_else(|| fail(MANIFEST, "/sections", format!("found {list}, expected a list")))?;
    let mut sections = Vec::new();
    // Textures are collected by file name, in order, and compared with the manifest's list below.
    let mut textures = 0;
    // Index of the hair guides among the sections, and their files.
    let mut guides = None;
    for (index, entry) in list.iter().enumerate() {
        let at = format!("/sections/{index}");
        let tag = tag_from_json(&entry["tag"]).ok_or_else(|| {
            fail(MANIFEST, &format!("{at}/tag"), format!("found {}, expected four characters", entry["tag"]))
        })?;
        if (tag == Tag::MANIFEST) != (index == 0) {
            return Err(fail(MANIFEST, &format!("{at}/tag"), "expected MANI first, and only there".into()));
        }
        if index == 0 {
            known_keys(&path(MANIFEST), &at, entry, &json!({ "tag": null }))?;
            continue;
        }
        let raw = entry["file"].as_str().is_some_and(|file| file.ends_with(".bin"));
        let is_hair = !raw && [Tag::STRANDS, Tag::HAIR].contains(&tag);
        let mut keys = json!({ "tag": null, "file": null });
        if is_hair {
            keys[STRANDS] = json!([]);
        }
        known_keys(&path(MANIFEST), &at, entry, &keys)?;
        let plain = |name: &&str| !name.is_empty() && !name.starts_with('.') && !name.contains(['/', '\\', ':', '\0']);
        // Returns the contents of the file named in the manifest.
        let mut named = |value: &Value, at: String| {
            let file = value
                .as_str()
                .filter(plain)
                .ok_or_else(|| fail(MANIFEST, &at, format!("found {value}, expected a file name without folders")))?;
            let bytes =
                read(file)?.ok_or_else(|| fail(file, "", format!("missing, but {MANIFEST} names it at {at}")))?;
            Ok::<_, BakeError>((file.to_owned(), bytes))
        };
        let (file, bytes) = named(&entry["file"], format!("{at}/file"))?;
        if is_hair {
            let list = entry[STRANDS].as_array().ok_or_else(|| {
                let reason = format!("found {}, expected a list of file names", entry[STRANDS]);
                fail(MANIFEST, &format!("{at}/{STRANDS}"), reason)
            })?;
            let mut found = Vec::new();
            for (k, name) in list.iter().enumerate() {
                let (file, bytes) = named(name, format!("{at}/{STRANDS}/{k}"))?;
                found.push((path(&file), bytes));
            }
            let described = (path(&file), bytes);
            if tag == Tag::STRANDS {
                sections.push(Content::StoredStrands(strands::read(&described, &found)?));
            } else if guides.replace((sections.len(), described, found)).is_some() {
                return Err(fail(MANIFEST, &format!("{at}/tag"), format!("a second {tag}, expected at most one")));
            }
            continue;
        }
        sections.push(match tag {
            Tag::MESH if !raw => Content::Mesh(mesh_glb::read(&path(&file), &bytes)?.into()),
            Tag::ANIMATION if !raw => Content::Animation(parse::<Animation>(&path(&file), &bytes)?.into()),
            Tag::TEXTURE => {
                let expected = manifest.textures.get(textures).map(|t| format!("{}.ktx2", t.name));
                if expected.as_ref() != Some(&file) {
                    let expected = expected.unwrap_or_else(|| "no further texture in /manifest/textures".into());
                    return Err(fail(MANIFEST, &format!("{at}/file"), format!("found {file:?}, expected {expected}")));
                }
                textures += 1;
                check_texture(&path(&file), &bytes)?;
                Content::Texture(bytes.into())
            }
            _ => Content::Bytes(tag, bytes.into()),
        });
    }
    if textures != manifest.textures.len() {
        let reason = format!("{} textures, but /sections lists {textures}", manifest.textures.len());
        return Err(fail(MANIFEST, "/manifest/textures", reason));
    }
    let faulty = |error: FormatError| {
        let file = match error.section() {
            Some(Tag::MESH) => MESH,
            Some(Tag::ANIMATION) => ANIMATION,
            Some(Tag::STRANDS) => strands::JSON,
            Some(Tag::HAIR) => hair::JSON,
            Some(Tag::FINS) => FINS,
            Some(Tag::INK) => INK,
            _ => MANIFEST,
        };
        // The error's byte offset is omitted, because it refers to a package that is not written.
        let reason = match error {
            FormatError::Content { reason, .. } => reason,
            other => other.to_string(),
        };
        fail(file, "contents", reason)
    };
    if let Some((index, described, found)) = guides {
        // Guides are read with the mesh surface at rest, taken from the package without guides. Their motion and the
        // fibres are left out too, because they require guides.
        let needs_guides = |section: &Content<'_>| {
            matches!(section, Content::Bytes(Tag::HAIR_MOTION | Tag::FIBRES | Tag::MEDULLAE, _))
        };
        let skin = sections.iter().filter(|section| !needs_guides(section));
        let without = assemble(version, manifest.clone(), skin.map(Content::borrowed)).map_err(faulty)?;
        let skin = Package::open(&without, &Limits::default()).and_then(|package| RestMesh::of(&package));
        let groups = hair::read(&described, &found, &skin.map_err(faulty)?)?;
        sections.insert(index, Content::Hair(groups));
    }
    assemble(version, manifest, sections).map_err(faulty)
}

/// Validates a texture on its own, so that the error names its file.
fn check_texture(file: &str, bytes: &[u8]) -> Result<(), BakeError> {
    const NAME: &str = "texture";
    let named = Manifest { textures: vec![TextureEntry { name: NAME.into() }], ..Manifest::default() };
    let write = |manifest, section| assemble(FORMAT_VERSION, manifest, [section]);
    let Err(error) = write(named, Content::Texture(bytes.into())) else { return Ok(()) };
    // Find where the texture begins in that package: write another package with the same bytes as an unknown section,
    // after a manifest of the same length. The list entry takes eight bytes for its length, then its letters.
    let same_length = Manifest { generator: " ".repeat(8 + NAME.len()), ..Manifest::default() };
    let same = write(same_length, Content::Bytes(Tag(*b"same"), bytes.into())).unwrap_or_default();
    let base = Package::open(&same, &Limits::default()).ok().and_then(|p| p.sections().get(1).map(|s| s.offset));
    let place = match (error.offset(), base) {
        (Some(offset), Some(base)) if offset >= base => format!("byte {}", offset - base),
        _ => "whole file".into(),
    };
    let reason = match error {
        FormatError::Content { reason, .. } => reason,
        other => other.to_string(),
    };
    Err(BakeError::Input { file: file.to_owned(), place, reason })
}

fn in_words(found: &Mismatch) -> String {
    format!("{} {}", found.key, found.reason)
}

fn digest_of(recipe: &str) -> String {
    hex(&Sha256::digest(recipe))
}

/// Returns the file name for a section that is stored as raw bytes.
fn raw_name(index: usize, tag: Tag) -> String {
    let safe: String = tag.0.iter().map(|b| if b.is_ascii_alphanumeric() { char::from(*b) } else { '_' }).collect();
    format!("section_{index}_{safe}.bin")
}

/// Converts a section tag to a string, or to four numbers if it is not text.
fn tag_to_json(tag: Tag) -> Value {
    match std::str::from_utf8(&tag.0) {
        Ok(text) if tag.0.iter().all(u8::is_ascii_graphic) => text.into(),
        _ => tag.0.to_vec().into(),
    }
}

fn tag_from_json(value: &Value) -> Option<Tag> {
    let bytes: Vec<u8> = match value {
        Value::String(text) => text.clone().into_bytes(),
        _ => serde_json::from_value(value.clone()).ok()?,
    };
    bytes.try_into().ok().map(Tag)
}

/// Converts the manifest without its recipe to JSON, with hashes in hexadecimal.
fn manifest_to_json(manifest: &Manifest) -> serde_json::Result<Value> {
    let mut value = serde_json::to_value(manifest)?;
    if let Some(object) = value.as_object_mut() {
        object.remove("recipe");
        for (key, field) in object.iter_mut() {
            // Quality figures and the evidence of a choice are f64; all other numbers are f32 and are shortened.
            if key != "quality" && key != "choice" {
                shorten_floats(field);
            }
        }
    }
    for (input, record) in value["inputs"].as_array_mut().into_iter().flatten().zip(&manifest.inputs) {
        input["sha256"] = hex(&record.sha256).into();
    }
    Ok(value)
}

fn manifest_from_json(file: &str, value: Value, recipe: String) -> Result<Manifest, BakeError> {
    let fail = |place: String, reason: String| BakeError::Input { file: file.to_owned(), place, reason };
    let mut full = value.clone();
    let object = full.as_object_mut().ok_or_else(|| fail("/manifest".into(), "missing, expected an object".into()))?;
    if object.contains_key("recipe") {
        return Err(fail("/manifest/recipe".into(), format!("unexpected: the recipe is in {RECIPE}")));
    }
    object.insert("recipe".into(), recipe.into());
    for (i, input) in full["inputs"].as_array_mut().into_iter().flatten().enumerate() {
        let Some(field) = input.as_object_mut().and_then(|o| o.get_mut("sha256")) else { continue };
        let digits = field.as_str().filter(|s| s.len() == 64).and_then(from_hex);
        let digits = digits.ok_or_else(|| {
            fail(format!("/manifest/inputs/{i}/sha256"), format!("found {field}, expected 64 hexadecimal digits"))
        })?;
        *field = digits.into();
    }
    let manifest: Manifest = deserialize(file, "/manifest", full)?;
    let back = manifest_to_json(&manifest).map_err(|e| BakeError::Internal(e.to_string()))?;
    known_keys(file, "/manifest", &value, &back)?;
    Ok(manifest)
}

/// Returns the names of all files that belong to the unpacked folder with this `manifest.json`; empty for another
/// document.
pub fn files_of(document: &Value) -> Vec<String> {
    let (true, Some(sections)) = (document[FORM.0] == FORM.1, document["sections"].as_array()) else {
        return Vec::new();
    };
    let of_section = |s: &Value| -> Vec<String> {
        let strands = s[STRANDS].as_array().into_iter().flatten();
        std::iter::once(&s["file"]).chain(strands).filter_map(Value::as_str).map(str::to_owned).collect()
    };
    let names = sections.iter().flat_map(of_section);
    [MANIFEST, RECIPE].map(str::to_owned).into_iter().chain(names).collect()
}
