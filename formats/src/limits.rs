/// Upper bounds on what a reader accepts, so that a damaged or hostile file cannot make it allocate without measure.
///
/// The defaults are far above what [`pelage bake`] writes and far below what harms a machine.
///
/// [`pelage bake`]: https://docs.rs/pelage-bake
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Sections in the table (default 4 096).
    pub sections: u32,
    /// Bytes of the manifest section (default 16 MiB, at most 256 MiB); also bounds every string and list inside it.
    pub manifest_bytes: u64,
    /// Bytes of the animation section (default 256 MiB, which is also the most).
    pub animation_bytes: u64,
    /// Vertices of the mesh (default 16 777 216).
    pub vertices: u32,
    /// Indices of the mesh (default 100 663 296).
    pub indices: u32,
    /// Fins (default 50 331 648).
    pub fins: u32,
    /// Strands of the tile, and hairs on guides (default 16 777 216).
    pub strands: u32,
    /// Width and height of a texture, texels (default 16 384).
    pub texture_size: u32,
    /// Array layers of a texture (default 2 048).
    pub texture_layers: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            sections: 4096,
            manifest_bytes: 16 << 20,
            animation_bytes: 256 << 20,
            vertices: 1 << 24,
            indices: 96 << 20,
            fins: 48 << 20,
            strands: 1 << 24,
            texture_size: 16_384,
            texture_layers: 2048,
        }
    }
}

impl Limits {
    /// No bounds: for what was just written, whose size is its writer's business.
    pub(crate) const NONE: Self = Self {
        sections: u32::MAX,
        manifest_bytes: u64::MAX,
        animation_bytes: u64::MAX,
        vertices: u32::MAX,
        indices: u32::MAX,
        fins: u32::MAX,
        strands: u32::MAX,
        texture_size: u32::MAX,
        texture_layers: u32::MAX,
    };
}
