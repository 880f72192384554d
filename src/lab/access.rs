//! Access control of the lab: a request must come from this machine and contain the token.
//!
//! Two kinds of requests from pages of other sites are refused. In the first kind, a site lets one of its host names
//! point to this machine (DNS rebinding); the browser then sends this name as `Host`. In the second kind, a page of
//! another site opens a WebSocket to the lab; the browser then sends the address of this page as `Origin`.

/// Number of random bytes in the token. The text of the token has two hexadecimal digits for each byte.
const BYTES: usize = 16;

/// Random secret in the address of the lab. Every request must contain the token, which is too long to be guessed.
#[derive(Clone, Debug)]
pub struct Token(String);

impl Token {
    /// Creates a token from random numbers of the operating system.
    ///
    /// # Errors
    /// Returns an error if the operating system gives no random numbers.
    pub fn new() -> Result<Self, getrandom::Error> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes)?;
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// Text of the token, as it is written in the address of the lab.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// True if `other`, a part of an address, equals the token. The duration of the comparison does not depend on the
    /// position of the first difference, so that the duration reveals nothing about the token.
    pub fn is(&self, other: &str) -> bool {
        let differing = self.0.bytes().zip(other.bytes()).fold(0, |differing, (a, b)| differing | (a ^ b));
        self.0.len() == other.len() && differing == 0
    }
}

/// Host names of this machine that a request may name in its `Host` header.
const NAMES: [&str; 2] = ["127.0.0.1", "localhost"];

/// True if the `Host` header of a request names this machine and the port of the lab.
pub fn is_host(host: Option<&str>, port: u16) -> bool {
    host.is_some_and(|host| NAMES.iter().any(|name| host.eq_ignore_ascii_case(&format!("{name}:{port}"))))
}

/// True if the `Origin` header of a request names a page of the lab at the port `port`. Browsers send no such header
/// with some requests, and other programs need not send one. A missing header is therefore accepted unless `required`
/// is true.
pub fn is_origin(origin: Option<&str>, port: u16, required: bool) -> bool {
    match origin {
        None => !required,
        Some(origin) => origin.strip_prefix("http://").is_some_and(|host| is_host(Some(host), port)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_differ_and_know_themselves() {
        let (one, other) = (Token::new().unwrap(), Token::new().unwrap());
        assert_eq!(one.as_str().len(), 32);
        assert!(one.is(one.as_str()) && !one.is(other.as_str()) && !one.is(&one.as_str()[..31]) && !one.is(""));
    }

    #[test]
    fn other_names_and_pages_are_refused() {
        assert!(is_host(Some("127.0.0.1:81"), 81) && is_host(Some("LOCALHOST:81"), 81));
        for host in [None, Some("127.0.0.1"), Some("127.0.0.1:82"), Some("evil.example:81"), Some("127.0.0.1:81.evil")]
        {
            assert!(!is_host(host, 81), "{host:?}");
        }
        assert!(is_origin(Some("http://localhost:81"), 81, true) && is_origin(None, 81, false));
        for origin in [None, Some("null"), Some("http://evil.example:81"), Some("https://127.0.0.1:81")] {
            assert!(!is_origin(origin, 81, true), "{origin:?}");
        }
    }
}
