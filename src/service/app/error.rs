//! Why the service could not start.

use std::net::SocketAddr;

use crate::service::store::StoreError;

/// Why the service could not start.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    /// The database or the object store cannot be used.
    #[error("{0}; check database_url, store and data in the configuration")]
    Store(#[from] StoreError),
    /// The folder of uploads cannot be made.
    #[error("cannot make the folder {folder}: {source}")]
    Folder {
        /// The folder.
        folder: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {source}; is another server running? choose another address with --listen")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// What the system said.
        source: std::io::Error,
    },
}
