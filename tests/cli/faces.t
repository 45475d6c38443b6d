#!/usr/bin/perl
# --sample faces: the surface of a mesh in place of its vertices, here and by a daemon of our own; who does not ask is told.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use JSON::PP;
use Test::More;

my $folder = scratch();
my $corners = join '', map { join(' ', $_ & 1, $_ >> 1 & 1, $_ >> 2) . "\n" } 0 .. 7;
my $head = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n";
my $cube = spew("$folder/cube.ply", "${head}element face 6\nproperty list uchar int vertex_index\nend_header\n$corners"
    . "4 0 1 3 2\n4 4 6 7 5\n4 0 4 5 1\n4 2 3 7 6\n4 0 2 6 4\n4 1 5 7 3\n");
my $bare = spew("$folder/bare.ply", "${head}end_header\n$corners");
my $draco = "$FindBin::Bin/../fuzz/corpus/draco/mesh-edgebreaker.drc";
my @quick = ('--iterations', 2, '--polish', 3);
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);
my %result;

for my $where ([], ['--server', $daemon->{url}]) {
    my $by = @$where ? 'by a daemon' : 'here';
    my $out = "$folder/out.ply";
    my ($code, $stdout, $stderr) = run(['resample', $cube, '-n', 500, '--sample', 'faces', '-fo', $out, @quick, '--json', @$where]);
    is "$code$stderr", '0', "a cube is resampled, $by";
    push @{ $result{cube} }, slurp($out);
    my $report = decode_json((split /\n/, $stdout)[-1]);
    is_deeply [@$report{qw(faces samples dropped)}], [6, 10000, []], "the report counts faces and samples, $by";
    is_deeply $report->{points}, { in => 8, out => 500 }, "and points, $by";
    is $report->{parameters}{sample}, 'faces', "and says what was asked for, $by";
    ($code, $stdout, $stderr) = run(['resample', $cube, '-n', 500, '--sample=faces', '-fo', $out, @quick, @$where]);
    unlike $stderr, qr/face/, "nobody is told to ask for what he has asked for, $by";

    ($code, $stdout, $stderr) = run(['resample', $cube, '-n', 8, '-fo', $out, @quick, @$where]);
    is $code, 0, "its vertices are resampled, $by" or diag($stderr);
    like $stderr, qr/: dropped: face \(6\)\nvoronoid: \S+cube\.ply: the file has 6 faces: use --sample faces to resample the surface of the faces\n\z/,
        "and what else there is, is said in one line, $by";
    ($code, $stdout, $stderr) = run(['resample', $cube, '-n', 8, '-fo', $out, @quick, '--sample', 'vertices', @$where]);
    is $code, 0, "so they are where they are asked for, $by";
    like $stderr, qr/: dropped: face \(6\)\n\z/, "without that line, $by";
    is +(run(['resample', $cube, '-n', 8, '-fo', $out, @quick, '--quiet', @$where]))[2], '', "--quiet says nothing, $by";

    ($code, $stdout, $stderr) = run(['resample', $bare, '-n', 8, '-fo', $out, '--sample', 'faces', @$where]);
    is $code, 2, "a cloud without faces is refused, $by";
    like $stderr, qr/\Avoronoid: \S*bare\.ply: (?:The faces of the cloud cannot be used: )?sample=faces needs faces with three or more corners, but the input has 8 points and no faces: use sample=vertices\n\z/,
        "in one line that names the parameter, $by";
    ($code, $stdout, $stderr) = run(['resample', $cube, '-n', 8, '-fo', $out, '--sample', 'edges', @$where]);
    is $code, 2, "a word that there is not is refused, $by";
    like $stderr, qr/sample is "edges", want one of vertices, faces/, "with those that there are, $by";

    ($code, $stdout, $stderr) = run(['resample', $draco, '-n', 300, '--sample', 'faces', '-fo', $out, @quick, '--json', @$where]);
    is "$code$stderr", '0', "a Draco mesh is resampled, $by";
    push @{ $result{draco} }, slurp($out);
    $report = decode_json((split /\n/, $stdout)[-1]);
    is_deeply [@$report{qw(faces samples dropped)}], [32, 10000, []], "with its faces, $by";
}
is $result{$_}[0], $result{$_}[1], "the $_ is the same from both" for sort keys %result;

# Without a number of points a filter makes the result of all points drawn.
my ($code, $stdout, $stderr) = run(['resample', $cube, '--filters', 'outliers', '--sample', 'faces', '-fo', "$folder/all.ply", '--json']);
is "$code$stderr", '0', 'filters alone take faces too';
is decode_json((split /\n/, $stdout)[-1])->{samples}, 10000, 'of which ten thousand points are drawn';
stop($daemon);
done_testing;
