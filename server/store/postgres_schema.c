#include "server/store/sql_verbs.h"

/* The tables, indexes and triggers of sqlite_schema.c, which says what each is for. */
enum { SCHEMA_VERSION = 7 };

/* clang-format off */

/* What statements use of SQLite's functions. */
#define FUNCTIONS                                                                                  \
    "CREATE FUNCTION max(bigint, bigint) RETURNS bigint IMMUTABLE LANGUAGE sql"                    \
    " AS 'SELECT greatest($1, $2)';"                                                               \
    "CREATE FUNCTION max(bigint, bigint, bigint, bigint) RETURNS bigint IMMUTABLE LANGUAGE sql"    \
    " AS 'SELECT greatest($1, $2, $3, $4)';"                                                       \
    "CREATE FUNCTION min(bigint, bigint) RETURNS bigint IMMUTABLE LANGUAGE sql"                    \
    " AS 'SELECT least($1, $2)';"                                                                  \
    "CREATE FUNCTION instr(text, text) RETURNS bigint IMMUTABLE LANGUAGE sql"                      \
    " AS 'SELECT strpos($1, $2)';"

#define WAITS(row) "(" row ".status = 'accepted')::int"
#define LIVES(row) "(" row ".status IN ('accepted', 'running'))::int"
#define COUNT(row, by)                                                                             \
    " INSERT INTO round SELECT place, " by ", (" by ") * " row ".decoded"                          \
    " FROM (VALUES (" row ".turn), (-1 - (" row ".turn >> 8))) AS places (place)"                  \
    " WHERE " by " <> 0 ON CONFLICT (number) DO UPDATE SET jobs = round.jobs + excluded.jobs,"     \
    " decoded = round.decoded + excluded.decoded;"                                                 \
    " DELETE FROM round WHERE number IN (" row ".turn, -1 - (" row ".turn >> 8)) AND jobs = 0;"
#define FUNCTION(name, body)                                                                       \
    "CREATE OR REPLACE FUNCTION " name "() RETURNS trigger LANGUAGE plpgsql"                       \
    " SET enable_seqscan = off AS $$ BEGIN" body " RETURN NULL; END $$;"

/* While an old transaction looks on, no version of a row that it might see can go, and an index
 * leads to all of them. So what is asked for at each change is where no dead version is met: a
 * change of the ledger is a new row of a higher number, and the highest of a principal, or of all,
 * is read; no waiting job has a turn below the head, from which the queue is read. A plan that was
 * made while tables were short must not last: it would read them whole. */
#define BESIDE                                                                                     \
    "CREATE TABLE voronoid_schema (version bigint NOT NULL, secret text NOT NULL DEFAULT"          \
    " gen_random_uuid()::text || gen_random_uuid()::text);"                                        \
    "CREATE TABLE event (seq bigint, attempt bigint, last bigint, data bytea NOT NULL,"            \
    " PRIMARY KEY (seq, attempt, last));"                                                          \
    "CREATE TABLE daemon (owner text PRIMARY KEY, lease bigint NOT NULL, engine text NOT NULL);"   \
    "CREATE TABLE round (number bigint PRIMARY KEY, jobs bigint NOT NULL,"                         \
    " decoded bigint NOT NULL);"                                                                   \
    "CREATE TABLE ledger (principal text NOT NULL, jobs bigint NOT NULL, kept bigint NOT NULL,"    \
    " held bigint NOT NULL, turn bigint NOT NULL DEFAULT -1,"                                      \
    " version bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,"                                    \
    " head bigint NOT NULL DEFAULT 0, served bigint NOT NULL DEFAULT 0);"                          \
    "CREATE INDEX ledger_newest ON ledger (principal, version);"                                   \
    "CREATE VIEW queue AS SELECT head, served FROM ledger ORDER BY version DESC LIMIT 1;"          \
    "CREATE FUNCTION ledger_add(who text, job_more bigint, kept_more bigint, held_more bigint,"    \
    " started bigint, waits bigint, left_queue bigint) RETURNS void LANGUAGE plpgsql"               \
    " AS $$ DECLARE had ledger; first bigint; last bigint; BEGIN"                                        \
    " SELECT * INTO had FROM ledger WHERE principal = who ORDER BY version DESC LIMIT 1;"          \
    " SELECT head, served INTO first, last FROM queue;"                                            \
    " IF left_queue > first AND NOT EXISTS (SELECT 1 FROM job WHERE status = 'accepted'"           \
    "  AND turn >= first AND turn < left_queue) THEN first := left_queue; END IF;"                 \
    " INSERT INTO ledger (principal, jobs, kept, held, turn, head, served) VALUES (who,"           \
    "  coalesce(had.jobs, 0) + job_more, coalesce(had.kept, 0) + kept_more,"                       \
    "  coalesce(had.held, 0) + held_more, greatest(had.turn, started, -1),"                        \
    "  least(coalesce(first, 0), waits), greatest(last, started, 0));"                             \
    " DELETE FROM ledger WHERE principal = who AND version = had.version; END $$;"

