//! Rotation of spheres: initial spins, tangential law, rolling and twisting resistance, and impact rule.

use super::{Resolver, vector};
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{
    CaseFile, HistoryFile, ImpactRuleFile, ParticlesFile, RollingFile, SoftFile, TangentialFile, Three,
};
use crate::case::located::Located;
use crate::case::quantity::{Ratio, Spin};
use crate::contact_law::ContactLaw;
use crate::experiment::{Integrator, Model, SoftSettings};
use crate::rotation::{
    ImpactKind, ImpactRule, LinearTangential, ResistanceFriction, RollingLaw, Rotation, SOLID_SPHERE, SpringHistory,
    TangentialLaw, TwistingLaw,
};
use crate::scene::Scene;
use nalgebra::Vector3;

impl Resolver {
    /// True if spheres of the case rotate. If the case does not give the key `contact.rotation`, spheres rotate if it
    /// has a tangential, rolling or twisting law, or an impact rule.
    pub(super) fn rotates(file: &CaseFile) -> bool {
        let typed = file.contact.as_ref().and_then(|contact| contact.value.rotation.as_ref());
        let tangential = file.soft.as_ref().is_some_and(|soft| {
            let SoftFile { tangential, rolling, twisting, .. } = &soft.value;
            tangential.is_some() || rolling.is_some() || twisting.is_some()
        });
        let rule = file.hard.as_ref().is_some_and(|hard| hard.value.friction.is_some());
        typed.map_or(tangential || rule, |typed| typed.value)
    }

    /// Coefficients of rolling and twisting friction of a wall or a pair. The case must contain the law that uses them.
    pub(super) fn resistance_friction(
        &self,
        file: &CaseFile,
        rolling: &Option<Located<Ratio>>,
        twisting: &Option<Located<Ratio>>,
    ) -> Result<ResistanceFriction, Diagnostic> {
        let soft = file.soft.as_ref().map(|soft| &soft.value);
        let law = soft.and_then(|soft| soft.rolling.as_ref());
        let has_friction = law.is_some_and(|law| !matches!(law.value, RollingFile::Viscous { .. }));
        let twists = soft.is_some_and(|soft| soft.twisting.is_some());
        let of = |typed: &Option<Located<Ratio>>, is_used: bool, laws: &str| {
            let Some(typed) = typed else { return Ok(None) };
            let friction = self.in_range(typed, "0 is no resistance")?;
            if !is_used {
                let why = "is the coefficient of a law that the case does not have";
                return Err(self.refuse(typed, why).help(format!("add {laws}, or leave it out")));
            }
            Ok(Some(friction))
        };
        Ok(ResistanceFriction {
            rolling: of(rolling, has_friction, "[soft.rolling.spring] or [soft.rolling.constant]")?,
            twisting: of(twisting, twists, "[soft.twisting]")?,
        })
    }

    /// [-] ratio of the moment of inertia of a sphere, about its centre, to m r²; 2/5 if the case gives no ratio.
    pub(super) fn inertia_factor(&self, kind: &Located<ParticlesFile>) -> Result<f64, Diagnostic> {
        let Some(typed) = &kind.value.inertia_factor else { return Ok(SOLID_SPHERE) };
        let help = "0.4 is a solid sphere, 0.667 a thin shell";
        self.in_range(typed, help)
    }

    /// [rad/s] vector of a spin that the case gives; zero if the case gives none. Warns about a spin if spheres of the
    /// case do not rotate.
    pub(super) fn spin(&mut self, typed: Option<&Three<Spin>>, scene: &Scene) -> Result<Vector3<f64>, Diagnostic> {
        let Some(typed) = typed else { return Ok(Vector3::zeros()) };
        for component in &typed.value {
            let help = "a particle's spin, right-handed about its direction";
            self.in_range(component, help)?;
        }
        self.warn_of_spin(typed, scene);
        Ok(vector(typed))
    }

