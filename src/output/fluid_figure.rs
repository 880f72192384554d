//! The figure of a gas profile.

use crate::fluid::{ChannelFlow, Profile, TurbulenceModel};
use kuva::prelude::*;

/// U+(y+) of a direct numerical simulation of channel flow at Re_τ = 1000.512, u_τ = 0.0500256 U_b: Lee and Moser 2015,
/// J. Fluid Mech. 774, 395-415.
const DNS: [(f64, f64); 9] = [
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

/// Colours that stay apart for colour-blind readers: Okabe and Ito 2008.
const BLUE: &str = "#0072B2";
const VERMILION: &str = "#D55E00";
const GREY: &str = "#666666";

/// Points of a drawn curve.
const POINTS: usize = 400;

/// The profile as an SVG: in wall units with direct numerical simulation beside it for a k-epsilon channel, otherwise
/// U against y over `height` [m].
pub fn fluid_figure(profile: &Profile, height: f64) -> String {
    match profile.channel_flow() {
        Some(flow) => wall_units(profile, flow),
        None => plain(profile, height),
    }
}

fn wall_units(profile: &Profile, flow: &ChannelFlow) -> String {
    let wall_unit = flow.kinematic_viscosity / flow.friction_velocity;
    let model = match flow.model {
        TurbulenceModel::WallFunctions => "k-ε with wall functions",
        TurbulenceModel::LaunderSharma => "k-ε of Launder and Sharma",
    };
    let logarithmic = |from: f64, to: f64| (0..=POINTS).map(move |i| from * (to / from).powf(i as f64 / POINTS as f64));
    let curve =
        logarithmic(1.0, flow.reynolds_tau).map(|y| (y, profile.velocity(y * wall_unit) / flow.friction_velocity));
    let mut plots: Vec<Plot> = vec![
        LinePlot::new()
            .with_data(logarithmic(1.0, 14.0).map(|y| (y, y)))
            .with_color(GREY)
            .with_dotted()
            .with_stroke_width(1.5)
            .with_legend("viscous law, U⁺ = y⁺")
            .into(),
        LinePlot::new()
            // κ = 0.41 and E = 9.0: the constants of the wall functions.
            .with_data(logarithmic(5.0, flow.reynolds_tau).map(|y| (y, (9.0 * y).ln() / 0.41)))
            .with_color(GREY)
            .with_dashed()
            .with_stroke_width(1.5)
            .with_legend("log law, U⁺ = ln(9 y⁺)/0.41")
            .into(),
        LinePlot::new()
            .with_data(curve)
            .with_color(BLUE)
            .with_stroke_width(2.5)
            .with_legend(format!("{model}, Re_τ = {:.0}", flow.reynolds_tau))
            .into(),
    ];
    if flow.model == TurbulenceModel::WallFunctions {
        let nodes = flow.nodes.iter().map(|node| (node.y / wall_unit, node.u / flow.friction_velocity));
        plots.push(
            ScatterPlot::new()
                .with_data(nodes)
                .with_color(BLUE)
                .with_size(3.5)
                .with_marker(MarkerShape::Square)
                .with_legend("its nodes; below: law of the wall")
                .into(),
        );
    }
    plots.push(
        ScatterPlot::new()
            .with_data(DNS)
            .with_color(VERMILION)
            .with_size(5.0)
            .with_marker(MarkerShape::Circle)
            .with_legend("DNS, Lee and Moser 2015, Re_τ = 1001")
            .into(),
    );
    let layout = Layout::auto_from_plots(&plots)
        .with_log_x()
        .with_x_axis_min(1.0)
        .with_x_axis_max(2.0 * flow.reynolds_tau)
        .with_y_axis_min(0.0)
        .with_title("Mean gas velocity in the channel, wall units")
        .with_x_label("distance from the wall, y⁺ = y u_τ / ν  [-]")
        .with_y_label("mean velocity, U⁺ = U / u_τ  [-]")
        .with_legend_position(LegendPosition::InsideTopLeft)
        .with_width(760.0)
        .with_height(520.0);
    kuva::render_to_svg(plots, layout)
}

fn plain(profile: &Profile, height: f64) -> String {
    let points = profile.sample(height, POINTS).into_iter().map(|(y, u)| (u, 1e3 * y));
    let plots: Vec<Plot> = vec![LinePlot::new().with_data(points).with_color(BLUE).with_stroke_width(2.5).into()];
    let layout = Layout::auto_from_plots(&plots)
        .with_title("Mean gas velocity")
        .with_x_label("mean velocity, U  [m/s]")
        .with_y_label("distance from the wall, y  [mm]")
        .with_width(760.0)
        .with_height(520.0);
    kuva::render_to_svg(plots, layout)
}
