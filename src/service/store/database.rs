//! The database file and its schema.

use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Sqlite, Transaction};

use crate::service::store::{Blobs, StoreError};

/// How long a writer waits for another one.
const BUSY_TIMEOUT: Duration = Duration::from_secs(15);

/// Rows and blobs. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Store {
    pool: SqlitePool,
    blobs: Blobs,
}

impl Store {
    /// Opens the database at `url` (`sqlite:FILE`), creating and migrating it as needed, and the object store in the
    /// folder `blobs`.
    pub async fn open(url: &str, blobs: &Path) -> Result<Self, StoreError> {
        let options = SqliteConnectOptions::from_str(url)
            .map_err(|error| StoreError::Unsupported(format!("{url} is not the address of an SQLite file: {error}")))?;
        if let Some(folder) = options.get_filename().parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder)
                .map_err(|source| StoreError::File { what: "creating the folder of the database", source })?;
        }
        // Not the queue's own `setup`: it switches `synchronous` off, and a job that was accepted must survive.
        let options = options
            .create_if_missing(true)
            .journal_mode(SqliteJournalMode::Wal)
            .synchronous(SqliteSynchronous::Normal)
            .busy_timeout(BUSY_TIMEOUT)
            .foreign_keys(true);
        let pool = SqlitePoolOptions::new().max_connections(8).connect_with(options).await?;
        let mut migrator = sqlx::migrate!("src/service/store/migrations");
        // The queue keeps its history under the default name in the same file.
        migrator.dangerous_set_table_name("_quadrille_migrations");
        migrator.run(&pool).await?;
        Ok(Self { pool, blobs: Blobs::open(blobs)? })
    }

    /// The connections.
    pub fn pool(&self) -> &SqlitePool {
        &self.pool
    }

    /// The object store.
    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// A transaction that may write. It takes the write lock at once: a reader that becomes a writer later fails
    /// immediately when another one was faster, whatever the busy timeout.
    pub async fn write(&self) -> Result<Transaction<'static, Sqlite>, StoreError> {
        Ok(self.pool.begin_with("BEGIN IMMEDIATE").await?)
    }

    /// Whether rows and blobs can be written.
    pub async fn ping(&self) -> Result<(), StoreError> {
        self.write().await?.rollback().await?;
        self.blobs.ping().await
    }

    /// Closes all connections after the last statement.
    pub async fn close(&self) {
        self.pool.close().await;
    }
}
