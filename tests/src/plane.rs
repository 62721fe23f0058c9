//! Plane with uniform fur, lit so that only the opacity of the layers is visible.

use crate::support::ktx2;
use crate::support::sphere::{SphereParams, manifest};
use glam::Vec3;
use pelage_runtime::formats::{
    AttributeVertex, GeometryVertex, MeshData, PackageWriter, Shading, ShellTextures, StrandsData, TextureEntry,
    TextureFormat,
};

/// Groom of a plane.
#[derive(Clone, Debug, Default)]
pub struct PlaneGroom {
    /// Lean of the hair at all vertices.
    pub lean: f32,
    /// Slope by which the normals at the corners of the plane are tilted outward.
    pub outwards: f32,
    /// Bareness and wetness of all vertices.
    pub vertex: [u8; 2],
    /// Groom texture over the whole plane: number of texels per row, and the amount of hair and wetness of each texel.
    pub texture: Option<(u32, Vec<[u8; 2]>)>,
    /// Opacity of the layers of wet hair, 0..=255.
    pub wet_opacity: Option<u8>,
    /// Strands of the tile, and the number of tiles along a side of the plane.
    pub strands: Option<(StrandsData, f32)>,
}

/// Returns a square of 0.2 m in the plane z = 0, facing +z. All texels of its layers have the same opacity, 0..=255.
pub fn plane(layers: u32, opacity: u8) -> Vec<u8> {
    groomed_plane(layers, opacity, Shading::default(), &PlaneGroom::default())
}

/// Returns the plane with a groom.
pub fn groomed_plane(layers: u32, opacity: u8, shading: Shading, groom: &PlaneGroom) -> Vec<u8> {
    let params = SphereParams { layers, texels: 4, ..SphereParams::default() };
    let corner = |x: f32, y: f32| GeometryVertex {
        position: [0.1 * x, 0.1 * y, 0.0],
        fur_height: params.height_m,
        normal: Vec3::new(groom.outwards * x, groom.outwards * y, 1.0).normalize().to_array(),
        lean: groom.lean,
        tangent: Vec3::new(1.0, 0.0, -groom.outwards * x).normalize().extend(1.0).to_array(),
    };
    let [bareness, wetness] = groom.vertex;
    let tiles = groom.strands.as_ref().map_or(0.0, |(_, tiles)| *tiles);
    let attributes = |base_uv: [f32; 2]| AttributeVertex {
        tile_uv: [tiles * base_uv[0], tiles * (1.0 - base_uv[1])],
        base_uv,
        color: [255; 4],
        groom: [bareness, wetness, 0, 0],
    };
    let mesh = MeshData {
        geometry: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        attributes: [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(attributes).to_vec(),
        skin: Vec::new(),
        indices: vec![0, 1, 2, 0, 2, 3],
    };
    let texels = |texel: [u8; 4], skin: [u8; 4]| -> Vec<u8> {
        (0..layers * 16).flat_map(|i| if i < 16 { skin } else { texel }).collect()
    };
    let colors = |opacity: u8| {
        let half = opacity / 2;
        texels([half, half, half, opacity], [128, 128, 128, 255])
    };
    let directions = texels([128, 128, 255, 255], [128, 128, 255, 255]);
    let ktx2 = |texels| ktx2::write(TextureFormat::Rgba8Unorm, 4, 4, layers, &[texels]);
    let mut files = vec![ktx2(colors(opacity)), ktx2(directions.clone())];
    let mut manifest = manifest(&params, 6, 0);
    manifest.shading = shading;
    if let Some(opacity) = groom.wet_opacity {
        let (color_texture, direction_texture) = (files.len() as u32, files.len() as u32 + 1);
        manifest.fur.wet = Some(ShellTextures { color_texture, direction_texture });
        files.extend([ktx2(colors(opacity)), ktx2(directions)]);
    }
    if let Some((width, rows)) = &groom.texture {
        manifest.materials[0].groom_texture = Some(files.len() as u32);
        let texels = rows.concat();
        files.push(ktx2::write(TextureFormat::Rg8Unorm, *width, rows.len() as u32 / width, 1, &[texels]));
    }
    manifest.textures = (0..files.len()).map(|i| TextureEntry { name: format!("texture_{i}") }).collect();
    if tiles > 0.0 {
        manifest.fur.tile_size_m = 0.2 / tiles;
    }
    let mut writer = PackageWriter::new(manifest).mesh(&mesh);
    if let Some((strands, _)) = &groom.strands {
        writer = writer.strands(strands);
    }
    files.into_iter().fold(writer, PackageWriter::texture).finish().expect("the plane is a valid package")
}
