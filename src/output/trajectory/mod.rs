//! The particles at common times, for ParaView (`.vtp` with a `.pvd`), OVITO and ASE (extended XYZ).
//!
//! An observer copies what it needs of the simulation and hands it to a thread that sorts and writes, each file whole or not at
//! all. It holds two frames at most, however long the run is; where the disk is slower than the run, the run waits.
//!
//! Where processes share a run and each has a part of the particles, each writes its part of a frame as a VTK file, and waits until all
//! have done so; then the lead's thread writes the file that joins these pieces (`.pvtp`).

mod frame;
mod pieces;
mod vtp;
mod walls;

pub(super) use walls::flat;

use super::{Folder, OutputError};
use crate::experiment::{Trajectories, TrajectoryFormat};
use crate::observe::{Needs, Observer};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::stored::{StoreError, Stored};
use frame::{Cast, TrajectoryFrame};
use pieces::FramePiece;
use std::fmt::Write;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Scope, ScopedJoinHandle};

/// The subfolder of trajectories.
pub const TRAJECTORY: &str = "trajectory";

/// Whether a file is one that a trajectory wrote: it says so at its beginning. Others in the folder are the user's own.
pub(super) fn is_ours(path: &Path) -> bool {
    let mut beginning = [0; 512];
    let read = File::open(path).and_then(|mut file| file.read(&mut beginning));
    read.is_ok_and(|length| beginning[..length].windows(7).any(|word| word == b"diptych"))
}

/// What goes to the thread that writes.
enum WriterMessage {
    /// The walls, and the times [s] of frames that are there already.
    Begin(Option<[Vec<u8>; 3]>, Vec<f64>),
    /// The cast of the frames that follow.
    Cast(Box<Cast>),
    Frame(TrajectoryFrame),
    /// So many processes have written their pieces of the frame at that time [s].
    Pieces(f64, usize),
}

/// How far the thread that writes is.
#[derive(Default)]
struct WriterProgress {
    written: Mutex<Written>,
    changed: Condvar,
}

/// What the thread has written.
#[derive(Default)]
struct Written {
    frames: u64,
    /// Whether no more will be.
    ended: bool,
    /// Why it cannot write.
    failed: Option<String>,
}

impl WriterProgress {
    fn now(&self) -> MutexGuard<'_, Written> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn tell(&self, change: impl FnOnce(&mut Written)) {
        change(&mut self.now());
        self.changed.notify_all();
    }

    /// Waits until so many frames are written, or no more will be.
    fn wait(&self, frames: u64) {
        drop(self.changed.wait_while(self.now(), |written| written.frames < frames && !written.ended));
    }
}

/// Says that the thread has ended, in whatever way.
struct Ended(Arc<WriterProgress>);

impl Drop for Ended {
    fn drop(&mut self) {
        self.0.tell(|written| written.ended = true);
    }
}

/// Hands the particles to a thread that writes them.
pub struct Trajectory<'scope> {
    folder: &'scope Folder,
    name: String,
    asked: Trajectories,
    /// `None` once it is over.
    frames: Option<SyncSender<WriterMessage>>,
    /// Frames that have been written, for their memory.
    used: Receiver<TrajectoryFrame>,
    writer: Option<ScopedJoinHandle<'scope, Result<(), OutputError>>>,
    progress: Arc<WriterProgress>,
    /// Whether the thread knows the walls.
    begun: bool,
    /// Whether it knows the cast.
    has_cast: bool,
    /// The part of a frame that this process writes by itself.
    piece: FramePiece,
    /// [s] of the frames of earlier parts of the run and of this one.
    times: Vec<f64>,
    /// How many of them were there before this part of the run.
    earlier: usize,
    failed: Option<OutputError>,
}

