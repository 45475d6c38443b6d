#include "server/store/sql_verbs.h"

/* No store of an earlier version was released. */
enum { SCHEMA_VERSION = 18 };

/* What stands beside the tables of jobs (VOR_SQL_TABLE_OF_JOB). ledger is what each principal has,
 * and the turn of its job that was claimed last; round is how much waits, by which a place in the
 * queue is counted: in turn t in row t, and in the 256 turns of which t is one in row -1 - t / 256.
 * Triggers keep both, so that they change in the transaction of whatever changes a job. Leases are
 * a row of each daemon. Events stand in the pieces that were appended, each with the number of its
 * last one. Keys of events and of small files stand in an index: one in the same tree as the bytes
 * would be compared with all bytes at hand. The view, and the ledger's version, are words that
 * statements have for PostgreSQL's sake: postgres_schema.c says why. */
#define BESIDE                                                                                     \
    "CREATE TABLE ledger (principal TEXT PRIMARY KEY, jobs INTEGER NOT NULL, kept INTEGER NOT"     \
    " NULL, held INTEGER NOT NULL, turn INTEGER NOT NULL DEFAULT -1,"                              \
    " version INTEGER NOT NULL DEFAULT 0) WITHOUT ROWID;"                                          \
    "CREATE INDEX ledger_turn ON ledger (turn);"                                                   \
    "CREATE VIEW queue AS SELECT 0 AS head, coalesce(max(turn), 0) AS served FROM ledger;"         \
    "CREATE TABLE round (number INTEGER PRIMARY KEY, jobs INTEGER NOT NULL,"                       \
    " decoded INTEGER NOT NULL);"                                                                  \
    "CREATE TABLE daemon (owner TEXT PRIMARY KEY, lease INTEGER NOT NULL,"                         \
    " engine TEXT NOT NULL) WITHOUT ROWID;"                                                        \
    "CREATE TABLE event (seq INTEGER, attempt INTEGER, last INTEGER, data BLOB NOT NULL,"          \
    " PRIMARY KEY (seq, attempt, last));"                                                          \
    "CREATE TABLE small_file (name TEXT NOT NULL, size INTEGER NOT NULL, data BLOB NOT NULL);"     \
    "CREATE INDEX small_named ON small_file (name, size);"

/* clang-format off */
#define WAITS(row) "(" row ".status = 'accepted')"
#define LIVES(row) "(" row ".status IN ('accepted', 'running'))"

#define COUNT(row, by)                                                                             \
    " INSERT INTO round SELECT place, " by ", (" by ") * " row ".decoded"                          \
    " FROM (SELECT " row ".turn AS place UNION ALL SELECT -1 - (" row ".turn >> 8))"               \
    " WHERE " by " <> 0 ON CONFLICT (number)"                                                      \
    " DO UPDATE SET jobs = jobs + excluded.jobs, decoded = decoded + excluded.decoded;"            \
    " DELETE FROM round WHERE number IN (" row ".turn, -1 - (" row ".turn >> 8)) AND jobs = 0;"

/* Each index of a list holds all columns that lists are about. */
#define INDEXES                                                                                    \
    VOR_SQL_INDEXES                                                                                \
    "CREATE UNIQUE INDEX job_key ON job (principal, idem_key) WHERE idem_key IS NOT NULL;"         \
    "CREATE INDEX job_listed ON job"                                                               \
    " (seq, status, process_id, created, started, finished, name, principal) WHERE expired = 0;"   \
    "CREATE INDEX job_named ON job"                                                                \
    " (name, seq, status, process_id, created, started, finished, principal) WHERE expired = 0;"   \
    "CREATE INDEX job_owned ON job"                                                                \
    " (principal, seq, status, process_id, created, started, finished, name) WHERE expired = 0;"

#define TRIGGERS                                                                                   \
    "CREATE TRIGGER job_added AFTER INSERT ON job BEGIN"                                           \
    " INSERT INTO ledger (principal, jobs, kept, held)"                                            \
    " VALUES (new.principal, " LIVES("new") ", new.kept, new.held)"                                \
    " ON CONFLICT (principal) DO UPDATE SET jobs = jobs + excluded.jobs,"                          \
    " kept = kept + excluded.kept, held = held + excluded.held;"                                   \
    COUNT("new", WAITS("new")) " END;"                                                             \
    "CREATE TRIGGER job_changed AFTER UPDATE OF status, kept, held ON job"                         \
    " WHEN new.kept <> old.kept OR new.held <> old.held OR new.status <> old.status BEGIN"         \
    " UPDATE ledger SET jobs = jobs + " LIVES("new") " - " LIVES("old") ","                        \
    " kept = kept + new.kept - old.kept, held = held + new.held - old.held,"                       \
    " turn = CASE new.status WHEN 'running' THEN max(turn, new.turn) ELSE turn END"                \
    " WHERE principal = new.principal;"                                                            \
    COUNT("new", WAITS("new") " - " WAITS("old"))                                                  \
    " DELETE FROM job_run WHERE seq = new.seq AND NOT " LIVES("new") "; END;"                      \
    "CREATE TRIGGER job_expired AFTER UPDATE OF expired ON job WHEN new.expired BEGIN"             \
    " UPDATE job_end SET report = NULL WHERE seq = new.seq;"                                       \
    " DELETE FROM event WHERE seq = new.seq; END;"                                                 \
    "CREATE TRIGGER job_removed AFTER DELETE ON job BEGIN"                                         \
    " UPDATE ledger SET jobs = jobs - " LIVES("old") ", kept = kept - old.kept,"                   \
    " held = held - old.held WHERE principal = old.principal;"                                     \
    " DELETE FROM job_text WHERE seq = old.seq; DELETE FROM job_run WHERE seq = old.seq;"          \
    " DELETE FROM job_end WHERE seq = old.seq; DELETE FROM event WHERE seq = old.seq; END;"

#define JOBS                                                                                       \
    VOR_SQL_TABLE_OF_JOB("INTEGER PRIMARY KEY AUTOINCREMENT", " UNIQUE", ")")                      \
    VOR_SQL_TABLES_BESIDE("INTEGER PRIMARY KEY")

/* How pages are given back (vor_store_give_back) is set in a file that has some by VACUUM alone. */
static const char first[] = "PRAGMA auto_vacuum=INCREMENTAL; VACUUM;"
    "BEGIN;" BESIDE JOBS INDEXES TRIGGERS "PRAGMA user_version=18; COMMIT;";
/* clang-format on */

static const struct {
    int64_t from, to;
    const char *sql;
} steps[] = {{0, SCHEMA_VERSION, first}};

vor_status vor_sqlite_prepare_schema(struct vor_store *store, struct vor_error *err)
{
    int64_t version = -1;
    vor_status status =
        vor_sql_query(store, vor_sql_take_number, &version, err, "PRAGMA user_version", "");

    for (size_t i = 0; i < sizeof steps / sizeof steps[0] && status == VOR_OK; i++) {
        if (version != steps[i].from)
            continue;
        status = vor_sql_run(store, steps[i].sql, err);
        version = steps[i].to;
    }
    if (status == VOR_OK && version != SCHEMA_VERSION)
        return vor_fail(err, VOR_E_IO,
                        "the job database has schema %lld, but this version reads only %d: start "
                        "the version that wrote the database, or choose another --data",
                        (long long)version, SCHEMA_VERSION);
    return status;
}
