// SPDX-License-Identifier: Apache-2.0
//! `at user@host:port`.

use super::super::ast::Host;
use super::super::token::TokenKind;
use super::{Parsed, Parser};
use crate::diagnostics::{Code, Diagnostic};

impl Parser<'_> {
    /// Parses `at …`, if it is here.
    pub(super) fn host(&mut self) -> Parsed<Option<Host>> {
        if self.eat_word("at").is_none() {
            return Ok(None);
        }
        let start = self.here();
        let mut first = true;
        while first || self.peek(0).adjacent {
            let part = matches!(
                self.kind(),
                TokenKind::Word
                    | TokenKind::Int
                    | TokenKind::Float
                    | TokenKind::Dot
                    | TokenKind::Colon
                    | TokenKind::DoubleColon
                    | TokenKind::Minus
                    | TokenKind::At
                    | TokenKind::OpenBracket
                    | TokenKind::CloseBracket
                    | TokenKind::Percent
            );
            if !part {
                break;
            }
            self.advance();
            first = false;
        }
        if first {
            return self.unexpected("a host name or address");
        }
        let span = start.to(self.before());
        let text = self.slice(span).to_owned();
        match parse_host(&text) {
            Ok((user, address, port)) => Ok(Some(Host { user, address, port, span })),
            Err(reason) => {
                let message = format!("`{text}` is no host: {reason}");
                let hint = "write a host name or an address, and a port if needed: `at 192.168.1.10:15045`";
                self.report(Diagnostic::new(Code::BadHost, span, message).hint(hint));
                Ok(None)
            }
        }
    }
}

type HostParts = (Option<String>, String, Option<u16>);

/// Splits `user@host:port` or `[user@ipv6]:port`.
fn parse_host(text: &str) -> Result<HostParts, &'static str> {
    if let Some(bracketed) = text.strip_prefix('[') {
        let (inside, behind) = bracketed.split_once(']').ok_or("`]` is missing")?;
        let (user, address) = split_user(inside);
        address_v6(address)?;
        let port = match behind.strip_prefix(':') {
            Some(port) => Some(parse_port(port)?),
            None if behind.is_empty() => None,
            None => return Err("only `:port` may follow `]`"),
        };
        return Ok((user, address.to_owned(), port));
    }
    let (user, rest) = split_user(text);
    if rest.matches(':').count() > 1 {
        address_v6(rest)?;
        return Ok((user, rest.to_owned(), None));
    }
    let (address, port) = match rest.split_once(':') {
        Some((address, port)) => (address, Some(parse_port(port)?)),
        None => (rest, None),
    };
    let numeric = address.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    if numeric && address.parse::<std::net::Ipv4Addr>().is_err() {
        return Err("an IPv4 address has four numbers from 0 to 255");
    }
    let label_fits = |label: &str| {
        let inner = label.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_');
        !label.is_empty() && label.len() <= 63 && inner && !label.starts_with('-') && !label.ends_with('-')
    };
    if !address.split('.').all(label_fits) {
        return Err("a host name has letters, digits and `-` between its dots");
    }
    Ok((user, address.to_owned(), port))
}

fn split_user(text: &str) -> (Option<String>, &str) {
    match text.split_once('@') {
        Some((user, rest)) => (Some(user.to_owned()), rest),
        None => (None, text),
    }
}

fn address_v6(text: &str) -> Result<(), &'static str> {
    let address = text.split('%').next().unwrap_or_default();
    address.parse::<std::net::Ipv6Addr>().map(|_| ()).map_err(|_| "this is no IPv6 address")
}

fn parse_port(text: &str) -> Result<u16, &'static str> {
    match text.parse::<u16>() {
        Ok(port) if port > 0 => Ok(port),
        _ => Err("a port is a number from 1 to 65535"),
    }
}

#[cfg(test)]
mod tests {
    use super::parse_host;

    #[test]
    fn names_and_addresses_are_taken_apart() {
        let host = |user: Option<&str>, address: &str, port| Ok((user.map(str::to_owned), address.to_owned(), port));
        assert_eq!(parse_host("pi@10.0.0.1:80"), host(Some("pi"), "10.0.0.1", Some(80)));
        assert_eq!(parse_host("my-board.local"), host(None, "my-board.local", None));
        assert_eq!(parse_host("[me@fe80::7%eth0]:9"), host(Some("me"), "fe80::7%eth0", Some(9)));
        assert_eq!(parse_host("::1"), host(None, "::1", None));
        for bad in ["10.0.0", "10.0.0.256", "a:0", "a:70000", "a..b", "-a", "[::1", "1:2:3"] {
            assert!(parse_host(bad).is_err(), "{bad}");
        }
    }
}
