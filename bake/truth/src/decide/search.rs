//! Search: chooses the next setting to measure, decides when to stop, and draws conclusions from the measurements.

use super::model::{Model, models};
use super::{Decision, Figure, Judge, Limits, Setting, SettingFigures, SettingSpace, Trial};

/// Minimum gain that justifies a measurement, as a fraction of the objective.
const WORTH: f64 = 0.02;

/// Relative difference below which frame times count as equal, so that the smallest package is chosen. Two measurements
/// of one frame time differ by about 8 %.
const FRAME_TIE: f64 = 0.08;
/// Relative difference below which errors count as equal, so that the smallest package is chosen. A difference of 1 %
/// cannot be seen.
const ERROR_TIE: f64 = 0.01;

/// Minimum relative difference at which times count as different, however narrow their spread.
const LEAST_NOISE: f64 = 0.03;
/// Assumed relative uncertainty of times measured separately. On an idle machine two times of one frame differ by 10 %.
/// If the choice depends on such a difference, the settings are timed again.
const NOISE: f64 = 0.15;
/// Maximum number of candidates timed again at once; the best ones are taken.
const MOST_AGAIN: usize = 6;

/// Searches for the setting that the limits ask for: the fastest if the error is limited, else the most accurate.
/// Returns the best that meets all limits. If none does, returns the nearest to them.
///
/// Fails with the errors of the judge.
pub fn decide<J: Judge>(space: &SettingSpace, limits: &Limits, judge: &mut J) -> Result<Decision, J::Error> {
    let mut search = Search { space, limits, trials: Vec::new(), models: models() };
    search.measure(space.start, judge)?;
    while let Some(setting) = search.next() {
        search.measure(setting, judge)?;
    }
    while let Some(setting) = search.coarser_tile().or_else(|| search.layer_neighbour()) {
        search.measure(setting, judge)?;
    }
    let chosen = search.best();
    // Measures a better and a cheaper neighbour of the choice, to show the user the effect of a small change either
    // way.
    for side in [Side::Better, Side::Cheaper] {
        if search.neighbour(chosen, side).is_none()
            && let Some(setting) = search.predicted_neighbour(chosen, side)
        {
            search.measure(setting, judge)?;
        }
    }
    search.retime(judge)?;
    Ok(search.decision())
}

/// Measures every setting of the space. Slow; a reference for [`decide`].
///
/// Fails with the errors of the judge.
pub fn exhaustive<J: Judge>(space: &SettingSpace, limits: &Limits, judge: &mut J) -> Result<Decision, J::Error> {
    let mut search = Search { space, limits, trials: Vec::new(), models: models() };
    space.settings.iter().try_for_each(|setting| search.measure(*setting, judge))?;
    search.retime(judge)?;
    Ok(search.decision())
}

/// Direction along the Pareto front from one setting to another.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Better,
    Cheaper,
}

struct Search<'a> {
    space: &'a SettingSpace,
    limits: &'a Limits,
    trials: Vec<(Setting, SettingFigures)>,
    models: [Model; 3],
}

