//! The parameters of each stage, with their meaning, range and default in one place.

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
    /// `[model]`: how the model is read.
    ModelParams in model {
        /// Metres per unit of the model. glTF says metres; set it where an exporter did not keep to that, and for OBJ, which does not say.
        unit_m: f32 = 1.0, in ImportOptions::UNIT_M;
        /// Names of materials where no hair grows, such as eyes and hooves. `*` stands for any characters, `?` for one; `[]` has hair grow everywhere. Left
        /// out, eyes, teeth, tongues, noses, claws, hooves, horns, beaks and clothes are found by the names of materials, nodes and meshes in eight languages,
        /// and small parts by gloss or by the shape of eyes. What is in doubt grows hair; the bake says what it found. Of a material that also covers
        /// furred parts, a nose, rims of eyes, claws and what a node or a mesh names are told apart: `Black/nose`, `Main/Eye_L`; `Black` names them all.
        bare: Option<Vec<String>> = None;
    }
}

words! {
    /// Where tile coordinates come from.
    SurfaceSource {
        /// Lapped patches over any surface.
        #[default]
        Patches = "patches",
        /// The model's own texture coordinates, scaled.
        Model = "model",
    }
}

words! {
    /// Where hair is combed to.
    CombSource {
        /// Marks where the recipe or the model has some, else one direction.
        #[default]
        Auto = "auto",
        /// One direction everywhere.
        Direction = "direction",
        /// Down.
        Gravity = "gravity",
        /// Down the model's own texture.
        Tangents = "tangents",
        /// Directions at a few places.
        Marks = "marks" was "guides",
        /// Nowhere: patches lie as they distort least.
        None = "none",
    }
}

params! {
    /// `[surface]`: how the periodic tile of hair lies on the model, and where the hair is combed to.
    SurfaceParams in surface {
        /// Where tile coordinates come from: `patches` grows patches over any surface and needs no texture coordinates, `model` takes
        /// the model's own.
        source: SurfaceSource = SurfaceSource::Patches;
        /// Width of the tile on the skin, metres: the reciprocal of tiles per metre. Left out, it is chosen from the model's size, and no wider than
        /// `hair.density_mm2` and `hair.root_radius_m` allow. Small repeats visibly, large spreads the texels thin.
        tile_size_m: Option<f32> = None, in 1e-6..=1e3;
        /// The same where surface.tile_size_m is left out, as a share of the radius of the sphere around the model at rest.
        tile_size_per_radius: f32 = 0.15, in 1e-3..=10.0;
        /// Where hair is combed to: `direction` (surface.comb_direction), `gravity`, `tangents` (down the model's own texture), `marks`
        /// (surface.comb_marks, and lines that are drawn in the model), or `none`, which lets patches lie as they distort least and suits hair that
        /// stands up. `auto` is `marks` where a mark of the recipe has a direction, or where the model has such lines and surface.comb_direction is left
        /// alone; else it is `direction`.
        comb: CombSource = CombSource::Auto;
        /// Direction of the comb in world space at rest, any length but 0. The default runs from nose to tail and a little down on an animal
        /// that looks along +z.
        comb_direction: [f32; 3] = [0.0, -0.35, -1.0], in -1e6..=1e6;
        /// What hair is like at places, spread over the skin: tables with `name`, `at` (metres), and any of `direction`, `length`, `density`, `lean`,
        /// `color`, which go before what `[groom]` says, with `reach_m` and `mirrored`. Directions count with `surface.comb = "marks"`, the others always.
        comb_marks: Vec<CombMarkParams> = Vec::new(), was "guides";
        /// How far neighbours are asked where the comb is weak or broken, tiles: small keeps every wish, large makes broad strokes.
        comb_smoothing: f32 = 1.0, in 0.01..=100.0;
        /// How strictly patches follow the comb: 1 along it, 0 turns every triangle to what distorts least.
        comb_weight: f32 = 0.5, in 0.0..=1.0;
        /// How far a patch may grow from its seed, tiles. Large has few seams and more distortion.
        patch_size: f32 = 4.0, in 0.05..=1000.0;
        /// Largest angle between a patch's hair and the comb, degrees.
        patch_turn_deg: f32 = 25.0, in 1.0..=60.0;
        /// Largest stretch of a triangle in any direction, and the inverse of the least.
        patch_stretch: f32 = 1.5, in 1.01..=4.0;
    }
}

