//! The velocity profile the engines read.

/// Streamwise gas velocity u_z(y), y in [0, height].
#[derive(Clone, Debug)]
pub enum Profile {
    /// [m/s] the same everywhere.
    Uniform(f64),
}

impl Profile {
    /// Stub until the k-ε solver is merged.
    ///
    /// # Errors
    /// Never.
    pub fn k_epsilon_channel(
        bulk_velocity: f64,
        _height: f64,
        _nu: f64,
        _model: super::k_epsilon::TurbulenceModel,
    ) -> Result<Self, String> {
        Ok(Self::Uniform(bulk_velocity))
    }

    /// Stub until tables are merged.
    ///
    /// # Errors
    /// An empty table.
    pub fn table(points: &[(f64, f64)]) -> Result<Self, String> {
        points.first().map(|point| Self::Uniform(point.1)).ok_or_else(|| "empty".into())
    }

    /// [m/s] streamwise gas velocity at distance `y` [m] from the wall y = 0.
    #[inline]
    pub fn velocity(&self, y: f64) -> f64 {
        let _ = y;
        match self {
            Self::Uniform(velocity) => *velocity,
        }
    }
}
