/** The store of a database with SQL, and its tables; the verbs are the same for every engine. Only
 *  files of the store include this. */
#ifndef VOR_SERVER_STORE_SQL_VERBS_H
#define VOR_SERVER_STORE_SQL_VERBS_H

#include "server/store/sql.h"

/** The tables of jobs, for the schema of every engine, which says how the key is written. A row of
 *  job changes with the state of its job, and has what queues and lists go by; what else is known
 * of a job stands beside it, written once: when it is accepted (job_text), and when it is over
 *  (job_end). job_run has the progress of jobs that are not over. Wide rows that change leave wide
 *  dead versions behind. Of job, unique is said of its id, and rest ends the statement. */
#define VOR_SQL_TABLE_OF_JOB(key, unique, rest)                                                    \
    "CREATE TABLE job (seq " key ", created bigint NOT NULL,"                                      \
    " started bigint NOT NULL DEFAULT 0, updated bigint NOT NULL,"                                 \
    " finished bigint NOT NULL DEFAULT 0, expires bigint NOT NULL DEFAULT 0,"                      \
    " kept bigint NOT NULL DEFAULT 0," /* bytes of inputs */                                       \
    " held bigint NOT NULL DEFAULT 0," /* bytes of results */                                      \
    " turn bigint NOT NULL DEFAULT 0, decoded bigint NOT NULL DEFAULT 0,"                          \
    " attempt integer NOT NULL DEFAULT 0, crashes integer NOT NULL DEFAULT 0,"                     \
    " expired integer NOT NULL DEFAULT 0, alone integer NOT NULL DEFAULT 0,"                       \
    " stop integer NOT NULL DEFAULT 0, id text NOT NULL" unique ", process_id text NOT NULL,"      \
    " status text NOT NULL"                                                                        \
    "  CHECK (status IN ('accepted','running','successful','failed','dismissed')),"                \
    " name text NOT NULL DEFAULT '', principal text NOT NULL DEFAULT '', idem_key text,"           \
    " owner text NOT NULL DEFAULT ''" rest ";"
#define VOR_SQL_TABLES_BESIDE(key)                                                                 \
    "CREATE TABLE job_text (seq " key ", input_format bigint NOT NULL,"                            \
    " input_points bigint NOT NULL, input_bytes bigint NOT NULL, memory bigint NOT NULL,"          \
    " release bigint NOT NULL, input_seconds double precision NOT NULL, input_sha256 text NOT "    \
    "NULL,"                                                                                        \
    " fingerprint text NOT NULL, traceparent text NOT NULL, engine text NOT NULL,"                 \
    " message text NOT NULL, request text NOT NULL, inputs text);" /* beside the main one */       \
    "CREATE TABLE job_end (seq " key ", progress bigint NOT NULL, output_format bigint NOT NULL,"  \
    " output_points bigint NOT NULL, output_bytes bigint NOT NULL, report_bytes bigint NOT NULL,"  \
    " output_sha256 text NOT NULL, message text NOT NULL, metrics text, problem text,"             \
    " outputs text, report text);"                                                                 \
    "CREATE TABLE job_run (seq " key ", progress bigint NOT NULL, updated bigint NOT NULL,"        \
    " metrics text);"

/** Their columns but seq. */
#define VOR_SQL_JOB                                                                                \
    "created, started, updated, finished, expires, kept, held, turn, decoded, attempt, crashes,"   \
    " expired, alone, stop, id, process_id, status, name, principal, idem_key, owner"
#define VOR_SQL_TEXT                                                                               \
    "input_format, input_points, input_bytes, memory, release, input_seconds, input_sha256,"       \
    " fingerprint, traceparent, engine, message, request, inputs"
#define VOR_SQL_END                                                                                \
    "progress, output_format, output_points, output_bytes, report_bytes, output_sha256, message,"  \
    " metrics, problem, outputs, report"

/** The indexes that every engine has. */
#define VOR_SQL_INDEXES                                                                            \
    "CREATE INDEX job_ready ON job (turn, seq) WHERE status = 'accepted';"                         \
    "CREATE INDEX job_turn ON job (principal, turn) WHERE status = 'accepted';"                    \
    "CREATE INDEX job_status ON job (status, seq) WHERE expired = 0;"                              \
    "CREATE INDEX job_expires ON job (expires) WHERE expires > 0;"                                 \
    "CREATE INDEX job_kept ON job (finished, seq, kept) WHERE kept > 0;"                           \
    "CREATE INDEX job_held ON job (finished, seq, held) WHERE held > 0;"

/** Give an empty database, or schema of one, its tables, in one transaction.
 *
 *  @retval VOR_E_IO it is of another version or program (message: which), or refuses */
VOR_NODISCARD vor_status vor_sqlite_prepare_schema(struct vor_store *store, struct vor_error *err);
VOR_NODISCARD vor_status vor_postgres_prepare_schema(struct vor_store *store,
                                                     struct vor_error *err);

#endif
