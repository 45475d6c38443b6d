#!/usr/bin/perl
# Event streams: order, replay, end, heartbeats, the limit, and the whole job as one stream.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Time::HiRes qw(time);
use Vt;

my $daemon = Vt->start(heartbeat => 1, streams => 3, jobs => 1);
my $cloud = sphere_ply(3000);
my $stream_of = { Accept => 'text/event-stream' };

sub number { return (split /\./, $_[0]{id})[1] }
sub never_falls {
    my @values = @_;
    return !grep { $values[$_] < $values[$_ - 1] } 1 .. $#values;
}

# A job followed from its beginning to its end.
my $id = $daemon->submit('points=500&iterations=30&polish=0', $cloud);
my $stream = $daemon->events("/v1/jobs/$id/events", headers => $stream_of);
like $stream->{head}, qr{\AHTTP/1\.1 200 }, 'a stream is a 200';
like $stream->{head}, qr{^Content-Type: text/event-stream\r$}m, 'of the right type';
like $stream->{head}, qr{^X-Accel-Buffering: no\r$}m, 'that no proxy may buffer';
like $stream->{head}, qr{^Cache-Control: no-store\r$}m, 'nor store';
is $stream->next_block->{retry}, 2000, 'it begins with retry: 2000';
my @events = $stream->all;
ok $stream->{whole}, 'and ends in good order';
is $events[0]{event}, 'status', 'the first event is a status';
my $first = json($events[0]{data});
is $first->{jobID}, $id, 'a whole statusInfo';
ok ref $first->{links}, 'with links';
is $events[-1]{event}, 'end', 'the last event is the end';
my $end = json($events[-1]{data});
is $end->{status}, 'successful', 'the end has the status';
is $end->{href}, "$daemon->{url}/v1/jobs/$id/results/cloud", 'and the address of the result';
is_deeply $end->{outputs}, { map { $_ => "$daemon->{url}/v1/jobs/$id/results/$_" } qw(cloud report) },
    'and those of all outputs';
is $end->{report}, $end->{outputs}{report}, 'the report is one of them';
is scalar(grep { $_->{event} eq 'end' } @events), 1, 'there is one end';
ok never_falls(map { number($_) } @events), 'numbers never fall';
ok !(grep { $_->{id} !~ /^1\.[1-9][0-9]*$/ } @events), 'ids are ATTEMPT.NUMBER';
my @progress = map { json($_->{data}) } grep { $_->{event} eq 'progress' } @events;
cmp_ok scalar(@progress), '>', 0, 'there is progress';
is_deeply [sort keys %{ $progress[0] }],
    [sort qw(jobID attempt stage iteration maxIterations polish maxPolish delta sigma epsilon energy
            max_move held seconds run_stage step of ahead best quality angle mse progress eta)], 'with every member';
is $progress[-1]{iteration}, 30, 'the last iteration is among them';
is $progress[0]{maxIterations}, 30, 'it tells how many there may be';
is $progress[0]{maxPolish}, 0, 'and how many steps of the polish';
is $progress[-1]{quality}, 0, 'no triangles join its points';
ok never_falls(map { $_->{progress} } @progress), 'progress never falls';
is scalar(grep { $_->{best}{delta} > $_->{delta} } @progress), 0, 'the best is as even as any';
my $report = json($daemon->get("/v1/jobs/$id/results/report"));
is_deeply { map { $_ => $progress[-1]{best}{$_} } qw(delta sigma epsilon) }, { map { $_ => $report->{$_} } qw(delta sigma epsilon) },
    'the last best is what the report says';

# Replay.
my @all = $daemon->events("/v1/jobs/$id/events", headers => { 'Last-Event-ID' => '1.1' })->all;
is_deeply [map { number($_) } @all], [2 .. number($all[-1])],
    'after Last-Event-ID every later event comes, each once';
