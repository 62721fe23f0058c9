//! Guided hair: `[[strands.group]]` and `[[strands.tuft]]`.

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
    /// Hair that follows guides. Keys left out have their defaults.
    HairGroupParams of "a group of hair" {
        /// Name of the materials that it grows on, its scalp; `*` matches any characters, `?` one.
        material: String = "*".into(), in ();
        /// Density relative to the densest part of the scalp: a number, the vertex colours or an image. No hair grows
        /// where it is below 0.01.
        mask: ScalarMap = ScalarMap::Constant(1.0), in SHARE;
        /// Strand file whose strands become guides, relative to the recipe's folder. Formats: .hair (Cem Yuksel), .tfx
        /// (TressFX), .txt (lines of x y z, strands separated by blank lines), .usda (USD as text: BasisCurves,
        /// converted to metres, y up), .glb and .gltf (lines; those that share vertices form one strand). Bad strands
        /// are left out with a warning. Hair then grows only where the scalp has guides nearby. Default: guides are
        /// generated.
        file: FilePath, in ();
        /// Length of one unit of the strand file, metres.
        scale_m: f32 = 1.0, in 1e-6..=1e6;
        /// Rotation of the strand file about x, then y, then z, degrees.
        turn_deg: [f32; 3] = [0.0; 3], in -360.0..=360.0;
        /// Position of the strand file's origin, metres.
        at: [f32; 3] = [0.0; 3], in PLACE;
        /// Maximum distance from the scalp to the root of a strand of the file, metres. Strands farther away are
        /// ignored; the lower ends of the others are bent to the scalp. Default: a tenth of the model's radius.
        loose_m: f32, in 0.0..=1e6;
        /// Interval between strands of the file that become guides: 1 uses all strands, 2 every second.
        every: u32 = 1, in 1..=1_000_000;
        /// Number of generated guides; unused with `file`.
        guides: u32 = 300, in 1..=20_000;
        /// Number of hairs that follow the guides; with 0, the guides themselves are the hairs.
        hairs: u32 = 20_000, in 0..=4_000_000;
        /// Number of points of each hair, preferably one more than a power of two.
        points: u32 = 17, in 2..=65;
        /// Number of points of each guide; hairs are smooth curves through them. Default: 8; 29 for `curly`.
        guide_points: u32, in 2..=65;
        /// Length of generated guides, metres. Default: a sixth of the model's radius.
        length_m: f32, in LENGTH;
        /// Shape of generated guides: `straight` and `wet` hang down, `curly` hangs in helices, `messy` hangs in waves,
        /// `lying` follows the mesh surface.
        style: Style = Style::Straight, in ();
        /// Direction in which generated guides hang, at rest.
        fall: [f32; 3] = [0.0, -1.0, 0.0], in PLACE;
        /// Comb direction at the roots, at rest. Only its component along the mesh surface counts; `[0, 0, 0]` means
        /// none.
        comb: [f32; 3] = [0.0; 3], in PLACE;
        /// Parting: x of a plane, metres, from which hair is combed to both sides. Default: none.
        parting_m: f32, in PLACE;
        /// Steepness of combed hair at the root: 0 lies along the mesh surface, 1 rises at 45 degrees.
        rise: f32 = 0.5, in 0.0..=10.0;
        /// Distance from the root over which hair keeps its direction, as a share of its length.
        stiffness: f32 = 0.08, in 0.001..=10.0;
        /// Maximum height of `lying` hair above the mesh surface, as a share of its length.
        lift: f32 = 0.06, in 0.0..=1.0;
        /// Radius from the root to the middle, metres.
        root_radius_m: f32 = 5e-5, in RADIUS;
        /// Radius at the tip, metres. Default: a third of the radius at the root.
        tip_radius_m: f32, in 0.0..=0.1;
        /// Colour at the root, independent of the colour of the mesh surface.
        root_color: SrgbColor = SrgbColor::hex(0x3a_2a_1c), in ();
        /// Colour at the tip.
        tip_color: SrgbColor = SrgbColor::hex(0x6b_4a_2f), in ();
        /// Variation in brightness between single hairs.
        color_variation: f32 = 0.2, in SHARE;
        /// Variation in length: the shortest hair is shorter than the longest by this share.
        length_variation: f32 = 0.15, in 0.0..=0.95;
        /// Clumping of the hairs of a lock towards their tips: 0 none, 1 full.
        clump: f32 = 0.5, in SHARE;
        /// Number of hairs in a lock.
        lock_hairs: u32 = 60, in 1..=1_000_000;
        /// Sideways offset of the tips of stray hairs, as a share of their length.
        stray: f32 = 0.1, in SHARE;
        /// Share of the hair, from the root, that is fixed to the mesh surface. With 1, the hair has no motion of its
        /// own.
        held: f32 = GroupMotion::default().held, in SHARE;
        /// Share of the hair, from the root, beyond which hair moves freely; at least `held`.
        free: f32 = GroupMotion::default().free, in SHARE;
        /// Factor on the freedom of motion given by `held` and `free`, at the hair's root: a number, the vertex colours
        /// or an image. Where it is 0, hair is fixed to the mesh surface.
        freedom: ScalarMap = ScalarMap::Constant(1.0), in SHARE;
        /// Air drag: rate at which hair adopts the velocity of the air, 1/s.
        drag_per_s: f32 = GroupMotion::default().drag_per_s, in GroupMotion::DRAG_PER_S;
        /// Frequency at which hair swings back to its groomed position, Hz. With 0, it hangs.
        swing_hz: f32 = GroupMotion::default().shape_hz, in GroupMotion::HZ;
        /// Frequency at which segments bend back to their groomed shape, Hz. With 0, hair is limp.
        bend_hz: f32 = GroupMotion::default().bend_hz, in GroupMotion::HZ;
        /// Friction on the body: share of the tangential speed lost in 1/120 s of contact.
        friction: f32 = GroupMotion::default().friction, in SHARE;
        /// Random seed.
        seed: u32 = 1, in 0..=4_000_000_000;
    }
}

