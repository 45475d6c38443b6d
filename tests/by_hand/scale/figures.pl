#!/usr/bin/perl
# usage: figures.pl [PART...]: what several daemons on one PostgreSQL and one S3 reach, with real servers that are started here; parts:
# churn, finish, workers, large, events. Needs what `make scale` installs, and build/release/tests/by_hand/scale/churn for churn.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", "$FindBin::Bin/../../scale";
use POSIX ();
use Scale;
use Time::HiRes qw(time sleep);
use Vt;

my %want = map { $_ => 1 } @ARGV ? @ARGV : qw(churn finish workers large events);
my $cloud = sphere_ply(4000);
$| = 1;
start_postgres() or die Vt::slurp("$Scale::dir/postgres.out");

# Jobs beside an idle transaction that sees what was there before them: versions of rows pile up.
if ($want{churn}) {
    my $count = $ENV{VT_CHURN} //= 10_000;
    local @ENV{qw(VT_STORE VT_POSTGRES CK_FORK CK_DEFAULT_TIMEOUT)} = ('postgres', "host=127.0.0.1 port=$Scale::postgres user=voronoid", 'no', 0);
    ask('postgres', 'CREATE DATABASE churn');
    { local $ENV{VT_CHURN} = 1; `build/release/tests/by_hand/scale/churn` }
    my $sizes = "SELECT pg_table_size('job'), (SELECT sum(pg_column_size(job.*)) FROM job), pg_table_size('round'), pg_table_size('ledger')";
    open my $idle, '|-', 'psql', '-Xq', "host=127.0.0.1 port=$Scale::postgres user=voronoid dbname=churn" or die "psql: $!";
    $idle->autoflush;
    print $idle "BEGIN ISOLATION LEVEL REPEATABLE READ; SELECT count(*) AS before FROM job;\n";
    sleep 1;
    my $began = time;
    print "churn: $count jobs\n", grep { /^#/ } `build/release/tests/by_hand/scale/churn`;
    printf "  %.0f s; bytes of job, of its live rows, of round, of ledger: %s\n", time - $began, ask('churn', $sizes);
    close $idle;
    ask('churn', 'VACUUM');
    print '  after that transaction and a vacuum: ', ask('churn', $sizes), "\n";
    print '  of job, free for what comes: ', ask('churn', 'CREATE EXTENSION IF NOT EXISTS pg_freespacemap; SELECT sum(avail) FROM pg_freespace(\'job\')'), "\n";
}
exit unless grep { $want{$_} } qw(finish workers large events);

start_swift() or die Vt::slurp("$Scale::dir/proxy.out");
ask('postgres', 'CREATE DATABASE daemons');
my %place = (store => "postgresql://voronoid\@127.0.0.1:$Scale::postgres/daemons", blobs => "s3:http://127.0.0.1:$Scale::swift{proxy}/bucket");
my @api = map { Vt->start(%place, role => 'api') } 1 .. 2;

# PostgreSQL stops for 20 s (and for 45 s, longer than the lease) while a job runs that ends meanwhile.
for my $away ($want{finish} ? (20, 45) : ()) {
    my @workers = map { Vt->start(%place, role => 'worker', jobs => 1) } 1 .. 2;
    my $id = $api[0]->submit('points=2000&iterations=150&delta=0', $cloud);
    wait_until(sub { $api[0]->status($id) eq 'running' });
    stop_postgres('immediate');
    sleep $away;
    start_postgres();
    my $status = wait_until(sub { my $s = eval { $api[0]->status($id) } // ''; $s eq 'successful' || $s eq 'failed' ? $s : undef });
    my $started = () = join('', map { $_->log_text } @workers) =~ /"msg":"job started","job":"$id"/g;
    printf "finish: PostgreSQL away for %d s: %s, started %d times, attempt %s\n", $away, $status, $started,
        ask('daemons', "SELECT attempt FROM job WHERE id = '$id'");
    $_->stop for @workers;
}

# The same jobs by one worker and by two, of one thread each.
if ($want{workers}) {
    my @rates;
    for my $count (1, 2) {
        my @workers = map { Vt->start(%place, role => 'worker', jobs => 1, threads => 1) } 1 .. $count;
        my $began = time;
        my @ids = map { $api[$_ % 2]->submit('points=2000&iterations=60&delta=0', $cloud) } 1 .. 24;
        wait_until(sub { ask('daemons', "SELECT count(*) FROM job WHERE status IN ('accepted', 'running')") eq '0' });
        push @rates, @ids / (time - $began);
        $_->stop for @workers;
    }
    printf "workers: %.2f jobs/s by one, %.2f by two: %.2f x\n", @rates, $rates[1] / $rates[0];
}

# The first byte of a large file from a daemon that has no copy, and from the same daemon again.
if ($want{large}) {
    my $padded = $cloud =~ s/(?=^end_header)/element padding 1\nproperty list int uchar bytes\n/mr . pack('l<', 64 << 20) . 'x' x (64 << 20);
    my $id = $api[0]->submit('points=100', $padded);
    my @seconds = map { `curl -sS -o /dev/null -w '%{time_starttransfer} of %{time_total}' $api[1]{url}/v1/jobs/$id/input` } 1 .. 2;
    print "large: first byte of 64 MiB after $seconds[0] s, again $seconds[1] s\n";
    $api[0]->request('DELETE', "/v1/jobs/$id");
}

# Jobs write events; readers of other daemons are cut at random and go on from the last one.
if ($want{events}) {
    my $worker = Vt->start(%place, role => 'worker', jobs => 8, threads => 1);
    my @ids = map { $api[0]->submit('points=2000&iterations=2000&delta=0&seed=' . $_, $cloud) } 1 .. 8;
    my @children;
    for my $reader (1 .. 20) {
        my $pid = fork // die "fork: $!";
        push @children, $pid;
        next if $pid;
        srand $reader;
        my ($id, $last, $bad, $seen, $cuts, $over) = ($ids[$reader % 8], '', 0, 0, 0, 0);
        while (!$over) {
            my $stream = $api[rand 2]->events("/v1/jobs/$id/events", $last ? (headers => { 'Last-Event-ID' => $last }) : ());
            my $left = 1 + int rand 40;
            while ($left-- > 0 && (my $event = $stream->next_event)) {
                $over ||= ($event->{event} // '') eq 'end' || ($event->{data} // '') =~ /"status":"successful"/;
                next unless $event->{id};
                my ($number) = $event->{id} =~ /\.(\d+)$/;
                my ($before) = $last =~ /\.(\d+)$/;
                $bad++ if defined $before && $number <= $before;
                ($last, $seen) = ($event->{id}, $seen + 1);
            }
            $cuts++;
        }
        print "events: reader $reader of $id saw $seen, cut $cuts times, $bad out of order or twice, last $last\n";
        POSIX::_exit($bad ? 1 : 0);
    }
    my $failed = 0;
    for my $pid (@children) { waitpid $pid, 0; $failed += $? != 0 }
    print "events: $failed of 20 readers saw one twice or out of order; stored: ", ask('daemons', 'SELECT count(*), sum(length(data)) FROM event'), "\n";
}