params! {
    /// `[hair]`: the strands of one tile. Lengths on the tile are fractions of its width, so that the look does not depend on
    /// the model's units.
    HairParams in hair {
        /// The kind of hair, which gives other keys their defaults: what each sets stands on the page of [coats](coats.md). What a recipe says
        /// itself counts, wherever it stands; keys that have the value of the coat before follow a change by `--set`.
        coat: Coat = Coat::Animal;
        /// The forces that shape a strand: `straight`, `curly`, `messy`, `wet` or `lying`. `wet` gathers strands into locks,
        /// darkens their colour and makes the highlight stronger and narrower than `[shading]` says; `lying` is combed flat.
        style: Style = Style::Straight;
        /// Seed of everything random. Another seed is another coat of the same kind.
        seed: u64 = 1, in 0..=i64::MAX as u64;
        /// Strands in the tile.
        density: u32 = 600, in 1..=1_000_000;
        /// Hairs per square millimetre of skin, in place of `hair.density`: a dog's back has some 3 guard hairs and 40 of underfur. Where
        /// `surface.tile_size_m` is left out, the tile is then as wide as some thousands of strands allow. It holds where `groom.density` is 1.
        density_mm2: Option<f32> = None, in 1e-6..=1e4;
        /// Length of the longest strand along its curve, metres. Left out, it is chosen from the model's size.
        length_m: Option<f32> = None, in 1e-6..=1e3;
        /// The same where hair.length_m is left out, as a share of the radius of the sphere around the model at rest: 0.02 a short-haired animal,
        /// 0.15 a long-haired one.
        length_per_radius: f32 = 0.05, in 1e-4..=10.0;
        /// How much shorter than the longest a strand may be: 0 all alike, 1 down to nothing. Longer is rarer, so that the
        /// fur thins towards its surface.
        length_variation: f32 = 0.5, in 0.0..=1.0;
        /// Radius at the root, fractions of the tile's width. Below a texel hair fades instead of breaking up.
        root_radius: f32 = 0.0065, in 1e-5..=0.25;
        /// Radius at the tip, fractions of the tile's width.
        tip_radius: f32 = 0.0013, in 0.0..=0.25;
        /// Radius at the root, metres, in place of `hair.root_radius`: 0.00003 of a dog's guard hair, 0.001 of a hedgehog's spine. Where
        /// `surface.tile_size_m` is left out, the tile is then so narrow that a hair is as wide as one of its texels (`slice.tile_texels`).
        root_radius_m: Option<f32> = None, in 1e-7..=0.1;
        /// Radius at the tip, metres, in place of `hair.tip_radius`.
        tip_radius_m: Option<f32> = None, in 0.0..=0.1;
        /// How far strands bend over from root to tip: 0 upright, 1 lying on the skin.
        lean: f32 = 0.65, in 0.0..=1.0;
        /// Where they lean to, degrees in the tile: 0 towards +v, 90 towards +u.
        lean_direction_deg: f32 = 0.0, in -360.0..=360.0;
        /// Radius of the helix of `curly` strands, fractions of the tile's width.
        curl_radius: f32 = 0.03, in 0.0..=1.0;
        /// Height of one turn of that helix along its axis, fractions of the tile's width. Small is tight.
        curl_pitch: f32 = 0.18, in 1e-3..=100.0;
        /// Small random bends along a strand: 0 smooth, 1 woolly. `wet` and `lying` keep a third of it.
        frizz: f32 = 0.1, in 0.0..=1.0;
        /// How closely the strands of `wet` hair gather: 0 not at all, 1 every lock ends in a point.
        clump: f32 = 0.9, in 0.0..=1.0;
        /// How closely hair that is not wet gathers in locks towards its tips, as thick coats do: 0 not at all, 1 every lock ends in a point.
        dry_clump: f32 = 0.25, in 0.0..=1.0;
        /// Locks in the tile, at most one a strand. Left out, it is chosen from the hair's length.
        clump_count: Option<u32> = None, in 1..=1_000_000;
    }
}

