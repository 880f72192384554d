//! Chart of one impact: every method is compared with the closed form. A point of the chart is one method with one
//! value of its parameter. For each point, the bodies first touch at 128 different instants within a time step, called
//! phases.

use super::methods::{MethodParameter, MethodSweep, Values, total, work};
use crate::contact_law::Bodies;
use crate::domain::Domain;
use crate::engine::{Counters, Partner};
use crate::experiment::{Experiment, HardStepping, Model, TimeStep};
use crate::output::{ChartFailure, ChartPoint, ChartQuantity, CostSpread, PointError};
use crate::particles::Particles;
use crate::runs::StudyError;
use crate::scene::{Kind, Meeting, Scene, Species, Surface};
use crate::simulation::{Simulation, soft_step};
use crate::statistics::Estimate;
use crate::study::impact::{meeting, point};
use crate::walls::{Plane, Wall, WallGeometry};
use nalgebra::Vector3;
use std::path::Path;
use std::time::Instant;

/// Number of runs of each point of the chart (a method with one value of its parameter). The runs differ in the phase,
/// the instant within a time step at which the bodies first touch.
pub const PHASES: usize = 128;

/// Number of phases (instants of the first touch within a time step) divided by the number of phases that are run on
/// trial. The wall time of a run with all phases is estimated from the trial.
const TRIAL: usize = 16;

/// One head-on impact of two spheres, or of a sphere on a plane wall.
#[derive(Clone, Debug)]
pub struct HeadOn {
    /// Experiment of the case, with its settings for the engines. Each run replaces the scene by an empty box with the
    /// two bodies.
    pub experiment: Experiment,
    /// Species of the two spheres; `None` in place of the second for a plane wall.
    pub bodies: (Species, Option<Species>),
    /// Properties of the two bodies on which the contact law depends, such as radii and masses.
    pub contact: Bodies,
    /// Surface properties of the contact, such as restitution and friction.
    pub surface: Surface,
    /// [m/s] normal speed at which the bodies approach each other, positive.
    pub approach: f64,
    /// [s] time of straight flight from the start until the two bodies first touch.
    pub touch: f64,
    /// [s] simulated time of one run.
    pub duration: f64,
}

/// Run that failed before its end, or in which the bodies did not separate. It has the reason and the cost of the run.
struct Stopped {
    why: ChartFailure,
    counters: Counters,
    wall: f64,
}

/// Results of one simulated impact of the two bodies.
struct Rebound {
    restitution: f64,
    /// [-] energy that the ledger (sum of all gains and losses) does not explain, divided by the energy at the start.
    residual: f64,
    /// [-] gap between the bodies at the end of the run minus the gap after an instantaneous collision, divided by the
    /// diameter of the smaller sphere.
    displacement: f64,
    counters: Counters,
    wall: f64,
}

impl HeadOn {
    /// Makes the head-on impact of the two bodies of a case, with their normal speed of approach.
    ///
    /// # Errors
    /// Returns an error if the case does not have two bodies, if they do not approach each other, or if the impact does
    /// not end within `run.duration`.
    pub fn of(experiment: &Experiment, particles: &Particles, case: &Path) -> Result<Self, StudyError> {
        let meeting = meeting(&experiment.scene, particles, case)?;
        let first = point(&experiment.scene, particles, &meeting, 0.0);
        let (approach, touch) = (-first.normal_velocity, -first.gap / first.normal_velocity);
        let duration = experiment.run.duration;
        let wrong = |what: &str| {
            Err(StudyError::Input(format!(
                "error: {}: {what}\nhelp: the bodies of an impact start apart and approach, and `run.duration` sees them part again",
                case.display()
            )))
        };
        if approach <= 0.0 || touch < 0.0 {
            return wrong("the bodies do not approach each other from apart");
        }
        let lasts = experiment.soft.law.map_or(0.0, |law| law.contact_time(&law.between(&meeting.bodies), approach));
        if touch + lasts >= duration {
            return wrong("the impact has not ended within `run.duration`");
        }
        let species = |place: usize| {
            let species = &experiment.scene.species[usize::from(particles.species[place])];
            match species.sizes {
                Some(_) => species.of_one_size(2.0 * particles.radius[place]),
                None => species.clone(),
            }
        };
        let bodies = match meeting.partner {
            Partner::Particle(_) => (species(0), Some(species(1))),
            Partner::Wall(_) => (species(0), None),
        };
        let experiment = experiment.clone();
        Ok(Self { experiment, bodies, contact: meeting.bodies, surface: meeting.surface, approach, touch, duration })
    }

