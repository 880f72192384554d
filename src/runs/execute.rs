//! Runs one variant from its initial state to its outcome. A variant is one of the experiments of a case, and an
//! observer is a measurement during a run. If several processes share a run, one of them is the lead.

use super::checkpointer::Checkpointer;
use super::error::StudyError;
use super::ranks::Ranks;
use super::resumable::ResumableRun;
use super::standard_observers::StandardObservers;
use super::terminal::tell;
use crate::checkpoint::{RunIdentity, StoredRun};
use crate::clock::Clock;
use crate::communicator::Communicator;
use crate::engine::Failure;
use crate::experiment::{Experiment, Integrator, Model};
use crate::observe::{Needs, Observer, RunLoop};
use crate::outcome::Outcome;
use crate::output::OutputError;
use crate::particles::Particles;
use crate::placement::Start;
use crate::simulation::Simulation;
use crate::stored::StoreError;
use crate::work_sharing::keep_workers_spinning;
use std::sync::Arc;

/// Runs a variant (experiment of a case) from the particles `start` to its end or to a failure; a failure is a part of
/// the outcome. `others` are observers (measurements during the run) in addition to the standard ones. Returns the
/// outcome and the final state of the particles in the order of ids.
pub fn execute(experiment: &Experiment, start: Particles, others: &mut [&mut dyn Observer]) -> (Outcome, Particles) {
    // the whole loop runs on a thread of the pool, because a thread outside the pool would sleep and be woken at every
    // parallel loop
    keep_workers_spinning(|| {
        let mut seen = StandardObservers::new(experiment, start.fingerprint());
        let mut simulation = Simulation::new(experiment, start).with_clock(Clock::wall());
        let schedule = seen.schedule;
        let mut observers = seen.with(others);
        let mut course = RunLoop::new(&schedule, observers.len());
        let failure = course.run(&mut simulation, &mut observers, &mut || false).err();
        course.end(&mut simulation, &mut observers, failure.as_ref());
        drop(observers);
        simulation.end();
        (seen.outcome(&simulation, failure, simulation.particles.fingerprint()), simulation.particles)
    })
}

/// Runs a variant (experiment of a case) like [`execute`], with a checkpointer that stores the state of the run at
/// intervals and may stop the run. If a state is stored, the run continues from this state. A run that has ended is
/// not repeated. Returns the outcome and the final state of the particles; the state is empty if `shared` does not
/// request the final state.
///
/// If `shared` is given, all processes share the run. This process is the lead, and first sends the index of the run
/// to the other processes.
///
/// # Errors
/// Returns an error if the run cannot begin, if its state cannot be stored, or if the stored state belongs to another
/// run.
pub fn execute_with_checkpoints(
    run: &ResumableRun,
    others: &mut [&mut dyn Observer],
    checkpointer: &mut Checkpointer,
    shared: Option<SharedRun>,
) -> Result<(Outcome, Particles), StudyError> {
    let experiment = &run.experiment;
    let gives_end = shared.is_none_or(|shared| shared.gives_end);
    let mut simulate = |communicator: Option<Arc<dyn Communicator>>| {
        let start = run.start()?;
        let mut seen = StandardObservers::new(experiment, start.fingerprint);
        let in_parts = others.iter().take_while(|other| other.needs() == Needs::Parts).count();
        let common = seen.with(&mut []).len() + in_parts;
        let schedule = seen.schedule;
        let mut observers = seen.with(others);
        let begun = RunLoop::new(&schedule, observers.len());
        let (mut simulation, mut course, mut over) =
            begin_or_resume(run, start, begun, (&mut observers, common), checkpointer, communicator)?;
        let failure = loop {
            if let Some(failure) = over {
                break failure;
            }
            over = match course.run(&mut simulation, &mut observers, &mut || checkpointer.is_due()) {
                Ok(true) => Some(None),
                Ok(false) => None,
                Err(failure) => Some(Some(failure)),
            };
            if let Some(why) = store(&mut simulation, &course, &observers, (&run.identity, checkpointer), &over)? {
                course.finish_half_kick(&mut simulation);
                break Some(why);
            }
        };
        course.end(&mut simulation, &mut observers, failure.as_ref());
        drop(observers);
        if gives_end {
            simulation.gather(1);
            simulation.end();
        }
        let hash = simulation.fingerprint();
        let particles = if gives_end { std::mem::take(&mut simulation.particles) } else { Particles::default() };
        Ok((seen.outcome(&simulation, failure, hash), particles))
    };
    let Some(SharedRun { index, ranks, quiet, .. }) = shared else {
        return keep_workers_spinning(|| simulate(None));
    };
    ranks.call_together(index);
    let (result, traffic) = ranks.together(|communicator| rayon::scope(|_| simulate(Some(communicator))));
    if let (Ok((outcome, _)), false) = (&result, quiet) {
        tell(format!("{}: {}", experiment.name, traffic_of(experiment, outcome, &traffic)));
    }
    result
}