words! {
    /// What the images of `[groom]` lie over.
    GroomCoordinates {
        /// The model's own texture coordinates.
        #[default]
        Model = "model",
        /// An atlas of the model alone.
        Atlas = "atlas",
        /// Space, projected along x: y is up on the image.
        X = "x",
        /// Along y: z points down on the image.
        Y = "y",
        /// Along z: y is up on the image.
        Z = "z",
        /// Along all three axes, blended by the normal.
        Box = "box",
    }
}

impl GroomCoordinates {
    /// How images are laid through space, where they are.
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
    /// `[underfur]`: a second coat below the first, as most animals have it: short, fine and dense under the longer and coarser guard hairs
    /// that `[hair]` describes. What it leaves out is as `[hair]` says, and both gather in the same locks.
    UnderfurParams in underfur {
        /// Strands of underfur in the tile, beside those of `hair.density`. 0 is a coat of guard hair alone.
        density: u32 = 700, in 0..=1_000_000;
        /// Hairs of underfur per square millimetre of skin, in place of `underfur.density`, as `hair.density_mm2`.
        density_mm2: Option<f32> = None, in 0.0..=1e4;
        /// Length of the longest of them, as a share of the longest guard hair's.
        length: f32 = 0.5, in 0.01..=1.0;
        /// How much shorter than that one may be, as `hair.length_variation`.
        length_variation: f32 = 0.4, in 0.0..=1.0;
        /// Radius at the root, fractions of the tile's width.
        root_radius: f32 = 0.005, in 1e-5..=0.25;
        /// Radius at the tip, fractions of the tile's width.
        tip_radius: f32 = 0.0015, in 0.0..=0.25;
        /// Radius at the root, metres, in place of `underfur.root_radius`, as `hair.root_radius_m`: 0.00001 of a dog's.
        root_radius_m: Option<f32> = None, in 1e-7..=0.1;
        /// Radius at the tip, metres, in place of `underfur.tip_radius`.
        tip_radius_m: Option<f32> = None, in 0.0..=0.1;
        /// Its style, where it is another than `hair.style`. Hair is wet in both coats or in none.
        style: Option<Style> = None;
        /// How far it bends over, where that is not as `hair.lean` says.
        lean: Option<f32> = None, in 0.0..=1.0;
        /// Small random bends along a strand: underfur is crimped.
        frizz: f32 = 0.3, in 0.0..=1.0;
        /// How closely it gathers in locks, where that is not as `hair.dry_clump` says.
        dry_clump: Option<f32> = None, in 0.0..=1.0;
        /// sRGB colour at the root, where it is another than `color.root`.
        root: Option<SrgbColor> = None;
        /// sRGB colour at the tip, where it is another than `color.tip`.
        tip: Option<SrgbColor> = None;
    }
}

