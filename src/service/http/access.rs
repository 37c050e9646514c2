//! Who may use the API from a browser.
//!
//! There is no authentication, so what protects a server on loopback from the pages that its user visits is what the
//! browser itself says of a request. A foreign `Host` is a page whose own name was made to resolve to this server (DNS
//! rebinding); a foreign `Origin` on a request that changes something is a page of another site. Programs send no
//! `Origin` and are not asked for one.

use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderName, HeaderValue, Method, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use tower_http::cors::{AllowHeaders, AllowOrigin, CorsLayer};
use tower_http::csrf::{CsrfLayer, ProtectionError};

use crate::service::config::HttpConfig;
use crate::service::http::extract::text;
use crate::service::wire::{Problem, ProblemKind};

/// How long browsers may remember what a preflight request told them.
const REMEMBERED: Duration = Duration::from_secs(3600);

/// Headers of answers that pages of other origins may read.
const EXPOSED: [HeaderName; 10] = [
    header::LOCATION,
    header::ETAG,
    header::CONTENT_DISPOSITION,
    header::CONTENT_LENGTH,
    header::CONTENT_RANGE,
    header::ACCEPT_RANGES,
    header::RETRY_AFTER,
    HeaderName::from_static("preference-applied"),
    HeaderName::from_static("idempotent-replayed"),
    HeaderName::from_static("x-request-id"),
];

/// The rules of one server. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Access {
    origins: Arc<Vec<String>>,
    hosts: Arc<Hosts>,
}

#[derive(Debug)]
enum Hosts {
    Every,
    These { names: Vec<String>, listen: IpAddr },
}

impl Access {
    /// The rules of a server that listens on `listen`.
    pub fn new(config: &HttpConfig, listen: IpAddr) -> Self {
        let hosts = if config.allowed_hosts.iter().any(|host| host == "*") {
            Hosts::Every
        } else {
            Hosts::These { names: config.allowed_hosts.clone(), listen }
        };
        Self { origins: Arc::new(config.allowed_origins.clone()), hosts: Arc::new(hosts) }
    }

    /// Refuses foreign hosts, and foreign origins where something would be changed; what is refused is a problem.
    pub(super) fn guard(&self, routes: Router) -> Router {
        let refused = |_: ProtectionError| {
            let detail = "A page of another origin may not do this; http.allowed_origins names those that may.";
            Problem::new(ProblemKind::ForeignOrigin, detail).into_response()
        };
        let trusted = self.origins.iter().try_fold(CsrfLayer::new(), |layer, origin| layer.add_trusted_origin(origin));
        let origins = trusted.unwrap_or_else(|error| {
            tracing::error!(%error, "no page of another origin is allowed");
            CsrfLayer::new()
        });
        routes
            .layer(origins.with_rejection_response(refused))
            .layer(from_fn_with_state(Arc::clone(&self.hosts), known_host))
    }

    /// Tells browsers what pages of the allowed origins may send and read (CORS).
    pub(super) fn cors(&self) -> CorsLayer {
        let origins = self.origins.iter().filter_map(|origin| HeaderValue::from_str(origin).ok());
        CorsLayer::new()
            .allow_origin(AllowOrigin::list(origins))
            .allow_methods([Method::GET, Method::HEAD, Method::POST, Method::DELETE])
            .allow_headers(AllowHeaders::mirror_request())
            .expose_headers(EXPOSED)
            .allow_private_network(true)
            .max_age(REMEMBERED)
    }
}

/// Answers only under names that are ours. Requests without a name come from no browser.
async fn known_host(State(hosts): State<Arc<Hosts>>, request: Request, next: Next) -> Response {
    let named = match request.uri().authority() {
        Some(authority) => Some(authority.as_str()),
        None => text(request.headers(), "host"),
    };
    if named.is_none_or(|named| hosts.know(named)) {
        return next.run(request).await;
    }
    let detail = "The server is not known under this name; http.allowed_hosts names those that it has.";
    Problem::new(ProblemKind::ForeignHost, detail).into_response()
}

impl Hosts {
    /// Whether `named`, a host with or without a port, is one of ours.
    fn know(&self, named: &str) -> bool {
        let Self::These { names, listen } = self else { return true };
        let Ok(authority) = named.parse::<Authority>() else { return false };
        let host = authority.host().trim_end_matches('.').to_ascii_lowercase();
        // Nobody can make an address lead elsewhere, only a name.
        let address = host.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
        let ours = address.is_ok_and(|ip| ip.is_loopback() || ip == *listen || listen.is_unspecified());
        ours || host == "localhost" || names.contains(&host)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knows(allowed: &[&str], listen: &str, named: &str) -> bool {
        let config = HttpConfig {
            allowed_hosts: allowed.iter().map(|&name| name.to_owned()).collect(),
            ..HttpConfig::default()
        };
        Access::new(&config, listen.parse().unwrap()).hosts.know(named)
    }

    #[test]
    fn loopback_the_listen_address_and_the_allowed_names_are_ours() {
        for named in ["localhost", "LOCALHOST:8620", "localhost.", "127.0.0.1:1", "[::1]:8620"] {
            assert!(knows(&[], "127.0.0.1", named), "{named}");
        }
        for named in ["evil.example", "localhost.evil.example", "10.0.0.7", "a@localhost.evil", "", "x y"] {
            assert!(!knows(&[], "127.0.0.1", named), "{named}");
        }
        assert!(knows(&[], "10.0.0.7", "10.0.0.7:8620") && !knows(&[], "10.0.0.7", "10.0.0.8:8620"));
        assert!(knows(&[], "0.0.0.0", "192.168.1.2") && knows(&[], "::", "[fe80::1]:80"));
        assert!(!knows(&[], "0.0.0.0", "evil.example"));
        assert!(knows(&["models.example.org"], "127.0.0.1", "Models.Example.org:443"));
        assert!(knows(&["*"], "127.0.0.1", "evil.example"));
    }
}
