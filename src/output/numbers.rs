//! Formats numbers for readers, with significant digits only, SI prefixes, and standard errors.

use crate::statistics::Estimate;

/// Sign in place of an unknown number.
pub const UNKNOWN: &str = "–";

/// Text of `value` with the given number of significant digits. A number gets a power of ten if its magnitude, after
/// rounding, is below 0.001 (except 0), or is 100 000 or more. `None` and values that are not finite give the sign for
/// an unknown number.
pub fn significant(value: impl Into<Option<f64>>, digits: usize) -> String {
    let Some(value) = finite(value) else { return UNKNOWN.into() };
    if value == 0.0 {
        return "0".into();
    }
    let exponent = exponent(value, digits);
    let digits = digits.max(1) as i32;
    if (-3..5).contains(&exponent) {
        return signed(value, digits - 1 - exponent);
    }
    // the mantissa is read from the text, because the power of ten of a number below 1e-308 would be computed as zero
    let text = format!("{:.*e}", digits as usize - 1, value);
    let mantissa = text.split('e').next().and_then(|digits| digits.parse().ok()).unwrap_or(value);
    format!("{} × 10{}", signed(mantissa, digits - 1), superscript(exponent))
}

/// Returns the value if it is present and finite, otherwise `None`.
fn finite(value: impl Into<Option<f64>>) -> Option<f64> {
    value.into().filter(|value| value.is_finite())
}

/// Text of a value ± one standard error, such as `1.234 ± 0.015`. The error has one or two digits, and the value has as
/// many decimal places as the error. If the error is unknown, the value has four digits, and `?` replaces the error. An
/// error of 0 is left out. An unknown value gives the sign for an unknown number.
pub fn with_error(found: impl Into<Option<Estimate>>) -> String {
    let Some(Estimate { value, error }) = found.into().filter(|found| found.value.is_finite()) else {
        return UNKNOWN.into();
    };
    let Some(error) = finite(error) else { return format!("{} ± ?", significant(value, 4)) };
    if error <= 0.0 {
        return significant(value, 4);
    }
    let scale = exponent(value.abs().max(error), 4);
    let power = if (-3..5).contains(&scale) { 0 } else { scale };
    let (value, error) = (value / 10f64.powi(power), error / 10f64.powi(power));
    // an error that begins with 1 or 2 has two digits, because rounding 0.14 to 0.1 would change the error by a third
    let leading = exponent(error, 2);
    let places = if error / 10f64.powi(leading) < 2.95 { 1 - leading } else { -leading };
    let pair = format!("{} ± {}", signed(value, places), signed(error, places));
    if power == 0 { pair } else { format!("({pair}) × 10{}", superscript(power)) }
}

/// Text of `value` with its unit and an SI prefix, for example 4.06e-4 m as `406 µm`. The unit must have no power,
/// unlike m².
pub fn quantity(value: impl Into<Option<f64>>, unit: &str, digits: usize) -> String {
    let Some(value) = finite(value) else { return UNKNOWN.into() };
    let prefix = Prefix::of(value);
    format!("{} {}{unit}", significant(value * prefix.factor, digits), prefix.symbol)
}

/// Text of a number of objects, with the noun `thing` in the singular or plural: `1 thread`, `2 threads`.
pub fn counted(number: usize, thing: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {thing}{plural}", count(number as u64))
}

/// Text of a count, with thin spaces between groups of three digits.
pub fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() * 2);
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// Text of the ratio `part`/`whole` in per cent, with two significant digits; the sign for an unknown number if
/// `whole` is 0.
pub fn percent(part: f64, whole: f64) -> String {
    let ratio = 100.0 * part / whole;
    if ratio.is_finite() { format!("{} %", significant(ratio, 2)) } else { UNKNOWN.into() }
}

/// SI prefix with its factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prefix {
    /// [-] factor by which a value in the plain unit is multiplied to give the number before the prefixed unit: 1000
    /// for milli.
    pub factor: f64,
    /// Letter of the SI prefix, such as `m` for milli.
    pub symbol: &'static str,
}

impl Prefix {
    /// Prefix from pico to tera for which the number before the unit has one to three digits before the decimal point.
    /// Values beyond this range get pico or tera; 0 and values that are not finite get no prefix.
    pub fn of(value: f64) -> Self {
        const SYMBOLS: [&str; 9] = ["p", "n", "µ", "m", "", "k", "M", "G", "T"];
        if value == 0.0 || !value.is_finite() {
            return Self { factor: 1.0, symbol: "" };
        }
        let thousand = exponent(value, 3).div_euclid(3).clamp(-4, 4);
        Self { factor: 1000f64.powi(-thousand), symbol: SYMBOLS[(thousand + 4) as usize] }
    }
}

/// Power of ten of the first digit of `value`, after rounding to `digits` significant digits: 2 for 345.
fn exponent(value: f64, digits: usize) -> i32 {
    let text = format!("{:.*e}", digits.max(1) - 1, value.abs());
    text.split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0)
}

/// Text of a number with `places` decimal places and a typographic minus sign. If `places` is negative, the number is
/// rounded to a multiple of 10 to the power -`places`.
fn signed(value: f64, places: i32) -> String {
    let rounded = if places < 0 {
        let unit = 10f64.powi(-places);
        (value / unit).round() * unit
    } else {
        value
    };
    let text = format!("{:.*}", places.max(0) as usize, rounded.abs());
    let zero = text.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    if rounded < 0.0 && !zero { format!("−{text}") } else { text }
}

/// Digits of `power`, the exponent of a power of ten, as superscript characters.
pub(crate) fn superscript(power: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raise = |c: char| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]);
    power.to_string().chars().map(raise).collect()
}
