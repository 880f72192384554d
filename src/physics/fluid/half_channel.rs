//! Finite-volume equations from the wall of a channel to its centre plane, or from the wall of a pipe to its axis. All
//! quantities are in wall units.

use super::k_epsilon::{C_MU, GridNode, KBudget, Section, TurbulenceModel};
use super::{launder_sharma, wall_functions};
use serde::{Deserialize, Serialize};

/// Flow in one half of a channel, in wall units: lengths are in units of ν/u_τ, velocities in units of u_τ. The
/// viscosity ν and the wall stress τ_w are then 1, and the half height h is Re_τ.
///
/// The flow may also be that in a pipe of radius h, because the stress in a pipe also falls linearly, to 0 at the axis.
/// In a pipe the area of a face is proportional to its distance r from the axis. The equation of a quantity φ with the
/// diffusivity D is then (1/r) d/dr(r D dφ/dr) = sink φ - source.
///
/// Values are given at cell centres. Face number `i` is between cells `i - 1` and `i`. Face 0 is the wall. The last
/// face is the centre plane, which has no flux.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct HalfChannel {
    /// Cross-section of the flow: channel or pipe.
    pub section: Section,
    /// [-] half height h⁺ of the channel, or radius of the pipe.
    pub reynolds_tau: f64,
    /// [-] distance y⁺ of the faces from the wall.
    pub face: Vec<f64>,
    /// [-] distance y⁺ of the cell centres from the wall.
    pub y: Vec<f64>,
    /// [-] mean velocity u⁺ = u/u_τ in each cell.
    pub u: Vec<f64>,
    /// [-] turbulent kinetic energy k⁺ = k/u_τ² in each cell.
    pub k: Vec<f64>,
    /// [-] dissipation rate in units of u_τ⁴/ν. For the Launder-Sharma model it is ε̃ = ε - 2ν (d√k/dy)², with the
    /// turbulent kinetic energy k; otherwise it is ε.
    pub epsilon: Vec<f64>,
    /// [-] eddy viscosity ν_t over ν in each cell.
    pub nu_t: Vec<f64>,
    /// [-] shear stress (1 + ν_t) dU/dy at the faces, with the eddy viscosity ν_t, for a gas that particles brake or
    /// drive. `None` for a gas alone, whose stress is 1 - y/h.
    pub face_stress: Option<Vec<f64>>,
}

/// Parameters of one sweep, which updates the turbulent kinetic energy k and its dissipation rate ε once.
pub(super) struct SweepStep<'a> {
    /// [-] weight of the newly computed values in the next iterate; the previous values have the remaining weight.
    pub relaxation: f64,
    /// [-] 1/Δt in wall units, with the time step Δt of the implicit Euler scheme; 0 for the steady equations.
    pub rate: f64,
    /// Rate at which particles damp the turbulent kinetic energy, one value per cell in wall units, followed by the
    /// factor by which this rate is multiplied in the equation of the dissipation rate.
    pub damping: (&'a [f64], f64),
    /// Production of turbulent kinetic energy by particles, one value per cell in wall units; empty without such a
    /// production.
    pub produced: &'a [f64],
}

impl SweepStep<'_> {
    /// Production of turbulent kinetic energy by particles in a cell, in wall units.
    pub fn produced_in(&self, cell: usize) -> f64 {
        self.produced.get(cell).copied().unwrap_or(0.0)
    }
}

/// Steady diffusion-reaction equation of one quantity φ: -(D φ')' + sink φ = source in every cell. The diffusivity is D
/// = 1 + ν_t/σ, with the eddy viscosity ν_t.
pub(super) struct Equation<'a> {
    /// [-] turbulent Prandtl number σ of the quantity φ.
    pub prandtl: f64,
    /// Coefficient of the quantity φ in the sink term of each cell, per volume and in wall units; >= 0.
    pub sink: &'a [f64],
    /// Source term of the quantity φ in each cell, per volume and in wall units.
    pub source: &'a [f64],
    /// Condition on the quantity φ at the wall.
    pub wall: WallCondition,
}

