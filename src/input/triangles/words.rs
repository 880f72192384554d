//! Splits a text into words with their line numbers. The text may have any encoding, because mesh files may contain
//! names in any encoding.

/// Word of a text, with the number of its line.
#[derive(Clone, Copy, Debug)]
pub struct Word<'a> {
    /// Bytes of the word.
    pub bytes: &'a [u8],
    /// Number of the line of the word, counted from 1.
    pub line: usize,
}

impl Word<'_> {
    /// True if the word equals `word`, regardless of capitals.
    pub fn is(&self, word: &str) -> bool {
        self.bytes.eq_ignore_ascii_case(word.as_bytes())
    }

    /// Word in quotes for a message, cut after 40 characters.
    pub fn shown(&self) -> String {
        let text = String::from_utf8_lossy(self.bytes);
        let mut short: String = text.chars().take(40).map(|c| if c.is_control() { ' ' } else { c }).collect();
        if text.chars().nth(40).is_some() {
            short.push('…');
        }
        format!("\"{short}\"")
    }

    /// Value of the word as a finite number, and its number of significant digits [-].
    ///
    /// # Errors
    /// A message in words: the word is not a finite number.
    pub fn number(&self) -> Result<(f64, usize), String> {
        let text = std::str::from_utf8(self.bytes).unwrap_or("");
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        let number = number.ok_or_else(|| format!("the coordinate {} is not a finite number", self.shown()))?;
        Ok((number, digits(text)))
    }
}

/// [-] number of significant digits of a typed number, including zeros at its end.
pub fn digits(number: &str) -> usize {
    let mantissa = number.split(['e', 'E']).next().unwrap_or("");
    let digits = mantissa.bytes().filter(u8::is_ascii_digit).skip_while(|digit| *digit == b'0');
    digits.count()
}

/// Iterator over the words of a text. Lines end with LF, CR LF or CR.
#[derive(Clone, Debug)]
pub struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Words<'a> {
    /// Creates an iterator before the first word of a text; a byte order mark at the beginning is skipped.
    pub fn of(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Self { bytes, at: 0, line: 1 }
    }

    /// Skips blanks up to the next word, and line ends too if `across_lines` is true.
    fn skip_blanks(&mut self, across_lines: bool) {
        while let Some(&byte) = self.bytes.get(self.at) {
            match byte {
                b' ' | b'\t' | 0x0b | 0x0c => {}
                b'\n' | b'\r' if across_lines => {
                    let pair = byte == b'\r' && self.bytes.get(self.at + 1) == Some(&b'\n');
                    self.line += usize::from(!pair);
                }
                _ => return,
            }
            self.at += 1;
        }
    }

    /// Reads the word that begins at the current position; `None` at the end of a line or of the text.
    fn here(&mut self) -> Option<Word<'a>> {
        let rest = &self.bytes[self.at..];
        let blank = |byte: &u8| matches!(byte, b' ' | b'\t' | 0x0b | 0x0c | b'\n' | b'\r');
        let length = rest.iter().position(blank).unwrap_or(rest.len());
        self.at += length;
        (length > 0).then_some(Word { bytes: &rest[..length], line: self.line })
    }

    /// Moves to the beginning of the next line. It is called after the last word of a line has been read.
    pub fn next_line(&mut self) {
        self.skip_blanks(false);
        let rest = &self.bytes[self.at..];
        let length = if rest.starts_with(b"\r\n") { 2 } else { rest.len().min(1) };
        self.at += length;
        self.line += 1;
    }

    /// Reads the next word of the current line; `None` at the end of this line.
    pub fn next_in_line(&mut self) -> Option<Word<'a>> {
        self.skip_blanks(false);
        self.here()
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = Word<'a>;

    fn next(&mut self) -> Option<Word<'a>> {
        self.skip_blanks(true);
        self.here()
    }
}