    /// Mean and standard deviation [rad/s] of the spins of a random start. If `placed` is true, spins come with the
    /// positions, and a typed mean or deviation causes a warning.
    pub(super) fn random_spin(
        &mut self,
        kind: &ParticlesFile,
        scene: &Scene,
        placed: bool,
    ) -> Result<(Vector3<f64>, f64), Diagnostic> {
        let mean = self.spin(kind.spin_mean.as_ref(), scene)?;
        let mut deviation = 0.0;
        if let Some(typed) = &kind.spin_fluctuation {
            let help = "the standard deviation of each spin component";
            deviation = self.in_range(typed, help)?;
            self.warn_of_spin(typed, scene);
        }
        let typed = kind.spin_mean.as_ref().map(|typed| (&typed.origin, &typed.path));
        let typed = typed.or(kind.spin_fluctuation.as_ref().map(|typed| (&typed.origin, &typed.path)));
        if let (true, Some((origin, path))) = (placed, typed) {
            self.warn(origin, format!("`{path}` is not used: spins come with the places"), "leave it out");
        }
        Ok((mean, deviation))
    }

    fn warn_of_spin<T>(&mut self, typed: &Located<T>, scene: &Scene) {
        if scene.rotation.is_none() {
            let message = format!("`{}` is not used: spheres of this case do not rotate", typed.path);
            self.warn(&typed.origin, message, "add `rotation = true` to [contact], or a tangential law");
        }
    }

    /// Laws and rules by which spheres rotate; `None` if spheres do not rotate.
    pub(super) fn rotation(
        &mut self,
        file: &CaseFile,
        scene: &Scene,
        soft: &SoftSettings,
    ) -> Result<Option<Rotation>, Diagnostic> {
        if !Self::rotates(file) {
            return Ok(None);
        }
        let tangential = self.tangential_law(file, soft)?;
        let impact = self.impact_rule(file, scene, soft, tangential)?;
        let rolling = self.rolling_law(file)?;
        let twisting = self.twisting_law(file, tangential)?;
        let integrator = file.soft.as_ref().and_then(|soft| soft.value.integrator.as_ref());
        if let Some(typed) = integrator.filter(|typed| typed.value == Integrator::Rk2 && self.model.has_contacts()) {
            let why = "is for the paper's spheres, which do not rotate";
            return Err(self.refuse(typed, why).help("use \"velocity_verlet\", or leave the key out"));
        }
        Ok(Some(Rotation { tangential, impact, rolling, twisting }))
    }

    fn walton(&self, file: &CaseFile) -> Result<Option<f64>, Diagnostic> {
        let rule = file.hard.as_ref().and_then(|hard| hard.value.friction.as_ref());
        let Some(ImpactRuleFile::Walton { tangential_restitution }) = rule.map(|rule| &rule.value) else {
            return Ok(None);
        };
        let typed = self.need(tangential_restitution, "hard.friction.walton.tangential_restitution")?;
        let help = "-1 leaves the slip as it is, 0 stops it, 1 reverses it; glass has 0.44";
        self.in_range(typed, help).map(Some)
    }

