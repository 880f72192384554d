//! Reads the velocity profiles of a pipe flow and of the logarithmic law. Checks that the velocity of the gas is
//! defined at all particles, and that the drag law is valid for them.

use super::{Resolver, short};
use crate::case::diagnostic::Diagnostic;
use crate::case::file::CaseFile;
use crate::case::located::Located;
use crate::case::quantity::{Length, Quantity, Ratio, Speed};
use crate::domain::Domain;
use crate::experiment::{Amount, Experiment, Population};
use crate::fluid::{Fluid, LogConstants, LogLaw, Profile};
use crate::predict::flow::terminal_slip;
use nalgebra::Vector3;

/// Number of positions across the channel at which the slip (velocity of particles relative to the gas) is computed
/// before the run.
const PLACES: usize = 101;

impl Resolver {
    /// Checks that the domain is not periodic along y, because a channel flow needs walls at y = 0 and at the height of
    /// the domain. `typed` is the value in the case by which the flow was chosen, for the message.
    pub(super) fn between_walls<const M: i8, const K: i8, const S: i8>(
        &self,
        typed: &Located<Quantity<M, K, S>>,
        domain: &Domain,
    ) -> Result<(), Diagnostic> {
        if !domain.periodic[1] {
            return Ok(());
        }
        let why = "is a flow between walls at y = 0 and y = L_y, but the domain is periodic along y";
        Err(self.refuse(typed, why).help("take \"y\" out of domain.periodic, or use a uniform profile"))
    }

    /// Profile of the turbulent flow through a pipe in the domain. `number` is the bulk Reynolds number; `nu` is the
    /// kinematic viscosity ν of the gas [m²/s]. Without a `diameter`, the pipe is as wide as the domain along y;
    /// without a `center`, it is in the middle.
    pub(super) fn pipe(
        &self,
        number: &Located<Ratio>,
        diameter: Option<&Located<Length>>,
        center: Option<&Located<[Located<Length>; 2]>>,
        (domain, nu): (&Domain, f64),
    ) -> Result<Profile, Diagnostic> {
        let help = "Re = U_b D/ν with the bulk velocity and the diameter; the model is for turbulent flow";
        let reynolds = self.in_range(number, help)?;
        let d = match diameter {
            Some(typed) => self.in_range(typed, "the inner diameter of the pipe")?,
            None => domain.size.y,
        };
        let middle = [0.5 * domain.size.x, 0.5 * domain.size.y];
        let axis = center.map_or(middle, |center| center.value.each_ref().map(|typed| typed.value.0));
        for (name, (at, size)) in ["x", "y"].into_iter().zip(axis.iter().zip([domain.size.x, domain.size.y])) {
            // a pipe that is exactly as wide as the box fits, although rounding may have changed computed edges
            if at - 0.5 * d < -1e-9 * size || at + 0.5 * d > size * (1.0 + 1e-9) {
                let typed = |origin, path: &str| {
                    let message = format!("the pipe of `{path}` does not fit into the box along {name}");
                    self.sources
                        .error(origin, message)
                        .help("the box must hold all of the pipe: 0 to the size along x and y")
                };
                return Err(match (center, diameter) {
                    (Some(center), _) => typed(&center.origin, &center.path),
                    (None, Some(diameter)) => typed(&diameter.origin, &diameter.path),
                    (None, None) => typed(&number.origin, &number.path),
                });
            }
        }
        Profile::k_epsilon_pipe(reynolds * nu / d, d, axis, nu)
            .map_err(|why| self.refuse(number, format!("gives no k-ε solution: {why}")).help(help))
    }

    /// Constants κ and B of the logarithmic law. Each is read from its key of the case, or has its default if the case
    /// lacks the key.
    pub(super) fn log_constants(
        &self,
        von_karman: Option<&Located<Ratio>>,
        intercept: Option<&Located<Ratio>>,
    ) -> Result<LogConstants, Diagnostic> {
        let mut constants = LogConstants::default();
        let help = "measured in channels and pipes: κ = 0.37 ..= 0.44, B = 3.7 ..= 6 on smooth walls";
        if let Some(kappa) = von_karman {
            constants.von_karman = self.in_range(kappa, help)?;
        }
        if let Some(intercept) = intercept {
            // the constant B is smaller for rough walls, and larger for walls that reduce drag
            constants.intercept = self.in_range(intercept, help)?;
        }
        Ok(constants)
    }

