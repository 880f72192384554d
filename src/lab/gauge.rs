//! Quantities that a scene of the lab measures at the end of every window (time between two exchanges of momentum with
//! the gas), and the graphs of these quantities.

use crate::contact_law::Bodies;
use crate::encounter::{Couple, FrameTime, Other};
use crate::experiment::Experiment;
use crate::observe::Observer;
use crate::particles::Particles;
use crate::predict::closed_form::{Bouncing, Cooling};
use crate::predict::contact::ContactTimes;
use crate::scene::Scene;
use crate::simulation::Simulation;
use serde::Serialize;

/// Number of intervals of time from which a theoretical curve is drawn.
const POINTS: usize = 200;

/// Set of quantities that a scene of the lab measures and draws as graphs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gauge {
    /// Overlap, relative velocity and contact forces of two spheres.
    Impact,
    /// Velocity of each sphere along x, the direction of a row of spheres.
    Speeds,
    /// Height of one sphere above the floor, and the number of its impacts on the floor.
    Bounces,
    /// Granular temperature of a gas, divided by its initial value, and mean number of collisions of a sphere since the
    /// start.
    Gas,
    /// Energy of a gas divided by its initial energy; it should be constant.
    Energy,
    /// Energy of a gas divided by its initial energy, on a logarithmic axis; it should be constant.
    Explosion,
    /// Mean velocity and granular temperature of particles in a channel. The page also shows profiles over the height,
    /// for both of its panels (simulations side by side).
    Channel,
    /// Largest overlap, number of impacts, and kinetic energy of a column of spheres on a floor.
    Column,
    /// Velocity of one ball along the wall below it, radius times spin of the ball, and slip (velocity of its lowest
    /// point along the wall).
    Spin,
    /// Height of the first ball of a heap above the floor, and radius times spin of the second ball.
    Heap,
    /// Mean number of collisions of a sphere in a gas since the start, and share of the collisions that are missed
    /// because they begin and end within a time step.
    Missed,
}

