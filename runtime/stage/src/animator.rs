//! Clip playback of a character that an application moves.

use crate::cast::Playback;
use pelage_formats::ClipLayer;
use pelage_runtime::Motion;

/// Plays a clip and cross-fades to others. Independent of models: keep one per character. Call [`Animator::play`] for
/// each new clip, and [`Animator::advance`] as time passes. Set the result of [`Animator::motion`] on the character's
/// instance.
///
/// A clip requested during a fade starts from the current blended pose, so that the motion is continuous.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animator {
    /// Layers in order of request, the latest last. Earlier layers have weight until the latest has faded in
    /// completely.
    layers: Vec<Layer>,
}

#[derive(Clone, Debug, PartialEq)]
struct Layer {
    /// Clip that the layer plays; `None` for the rest pose.
    playing: Option<Playback>,
    /// Seconds since the request.
    time_s: f32,
    /// Duration of the fade-in, seconds.
    fade_s: f32,
}

impl Layer {
    /// Returns the weight of the layer, 0..=1, eased at both ends so that limbs neither start nor stop abruptly.
    fn share(&self) -> f32 {
        if self.time_s >= self.fade_s {
            return 1.0;
        }
        let t = self.time_s / self.fade_s;
        t * t * (3.0 - 2.0 * t)
    }
}

impl Animator {
    /// Creates an animator at rest.
    pub fn new() -> Self {
        Self::default()
    }

    /// Fades to a clip, or to the rest pose with `None`, within `fade_s` seconds. 0, negative values and NaN switch
    /// immediately. The clip begins at its `start_s`.
    pub fn play(&mut self, playing: Option<Playback>, fade_s: f32) {
        let fade_s = if fade_s.is_nan() { 0.0 } else { fade_s.max(0.0) };
        self.layers.push(Layer { playing, time_s: 0.0, fade_s });
        self.tidy();
    }

    /// Advances time by `seconds`. Negative, NaN and infinite values are ignored.
    pub fn advance(&mut self, seconds: f32) {
        if seconds > 0.0 && seconds.is_finite() {
            self.layers.iter_mut().for_each(|layer| layer.time_s += seconds);
            self.tidy();
        }
    }

    /// Returns the latest requested clip; `None` for the rest pose.
    pub fn playing(&self) -> Option<&Playback> {
        self.layers.last().and_then(|layer| layer.playing.as_ref())
    }

    /// Returns whether a fade to another clip is in progress.
    pub fn is_fading(&self) -> bool {
        self.layers.last().is_some_and(|layer| layer.share() < 1.0)
    }

    /// Returns whether a clip that does not loop has faded in completely and reached its end.
    pub fn is_over(&self) -> bool {
        let Some(layer) = self.layers.last() else { return false };
        let at_end = |playing: &Playback| !playing.looped && playing.moment(layer.time_s) >= playing.duration_s;
        !self.is_fading() && layer.playing.as_ref().is_some_and(at_end)
    }

    /// Returns the current pose.
    pub fn motion(&self) -> Motion {
        let layer = |layer: &Layer| match &layer.playing {
            Some(playing) => playing.layer(layer.time_s, layer.share()),
            None => ClipLayer { clip: None, time_s: 0.0, share: layer.share() },
        };
        motion(self.layers.iter().map(layer).collect())
    }

    /// Drops layers without weight. Drops the oldest layers if there are more than a pose can have.
    fn tidy(&mut self) {
        let whole = self.layers.iter().rposition(|layer| layer.share() >= 1.0).unwrap_or(0);
        let most = self.layers.len().saturating_sub(Motion::MAX_LAYERS);
        self.layers.drain(..whole.max(most));
    }
}

/// Converts layers of a pose to the runtime's motion.
pub(crate) fn motion(layers: Vec<ClipLayer>) -> Motion {
    match layers[..] {
        [] => Motion::Rest,
        [ClipLayer { clip, time_s, share }] if share >= 1.0 => {
            clip.map_or(Motion::Rest, |clip| Motion::Clip { clip, time_s })
        }
        _ => Motion::Blend(layers),
    }
}