    /// Values over which the parameters of the methods are swept; fewer values if `quick` is true.
    pub fn values(quick: bool) -> Values {
        let steps: &[f64] = if quick {
            &[1.5, 5.0, 10.0, 15.0, 20.0, 50.0]
        } else {
            &[1.5, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0, 200.0, 500.0]
        };
        Values {
            steps_per_contact: steps.to_vec(),
            stiffness: vec![1e-4, 1e-2, 0.1, 1.0, 10.0, 100.0],
            theta: vec![0.3, 0.03, 0.01, 3e-3, 1e-3, 3e-4],
            windows: vec![1.0, 0.25, 0.0625],
        }
    }

    /// Quantities in which the methods are compared. Their references are exact closed forms.
    pub fn quantities(&self) -> Vec<ChartQuantity> {
        let of = |key, name, axis, reference| ChartQuantity {
            key,
            name,
            axis,
            reference: Estimate::exact(reference),
            unit: "",
            floor: 0.0,
        };
        let e = self.surface.restitution;
        vec![
            of("restitution_mean", "realised restitution, mean over phases", "|mean e − e₀|/e₀", e),
            of("restitution_single", "realised restitution of a single impact", "rms of (e − e₀)/e₀ over phases", e),
            of("energy", "energy ledger residual", "rms of unexplained energy/energy at the start", 0.0),
            of(
                "displacement",
                "place after the rebound, beside an instant collision",
                "rms displacement/diameter",
                0.0,
            ),
        ]
    }

    fn radii(&self) -> (f64, f64) {
        (0.5 * self.bodies.0.diameter, self.bodies.1.as_ref().map_or(0.0, |other| 0.5 * other.diameter))
    }

    /// [m] diameter of the smaller sphere, by which displacements are divided.
    fn diameter(&self) -> f64 {
        let first = self.bodies.0.diameter;
        self.bodies.1.as_ref().map_or(first, |other| first.min(other.diameter))
    }

    /// Experiment of one method of the chart, at the value `value` (SI unit) of its swept parameter.
    fn run_of(&self, sweep: &MethodSweep, value: f64) -> Experiment {
        let mut experiment = sweep.experiment(&self.experiment, value);
        if let (Some(law), TimeStep::PerContact(steps)) = (experiment.law(), experiment.soft.time_step) {
            // the contact time is that of these two bodies; the case may have further species
            let time = law.contact_time(&law.between(&self.contact), self.approach);
            experiment.soft.time_step = TimeStep::Fixed(time / steps);
        }
        experiment
    }

    /// [s] expected wall time of every point of every method, from a trial with one in sixteen phases. A phase is the
    /// instant of the first touch within a time step.
    pub fn expected(&self, sweeps: &[MethodSweep]) -> Vec<f64> {
        let points = sweeps.iter().flat_map(|sweep| sweep.values.iter().map(move |value| (sweep, *value)));
        let trial = |(sweep, value): (&MethodSweep, f64)| {
            let experiment = self.run_of(sweep, value);
            let clock = Instant::now();
            let ran = (0..PHASES).step_by(TRIAL).all(|k| self.rebound(&experiment, sweep.knob, phase(k)).is_ok());
            clock.elapsed().as_secs_f64() * if ran { TRIAL as f64 } else { 1.0 }
        };
        points.map(trial).collect()
    }

