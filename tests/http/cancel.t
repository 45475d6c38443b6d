#!/usr/bin/perl
# Ending a job before its time: DELETE, stop, a caller who leaves; a full queue; many at once.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start(jobs => 1, queue => 2);
my $cloud = sphere_ply(4000);
my $long = 'points=4000&iterations=10000';

sub running { my ($id) = @_; return wait_until(sub { $daemon->status($id) eq 'running' }) }
sub iterating {
    my ($id) = @_;
    return wait_until(
        sub { (json($daemon->get("/v1/jobs/$id"))->{voronoid}{metrics} // {})->{iteration} });
}

# DELETE of a running and of a waiting job.
my $id = $daemon->submit($long, $cloud);
ok running($id), 'a job runs';
is_problem($daemon->get("/v1/jobs/$id/results/cloud"), 404, 'result-not-ready',
    'its result is not ready');
is_problem($daemon->get("/v1/jobs/$id/results"), 404, 'result-not-ready', 'nor are its results');
my @monitors = grep { $_->{rel} eq 'monitor' } @{ json($daemon->get("/v1/jobs/$id"))->{links} };
is scalar(@monitors), 2, 'its status can be monitored in two ways';
my $waiting = $daemon->submit('points=50&iterations=1', $cloud);
is $daemon->status($waiting), 'accepted', 'another one waits';
is_problem($daemon->request('POST', "/v1/jobs/$waiting/stop"), 409, 'not-running',
    'a waiting job cannot be stopped');
is json($daemon->request('DELETE', "/v1/jobs/$waiting"))->{status}, 'dismissed',
    'but dismissed';
is $daemon->status($waiting), 'dismissed', 'and stays so';
my $gone = json($daemon->request('DELETE', "/v1/jobs/$id"));
is $gone->{status}, 'dismissed', 'a running job is dismissed at once';
is_problem($daemon->get("/v1/jobs/$id/results/cloud"), 404, 'result-not-available',
    'a dismissed job has no result');
is_problem($daemon->request('POST', "/v1/jobs/$id/stop"), 409, 'not-running',
    'nor can it be stopped');
is $daemon->finish($daemon->submit('points=50&iterations=1', $cloud))->{status}, 'successful',
    'the next job has its place';

# stop.
$id = $daemon->submit($long, $cloud);
ok iterating($id), 'a job iterates';
my $stopped = $daemon->request('POST', "/v1/jobs/$id/stop");
is $stopped->{status}, 202, 'stop answers 202';
is $daemon->finish($id)->{status}, 'successful', 'a stopped job is successful';
is json($daemon->get("/v1/jobs/$id/results/report"))->{stopped}, 'stopped', 'its report says stopped';
like $daemon->get("/v1/jobs/$id/results/cloud")->{content}, qr/^element vertex 4000$/m,
    'its cloud is whole';

# A caller who leaves, waiting and queued; one who half-closes has left as well.
my $left = 0;
for my $how ('close', 'shutdown') {
    my $socket = $daemon->connect;
    my %before = map { $_->{jobID} => 1 } @{ json($daemon->get('/v1/jobs?limit=100'))->{jobs} };
    $socket->print("POST /v1/resample?$long HTTP/1.1\r\nHost: localhost\r\nContent-Length: "
            . length($cloud) . "\r\n\r\n$cloud");
    $socket->flush;
    my $new = wait_until(
        sub { (grep { !$before{$_} } map { $_->{jobID} } @{ json($daemon->get('/v1/jobs'))->{jobs} })[0] });
    ok running($new), "$how: the job of a synchronous caller runs";
    $how eq 'close' ? close $socket : shutdown $socket, 1;
    ok wait_until(sub { $daemon->status($new) eq 'dismissed' }), "$how: it ends when the caller leaves";
    $left++;
    ok wait_until(sub { $left == grep { ($_->{status} // '') eq '499' } $daemon->log_lines }),
        "$how: the log says 499";
}

# A full queue.
my @jobs = map { $daemon->submit($long, $cloud) } 1;
ok running($jobs[0]), 'one job runs';
push @jobs, map { $daemon->submit($long, $cloud) } 1 .. 2;
my $full = $daemon->post("/v1/resample?$long", $cloud);
is_problem($full, 429, 'queue-full', 'a queue of two takes two');
like $full->{headers}{'retry-after'}, qr/^[1-9][0-9]*$/, 'Retry-After is a whole number';
is json($full)->{queueDepth}, 2, 'the depth of the queue is told';
my $early = $daemon->raw("POST /v1/resample?points=5 HTTP/1.1\r\nHost: localhost\r\n"
        . "Content-Length: 1000000\r\n\r\n");
like $early, qr{\AHTTP/1\.1 429 }, 'a full queue is told before the body is sent';
is $daemon->get('/readyz')->{status}, 200, 'a full queue is not un-ready';
my @positions = map { json($daemon->get("/v1/jobs/$_"))->{voronoid}{queuePosition} } @jobs[1, 2];
is_deeply \@positions, [0, 1], 'waiting jobs know their places';
is json($daemon->request('DELETE', "/v1/jobs/$_"))->{status}, 'dismissed', "job dismissed" for @jobs;
is $daemon->stop, 0, 'the daemon ends with 0';

# Many at once.
$daemon = Vt->start(jobs => 2);
my @children;
for my $child (1 .. 6) {
    pipe my $from, my $to or die "pipe: $!";
    my $pid = fork // die "fork: $!";
    if (!$pid) {
        my @digests = map {
            my $seed = $_;
            my $answer = HTTP::Tiny->new(timeout => $Vt::PATIENCE)->post(
                "$daemon->{url}/v1/resample?points=200&iterations=3&seed=$seed", { content => $cloud });
            "$answer->{status} $seed $answer->{headers}{etag}";
        } 1 .. 4;
        print {$to} map { "$_\n" } @digests;
        close $to;
        POSIX::_exit(0);
    }
    close $to;
    push @children, [$pid, $from];
}
my %lines;
for my $child (@children) {
    my ($pid, $from) = @$child;
    $lines{$_}++ while <$from>;
    waitpid $pid, 0;
}
is scalar(keys %lines), 4, 'parallel clients get the same bytes for the same seed';
is scalar(grep { /^200 / } keys %lines), 4, 'and no errors';
is_deeply [values %lines], [(6) x 4], 'each of them';
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
