//! Exchange between the particle store and the calendar (the event queue of all particles). The calendar reads
//! particles, writes them back, and begins new epochs. The *epoch* is the instant from which the calendar counts times.
//! A window is the time between two exchanges with the gas. A shell is a ball around a particle, in which its neighbour
//! list is valid.

use super::cells::ROUNDING;
use super::division::Division;
use super::event_queue::{EventQueue, EventTable};
use super::frame::FallingFrame;
use super::neighbour_lists::lists_of;
use super::next_events::{FlightState, NextEvents, ParticleRange};
use super::prediction::Flights;
use super::search::has_images;
use super::shells::RadiusClass;
use super::sliding::SLIDE;
use super::territories::Territories;
use super::walls::{WallContacts, across};
use super::{GlobalCalendar, LastCollision, Recent, view_of};
use crate::engine::driver::Work;
use crate::engine::population::crowded_density;
use crate::engine::{Failure, Window, not_a_number};
use crate::neighbours::along_walls;
use crate::particles::{CHUNK, Particles};
use crate::scene::Scene;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::f64::consts::{PI, SQRT_2};

/// Number of times that the fastest particle may cross the box between two epochs, the instants from which times are
/// counted. Over a longer time the rounding errors of times would matter as much as the rounding errors of positions.
const CROSSINGS: f64 = 8.0;

/// [-] distance that the frame may move towards a wall while it follows a flying layer of particles, divided by the
/// largest diameter. The limit applies to the time between two epochs, the instants from which times are counted. All
/// particles within this distance of a wall are tested for a touch. A shorter distance needs more epochs, at each of
/// which all lists are built again.
const FOLLOWED: f64 = 2.0;

/// Smallest number of particles whose common motion the frame of the event queue follows. The mean velocity of few
/// particles is large by chance.
const FEWEST: usize = 100;

/// [-] squared speed of a layer of particles relative to the frame of the event queue, over the mean square of the
/// random velocities in the layer. Above this value the frame follows the layer from the next window on.
const LEFT_BEHIND: f64 = 2.0;

/// Number of collisions per particle after which the particle store is sorted again. By then, particles near in memory
/// are no longer near in space. The number of new neighbour lists would be a better measure of this motion, but it
/// depends on the number of threads.
const SORT_AFTER: u64 = 40;

/// Kind of change that other parts of the program have made to the particle store since the calendar (event queue of
/// all particles) wrote its state there.
enum Change {
    /// No position or velocity has changed, so all predicted events remain valid.
    None,
    /// Velocities have changed, so all events must be predicted again.
    Kicked,
    /// Positions or the order of particles have changed, so all events and neighbour lists must be made again.
    Moved,
}

impl GlobalCalendar {
    /// Prepares a window (time between two exchanges with the gas): adopts changes of the particle store since the last
    /// window, and queues the events of the new window. `outdated` is true if islands (groups of particles that may
    /// meet) have moved particles since the last call.
    pub(super) fn begin(&mut self, work: &mut Work<Recent>, window: Window, outdated: bool) -> Result<(), Failure> {
        let scene = work.scene;
        if !self.ready {
            self.walls = WallContacts::of(scene);
        }
        let kicked = scene.is_kicked();
        let due = self.events - self.sorted_at > SORT_AFTER * self.next_events.len() as u64;
        let due = due || (!outdated && self.is_left_behind(work.particles, scene));
        let change = if outdated || due { Change::Moved } else { self.change(work.particles, scene) };
        match change {
            Change::Moved => {
                let met = self.history(work.particles, outdated.then_some(work.lasting.as_slice()));
                self.load(work.particles, scene, met, window.start)?;
            }
            Change::None if !kicked => self.take_back_crossings(work),
            Change::None | Change::Kicked => self.reload_velocities(work, window.start)?,
        }
        if !self.ready {
            self.shells.fill_cells(&self.next_events, &self.bodies, &scene.domain);
        }
        self.horizon = if kicked { self.now + window.duration } else { f64::INFINITY };
        let anew = kicked || !matches!(change, Change::None);
        if anew {
            self.predict_all(scene);
        }
        if anew || !self.ready {
            self.fill_queue();
        }
        self.ready = true;
        Ok(())
    }

