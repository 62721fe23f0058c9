//! Parts of a body, and how hair grows on each.

/// A part of a body.
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
    /// A leg or an arm, of which the name does not say the height: `regions::of_nodes` says it by what it hangs on.
    Limb,
    Shoulder,
    Neck,
    Head,
    Chest,
    Belly,
    Torso,
    /// No name says it.
    Unknown,
}

/// How hair grows on a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Growth {
    /// Length over that on the back.
    pub length: f32,
    /// Extra lean, 0..=1: short hair lies along legs and face.
    pub lean: f32,
    /// Hairs per area over those on the back: the shorter the finer and the denser.
    pub density: f32,
    /// How much of it is left to thickness, 0..=1: within a part that is thick and thin.
    pub by_thickness: f32,
}

impl Region {
    /// All that `regions::of_nodes` gives.
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

    /// Shares read off photographs of dogs, wolves, horses, cattle, foxes and cats in their own coats: what those agree in.
    pub(super) fn growth(self) -> Growth {
        let grows = |length, lean, density, by_thickness| Growth { length, lean, density, by_thickness };
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

    /// Whether it tells where on an animal one is; a root called "body" alone does not.
    pub(super) fn tells(self) -> bool {
        !matches!(self, Self::Unknown | Self::Torso)
    }

    /// Whether it has a back and an underside.
    pub(super) fn is_trunk(self) -> bool {
        matches!(self, Self::Chest | Self::Belly | Self::Torso)
    }
}
