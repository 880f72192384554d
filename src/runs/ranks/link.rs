//! Connection between processes.

#[allow(unused_imports, reason = "for the links in the comments")]
use crate::communicator::Communicator;

/// Communication between the processes that work on one command. All methods are called from the thread that made the
/// link.
pub trait Link {
    /// Number of this process, from 0.
    fn rank(&self) -> usize;

    /// Number of processes.
    fn size(&self) -> usize;

    /// Number of processes on this machine.
    fn on_this_machine(&self) -> usize;

    /// Sends bytes to another process; they arrive in the order in which they were sent.
    fn send(&self, to: usize, bytes: &[u8]);

    /// Next message that has arrived from any process and has not been taken yet, with the number of its sender.
    fn take(&self) -> Option<(usize, Vec<u8>)>;

    /// The bytes of all processes, in the order of their numbers. All processes must call this.
    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>>;

    /// Exchanges bytes, as in [`Communicator::exchange`].
    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>>;

    /// Broadcasts bytes, as in [`Communicator::broadcast`].
    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8>;

    /// Sums numbers, as in [`Communicator::sum`].
    fn sum(&self, numbers: &mut [i64]);

    /// Takes the largest values, as in [`Communicator::largest`].
    fn largest(&self, values: &mut [f64]);
}

/// A process by itself.
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

/// True if this process was started as one of several: by Open MPI, MPICH and its relatives, or Slurm with PMIx. Each
/// of them gives its processes a number in one of these variables.
pub fn is_one_of_several() -> bool {
    ["OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"].iter().any(|name| std::env::var_os(name).is_some())
}
