//! Hair that is no coat: `[[strands.group]]` and `[[strands.tuft]]`.

use super::maps::{FilePath, ScalarMap};
use super::material_groom::SHARE;
use super::named_table::named_table;
use super::style::Style;
use pelage_formats::GroupMotion;
use pelage_params::{Range, SrgbColor};

/// Range of coordinates, metres.
const PLACE: Range<f32> = -1e6..=1e6;
/// Range of lengths, metres.
const LENGTH: Range<f32> = 1e-4..=100.0;
/// Range of radii, metres.
const RADIUS: Range<f32> = 1e-6..=0.1;

named_table! {
    /// Hair that follows guides. A key that is left out has its default, or what stands in brackets.
    HairGroupParams of "a group of hair" {
        /// Name of the materials that it grows on, its scalp; `*` stands for any characters, `?` for one.
        material: String = "*".into(), in ();
        /// How dense it is there, over where it is densest: a number, the vertex colours or an image. Where it is less than 0.01 nothing grows.
        mask: ScalarMap = ScalarMap::Constant(1.0), in SHARE;
        /// Strands to take as guides, from the recipe's folder: .hair (Cem Yuksel), .tfx (TressFX), .txt (lines of x y z), or .glb and .gltf (lines, those that
        /// share vertices being one strand). Hair then grows where the scalp has some near. Without, guides grow.
        file: FilePath, in ();
        /// What a length of 1 in that file is, metres.
        scale_m: f32 = 1.0, in 1e-6..=1e6;
        /// By how many degrees the file is turned about x, then y, then z.
        turn_deg: [f32; 3] = [0.0; 3], in -360.0..=360.0;
        /// Where the file's origin is, metres.
        at: [f32; 3] = [0.0; 3], in PLACE;
        /// How far from the scalp a strand of the file may root to be a guide, metres: its beginning is led there (a tenth of the model's radius).
        loose_m: f32, in 0.0..=1e6;
        /// Every how many strands of the file is a guide.
        every: u32 = 1, in 1..=1_000_000;
        /// Guides that grow where there is no file.
        guides: u32 = 300, in 1..=20_000;
        /// Hairs that follow them; 0 takes the guides for the hairs.
        hairs: u32 = 20_000, in 0..=4_000_000;
        /// Points of each hair: one more than a power of two suits best.
        points: u32 = 17, in 2..=65;
        /// Points of each guide, of which hairs are smooth curves (8; 29 where it is curly).
        guide_points: u32, in 2..=65;
        /// Length of the guides that grow, metres (a sixth of the model's radius).
        length_m: f32, in LENGTH;
        /// How guides grow: `straight` and `wet` fall, `curly` falls in helices, `messy` falls in waves, `lying` follows the skin.
        style: Style = Style::Straight, in ();
        /// Where they fall to: a direction at rest.
        fall: [f32; 3] = [0.0, -1.0, 0.0], in PLACE;
        /// How they are combed where they leave the skin: a direction at rest, of which the part along the skin counts; `[0, 0, 0]`: none.
        comb: [f32; 3] = [0.0; 3], in PLACE;
        /// Where hair parts: x of a plane, metres, from which it is combed to both sides (none).
        parting_m: f32, in PLACE;
        /// How steeply hair leaves the skin where it is combed: 1 as much up as along.
        rise: f32 = 0.5, in 0.0..=10.0;
        /// How long hair keeps the way it leaves the skin in, over its length.
        stiffness: f32 = 0.08, in 0.001..=10.0;
        /// How far from the skin hair lies at most, over its length.
        lift: f32 = 0.06, in 0.0..=1.0;
        /// Radius from the root to the middle, metres.
        root_radius_m: f32 = 5e-5, in RADIUS;
        /// Radius at the tip, metres (a third of that at the root).
        tip_radius_m: f32, in 0.0..=0.1;
        /// Colour at the root; the skin's does not matter.
        root_color: SrgbColor = SrgbColor::hex(0x3a_2a_1c), in ();
        /// Colour at the tip.
        tip_color: SrgbColor = SrgbColor::hex(0x6b_4a_2f), in ();
        /// How much brighter or darker single hairs are.
        color_variation: f32 = 0.2, in SHARE;
        /// Share of the length that the shortest hair lacks.
        length_variation: f32 = 0.15, in 0.0..=0.95;
        /// How much hairs of a lock come together at their tips.
        clump: f32 = 0.5, in SHARE;
        /// Hairs of a lock.
        lock_hairs: u32 = 60, in 1..=1_000_000;
        /// How far the tips of stray hairs are aside, over their length.
        stray: f32 = 0.1, in SHARE;
        /// Share of the hair from its root on that the skin holds; 1: it does not move of itself.
        held: f32 = GroupMotion::default().held, in SHARE;
        /// Share of the hair from its root on beyond which it moves freely, not below `held`.
        free: f32 = GroupMotion::default().free, in SHARE;
        /// How freely it moves, times what `held` and `free` say, by where it roots: a number, the vertex colours or an image; 0: it goes with the skin.
        freedom: ScalarMap = ScalarMap::Constant(1.0), in SHARE;
        /// How fast the air takes it along, and stops it where it is still, 1/s.
        drag_per_s: f32 = GroupMotion::default().drag_per_s, in GroupMotion::DRAG_PER_S;
        /// How often a second it swings back to where it was groomed; 0: it hangs.
        swing_hz: f32 = GroupMotion::default().shape_hz, in GroupMotion::HZ;
        /// How often a second its pieces swing back to the shape that they were groomed in; 0: it is limp.
        bend_hz: f32 = GroupMotion::default().bend_hz, in GroupMotion::HZ;
        /// Share of its speed along the body that it loses in 1/120 s where it touches.
        friction: f32 = GroupMotion::default().friction, in SHARE;
        /// Another number is another chance.
        seed: u32 = 1, in 0..=4_000_000_000;
    }
}