params! {
    /// `[groom]`: what varies over the model. A map is a number for the whole model, `"vertex"` for the vertex colours, or the
    /// path of an image over `groom.coordinates`, from the recipe's folder; `#g` behind either reads another channel
    /// than the red.
    GroomParams in groom {
        /// What its images lie over: `model`, the model's own texture coordinates, or `atlas`, an atlas that needs none and is the same for the same
        /// model whatever else the recipe says. `pelage groom` writes maps over either, to paint on. Or they are laid through the model at rest, which
        /// each spans once, as a pattern is by `color.pattern_projection`: `x`, `y` and `z` project them along that axis, `box` along all three, blended
        /// by the normal. Over anything but the model's own coordinates all images are read at the vertices, also those of wetness, bareness and
        /// colour.
        coordinates: GroomCoordinates = GroomCoordinates::Model;
        /// Share of `hair.length_m`: 0 no hair, 1 full length.
        length: ScalarMap = ScalarMap::Constant(1.0), in SHARE;
        /// Hairs per area relative to the rest of the coat. Of a map, 0, 0.5 and 1 stand for 0.25, 1 and 4.
        density: ScalarMap = ScalarMap::Constant(1.0), in DENSITY;
        /// How far the hair lies over towards the comb direction, beyond what `hair.lean` does: 0 no further, 1 its tips stand a
        /// hair's length aside.
        lean: ScalarMap = ScalarMap::Constant(0.0), in SHARE;
        /// Where the hair is combed to, in place of `surface.comb`; the length, up to 1, is how much it counts. Of vertex colours and images, 2·rgb − 1 is x, y, z of the model at rest; of an image with
        /// `#uv`, 2·rg − 1 points right and up on the image.
        comb: Option<VectorMap> = None;
        /// 0 dry, 1 as `hair.style` `wet`; anything between mixes both.
        wetness: ScalarMap = ScalarMap::Constant(0.0), in SHARE;
        /// 1 where no hair grows: the skin shows its base colour. Images over the model's texture coordinates are followed texel by texel.
        bare: ScalarMap = ScalarMap::Constant(0.0), in SHARE;
        /// How far from a bare material hair has its full length, metres on the skin; from there it grows shorter, to nothing at the border, so that
        /// long hair beside an eye does not hang over it. It is known at the model's vertices. Left out, it is as wide as the hair there needs for not to hide any of them; 0 leaves hair
        /// as long beside bare materials as elsewhere.
        bare_margin_m: Option<f32> = None, in 0.0..=1e3;
        /// Colour of the hair on furred materials in place of the model's base colour; multiplies root and tip colour.
        color: Option<ColorMap> = None;
        /// The same for single materials: `[[groom.material]]` with a `name`, in which `*` stands for any characters and `?` for
        /// one, and any of the keys above. Later ones win.
        material: Vec<MaterialGroom> = Vec::new();
        /// The same for single joints of the skeleton: `[[groom.joint]]` with a `name`, in which `*` stands for any characters and `?` for one, and
        /// numbers for any of length, density, lean, wetness and bare. A table holds for the joints that hang on its own as well, where none
        /// nearer says the key; of several for one joint the last wins. Values fade into each other, and into what materials say, as the skin's
        /// weights do.
        joint: Vec<JointGroom> = Vec::new();
        /// How much the shape of the body and the names of its joints shape the coat where no map says it: 0 not at all, 1 short and flat hair on legs,
        /// ears and muzzle and near small bare parts, long hair on neck, belly and tail. `hair.length_m` stays the length of the longest.
        by_body: f32 = 1.0, in SHARE;
    }
}

params! {
    /// `[color]`: the strands' colour.
    ColorParams in color {
        /// sRGB colour at the root. Left out, it is near white where the model brings colours of its own, which the hair then has, and brown where it brings
        /// none.
        root: Option<SrgbColor> = None;
        /// sRGB colour at the tip. Left out, it is white or a light brown, likewise.
        tip: Option<SrgbColor> = None;
        /// How much lighter hair is than its colours say: makes up for the shadow that hairs throw on each other, so that a coat is on the whole as light as the
        /// skin that it hides. Left out, it does so where the model brings colours of its own, and is 1 where it brings none. Bare materials keep theirs.
        gain: Option<f32> = None, in 0.1..=4.0;
        /// sRGB colour of a band across each guard hair, as agouti coats of wild animals have: root, band, tip. Left out, there is none.
        band: Option<SrgbColor> = None;
        /// Where the middle of the band lies: 0 at the root, 1 at the tip.
        band_at: f32 = 0.7, in 0.0..=1.0;
        /// Width of the band, share of the hair's length. It fades over half of that to either side.
        band_width: f32 = 0.25, in 0.01..=1.0;
        /// How much strands differ in brightness: 0 all alike, 1 from black to double.
        variation: f32 = 0.35, in 0.0..=1.0;
        /// Whether the model's base colour (factor, texture and vertex colours) multiplies the hair's.
        base_color: bool = true;
        /// Whether hair that hangs over skin of another colour keeps the colour that the model, `groom.color` or the pattern has where it roots, so
        /// that colours grade into each other hair by hair. Where it does, the colours of furred materials are painted into a texture for it. If not, colours in
        /// layers end where they end on the skin.
        at_root: bool = true;
        /// Pattern of the coat: an image laid through the model at rest, which multiplies the hair's colour. It needs no texture
        /// coordinates. The path is from the recipe's folder.
        pattern: Option<FilePath> = None;
        /// How it is laid: `x`, `y` and `z` project it along that axis, `box` along all three, softly blended by the normal.
        pattern_projection: PatternProjection = PatternProjection::Box;
        /// Width of the image on the model, metres. Left out, the image spans the model once.
        pattern_size_m: Option<f32> = None, in 1e-6..=1e6;
        /// Beyond its border: `repeat` starts over, `clamp` goes on with the outermost texel.
        pattern_wrap: PatternWrap = PatternWrap::Repeat;
        /// Width and height of the texture that the pattern is painted into, texels; at most `pack.base_color_max`.
        pattern_texels: u32 = 1024, in 64..=8192, as PowerOfTwo;
    }
}