    /// Runs one method at the value `value` (SI unit) of its swept parameter, once for each phase (instant of the first
    /// touch within a time step). `method` is the index of the method in the chart.
    pub fn point(&self, sweep: &MethodSweep, method: usize, value: f64) -> ChartPoint {
        let experiment = self.run_of(sweep, value);
        let phases = (0..PHASES).map(|k| self.rebound(&experiment, sweep.knob, phase(k)));
        let runs: Result<Vec<Rebound>, Stopped> = phases.collect();
        let runs = match runs {
            Ok(runs) => runs,
            Err(Stopped { why, counters, wall }) => {
                let wall = CostSpread { median: wall, lowest: wall, highest: wall };
                let (work, failure) = (work(&counters), Some(why));
                return ChartPoint {
                    method,
                    knob: value,
                    samples: 1,
                    wall,
                    counters,
                    work,
                    errors: Vec::new(),
                    failure,
                };
            }
        };
        let mut counters = Counters::default();
        for run in &runs {
            total(&mut counters, &run.counters);
        }
        let mut times: Vec<f64> = runs.iter().map(|run| run.wall).collect();
        times.sort_by(f64::total_cmp);
        let e = self.surface.restitution;
        // errors are divided by the given restitution, unless it is zero
        let scale = if e > 0.0 { e } else { 1.0 };
        let column = |of: fn(&Rebound) -> f64| -> Vec<f64> { runs.iter().map(of).collect() };
        let restitution = column(|run| run.restitution);
        let errors = vec![
            Some(mean_error(&restitution, e, scale)),
            Some(rms_error(&restitution, e, scale)),
            Some(rms_error(&column(|run| run.residual), 0.0, 1.0)),
            Some(rms_error(&column(|run| run.displacement), 0.0, 1.0)),
        ];
        ChartPoint {
            method,
            knob: value,
            samples: PHASES,
            wall: CostSpread { median: times[PHASES / 2], lowest: times[0], highest: times[PHASES - 1] },
            work: work(&counters) / PHASES as f64,
            counters,
            errors,
            failure: None,
        }
    }

    /// Runs one impact in which the bodies first touch at `phase` [-], a share between 0 and 1 of a time step. If the
    /// run fails, or if the bodies do not separate, the error contains its cost.
    fn rebound(&self, experiment: &Experiment, knob: MethodParameter, phase: f64) -> Result<Rebound, Stopped> {
        let (scene, mut particles) = self.scene();
        let experiment = Experiment { scene, ..experiment.clone() };
        let step = match (experiment.model(), experiment.hard.stepping) {
            (Model::Soft | Model::Hybrid, _) => soft_step(&experiment, particles.len()),
            (Model::Hard, HardStepping::Steps { theta }) => {
                let scene = &experiment.scene;
                let step = crate::engine::hard::SteppedHard::longest_step(theta, &particles, scene, self.duration);
                step.min(self.duration)
            }
            // without time steps, the instant of the first touch varies over a short time
            (Model::Hard, HardStepping::Events) | (Model::Dsmc, _) => 0.01 * self.touch,
        };
        let touch = ((self.touch / step).floor() + phase) * step;
        self.place(&mut particles, touch);
        let (window, windows) = match knob {
            MethodParameter::Window => {
                let window = experiment.run.window.unwrap_or(self.duration);
                (window, (self.duration / window - 1e-9).ceil())
            }
            // a window with a whole number of steps, so that the step has exactly the given length
            _ => ((self.duration / step - 1e-9).ceil() * step, 1.0),
        };
        let mut simulation = Simulation::new(&experiment, particles);
        let at_start = simulation.energy();
        let began = Instant::now();
        let result = simulation.run(windows as u64, window);
        let wall = began.elapsed().as_secs_f64();
        let stopped = |why| Stopped { why, counters: simulation.counters(), wall };
        result.map_err(|why| stopped(ChartFailure::Engine(why)))?;
        let record = &simulation.record;
        let impacts = if self.bodies.1.is_some() { &record.pairs } else { &record.walls };
        let Some(restitution) = impacts.summary().mean_restitution else {
            return Err(stopped(ChartFailure::Unfinished));
        };
        let instant = self.surface.restitution * self.approach * (simulation.time - touch);
        Ok(Rebound {
            restitution,
            residual: record.ledger.residual(at_start, simulation.energy()) / at_start,
            displacement: (self.gap(&simulation) - instant) / self.diameter(),
            counters: simulation.counters(),
            wall,
        })
    }