#define ENDED " DELETE FROM job_run WHERE seq = new.seq AND " LIVES("new") " = 0;"

/* Jobs that wait, that run and that are over are partitions: those that an old transaction holds up
 * lie apart from what stays, and VACUUM gives their pages back. What is unique in all of them stands
 * in idempotency. A job that goes on to another partition is removed from the one and added to the
 * other, and is there when the triggers run. */
#define JOB                                                                                        \
    VOR_SQL_TABLE_OF_JOB("bigint GENERATED BY DEFAULT AS IDENTITY", "",                            \
                         ", PRIMARY KEY (seq, status)) PARTITION BY LIST (status)")                \
    "CREATE TABLE job_waiting PARTITION OF job FOR VALUES IN ('accepted');"                        \
    "CREATE TABLE job_running PARTITION OF job FOR VALUES IN ('running');"                         \
    "CREATE TABLE job_over PARTITION OF job DEFAULT;"                                              \
    "CREATE TABLE idempotency (principal text NOT NULL, idem_key text NOT NULL, seq bigint NOT NULL," \
    " PRIMARY KEY (principal, idem_key));"                                                         \
    "CREATE INDEX idempotency_job ON idempotency (seq);"

#define INDEXES_AND_TRIGGERS                                                                       \
    VOR_SQL_INDEXES                                                                                \
    "CREATE INDEX job_key ON job (principal, idem_key) WHERE idem_key IS NOT NULL;"                \
    "CREATE INDEX job_id ON job (id);"                                                             \
    "CREATE INDEX job_named ON job (name, seq) WHERE expired = 0;"                                 \
    "CREATE INDEX job_owned ON job (principal, seq) WHERE expired = 0;"                            \
    FUNCTION("job_added",                                                                          \
             " PERFORM ledger_add(new.principal, " LIVES("new") ", new.kept, new.held,"            \
             " CASE new.status WHEN 'running' THEN new.turn END,"                                  \
             " CASE new.status WHEN 'accepted' THEN new.turn END, NULL);"                          \
             COUNT("new", WAITS("new")) ENDED                                                      \
             " IF new.idem_key IS NOT NULL AND NOT EXISTS (SELECT 1 FROM idempotency"              \
             "  WHERE principal = new.principal AND idem_key = new.idem_key AND seq = new.seq) THEN" \
             "  INSERT INTO idempotency VALUES (new.principal, new.idem_key, new.seq); END IF;")   \
    "CREATE TRIGGER job_added AFTER INSERT ON job FOR EACH ROW EXECUTE FUNCTION job_added();"      \
    FUNCTION("job_changed",                                                                        \
             " PERFORM ledger_add(new.principal, 0, new.kept - old.kept, new.held - old.held,"     \
             " NULL, NULL, NULL);")                                                                \
    "CREATE TRIGGER job_changed AFTER UPDATE OF kept, held ON job FOR EACH ROW"                    \
    " WHEN (new.kept <> old.kept OR new.held <> old.held)"                                         \
    " EXECUTE FUNCTION job_changed();"                                                             \
    FUNCTION("job_expired", " UPDATE job_end SET report = NULL WHERE seq = new.seq;"               \
                            " DELETE FROM event WHERE seq = new.seq;"                              \
                            " DELETE FROM idempotency WHERE seq = new.seq;")                       \
    "CREATE TRIGGER job_expired AFTER UPDATE OF expired ON job FOR EACH ROW"                       \
    " WHEN (new.expired <> 0) EXECUTE FUNCTION job_expired();"                                     \
    FUNCTION("job_removed",                                                                        \
             " PERFORM ledger_add(old.principal, -" LIVES("old") ", -old.kept, -old.held, NULL,"   \
             " NULL, CASE old.status WHEN 'accepted' THEN old.turn END);"                          \
             COUNT("old", "-" WAITS("old"))                                                        \
             " IF EXISTS (SELECT 1 FROM job WHERE seq = old.seq) THEN RETURN NULL; END IF;"        \
             " DELETE FROM idempotency WHERE seq = old.seq;"                                       \
             " DELETE FROM job_text WHERE seq = old.seq; DELETE FROM job_run WHERE seq = old.seq;" \
             " DELETE FROM job_end WHERE seq = old.seq; DELETE FROM event WHERE seq = old.seq;")   \
    "CREATE TRIGGER job_removed AFTER DELETE ON job FOR EACH ROW EXECUTE FUNCTION job_removed();"  \
    "ALTER TABLE job_waiting SET (autovacuum_vacuum_scale_factor = 0.02);"                         \
    "ALTER TABLE job_running SET (autovacuum_vacuum_scale_factor = 0.02);"                         \
    "ALTER TABLE job_over SET (autovacuum_vacuum_scale_factor = 0.02);"                            \
    "ALTER TABLE job_run SET (fillfactor = 50, autovacuum_vacuum_scale_factor = 0.02);"

