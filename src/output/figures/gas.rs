//! Figures of the gas velocity: across the channel (Fig. 2 of the paper, docs/paper.md), and in wall units together
//! with a direct numerical simulation. A variant is one of the experiments of a case.

use super::chart;
use super::profiles;
use crate::fluid::{ChannelFlow, GridNode, Profile, Section, TurbulenceModel};
use crate::outcome::Outcome;
use crate::output::numbers::Prefix;
use crate::output::panel::Figure;
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};

/// Points (y⁺, U⁺) of a direct numerical simulation of channel flow at Re_τ = 1000.512, in wall units: y⁺ = y u_τ/ν and
/// U⁺ = U/u_τ, with the kinematic viscosity ν. The friction velocity u_τ of the simulation is 0.0500256 times its bulk
/// velocity. Source: Lee and Moser 2015, J. Fluid Mech. 774, 395-415.
pub const CHANNEL_DNS: [(f64, f64); 9] = [
    (5.0, 4.829),
    (10.0, 8.434),
    (30.0, 13.453),
    (100.0, 16.454),
    (200.0, 18.199),
    (300.0, 19.319),
    (500.0, 20.857),
    (700.0, 21.907),
    (998.0, 22.593),
];

/// Number of points of a drawn curve of the gas velocity.
const POINTS: usize = 400;
/// Number of points of each curve in a picture of several gases.
const GASES_POINTS: usize = 120;

/// Figures of the profile of the gas velocity between walls at y = 0 and y = `height` [m]. For a channel that is
/// computed by a k-epsilon model, there is a second figure in wall units. These are ν/u_τ for distances and u_τ for
/// velocities, with the kinematic viscosity ν and the friction velocity u_τ.
pub fn gas(profile: &Profile, height: f64) -> Vec<Figure> {
    let mut figures = vec![Figure::new(
        "velocity",
        "Mean streamwise velocity of the gas.",
        chart::single(&profiles::gas_velocity(profile, height)),
    )];
    // the direct numerical simulation is that of a channel, not of a pipe
    if let Some(flow) = profile.channel_flow().filter(|flow| flow.section == Section::Channel) {
        figures.push(Figure::new(
            "wall-units",
            "Mean streamwise velocity of the gas in wall units, beside a direct numerical simulation.",
            chart::single(&wall_units(profile, flow)),
        ));
    }
    figures
}

/// Figure of the profiles of several gases between walls at y = 0 and y = `height` [m]. The horizontal axis is the
/// distance from the wall on a logarithmic scale, up to the middle of the channel. `None` if there are fewer than two
/// gases.
pub fn gases(profiles: &[(String, Profile)], height: f64) -> Option<Figure> {
    /// [-] distance from the wall at which the curves begin, divided by the width of the channel. In a channel of the
    /// width 40 mm, this distance is 0.1 mm, half the radius of spheres with the diameter 0.4 mm.
    const NEAREST: f64 = 2.5e-3;
    if profiles.len() < 2 {
        return None;
    }
    let prefix = Prefix::of(height);
    let place = |i: usize| NEAREST * height * (0.5 / NEAREST).powf(i as f64 / GASES_POINTS as f64);
    let series = profiles.iter().enumerate().map(|(look, (name, profile))| {
        let point = |y: f64| SeriesPoint::at(y * prefix.factor, profile.velocity(y));
        PanelSeries::new(name, SeriesStyle::Line(look), (0..=GASES_POINTS).map(|i| point(place(i))))
    });
    let series: Vec<PanelSeries> = series.collect();
    let top = series.iter().flat_map(|series| &series.points).fold(0.0, |top: f64, point| top.max(point.y));
    let panel = Panel {
        x_label: format!("y  [{}m]", prefix.symbol),
        y_label: "U  [m/s]".into(),
        series,
        y_range: Some((0.0, 1.1 * top)), // room above the curves
        x_range: Some((NEAREST * height * prefix.factor, 0.5 * height * prefix.factor)),
        log_x: true,
        ..Panel::default()
    };
    Some(Figure::new("gases", "Mean streamwise velocity of the gases of all variants.", chart::single(&panel)))
}

