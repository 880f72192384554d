//! Quantities with units, as users type them: `"406 um"`, `"7.5e-7 s"`, `"1.205 kg/m^3"`.
//!
//! A quantity is a number and a product of units. Its dimension is checked against that of the key, and its value is
//! converted to SI. A plain number (without quotes) is already in SI. The power of ten of a prefix is added to the
//! decimal exponent of the text before the number is parsed. So `"406 um"` is exactly the double nearest to 4.06e-4.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Visitor};
use std::borrow::Cow;
use std::fmt;

/// Name of the schema entry that holds the kind of quantity in words, such as "length".
pub(super) const QUANTITY: &str = "x-quantity";

/// Name of the schema entry that holds the SI unit of a number typed without a unit.
pub(super) const UNIT: &str = "x-unit";

/// Exponents of metre, kilogram and second in a dimension.
pub type Exponents = [i8; 3];

/// Finite number in SI units. Its dimension is m^M kg^K s^S, with the exponents M, K and S.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity<const M: i8, const K: i8, const S: i8>(pub f64);

/// [-] number without dimension, typed as a plain number or a percentage.
pub type Ratio = Quantity<0, 0, 0>;
/// [m] length.
pub type Length = Quantity<1, 0, 0>;
/// [s] time.
pub type Time = Quantity<0, 0, 1>;
/// [m/s] speed, or component of a velocity.
pub type Speed = Quantity<1, 0, -1>;
/// [rad/s] angular velocity, or [1/s] a rate or a frequency.
pub type Spin = Quantity<0, 0, -1>;
/// [s/m] time per length.
pub type Slowness = Quantity<-1, 0, 1>;
/// [m/s²] acceleration.
pub type Acceleration = Quantity<1, 0, -2>;
/// [kg/m³] density.
pub type Density = Quantity<-3, 1, 0>;
/// [m²/s] kinematic viscosity.
pub type KinematicViscosity = Quantity<2, 0, -1>;
/// [kg/s] mass per time.
pub type MassRate = Quantity<0, 1, -1>;
/// [m²/s²] energy per mass.
pub type SpecificEnergy = Quantity<2, 0, -2>;
/// [m²/s³] rate of energy per mass.
pub type DissipationRate = Quantity<2, 0, -3>;
/// [N/m] stiffness.
pub type Stiffness = Quantity<0, 1, -2>;

/// [Pa] pressure or elastic modulus.
pub type Pressure = Quantity<-1, 1, -2>;

/// [Pa/m] pressure drop per length.
pub type PressureGradient = Quantity<-2, 1, -2>;

/// [m²] area.
pub type Area = Quantity<2, 0, 0>;

/// [Pa s/m] pressure over speed: damping of a servo wall.
pub type PressurePerSpeed = Quantity<-2, 1, -1>;

/// Common dimensions, each with its exponents, its name, its SI unit and an example.
const DIMENSIONS: &[(Exponents, &str, &str, &str)] = &[
    ([0, 0, 0], "a plain number", "", "0.5"),
    ([1, 0, 0], "a length", "m", "\"1.5 mm\""),
    ([0, 0, 1], "a time", "s", "\"2 s\""),
    ([0, 1, 0], "a mass", "kg", "\"3 mg\""),
    ([2, 0, 0], "an area", "m^2", "\"1 mm^2\""),
    ([3, 0, 0], "a volume", "m^3", "\"1 mm^3\""),
    ([0, 0, -1], "a rate", "1/s", "\"50 Hz\""),
    ([1, 0, -1], "a velocity", "m/s", "\"12 m/s\""),
    ([-1, 0, 1], "a time per length", "s/m", "\"0.1 s/m\""),
    ([1, 0, -2], "an acceleration", "m/s^2", "\"9.81 m/s^2\""),
    ([-3, 1, 0], "a density", "kg/m^3", "\"1038 kg/m^3\""),
    ([2, 0, -1], "a kinematic viscosity", "m^2/s", "\"1.515e-5 m^2/s\""),
    ([2, 0, -2], "an energy per mass", "m^2/s^2", "\"0.5 m^2/s^2\""),
    ([2, 0, -3], "a dissipation rate", "m^2/s^3", "\"10 m^2/s^3\""),
    ([-1, 1, -1], "a dynamic viscosity", "Pa s", "\"1.8e-5 Pa s\""),
    ([0, 1, -1], "a mass per time", "kg/s", "\"20 g/s\""),
    ([0, 1, -2], "a stiffness", "N/m", "\"3000 N/m\""),
    ([1, 1, -2], "a force", "N", "\"1 mN\""),
    ([-1, 1, -2], "a pressure", "Pa", "\"101 kPa\""),
    ([2, 1, -2], "an energy", "J", "\"1 uJ\""),
    ([-2, 1, -2], "a pressure gradient", "Pa/m", "\"12 Pa/m\""),
    ([-2, 1, -1], "a pressure per speed", "Pa s/m", "\"500 Pa s/m\""),
];

