//! Body parts, and the groom of each.

/// Part of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Region {
    Muzzle,
    Face,
    Ear,
    Mane,
    Tail,
    Wing,
    Foot,
    LowerLeg,
    UpperLeg,
    /// Leg or arm whose name does not distinguish upper from lower. `regions::of_nodes` uses the parent to resolve it.
    Limb,
    Shoulder,
    Neck,
    Head,
    Chest,
    Belly,
    Torso,
    /// Part whose name is not known.
    Unknown,
}

/// Groom of a body part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PartGroom {
    /// Length relative to the back.
    pub length: f32,
    /// Extra lean, 0..=1: short hair lies flat on legs and face.
    pub lean: f32,
    /// Hairs per area relative to the back: shorter hair is finer and denser.
    pub density: f32,
    /// Influence of the thickness, 0..=1. It is above 0 for parts with thick and thin regions.
    pub by_thickness: f32,
}

impl Region {
    /// All parts that `regions::of_nodes` returns.
    pub(super) const ALL: [Self; 16] = [
        Self::Muzzle,
        Self::Face,
        Self::Ear,
        Self::Mane,
        Self::Tail,
        Self::Wing,
        Self::Foot,
        Self::LowerLeg,
        Self::UpperLeg,
        Self::Shoulder,
        Self::Neck,
        Self::Head,
        Self::Chest,
        Self::Belly,
        Self::Torso,
        Self::Unknown,
    ];

    /// Returns the groom of the part. The values are common to photographs of dogs, wolves, horses, cattle, foxes and
    /// cats.
    pub(super) fn groom(self) -> PartGroom {
        let grows = |length, lean, density, by_thickness| PartGroom { length, lean, density, by_thickness };
        match self {
            Self::Muzzle => grows(0.2, 0.5, 2.0, 0.0),
            Self::Face => grows(0.3, 0.4, 1.5, 0.0),
            Self::Ear => grows(0.35, 0.4, 1.6, 0.0),
            Self::Mane | Self::Neck => grows(1.3, 0.0, 1.0, 0.0),
            Self::Tail => grows(1.1, 0.1, 1.0, 0.0),
            Self::Wing => grows(0.5, 0.4, 1.2, 0.0),
            Self::Foot => grows(0.25, 0.5, 1.6, 0.0),
            Self::LowerLeg => grows(0.35, 0.4, 1.4, 0.0),
            Self::UpperLeg | Self::Limb => grows(0.7, 0.15, 1.1, 0.0),
            Self::Shoulder => grows(0.85, 0.1, 1.0, 0.0),
            Self::Head => grows(0.4, 0.35, 1.3, 0.7),
            Self::Chest | Self::Belly => grows(1.1, 0.0, 1.0, 0.0),
            Self::Torso => grows(1.0, 0.0, 1.0, 0.0),
            Self::Unknown => grows(1.0, 0.0, 1.0, 1.0),
        }
    }

    /// Whether the part identifies a location on an animal; a root named "body" alone does not.
    pub(super) fn is_specific(self) -> bool {
        !matches!(self, Self::Unknown | Self::Torso)
    }

    /// Whether the part has a back and an underside.
    pub(super) fn is_trunk(self) -> bool {
        matches!(self, Self::Chest | Self::Belly | Self::Torso)
    }
}