/// Condition on a transported quantity φ at the wall.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum WallCondition {
    /// The quantity φ is 0 at the wall itself.
    Zero,
    /// No flux of the quantity φ through the wall.
    Insulated,
    /// The cell at the wall has this value of the quantity φ.
    FirstCell(f64),
}

impl HalfChannel {
    /// Makes a half channel with the given faces of cells: distances from the wall over the half height, from 0 to 1.
    /// `reynolds_tau` is the first estimate of the friction Reynolds number.
    pub fn new(section: Section, faces: &[f64], reynolds_tau: f64) -> Self {
        let mut channel = Self {
            section,
            reynolds_tau: 1.0,
            face: faces.to_vec(),
            y: faces.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect(),
            u: vec![0.0; faces.len() - 1],
            k: Vec::new(),
            epsilon: Vec::new(),
            nu_t: Vec::new(),
            face_stress: None,
        };
        channel.stretch(reynolds_tau);
        // The iteration converges from any positive start. The start here has the right size: the eddy viscosity is
        // that of the logarithmic layer with van Driest's damping (1956, A+ = 26), and k+ is 1/sqrt(C_mu). Both are
        // reduced towards the centre.
        for &y in &channel.y {
            let damping = 1.0 - (-y / 26.0).exp();
            let nu_t = wall_functions::KAPPA * y * damping * damping * (1.0 - 0.5 * y / reynolds_tau);
            let k = damping * damping * (1.0 - 0.8 * y / reynolds_tau) / C_MU.sqrt();
            channel.nu_t.push(nu_t);
            channel.k.push(k);
            channel.epsilon.push(C_MU * k * k / nu_t);
        }
        channel
    }

    /// Changes the friction Reynolds number Re_τ. All distances are scaled, so that the grid in y/h does not change.
    pub fn stretch(&mut self, reynolds_tau: f64) {
        let factor = reynolds_tau / self.reynolds_tau;
        self.face.iter_mut().chain(&mut self.y).for_each(|y| *y *= factor);
        self.reynolds_tau = reynolds_tau;
    }

    /// [-] area of a surface at the distance `y` from the wall, over the area of the wall: 1 in a channel, r/R in a
    /// pipe of radius R, with the distance r = R - `y` from the axis.
    pub fn area(&self, y: f64) -> f64 {
        match self.section {
            Section::Channel => 1.0,
            Section::Pipe => 1.0 - y / self.reynolds_tau,
        }
    }

    /// Volume of a cell divided by the area of the wall, in units of ν/u_τ.
    pub fn volume(&self, cell: usize) -> f64 {
        let [start, end] = [self.face[cell], self.face[cell + 1]];
        (end - start) * self.area(0.5 * (start + end))
    }

    /// [-] total shear stress 1 - y/h of a gas without particles at the distance `y` from the wall, in units of the
    /// wall stress. The half height h of the channel, or the radius of the pipe, is in wall units, like `y`.
    pub fn stress(&self, y: f64) -> f64 {
        1.0 - y / self.reynolds_tau
    }

    /// [-] shear stress at the face number `face`, in units of the wall stress of the gas without particles.
    pub fn stress_at_face(&self, face: usize) -> f64 {
        self.face_stress.as_ref().map_or_else(|| self.stress(self.face[face]), |stress| stress[face])
    }

    /// [-] shear stress at the wall, in units of the wall stress of the gas without particles; 1 if particles do not
    /// change the flow.
    pub fn wall_stress(&self) -> f64 {
        self.face_stress.as_ref().map_or(1.0, |stress| stress[0])
    }