/// Units that take no prefix: name, exponents of the dimension, power of ten, factor. In SI the unit is factor ·
/// 10^power.
pub(super) const WHOLE_UNITS: &[(&str, Exponents, i32, f64)] = &[
    ("1", [0, 0, 0], 0, 1.0),
    ("%", [0, 0, 0], -2, 1.0),
    ("rad", [0, 0, 0], 0, 1.0),
    ("deg", [0, 0, 0], 0, std::f64::consts::PI / 180.0),
    ("°", [0, 0, 0], 0, std::f64::consts::PI / 180.0),
    ("min", [0, 0, 1], 0, 60.0),
    ("h", [0, 0, 1], 0, 3600.0),
];

/// Units that take a prefix: name, exponents of the dimension, power of ten by which the unit differs from the SI unit.
pub(super) const UNITS: &[(&str, Exponents, i32)] = &[
    ("m", [1, 0, 0], 0),
    ("g", [0, 1, 0], -3),
    ("s", [0, 0, 1], 0),
    ("N", [1, 1, -2], 0),
    ("Pa", [-1, 1, -2], 0),
    ("J", [2, 1, -2], 0),
    ("W", [2, 1, -3], 0),
    ("Hz", [0, 0, -1], 0),
    ("l", [3, 0, 0], -3),
    ("L", [3, 0, 0], -3),
];

/// Prefixes and their powers of ten. The prefix micro may be written with the letter u or with either Unicode sign.
pub(super) const PREFIXES: &[(&str, i32)] = &[
    ("p", -12),
    ("n", -9),
    ("u", -6),
    ("µ", -6),
    ("μ", -6),
    ("m", -3),
    ("c", -2),
    ("d", -1),
    ("k", 3),
    ("M", 6),
    ("G", 9),
];

/// Reason why a text is not a quantity, with a remedy for the author of the case.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityError {
    /// Problem, in words that follow the key and the value: "is a time, but a length belongs here".
    pub message: String,
    /// Remedy: what to type instead; `None` if there is none.
    pub help: Option<String>,
}

impl QuantityError {
    fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: message.into(), help: Some(help.into()) }
    }
}

/// Name of a dimension, such as "a length", or its unit if it has no name, as in "a quantity in m^2 kg".
pub fn dimension_name(exponents: Exponents) -> String {
    if let Some((_, name, ..)) = DIMENSIONS.iter().find(|(known, ..)| *known == exponents) {
        return (*name).to_string();
    }
    format!("a quantity in {}", powers(exponents))
}

/// Example of a quantity of a dimension, as it would be typed in a case.
pub fn dimension_example(exponents: Exponents) -> &'static str {
    DIMENSIONS.iter().find(|(known, ..)| *known == exponents).map_or("a plain SI number", |(.., example)| example)
}

/// SI unit of a dimension, as it would be typed in a case; empty for numbers without dimension.
pub fn si_unit(exponents: Exponents) -> String {
    match DIMENSIONS.iter().find(|(known, ..)| *known == exponents) {
        Some((_, _, unit, _)) => (*unit).to_owned(),
        None => powers(exponents),
    }
}

/// Text of a dimension as a product of powers of the base units m, kg and s.
fn powers(exponents: Exponents) -> String {
    let powers = ["m", "kg", "s"].iter().zip(exponents).filter(|(_, power)| *power != 0);
    let powers = powers.map(|(unit, power)| if power == 1 { (*unit).to_string() } else { format!("{unit}^{power}") });
    powers.collect::<Vec<_>>().join(" ")
}

