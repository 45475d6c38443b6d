#!/usr/bin/perl
# sample=faces over HTTP: PLY in every encoding and Draco, the same after a crash and of a job's input, and what is refused.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my @corners = map { [$_ & 1, $_ >> 1 & 1, $_ >> 2] } 0 .. 7;
my @faces = ([0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]);

sub cube {
    my ($format, @faces) = @_;
    my $float = $format eq 'binary_big_endian' ? 'f>' : 'f<';
    my $int = $format eq 'binary_big_endian' ? 'l>' : 'l<';
    my $body = $format eq 'ascii'
        ? join('', map { "@$_\n" } @corners, map { [scalar @$_, @$_] } @faces)
        : join('', (map { pack "${float}3", @$_ } @corners), map { pack "C${int}*", scalar @$_, @$_ } @faces);
    return "ply\nformat $format 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face "
        . @faces . "\nproperty list uchar int vertex_indices\nend_header\n$body";
}

sub job_of { return $_[0]{headers}{location} =~ m{(/v1/jobs/[^/]+)\z} ? $1 : die 'no Location' }
my $daemon = Vt->start;
sub report_of { return json($daemon->get(job_of($_[0]) . '/results/report')) }

my $query = 'points=500&iterations=2&polish=3&sample=faces';
my $cube = cube('binary_little_endian', @faces);
my $first = $daemon->post("/v1/resample?$query", $cube);
is $first->{status}, 200, 'a cube of eight vertices is resampled' or diag($first->{content});
my $report = report_of($first);
is_deeply [@$report{qw(faces samples dropped)}], [6, 10000, []], 'the report counts faces and samples';
is_deeply $report->{points}, { in => 8, out => 500 }, 'and points';
is $daemon->post("/v1/resample?$query", cube($_, @faces))->{content}, $first->{content}, "$_ is the same"
    for 'ascii', 'binary_big_endian';
isnt $daemon->post("/v1/resample?$query&seed=2", $cube)->{content}, $first->{content}, 'another seed draws others';
my $again = $daemon->post("/v1/resample?$query&input=job:" . (job_of($first) =~ s{.*/}{}r), '');
is $again->{content}, $first->{content}, 'the input of a job has its faces';
$again = $daemon->post('/v1/resample?points=8&iterations=2&input=job:' . (job_of($first) =~ s{.*/}{}r), '');
is report_of($again)->{samples}, 0, 'which need not be sampled';
is_deeply report_of($again)->{dropped}, [{ what => 'face', count => 6 }], 'and are then left out';
is report_of($again)->{faces}, 6, 'but counted';
is $daemon->post('/v1/upsample?ratio=16&iterations=1&polish=0&sample=faces', $cube)->{status}, 200, 'a ratio counts vertices';
is $daemon->post('/v1/resample?points=200&iterations=1&polish=0&sample=faces',
    Vt::slurp("$FindBin::Bin/../fuzz/corpus/draco/mesh-sequential.drc"))->{status}, 200, 'a Draco mesh has faces';

# --- what is refused ------------------------------------------------------------------------------

for my $case (
    ['no faces', cube('ascii'), 'unusable-faces', qr/^sample=faces needs faces .*but the input has 8 points and no faces/],
    ['faces without area', cube('ascii', [0, 1, 1], [2, 2, 2]), 'unusable-faces', qr/ all 2 triangles of the input have area 0/],
    ['a corner that is no vertex', cube('ascii', @faces, [0, 8, 1]), 'undecodable-cloud', qr/^corner 1 of face 6 is vertex 8, want 0 to 7$/],
    ['a corner below 0', cube('binary_little_endian', @faces, [0, 1, -1]), 'undecodable-cloud', qr/^corner 2 of face 6 is vertex -1, want 0 to 7$/],
    ['faces that are cut', substr($cube, 0, -1), 'undecodable-cloud', qr/ bytes are left$/],
) {
    my ($what, $body, $slug, $detail) = @$case;
    my $refused = $daemon->post("/v1/resample?$query", $body);
    is_problem($refused, 422, $slug, $what);
    like json($refused)->{detail}, $detail, "$what: the answer says it";
    is json($refused)->{errors}[0]{parameter}, 'sample', "$what: and the parameter" if $slug eq 'unusable-faces';
    is $daemon->post('/v1/resample?points=8&iterations=1', $body)->{status}, 200, "$what: nobody looks at it who does not ask";
}
is_problem($daemon->post('/v1/resample?points=8&sample=edges', $cube), 400, 'invalid-parameter', 'a word that there is not');
is_problem($daemon->post('/v1/simplify?points=9&sample=faces', $cube), 422, 'target-out-of-range', 'simplify counts vertices');
is_problem($daemon->post('/v1/resample?spacing=1e-9&sample=faces', $cube), 422, 'target-out-of-range', 'more than ten million points');

# --- a crash --------------------------------------------------------------------------------------

my $long = 'points=4000&iterations=30&sample=faces';
my $want = $daemon->post("/v1/resample?$long", $cube)->{content};
my $id = $daemon->submit($long, $cube);
is $daemon->stop('KILL'), 'signal 9', 'a daemon is killed';
$daemon = Vt->start(dir => $daemon->{dir});
is $daemon->finish($id)->{status}, 'successful', 'its job goes on when it is back';
is $daemon->get("/v1/jobs/$id/results/cloud")->{content}, $want, 'with the faces that it had';
is $daemon->stop, 0, 'it ends with 0';

done_testing;
