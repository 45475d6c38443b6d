#!/usr/bin/perl
# What simple methods make of the same input, beside the result: a table on the terminal, a member of the report here and over HTTP.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use HTTP::Tiny;
use JSON::PP;
use Test::More;

my $folder = scratch();
my $in = spew("$folder/in.ply", sphere(600));
my $out = "$folder/out.ply";
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);
my @request = ('resample', $in, '-n', 100, '-fo', $out);

my ($code, $stdout, $stderr) = run([@request]);
my $plain = slurp($out);
is $code, 0, 'a request without baselines works';
unlike $stderr, qr/kmeans|voxel/, 'and tells of none';

($code, $stdout, $stderr) = run([@request, '--baselines']);
is $code, 0, 'one with them works';
ok slurp($out) eq $plain, 'and makes the same file';
my @rows = $stderr =~ /: (result|kmeans|random|voxel|farthest) +\d+ points, delta 0\.\d{4}, sigma \S+, six neighbours 0\.\d{3}, distance from the input \S+, at most \S+$/mg;
is_deeply \@rows, [qw(result kmeans random voxel farthest)], 'the terminal has a table of them';

($code, $stdout) = run([@request, '--baselines=true', '--json']);
my $here = decode_json((split /\n/, $stdout)[-1]);
is_deeply [sort keys %{ $here->{baselines} }], [qw(farthest kmeans random voxel)], 'the report has each of them';
is_deeply [sort keys %{ $here->{baselines}{voxel} }], [qw(delta epsilon points ref_to_out sigma six_share spacing)], 'with these members';
is $here->{baselines}{random}{points}, 100, 'as many points as the result';
cmp_ok $here->{delta}, '<', $here->{baselines}{kmeans}{delta}, 'the result is more even';
is_deeply $here->{stages}[-1]{stage}, 'baselines', 'they are the last stage';

($code, $stdout) = run([@request, '--baselines', '--json', '--server', $daemon->{url}]);
is_deeply decode_json((split /\n/, $stdout)[-1])->{baselines}, $here->{baselines}, 'a daemon comes to the same numbers';
($code, $stdout, $stderr) = run([@request, '--baselines', '--server', $daemon->{url}]);
like $stderr, qr/: farthest +100 points, delta/, 'and the same table is printed';

my $http = HTTP::Tiny->new(timeout => 120);
my $refused = $http->post("$daemon->{url}/v1/resample?points=100&baselines=7", { content => slurp($in) });
is $refused->{status}, 400, 'over HTTP a value that is neither true nor false is refused';
like decode_json($refused->{content})->{detail}, qr/^baselines is "?7"?, want true or false/, 'with what is wanted';
($code, $stdout, $stderr) = run(['measure', $in, '--baselines']);
is $code, 2, 'a process that spreads nothing takes no baselines';
done_testing;