    /// Puts the next events of all particles into the event queue for a single thread, and ends the division of the
    /// particles among threads.
    pub(super) fn fill_queue(&mut self) {
        self.parts.clear();
        let table = EventTable { first: 0, next_events: &self.next_events, ids: &self.ids };
        self.queue.fill(table, self.now, self.horizon);
    }

    /// Predicts the next two events of every particle, without filling the event queue.
    pub(super) fn predict_all(&mut self, scene: &Scene) {
        let around = view_of!(self, scene);
        let flights = Flights { around: &around, first: 0, bodies: &self.bodies, now: self.now, in_order: true };
        let chunks = self.next_events.par_chunks_mut(CHUNK).zip(self.bodies.par_chunks(CHUNK)).enumerate();
        let (lists, parts) = (&self.lists, &self.shells.parts);
        let touch_times = chunks.map(|(chunk, (entries, bodies))| {
            for (index, (events, body)) in ((chunk * CHUNK) as u32..).zip(entries.iter_mut().zip(bodies)) {
                flights.predict_into(body, events, lists_of(lists, parts, index));
            }
            entries.iter().map(|events| u64::from(events.shell.count())).sum::<u64>()
        });
        self.pair_checks += touch_times.sum::<u64>();
    }

    /// Updates `Shell::across` of each particle, which is true if the prediction of touches must look for the nearest
    /// periodic image of each neighbour. The update is needed after flights have been shifted by whole periods.
    fn find_images(&mut self, scene: &Scene) {
        for index in 0..self.next_events.len() as u32 {
            let particles = ParticleRange { first: 0, bodies: &self.bodies, next_events: &self.next_events };
            let near = lists_of(&self.lists, &self.shells.parts, index).neighbours(particles.shell(index));
            let across = has_images(index, near, particles, (&scene.domain, self.now));
            self.next_events[index as usize].shell.across = across;
        }
    }

    /// True if the particles fly together as a layer with a mean velocity that the frame of the event queue does not
    /// have, for instance after a rebound from a floor.
    fn is_left_behind(&self, particles: &Particles, scene: &Scene) -> bool {
        if !is_built_each_epoch(scene) || particles.len() < FEWEST {
            return false;
        }
        let (mean, square) = mean_and_fluctuation(particles);
        // without the lower limit `fall`, a frame that falls past particles at rest would be replaced before its next
        // epoch
        let largest = self.shells.kinds.last().map_or(0.0, |kind| kind.radius);
        let fall = across(scene, scene.gravity).norm() * 2.0 * largest;
        let behind = across(scene, mean - self.frame.velocity_at(self.now)).norm_squared();
        behind > (LEFT_BEHIND * square).max(fall)
    }

    fn change(&self, particles: &Particles, scene: &Scene) -> Change {
        if self.next_events.is_empty() || self.ids != particles.id {
            return Change::Moved;
        }
        let mut change = Change::None;
        for index in 0..self.bodies.len() {
            let (mut position, mut velocity) = self.motion_in_scene(index);
            scene.domain.wrap_motion(&mut position, &mut velocity);
            if position != particles.position[index] {
                return Change::Moved;
            }
            if velocity != particles.velocity[index] {
                change = Change::Kicked;
            }
        }
        change
    }

    /// Present position [m] and velocity [m/s] of the particle with the index `index`, relative to the scene and not to
    /// the frame that falls with gravity. The position may be outside the box.
    pub(super) fn motion_in_scene(&self, index: usize) -> (Vector3<f64>, Vector3<f64>) {
        let body = &self.bodies[index];
        let flight = self.frame.flight(&body.position_at(self.now), &body.velocity, self.now);
        (flight.position, flight.velocity)
    }