static const char first[] =
    FUNCTIONS BESIDE JOB VOR_SQL_TABLES_BESIDE("bigint PRIMARY KEY") INDEXES_AND_TRIGGERS "INSERT INTO voronoid_schema (version) VALUES (7);";

/* clang-format on */

static const struct {
    int64_t from;
    const char *sql;
} steps[] = {{0, first}};

static vor_status read_version(struct vor_store *store, int64_t *version, struct vor_error *err)
{
    return vor_sql_query(store, vor_sql_take_number, version, err,
                         "SELECT version FROM voronoid_schema", "");
}

vor_status vor_postgres_prepare_schema(struct vor_store *store, struct vor_error *err)
{
    int64_t found = 0, version = 0;
    vor_status made = VOR_OK;
    struct vor_error failure = {.status = VOR_OK};
    vor_status status =
        vor_sql_query(store, vor_sql_take_number, &found, err,
                      "SELECT CASE WHEN to_regclass('voronoid_schema') IS NOT NULL THEN 1"
                      " WHEN to_regclass('job') IS NULL THEN 0 ELSE -1 END",
                      "");

    if (status == VOR_OK && found < 0)
        return vor_fail(
            err, VOR_E_IO,
            "the job store: the table \"job\" of this database belongs to another program; "
            "choose an empty schema or database");
    if (found > 0)
        VOR_THEN(status, read_version(store, &version, err));
    for (size_t i = 0; i < sizeof steps / sizeof steps[0] && status == VOR_OK; i++) {
        if (version != steps[i].from)
            continue;
        made = vor_sql_run(store, steps[i].sql, &failure); /* or another daemon, meanwhile */
        status = read_version(store, &version, err);
        if (status == VOR_OK && version == steps[i].from) {
            if (err != NULL)
                *err = failure;
            return made;
        }
    }
    if (status != VOR_OK && made != VOR_OK && err != NULL)
        *err = failure; /* nor has another daemon made them meanwhile */
    if (status == VOR_OK && version != SCHEMA_VERSION)
        return vor_fail(err, VOR_E_IO,
                        "the job store has schema %lld, this version reads %d: start the version "
                        "that wrote it, or choose another schema or database",
                        (long long)version, SCHEMA_VERSION);
    return status;
}