    /// [-] eddy viscosity over ν at the face between two cells, interpolated linearly between the centres of these
    /// cells.
    pub fn face_nu_t(&self, face: usize) -> f64 {
        let weight = (self.face[face] - self.y[face - 1]) / (self.y[face] - self.y[face - 1]);
        self.nu_t[face - 1] + weight * (self.nu_t[face] - self.nu_t[face - 1])
    }

    /// Integrates (1 + ν_t) dU/dy = τ from the wall to the centre, starting with the velocity `first` in the first
    /// cell. Here U is the mean velocity, ν_t the eddy viscosity, and τ the shear stress, which is 1 - y/h in a gas
    /// alone. The discrete stress balance then holds at every face, up to rounding.
    pub fn integrate_momentum(&mut self, first: f64) {
        self.u[0] = first;
        for i in 1..self.u.len() {
            let gradient = self.stress_at_face(i) / (1.0 + self.face_nu_t(i));
            self.u[i] = self.u[i - 1] + gradient * (self.y[i] - self.y[i - 1]);
        }
    }

    /// [-] velocity gradient dU/dy in a cell, computed from the shear stress at its centre.
    pub fn shear(&self, cell: usize) -> f64 {
        let stress = match &self.face_stress {
            Some(stress) => 0.5 * (stress[cell] + stress[cell + 1]),
            None => self.stress(self.y[cell]),
        };
        stress / (1.0 + self.nu_t[cell])
    }

    /// Solves the equation of one quantity φ in all cells by Thomas' algorithm. Moves `phi`, the values of φ, towards
    /// the solution by the fraction `relaxation` [-]. Returns the largest relative difference between the solution and
    /// the previous `phi`, or not-a-number if the new `phi` is not finite.
    pub fn solve(&self, equation: &Equation, relaxation: f64, phi: &mut [f64]) -> f64 {
        let count = phi.len();
        let conductance = |face: usize| {
            self.area(self.face[face]) * (1.0 + self.face_nu_t(face) / equation.prandtl)
                / (self.y[face] - self.y[face - 1])
        };
        let (mut upper, mut right) = (vec![0.0; count], vec![0.0; count]);
        for i in 0..count {
            let width = self.volume(i);
            let below = match (i, equation.wall) {
                (0, WallCondition::Zero) => 1.0 / self.y[0],
                (0, _) => 0.0,
                _ => conductance(i),
            };
            let above = if i + 1 < count { conductance(i + 1) } else { 0.0 };
            let diagonal = below + above + equation.sink[i] * width;
            let (mut above, mut diagonal, mut source) = (above, diagonal, equation.source[i] * width);
            let mut lower = if i > 0 { below } else { 0.0 };
            if let (0, WallCondition::FirstCell(value)) = (i, equation.wall) {
                (lower, above, diagonal, source) = (0.0, 0.0, 1.0, value);
            }
            let (before_upper, before_right) = if i > 0 { (upper[i - 1], right[i - 1]) } else { (0.0, 0.0) };
            let pivot = diagonal - lower * before_upper;
            upper[i] = above / pivot;
            right[i] = (source + lower * before_right) / pivot;
        }
        let mut change: f64 = 0.0;
        let mut next = 0.0;
        for i in (0..count).rev() {
            next = right[i] + upper[i] * next;
            let difference = next - phi[i];
            change = change.max((difference / phi[i]).abs());
            phi[i] += relaxation * difference;
        }
        // max() ignores not-a-number, but the sum does not
        if phi.iter().sum::<f64>().is_finite() { change } else { f64::NAN }
    }

    /// [-] velocity on the centre plane of a channel or on the axis of a pipe. It is taken from a parabola through the
    /// velocities of the last two cells, with zero slope at the centre.
    pub fn centre_velocity(&self) -> f64 {
        let last = self.u.len() - 1;
        let near = (self.reynolds_tau - self.y[last]).powi(2);
        let far = (self.reynolds_tau - self.y[last - 1]).powi(2);
        self.u[last] + (self.u[last] - self.u[last - 1]) * near / (far - near)
    }