/// Graph of measured quantities as functions of time or of another measured quantity. A measured row has one value for
/// each quantity; the graph names a quantity by its index (column) in the row.
#[derive(Clone, Debug, Serialize)]
pub struct Graph {
    /// Title of the graph.
    pub title: &'static str,
    /// Index (column) of the quantity on the horizontal axis, and the label of this axis.
    pub x: (usize, &'static str),
    /// Label of the vertical axis.
    pub y: &'static str,
    /// Indices (columns) of the quantities on the vertical axis.
    pub columns: Vec<usize>,
    /// True if the vertical axis is logarithmic.
    pub logarithmic: bool,
    /// Lower and upper end of the horizontal axis, in the unit of this axis; `None` if the axis covers the whole run.
    pub window: Option<[f64; 2]>,
    /// True if negative overlaps, which are gaps, are drawn only down to a small part of the largest overlap.
    pub short_gaps: bool,
    /// Name and points of a theoretical curve, in the units of the axes; `None` if there is no theory.
    pub theory: Option<(&'static str, Vec<[f64; 2]>)>,
}

impl Graph {
    /// Creates a graph on linear axes, without theory.
    pub fn new(title: &'static str, x: (usize, &'static str), y: &'static str, columns: Vec<usize>) -> Self {
        Self { title, x, y, columns, logarithmic: false, window: None, short_gaps: false, theory: None }
    }

    fn with(self, name: &'static str, points: Option<Vec<[f64; 2]>>) -> Self {
        Self { theory: points.map(|points| (name, points)), ..self }
    }
}

/// Points of a theoretical curve over time, from 0 to the duration of the experiment. The function `at` returns the
/// value of the curve at a time [s]; times at which it returns `None` are left out. On the horizontal axis are the
/// times divided by `unit` [s].
fn curve(experiment: &Experiment, unit: f64, at: impl Fn(f64) -> Option<f64>) -> Vec<[f64; 2]> {
    let times = (0..=POINTS).map(|k| experiment.run.duration * k as f64 / POINTS as f64);
    times.filter_map(|time| Some([time / unit, at(time)?])).collect()
}

impl Gauge {
    /// Graphs of the quantities of this set, with theoretical curves for the `experiment` and its particles at the
    /// `start`.
    pub fn graphs(self, experiment: &Experiment, start: &Particles) -> Vec<Graph> {
        const MICRO: (usize, &str) = (0, "time [µs]");
        const MILLI: (usize, &str) = (0, "time [ms]");
        const SECONDS: (usize, &str) = (0, "time [s]");
        match self {
            Self::Impact => vec![
                Graph { short_gaps: true, ..Graph::new("Overlap over time", MICRO, "overlap δ [µm]", vec![1]) },
                Graph {
                    short_gaps: true,
                    ..Graph::new("Force over overlap: the loop", (1, "overlap δ [µm]"), "force [mN]", vec![5])
                },
                Graph::new("Relative velocity over time", MICRO, "normal velocity [m/s]", vec![2]),
            ],
            Self::Speeds => {
                let graph = |title| Graph::new(title, MICRO, "velocity [m/s]", (1..=start.len()).collect());
                let blow = Graph { window: blow(experiment, start), ..graph("The same around the blow") };
                vec![graph("Velocity of each sphere"), blow]
            }
            Self::Bounces => {
                let path = Bouncing::of(experiment, [start.position[0], start.velocity[0]]);
                let radius = start.radius[0];
                let points = path.map(|path| curve(experiment, 1e-3, |t| Some(1e3 * (path.at(t)?[0].norm() - radius))));
                vec![
                    Graph::new("Height over the floor", MILLI, "height [mm]", vec![1]).with("closed form", points),
                    Graph::new("Times that it has met the floor", MILLI, "impacts", vec![2]),
                ]
            }
            Self::Gas => {
                let at_start = temperature(start);
                let haff = Cooling::of(experiment, start.len(), at_start);
                let points = haff.map(|haff| curve(experiment, 1e-3, |t| Some(haff.temperature(t) / at_start)));
                vec![
                    Graph::new("Temperature", MILLI, "T/T₀", vec![1]).with("Haff", points),
                    Graph::new("Collisions suffered by a sphere", MILLI, "collisions", vec![2]),
                ]
            }
            Self::Energy => vec![Graph::new("Energy", MILLI, "energy over that of the start", vec![1])],
            Self::Explosion => {
                vec![Graph {
                    logarithmic: true,
                    ..Graph::new("Energy", MILLI, "energy over that of the start", vec![1])
                }]
            }
            Self::Channel => vec![
                Graph::new("Mean velocity of the particles", SECONDS, "velocity [m/s]", vec![1]),
                Graph::new("Granular temperature", SECONDS, "T [m²/s²]", vec![2]),
            ],
            Self::Column => {
                let mut overlap = Graph::new("Deepest overlap", MILLI, "overlap/diameter [%]", vec![1]);
                overlap = overlap.with("weight of all over k", statics(experiment, start));
                vec![
                    overlap,
                    Graph::new("Impacts that have ended", MILLI, "impacts", vec![2]),
                    Graph::new("Kinetic energy", MILLI, "energy [nJ]", vec![3]),
                ]
            }
            Self::Spin => vec![
                Graph::new("Velocity along the wall", MILLI, "velocity [m/s]", vec![1]),
                Graph::new("Radius times spin, positive if it rolls forward", MILLI, "R ω [m/s]", vec![2]),
                Graph::new("Slip of the point of contact", MILLI, "slip [m/s]", vec![3]),
            ],
            Self::Heap => vec![
                Graph::new("Height of the top ball over the floor", MILLI, "height [mm]", vec![1]),
                Graph::new("Radius times spin of the left ball", MILLI, "R ω [m/s]", vec![2]),
            ],
            Self::Missed => vec![
                Graph::new("Collisions suffered by a sphere", MILLI, "collisions", vec![1]),
                Graph::new("Collisions that were missed, of all that should have been", MILLI, "share [%]", vec![2]),
            ],
        }
    }

