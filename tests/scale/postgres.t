#!/usr/bin/perl
# The store in PostgreSQL, by a real server that is started here: the conformance tests of a store's verbs, directly and through pgbouncer
# in transaction mode; and daemons on it that are killed, that find it taken, and that lose the server while a job runs.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use IO::Socket::INET;
use Test::More;
use Vt;

my ($programs) = sort { $b cmp $a } glob '/usr/lib/postgresql/*/bin' or BAIL_OUT 'PostgreSQL is not installed';
my $dir = tempdir(CLEANUP => 1);
my @as = $> == 0 ? qw(setpriv --reuid=postgres --regid=postgres --clear-groups) : (); # neither program runs as root
my ($port, $pool_port) = map { free_port() } 1 .. 2;
END { my $status = $?; server('stop', '-m', 'immediate') if -e "$dir/data/postmaster.pid"; kill 'TERM', slurped("$dir/pool.pid") if -s "$dir/pool.pid"; $? = $status }

sub free_port { return IO::Socket::INET->new(LocalAddr => '127.0.0.1', LocalPort => 0, Listen => 1)->sockport }
sub slurped { return Vt::slurp($_[0]) =~ s/\s+\z//r }

# The program as the user that may run it; its output goes to a file.
sub as_user {
    my $pid = fork // die "fork: $!";
    if (!$pid) {
        open STDOUT, '>>', "$dir/out";
        open STDERR, '>&', \*STDOUT;
        exec @as, @_ or POSIX::_exit(127);
    }
    waitpid $pid, 0;
    return $?;
}

sub server { return as_user("$programs/pg_ctl", '-D', "$dir/data", '-w', '-l', "$dir/log", @_) }
sub start_server { return server('-o', "-p $port -c listen_addresses=127.0.0.1 -c fsync=off -k $dir", 'start') }

# Of an SQL statement, what it returns.
sub ask {
    my ($database, $sql) = @_;
    open my $answer, '-|', 'psql', '-XqAt', "host=127.0.0.1 port=$port user=voronoid dbname=$database", '-c', $sql or die "psql: $!";
    local $/;
    return <$answer> =~ s/\s+\z//r;
}

chown +(getpwnam 'postgres')[2, 3], $dir if @as;
is as_user("$programs/initdb", '-D', "$dir/data", '-A', 'trust', '-U', 'voronoid', '-E', 'UTF8', '--no-sync'), 0, 'a cluster is made' or BAIL_OUT slurped("$dir/out");
is start_server(), 0, 'and serves' or BAIL_OUT slurped("$dir/out");
open my $file, '>', "$dir/pool.ini" or die "pool.ini: $!";
print $file "[databases]\n* = host=127.0.0.1 port=$port user=voronoid\n[pgbouncer]\nlisten_addr=127.0.0.1\nlisten_port=$pool_port\n"
    . "auth_type=any\npool_mode=transaction\ndefault_pool_size=2\nunix_socket_dir=\nlogfile=$dir/pool.log\npidfile=$dir/pool.pid\nserver_idle_timeout=1\n";
close $file;
is as_user('/usr/sbin/pgbouncer', '-d', "$dir/pool.ini"), 0, 'a pooler stands before it' or BAIL_OUT slurped("$dir/out");

# The verbs.
my ($build) = ($ENV{VORONOID} // 'build/release/voronoid') =~ m{^(.*)/};
my @programs = qw(unit/store_rows unit/store_queue unit/store_tenants property/store_model);
for my $way ([directly => $port], ['through pgbouncer' => $pool_port]) {
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
my ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', "$dir/other", '--store', $uri);
is $status, 75, 'a second daemon finds the store taken';
like $text, qr/another daemon uses the job store/, 'and says so';

my $long = $daemon->submit('points=2000&iterations=200', $cloud);
ok wait_until(sub { $daemon->status($long) eq 'running' }), 'a job runs';
$daemon->stop('KILL');
my $next = Vt->start(dir => $daemon->{dir}, store => "postgres:host=127.0.0.1 port=$port user=voronoid dbname=daemons", jobs => 1);
is $next->finish($long)->{status}, 'successful', 'the next daemon runs what the killed one ran';
is $next->finish($report->{jobID})->{status}, 'successful', 'and has its results';

$long = $next->submit('points=2000&iterations=300&delta=0', $cloud);
ok wait_until(sub { $next->status($long) eq 'running' }), 'while a job runs';
is server('stop', '-m', 'immediate'), 0, 'the server dies';
is $next->post('/v1/resample?points=100', $cloud, Prefer => 'respond-async')->{status}, 503, 'a submit is told to come again';
is $next->get('/readyz')->{status}, 503, 'the daemon is not ready';
is start_server(), 0, 'and comes back';
my $ended = $next->finish($long);
is $ended->{status}, 'successful', 'the job ends';
like $next->log_text, qr/"msg":"job ended","job":"$long"[^\n]*"attempt":1/, 'by its first attempt';
ok wait_until(sub { $next->get('/readyz')->{status} == 200 }), 'and the daemon is ready again';
is $next->finish($next->submit('points=100', $cloud))->{status}, 'successful', 'another job runs';

# What is refused, each in one line without the password.
ask('postgres', 'CREATE DATABASE other');
ask('other', 'CREATE TABLE job (id int)');
for my $case (
    ["postgresql://voronoid:secret-word\@127.0.0.1:$port/other", qr/table "job" of this database is another program's/],
    ["postgresql://voronoid:secret-word\@127.0.0.1:$port/none", qr/database "none" does not exist/],
    ["postgresql://voronoid:secret-word\@127.0.0.1:1/daemons", qr/Connection refused/],
    ['postgres:nonsense=1', qr/invalid connection option "nonsense"/], ['postgre:secret-word', qr/store is "postgre:...", want sqlite:PATH or postgres:URI/]
) {
    ($status, $text) = Vt::run('--listen', '127.0.0.1:0', '--data', "$dir/other", '--store', $case->[0]);
    isnt $status, 0, "$case->[0] is refused";
    like $text, $case->[1], 'with the reason';
    unlike $text, qr/secret-word/, 'and no password';
}
unlike $_->log_text, qr/secret-word/, 'nor is it in a log' for $daemon, $next;
done_testing;
