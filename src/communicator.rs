//! How processes that share one run reach one another. What joins them (MPI, or threads in tests) is lent to a simulation.

use crate::exact::ExactSum;

/// Processes that share one run. Everybody calls the same methods in the same order: each is answered when all have called it.
/// Process 0 is the lead.
pub trait Communicator: Send + Sync {
    /// Number of this process, from 0.
    fn rank(&self) -> usize;

    /// How many there are.
    fn size(&self) -> usize;

    /// Sends to each process the bytes that stand at its number; returns what each has sent to this one, in the order of their numbers.
    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>>;

    /// The bytes of the lead; those of the others do not matter.
    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8>;

    /// Puts in place of each number its sum over all processes.
    fn sum(&self, numbers: &mut [i64]);

    /// Puts in place of each value the largest of all processes.
    fn largest(&self, values: &mut [f64]);

    /// Whether this is the lead.
    fn is_lead(&self) -> bool {
        self.rank() == 0
    }

    /// Puts in place of each sum that of all processes.
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

    /// Sends bytes to the lead, who gets those of all in the order of their numbers; the others get none.
    fn collect(&self, own: Vec<u8>) -> Vec<Vec<u8>> {
        let mut outgoing = vec![Vec::new(); self.size()];
        if let Some(lead) = outgoing.first_mut() {
            *lead = own;
        }
        let all = self.exchange(outgoing);
        if self.is_lead() { all } else { Vec::new() }
    }
}