/// Returns the layers of the pose that a motion stands for.
pub(crate) fn layers(motion: &Motion) -> Vec<ClipLayer> {
    match motion {
        Motion::Clip { clip, time_s } => vec![ClipLayer { clip: Some(*clip), time_s: *time_s, share: 1.0 }],
        Motion::Blend(layers) => layers.clone(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALK: Playback = Playback { clip: 0, duration_s: 1.0, start_s: 0.0, speed: 1.0, looped: true };
    const RUN: Playback = Playback { clip: 1, duration_s: 0.5, start_s: 0.1, speed: 2.0, looped: true };
    const LAND: Playback = Playback { clip: 2, duration_s: 0.4, start_s: 0.0, speed: 1.0, looped: false };

    fn layers(animator: &Animator) -> Vec<ClipLayer> {
        match animator.motion() {
            Motion::Blend(layers) => layers,
            other => panic!("found {other:?}, expected a blend"),
        }
    }

    #[test]
    fn single_clip_plays_and_no_clip_rests() {
        let mut animator = Animator::new();
        assert_eq!(animator.motion(), Motion::Rest);
        animator.play(Some(WALK), 0.0);
        animator.advance(1.25);
        assert_eq!(animator.motion(), Motion::Clip { clip: 0, time_s: 0.25 });
        animator.play(Some(RUN), 0.0);
        assert_eq!(animator.motion(), Motion::Clip { clip: 1, time_s: 0.1 });
    }

    #[test]
    fn cross_fade_lasts_its_time_while_both_clips_play() {
        let mut animator = Animator::new();
        animator.play(Some(WALK), 0.0);
        animator.play(Some(RUN), 0.4);
        assert!(animator.is_fading() && animator.playing() == Some(&RUN));
        animator.advance(0.2);
        let [walk, run] = layers(&animator)[..] else { panic!("{animator:?}") };
        assert_eq!((walk.clip, walk.time_s, walk.share), (Some(0), 0.2, 1.0));
        assert_eq!((run.clip, run.share), (Some(1), 0.5));
        assert!((run.time_s - 0.5).abs() < 1e-6, "0.1 + 2 * 0.2: {run:?}");
        animator.advance(0.2);
        assert!(!animator.is_fading());
        assert!(matches!(animator.motion(), Motion::Clip { clip: 1, .. }), "the finished fade must drop the walk");
    }

    #[test]
    fn third_clip_fades_in_from_the_unfinished_cross_fade() {
        let mut animator = Animator::new();
        animator.play(Some(WALK), 0.0);
        animator.play(Some(RUN), 0.4);
        animator.advance(0.1);
        let before = layers(&animator);
        animator.play(Some(LAND), 0.3);
        let after = layers(&animator);
        assert_eq!((&after[..2], after[2].share), (&before[..], 0.0), "the pose must not jump");
        animator.advance(0.3);
        assert_eq!(animator.motion(), Motion::Clip { clip: 2, time_s: 0.3 });
        assert!(!animator.is_over());
        animator.advance(0.2);
        assert!(animator.is_over());
        animator.play(None, 0.2);
        animator.advance(0.2);
        assert!(animator.motion() == Motion::Rest && !animator.is_over());
    }

    #[test]
    fn invalid_and_hasty_cross_fades_stay_finite() {
        let mut animator = Animator::new();
        for seconds in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            animator.play(Some(WALK), seconds);
            animator.advance(seconds);
        }
        for _ in 0..100 {
            animator.play(Some(RUN), 1.0);
            animator.advance(0.001);
        }
        let layers = layers(&animator);
        assert!(layers.len() <= Motion::MAX_LAYERS);
        assert!(
            layers.iter().all(|layer| layer.time_s.is_finite() && (0.0..=1.0).contains(&layer.share)),
            "{layers:?}"
        );
    }
}
