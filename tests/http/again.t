#!/usr/bin/perl
# The same again: a request that is sent twice is one job, an input that is kept need not be sent twice, and jobs have
# names to be found by.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use Encode qw(encode_utf8);
use File::Temp ();
use FindBin;
use lib "$FindBin::Bin/../support";
use POSIX ();
use Test::More;
use Time::HiRes qw(sleep);
use Vt;

my $dir = File::Temp::tempdir(CLEANUP => 1);
my $daemon = Vt->start(dir => $dir, jobs => 1, 'admin-listen' => '127.0.0.1:0');
my $cloud = sphere_ply(2000);
my $quick = '/v1/resample?points=100&iterations=2&polish=0';
my $endless = '/v1/resample?points=2000&iterations=10000';
my @async = (Prefer => 'respond-async');

sub id_of { return $_[0]{headers}{location} =~ m{/v1/jobs/([0-9a-f-]+)$} ? $1 : undef }
sub replayed { return $_[0]{headers}{'idempotent-replayed'} // 'no' }
sub keyed { my ($key, @more) = @_; return ('Idempotency-Key' => $key, @more) }
sub files { my ($what) = @_; return grep { /\Q$what\E$/ } $daemon->blobs }
sub jobs { return scalar @{ json($daemon->get('/v1/jobs?limit=10000'))->{jobs} } }

# --- keys ----------------------------------------------------------------------------------------

my $first = $daemon->post($quick, $cloud, keyed('"a-1"'));
is $first->{status}, 200, 'a synchronous call with a key answers 200';
is replayed($first), 'no', 'the first time is no replay';
my $before = jobs();
my $again = $daemon->post($quick, $cloud, keyed('"a-1"'));
is $again->{status}, 200, 'so does the same again';
is replayed($again), 'true', 'which says that it is a replay';
is id_of($again), id_of($first), 'it is the same job';
is $again->{content}, $first->{content}, 'with the same bytes';
is id_of($daemon->post($quick, $cloud, keyed('a-1'))), id_of($first), 'a key without quotes is the same key';
my $late = $daemon->post($quick, $cloud, keyed('a-1', @async));
is "$late->{status} " . json($late)->{status}, '201 successful', 'asked for asynchronously it is 201, with the job as it is';
is replayed($late), 'true', 'also a replay';
is id_of($daemon->post('/v1/resample?polish=0&iterations=2&points=1e2', $cloud, keyed('a-1'))), id_of($first),
    'the same parameters in another order and notation are the same';
my $stream = $daemon->events($quick, method => 'POST', body => $cloud,
    headers => { keyed('a-1', Accept => 'text/event-stream') });
like $stream->{head}, qr/^Idempotent-Replayed: true\r$/m, 'a stream of it is one of the same job';
is json(($stream->all)[-1]{data})->{jobID}, id_of($first), 'to its end';
is jobs(), $before, 'none of these made a job';

for my $case (
    ['another parameter', '/v1/resample?points=101&iterations=2&polish=0', $cloud],
    ['another process', '/v1/denoise?points=100&iterations=2&polish=0', $cloud],
    ['another name', "$quick&name=b", $cloud],
    ['another format', "$quick&format=drc", $cloud],
    ['another body', $quick, sphere_ply(2001)]) {
    my ($what, $path, $body) = @$case;
    my $refused = $daemon->post($path, $body, keyed('a-1'));
    is_problem($refused, 422, 'idempotency-key-reused', "$what under the same key is refused");
    like json($refused)->{detail}, qr/a-1 .*\Q@{[id_of($first)]}/, 'which names key and job';
}
is jobs(), $before, 'and none of these made one';

for my $bad ('""', '"a', 'a b', 'a"b', '"a", "b"', '"' . 'x' x 256 . '"', 'a\\b') {
    my $refused = $daemon->post($quick, $cloud, keyed($bad));
    is_problem($refused, 400, 'invalid-parameter', 'no key: ' . substr($bad, 0, 12));
    like json($refused)->{detail}, qr/want 1 to 255 visible ASCII characters except quote, comma and backslash/,
        'the answer says what one is';
}
is $daemon->post($quick, $cloud, keyed('"' . '~' x 255 . '"'))->{status}, 200, 'the longest key is one';
for my $lines ("Idempotency-Key: a\r\nIdempotency-Key: a\r\n", "Idempotency-Key: \xe9\r\n", "Idempotency-Key:\r\n") {
    like body_of($daemon->raw("POST $quick HTTP/1.1\r\nHost: localhost\r\n${lines}Connection: close\r\nContent-Length: 0\r\n\r\n")),
        qr/invalid-parameter/, 'a key given twice, one that is not ASCII and an empty one are refused';
}

# Refusals leave the key free.
is $daemon->post('/v1/resample?points=100&iterations=2&polish=0', 'rubbish', keyed('free'))->{status}, 415,
    'bytes that are no cloud are refused with a key too';
is $daemon->post('/v1/resample?points=0', $cloud, keyed('free'))->{status}, 400, 'so is a bad parameter';
my $free = $daemon->post($quick, $cloud, keyed('free'));
is "$free->{status} " . replayed($free), '200 no', 'and the key is still free';

# While the first request's body arrives, the second is told to wait.
my $length = length $cloud;
my $socket = $daemon->connect;
$socket->print("POST $quick HTTP/1.1\r\nHost: localhost\r\nIdempotency-Key: slow\r\nConnection: close\r\n"
    . "Expect: 100-continue\r\nContent-Length: $length\r\n\r\n");
$socket->flush;
$socket->sysread(my $continue, 100);
like $continue, qr/ 100 Continue/, 'the first request is taken in';
my $busy = $daemon->post($quick, $cloud, keyed('slow'));
is_problem($busy, 409, 'idempotency-in-flight', 'a key that is in flight is 409');
like $busy->{headers}{'retry-after'}, qr/^\d+$/, 'with Retry-After';
$socket->print($cloud);
$socket->flush;
like Vt::read_all($socket), qr{\AHTTP/1\.1 200 }, 'the first one goes on';
is replayed($daemon->post($quick, $cloud, keyed('slow'))), 'true', 'and then the key is that of its job';
$socket = $daemon->connect;
$socket->print("POST $quick HTTP/1.1\r\nHost: localhost\r\nIdempotency-Key: gone\r\nContent-Length: $length\r\n\r\nply");
$socket->flush;
ok wait_until(sub { $daemon->metric('uploads_active') == 1 }), 'a body is under way';
close $socket;
ok wait_until(sub { $daemon->post($quick, $cloud, keyed('gone'))->{status} == 200 }),
    'a caller who leaves before the body is in leaves the key free';

# A caller who leaves.
sub leave {
    my (%headers) = @_;
    my $socket = $daemon->connect;
    my $known = { map { $_->{jobID} => 1 } @{ json($daemon->get('/v1/jobs?limit=1000'))->{jobs} } };
    $socket->print("POST $endless HTTP/1.1\r\nHost: localhost\r\n" . join('', map { "$_: $headers{$_}\r\n" } keys %headers)
        . "Content-Length: $length\r\n\r\n$cloud");
    $socket->flush;
    my $id = wait_until(sub {
        my ($job) = grep { !$known->{ $_->{jobID} } } @{ json($daemon->get('/v1/jobs?limit=1000'))->{jobs} };
        return $job && $job->{status} eq 'running' ? $job->{jobID} : undef;
    });
    close $socket;
    return $id;
}
my $left = leave();
is $daemon->finish($left)->{status}, 'dismissed', 'a synchronous call without a key is cancelled when its caller leaves';
my $stays = leave(keyed('stays'));
ok $daemon->wait_asleep(0), 'it is seen that another caller has left';
is $daemon->status($stays), 'running', 'one with a key is not';
my $back = $daemon->post($endless, $cloud, keyed('stays', Prefer => 'wait=1'));
is "$back->{status} " . id_of($back), "201 $stays", 'and its caller can come back to it while it runs';
is json($daemon->request('DELETE', "/v1/jobs/$stays"))->{status}, 'dismissed', 'until it is dismissed';
is_problem($daemon->post($endless, $cloud, keyed('stays')), 404, 'result-not-available', 'which the same again is told');
$daemon->request('DELETE', "/v1/jobs/$stays");
my $fresh = $daemon->post($quick, $cloud, keyed('stays'));
is "$fresh->{status} " . replayed($fresh), '200 no', 'once the job is removed, the key is free';

# --- the input again -----------------------------------------------------------------------------

my $id = id_of($first);
my $info = json($daemon->get("/v1/jobs/$id"));
my ($link) = grep { $_->{rel} eq 'input' } @{ $info->{links} };
is "$link->{href} $link->{type} $link->{length}", "$daemon->{url}/v1/jobs/$id/input application/ply $length",
    'a job whose input is kept links to it';
my $input = $daemon->get("/v1/jobs/$id/input");
is $input->{status}, 200, 'the input is there';
is $input->{content}, $cloud, 'as it came';
is $input->{headers}{etag}, '"' . sha256_hex($cloud) . '"', 'its ETag is its SHA-256';
is $input->{headers}{'content-type'}, 'application/ply', 'with its media type';
like $input->{headers}{'content-disposition'}, qr/filename="$id\.input\.ply"/, 'and a file name';
my $part = $daemon->get("/v1/jobs/$id/input", headers => { Range => 'bytes=3-12' });
is "$part->{status} $part->{content}", '206 ' . substr($cloud, 3, 10), 'a range of it is 206';
is_problem($daemon->get("/v1/jobs/$id/input", headers => { Range => "bytes=$length-" }), 416, 'range-not-satisfiable');
is $daemon->get("/v1/jobs/$id/input", headers => { 'If-None-Match' => $input->{headers}{etag} })->{status}, 304,
    'If-None-Match with its ETag is 304';
is $daemon->request('HEAD', "/v1/jobs/$id/input")->{headers}{'content-length'}, $length, 'HEAD tells its length';

my $rerun = $daemon->post("$quick&input=job:$id", '');
is $rerun->{status}, 200, 'input=job:ID runs again without an upload';
is $rerun->{content}, $first->{content}, 'and gives the same bytes';
isnt id_of($rerun), $id, 'as a job of its own';
my $other = json($daemon->post("/v1/inspect?input=job:$id", ''));
is $other->{points}{all}, 2000, 'another process takes it as well';
my $told = json($daemon->get('/v1/jobs/' . id_of($rerun)))->{voronoid}{input};
is_deeply $told, $info->{voronoid}{input}, 'what its statusInfo says of the input is what the first one said';
is id_of($daemon->post("$quick&input=job:$id", '', keyed('a-1'))), $id, 'the bytes count for a key, not how they came';
is $daemon->request('DELETE', "/v1/jobs/$id")->{status}, 200, 'the first job is removed';
is_problem($daemon->get("/v1/jobs/$id/input"), 404, 'no-such-job', 'and its input with it');
is $daemon->get('/v1/jobs/' . id_of($rerun) . '/input')->{content}, $cloud, 'but not that of the second one';
my $third = $daemon->post("$quick&input=job:" . id_of($rerun), '');
is $third->{content}, $first->{content}, 'which can be run again in its turn';

for my $case (['nothing that says so', ''], ['a length of 0', "Content-Length: 0\r\n"]) {
    like head_of($daemon->raw("POST $quick&input=job:" . id_of($rerun) . " HTTP/1.1\r\nHost: localhost\r\n$case->[1]"
        . "Connection: close\r\n\r\n")), qr{\AHTTP/1\.1 200 }, "without a body, with $case->[0]";
}
like $daemon->raw("POST $quick&input=job:" . id_of($rerun) . " HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n"
    . "Connection: close\r\n\r\n3\r\nply\r\n0\r\n\r\n"), qr{\AHTTP/1\.1 400 .*but the body also has a cloud}s,
    'a body without a length is one too';

my $unknown = $daemon->post("$quick&input=job:$id", '');
is_problem($unknown, 404, 'no-such-job', 'the input of a job that is gone is 404');
like json($unknown)->{detail}, qr/^input is job:$id: there is no such job/, 'which names it';
for my $bad ('', 'job:', "job:${id}0", $id, 'file:/etc/passwd', 'job:../x') {
    my $refused = $daemon->post("$quick&input=$bad", '');
    is_problem($refused, 400, 'invalid-parameter', "input=$bad is refused");
    like json($refused)->{detail}, qr/^input is "\Q$bad\E", want job:ID, with/, 'with what it may be';
}
is_problem($daemon->post("$quick&input=job:" . id_of($rerun), $cloud), 400, 'invalid-parameter',
    'input and a body together are refused');
is_problem($daemon->get("/v1/jobs/$left/input"), 404, 'input-not-kept', 'a dismissed job has no input');
is_problem($daemon->post("$quick&input=job:$left", ''), 404, 'input-not-kept', 'nor can it be run on again');

# --- forms and gzip ------------------------------------------------------------------------------

# A form of [name, content] pairs; those with a third are files.
sub form {
    my (@parts) = @_;
    return join('', map { "--b\r\nContent-Disposition: form-data; name=\"$_->[0]\"" . ($_->[2] ? "; filename=\"$_->[2]\"" : '')
        . "\r\n\r\n$_->[1]\r\n" } @parts) . "--b--\r\n";
}
my @form = ('Content-Type' => 'multipart/form-data; boundary=b');
my @quick = (['points', 100], ['iterations', 2], ['polish', 0]);
my $sent = $daemon->post('/v1/resample', form(@quick, ['name', 'by form'], ['file', $cloud, 'x.ply']), @form, keyed('form', @async));
is "$sent->{status} " . json($sent)->{voronoid}{name}, '201 by form', 'a form has a key and a name as well';
my $resent = $daemon->post('/v1/resample', form(['file', $cloud, 'y.ply'], ['name', 'by form'], reverse @quick), @form, keyed('form', @async));
is replayed($resent) . ' ' . id_of($resent), 'true ' . id_of($sent), 'its parts in another order are the same again';
is id_of($daemon->post("$quick&name=by%20form", $cloud, keyed('form', @async))), id_of($sent), 'and so is the same without a form';
is_problem($daemon->post('/v1/resample', form(@quick, ['file', $cloud, 'x']), @form, keyed('form')), 422, 'idempotency-key-reused');
my $rerun_by_form = $daemon->post('/v1/resample', form(@quick, ['input', 'job:' . id_of($sent)]), @form);
is $rerun_by_form->{content}, $first->{content}, 'a field input runs again on the input of a job';
my $measured = $daemon->post('/v1/measure?input=job:' . id_of($sent), form(['reference', $cloud, 'r.ply']), @form);
is json($measured)->{input}{hausdorff}, 0, 'and the other inputs may come with it';
is_problem($daemon->post('/v1/resample', form(@quick, ['input', 'job:' . id_of($sent)], ['file', $cloud, 'x']), @form), 400,
    'invalid-parameter', 'but not the same one');
is_problem($daemon->post('/v1/resample', form(@quick, ['name', 'a'], ['name', 'b'], ['file', $cloud, 'x']), @form), 400,
    'invalid-parameter', 'nor two names');
is_problem($daemon->post('/v1/resample?name=a', form(@quick, ['name', 'b'], ['file', $cloud, 'x']), @form), 400,
    'invalid-parameter', 'nor one in the query and one in the form');
my $from = id_of($third);
my $next = $daemon->post("$quick&previous=job:$from", $cloud);
like $next->{content}, qr/^property uint track$/m, 'previous=job:ID starts from the result of that job';
is $daemon->post('/v1/resample', form(@quick, $_, ['file', $cloud, 'x']), @form)->{content}, $next->{content}, 'so does a part of a form'
    for ['previous', "job:$from"], ['previous', $third->{content}, 'p.ply'];
is_problem($daemon->post("/v1/resample?previous=job:$from", form(@quick, ['previous', $cloud, 'p'], ['file', $cloud, 'x']), @form), 400,
    'invalid-parameter', 'not both');
for my $ends (['POST', '/stop', qr/\AHTTP\S+ 200 .*^property uint track$/ms], ['DELETE', '', qr/\AHTTP\S+ 404 .*result-not-available/s]) {
    my $unended = id_of($daemon->post($endless, $cloud, @async));
    my $socket = $daemon->connect; # the next frame
    print $socket "POST $quick&previous=job:$unended HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: "
        . length($cloud) . "\r\n\r\n$cloud";
    $socket->flush;
    ok wait_until(sub { json($daemon->get("/v1/jobs/$unended"))->{status} eq 'running' }), 'a job runs';
    $daemon->request($ends->[0], "/v1/jobs/$unended$ends->[1]");
    like do { local $/; <$socket> }, $ends->[2], 'the request that goes on from it is answered once it has ended';
}
is_problem($daemon->post("$quick&previous=job:" . id_of($measured), $cloud), 404, 'no-such-output', 'nor has one that measures');
require IO::Compress::Gzip;
IO::Compress::Gzip::gzip(\$cloud, \my $gzipped);
my $inflated = $daemon->post($quick, $gzipped, 'Content-Encoding' => 'gzip');
is $daemon->get('/v1/jobs/' . id_of($inflated) . '/input')->{content}, $cloud, 'what came as gzip is kept inflated';
is $daemon->post("$quick&input=job:" . id_of($inflated), '')->{content}, $first->{content}, 'and runs again';

# --- names ---------------------------------------------------------------------------------------

my $name = "m\x{fc}nster <b>\"'&\\ \x{1f600}";
my $escaped = join '', map { sprintf '%%%02X', ord } split //, encode_utf8($name);
my $named = json($daemon->post("$quick&name=$escaped", $cloud, @async));
is $named->{voronoid}{name}, $name, 'a job has the name that it was given';
is json($daemon->get("/v1/jobs/$named->{jobID}"))->{voronoid}{name}, $name, 'also later';
my $listed = json($daemon->get("/v1/jobs?name=$escaped"));
is_deeply [map { $_->{jobID} } @{ $listed->{jobs} }], [$named->{jobID}], 'a list finds it by its name';
is $listed->{jobs}[0]{voronoid}{name}, $name, 'and shows it';
is_deeply json($daemon->get('/v1/jobs?name=m'))->{jobs}, [], 'by the whole of it';
ok !exists json($daemon->get('/v1/jobs/' . id_of($rerun)))->{voronoid}{name}, 'a job without a name has none';
is json($daemon->post("$quick&name=" . '%C3%BC' x 200, $cloud, @async))->{voronoid}{name}, "\x{fc}" x 200,
    'a name of 200 characters is one, however many bytes they take';
for my $bad ('', '%C3%BC' x 201, 'x' x 201, '%C2%85', '%FF', 'a%C3', '%ED%A0%80') {
    my $refused = $daemon->post("$quick&name=$bad", $cloud, @async);
    is_problem($refused, 400, 'invalid-parameter', 'no name: ' . substr $bad, 0, 12);
    like json($refused)->{detail}, qr/^name is ".*", want 1 to 200 characters of UTF-8/, 'the answer says what one is';
}
is $daemon->post("$quick&name=a$_", $cloud)->{status}, 400, "a name with $_ does not pass the gate" for '%0A', '%00', '%1B', '%7F';

# --- all of it after a restart -------------------------------------------------------------------

$daemon->finish($named->{jobID});
is $daemon->stop, 0, 'the daemon ends with 0';
$daemon = Vt->start(dir => $dir, jobs => 1);
my $kept = $daemon->post($quick, $cloud, keyed('free'));
is replayed($kept) . ' ' . id_of($kept), 'true ' . id_of($free), 'a key is known after a restart';
is_problem($daemon->post('/v1/resample?points=9', $cloud, keyed('free')), 422, 'idempotency-key-reused',
    'and for something else refused');
is $daemon->get('/v1/jobs/' . id_of($rerun) . '/input')->{content}, $cloud, 'inputs are kept over it';
is json($daemon->get("/v1/jobs/$named->{jobID}"))->{voronoid}{name}, $name, 'and names';
is $daemon->stop, 0, 'the daemon ends with 0 again';

# --- the quota -----------------------------------------------------------------------------------

# Room for two inputs of three.
my $small = sphere_ply(500);
$daemon = Vt->start('keep-inputs' => 2 * length($small) + 100);
my @ids = map { id_of($daemon->post($quick, $small)) } 1 .. 3;
ok wait_until(sub { $daemon->get("/v1/jobs/$ids[0]/input")->{status} == 404 }), 'the input of the job that ended first goes';
is $daemon->get("/v1/jobs/$_/input")->{status}, 200, 'those after it stay' for @ids[1, 2];
ok !(grep { $_->{rel} eq 'input' } @{ json($daemon->get("/v1/jobs/$ids[0]"))->{links} }), 'nothing links to it any more';
is $daemon->get("/v1/jobs/$ids[0]/results/cloud")->{status}, 200, 'its result is still there';
my $large = id_of($daemon->post($quick, sphere_ply(3000)));
is_problem($daemon->get("/v1/jobs/$large/input"), 404, 'input-not-kept', 'what is larger than the quota is not kept');
is $daemon->get("/v1/jobs/$ids[2]/input")->{status}, 200, 'and makes nothing else go';
is scalar(() = files('.upload')), 2, 'two are on the disk';
is $daemon->stop, 0, 'the daemon ends with 0';
$daemon = Vt->start(dir => $daemon->{dir}, 'keep-inputs' => 0);
ok wait_until(sub { !(() = files('.upload')) }), 'a quota of 0 drops what was kept';
is_problem($daemon->get('/v1/jobs/' . id_of($daemon->post($quick, $small)) . '/input'), 404, 'input-not-kept',
    'and keeps nothing');
is $daemon->stop, 0, 'the daemon ends with 0';

# --- a full queue ---------------------------------------------------------------------------------

$daemon = Vt->start(jobs => 1, queue => 1);
my $runs = $daemon->post($endless, $cloud, keyed('runs', @async));
ok wait_until(sub { $daemon->status(id_of($runs)) eq 'running' }), 'one job runs';
my $waits = $daemon->post($endless, $cloud, keyed('waits', @async));
is_problem($daemon->post($endless, $cloud, keyed('new', @async)), 429, 'queue-full', 'and one waits: there is no room for another');
my $asked = $daemon->post($endless, $cloud, keyed('waits', @async));
is "$asked->{status} " . replayed($asked), '201 true', 'but whoever asks for one of them again is answered';
is_problem($daemon->post($quick, $cloud, keyed('waits', @async)), 422, 'idempotency-key-reused', 'rightly');
$daemon->request('DELETE', '/v1/jobs/' . id_of($_)) for $waits, $runs;
my $fits = $daemon->post($quick, $cloud, keyed('new', @async));
is "$fits->{status} " . replayed($fits), '201 no', 'and the refused one has its key still';
is $daemon->stop, 0, 'the daemon ends with 0';

# --- expiry --------------------------------------------------------------------------------------

# A result lives a second, from its end on; the sweeper looks at the start and once a minute.
$daemon = Vt->start('result-ttl' => 1);
my $old = id_of($daemon->post($quick, $small, keyed('old')));
sleep 1.1;
$daemon->stop;
$daemon = Vt->start(dir => $daemon->{dir}, 'result-ttl' => 1);
ok wait_until(sub { $daemon->get("/v1/jobs/$old/input")->{status} =~ /^4(10|04)$/ }), 'an expired job has no input';
ok wait_until(sub { !(() = files('')) }), 'no bytes of it are left';
my $renewed = $daemon->post($quick, $small, keyed('old'));
is "$renewed->{status} " . replayed($renewed), '200 no', 'and its key is free';
is $daemon->stop, 0, 'the daemon ends with 0';

# --- kill -9 -------------------------------------------------------------------------------------

# A caller who repeats a request with its key until it is answered has one job, wherever the daemon was killed: once its log
# has so many lines that tell of jobs, of eighteen or so; the last daemon is killed when it has answered everything.
srand 14;
$dir = File::Temp::tempdir(CLEANUP => 1);
sub told { return scalar(() = $_[0]->log_text =~ /"msg":"job /g) }
my (%sent, %answer);
for my $round (1 .. 8) {
    my $killer = Vt->start(dir => $dir);
    my $lines = int rand 18;
    my $pid = $round == 8 ? undef : fork // die "fork: $!";
    if (defined $pid && !$pid) {
        wait_until(sub { told($killer) >= $lines });
        kill 'KILL', $killer->{pid};
        POSIX::_exit(0);
    }
    for my $key (1 .. 6) {
        my $slot = "k$key-" . int(($round - 1) / 2);
        $sent{$slot} = 1;
        my $answer = $killer->{http}->post("$killer->{url}$quick&seed=$key",
            { content => $small, headers => { keyed($slot, @async) } });
        last if $answer->{status} != 201;
        my $job = id_of($answer);
        is $job, $answer{$slot} //= $job, "round $round, $slot: the same job as before the kill";
    }
    kill 'KILL', $pid // (), $killer->{pid};
    waitpid $pid, 0 if defined $pid;
    Vt::reap(delete $killer->{pid});
}
$daemon = Vt->start(dir => $dir);
for my $slot (sort keys %answer) {
    my $info = $daemon->finish($answer{$slot});
    is $info->{status}, 'successful', "$slot: what was accepted is done" or diag($info->{message});
    is $daemon->get("/v1/jobs/$answer{$slot}/input")->{content}, $small, "$slot: and its input is kept";
}
my @all = @{ json($daemon->get('/v1/jobs?limit=1000'))->{jobs} };
my $done = grep { $daemon->finish($_->{jobID})->{status} eq 'successful' } @all;
cmp_ok scalar(@all), '<=', scalar(keys %sent), 'no key has two jobs';
cmp_ok scalar(keys %answer), '>=', 1, 'some requests were answered';
ok wait_until(sub {
    my @files = files('');
    return @files == @all + $done;
}), 'an upload for each job and a cloud for each that is done are on the disk, and nothing else';
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