impl<'scope> Trajectory<'scope> {
    /// Into `trajectory/NAME` of a folder; the thread that writes belongs to `scope`.
    pub fn new<'env>(
        scope: &'scope Scope<'scope, 'env>,
        folder: &'env Folder,
        name: &str,
        asked: Trajectories,
    ) -> Self {
        let (frames, to_write) = sync_channel(1);
        let (give_back, used) = channel();
        let progress = Arc::new(WriterProgress::default());
        let ended = Ended(progress.clone());
        let format = asked.format;
        let writer = Writer {
            folder,
            name: name.to_owned(),
            format,
            frames: Vec::new(),
            listed: 0,
            walls: false,
            spare: Vec::new(),
        };
        let writer = scope.spawn(move || {
            let result = writer.write(&to_write, |frame| {
                ended.0.tell(|written| written.frames += 1);
                frame.into_iter().for_each(|frame| drop(give_back.send(frame)));
            });
            if let Err(why) = &result {
                ended.0.tell(|written| written.failed = Some(why.to_string()));
            }
            result
        });
        Self {
            folder,
            name: name.to_owned(),
            asked,
            frames: Some(frames),
            used,
            writer: Some(writer),
            progress,
            begun: false,
            has_cast: false,
            piece: FramePiece::default(),
            times: Vec::new(),
            earlier: 0,
            failed: None,
        }
    }

    fn send(&mut self, message: WriterMessage) {
        // a writer that has gone has left its reason behind
        if self.frames.as_ref().is_none_or(|frames| frames.send(message).is_err()) {
            self.finish();
        }
    }

    /// Waits until all is written.
    fn finish(&mut self) {
        self.frames = None;
        let Some(writer) = self.writer.take() else { return };
        let panicked = |_| {
            let why = std::io::Error::other("the thread that writes them has panicked");
            Err(OutputError::io("write the trajectories into", Path::new(TRAJECTORY), why))
        };
        let failed = writer.join().unwrap_or_else(panicked).err();
        self.failed = self.failed.take().or(failed);
    }

    /// Whether nothing is to be written of that time [s]: there is a frame of it, or one before could not be written.
    fn is_done(&self, time: f64) -> bool {
        self.failed.is_some() || self.times.last().is_some_and(|last| *last >= time)
    }

    /// Tells the thread what it needs to know before the first frame.
    fn begin(&mut self, simulation: &Simulation) {
        if !self.begun {
            self.send(WriterMessage::Begin(walls::walls(simulation.scene()), self.times.clone()));
            self.begun = true;
        }
    }

    /// Hands all particles to the thread.
    fn take_all(&mut self, simulation: &Simulation) {
        if self.is_done(simulation.time) {
            return;
        }
        self.begin(simulation);
        if !self.has_cast {
            self.send(WriterMessage::Cast(Box::new(Cast::of(simulation))));
            self.has_cast = true;
        }
        self.times.push(simulation.time);
        let mut frame = self.used.try_recv().unwrap_or_default();
        frame.take(simulation);
        self.send(WriterMessage::Frame(frame));
    }

    /// Whether all could be written.
    ///
    /// # Errors
    /// A frame could not be written.
    pub fn written(mut self) -> Result<(), OutputError> {
        self.finish();
        self.failed.map_or(Ok(()), Err)
    }
}

impl Observer for Trajectory<'_> {
    /// The next whole multiple of the time asked for: the same in every variant, however its windows lie.
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        // rounding of a sum of windows
        Some(((now / self.asked.every * (1.0 + 1e-9)).floor() + 1.0) * self.asked.every)
    }

    /// Extended XYZ is one file of all particles.
    fn sight(&self) -> Needs {
        if self.asked.format.is_xyz() { Needs::Every(1) } else { Needs::Parts }
    }

    fn see(&mut self, simulation: &Simulation) {
        match simulation.parts() {
            Some(processes) => self.take_part(simulation, processes),
            None => self.take_all(simulation),
        }
    }

    fn sight_of_end(&self, now: f64) -> Needs {
        if self.is_done(now) { Needs::Nothing } else { self.sight() }
    }

    fn end(&mut self, simulation: &Simulation) {
        // of parts the last has been seen by all processes together
        if simulation.parts().is_none() {
            self.take_all(simulation);
        }
        self.finish();
    }

    /// The times of all frames, once they are written: a run that goes on counts from there.
    fn stored(&self) -> Result<Stored, StoreError> {
        self.progress.wait((self.times.len() - self.earlier) as u64);
        Stored::of(&self.times)
    }

    fn restore(&mut self, stored: &Stored) -> Result<(), StoreError> {
        self.times = stored.read()?;
        self.earlier = self.times.len();
        Ok(())
    }

    fn stop(&self) -> Option<String> {
        self.progress.now().failed.clone().or_else(|| self.failed.as_ref().map(ToString::to_string))
    }
}

/// Writes what it is given.
struct Writer<'env> {
    folder: &'env Folder,
    name: String,
    format: TrajectoryFormat,
    /// [s] of the frames written, and whether each is in pieces.
    frames: Vec<(f64, bool)>,
    /// How many of them the index lists.
    listed: usize,
    walls: bool,
    /// Files of such frames that another part of the run has left, which the next index no longer lists.
    spare: Vec<String>,
}