    /// True if each impact in the scene is between two bodies alone, so that its restitution can be measured. If a
    /// sphere presses on several others at once, the restitution of a single impact is not defined.
    pub fn has_lone_impacts(self) -> bool {
        !matches!(self, Self::Speeds | Self::Column | Self::Heap)
    }

    /// True if a run is long enough to compare the costs of the models. The wall time of a single impact is too short
    /// to be measured reliably.
    pub fn tells_cost(self) -> bool {
        !matches!(self, Self::Impact | Self::Speeds | Self::Spin)
    }

    /// Quantities of this set at one instant: a row with one value for each column that the graphs show, in the unit of
    /// the column. In the sets `Gas`, `Energy` and `Explosion`, temperature or energy is divided by `at_start`, the
    /// granular temperature [m²/s²] or energy [J] at the start.
    fn row(self, simulation: &Simulation, at_start: f64) -> Vec<f64> {
        let (particles, time) = (&simulation.particles, simulation.time);
        let suffered = 2.0 * simulation.record.pairs.count as f64 / particles.len().max(1) as f64;
        match self {
            Self::Impact => Vec::new(),
            Self::Speeds => {
                let mut row = vec![0.0; particles.len() + 1];
                row[0] = 1e6 * time;
                particles.id.iter().zip(&particles.velocity).for_each(|(id, v)| row[*id as usize + 1] = v.x);
                row
            }
            Self::Bounces => {
                let height = particles.position[0].y - particles.radius[0];
                vec![1e3 * time, 1e3 * height, simulation.record.walls.count as f64]
            }
            Self::Gas => vec![1e3 * time, temperature(particles) / at_start, suffered],
            Self::Energy | Self::Explosion => vec![1e3 * time, simulation.energy() / at_start],
            Self::Channel => {
                let mean = particles.velocity.iter().map(|v| v.z).sum::<f64>() / particles.len().max(1) as f64;
                vec![time, mean, temperature(particles)]
            }
            Self::Column => {
                let deepest = simulation.overlaps().into_iter().fold(0.0, f64::max);
                let impacts = simulation.record.pairs.count + simulation.record.walls.count;
                let diameter = 2.0 * particles.radius[0];
                vec![1e3 * time, 1e2 * deepest / diameter, impacts as f64, 1e9 * particles.kinetic_energy()]
            }
            Self::Spin => {
                let (velocity, surface) = (particles.velocity[0].x, -particles.radius[0] * particles.spin_of(0).z);
                vec![1e3 * time, velocity, surface, velocity - surface]
            }
            Self::Heap => {
                let place = |ball: u32| particles.id.iter().position(|id| *id == ball).unwrap_or(0);
                let (top, left) = (place(0), place(1));
                let height = particles.position[top].y - particles.radius[top];
                vec![1e3 * time, 1e3 * height, particles.radius[left] * particles.spin_of(left).z]
            }
            Self::Missed => {
                let missed = simulation.counters().missed_collisions as f64;
                let all = missed + simulation.record.pairs.count as f64;
                vec![1e3 * time, suffered, if all > 0.0 { 1e2 * missed / all } else { 0.0 }]
            }
        }
    }

