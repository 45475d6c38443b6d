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
is_deeply [sort keys %{ $described->{inputs} }], [qw(cloud intrinsic invalid outliers vcm)], 'its inputs are described';
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
    is_deeply [sort keys %$told], [sort grep { $_ ne 'vcm' } keys %{ $schema->{properties} }], 'the document has the members described';
    is_deeply $told->{points}, { all => $points, invalid => 0, distinct => $points, outliers => 0 }, 'it counts the points';
    my ($id) = $answer->{headers}{location} =~ m{/v1/jobs/([^/]+)\z};
    is $daemon->get("/v1/jobs/$id/results/inspect")->{content}, $answer->{content}, 'and stays at results';
}
is_problem($daemon->post('/v1/inspect', $cloud, Accept => 'application/ply'), 406, 'not-acceptable', 'it is no cloud');
is_problem($daemon->post('/v1/inspect?points=5', $cloud), 400, 'invalid-parameter', 'it takes no points');
is json($daemon->post('/v1/inspect?points=5', $cloud))->{detail}, 'unknown parameter "points" of inspect; nearest: outliers, vcm, intrinsic',
    'and says what it takes';

my $accepted = $daemon->post('/v1/inspect?intrinsic=satellites&outliers=keep&vcm=true', $cloud, Prefer => 'respond-async');
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
is_deeply json($document)->{vcm}, { points => 0, common => 0 }, 'a sphere has no edges by VCM';
my $etag = '"' . sha256_hex($document->{content}) . '"';
is_deeply [@{ $document->{headers} }{qw(content-type accept-ranges etag content-disposition)}],
    ['application/json', 'bytes', $etag, qq(attachment; filename="$id.inspect.json")], 'it has a type, a digest and a name';
is_deeply json($daemon->get("/v1/jobs/$id/results")), { inspect => { href => $address, type => 'application/json' } }, 'results list it';
is_deeply [map { [@$_{qw(title type length)}] } grep { $_->{rel} eq 'item' } @{ $job->{links} }],
    [['inspect', 'application/json', length $document->{content}]], 'the job links to it alone';
is_problem($daemon->get("/v1/jobs/$id/results/$_"), 404, 'no-such-output', "there is no $_") for qw(cloud report inspec inspects input);
is $daemon->request('DELETE', "/v1/jobs/$id")->{status}, 200, 'the job is deleted';
is $daemon->get($path)->{status}, 404, 'and the document with it';

done_testing();
