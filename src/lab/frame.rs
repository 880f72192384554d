//! Frame of the lab: data of one instant, from which the page draws its panels (simulations side by side).
//!
//! A frame is a sequence of bytes, little endian: the length of the JSON in bytes (u32), the JSON, and blanks up to a
//! multiple of four. Then come the particles of each panel, in the order of their ids. Each particle has x, y, z [m],
//! speed [m/s], overlap [m] and radius [m], as f32.

use crate::engine::Failure;
use crate::simulation::Simulation;
use serde::Serialize;

/// Numbers of one particle in a frame (data of one instant): x, y, z [m], speed [m/s], overlap [m] and radius [m].
pub type DrawnParticle = [f32; 6];

/// State of one panel at one instant, without its particles.
#[derive(Clone, Debug, Serialize)]
pub struct Now {
    /// [s] simulated time that the panel has reached.
    pub time: f64,
    /// State of the run: `running`, `over` (it has reached its end) or `failed`.
    pub state: &'static str,
    /// Reason why the run failed, as one word and as a sentence; `None` if it did not fail.
    pub failure: Option<(&'static str, String)>,
    /// Rows of quantities measured since the previous frame (data of one instant sent to the page), or in a live view
    /// since the start. A row has one value for each column of the graphs, in the unit of this column.
    pub rows: Vec<Vec<f64>>,
    /// Numbers of the run, such as energies and counts, that the page shows next to the panel.
    pub live: Live,
}

/// Numbers of a run that the page shows next to its panel.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Live {
    /// [J] kinetic energy of all particles, including that of rotation.
    pub kinetic: f64,
    /// [J] elastic energy that is stored in contacts.
    pub elastic: f64,
    /// [J] energy that the particles have lost in impacts, lasting contacts and friction since the start.
    pub dissipated: f64,
    /// [J] energy that the particles have gained since the start other than by impacts, such as by gravity, drag and
    /// moving walls.
    pub work: f64,
    /// [J] kinetic plus elastic energy at the start.
    pub at_start: f64,
    /// [J] residual of the energy balance: change of the energy since the start, minus the work, plus the recorded
    /// losses.
    pub residual: f64,
    /// [J] energy that all particles together would gain if each fell by its diameter; 0 without gravity.
    pub fall: f64,
    /// Number of finished impacts between particles.
    pub pairs: u64,
    /// Number of finished impacts of particles on walls.
    pub walls: u64,
    /// [-] realised restitution, as root mean square over all impacts between particles and at walls; `None` without an
    /// impact.
    pub restitution: Option<f64>,
    /// [-] largest overlap in the finished impacts, divided by the diameter of the smaller sphere; `None` without an
    /// impact.
    pub overlap: Option<f64>,
    /// [s] mean duration of the impacts of pairs and at walls; `None` without an impact.
    pub duration: Option<f64>,
    /// [s/s] wall time that the engine needed, divided by the simulated time. `None` at the start, and in scenes of a
    /// few impacts, whose wall times are too short to be measured reliably.
    pub cost: Option<f64>,
    /// Number of time steps of the engine since the start.
    pub steps: u64,
    /// Number of collisions since the start that were computed as an impulse.
    pub events: u64,
    /// Number of checks of the distance of two particles since the start.
    pub checks: u64,
    /// Number of collisions that were missed since the start, because hard spheres moved in time steps.
    pub missed: u64,
}

