//! The database file and its schema.

use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

use sqlx::sqlite::{
    SqliteConnectOptions, SqliteConnection, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous,
};
use sqlx::{ConnectOptions, Connection, Sqlite, Transaction};

use crate::service::store::database_file::DatabaseFile;
use crate::service::store::folder::private_folder;
use crate::service::store::{Blobs, StoreError, now_ms};

/// How long a writer waits for another one.
const BUSY_TIMEOUT: Duration = Duration::from_secs(15);
/// How long the end of the process waits for statements that still run.
const CLOSING: Duration = Duration::from_secs(1);

/// Rows and blobs. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Store {
    pool: SqlitePool,
    file: DatabaseFile,
    blobs: Blobs,
}

impl Store {
    /// Opens the database at `url` (`sqlite:FILE`), creating and migrating it as needed, and the object store in the
    /// folder `blobs`.
    pub async fn open(url: &str, blobs: &Path) -> Result<Self, StoreError> {
        let options = SqliteConnectOptions::from_str(url)
            .map_err(|error| StoreError::Unsupported(format!("{url} is not the address of an SQLite file: {error}")))?;
        let path = options.get_filename().to_path_buf();
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            private_folder(folder)
                .map_err(|source| StoreError::File { what: "creating the folder of the database", source })?;
        }
        // Not the queue's own `setup`: it switches `synchronous` off, and a job that was accepted must survive. FULL
        // syncs the log at every commit; with NORMAL a loss of power takes back what was acknowledged.
        let options = options
            .journal_mode(SqliteJournalMode::Wal)
            .synchronous(SqliteSynchronous::Full)
            .busy_timeout(BUSY_TIMEOUT)
            .foreign_keys(true);
        // Made here or never: a connection that is opened later must not begin an empty database in the place of one
        // that was removed.
        options.clone().create_if_missing(true).connect().await?.close().await?;
        let file = DatabaseFile::at(&path)?;
        let opened = file.clone();
        let pool = SqlitePoolOptions::new()
            .max_connections(8)
            .after_connect(move |_, _| {
                let same = opened.check().map_err(|error| sqlx::Error::Io(std::io::Error::other(error)));
                Box::pin(async move { same })
            })
            .after_release(|connection, _| Box::pin(may_be_used_again(connection)))
            .connect_with(options.create_if_missing(false))
            .await?;
        let mut migrator = sqlx::migrate!("src/service/store/migrations");
        // The queue keeps its history under the default name in the same file.
        migrator.dangerous_set_table_name("_quadrille_migrations");
        migrator.run(&pool).await?;
        Ok(Self { pool, file, blobs: Blobs::open(blobs)? })
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
        self.file.check()?;
        Ok(self.pool.begin_with("BEGIN IMMEDIATE").await?)
    }

    /// Writes a row and a blob.
    pub async fn probe(&self) -> Result<(), StoreError> {
        let mut tx = self.write().await?;
        sqlx::query("INSERT INTO probes (id, at) VALUES (1, ?) ON CONFLICT (id) DO UPDATE SET at = excluded.at")
            .bind(now_ms())
            .execute(&mut *tx)
            .await?;
        tx.commit().await?;
        self.blobs.probe().await
    }

    /// Closes all connections; a statement that hangs is not waited for.
    pub async fn close(&self) {
        let _ = tokio::time::timeout(CLOSING, self.pool.close()).await;
    }
}

/// Whether a connection goes back to the pool; otherwise it is closed. SQLite ends a transaction by itself when the disk
/// is full or fails; the rollback that follows finds none, fails, and leaves sqlx with the belief that the transaction
/// goes on. From then on `BEGIN IMMEDIATE` is refused, and a plain `BEGIN` becomes a savepoint, whose rollback keeps the
/// write lock.
async fn may_be_used_again(connection: &mut SqliteConnection) -> Result<bool, sqlx::Error> {
    // The rollback of a transaction that was dropped may still be on its way.
    connection.ping().await?;
    Ok(!connection.is_in_transaction())
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn store(folder: &Path) -> Store {
        let url = format!("sqlite://{}", folder.join("jobs.sqlite").display());
        Store::open(&url, &folder.join("objects")).await.unwrap()
    }

    #[tokio::test]
    async fn a_transaction_that_the_database_broke_off_leaves_no_trace() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(folder.path()).await;
        for _ in 0..3 {
            let mut tx = store.write().await.unwrap();
            // As on a full disk.
            sqlx::query("PRAGMA max_page_count = 1").execute(&mut *tx).await.unwrap();
            let full = sqlx::query("INSERT INTO probes (id, at) VALUES (2, zeroblob(1000000))");
            let error = full.execute(&mut *tx).await.unwrap_err();
            assert_eq!(error.into_database_error().unwrap().code().as_deref(), Some("13"), "SQLITE_FULL");
        }
        for _ in 0..10 {
            store.write().await.unwrap().commit().await.unwrap();
            store.probe().await.unwrap();
        }
        store.close().await;
    }

    #[tokio::test]
    async fn nothing_is_written_to_a_file_that_was_removed_or_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let store = store(folder.path()).await;
        let (here, away) = (folder.path().join("jobs.sqlite"), folder.path().join("away.sqlite"));
        store.probe().await.unwrap();
        std::fs::rename(&here, &away).unwrap();
        assert!(matches!(store.write().await, Err(StoreError::Replaced(_))));
        std::fs::copy(&away, &here).unwrap();
        assert!(matches!(store.probe().await, Err(StoreError::Replaced(_))));
        std::fs::rename(&away, &here).unwrap();
        store.probe().await.unwrap();
        store.close().await;
    }
}
