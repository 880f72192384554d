//! `diptych fluid`: writes the velocity profile of the gas as a table and a figure, without moving any particle. A
//! variant is one of the experiments of a case.

mod among;

use crate::case::Case;
use crate::cli::FluidArguments as Args;
use crate::fluid::{Fluid, Profile};
use crate::output::{FIGURES, Folder, OutputError, SUMMARY, figures};
use crate::runs::{StudyError, conclude, folder, read};
use serde::Serialize;

/// Number of equally spaced rows in `profile.csv`, for a profile that was not computed on a grid.
const ROWS: usize = 401;

/// Summary of the velocity profile of a gas.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FluidSummary {
    /// [m] height of the box along y, the wall-normal direction.
    pub height: f64,
    /// [m/s] mean velocity of the gas over the height of the box, or over the cross-section of a pipe.
    pub bulk_velocity: f64,
    /// [m/s] greatest velocity of the gas.
    pub maximum_velocity: f64,
    /// [-] Reynolds number of the mean velocity and the distance between the walls of the gas. In a pipe, the diameter
    /// replaces this distance.
    pub reynolds_number: f64,
    /// [m/s] friction velocity u_τ of the gas; `None` for a uniform profile and for one from a table.
    pub friction_velocity: Option<f64>,
    /// Summary of the computed channel flow, for a k-epsilon profile; `None` for other profiles.
    pub channel: Option<ChannelSummary>,
}

/// Summary of a channel flow that was computed with a k-epsilon model of turbulence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelSummary {
    /// Name of the k-epsilon model of turbulence.
    pub model: String,
    /// [m/s] friction velocity u_τ of the channel flow.
    pub friction_velocity: f64,
    /// [-] friction Reynolds number u_τ h/ν of the channel, where h is half the height of the channel and ν the
    /// kinematic viscosity.
    pub reynolds_tau: f64,
    /// Number of cells of the grid over half the height of the channel.
    pub cells: usize,
    /// [-] distance of the first node of the grid from the wall, in wall units (y⁺).
    pub first_node: f64,
    /// Number of iterations of the equations of k and ε until they converged.
    pub iterations: usize,
    /// [-] largest relative change of the variables of the turbulence model in the last iteration.
    pub residual: f64,
    /// [-] imbalance of the equation of the turbulent kinetic energy k, integrated over half the channel. It is
    /// (production - dissipation - wall flux)/production.
    pub k_imbalance: f64,
}

/// One row of `profile.csv`: the gas at one height y, in SI units. Cells are empty if the profile gives no value.
#[derive(Serialize)]
struct FluidProfileRow {
    y_m: f64,
    #[serde(rename = "U_m_s")]
    u: f64,
    k_m2_s2: Option<f64>,
    epsilon_m2_s3: Option<f64>,
    nu_t_m2_s: Option<f64>,
    y_plus: Option<f64>,
    #[serde(rename = "U_plus")]
    u_plus: Option<f64>,
}

