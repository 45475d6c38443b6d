#!/usr/bin/perl
# The frames of a sequence in one request, as a tar archive and as a form: results in their order, each from the one
# before, with the bytes that the command line makes; what is damaged fails alone, and what was accepted survives kill -9.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $dir = tempdir(CLEANUP => 1);
my $daemon = Vt->start(dir => $dir, jobs => 2);
my $binary = $ENV{VORONOID} // 'build/release/voronoid';
my @small = ('points=80', 'iterations=3', 'polish=4');
my $path = '/v1/processes/resample/frames?' . join '&', @small;
my %clouds = ('a.ply' => sphere_ply(400), 'b.ply' => 'no cloud', 'c.ply' => sphere_ply(500), 'd.ply' => sphere_ply(450));
my @names = sort keys %clouds;

# An archive of these files; the files of an archive, and their names in its order.
sub archive { my (@options) = @_; return scalar qx(tar -C $dir/frames -c @options) }
sub contents {
    my ($bytes) = @_;
    my $out = tempdir(CLEANUP => 1);
    my @listed = split /\n/, qx(tar -x -v -C $out -f @{[spew("$dir/answer.tar", $bytes)]} 2>&1);
    return (\@listed, { map { $_ => Vt::slurp("$out/$_") } @listed });
}

mkdir "$dir/$_" for 'frames', 'frames/.hidden', 'here';
spew("$dir/frames/$_", $clouds{$_}) for @names;
spew("$dir/frames/$_", 'no frame') for '._a.ply', 'a.json';
system "$binary sequence @{[map { qq($dir/frames/$_) } @names]} @{[map { qq(--$_) } @small]} -q -o $dir/here/ 2>&-";

for my $format (qw(ustar pax gnu)) {
    my $answer = $daemon->post($path, archive("--format=$format", '._a.ply', '.hidden', $format eq 'pax' ? './a.ply' : 'a.ply',
        'a.json', @names[1 .. 3]), Accept => 'application/x-tar');
    is "$answer->{status} $answer->{headers}{'content-type'}", '200 application/x-tar', "$format: the answer is an archive";
    my ($listed, $files) = contents($answer->{content});
    is "@$listed", 'a.json a.ply b.json c.json c.ply d.json d.ply', 'with the frames in their order';
    ok $files->{$_} eq Vt::slurp("$dir/here/$_"), "$_: the bytes of the command line" for qw(a.ply c.ply d.ply);
    my %told = map { $_ => json($files->{"$_.json"}) } qw(a b c d);
    like $told{b}{type}, qr/unsupported-format$/, 'what is damaged fails alone';
    is "$told{$_}{status} $told{$_}{voronoid}{name}", "successful $_.ply", "$_: an ordinary job" for qw(a c d);
}

my @events = $daemon->events($path, method => 'POST', body => archive(@names), headers => { Accept => 'text/event-stream' })->all;
is join(' ', map { "$_->{id}:$_->{event}:" . json($_->{data})->{status} } @events),
    join(' ', '1:frame:accepted 1:frame:successful 2:frame:415', map { "$_:frame:accepted $_:frame:successful" } 3, 4), 'the same as events';

my (undef, $restored) = contents($daemon->post('/v1/processes/restore/frames', archive(@names))->{content});
ok $restored->{$_} eq $daemon->post('/v1/restore', $clouds{$_})->{content}, "restore: $_ as alone" for qw(a.ply c.ply d.ply);
my (undef, $of_form) = contents(scalar qx(curl -s @{[map { "-F x=\@$dir/frames/$_" } @names]} '$daemon->{url}$path'));
ok $of_form->{$_->[0]} eq Vt::slurp("$dir/here/$_->[1]"), "a form: $_->[0]" for ['0001.ply', 'a.ply'], ['0004.ply', 'd.ply'];

# --- results while later frames arrive ------------------------------------------------------------

