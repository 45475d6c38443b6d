#!/usr/bin/perl
# The store in PostgreSQL, by a real server that is started here: the conformance tests of a store's verbs, directly and through pgbouncer
# in transaction mode; and daemons on it that are killed, that find it taken, and that lose the server while a job runs.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support", $FindBin::Bin;
use Scale;
use Test::More;
use Vt;

ok start_postgres(), 'PostgreSQL serves' or BAIL_OUT Vt::slurp("$Scale::dir/postgres.out");
my $port = $Scale::postgres;

# The verbs.
my ($build) = ($ENV{VORONOID} // 'build/release/voronoid') =~ m{^(.*)/};
my @programs = qw(unit/store_rows unit/store_queue unit/store_tenants property/store_model);
for my $way ([directly => $port], ['through pgbouncer' => $Scale::pooler]) {
    local @ENV{qw(VT_STORE VT_POSTGRES)} = ('postgres', "host=127.0.0.1 port=$way->[1] user=voronoid");
    for my $program (@programs) {
        my $printed = `$build/tests/$program 2>&1`;
        is $?, 0, "$program holds $way->[0]" or diag $printed;
    }
}

# Daemons. The password is one that the server does not ask for.
my $uri = "postgresql://voronoid:secret-word\@127.0.0.1:$port/daemons";
ask('postgres', 'CREATE DATABASE daemons');
my $cloud = sphere_ply(4000);
my $daemon = Vt->start(store => $uri, jobs => 1);
my $report = $daemon->finish($daemon->submit('points=500', $cloud));
is $report->{status}, 'successful', 'a job runs';
is ask('daemons', "SELECT status FROM job"), 'successful', 'and stands in the database';
my ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', "$Scale::dir/other", '--store', $uri);
is $status, 75, 'a second daemon finds the store taken';
like $text, qr/another daemon is already using the job store/, 'and says so';

my $long = $daemon->submit('points=2000&iterations=200', $cloud);
ok wait_until(sub { $daemon->status($long) eq 'running' }), 'a job runs';
$daemon->stop('KILL');
ask('daemons', 'CREATE TABLE wide AS SELECT job.*, request, inputs, input_format, input_points, input_bytes, input_seconds, input_sha256, fingerprint,'
    . ' memory, engine, release, traceparent, job_text.message, coalesce(job_end.progress, 0) AS progress, metrics, problem, report_bytes, output_format,'
    . ' output_points, output_bytes, output_sha256, outputs FROM job JOIN job_text USING (seq) LEFT JOIN job_end USING (seq);'
    . ' CREATE TABLE job_blob AS SELECT seq, report FROM job_end; DROP TABLE job, job_text, job_end, job_run;'
    . ' ALTER TABLE wide RENAME TO job; ALTER TABLE job ALTER COLUMN seq SET NOT NULL,'
    . ' ALTER COLUMN seq ADD GENERATED ALWAYS AS IDENTITY (START 100); UPDATE voronoid_schema SET version = 4');
is ask('daemons', 'SELECT version, (SELECT count(*) FROM job WHERE request IS NOT NULL) FROM voronoid_schema'), '4|2', 'tables are as they were';
my $next = Vt->start(dir => $daemon->{dir}, store => "postgres:host=127.0.0.1 port=$port user=voronoid dbname=daemons", jobs => 1);
is $next->finish($long)->{status}, 'successful', 'the next daemon runs what the killed one ran, from tables of the version before';
is $next->finish($report->{jobID})->{status}, 'successful', 'and has its results';

$long = $next->submit('points=2000&iterations=300&delta=0', $cloud);
ok wait_until(sub { $next->status($long) eq 'running' }), 'while a job runs';
is stop_postgres('immediate'), 0, 'the server dies';
is $next->post('/v1/resample?points=100', $cloud, Prefer => 'respond-async')->{status}, 503, 'a submit is told to come again';
is $next->get('/readyz')->{status}, 503, 'the daemon is not ready';
ok start_postgres(), 'and comes back';
my $ended = $next->finish($long);
is $ended->{status}, 'successful', 'the job ends';
ok wait_until(sub { $next->log_text =~ /"msg":"job ended","job":"$long"[^\n]*"attempt":1/ }), 'by its first attempt';
ok wait_until(sub { $next->get('/readyz')->{status} == 200 }), 'and the daemon is ready again';
is $next->finish($next->submit('points=100', $cloud))->{status}, 'successful', 'another job runs';

# What is refused, each in one line without the password.
ask('postgres', 'CREATE DATABASE other');
ask('other', 'CREATE TABLE job (id int)');
for my $case (
    ["postgresql://voronoid:secret-word\@127.0.0.1:$port/other", qr/table "job" of this database belongs to another program/],
    ["postgresql://voronoid:secret-word\@127.0.0.1:$port/none", qr/database "none" does not exist/],
    ["postgresql://voronoid:secret-word\@127.0.0.1:1/daemons", qr/Connection refused/],
    ['postgres:nonsense=1', qr/invalid connection option "nonsense"/], ['postgre:secret-word', qr/store is "postgre:...", want sqlite:PATH or postgres:URI/]
) {
    ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', "$Scale::dir/other", '--store', $case->[0]);
    isnt $status, 0, "$case->[0] is refused";
    like $text, $case->[1], 'with the reason';
    unlike $text, qr/secret-word/, 'and no password';
}
unlike $_->log_text, qr/secret-word/, 'nor is it in a log' for $daemon, $next;
done_testing;