/// Computes the gas profile of a case and writes it to `profile.csv`, `figures/` and `summary.json`.
///
/// # Errors
/// Returns an error for bad input, before anything is written, or for a file that cannot be written.
pub fn fluid(args: &Args) -> Result<(), StudyError> {
    let case = read(&args.case, &args.input)?;
    let checked = match case.experiment(None, None) {
        Ok(checked) => checked,
        // if the model of the case cannot run, the variants of the case may still define a gas
        Err(why) => case.variants(None).ok().and_then(|list| list.into_iter().next()).ok_or(why)?,
    };
    let scene = &checked.0.scene;
    let Some(fluid) = &scene.fluid else {
        let case = args.case.display();
        return Err(StudyError::Input(format!(
            "error: the case `{case}` has no gas\nhelp: give it a [fluid] table; `cases/quick.toml` has one"
        )));
    };
    let among = match &args.after {
        Some(run) => among::gases(run, &fluid.profile)?,
        None => Vec::new(),
    };
    let folder = folder(&args.output, &args.case, "fluid")?;
    let summary = write_profile(fluid, scene.domain.size.y, &folder)?;
    let gases = gases(&case);
    let flows = among.iter().map(|gas| (gas.name.as_str(), [gas.alone.as_slice(), gas.mean.as_slice()]));
    let before_and_after = figures::loaded_flows(&flows.collect::<Vec<_>>());
    let others = figures::gases(&gases, scene.domain.size.y).into_iter().chain(before_and_after);
    for figure in others.chain([figures::geometry(scene)]) {
        folder.write(&format!("{FIGURES}/{}.svg", figure.name), figure.svg.as_bytes())?;
    }
    if !args.output.quiet {
        let mut sentences = vec![format!(
            "Bulk velocity {:.4} m/s, Reynolds number {:.0}, greatest velocity {:.4} m/s.",
            summary.bulk_velocity, summary.reynolds_number, summary.maximum_velocity
        )];
        if let Some(wall) = fluid.profile.wall_scale() {
            let name = match fluid.profile.channel_flow() {
                Some(flow) => flow.model.to_string(),
                None => "logarithmic law".into(),
            };
            sentences.push(format!(
                "{name}: friction velocity {:.4} m/s, friction Reynolds number {:.1}.",
                wall.friction_velocity,
                0.5 * width(&fluid.profile, scene.domain.size.y) / wall.length
            ));
        }
        sentences.extend(gases.iter().map(|(name, profile)| {
            let bulk = bulk_velocity(profile, scene.domain.size.y);
            format!("\"{name}\": bulk velocity {bulk:.4} m/s, greatest velocity {:.4} m/s.", profile.maximum())
        }));
        sentences.extend(among.iter().filter_map(among::GasAmongParticles::sentence));
        sentences.extend(folder.pictures().iter().map(|picture| format!("Picture: {}", picture.display())));
        conclude(&sentences, "Profile", &folder.path().join("profile.csv"));
    }
    Ok(())
}

/// Writes the profile of the gas between walls at y = 0 and y = `height` [m]. A k-epsilon profile is written at the
/// nodes of its grid in both halves of the channel. Near the walls it has points of the law of the wall, without k, ε
/// and ν_t. Any other profile is written at equal distances. Figures of the profile and its summary are also written;
/// the summary is returned.
///
/// # Errors
/// Returns an error if a file cannot be written.
pub fn write_profile(fluid: &Fluid, height: f64, folder: &Folder) -> Result<FluidSummary, OutputError> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in rows(&fluid.profile, height) {
        csv.serialize(row)?;
    }
    let csv = csv.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    folder.write("profile.csv", &csv)?;
    for figure in figures::gas(&fluid.profile, height) {
        folder.write(&format!("{FIGURES}/{}.svg", figure.name), figure.svg.as_bytes())?;
    }
    let summary = summary(fluid, height);
    folder.write(SUMMARY, &serde_json::to_vec_pretty(&summary)?)?;
    Ok(summary)
}

