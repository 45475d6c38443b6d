#!/usr/bin/perl
# inspect over HTTP: a process whose only output is a document.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $daemon = Vt->start;
my $points = 800;
my $cloud = sphere_ply($points);

my $described = json($daemon->get('/v1/processes/inspect'));
is_deeply [sort keys %{ $described->{inputs} }], [qw(cloud intrinsic invalid outliers)], 'its inputs are described';
is_deeply $described->{inputs}{intrinsic}{schema},
    { type => 'string', enum => [qw(local satellites none)], default => 'local' }, 'with words and default';
is $described->{inputs}{outliers}{schema}{default}, 'drop', 'outliers are left aside';
is_deeply [keys %{ $described->{outputs} }], ['inspect'], 'its output is the document';
my $schema = $described->{outputs}{inspect}{schema};
is $schema->{properties}{noise}{'x-unit'}, 'unit of the cloud', 'which has units';

for my $path ('/v1/inspect', '/v1/processes/inspect/execution') {
    my $answer = $daemon->post($path, $cloud);
    is $answer->{status}, 200, "POST $path answers" or diag($answer->{content});
    is $answer->{headers}{'content-type'}, 'application/json', 'with JSON';
    is $answer->{headers}{etag}, '"' . sha256_hex($answer->{content}) . '"', 'and its ETag';
    my $told = json($answer);
    is_deeply [sort keys %$told], [sort keys %{ $schema->{properties} }], 'the document has the members described';
    is_deeply $told->{points}, { all => $points, invalid => 0, distinct => $points, outliers => 0 }, 'it counts the points';
    my ($id) = $answer->{headers}{location} =~ m{/v1/jobs/([^/]+)\z};
    is $daemon->get("/v1/jobs/$id/results/inspect")->{content}, $answer->{content}, 'and stays at results';
}
is_problem($daemon->post('/v1/inspect', $cloud, Accept => 'application/ply'), 406, 'not-acceptable', 'it is no cloud');
is_problem($daemon->post('/v1/inspect?points=5', $cloud), 400, 'invalid-parameter', 'it takes no points');
is json($daemon->post('/v1/inspect?points=5', $cloud))->{detail}, 'unknown parameter "points" of inspect; want outliers, intrinsic, invalid',
    'and says what it takes';
is_problem($daemon->post('/v1/inspect?intrinsic=global', $cloud), 400, 'invalid-parameter', 'a word that there is not');

my $accepted = $daemon->post('/v1/inspect?intrinsic=satellites&outliers=keep', $cloud, Prefer => 'respond-async');
is $accepted->{status}, 201, 'a job is accepted';
my $id = json($accepted)->{jobID};
my $job = $daemon->finish($id);
is $job->{status}, 'successful', 'it ends well';
ok !exists $job->{voronoid}{target}, 'it has no target';
my $path = "/v1/jobs/$id/results/inspect";
my $address = "$daemon->{url}$path";
my ($end) = map { json($_->{data}) } grep { $_->{event} eq 'end' } $daemon->events("/v1/jobs/$id/events")->all;
is_deeply [@$end{qw(status href outputs)}], ['successful', $address, { inspect => $address }], 'its end has the address of the document';
ok !exists $end->{report}, 'and none of a report';
is_deeply json($daemon->get("/v1/jobs/$id/trace"))->{records}, [], 'its trace has no records';

# The document is served as any output.
my $document = $daemon->get($path);
my $etag = '"' . sha256_hex($document->{content}) . '"';
is_deeply [@{ $document->{headers} }{qw(content-type accept-ranges etag content-disposition)}],
    ['application/json', 'bytes', $etag, qq(attachment; filename="$id.inspect.json")], 'it has a type, a digest and a name';
my $length = length $document->{content};
my $head = $daemon->request('HEAD', $path);
is "$head->{status} $head->{headers}{'content-length'} " . ($head->{content} // ''), "200 $length ", 'HEAD tells its length';
my $part = $daemon->get($path, headers => { Range => 'bytes=0-4' });
is "$part->{status} $part->{content}", '206 ' . substr($document->{content}, 0, 5), 'a part of it can be had';
is $daemon->get($path, headers => { 'If-None-Match' => $etag })->{status}, 304, 'who has it is told so';
is_deeply json($daemon->get("/v1/jobs/$id/results")), { inspect => { href => $address, type => 'application/json' } }, 'results list it';
is_deeply [map { [@$_{qw(title type length)}] } grep { $_->{rel} eq 'item' } @{ $job->{links} }],
    [['inspect', 'application/json', $length]], 'the job links to it alone';
for my $other (qw(cloud report inspec inspects input)) {
    my $none = $daemon->get("/v1/jobs/$id/results/$other");
    is_problem($none, 404, 'no-such-output', "there is no $other");
    is json($none)->{detail}, "there is no output $other, want inspect", 'the answer says what there is';
}
is $daemon->request('DELETE', "/v1/jobs/$id")->{status}, 200, 'the job is deleted';
is $daemon->get($path)->{status}, 404, 'and the document with it';

# A square that was sampled evenly has a rim, and a hole where points are missing.
my @place = grep { ($_->[0] - 20)**2 + ($_->[1] - 25)**2 >= 36 } map { my $y = $_; map { [$_, $y] } 0 .. 49 } 0 .. 49;
my $holed = $daemon->post('/v1/inspect', sprintf("ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
        . "property float z\nend_header\n%s", scalar @place,
    join '', map { pack 'f<3', $_->[0] + 0.1 * sin(5 * $_->[1]), $_->[1] + 0.1 * sin(9 * $_->[0]), 0 } @place));
is $holed->{status}, 200, 'a square with a hole is told of' or diag($holed->{content});
my $border = json($holed);
is_deeply [map { "$_->{id} $_->{kind}" } @{ $border->{loops} }], ['1 rim', '2 hole'], 'it has a rim, and a hole';
is_deeply [@{ $border->{border} }{qw(loops holes open)}], [2, 1, 0], 'which are counted';
my ($rim, $hole) = @{ $border->{loops} };
cmp_ok abs($rim->{length} - 199), '<', 6, 'the rim is as long as the sides';
cmp_ok abs($hole->{length} - 37.7), '<', 3.8, 'the hole as its circle';
cmp_ok abs($hole->{centre}{x} - 20) + abs($hole->{centre}{y} - 25) + abs($hole->{centre}{z}), '<', 1, 'and where that was';
is_deeply [sort keys %$hole], [sort keys %{ $schema->{properties}{loops}{items}{properties} }], 'a loop has the members described';

# A line is no surface; the job says so.
my $line = join '', map { pack 'f<3', $_, 0, 0 } 1 .. 30;
my $answer = $daemon->post('/v1/inspect',
    "ply\nformat binary_little_endian 1.0\nelement vertex 30\nproperty float x\nproperty float y\nproperty float z\nend_header\n$line");
is $answer->{status}, 422, 'a line is refused';
done_testing();
