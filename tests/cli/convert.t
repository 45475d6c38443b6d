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
    . "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    . join('', map { pack 'f<3C3', @$_ } [0, 0, 0, 1, 2, 3], [1, 0, 0, 4, 5, 6], [0, 1, 0, 7, 8, 9]) . pack 'Cl<3', 3, 0, 1, 2;
# Each face continues the fan of the one before.
my $polygons = spew("$folder/polygons.ply", "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
    . "property float z\nelement face 3\nproperty list uchar int vertex_indices\nend_header\n"
    . "0 0 0\n3 0 0\n2 2 0\n0 3 0\n-2 2 0\n-2 -2 1\n3 0 1 2\n4 0 2 3 4\n4 0 4 5 1\n");

# The faces of a PLY file of ours with 6 points, each from its smallest corner on.
sub faces_of {
    my $text = slurp($_[0]) =~ s/.*?end_header\n//sr;
    my ($at, @faces) = (72);
    while ($at < length $text) {
        my @face = unpack 'C/l<', substr $text, $at;
        $at += 1 + 4 * @face;
        push @face, shift @face until $face[0] == (sort { $a <=> $b } @face)[0];
        push @faces, "@face";
    }
    return join ', ', sort @faces;
}
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);

for my $where ([], ['--server', $daemon->{url}]) {
    my $by = @$where ? 'by a daemon' : 'here';
    my ($code, $stdout, $stderr) = run(['convert', $mesh, '-fo', "$folder/out.ply", @$where]);
    is "$code$stdout", '0', "PLY to PLY, $by" or diag($stderr);
    is slurp("$folder/out.ply"), $wanted, "with its attributes, faces and comments, $by";
    like $stderr, qr/\Avoronoid: \S+out\.ply: 3 points, [\d.]+ s\n\z/, "nothing is left out, $by";
    ($code, $stdout, $stderr) = run(['convert', $mesh, '-fo', "$folder/out.drc", '--quantization', 0, @$where]);
    is $code, 0, "PLY to Draco, $by";
    is substr(slurp("$folder/out.drc"), 0, 5), 'DRACO', "by the suffix, $by";
    like $stderr, qr/\nvoronoid: \S+out\.drc: dropped: comment \(1\)\n\z/, "which has no comments, as one line says, $by";
    ($code, $stdout, $stderr) = run(['convert', "$folder/out.drc", '-fo', "$folder/back.ply", '--json', @$where]);
    is "$code$stderr", '0', "and back, $by";
    is slurp("$folder/back.ply"), $wanted =~ s/comment a scan\n//r, "bit for bit, $by";
    my $report = decode_json((split /\n/, $stdout)[-1]);
    is_deeply $report->{dropped}, [], "without loss, $by";
    is $report->{parameters}{format}, 'ply', "the report says the format, $by";
    is +(run(['convert', $mesh, '-fo', "$folder/out.ply", '-q', @$where]))[2], '', "--quiet says nothing, $by";
    ($code, $stdout, $stderr) = run(['convert', $polygons, '-fo', "$folder/out.ply", @$where]);
    is faces_of("$folder/out.ply"), '0 1 2, 0 2 3 4, 0 4 5 1', "polygons of a PLY file stay what they are, $by" or diag($stderr);
    ($code, $stdout, $stderr) = run(['convert', $polygons, '-fo', "$folder/out.drc", '--quantization', 0, @$where]);
    like $stderr, qr/\nvoronoid: \S+out\.drc: dropped: polygon, cut into triangles \(2\)\n\z/, "for Draco they are cut, $by";
    run(['convert', "$folder/out.drc", '-fo', "$folder/back.ply", @$where]);
    is scalar(split /, /, faces_of("$folder/back.ply")), 5, "into triangles, $by";
}
is +(run(['convert', $mesh, '-fo', '-', '--quiet']))[1], $wanted, 'stdout has the format of the input';
my ($code, $stdout, $stderr) = run(['convert', $mesh, '-fo', "$folder/out.xyz"]);
is "$code$stdout$stderr", "2voronoid: convert: the suffix of the output is .xyz, want one of .ply, .drc, or give --format\n",
    'a format that is not served is refused';

# Points that are not finite.
my $sick = spew("$folder/sick.ply", slurp($mesh) =~ s/element vertex 3/element vertex 4/r =~ s/3 0 1 2/nan 0 0 1 1 1\n3 0 1 2/r);
($code, $stdout, $stderr) = run(['convert', $sick, '-fo', "$folder/no.ply"]);
is "$code$stdout$stderr", "3voronoid: $sick: 1 of 4 points have a coordinate that is not finite. The first is point 3: its x is nan. "
    . "invalid=drop leaves such points out\n", 'such a point is refused';
for my $where ([], ['--server', $daemon->{url}]) {
    ($code, $stdout, $stderr) = run(['convert', $sick, '-fo', "$folder/well.ply", '--invalid=drop', @$where]);
    is $code, 0, 'unless it is to be dropped';
    is slurp("$folder/well.ply"), $wanted, 'then the others are converted';
    like $stderr, qr/: dropped: invalid point \(1\)\n\z/, 'which is said';
}
is decode_json((run(['measure', $sick, '--invalid', 'drop']))[1])->{invalid}, 1, 'measure counts it too';
done_testing();
