//! Trajectories of a run divided into domains (blocks of the box, one per process), with threads in place of
//! processes. Together, the pieces of a frame must equal the frame of a single process.

use crate::support::*;
use crate::trajectory::{array, numbers};
use diptych::contact_law::ContactLaw;
use diptych::engine::Failure;
use diptych::experiment::{Experiment, Model, SoftStepping, Spheres, Trajectories, TrajectoryFormat};
use diptych::fluid::{Fluid, Profile};
use diptych::observe::{Observer, Pause, RunLoop};
use diptych::output::{Folder, Trajectory};
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use diptych::{Drag, SchillerNaumann};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const EVERY: Trajectories = Trajectories { every: 1e-4, format: TrajectoryFormat::Vtp };

/// Experiment of a gas with islands (groups of particles that may meet), which falls in air between two walls. There
/// are frames at samples (instants of measurement), between samples, and at the end.
fn gas(model: Model) -> Experiment {
    let size = edge(2000, small().diameter, 0.04);
    let mut scene = empty([size; 3], [true, false, true], small(), surface(0.9, 0.1));
    scene.gravity = Vector3::new(0.0, -3.0, -9.81);
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.0)),
        plane([0.0, size, 0.0], [0.0, -1.0, 0.0], surface(0.9, 0.0)),
    ];
    scene.fluid = Some(Fluid::new(1.2, 1.5e-5, Profile::Uniform(0.5), Some(Drag::SchillerNaumann(SchillerNaumann))));
    let mut gas = experiment(scene, 2000, [0.0; 3], 0.5, model, 3);
    if model == Model::Soft {
        gas.soft.law = Some(ContactLaw::linear(100.0));
        gas.run.spheres = Spheres::Soft(ContactLaw::linear(100.0));
        gas.soft.stepping = SoftStepping::Local;
    }
    gas.run.duration = 2.05e-3;
    gas.run.window = Some(1e-5);
    gas.statistics.sample_interval = Some(4e-4);
    gas
}

/// Runs with trajectories into folders, one for each thread in place of a process. A single folder means a single
/// process. The run begins at its start or at the stored state `from`. Returns the result, and the state after `leave`
/// windows (pieces of the run).
fn run(
    experiment: &Experiment,
    folders: &[Folder],
    from: Option<Pause>,
    leave: usize,
) -> (Result<bool, Failure>, Option<Pause>) {
    let start = initial_state(experiment).unwrap();
    let mut crew = Crew::of(folders.len());
    let lead = crew.remove(0);
    std::thread::scope(|scope| {
        for (communicator, folder) in crew.into_iter().zip(&folders[1..]) {
            let start = start.clone();
            scope.spawn(move || {
                std::thread::scope(|scope| {
                    let mut trajectory = Trajectory::new(scope, folder, "some", EVERY);
                    let simulation = Simulation::new(experiment, start).shared(communicator, 1);
                    simulation.follow(&mut |simulation, _, kept| {
                        kept.into_iter().for_each(|kept| trajectory.restore(kept).unwrap());
                        trajectory.see(simulation);
                    });
                });
            });
        }
        let mut trajectory = Trajectory::new(scope, &folders[0], "some", EVERY);
        let mut observers: [&mut dyn Observer; 1] = [&mut trajectory];
        let (simulation, mut course) = match from {
            Some(pause) => pause.resume(experiment, &mut observers).unwrap(),
            None => (Simulation::new(experiment, start), RunLoop::new(&Schedule::new(experiment), 1)),
        };
        let mut simulation = if folders.len() > 1 { simulation.shared(lead, 1) } else { simulation };
        let (mut windows, mut left) = (0, None);
        let mut is_time = || {
            windows += 1;
            windows == leave
        };
        let result = loop {
            match course.run(&mut simulation, &mut observers, &mut is_time) {
                Ok(false) => {
                    simulation.gather(1);
                    left = Some(course.store(&simulation, &observers).unwrap());
                }
                over => break over,
            }
        };
        course.end(&mut simulation, &mut observers, result.as_ref().err());
        (result, left)
    })
}

