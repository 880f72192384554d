//! Numbers of particles that are expected during a run, including those that inlets bring.

use super::Experiment;
use crate::scene::Inlet;

/// [-] largest volume fraction up to which inlets fill a scene: that of random close packing, 0.64 (Scott and Kilgour
/// 1969, J. Phys. D 2, 863).
const PACKED: f64 = 0.64;

impl Experiment {
    /// Expected largest number of particles of each species in the scene: those of the start, and those that inlets
    /// bring. In a scene with outlets, an inlet contributes at most the particles that come in while one particle
    /// crosses the diagonal of the box, and one more. The speed of this particle is the root mean square of the speeds
    /// at the inlet. Particles from inlets fill at most the volume fraction of random close packing.
    ///
    /// Without inlets these are the numbers at the start.
    pub fn expected_counts(&self) -> Vec<f64> {
        let (scene, counts) = (&self.scene, self.counts());
        let mut coming = vec![0.0; counts.len()];
        for inlet in &scene.inlets {
            coming[usize::from(inlet.species)] += self.expected_from(inlet);
        }
        let filled: f64 = coming.iter().zip(&scene.species).map(|(count, species)| count * species.volume()).sum();
        let share = if filled > 0.0 { (PACKED * scene.room() / filled).min(1.0) } else { 1.0 };
        counts.into_iter().zip(coming).map(|(count, coming)| count as f64 + share * coming).collect()
    }

    /// Expected largest number of particles of all species in the scene, including those that inlets bring.
    pub fn expected_count(&self) -> f64 {
        self.expected_counts().iter().sum()
    }

    /// Expected largest number of particles of each species in the scene, rounded up.
    pub fn expected_numbers(&self) -> Vec<usize> {
        self.expected_counts().into_iter().map(|count| count.ceil() as usize).collect()
    }

    /// Expected largest number of particles that came from an inlet and are in the scene at the same time.
    fn expected_from(&self, inlet: &Inlet) -> f64 {
        let due = inlet.due(self.run.duration) as f64;
        if self.scene.outlets.is_empty() {
            return due;
        }
        let speed = (inlet.velocity_mean.norm_squared() + inlet.velocity_fluctuation.norm_squared()).sqrt();
        due.min(1.0 + inlet.rate * self.scene.domain.size.norm() / speed)
    }
}
