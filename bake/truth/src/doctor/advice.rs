//! Advice: detail that a package has in excess or lacks on a screen, and the recipe line that would change it.

use super::prognosis::{Advice, Prognosis, PrognosisView, Saved};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::metric::LEAST_HAIR_TEXELS;
use pelage_formats::{FormatError, Manifest, Package, TextureFormat};
use pelage_import::BakeError;

/// Collects all advice. Changes that improve the look come first, then savings, largest first.
///
/// Changes without savings are not advised. For example, thinner or thicker hair changes the look of the fur but not
/// the number of fragments.
///
/// Fails with the errors of [`super::diagnose`].
pub(super) fn advise(
    package: &Package<'_>,
    view: &PrognosisView,
    found: &Prognosis,
    fault: &dyn Fn(FormatError) -> BakeError,
) -> Result<Vec<Advice>, BakeError> {
    let manifest = package.manifest();
    let furry = manifest.fur.layers > 1 && found.on_screen.height_px > 0.0;
    let mut out = Vec::new();
    if furry {
        let textures = package.fur_textures().map_err(fault)?;
        let visibility = package.visibility_textures().map_err(fault)?;
        let seen = visibility.as_ref().map_or(0, |t| t.dry.gpu_bytes());
        let bytes = textures.map_or(0, |t| t.color.gpu_bytes() + t.direction.gpu_bytes() + seen);
        out.extend(close_up(manifest, found));
        out.extend(layers(manifest, view, found, bytes, visibility.is_some()));
        out.extend(tile(manifest, found, bytes));
        out.extend(fins(package, found, fault)?);
    }
    out.extend(formats(package, fault)?);
    out.extend(base_color(package, view, found, fault)?);
    out.extend(triangles(found));
    out.retain(|advice| advice.saved != Some(Saved::default()));
    // Advice that improves the look has no savings, and `None` sorts first.
    out.sort_by_key(|advice| advice.saved.map(std::cmp::Reverse));
    Ok(out)
}

/// Maximum relative increase of the error that counts as harmless. Two reference images with different noise differ by
/// as much.
const HARMLESS: f64 = 0.02;

/// Returns whether a picture with error `after` is as good as one with error `before`. Both are [`crate::likeness`]
/// against the same reference image.
pub fn is_harmless(before: f64, after: f64) -> bool {
    after <= (1.0 + HARMLESS) * before
}

/// Maximum gap between layers, in pixels seen from the side. Above it layers appear as steps, and as lines beside the
/// outline.
///
/// Example: a long-haired dog at 834x424. 16 layers, 2 pixels apart, look like soft fur. 8 layers (4 pixels) look like
/// lines. 4 layers (10 pixels) look like a ghost around a bare body.
const MOST_GAP_PX: f64 = 3.0;
/// Maximum number of layers that is advised. A frame with 64 layers takes four times as long as with the usual 16.
pub(super) const MOST_LAYERS: u32 = 64;

/// Returns advice for a close-up: add layers, or increase the distance.
fn close_up(manifest: &Manifest, found: &Prognosis) -> Option<Advice> {
    let now = manifest.fur.layers;
    let (gap, height, near_m) = (found.on_screen.layer_gap_px, found.on_screen.height_px, found.on_screen.near_m);
    if gap <= MOST_GAP_PX {
        return None;
    }
    // The gap in pixels is inversely proportional to the distance.
    let fine_from_m = |layers: u32| near_m * height / f64::from(layers.max(2) - 1) / MOST_GAP_PX;
    let enough = (height / MOST_GAP_PX).ceil().min(f64::from(u32::MAX - 1)) as u32 + 1;
    let apart = format!("{now} layers are {gap:.1} pixels apart where the fur is nearest, {near_m:.2} m from the eye");
    let mend = |change: String, found: String, costs: String| Advice {
        change,
        found,
        saves: "nothing: it improves the picture".into(),
        costs,
        saved: None,
        can_be_tried: false,
        measured: None,
    };
    if enough <= MOST_LAYERS {
        let more = f64::from(enough - 1) / f64::from(now.max(2) - 1);
        return Some(mend(
            format!("slice.layers={enough}"),
            format!("{apart}: steps between them are visible"),
            format!(
                "{more:.1} times as many fragments of shells; without this change, the {now} layers look smooth from \
                 {:.2} m on",
                fine_from_m(now)
            ),
        ));
    }
    let most = MOST_LAYERS.max(now);
    Some(mend(
        format!("the camera: {:.2} m or more from the fur, with slice.layers={most}", fine_from_m(most)),
        format!(
            "too near for shells: {apart}, and {most} layers would still be {:.1} pixels \
             apart",
            height / f64::from(most - 1)
        ),
        format!("a smaller animal in the picture; the present {now} layers need {:.2} m", fine_from_m(now)),
    ))
}

/// Gap between layers, in pixels seen from the side, below which layers cannot be distinguished.
const LEAST_GAP_PX: f64 = 0.5;

