#!/usr/bin/perl
# One stream for many jobs: whose events come, in which order, where it goes on, and what it refuses.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start(heartbeat => 1, streams => 3, jobs => 1, 'drain-timeout' => 0);
my $cloud = sphere_ply(2000);
my $of_events = { Accept => 'text/event-stream' };
my $nobody = '0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11';

sub data { return json($_[0]{data}) }
sub path { my ($jobs, $last) = @_; return '/v1/events?jobs=' . join(',', @$jobs) . (defined $last ? "&lastEventId=$last" : '') }
sub stream { return $daemon->events(path(@_), headers => $of_events) }

# One that is over, one that is none, one that runs, and one that waits behind it.
my $over = $daemon->submit('points=200&iterations=20&polish=0', $cloud);
is $daemon->finish($over)->{status}, 'successful', 'a job is over';
my $runs = $daemon->submit('points=2000&iterations=10000&delta=0&polish=0', $cloud);
my $waits = $daemon->submit('points=100&iterations=5', $cloud);
my @jobs = ($over, $nobody, $runs, $waits);
my $stream = stream(\@jobs);
like $stream->{head}, qr{\AHTTP/1\.1 200 .*^Content-Type: text/event-stream\r$}ms, 'it is a stream';
is $stream->next_block->{retry}, 2000, 'that begins as those of one job do';
my @events;
push @events, $stream->next_event until grep { $_->{event} eq 'progress' && data($_)->{jobID} eq $runs } @events;
my @of_over = grep { data($_)->{jobID} eq $over } @events;
is $of_over[0]{event}, 'status', 'of a job that is over the status comes';
is $of_over[-1]{event}, 'end', 'and the end';
is data($of_over[-1])->{outputs}{cloud}, "$daemon->{url}/v1/jobs/$over/results/cloud", 'that leads to its results';
is_deeply [map { $_->{event} } grep { data($_)->{jobID} eq $nobody } @events], ['unknown'],
    'a job that is none is unknown, and the others go on';
is_deeply data((grep { $_->{event} eq 'unknown' } @events)[0]), { jobID => $nobody }, 'which says that alone';
push @events, $stream->next_event until grep { data($_)->{jobID} eq $waits } @events;
is data((grep { data($_)->{jobID} eq $waits } @events)[0])->{voronoid}{queuePosition}, 0, 'a job that waits knows its place';
like $_->{id}, qr/^(?:(?:\d+\.\d+|end)(?:,|$)){4}$/, 'an id has a position of each job' for @events[0, -1];
like $events[-1]{id}, qr/^end,end,1\.\d+,1\.\d+$/, 'those that are over are at their end';

# It is lost, and asked for again where it ended.
my $last = $events[-1]{id};
$stream->close;
my $again = stream(\@jobs, $last);
my ($next) = $again->next_event;
is data($next)->{jobID}, $runs, 'what comes first is of a job that goes on';
my @numbers = map { (split /[.,]/, $_->{id})[3] } $next;
is $numbers[0], 1 + (split /[.,]/, $last)[3], 'its next event, so that none is lost and none comes twice';
is $daemon->request('DELETE', "/v1/jobs/$runs")->{status}, 200, 'the job that runs is dismissed';
my @rest = $again->all;
ok $again->{whole}, 'the stream ends in good order once all jobs have';
my %ends = map { data($_)->{jobID} => data($_)->{status} } grep { $_->{event} eq 'end' } @rest;
is_deeply \%ends, { $runs => 'dismissed', $waits => 'successful' }, 'with the ends of those that were not over';
is $rest[-1]{id}, 'end,end,end,end', 'and the last id says so';
is $daemon->get(path(\@jobs, $rest[-1]{id}))->{status}, 204, 'after it there is nothing: 204';
is $daemon->get(path(\@jobs), headers => { 'Last-Event-ID' => $rest[-1]{id} })->{status}, 204, 'by the header, too';

