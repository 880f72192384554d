//! Scene of the lab while it runs: both panels (simulations side by side), and the times of the latest frame (picture
//! on the page) and of the latest comparison.

use super::frame::{DrawnParticle, Head, Now, PanelComparison, bytes};
use super::panel::LabPanel;
use super::scene_state::SceneState;
use crate::clock::Clock;
use crate::outcome::Outcome;
use crate::statistics::{Batches, U, UU, VV, WW};
use crate::study::judge;
use std::time::Duration;

/// Wall time from one frame (picture on the page) to the next.
const FRAME: Duration = Duration::from_millis(33);

/// Largest wall time since the previous frame (picture on the page) that is converted to simulated time for the next
/// frame. If a pause is longer, the rest of it is left out.
const LATEST: Duration = Duration::from_millis(100);

/// Wall time from one comparison of the panels to the next.
const VERDICT: Duration = Duration::from_millis(1500);

/// [-] margin of equivalence (largest accepted relative difference) of the comparison. In the scene `channel`, no
/// difference is larger than 5.5 % at the end (20 s), according to `diptych compare` with the case that the page saves.
/// The answer is therefore "equivalent" at 10 %. At 1 %, the default of `compare`, it would be "unresolved".
const MARGIN: f64 = 0.1;

/// Largest wall time that one panel may compute for one frame (picture on the page). A panel that needs longer shows
/// the simulated time that it has reached.
const BUDGET: Duration = Duration::from_millis(14);

/// Panels (simulations side by side) of an opened scene while they run, with the times of the latest frame (picture on
/// the page) and of the latest comparison.
pub struct StageRun<'a> {
    stage: &'a SceneState,
    /// The left and the right panel.
    pub panels: [LabPanel<'a>; 2],
    clock: Clock,
    /// Wall time at which the latest frame (data for the page) was made, measured by `clock`.
    shown: Duration,
    /// Latest comparison of the panels, which is sent in the next frame (data for the page). `None` if there is none,
    /// or if the page has already got it.
    pub judged: Option<PanelComparison>,
    /// Wall time of the latest comparison of the panels, measured by `clock`.
    judged_at: Duration,
}

impl<'a> StageRun<'a> {
    /// Creates both panels in the initial state of the scene.
    pub fn new(stage: &'a SceneState) -> Self {
        let frame = stage.pace() * FRAME.as_secs_f64();
        let panel =
            |side: usize| LabPanel::new(&stage.experiments[side], stage.starts[side].clone(), stage.scene.gauge, frame);
        let clock = Clock::wall();
        let now = clock.now();
        Self { stage, panels: [panel(0), panel(1)], clock, shown: now, judged: None, judged_at: now }
    }

    /// True if the time for the next frame (picture on the page) has come.
    pub fn is_due(&self) -> bool {
        self.clock.now() >= self.shown + FRAME
    }

    /// Wall time until the next frame (picture on the page) is due; at least 1 ms.
    pub fn until_next_frame(&self) -> Duration {
        // at least 1 ms, so that the sessions of other pages can get the lock of the engine
        (self.shown + FRAME).saturating_sub(self.clock.now()).max(Duration::from_millis(1))
    }

    /// [s] simulated time by which the panels advance for the next frame (picture on the page): wall time since the
    /// previous frame, times the pace (simulated time divided by wall time). `factor` [-] multiplies the default pace
    /// of the scene. If `single` is true, the usual time from one frame to the next takes the place of the wall time
    /// that has passed.
    pub fn stretch(&self, factor: f64, single: bool) -> f64 {
        let passed = if single { FRAME } else { (self.clock.now() - self.shown).min(LATEST) };
        self.stage.pace() * factor * passed.as_secs_f64()
    }

    /// Advances both panels to the same simulated time: the time of the running panel that is behind the other, plus
    /// `stretch` [s]. A panel computes for at most 14 ms of wall time, and may then stay behind. Then the panels are
    /// compared if the latest comparison is more than 1.5 s of wall time ago.
    pub fn go_on(&mut self, stretch: f64) {
        let times = self.panels.iter().filter_map(LabPanel::running);
        let until = times.fold(f64::INFINITY, f64::min) + stretch;
        self.panels.iter_mut().for_each(|panel| panel.run(until, BUDGET));
        let now = self.clock.now();
        if now - self.judged_at > VERDICT {
            self.judge();
            self.judged_at = self.clock.now();
        }
    }

    /// Compares the results of both panels so far. Nothing is compared at the start, and in scenes whose panels do not
    /// measure averages.
    pub fn judge(&mut self) {
        let [Some(left), Some(right)] = [self.panels[0].outcome(), self.panels[1].outcome()] else { return };
        let outcomes = [left, right];
        self.judged = judge(&outcomes, &[], MARGIN).into_iter().next().map(|verdict| {
            let answer = serde_json::to_value(verdict.answer).ok();
            let answer = answer.as_ref().and_then(serde_json::Value::as_str).unwrap_or_default().to_owned();
            let from = outcomes[0].steadiness.from;
            PanelComparison {
                answer,
                sentence: verdict.sentence,
                from,
                profiles: [profile(&outcomes[0]), profile(&outcomes[1])],
            }
        });
    }

    /// Frame of the present state, as bytes: the data from which the page draws both panels. A new comparison is part
    /// of the first frame after the comparison only.
    pub fn frame(&mut self) -> Vec<u8> {
        self.shown = self.clock.now();
        let sides: Vec<Now> = self.panels.iter_mut().map(LabPanel::now).collect();
        let particles: Vec<Vec<DrawnParticle>> = self.panels.iter().map(LabPanel::particles).collect();
        let counts = particles.iter().map(Vec::len).collect();
        bytes(&Head { serial: self.stage.choice.serial, counts, sides: &sides, judged: self.judged.take() }, &particles)
    }
}

/// Profile of a channel for the page, with one row for each slice (layer of the box normal to y). A row has the height
/// y [mm], the streamwise velocity and its standard error [m/s], and the granular temperature and its standard error
/// [m²/s²]. Unknown values are `None`.
fn profile(outcome: &Outcome) -> Vec<[Option<f64>; 5]> {
    let table = &outcome.profiles;
    let rows = table.slices.iter().enumerate().map(|(slice, row)| {
        let normal: Option<Vec<f64>> = [UU, VV, WW].into_iter().map(|one| Some(row.of(one)?.value)).collect();
        let temperature = normal.map(|normal| normal.iter().sum::<f64>() / 3.0);
        // the moments uu, vv and ww of one run are correlated, so their averages over each interval of time are added
        // before the error is computed
        let parts: Option<Vec<_>> =
            [UU, VV, WW].into_iter().map(|one| Some((1.0 / 3.0, table.batches(slice, one)?))).collect();
        let blocks = parts.and_then(|parts| Batches::sum(&parts)).and_then(|blocks| blocks.estimate());
        let mean = row.of(U);
        [
            Some(1e3 * row.y),
            mean.map(|mean| mean.value),
            mean.and_then(|mean| mean.error),
            temperature,
            blocks.and_then(|blocks| blocks.error),
        ]
    });
    rows.collect()
}