/// [SI] value of a text such as `"3000 N/m"`, with the dimension `wanted`.
///
/// # Errors
/// The problem and its remedy: no number, an unknown unit, another dimension, a decimal comma, or a number that no
/// double can hold.
pub fn parse(text: &str, wanted: Exponents) -> Result<f64, QuantityError> {
    let trimmed = text.trim();
    let like = || format!("write {}, such as {}", dimension_name(wanted), dimension_example(wanted));
    let Some((mantissa, exponent, rest)) = split_number(trimmed) else {
        return Err(QuantityError::new("does not start with a number", like()));
    };
    if rest.starts_with(',') && rest[1..].starts_with(|c: char| c.is_ascii_digit()) {
        return Err(QuantityError::new(
            "has a decimal comma",
            format!("the decimal mark is a point: \"{}\"", trimmed.replacen(',', ".", 1)),
        ));
    }
    let unit_text = rest.trim();
    if unit_text.is_empty() {
        return Err(if wanted == [0, 0, 0] {
            QuantityError::new("is a string where a number belongs", format!("leave the quotes out: {trimmed}"))
        } else {
            QuantityError::new("has no unit", format!("{}; a number without quotes is taken as SI", like()))
        });
    }
    let unit = parse_unit(unit_text).map_err(|message| QuantityError::new(format!("has {message}"), like()))?;
    if unit.exponents != wanted {
        return Err(QuantityError::new(
            format!("is {}, but {} belongs here", dimension_name(unit.exponents), dimension_name(wanted)),
            like(),
        ));
    }
    let power = exponent.saturating_add(i64::from(unit.power));
    let value = format!("{mantissa}e{power}").parse::<f64>().map_or(f64::NAN, |number| number * unit.factor);
    if !value.is_finite() {
        return Err(QuantityError::new("is too large for a double", like()));
    }
    if value == 0.0 && mantissa.bytes().any(|b| (b'1'..=b'9').contains(&b)) {
        return Err(QuantityError::new("is too small for a double", like()));
    }
    Ok(value)
}

/// Dimension of a unit such as "mm/s", or of a multiple such as "1e-5 s", and its size in SI.
///
/// # Errors
/// The text contains an unknown unit, or its size is no finite number greater than 0.
pub fn unit(text: &str) -> Result<(Exponents, f64), QuantityError> {
    let like = "write a unit such as \"m/s\", or a multiple such as \"1e-5 s\"";
    let (mantissa, exponent, rest) = split_number(text.trim()).unwrap_or(("1".into(), 0, text.trim()));
    let unit = parse_unit(rest.trim()).map_err(|message| QuantityError::new(format!("has {message}"), like))?;
    let power = exponent.saturating_add(i64::from(unit.power));
    let size = format!("{mantissa}e{power}").parse::<f64>().map_or(f64::NAN, |number| number * unit.factor);
    if size.is_finite() && size > 0.0 {
        Ok((unit.exponents, size))
    } else {
        Err(QuantityError::new("has no size greater than 0", like))
    }
}

/// [SI] value of a text that is a quantity of one of the `DIMENSIONS`; `None` for other texts.
pub fn value(text: &str) -> Option<f64> {
    DIMENSIONS.iter().find_map(|(dimension, ..)| parse(text, *dimension).ok())
}

/// Splits a text into the mantissa and the decimal exponent of its leading number, and the rest of the text. `None` if
/// the text does not begin with a number.
fn split_number(text: &str) -> Option<(String, i64, &str)> {
    let mut mantissa = String::new();
    let mut digits = 0;
    let mut end = 0;
    let mut point = false;
    for (at, c) in text.char_indices() {
        match c {
            '-' | '\u{2212}' if at == 0 => mantissa.push('-'),
            '+' if at == 0 => {}
            '.' if !point => {
                point = true;
                mantissa.push('.');
            }
            '0'..='9' => {
                digits += 1;
                mantissa.push(c);
            }
            _ => break,
        }
        end = at + c.len_utf8();
    }
    if digits == 0 {
        return None;
    }
    let rest = &text[end..];
    if let Some(tail) = rest.strip_prefix(['e', 'E']) {
        let sign = usize::from(tail.starts_with(['+', '-']));
        let length = tail[sign..].bytes().take_while(u8::is_ascii_digit).count();
        if length > 0 {
            let exponent = &tail[..sign + length];
            let saturated = if exponent.starts_with('-') { -1_000_000 } else { 1_000_000 };
            let exponent = exponent.parse::<i64>().unwrap_or(saturated).clamp(-1_000_000, 1_000_000);
            return Some((mantissa, exponent, &tail[sign + length..]));
        }
    }
    Some((mantissa, 0, rest))
}

