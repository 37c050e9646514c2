//! Names of origins and hosts in the configuration.

use axum::http::uri::{Authority, Uri};
use serde::Deserialize;

/// A list of names; in the environment and in flags they are joined by commas.
#[derive(Debug, Default, Deserialize)]
#[serde(from = "Written")]
pub(super) struct Names(pub(super) Vec<String>);

#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    List(Vec<String>),
    Text(String),
}

impl From<Written> for Names {
    fn from(written: Written) -> Self {
        let names = match written {
            Written::List(names) => names,
            Written::Text(text) => text.split(',').map(str::to_owned).collect(),
        };
        Self(names.iter().map(|name| name.trim().to_ascii_lowercase()).filter(|name| !name.is_empty()).collect())
    }
}

/// Whether a browser may write this as `Origin`. They leave out the slash at the end and the scheme's own port.
pub(super) fn is_origin(text: &str) -> bool {
    let Ok(uri) = text.parse::<Uri>() else { return false };
    let (Some(scheme @ ("http" | "https")), Some(authority)) = (uri.scheme_str(), uri.authority()) else {
        return false;
    };
    let implied = if scheme == "http" { 80 } else { 443 };
    text == format!("{scheme}://{authority}") && is_plain(authority) && authority.port_u16() != Some(implied)
}

/// Whether this is the name or address of a host alone, or `*`.
pub(super) fn is_host(text: &str) -> bool {
    let is_name = |authority: Authority| is_plain(&authority) && authority.host() == text;
    text == "*" || text.parse().is_ok_and(is_name)
}

fn is_plain(authority: &Authority) -> bool {
    !authority.as_str().contains(['@', '*']) && !authority.host().is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_browsers_send_is_an_origin_or_a_host() {
        for origin in ["https://a.example", "http://a.example:8080", "http://[::1]:3000"] {
            assert!(is_origin(origin), "{origin}");
        }
        for text in
            ["a.example", "https://a.example/", "https://a.example:443", "https://b@a.example", "ftp://a", "*", ""]
        {
            assert!(!is_origin(text), "{text}");
        }
        for host in ["a.example", "localhost", "10.0.0.7", "[::1]", "*"] {
            assert!(is_host(host), "{host}");
        }
        for text in ["a.example:80", "https://a.example", "a/b", "*.example", "a@b", ""] {
            assert!(!is_host(text), "{text}");
        }
    }

    #[test]
    fn lists_are_arrays_or_joined_by_commas() {
        let Names(joined) = serde_json::from_str("\"https://A.example , https://b.example\"").unwrap();
        let Names(array) = serde_json::from_str("[\"https://a.example\", \"https://b.example\"]").unwrap();
        assert_eq!(joined, array);
        assert_eq!(serde_json::from_str::<Names>("\"\"").unwrap().0, Vec::<String>::new());
    }
}
