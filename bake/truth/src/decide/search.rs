//! The search: which setting to measure next, when to stop, and what the measurements say.

use super::model::{Model, models};
use super::{Decision, Figure, Judge, Limits, Measured, Setting, Space, Trial};

/// A gain of less than this share of the objective is not worth a measurement.
const WORTH: f64 = 0.02;

/// Settings whose frame or whose error is this little above the least count as equal, and the smallest package wins: two measurements of one frame
/// are apart by about as much, and a difference of error that small is not seen.
const FRAME_TIE: f64 = 0.08;
const ERROR_TIE: f64 = 0.01;

/// Times that differ by less than this share are not told apart, however narrow their spread is.
const LEAST_NOISE: f64 = 0.03;
/// So far a time of a setting that was measured by itself may be off, as a share: settings of which this decides are timed again. On a machine that does
/// nothing else two times of one frame are apart by a tenth.
const NOISE: f64 = 0.15;
/// So many are timed again at once: the likeliest.
const MOST_AGAIN: usize = 6;

/// Looks for the setting that the limits ask for: the cheapest frame where the error is limited, else the least error. Returns the best that
/// meets all limits, or the nearest to them where none does.
///
/// # Errors
///
/// Those of the judge.
pub fn decide<J: Judge>(space: &Space, limits: &Limits, judge: &mut J) -> Result<Decision, J::Error> {
    let mut search = Search { space, limits, trials: Vec::new(), models: models() };
    search.measure(space.start, judge)?;
    while let Some(setting) = search.next() {
        search.measure(setting, judge)?;
    }
    while let Some(setting) = search.smaller().or_else(|| search.beside()) {
        search.measure(setting, judge)?;
    }
    let chosen = search.best();
    // Evidence on both sides of the choice, so that the user sees what a little more and a little less would be.
    for side in [Side::Better, Side::Cheaper] {
        if search.neighbour(chosen, side).is_none()
            && let Some(setting) = search.predicted_neighbour(chosen, side)
        {
            search.measure(setting, judge)?;
        }
    }
    search.time_again(judge)?;
    Ok(search.decision())
}

/// Measures every setting of the space: slow, and what [`decide`] can be held against.
///
/// # Errors
///
/// Those of the judge.
pub fn exhaustive<J: Judge>(space: &Space, limits: &Limits, judge: &mut J) -> Result<Decision, J::Error> {
    let mut search = Search { space, limits, trials: Vec::new(), models: models() };
    space.settings.iter().try_for_each(|setting| search.measure(*setting, judge))?;
    search.time_again(judge)?;
    Ok(search.decision())
}

/// On which side of a setting another one lies.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Better,
    Cheaper,
}

struct Search<'a> {
    space: &'a Space,
    limits: &'a Limits,
    trials: Vec<(Setting, Measured)>,
    models: [Model; 3],
}

