//! Foreign text, such as keys, names and cells of a file, made safe to display.
//!
//! A terminal, a browser or a spreadsheet would act on certain texts instead of showing them: escape sequences,
//! characters that change the direction of writing, formulas. Messages, pages, pictures and tables therefore show such
//! characters in the form `\u{1b}`, and put an apostrophe before formulas.

use std::borrow::Cow;

/// [characters] number of characters of a foreign text, such as a name from a file, after which a message cuts it.
const QUOTED: usize = 200;

/// [characters] largest length of a message: about 25 lines of a terminal.
const MESSAGE: usize = 2000;

/// True for a character that has an effect instead of a visible shape. These are controls (category Cc of Unicode),
/// line and paragraph separators, and characters of category Cf that change the direction of writing or have no width.
/// UTR 36, "Unicode Security Considerations", names the categories Cc and Cf. The joiners U+200C and U+200D, which
/// have no width either, are allowed, because scripts of India and Persia require them.
pub fn acts(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
            | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

/// Text of one or more lines made safe to display: characters that would act on a terminal or change the direction of
/// writing are replaced by escapes. Line ends and tabs stay.
pub fn lines(text: &str) -> Cow<'_, str> {
    if !text.contains(|c| acts(c) && !matches!(c, '\n' | '\t')) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '\r' if rest.peek() == Some(&'\n') => {}
            '\n' | '\t' => shown.push(c),
            _ => show(c, &mut shown),
        }
    }
    Cow::Owned(shown)
}

/// A message of one line made safe to display: characters that would act on a terminal or change the direction of
/// writing are replaced by escapes. The text is cut after `MESSAGE` characters.
pub fn message(text: &str) -> Cow<'_, str> {
    let is_long = text.len() > MESSAGE && text.chars().nth(MESSAGE).is_some();
    if !is_long && !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len().min(4 * MESSAGE));
    text.chars().take(MESSAGE).for_each(|c| show(c, &mut shown));
    if is_long {
        shown.push('…');
    }
    Cow::Owned(shown)
}

/// First `QUOTED` characters of a foreign name or cell, for a message. A text that was cut ends with an ellipsis.
pub fn quote(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(QUOTED) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
    }
}

/// A JSON text in which characters that act on a terminal instead of being visible are replaced by JSON escapes.
pub fn json(text: &str) -> Cow<'_, str> {
    if !text.contains(|c| acts(c) && c != '\n') {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if acts(c) && c != '\n' {
            let units = c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")).collect::<String>();
            shown.push_str(&units);
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// Appends a character to `to`. A character with an effect instead of a visible shape ([`acts`]) is replaced by its
/// escape.
fn show(c: char, to: &mut String) {
    match c {
        '\n' | '\r' | '\t' => to.extend(c.escape_default()),
        c if acts(c) => to.extend(c.escape_unicode()),
        c => to.push(c),
    }
}

/// True if a spreadsheet could read a text as a formula (OWASP, "CSV Injection"). Apostrophes at its beginning are
/// ignored, because [`cell`] adds such an apostrophe.
fn is_formula(text: &str) -> bool {
    text.trim_start_matches('\'').starts_with(['=', '+', '-', '@', '\t', '\r'])
}

/// Text of a table cell, changed so that a spreadsheet does not compute it. An apostrophe is put before a text that a
/// spreadsheet could read as a formula; numbers stay unchanged.
pub fn cell(text: String) -> String {
    let is_number = || text.parse::<f64>().is_ok_and(f64::is_finite);
    if !is_formula(&text) || is_number() { text } else { format!("'{text}") }
}

/// Returns the original text of a cell from the text that [`cell`] made of it.
pub fn of_cell(cell: &str) -> &str {
    cell.strip_prefix('\'').filter(|text| is_formula(text)).unwrap_or(cell)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_acts_is_seen() {
        assert_eq!(lines("a\u{1b}[31mb\r\n\tc\rd"), "a\\u{1b}[31mb\n\tc\\rd");
        assert_eq!(message("a\nerror: b\u{202e}c\u{9b}"), "a\\nerror: b\\u{202e}c\\u{9b}");
        assert_eq!(json("{\"a\": \"\u{7f}\u{e0041}\"}\n"), "{\"a\": \"\\u007f\\udb40\\udc41\"}\n");
        assert_eq!(lines("φ = 0.1, µm, ∞\n"), "φ = 0.1, µm, ∞\n");
        assert_eq!(quote(&"x".repeat(300)).chars().count(), QUOTED + 1);
        assert_eq!(message(&"µ".repeat(3000)).chars().count(), MESSAGE + 1);
    }

    #[test]
    fn formulas_are_text_and_numbers_stay() {
        for text in ["=1+1", "+cmd", "-coarse", "@sum", "\t=1", "'=1", "''=1", "-inf"] {
            assert_eq!(cell(text.into()), format!("'{text}"));
        }
        for text in ["", "-1.5e-3", "+2", "glass", "'tis", "a=b", "0"] {
            assert_eq!(cell(text.into()), text);
        }
    }

    proptest! {
        #[test]
        fn a_cell_reads_back(text in "['=+\\-@\\ta1. ]{0,6}") {
            let written = cell(text.clone());
            prop_assert_eq!(of_cell(&written), &text);
        }

        #[test]
        fn nothing_that_acts_is_left(text in any::<String>()) {
            prop_assert!(!message(&text).contains(acts));
            prop_assert!(!lines(&text).contains(|c| acts(c) && !matches!(c, '\n' | '\t')));
            prop_assert!(!json(&text).contains(|c| acts(c) && c != '\n'));
            let back: String = serde_json::from_str(&json(&serde_json::to_string(&text).unwrap())).unwrap();
            prop_assert_eq!(back, text);
        }
    }
}
