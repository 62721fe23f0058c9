//! Parameters of the stages. Each is declared once, with meaning, range and default.

use super::coats::Coat;
use super::comb_marks::CombMarkParams;
use super::hair_group::{HairColliderParams, HairGroupParams, TuftParams};
use super::joint_groom::JointGroom;
use super::maps::{ColorMap, FilePath, ScalarMap, VectorMap};
use super::material_groom::{DENSITY, MaterialGroom, SHARE};
use super::style::Style;
use pelage_import::ImportOptions;
use pelage_params::{PowerOfTwo, SrgbColor, params, words};
use pelage_stage::Viewpoint;

params! {
    /// `[model]`: import of the model.
    ModelParams in model {
        /// Length of one unit of the model, metres. glTF uses metres; set this if the exporter used another unit, and
        /// for OBJ, which does not define one.
        unit_m: f32 = 1.0, in ImportOptions::UNIT_M;
        /// Names of materials, nodes, meshes and joints where no hair grows, such as eyes and hooves. A joint's name
        /// includes the joints below it. `*` matches any characters, `?` one; with `[]`, hair grows everywhere. If left
        /// out, eyes, teeth, tongues, noses, claws, hooves, horns, beaks and clothes are detected by the names of
        /// materials, nodes, meshes and joints in eight languages. Small parts are also detected by gloss, by the shape
        /// or colour of eyes, or because they are inside the head. If in doubt, hair grows; the bake reports what it
        /// detected. Bare parts of a furred material get their own names, such as `Black/nose` or `Main/Eye_L`: a nose,
        /// eyes, eye rims, claws, parts in the head, and parts named by a node, mesh or joint. `Black` matches all of
        /// them.
        bare: Option<Vec<String>> = None;
    }
}

words! {
    /// Source of the tile coordinates.
    SurfaceSource {
        /// Overlapping patches, grown over any mesh.
        #[default]
        Patches = "patches",
        /// The model's own texture coordinates, scaled.
        Model = "model",
    }
}

words! {
    /// Source of the comb direction.
    CombSource {
        /// `marks` if the recipe or the model has any that set directions, otherwise `direction`.
        #[default]
        Auto = "auto",
        /// Same direction everywhere.
        Direction = "direction",
        /// Down.
        Gravity = "gravity",
        /// Downwards on the model's own texture.
        Tangents = "tangents",
        /// Directions at single points.
        Marks = "marks" was "guides",
        /// No comb direction: patches are laid out with the least distortion.
        None = "none",
    }
}

params! {
    /// `[surface]`: layout of the periodic hair tile on the model, and comb direction of the hair.
    SurfaceParams in surface {
        /// Source of the tile coordinates. `patches` grows patches over any mesh and needs no texture coordinates;
        /// `model` uses the model's own.
        source: SurfaceSource = SurfaceSource::Patches;
        /// Round furred surface that is coarse: split triangles with an edge of more than 32° between its normals, and
        /// move the new vertices onto a curve along the normals. Otherwise, fur shows every triangle. Flat surface and
        /// hard edges stay as they are.
        rounded: bool = true;
        /// Width of the tile on the mesh surface, metres. A small tile repeats visibly, a large one has a low texel
        /// density. If left out, the width is chosen from the model's size, and limited by `hair.density_mm2` and
        /// `hair.root_radius_m`.
        tile_size_m: Option<f32> = None, in 1e-6..=1e3;
        /// Width of the tile if `surface.tile_size_m` is left out, as a share of the radius of the bounding sphere of
        /// the model at rest.
        tile_size_per_radius: f32 = 0.15, in 1e-3..=10.0, needs "surface.tile_size_m=none";
        /// Source of the comb direction: `direction` (`surface.comb_direction`), `gravity`, `tangents` (downwards on
        /// the model's own texture), `marks` (`surface.comb_marks`, and lines drawn in the model), or `none`. `none`
        /// lays out patches with the least distortion and suits upright hair. `auto` selects `marks` if a mark of the
        /// recipe has a direction, or if the model has such lines and `surface.comb_direction` has its default.
        /// Otherwise, `auto` selects `direction`; if `surface.comb_direction` has its default, the head of an animal
        /// is combed from the tip of its nose to its neck. Joints name the head, or without joints, ears and nose show
        /// where it is and where the body's comb direction turns.
        comb: CombSource = CombSource::Auto;
        /// Comb direction in world space at rest, any length but 0. The default runs from nose to tail and slightly
        /// down on an animal that faces +z.
        comb_direction: [f32; 3] = [0.0, -0.35, -1.0], in -1e6..=1e6;
        /// Hair properties at single points, spread over the surface: tables with `name`, `at` (metres), and any of
        /// `direction`, `length`, `density`, `lean`, `color`, `reach_m` and `mirrored`. They override `[groom]`.
        /// Directions require that `surface.comb` is `"marks"` or selects it; the other keys always apply.
        comb_marks: Vec<CombMarkParams> = Vec::new(), was "guides";
        /// Distance over which the comb direction is averaged where it is weak or discontinuous, tiles. A small value
        /// keeps all detail, a large one gives broad strokes.
        comb_smoothing: f32 = 1.0, in 0.01..=100.0;
        /// Weight of the comb direction in patches: 1 follows it, 0 rotates every triangle for the least distortion.
        comb_weight: f32 = 0.5, in 0.0..=1.0, needs "surface.source=patches";
        /// Maximum distance between a patch's seed and its border, tiles. Large patches have fewer seams and more
        /// distortion.
        patch_size: f32 = 4.0, in 0.05..=1000.0, needs "surface.source=patches";
        /// Largest angle between a patch's hair and the comb direction, degrees.
        patch_turn_deg: f32 = 25.0, in 1.0..=60.0, needs "surface.source=patches";
        /// Largest stretch of a triangle in any direction; the smallest is its reciprocal.
        patch_stretch: f32 = 1.5, in 1.01..=4.0, needs "surface.source=patches";
    }
}