fn rows(profile: &Profile, height: f64) -> Vec<FluidProfileRow> {
    let [low, _] = profile.between(height);
    let Some(flow) = profile.channel_flow() else {
        let sample = profile.sample(height, ROWS).into_iter();
        let row = |(y_m, u)| FluidProfileRow {
            y_m,
            u,
            k_m2_s2: None,
            epsilon_m2_s3: None,
            nu_t_m2_s: None,
            y_plus: None,
            u_plus: None,
        };
        return sample.map(row).collect();
    };
    let wall = |y: f64, u: f64| FluidProfileRow {
        y_m: y,
        u,
        k_m2_s2: None,
        epsilon_m2_s3: None,
        nu_t_m2_s: None,
        y_plus: Some(y * flow.friction_velocity / flow.kinematic_viscosity),
        u_plus: Some(u / flow.friction_velocity),
    };
    let first = flow.nodes.first().map_or(0.0, |node| node.y);
    let below = flow.profile.iter().take_while(|(y, _)| *y < first).map(|(y, u)| wall(*y, *u));
    let nodes = flow.nodes.iter().map(|node| FluidProfileRow {
        k_m2_s2: Some(node.k),
        epsilon_m2_s3: Some(node.epsilon),
        nu_t_m2_s: Some(node.nu_t),
        ..wall(node.y, node.u)
    });
    let half: Vec<FluidProfileRow> = below.chain(nodes).collect();
    let mirrored: Vec<FluidProfileRow> =
        half.iter().rev().map(|row| FluidProfileRow { y_m: flow.height - row.y_m, ..*row }).collect();
    let rows = half.into_iter().chain([wall(0.5 * flow.height, flow.centre_velocity)]).chain(mirrored);
    rows.map(|row| FluidProfileRow { y_m: low + row.y_m, ..row }).collect()
}

fn summary(fluid: &Fluid, height: f64) -> FluidSummary {
    let profile = &fluid.profile;
    let flow = profile.channel_flow();
    let bulk_velocity = bulk_velocity(profile, height);
    FluidSummary {
        height,
        bulk_velocity,
        maximum_velocity: profile.maximum(),
        reynolds_number: bulk_velocity * width(profile, height) / fluid.kinematic_viscosity,
        friction_velocity: profile.wall_scale().map(|wall| wall.friction_velocity),
        channel: flow.map(|flow| {
            let budget = flow.k_budget;
            let first = flow.nodes.first().map_or(0.0, |node| node.y);
            ChannelSummary {
                model: format!("{:?}", flow.model),
                friction_velocity: flow.friction_velocity,
                reynolds_tau: flow.reynolds_tau,
                cells: flow.nodes.len(),
                first_node: first * flow.friction_velocity / flow.kinematic_viscosity,
                iterations: flow.iterations,
                residual: flow.residual,
                k_imbalance: (budget.production - budget.dissipation - budget.wall_flux) / budget.production,
            }
        }),
    }
}

/// Gas profiles of the variants (experiments) of a case, each with the name of the first variant that has this gas.
/// Empty if all variants have the same gas or none.
fn gases(case: &Case) -> Vec<(String, Profile)> {
    let mut gases: Vec<(String, Profile)> = Vec::new();
    for (experiment, _) in case.variants(None).unwrap_or_default() {
        let Some(fluid) = experiment.scene.fluid else { continue };
        let height = experiment.scene.domain.size.y;
        let known = |(_, other): &(String, Profile)| other.sample(height, ROWS) == fluid.profile.sample(height, ROWS);
        if !gases.iter().any(known) {
            gases.push((experiment.name, fluid.profile));
        }
    }
    if gases.len() < 2 { Vec::new() } else { gases }
}

/// [m] length by which the Reynolds number of the gas is defined: the distance between its walls, or the diameter of
/// its pipe. `height` [m] is the height of the box.
fn width(profile: &Profile, height: f64) -> f64 {
    let [low, high] = profile.between(height);
    high - low
}

/// [m/s] mean velocity of the gas over the height `height` [m], or over the cross-section of a pipe. The profiles of a
/// channel flow, a logarithmic law and a pipe store this mean. For other profiles, [`ROWS`] equally spaced points are
/// averaged.
fn bulk_velocity(profile: &Profile, height: f64) -> f64 {
    profile.bulk_velocity().unwrap_or_else(|| mean(profile, height))
}

/// [m/s] mean velocity of the gas over the height `height` [m], by the trapezoidal rule on [`ROWS`] equally spaced
/// points.
fn mean(profile: &Profile, height: f64) -> f64 {
    let sample = profile.sample(height, ROWS);
    sample.windows(2).map(|pair| 0.5 * (pair[0].1 + pair[1].1)).sum::<f64>() / (ROWS - 1) as f64
}