fn layers(
    manifest: &Manifest,
    view: &PrognosisView,
    found: &Prognosis,
    textures: u64,
    knows_visibility: bool,
) -> Option<Advice> {
    let now = manifest.fur.layers;
    let (gap, height) = (found.on_screen.layer_gap_px, found.on_screen.height_px);
    // A single layer per pixel suffices; fewer than four do not look like fur.
    let enough = (height.ceil() as u32 + 1).max(4);
    if gap >= LEAST_GAP_PX || enough >= now {
        return None;
    }
    let less = |most: u32| 1.0 - (f64::from(enough - 1) / f64::from(most)).min(1.0);
    // If the superfluous layers are not drawn anyway, the change saves only textures.
    let (share, of_drawn) = (less(now - 1), less(found.on_screen.layers_drawn.max(1)));
    let of = |count: u64| (count as f64 * of_drawn) as u64;
    let shells = found.passes.iter().find(|pass| pass.name == "shells")?;
    // Shadow maps, if the runtime makes them, have two bytes per texel and layer.
    let maps = if knows_visibility { 0 } else { 2 * u64::from(view.shadow_map).pow(2) * u64::from(now - enough) };
    Some(Advice {
        change: format!("slice.layers={enough}"),
        found: format!("{now} layers are {gap:.2} pixels apart where the fur is nearest"),
        saves: format!(
            "{:.0} % of the shells' fragments and vertices, {:.0} % of their textures{}",
            100.0 * of_drawn,
            100.0 * share,
            if knows_visibility { "" } else { " and of the layer-wise shadow maps" }
        ),
        costs: "steps between layers when the camera comes nearer".into(),
        saved: Some(Saved {
            fragments: of(shells.fragments.unwrap_or_default()),
            vertices: of(shells.vertices),
            bytes: (textures as f64 * share) as u64 + maps,
        }),
        can_be_tried: true,
        measured: None,
    })
}

/// Width of a tile's texel on the screen, pixels, below which the tile is finer than needed: the shader then reads
/// mips.
const LEAST_TEXEL_PX: f64 = 0.5;

fn tile(manifest: &Manifest, found: &Prognosis, bytes: u64) -> Option<Advice> {
    let recipe = Recipe::parse_recorded("recipe of the package", &manifest.recipe).ok()?;
    let (now, texel) = (manifest.fur.tile_texels, found.on_screen.texel_px);
    let small = |texels: u32| texel * f64::from(now) / f64::from(texels) <= LEAST_TEXEL_PX;
    let holds_hair = |texels: u32| 2.0 * f64::from(recipe.hair.root_radius) * f64::from(texels) >= LEAST_HAIR_TEXELS;
    let mut enough = now;
    while enough > 16 && small(enough) && holds_hair(enough / 2) {
        enough /= 2;
    }
    if enough == now {
        return None;
    }
    let saved = bytes as f64 * (1.0 - (f64::from(enough) / f64::from(now)).powi(2));
    Some(Advice {
        change: format!("slice.tile_texels={enough}"),
        found: format!("a texel of the tile is {texel:.2} pixels wide where the fur is nearest"),
        saves: format!("{:.0} KiB of textures", saved / 1024.0),
        costs: "blurred hair when the camera comes nearer".into(),
        saved: Some(Saved { bytes: saved as u64, ..Saved::default() }),
        can_be_tried: true,
        measured: None,
    })
}

fn fins(
    package: &Package<'_>,
    found: &Prognosis,
    fault: &dyn Fn(FormatError) -> BakeError,
) -> Result<Option<Advice>, BakeError> {
    let (Some(info), Some(pass)) = (package.manifest().fur.fins, found.passes.iter().find(|pass| pass.name == "fins"))
    else {
        return Ok(None);
    };
    if found.on_screen.height_px >= 1.0 {
        return Ok(None);
    }
    let mut bytes = 0;
    for index in [info.color_texture, info.direction_texture] {
        bytes += package.texture(index).map_err(fault)?.gpu_bytes();
    }
    Ok(Some(Advice {
        change: "fins.enabled=false".into(),
        found: format!(
            "the fur is at most {:.2} pixels high: fins never cover a pixel of their own",
            found.on_screen.height_px
        ),
        saves: format!("{} vertices a frame, and the fins' textures", pass.vertices),
        costs: "a coarser outline when the camera comes nearer".into(),
        saved: Some(Saved { fragments: pass.fragments.unwrap_or_default(), vertices: pass.vertices, bytes }),
        can_be_tried: true,
        measured: None,
    }))
}