params! {
    /// `[hair]`: strands of the tile. Lengths on the tile are fractions of its width, so that the look is independent
    /// of the model's units.
    HairParams in hair {
        /// Kind of hair, which sets the defaults of other keys, listed in [coats](coats.md). Keys set in the recipe
        /// take precedence, whether they precede or follow this one. When `--set` changes the coat, keys that still
        /// have the previous coat's value change too.
        coat: Coat = Coat::Animal;
        /// Shape of the strands: `straight`, `curly`, `messy`, `wet` or `lying`. `wet` gathers strands into locks and
        /// darkens their colour. It also makes the highlight stronger and narrower than `[shading]` defines. `lying` is
        /// combed flat.
        style: Style = Style::Straight;
        /// Random seed. Another seed gives different hair of the same kind.
        seed: u64 = 1, in 0..=i64::MAX as u64;
        /// Number of strands in the tile.
        density: u32 = 600, in 1..=1_000_000, needs "hair.density_mm2=none";
        /// Hairs per square millimetre where `groom.density` is 1, instead of `hair.density`. A dog's back has about 3
        /// guard hairs and 40 hairs of underfur. If `surface.tile_size_m` is left out, the tile is made narrow enough
        /// to hold at most 20 000 strands.
        density_mm2: Option<f32> = None, in 1e-6..=1e4;
        /// Length of the longest strand along its curve, metres. If left out, it is chosen from the model's size.
        length_m: Option<f32> = None, in 1e-6..=1e3;
        /// Length of the longest strand if `hair.length_m` is left out, as a share of the radius of the bounding sphere
        /// of the model at rest. Examples: 0.02 for a short-haired animal, 0.15 for a long-haired one.
        length_per_radius: f32 = 0.05, in 1e-4..=10.0, needs "hair.length_m=none";
        /// Variation in length: with 0, all strands are equally long; with 1, they may be arbitrarily short. Long
        /// strands are rarer, so the fur thins towards its outside.
        length_variation: f32 = 0.5, in 0.0..=1.0;
        /// Radius at the root, fractions of the tile's width. Hair thinner than a texel fades instead of breaking up.
        root_radius: f32 = 0.0065, in 1e-5..=0.25, needs "hair.root_radius_m=none";
        /// Radius at the tip, fractions of the tile's width.
        tip_radius: f32 = 0.0013, in 0.0..=0.25, needs "hair.tip_radius_m=none";
        /// Radius at the root, metres, instead of `hair.root_radius`. Examples: 0.00003 for a dog's guard hair, 0.001
        /// for a hedgehog's spine. If `surface.tile_size_m` is left out, the tile is made narrow enough that a hair is
        /// as wide as a texel (`slice.tile_texels`).
        root_radius_m: Option<f32> = None, in 1e-7..=0.1;
        /// Radius at the tip, metres, instead of `hair.tip_radius`.
        tip_radius_m: Option<f32> = None, in 0.0..=0.1;
        /// Bending of strands from root to tip: 0 upright, 1 lying on the mesh surface.
        lean: f32 = 0.65, in 0.0..=1.0;
        /// Direction in which strands lean, degrees in the tile: 0 towards +v, 90 towards +u.
        lean_direction_deg: f32 = 0.0, in -360.0..=360.0;
        /// Radius of the helix of `curly` strands, fractions of the tile's width.
        curl_radius: f32 = 0.03, in 0.0..=1.0;
        /// Height of one turn of the helix of `curly` strands along its axis, fractions of the tile's width. Small
        /// values give tight curls.
        curl_pitch: f32 = 0.18, in 1e-3..=100.0;
        /// Small random bends along a strand: 0 smooth, 1 woolly. `wet` and `lying` strands have a third of it.
        frizz: f32 = 0.1, in 0.0..=1.0;
        /// Clumping of `wet` hair: with 0 there is none, with 1 every lock ends in a point.
        clump: f32 = 0.9, in 0.0..=1.0;
        /// Clumping of dry hair towards its tips, typical of thick fur: with 0 there is none, with 1 every lock ends in
        /// a point.
        dry_clump: f32 = 0.25, in 0.0..=1.0;
        /// Number of locks in the tile, at most one per strand. If left out, it is chosen from the hair's length.
        clump_count: Option<u32> = None, in 1..=1_000_000;
    }
}

