//! Restitution of surfaces: a number, or a law by which it depends on the speed of the impact.

use super::Resolver;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, RestitutionFile, RestitutionLawFile};
use crate::case::located::Located;
use crate::case::quantity::Ratio;
use crate::contact_law::ContactLaw;
use crate::experiment::SoftSettings;
use crate::restitution::RestitutionBySpeed;
use crate::scene::{Scene, Surface};

/// Explanation of the restitution in the message about a value out of range.
const RATIO: &str =
    "restitution is the ratio of normal speeds after and before an impact: 1 elastic, 0 without rebound";

impl Resolver {
    /// Restitution and friction of a surface. For a restitution that depends on speed, predictions first use its value
    /// at 1 m/s. This value is replaced when the speeds at the start are known ([`Surface::represent`]).
    pub(super) fn surface(
        &self,
        restitution: &Option<Located<RestitutionFile>>,
        friction: &Option<Located<Ratio>>,
    ) -> Result<Surface, Diagnostic> {
        let typed = self.need(restitution, "restitution")?;
        let friction = self.friction(friction)?;
        let law = match &typed.value {
            RestitutionFile::Constant(number) => {
                let number = Located { value: *number, origin: typed.origin.clone(), path: typed.path.clone() };
                let e = self.in_range(&number, RATIO)?;
                if e == 0.0 && self.model.has_contacts() {
                    let why = "cannot be had from a linear spring-dashpot: its damping ratio -ln e / sqrt(π² + ln² e) needs ln 0; \
                               allowed: 0 < e <= 1";
                    return Err(self.refuse(&number, why).help("use 0.01, or the hard model, which takes 0"));
                }
                return Ok(Surface::new(e, friction));
            }
            RestitutionFile::BySpeed(law) => self.restitution_law(law)?,
        };
        let mut surface = Surface { by_speed: Some(law), ..Surface::new(1.0, friction) };
        surface.represent(1.0);
        Ok(surface)
    }

    fn restitution_law(&self, typed: &RestitutionLawFile) -> Result<RestitutionBySpeed, Diagnostic> {
        let speed = |typed, key| self.in_range(self.need(typed, key)?, "a normal speed of impact");
        let ratio = |typed, key| self.in_range(self.need(typed, key)?, RATIO);
        let exponent = |typed, key| self.in_range(self.need(typed, key)?, "1/5 and 3/4 are usual, and 0.234 is ice");
        match typed {
            RestitutionLawFile::Bridges { speed: elastic, exponent: p } => Ok(RestitutionBySpeed::Bridges {
                speed: speed(elastic, "restitution.bridges.speed")?,
                exponent: exponent(p, "restitution.bridges.exponent")?,
            }),
            RestitutionLawFile::Power { restitution, speed: of, exponent: q, least } => {
                let floor = ratio(least, "restitution.power.least")?;
                let law = RestitutionBySpeed::Power {
                    restitution: ratio(restitution, "restitution.power.restitution")?,
                    speed: speed(of, "restitution.power.speed")?,
                    exponent: exponent(q, "restitution.power.exponent")?,
                    least: floor,
                };
                match least.as_ref().filter(|_| !law.always_rebounds() && self.model.has_contacts()) {
                    None => Ok(law),
                    Some(least) => {
                        let why =
                            "cannot be had from a dashpot, with which every contact must end; allowed: 0 < e <= 1";
                        Err(self.refuse(least, why).help("use 0.01, or the hard or dsmc model, which takes 0"))
                    }
                }
            }
            RestitutionLawFile::Viscoelastic { restitution, speed: of } => Ok(RestitutionBySpeed::viscoelastic(
                ratio(restitution, "restitution.viscoelastic.restitution")?,
                speed(of, "restitution.viscoelastic.speed")?,
            )),
        }
    }

    /// Refuses surfaces whose restitution the damping of Kuwabara and Kono's contact law cannot give.
    pub(super) fn check_restitution(
        &self,
        file: &CaseFile,
        scene: &Scene,
        soft: &SoftSettings,
    ) -> Result<(), Diagnostic> {
        let law = file.soft.as_ref().and_then(|soft| soft.value.kuwabara_kono.as_ref());
        let (Some(law), Some(ContactLaw::KuwabaraKono(_))) = (law, soft.law) else { return Ok(()) };
        let fits = |surface: &Surface| match surface.by_speed {
            Some(RestitutionBySpeed::Viscoelastic { .. }) => true,
            Some(RestitutionBySpeed::Bridges { .. } | RestitutionBySpeed::Power { .. }) => false,
            None => surface.restitution == 1.0,
        };
        // without `[contact]` the surface between particles is elastic, which fits the law
        let walls = scene.walls.iter().map(|wall| &wall.surface);
        let pairs = scene.pairs.iter().map(|(_, _, meeting)| &meeting.surface);
        if !self.model.has_contacts() || walls.chain(pairs).chain([&scene.contact]).all(fits) {
            return Ok(());
        }
        let message = "`soft.kuwabara_kono` is the law of viscoelastic spheres, and a surface of this case has another restitution";
        let help = "give it `restitution = { viscoelastic = { restitution = 0.9, speed = \"1 m/s\" } }` or 1, or use [soft.hertz], \
                    which takes every restitution";
        Err(self.sources.error(&law.origin, message).help(help))
    }
}
