//! `diptych chart CASE`: the precision that each method reaches for its cost.
//!
//! Each method has a parameter, such as the time step, that is varied in a sweep. The runs are done one after the other
//! on one thread. Errors are measured against a reference, and the chart also gives the error of the reference.

mod conclusion;
mod crowd;
mod impact;
mod methods;
mod outlook;
mod stretch;

pub use conclusion::{sentences, slopes};
pub use crowd::Crowd;
pub use impact::{HeadOn, PHASES};
pub use methods::{FINE_STEPS, MethodParameter, MethodSweep, Values};
pub use outlook::Outlook;
pub use stretch::{STARTS, Stretch};

use crate::case::{Case, describe};
use crate::cli::Chart;
use crate::experiment::Experiment;
use crate::output::numbers::{quantity, significant};
use crate::output::{ChartMethod, ChartPoint, ChartQuantity, ChartStudy, chart_answers, write_chart};
use crate::predict::contact::at_fastest_impacts;
use crate::predict::springs::fastest_spring;
use crate::runs::{StudyError, conclude, folder, provenance, read, start, tell};

/// Results of a chart, before they are written to files.
pub struct ChartResults {
    /// Description, for the reader, of the reference against which errors are measured.
    pub reference: String,
    /// Description of the runs from which each point of the chart is computed, for the reader.
    pub setting: String,
    /// Methods that the chart compares.
    pub methods: Vec<ChartMethod>,
    /// Quantities in which the errors of the methods are measured.
    pub quantities: Vec<ChartQuantity>,
    /// Points of the chart: cost and errors of one method at one value of its parameter. They are ordered by method,
    /// and from coarse to fine.
    pub points: Vec<ChartPoint>,
    /// Notes for the reader below the chart.
    pub notes: Vec<String>,
}

/// Makes the chart of a case and writes it to a folder.
///
/// # Errors
/// Returns an error for bad input, before anything is computed, or if no reference can be computed for the scene.
pub fn chart(args: &Chart) -> Result<(), StudyError> {
    let case = read(&args.case, &args.input)?;
    let base = base(&case)?;
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = one_thread.map_err(|why| StudyError::Failed(format!("error: cannot start a thread: {why}")))?;
    let scene = scene(&base, &args.case)?;
    let folder = folder(&args.output, &args.case, "chart")?;
    let quiet = args.output.quiet;
    let mut outlook = Outlook::new((!quiet).then_some(|text| tell(text)));
    let results = pool.install(|| measure(&base, scene, args.quick, &mut outlook))?;
    let slopes = slopes(&results.quantities, results.methods.len(), &results.points);
    let verdicts = sentences(&results.methods, &results.quantities, &results.points, &slopes);
    let study = ChartStudy {
        provenance: &provenance(&case, describe(&base)),
        reference: &results.reference,
        setting: &results.setting,
        methods: &results.methods,
        quantities: &results.quantities,
        points: &results.points,
        slopes: &slopes,
        verdicts: &verdicts,
        notes: &results.notes,
    };
    let report = write_chart(&folder, &study)?;
    if !quiet {
        // the first sentences, one for each quantity, are in the report only; they are not printed
        let failures = verdicts.iter().skip(results.quantities.len()).cloned();
        let said: Vec<String> = std::iter::once(chart_answers(&study)).chain(failures).collect();
        conclude(&said, "Report", &report);
    }
    Ok(())
}

/// Experiment of the case, with the contact law of the first variant (experiment of the case) that has one. Every
/// method of the chart runs a changed copy of this experiment.
fn base(case: &Case) -> Result<Experiment, StudyError> {
    let variants = case.variants(None);
    let run = case.experiment(None, None);
    let known: Vec<Experiment> =
        run.iter().cloned().chain(variants.iter().flatten().cloned()).map(|(experiment, _)| experiment).collect();
    let Some(mut base) = known.first().cloned() else {
        // both results are errors here; the error of the case itself says more than that of its variants
        return Err(run
            .err()
            .or(variants.err())
            .map_or_else(|| StudyError::Failed("error: no variant".into()), Into::into));
    };
    base.soft.law = base.soft.law.or_else(|| known.iter().find_map(|experiment| experiment.soft.law));
    Ok(base)
}

/// Head-on impact of the case, if its scene consists of one or two particles; `None` for a scene with more particles.
fn scene(base: &Experiment, path: &std::path::Path) -> Result<Option<HeadOn>, StudyError> {
    let count: usize = base.start.iter().map(|population| population.amount.count()).sum();
    if count == 0 {
        return Err(StudyError::Input(format!(
            "error: {}: there are no particles to chart\nhelp: `cases/impact.toml` and `cases/quick.toml` can be charted",
            path.display()
        )));
    }
    if base.run.duration <= 0.0 {
        return Err(StudyError::Input(format!(
            "error: {}: `run.duration` = 0 s leaves nothing to chart\nhelp: give it the time that should be simulated",
            path.display()
        )));
    }
    if count > 2 {
        return Ok(None);
    }
    let particles = start(base)?;
    HeadOn::of(base, &particles, path).map(Some)
}

