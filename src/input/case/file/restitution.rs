//! Restitution in a case file: one number, or a law by which it depends on the speed.

use crate::case::de::HELP_MARK;
use crate::case::located::Located;
use crate::case::quantity::{QUANTITY, Ratio, Speed};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, IntoDeserializer, MapAccess, Visitor};
use std::borrow::Cow;

/// Names of the laws by which the restitution depends on the speed.
const LAWS: &[&str] = &["bridges", "power", "viscoelastic"];

/// Restitution of a contact: one number, or a law by which it depends on the speed.
#[derive(Clone, Debug)]
pub enum RestitutionFile {
    /// [-] restitution, the same at all speeds.
    Constant(Ratio),
    /// Law by which the restitution depends on the normal speed of the impact.
    BySpeed(Box<RestitutionLawFile>),
}

/// Tables `restitution.*`: choice of a law by which the restitution depends on the normal speed u of the impact.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RestitutionLawFile {
    /// Restitution e = min(1, (u/u_c)^-p) at the normal speed u, measured for ice by Bridges, Hatzes and Lin (1984).
    Bridges {
        /// Normal speed u_c up to which impacts are elastic.
        #[schemars(example = &"0.077 mm/s", extend("x-required" = "always", "x-range" = "1e-9 ..= 1e5 m/s"))]
        speed: Option<Located<Speed>>,
        /// Exponent p of the law e = (u/u_c)^-p for normal speeds u above u_c.
        #[schemars(example = 0.234, extend("x-required" = "always", "x-range" = "0 ..= 10"))]
        exponent: Option<Located<Ratio>>,
    },
    /// Restitution e = max(e_min, 1 - (1 - e_1) (u/u_1)^q) at the normal speed u, with the value e_1 at the speed u_1.
    /// Bizon et al. (1998) take q = 0.75 and e_min = e_1.
    Power {
        /// Restitution e_1 of an impact at the normal speed u_1.
        #[schemars(example = 0.9, extend("x-required" = "always", "x-range" = "0 ..= 1"))]
        restitution: Option<Located<Ratio>>,
        /// Normal speed u_1 of an impact with the restitution e_1.
        #[schemars(example = &"1 m/s", extend("x-required" = "always", "x-range" = "1e-9 ..= 1e5 m/s"))]
        speed: Option<Located<Speed>>,
        /// Exponent q of the law e = 1 - (1 - e_1) (u/u_1)^q, with the value e_1 at the normal speed u_1.
        #[schemars(example = 0.2, extend("x-required" = "always", "x-range" = "greater than 0, up to 10"))]
        exponent: Option<Located<Ratio>>,
        /// Smallest restitution, e_min. The value 0 is only for the models hard and dsmc.
        #[schemars(example = 0.5, extend("x-required" = "always", "x-range" = "0 ..= 1"))]
        least: Option<Located<Ratio>>,
    },
    /// Restitution of viscoelastic spheres (Ramírez et al. 1999), whose soft law is `[soft.kuwabara_kono]`.
    Viscoelastic {
        /// Restitution of viscoelastic spheres in an impact at the normal speed `speed`.
        #[schemars(example = 0.9, extend("x-required" = "always", "x-range" = "0.001 ..= 1"))]
        restitution: Option<Located<Ratio>>,
        /// Normal speed of an impact that has the restitution `restitution`.
        #[schemars(example = &"1 m/s", extend("x-required" = "always", "x-range" = "1e-9 ..= 1e5 m/s"))]
        speed: Option<Located<Speed>>,
    },
}

impl<'de> Deserialize<'de> for RestitutionFile {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrLaw;
        impl<'de> Visitor<'de> for NumberOrLaw {
            type Value = RestitutionFile;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number, or a table with the name of a law")
            }

            fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<RestitutionFile, E> {
                Ratio::deserialize(value.into_deserializer()).map(RestitutionFile::Constant)
            }

            fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<RestitutionFile, E> {
                self.visit_f64(value as f64)
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<RestitutionFile, E> {
                Ratio::deserialize(text.into_deserializer()).map(RestitutionFile::Constant)
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RestitutionFile, A::Error> {
                let law = RestitutionLawFile::deserialize(MapAccessDeserializer::new(&mut map))?;
                match map.next_key::<String>()? {
                    Some(name) if LAWS.contains(&name.as_str()) => {
                        let (mark, laws) = (HELP_MARK, LAWS.join("`, `"));
                        Err(A::Error::custom(format_args!("names two laws{mark}choose exactly one of `{laws}`")))
                    }
                    Some(name) => Err(A::Error::unknown_variant(&name, LAWS)),
                    None => Ok(RestitutionFile::BySpeed(Box::new(law))),
                }
            }
        }
        deserializer.deserialize_any(NumberOrLaw)
    }
}

impl JsonSchema for RestitutionFile {
    fn schema_name() -> Cow<'static, str> {
        "NumberOrLaw".into()
    }

    /// Schema of a restitution: a number, or a table with the name of a law.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut laws = RestitutionLawFile::json_schema(generator);
        let number = Ratio::json_schema(generator).to_value();
        if let Some(serde_json::Value::Array(branches)) = laws.get_mut("oneOf") {
            branches.insert(0, number);
        }
        laws.insert(QUANTITY.into(), "number, or a table".into());
        laws
    }
}