fn formats(package: &Package<'_>, fault: &dyn Fn(FormatError) -> BakeError) -> Result<Option<Advice>, BakeError> {
    let fur = &package.manifest().fur;
    let (mut keys, mut bytes, mut saved) = (Vec::new(), 0, 0.0);
    let ink = package.ink().map_err(fault)?.map(|ink| ink.info);
    // The paper texture is never block-compressed. Painted textures have the format of the shells.
    let paper = ink.as_ref().map(|ink| ink.paper_texture);
    let painted = ink.as_ref().map(|ink| [Some(ink.stroke_texture), Some(ink.wash_texture), ink.fur_texture]);
    let painted: Vec<_> = painted.into_iter().flatten().flatten().collect();
    for index in 0..package.manifest().textures.len() as u32 {
        if Some(index) == paper {
            continue;
        }
        let view = package.texture(index).map_err(fault)?;
        let hair = [Some(fur.color_texture), fur.fins.map(|f| f.color_texture), fur.wet.map(|w| w.color_texture)];
        let base = package.manifest().materials.iter().any(|m| m.base_color_texture == Some(index));
        let (key, share) = match view.format {
            TextureFormat::Rgba8Srgb | TextureFormat::Rgba8Unorm
                if hair.contains(&Some(index)) || painted.contains(&index) =>
            {
                ("pack.shell_format=bc7", 0.75)
            }
            TextureFormat::Rgba8Srgb | TextureFormat::Rgba8Unorm if base => ("pack.base_color_format=bc7", 0.75),
            TextureFormat::Rgba8Unorm => ("pack.direction_format=bc5", 0.75),
            TextureFormat::Rg8Unorm => ("pack.direction_format=bc5", 0.5),
            _ => continue,
        };
        if !keys.contains(&key) {
            keys.push(key);
        }
        bytes += view.gpu_bytes();
        saved += view.gpu_bytes() as f64 * share;
    }
    // For smaller textures the savings of compression do not justify its errors.
    if bytes < 64 << 10 {
        return Ok(None);
    }
    Ok(Some(Advice {
        change: keys.join(" --set "),
        found: format!("{} KiB of textures are not compressed", bytes >> 10),
        saves: format!("{:.0} KiB on the device, and as much to read", saved / 1024.0),
        costs: "a little noise in colour and direction".into(),
        saved: Some(Saved { bytes: saved as u64, ..Saved::default() }),
        // Slicing a package again does not change the format of base colours, so this change cannot be tried.
        can_be_tried: !keys.contains(&"pack.base_color_format=bc7"),
        measured: None,
    }))
}

/// Minimum number of base-colour texels per covered pixel: two in each direction, and twice that because half of the
/// surface faces away.
const TEXELS_A_PIXEL: u64 = 8;

fn base_color(
    package: &Package<'_>,
    view: &PrognosisView,
    found: &Prognosis,
    fault: &dyn Fn(FormatError) -> BakeError,
) -> Result<Option<Advice>, BakeError> {
    let materials = package.manifest().materials.iter();
    let mut indices: Vec<u32> = materials.filter_map(|m| m.base_color_texture).collect();
    indices.sort_unstable();
    indices.dedup();
    let (mut texels, mut bytes, mut side) = (0, 0, 0);
    for index in indices {
        let texture = package.texture(index).map_err(fault)?;
        texels += u64::from(texture.width) * u64::from(texture.height);
        bytes += texture.gpu_bytes();
        side = side.max(texture.width.max(texture.height));
    }
    let covered = found.covered_pixels[0].max(found.covered_pixels[1]);
    let mut enough = side;
    let left = |side_now: u32| texels * u64::from(side_now).pow(2) / u64::from(side.max(1)).pow(2);
    while enough > 16 && left(enough / 2) >= TEXELS_A_PIXEL * covered {
        enough /= 2;
    }
    if enough == side {
        return Ok(None);
    }
    let saved = bytes as f64 * (1.0 - (f64::from(enough) / f64::from(side)).powi(2));
    let (width, height) = view.size;
    Ok(Some(Advice {
        change: format!("pack.base_color_max={enough}"),
        found: format!("base-colour textures have {texels} texels for {covered} pixels of a {width}x{height} picture"),
        saves: format!("{:.0} KiB of textures", saved / 1024.0),
        costs: "a blurred pattern when the camera comes nearer".into(),
        saved: Some(Saved { bytes: saved as u64, ..Saved::default() }),
        can_be_tried: false,
        measured: None,
    }))
}

/// Fraction of small triangles above which a mesh is finer than the picture needs.
const MOST_SMALL: f64 = 0.8;
/// Number of triangles below which the mesh density does not matter.
const FEW_TRIANGLES: u64 = 500;

fn triangles(found: &Prognosis) -> Option<Advice> {
    let on_screen = &found.on_screen;
    if on_screen.small_triangles < MOST_SMALL || on_screen.triangles < FEW_TRIANGLES {
        return None;
    }
    let vertices: u64 = found.passes.iter().map(|pass| pass.vertices).sum();
    Some(Advice {
        change: "the model: fewer triangles".into(),
        found: format!(
            "{:.0} % of the {} visible triangles are smaller than 4 by 4 pixels; every layer draws them again",
            100.0 * on_screen.small_triangles,
            on_screen.triangles
        ),
        saves: format!("half of the {vertices} vertices per frame, if half of the triangles are removed"),
        costs: "a coarser outline when the camera comes nearer".into(),
        saved: Some(Saved { vertices: vertices / 2, ..Saved::default() }),
        can_be_tried: false,
        measured: None,
    })
}
