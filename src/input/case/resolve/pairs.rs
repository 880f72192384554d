//! Contact properties of particular pairs of species, or of a species and a wall.

use super::settings::SPRINGS;
use super::{Resolver, short};
use crate::case::de::suggestion;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, PairFile};
use crate::case::located::Located;
use crate::contact_law::{Bodies, ContactLaw, damping_ratio, reduced_overlap};
use crate::experiment::SoftSettings;
use crate::scene::{Kind, Meeting, Pairs, Scene, Surface};
use std::f64::consts::PI;

/// Contact stiffness of a pair that follows from one key in the table of the pair, such as `contact_time`.
struct Wanted<'a> {
    /// [N/m] stiffness that follows from the key.
    stiffness: f64,
    /// [kg] effective mass for which the stiffness was computed. `None` if all contacts of the pair have the same
    /// stiffness.
    at_mass: Option<f64>,
    /// Source position and path of the key, for messages.
    key: (&'a crate::case::source::Origin, &'a str),
}

impl Resolver {
    /// Contact properties of all pairs listed in a case. The pairs of `scene` are still empty when this function is
    /// called. `usual` [m/s] is the normal speed at which restitutions that depend on the speed are evaluated for
    /// predictions.
    pub(super) fn pairs(
        &mut self,
        file: &CaseFile,
        scene: &Scene,
        soft: &SoftSettings,
        usual: f64,
    ) -> Result<Pairs, Diagnostic> {
        let mut pairs = Pairs::default();
        self.check_names(file, scene)?;
        let listed = file.contact.iter().flat_map(|contact| contact.value.pairs.iter().flatten());
        for pair in listed {
            for (species, other) in self.between(file, scene, pair)? {
                if pairs.find(species, other).is_some() {
                    let message = format!("`{}` names a pair that is listed before", pair.path);
                    return Err(self.sources.error(&pair.origin, message).help("one [[contact.pairs]] table each"));
                }
                let mut surface = self.pair_surface(&pair.value, *scene.surface(species, other))?;
                surface.represent(usual);
                let wanted = self.pair_stiffness(&pair.value, scene, (species, other), &surface)?;
                let stiffness_ratio = wanted.as_ref().map_or(1.0, |wanted| self.ratio(wanted, soft));
                let at_mass = wanted.and_then(|wanted| wanted.at_mass);
                let own = &pair.value;
                let resistance = self.resistance_friction(file, &own.rolling_friction, &own.twisting_friction)?;
                let resistance = resistance.or(scene.resistance(species, other));
                pairs.set(species, other, Meeting { surface, stiffness_ratio, at_mass, resistance });
            }
        }
        Ok(pairs)
    }

    /// Checks that no wall has the name of a species, so that each name in a pair is unique.
    fn check_names(&self, file: &CaseFile, scene: &Scene) -> Result<(), Diagnostic> {
        for name in file.walls.iter().flatten().filter_map(|wall| wall.value.name.as_ref()) {
            if scene.species.iter().any(|species| species.name == name.value) {
                let message = format!("a wall and a kind of particles are both called \"{}\"", name.value);
                return Err(self.sources.error(&name.origin, message).help("give the wall another `name`"));
            }
        }
        Ok(())
    }

    /// Pairs of bodies that a table names: the index of a species, with its partner. The partner is another species, or
    /// one of the walls with the given name.
    fn between(
        &self,
        file: &CaseFile,
        scene: &Scene,
        pair: &Located<PairFile>,
    ) -> Result<Vec<(u16, Kind)>, Diagnostic> {
        let between = self.need(&pair.value.between, "contact.pairs.between")?;
        let [one, other] = &between.value;
        let (first, second) = (self.kinds(file, scene, one)?, self.kinds(file, scene, other)?);
        match (first.as_slice(), second.as_slice()) {
            ([Kind::Species(species)], others) | (others, [Kind::Species(species)]) => {
                Ok(others.iter().map(|other| (*species, *other)).collect())
            }
            _ => Err(self.refuse(between, "names two walls, which never meet").help("name a kind of particles first")),
        }
    }

    /// Kinds of bodies with the given name: one species, or all walls with this name.
    fn kinds(&self, file: &CaseFile, scene: &Scene, name: &Located<String>) -> Result<Vec<Kind>, Diagnostic> {
        if let Some(species) = scene.species.iter().position(|species| species.name == name.value) {
            return Ok(vec![Kind::Species(species as u16)]);
        }
        let names = || file.walls.iter().flatten().map(|wall| wall.value.name.as_ref().map(|name| &name.value));
        let walls: Vec<Kind> =
            (0..).zip(names()).filter(|(_, own)| *own == Some(&name.value)).map(|(k, _)| Kind::Wall(k)).collect();
        if walls.is_empty() {
            let known: Vec<String> =
                scene.species.iter().map(|species| &species.name).chain(names().flatten()).cloned().collect();
            let what = "is no `name` of [[particles]] or [[walls]]";
            return Err(self.refuse(name, what).help(suggestion(&name.value, &known, "names")));
        }
        Ok(walls)
    }