    /// Writes the present positions and velocities of all particles, relative to the scene, to the particle store.
    /// Positions are shifted into the box, except across sheared sides, where the velocity would change too.
    pub(super) fn write(&self, particles: &mut Particles, scene: &Scene) {
        for index in 0..self.bodies.len() {
            let (position, velocity) = self.motion_in_scene(index);
            let position = if scene.domain.shear.is_none() { scene.domain.wrap(&position) } else { position };
            (particles.position[index], particles.velocity[index]) = (position, velocity);
        }
    }

    /// Collision history of each particle, by id; empty if no particle has one. If `recently` is given, the histories
    /// are made from these last collisions. Otherwise they are the histories that the event queue has stored.
    fn history(&self, particles: &Particles, recently: Option<&[Recent]>) -> Vec<LastCollision> {
        // after particles have left or come in, the largest id exceeds their number
        let nothing = |ids: &[u32]| {
            vec![LastCollision::default(); ids.iter().map(|id| *id as usize + 1).max().unwrap_or_default()]
        };
        match recently {
            Some([]) => Vec::new(),
            Some(recently) => {
                let mut by_id = nothing(&particles.id);
                for recent in recently {
                    by_id[particles.id[recent.index as usize] as usize] = LastCollision::at(recent.time);
                }
                by_id
            }
            None if self.last_collisions.len() == self.ids.len() => {
                let mut by_id = nothing(&self.ids);
                for (&id, met) in self.ids.iter().zip(&self.last_collisions) {
                    by_id[id as usize] = *met;
                }
                by_id
            }
            None => Vec::new(),
        }
    }

    /// Frees the memory of flights, events, collision histories and neighbour lists, before these are made again or at
    /// the end of a run.
    pub fn forget(&mut self) {
        (self.bodies, self.next_events, self.last_collisions) = (Vec::new(), Vec::new(), Vec::new());
        self.queue = EventQueue::default();
        (self.parts, self.lists) = (Vec::new(), Vec::new());
        (self.shells.levels, self.shells.territories) = (Vec::new(), Territories::default());
    }

    /// Builds the event queue of all particles anew, except its entries: sorts the particle store along a curve through
    /// the box, copies the flights of the particles, and makes shells (balls in which neighbour lists are valid) and
    /// neighbour lists. `met` contains the collision histories by id, and `start` [s] is the simulated time.
    fn load(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        met: Vec<LastCollision>,
        start: f64,
    ) -> Result<(), Failure> {
        let began = self.clock.now();
        self.forget();
        particles.wrap(&scene.domain);
        particles.reorder(&super::curve::order(particles, &scene.domain));
        (self.now, self.epoch, self.slack) = (0.0, start, 0.0);
        self.limit = f64::INFINITY;
        self.frame = FallingFrame {
            offset: Vector3::zeros(),
            velocity: frame_velocity(particles, scene),
            gravity: scene.gravity,
        };
        let kinds = kinds(particles);
        let kind = |index: usize| RadiusClass { radius: particles.radius[index], mass: particles.mass[index] };
        let body = |index: usize| FlightState {
            position: particles.position[index],
            velocity: particles.velocity[index] - self.frame.velocity,
            time: 0.0,
            kind: kinds.partition_point(|other| by_size(other, &kind(index)).is_lt()) as u32,
            collision_count: 0,
        };
        self.bodies = (0..particles.len()).map(body).collect();
        self.shells.kinds = kinds;
        self.last_collisions =
            particles.id.iter().map(|&id| met.get(id as usize).copied().unwrap_or_default()).collect();
        // frees the memory, since the following lines require much
        drop(met);
        self.ids.clone_from(&particles.id);
        self.next_events = vec![NextEvents::blank(); particles.len()];
        self.set_limit(particles, scene, start)?;
        let density = crowded_density(particles, &scene.domain);
        let volume = self.bodies.len().max(1) as f64 / density;
        let crowds = crowds(&self.bodies, &self.shells.kinds, volume);
        let margin = margin(particles, density, &crowds, scene);
        let reach = 2.0 * particles.radius.iter().fold(0.0, |a: f64, &r| a.max(r));
        // both particles may cross their shells, each by two margins, so a farther image can come into reach if half
        // the period is less than the largest diameter plus four margins
        self.far_images = std::array::from_fn(|axis| {
            scene.domain.periodic[axis] && 0.5 * scene.domain.size[axis] - reach < 4.0 * margin
        });
        self.shells.margin = margin;
        self.begin_interval(scene);
        let parts = if self.may_be_shared(scene) { self.number_of_parts() } else { 1 };
        self.shells.parts = Division::new(particles.len(), parts);
        let around = view_of!(self, scene);
        let at_wall: Vec<bool> = self.bodies.iter().map(|body| around.at_wall(body, self.now)).collect();
        let domain = around.domain_of_lists().into_owned();
        let (lists, checks) = self.shells.build(&mut self.next_events, &self.bodies, &domain, &at_wall);
        self.lists = lists;
        self.pair_checks += checks;
        self.sorted_at = self.events;
        self.ready = true;
        self.builds += 1;
        self.building += self.clock.now() - began;
        Ok(())
    }

