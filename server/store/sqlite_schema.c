#include "server/store/sqlite_schema.h"

#include "proto/text.h"

/* What brings the schema from each version to the next one, from an empty file on. A store keeps
 * its version, so a step is never changed: what comes later is a step of its own, and must leave
 * the rows that are there as good as they were. */
static const char *const steps[] = {
    /* 1 */
    "CREATE TABLE job ("
    " seq INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, process_id TEXT NOT NULL,"
    " status TEXT NOT NULL"
    "  CHECK (status IN ('accepted','running','successful','failed','dismissed')),"
    " progress INTEGER NOT NULL DEFAULT 0, message TEXT NOT NULL DEFAULT '',"
    " request TEXT NOT NULL, metrics TEXT, problem TEXT, report TEXT, trace BLOB,"
    " input_format INTEGER NOT NULL, input_points INTEGER NOT NULL, input_bytes INTEGER NOT NULL,"
    " input_sha256 TEXT NOT NULL, input_seconds REAL NOT NULL,"
    " output_format INTEGER NOT NULL DEFAULT 0, output_points INTEGER NOT NULL DEFAULT 0,"
    " output_bytes INTEGER NOT NULL DEFAULT 0, output_sha256 TEXT NOT NULL DEFAULT '',"
    " attempt INTEGER NOT NULL DEFAULT 0, crashes INTEGER NOT NULL DEFAULT 0,"
    " created INTEGER NOT NULL, started INTEGER NOT NULL DEFAULT 0, updated INTEGER NOT NULL,"
    " finished INTEGER NOT NULL DEFAULT 0, expires INTEGER NOT NULL DEFAULT 0,"
    " expired INTEGER NOT NULL DEFAULT 0);"
    "CREATE INDEX job_status ON job (status, seq) WHERE expired = 0;"
    "CREATE INDEX job_expires ON job (expires) WHERE expires > 0;",
    /* 2: inputs and outputs beside the main ones */
    "ALTER TABLE job ADD COLUMN inputs TEXT; ALTER TABLE job ADD COLUMN outputs TEXT;",
    /* 3: names, keys, kept uploads */
    "ALTER TABLE job ADD COLUMN name TEXT NOT NULL DEFAULT '';"
    "ALTER TABLE job ADD COLUMN principal TEXT NOT NULL DEFAULT '';"
    "ALTER TABLE job ADD COLUMN idem_key TEXT;"
    "ALTER TABLE job ADD COLUMN fingerprint TEXT NOT NULL DEFAULT '';"
    "ALTER TABLE job ADD COLUMN kept INTEGER NOT NULL DEFAULT 0;"
    "CREATE UNIQUE INDEX job_key ON job (principal, idem_key) WHERE idem_key IS NOT NULL;"
    "CREATE INDEX job_kept ON job (finished, seq, kept) WHERE kept > 0;",
    /* 4: jobs that run alone; crashes counts only those from here on, so what waits begins anew */
    "ALTER TABLE job ADD COLUMN alone INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job ADD COLUMN kills INTEGER NOT NULL DEFAULT 0;"
    "UPDATE job SET crashes = 0 WHERE status IN ('accepted', 'running');",
    /* 5: the trace that asked for a job */
    "ALTER TABLE job ADD COLUMN traceparent TEXT NOT NULL DEFAULT '';",
    /* 6: bytes of results */
    "ALTER TABLE job ADD COLUMN held INTEGER NOT NULL DEFAULT 0;"
    "UPDATE job SET held = output_bytes WHERE status = 'successful' AND expired = 0;"
    "CREATE INDEX job_held ON job (finished, seq, held) WHERE held > 0;",
};

enum { SCHEMA_VERSION = sizeof steps / sizeof steps[0] };

static int take_number(void *ctx, struct vor_sqlite_row *row)
{
    *(int64_t *)ctx = vor_sqlite_number(row);
    return 1;
}

static vor_status upgrade(struct vor_sqlite *db, int64_t version, struct vor_error *err)
{
    struct vor_text sql;
    vor_status status;

    vor_text_init(&sql, 0);
    vor_text_puts(&sql, "BEGIN;");
    for (; version < SCHEMA_VERSION; version++)
        vor_text_puts(&sql, steps[version]);
    vor_text_printf(&sql, "PRAGMA user_version=%d;COMMIT;", SCHEMA_VERSION);
    status = vor_text_status(&sql, err);
    if (status == VOR_OK)
        status = vor_sqlite_run(db, sql.data, err);
    vor_text_free(&sql);
    return status;
}

vor_status vor_sqlite_migrate(struct vor_sqlite *db, struct vor_error *err)
{
    int64_t version = -1;
    vor_status status = vor_sqlite_query(db, take_number, &version, err, "PRAGMA user_version", "");

    if (status != VOR_OK || version == SCHEMA_VERSION)
        return status;
    if (version < 0 || version > SCHEMA_VERSION)
        return vor_fail(err, VOR_E_IO,
                        "the job store is of schema %lld, this program knows up to %d",
                        (long long)version, SCHEMA_VERSION);
    return upgrade(db, version, err);
}
