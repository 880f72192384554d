//! Gas among particles, as a finished run with `[fluid.coupling]` (the particles act back on the gas) has written it to
//! `gas.csv`. A variant is one of the experiments of a case.

use crate::fluid::{GridNode, Profile};
use crate::legible::quote;
use crate::runs::StudyError;
use serde::Deserialize;
use std::path::Path;

/// Name of the table with the gas among the particles, in the folder of a finished run.
const GAS_TABLE: &str = "gas.csv";
/// Largest size [bytes] of a table `gas.csv` that is read. The table of one variant (experiment of a case) has some 20
/// kB.
const LARGEST: u64 = 50_000_000;
/// [-] largest allowed difference between two velocities of the gas alone: that in the table of the run and that of
/// the case. The difference is divided by the largest velocity. The table has all digits of a double.
const SAME_GAS: f64 = 1e-6;

/// Row of `gas.csv`: the gas at one grid point, alone and averaged among the particles.
#[derive(Clone, Debug, Deserialize)]
struct GasRow {
    variant: String,
    y_m: f64,
    #[serde(rename = "U_alone_m_s")]
    u_alone: f64,
    #[serde(rename = "U_m_s")]
    u: f64,
    k_alone_m2_s2: f64,
    k_m2_s2: f64,
    epsilon_alone_m2_s3: f64,
    epsilon_m2_s3: f64,
    nu_t_alone_m2_s: f64,
    nu_t_m2_s: f64,
}

impl GasRow {
    /// Values of the row at its grid point: first of the gas alone, then of the gas among the particles.
    fn nodes(&self) -> [GridNode; 2] {
        let y = self.y_m;
        [
            GridNode {
                y,
                u: self.u_alone,
                k: self.k_alone_m2_s2,
                epsilon: self.epsilon_alone_m2_s3,
                nu_t: self.nu_t_alone_m2_s,
            },
            GridNode { y, u: self.u, k: self.k_m2_s2, epsilon: self.epsilon_m2_s3, nu_t: self.nu_t_m2_s },
        ]
    }
}

/// Gas of one of the variants (experiments of a case) that were run.
pub struct GasAmongParticles {
    /// Name of the variant (experiment of a case).
    pub name: String,
    /// Gas without particles, at the grid points from the wall to the middle of the channel.
    pub alone: Vec<GridNode>,
    /// Time average of the gas among the particles, at the grid points from the wall to the middle of the channel.
    pub mean: Vec<GridNode>,
}

impl GasAmongParticles {
    /// Sentence about the gas in the middle of the channel, without and with particles; `None` if the table of the gas
    /// is empty.
    pub fn sentence(&self) -> Option<String> {
        let (alone, mean) = (self.alone.last()?, self.mean.last()?);
        Some(format!(
            "\"{}\": among the particles the gas in the middle has {:.4} m/s in place of {:.4} m/s, and {:.3} times its turbulent kinetic energy.",
            self.name,
            mean.u,
            alone.u,
            mean.k / alone.k
        ))
    }
}

/// Reads the gases among particles from the folder `run` of a finished run, one per variant (experiment of a case).
/// `profile` is the gas of the case.
///
/// # Errors
/// Returns an error for a folder without the table, for a table that cannot be read or is too large, or for the table
/// of another gas.
pub fn gases(run: &Path, profile: &Profile) -> Result<Vec<GasAmongParticles>, StudyError> {
    let path = run.join(GAS_TABLE);
    let refuse = |why: String, help: &str| StudyError::Input(format!("error: {why}\nhelp: {help}"));
    let shown = path.display();
    let size = std::fs::metadata(&path).map(|data| data.len()).map_err(|why| {
        let help = "`diptych run` of a case with [fluid.coupling] writes it; a frozen gas is the same before and after";
        refuse(format!("cannot read `{shown}`: {why}"), help)
    })?;
    if size > LARGEST {
        return Err(refuse(format!("`{shown}` has {size} bytes"), "a table of the gas has far fewer"));
    }
    let text = std::fs::read_to_string(&path)
        .map_err(|why| refuse(format!("cannot read `{shown}`: {why}"), "a text file belongs here"))?;
    let mut gases: Vec<GasAmongParticles> = Vec::new();
    for row in csv::Reader::from_reader(text.as_bytes()).deserialize::<GasRow>() {
        let row = row.map_err(|why| refuse(format!("`{shown}` is no table of the gas: {why}"), "run the case anew"))?;
        let [alone, mean] = row.nodes();
        if gases.last().is_none_or(|gas| gas.name != row.variant) {
            gases.push(GasAmongParticles { name: quote(&row.variant).into_owned(), alone: vec![], mean: vec![] });
        }
        if let Some(gas) = gases.last_mut() {
            gas.alone.push(alone);
            gas.mean.push(mean);
        }
    }
    let nodes = profile.channel_flow().map_or(&[][..], |flow| &flow.nodes);
    let largest = profile.maximum();
    let differs = |(there, here): (&GridNode, &GridNode)| (there.u - here.u).abs() > SAME_GAS * largest;
    let is_other =
        |gas: &&GasAmongParticles| gas.alone.len() != nodes.len() || gas.alone.iter().zip(nodes).any(differs);
    if let Some(gas) = gases.iter().find(is_other) {
        let why = format!("the gas alone of \"{}\" in `{shown}` is not the gas of this case", gas.name);
        return Err(refuse(why, "name the case of that run, with its --set"));
    }
    Ok(gases)
}