words! {
    /// Texture coordinates of the images in `[groom]`.
    GroomCoordinates {
        /// The model's own texture coordinates.
        #[default]
        Model = "model",
        /// Generated atlas, which depends on the model alone.
        Atlas = "atlas",
        /// Projection along x: y is up on the image.
        X = "x",
        /// Projection along y: z points down on the image.
        Y = "y",
        /// Projection along z: y is up on the image.
        Z = "z",
        /// Projections along all three axes, blended by the normal.
        Box = "box",
    }
}

impl GroomCoordinates {
    /// Returns the spatial projection of images; `None` if images use texture coordinates.
    pub fn projection(self) -> Option<PatternProjection> {
        match self {
            Self::Model | Self::Atlas => None,
            Self::X => Some(PatternProjection::X),
            Self::Y => Some(PatternProjection::Y),
            Self::Z => Some(PatternProjection::Z),
            Self::Box => Some(PatternProjection::Box),
        }
    }
}

params! {
    /// `[underfur]`: short, fine and dense hair below the longer and coarser guard hair of `[hair]`, as on most
    /// animals. Keys left out have the values of `[hair]`. Underfur and guard hair gather in the same locks.
    UnderfurParams in underfur {
        /// Number of strands of underfur in the tile, in addition to `hair.density`. 0: guard hair only.
        density: u32 = 700, in 0..=1_000_000;
        /// Hairs of underfur per square millimetre, instead of `underfur.density`; see `hair.density_mm2`.
        density_mm2: Option<f32> = None, in 0.0..=1e4;
        /// Length of the longest hair of underfur, as a share of the longest guard hair.
        length: f32 = 0.5, in 0.01..=1.0;
        /// Variation in length; see `hair.length_variation`.
        length_variation: f32 = 0.4, in 0.0..=1.0;
        /// Radius at the root, fractions of the tile's width.
        root_radius: f32 = 0.005, in 1e-5..=0.25;
        /// Radius at the tip, fractions of the tile's width.
        tip_radius: f32 = 0.0015, in 0.0..=0.25;
        /// Radius at the root, metres, instead of `underfur.root_radius`; see `hair.root_radius_m`. Example: 0.00001
        /// for a dog.
        root_radius_m: Option<f32> = None, in 1e-7..=0.1;
        /// Radius at the tip, metres, instead of `underfur.tip_radius`.
        tip_radius_m: Option<f32> = None, in 0.0..=0.1;
        /// Style, if it differs from `hair.style`. Either both are wet or neither is.
        style: Option<Style> = None;
        /// Bending from root to tip, if it differs from `hair.lean`.
        lean: Option<f32> = None, in 0.0..=1.0;
        /// Small random bends along a strand: 0 smooth, 1 woolly. Underfur is crimped.
        frizz: f32 = 0.3, in 0.0..=1.0;
        /// Clumping, if it differs from `hair.dry_clump`.
        dry_clump: Option<f32> = None, in 0.0..=1.0;
        /// sRGB colour at the root, if it differs from `color.root`.
        root: Option<SrgbColor> = None;
        /// sRGB colour at the tip, if it differs from `color.tip`.
        tip: Option<SrgbColor> = None;
    }
}