my %iterations = map { json($_->{data})->{iteration} => 1 } grep { $_->{event} eq 'progress' } @all;
is_deeply [sort { $a <=> $b } keys %iterations], [0 .. 30], 'every iteration among them';
my $middle = $all[@all / 2]{id};
my @rest = $daemon->events("/v1/jobs/$id/events?lastEventId=$middle", headers => $stream_of)->all;
is number($rest[0]), 1 + (split /\./, $middle)[1], 'lastEventId in the query does the same';
is $rest[-1]{id}, $all[-1]{id}, 'up to the same end';
my $over = $daemon->get("/v1/jobs/$id/events", headers => { 'Last-Event-ID' => $all[-1]{id} });
is $over->{status}, 204, 'after the end there is nothing: 204';
my $head = $daemon->raw("HEAD /v1/jobs/$id/events HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
like $head, qr{\AHTTP/1\.1 200 .*^Content-Type: text/event-stream}ms, 'HEAD shows the stream';
is body_of($head), '', 'without its bytes';

# The polish: its steps follow the iterations, and both share the progress.
my $polished = $daemon->submit('points=500&iterations=10&polish=50', $cloud);
is $daemon->finish($polished)->{status}, 'successful', 'a job with a polish ends well';
my @steps = map { json($_->{data}) } grep { $_->{event} eq 'progress' }
    $daemon->events("/v1/jobs/$polished/events", headers => { 'Last-Event-ID' => '1.1' })->all;
my @plain = grep { $_->{polish} == 0 } @steps;
my @after = grep { $_->{polish} > 0 } @steps;
is_deeply [map { $_->{iteration} } @plain], [0 .. 10], 'a record an iteration';
is_deeply [@steps[0 .. $#plain]], \@plain, 'iterations come first';
is_deeply [map { $_->{iteration} } @after], [(10) x @after], 'the polish stays at the last one';
my @steps_after = map { $_->{polish} } @after; # points that move after the last step have a record of their own
is_deeply \@steps_after, [sort { $a <=> $b } @steps_after], 'the steps of the polish do not fall';
is(($after[-1] // $plain[-1])->{polish},
    json($daemon->get("/v1/jobs/$polished/results/report"))->{polish_steps},
    'the last record has as many as the report');
is $plain[-1]{progress}, 10 + int(80 * 10 / 60), 'iterations have their share of the progress';
is $_->{progress}, 10 + int(80 * (10 + $_->{polish}) / 60 + 1e-9), "so have $_->{polish} steps" for @after;
is $_->{maxPolish}, 50, 'a record tells how many steps there may be' for $steps[0];
cmp_ok $_->{eta}, '>=', 0, 'the time left is known' for @steps[1 .. $#steps];

# A long replay: what it tells of the job was fetched when it began.
my $big = $daemon->submit('points=20&iterations=10000&polish=10000&delta=0', sphere_ply(40));
is $daemon->finish($big)->{status}, 'successful', 'a job with many records ends';
my $replay = $daemon->events("/v1/jobs/$big/events", headers => { 'Last-Event-ID' => '1.1' });
my @early = map { $replay->next_event } 1 .. 5;
is $daemon->request('DELETE', "/v1/jobs/$big")->{status}, 200, 'it is removed during a replay';
$replay->unchunk while $replay->more;
like $replay->{text}, qr/^event: end\n/m, 'which ends then';
my @late = $replay->{text} =~ /^event: progress\ndata: (.*)/mg;
is scalar(grep { !/"maxIterations":10000\b/ || !/"maxPolish":10000\b/ } @late), 0,
    'and knows the request of the job all along';

# NDJSON.
my @lines = map { json($_) } grep { length } split /\n/,
    $daemon->get("/v1/jobs/$id/events", headers => { Accept => 'application/x-ndjson' })->{content};
is $lines[0]{event}, 'status', 'NDJSON begins with the status';
is $lines[-1]{event}, 'end', 'and ends with the end';
is $lines[-1]{data}{status}, 'successful', 'with the same data';

# Heartbeats while a job waits behind another one.
my $long = $daemon->submit('points=3000&iterations=10000', $cloud);
my $waiting = $daemon->submit('points=100&iterations=1', $cloud);
my $quiet = $daemon->events("/v1/jobs/$waiting/events", headers => $stream_of);
my $beats = 0;
my $position;
while ($beats < 2 || ($position // -1) != 0) {
    my $block = $quiet->next_block or last;
    $beats++ if ($block->{comment} // '') eq 'hb';
    $position = json($block->{data})->{voronoid}{queuePosition} if defined $block->{data};
}
cmp_ok $beats, '>=', 2, 'a quiet stream shows that it lives';
is $position, 0, 'a waiting job knows its place';

# The rate for one client, and the limit on streams.
my $began = time;
my $busy = $daemon->events("/v1/jobs/$long/events", headers => $stream_of);
my $seen = 0;
while ($seen < 15 && (my $event = $busy->next_event)) { $seen++ if $event->{event} eq 'progress' }
is $seen, 15, 'a live stream shows progress';
cmp_ok time - $began, '>=', 1.3, 'at most ten times a second';
my $third = $daemon->events("/v1/jobs/$long/events", headers => $stream_of);
$third->next_event;
my $crowded = $daemon->get("/v1/jobs/$long/events", headers => $stream_of);
is $crowded->{status}, 200, 'one stream too many is no error';
is $crowded->{content}, "retry: 10000\n\n", 'but told to come back';
is_problem($daemon->post('/v1/resample?points=10', $cloud, %$stream_of), 429, 'too-many-streams',
    'a job as a stream is refused then');
$_->close for $busy, $third, $quiet;
ok Vt::wait_until(
    sub { $daemon->get("/v1/jobs/$id/events", headers => $stream_of)->{content} =~ /event: end/ }),
    'streams whose clients left make room';
is $daemon->status($long), 'running', 'whoever watches does not own the job';
$daemon->request('DELETE', "/v1/jobs/$long");
is $daemon->finish($waiting)->{status}, 'successful', 'the waiting job had its turn';

# The whole job as one stream.
my $whole = $daemon->events('/v1/resample?points=300&iterations=5', method => 'POST', body => $cloud,
    headers => { %$stream_of, Prefer => 'respond-async' });
unlike $whole->{head}, qr{^Preference-Applied}m, 'a stream claims to follow no preference';
like $whole->{head}, qr{\AHTTP/1\.1 200 .*^Location: \Q$daemon->{url}\E/v1/jobs/}ms,
    'a job as a stream is a 200 with its Location';
@events = $whole->all;
my $job = json($events[0]{data})->{jobID};
ok defined $job, 'its first event names the job';
is $events[-1]{event}, 'end', 'its last one is the end';
my ($path) = json($events[-1]{data})->{href} =~ m{^\Q$daemon->{url}\E(/.*)};
like $daemon->get($path)->{content}, qr/^element vertex 300$/m, 'which leads to the cloud';
is_problem($daemon->post('/v1/resample?points=0', $cloud, %$stream_of), 400, 'invalid-parameter',
    'a refusal before the stream begins is an ordinary problem');
is_problem($daemon->post('/v1/resample?points=5', 'nonsense', %$stream_of), 415,
    'unsupported-format', 'bytes nobody can read too');
my $left = $daemon->events('/v1/resample?points=3000&iterations=60', method => 'POST',
    body => $cloud, headers => $stream_of);
$job = json($left->next_event->{data})->{jobID};
$left->close;
is $daemon->finish($job)->{status}, 'successful', 'losing the client does not cancel';
my $failed = $daemon->events('/v1/resample?points=2', method => 'POST', headers => $stream_of,
    body => "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        . "property float z\nend_header\n" . "1 1 1\n" x 4);
@events = $failed->all;
is json($events[-1]{data})->{status}, 'failed', 'a job that fails ends its stream with that';

# Lv 2022, Fig. 25: triangles are good after a few steps. Q_avg is .91 in their Table 5.
my $meshed = $daemon->finish($daemon->submit('points=500&method=isotropic&iterations=10&polish=0', $cloud))->{jobID};
@progress = @{ json($daemon->get("/v1/jobs/$meshed/trace"))->{records} };
cmp_ok $progress[5]{$_->[0]}, '>', $_->[1], "$_->[0] after five steps" for ['quality', 0.8], ['angle', 45], ['quality', $progress[0]{quality} + 0.1];

is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
