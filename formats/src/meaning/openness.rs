//! Openness: the directions in which the body does not hide the surroundings from its hair. Ears, legs and belly hide
//! part of the sky; convex surfaces are open to more than a hemisphere.

use glam::Vec3;

/// Directions in which the body at rest does not hide the surroundings from the hair tips at a surface point. On a bare
/// surface, the surface itself takes the place of the tips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Openness {
    /// Share of all directions that is open, 0..=1; 0.5 above a plane.
    pub share: f32,
    /// Tangential components, along u and v of the tile, of the unit vector towards the centre of the open directions;
    /// length at most 1. The centre is never below the surface's horizon.
    pub tangential: [f32; 2],
}

impl Default for Openness {
    /// Returns the openness of a plane.
    fn default() -> Self {
        Self { share: 0.5, tangential: [0.0; 2] }
    }
}

impl Openness {
    /// Returns the four bytes stored in a package: share as unorm, the two tangential components as snorm, 0.
    pub fn to_bytes(self) -> [u8; 4] {
        let share = (self.share.clamp(0.0, 1.0) * 255.0).round() as u8;
        // Round towards 0, so that the stored vector is never longer than 1.
        let [u, v] = self.tangential.map(|x| (x.clamp(-1.0, 1.0) * 127.0) as i8 as u8);
        [share, u, v, 0]
    }

    /// Decodes four bytes of a package.
    pub fn from_bytes([share, u, v, _]: [u8; 4]) -> Self {
        Self { share: f32::from(share) / 255.0, tangential: [u, v].map(|x| (f32::from(x as i8) / 127.0).max(-1.0)) }
    }

    /// Returns the vector towards the centre of the open directions, whose length is the open share. Its components are
    /// along u and v of the tile and along the surface normal.
    pub fn vector(self) -> Vec3 {
        let [u, v] = self.tangential;
        self.share * Vec3::new(u, v, (1.0 - u * u - v * v).max(0.0).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn openness_survives_encoding_to_bytes() {
        for (share, aside) in [(0.0, [0.0, 0.0]), (1.0, [0.6, -0.8]), (0.3, [-0.25, 0.9]), (0.7, [1.0, 0.0])] {
            let bytes = Openness { share, tangential: aside }.to_bytes();
            let back = Openness::from_bytes(bytes);
            assert_eq!(back.to_bytes(), bytes);
            let off = (back.share - share).abs().max((back.tangential[0] - aside[0]).abs());
            assert!(off.max((back.tangential[1] - aside[1]).abs()) < 0.01, "{back:?}");
            assert!(back.tangential.iter().map(|x| x * x).sum::<f32>() <= 1.0, "{back:?}");
            assert!((back.vector().length() - back.share).abs() < 1e-5, "{back:?}");
        }
        assert_eq!(Openness::default().to_bytes(), [128, 0, 0, 0]);
    }
}
