//! Access control.
//!
//! Three properties of a request are checked. *Host*: the name under which the browser addresses this server must be one of its names; a
//! foreign page whose name was redirected to this machine after it had been loaded (DNS rebinding) sends its own. *Origin*: the page that
//! sent the request must be served by this server. *Token*, if other machines can reach the server: it is part of the printed address; the
//! page loaded from that address sets a cookie that admits all further requests.

use std::net::IpAddr;

use axum::http::header::{COOKIE, HOST, HeaderName, ORIGIN};
use axum::http::{HeaderMap, StatusCode};

use super::access_key::AccessKey;
use super::query_value;

/// Rules that requests are checked against.
#[derive(Clone, Debug)]
pub(crate) struct AccessControl {
    /// Host name of this machine as given for `--host`; `None` for an IP address.
    name: Option<String>,
    /// True if other machines may connect by any IP address of this one.
    others: bool,
    token: Option<AccessToken>,
}

/// A secret, and the name of the cookie that carries it.
#[derive(Clone, Debug)]
struct AccessToken {
    key: AccessKey,
    /// Browsers store cookies by host, not by port: each server needs a name of its own.
    cookie: String,
}

/// Result of an access check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum AccessDecision {
    /// Admitted.
    Granted,
    /// Admitted; the response sets this cookie.
    WithCookie(String),
    /// Refused, with the reason.
    Refused(StatusCode, &'static str),
}

impl AccessControl {
    /// Rules for a server that only this machine reaches.
    pub(crate) fn local() -> Self {
        Self { name: None, others: false, token: None }
    }

    /// Rules for a server at `host` and `port` that requires the token `key`.
    pub(crate) fn with_token(host: &str, port: u16, key: AccessKey) -> Self {
        let name = host.parse::<IpAddr>().is_err().then(|| host.to_ascii_lowercase());
        Self { name, others: true, token: Some(AccessToken { key, cookie: format!("glanz-{port}") }) }
    }

    /// Checks a request for `path` with its `query`.
    pub(crate) fn admit(&self, path: &str, query: Option<&str>, headers: &HeaderMap) -> AccessDecision {
        let Some(host) = only(headers, &HOST) else {
            return AccessDecision::Refused(StatusCode::BAD_REQUEST, "the request must have one Host header");
        };
        if !self.is_own_host(host) {
            return AccessDecision::Refused(
                StatusCode::MISDIRECTED_REQUEST,
                "the Host header does not name this server",
            );
        }
        if headers.contains_key(ORIGIN) && !is_own(only(headers, &ORIGIN), host) {
            return AccessDecision::Refused(
                StatusCode::FORBIDDEN,
                "the request comes from a page of another server",
            );
        }
        self.token.as_ref().map_or(AccessDecision::Granted, |token| token.admit(path, query, headers))
    }

    /// True if `host` (a `Host` header) names this server, with any port: it may be forwarded.
    fn is_own_host(&self, host: &str) -> bool {
        let Some(name) = without_port(host) else { return false };
        let name = name.to_ascii_lowercase();
        if name == "localhost" || self.name.as_ref() == Some(&name) {
            return true;
        }
        let number = name.strip_prefix('[').and_then(|n| n.strip_suffix(']')).unwrap_or(&name);
        // An IP address cannot be redirected here by DNS.
        number.parse::<IpAddr>().is_ok_and(|ip| self.others || ip.is_loopback())
    }
}

impl AccessToken {
    fn admit(&self, path: &str, query: Option<&str>, headers: &HeaderMap) -> AccessDecision {
        let is_right = |text: &str| AccessKey::parse(text).is_some_and(|key| key.is(&self.key));
        let given = query_value(query, "token");
        if path == "/" && given.is_some_and(is_right) {
            let Self { key, cookie } = self;
            return AccessDecision::WithCookie(format!("{cookie}={key}; Path=/; HttpOnly; SameSite=Strict"));
        }
        let cookies = headers.get_all(COOKIE).iter().filter_map(|value| value.to_str().ok());
        let mut pairs =
            cookies.flat_map(|value| value.split(';')).filter_map(|pair| pair.trim().split_once('='));
        if pairs.any(|(name, value)| name == self.cookie && is_right(value)) {
            return AccessDecision::Granted;
        }
        AccessDecision::Refused(
            StatusCode::UNAUTHORIZED,
            "open the printed address, which contains the token",
        )
    }
}

/// The value of a header that occurs exactly once.
fn only<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let mut values = headers.get_all(name).iter();
    let first = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(first)
}

/// True if `origin` is that of a page served by this server under the name `host`.
fn is_own(origin: Option<&str>, host: &str) -> bool {
    let page = origin.and_then(|o| o.strip_prefix("http://").or_else(|| o.strip_prefix("https://")));
    page.is_some_and(|page| page.eq_ignore_ascii_case(host))
}