/// Product of units: its dimension, and its size in SI as 10^power · factor.
struct Unit {
    exponents: Exponents,
    power: i32,
    factor: f64,
}

/// Reads a product of units, such as "kg/m^3", "kg m^-3", "kg·m⁻³" or "Pa s". Factors are separated by blanks, `*`, `·`
/// or `/`; a slash divides only by the next factor.
fn parse_unit(text: &str) -> Result<Unit, String> {
    let mut unit = Unit { exponents: [0; 3], power: 0, factor: 1.0 };
    let mut divide = false;
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let end = rest.find(|c: char| c.is_whitespace() || "*·⋅/".contains(c)).unwrap_or(rest.len());
        let (factor, after) = rest.split_at(end);
        if !factor.is_empty() {
            multiply(&mut unit, factor, if divide { -1 } else { 1 })?;
            divide = false;
        }
        let mut chars = after.chars();
        match chars.next() {
            Some('/') if divide => return Err("two slashes in a row".into()),
            Some('/') => divide = true,
            _ => {}
        }
        rest = chars.as_str();
    }
    if divide {
        return Err("a slash with nothing after it".into());
    }
    Ok(unit)
}

/// Multiplies `unit` by one factor such as `m^-3` if `sign` is 1, or divides `unit` by that factor if `sign` is -1.
fn multiply(unit: &mut Unit, factor: &str, sign: i32) -> Result<(), String> {
    let plain: String = factor.chars().map(plain_digit).collect();
    let split = plain
        .char_indices()
        .find(|(at, c)| *at > 0 && (*c == '^' || c.is_ascii_digit() || *c == '-'))
        .map_or(plain.len(), |(at, _)| at);
    let (name, exponent) = plain.split_at(split);
    let exponent = exponent.strip_prefix('^').unwrap_or(exponent);
    let exponent: i32 = if exponent.is_empty() && split == plain.len() {
        1
    } else {
        exponent
            .parse::<i32>()
            .ok()
            .filter(|e| e.abs() <= 9)
            .ok_or_else(|| format!("an unknown exponent, `{factor}`"))?
    };
    let exponent = exponent * sign;
    let (exponents, power, size) = named_unit(name)?;
    for (sum, e) in unit.exponents.iter_mut().zip(exponents) {
        *sum = i32::from(e)
            .checked_mul(exponent)
            .and_then(|e| e.checked_add(i32::from(*sum)))
            .and_then(|e| i8::try_from(e).ok())
            .ok_or_else(|| "too high a power".to_string())?;
    }
    unit.power += power * exponent;
    unit.factor *= size.powi(exponent);
    Ok(())
}

/// Turns a superscript digit into a plain digit, and a typographic minus into a plain minus.
fn plain_digit(c: char) -> char {
    match c {
        '⁰' => '0',
        '¹' => '1',
        '²' => '2',
        '³' => '3',
        '⁴' => '4',
        '⁵' => '5',
        '⁶' => '6',
        '⁷' => '7',
        '⁸' => '8',
        '⁹' => '9',
        '⁻' | '\u{2212}' => '-',
        _ => c,
    }
}

fn named_unit(name: &str) -> Result<(Exponents, i32, f64), String> {
    if let Some((_, exponents, power, factor)) = WHOLE_UNITS.iter().find(|(known, ..)| *known == name) {
        return Ok((*exponents, *power, *factor));
    }
    if let Some((_, exponents, power)) = UNITS.iter().find(|(known, ..)| *known == name) {
        return Ok((*exponents, *power, 1.0));
    }
    for (prefix, prefix_power) in PREFIXES {
        if let Some(base) = name.strip_prefix(prefix)
            && let Some((_, exponents, power)) = UNITS.iter().find(|(known, ..)| *known == base)
        {
            return Ok((*exponents, power + prefix_power, 1.0));
        }
    }
    let known = "units are m, g, s, N, Pa, J, W, Hz, l with prefixes p n u m c d k M G, and min, h, deg, %";
    Err(format!("an unknown unit, `{name}` ({known})"))
}

