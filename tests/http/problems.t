#!/usr/bin/perl
# Every mistake gets its own problem: status, type, and the value with the allowed range.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start('body-limit' => '200K', 'points-limit' => 5000);
my $cloud = sphere_ply(500);
my $none = '0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11';

# Parameters, decided before the body is read.
for my $case (
    ['points=0', qr/points is 0, want a whole number from 1 to 10000000/, 'points'],
    ['points=', qr/points is empty/, 'points'],
    ['', qr/points, ratio and spacing: none/, 'points'],
    ['points=10&ratio=0.5', qr/points, ratio and spacing, not 2/, 'points'],
    ['points=10&points=10', qr/points is given more than once/, 'points'],
    ['points=10&neighbours=6', qr/^unknown parameter "neighbours" of resample; nearest: neighbors, \w+, \w+$/, 'neighbours'],
    ['points=10&peak=6', qr/^unknown parameter "peak" of resample; nearest: \w+, \w+, \w+$/, 'peak'],
    ['points=10&neighbors=5', qr/neighbors is 5, want .* from 6 to 500 or auto/, 'neighbors'],
    ['points=10&boundary=open', qr/boundary is "open", want one of keep, free, sites, fill/, 'boundary'],
    ['ratio=1e999', qr/ratio is 1e999/, 'ratio'],
    ['points=10&seconds=-1', qr/seconds is -1/, 'seconds'],
    ['points=10&polish=0&polish=0', qr/polish is given more than once/, 'polish'],
    ['points=10&compression=11', qr/from 0 to 10/, 'compression'],
) {
    my ($query, $detail, $parameter) = @$case;
    my $answer = $daemon->post("/v1/resample?$query", $cloud);
    refused($answer, 400, 'invalid-parameter', $detail, "?$query");
    is_deeply json($answer)->{errors}, [{ parameter => $parameter }], "?$query: errors[] names the parameter, and detail alone says the rest";
}
# A list that can be read, with a word that is none of its own.
for my $query ('filters=blur', 'filters=mls,blur', 'points=10&filters=mls,none') {
    my $answer = $daemon->post("/v1/resample?$query", $cloud);
    refused($answer, 422, 'unknown-word', qr/^filters is "[a-z,]+", want words separated by commas, each at most once: mls, outliers, thin, or none$/,
        "?$query");
    is json($answer)->{errors}[0]{parameter}, 'filters', "?$query: errors[] names the parameter";
    ok !defined json($answer)->{jobID}, "?$query: and there is no job";
}
refused($daemon->post("/v1/resample?filters=$_", $cloud), 400, 'invalid-parameter', qr/^filters is .*, want words separated by commas, each at most once: /,
    "?filters=$_, which is no list") for '', 'mls,mls', 'mls,';
is_problem($daemon->post('/v1/resample?points=%zz', $cloud), 400, 'malformed-request',
    'a malformed escape');
is_problem($daemon->post('/v1/resample?points=1%00', $cloud), 400, 'malformed-request',
    'a NUL in the query');
is_problem($daemon->post('/v1/resample?' . join('&', map { "a$_=1" } 1 .. 65), $cloud), 400,
    'malformed-request', 'more than 64 pairs');
is_problem($daemon->post('/v1/resample?points=10', $cloud, Accept => 'image/png'), 406,
    'not-acceptable', 'an Accept nobody can serve');
is_problem($daemon->post('/v1/resample?points=10&format=drc', $cloud, Accept => 'application/ply'), 406,
    'not-acceptable', 'an Accept that leaves the format out');
is_problem($daemon->post('/v1/processes/nope/execution?points=10', $cloud), 404, 'no-such-process',
    'a process that is not');