    /// Empty box with the two bodies on the x axis, far from the sides of the box.
    fn scene(&self) -> (Scene, Particles) {
        let (a, b) = self.radii();
        // distance from the centre of the box that no sphere reaches during a run
        let reach = 4.0 * (a + b) + 2.0 * self.approach * (self.duration + self.touch) * 2.0;
        let size = Vector3::repeat(2.0 * reach);
        let plane = Plane { point: Vector3::zeros(), normal: Vector3::x() };
        let wall =
            Wall { elasticity: self.contact.elasticity[1], ..Wall::new(WallGeometry::Plane(plane), self.surface) };
        let species = std::iter::once(self.bodies.0.clone()).chain(self.bodies.1.clone()).collect();
        let mut scene = Scene {
            walls: if self.bodies.1.is_some() { Vec::new() } else { vec![wall] },
            ..Scene::new(Domain::new(size, [false; 3]), self.surface, species)
        };
        let other = if self.bodies.1.is_some() { Kind::Species(1) } else { Kind::Wall(0) };
        let meeting = Meeting {
            surface: self.surface,
            stiffness_ratio: self.contact.stiffness_ratio,
            at_mass: None,
            resistance: Default::default(),
        };
        scene.pairs.set(0, other, meeting);
        let mut particles = Particles::default();
        let centre = Vector3::repeat(reach);
        let half = Vector3::new(0.5 * self.approach, 0.0, 0.0);
        match &self.bodies.1 {
            Some(other) => {
                let first = &self.bodies.0;
                particles.push(centre, half, a, first.mass(), 0);
                particles.push(centre, -half, b, other.mass(), 1);
            }
            None => particles.push(centre, -2.0 * half, a, self.bodies.0.mass(), 0),
        }
        (scene, particles)
    }

    /// Moves the bodies apart along the x axis, so that they touch after `touch` [s] of straight flight.
    fn place(&self, particles: &mut Particles, touch: f64) {
        let (a, b) = self.radii();
        let apart = a + b + self.approach * touch;
        if self.bodies.1.is_some() {
            particles.position[1].x = particles.position[0].x + apart;
        } else {
            particles.position[0].x = apart;
        }
    }

    /// [m] gap between the surfaces of the two bodies, negative while they overlap.
    fn gap(&self, simulation: &Simulation) -> f64 {
        let (a, b) = self.radii();
        let x = |id: u32| {
            let place = simulation.particles.id.iter().position(|&other| other == id).unwrap_or_default();
            simulation.particles.position[place].x
        };
        if self.bodies.1.is_some() { x(1) - x(0) - a - b } else { x(0) - a }
    }
}

/// [-] instant of the first touch within a time step, as a share of the step, for the run with number `k`. The instants
/// are equally spaced between 0 and 1.
fn phase(k: usize) -> f64 {
    (k as f64 + 0.5) / PHASES as f64
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
}

/// Absolute error of the mean of `values` against `reference`, divided by `scale`. Its standard error is computed as
/// if the phases (instants of the first touch within a time step) were random and independent. For equally spaced
/// phases the true error is far smaller.
fn mean_error(values: &[f64], reference: f64, scale: f64) -> PointError {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let uncertainty = Some((variance / count).sqrt() / scale);
    PointError { value: mean, error: (mean - reference).abs() / scale, uncertainty, range: Some(range(values)) }
}

/// Root mean square deviation of `values` from `reference`, divided by `scale`. Its standard error is computed from the
/// scatter of the squares.
fn rms_error(values: &[f64], reference: f64, scale: f64) -> PointError {
    let count = values.len() as f64;
    let squares: Vec<f64> = values.iter().map(|v| ((v - reference) / scale).powi(2)).collect();
    let mean = squares.iter().sum::<f64>() / count;
    let variance = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let error = mean.sqrt();
    // the errors δ follow from δ(rms²) = 2 rms δ(rms)
    let uncertainty = if error > 0.0 { (variance / count).sqrt() / (2.0 * error) } else { 0.0 };
    let (value, range) = (values.iter().sum::<f64>() / count, Some(range(values)));
    PointError { value, error, uncertainty: Some(uncertainty), range }
}