    /// Initial value by which measured temperatures or energies are divided: the granular temperature [m²/s²] for the
    /// set `Gas`, else the energy [J].
    fn scale(self, simulation: &Simulation) -> f64 {
        match self {
            Self::Gas => temperature(&simulation.particles),
            _ => simulation.energy(),
        }
    }
}

/// Interval of time [µs] around the first touch of the first two spheres of a row. It begins one contact time before
/// this touch. It ends one contact time per sphere of the row after the touch, about the end of all contacts. The
/// second sphere is assumed to rest. `None` without a contact law, or if the first sphere does not fly towards the
/// second.
fn blow(experiment: &Experiment, start: &Particles) -> Option<[f64; 2]> {
    let contact_time = ContactTimes::of(experiment, &experiment.law()?, start.len()).governing()?;
    let [gap, closing] =
        [start.position[1].x - start.position[0].x - start.radius[0] - start.radius[1], start.velocity[0].x];
    let touch = gap / closing;
    let ends = [touch - contact_time, touch + start.len() as f64 * contact_time];
    (closing > 0.0).then(|| ends.map(|time| 1e6 * time))
}

/// Theoretical overlap of the floor and the lowest of n spheres that rest on one another, as a curve of two points: at
/// the start and at the end of the run. A point has a time [ms] and the overlap in per cent of the diameter. For a
/// linear spring the overlap is n m g/k, with the mass m of a sphere and the stiffness k. `None` without a contact law
/// or a floor.
fn statics(experiment: &Experiment, start: &Particles) -> Option<Vec<[f64; 2]>> {
    let law = experiment.law()?;
    let wall = experiment.scene.walls.first().map(|_| 0)?;
    let weight = start.mass.iter().sum::<f64>() * experiment.scene.gravity.norm();
    let spring = law.between(&Bodies::at_wall(&experiment.scene, start, 0, wall));
    let share = 1e2 * law.static_overlap(&spring, weight) / (2.0 * start.radius[0]);
    Some(vec![[0.0, share], [1e3 * experiment.run.duration, share]])
}

/// [m²/s²] granular temperature: a third of the mean square of the velocities relative to the mean velocity; 0 without
/// particles.
fn temperature(particles: &Particles) -> f64 {
    let count = particles.len().max(1) as f64;
    let mean = particles.velocity.iter().sum::<nalgebra::Vector3<f64>>() / count;
    particles.velocity.iter().map(|v| (v - mean).norm_squared()).sum::<f64>() / (3.0 * count)
}

/// Observer that measures the quantities of a set (gauge) while a panel of the page runs.
pub struct Meter<'a> {
    /// Set of quantities that are measured.
    pub gauge: Gauge,
    experiment: &'a Experiment,
    at_start: Option<f64>,
    /// Rows measured since the previous frame (data of one instant sent to the page). A row has one value for each
    /// column of the graphs, in the unit of this column.
    pub rows: Vec<Vec<f64>>,
}

impl<'a> Meter<'a> {
    /// Creates an observer for the quantities of the set `gauge`, with no measured rows.
    pub fn new(gauge: Gauge, experiment: &'a Experiment) -> Self {
        Self { gauge, experiment, at_start: None, rows: Vec::new() }
    }

    /// Row of the set `Impact`, for the first two spheres: time [µs], overlap δ [µm], normal velocity [m/s], and spring
    /// force, dashpot force and their sum [mN]. The forces are computed from the contact law at this instant; without
    /// an overlap they are 0.
    fn meeting(&self, simulation: &Simulation) -> Vec<f64> {
        let (particles, scene) = (&simulation.particles, simulation.scene());
        let met = Couple { i: 0, other: Other::Particle(1) }.meet(particles, scene, FrameTime::default());
        let (overlap, velocity) = (met.overlap(), met.normal_velocity);
        let (spring, dashpot) = match self.experiment.law().filter(|_| overlap > 0.0) {
            Some(law) => law.force(&law.between(&pair(scene, particles)), overlap, velocity),
            None => (0.0, 0.0),
        };
        vec![1e6 * simulation.time, 1e6 * overlap, velocity, 1e3 * spring, 1e3 * dashpot, 1e3 * (spring + dashpot)]
    }
}

/// First two spheres of the scene, with the properties on which a contact law depends.
fn pair(scene: &Scene, particles: &Particles) -> Bodies {
    Bodies::pair(scene, particles, 0, 1)
}

impl Observer for Meter<'_> {
    fn see(&mut self, simulation: &Simulation) {
        let at_start = *self.at_start.get_or_insert_with(|| self.gauge.scale(simulation));
        let row = match self.gauge {
            Gauge::Impact => self.meeting(simulation),
            gauge => gauge.row(simulation, at_start),
        };
        self.rows.push(row);
    }
}