/// Colours of hair at root and tip, and how they are used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HairColors {
    /// What multiplies the colours of furred materials.
    pub gain: f32,
    /// At the root.
    pub root: SrgbColor,
    /// At the tip.
    pub tip: SrgbColor,
}

impl HairColors {
    /// Those of hair that nothing else colours: a brown coat.
    pub const BROWN: Self = Self { gain: 1.0, root: SrgbColor::hex(0x4a_36_24), tip: SrgbColor::hex(0xe8_d2_ac) };
    /// What a coat of that brown looks like with [`Self::NEUTRAL`] hair, where marks colour other parts of it.
    pub const PLAIN: SrgbColor = SrgbColor::hex(0xa8_8c_68);
    /// Those of hair that the model colours: it is the hairs' own shadows that darken it towards the roots. The gain is what five animals need on the
    /// mean of four lights (`formats/docs/formulas.md`, 7.7).
    pub const NEUTRAL: Self = Self { gain: 1.3, root: SrgbColor::hex(0xd8_d8_d8), tip: SrgbColor::hex(0xff_ff_ff) };
}

impl HairColors {
    /// Those of hair that the model colours, where hair lights hair: nothing is to be made up for.
    pub const SCATTERING: Self = Self { gain: 1.0, root: SrgbColor::hex(0xff_ff_ff), tip: SrgbColor::hex(0xff_ff_ff) };
}

impl ColorParams {
    /// Colours of the hair, with `open` for those that are left out.
    pub fn hair(&self, open: HairColors) -> HairColors {
        // Who says a colour of hair has chosen how light it is.
        let is_said = self.root.is_some() || self.tip.is_some();
        HairColors {
            gain: self.gain.unwrap_or(if is_said { 1.0 } else { open.gain }),
            root: self.root.unwrap_or(open.root),
            tip: self.tip.unwrap_or(open.tip),
        }
    }
}

words! {
    /// How a pattern is laid on the model.
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
    /// What lies beyond a pattern's border.
    PatternWrap {
        /// The pattern again.
        #[default]
        Repeat = "repeat",
        /// Its outermost texels.
        Clamp = "clamp",
    }
}

words! {
    /// How hair is lit.
    ShadingModel {
        /// By two lobes and constants.
        #[default]
        KajiyaKay = "kajiya-kay",
        /// As fibres that scatter light.
        Marschner = "marschner",
    }
}

