#!/usr/bin/perl
# Jobs that crash the process of the engine, that never end, that take all memory: the daemon does not notice, and nobody else is
# blamed. What ran in a crash is run again with nothing beside it. And nobody is blamed for kill -9 of the daemon.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin, "$FindBin::Bin/../cli", "$FindBin::Bin/../support";
use Toy;
use JSON::PP;
use Test::More;
use Time::HiRes qw(sleep);
use Vt;

my $cloud = cloud_of(grid(5, 0, 0, 0));
my $good = '/v1/census?parts=3&pause=0.01';

# A daemon on the directory of an earlier one that has ended by itself or is ended now.
sub again {
    my ($before) = @_;
    Vt::reap(delete $before->{pid}, 20) if $before->{pid};
    return eval { Vt->start(dir => $before->{dir}, jobs => 4) };
}

sub submit {
    my ($daemon, $path) = @_;
    my $answer = $daemon->post($path, $cloud, Prefer => 'respond-async');
    is $answer->{status}, 201, "$path is accepted";
    return json($answer)->{jobID};
}

sub crashes { return scalar grep { $_->{msg} eq 'worker ended' } $_[0]->log_lines }

for my $venom (qw(fault abort leak)) {
    subtest "a poison that ends by $venom among good jobs" => sub {
        my $daemon = Vt->start(jobs => 4, 'job-memory' => 16 << 20);
        my $started = json($daemon->get('/v1/'))->{started};
        my @good = map { submit($daemon, $good) } 1 .. 4;
        my $poison = submit($daemon, "/v1/poison?venom=$venom");
        push @good, map { submit($daemon, $good) } 1 .. 4;
        my $info = $daemon->finish($poison);
        is "$info->{status}: $info->{message}", 'failed: crashed: the worker ended 2 times while it worked on this job alone', 'it fails';
        is_deeply [grep { $_ ne 'successful' } map { $daemon->finish($_)->{status} } @good], [], 'all others succeed';
        is crashes($daemon), $info->{voronoid}{attempt}, 'each of its attempts, and nothing else, has ended a worker';
        cmp_ok crashes($daemon), '<=', 3, 'once beside others at most, and twice alone';
        is $daemon->stop, 0, 'the daemon ends with 0';
    };
}

subtest 'a poison that never ends' => sub {
    my $daemon = Vt->start(jobs => 2);
    my $poison = submit($daemon, '/v1/poison?venom=spin');
    my @good = map { submit($daemon, $good) } 1 .. 4;
    is_deeply [grep { $_ ne 'successful' } map { $daemon->finish($_)->{status} } @good], [], 'others succeed beside it';
    is $daemon->get("/v1/jobs/$poison")->{status}, 200, 'it runs';
    is json($daemon->request('DELETE', "/v1/jobs/$poison"))->{status}, 'dismissed', 'and is dismissed';
    ok wait_until(sub { crashes($daemon) == 1 }, 20), 'then its worker is ended, as it does not listen';
    is $daemon->finish(submit($daemon, $good))->{status}, 'successful', 'and another takes the next job';
    is $daemon->stop, 0, 'the daemon ends with 0';
};

subtest 'readers of events are told that a job begins anew' => sub {
    my $daemon = Vt->start(jobs => 1);
    my $id = submit($daemon, '/v1/census?parts=10&pause=0.05');
    ok wait_until(sub { json($daemon->get("/v1/jobs/$id"))->{status} eq 'running' }, 20), 'it runs';
    sleep 0.2;
    my ($worker) = map { $_->{pid} } grep { $_->{msg} eq 'worker started' } $daemon->log_lines;
    kill 'KILL', $worker;
    my $events = $daemon->get("/v1/jobs/$id/events", headers => { Accept => 'application/x-ndjson' })->{content};
    my @events = lines($events);
    shift @events while @events && $events[0]{id} =~ /^1\./;
    is_deeply $events[0], { event => 'replaced', id => '2.1', data => { jobID => $id, attempt => 2, reason => 'worker-restarted' } },
        'the second attempt begins with that';
    is $events[-1]{event}, 'end', 'and the stream ends with the end';
    is_deeply [grep { $_->{id} !~ /^2\./ } @events], [], 'all between are of the second attempt';
    is json($daemon->get("/v1/jobs/$id"))->{status}, 'successful', 'which succeeds';
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
    my $daemon = Vt->start(jobs => 4);
    my @good = map { submit($daemon, '/v1/census?parts=20&pause=0.01') } 1 .. 4;
    my %attempts;
    for (1 .. 4) {
        sleep 0.1;
        my @family = family($daemon);
        cmp_ok scalar(@family), '>=', 2, 'a zygote and a worker';
        kill 'KILL', $daemon->{pid};
        $daemon = again($daemon) // die 'it does not start';
        ok wait_until(sub { !alive(@family) }, 20), 'both go with the daemon';
    }
    for my $id (@good) {
        my $info = $daemon->finish($id);
        is $info->{status}, 'successful', "$id" or diag($info->{message});
        $attempts{$id} = $info->{voronoid}{attempt};
    }
    cmp_ok((sort { $b <=> $a } values %attempts)[0], '>=', 3, 'one was killed alone more often than a job may crash alone');
    is $daemon->stop, 0, 'the daemon ends with 0';
};
done_testing;