impl Search<'_> {
    fn measure<J: Judge>(&mut self, setting: Setting, judge: &mut J) -> Result<(), J::Error> {
        self.trials.push((setting, judge.measure(&setting)?));
        let figures: [fn(&Measured) -> f64; 3] = [|m| m.error, |m| m.frame.ms, |m| m.bytes as f64];
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

    /// What is minimised, of a trial.
    fn objective(&self, trial: usize) -> f64 {
        self.trials[trial].1.figures()[self.limits.objective() as usize]
    }

    /// Times what may be chosen again, and its neighbours, until the choice rests on such times alone.
    fn time_again<J: Judge>(&mut self, judge: &mut J) -> Result<(), J::Error> {
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
            // The chosen one comes along, so that times of different turns have something in common.
            again.retain(|i| *i == chosen || !timed.contains(i));
            let settings: Vec<Setting> = again.iter().map(|i| self.trials[*i].0).collect();
            for (i, frame) in again.iter().zip(judge.time_again(&settings)?) {
                self.trials[*i].1.frame = frame;
            }
            timed.extend(again);
        }
    }

    /// The trials that may turn out to be the best if times are off by [`NOISE`], the likeliest first.
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

    /// Share of the objective within which settings count as equal.
    fn tie(&self) -> f64 {
        if self.limits.objective() == Figure::Error { ERROR_TIE } else { FRAME_TIE }
    }

    /// Whether a trial is better than another in error and time, in one of the two beyond doubt.
    fn beats(&self, i: usize, other: usize) -> bool {
        let (own, other) = (self.trials[i].1, self.trials[other].1);
        let faster = own.frame.high < (1.0 - LEAST_NOISE) * other.frame.low;
        let better = own.error < (1.0 - ERROR_TIE) * other.error;
        faster && own.error <= other.error || better && own.frame.ms <= other.frame.ms
    }

    /// The best trial that meets the limits and is on the front of those that do, or the nearest to the limits.
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

    /// What the best one is to be held against before it is chosen: as many layers of the next coarser tile, which take as long and less memory.
    fn smaller(&self) -> Option<Setting> {
        let best = self.trials[self.best()].0;
        let coarser = |s: &&Setting| (s.layers, s.fins) == (best.layers, best.fins) && s.tile_texels < best.tile_texels;
        let next = self.space.settings.iter().filter(coarser).max_by_key(|s| s.tile_texels)?;
        let optimistic = self.models.each_ref().map(|model| model.optimistic(next, true));
        (!self.is_measured(next) && self.limits.excess(optimistic) <= 0.0).then_some(*next)
    }

    /// What the truest one is also held against: the next fewer and the next more layers of its tile. More layers of the same strands blur each other, so
    /// that the error need not fall with their number, as the model has it.
    fn beside(&self) -> Option<Setting> {
        if self.limits.objective() != Figure::Error {
            return None;
        }
        let best = self.trials[self.best()].0;
        let of_tile = || self.space.settings.iter().filter(|s| s.is_beside(&best));
        let fewer = of_tile().filter(|s| s.layers < best.layers).max_by_key(|s| s.layers);
        let more = of_tile().filter(|s| s.layers > best.layers).min_by_key(|s| s.layers);
        let within = |s: &&&Setting| {
            let mut optimistic = self.models.each_ref().map(|model| model.optimistic(s, true));
            // How wrong it is, is the question.
            optimistic[Figure::Error as usize] = 0.0;
            self.limits.excess(optimistic) <= 0.0
        };
        [fewer, more].iter().flatten().filter(within).find(|s| !self.is_measured(s)).map(|s| **s)
    }

    fn is_measured(&self, setting: &Setting) -> bool {
        self.trials.iter().any(|(known, _)| known == setting)
    }

    /// Whether a measurement of the same tile and fins shows that this setting breaks a limit, or is no gain: with fewer layers the error is no
    /// smaller, with more the frame is no shorter and the package no smaller.
    fn is_ruled_out(&self, setting: &Setting) -> bool {
        let beside = |(known, _): &&(Setting, Measured)| known.is_beside(setting);
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

    /// The setting to measure next; `None` when none is likely to be worth it.
    fn next(&self) -> Option<Setting> {
        let best = self.best();
        let found = self.excess(best) <= 0.0;
        let objective = self.limits.objective() as usize;
        let promising = |setting: &&Setting| {
            let beside = self.trials.iter().any(|(known, _)| known.is_beside(setting));
            let optimistic = self.models.each_ref().map(|model| model.optimistic(setting, beside));
            let gains = !found || optimistic[objective] < (1.0 - WORTH) * self.objective(best);
            gains && self.limits.excess(optimistic) <= 0.0
        };
        // First what should meet the limits, the best of it first; then what comes nearest to them.
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
        // What fins do to an animal, the model cannot know before it has seen it with and without.
        let here = self.trials[best].0;
        let other = Setting { fins: !here.fins, ..here };
        let unseen = self.trials.iter().all(|(s, _)| s.fins == here.fins) && self.space.settings.contains(&other);
        let next = next.copied().or(unseen.then_some(other));
        if next.is_some() || found {
            return next;
        }
        // Nothing seems to meet the limits. The nearest is to be named, so what seems nearer than all that was measured is worth a look.
        let nearer = |s: &&Setting| self.limits.excess(self.predict(s)) < (1.0 - WORTH) * self.excess(best);
        unmeasured().filter(nearer).min_by(order).copied()
    }

    /// Whether one trial has more of what that side is about than another.
    fn gains(&self, i: usize, chosen: usize, side: Side) -> bool {
        let (other, own) = (self.trials[i].1, self.trials[chosen].1);
        match side {
            Side::Better => other.error < own.error,
            // What takes as long and is larger was left out on purpose.
            Side::Cheaper => other.frame.ms < own.frame.ms && other.bytes <= own.bytes,
        }
    }

    /// Whether one trial lies on that side of another along the front: what it gains on one side, it pays for on the other.
    fn is_beyond(&self, i: usize, chosen: usize, side: Side) -> bool {
        let (other, own) = (self.trials[i].1, self.trials[chosen].1);
        let pays = match side {
            // Nor is a difference that nobody sees worth a look.
            Side::Better => other.frame.ms >= own.frame.ms && other.error < (1.0 - ERROR_TIE) * own.error,
            Side::Cheaper => other.error >= own.error,
        };
        pays && self.gains(i, chosen, side)
    }

    /// The nearest measured setting on one side of `chosen` that nothing measured beats.
    fn neighbour(&self, chosen: usize, side: Side) -> Option<usize> {
        let of = |i: usize| self.trials[i].1;
        let beyond = |i: &usize| self.is_beyond(*i, chosen, side);
        let order = |a: &usize, b: &usize| match side {
            Side::Better => of(*a).frame.ms.total_cmp(&of(*b).frame.ms),
            Side::Cheaper => of(*a).error.total_cmp(&of(*b).error),
        };
        (0..self.trials.len()).filter(beyond).min_by(order)
    }

    /// The same among those that were not measured, as the model sees them.
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
        // The nearest of those that would have been chosen but for a limit.
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