params! {
    /// `[shading]`: how hair is lit. Constants are those of Yang 2006, eqs. (1)–(3); colours are linear RGB.
    ShadingParams in shading {
        /// How hair is lit: `kajiya-kay` by two lobes and the constants below (Yang 2006), or `marschner` as fibres that scatter light, by tables of the fibres of
        /// `[fibre]`, with light that goes on from hair to hair. Then the hair's colour is that of a deep coat in even light, no gain makes up for shadows, and of
        /// the constants the ambient ones alone count.
        model: ShadingModel = ShadingModel::KajiyaKay;
        /// ka: ambient light, multiplied by the hair's colour.
        ambient: [f32; 3] = pelage_formats::Shading::default().ambient, in 0.0..=100.0;
        /// kd: diffuse light.
        diffuse: [f32; 3] = pelage_formats::Shading::default().diffuse, in 0.0..=100.0;
        /// ks: the highlight, white whatever the hair's colour: on combed dark hair much of it looks like dust.
        specular: [f32; 3] = [0.09; 3], in 0.0..=100.0;
        /// pd: 0 lights all directions alike, higher darkens hair that points to the light.
        diffuse_exponent: f32 = pelage_formats::Shading::default().diffuse_exponent, in pelage_formats::Shading::EXPONENT;
        /// ps: higher is a narrower highlight.
        specular_exponent: f32 = 60.0, in pelage_formats::Shading::EXPONENT;
        /// Share of the ambient light that reaches the skin: 0 black roots, towards 1 flat.
        ambient_floor: f32 = pelage_formats::Shading::default().ambient_floor, in 0.0..=0.999;
        /// How far light creeps past the terminator, as −N·L: small is a hard edge.
        back_light_range: f32 = pelage_formats::Shading::default().back_light_range, in 0.001..=0.999;
    }
}

impl From<&ShadingParams> for pelage_formats::Shading {
    fn from(params: &ShadingParams) -> Self {
        Self {
            ambient: params.ambient,
            diffuse: params.diffuse,
            specular: params.specular,
            diffuse_exponent: params.diffuse_exponent,
            specular_exponent: params.specular_exponent,
            ambient_floor: params.ambient_floor,
            back_light_range: params.back_light_range,
        }
    }
}

params! {
    /// `[slice]`: the shell textures. Defaults as in Yang 2006, but for twice its texels: a frame does not pay for them, and close-ups show them.
    SliceParams in slice {
        /// Layers, skin included. More is smoother from the side and costs frame time in proportion.
        layers: u32 = 16, in 4..=256;
        /// Width and height of a layer, texels.
        tile_texels: u32 = 128, in 16..=2048, as PowerOfTwo;
        /// Standard deviation of the Gaussian that filters the strands, texels: small is sharp and sparkles, large is soft.
        filter_width: f32 = 0.5, in 0.25..=4.0;
    }
}

params! {
    /// `[visibility]`: how much light reaches the hair past the other strands, found by rays and kept in a texture, so that no shadow map needs to be
    /// drawn for it.
    VisibilityParams in visibility {
        /// Whether the package has that texture: half as many bytes of hair again, and no layer-wise map to draw when light or
        /// pose move.
        enabled: bool = true;
        /// Directions that each point of a strand looks into. More are less noise, and take longer in proportion.
        directions: u32 = 12, in 8..=1024;
    }
}

params! {
    /// `[strands]`: the hair as single strands, for pictures near enough to see them.
    StrandParams in strands {
        /// Whether the package has the strands of its tile, which are the coat's: 16 bytes a point, 144 KB for 1000 strands. Without, layers are drawn
        /// however near the eye is.
        enabled: bool = true;
        /// Points of each strand. Those of half, a quarter and so on of the pieces are drawn where strands are small, so that one more than a power of two
        /// suits best.
        points: u32 = 9, in 2..=33;
        /// Hair on guides: `[[strands.group]]` with a `name`, for manes, tails, a head of hair. It is there whether or not `enabled` is.
        group: Vec<HairGroupParams> = Vec::new();
        /// A few thick hairs at a place: `[[strands.tuft]]` with a `name`, for whiskers, lashes and brows. They are there whether or not `enabled` is.
        tuft: Vec<TuftParams> = Vec::new();
        /// Whether hair on guides that moves stays out of the body: a capsule for each joint is fitted to the skin.
        colliders: bool = true;
        /// Capsules of your own: `[[strands.collider]]` with a `name`. They take the place of the one that is fitted to their joint.
        collider: Vec<HairColliderParams> = Vec::new();
    }
}