# Whoever comes late and wants everything: each record of each job, once, as in the trace.
my $second = $daemon->submit('points=150&iterations=12&polish=0', $cloud);
$daemon->finish($second);
my $late = stream([$second, $over], '0.0,0.0');
my %seen;
for my $event ($late->all) {
    push @{ $seen{ data($event)->{jobID} } }, data($event)->{iteration} if $event->{event} eq 'progress';
}
is_deeply \%seen, { map { $_ => [map { $_->{iteration} } @{ json($daemon->get("/v1/jobs/$_/trace"))->{records} }] } $over, $second },
    'from 0.0 on there is the whole curve of each, no record twice';
my @lines = map { json($_) } split /\n/, $daemon->get(path([$over, $nobody]), headers => { Accept => 'application/x-ndjson' })->{content};
is_deeply [$lines[0]{event}, map { $_->{event} } @lines[-2, -1]], [qw(status end unknown)], 'as lines, too';
is $lines[-1]{id}, 'end,end', 'with the same ids';
is $lines[-1]{data}{jobID}, $nobody, 'and data';

# Limits.
my @many = map { sprintf "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b%04x", $_ } 1 .. 65;
my @unknown = stream([@many[0 .. 63]])->all;
is_deeply [map { data($_)->{jobID} } @unknown], [@many[0 .. 63]], '64 jobs may be asked for at once';
is_problem $daemon->get(path(\@many)), 400, 'invalid-query-parameter-value', '65 may not';
for my $case (
    ['', qr/jobs is missing, want 1 to 64/], ['?jobs=', qr/jobs holds "", want 1 to 64 IDs/],
    ['?jobs=1', qr/jobs holds "1"/], ["?jobs=$over,", qr/jobs holds ""/], ["?jobs=$over,$over", qr/holds $over twice/],
    ["?jobs=$over&lastEventId=1.1,1.1", qr/the last event id is "1\.1,1\.1", want .* for each of the 1 jobs/],
    ["?jobs=$over,$nobody&lastEventId=1.1", qr/each of the 2 jobs/], ["?jobs=$over&lastEventId=", qr/the last event id is ""/],
    ["?jobs=$over&lastEventId=ends", qr/is "ends"/], ["?jobs=$over&lastEventId=1.1.1", qr/is "1\.1\.1"/],
) {
    my ($query, $words) = @$case;
    my $refused = $daemon->get("/v1/events$query");
    is_problem $refused, 400, 'invalid-query-parameter-value', "/v1/events$query is refused";
    like json($refused)->{detail}, $words, 'with the value and what is wanted';
}
my $long = $daemon->submit('points=2000&iterations=10000&delta=0&polish=0', $cloud);
my @open = map { stream([$long]) } 1 .. 3;
$_->next_event for @open;
is $daemon->get(path([$long, $nobody]))->{content}, "retry: 10000\n\n", 'one stream too many is told to come back';
$_->close for @open[1, 2];

# The daemon ends while it is open: the client is told when to come back, and its last id holds after that.
is $daemon->stop, 0, 'the daemon ends with 0';
my $bye;
while (my $block = $open[0]->next_block) { $bye = $block }
is $bye->{retry}, 1000, 'the last thing that a stream says is when to come back';

# A key sees its own jobs.
my $dir = tempdir(CLEANUP => 1);
spew("$dir/keys", map { "$_:submit,read:" . sha256_hex("a key of $_") . "\n" } qw(anna berta));
$daemon = Vt->start('api-keys' => "$dir/keys");
my $of_anna = json($daemon->post('/v1/resample?points=50&iterations=2', $cloud, Prefer => 'respond-async',
    'X-API-Key' => 'a key of anna'))->{jobID};
my %got;
for my $who (qw(anna berta)) {
    my $answer = $daemon->get(path([$of_anna]), headers => { 'X-API-Key' => "a key of $who" });
    $got{$who} = [$answer->{content} =~ /^event: (unknown|end)$/mg];
}
is_deeply \%got, { anna => ['end'], berta => ['unknown'] }, "another key's job is as unknown as none";
my $polled = $daemon->get(path([$of_anna]), headers => { Prefer => 'wait=600', 'X-API-Key' => 'a key of berta' });
is_deeply [$polled->{content} =~ /^event: (\w+)$/mg], ['unknown'], 'and ends a poll at once';
is_problem $daemon->get(path([$of_anna]), headers => $_), 401, 'unauthorized', 'without a key there is no stream, and no poll'
    for {}, { Prefer => 'wait=600' };
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