/// Sentence on the communication in a run that all processes shared.
fn traffic_of(experiment: &Experiment, outcome: &Outcome, traffic: &impl std::fmt::Display) -> String {
    let verlet = experiment.model() == Model::Soft && experiment.soft.integrator == Integrator::VelocityVerlet;
    let steps_are_shared = verlet && outcome.counters.uniform_steps > 0;
    let is_alone = outcome.windows > 0 && outcome.counters.islands == 0 && !steps_are_shared;
    if is_alone {
        return "nothing was shared: no window was moved by islands, and what moves all particles at once is done by process 0 alone".into();
    }
    traffic.to_string()
}

/// Run that all processes share, with the choices of what is printed and returned.
#[derive(Clone, Copy)]
pub struct SharedRun<'a> {
    /// Index of the run in the list of runs; all processes have the same list.
    pub index: usize,
    /// Processes that share the run.
    pub ranks: &'a Ranks,
    /// True if no summary of the communication is printed after the run.
    pub quiet: bool,
    /// True if the final state is returned after the run.
    pub gives_end: bool,
}

/// Takes part in a run that all processes share, in a process other than the lead. `others` are the additional
/// observers (measurements during the run) that work on parts of the particles. The list of additional observers of
/// the lead process must begin with the same ones, in the same order.
pub fn follow(run: &ResumableRun, others: &mut [&mut dyn Observer], ranks: &Ranks) {
    let experiment = &run.experiment;
    let Ok(start) = run.start() else { return };
    ranks.together(|communicator| {
        rayon::scope(|_| {
            let mut seen = StandardObservers::new(experiment, 0);
            let mut observers = seen.with(others);
            let is_part = start.is_part;
            let begun = begin(experiment, start, Some(&*communicator));
            let beginning = Beginning::from(communicator.broadcast(Vec::new()));
            let mut simulation = share(begun, communicator, observers.len(), is_part && beginning != Beginning::Whole);
            if beginning == Beginning::Dealt {
                simulation.take_dealt().unwrap_or_else(|why| leave(&why));
            }
            simulation.follow(&mut |simulation, index, kept| {
                if let Some(Err(why)) = kept.map(|kept| observers[index].restore(kept)) {
                    leave(&why);
                }
                observers[index].see(simulation);
            });
        });
    });
}

/// Makes the simulation of a run from `start`, or from the stored state if there is one. The second result is the
/// position (place in the schedule) from which the run continues; `begun` is this position for a run at its start. The
/// third result is `None` if the run goes on. For a stored run that had ended, it is the failure of the run, or
/// `Some(None)` without a failure. The first `common` of the `observers` (measurements during the run) exist in all
/// processes.
fn begin_or_resume(
    run: &ResumableRun,
    start: Start,
    begun: RunLoop,
    (observers, common): (&mut [&mut dyn Observer], usize),
    checkpointer: &mut Checkpointer,
    communicator: Option<Arc<dyn Communicator>>,
) -> Result<(Simulation, RunLoop, Option<Option<Failure>>), StudyError> {
    let (experiment, identity) = (&run.experiment, &run.identity);
    let (is_part, earlier) = (start.is_part, checkpointer.earlier(identity));
    let parts = earlier.as_ref().map(|kept| kept.pause.snapshot.parts);
    let beginning = Beginning::of(is_part, parts);
    let mut simulation = begin(experiment, start, communicator.as_deref()).with_clock(Clock::wall());
    if let Some(communicator) = &communicator {
        communicator.broadcast(beginning.told());
        if beginning != Beginning::Whole {
            simulation = share(simulation, communicator.clone(), common, is_part);
        }
    }
    let (mut course, mut over) = (begun, None);
    if let Some(kept) = earlier {
        over = kept.over;
        (simulation, course) = kept.pause.resume_as(simulation, experiment, observers).map_err(unfit)?;
        if let Some(count) = parts.filter(|count| *count > 0) {
            let taken = simulation.take_parts(count, &mut |number| checkpointer.part(identity, over.is_some(), number));
            taken.unwrap_or_else(|why| leave(&why));
        }
    }
    if let (Some(communicator), Beginning::Whole) = (communicator, beginning) {
        simulation = share(simulation, communicator, common, false);
    }
    Ok((simulation, course, over))
}

