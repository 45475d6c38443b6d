#!/usr/bin/perl
# The long poll of events: what has happened is answered at once, nothing is waited for, for so long; no event is lost between polls.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Time::HiRes qw(time);
use Vt;

use constant LONG => 600; # seconds that a poll may wait, and more than anything is waited for here

my $daemon = Vt->start(streams => 1, jobs => 1, 'drain-timeout' => 0, 'admin-listen' => '127.0.0.1:0');
my $cloud = sphere_ply(2000);
my $nobody = '0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11';

sub path { my ($jobs, $last) = @_; return '/v1/events?jobs=' . join(',', @$jobs) . (defined $last ? "&lastEventId=$last" : '') }

# {seconds, status, applied, lines}
sub poll {
    my ($path, $wait, %more) = @_;
    my $begin = time;
    my $answer = $daemon->get($path, headers => { Prefer => "wait=$wait", Accept => 'application/x-ndjson', %more });
    return { seconds => time - $begin, status => $answer->{status}, applied => $answer->{headers}{'preference-applied'},
        type => $answer->{headers}{'content-type'}, text => $answer->{content} // '', lines => [map { json($_) } split /\n/, $answer->{content} // ''] };
}

# Of one that is over and one that is none everything comes at once.
my $over = $daemon->submit('points=200&iterations=8&polish=0', $cloud);
$daemon->finish($over);
my $all = poll(path([$over, $nobody], '0.0,0.0'), LONG);
is "$all->{status} $all->{applied} $all->{type}", '200 wait=' . LONG . ' application/x-ndjson',
    'a poll is answered with lines, and says that it would wait longer than this test does';
is_deeply [map { $_->{event} } @{ $all->{lines} }[0, -2, -1]], [qw(status end unknown)], 'all that has happened, to the end';
is_deeply [map { $_->{data}{iteration} } grep { $_->{event} eq 'progress' } @{ $all->{lines} }],
    [map { $_->{iteration} } @{ json($daemon->get("/v1/jobs/$over/trace"))->{records} }], 'with every record';
my $end = $all->{lines}[-1]{id};
is poll(path([$over, $nobody], $end), LONG)->{status}, 204, 'behind the end there is nothing to wait for';
is poll("/v1/jobs/$over/events", LONG)->{lines}[-1]{event}, 'end', 'the events of one job can be polled as well';

# A job that runs tells its records from poll to poll: each once, none left out.
my $runs = $daemon->submit('points=2000&iterations=10000&delta=0&polish=0', $cloud);
my $waits = $daemon->submit('points=100&iterations=5', $cloud);
my ($last, @told) = ('0.0,0.0');
while (@told < 20) {
    my $answer = poll(path([$runs, $waits], $last), LONG);
    last if $answer->{status} != 200;
    push @told, map { $_->{data}{iteration} } grep { $_->{event} eq 'progress' } @{ $answer->{lines} };
    $last = $answer->{lines}[-1]{id} if @{ $answer->{lines} };
}
is_deeply \@told, [map { $_->{iteration} } @{ json($daemon->get("/v1/jobs/$runs/trace"))->{records} }[0 .. $#told]],
    'from poll to poll every record comes, each once';
my $sse = $daemon->get(path([$runs], '0.0'), headers => { Prefer => 'wait=5', Accept => 'text/event-stream' });
like $sse->{content}, qr/\Aid: 1\.1\nevent: status\ndata: \{.*\n\n\z/s, 'or as text/event-stream';

# That points have moved is told, and ends no poll: what happens besides does.
my $moved;
for (my $at = '1.1'; !$moved;) {
    my @lines = @{ poll("/v1/jobs/$runs/events?lastEventId=$at&preview=100", LONG)->{lines} } or last;
    ($moved) = grep { $_->{event} eq 'preview' } @lines;
    ($at) = map { $_->{id} } grep { $_->{id} } reverse @lines;
    $moved = undef, last if !defined $at;
}
is $moved && $moved->{data}{jobID}, $runs, 'that points have moved is told as well, and never alone';

# Where nothing happens it waits, for so long.
my $quiet = poll("/v1/jobs/$waits/events", 0)->{lines}[-1]{id};
my $nothing = poll("/v1/jobs/$waits/events?lastEventId=$quiet", 1);
is "$nothing->{status} $nothing->{applied} [$nothing->{text}]", '200 wait=1 []', 'where nothing happens the answer has no line';
cmp_ok $nothing->{seconds}, '>', 0.9, 'after as many seconds as were asked for';
my $now = poll(path([$waits], $quiet), 0);
is "$now->{status} $now->{applied} [$now->{text}]", '200 wait=0 []', 'wait=0 waits for nothing';

# It counts as no stream: the one that there may be is open.
my $stream = $daemon->events("/v1/jobs/$runs/events");
$stream->next_event;
my $socket = $daemon->connect;
print $socket 'GET ' . path([$waits, $nobody], "$quiet,end") . " HTTP/1.1\r\nHost: 127.0.0.1\r\nPrefer: wait=@{[LONG]}\r\nConnection: close\r\n\r\n";
ok $daemon->wait_asleep(2), 'a poll waits beside a stream';
is $daemon->request('DELETE', "/v1/jobs/$waits")->{status}, 200, 'what is waited for happens';
my $woken = Vt::read_all($socket);
like $woken, qr{\AHTTP/1\.1 200 .*^event: end\ndata: [^\n]*"dismissed"}ms, 'and is answered, where there are as many streams as may be';
$stream->close;

# What is wrong with a stream is wrong with a poll (what a key may see: events_many.t).
is_problem $daemon->get($_, headers => { Prefer => 'wait=5' }), 400, 'invalid-query-parameter-value', "$_ is refused"
    for '/v1/events', "/v1/events?jobs=1", path([$over], 'never'), "/v1/jobs/$over/events?lastEventId=x", path([$over]) . '&preview=0';
is_problem $daemon->get("/v1/jobs/$nobody/events", headers => { Prefer => 'wait=5' }), 404, 'no-such-job', 'a job that is none';

# The daemon's end is not waited for.
$socket = $daemon->connect;
my $queued = $daemon->submit('points=100&iterations=5', $cloud);
$last = poll("/v1/jobs/$queued/events", 0)->{lines}[-1]{id};
print $socket "GET /v1/jobs/$queued/events?lastEventId=$last HTTP/1.1\r\nHost: 127.0.0.1\r\nPrefer: wait=@{[LONG]}\r\n\r\n";
ok $daemon->wait_asleep(1), 'another poll waits';
is $daemon->stop, 0, 'a daemon that has polls waiting ends with 0';
like Vt::read_all($socket), qr{\AHTTP/1\.1 200 }, 'and answers them';
done_testing;