    /// Values of all cells, converted to SI units. `wall_unit` [m] is the unit of lengths ν/u_τ, and
    /// `friction_velocity` [m/s] the unit of velocities u_τ.
    pub fn nodes(&self, model: TurbulenceModel, wall_unit: f64, friction_velocity: f64) -> Vec<GridNode> {
        (0..self.u.len())
            .map(|i| {
                let epsilon = self.epsilon[i]
                    + match model {
                        TurbulenceModel::WallFunctions => 0.0,
                        TurbulenceModel::LaunderSharma => launder_sharma::wall_dissipation(self, i),
                    };
                GridNode {
                    y: self.y[i] * wall_unit,
                    u: self.u[i] * friction_velocity,
                    k: self.k[i] * friction_velocity.powi(2),
                    epsilon: epsilon * friction_velocity.powi(3) / wall_unit,
                    nu_t: self.nu_t[i] * friction_velocity * wall_unit,
                }
            })
            .collect()
    }

    /// Terms of the equation of the turbulent kinetic energy k, integrated over the half channel, in units of u_τ³.
    pub fn k_budget(&self, model: TurbulenceModel) -> KBudget {
        let mut budget = KBudget::default();
        for i in 0..self.u.len() {
            let width = self.volume(i);
            let (production, dissipation) = match model {
                TurbulenceModel::WallFunctions => (wall_functions::production(self, i), self.epsilon[i]),
                TurbulenceModel::LaunderSharma => {
                    (launder_sharma::production(self, i), self.epsilon[i] + launder_sharma::wall_dissipation(self, i))
                }
            };
            budget.production += production * width;
            budget.dissipation += dissipation * width;
        }
        budget.wall_flux = match model {
            TurbulenceModel::WallFunctions => 0.0,
            TurbulenceModel::LaunderSharma => self.k[0] / self.y[0],
        };
        budget
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the profile without turbulence, U = 1.5 U_b (1 - (1 - y/h)²), whose bulk velocity U_b is Re_τ/3 in wall
    /// units. The error of the computed profile falls with the square of the cell width.
    #[test]
    fn laminar_flow_is_a_parabola() {
        let error = |cells: usize| {
            let reynolds_tau = 10.0;
            let mut channel = HalfChannel::new(Section::Channel, &wall_functions::faces(cells), reynolds_tau);
            channel.nu_t.fill(0.0);
            channel.integrate_momentum(channel.y[0]);
            let exact = |y: f64| 0.5 * reynolds_tau * (1.0 - (1.0 - y / reynolds_tau).powi(2));
            let centre = channel.centre_velocity() / exact(reynolds_tau) - 1.0;
            let nodes = channel.y.iter().zip(&channel.u).map(|(y, u)| (u - exact(*y)).abs());
            nodes.fold(centre.abs(), f64::max)
        };
        for cells in [10, 20, 40, 80] {
            let ratio = error(cells) / error(2 * cells);
            assert!((3.8..4.2).contains(&ratio), "{cells} cells: the error falls by {ratio}");
        }
    }

    /// Checks the profile in a pipe without turbulence against the law of Hagen and Poiseuille. In wall units the
    /// velocity is R/2 (1 - r²/R²) and the bulk velocity R/4, with the radius R. On equal cells, whose faces are
    /// midway between the centres, the profile and the friction factor 64/Re are exact up to rounding.
    #[test]
    fn laminar_flow_in_a_pipe_is_hagen_and_poiseuille() {
        let radius = 25.0;
        for cells in [8, 40] {
            let faces: Vec<f64> = (0..=cells).map(|face| face as f64 / cells as f64).collect();
            let mut pipe = HalfChannel::new(Section::Pipe, &faces, radius);
            pipe.nu_t.fill(0.0);
            let exact = |y: f64| 0.5 * radius * (1.0 - (1.0 - y / radius).powi(2));
            // the velocity of the first cell follows from zero velocity at the wall and the stress midway between wall
            // and cell centre
            pipe.integrate_momentum(pipe.y[0] * pipe.stress(0.5 * pipe.y[0]));
            for (y, u) in pipe.y.iter().zip(&pipe.u) {
                assert!((u - exact(*y)).abs() < 1e-12 * radius, "{cells} cells, y = {y}: {u}");
            }
            assert!((pipe.centre_velocity() / exact(radius) - 1.0).abs() < 1e-12);
            // Simpson's rule over each cell is exact for the cubic (1 - y/R) U
            let flow = (0..cells).map(|i| {
                let at = |y: f64| pipe.area(y) * exact(y);
                let (a, b) = (pipe.face[i], pipe.face[i + 1]);
                (b - a) / 6.0 * (at(a) + 4.0 * pipe.area(pipe.y[i]) * pipe.u[i] + at(b))
            });
            let bulk = 2.0 * flow.sum::<f64>() / radius;
            let (reynolds, friction) = (2.0 * radius * bulk, 8.0 / (bulk * bulk));
            assert!((friction * reynolds / 64.0 - 1.0).abs() < 1e-12, "{cells} cells: λ Re = {}", friction * reynolds);
        }
    }

    /// Checks the solution of (1/r)(r φ')' = φ - 1 with φ(R) = 0, at the distance r from the axis of a pipe of radius
    /// R. The solution is φ = 1 - I_0(r)/I_0(R), with the modified Bessel function I_0 computed by its series.
    #[test]
    fn diffusion_in_a_pipe_is_of_second_order() {
        let bessel = |r: f64| {
            (0..40).fold((0.0, 1.0), |(sum, term), k| (sum + term, term * (0.5 * r / f64::from(k + 1)).powi(2))).0
        };
        let error = |cells: usize| {
            let faces: Vec<f64> = (0..=cells).map(|face| face as f64 / cells as f64).collect();
            let mut pipe = HalfChannel::new(Section::Pipe, &faces, 3.0);
            pipe.nu_t.fill(0.0);
            let ones = vec![1.0; cells];
            let equation = Equation { prandtl: 1.0, sink: &ones, source: &ones, wall: WallCondition::Zero };
            let mut phi = ones.clone();
            pipe.solve(&equation, 1.0, &mut phi);
            let exact = |y: f64| 1.0 - bessel(3.0 - y) / bessel(3.0);
            pipe.y.iter().zip(&phi).map(|(y, phi)| (phi - exact(*y)).abs()).fold(0.0, f64::max)
        };
        let ratio = error(40) / error(80);
        assert!(error(40) < 1e-3 && (3.5..4.5).contains(&ratio), "{} and falls by {ratio}", error(40));
    }

    /// Checks the solution of -φ'' + sink φ = sink in a channel of half height h, with φ(0) = 0 and no flux at the
    /// centre y = h. The solution is φ = 1 - cosh(q (h - y))/cosh(q h) with q² = sink.
    #[test]
    fn diffusion_with_a_sink_is_of_second_order() {
        let error = |cells: usize| {
            let mut channel = HalfChannel::new(Section::Channel, &wall_functions::faces(cells), 3.0);
            channel.nu_t.fill(0.0);
            let sink = vec![1.44; cells];
            let equation = Equation { prandtl: 1.0, sink: &sink, source: &sink, wall: WallCondition::Zero };
            let mut phi = vec![1.0; cells];
            channel.solve(&equation, 1.0, &mut phi);
            let exact = |y: f64| 1.0 - (1.2 * (3.0 - y)).cosh() / 3.6_f64.cosh();
            channel.y.iter().zip(&phi).map(|(y, phi)| (phi - exact(*y)).abs()).fold(0.0, f64::max)
        };
        let ratio = error(40) / error(80);
        assert!((3.7..4.3).contains(&ratio), "the error falls by {ratio}");
    }
}