params! {
    /// `[groom]`: values that vary over the model. A map is a number for the whole model, `"vertex"` for the vertex
    /// colours, or the path of an image, relative to the recipe's folder. Images use the texture coordinates that
    /// `groom.coordinates` selects. Append `#g`, `#b` or `#a` to read a channel other than red.
    GroomParams in groom {
        /// Texture coordinates of images: `model` uses the model's own. `atlas` is a generated atlas, which depends on
        /// the model alone, not on the recipe, and needs no texture coordinates. `pelage groom` writes maps to paint on
        /// for both. `x`, `y` and `z` project each image once through the model at rest, along that axis. `box`
        /// projects it along all three, blended by the normal (see `color.pattern_projection`). Except with `model`,
        /// all images are read at the vertices, including those of wetness, bareness and colour.
        coordinates: GroomCoordinates = GroomCoordinates::Model;
        /// Hair length, as a share of `hair.length_m`: 0 no hair, 1 full length.
        length: ScalarMap = ScalarMap::Constant(1.0), in SHARE;
        /// Hairs per area relative to the rest of the fur. In images and vertex colours, 0, 0.5 and 1 mean 0.25, 1 and
        /// 4.
        density: ScalarMap = ScalarMap::Constant(1.0), in DENSITY;
        /// Additional lean towards the comb direction, beyond `hair.lean`: 0 none, 1 moves the tips sideways by the
        /// length of the hair.
        lean: ScalarMap = ScalarMap::Constant(0.0), in SHARE;
        /// Comb direction, instead of `surface.comb`; its length, up to 1, is its weight. Vertex colours and images
        /// hold x, y, z of the model at rest as 2·rgb − 1. An image with `#uv` holds right and up on the image as 2·rg
        /// − 1.
        comb: Option<VectorMap> = None;
        /// Wetness: 0 dry, 1 wet like `hair.style` `wet`; values between blend both.
        wetness: ScalarMap = ScalarMap::Constant(0.0), in SHARE;
        /// Bareness: where it is 1, no hair grows and the base colour shows. Images in the model's texture coordinates
        /// are sampled per texel.
        bare: ScalarMap = ScalarMap::Constant(0.0), in SHARE;
        /// Distance from bare materials at which hair reaches its full length, metres along the mesh surface. Towards
        /// the border, its length falls to zero, so that long hair does not cover an eye. Evaluated at the model's
        /// vertices. If left out, it is just wide enough that hair hides no bare part. With 0, hair is not shortened.
        bare_margin_m: Option<f32> = None, in 0.0..=1e3;
        /// Colour of hair and skin on furred materials, instead of the model's base colour; for hair, it multiplies
        /// root and tip colour. `groom.hair_color` colours the hair alone.
        color: Option<ColorMap> = None;
        /// Colour of the hair alone on furred materials, sRGB, instead of the model's base colour; multiplies root and
        /// tip colour. The skin, at bare places and in the styles `bare` and `ink`, keeps the colour of the model or of
        /// `groom.color`. A pattern and the colours of comb marks then apply to the skin alone.
        hair_color: Option<SrgbColor> = None;
        /// Groom of single materials: `[[groom.material]]` with a `name`, in which `*` matches any characters and `?`
        /// one, and any of the keys above. Later tables take precedence.
        material: Vec<MaterialGroom> = Vec::new();
        /// Groom of single joints of the skeleton: `[[groom.joint]]` with a `name`, in which `*` matches any characters
        /// and `?` one, and numbers for any of length, density, lean, wetness and bare. A table also applies to
        /// descendant joints, unless a table for a nearer joint sets the key. If several tables match a joint, the last
        /// takes precedence. The skinning weights blend the values of joints with each other and with those of
        /// materials.
        joint: Vec<JointGroom> = Vec::new();
        /// Weight of the automatic groom where no map sets a value: 0 none, 1 full. It follows the shape of the body
        /// and the names of its joints. Hair is short and flat on legs, ears and muzzle and near small bare parts, and
        /// long on neck, belly and tail. Near soles, it reaches beyond them by at most about a quarter of the limb's
        /// radius. `hair.length_m` remains the length of the longest hair.
        by_body: f32 = 1.0, in SHARE;
    }
}