impl Writer<'_> {
    fn write(
        mut self,
        messages: &Receiver<WriterMessage>,
        written: impl Fn(Option<TrajectoryFrame>),
    ) -> Result<(), OutputError> {
        let (mut cast, mut memory) = (None, Vec::new());
        for message in messages {
            match message {
                WriterMessage::Begin(walls, times) => self.begin(walls, &times)?,
                WriterMessage::Cast(mut all) => {
                    all.sort();
                    cast = Some(all);
                }
                WriterMessage::Frame(mut frame) => {
                    if let Some(cast) = &cast {
                        frame.sort();
                        memory = self.frame(cast, &frame, memory)?;
                    }
                    written(Some(frame));
                }
                WriterMessage::Pieces(time, count) => {
                    // room for all particles is given back
                    (cast, memory) = (None, Vec::new());
                    self.join(time, count)?;
                    written(None);
                }
            }
        }
        let gone = self.gone();
        self.list(&gone)?;
        match gone.first() {
            None => Ok(()),
            Some(first) => {
                let path = self.folder.path().join(self.file(*first));
                Err(OutputError::Gone { path, gone: gone.len(), frames: self.frames.len() })
            }
        }
    }

    /// Numbers of frames whose files are there no more.
    fn gone(&self) -> Vec<usize> {
        let is_gone = |number: &usize| !self.folder.path().join(self.file(*number)).exists();
        (0..self.frames.len()).filter(is_gone).collect()
    }

    /// The file of a frame, relative to the folder of results.
    fn file(&self, number: usize) -> String {
        let kind = match self.frames[number].1 {
            true => "pvtp",
            false if self.format.is_vtp() => "vtp",
            false => "xyz",
        };
        format!("{TRAJECTORY}/{}/{number:06}.{kind}", self.name)
    }

    fn begin(&mut self, walls: Option<[Vec<u8>; 3]>, times: &[f64]) -> Result<(), OutputError> {
        let is_joined = |number| self.folder.path().join(pieces::joined(&self.name, number)).exists();
        self.frames = times.iter().enumerate().map(|(number, time)| (*time, is_joined(number))).collect();
        self.listed = times.len();
        self.walls = walls.is_some() && self.format.is_vtp();
        if let Some(walls) = walls.filter(|_| self.walls) {
            self.folder.write_parts(&format!("{TRAJECTORY}/{}-walls.vtp", self.name), &walls)?;
        }
        Ok(())
    }

    fn frame(&mut self, cast: &Cast, frame: &TrajectoryFrame, memory: Vec<u8>) -> Result<Vec<u8>, OutputError> {
        let number = self.frames.len();
        let path = format!("{TRAJECTORY}/{}/{number:06}", self.name);
        let mut memory = memory;
        if self.format.is_vtp() {
            let parts = frame.vtp(cast, memory);
            self.folder.write_parts(&format!("{path}.vtp"), &parts)?;
            let [_, data, _] = parts;
            memory = data;
        }
        if self.format.is_xyz() {
            self.folder.write_parts(&format!("{path}.xyz"), &[frame.xyz(cast)])?;
        }
        self.spare.push(pieces::joined(&self.name, number));
        self.spare.extend(self.pieces_from(number, 0));
        self.is_written(frame.time, false)?;
        Ok(memory)
    }

    /// Writes the file that joins the pieces of a frame.
    fn join(&mut self, time: f64, count: usize) -> Result<(), OutputError> {
        let number = self.frames.len();
        let sources = (0..count).map(|rank| format!("{number:06}-{rank}.vtp"));
        self.folder.write_parts(&pieces::joined(&self.name, number), &[TrajectoryFrame::joined(time, sources)])?;
        self.spare.push(format!("{TRAJECTORY}/{}/{number:06}.vtp", self.name));
        self.spare.extend(self.pieces_from(number, count));
        self.is_written(time, true)
    }

    /// Pieces of a frame that are there, of processes from that number on.
    fn pieces_from(&self, number: usize, rank: usize) -> Vec<String> {
        let names = (rank..).map(|rank| pieces::piece(&self.name, number, rank));
        names.take_while(|name| self.folder.path().join(name).exists()).collect()
    }

    fn is_written(&mut self, time: f64, in_pieces: bool) -> Result<(), OutputError> {
        self.frames.push((time, in_pieces));
        // an index of all frames after each of them would take the square of their number
        if self.frames.len() <= 100 || self.frames.len() >= self.listed + self.listed / 20 {
            self.list(&[])?;
        }
        Ok(())
    }

    /// The index that ParaView opens: time and file of every frame but those that are gone.
    fn list(&mut self, gone: &[usize]) -> Result<(), OutputError> {
        if !self.format.is_vtp() || gone.is_empty() && self.listed == self.frames.len() {
            return Ok(());
        }
        let name = &self.name;
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<!-- written by diptych -->\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n",
        );
        for (number, (time, in_pieces)) in self.frames.iter().enumerate() {
            if gone.binary_search(&number).is_ok() {
                continue;
            }
            let kind = if *in_pieces { "pvtp" } else { "vtp" };
            // to a string nothing can fail
            let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{name}/{number:06}.{kind}\"/>");
            if self.walls {
                let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"1\" file=\"{name}-walls.vtp\"/>");
            }
        }
        text += "</Collection>\n</VTKFile>\n";
        self.folder.write_parts(&format!("{TRAJECTORY}/{name}.pvd"), &[text.into_bytes()])?;
        self.listed = self.frames.len();
        self.folder.remove(&std::mem::take(&mut self.spare))
    }
}
