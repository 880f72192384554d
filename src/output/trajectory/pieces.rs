//! Frames (files of one instant) of a trajectory of a run that several processes share. Each process writes its own
//! particles as a piece of the frame, and the lead process (rank 0) joins the pieces.

use super::frame::{Cast, TrajectoryFrame};
use super::{TRAJECTORY, Trajectory, WriterMessage};
use crate::communicator::Communicator;
use crate::output::{Folder, OutputError};
use crate::simulation::Simulation;
use std::io::{Error, ErrorKind};

/// Path of the file in which the process with the number `rank` writes its particles at one instant (frame) of a
/// trajectory, relative to the folder of results. `number` is the number of the frame.
pub(super) fn piece(name: &str, number: usize, rank: usize) -> String {
    format!("{TRAJECTORY}/{name}/{number:06}-{rank}.vtp")
}

/// Path of the file that joins the pieces of a frame (files with the particles of one process at one instant), relative
/// to the folder of results. `number` is the number of the frame.
pub(super) fn joined(name: &str, number: usize) -> String {
    format!("{TRAJECTORY}/{name}/{number:06}.pvtp")
}

/// Piece of a frame: the particles of this process at one instant. The memory is reused from instant to instant.
#[derive(Debug, Default)]
pub(super) struct FramePiece {
    frame: TrajectoryFrame,
    bytes: Vec<u8>,
}

impl FramePiece {
    /// Writes the particles of this process into the file with the name `name` in a folder of results.
    fn write(&mut self, simulation: &Simulation, folder: &Folder, name: &str) -> Result<(), OutputError> {
        self.frame.take(simulation);
        self.frame.sort();
        // each frame has its own ids, radii and species, because particles move between processes
        let mut cast = Cast::of(simulation);
        cast.sort();
        let parts = self.frame.vtp(&cast, std::mem::take(&mut self.bytes));
        folder.write_parts(name, &parts)?;
        let [_, data, _] = parts;
        self.bytes = data;
        Ok(())
    }
}

impl Trajectory<'_> {
    /// Writes the particles of this process as a piece of the next frame (file of one instant). All processes must call
    /// this function. When all pieces exist, the writing thread of the lead process joins them. If one piece cannot be
    /// written, the trajectory of the lead process fails.
    pub(super) fn take_part(&mut self, simulation: &Simulation, processes: &dyn Communicator) {
        let leads = processes.is_lead();
        let mut number = [if leads { self.next_frame(simulation) } else { 0 }];
        processes.sum(&mut number);
        // the sum is the frame number of the lead process, because all other processes contribute 0; a negative number
        // means that writing has failed in the lead process, or that the frame exists
        let Ok(number) = usize::try_from(number[0]) else { return };
        let own = piece(&self.name, number, processes.rank());
        let result = self.piece.write(simulation, self.folder, &own);
        let words = result.err().map(|why| why.to_string()).unwrap_or_default();
        let told = processes.collect(words.into_bytes());
        if !leads {
            return;
        }
        let wrong = told.iter().enumerate().find_map(|(process, why)| {
            let why = String::from_utf8_lossy(why).into_owned();
            if why.is_empty() { self.missing(number, process) } else { Some(OutputError::OfProcess { process, why }) }
        });
        if let Some(why) = wrong {
            self.failed = Some(why);
            return;
        }
        self.times.push(simulation.time);
        self.send(WriterMessage::Pieces(simulation.time, processes.size()));
    }

    /// Number of the frame (instant of the trajectory) that all processes are to write; -1 if this frame exists or
    /// writing has failed. If there is a frame to write, all earlier frames of this run are written on return. A file
    /// that would join incomplete pieces of this frame has been removed.
    fn next_frame(&mut self, simulation: &Simulation) -> i64 {
        let number = self.times.len();
        if self.is_done(simulation.time) {
            return -1;
        }
        self.begin(simulation);
        self.progress.wait((number - self.earlier) as u64);
        // if each process writes a piece of the frame, no memory for all particles is needed
        while self.used.try_recv().is_ok() {}
        self.has_cast = false;
        let ready = self.folder.make_room().and_then(|()| self.folder.remove(&[joined(&self.name, number)]));
        self.failed = ready.err();
        if self.failed.is_some() || self.progress.now().failed.is_some() { -1 } else { number as i64 }
    }

    /// Error if the piece of the process with the number `process` does not exist in the folder of this process;
    /// otherwise `None`. `number` is the number of the frame (instant of the trajectory).
    fn missing(&self, number: usize, process: usize) -> Option<OutputError> {
        let path = self.folder.path().join(piece(&self.name, number, process));
        let why = || {
            Error::new(
                ErrorKind::NotFound,
                format!("process {process} has written it, but elsewhere: all must share the folder of results"),
            )
        };
        (!path.exists()).then(|| OutputError::io("find", &path, why()))
    }
}
