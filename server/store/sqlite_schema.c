#include "server/store/sqlite_schema.h"

/* Versions 1 to 5 were never released: a file of them is refused, like one of a later version. */
enum { SCHEMA_VERSION = 6 };

static const char schema[] =
    "BEGIN;"
    "CREATE TABLE job ("
    " seq INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, process_id TEXT NOT NULL,"
    " status TEXT NOT NULL"
    "  CHECK (status IN ('accepted','running','successful','failed','dismissed')),"
    " progress INTEGER NOT NULL DEFAULT 0, message TEXT NOT NULL DEFAULT '',"
    " request TEXT NOT NULL, metrics TEXT, problem TEXT,"
    " input_format INTEGER NOT NULL, input_points INTEGER NOT NULL, input_bytes INTEGER NOT NULL,"
    " input_sha256 TEXT NOT NULL, input_seconds REAL NOT NULL,"
    " output_format INTEGER NOT NULL DEFAULT 0, output_points INTEGER NOT NULL DEFAULT 0,"
    " output_bytes INTEGER NOT NULL DEFAULT 0, output_sha256 TEXT NOT NULL DEFAULT '',"
    " attempt INTEGER NOT NULL DEFAULT 0, crashes INTEGER NOT NULL DEFAULT 0,"
    " created INTEGER NOT NULL, started INTEGER NOT NULL DEFAULT 0, updated INTEGER NOT NULL,"
    " finished INTEGER NOT NULL DEFAULT 0, expires INTEGER NOT NULL DEFAULT 0,"
    " expired INTEGER NOT NULL DEFAULT 0,"
    " inputs TEXT, outputs TEXT," /* beside the main ones */
    " name TEXT NOT NULL DEFAULT '', principal TEXT NOT NULL DEFAULT '', idem_key TEXT,"
    " fingerprint TEXT NOT NULL DEFAULT '',"
    " kept INTEGER NOT NULL DEFAULT 0," /* bytes of inputs */
    " alone INTEGER NOT NULL DEFAULT 0, kills INTEGER NOT NULL DEFAULT 0,"
    " traceparent TEXT NOT NULL DEFAULT '',"
    " held INTEGER NOT NULL DEFAULT 0," /* bytes of results */
    " report TEXT, trace BLOB);"        /* last: what stands behind them is read through them */
    "CREATE INDEX job_status ON job (status, seq) WHERE expired = 0;"
    "CREATE INDEX job_expires ON job (expires) WHERE expires > 0;"
    "CREATE UNIQUE INDEX job_key ON job (principal, idem_key) WHERE idem_key IS NOT NULL;"
    "CREATE INDEX job_kept ON job (finished, seq, kept) WHERE kept > 0;"
    "CREATE INDEX job_held ON job (finished, seq, held) WHERE held > 0;"
    "PRAGMA user_version=6;"
    "COMMIT;";

/* What is asked of many rows: each of these holds all columns that such a question is about, so
 * that no row is read for it, with its report and its trace. They are added to a store that has
 * none. */
static const char indexes[] =
    "CREATE INDEX IF NOT EXISTS job_listed ON job"
    " (seq, status, process_id, created, started, finished, name, principal) WHERE expired = 0;"
    "CREATE INDEX IF NOT EXISTS job_named ON job"
    " (name, seq, status, process_id, created, started, finished, principal) WHERE expired = 0;"
    "CREATE INDEX IF NOT EXISTS job_owned ON job"
    " (principal, seq, status, process_id, created, started, finished, name, kept, output_bytes)"
    " WHERE expired = 0;";

static int take_number(void *ctx, struct vor_sqlite_row *row)
{
    *(int64_t *)ctx = vor_sqlite_number(row);
    return 1;
}

vor_status vor_sqlite_prepare_schema(struct vor_sqlite *db, struct vor_error *err)
{
    int64_t version = -1;
    vor_status status = vor_sqlite_query(db, take_number, &version, err, "PRAGMA user_version", "");

    if (status == VOR_OK && version != 0 && version != SCHEMA_VERSION)
        return vor_fail(err, VOR_E_IO, "the job store has schema %lld, this program knows only %d",
                        (long long)version, SCHEMA_VERSION);
    if (status == VOR_OK && version == 0)
        status = vor_sqlite_run(db, schema, err);
    return status == VOR_OK ? vor_sqlite_run(db, indexes, err) : status;
}
