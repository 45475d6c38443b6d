#!/usr/bin/perl
# The frame of Draco results as another program sees it: what Debian's draco_decoder decodes, plus the origin that the
# report tells, is what the same request gives as PLY, within half a cell and a step of float32; the line on the
# terminal; and what is refused. Clouds: a bunny as it is, one with colours and normals, one at UTM coordinates, autzen.
use strict;
use warnings;
use JSON::PP;
use FindBin;
use lib $FindBin::Bin, "$FindBin::Bin/../support";
use Cli;
use Frame;
use Test::More;

my $dir = scratch();

sub decode {
    my ($file, $out, $name) = @_;
    is system("draco_decoder -i $file -o $out >$dir/log 2>&1"), 0, "$name: draco_decoder decodes it" or diag slurp("$dir/log");
}

SKIP: {
    skip 'draco_decoder (Debian package draco) is not installed', 1
        if !$ENV{CI} && system('command -v draco_decoder >/dev/null') != 0;
    my @clouds = clouds($dir);
    skip 'no ../shared/data', 1 unless @clouds;
    for my $order ('spatial', 'progressive') { compare($dir, $_, $order, \&decode) for @clouds }
}

# A sheet of a hundred metres, 0.9 m between its points, at UTM coordinates.
my $state = 1;
sub random { $state = ($state * 1664525 + 1013904223) % 4294967296; return $state / 4294967296 }
my @sheet = map { [100 * random(), 100 * random(), random()] } 1 .. 4000;
spew("$dir/sheet.ply", ply(['double x', 'double y', 'double z'], map { [$_->[0] + 566000, $_->[1] + 5933000, $_->[2]] } @sheet));
my @quick = ('--iterations', 1, '--polish', 0);

my ($code, $out, $err) = run(['resample', "$dir/sheet.ply", '-n', 300, @quick, '-fo', "$dir/a.drc"]);
is $code, 0, 'a sheet is resampled';
like $err, qr{^voronoid: \S+/a\.drc: positions in the file are relative to the origin 566050,5933050,0$}m,
    'a line tells where its zero is';
is scalar(() = $err =~ /origin/g), 1, 'one line';
(undef, undef, $err) = run(['resample', "$dir/sheet.ply", '-n', 300, @quick, '-fo', "$dir/a.ply"]);
unlike $err, qr/origin/, 'PLY has the coordinates of the input';

# The origin of a Draco file is applied when it is read.
my $measured = decode_json((run(['measure', "$dir/a.drc", '--reference', "$dir/a.ply"]))[1]);
cmp_ok $measured->{input}{hausdorff_relative}, '<', 1e-4, 'the Draco file holds the points of the PLY file';

# points never moves the frame.
my %frames;
for my $n (50, 3000) {
    my (undef, $json) = run(['resample', "$dir/sheet.ply", '-n', $n, @quick, '--json', '-fo', "$dir/b.drc"]);
    $frames{ origin_of(decode_json((split /\n/, $json)[-1])) } = 1;
}
is join(' ', keys %frames), '566050,5933050,0', 'few and many points lie in one frame';

for my $case (['566000.5,5933000,-3', '566000.5,5933000,-3'], ['relative', '566050,5933050,0']) {
    my ($asked, $want) = @$case;
    my (undef, $json) = run(['resample', "$dir/sheet.ply", '-n', 300, @quick, '--origin', $asked, '--json', '-fo', "$dir/b.drc"]);
    my $report = decode_json((split /\n/, $json)[-1]);
    is origin_of($report), $want, "--origin $asked";
    is $report->{parameters}{origin}, $asked, "--origin $asked is in the report";
}

# At 5933100 float32 has steps of 0.5: 300 points are 6 apart, so steps of 0.3 at most.
spew("$dir/c.drc", 'as it was');
($code, undef, $err) = run(['resample', "$dir/sheet.ply", '-n', 3000, @quick, '--origin', 'absolute', '-fo', "$dir/c.drc"]);
is $code, 3, 'absolute is refused where float32 is too coarse';
like $err, qr/^voronoid: \S+sheet\.ply: with origin=absolute, float32 has steps of 0\.5 /, 'with the step, before the work';
($code, undef, $err) = run(['resample', "$dir/sheet.ply", '-n', 300, @quick, '--origin', 'absolute', '-fo', "$dir/c.drc"]);
is $code, 3, 'also after it, where the estimate was not sure';
like $err, qr/^voronoid: \S+c\.drc: with origin=absolute, float32 has steps of 0\.5 .* want at most 0\.[23]\d+ \(1\/\d+ of the spacing/,
    'with the step';
is slurp("$dir/c.drc"), 'as it was', 'and what lay there still does';
($code) = run(['resample', "$dir/sheet.ply", '-n', 60, @quick, '--origin', 'absolute', '--quiet', '-fo', "$dir/c.drc"]);
is $code, 0, 'where it is fine enough, absolute is what is written';
($code) = run(['resample', "$dir/sheet.ply", '-n', 3000, @quick, '--origin', 'absolute', '--quiet', '-fo', "$dir/c.ply"]);
is $code, 0, 'PLY takes no offence';
($code, undef, $err) = run(['resample', "$dir/sheet.ply", '-n', 60, '--origin', '1,2', '-fo', "$dir/c.drc"]);
is $code, 2, 'an origin of two numbers is a mistake';
like $err, qr/origin is "1,2", want one of auto, absolute, relative or X,Y,Z of numbers from -1e\+30 to 1e\+30/, 'that is named';

# A daemon does and says the same.
my $daemon = daemon(scratch() . '/data', '127.0.0.1:0', '--threads', 2);
my @there = ('resample', "$dir/sheet.ply", @quick, '--server', $daemon->{url});
($code, undef, $err) = run([@there, '-n', 300, '-fo', "$dir/there.drc"]);
is $code, 0, 'a daemon resamples the sheet';
like $err, qr{there\.drc: positions in the file are relative to the origin 566050,5933050,0$}m, 'and its origin is told';
ok slurp("$dir/there.drc") eq slurp("$dir/a.drc"), 'the file is the one that is made here';
for my $n (3000, 300) {
    ($code, undef, $err) = run([@there, '-n', $n, '--origin', 'absolute', '-fo', "$dir/there.drc"]);
    is $code, 3, "$n points, absolute, are refused";
    like $err, qr/float32 has steps of 0\.5 /, "$n points: with the step";
}
stop($daemon);
done_testing;