# Bytes.
my $count = 0;
for my $case (
    ['', 422, 'empty-cloud', qr/./, 'no bytes'],
    ['{"points":3}', 415, 'unsupported-format', qr{^the input is JSON, want PLY or Draco: }, 'JSON'],
    ['PK' . "\3\4" . 'x' x 100, 415, 'unsupported-format', qr{^the input is ZIP, want PLY or Draco: unpack it with unzip$}, 'a zip file'],
    ["ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
        . "end_header\n", 422, 'empty-cloud', qr/./, 'no points'],
    ["ply\nformat ascii 1.0\nelement vertex 6000\nproperty float x\nproperty float y\n"
        . "property float z\nend_header\n", 413, 'too-many-points', qr/6000.*5000/,
        'more points declared than allowed'],
    ["ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
        . "end_header\n1 nan 2\n", 422, 'non-finite-points', qr/./, 'a coordinate that is none'],
    [substr($cloud, 0, 3000), 422, 'undecodable-cloud', qr/./, 'a PLY file cut short'],
    ["ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n", 422, 'undecodable-cloud', qr/./,
        'a PLY header without an end'],
    ["ply\nformat ascii 1.0\nelement vertex 4294967295\nproperty double x\nproperty double y\n"
        . "property double z\nend_header\n", 413, 'too-many-points', qr/4294967295/, 'a PLY bomb'],
    ['DRACO' . "\0" x 20, 422, 'undecodable-cloud', qr/./, 'a Draco file of zeros'],
    ['DRACO' . "\2\3\0\1\0\0" . "\xff" x 20, 422, 'undecodable-cloud', qr/./,
        'a Draco file of ones'],
    ['DRACO', 422, 'undecodable-cloud', qr/./, 'nothing but a magic'],
) {
    my ($bytes, $status, $slug, $detail, $name) = @$case;
    refused($daemon->post('/v1/resample?points=10', $bytes), $status, $slug, $detail, $name);
    $count++;
}
refused($daemon->post('/v1/resample?points=10', $cloud x 40), 413, 'too-many-bytes',
    qr/the body has \d+ bytes, want at most 204800/, 'a body beyond the limit');
my $limit = json($daemon->post('/v1/resample?points=10', $cloud x 40));
is $limit->{limit}, 204800, 'a body beyond the limit: the limit';
is $limit->{got}, 40 * length $cloud, 'a body beyond the limit: what it has';
refused($daemon->post('/v1/resample?points=9000', $cloud), 422, 'target-out-of-range', qr/9000/,
    'more than 16 times as many points');
my $line = "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\n"
    . "property float z\nend_header\n" . join('', map { "$_ 0 0\n" } 1 .. 9);
my $flat = $daemon->post('/v1/resample?points=5', $line);
refused($flat, 422, 'degenerate-cloud', qr/./, 'points on a line');
refused($daemon->post('/v1/resample?points=10&inputNormals=use', $cloud), 422, 'unusable-normals', qr/none of the input.s \d+ points has a normal/,
    'normals to be used that are not there');
refused($daemon->post('/v1/resample?points=10&density=attribute:height', $cloud), 422, 'unusable-density',
    qr/no attribute height; its scalars are none/, 'a density that is not there');
refused($daemon->post('/v1/resample?points=10&density=edges', $cloud), 422, 'unusable-density',
    qr/density=edges needs sharp edges, but none of the input's \d+ points lies on one: use uniform, curvature or attribute:NAME/,
    'edges of what has none');
refused($daemon->post('/v1/resample?points=10&metric=attribute:shape', $cloud), 422, 'unusable-metric',
    qr/no tensors shape, want six scalars NAME_xx, .*; its tensors are none/, 'a metric that is not there');
refused($daemon->post('/v1/resample?points=3&method=kmeans&metric=anisotropic', $cloud), 422, 'unusable-metric',
    qr/kmeans does not support a metric/, 'a metric that the method does not follow');
my $splats = $line =~ s/end_header\n.*//sr . join('', map { "property float $_\n" } qw(f_dc_0 opacity scale_0 rot_0)) . "end_header\n";
$splats =~ s/vertex 9/vertex 500/;
$splats .= join '', map { join(' ', cos($_), sin($_), $_ / 500, 1 .. 4) . "\n" } 1 .. 500;
refused($daemon->post("/v1/$_", $splats), 422, 'gaussian-splats', qr/^the cloud is a 3D Gaussian splat .*; .*\. attributes=drop resamples the positions alone/,
    "splats would move: $_") for 'resample?points=10', 'denoise?filters=mls';
is $daemon->post("/v1/$_", $splats)->{status}, 200, "and here they do not: $_"
    for 'resample?points=10&attributes=drop', 'denoise?filters=outliers', 'convert?format=drc', 'measure', 'inspect';
for my $case (
    ['metric=lp&method=kmeans', qr/^metric=lp works only with method=cvt$/, 'a metric with kmeans'],
    ['edges=sites&method=wlop', qr/^edges=sites does not work with method=wlop: use ignore/, 'sites with wlop'],
    ['cells=euclid&method=kmeans', qr/^cells=euclid works only with method=cvt$/, 'cells with kmeans'],
    ['metric=lp&density=curvature', qr/^metric=lp works only with density=uniform$/, 'a metric with a density'],
    ['cells=euclid&density=curvature', qr/^cells=euclid works only with density=uniform/, 'cells with a density'],
) {
    my ($query, $detail, $name) = @$case;
    refused($daemon->post("/v1/resample?points=10&$query", $cloud), 400, 'invalid-parameter', $detail, $name);
}
refused($daemon->post('/v1/resample?points=10&boundary=fill&holes=7', $cloud), 422, 'unknown-hole',
    qr/holes contains 7, (?:but the input has no border loops|but the border loops are numbered from 1 to)/, 'a hole that is not there');