/// A host without `:PORT`; IPv6 addresses keep their brackets. `None` if it is not a host.
fn without_port(host: &str) -> Option<&str> {
    let end = match host.starts_with('[') {
        true => host.find(']')? + 1,
        false => host.find(':').unwrap_or(host.len()),
    };
    let (name, port) = host.split_at_checked(end)?;
    let port_is_fine = port.is_empty() || port.strip_prefix(':').is_some_and(|p| p.parse::<u16>().is_ok());
    (!name.is_empty() && port_is_fine).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(pairs: &[(HeaderName, &str)]) -> HeaderMap {
        let mut map = HeaderMap::new();
        for (name, value) in pairs {
            map.append(name, value.parse().unwrap());
        }
        map
    }

    fn status(decision: AccessDecision) -> Option<StatusCode> {
        match decision {
            AccessDecision::Refused(status, _) => Some(status),
            _ => None,
        }
    }

    #[test]
    fn a_local_server_answers_to_local_names_only() {
        let ask = |host| status(AccessControl::local().admit("/", None, &headers(&[(HOST, host)])));
        for host in ["localhost", "LOCALHOST:9000", "127.0.0.1:80", "127.5.5.5", "[::1]:7878", "[::1]"] {
            assert_eq!(ask(host), None, "{host}");
        }
        for host in [
            "evil.example",
            "localhost.evil.example",
            "127.0.0.1.evil.example:80",
            "192.168.0.7",
            "[::2]",
            "[::1",
            "localhost:x",
            "localhost:80:80",
            ":80",
            "",
            "user@localhost",
        ] {
            assert_eq!(ask(host), Some(StatusCode::MISDIRECTED_REQUEST), "{host}");
        }
        assert_eq!(
            status(AccessControl::local().admit("/", None, &HeaderMap::new())),
            Some(StatusCode::BAD_REQUEST)
        );
        let two = headers(&[(HOST, "localhost"), (HOST, "evil.example")]);
        assert_eq!(status(AccessControl::local().admit("/", None, &two)), Some(StatusCode::BAD_REQUEST));
    }

    #[test]
    fn requests_from_pages_of_others_are_refused() {
        let ask = |origin| {
            let headers = headers(&[(HOST, "localhost:7878"), (ORIGIN, origin)]);
            status(AccessControl::local().admit("/ws", None, &headers))
        };
        assert_eq!(ask("http://localhost:7878"), None);
        for origin in
            ["http://evil.example", "http://localhost:7879", "http://localhost", "null", "localhost:7878", ""]
        {
            assert_eq!(ask(origin), Some(StatusCode::FORBIDDEN), "{origin}");
        }
    }

    #[test]
    fn a_server_for_others_asks_for_its_token() {
        let key = AccessKey::random().unwrap();
        let access = AccessControl::with_token("box.example", 80, key);
        let ask = |path: &str, query: Option<&str>, cookie: &str| {
            access.admit(path, query, &headers(&[(HOST, "box.example"), (COOKIE, cookie)]))
        };
        let cookie = format!("glanz-80={key}");
        let query = format!("token={key}");
        assert_eq!(
            ask("/", Some(&query), "a=b"),
            AccessDecision::WithCookie(format!("{cookie}; Path=/; HttpOnly; SameSite=Strict"))
        );
        assert_eq!(ask("/ws", None, &format!("a=b; {cookie}")), AccessDecision::Granted);
        let other = AccessKey::random().unwrap();
        for (path, query, cookie) in [
            ("/", None, String::new()),
            ("/", Some(format!("token={other}")), String::new()),
            ("/", Some("token=".to_owned()), String::new()),
            // The token in the query admits to the page only.
            ("/ws", Some(format!("token={key}")), String::new()),
            ("/ws", None, format!("glanz-81={key}")),
            ("/ws", None, format!("glanz-80={other}")),
        ] {
            let decision = ask(path, query.as_deref(), &cookie);
            assert_eq!(status(decision), Some(StatusCode::UNAUTHORIZED), "{path} {query:?} {cookie}");
        }
    }

    #[test]
    fn a_server_for_others_answers_to_its_name_and_to_numbers() {
        let access = AccessControl::with_token("Box.example", 80, AccessKey::random().unwrap());
        let is_own_host = |host| access.is_own_host(host);
        assert!(
            is_own_host("box.EXAMPLE")
                && is_own_host("192.168.0.7:80")
                && is_own_host("[fe80::1]:80")
                && is_own_host("localhost")
        );
        assert!(!is_own_host("evil.example"));
    }
}
