/// Upper bounds on the input of a reader, so that a damaged or hostile file cannot cause unbounded allocation.
///
/// The defaults are far above what [`pelage bake`] writes and far below what harms a machine.
///
/// [`pelage bake`]: https://docs.rs/pelage-bake
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Maximum number of sections in the table (default 4 096).
    pub sections: u32,
    /// Maximum size of the manifest section, bytes (default 16 MiB, at most 256 MiB); also bounds every string and list
    /// inside it.
    pub manifest_bytes: u64,
    /// Maximum size of the animation section, bytes (default 256 MiB, which is also the largest allowed).
    pub animation_bytes: u64,
    /// Maximum number of mesh vertices (default 16 777 216).
    pub vertices: u32,
    /// Maximum number of mesh indices (default 100 663 296).
    pub indices: u32,
    /// Maximum number of fins (default 50 331 648).
    pub fins: u32,
    /// Maximum number of strands of the tile, and of guided hairs (default 16 777 216).
    pub strands: u32,
    /// Maximum width and height of a texture, texels (default 16 384).
    pub texture_size: u32,
    /// Maximum number of array layers of a texture (default 2 048).
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
    /// No limits: used to read back data that was just written, whose size is the writer's responsibility.
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
