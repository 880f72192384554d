//! The particles at common times, for ParaView (`.vtp` with a `.pvd`), OVITO and ASE (extended XYZ).
//!
//! An observer copies what it needs of the simulation and hands it to a thread that sorts and writes, each file whole or not at
//! all. It holds two frames at most, however long the run is; where the disk is slower than the run, the run waits.

mod frame;
mod vtp;
mod walls;

pub(super) use walls::flat;

use super::{Folder, OutputError};
use crate::experiment::{Trajectories, TrajectoryFormat};
use crate::observe::{Observer, Sight};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::stored::{StoreError, Stored};
use frame::{Cast, Frame};
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
enum Message {
    /// The cast, the walls, and the times [s] of frames that are there already.
    Begin(Box<Cast>, Option<[Vec<u8>; 3]>, Vec<f64>),
    Frame(Frame),
}

/// How far the thread that writes is.
#[derive(Default)]
struct Progress {
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

impl Progress {
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
struct Ended(Arc<Progress>);

impl Drop for Ended {
    fn drop(&mut self) {
        self.0.tell(|written| written.ended = true);
    }
}

/// Hands the particles to a thread that writes them.
pub struct Trajectory<'scope> {
    asked: Trajectories,
    /// `None` once it is over.
    frames: Option<SyncSender<Message>>,
    /// Frames that have been written, for their memory.
    used: Receiver<Frame>,
    writer: Option<ScopedJoinHandle<'scope, Result<(), OutputError>>>,
    progress: Arc<Progress>,
    /// Whether the thread knows the cast.
    begun: bool,
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
        let progress = Arc::new(Progress::default());
        let ended = Ended(progress.clone());
        let format = asked.format;
        let writer = Writer { folder, name: name.to_owned(), format, times: Vec::new(), listed: 0, walls: false };
        let writer = scope.spawn(move || {
            let result = writer.write(&to_write, |frame| {
                ended.0.tell(|written| written.frames += 1);
                drop(give_back.send(frame));
            });
            if let Err(why) = &result {
                ended.0.tell(|written| written.failed = Some(why.to_string()));
            }
            result
        });
        let (frames, writer) = (Some(frames), Some(writer));
        Self { asked, frames, used, writer, progress, begun: false, times: Vec::new(), earlier: 0, failed: None }
    }

    fn send(&mut self, message: Message) {
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
        self.failed = writer.join().unwrap_or_else(panicked).err();
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

    fn see(&mut self, simulation: &Simulation) {
        if !self.begun {
            let walls = walls::walls(simulation.scene());
            self.send(Message::Begin(Box::new(Cast::of(simulation)), walls, self.times.clone()));
            self.begun = true;
        }
        self.times.push(simulation.time);
        let mut frame = self.used.try_recv().unwrap_or_default();
        frame.take(simulation);
        self.send(Message::Frame(frame));
    }

    fn sight_of_end(&self, _now: f64) -> Sight {
        Sight::Every(1)
    }

    fn end(&mut self, simulation: &Simulation) {
        if self.times.last().is_none_or(|last| *last < simulation.time) {
            self.see(simulation);
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
    /// [s] of the frames written.
    times: Vec<f64>,
    /// How many of them the index lists.
    listed: usize,
    walls: bool,
}

impl Writer<'_> {
    fn write(mut self, messages: &Receiver<Message>, give_back: impl Fn(Frame)) -> Result<(), OutputError> {
        let (mut cast, mut memory) = (None, Vec::new());
        for message in messages {
            match message {
                Message::Begin(mut all, walls, times) => {
                    all.sort();
                    cast = Some(all);
                    (self.listed, self.times) = (times.len(), times);
                    self.walls = walls.is_some() && self.format.is_vtp();
                    if let Some(walls) = walls.filter(|_| self.walls) {
                        self.folder.write_parts(&format!("{TRAJECTORY}/{}-walls.vtp", self.name), &walls)?;
                    }
                }
                Message::Frame(mut frame) => {
                    if let Some(cast) = &cast {
                        frame.sort();
                        memory = self.frame(cast, &frame, memory)?;
                    }
                    give_back(frame);
                }
            }
        }
        self.list()
    }

    fn frame(&mut self, cast: &Cast, frame: &Frame, memory: Vec<u8>) -> Result<Vec<u8>, OutputError> {
        let path = format!("{TRAJECTORY}/{}/{:06}", self.name, self.times.len());
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
        self.times.push(frame.time);
        // an index of all frames after each of them would take the square of their number
        if self.times.len() <= 100 || self.times.len() >= self.listed + self.listed / 20 {
            self.list()?;
        }
        Ok(memory)
    }

    /// The index that ParaView opens: time and file of every frame.
    fn list(&mut self) -> Result<(), OutputError> {
        if !self.format.is_vtp() || self.listed == self.times.len() {
            return Ok(());
        }
        let name = &self.name;
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<!-- written by diptych -->\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n",
        );
        for (number, time) in self.times.iter().enumerate() {
            // to a string nothing can fail
            let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{name}/{number:06}.vtp\"/>");
            if self.walls {
                let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"1\" file=\"{name}-walls.vtp\"/>");
            }
        }
        text += "</Collection>\n</VTKFile>\n";
        self.folder.write_parts(&format!("{TRAJECTORY}/{name}.pvd"), &[text.into_bytes()])?;
        self.listed = self.times.len();
        Ok(())
    }
}
