//! Communication among processes that share one run. The program that starts a simulation passes an implementation of
//! the trait [`Communicator`]: MPI, or threads in tests.

use crate::exact::ExactSum;

/// Connection between the processes that share one run. All processes must call the same methods in the same order. A
/// call returns when all processes have made this call. Process 0 is called the lead.
pub trait Communicator: Send + Sync {
    /// Number of this process, counted from 0.
    fn rank(&self) -> usize;

    /// Number of processes that share the run.
    fn size(&self) -> usize;

    /// Sends `outgoing[k]` to process k, for all k. Returns the bytes that each process sent to this process, in the
    /// order of process numbers.
    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>>;

    /// Sends the bytes of the lead (process 0) to all processes and returns them. The arguments of the other processes
    /// are ignored.
    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8>;

    /// Replaces each number of the list by the sum, over all processes, of the numbers at this position in their
    /// lists.
    fn sum(&self, numbers: &mut [i64]);

    /// Replaces each value of the list by the largest value that any process has at this position in its list.
    fn largest(&self, values: &mut [f64]);

    /// True if this process is the lead, which is process 0.
    fn is_lead(&self) -> bool {
        self.rank() == 0
    }

    /// Replaces each sum of this process by its total over all processes. An [`ExactSum`] is free of rounding, so the
    /// total does not depend on the order of the processes.
    fn total(&self, sums: &mut [&mut ExactSum]) {
        let mut words: Vec<i64> = sums.iter_mut().flat_map(|sum| *sum.words()).collect();
        self.sum(&mut words);
        let mut rest = words.as_slice();
        for sum in sums {
            let own = sum.words();
            let (first, others) = rest.split_at(own.len());
            own.copy_from_slice(first);
            rest = others;
        }
    }

    /// Sends the bytes of every process to the lead (process 0). In the lead, returns the bytes of all processes in the
    /// order of their numbers; in the other processes, returns an empty list.
    fn collect(&self, own: Vec<u8>) -> Vec<Vec<u8>> {
        let mut outgoing = vec![Vec::new(); self.size()];
        if let Some(lead) = outgoing.first_mut() {
            *lead = own;
        }
        let all = self.exchange(outgoing);
        if self.is_lead() { all } else { Vec::new() }
    }
}