    /// Replaces the velocities of all flights by those in the particle store, after drag or other kicks have changed
    /// the velocities in the store. `start` [s] is the simulated time.
    fn reload_velocities(&mut self, work: &mut Work<Recent>, start: f64) -> Result<(), Failure> {
        let of_frame = self.frame.velocity_at(self.now);
        let velocities = self.velocities_after_kick(work);
        for (body, velocity) in self.bodies.iter_mut().zip(velocities.iter()) {
            body.advance(self.now);
            body.velocity = velocity - of_frame;
        }
        self.set_limit(work.particles, work.scene, start)
    }

    /// Chooses the time at which the next epoch begins, the instant from which times are then counted. The largest
    /// speed, the motion of the frame towards walls, and moving walls limit the time until then. `start` [s] is the
    /// simulated time. Returns an error if a velocity is not a finite number.
    fn set_limit(&mut self, particles: &Particles, scene: &Scene, start: f64) -> Result<(), Failure> {
        let before = self.limit;
        let fastest = self.bodies.iter().map(|body| body.velocity.norm_squared()).fold(0.0, |a: f64, b| {
            // the second test finds a NaN, with which every comparison is false
            if b > a || b.is_nan() { b } else { a }
        });
        if !fastest.is_finite() {
            return Err(not_a_number(particles, start));
        }
        let walls = scene.wall_speed();
        let crossing = scene.domain.size.max() / (fastest.sqrt() + walls);
        self.limit = CROSSINGS * crossing;
        if walls > 0.0 {
            // the search for walls near a shell allows for the distance that walls move until the end of the epoch
            self.limit = before.min(self.limit);
        }
        let fall = across(scene, scene.gravity).norm();
        // without particles an epoch has no limit
        if fall > 0.0 && !self.bodies.is_empty() {
            // the frame must not fall towards walls much faster than the particles move, since the search for walls
            // near a shell allows for the distance that the frame falls until the end of the epoch
            let count = self.bodies.len() as f64;
            let square = self.bodies.iter().map(|body| body.velocity.norm_squared()).sum::<f64>() / count;
            let diameter = 2.0 * self.bodies.iter().map(|body| self.shells.radius(body)).sum::<f64>() / count;
            self.limit = before.min(square.max(fall * diameter).sqrt() / fall);
        }
        let drift = across(scene, self.frame.velocity).norm();
        if drift > 0.0 && !self.bodies.is_empty() {
            let largest = self.shells.kinds.last().map_or(0.0, |kind| kind.radius);
            self.limit = self.limit.min(2.0 * FOLLOWED * largest / drift);
        }
        Ok(())
    }