    /// Tangential law that a case gives. A case without such a law may have Walton's rule, by which an impact changes
    /// the slip s to -β_0 s. If β_0 > 0 and the normal law is linear or absent, the law is then a spring that gives
    /// this β_0. In all other cases without a given law the result is Coulomb's friction without a spring.
    fn tangential_law(&mut self, file: &CaseFile, soft: &SoftSettings) -> Result<TangentialLaw, Diagnostic> {
        let is_linear = soft.law.is_none_or(|law| law.is_linear());
        let is_viscoelastic = matches!(soft.law, Some(ContactLaw::KuwabaraKono(_)));
        let is_hertz = is_viscoelastic || soft.law.is_none_or(|law| matches!(law, ContactLaw::Hertz(_)));
        let typed = file.soft.as_ref().and_then(|soft| soft.value.tangential.as_ref());
        match typed.map(|typed| (&typed.origin, &typed.value)) {
            None => Ok(match self.walton(file)?.filter(|beta| *beta > 0.0 && is_linear) {
                Some(beta) => TangentialLaw::Linear(LinearTangential::Restitution(beta)),
                None => TangentialLaw::Coulomb,
            }),
            Some((_, TangentialFile::Coulomb {})) => Ok(TangentialLaw::Coulomb),
            Some((origin, TangentialFile::Linear { .. })) if !is_linear => {
                let message = "`soft.tangential.linear` needs the linear normal law";
                let help = "use `soft.linear_spring_dashpot`, or `soft.tangential.mindlin`";
                Err(self.sources.error(origin, message).help(help))
            }
            Some((origin, TangentialFile::Mindlin { .. })) if !is_hertz => {
                let message = "`soft.tangential.mindlin` needs Hertz's normal law, whose elastic constants it shares";
                let help = "use `soft.hertz`, or `soft.tangential.linear`";
                Err(self.sources.error(origin, message).help(help))
            }
            Some((_, TangentialFile::Mindlin { dashpot_ratio: Some(typed), .. })) if is_viscoelastic => {
                let why = "is a share of a normal dashpot of Hertz's law, which `soft.kuwabara_kono` does not have";
                Err(self.refuse(typed, why).help("leave it out, or use [soft.hertz]"))
            }
            Some((_, TangentialFile::Mindlin { history, dashpot_ratio })) => {
                let history = match history.as_ref().map(|typed| typed.value) {
                    None | Some(HistoryFile::Rescaled) => SpringHistory::Rescaled,
                    Some(HistoryFile::Force) => SpringHistory::Force,
                    Some(HistoryFile::Displacement) => SpringHistory::Displacement,
                };
                Ok(TangentialLaw::Mindlin { history, dashpot: self.dashpot_ratio(dashpot_ratio.as_ref())? })
            }
            Some((origin, TangentialFile::Linear { stiffness_ratio, dashpot_ratio, tangential_restitution })) => {
                let one = || {
                    let message = "`soft.tangential.linear` takes either `stiffness_ratio` or `tangential_restitution`";
                    self.sources.error(origin, message)
                };
                match (stiffness_ratio, tangential_restitution) {
                    (Some(stiffness), None) => {
                        self.ratios(stiffness, dashpot_ratio.as_ref()).map(TangentialLaw::Linear)
                    }
                    (None, Some(_)) if dashpot_ratio.is_some() => {
                        Err(one().help("the dashpot follows from `tangential_restitution`: leave `dashpot_ratio` out"))
                    }
                    (None, Some(typed)) => {
                        let help = "no spring in equal half periods has less; `stiffness_ratio` below 1/14 has β_0 < 0";
                        let beta = self.in_range(typed, help)?;
                        Ok(TangentialLaw::Linear(LinearTangential::Restitution(beta)))
                    }
                    _ => Err(one().help("0.2857 (2/7) is a usual `stiffness_ratio`")),
                }
            }
        }
    }

    fn ratios(
        &self,
        stiffness: &Located<Ratio>,
        dashpot: Option<&Located<Ratio>>,
    ) -> Result<LinearTangential, Diagnostic> {
        let help = "spheres of an elastic solid have 2(1 - ν)/(2 - ν), 0.67 to 1; 2/7 swings as the normal spring does";
        let stiffness = self.in_range(stiffness, help)?;
        Ok(LinearTangential::Ratios { stiffness, dashpot: self.dashpot_ratio(dashpot)? })
    }

    fn dashpot_ratio(&self, typed: Option<&Located<Ratio>>) -> Result<f64, Diagnostic> {
        typed.map_or(Ok(0.0), |typed| self.in_range(typed, "other codes often take 0.5"))
    }

    /// Law of rolling resistance that a case gives; `None` if there is none.
    fn rolling_law(&self, file: &CaseFile) -> Result<Option<RollingLaw>, Diagnostic> {
        let typed = file.soft.as_ref().and_then(|soft| soft.value.rolling.as_ref());
        let Some(typed) = typed else { return Ok(None) };
        let help = "glass beads have some 0.01, sand 0.1";
        let law = match &typed.value {
            RollingFile::Spring { friction, stiffness_ratio, damping_ratio } => {
                let friction = self.in_range(self.need(friction, "soft.rolling.spring.friction")?, help)?;
                let help = "leave it out for 2.25 μ_r²";
                let stiffness = stiffness_ratio.as_ref().map(|typed| self.in_range(typed, help)).transpose()?;
                let damping = self.resistance_damping(damping_ratio.as_ref(), 0.3)?; // example of Ai et al. 2011
                RollingLaw::Spring { friction, stiffness, damping }
            }
            RollingFile::Constant { friction } => {
                let friction = self.in_range(self.need(friction, "soft.rolling.constant.friction")?, help)?;
                RollingLaw::Constant { friction }
            }
            RollingFile::Viscous { coefficient } => {
                let typed = self.need(coefficient, "soft.rolling.viscous.coefficient")?;
                let help = "rolling friction over the speed at which it would be reached";
                RollingLaw::Viscous { coefficient: self.in_range(typed, help)? }
            }
        };
        Ok(Some(law))
    }