    /// Restitution and friction of a pair. Values that the pair does not give are taken from `usual`.
    fn pair_surface(&self, pair: &PairFile, usual: Surface) -> Result<Surface, Diagnostic> {
        let mut surface = usual;
        if pair.restitution.is_some() {
            surface = Surface { friction: usual.friction, ..self.surface(&pair.restitution, &None)? };
        }
        if pair.friction.is_some() {
            surface.friction = self.friction(&pair.friction)?;
        }
        Ok(surface)
    }

    /// Stiffness of a pair; `None` if no key of the pair determines it. The damping ratio ζ follows from the
    /// restitution. A contact then lasts T_c = π/(ω_0 sqrt(1 - ζ²)), where ω_0² = k_n/M is the square of the undamped
    /// angular frequency, with stiffness k_n and effective mass M. Its largest overlap is a u/ω_0, with the speed of
    /// approach u and the factor a that the function `reduced_overlap` gives.
    fn pair_stiffness<'a>(
        &self,
        pair: &'a PairFile,
        scene: &Scene,
        (species, other): (u16, Kind),
        surface: &Surface,
    ) -> Result<Option<Wanted<'a>>, Diagnostic> {
        let bodies = match other {
            Kind::Species(other) => Bodies::between(scene, species, other),
            Kind::Wall(wall) => Bodies::beside(scene, species, wall),
        };
        let spread = |species: u16| scene.species[usize::from(species)].sizes.is_some();
        let of_sizes = spread(species) || matches!(other, Kind::Species(other) if spread(other));
        let at_mass = of_sizes.then_some(bodies.effective_mass);
        let (mass, damping) = (bodies.effective_mass, damping_ratio(surface.restitution));
        let mut wanted: Vec<Wanted> = Vec::new();
        if let Some(k) = &pair.stiffness {
            let stiffness = self.in_range(k, "how stiff a contact of the two is")?;
            wanted.push(Wanted { stiffness, at_mass: None, key: (&k.origin, &k.path) });
        }
        if let Some(time) = &pair.contact_time {
            let t = self.in_range(time, "how long a contact lasts")?;
            if damping >= 1.0 {
                let why = "cannot be had at restitution 0: a contact never ends";
                return Err(self.refuse(time, why).help("leave it out"));
            }
            let stiffness = mass * (PI / t).powi(2) / (1.0 - damping * damping);
            wanted.push(Wanted { stiffness, at_mass, key: (&time.origin, &time.path) });
        }
        if let Some([depth, speed]) = self.overlap(pair)? {
            let stiffness = mass * (reduced_overlap(surface.restitution) * speed / depth).powi(2);
            wanted.extend(pair.overlap.as_ref().map(|l| Wanted { stiffness, at_mass, key: (&l.origin, &l.path) }));
        }
        // these keys are not declared as exclusive: otherwise one of them from a later source would remove `overlap`
        // but keep its `impact_speed`
        if let [_, Wanted { key: (origin, path), .. }, ..] = wanted.as_slice() {
            let message = format!("`{path}` says again how stiff the pair is");
            let help = "keep one of `stiffness`, `contact_time` and `overlap`";
            return Err(self.sources.error(origin, message).help(help));
        }
        let Some(wanted) = wanted.pop() else { return Ok(None) };
        if !SPRINGS.contains(&wanted.stiffness) {
            let (origin, path) = wanted.key;
            let means = short(wanted.stiffness);
            let message = format!("`{path}` means a spring of {means} N/m; allowed: 1e-9 ..= 1e20 N/m");
            return Err(self.sources.error(origin, message));
        }
        Ok(Some(wanted))
    }

    /// Desired overlap [m] of an impact of the pair, and the normal speed [m/s] of that impact; `None` if the pair does
    /// not give them.
    fn overlap(&self, pair: &PairFile) -> Result<Option<[f64; 2]>, Diagnostic> {
        let depth = pair.overlap.as_ref().map(|overlap| self.in_range(overlap, "how deep an impact goes"));
        let speed = pair.impact_speed.as_ref().map(|speed| self.in_range(speed, "the normal speed of the impact"));
        let (depth, speed) = (depth.transpose()?, speed.transpose()?);
        match (&pair.overlap, &pair.impact_speed) {
            (None, Some(speed)) => {
                Err(self.refuse(speed, "goes with `overlap`, which is not there").help("add `overlap`"))
            }
            (Some(overlap), None) => Err(self
                .refuse(overlap, "is of an impact at which speed?")
                .help("add `impact_speed`, such as \"0.5 m/s\"")),
            _ => Ok(depth.zip(speed).map(|(depth, speed)| [depth, speed])),
        }
    }

    /// [-] stiffness of a pair over that of the contact law. If the law is not linear, the ratio is 1, and a warning is
    /// given.
    fn ratio(&mut self, wanted: &Wanted, soft: &SoftSettings) -> f64 {
        if let Some(ContactLaw::LinearSpringDashpot(law)) = &soft.law {
            return wanted.stiffness / law.stiffness;
        }
        let message = format!("`{}` is not used: the case has no `soft.linear_spring_dashpot`", wanted.key.1);
        let help = "Hertz's law makes the stiffness of a pair from the `elasticity` of each kind and wall";
        self.warn(wanted.key.0, message, help);
        1.0
    }
}
