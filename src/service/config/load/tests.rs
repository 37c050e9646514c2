//! Layers of the configuration, and all their errors at once.

use super::*;

fn load(environment: &[(&str, &str)], flags: &[Override]) -> Result<Config, ConfigError> {
    let environment = environment.iter().map(|&(k, v)| (k.to_owned(), v.to_owned()));
    Config::from_layers(None, environment, flags)
}

#[test]
fn the_defaults_are_valid_and_listen_on_loopback_only() {
    let config = load(&[], &[]).unwrap();
    assert!(config.listen.ip().is_loopback());
    assert!(config.store.starts_with(&config.data));
    assert!(config.database_url.contains(&*config.data.to_string_lossy()));
    assert!(config.engine.threads >= 1);
    assert_eq!(known_keys().len(), 24);
}

#[test]
fn flags_win_over_the_environment_and_that_over_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.toml");
    std::fs::write(&file, "listen = \"127.0.0.1:1\"\n[limits]\nvertices = 1\ntriangles = 1\n").unwrap();
    let environment =
        [("QUADRILLE_LISTEN", "127.0.0.1:2"), ("QUADRILLE_LIMITS__VERTICES", "2"), ("QUADRILLE_PORT", "tcp://x")];
    let environment = environment.map(|(k, v)| (k.to_owned(), v.to_owned()));
    let flags = [("listen", "127.0.0.1:3".to_owned())];
    let config = Config::from_layers(Some(&file), environment, &flags).unwrap();
    assert_eq!((config.listen.port(), config.limits.vertices, config.limits.triangles), (3, 2, 1));
}

#[test]
fn all_errors_are_reported_at_once() {
    let environment = [
        ("QUADRILLE_LISTEN", "everywhere"),
        ("QUADRILLE_DATABASE_URL", "postgres://a/b"),
        ("QUADRILLE_STORE", "s3://bucket"),
        ("QUADRILLE_JOBS__WORKERS", "many"),
        ("QUADRILLE_HTTP__ALLOWED_ORIGINS", "https://a.example, b.example"),
        ("QUADRILLE_HTTP__ALLOWED_HOSTS", "c.example:80"),
        ("QUADRILLE_LIMITS__UPLOAD_BYTES", "0"),
        ("QUADRILLE_LIMITS__CONNECTIONS", "0"),
        ("QUADRILLE_LIMITS__HEADERS_S", "0"),
        ("QUADRILLE_LIMITS__STALLED_S", "4000"),
    ];
    let error = load(&environment, &[]).unwrap_err();
    let keys: Vec<_> = error.0.iter().map(|violation| violation.pointer.as_str()).collect();
    let limits = ["limits.upload_bytes", "limits.connections", "limits.headers_s", "limits.stalled_s"];
    let http = ["http.allowed_origins", "http.allowed_hosts"];
    for key in ["listen", "database_url", "store", "jobs.workers"].into_iter().chain(limits).chain(http) {
        assert!(keys.contains(&key), "{key} in {keys:?}");
    }
}

#[test]
fn unknown_keys_of_a_file_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.toml");
    std::fs::write(&file, "port = 1\n[limits]\nvertexes = 1\n").unwrap();
    let error = Config::from_layers(Some(&file), [], &[]).unwrap_err().to_string();
    assert!(error.contains("port: unknown field") && error.contains("limits.vertexes: unknown field"), "{error}");
}