    fn resistance_damping(&self, typed: Option<&Located<Ratio>>, default: f64) -> Result<f64, Diagnostic> {
        typed.map_or(Ok(default), |typed| self.in_range(typed, "1 is critical damping"))
    }

    /// Law of twisting resistance that a case gives; `None` if there is none.
    fn twisting_law(&self, file: &CaseFile, tangential: TangentialLaw) -> Result<Option<TwistingLaw>, Diagnostic> {
        let typed = file.soft.as_ref().and_then(|soft| soft.value.twisting.as_ref());
        let Some(typed) = typed else { return Ok(None) };
        if !tangential.has_memory() {
            let message = "`soft.twisting` needs a tangential spring, whose stiffness it shares";
            let help = "add [soft.tangential.linear] or [soft.tangential.mindlin]";
            return Err(self.sources.error(&typed.origin, message).help(help));
        }
        let damping = self.resistance_damping(typed.value.damping_ratio.as_ref(), 0.0)?;
        Ok(Some(TwistingLaw { damping }))
    }

    /// Refuses the impact rule of a tangential spring in models with instantaneous impacts if a restitution depends on
    /// the speed, because this rule holds for one restitution only. With soft spheres the result is then Coulomb's
    /// rule, which is never used. `None` if no restitution depends on the speed.
    fn rule_by_speed(&self, file: &CaseFile, scene: &Scene) -> Result<Option<ImpactRule>, Diagnostic> {
        let depends = scene.depends_on_speed();
        let typed = file.hard.as_ref().and_then(|hard| hard.value.friction.as_ref()).map(|rule| &rule.origin);
        let typed = typed.or(file.soft.as_ref().map(|soft| &soft.origin));
        match typed.filter(|_| depends && self.model != Model::Soft) {
            Some(origin) => {
                let message = "the rule of a tangential spring holds for one restitution, and a restitution of this case depends \
                               on the speed of impact";
                let help = "add [hard.friction.walton], or use the soft model";
                Err(self.sources.error(origin, message).help(help))
            }
            None => Ok(depends.then_some(ImpactRule::COULOMB)),
        }
    }

    /// Impact rule that a case gives. If the case gives none, the rule is that of the tangential spring; without such
    /// a spring it is Coulomb's rule (an impact stops the slip, as far as friction suffices).
    fn impact_rule(
        &mut self,
        file: &CaseFile,
        scene: &Scene,
        soft: &SoftSettings,
        tangential: TangentialLaw,
    ) -> Result<ImpactRule, Diagnostic> {
        if let Some(tangential_restitution) = self.walton(file)? {
            return Ok(ImpactRule::Walton { tangential_restitution });
        }
        let typed = file.hard.as_ref().and_then(|hard| hard.value.friction.as_ref());
        let wants_spring = typed.filter(|typed| matches!(typed.value, ImpactRuleFile::OfSpring {}));
        if let (Some(typed), false) = (wants_spring, tangential.has_memory()) {
            let message = format!("`{}.of_spring` needs a spring", typed.path);
            let help = "add [soft.tangential.linear], or use [hard.friction.walton]";
            return Err(self.sources.error(&typed.origin, message).help(help));
        }
        if !tangential.has_memory() || (typed.is_some() && wants_spring.is_none()) {
            return Ok(ImpactRule::COULOMB);
        }
        if let Some(rule) = self.rule_by_speed(file, scene)? {
            return Ok(rule);
        }
        let impacts = scene.impact_kinds(|elasticity| soft.law.map_or(0.0, |law| law.shear_ratio(elasticity)));
        let two_rules = |one: &ImpactKind| impacts.iter().any(|other| one.has_table_of(other) && !one.is_like(other));
        if let (true, Some(typed)) = (impacts.iter().any(two_rules), file.soft.as_ref()) {
            let message = "two materials have different springs at equal restitution: a hard impact has no single rule";
            let help = "use [hard.friction.walton], or give both the same `elasticity`";
            return Err(self.sources.error(&typed.origin, message).help(help));
        }
        let stops = impacts.iter().any(|kind| kind.restitution <= 0.0);
        if let (true, Some(contact)) = (stops, &file.contact) {
            let message = "restitution 0 has no spring, whose rule hard impacts are to follow";
            let help = "use 0.01, or [hard.friction.walton]";
            return Err(self.sources.error(&contact.origin, message).help(help));
        }
        Ok(ImpactRule::of_spring(&tangential, &impacts))
    }
}