# Each frame is sent once the result of the one before has been read, and no byte meanwhile, but for events the end of its chunk; then these
# bytes. What came, in chunks.
sub early {
    my ($accept, $end, @results) = @_;
    my ($socket, $got) = ($daemon->connect, '');
    my @apart = $accept =~ /event/ ? ('', "\r\n") : ("\r\n");
    my $send = sub { $socket->syswrite($_) for sprintf("%x\r\n%s%s", length $_[0], @_, $apart[0]), @apart[1 .. $#apart] };
    $socket->syswrite("POST $path HTTP/1.1\r\nHost: localhost\r\nAccept: $accept\r\nPrefer: respond-early\r\nTransfer-Encoding: chunked\r\n\r\n");
    for my $name (qw(a c d)) {
        $send->(substr archive('-b1', "$name.ply"), 0, -1024);
        $got .= Vt::read_all($socket, shift @results);
    }
    $send->($end);
    $socket->syswrite("0\r\n\r\n");
    my ($left, $text) = (body_of($got . Vt::read_all($socket)), '');
    $text .= substr $left, 0, 2 + hex $1, '' and substr($text, -2) = '' while $left =~ s/\A([0-9a-f]+)\r\n// && hex $1 > 0;
    return ($text, $left);
}

my ($text, $left) = early('application/x-tar', "\0" x 1024, map { qr/$_\.ply\0/ } qw(a c d));
my (undef, $early) = contents($text);
ok $early->{$_} eq Vt::slurp("$dir/here/$_"), "early: $_" for qw(a.ply c.ply d.ply);
is $left, "\r\n", 'and the end';
is((early('text/event-stream', "\0" x 1024, (qr/"successful"/) x 3))[0] =~ s/^(?!id: |event: ).*\n//mgr =~ tr/\n/ /r, join('', map { "id: $_ event: frame " x 2 } 1 .. 3), 'events');
($text, $left) = early('application/x-tar', 'x' x 1024, map { qr/$_\.ply\0/ } qw(a c d));
is $left, '', 'a body that is damaged then cuts the answer';

# Frames that do not depend on each other: two are computed while the next one, decoded, waits for its turn.
spew("$dir/frames/$_.ply", sphere_ply(20_000)) for 1 .. 3;
my $abreast = $daemon->events('/v1/processes/resample/frames?points=10000&method=wlop&rounds=20&steps=100', method => 'POST',
    body => archive(map { "$_.ply" } 1 .. 3), headers => { Accept => 'text/event-stream' });
my $states = sub { join ' ', map { $_->{status} } grep { $_->{voronoid}{name} =~ /^[123]\.ply$/ } @{ json($daemon->get('/v1/jobs?limit=9'))->{jobs} } };
ok wait_until(sub { $states->() eq 'accepted running running' }), 'neighbouring frames overlap';
$abreast->close;
$daemon->request('DELETE', "/v1/jobs/$_->{jobID}") for grep { $_->{voronoid}{name} =~ /^[123]/ } @{ json($daemon->get('/v1/jobs?limit=9'))->{jobs} };

# --- refusals -------------------------------------------------------------------------------------

my $whole = archive('a.ply');
spew("$dir/frames/.hidden/a.ply", '');
for (['no archive', $path, 'x' x 600, 400, 'malformed-request'], ['a part of one', $path, substr($whole, 0, 900), 400, 'malformed-request'],
    ['no frame', $path, "\0" x 1024, 422, 'empty-cloud'], ['two of one name', $path, archive('a.ply', '.hidden'), 400, 'malformed-request'],
    ['a measure', '/v1/processes/measure/frames', $whole, 400, 'invalid-parameter'], ['a name', "$path&name=n", $whole, 400, 'invalid-parameter'],
    ['a text', $path, "--b\r\nContent-Disposition: form-data; name=\"points\"\r\n\r\n3\r\n--b--\r\n", 400, 'invalid-parameter', 'Content-Type' => 'multipart/form-data; boundary=b'],
    ['a key', $path, $whole, 400, 'invalid-parameter', 'Idempotency-Key' => '"k"'], ['gzip', $path, $whole, 415, 'unsupported-format', 'Content-Encoding' => 'gzip'],
    ['images', $path, $whole, 406, 'not-acceptable', Accept => 'image/png'],
    ['a result that is not there', "$path&previous=job:00000000-0000-7000-8000-000000000000", $whole, 404, 'no-such-job']) {
    my ($what, $where, $body, $status, $slug, %headers) = @$_;
    is_problem($daemon->post($where, $body, %headers), $status, $slug, $what);
    is_problem($daemon->post($where, $body, %headers, Prefer => 'respond-early'), $status, $slug, "$what, early");
}

# --- kill -9 in the middle ------------------------------------------------------------------------

my $stream = $daemon->events($path =~ s/iterations=3/iterations=10000/r, method => 'POST', body => archive(@names), headers => { Accept => 'text/event-stream' });
my $id = json($stream->next_event->{data})->{jobID};
wait_until(sub { $daemon->status($id) eq 'running' });
$daemon->stop('KILL');
$daemon = Vt->start(dir => $dir, jobs => 2);
$daemon->post("/v1/jobs/$id/stop", '') if wait_until(sub { json($daemon->get("/v1/jobs/$id"))->{voronoid}{metrics} });
is $daemon->finish($id)->{status}, 'successful', 'the frame that was accepted runs again';
my ($listed) = contents($daemon->post("$path&previous=job:$id", archive(@names[2, 3]))->{content});
is "@$listed", 'c.json c.ply d.json d.ply', 'and the others go on from it';

done_testing;