params! {
    /// `[color]`: colours of the strands.
    ColorParams in color {
        /// sRGB colour at the root. If left out, it is near white for a model with colours, which then colour the hair,
        /// and brown otherwise.
        root: Option<SrgbColor> = None;
        /// sRGB colour at the tip. If left out, it is white for a model with colours, and light brown otherwise.
        tip: Option<SrgbColor> = None;
        /// Factor on the hair's colours. It compensates for the shadows that hairs cast on each other, so that fur
        /// looks as light as the mesh surface below. If left out, it is chosen if the model has colours of its own and
        /// neither `color.root` nor `color.tip` is set; otherwise it is 1. Bare materials are unaffected.
        gain: Option<f32> = None, in 0.1..=4.0;
        /// sRGB colour of a band across each guard hair, between root and tip colour, as in the agouti fur of wild
        /// animals. If left out, hairs have no band.
        band: Option<SrgbColor> = None;
        /// Position of the middle of the band: 0 at the root, 1 at the tip.
        band_at: f32 = 0.7, in 0.0..=1.0, needs "color.band!=none";
        /// Width of the band, as a share of the hair's length. On either side, the band fades over half its width.
        band_width: f32 = 0.25, in 0.01..=1.0, needs "color.band!=none";
        /// Variation in brightness between strands: with 0, all strands are equally bright; with 1, they range from
        /// black to twice the brightness.
        variation: f32 = 0.35, in 0.0..=1.0;
        /// Whether the model's base colour (factor, texture and vertex colours) multiplies the hair's colour.
        base_color: bool = true;
        /// Whether hair keeps the colour at its root where it hangs over another colour, so that colours blend hair by
        /// hair. The colour is that of the model, `groom.color` or the pattern. The colours of the affected furred
        /// materials are painted into a texture. If off, colours of layers change where those of the surface do.
        at_root: bool = true;
        /// Image of a fur pattern, projected through the model at rest, by which the hair's colour is multiplied. It
        /// needs no texture coordinates. The path is relative to the recipe's folder.
        pattern: Option<FilePath> = None;
        /// Projection of the pattern: `x`, `y` and `z` project along that axis; `box` projects along all three, softly
        /// blended by the normal.
        pattern_projection: PatternProjection = PatternProjection::Box, needs "color.pattern!=none";
        /// Width of the pattern image on the model, metres. If left out, the image spans the model once.
        pattern_size_m: Option<f32> = None, in 1e-6..=1e6, needs "color.pattern!=none";
        /// Continuation of the pattern image beyond its border: `repeat` repeats it, `clamp` extends the outermost
        /// texels.
        pattern_wrap: PatternWrap = PatternWrap::Repeat, needs "color.pattern!=none";
        /// Width and height of the texture that the pattern is painted into, texels; at most `pack.base_color_max`.
        pattern_texels: u32 = 1024, in 64..=8192, as PowerOfTwo;
    }
}

/// Hair colours at root and tip, and their gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HairColors {
    /// Factor on the colours of furred materials.
    pub gain: f32,
    /// Colour at the root.
    pub root: SrgbColor,
    /// Colour at the tip.
    pub tip: SrgbColor,
}

impl HairColors {
    /// Hair colours for a model without any colour: brown.
    pub const BROWN: Self = Self { gain: 1.0, root: SrgbColor::hex(0x4a_36_24), tip: SrgbColor::hex(0xe8_d2_ac) };
    /// Apparent colour of fur with [`Self::BROWN`] hair. If a model has no colours but its comb marks do, this is the
    /// base colour, combined with [`Self::NEUTRAL`] hair.
    pub const PLAIN: SrgbColor = SrgbColor::hex(0xa8_8c_68);
    /// Hair colours for a model with colours; roots are darkened only by the hairs' shadows. The gain makes fur as
    /// bright as the mesh surface, measured on five animals in the mean of four lights (`formats/docs/formulas.md`,
    /// 7.7).
    pub const NEUTRAL: Self = Self { gain: 1.3, root: SrgbColor::hex(0xd8_d8_d8), tip: SrgbColor::hex(0xff_ff_ff) };
}