impl Live {
    /// Numbers of a simulation at the present time. `at_start` [J] is its energy at the start.
    pub fn of(simulation: &Simulation, at_start: f64) -> Self {
        let counters = simulation.counters();
        let (record, ledger) = (&simulation.record, &simulation.record.ledger);
        let squares = record.pairs.normal_speed.sum_of_squares() + record.walls.normal_speed.sum_of_squares();
        let rebound = record.pairs.rebound_squares() + record.walls.rebound_squares();
        let summaries = [record.pairs.summary(), record.walls.summary()];
        let largest = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).max_by(f64::total_cmp);
        let count = record.pairs.count + record.walls.count;
        let particles = &simulation.particles;
        let falls = particles.mass.iter().zip(&particles.radius).map(|(mass, radius)| mass * 2.0 * radius);
        Self {
            kinetic: particles.kinetic_energy() + particles.rotational_energies().value(),
            elastic: simulation.elastic_energy(),
            dissipated: ledger.dissipated(),
            work: ledger.work(),
            at_start,
            residual: ledger.residual(at_start, simulation.energy()),
            fall: falls.sum::<f64>() * simulation.scene().gravity.norm(),
            pairs: record.pairs.count,
            walls: record.walls.count,
            restitution: (squares > 0.0).then(|| (rebound / squares).sqrt()),
            overlap: largest(summaries[0].largest_overlap, summaries[1].largest_overlap),
            duration: (count > 0).then(|| (record.pairs.duration.sum() + record.walls.duration.sum()) / count as f64),
            cost: (simulation.time > 0.0).then(|| simulation.spent.engine.as_secs_f64() / simulation.time),
            steps: counters.steps,
            events: counters.events,
            checks: counters.pair_checks,
            missed: counters.missed_collisions,
        }
    }
}

/// Particles of a simulation as a page draws them, in the order of ids. If there are more than `most` particles, only
/// every n-th is drawn, with the smallest n that leaves at most `most`. Along periodic axes, positions outside the box
/// are replaced by those of the image within the box.
pub fn drawn(simulation: &Simulation, most: usize) -> Vec<DrawnParticle> {
    let (particles, domain) = (&simulation.particles, &simulation.scene().domain);
    let overlaps = simulation.overlaps();
    let mut places: Vec<usize> = (0..particles.len()).collect();
    places.sort_unstable_by_key(|place| particles.id[*place]);
    let each = |place: usize| {
        let (mut x, speed) = (particles.position[place], particles.velocity[place].norm());
        (0..3).filter(|axis| domain.periodic[*axis]).for_each(|axis| x[axis] = x[axis].rem_euclid(domain.size[axis]));
        [x.x, x.y, x.z, speed, overlaps[place], particles.radius[place]].map(|value| value as f32)
    };
    places.into_iter().step_by(particles.len().div_ceil(most).max(1)).map(each).collect()
}

/// Result of the comparison of the two panels. Only in scenes whose averages are tested statistically are the panels
/// compared.
#[derive(Clone, Debug, Serialize)]
pub struct PanelComparison {
    /// Answer of the comparison of the two panels: equivalent, different or unresolved.
    pub answer: String,
    /// Sentence that explains the answer.
    pub sentence: String,
    /// [s] simulated time at which averaging begins.
    pub from: f64,
    /// Profiles of the left and the right panel over the height. Each slice (layer of the box normal to y) has five
    /// numbers: its height y [mm], the streamwise velocity and its standard error [m/s], and the granular temperature
    /// and its standard error [m²/s²]. Unknown values are `None`.
    pub profiles: [Vec<[Option<f64>; 5]>; 2],
}

/// Part of a frame (data of one instant, from which the page draws) that is sent as JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Head<'a> {
    /// Serial number of the choice (scene and settings) by which the page opened the running scene.
    pub serial: u32,
    /// Number of drawn particles in each panel, from left to right.
    pub counts: Vec<usize>,
    /// States of the panels at this instant, from left to right.
    pub sides: &'a [Now],
    /// Comparison of the two panels, in the first frame (data of one instant) after a new comparison. It is `None` in
    /// all other frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judged: Option<PanelComparison>,
}

/// Makes the bytes of a frame (data of one instant, from which the page draws) from its JSON part `head` and from the
/// particles of its panels.
pub fn bytes(head: &impl Serialize, particles: &[Vec<DrawnParticle>]) -> Vec<u8> {
    let mut json = serde_json::to_vec(head).unwrap_or_default();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = (json.len() as u32).to_le_bytes().to_vec();
    bytes.append(&mut json);
    for values in particles.iter().flatten().flatten() {
        bytes.extend_from_slice(&values.to_le_bytes());
    }
    bytes
}

/// Reason why a run failed: the kind of the failure as one word, and the failure as a sentence.
pub fn words(failure: &Failure) -> (&'static str, String) {
    (failure.kind(), failure.to_string())
}