/// Stores the state of a run at a checkpoint or at the end of the run. `over` is `None` at a checkpoint. At the end of
/// the run, `over` contains the failure of the run, or `Some(None)` without a failure. Returns a failure if the run
/// must stop, because the user asked for it or because a file could not be written; otherwise `None`.
fn store(
    simulation: &mut Simulation,
    course: &RunLoop,
    observers: &[&mut dyn Observer],
    (run, checkpointer): (&RunIdentity, &mut Checkpointer),
    over: &Option<Option<Failure>>,
) -> Result<Option<Failure>, StudyError> {
    // after a failure to write, the run can be resumed from the state stored before, so no final data are stored
    let unwritten = matches!(over, Some(Some(Failure::Unwritten { .. })));
    if unwritten || over.is_some() && !checkpointer.wants_the_end() {
        return Ok(None);
    }
    let parts = store_parts(simulation, (run, checkpointer), over.is_some());
    let pause = course.store(simulation, observers).map_err(unfit)?;
    if let Some(why) = observers.iter().find_map(|observer| observer.stop()) {
        return Ok(Some(Failure::Unwritten { time: simulation.time, why }));
    }
    let kept = StoredRun { pause, over: over.clone() };
    if over.is_some() {
        checkpointer.finish(run, &kept, parts).map_err(unfit)?;
        return Ok(None);
    }
    let stops = checkpointer.keep(run, &kept, parts);
    Ok(stops.then_some(Failure::Stopped { time: simulation.time }))
}

/// Stores the parts of the state of a run, one part for each process; `over` is true at the end of the run. If the
/// state is not divided into parts, all particles are gathered in this process, and this function stores nothing; the
/// caller stores the whole state.
fn store_parts(
    simulation: &mut Simulation,
    (run, checkpointer): (&RunIdentity, &Checkpointer),
    over: bool,
) -> Result<(), OutputError> {
    if simulation.parts_of_state() == 0 {
        simulation.gather(1);
        return Ok(());
    }
    let (mut written, mut number) = (Ok(()), 0);
    simulation.give_parts(&mut |part| {
        if written.is_ok() {
            written = checkpointer.keep_part(run, over, number, &part);
        }
        number += 1;
    });
    written
}

/// Processes that have the particles at the beginning of a run that several processes share.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Beginning {
    /// The lead process has all particles, of the initial state or of a stored state.
    Whole,
    /// Each process has made its part of the initial state.
    Parts,
    /// The lead process has a stored state in parts, and sends each process its part.
    Dealt,
}

impl Beginning {
    /// Processes that have the particles at the beginning of a run. `is_part` is true if each process has made a part
    /// of the initial state. `stored` is the number of parts of the stored state; `None` without a stored state.
    fn of(is_part: bool, stored: Option<usize>) -> Self {
        match stored {
            None if is_part => Self::Parts,
            Some(1..) => Self::Dealt,
            None | Some(0) => Self::Whole,
        }
    }

    /// Returns this value as bytes, the form in which the lead process sends it to the other processes.
    fn told(self) -> Vec<u8> {
        vec![self as u8]
    }
}

impl From<Vec<u8>> for Beginning {
    fn from(told: Vec<u8>) -> Self {
        let known = [Self::Parts, Self::Dealt].into_iter().find(|one| one.told() == told);
        known.unwrap_or(Self::Whole)
    }
}

/// Ends this process with an error message; all other processes then end too. If this process went on after the error,
/// its state would differ from that of the others.
fn leave(why: &StoreError) -> ! {
    tell(format!("error: the processes cannot go on together: {why}"));
    std::process::exit(1);
}

/// Makes the simulation of a run from its start, which may be a part of the particles. `communicator` is the connection
/// to the other processes; `None` means that the run is not shared.
fn begin(experiment: &Experiment, start: Start, communicator: Option<&dyn Communicator>) -> Simulation {
    match communicator.filter(|_| start.is_part) {
        Some(communicator) => Simulation::part(experiment, start.particles, communicator),
        None => Simulation::new(experiment, start.particles),
    }
}

/// Makes all processes share the simulation. If `in_parts` is true, each process continues with its part of the
/// particles. Otherwise the lead process has all particles. `observers` is the number of observers.
fn share(simulation: Simulation, with: Arc<dyn Communicator>, observers: usize, in_parts: bool) -> Simulation {
    if in_parts { simulation.shared_in_parts(with, observers) } else { simulation.shared(with, observers) }
}

/// Error of a run whose state cannot be stored, or whose stored state belongs to another run, with the reason `why`.
fn unfit(why: impl std::fmt::Display) -> StudyError {
    StudyError::Failed(format!("error: cannot store this run or go on with it: {why}"))
}