named_table! {
    /// Small group of thick hairs at one point, such as whiskers, lashes and brows. Keys left out have their defaults.
    TuftParams of "a tuft" {
        /// Centre of the tuft, metres in world space at rest. With `joint`, it is an offset from the joint along the
        /// world's axes, by default [0, 0, 0]. The tuft grows at the nearest point of the mesh surface. `at` or `joint`
        /// is required.
        at: [f32; 3], in PLACE;
        /// Name of a joint or another node of the model. The tuft grows at the point of the mesh surface nearest to
        /// that node at rest. Default: none.
        joint: String, in ();
        /// Name of the materials that it may grow on; `*` matches any characters, `?` one. Default: all.
        material: String, in ();
        /// Whether there is a second tuft, mirrored in x.
        mirrored: bool = false, in ();
        /// Number of hairs.
        hairs: u32 = 12, in 1..=10_000;
        /// Maximum distance of a root from the centre, metres.
        spread_m: f32 = 0.005, in 0.0..=100.0;
        /// Length, metres.
        length_m: f32 = 0.05, in LENGTH;
        /// Direction added to the unit surface normal; its length is its weight relative to the normal.
        direction: [f32; 3] = [0.0; 3], in PLACE;
        /// Sag of the tips, as a share of the length.
        bend: f32 = 0.15, in -1.0..=1.0;
        /// Fanning out of the hairs from the centre: 0 none, 1 full.
        fan: f32 = 0.3, in SHARE;
        /// Radius at the root, metres.
        root_radius_m: f32 = 3e-4, in RADIUS;
        /// Radius at the tip, metres. Default: a sixth of the radius at the root.
        tip_radius_m: f32, in 0.0..=0.1;
        /// Colour at the root.
        root_color: SrgbColor = SrgbColor::hex(0xe8_e0_d4), in ();
        /// Colour at the tip.
        tip_color: SrgbColor = SrgbColor::hex(0xf4_ef_e8), in ();
        /// Number of points of each hair.
        points: u32 = 9, in 2..=65;
        /// Variation in length: the shortest hair is shorter than the longest by this share.
        length_variation: f32 = 0.4, in 0.0..=0.95;
        /// Random seed.
        seed: u32 = 1, in 0..=4_000_000_000;
    }
}

named_table! {
    /// Capsule that guided hair cannot enter; replaces the capsule fitted to its joint.
    HairColliderParams of "a collider" checked by check_capsule {
        /// Name of the joint that the capsule follows. Required, unless the model has no skeleton.
        joint: String, in ();
        /// First end of the capsule's axis, metres in world space at rest.
        from: [f32; 3], in PLACE;
        /// Second end of the capsule's axis, metres in world space at rest. Default: `from`, which makes a sphere.
        to: [f32; 3], in PLACE;
        /// Radius, metres.
        radius_m: f32, in 1e-6..=1e4;
    }
}

fn check_capsule(collider: &HairColliderParams) -> Result<(), String> {
    match (collider.from, collider.radius_m) {
        (None, _) => Err("found no `from`, expected a position, [x, y, z] in metres".into()),
        (_, None) => Err("found no `radius_m`, expected metres".into()),
        _ => Ok(()),
    }
}