/// Folder of a run, opened by each of `size` processes.
fn folders(place: &Path, size: usize) -> Vec<Folder> {
    let own = Folder::create(place, true).unwrap();
    std::iter::once(own).chain((1..size).map(|_| Folder::of_another(place))).collect()
}

/// Data of one frame: all numbers of every particle by id, and the number of files.
struct Frame {
    particles: BTreeMap<u32, Vec<u8>>,
    pieces: usize,
}

/// Files that are named in a joining file.
fn sources(text: &str) -> Vec<&str> {
    text.split("Source=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect()
}

/// Reads all frames that the index of the trajectory lists, each with its time [s].
fn frames(place: &Path) -> Vec<(f64, Frame)> {
    let place = place.join("trajectory");
    let index = std::fs::read_to_string(place.join("some.pvd")).unwrap();
    let listed = index.split("timestep=\"").skip(1).step_by(2);
    let frame = |one: &str| {
        let file = place.join(one.split("file=\"").nth(1).unwrap().split('"').next().unwrap());
        let files: Vec<PathBuf> = if file.extension().unwrap() == "pvtp" {
            let text = std::fs::read_to_string(&file).unwrap();
            let pieces: Vec<PathBuf> = sources(&text).into_iter().map(|name| file.with_file_name(name)).collect();
            check_header(&text, &pieces[0]);
            pieces
        } else {
            vec![file]
        };
        let mut particles = BTreeMap::new();
        for file in &files {
            add(&std::fs::read(file).unwrap(), &mut particles);
        }
        (one.split('"').next().unwrap().parse().unwrap(), Frame { particles, pieces: files.len() })
    };
    listed.map(frame).collect()
}

/// Adds the particles of a file.
fn add(file: &[u8], particles: &mut BTreeMap<u32, Vec<u8>>) {
    let ids = numbers(array(file, "id"), u32::from_le_bytes);
    assert!(ids.is_sorted());
    let names = [("Points", 24), ("velocity", 24), ("radius", 8), ("species", 2), ("overlap", 8), ("contacts", 2)];
    let arrays = names.iter().chain(&[("solver", 1)]).map(|(name, size)| {
        let all = array(file, name);
        assert_eq!(all.len(), size * ids.len(), "{name}");
        all.chunks_exact(*size).collect::<Vec<_>>()
    });
    let arrays: Vec<_> = arrays.collect();
    for (k, id) in ids.iter().enumerate() {
        let one = arrays.iter().flat_map(|of_all| of_all[k].to_vec());
        assert!(particles.insert(*id, one.collect()).is_none(), "{id} is in two pieces");
    }
}

/// Checks that the joining file has the time of the pieces, and names the same arrays of points.
fn check_header(joined: &str, piece: &Path) {
    let piece = std::fs::read(piece).unwrap();
    let text = String::from_utf8_lossy(&piece);
    let head = text.split("<Verts>").next().unwrap();
    let declared = |text: &str, tag: &str| -> Vec<String> {
        let arrays = text.split(tag).skip(1).map(|rest| rest.split("NumberOfComponents").collect::<Vec<_>>());
        arrays.filter(|parts| parts.len() > 1).map(|parts| format!("{}{}", parts[0], &parts[1][..4])).collect()
    };
    let of_piece = declared(head, "<DataArray ");
    assert_eq!((of_piece.len(), &of_piece), (8, &declared(joined, "<PDataArray ")));
    let time = |text: &str| text.split("TimeValue").nth(1).unwrap().split("</").next().unwrap().to_owned();
    assert_eq!(time(&text), time(joined));
}

/// Checks that the frames of both runs have identical bits. Returns the number of frames of the second run that
/// consist of several files.
fn same(name: &str, one: &[(f64, Frame)], other: &[(f64, Frame)]) -> usize {
    assert_eq!(one.len(), other.len(), "{name}");
    for ((time, one), (at, other)) in one.iter().zip(other) {
        assert_eq!(time, at, "{name}");
        assert_eq!(one.particles.len(), other.particles.len(), "{name} at {time} s");
        let differ = one.particles.iter().find(|(id, numbers)| other.particles.get(id) != Some(numbers));
        assert!(differ.is_none(), "{name} at {time} s: {differ:?}");
    }
    other.iter().filter(|(_, frame)| frame.pieces > 1).count()
}

#[test]
fn pieces_are_together_the_frame_of_one_process() {
    for model in [Model::Soft, Model::Hard] {
        let (gas, whole) = (gas(model), tempfile::tempdir().unwrap());
        run(&gas, &folders(whole.path(), 1), None, 0).0.unwrap();
        let whole = frames(whole.path());
        assert_eq!(whole.len(), 22);
        let touching = |frame: &Frame| frame.particles.values().filter(|numbers| numbers[66..68] != [0, 0]).count();
        let contacts: usize = whole.iter().map(|(_, frame)| touching(frame)).sum();
        assert!((model == Model::Soft) == (contacts > 200), "{contacts}");
        for size in [2, 3, 5] {
            let parts = tempfile::tempdir().unwrap();
            run(&gas, &folders(parts.path(), size), None, 0).0.unwrap();
            let in_pieces = same(&format!("{model:?} on {size}"), &whole, &frames(parts.path()));
            assert!(in_pieces >= 20, "{model:?} on {size}: {in_pieces} frames in pieces");
        }
    }
}

#[test]
fn a_run_in_pieces_goes_on_with_its_frames_in_any_number_of_processes() {
    let (gas, whole) = (gas(Model::Soft), tempfile::tempdir().unwrap());
    run(&gas, &folders(whole.path(), 1), None, 0).0.unwrap();
    let whole = frames(whole.path());
    let place = tempfile::tempdir().unwrap();
    let (result, left) = run(&gas, &folders(place.path(), 3), None, 97);
    assert!(result.unwrap());
    for size in [2, 1, 4] {
        // files of frames that a run with another number of processes wrote later
        let resume = |_| Folder::resume(place.path()).unwrap();
        let all = (0..1).map(resume).chain((1..size).map(|_| Folder::of_another(place.path())));
        run(&gas, &all.collect::<Vec<_>>(), left.clone(), 0).0.unwrap();
        let found = frames(place.path());
        same(&format!("{size} processes"), &whole, &found);
        let last = &found.last().unwrap().1;
        assert_eq!(last.pieces, size);
        let names = std::fs::read_dir(place.path().join("trajectory/some")).unwrap();
        let names = names.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
        let of_last = names.filter(|name| name.starts_with("000021")).count();
        assert_eq!(of_last, if size > 1 { size + 1 } else { 1 }, "nothing is left of the earlier part");
    }
}

#[test]
fn a_piece_that_cannot_be_written_stops_the_run_with_a_message() {
    let gas = gas(Model::Hard);
    let (place, elsewhere, file) =
        (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap(), tempfile::NamedTempFile::new().unwrap());
    for (folder, words) in
        [(elsewhere.path(), "process 1 has written it, but elsewhere"), (file.path(), "process 1: cannot write")]
    {
        let all = [Folder::create(place.path(), true).unwrap(), Folder::of_another(folder)];
        // a joining file of an earlier part of the run, which is about to be replaced
        std::fs::create_dir_all(place.path().join("trajectory/some")).unwrap();
        std::fs::write(place.path().join("trajectory/some/000001.pvtp"), "written by diptych").unwrap();
        let (result, _) = run(&gas, &all, None, 0);
        let why = result.unwrap_err();
        assert!(matches!(why, Failure::Unwritten { .. }) && why.to_string().contains(words), "{why}");
        // the first frame is complete, and no joining file names missing pieces
        assert_eq!(frames(place.path()).len(), 1);
        assert!(!place.path().join("trajectory/some/000001.pvtp").exists());
    }
}
