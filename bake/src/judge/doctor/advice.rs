//! What a package has more of than a screen shows, and the recipe line that would change it.

use super::prognosis::{Advice, Prognosis, View};
use crate::BakeError;
use crate::recipe::Recipe;
use crate::stages::textures::decode_texture;
use pelage_formats::{FormatError, Manifest, Package, TextureFormat};

/// Looks for everything there is advice on, the dearest first.
///
/// # Errors
///
/// As [`super::diagnose`].
pub(super) fn advise(
    package: &Package<'_>,
    view: &View,
    found: &Prognosis,
    fault: &dyn Fn(FormatError) -> BakeError,
) -> Result<Vec<Advice>, BakeError> {
    let manifest = package.manifest();
    let furry = found.passes.iter().any(|pass| pass.name == "shells" && pass.runs);
    let mut out = Vec::new();
    if furry {
        let hidden = hidden_layers(package, fault)?;
        out.extend(layers(manifest, found));
        out.extend(density(manifest, hidden));
        out.extend(tile(manifest, package, found, fault)?);
        out.extend(thin_hair(manifest));
        out.extend(fins(found));
    }
    out.extend(formats(package, fault)?);
    out.extend(base_color(package, view, found, fault)?);
    out.extend(triangles(found));
    Ok(out)
}

/// Layers that are nearer to each other than this, pixels seen from the side, cannot be told apart.
const LEAST_GAP_PX: f64 = 0.5;

fn layers(manifest: &Manifest, found: &Prognosis) -> Option<Advice> {
    let now = manifest.fur.layers;
    let (gap, height) = (found.on_screen.layer_gap_px, found.on_screen.height_px);
    // As many as have a pixel each would do, and fewer than four are no fur.
    let enough = (height.ceil() as u32 + 1).max(4);
    if gap >= LEAST_GAP_PX || enough >= now {
        return None;
    }
    let share = 1.0 - f64::from(enough - 1) / f64::from(now - 1);
    Some(Advice {
        change: format!("slice.layers={enough}"),
        found: format!("{now} layers lie {gap:.2} pixels apart where the fur is nearest"),
        saves: format!(
            "{:.0} % of the shells' fragments and vertices, of their textures and of the layer-wise shadow maps",
            100.0 * share
        ),
        costs: "steps between layers when the camera comes nearer".into(),
    })
}

/// Texels of the tile that are smaller than this on the screen, pixels, are more than it shows: mips are read instead.
const LEAST_TEXEL_PX: f64 = 0.5;

fn tile(
    manifest: &Manifest,
    package: &Package<'_>,
    found: &Prognosis,
    fault: &dyn Fn(FormatError) -> BakeError,
) -> Result<Option<Advice>, BakeError> {
    let (now, texel) = (manifest.fur.tile_texels, found.on_screen.texel_px);
    let mut enough = now;
    while enough > 16 && texel * f64::from(now) / f64::from(enough) <= LEAST_TEXEL_PX {
        enough /= 2;
    }
    if enough == now {
        return Ok(None);
    }
    let Some(textures) = package.fur_textures().map_err(fault)? else { return Ok(None) };
    let bytes = textures.color.gpu_bytes() + textures.direction.gpu_bytes();
    let saved = bytes as f64 * (1.0 - (f64::from(enough) / f64::from(now)).powi(2));
    Ok(Some(Advice {
        change: format!("slice.tile_texels={enough}"),
        found: format!("a texel of the tile is {texel:.2} pixels wide where the fur is nearest"),
        saves: format!("{:.0} KiB of textures", saved / 1024.0),
        costs: "blurred hair when the camera comes nearer".into(),
    }))
}

/// Hair that is thinner than a texel fades instead of showing.
fn thin_hair(manifest: &Manifest) -> Option<Advice> {
    let recipe = Recipe::parse("recipe of the package", &manifest.recipe).ok()?;
    let texels = manifest.fur.tile_texels;
    let width = 2.0 * recipe.hair.root_radius * texels as f32;
    if width >= 1.0 || width <= 0.0 {
        return None;
    }
    let radius = (500.0 / texels as f32).ceil() / 1000.0;
    Some(Advice {
        change: format!("hair.root_radius={radius}"),
        found: format!("at its root a hair is {width:.2} texels wide, and fades instead of showing"),
        saves: "nothing: the same texels show hair; as well slice.tile_texels could double, for four times the bytes"
            .into(),
        costs: "thicker hair, a denser coat".into(),
    })
}

