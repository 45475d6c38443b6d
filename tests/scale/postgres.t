#!/usr/bin/perl
# Jobs and files in PostgreSQL, by a real server that is started here: the conformance tests of a store's verbs and of blobs, directly and through pgbouncer
# in transaction mode, there with hints by a direct connection; and daemons on it that are killed, that find it taken, and that lose the server while a job runs.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support", $FindBin::Bin;
use Scale;
use Test::More;
use Vt;

ok start_postgres(), 'PostgreSQL serves' or BAIL_OUT Vt::slurp("$Scale::dir/postgres.out");
my $port = $Scale::postgres;

# The verbs, both ways at once, beside a test that needs a lock which a pooler loses.
my ($build) = ($ENV{VORONOID} // 'build/release/voronoid') =~ m{^(.*)/};
my $server = "host=127.0.0.1 port=$port user=voronoid";
my @ways = ([directly => "VT_POSTGRES='$server'"], ['through pgbouncer' => "VT_LISTEN='$server' VT_POSTGRES='" . $server =~ s/$port/$Scale::pooler/r . "'"]);
sub program { open my $out, '-|', "VT_STORE=postgres @_ 2>&1" or die "sh: $!"; return $out }
sub holds { my ($out, $what) = @_; my $printed = join '', <$out>; close $out; is $?, 0, $what or diag $printed; return }
my $crash = program('VT_BLOBS=dir', $ways[0][1], "$build/tests/unit/job_service_crash");
for my $program (qw(unit/blob_any unit/store_rows unit/store_queue unit/store_tenants property/store_model)) {
    my @out = map { program('VT_BLOBS=postgres', $_->[1], "$build/tests/$program") } @ways;
    holds($out[$_], "$program holds $ways[$_][0]") for 0, 1;
}
holds($crash, 'a worker that dies has lost nothing');

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
ask('daemons', 'UPDATE voronoid_schema SET version = 4');
($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', $daemon->{dir}, '--store', $uri);
is $status, 1, 'tables of another version are refused';
like $text, qr/the job store has schema 4, this version reads 7: start the version that wrote it, or choose/, 'in a line that says what to do';
ask('daemons', 'UPDATE voronoid_schema SET version = 7');
my $next = Vt->start(dir => $daemon->{dir}, store => "postgres:host=127.0.0.1 port=$port user=voronoid dbname=daemons", jobs => 1, 'admin-listen' => '127.0.0.1:0');
is $next->finish($long)->{status}, 'successful', 'the next daemon runs what the killed one ran';
is $next->finish($report->{jobID})->{status}, 'successful', 'and has its results';

for my $way (['dies', sub { !stop_postgres('immediate') }, \&start_postgres], ['hangs', map { my $s = $_; sub { signal_postgres($s) } } qw(STOP CONT)]) {
    $long = $next->submit('points=2000&iterations=300&delta=0', $cloud);
    ok wait_until(sub { $next->status($long) eq 'running' }), 'while a job runs';
    ok $way->[1]->(), "the server $way->[0]";
    is_problem($next->post('/v1/resample?points=100', $cloud, Prefer => 'respond-async'), 503, 'store-unavailable', 'a submit is told to come again');
    like json($next->get('/readyz'))->{detail}, qr/^--store: /, 'the daemon is not ready';
    is $next->get('/livez')->{status}, 200, 'but lives';
    ok $way->[2]->(), 'and comes back';
    is $next->finish($long)->{status}, 'successful', 'the job ends';
    ok wait_until(sub { $next->log_text =~ /"msg":"job ended","job":"$long"[^\n]*"attempt":1/ }), 'by its first attempt';
    ok wait_until(sub { $next->get('/readyz')->{status} == 200 }), 'and the daemon is ready again';
    is $next->finish($next->submit('points=100', $cloud))->{status}, 'successful', 'another job runs';
}

# The process of the server that has the daemon's lock hangs: the daemon waits for its own lock, and does not take itself for another.
my ($hung) = ask('daemons', "SELECT pid FROM pg_locks WHERE locktype = 'advisory' AND classid = 1987015279") =~ /^(\d+)$/;
kill STOP => $hung;
my $why;
ok wait_until(sub { ($why = json($next->get('/readyz'))->{detail} // '') =~ /^--store: / && !$next->metric('storage_up\{part="store"\}') }), 'is not ready';
unlike $why, qr/another daemon/, 'while its lock hangs';
kill CONT => $hung;
ok wait_until(sub { $next->get('/readyz')->{status} == 200 }), 'and is when it is free';

# The answer to the COMMIT of a job is lost, and it is made later: nobody knows of it, but it runs, with its input.
ask('postgres', 'CREATE DATABASE later');
my $relay = start_cutter(sub { 1 << 40 }, undef, $port);
my $unsure = Vt->start(store => $uri =~ s{:$port/.*}{:$relay/later}r, jobs => 1);
ask('later', 'CREATE FUNCTION wait() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN PERFORM pg_advisory_xact_lock(7); RETURN NULL; END $$;'
    . ' CREATE CONSTRAINT TRIGGER wait AFTER INSERT ON job DEFERRABLE INITIALLY DEFERRED FOR EACH ROW EXECUTE FUNCTION wait()');
open my $holder, '|-', 'psql', '-Xq', "host=127.0.0.1 port=$port user=voronoid dbname=later" or die "psql: $!";
$holder->autoflush;
print $holder "SELECT pg_advisory_lock(7) \\g /dev/null\n";
my $locks = "SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND objid = 7 AND granted =";
ok wait_until(sub { ask('later', "$locks true") }), 'a COMMIT will have to wait';
Scale::child('submit', sub { print $unsure->{http}->post("$unsure->{url}/v1/resample?points=100", { content => $cloud, headers => { Prefer => 'respond-async' } })->{status}; exec 'true' });
ok wait_until(sub { ask('later', "$locks false") }), 'it does';
Scale::end_child('cutter');
ok wait_until(sub { Vt::slurp("$Scale::dir/submit.out") eq '503' }), 'who waits for the answer learns that there is none';
close $holder;
start_cutter(sub { 1 << 40 }, $relay, $port);
ok wait_until(sub { ask('later', 'SELECT status FROM job') eq 'successful' }), 'the job runs when it is there';
$unsure->stop;

# Files as well, through the pooler, of daemons that share them.
my $files = $uri =~ s/:$port/:$Scale::pooler/r;
my $wanted = $next->post('/v1/resample?points=800', $cloud)->{content};
$next->stop;
my @daemons = map { Vt->start(store => $uri, blobs => $files, jobs => 1) } 1 .. 2;
my @ids = map { $daemons[$_ % 2]->submit('points=800', $cloud) } 1 .. 8;
is scalar(grep { $daemons[0]->finish($_)->{status} eq 'successful' } @ids), @ids, 'jobs with files in the database end well';
sub result { my ($daemon, $id, @how) = @_; return $daemon->get("/v1/jobs/$id/results/cloud", @how) }
is scalar(grep { my $id = $_; 2 == grep { result($_, $id)->{content} eq $wanted } @daemons } @ids), @ids, 'with results that both have';
is result($daemons[1], $ids[0], headers => { Range => 'bytes=100-199' })->{content}, substr($wanted, 100, 100), 'and parts of them';
$daemons[0]->request('DELETE', "/v1/jobs/$ids[0]");
ok wait_until(sub { !ask('daemons', "SELECT count(*) FROM voronoid_file WHERE key LIKE '%$ids[0]%'") }), 'the files of a deleted job are deleted';
is ask('daemons', 'SELECT count(*) FROM voronoid_piece WHERE object NOT IN (SELECT object FROM voronoid_file)'), 0, 'whole';
$_->stop('KILL') for @daemons;
ask('daemons', "INSERT INTO voronoid_file (key, size) SELECT 'keep/' || CASE WHEN n < 20 THEN '" . substr($ids[1], 0, 13) . "' ELSE '0193b5f2-7c1e' END || '-7f7a-9d3e-2a6c1f0b8e' || n || '.cloud', 0 FROM generate_series(10, 29) n");
ask('daemons', "UPDATE voronoid_piece SET data = set_byte(data, 200, 7) WHERE object = (SELECT object FROM voronoid_file WHERE key = 'keep/$ids[1].cloud')");
my $last = Vt->start(dir => $daemons[0]{dir}, store => $uri, blobs => $files);
ok result($last, $ids[2])->{content} eq $wanted, 'they outlive the daemons';
is_problem(result($last, $ids[1]), 500, 'damaged-bytes', 'bytes that are not what was written are not sent');
ok wait_until(sub { 10 == ask('daemons', "SELECT count(*) FROM voronoid_file WHERE key LIKE '%-7f7a-9d3e-2a6c1f0b8e%'") }), 'results without a job go when they are too old';
stop_postgres('immediate');
is_problem(result($last, $ids[3]), 503, 'store-unavailable', 'while the server is away a result is not to be had');
ok start_postgres(), 'the server comes back';
ok wait_until(sub { result($last, $ids[3])->{content} eq $wanted }), 'and so does the result';
ok wait_until(sub { $last->get('/readyz')->{status} == 200 }), 'the daemon is ready again';
is $last->finish($last->submit('points=100', $cloud))->{status}, 'successful', 'and runs a job';

# Daemons that share a folder; a file that nobody writes any more goes, those of others stay.
ask('postgres', 'CREATE DATABASE shared');
my %both = (store => $uri =~ s/daemons$/shared/r, blobs => "dir:$Scale::dir/shared");
my @two = map { Vt->start(%both, jobs => 1) } 1 .. 2;
my @more = map { $two[$_ % 2]->submit('points=800&iterations=100&delta=0', $cloud) } 1 .. 6;
Scale::write_file("$Scale::dir/shared/tmp/left", 'over');
push @two, Vt->start(%both, role => 'api');
ok !-e "$Scale::dir/shared/tmp/left", 'what is left over goes';
is scalar(grep { my $id = $_; 3 == grep { $_->finish($id)->{status} eq 'successful' && length result($_, $id)->{content} } @two } @more), 6, 'all have all';
$_->stop for splice @two, 0, 2;
ask('shared', 'DELETE FROM daemon');
ok wait_until(sub { ask('shared', 'SELECT count(*) FROM daemon') }), 'the one that is left, and only answers, is known to be there';
for my $case ([%both, blobs => "dir:$Scale::dir/elsewhere", qr/must be the folder that they all share/], [%both, store => $uri, qr/belong to another database of jobs/]) {
    my ($why, %with) = (pop @$case, @$case);
    ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', "$Scale::dir/other", map { ("--$_", $with{$_}) } keys %with);
    like "$status $text", qr/\A1 [^\n]*${why}[^\n]*\n\z/, 'who has other files, or other jobs, is refused';
}

# What is refused, each in one line without the password.
ask('postgres', 'CREATE DATABASE other');
ask('other', 'CREATE TABLE job (id int)');
Scale::write_file("$Scale::dir/data/pg_hba.conf", "host all locked all scram-sha-256\n" . Vt::slurp("$Scale::dir/data/pg_hba.conf"));
ask('postgres', $_) for "CREATE ROLE locked LOGIN PASSWORD 'another-word'", 'SELECT pg_reload_conf()';
for my $case (
    ["postgresql://voronoid:secret-word\@127.0.0.1:$port/other", qr/table "job" of this database belongs to another program/],
    ["postgresql://voronoid:secret-word\@127.0.0.1:$port/none", qr/database "none" does not exist/],
    ["postgresql://locked:secret-word\@127.0.0.1:$port/daemons", qr/password authentication failed for user "locked"/],
    ["postgresql://voronoid:secret-word\@127.0.0.1:1/daemons", qr/Connection refused/],
    ['postgres:nonsense=1', qr/invalid connection option "nonsense"/], ['postgre:secret-word', qr/is "postgre:...", want .*or postgres:URI/],
    map { [$_, qr/malformed/] } 'postgresql://a:secret-word@[host', 'postgresql://a:secret-word%4@h/b', 'postgres:password=x secret-word'
) {
    for my $option (qw(--store --blobs)) {
        my $why = $case->[1];
        next if $option eq '--blobs' && $case->[0] =~ /other$/; # files stand beside any other table
        ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', "$Scale::dir/other", $option, $case->[0]);
        is $status, 1, "$option $case->[0] is refused";
        like $text, qr/\A[^\n]*${why}[^\n]*\n\z/, 'with the reason in a line';
        unlike $text, qr/secret-word/, 'and no password';
    }
}
unlike $_->log_text, qr/secret-word/, 'nor is it in a log' for $daemon, $next, @daemons, $last, @two;
done_testing;
