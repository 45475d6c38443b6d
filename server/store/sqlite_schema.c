#include "server/store/sqlite_schema.h"

#include "server/store/sql_verbs.h"

/* Version 8 is the first that is kept: what comes later goes on from it. A store of version 6 is
 * brought up to it; versions 1 to 5 and 7 were never released. */
enum { SCHEMA_VERSION = 14 };

/* The tables up to version 13; VOR_SQL_TABLES has those of jobs since. ledger is what each
 * principal has, and the turn of its job that was claimed last; round is how much waits, by which a
 * place in the queue is counted: in turn t in row t, and in the 256 turns of which t is one in row
 * -1 - t / 256. Triggers keep both, so that they change in the transaction of whatever changes a
 * job. */
#define TABLES                                                                                     \
    "CREATE TABLE job ("                                                                           \
    " seq INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, process_id TEXT NOT NULL,"   \
    " status TEXT NOT NULL"                                                                        \
    "  CHECK (status IN ('accepted','running','successful','failed','dismissed')),"                \
    " progress INTEGER NOT NULL DEFAULT 0, message TEXT NOT NULL DEFAULT '',"                      \
    " request TEXT NOT NULL, metrics TEXT, problem TEXT,"                                          \
    " input_format INTEGER NOT NULL, input_points INTEGER NOT NULL, input_bytes INTEGER NOT NULL," \
    " input_sha256 TEXT NOT NULL, input_seconds REAL NOT NULL,"                                    \
    " output_format INTEGER NOT NULL DEFAULT 0, output_points INTEGER NOT NULL DEFAULT 0,"         \
    " output_bytes INTEGER NOT NULL DEFAULT 0, output_sha256 TEXT NOT NULL DEFAULT '',"            \
    " report_bytes INTEGER NOT NULL DEFAULT 0,"                                                    \
    " attempt INTEGER NOT NULL DEFAULT 0, crashes INTEGER NOT NULL DEFAULT 0,"                     \
    " created INTEGER NOT NULL, started INTEGER NOT NULL DEFAULT 0, updated INTEGER NOT NULL,"     \
    " finished INTEGER NOT NULL DEFAULT 0, expires INTEGER NOT NULL DEFAULT 0,"                    \
    " expired INTEGER NOT NULL DEFAULT 0,"                                                         \
    " inputs TEXT, outputs TEXT," /* beside the main ones */                                       \
    " name TEXT NOT NULL DEFAULT '', principal TEXT NOT NULL DEFAULT '', idem_key TEXT,"           \
    " fingerprint TEXT NOT NULL DEFAULT '',"                                                       \
    " kept INTEGER NOT NULL DEFAULT 0," /* bytes of inputs */                                      \
    " held INTEGER NOT NULL DEFAULT 0," /* bytes of results */                                     \
    " alone INTEGER NOT NULL DEFAULT 0, traceparent TEXT NOT NULL DEFAULT '',"                     \
    " turn INTEGER NOT NULL DEFAULT 0, memory INTEGER NOT NULL DEFAULT 0,"                         \
    " decoded INTEGER NOT NULL DEFAULT 0, owner TEXT NOT NULL DEFAULT '');"                        \
    "CREATE TABLE job_blob (seq INTEGER PRIMARY KEY, report TEXT, trace BLOB);"                    \
    "CREATE TABLE ledger (principal TEXT PRIMARY KEY, jobs INTEGER NOT NULL, kept INTEGER NOT"     \
    " NULL, held INTEGER NOT NULL, turn INTEGER NOT NULL DEFAULT -1) WITHOUT ROWID;"               \
    "CREATE TABLE round (number INTEGER PRIMARY KEY, jobs INTEGER NOT NULL,"                       \
    " decoded INTEGER NOT NULL);"

/* clang-format off */
#define WAITS(row) "(" row ".status = 'accepted')"
#define LIVES(row) "(" row ".status IN ('accepted', 'running'))"

#define END "PRAGMA user_version=8; COMMIT;"

static const char first[] = "BEGIN;" TABLES "CREATE INDEX ledger_turn ON ledger (turn);" END;

/* Columns of both versions; those of before stand in another order in some stores. */
#define COLUMNS                                                                                    \
    "seq, id, process_id, status, progress, message, request, metrics, problem, input_format,"     \
    " input_points, input_bytes, input_sha256, input_seconds, output_format, output_points,"       \
    " output_bytes, output_sha256, attempt, crashes, created, started, updated, finished,"         \
    " expires, expired, inputs, outputs, name, principal, idem_key, fingerprint, kept, held,"      \
    " alone, traceparent"

