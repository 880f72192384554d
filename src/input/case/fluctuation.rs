//! Velocity fluctuation in a case file: one speed for all components, or one for each.

use super::located::Located;
use super::quantity::{QUANTITY, Speed, UNIT, si_unit};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{IntoDeserializer, SeqAccess, Visitor};
use std::borrow::Cow;

/// Standard deviation of the velocities of a random start.
#[derive(Clone, Debug)]
pub enum FluctuationFile {
    /// One speed for all of x, y and z.
    Same(Speed),
    /// Three speeds: one each for x, y and z.
    Each(Box<[Located<Speed>; 3]>),
}

impl<'de> Deserialize<'de> for FluctuationFile {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ScalarOrVector;
        impl<'de> Visitor<'de> for ScalarOrVector {
            type Value = FluctuationFile;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a speed, such as \"0.5 m/s\", or a list of three")
            }

            fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<FluctuationFile, E> {
                Speed::deserialize(value.into_deserializer()).map(FluctuationFile::Same)
            }

            fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<FluctuationFile, E> {
                self.visit_f64(value as f64)
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<FluctuationFile, E> {
                Speed::deserialize(text.into_deserializer()).map(FluctuationFile::Same)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<FluctuationFile, A::Error> {
                let list = serde::de::value::SeqAccessDeserializer::new(seq);
                <[Located<Speed>; 3]>::deserialize(list).map(|each| FluctuationFile::Each(Box::new(each)))
            }
        }
        deserializer.deserialize_any(ScalarOrVector)
    }
}

impl JsonSchema for FluctuationFile {
    fn schema_name() -> Cow<'static, str> {
        "OneSpeedOrThree".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let speed = Speed::json_schema(generator);
        json_schema!({
            "type": ["string", "number", "array"], "pattern": super::schema::pattern([1, 0, -1], None), "items": speed, "minItems": 3, "maxItems": 3,
            QUANTITY: "speed, or list of 3", UNIT: si_unit([1, 0, -1])
        })
    }
}
