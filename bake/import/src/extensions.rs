//! Required extensions: a list of those that can be read, and advice on how to convert the others.

use super::json::JsonNode;
use super::source::Source;
use crate::BakeError;
use glam::Quat;

/// Extensions that are read, or that do not affect shape, base colour or motion. A texture that cannot be read for lack
/// of its extension is a warning of its own.
const READABLE: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "MSFT_texture_dds",
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_lights_punctual",
    "KHR_materials_variants",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
    "EXT_lights_image_based",
    "EXT_lights_ies",
    "MSFT_packing_occlusionRoughnessMetallic",
    "MSFT_packing_normalRoughnessMetallic",
];

/// Extension of VRM 0.x, whose models look along −z. VRM 1.0 has `VRMC_vrm` instead, and looks along +z as glTF 2.0
/// defines.
const VRM_0: &str = "VRM";

/// Returns advice on how to remove an extension that cannot be read.
pub(super) fn conversion(name: &str) -> &'static str {
    match name {
        "KHR_meshopt_compression" => "decode it with `gltf-transform cp in.glb out.glb`, or run gltfpack without -c",
        "KHR_texture_basisu" => "supply the textures as PNG or JPEG: `gltf-transform ktxdecompress in.glb out.glb`",
        "EXT_texture_avif" | "MSFT_texture_dds" => "supply the textures as PNG or JPEG",
        _ => "export the model without it",
    }
}

impl Source<'_, '_> {
    /// Returns the rotation that makes the model look along +z, as glTF 2.0 defines (section 3.4): half a turn about y
    /// for VRM 0.x, which is reported, otherwise the identity.
    pub fn forward_turn(&mut self) -> Quat {
        let has = |name: &str| {
            let in_list = |at: JsonNode<'_>| at.entries().is_ok_and(|mut all| all.any(|at| at.value == name));
            self.root.get("extensions").is_some_and(|all| all.get(name).is_some())
                || self.root.get("extensionsUsed").is_some_and(in_list)
        };
        if !has(VRM_0) || has("VRMC_vrm") {
            return Quat::IDENTITY;
        }
        self.warn("VRM 0.x models look along -z; turned by 180° about y to look along +z, as glTF 2.0 defines");
        Quat::from_xyzw(0.0, 1.0, 0.0, 0.0)
    }

    /// Fails if the model requires extensions that cannot be read. The error names each of them.
    pub fn check_extensions(&mut self) -> Result<(), BakeError> {
        let Some(list) = self.root.get("extensionsRequired") else { return Ok(()) };
        let mut unreadable = Vec::new();
        let Some(list) = self.or_warn(list.entries(), "ignored") else { return Ok(()) };
        for at in list {
            let Some(name) = self.or_warn(at.string(), "ignored") else { continue };
            // Only the base colour of materials is read; all other material extensions leave it unchanged.
            let harmless = ["KHR_materials_", "VRMC_"].iter().any(|prefix| name.starts_with(prefix)) || name == VRM_0;
            if !READABLE.contains(&name) && !harmless {
                unreadable.push((at.clone(), format!("{}: {}", super::json::shorten(name), conversion(name))));
            }
        }
        let Some((first, _)) = unreadable.first() else { return Ok(()) };
        let names: Vec<&str> = unreadable.iter().map(|(_, text)| text.as_str()).collect();
        Err(first.fault(format!("the model requires extensions that pelage cannot read: {}", names.join("; "))))
    }
}