impl Search<'_> {
    fn measure<J: Judge>(&mut self, setting: Setting, judge: &mut J) -> Result<(), J::Error> {
        self.trials.push((setting, judge.measure(&setting)?));
        let figures: [fn(&SettingFigures) -> f64; 3] = [|m| m.error, |m| m.frame.ms, |m| m.bytes as f64];
        for (model, figure) in self.models.iter_mut().zip(figures) {
            model.fit(&self.trials, figure);
        }
        Ok(())
    }

    fn predict(&self, setting: &Setting) -> [f64; 3] {
        self.models.each_ref().map(|model| model.predict(setting))
    }

    fn excess(&self, trial: usize) -> f64 {
        self.limits.excess(self.trials[trial].1.figures())
    }

    /// Returns the figure of a trial that the search minimises.
    fn objective(&self, trial: usize) -> f64 {
        self.trials[trial].1.figures()[self.limits.objective() as usize]
    }

    /// Times the candidates and their neighbours again, until the choice depends only on times that were measured in
    /// turns.
    fn retime<J: Judge>(&mut self, judge: &mut J) -> Result<(), J::Error> {
        let mut timed: Vec<usize> = Vec::new();
        loop {
            let chosen = self.best();
            let sides = [Side::Better, Side::Cheaper].map(|side| self.neighbour(chosen, side));
            let mut again = self.contenders();
            again.extend(sides.into_iter().flatten().chain([chosen]));
            again.sort_unstable();
            again.dedup();
            if again.iter().all(|i| timed.contains(i)) {
                return Ok(());
            }
            // The chosen setting is timed in each group, so that times of different groups can be compared.
            again.retain(|i| *i == chosen || !timed.contains(i));
            let settings: Vec<Setting> = again.iter().map(|i| self.trials[*i].0).collect();
            for (i, frame) in again.iter().zip(judge.retime(&settings)?) {
                self.trials[*i].1.frame = frame;
            }
            timed.extend(again);
        }
    }

    /// Returns the trials that could be the best if times are wrong by [`NOISE`], best first.
    fn contenders(&self) -> Vec<usize> {
        let off = |i: usize, by: f64| {
            let mut figures = self.trials[i].1.figures();
            figures[Figure::FrameMs as usize] *= by;
            figures
        };
        let (fast, slow) = (|i: usize| off(i, 1.0 - NOISE), |i: usize| off(i, 1.0 + NOISE));
        let objective = self.limits.objective() as usize;
        let all = || 0..self.trials.len();
        let sure = || all().filter(|i| self.limits.excess(slow(*i)) <= 0.0);
        let least = sure().map(|i| slow(i)[objective]).fold(f64::INFINITY, f64::min);
        let may = |i: &usize| {
            let at_best = fast(*i);
            let beaten = |j: usize| slow(j)[0] <= at_best[0] && slow(j)[1] < at_best[1];
            self.limits.excess(at_best) <= 0.0
                && at_best[objective] <= (1.0 + self.tie()) * least
                && !sure().any(beaten)
        };
        let mut found: Vec<usize> = all().filter(may).collect();
        found.sort_by(|a, b| self.objective(*a).total_cmp(&self.objective(*b)));
        found.truncate(MOST_AGAIN);
        found
    }

    /// Returns the relative difference of the objective below which settings count as equal.
    fn tie(&self) -> f64 {
        if self.limits.objective() == Figure::Error { ERROR_TIE } else { FRAME_TIE }
    }

    /// Returns whether a trial is at least as good as another in error and time, and clearly better in one of them.
    fn beats(&self, i: usize, other: usize) -> bool {
        let (own, other) = (self.trials[i].1, self.trials[other].1);
        let faster = own.frame.high < (1.0 - LEAST_NOISE) * other.frame.low;
        let better = own.error < (1.0 - ERROR_TIE) * other.error;
        faster && own.error <= other.error || better && own.frame.ms <= other.frame.ms
    }

    /// Returns the best trial within the limits, which is on the Pareto front of all trials within the limits. If no
    /// trial is within the limits, returns the nearest to them.
    fn best(&self) -> usize {
        let within: Vec<usize> = (0..self.trials.len()).filter(|i| self.excess(*i) <= 0.0).collect();
        let on_front = |i: &usize| !within.iter().any(|j| self.beats(*j, *i));
        let front: Vec<usize> = within.iter().copied().filter(on_front).collect();
        let least = front.iter().map(|i| self.objective(*i)).fold(f64::INFINITY, f64::min);
        let as_good = |i: &usize| self.objective(*i) <= (1.0 + self.tie()) * least;
        let size = |i: &usize| self.trials[*i].1.bytes;
        let smallest = front.into_iter().filter(as_good).min_by_key(size);
        let nearest = || (0..self.trials.len()).min_by(|a, b| self.excess(*a).total_cmp(&self.excess(*b)));
        smallest.or_else(nearest).unwrap_or_default()
    }

    /// Returns a setting to measure before the best one is chosen: the same layers with the next coarser tile. It takes
    /// the same time and less memory.
    fn coarser_tile(&self) -> Option<Setting> {
        let best = self.trials[self.best()].0;
        let coarser = |s: &&Setting| (s.layers, s.fins) == (best.layers, best.fins) && s.tile_texels < best.tile_texels;
        let next = self.space.settings.iter().filter(coarser).max_by_key(|s| s.tile_texels)?;
        let optimistic = self.models.each_ref().map(|model| model.optimistic(next, true));
        (!self.is_measured(next) && self.limits.excess(optimistic) <= 0.0).then_some(*next)
    }

    /// Returns another setting to measure before the most accurate one is chosen: the next smaller or larger number of
    /// layers, with the same tile. More layers of the same strands blur each other, so more layers need not reduce the
    /// error as the model assumes.
    fn layer_neighbour(&self) -> Option<Setting> {
        if self.limits.objective() != Figure::Error {
            return None;
        }
        let best = self.trials[self.best()].0;
        let of_tile = || self.space.settings.iter().filter(|s| s.differs_only_in_layers(&best));
        let fewer = of_tile().filter(|s| s.layers < best.layers).max_by_key(|s| s.layers);
        let more = of_tile().filter(|s| s.layers > best.layers).min_by_key(|s| s.layers);
        let within = |s: &&&Setting| {
            let mut optimistic = self.models.each_ref().map(|model| model.optimistic(s, true));
            // The error may not follow the model, so it is assumed to be zero and excludes no setting.
            optimistic[Figure::Error as usize] = 0.0;
            self.limits.excess(optimistic) <= 0.0
        };
        [fewer, more].iter().flatten().filter(within).find(|s| !self.is_measured(s)).map(|s| **s)
    }

    fn is_measured(&self, setting: &Setting) -> bool {
        self.trials.iter().any(|(known, _)| known == setting)
    }

    /// Returns whether a measurement with the same tile and fins rules out this setting: the setting breaks a limit or
    /// brings no improvement. Assumes that fewer layers do not reduce the error, and that more reduce neither frame
    /// time nor package size.
    fn is_ruled_out(&self, setting: &Setting) -> bool {
        let beside = |(known, _): &&(Setting, SettingFigures)| known.differs_only_in_layers(setting);
        self.trials.iter().filter(beside).any(|(known, measured)| {
            let broken = |figure: Figure| self.limits.broken(measured).any(|f| f == figure);
            let too_coarse = known.layers >= setting.layers && broken(Figure::Error);
            let too_dear = known.layers <= setting.layers && (broken(Figure::FrameMs) || broken(Figure::Bytes));
            let meets = self.limits.excess(measured.figures()) <= 0.0;
            let no_gain = match self.limits.objective() {
                Figure::Error => meets && known.layers >= setting.layers,
                Figure::FrameMs | Figure::Bytes => meets && known.layers <= setting.layers,
            };
            too_coarse || too_dear || no_gain
        })
    }

    /// Returns the setting to measure next; `None` if none is likely to be worth it.
    fn next(&self) -> Option<Setting> {
        let best = self.best();
        let found = self.excess(best) <= 0.0;
        let objective = self.limits.objective() as usize;
        let promising = |setting: &&Setting| {
            let beside = self.trials.iter().any(|(known, _)| known.differs_only_in_layers(setting));
            let optimistic = self.models.each_ref().map(|model| model.optimistic(setting, beside));
            let gains = !found || optimistic[objective] < (1.0 - WORTH) * self.objective(best);
            gains && self.limits.excess(optimistic) <= 0.0
        };
        // Settings that are predicted to meet the limits come first, ordered by the objective. The others follow,
        // nearest to the limits first.
        let rank = |setting: &Setting| {
            let predicted = self.predict(setting);
            (self.limits.excess(predicted).max(0.0), predicted[objective])
        };
        let order = |a: &&Setting, b: &&Setting| {
            let (a, b) = (rank(a), rank(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        let unmeasured = || self.space.settings.iter().filter(|s| !self.is_measured(s) && !self.is_ruled_out(s));
        let next = unmeasured().filter(promising).min_by(order);
        // The model cannot predict the effect of fins until an animal has been measured both with and without them.
        let here = self.trials[best].0;
        let other = Setting { fins: !here.fins, ..here };
        let unseen = self.trials.iter().all(|(s, _)| s.fins == here.fins) && self.space.settings.contains(&other);
        let next = next.copied().or(unseen.then_some(other));
        if next.is_some() || found {
            return next;
        }
        // No setting is predicted to meet the limits. One that is predicted nearer to them than all measured settings
        // is worth a measurement.
        let nearer = |s: &&Setting| self.limits.excess(self.predict(s)) < (1.0 - WORTH) * self.excess(best);
        unmeasured().filter(nearer).min_by(order).copied()
    }

    /// Returns whether a trial is better than `chosen` on `side`: in error, or in cost.
    fn gains(&self, i: usize, chosen: usize, side: Side) -> bool {
        let (other, own) = (self.trials[i].1, self.trials[chosen].1);
        match side {
            Side::Better => other.error < own.error,
            // A larger package with an equal frame time was rejected on purpose, so it does not count as cheaper.
            Side::Cheaper => other.frame.ms < own.frame.ms && other.bytes <= own.bytes,
        }
    }

    /// Returns whether a trial is further along the Pareto front than `chosen` on `side`: better in one figure, not
    /// better in the other.
    fn is_beyond(&self, i: usize, chosen: usize, side: Side) -> bool {
        let (other, own) = (self.trials[i].1, self.trials[chosen].1);
        let pays = match side {
            // An invisible difference of error is not worth a measurement.
            Side::Better => other.frame.ms >= own.frame.ms && other.error < (1.0 - ERROR_TIE) * own.error,
            Side::Cheaper => other.error >= own.error,
        };
        pays && self.gains(i, chosen, side)
    }

    /// Returns the nearest measured setting further along the Pareto front, on `side` of `chosen`.
    fn neighbour(&self, chosen: usize, side: Side) -> Option<usize> {
        let of = |i: usize| self.trials[i].1;
        let beyond = |i: &usize| self.is_beyond(*i, chosen, side);
        let order = |a: &usize, b: &usize| match side {
            Side::Better => of(*a).frame.ms.total_cmp(&of(*b).frame.ms),
            Side::Cheaper => of(*a).error.total_cmp(&of(*b).error),
        };
        (0..self.trials.len()).filter(beyond).min_by(order)
    }

    /// Returns the nearest setting on `side` of `chosen` that was not measured, according to the model.
    fn predicted_neighbour(&self, chosen: usize, side: Side) -> Option<Setting> {
        let here = self.predict(&self.trials[chosen].0);
        let figure = if side == Side::Better { Figure::Error } else { Figure::FrameMs } as usize;
        let other = if side == Side::Better { Figure::FrameMs } else { Figure::Error } as usize;
        let room = if side == Side::Better { f64::INFINITY } else { here[Figure::Bytes as usize] };
        let beyond = |s: &&Setting| {
            let predicted = self.predict(s);
            let gains = predicted[figure] < (1.0 - WORTH) * here[figure] && predicted[other] >= here[other];
            !self.is_measured(s) && gains && predicted[Figure::Bytes as usize] <= room
        };
        let order = |a: &&Setting, b: &&Setting| self.predict(a)[other].total_cmp(&self.predict(b)[other]);
        self.space.settings.iter().filter(beyond).min_by(order).copied()
    }

    fn decision(self) -> Decision {
        let chosen = self.best();
        let meets = self.excess(chosen) <= 0.0;
        let (next_better, next_cheaper) = (self.neighbour(chosen, Side::Better), self.neighbour(chosen, Side::Cheaper));
        // Among all better settings that only a limit excludes, the nearest to the limits determines the binding limit.
        let side = if self.limits.objective() == Figure::Error { Side::Better } else { Side::Cheaper };
        let kept_out = |i: &usize| self.gains(*i, chosen, side) && self.excess(*i) > 0.0;
        let beyond = (0..self.trials.len()).filter(kept_out).min_by(|a, b| self.excess(*a).total_cmp(&self.excess(*b)));
        let subject = if meets { beyond } else { Some(chosen) };
        let worst = |a: &Figure, b: &Figure| {
            let excess = |f: &Figure| {
                let figures = subject.map_or([0.0; 3], |i| self.trials[i].1.figures());
                self.limits.of(*f).map_or(0.0, |limit| figures[*f as usize] / limit)
            };
            excess(a).total_cmp(&excess(b))
        };
        let binding = subject.and_then(|i| self.limits.broken(&self.trials[i].1).max_by(worst));
        let trials =
            self.trials.iter().map(|(setting, measured)| Trial { setting: *setting, measured: *measured }).collect();
        Decision { trials, chosen, meets, next_better, next_cheaper, binding }
    }
}
