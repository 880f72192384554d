//! Comparisons that the validation suite does not make, because the program lacks a feature or the numbers are not
//! public.

use crate::output::NotValidated;

/// All comparisons that are not made, each with its reference and with the things that are missing for it. The
/// references are known to exist, but were not read.
pub const MISSING: &[NotValidated] = &[
    NotValidated {
        name: "simple shear, hard spheres",
        reference: "Mitarai and Nakanishi (2007, Phys. Rev. E 75, 031305); theory of Garzó and Dufty (1999) at φ = 0.1, 0.3, 0.49",
        needs: "a row of this suite with published digits; `cases/shear` and its page compare with kinetic theory",
    },
    NotValidated {
        name: "simple shear, soft spheres",
        reference: "Vescovi, Berzi, Richard and Brodu (2014, Phys. Fluids 26, 053305)",
        needs: "a row of this suite with published digits; `cases/shear` compares soft with hard spheres",
    },
    NotValidated {
        name: "particle-laden channel of air",
        reference: "Kussin and Sommerfeld (2002, Exp. Fluids 33, 143); Benson and Eaton (2003)",
        needs: "a table of the measured profiles; none was found in public",
    },
    NotValidated {
        name: "particle-laden vertical pipe",
        reference: "Tsuji, Morikawa and Shiomi (1984, J. Fluid Mech. 139, 417)",
        needs: "a table of the measured profiles; none was found in public",
    },
    NotValidated {
        name: "fluidized bed",
        reference: "benchmarks of MFIX-Exa with measured pressure drop and bubbles (Fullmer et al. 2019, arXiv:1909.02067)",
        needs: "a gas that is resolved in three dimensions",
    },
    NotValidated {
        name: "rebound of glass and acetate spheres",
        reference: "Foerster, Louge, Chang and Allia (1994, Phys. Fluids 6, 1108)",
        needs: "measured points in public: only e, μ and β_0 are, which are inputs here",
    },
    NotValidated {
        name: "chung-ooi-8",
        reference: "Chung and Ooi (2011), test 8: a ball with spin on a large one of 1000 times the density",
        needs: "densities above 30,000 kg/m³, which cases refuse; its answer is that of test 6 to 1e-5",
    },
    NotValidated {
        name: "restitution that depends on speed",
        reference: "Chung and Ooi (2011) do not test it; Kuwabara and Kono (1987) and others do",
        needs: "a row of this suite with measured digits; `cases/viscoelastic-gas.toml` compares with theory",
    },
    NotValidated {
        name: "heap and drum",
        reference: "angles of repose of many authors, with scatter of some degrees between laboratories",
        needs: "walls that turn with the particles in a case of this suite, and a scene with published digits",
    },
];
