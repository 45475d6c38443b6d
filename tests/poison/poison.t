#!/usr/bin/perl
# Jobs that crash the process of the engine, that never end, that take all memory: the daemon does not notice, and nobody else is
# blamed. What ran in a crash is run again with nothing beside it. And nobody is blamed for kill -9 of the daemon. The binary is
# the product with processes that do so (rows.h).
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
BEGIN { $ENV{VORONOID} = 'build/release/tests/poison/voronoid' }
use JSON::PP;
use Test::More;
use Vt;

my $cloud = sphere_ply(300);
my $good = '/v1/resample?points=100&iterations=3&polish=5';
my $endless = '/v1/resample?points=4000&iterations=10000&polish=0'; # until it is stopped
my $large = sphere_ply(20000);

sub submit {
    my ($daemon, $path, $body) = @_;
    my $answer = $daemon->post($path, $body // $cloud, Prefer => 'respond-async');
    is $answer->{status}, 201, "$path is accepted" or die $answer->{content};
    return json($answer)->{jobID};
}

sub crashes { return scalar grep { $_->{msg} eq 'worker ended' } $_[0]->log_lines }

# Waits until a job runs for the n-th time.
sub runs {
    my ($daemon, $id, $attempt) = @_;
    return ok wait_until(
        sub {
            my $info = json($daemon->get("/v1/jobs/$id"));
            $info->{status} eq 'running' && $info->{voronoid}{attempt} == $attempt;
        }, 60), "$id runs for time $attempt";
}

for my $poison (qw(fault abort leak)) {
    subtest "a poison that ends by $poison among good jobs" => sub {
        my $daemon = Vt->start(jobs => 4, 'job-memory' => 16 << 20);
        my @good = map { submit($daemon, $good) } 1 .. 4;
        my $id = submit($daemon, "/v1/$poison");
        push @good, map { submit($daemon, $good) } 1 .. 4;
        my $info = $daemon->finish($id);
        is "$info->{status}: $info->{message}", 'failed: crashed: the worker process crashed 2 times while it ran only this job', 'it fails';
        is_deeply [grep { $_ ne 'successful' } map { $daemon->finish($_)->{status} } @good], [], 'all others succeed';
        is crashes($daemon), $info->{voronoid}{attempt}, 'each of its attempts, and nothing else, has ended a worker';
        cmp_ok crashes($daemon), '<=', 3, 'once beside others at most, and twice alone';
        is $daemon->stop, 0, 'the daemon ends with 0';
    };
}

subtest 'a poison that never ends' => sub {
    my $daemon = Vt->start(jobs => 2);
    my $poison = submit($daemon, '/v1/spin');
    my @good = map { submit($daemon, $good) } 1 .. 4;
    is_deeply [grep { $_ ne 'successful' } map { $daemon->finish($_)->{status} } @good], [], 'others succeed beside it';
    is $daemon->status($poison), 'running', 'it runs';
    is json($daemon->request('DELETE', "/v1/jobs/$poison"))->{status}, 'dismissed', 'and is dismissed';
    ok wait_until(sub { crashes($daemon) == 1 }, 20), 'then its worker is ended, as it does not listen';
    is $daemon->finish(submit($daemon, $good))->{status}, 'successful', 'and another takes the next job';
    is $daemon->stop, 0, 'the daemon ends with 0';
};

subtest 'readers of events are told that a job begins anew' => sub {
    my $daemon = Vt->start(jobs => 1);
    my $id = submit($daemon, $endless, $large);
    runs($daemon, $id, 1);
    kill 'KILL', map { $_->{pid} } grep { $_->{msg} eq 'worker started' } $daemon->log_lines;
    runs($daemon, $id, 2);
    is $daemon->request('POST', "/v1/jobs/$id/stop")->{status}, 202, 'the second attempt is stopped';
    my $events = $daemon->get("/v1/jobs/$id/events", headers => { Accept => 'application/x-ndjson' })->{content};
    my @events = map { decode_json($_) } split /\n/, $events;
    shift @events while @events && $events[0]{id} =~ /^1\./;
    is_deeply $events[0], { event => 'replaced', id => '2.1', data => { jobID => $id, attempt => 2, reason => 'worker-restarted' } },
        'the second attempt begins with that';
    is $events[-1]{event}, 'end', 'and the stream ends with the end';
    is_deeply [grep { $_->{id} !~ /^2\./ } @events], [], 'all between are of the second attempt';
    is $daemon->status($id), 'successful', 'which succeeds';
    is $daemon->stop, 0, 'the daemon ends with 0';
};

# The processes of a daemon: the zygote, and its children.
sub family {
    my ($daemon) = @_;
    my ($zygote) = split ' ', `pgrep -P $daemon->{pid}`;
    return ($zygote, split ' ', `pgrep -P $zygote`);
}

sub alive { return grep { -d "/proc/$_" && Vt::slurp("/proc/$_/stat") !~ /\) Z / } @_ }

subtest 'nobody is blamed for kill -9, and no process is left' => sub {
    my $daemon = Vt->start(jobs => 2);
    my @jobs = map { submit($daemon, $endless, $large) } 1 .. 2;
    for my $life (1 .. 4) { # more often than a job may crash alone
        runs($daemon, $_, $life) for @jobs;
        my @family = family($daemon);
        cmp_ok scalar(@family), '>=', 2, 'a zygote and a worker';
        is $daemon->stop('KILL'), 'signal 9', 'the daemon is killed';
        $daemon = Vt->start(dir => $daemon->{dir}, jobs => 2);
        ok wait_until(sub { !alive(@family) }, 20), 'both go with the daemon';
    }
    for my $id (@jobs) {
        runs($daemon, $id, 5);
        $daemon->request('POST', "/v1/jobs/$id/stop");
        is $daemon->finish($id)->{status}, 'successful', 'stopped in its fifth life, the job succeeds';
    }
    is $daemon->stop, 0, 'the daemon ends with 0';
};
done_testing;
