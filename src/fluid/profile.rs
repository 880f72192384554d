//! The velocity profile the engines read.

/// Streamwise gas velocity u_z(y), y in [0, height].
#[derive(Clone, Debug)]
pub enum Profile {
    /// [m/s] the same everywhere.
    Uniform(f64),
}

impl Profile {
    /// [m/s] streamwise gas velocity at distance `y` [m] from the wall y = 0.
    #[inline]
    pub fn velocity(&self, y: f64) -> f64 {
        let _ = y;
        match self {
            Self::Uniform(velocity) => *velocity,
        }
    }
}
