//! Connection between the processes that work on one command, for example by MPI.

#[allow(unused_imports, reason = "for the links in the comments")]
use crate::communicator::Communicator;

/// Connection between the processes that work on one command. All methods must be called from the thread that has made
/// the connection.
pub trait Link {
    /// Number of this process, counted from 0 (its rank in MPI).
    fn rank(&self) -> usize;

    /// Number of all processes that work on the command.
    fn size(&self) -> usize;

    /// Number of processes of the command on this computer.
    fn on_this_machine(&self) -> usize;

    /// Sends `bytes` to the process with the number `to`. Messages arrive in the order in which they were sent.
    fn send(&self, to: usize, bytes: &[u8]);

    /// Returns the next message that has arrived from any process, with the number of the sender. `None` if no message
    /// has arrived.
    fn take(&self) -> Option<(usize, Vec<u8>)>;

    /// Returns the bytes `own` of all processes, in the order of their numbers. All processes must call this method.
    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>>;

    /// Sends element k of `outgoing` to process k. Returns the bytes that each process has sent to this one, in the
    /// order of the numbers of the processes, as [`Communicator::exchange`] does.
    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>>;

    /// Returns in all processes the bytes that process 0 has passed, as [`Communicator::broadcast`] does.
    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8>;

    /// Replaces each number of the list by the sum of the numbers at this position over all processes, as
    /// [`Communicator::sum`] does.
    fn sum(&self, numbers: &mut [i64]);

    /// Replaces each value of the list by the largest value at this position in all processes, as
    /// [`Communicator::largest`] does.
    fn largest(&self, values: &mut [f64]);
}

/// Link of a process that works alone. It is process 0, and no other process receives its messages.
pub struct LoneProcess;

impl Link for LoneProcess {
    fn rank(&self) -> usize {
        0
    }

    fn size(&self) -> usize {
        1
    }

    fn on_this_machine(&self) -> usize {
        1
    }

    fn send(&self, _to: usize, _bytes: &[u8]) {}

    fn take(&self) -> Option<(usize, Vec<u8>)> {
        None
    }

    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        vec![own.to_vec()]
    }

    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        outgoing
    }

    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8> {
        bytes
    }

    fn sum(&self, _numbers: &mut [i64]) {}

    fn largest(&self, _values: &mut [f64]) {}
}

/// True if Open MPI, MPICH and its relatives, or Slurm with PMIx has started this process as one of several. Each of
/// these programs sets one of the environment variables below to the number of the process.
pub fn is_one_of_several() -> bool {
    ["OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"].iter().any(|name| std::env::var_os(name).is_some())
}
