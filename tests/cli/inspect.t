#!/usr/bin/perl
# voronoid inspect, here and by a daemon of our own: one document.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use HTTP::Tiny;
use JSON::PP;
use Test::More;

my $folder = scratch();
my $points = 1500;
my $in = spew("$folder/in.ply", sphere($points));
my $daemon = daemon("$folder/data", '127.0.0.1:0', '--threads', 2);
my $http = HTTP::Tiny->new(timeout => 120);

my ($code, $stdout, $stderr) = run(['inspect', $in, '--json']);
is "$code$stderr", '0', 'all is well';
my $told = decode_json($stdout);
is_deeply [sort keys %$told], [qw(area attributes border bounds components edges format lattice loops neighbors noise origin points sheets
    spacing)], 'the members';
is_deeply $told->{points}, { all => $points, invalid => 0, distinct => $points, outliers => 0 }, 'every point is counted';
is $told->{format}, 'ply', 'its file was PLY';
is_deeply $told->{attributes}, [], 'it has positions only';
is_deeply $told->{origin}, { x => 0, y => 0, z => 0 }, 'which are absolute';
cmp_ok abs($told->{bounds}{$_}{y}) - 1, '<', 0.02, "$_ of its box is there" for qw(min max);
is $told->{components}{count}, 1, 'it is in one part';
is $told->{sheets}{found}, 'no', 'without sheets';
cmp_ok abs($told->{area} - 12.566), '<', 0.3, 'of the area of a sphere';
cmp_ok $told->{spacing}{p01}, '<', $told->{spacing}{p50}, 'quantiles ascend';
cmp_ok $told->{spacing}{p50}, '<', $told->{spacing}{p99}, 'all of them';

is +(run(['inspect', '-', '--json'], stdin => $in))[1], $stdout, 'stdin is the same';
is +(run(['inspect', $in, '--json', '--threads=3']))[1], $stdout, 'so are three threads';
is +(run(['inspect', $in, '--json', '--server', $daemon->{url}]))[1] =~ s/\n*\z/\n/r, $stdout, 'and a daemon';
my ($job) = @{ decode_json($http->get("$daemon->{url}/v1/jobs")->{content})->{jobs} };
is $job->{processID}, 'inspect', 'as a job of that process';

# Without --json: a line for each member, in the order of the document.
my ($lines_code, $lines, $lines_errors) = run(['inspect', $in]);
is "$lines_code$lines_errors", '0', 'all is well with lines';
my @rows = map { [split ' ', $_, 2] } split /\n/, $lines;
my @members = qw(format bounds.min bounds.max origin attributes points.all points.invalid points.distinct points.outliers components.count components.largest components.small
    components.small_points spacing.mean spacing.p01 spacing.p50 spacing.p99 noise neighbors lattice lattice.matters sheets.found
    sheets.own edges.points edges.length area border.loops border.holes border.length border.open loops);
is_deeply [map { $_->[0] } @rows], \@members, 'every member has a line';
my %line = map {@$_} @rows;
is $line{'points.all'}, "$points points", 'a count has its unit';
is $line{'components.count'}, '1', 'or none';
is $line{'spacing.mean'}, sprintf('%.6g unit of the cloud', $told->{spacing}{mean}), 'a length has six digits';
is $line{lattice}, '0 0 0 unit of the cloud', 'a vector its three parts';
is $line{'lattice.matters'}, 'no', 'beside what is told of it';
is $line{loops}, 'none', 'no loop, no line of one';
is +(run(['inspect', $in, '--quiet', '-fo', '-']))[1], $lines, 'stdout by name is the same';
is +(run(['inspect', $in, '--server', $daemon->{url}]))[1], $lines, 'so is a daemon';
my ($to_file, $printed) = run(['inspect', $in, '-fo', "$folder/told.json"]);
is "$to_file$printed", '0', 'nothing is printed where the document goes to a file';
is slurp("$folder/told.json"), $stdout, 'and the file has it as JSON';
my ($there_code, $there) = run(['inspect', $in, '-fo', "$folder/there.json", '--server', $daemon->{url}]);
is "$there_code$there", '0', 'nor where a daemon makes it';
is slurp("$folder/there.json") =~ s/\n*\z/\n/r, $stdout, 'and it is the same';
is join("\n", grep {/^vcm/} split /\n/, (run(['inspect', $in, '--vcm']))[1]), sprintf("%-24s0 points\n%-24s0 points", 'vcm.points', 'vcm.common'),
    'edges by VCM have lines if they are asked for';
like +(run(['inspect', '--help']))[1], qr/--json\n(?: {6}\S.*\n)*?.*inspect\s+prints\s+a\s+single\s+document$/m, '--help says so';

# A square far from zero, in double precision, has one loop.
my $square = join '', map { sprintf "%.3f %.3f 42\n", 500000 + ($_ % 40) + 0.2 * sin($_), 4100000 + int($_ / 40) + 0.2 * cos(7 * $_) } 0 .. 1599;
my $utm = spew("$folder/utm.ply",
    "ply\nformat ascii 1.0\nelement vertex 1600\nproperty double x\nproperty double y\nproperty double z\nend_header\n$square");
my ($loop) = @{ decode_json((run(['inspect', $utm, '--json']))[1])->{loops} };
is "$loop->{id} $loop->{kind}, $loop->{why}", '1 rim, encloses the surface', 'a square has a rim';
cmp_ok abs($loop->{length} - 158), '<', 6, 'as long as its sides';
cmp_ok abs($loop->{centre}{$_->[0]} - $_->[1]), '<', 0.5, "$_->[0] of its centre keeps its digits" for ['x', 500019.5], ['y', 4100019.5], ['z', 42];
my ($line) = grep {/^loops/} split /\n/, (run(['inspect', $utm]))[1];
like $line, qr/^loops\.1 +length 1\S+ unit of the cloud, points \d+ points, centre 5000\S+ 41000\S+ 42 unit of the cloud, kind rim, why encloses the surface, turns -\S+\z/, 'its line has all of it';

($code, $stdout, $stderr) = run(['inspect', spew("$folder/one.ply",
    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n")]);
is "$code$stdout", '3', 'a single point is refused';
like $stderr, qr/\Avoronoid: \S+one\.ply: the cloud has 1 distinct points, want at least 4\n\z/, 'in one line';
done_testing();