/// Share of what lies below that a layer must let through to be worth drawing.
const SEEN: f64 = 0.01;

/// How many layers above the skin are hidden by those above them, on the mean.
fn hidden_layers(package: &Package<'_>, fault: &dyn Fn(FormatError) -> BakeError) -> Result<u32, BakeError> {
    let Some(textures) = package.fur_textures().map_err(fault)? else { return Ok(0) };
    let view = &textures.color;
    let mut through = 1.0;
    let mut hidden = 0;
    for layer in (1..view.layers).rev() {
        hidden += u32::from(through < SEEN);
        // The last level keeps the mean of what comes through all layers.
        let texels = decode_texture(view, view.levels - 1, layer)?;
        through *= 1.0 - f64::from(texels[3]) / 255.0;
    }
    Ok(hidden)
}

fn density(manifest: &Manifest, hidden: u32) -> Option<Advice> {
    let layers = manifest.fur.layers;
    // A few layers at the skin are seen where hair is parted.
    if hidden * 4 < layers {
        return None;
    }
    let enough = (f64::from(manifest.fur.strands) * f64::from(layers - hidden) / f64::from(layers)).max(1.0) as u32;
    Some(Advice {
        change: format!("hair.density={enough}"),
        found: format!("the upper layers hide the lower {hidden} of {layers}: less than 1 % of what they draw is seen"),
        saves: "no fragment, but what is drawn is then seen; or fewer layers (slice.layers) at the same look".into(),
        costs: "the coat opens a little".into(),
    })
}

fn fins(found: &Prognosis) -> Option<Advice> {
    let pass = found.passes.iter().find(|pass| pass.name == "fins" && pass.runs)?;
    if found.on_screen.height_px >= 1.0 {
        return None;
    }
    Some(Advice {
        change: "fins.enabled=false".into(),
        found: format!(
            "the fur is {:.2} pixels high at its nearest: fins never reach a pixel of their own",
            found.on_screen.height_px
        ),
        saves: format!("{} vertices a frame, and the fins' textures", pass.vertices),
        costs: "a coarser outline when the camera comes nearer".into(),
    })
}

fn formats(package: &Package<'_>, fault: &dyn Fn(FormatError) -> BakeError) -> Result<Option<Advice>, BakeError> {
    let fur = &package.manifest().fur;
    let (mut keys, mut bytes, mut saved) = (Vec::new(), 0, 0.0);
    let ink = package.ink().map_err(fault)?.map(|ink| ink.info);
    // Never in blocks; and those that follow the shells.
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
    // Below that, blocks are not worth their errors.
    if bytes < 64 << 10 {
        return Ok(None);
    }
    Ok(Some(Advice {
        change: keys.join(" --set "),
        found: format!("{} KiB of textures are not compressed", bytes >> 10),
        saves: format!("{:.0} KiB on the device, and as much to read", saved / 1024.0),
        costs: "a little noise in colour and direction; on a software rasteriser the shells take several times as long"
            .into(),
    }))
}

/// A base colour of more than this many texels for each pixel of the picture that it covers is more than is seen.
const TEXELS_A_PIXEL: u64 = 4;

fn base_color(
    package: &Package<'_>,
    view: &View,
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
    while enough > 16 && texels * u64::from(enough).pow(2) / u64::from(side.max(1)).pow(2) > TEXELS_A_PIXEL * covered {
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
    }))
}

/// Share of small triangles from which a mesh is finer than the picture.
const MOST_SMALL: f64 = 0.8;
/// So few triangles that it does not matter.
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
            "{:.0} % of the {} triangles in sight are smaller than 4 by 4 pixels; every layer draws them again",
            100.0 * on_screen.small_triangles,
            on_screen.triangles
        ),
        saves: format!("with half of them, half of {vertices} vertices a frame"),
        costs: "a coarser outline when the camera comes nearer".into(),
    })
}