impl HairColors {
    /// Hair colours for a model with colours and multiple scattering between hairs, which makes a gain unnecessary.
    pub const SCATTERING: Self = Self { gain: 1.0, root: SrgbColor::hex(0xff_ff_ff), tip: SrgbColor::hex(0xff_ff_ff) };
}

impl ColorParams {
    /// Returns the hair colours of the recipe; keys that it leaves out get the values in `open`.
    pub fn hair(&self, open: HairColors) -> HairColors {
        // A recipe that sets a hair colour also determines its brightness, so the gain is 1.
        let is_said = self.root.is_some() || self.tip.is_some();
        HairColors {
            gain: self.gain.unwrap_or(if is_said { 1.0 } else { open.gain }),
            root: self.root.unwrap_or(open.root),
            tip: self.tip.unwrap_or(open.tip),
        }
    }
}

words! {
    /// Projection of a pattern onto the model.
    PatternProjection {
        /// Along x: y is up on the image.
        X = "x",
        /// Along y: z points down on the image.
        Y = "y",
        /// Along z: y is up on the image.
        Z = "z",
        /// Along all three axes, blended by the normal.
        #[default]
        Box = "box",
    }
}

words! {
    /// Continuation of a pattern beyond its border.
    PatternWrap {
        /// Repeats the image.
        #[default]
        Repeat = "repeat",
        /// Extends the outermost texels.
        Clamp = "clamp",
    }
}

params! {
    /// `[slice]`: shell textures. Defaults are those of Yang 2006, except for twice as many texels, which cost no frame
    /// time and show in close-ups.
    SliceParams in slice {
        /// Number of layers, including the one on the mesh surface. More layers are smoother from the side and cost
        /// frame time in proportion.
        layers: u32 = 16, in 4..=256;
        /// Width and height of a layer, texels.
        tile_texels: u32 = 128, in 16..=2048, as PowerOfTwo;
        /// Standard deviation of the Gaussian that filters the strands, texels. Small values give sharp hair that
        /// sparkles, large ones give soft hair.
        filter_width: f32 = 0.5, in 0.25..=4.0;
    }
}

params! {
    /// `[visibility]`: light that reaches the hair past other strands, computed by ray casting and stored in a texture.
    /// It needs no shadow map.
    VisibilityParams in visibility, needs "visibility.enabled=true" {
        /// Whether the package has the visibility texture. It increases the size of the hair data by half, but saves
        /// rendering a map per layer when light or pose change.
        enabled: bool = true;
        /// Number of ray directions per point of a strand. More directions reduce noise and increase the bake time in
        /// proportion.
        directions: u32 = 12, in 8..=1024;
    }
}

params! {
    /// `[strands]`: hair as single strands, for close views.
    StrandParams in strands {
        /// Whether the package has the strands of the tile: 16 bytes per point, 144 KB for 1000 strands. Without them,
        /// layers are drawn at any distance.
        enabled: bool = true;
        /// Number of points of each strand, preferably one more than a power of two. Strands that are small on screen
        /// are drawn with a half, a quarter and so on of the segments.
        points: u32 = 9, in 2..=33, needs "strands.enabled=true";
        /// Guided hair: `[[strands.group]]` with a `name`, for manes, tails, a head of hair. Independent of
        /// `enabled`.
        group: Vec<HairGroupParams> = Vec::new();
        /// Small group of thick hairs at one point: `[[strands.tuft]]` with a `name`, for whiskers, lashes and brows.
        /// Independent of `enabled`.
        tuft: Vec<TuftParams> = Vec::new();
        /// Whether moving guided hair collides with the body: a capsule is fitted to the mesh surface of each
        /// joint.
        colliders: bool = true;
        /// User-defined capsules: `[[strands.collider]]` with a `name`. Each replaces the capsule fitted to its joint.
        collider: Vec<HairColliderParams> = Vec::new();
    }
}

params! {
    /// `[fins]`: quads of hair on the edges of the mesh, visible where the layers are seen edge-on.
    FinParams in fins, needs "fins.enabled=true" {
        /// Whether there are fins. They reduce blur and make layers less visible along the outline, for a fifth of the
        /// frame time.
        enabled: bool = false;
        /// Depth of the hair that each fin shows, measured across the fin, widths of the tile. If left out, it is
        /// chosen such that layers and fins together cover the outline like much finer layers. Higher values are denser
        /// and crisper.
        depth: Option<f32> = None, in 1e-3..=8.0;
    }
}