/* The numbers of acceptance go on where they were, as lists go by them. Jobs that wait take turns
 * from the first on. */
static const char from_6[] =
    "BEGIN; ALTER TABLE job RENAME TO job_before;" TABLES
    "INSERT INTO job (" COLUMNS ", report_bytes, memory, turn) SELECT " COLUMNS ","
    " coalesce(length(CAST(report AS BLOB)), 0),"
    " CASE WHEN status IN ('accepted', 'running') THEN 9223372036854775807 ELSE 0 END,"
    " CASE status WHEN 'accepted' THEN row_number() OVER (PARTITION BY principal, status"
    " ORDER BY seq) - 1 ELSE 0 END FROM job_before ORDER BY seq;"
    "INSERT INTO job_blob SELECT seq, report, trace FROM job_before"
    " WHERE report IS NOT NULL OR trace IS NOT NULL ORDER BY seq;"
    "INSERT INTO ledger (principal, jobs, kept, held)"
    " SELECT principal, sum(" LIVES("job") "), sum(kept), sum(held) FROM job GROUP BY principal;"
    "DELETE FROM sqlite_sequence WHERE name = 'job';"
    "UPDATE sqlite_sequence SET name = 'job' WHERE name = 'job_before';"
    "DROP TABLE job_before; CREATE INDEX ledger_turn ON ledger (turn);" END;

/* A trace has the number of its events at byte 8, little endian; there are less than 65536. */
#define DIGIT(at) "(instr('0123456789ABCDEF', substr(hex(substr(trace, 9, 2)), " #at ", 1)) - 1)"

/* lease is when the owner loses a running job. Events stand in the pieces that were appended, each
 * with the number of its last one; those of a job that ended before are one piece. */
static const char from_8[] =
    "BEGIN; ALTER TABLE job ADD COLUMN lease INTEGER NOT NULL DEFAULT 0;"
    "CREATE TABLE event (seq INTEGER, attempt INTEGER, last INTEGER, data BLOB NOT NULL,"
    " PRIMARY KEY (seq, attempt, last)) WITHOUT ROWID;"
    "INSERT INTO event SELECT seq, max(1, attempt), " DIGIT(1) " * 16 + " DIGIT(2) " + " DIGIT(3)
    " * 4096 + " DIGIT(4) " * 256, trace FROM job_blob JOIN job USING (seq)"
    " WHERE length(trace) > 16;"
    "DELETE FROM job_blob WHERE report IS NULL;"
    "ALTER TABLE job_blob DROP COLUMN trace;"
    "PRAGMA user_version=9; COMMIT;";

#define COUNT_ALL(number)                                                                          \
    "INSERT INTO round SELECT " number ", count(*), sum(decoded) FROM job"                         \
    " WHERE status = 'accepted' GROUP BY 1;"

/* Before, round had the sums of 256 turns alone. */
static const char from_9[] =
    "BEGIN; DELETE FROM round;" COUNT_ALL("turn") COUNT_ALL("-1 - (turn >> 8)")
    "PRAGMA user_version=10; COMMIT;";

/* Leases are a row of each daemon, not of each job. */
static const char from_10[] =
    "BEGIN; CREATE TABLE daemon (owner TEXT PRIMARY KEY, lease INTEGER NOT NULL,"
    " engine TEXT NOT NULL) WITHOUT ROWID;"
    "ALTER TABLE job ADD COLUMN engine TEXT NOT NULL DEFAULT '';"
    "ALTER TABLE job ADD COLUMN release INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE job DROP COLUMN lease; PRAGMA user_version=11; COMMIT;";

/* Words that statements have for PostgreSQL's sake: postgres_schema.c says why. */
static const char from_11[] =
    "BEGIN; ALTER TABLE ledger ADD COLUMN version INTEGER NOT NULL DEFAULT 0;"
    "CREATE VIEW queue AS SELECT 0 AS head, coalesce(max(turn), 0) AS served FROM ledger;"
    "PRAGMA user_version=12; COMMIT;";

/* stop is the attempt that is to end. */
static const char from_12[] = "BEGIN; ALTER TABLE job ADD COLUMN stop INTEGER NOT NULL DEFAULT 0;"
                              "PRAGMA user_version=13; COMMIT;";

#define COUNT(row, by)                                                                             \
    " INSERT INTO round SELECT place, " by ", (" by ") * " row ".decoded"                          \
    " FROM (SELECT " row ".turn AS place UNION ALL SELECT -1 - (" row ".turn >> 8))"               \
    " WHERE " by " <> 0 ON CONFLICT (number)"                                                      \
    " DO UPDATE SET jobs = jobs + excluded.jobs, decoded = decoded + excluded.decoded;"            \
    " DELETE FROM round WHERE number IN (" row ".turn, -1 - (" row ".turn >> 8)) AND jobs = 0;"