/// Runs every method of the chart at every value of its swept parameter, and returns the results. `scene` is the
/// head-on impact of a case with one or two particles, `None` for a case with more particles. `quick` reduces the
/// number of values.
///
/// # Errors
/// Returns an error if no reference can be computed for the scene.
pub fn measure(
    base: &Experiment,
    scene: Option<HeadOn>,
    quick: bool,
    outlook: &mut Outlook,
) -> Result<ChartResults, StudyError> {
    let mut notes = vec![
        "Operations: pair checks, force evaluations and events, the same on every machine. Wall-clock times are those of this machine on one thread."
            .to_owned(),
    ];
    if base.soft.law.is_none() {
        notes.push("The case names no contact law: soft methods are left out.".into());
    }
    notes.extend(on_springs(base));
    match scene {
        Some(head_on) => measure_impact(&head_on, quick, notes, outlook),
        None => measure_crowd(base, quick, notes, outlook),
    }
}

/// Note for the reader on the number of time steps in half a period of the fastest tangential, rolling or twisting
/// spring. `None` if the contact law has no such spring.
fn on_springs(base: &Experiment) -> Option<String> {
    let (law, contacts) = (base.soft.law?, at_fastest_impacts(base));
    let shortest = contacts.iter().map(|contact| contact.contact_time(&law)).reduce(f64::min)?;
    let (spring, contact) = fastest_spring(base, &law, &contacts)?;
    Some(format!(
        "N_c counts the steps in the shortest contact, of {}. Half a period of the {} spring ({}) is {} and gets {} N_c steps.",
        quantity(shortest, "s", 3),
        spring.name,
        contact.name,
        quantity(spring.half_period(), "s", 3),
        significant(spring.half_period() / shortest, 3)
    ))
}

fn measure_impact(
    head_on: &HeadOn,
    quick: bool,
    mut notes: Vec<String>,
    outlook: &mut Outlook,
) -> Result<ChartResults, StudyError> {
    let sweeps = MethodSweep::all(&head_on.experiment, head_on.duration, &HeadOn::values(quick));
    outlook.expect(|| Ok::<_, StudyError>(head_on.expected(&sweeps)))?;
    let points = run_all(&sweeps, outlook, |sweep, method, value, _| head_on.point(sweep, method, value));
    notes.push("The bodies of the case meet head on, without gas or gravity: that has a closed form.".into());
    Ok(ChartResults {
        reference: format!(
            "closed form of one impact (restitution {}, no unexplained energy, an instant collision); exact up to rounding",
            significant(head_on.surface.restitution, 4)
        ),
        setting: format!(
            "{} of one impact at {} m/s, at {PHASES} phases of the first touch within a step; cost: mean counts and median time of one",
            quantity(head_on.duration, "s", 3),
            significant(head_on.approach, 4)
        ),
        methods: sweeps.iter().map(MethodSweep::method).collect(),
        quantities: head_on.quantities(),
        points,
        notes,
    })
}

fn measure_crowd(
    base: &Experiment,
    quick: bool,
    mut notes: Vec<String>,
    outlook: &mut Outlook,
) -> Result<ChartResults, StudyError> {
    let stretch = Stretch::of(base, quick)?;
    if let Some(shortfall) = stretch.shortfall(base, quick) {
        outlook.tell(&shortfall);
        notes.push(shortfall);
    }
    let sweeps = stretch.sweeps(quick);
    outlook.expect(|| stretch.expected(base, &sweeps))?;
    let crowd = Crowd::new(stretch, outlook)?;
    let quantities = crowd.quantities();
    let points = run_all(&sweeps, outlook, |sweep, method, value, outlook| {
        crowd.point(sweep, method, value, &quantities, outlook)
    });
    if !crowd.is_random() {
        notes.push("All starts are the same state: there is no statistical floor.".into());
    }
    let stretch = quantity(crowd.stretch.experiment.run.duration, "s", 3);
    Ok(ChartResults {
        reference: format!(
            "{}, mean of {STARTS} runs of {stretch} from starts of their own; restitution and energy against what they should be",
            crowd.method
        ),
        setting: format!("{stretch} from one state, after {}; one run each", quantity(crowd.stretch.before, "s", 3)),
        methods: sweeps.iter().map(MethodSweep::method).collect(),
        quantities,
        points,
        notes,
    })
}

fn run_all(
    sweeps: &[MethodSweep],
    outlook: &mut Outlook,
    mut point: impl FnMut(&MethodSweep, usize, f64, &mut Outlook) -> ChartPoint,
) -> Vec<ChartPoint> {
    let all: usize = sweeps.iter().map(|sweep| sweep.values.len()).sum();
    let mut points = Vec::with_capacity(all);
    for (method, sweep) in sweeps.iter().enumerate() {
        let name = sweep.method();
        for &value in &sweep.values {
            let number = points.len() + 1;
            outlook.begin(format!("{number}/{all} {}, {} = {}", name.name, name.knob, significant(value, 3)));
            let charted = point(sweep, method, value, outlook);
            outlook.end(&match &charted.failure {
                Some(why) => why.kind().to_owned(),
                None => quantity(charted.wall.median * charted.samples as f64, "s", 2),
            });
            points.push(charted);
        }
    }
    points
}
