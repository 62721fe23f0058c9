//! A plane of even fur: what is left to see is the opacity of the layers.

use crate::support::ktx2;
use crate::support::sphere::{SphereParams, manifest};
use pelage_runtime::formats::{AttributeVertex, GeometryVertex, MeshData, PackageWriter, TextureFormat};

/// A square of 0.2 m in the plane z = 0, facing +z, whose layers all have the same opacity (0..=255) everywhere.
pub fn plane(layers: u32, opacity: u8) -> Vec<u8> {
    let params = SphereParams { layers, texels: 4, ..SphereParams::default() };
    let corner = |x: f32, y: f32| GeometryVertex {
        position: [0.1 * x, 0.1 * y, 0.0],
        fur_height: params.height_m,
        normal: [0.0, 0.0, 1.0],
        lean: 0.0,
        tangent: [1.0, 0.0, 0.0, 1.0],
    };
    let mesh = MeshData {
        geometry: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        attributes: vec![AttributeVertex { color: [255; 4], ..AttributeVertex::default() }; 4],
        skin: Vec::new(),
        indices: vec![0, 1, 2, 0, 2, 3],
    };
    let texels = |texel: [u8; 4], skin: [u8; 4]| -> Vec<u8> {
        (0..layers * 16).flat_map(|i| if i < 16 { skin } else { texel }).collect()
    };
    let half = opacity / 2;
    let colors = texels([half, half, half, opacity], [128, 128, 128, 255]);
    let directions = texels([128, 128, 255, 255], [128, 128, 255, 255]);
    let ktx2 = |texels| ktx2::write(TextureFormat::Rgba8Unorm, 4, 4, layers, &[texels]);
    let writer = PackageWriter::new(manifest(&params, 6, 0)).mesh(&mesh);
    writer.texture(ktx2(colors)).texture(ktx2(directions)).finish().expect("the plane is a valid package")
}