params! {
    /// `[fins]`: quads of hair on the edges of the mesh, which show where the layers are seen on edge.
    FinParams in fins {
        /// Whether there are fins: less blur and fewer steps of layers along the outline, for a fifth of a frame.
        enabled: bool = false;
        /// Depth of the slab of hair that the fins show, widths of the tile. Left out, it is chosen so that layers and fins together
        /// cover the outline as much finer layers would. More is denser and crisper there.
        depth: Option<f32> = None, in 1e-3..=8.0;
    }
}

params! {
    /// `[detail]`: what is drawn where the fur is small on screen. Sizes are the fur's height on screen, pixels, at the default of a
    /// renderer's `bias`.
    DetailParams in detail {
        /// Whether the package has levels of detail: a chain of fewer layers, and the coat as it looks from afar.
        enabled: bool = true;
        /// Whether it has index lists of fewer triangles too, for models whose triangles are smaller than pixels.
        simplified: bool = true;
        /// Pixels between two layers, seen from the side: fur has as many layers as it is high over this, less is finer and dearer. More
        /// leaves a gap between the outermost layer and the next, which shows as a line around the body.
        gap_px: f32 = 1.15, in 0.05..=64.0;
        /// Share of the size at which a level is drawn in full, at which the next has taken over: 1 switches at once, less goes more
        /// slowly. Between both sizes layers go one after another.
        fade: f32 = 0.5, in 0.1..=1.0;
        /// Height of the fur from which on fins are drawn with the layers: without them the outline is that of fewer and blurred layers.
        fins_px: f32 = 0.0, in 0.0..=1e4;
        /// Height of the fur down to which some layers are drawn; below, the coat takes over. 0 draws layers however small.
        coat_px: f32 = 1.2, in 0.0..=1e4;
    }
}

words! {
    /// Texel format of the shell textures.
    ShellFormat {
        /// BC7: one byte a texel.
        #[default]
        Bc7 = "bc7",
        /// RGBA8: four bytes a texel, exact.
        Rgba8 = "rgba8",
    }
}

words! {
    /// Texel format of the direction textures.
    DirectionFormat {
        /// BC5: one byte a texel.
        #[default]
        Bc5 = "bc5",
        /// RG8: two bytes a texel.
        Rg8 = "rg8",
        /// RGBA8: four bytes a texel, with the confidence in the fourth.
        Rgba8 = "rgba8",
    }
}

words! {
    /// Texel format of base-colour textures.
    BaseColorFormat {
        /// BC7: one byte a texel.
        #[default]
        Bc7 = "bc7",
        /// RGBA8: four bytes a texel, exact.
        Rgba8 = "rgba8",
    }
}

words! {
    /// Effort of the block encoders.
    BcQuality {
        /// For trying things out.
        Fast = "fast",
        /// Balanced.
        #[default]
        Basic = "basic",
        /// For the final bake.
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
        /// Base-colour textures are scaled down until neither side has more texels than this.
        base_color_max: u32 = 1024, in 4..=16_384;
        /// Effort of the block encoders.
        bc_quality: BcQuality = BcQuality::Basic;
    }
}

params! {
    /// `[judge]`: the pictures that a bake with limits (`--max-error`, `--max-frame-ms`, `--max-bytes`) is judged by. Show what the scene shows: a
    /// model that stays small on the screen needs less.
    JudgeParams in judge {
        /// From where: each `"ex,ey,ez/tx,ty,tz/fov_deg"`, metres and degrees, the model at rest. Left empty, two that frame the model, from its
        /// front left and from its back right.
        views: Vec<Viewpoint> = Vec::new();
        /// Width of each picture, pixels.
        width: u32 = 834, in 16..=4096;
        /// Height of each picture, pixels.
        height: u32 = 424, in 16..=4096;
        /// Rays through each pixel of the true pictures. Few leave noise in them, which counts as error of the bake.
        samples: u32 = 64, in 1..=65_536;
    }
}
