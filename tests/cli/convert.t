#!/usr/bin/perl
# voronoid convert: PLY and Draco into each other, here and by a daemon of our own; what is left out is said in one line.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use JSON::PP;
use Test::More;

my $folder = scratch();
my $head = "ply\nformat ascii 1.0\ncomment a scan\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    . "property uchar red\nproperty uchar green\nproperty uchar blue\n";
my $mesh = spew("$folder/mesh.ply", "${head}element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    . "0 0 0 1 2 3\n1 0 0 4 5 6\n0 1 0 7 8 9\n3 0 1 2\n");
my $wanted = "ply\nformat binary_little_endian 1.0\ncomment written by voronoid\ncomment a scan\nelement vertex 3\n"
    . "property float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    . "end_header\n" . join '', map { pack 'f<3C3', @$_ } [0, 0, 0, 1, 2, 3], [1, 0, 0, 4, 5, 6], [0, 1, 0, 7, 8, 9];
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);

for my $where ([], ['--server', $daemon->{url}]) {
    my $by = @$where ? 'by a daemon' : 'here';
    my ($code, $stdout, $stderr) = run(['convert', $mesh, '-fo', "$folder/out.ply", @$where]);
    is "$code$stdout", '0', "PLY to PLY, $by" or diag($stderr);
    is slurp("$folder/out.ply"), $wanted, "with its attributes and comments, $by";
    like $stderr, qr/\Avoronoid: \S+out\.ply: 3 points, [\d.]+ s\nvoronoid: \S+out\.ply: dropped: face \(1\)\n\z/,
        "what is left out is said in one line, $by";
    ($code, $stdout, $stderr) = run(['convert', $mesh, '-fo', "$folder/out.drc", '--quantization', 0, @$where]);
    is $code, 0, "PLY to Draco, $by";
    is substr(slurp("$folder/out.drc"), 0, 5), 'DRACO', "by the suffix, $by";
    like $stderr, qr/: dropped: face \(1\), comment \(1\)\n\z/, "which has no comments, $by";
    ($code, $stdout, $stderr) = run(['convert', "$folder/out.drc", '-fo', "$folder/back.ply", '--json', @$where]);
    is "$code$stderr", '0', "and back, $by";
    is slurp("$folder/back.ply"), $wanted =~ s/comment a scan\n//r, "bit for bit, $by";
    my $report = decode_json((split /\n/, $stdout)[-1]);
    is_deeply $report->{dropped}, [], "without loss, $by";
    is $report->{parameters}{format}, 'ply', "the report says the format, $by";
    is +(run(['convert', $mesh, '-fo', "$folder/out.ply", '-q', @$where]))[2], '', "--quiet says nothing, $by";
}
is +(run(['convert', $mesh, '-fo', '-', '--quiet']))[1], $wanted, 'stdout has the format of the input';
my ($code, $stdout, $stderr) = run(['convert', $mesh, '-fo', "$folder/out.xyz"]);
is "$code$stdout$stderr", "2voronoid: convert: the output's suffix is .xyz, want one of .ply, .drc; or say --format\n",
    'a format that is not served is refused';

# Points that are not finite.
my $sick = spew("$folder/sick.ply", slurp($mesh) =~ s/element vertex 3/element vertex 4/r =~ s/3 0 1 2/nan 0 0 1 1 1\n3 0 1 2/r);
($code, $stdout, $stderr) = run(['convert', $sick, '-fo', "$folder/no.ply"]);
is "$code$stdout$stderr", "3voronoid: $sick: 1 of 4 points are not finite, the first is point 3: its x is nan; "
    . "invalid=drop leaves them out\n", 'such a point is refused';
for my $where ([], ['--server', $daemon->{url}]) {
    ($code, $stdout, $stderr) = run(['convert', $sick, '-fo', "$folder/well.ply", '--invalid=drop', @$where]);
    is $code, 0, 'unless it is to be dropped';
    is slurp("$folder/well.ply"), $wanted, 'then the others are converted';
    like $stderr, qr/: dropped: invalid point \(1\), face \(1\)\n\z/, 'which is said';
}
is decode_json((run(['measure', $sick, '--invalid', 'drop']))[1])->{invalid}, 1, 'measure counts it too';
done_testing();