impl<'de, const M: i8, const K: i8, const S: i8> Deserialize<'de> for Quantity<M, K, S> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Typed(Exponents);
        impl Visitor<'_> for Typed {
            type Value = f64;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "{}, such as {}", dimension_name(self.0), dimension_example(self.0))
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<f64, E> {
                if value.is_finite() {
                    return Ok(value);
                }
                let (mark, name, example) = (super::de::HELP_MARK, dimension_name(self.0), dimension_example(self.0));
                Err(E::custom(format_args!("is not a finite number{mark}write {name}, such as {example}")))
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<f64, E> {
                Ok(value as f64)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<f64, E> {
                parse(text, self.0).map_err(|error| match error.help {
                    // the error of the deserializer is split into message and remedy at this mark
                    Some(help) => E::custom(format_args!("{}{}{}", error.message, super::de::HELP_MARK, help)),
                    None => E::custom(error.message),
                })
            }
        }
        deserializer.deserialize_any(Typed([M, K, S])).map(Quantity)
    }
}

impl<const M: i8, const K: i8, const S: i8> JsonSchema for Quantity<M, K, S> {
    fn schema_name() -> Cow<'static, str> {
        format!("Quantity_{M}_{K}_{S}").into()
    }

    /// Schema of a quantity: a string with a unit, or a number in SI.
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let dimension = [M, K, S];
        let name = dimension_name(dimension);
        let name = name.split_once(' ').map_or(name.as_str(), |(_, name)| name);
        let pattern = super::schema::pattern(dimension, None);
        json_schema!({ "type": ["string", "number"], "pattern": pattern, QUANTITY: name, UNIT: si_unit(dimension) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings() {
        let density = [-3, 1, 0];
        for (text, wanted, value) in [
            ("406 um", [1, 0, 0], 4.06e-4),
            ("406um", [1, 0, 0], 4.06e-4),
            ("406 µm", [1, 0, 0], 4.06e-4),
            ("7.5e-7 s", [0, 0, 1], 7.5e-7),
            ("3000 N/m", [0, 1, -2], 3000.0),
            ("300N/m", [0, 1, -2], 300.0),
            ("1.515e-5 m^2/s", [2, 0, -1], 1.515e-5),
            ("1038 kg/m^3", density, 1038.0),
            ("1038 kg/m3", density, 1038.0),
            ("1038 kg/m³", density, 1038.0),
            ("1038 kg m^-3", density, 1038.0),
            ("1.038 g/cm^3", density, 1038.0),
            ("-9.81 m/s^2", [1, 0, -2], -9.81),
            ("−9.81 m s⁻²", [1, 0, -2], -9.81),
            ("1.8e-2 mPa s", [-1, 1, -1], 1.8e-5),
            ("2 min", [0, 0, 1], 120.0),
            ("94 %", [0, 0, 0], 0.94),
            ("50 Hz", [0, 0, -1], 50.0),
        ] {
            assert_eq!(parse(text, wanted), Ok(value), "{text}");
        }
    }

    #[test]
    fn refusals_name_the_remedy() {
        for (text, wanted, part) in [
            ("7.5e-7 s", [1, 0, 0], "is a time, but a length belongs here"),
            ("1,5 mm", [1, 0, 0], "decimal comma"),
            ("1,5", [1, 0, 0], "decimal comma"),
            ("406", [1, 0, 0], "has no unit"),
            ("0.94", [0, 0, 0], "is a string where a number belongs"),
            ("fast", [1, 0, -1], "does not start with a number"),
            ("nan m", [1, 0, 0], "does not start with a number"),
            ("1e400 m", [1, 0, 0], "too large"),
            ("1e99999999999999999999 m", [1, 0, 0], "too large"),
            ("1e-400 m", [1, 0, 0], "too small"),
            ("3 furlong", [1, 0, 0], "unknown unit, `furlong`"),
            ("3 m^99999", [1, 0, 0], "unknown exponent"),
            ("3 m^9 m^9 m^9 m^9 m^9 m^9 m^9 m^9 m^9 m^9 m^9 m^9 m^9 m^9 m^9", [1, 0, 0], "too high a power"),
            ("3 m/", [1, 0, 0], "slash"),
            ("", [1, 0, 0], "does not start with a number"),
        ] {
            let error = parse(text, wanted).expect_err(text);
            assert!(error.message.contains(part), "{text}: {}", error.message);
        }
    }
}
