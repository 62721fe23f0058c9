//! Systems of the main world: clip look-up and playback, and bounding boxes of animals.

use crate::components::{ClipLookup, Pelage, PelageClip};
use crate::model::PelageModel;
use bevy_asset::prelude::AssetChanged;
use bevy_asset::{AssetId, Assets};
use bevy_ecs::prelude::*;
use bevy_log::warn;
use bevy_time::Time;
use pelage_stage::wrap_time;
use std::collections::HashSet;

/// Inserts the bounding box of each animal's model when the model is loaded or replaced.
pub(crate) fn insert_bounding_boxes(
    mut commands: Commands,
    animals: Query<(Entity, &Pelage), Or<(Changed<Pelage>, AssetChanged<Pelage>)>>,
    models: Res<Assets<PelageModel>>,
) {
    for (entity, pelage) in &animals {
        if let Some(model) = models.get(&pelage.model) {
            commands.entity(entity).insert(model.bounds());
        }
    }
}

/// Looks up clips by name when the name or the model has changed.
pub(crate) fn find_clips(
    mut clips: Query<
        (&Pelage, &PelageClip, &mut ClipLookup),
        Or<(Changed<PelageClip>, Changed<Pelage>, AssetChanged<Pelage>)>,
    >,
    models: Res<Assets<PelageModel>>,
    mut missing: Local<HashSet<(AssetId<PelageModel>, String)>>,
) {
    for (pelage, clip, mut place) in &mut clips {
        let Some(model) = models.get(&pelage.model) else {
            place.found = None;
            continue;
        };
        let found = model.clip(&clip.name);
        if let Err(has) = &found
            && missing.insert((pelage.model.id(), clip.name.clone()))
        {
            warn!("PelageClip::name is {:?}: no such clip; {} {has}", clip.name, model.name());
        }
        place.found = found.ok();
    }
}

pub(crate) fn play_clips(mut clips: Query<(&mut PelageClip, &ClipLookup)>, time: Res<Time>) {
    for (mut clip, place) in &mut clips {
        let Some((_, duration_s)) = place.found else { continue };
        let time_s = time_after(&clip, time.delta_secs(), duration_s);
        // Bypasses change detection, which signals changes by the application.
        clip.bypass_change_detection().time_s = time_s;
    }
}

fn time_after(clip: &PelageClip, passed_s: f32, duration_s: f32) -> f32 {
    let time_s = if clip.paused { clip.time_s } else { clip.time_s + clip.speed * passed_s };
    match clip.looped {
        _ if !time_s.is_finite() => 0.0,
        true => wrap_time(time_s, duration_s),
        false => time_s.clamp(0.0, duration_s.max(0.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_loop_hold_and_pause_at_any_speed() {
        let clip = |time_s, speed| PelageClip { time_s, speed, ..PelageClip::new("Walk") };
        assert!((time_after(&clip(0.9, 1.0), 0.2, 1.0) - 0.1).abs() < 1e-6, "the clip loops");
        assert!((time_after(&clip(0.1, -1.0), 0.2, 1.0) - 0.9).abs() < 1e-6, "it also loops backwards");
        let held = PelageClip { looped: false, ..clip(0.9, 1.0) };
        assert_eq!(time_after(&held, 0.2, 1.0), 1.0);
        let paused = PelageClip { paused: true, ..clip(0.4, 1.0) };
        assert_eq!(time_after(&paused, 0.2, 1.0), 0.4);
        assert_eq!(time_after(&clip(f32::NAN, 1.0), 0.2, 1.0), 0.0);
        assert_eq!(time_after(&clip(0.0, f32::INFINITY), 0.2, 1.0), 0.0);
        assert_eq!(time_after(&clip(0.4, 1.0), 0.2, 0.0), 0.6, "the time of a clip without duration is not wrapped");
    }
}