    /// Begins a new epoch at the simulated time `time` [s]: the event queue then counts times from this instant, and
    /// all stored times are adapted. If gravity points towards a wall or walls move, the queue and all neighbour lists
    /// are built again.
    pub(super) fn new_epoch(&mut self, work: &mut Work<Recent>, time: f64) -> Result<(), Failure> {
        let (scene, horizon) = (work.scene, self.horizon - self.now);
        if is_built_each_epoch(scene) {
            // the search for walls near a shell allows only for the motion of frame and walls within one epoch
            self.write(work.particles, scene);
            let met = self.history(work.particles, None);
            self.load(work.particles, scene, met, time)?;
            self.horizon = horizon;
            self.predict_all(scene);
        } else {
            self.horizon = horizon;
            self.frame = self.frame.from(self.now);
            self.frame.offset = scene.domain.wrap(&self.frame.offset);
            // all flights begin anew, inside the box
            for body in &mut self.bodies {
                body.advance(self.now);
                body.time = 0.0;
                if scene.domain.shear.is_none() {
                    body.position = scene.domain.wrap(&body.position);
                }
            }
            self.epoch += self.now;
            self.lists_valid_until -= self.now;
            self.now = 0.0;
            self.set_limit(work.particles, scene, time)?;
            self.find_images(scene);
            self.predict_all(scene);
        }
        self.fill_queue();
        Ok(())
    }
}

/// [m/s] velocity of the frame of the event queue: the mean velocity of the particles along the walls. There is one
/// exception, if gravity points towards walls or walls move. If the particles then fly as a layer, faster than they
/// move relative to one another, the frame follows the layer also towards the walls. Otherwise each particle would soon
/// leave its shell (ball in which its neighbour list is valid).
fn frame_velocity(particles: &Particles, scene: &Scene) -> Vector3<f64> {
    if !is_built_each_epoch(scene) {
        return along_walls(scene, particles.mean_velocity());
    }
    let (mean, square) = mean_and_fluctuation(particles);
    let along = along_walls(scene, mean);
    let is_layer = particles.len() >= FEWEST && (mean - along).norm_squared() > square;
    if is_layer { mean } else { along }
}

/// True if the event queue is built again at each epoch (instant from which times are counted), since its frame falls
/// towards walls or walls move.
fn is_built_each_epoch(scene: &Scene) -> bool {
    scene.has_moving_walls() || across(scene, scene.gravity) != Vector3::zeros()
}

/// Mean velocity [m/s] of all particles, and mean square [m²/s²] of the velocities relative to this mean.
fn mean_and_fluctuation(particles: &Particles) -> (Vector3<f64>, f64) {
    let mean = particles.mean_velocity();
    let square: f64 = particles.velocity.iter().map(|velocity| (velocity - mean).norm_squared()).sum();
    (mean, square / particles.len().max(1) as f64)
}

/// Order of two classes of particles (combinations of radius and mass): by radius, and at equal radii by mass.
fn by_size(a: &RadiusClass, b: &RadiusClass) -> Ordering {
    a.radius.total_cmp(&b.radius).then(a.mass.total_cmp(&b.mass))
}

/// All different combinations of radius and mass among the particles, in ascending order.
fn kinds(particles: &Particles) -> Vec<RadiusClass> {
    let tidy = |kinds: &mut Vec<RadiusClass>| {
        kinds.sort_unstable_by(by_size);
        kinds.dedup();
    };
    let (mut kinds, mut most) = (Vec::new(), CHUNK);
    for (&radius, &mass) in particles.radius.iter().zip(&particles.mass) {
        kinds.push(RadiusClass { radius, mass });
        // removes duplicates from time to time, so that the list stays short if there are few kinds
        if kinds.len() >= most {
            tidy(&mut kinds);
            most = 2 * kinds.len() + CHUNK;
        }
    }
    tidy(&mut kinds);
    kinds.shrink_to_fit();
    kinds
}