/// Figure of a gas on which the particles act, together with the gas without particles. It shows velocity and turbulent
/// kinetic energy from the wall to the middle. `None` if the particles do not change the gas in any experiment of the
/// case.
pub fn loaded(outcomes: &[Outcome]) -> Option<Figure> {
    let flows = outcomes.iter().filter_map(|outcome| {
        let gas = outcome.gas.as_ref()?;
        Some((outcome.experiment.name.as_str(), [gas.alone.as_slice(), gas.mean.as_slice()]))
    });
    loaded_flows(&flows.collect::<Vec<_>>())
}

/// Figure of gas flows with particles, together with the flow without particles. Each entry of `flows` has a name and
/// the grid nodes, from the wall to the middle, of the gas without and with particles. The flow without particles is
/// drawn once, from the first entry. `None` if `flows` is empty.
pub fn loaded_flows(flows: &[(&str, [&[GridNode]; 2])]) -> Option<Figure> {
    let (_, [first, _]) = flows.first()?;
    let prefix = Prefix::of(first.last()?.y);
    let panel = |label: &str, of: fn(&GridNode) -> f64| {
        let points = |nodes: &[GridNode]| -> Vec<SeriesPoint> {
            nodes.iter().map(|node| SeriesPoint::at(node.y * prefix.factor, of(node))).collect()
        };
        let alone = PanelSeries::new("gas alone", SeriesStyle::Reference, points(first));
        let among = flows
            .iter()
            .enumerate()
            .map(|(style, (name, [_, mean]))| PanelSeries::new(*name, SeriesStyle::Line(style), points(mean)));
        Panel {
            x_label: format!("distance from the wall  [{}m]", prefix.symbol),
            y_label: label.into(),
            series: std::iter::once(alone).chain(among).collect(),
            ..Panel::default()
        }
    };
    let panels = [panel("U  [m/s]", |node| node.u), panel("k  [m²/s²]", |node| node.k)];
    let caption = "Mean velocity and turbulent kinetic energy of the gas, alone and averaged among the particles.";
    Some(Figure::new("gas", caption, chart::grid(&panels)))
}

fn wall_units(profile: &Profile, flow: &ChannelFlow) -> Panel {
    let wall_unit = flow.kinematic_viscosity / flow.friction_velocity;
    let model = match flow.model {
        TurbulenceModel::WallFunctions => "k-ε, wall functions",
        TurbulenceModel::LaunderSharma => "k-ε, Launder and Sharma",
    };
    let between = |from: f64, to: f64| (0..=POINTS).map(move |i| from * (to / from).powf(i as f64 / POINTS as f64));
    let series = |label: &str, look: SeriesStyle, points: Vec<(f64, f64)>| {
        PanelSeries::new(label, look, points.into_iter().map(|(x, y)| SeriesPoint::at(x, y)))
    };
    let velocity = |y: f64| profile.velocity(y * wall_unit) / flow.friction_velocity;
    let mut all = vec![
        // κ = 0.41 and E = 9.0 are the constants of the wall functions
        series(
            "ln(9 y⁺)/0.41",
            SeriesStyle::Exact,
            between(5.0, flow.reynolds_tau).map(|y| (y, (9.0 * y).ln() / 0.41)).collect(),
        ),
        series("U⁺ = y⁺", SeriesStyle::Reference, between(1.0, 14.0).map(|y| (y, y)).collect()),
        series(model, SeriesStyle::Line(0), between(1.0, flow.reynolds_tau).map(|y| (y, velocity(y))).collect()),
    ];
    if flow.model == TurbulenceModel::WallFunctions {
        let nodes = flow.nodes.iter().map(|node| (node.y / wall_unit, node.u / flow.friction_velocity));
        all.push(series("its nodes", SeriesStyle::Points(0), nodes.collect()));
    }
    all.push(series("DNS, Lee and Moser 2015", SeriesStyle::Points(1), CHANNEL_DNS.to_vec()));
    let top = all.iter().flat_map(|series| &series.points).fold(0.0, |top: f64, point| top.max(point.y));
    Panel {
        x_label: "y⁺ = y u_τ/ν  [–]".into(),
        y_label: "U⁺ = U/u_τ  [–]".into(),
        series: all,
        x_range: Some((1.0, 2.0 * flow.reynolds_tau)),
        y_range: Some((0.0, 1.1 * top)), // room above the curves
        log_x: true,
        ..Panel::default()
    }
}
