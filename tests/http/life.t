#!/usr/bin/perl
# The life of a job over HTTP, from the bytes that come in to those that go out.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Time::Local qw(timegm);
use Vt;

our $daemon = Vt->start;
my $cloud = sphere_ply(3000);
my $uuid = qr/[0-9a-f]{8}-[0-9a-f]{4}-7[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}/;

sub vertices { return $_[0] =~ /^element vertex (\d+)$/m ? $1 : -1 }
sub links { my ($info, $rel) = @_; return grep { $_->{rel} eq $rel } @{ $info->{links} } }

# Synchronous.
my $sync = $daemon->post('/v1/resample?points=500&iterations=5', $cloud);
is $sync->{status}, 200, 'a synchronous call answers 200';
is vertices($sync->{content}), 500, 'it yields exactly the number of points asked for';
is $sync->{headers}{'content-type'}, 'application/ply', 'the format is that of the input';
like $sync->{headers}{location}, qr{\Ahttp://127\.0\.0\.1:\d+/v1/jobs/$uuid\z},
    'Location is absolute and names the job';
is $sync->{headers}{etag}, '"' . sha256_hex($sync->{content}) . '"', 'the ETag is the SHA-256';
like $sync->{headers}{'content-disposition'}, qr/\Aattachment; filename="$uuid\.resample\.ply"\z/,
    'the answer suggests a file name';
my $stem = 'x' x 155;
for my $case (
    ['bunny.ply', 'bunny'], ['/home/a/../b%5Cbunny.DRC', 'bunny'], ['v1.5', 'v1.5'], ['..hidden.ply', 'hidden'], ['a%22%3Ab%3Cc', 'a__b_c'],
    ["${stem}%C3%A4%C3%A4%C3%A4", "${stem}____", "${stem}%C3%A4%C3%A4"], ['H%C3%A4schen.ply', 'H__schen', 'H%C3%A4schen'],
) {
    my ($name, $ascii, $utf8) = @$case;
    my $got = $daemon->post("/v1/convert?name=$name", $cloud);
    is $got->{headers}{'content-disposition'}, qq(attachment; filename="$ascii.convert.ply")
        . ($utf8 ? "; filename*=UTF-8''$utf8.convert.ply" : ''), substr("that of a job named $name", 0, 60);
}
like $daemon->post('/v1/convert?name=.ply', $cloud)->{headers}{'content-disposition'}, qr/"$uuid\.convert\.ply"\z/, 'a name of nothing gives none';
my ($sync_id) = $sync->{headers}{location} =~ /($uuid)\z/;
my $sync_report = json($daemon->get("/v1/jobs/$sync_id/results/report"));
is $sync_report->{points}{out}, 500, 'the caller of a synchronous call can read the report';
is $sync_report->{iterations}, 5, 'the report counts the iterations';
like $sync_report->{polish_steps}, qr/^\d+$/, 'and the steps of the polish';
cmp_ok $sync_report->{polish_steps}, '<=', $sync_report->{parameters}{polish}, 'which are no more than allowed';
my $default = json($daemon->get('/v1/processes/resample'))->{inputs}{polish}{schema};
is $sync_report->{parameters}{polish}, $default->{default}, 'by the default of the process';
is "$default->{type} $default->{minimum} $default->{maximum}", 'integer 0 10000', 'whose description has its range';
is $sync_report->{stopped}, 'iterations', 'the report says why the run ended';
my $same = $daemon->post('/v1/processes/resample/execution?points=500&iterations=5', $cloud,
    'Content-Type' => 'application/ply');
is $same->{content}, $sync->{content}, 'the execution path yields the same bytes';

# Asynchronous.
my $answer = $daemon->post('/v1/resample?points=400&iterations=8&polish=0&seed=3', $cloud,
    Prefer => 'respond-async');
is $answer->{status}, 201, 'respond-async answers 201';
is $answer->{headers}{'preference-applied'}, 'respond-async', 'it says that it did';
my $info = json($answer);
my $id = $info->{jobID};
like $id, qr/\A$uuid\z/, 'the identifier is a UUID of version 7';
is $info->{id}, $id, 'id and jobID are the same';
is $answer->{headers}{location}, "$daemon->{url}/v1/jobs/$id", 'Location names the job';
is $info->{type}, 'process', 'the type is process';
is $info->{processID}, 'resample', 'the process is named';
is $info->{voronoid}{input}{points}, 3000, 'the input was decoded before the 201';
is $info->{voronoid}{input}{sha256}, sha256_hex($cloud), 'the upload was digested on the way';
is $info->{voronoid}{input}{bytes}, length $cloud, 'and counted';
is $info->{voronoid}{target}{points}, 400, 'the target is known';

my $done = $daemon->finish($id);
is $done->{status}, 'successful', 'the job ends well';
is $done->{progress}, 100, 'progress reaches 100';
my $measured = json($daemon->get("/v1/jobs/$id/results/report"));
is_deeply [@{ $done->{voronoid}{metrics} }{qw(delta sigma epsilon)}], [@$measured{qw(delta sigma epsilon)}],
    'and the metrics are those of the result';
ok defined $done->{finished}, 'the end has a time';
my ($results) = links($done, 'http://www.opengis.net/def/rel/ogc/1.0/results');
is $results->{href}, "$daemon->{url}/v1/jobs/$id/results", 'the results link is there at the end';
is scalar(links($done, 'monitor')), 0, 'and the monitor link is gone';
my @items = links($done, 'item');
is scalar(@items), 2, 'each output has an item link';
my $outputs = json($daemon->get("/v1/jobs/$id/results"));
is_deeply [sort keys %$outputs], ['cloud', 'report'], 'the results are cloud and report';
is $outputs->{cloud}{type}, 'application/ply', 'the results document names media types';

# Bytes: Range, ETag, HEAD.
my $path = "/v1/jobs/$id/results/cloud";
my $whole = $daemon->get($path);
my $bytes = $whole->{content};
my $etag = $whole->{headers}{etag};
is vertices($bytes), 400, 'the cloud has the points asked for';
is $etag, '"' . sha256_hex($bytes) . '"', 'its ETag is its SHA-256';
is $items[0]{length}, length $bytes, 'its link told its length';
my $head = $daemon->request('HEAD', $path);
is $head->{status}, 200, 'HEAD answers';
is $head->{headers}{'content-length'}, length $bytes, 'HEAD tells the length';
is $head->{headers}{'accept-ranges'}, 'bytes', 'HEAD tells that ranges are served';
is body_of($daemon->raw("HEAD $path HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")), '',
    'HEAD sends no bytes';

sub part { my %h = @_; return $daemon->get($path, headers => \%h) }
my $size = length $bytes;
for my $case (
    ['bytes=0-9', 0, 9], ['bytes=10-10', 10, 10], ['bytes=100-', 100, $size - 1],
    ['bytes=-7', $size - 7, $size - 1], ['bytes=5-999999999', 5, $size - 1],
    ['bytes=-999999999', 0, $size - 1]) {
    my ($range, $first, $last) = @$case;
    my $got = part(Range => $range);
    is $got->{status}, 206, "$range is partial";
    is $got->{headers}{'content-range'}, "bytes $first-$last/$size", "$range names its bytes";
    is $got->{content}, substr($bytes, $first, $last - $first + 1), "$range sends those bytes";
}
for my $range ("bytes=$size-", 'bytes=-0') {
    my $got = part(Range => $range);
    is_problem($got, 416, 'range-not-satisfiable', "$range is refused");
    is $got->{headers}{'content-range'}, "bytes */$size", "$range is told the size";
}
is part(Range => $_)->{status}, 200, "$_ is ignored"
    for 'bytes=5-3', 'bytes=0-1,4-5', 'bytes=x', 'lines=0-1', 'bytes=-';
is part(Range => 'bytes=0-3', 'If-Range' => $etag)->{status}, 206, 'If-Range with the ETag holds';
is part(Range => 'bytes=0-3', 'If-Range' => '"x"')->{status}, 200, 'If-Range with another does not';
is part('If-None-Match' => $etag)->{status}, 304, 'If-None-Match with the ETag answers 304';
is part('If-None-Match' => "\"a\", W/$etag")->{status}, 304, 'also in a list, also when weak';
is part('If-None-Match' => '*')->{status}, 304, 'also for a star';
is part('If-None-Match' => '"a"')->{content}, $bytes, 'If-None-Match with another sends the bytes';
is part('If-Match' => $_)->{content}, $bytes, "If-Match: $_ sends the bytes" for $etag, '*', "\"a\", $etag";
is_problem(part('If-Match' => $_, 'If-None-Match' => $etag, Range => 'bytes=0-3'), 412, 'precondition-failed', "If-Match: $_")
    for '"zzz"', "W/$etag";
for my $known ($path, "/v1/jobs/$id", '/openapi.yaml', '/', '/assets/page.css', "/v1/jobs/$id/input") {
    my %ask = (Accept => 'text/html, */*', 'Accept-Encoding' => 'gzip');
    my $whole = $daemon->get($known, headers => \%ask);
    my $same = $daemon->get($known, headers => { %ask, 'If-None-Match' => $whole->{headers}{etag}, Range => 'bytes=0-3' });
    is $same->{status}, 304, "$known has not changed";
    delete @{ $_->{headers} }{qw(date x-request-id)} for $whole, $same;
    is_deeply $same->{headers}, $whole->{headers}, 'which is told with the headers of 200, the length as well';
}
my $report = $daemon->get("/v1/jobs/$id/results/report");
is $items[1]{length}, length $report->{content}, 'the link of the report told its length too';
is $report->{headers}{etag}, '"' . sha256_hex($report->{content}) . '"', 'the report has an ETag too';
is $daemon->get("/v1/jobs/$id/results/report", headers => { Range => 'bytes=0-0' })->{content}, '{',
    'and ranges';

# The job itself: ETag, and a wait for a change.
my $known = $daemon->get("/v1/jobs/$id");
is_deeply json($known)->{voronoid}{parameters}, { points => 400, iterations => 8, polish => 0, seed => 3, format => 'ply' },
    'and what was asked for, where it is not the default';
is $known->{headers}{etag}, '"' . sha256_hex($known->{content}) . '"', 'a statusInfo has an ETag';
my $unchanged = $daemon->get("/v1/jobs/$id", headers => { 'If-None-Match' => $known->{headers}{etag} });
is $unchanged->{status} . ($unchanged->{content} // ''), '304', 'who has it is told so, without a body';
is $unchanged->{headers}{etag}, $known->{headers}{etag}, 'with the same ETag';
is $daemon->get("/v1/jobs/$id", headers => { 'If-None-Match' => '"x"' })->{content}, $known->{content},
    'who has another one gets it';
sub poll {
    my ($job, $etag, $seconds) = @_;
    return $daemon->get("/v1/jobs/$job",
        headers => { 'If-None-Match' => $etag, Prefer => "wait=$seconds" });
}
is poll($id, $known->{headers}{etag}, 600)->{status}, 304, 'of a job that is over, no change is waited for';
{
    my $blocker = Vt->start(jobs => 1, 'admin-listen' => '127.0.0.1:0');
    my $running = $blocker->submit('points=3000&iterations=10000', $cloud);
    my $waiting = $blocker->submit('points=100&iterations=1', $cloud);
    wait_until(sub { $blocker->status($running) eq 'running' });
    local $daemon = $blocker;
    my $etag = $blocker->get("/v1/jobs/$waiting")->{headers}{etag};
    my $quiet = poll($waiting, $etag, 1);
    is $quiet->{status}, 304, 'a wait without a change ends with 304';
    is $quiet->{headers}{'preference-applied'}, 'wait=1', 'and says that it waited';
    is poll($waiting, '"old"', 600)->{status}, 200, 'what has changed already is not waited for';
    my $socket = $blocker->connect;
    print $socket "GET /v1/jobs/$waiting HTTP/1.1\r\nHost: $blocker->{address}\r\nIf-None-Match: $etag\r\nPrefer: wait=600\r\nConnection: close\r\n\r\n";
    ok $blocker->wait_asleep(1), 'a call waits for a change';
    $blocker->request('DELETE', "/v1/jobs/$running");
    my $changed = Vt::read_all($socket);
    like $changed, qr{\AHTTP/1\.1 200 }, 'which ends the wait';
    isnt json(body_of($changed))->{status}, 'accepted', 'with the job as it is then';
    unlike head_of($changed), qr/^ETag: \Q$etag\E/mi, 'and another ETag';
    is $blocker->finish($waiting)->{status}, 'successful', 'the job goes on';
    is $blocker->stop, 0, 'nobody waits in vain for the daemon to end';
}

# The trace.
my $trace = json($daemon->get("/v1/jobs/$id/trace"));
my @records = @{ $trace->{records} };
is_deeply [map { $_->{iteration} } @records[0 .. 8]], [0 .. 8], 'the trace has a record an iteration';
is join(' ', map { $_->{iteration} } @records[9 .. $#records]), @records > 9 ? '8' : '', 'and perhaps one of the result';
is_deeply { map { $_ => $records[-1]{best}{$_} } qw(delta sigma epsilon) },
    { map { $_ => json($daemon->get("/v1/jobs/$id/results/report"))->{$_} } qw(delta sigma epsilon) }, 'the last best is the report\'s';
is_deeply [sort keys %{ $records[0] }],
    [sort qw(iteration polish delta sigma epsilon energy max_move held seconds run_stage step of ahead best quality angle mse)],
    'with every member';
is scalar(grep { $_->{polish} != 0 } @records), 0, 'and without a polish none of its steps';
cmp_ok $records[8]{delta}, '<', $records[0]{delta}, 'delta falls';
is $daemon->get("/v1/jobs/$id/trace", headers => { Accept => 'text/csv;q=0, application/json' })->{headers}{'content-type'}, 'application/json',
    'the trace is JSON for who refuses CSV';
my @rows = split /\n/, $daemon->get("/v1/jobs/$id/trace", headers => { Accept => 'text/csv' })->{content};
is $rows[0], 'iteration,polish,delta,sigma,epsilon,energy,max_move,held,seconds,run_stage,step,of,ahead,'
    . 'best.iteration,best.polish,best.delta,best.sigma,best.epsilon,quality,angle,mse',
    'the table has its head';
is scalar(@rows), 1 + @records, 'and a row a record';
is join(',', (split /,/, $rows[9])[0, 1, 9 .. 12]), '8,0,iterate,8,8,0', 'in its order';
cmp_ok abs((split /,/, $rows[9])[2] - $records[8]{delta}), '<', 1e-15, 'with the same values';

# Formats.
for my $case (['Accept' => 'application/draco'], ['Accept' => 'application/ply;q=0.4, model/draco'],
    ['query' => '&format=drc']) {
    my ($how, $value) = @$case;
    my $got = $daemon->post('/v1/resample?points=50&iterations=1' . ($how eq 'query' ? $value : ''),
        $cloud, $how eq 'query' ? () : ($how => $value));
    is $got->{headers}{'content-type'}, 'application/draco', "$how $value asks for Draco";
    is substr($got->{content}, 0, 5), 'DRACO', "$how $value gets Draco";
}
my $drc = $daemon->post('/v1/resample?points=300&iterations=1&format=drc', $cloud)->{content};
my $again = $daemon->post('/v1/resample?points=60&iterations=1', $drc);
is $again->{headers}{'content-type'}, 'application/draco', 'Draco in is Draco out';
my $any = $daemon->post('/v1/resample?points=60&iterations=1', $drc, Accept => '*/*');
is $any->{headers}{'content-type'}, 'application/draco', 'also when anything is acceptable';

# wait=N.
my $waited = $daemon->post('/v1/resample?points=60&iterations=1', $cloud, Prefer => 'wait=600');
is $waited->{status}, 200, 'wait=600 answers with the result when it is there in time';
is $waited->{headers}{'preference-applied'}, 'wait=600', 'and says so';
my $early = $daemon->post('/v1/resample?points=60&iterations=1', $cloud, Prefer => 'respond-async, wait=600');
is "$early->{status} $early->{headers}{'preference-applied'}", '200 wait=600',
    'whoever would take a job gets the result when it is there in time';
my $late = $daemon->post('/v1/resample?points=3000&iterations=10000', $cloud,
    Prefer => 'respond-async, wait=1');
is $late->{status}, 201, 'wait=1 answers 201 when it is not';
is $late->{headers}{'preference-applied'}, 'respond-async, wait=1', 'and says what it did';
is $daemon->status(json($late)->{jobID}), 'running', 'and the job goes on';
my $cut = $daemon->request('DELETE', '/v1/jobs/' . json($late)->{jobID});
is json($cut)->{status}, 'dismissed', 'until it is dismissed';

# The list.
my $list = json($daemon->get('/v1/jobs?limit=3'));
is scalar(@{ $list->{jobs} }), 3, 'a list has as many jobs as asked for';
is $list->{jobs}[0]{jobID}, json($late)->{jobID}, 'the newest is the first';
my @seen = map { $_->{jobID} } @{ $list->{jobs} };
while (my ($next) = links($list, 'next')) {
    $next->{href} =~ s/^\Q$daemon->{url}\E// or last;
    $list = json($daemon->get($next->{href}));
    push @seen, map { $_->{jobID} } @{ $list->{jobs} };
}
my %once = map { $_ => 1 } @seen;
is scalar(@seen), scalar(keys %once), 'the pages hold no job twice';
ok $once{$id} && $once{$sync_id}, 'and every job once';
is_deeply [map { $_->{jobID} } @{ json($daemon->get('/v1/jobs?status=dismissed'))->{jobs} }],
    [json($late)->{jobID}], 'the list can be narrowed to a status';
is scalar(@{ json($daemon->get('/v1/jobs?processID=other'))->{jobs} }), 0, 'and to a process';
sub listed { return map { $_->{jobID} } @{ json($daemon->get("/v1/jobs?limit=100&$_[0]"))->{jobs} } }
my @every = listed('type=process');
is scalar(@every), scalar(@seen), 'every job is a process';
my $created = $done->{created};
is_deeply [listed("datetime=$created")], [$id], 'a time finds the job that was created then';
my $at = (grep { $every[$_] eq $id } 0 .. $#every)[0];
is_deeply [listed("datetime=$created/..")], [@every[0 .. $at]], 'an interval without an end those from then on';
is_deeply [listed("datetime=../$created")], [@every[$at .. $#every]], 'one without a beginning those up to then';
is_deeply [listed("datetime=$created/$created")], [$id], 'one with both what lies within';
my ($second) = $created =~ /^(.{19})/;
ok((grep { $_ eq $id } listed("datetime=${second}Z")), 'a whole second names all of it');
is_deeply [listed('datetime=1999-01-01T00:00:00Z')], [], 'another time finds nothing';
sub clock_of { my ($y, $m, $d, $H, $M, $s) = $_[0] =~ /[\d.]+/g; return timegm(0, $M, $H, $d, $m - 1, $y) + $s }
my %ran;
for my $job (@{ json($daemon->get('/v1/jobs?limit=100'))->{jobs} }) {
    $ran{ $job->{jobID} } = clock_of($job->{finished}) - clock_of($job->{started}) if $job->{started} && $job->{finished};
}
is scalar(keys %ran), scalar(@every), 'every job has started and ended by now';
is_deeply [listed('minDuration=1')], [grep { $ran{$_} >= 0.9995 } @every], 'minDuration finds those that ran as long';
is_deeply [listed('maxDuration=1')], [grep { $ran{$_} <= 1.0005 } @every], 'maxDuration those that did not run longer';
ok((grep { $_ eq json($late)->{jobID} } listed('minDuration=1')), 'of which there is one');
is_deeply [listed('minDuration=600')], [], 'and none ran for ten minutes';

# Removal.
is json($daemon->request('DELETE', "/v1/jobs/$id"))->{status}, 'dismissed',
    'DELETE of a job that is over says dismissed';
is_problem($daemon->get("/v1/jobs/$id"), 404, 'no-such-job', 'and then there is no such job');
is_problem($daemon->get($path), 404, 'no-such-job', 'nor its bytes');

# The rest of the table.
is $daemon->get($_)->{status}, 200, "GET $_ answers" for '/', '/v1/', '/livez', '/readyz', '/version',
    '/openapi.yaml', '/v1/processes', '/v1/processes/resample', '/problems/queue-full';
is $daemon->get('/openapi.yaml')->{content}, Vt::slurp("$FindBin::Bin/../../openapi.yaml"),
    'the daemon serves the openapi.yaml of the tree';
my $process = json($daemon->get('/v1/processes/resample'));
ok exists $process->{inputs}{points}, 'the process description has its parameters';
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