named_table! {
    /// A few thick hairs at a place: whiskers, lashes, brows. A key that is left out has its default, or what stands in brackets.
    TuftParams of "a tuft" {
        /// Middle of it, near the skin, metres in world space at rest; beside `joint` from there on, along the axes of the world ([0, 0, 0] there). It stands
        /// where the skin is nearest. Either of both must be given.
        at: [f32; 3], in PLACE;
        /// Name of a joint or another node of the model: the tuft stands where the skin is nearest to that at rest (none).
        joint: String, in ();
        /// Name of the materials that it may stand on; `*` stands for any characters, `?` for one (all).
        material: String, in ();
        /// Whether the same stands on the other side, x turned about.
        mirrored: bool = false, in ();
        /// Hairs of it.
        hairs: u32 = 12, in 1..=10_000;
        /// How far from the middle they root, metres.
        spread_m: f32 = 0.005, in 0.0..=100.0;
        /// Length, metres.
        length_m: f32 = 0.05, in LENGTH;
        /// Which way they go, as much as away from the skin.
        direction: [f32; 3] = [0.0; 3], in PLACE;
        /// How far their tips hang down, over their length.
        bend: f32 = 0.15, in -1.0..=1.0;
        /// How far they fan out.
        fan: f32 = 0.3, in SHARE;
        /// Radius at the root, metres.
        root_radius_m: f32 = 3e-4, in RADIUS;
        /// Radius at the tip, metres (a sixth of that at the root).
        tip_radius_m: f32, in 0.0..=0.1;
        /// Colour at the root.
        root_color: SrgbColor = SrgbColor::hex(0xe8_e0_d4), in ();
        /// Colour at the tip.
        tip_color: SrgbColor = SrgbColor::hex(0xf4_ef_e8), in ();
        /// Points of each hair.
        points: u32 = 9, in 2..=65;
        /// Share of the length that the shortest hair lacks.
        length_variation: f32 = 0.4, in 0.0..=0.95;
        /// Another number is another chance.
        seed: u32 = 1, in 0..=4_000_000_000;
    }
}

named_table! {
    /// A capsule that hair on guides stays out of, in place of what is fitted to its joint.
    HairColliderParams of "a collider" checked by is_body {
        /// Name of the joint that it goes with (none: of a model without skeleton).
        joint: String, in ();
        /// One end of its axis, metres in world space at rest.
        from: [f32; 3], in PLACE;
        /// The other end; a ball has one only (`from`).
        to: [f32; 3], in PLACE;
        /// Its radius, metres.
        radius_m: f32, in 1e-6..=1e4;
    }
}

fn is_body(collider: &HairColliderParams) -> Result<(), String> {
    match (collider.from, collider.radius_m) {
        (None, _) => Err("found no from, expected a place, [x, y, z] in metres".into()),
        (_, None) => Err("found no radius_m, expected metres".into()),
        _ => Ok(()),
    }
}