refused($daemon->post('/v1/resample?points=10&method=kmeans&edges=sites', $cloud), 400, 'invalid-parameter',
    qr/method=kmeans does not support edges=sites: use edges=ignore or method=cvt/, 'sites of a method that has none');
my $job = json($flat)->{jobID};
ok defined $job, 'a failed job is named';
is json($flat)->{instance}, "/v1/jobs/$job", 'as the instance';
my $failed = json($daemon->get("/v1/jobs/$job"));
is $failed->{status}, 'failed', 'its status says failed';
is $failed->{exception}{status}, 422, 'with the same problem';
is_deeply [map { @$_{qw(type attempt)} } $failed->{exception}, json($flat)], [(json($flat)->{type}, 1) x 2],
    'of the same type, of the first attempt';
# The exact shape of a statusInfo and of a problem: members, their order, what is left out. U: an address, N: a number, T: a time.
my $shape = $daemon->get("/v1/jobs/$job")->{content} =~ s/\Q$job\E/J/gr =~ s{http://[^"]+}{U}gr =~ s/"\d{4}-[^"]+Z"/T/gr =~ s/"[0-9a-f]{64}"/S/r;
my $was = json($flat)->{detail};
is $shape, '{"jobID":"J","id":"J","type":"process","processID":"resample","status":"failed","message":"' . $was . '","progress":' . $failed->{progress} .
    ',"created":T,"started":T,"updated":T,"finished":T,"voronoid":{"attempt":1,"stage":null,"queuePosition":null,"eta":null,' .
    qq("input":{"format":"ply","points":9,"bytes":${\length $line},"sha256":S},"parameters":{"points":5,"format":"ply"},"target":{"points":5,"format":"ply"},"metrics":null},) .
    '"exception":{"type":"U","title":"' . json($flat)->{title} . qq(","status":422,"detail":"$was","instance":"/v1/jobs/J","retryable":false,"jobID":"J","attempt":1},) .
    '"links":[' . join(',', '{"rel":"self","type":"application/json","href":"U"}',
        qq({"rel":"input","type":"$failed->{links}[1]{type}","href":"U","length":${\length $line}}), '{"rel":"up","type":"application/json","href":"U"}') . "]}\n",
    'a statusInfo has its shape';
like $flat->{content}, qr/^\{"type":"[^"]+","title":"[^"]+","status":422,"detail":"[^"]+","instance":"[^"]+","retryable":false,"requestId":"[^"]+","jobID":"$job","attempt":1\}\n\z/,
    'a problem has its shape';
is_problem($daemon->get("/v1/jobs/$job/results"), 422, 'degenerate-cloud',
    'its results answer with the problem');
is_problem($daemon->get("/v1/jobs/$job/results/cloud"), 422, 'degenerate-cloud', 'its cloud too');

is json($daemon->get("/v1/jobs/$job/results/mesh"))->{detail}, 'there is no output mesh, want cloud or report',
    'who asks for an output that is none is told which there are';

# Paths and methods.
for my $case (
    ['GET', '/nope', 404, 'no-such-resource'], ['GET', '/v2', 404, 'no-such-resource'],
    ['GET', '/v1/jobs/', 404, 'no-such-resource'], ['GET', '/v1//jobs', 404, 'no-such-resource'],
    ['GET', '/v1/../v1/jobs', 404, 'no-such-resource'],
    ['GET', '/v1/processes/nope', 404, 'no-such-process'],
    ['GET', "/v1/jobs/$none", 404, 'no-such-job'], ['DELETE', "/v1/jobs/$none", 404, 'no-such-job'],
    ['GET', '/v1/jobs/x', 404, 'no-such-job'],
    ['GET', '/v1/jobs/' . uc $none, 404, 'no-such-job'],
    ['POST', "/v1/jobs/$none/stop", 404, 'no-such-job'],
    ['GET', "/v1/jobs/$none/events", 404, 'no-such-job'],
    ['GET', "/v1/jobs/$none/trace", 404, 'no-such-job'],
    ['GET', "/v1/jobs/$none/results", 404, 'no-such-job'],
    ['GET', "/v1/jobs/$none/results/cloud", 404, 'no-such-job'],
    ['GET', "/v1/jobs/$job/results/mesh", 404, 'no-such-output'],
    ['POST', "/v1/jobs/$job/stop", 409, 'not-running'],
    ['GET', "/v1/jobs/$job/events?lastEventId=x", 400, 'invalid-query-parameter-value'],
    ['GET', '/problems/nope', 404, 'no-such-resource'],
    ['GET', '/v1/jobs?limit=0', 400, 'invalid-query-parameter-value'],
    ['GET', '/v1/jobs?limit=10001', 400, 'invalid-query-parameter-value'],
    ['GET', '/v1/jobs?limit=1e1', 400, 'invalid-query-parameter-value'],
    ['GET', '/v1/jobs?status=done', 400, 'invalid-query-parameter-value'],
    ['GET', '/v1/jobs?cursor=x', 400, 'invalid-query-parameter-value'],
    ['GET', '/v1/jobs?type=service', 400, 'invalid-query-parameter-value'],
    (map { ['GET', "/v1/jobs?datetime=$_", 400, 'invalid-query-parameter-value'] } '', '/', '2026-11-21',
        '2026-11-21T03:15:34', '2026-13-21T03:15:34Z', '2026-11-21T03:15:34.Z', '2026-11-21T03:15:34.5',
        '2026-11-21%2003:15:34Z', '2026-11-21T03:15:34Z/x', 'x/..', '../../..', '+026-11-21T03:15:34Z'),
    (map { ['GET', "/v1/jobs?minDuration=$_", 400, 'invalid-query-parameter-value'] } '', '-1', '1.5', 'x',
        '1000000001', '999999999999999999'),
    ['GET', '/v1/jobs?maxDuration=-1', 400, 'invalid-query-parameter-value'],
    ['GET', '/v1/jobs?colour=red', 400, 'invalid-query-parameter-value'],
    ['PUT', '/v1/jobs', 405, 'method-not-allowed'], ['POST', '/livez', 405, 'method-not-allowed'],
    ['GET', '/v1/resample', 405, 'method-not-allowed'],
    ['PATCH', "/v1/jobs/$none", 405, 'method-not-allowed'],
) {
    my ($method, $path, $status, $slug) = @$case;
    is_problem($daemon->request($method, $path), $status, $slug, "$method $path");
}
is $daemon->request('PUT', '/v1/resample')->{headers}{allow}, 'POST, OPTIONS', '405 lists the methods';
is $daemon->request('POST', "/v1/jobs/$none")->{headers}{allow}, 'GET, HEAD, DELETE, OPTIONS',
    '405 lists every method of the path';
my $options = $daemon->request('OPTIONS', '/v1/jobs');
is $options->{status}, 204, 'OPTIONS answers 204';
is $options->{headers}{allow}, 'GET, HEAD, OPTIONS', 'with the methods';

# What is echoed.
my $named = $daemon->get('/nope', headers => { 'X-Request-Id' => 'a.b_c-1' });
is $named->{headers}{'x-request-id'}, 'a.b_c-1', 'a sane X-Request-Id comes back';
is json($named)->{requestId}, 'a.b_c-1', 'in the problem as well';
for my $id ('a b', '<x>', 'x' x 65) {
    isnt $daemon->get('/nope', headers => { 'X-Request-Id' => $id })->{headers}{'x-request-id'}, $id,
        "the X-Request-Id \"$id\" does not";
}
is $daemon->get('/nope', headers => { Accept => 'application/json' })->{headers}{'content-type'},
    'application/json', 'who accepts application/json alone gets a problem as that';
my ($type) = json($daemon->get('/nope'))->{type} =~ m{^\Q$daemon->{url}\E(/.*)};
is $daemon->get($type)->{status}, 200, 'the type of a problem leads to a page';
ok((grep { ($_->{status} // '') eq '422' && $_->{problem} eq 'undecodable-cloud' } $daemon->log_lines),
    'the log names the problem');
ok !(grep { ($_->{status} // '') eq '200' && defined $_->{problem} } $daemon->log_lines),
    'where there was one';
is $daemon->get('/livez')->{status}, 200, "the daemon lives after all of this";
is scalar(grep { $_->{status} && $_->{status} =~ /^50[^3]/ } $daemon->log_lines), 0,
    'and nothing was our own fault';
is $daemon->stop, 0, 'it ends with 0';
done_testing;