/// Divides particles into groups in which the largest radius is at most twice the smallest. (The centres of shells are
/// sorted into one grid of cells for each such group.) Returns for each group the number density [1/m³] in the volume
/// `volume` [m³], and the largest diameter [m].
fn crowds(bodies: &[FlightState], kinds: &[RadiusClass], volume: f64) -> Vec<(f64, f64)> {
    let mut counts = vec![0u32; kinds.len()];
    for body in bodies {
        counts[body.kind as usize] += 1;
    }
    let mut crowds = Vec::new();
    let (mut kinds, mut counts) = (kinds, counts.as_slice());
    while let [smallest, ..] = kinds {
        let end = kinds.partition_point(|kind| kind.radius <= 2.0 * smallest.radius);
        let ((crowd, larger), (own, rest)) = (kinds.split_at(end), counts.split_at(end));
        let count: f64 = own.iter().copied().map(f64::from).sum();
        crowds.push((count / volume, 2.0 * crowd.last().unwrap_or(smallest).radius));
        (kinds, counts) = (larger, rest);
    }
    crowds
}

/// Distance [m] that a particle may move from the centre of its shell (ball in which its neighbour list is valid). A
/// larger distance needs fewer new shells but longer lists. The distance of lowest cost is taken; the costs in this
/// function serve only for this choice. `density` [1/m³] is the number density. `crowds` contains the number densities
/// [1/m³] and largest diameters [m] of groups of similar size.
fn margin(particles: &Particles, density: f64, crowds: &[(f64, f64)], scene: &Scene) -> f64 {
    /// [ns] cost of making a new shell (ball in which a neighbour list is valid): a fixed part, the cost per distance
    /// computed, and the cost per neighbour.
    const SHELL: [f64; 3] = [200.0, 3.0, 12.0];
    /// [ns] cost of predicting the events of a particle: a fixed part, and the cost per neighbour. Neighbours are
    /// tested in groups of four; tested one by one, each cost 7.0. With 7.0 instead of 3.5, dense gases take 1.03 to
    /// 1.05 times as long (10,000 spheres at volume fractions of 0.3 and 0.5).
    const EVENT: [f64; 2] = [80.0, 3.5];
    /// [-] number of predictions per collision of a particle. One prediction follows each collision. Further
    /// predictions are needed when the next event of a particle is void because its partner collided first.
    const FORETOLD: f64 = 1.7;
    let count = particles.len().max(1) as f64;
    let diameter = 2.0 * particles.radius.iter().sum::<f64>() / count;
    let largest = 2.0 * particles.radius.iter().fold(0.0, |a: f64, &r| a.max(r));
    let filled = (density * PI / 6.0 * diameter.powi(3)).min(0.6);
    // mean free path, with the crowding factor of Carnahan and Starling 1969
    let crowding = (1.0 - 0.5 * filled) / (1.0 - filled).powi(3);
    let free_path = 1.0 / (SQRT_2 * PI * density * diameter * diameter * crowding);
    let cost = |margin: f64| {
        let near = density * 4.0 / 3.0 * PI * (diameter + 2.0 * margin).powi(3);
        let looked_at: f64 = crowds.iter().map(|(of, largest)| 27.0 * of * (largest + 2.0 * margin).powi(3)).sum();
        // straight motion within a mean free path, and diffusion over longer distances
        let flown = margin * (1.0 + margin / (2.0 * free_path));
        let event = EVENT[0] + EVENT[1] * near;
        (SHELL[0] + SHELL[1] * looked_at + SHELL[2] * near + event) / flown + FORETOLD * event / free_path
    };
    let candidates = (0..60).map(|k| 0.03 * diameter * 1.12f64.powi(k));
    let wanted = candidates.min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(diameter);
    let periods = (0..3).filter(|axis| scene.domain.periodic[*axis]).map(|axis| scene.domain.size[axis]);
    let room = periods.fold(f64::INFINITY, f64::min) * 0.25 - 0.5 * largest;
    // in a sheared box only the nearest images of two particles may touch, although both may fly through their whole
    // shells while images slide through an interval
    let room = if scene.domain.shear.is_some() { room / (SLIDE + 2.0) } else { room };
    // at least the rounding error of the centres of shells, which is 6e-8 of the box
    wanted.min(room).min(scene.domain.size.max()).max(0.03 * diameter).max(ROUNDING * scene.domain.size.max())
}