params! {
    /// `[detail]`: levels of detail for fur that is small on screen. Sizes are the height of the fur on screen, pixels,
    /// at a renderer's default `bias`.
    DetailParams in detail, needs "detail.enabled=true" {
        /// Whether the package has levels of detail: a chain of levels with fewer layers, and a layer that shows the
        /// fur as seen from afar.
        enabled: bool = true;
        /// Whether the package also has simplified index lists, for models whose triangles are smaller than pixels.
        simplified: bool = true;
        /// Distance between two layers seen from the side, pixels. The number of layers is the height of the fur
        /// divided by this distance. Smaller is finer and more expensive. If it is too large, a gap below the outermost
        /// layer shows as a line around the body.
        gap_px: f32 = 1.15, in 0.05..=64.0;
        /// Size at which a level has been fully replaced by the next, divided by the size at which its replacement
        /// begins. 1 switches at once, smaller values blend longer. Between both sizes, layers are replaced one by one.
        fade: f32 = 0.5, in 0.1..=1.0;
        /// Height of the fur down to which fins are drawn with the layers. Without fins, the outline shows fewer,
        /// blurred layers.
        fins_px: f32 = 0.0, in 0.0..=1e4;
        /// Height of the fur down to which layers are drawn; below it, the far fur layer replaces them. 0 draws layers
        /// at any size.
        coat_px: f32 = 1.2, in 0.0..=1e4;
    }
}

words! {
    /// Texel format of the shell textures.
    ShellFormat {
        /// BC7: one byte per texel.
        #[default]
        Bc7 = "bc7",
        /// RGBA8: four bytes per texel, exact.
        Rgba8 = "rgba8",
    }
}

words! {
    /// Texel format of the direction textures.
    DirectionFormat {
        /// BC5: one byte per texel.
        #[default]
        Bc5 = "bc5",
        /// RG8: two bytes per texel.
        Rg8 = "rg8",
        /// RGBA8: four bytes per texel, with the confidence in alpha.
        Rgba8 = "rgba8",
    }
}

words! {
    /// Texel format of base-colour textures.
    BaseColorFormat {
        /// BC7: one byte per texel.
        #[default]
        Bc7 = "bc7",
        /// RGBA8: four bytes per texel, exact.
        Rgba8 = "rgba8",
    }
}

words! {
    /// Effort of the block encoders.
    BcQuality {
        /// For previews.
        Fast = "fast",
        /// Balanced.
        #[default]
        Basic = "basic",
        /// For final bakes.
        Slow = "slow",
    }
}

params! {
    /// `[pack]`: texture formats of the package.
    PackParams in pack {
        /// Texel format of the shell textures.
        shell_format: ShellFormat = ShellFormat::Bc7;
        /// Texel format of the direction and groom textures.
        direction_format: DirectionFormat = DirectionFormat::Bc5;
        /// Texel format of base-colour textures.
        base_color_format: BaseColorFormat = BaseColorFormat::Bc7;
        /// Maximum width and height of base-colour textures, texels; larger ones are scaled down.
        base_color_max: u32 = 1024, in 4..=16_384;
        /// Effort of the block encoders.
        bc_quality: BcQuality = BcQuality::Basic;
    }
}

params! {
    /// `[judge]`: images by which the error of a bake with limits (`--max-error`, `--max-frame-ms`, `--max-bytes`) is
    /// measured. Choose views like those in the scene: a model that stays small on screen needs less detail.
    JudgeParams in judge {
        /// Viewpoints, each `"ex,ey,ez/tx,ty,tz/fov_deg"` (eye, target, field of view), metres and degrees, with the
        /// model at rest. If empty, two viewpoints frame the model, from its front left and from its back right.
        views: Vec<Viewpoint> = Vec::new();
        /// Width of each image, pixels.
        width: u32 = 834, in 16..=4096;
        /// Height of each image, pixels.
        height: u32 = 424, in 16..=4096;
        /// Number of rays per pixel of the ray-traced reference images. A low number leaves noise, which counts as
        /// error of the bake.
        samples: u32 = 64, in 1..=65_536;
    }
}
