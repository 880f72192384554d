//! Quantities that are averaged in slices of the box, listed in [`SLICE_COLUMNS`]. Files, verdicts (tests whether two
//! runs differ) and pictures all use this list.

use super::modes::Parity;
use super::spin_sums::SPIN_QUANTITIES;

/// Number of slice quantities that are computed from positions and velocities. They come first in [`SLICE_COLUMNS`].
pub const VELOCITY_QUANTITIES: usize = 20;
/// Number of quantities that are averaged in each slice.
pub const SLICE_QUANTITIES: usize = VELOCITY_QUANTITIES + SPIN_QUANTITIES;

/// Quantity that is averaged in each slice of the box, a column of `profiles.csv`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceColumn {
    /// Name of the column in `profiles.csv`.
    pub name: &'static str,
    /// Symbol of the quantity in pictures.
    pub symbol: &'static str,
    /// SI unit of the quantity; empty for a ratio.
    pub unit: &'static str,
    /// Symmetry of the quantity under a reflection at the mid-plane, in a scene that has this symmetry.
    pub parity: Parity,
    /// Index of the quantity in [`SLICE_COLUMNS`].
    pub index: usize,
}

/// Column of the number density [-], divided by its mean in the whole box.
pub const NUMBER_DENSITY: SliceColumn = SLICE_COLUMNS[0];
/// Column of the streamwise mean velocity U [m/s].
pub const U: SliceColumn = SLICE_COLUMNS[1];
/// Column of the normal stress <u''u''> in the streamwise direction [m²/s²].
pub const UU: SliceColumn = SLICE_COLUMNS[4];
/// Column of the normal stress <v''v''> in the wall-normal direction [m²/s²].
pub const VV: SliceColumn = SLICE_COLUMNS[5];
/// Column of the normal stress <w''w''> in the spanwise direction [m²/s²].
pub const WW: SliceColumn = SLICE_COLUMNS[6];
/// Column of the shear stress <u''v''> [m²/s²].
pub const UV: SliceColumn = SLICE_COLUMNS[7];

/// Column of the mean spin along x, the spanwise direction [rad/s]. A sheared stream causes spin in this direction.
pub const MEAN_SPIN_X: SliceColumn = SLICE_COLUMNS[20];
/// Column of the rotational temperature T_r [m²/s²].
pub const ROTATIONAL_TEMPERATURE: SliceColumn = SLICE_COLUMNS[23];

/// Columns of `profiles.csv` for a scene. The columns of spins are included if the spheres rotate (`rotating`).
pub fn slice_columns(rotating: bool) -> &'static [SliceColumn] {
    if rotating { &SLICE_COLUMNS } else { &SLICE_COLUMNS[..VELOCITY_QUANTITIES] }
}

/// Columns of the six second central moments of the velocities [m²/s²].
pub fn second_moments() -> &'static [SliceColumn] {
    &SLICE_COLUMNS[UU.index..UU.index + 6]
}

/// Columns of the mean spins [rad/s], and of the parts of the rotational temperature along x, y and z [m²/s²].
pub fn spin_components() -> impl Iterator<Item = SliceColumn> {
    SLICE_COLUMNS[VELOCITY_QUANTITIES..].iter().copied().filter(|column| *column != ROTATIONAL_TEMPERATURE)
}

/// All quantities that are averaged in slices, in their order: density ratio, mean velocities, second and third central
/// moments, mean spins, rotational temperature and its parts. A spin is an axial vector: a reflection reverses the spin
/// components parallel to the mirror plane.
pub const SLICE_COLUMNS: [SliceColumn; SLICE_QUANTITIES] = {
    use Parity::{Even, Odd};
    let columns = [
        ("number_density_ratio", "n/⟨n⟩", "", Even),
        ("U", "U", "m/s", Even),
        ("V", "V", "m/s", Odd),
        ("W", "W", "m/s", Even),
        ("uu", "⟨u″u″⟩", "m²/s²", Even),
        ("vv", "⟨v″v″⟩", "m²/s²", Even),
        ("ww", "⟨w″w″⟩", "m²/s²", Even),
        ("uv", "⟨u″v″⟩", "m²/s²", Odd),
        ("uw", "⟨u″w″⟩", "m²/s²", Even),
        ("vw", "⟨v″w″⟩", "m²/s²", Odd),
        ("uuu", "⟨u″u″u″⟩", "m³/s³", Even),
        ("uuv", "⟨u″u″v″⟩", "m³/s³", Odd),
        ("uuw", "⟨u″u″w″⟩", "m³/s³", Even),
        ("uvv", "⟨u″v″v″⟩", "m³/s³", Even),
        ("uvw", "⟨u″v″w″⟩", "m³/s³", Odd),
        ("uww", "⟨u″w″w″⟩", "m³/s³", Even),
        ("vvv", "⟨v″v″v″⟩", "m³/s³", Odd),
        ("vvw", "⟨v″v″w″⟩", "m³/s³", Even),
        ("vww", "⟨v″w″w″⟩", "m³/s³", Odd),
        ("www", "⟨w″w″w″⟩", "m³/s³", Even),
        ("mean_spin_x", "Ω_x", "rad/s", Odd),
        ("mean_spin_y", "Ω_y", "rad/s", Even),
        ("mean_spin_z", "Ω_z", "rad/s", Odd),
        ("rotational_temperature", "T_r", "m²/s²", Even),
        ("Rxx", "T_r along x", "m²/s²", Even),
        ("Ryy", "T_r along y", "m²/s²", Even),
        ("Rzz", "T_r along z", "m²/s²", Even),
    ];
    let mut table = [SliceColumn { name: "", symbol: "", unit: "", parity: Even, index: 0 }; SLICE_QUANTITIES];
    let mut index = 0;
    // iterators are not allowed in the computation of constants
    while index < SLICE_QUANTITIES {
        let (name, symbol, unit, parity) = columns[index];
        table[index] = SliceColumn { name, symbol, unit, parity, index };
        index += 1;
    }
    table
};

/// Column with the name `name`; `None` if there is no such column.
pub fn slice_column(name: &str) -> Option<SliceColumn> {
    SLICE_COLUMNS.into_iter().find(|column| column.name == name)
}
