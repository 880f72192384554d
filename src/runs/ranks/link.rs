//! Connection between the processes that work on one command.

#[allow(unused_imports, reason = "for the links in the comments")]
use crate::communicator::Communicator;

/// Connection between the processes that work on one command. All methods must be called from the thread that made the
/// connection.
pub trait Link {
    /// Number of this process, from 0 (MPI: rank).
    fn rank(&self) -> usize;

    /// Number of processes that work on the command.
    fn size(&self) -> usize;

    /// Number of processes of the command that run on this computer.
    fn on_this_machine(&self) -> usize;

    /// Sends bytes to another process. Messages arrive in the order in which they were sent.
    fn send(&self, to: usize, bytes: &[u8]);

    /// Takes the next message that has arrived from any process, with the number of its sender; `None` if there is
    /// none.
    fn take(&self) -> Option<(usize, Vec<u8>)>;

    /// Gathers the bytes of all processes, in the order of their numbers. All processes must call this method.
    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>>;

    /// Exchanges bytes between all pairs of processes, as in [`Communicator::exchange`].
    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>>;

    /// Sends bytes of one process to all others, as in [`Communicator::broadcast`].
    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8>;

    /// Replaces each number by its sum over all processes, as in [`Communicator::sum`].
    fn sum(&self, numbers: &mut [i64]);

    /// Replaces each value by the largest one of all processes, as in [`Communicator::largest`].
    fn largest(&self, values: &mut [f64]);
}

/// Link of a process that works alone: it is process 0 of one, and has no other process to send to.
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

/// True if this process was started as one of several by Open MPI, MPICH and its relatives, or Slurm with PMIx. Each of
/// these sets one of the variables below to the number of the process.
pub fn is_one_of_several() -> bool {
    ["OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"].iter().any(|name| std::env::var_os(name).is_some())
}