    /// Logarithmic law of the wall in a gas of kinematic viscosity `nu` [m²/s]. The case gives exactly one of the
    /// friction velocity and the bulk Reynolds number.
    pub(super) fn log_law(
        &self,
        given: (Option<&Located<Speed>>, Option<&Located<Ratio>>),
        constants: LogConstants,
        domain: &Domain,
        nu: f64,
    ) -> Result<LogLaw, Diagnostic> {
        let height = domain.size.y;
        match given {
            (Some(friction), None) => {
                self.between_walls(friction, domain)?;
                let help = "about a twentieth of the bulk velocity";
                let u = self.in_range(friction, help)?;
                LogLaw::with_friction_velocity(u, height, nu, constants)
                    .map_err(|why| self.refuse(friction, format!("gives no turbulent channel: {why}")).help(help))
            }
            (None, Some(number)) => {
                self.between_walls(number, domain)?;
                let help = "Re = U_b L_y/ν with the bulk velocity and the full width";
                let reynolds = self.in_range(number, help)?;
                LogLaw::with_bulk_velocity(reynolds * nu / height, height, nu, constants)
                    .map_err(|why| self.refuse(number, format!("gives no turbulent channel: {why}")).help(help))
            }
            _ => {
                let message = "`fluid.profile.log_law` needs `friction_velocity` or `reynolds_number`";
                Err(Diagnostic::about("the case", message))
            }
        }
    }

    /// Checks that the rows of a gas table cover all possible positions of particle centres. For the smallest
    /// particles, of `radius` [m], these are all heights from y = `radius` to y = `height` - `radius` [m]. A gap gives
    /// a warning, fewer than two rows within the domain an error.
    pub(super) fn check_cover(
        &mut self,
        name: &Located<String>,
        points: &[(f64, f64)],
        height: f64,
        radius: f64,
    ) -> Result<(), Diagnostic> {
        let (Some((first, _)), Some((last, _))) = (points.first(), points.last()) else { return Ok(()) };
        // a row at a wall may differ from the position of the wall by rounding to six digits
        let close = 1e-6 * height;
        let rows = format!("has rows from y = {} m to {} m", short(*first), short(*last));
        let gap = format!("the gap from y = 0 to {} m", short(height));
        let inside = points.iter().filter(|(y, _)| (-close..=height + close).contains(y)).count();
        if inside < 2 {
            let what = format!("{rows}, {inside} of which lie in {gap}; allowed: two or more in it");
            return Err(self.refuse(name, what).help("`y_m` is the distance from the wall at y = 0, in metres"));
        }
        if *first > radius + close || *last < height - radius - close {
            let message = format!("{} {rows}, which leave a part of {gap} uncovered", self.as_typed(name));
            let help = "the gas keeps the velocity of the nearest row there; add rows up to both walls";
            self.warn(&name.origin, message, help);
        }
        Ok(())
    }

    /// Warns if the Reynolds numbers of particles are far outside the range of the drag law.
    pub(super) fn check_drag(&mut self, file: &CaseFile, experiment: &Experiment) {
        let Some(fluid) = &experiment.scene.fluid else { return };
        let far = fluid.drag.as_ref().and_then(|drag| drag.law().far());
        let (Some(typed), Some((far, why))) = (&file.drag, far) else { return };
        let largest = largest_reynolds(experiment, fluid);
        if largest > far {
            let message = format!("the particles slip through the gas at Reynolds numbers up to {largest:.2e}");
            self.warn(&typed.origin, message, why);
        }
    }
}

/// [-] largest particle Reynolds number that is known before the run, for the particles at the start and for those of
/// inlets. It is computed from the largest diameter of the species. The slip is that at the start (for inlets, at
/// entry) or that at which drag balances the weight, whichever is larger.
fn largest_reynolds(experiment: &Experiment, fluid: &Fluid) -> f64 {
    let (scene, Some(drag)) = (&experiment.scene, &fluid.drag) else { return 0.0 };
    let slip = |gas: f64, v: &Vector3<f64>| (v - Vector3::new(0.0, 0.0, gas)).norm();
    let anywhere = |velocity: &Vector3<f64>| {
        let gas = fluid.profile.sample(scene.domain.size.y, PLACES);
        gas.iter().map(|(_, u)| slip(*u, velocity)).fold(0.0, f64::max)
    };
    let of_population = |population: &Population| match &population.amount {
        Amount::Count(_) => anywhere(&population.velocity_mean),
        Amount::Placed(placed) => {
            let slips =
                placed.position.iter().zip(&placed.velocity).map(|(x, v)| slip(fluid.profile.velocity_at(x), v));
            slips.fold(0.0, f64::max)
        }
    };
    let there = experiment.start.iter().filter(|population| population.amount.count() > 0);
    let of_start = there.map(|population| (population.species, of_population(population)));
    let of_inlets = scene.inlets.iter().map(|inlet| (inlet.species, anywhere(&inlet.velocity_mean)));
    let number = |(species, at_first): (u16, f64)| {
        let species = scene.species.get(usize::from(species))?;
        let sphere = fluid.sphere(&species.of_one_size(species.largest()));
        let falling = terminal_slip(drag, &sphere, scene.gravity_of(species).norm());
        Some(at_first.max(falling) * sphere.reynolds_per_speed)
    };
    of_start.chain(of_inlets).filter_map(number).fold(0.0, f64::max)
}
