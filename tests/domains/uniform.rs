//! Uniform steps (equal time steps for all particles) of a run that is divided into domains (blocks of the box, one
//! per process).

use super::*;
use diptych::engine::Failure;
use diptych::record::Books as Ledger;
use diptych::simulation::Snapshot;

/// Bed of two sizes with friction, walls, gravity, and gas that flows through it. It is so dense that contacts last and
/// cross the borders of domains.
fn bed(count: usize, volume_fraction: f64) -> (Scene, Particles) {
    let mut of = scene(count, volume_fraction);
    of.0.fluid = Some(air());
    of
}

#[test]
fn uniform_steps_over_processes_give_the_bits_of_one() {
    let uniform = || support_soft(Integrator::VelocityVerlet);
    for fraction in [0.3, 0.45] {
        let of = bed(2500, fraction);
        let name = format!("uniform at {fraction}");
        let counters = run(&of.0, of.1.clone(), uniform(), 1e-3, 10).counters();
        assert!(counters.uniform_steps > 1900 && counters.neighbour_builds > 8, "{counters:?}");
        same_bits_over_processes(&name, &of, &uniform, (1e-3, 10));
        let alone = sums(None, &of, &uniform, 1e-3);
        for size in [1, 2, 3, 4] {
            let seen = sums(Some(size), &of, &uniform, 1e-3);
            let differs = seen.iter().zip(&alone).position(|(seen, alone)| seen != alone);
            let pair = differs.map(|at| (&seen[at], &alone[at]));
            assert_eq!((seen.len(), pair), (alone.len(), None), "{name} on {size}");
        }
    }
}

#[test]
fn who_looks_at_shared_uniform_steps_sees_what_one_process_shows() {
    let (of, uniform) = (bed(2500, 0.4), || support_soft(Integrator::VelocityVerlet));
    let alone = glances(None, &of, &uniform, 1e-3);
    for size in [1, 2, 3, 4] {
        let seen = glances(Some(size), &of, &uniform, 1e-3);
        let differs = seen.iter().zip(&alone).position(|(seen, alone)| seen != alone);
        assert_eq!((seen.len(), differs), (alone.len(), None), "{size} processes");
    }
}

/// Checksum and ledger (sums of energies and impulses) at the end of a run in uniform steps. The run is stopped on one
/// number of processes and resumed on another; `None` means one process.
pub fn left_and_resumed(sizes: [Option<usize>; 2], of: &(Scene, Particles)) -> (u64, Ledger) {
    const WINDOWS: u64 = 12;
    let (window, left) = (1e-3 / WINDOWS as f64, 5);
    let part = |size: Option<usize>, snapshot: Option<&Snapshot>| -> (Snapshot, (u64, Ledger)) {
        let plain = || {
            let simulation = Simulation::with_distributed_engine(
                of.0.clone(),
                of.1.clone(),
                support_soft(Integrator::VelocityVerlet),
            );
            match snapshot {
                Some(snapshot) => simulation.resume(snapshot.clone()).unwrap(),
                None => simulation,
            }
        };
        let mut crew = Crew::of(size.unwrap_or(1));
        let lead = crew.remove(0);
        std::thread::scope(|scope| {
            for communicator in crew {
                scope.spawn(|| {
                    // the lead process has the records up to now
                    let mut follower = plain();
                    follower.record = Default::default();
                    follower.shared(communicator, 0).follow(&mut |_, _, _| {});
                });
            }
            let mut simulation = if size.is_some() { plain().shared(lead, 0) } else { plain() };
            let windows = WINDOWS - simulation.windows;
            simulation.run_while(windows, window, &mut |_, k| snapshot.is_some() || k < left).unwrap();
            simulation.gather(1);
            let end = (simulation.state().fingerprint(), simulation.record.ledger.clone());
            (simulation.snapshot().unwrap(), end)
        })
    };
    let (snapshot, _) = part(sizes[0], None);
    part(sizes[1], Some(&snapshot)).1
}

#[test]
fn shared_uniform_steps_are_left_and_resumed_on_any_number_of_processes() {
    let of = bed(2500, 0.4);
    let alone = left_and_resumed([None, None], &of);
    for sizes in [[Some(2), None], [None, Some(3)], [Some(3), Some(2)], [Some(1), Some(4)]] {
        assert_eq!(left_and_resumed(sizes, &of), alone, "{sizes:?}");
    }
}

#[test]
fn shared_uniform_steps_fail_as_those_of_one_process() {
    let of = bed(2500, 0.45);
    // spheres so soft that they overlap most of the time
    let engine = || soft(0.05, 1e-5, Integrator::VelocityVerlet);
    let (alone, failure) = try_run(&of.0, of.1.clone(), engine(), 1e-2, 10);
    let failure = failure.unwrap_err();
    assert!(matches!(failure, Failure::OverlapTooLarge { .. }) && alone.time > 5e-5, "{failure:?} at {}", alone.time);
    for size in [2, 3, 4] {
        let plain = |communicator| {
            Simulation::with_distributed_engine(of.0.clone(), of.1.clone(), engine()).shared(communicator, 0)
        };
        let mut crew = Crew::of(size);
        let lead = crew.remove(0);
        std::thread::scope(|scope| {
            for communicator in crew {
                scope.spawn(|| plain(communicator).follow(&mut |_, _, _| {}));
            }
            let mut simulation = plain(lead);
            assert_eq!(simulation.run(10, 1e-3).unwrap_err(), failure, "{size} processes");
            assert_eq!(simulation.state().fingerprint(), alone.state().fingerprint(), "{size} processes");
            assert_eq!(simulation.record.ledger, alone.record.ledger, "{size} processes");
        });
    }
}