/* Each index of a list holds all columns that lists are about. */
#define INDEXES                                                                                    \
    VOR_SQL_INDEXES                                                                                \
    "CREATE INDEX job_listed ON job"                                                               \
    " (seq, status, process_id, created, started, finished, name, principal) WHERE expired = 0;"   \
    "CREATE INDEX job_named ON job"                                                                \
    " (name, seq, status, process_id, created, started, finished, principal) WHERE expired = 0;"   \
    "CREATE INDEX job_owned ON job"                                                                \
    " (principal, seq, status, process_id, created, started, finished, name) WHERE expired = 0;"

/* Before, a row of job had all of it. The numbers of acceptance go on where they were. */
static const char from_13[] =
    "BEGIN; ALTER TABLE job RENAME TO job_before;"
    VOR_SQL_TABLES("INTEGER PRIMARY KEY AUTOINCREMENT", "INTEGER PRIMARY KEY") VOR_SQL_SPLIT
    "DELETE FROM sqlite_sequence WHERE name = 'job';"
    "UPDATE sqlite_sequence SET name = 'job' WHERE name = 'job_before';"
    "DROP TABLE job_before; DROP TABLE job_blob;" INDEXES
    "CREATE TRIGGER job_added AFTER INSERT ON job BEGIN"
    " INSERT INTO ledger (principal, jobs, kept, held)"
    " VALUES (new.principal, " LIVES("new") ", new.kept, new.held)"
    " ON CONFLICT (principal) DO UPDATE SET jobs = jobs + excluded.jobs,"
    " kept = kept + excluded.kept, held = held + excluded.held;"
    COUNT("new", WAITS("new")) " END;"
    "CREATE TRIGGER job_changed AFTER UPDATE OF status, kept, held ON job"
    " WHEN new.kept <> old.kept OR new.held <> old.held OR new.status <> old.status BEGIN"
    " UPDATE ledger SET jobs = jobs + " LIVES("new") " - " LIVES("old") ","
    " kept = kept + new.kept - old.kept, held = held + new.held - old.held,"
    " turn = CASE new.status WHEN 'running' THEN max(turn, new.turn) ELSE turn END"
    " WHERE principal = new.principal;"
    COUNT("new", WAITS("new") " - " WAITS("old"))
    " DELETE FROM job_run WHERE seq = new.seq AND NOT " LIVES("new") "; END;"
    "CREATE TRIGGER job_expired AFTER UPDATE OF expired ON job WHEN new.expired BEGIN"
    " UPDATE job_end SET report = NULL WHERE seq = new.seq;"
    " DELETE FROM event WHERE seq = new.seq; END;"
    "CREATE TRIGGER job_removed AFTER DELETE ON job BEGIN"
    " UPDATE ledger SET jobs = jobs - " LIVES("old") ", kept = kept - old.kept,"
    " held = held - old.held WHERE principal = old.principal;"
    " DELETE FROM job_text WHERE seq = old.seq; DELETE FROM job_run WHERE seq = old.seq;"
    " DELETE FROM job_end WHERE seq = old.seq; DELETE FROM event WHERE seq = old.seq; END;"
    "PRAGMA user_version=14; COMMIT;";
/* clang-format on */

static const struct {
    int64_t from, to;
    const char *sql;
} steps[] = {{0, 8, first},     {6, 8, from_6},    {8, 9, from_8},    {9, 10, from_9},
             {10, 11, from_10}, {11, 12, from_11}, {12, 13, from_12}, {13, 14, from_13}};

vor_status vor_sqlite_prepare_schema(struct vor_sqlite *db, struct vor_error *err)
{
    int64_t version = -1;
    vor_status status = vor_sql_query(vor_sqlite_sql(db), vor_sql_take_number, &version, err,
                                      "PRAGMA user_version", "");

    for (size_t i = 0; i < sizeof steps / sizeof steps[0] && status == VOR_OK; i++) {
        if (version != steps[i].from)
            continue;
        status = vor_sqlite_run(db, steps[i].sql, err);
        version = steps[i].to;
    }
    if (status == VOR_OK && version != SCHEMA_VERSION)
        return vor_fail(err, VOR_E_IO,
                        "the job database has schema %lld, but this version reads only 6, 8, "
                        "9, 10, 11, 12, 13 and %d: start the version that wrote the database, or "
                        "choose another "
                        "--data",
                        (long long)version, SCHEMA_VERSION);
    return status;
}
