//! Keys whose value is a time or, in place of a time, one fixed word such as `"auto"`.

use super::quantity::{self, QUANTITY, UNIT};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use std::borrow::Cow;

/// Exponents of the dimension time.
const TIME: quantity::Exponents = [0, 0, 1];

/// Start of the averaging period: a time, or `"steady"`.
#[derive(Clone, Copy, Debug)]
pub enum AverageFromFile {
    /// [s] given start of the averaging period.
    Time(f64),
    /// Start found by the run: the time from which the flow is steady.
    Steady,
}

/// Length of a window: a time, or `"auto"`. A window is the time between two exchanges of momentum with the gas.
#[derive(Clone, Copy, Debug)]
pub enum WindowFile {
    /// [s] given length of the window, the time between two exchanges of momentum with the gas.
    Time(f64),
    /// Length of the window that the program chooses from the scene.
    Auto,
}

/// Reads a time [s], or the one word that is allowed instead; `None` stands for the word.
fn time_or_word<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
    word: &'static str,
) -> Result<Option<f64>, D::Error> {
    struct TimeOrWord(&'static str);
    impl serde::de::Visitor<'_> for TimeOrWord {
        type Value = Option<f64>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            write!(f, "a time, such as \"2 s\", or \"{}\"", self.0)
        }

        fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Option<f64>, E> {
            if value.is_finite() {
                return Ok(Some(value));
            }
            let (mark, word) = (super::de::HELP_MARK, self.0);
            Err(E::custom(format_args!("is not a finite number{mark}write a time, such as \"2 s\", or \"{word}\"")))
        }

        fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<Option<f64>, E> {
            Ok(Some(value as f64))
        }

        fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Option<f64>, E> {
            if text == self.0 {
                return Ok(None);
            }
            quantity::parse(text, TIME).map(Some).map_err(|error| {
                let help = error.help.unwrap_or_default();
                E::custom(format_args!("{}{}{help}, or \"{}\"", error.message, super::de::HELP_MARK, self.0))
            })
        }
    }
    deserializer.deserialize_any(TimeOrWord(word))
}

impl<'de> Deserialize<'de> for AverageFromFile {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(time_or_word(deserializer, "steady")?.map_or(Self::Steady, Self::Time))
    }
}

impl<'de> Deserialize<'de> for WindowFile {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(time_or_word(deserializer, "auto")?.map_or(Self::Auto, Self::Time))
    }
}

/// JSON schema of a value that is a time or the given word.
fn schema(word: &str) -> Schema {
    let name = format!("time, or \"{word}\"");
    let pattern = super::schema::pattern(TIME, Some(word));
    json_schema!({ "type": ["string", "number"], "pattern": pattern, QUANTITY: name, UNIT: quantity::si_unit(TIME) })
}

impl JsonSchema for AverageFromFile {
    fn schema_name() -> Cow<'static, str> {
        "TimeOrSteady".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        schema("steady")
    }
}

impl JsonSchema for WindowFile {
    fn schema_name() -> Cow<'static, str> {
        "TimeOrAuto".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        schema("auto")
    }
}
